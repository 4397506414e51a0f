#!/usr/bin/env python3
"""How soon eosphor and Mitsuba 3 have how little noise: CPU seconds times relative mean squared error (relMSE), of the same scenes.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python time_to_error.py --eosphor ../../target/release/eosphor [--seeds N] [SCENE...]

Both trace paths of at most 8 bounces without roulette, on one thread, and take turns. Each picture is compared with one of its own
program and many samples, so that no difference of models counts as noise; how far those two are apart is printed, too. Mitsuba runs
as `llvm_ad_rgb` (DRJIT_LIBLLVM_PATH names the library; version 17 or later on processors without AVX-512) with each of its samplers,
and its first picture, which is compiled, is not timed. eosphor's time is that of the whole process.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import tempfile
import time

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import drjit as dr  # noqa: E402

EPSILON = 0.01
DEPTH = 8
SAMPLERS = ["independent", "multijitter", "ldsampler"]


def rgb(color):
    return {"type": "rgb", "value": color}


def matte(color):
    return {"matte": {"color": color}}


def box(corner, u, v, w, material):
    """Six parallelograms that face outwards; u, v and w are right-handed."""
    c, u, v, w = (np.array(x, dtype=float) for x in (corner, u, v, w))
    sides = [(c, v, u), (c, w, v), (c, u, w), (c + w, u, v), (c + u, v, w), (c + v, w, u)]
    return [{"corner": list(a), "edge-u": list(b), "edge-v": list(d), "material": material} for a, b, d in sides]


def cornell():
    """The room of Cornell University with two matte boxes, in numbers of about 2."""
    wall = lambda corner, u, v, material: {"corner": corner, "edge-u": u, "edge-v": v, "material": material}
    turned = lambda degrees, size: [[size * np.cos(a), 0, -size * np.sin(a)] for a in [np.radians(degrees)]][0]
    boxes = []
    for middle, degrees, height in [((0.33, 0, 0.35), -18, 0.6), ((-0.35, 0, -0.3), 17, 1.2)]:
        u, v = np.array(turned(degrees, 0.6)), np.array(turned(degrees - 90, 0.6))
        boxes += box(np.array(middle) - (u + v) / 2, v, u, [0, height, 0], "white")
    return {
        "materials": {
            "white": matte([0.73, 0.71, 0.68]),
            "red": matte([0.63, 0.065, 0.05]),
            "green": matte([0.14, 0.45, 0.091]),
            "lamp": {"emissive": {"radiance": [17, 12, 4]}},
        },
        "parallelograms": [
            wall([-1, 0, 1], [2, 0, 0], [0, 0, -2], "white"),
            wall([-1, 2, -1], [2, 0, 0], [0, 0, 2], "white"),
            wall([-1, 0, -1], [2, 0, 0], [0, 2, 0], "white"),
            wall([-1, 0, 1], [0, 0, -2], [0, 2, 0], "red"),
            wall([1, 0, -1], [0, 0, 2], [0, 2, 0], "green"),
            wall([-0.25, 1.98, -0.2], [0.5, 0, 0], [0, 0, 0.4], "lamp"),
        ]
        + boxes,
        "camera": {"position": [0, 1, 3.9], "look-at": [0, 1, 0], "fov-y-degrees": 39},
        "size": [128, 128],
    }


def metal_spheres(environment):
    """Spheres of metal from smooth to rough over a matte plane, below a sky."""
    metal = lambda rough: {"pbr": {"color": [0.95, 0.8, 0.5], "metallic": 1, "roughness": rough}}
    roughnesses = [0.1, 0.25, 0.4, 0.6, 0.8]
    return {
        "materials": {"floor": matte([0.5, 0.5, 0.5])} | {f"metal{i}": metal(r) for i, r in enumerate(roughnesses)},
        "parallelograms": [{"corner": [-4, 0, 4], "edge-u": [8, 0, 0], "edge-v": [0, 0, -8], "material": "floor"}],
        "spheres": [{"center": [1.1 * (i - 2), 0.5, 0], "radius": 0.5, "material": f"metal{i}"} for i in range(5)],
        "environment": {"file": str(environment)},
        "camera": {"position": [0, 1.6, 5], "look-at": [0, 0.4, 0], "fov-y-degrees": 32},
        "size": [128, 72],
    }


def sponza(obj, environment):
    """Its walls, all matte, below a sky."""
    return {
        "obj": str(obj),
        "materials": {"stone": matte([0.6, 0.55, 0.5])},
        "environment": {"file": str(environment)},
        "camera": {"position": [-11, 3, 0.2], "look-at": [5, 4, 0], "fov-y-degrees": 60},
        "size": [128, 72],
    }


def eosphor_scene(scene, folder):
    """A file, and the flags that go with it."""
    file = {"eosphor": 2} | {k: scene[k] for k in ("materials", "parallelograms", "spheres", "environment", "camera") if k in scene}
    if "obj" in scene:
        file["meshes"] = [{"file": scene["obj"], "material": "stone"}]
    file["settings"] = {"size": scene["size"], "integrator": "path", "depth": DEPTH, "roulette": 64}
    path = folder / "scene.json"
    path.write_text(json.dumps(file))
    return path


def mitsuba_bsdf(material):
    if "matte" in material:
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": rgb(material["matte"]["color"])}}
    pbr = material["pbr"]
    # The nearest that Mitsuba has: noise counts here, not the last percent of the look.
    return {"type": "principled", "base_color": rgb(pbr["color"]), "metallic": 1.0, "roughness": pbr["roughness"], "specular": 0.5}


def mitsuba_scene(scene, sampler):
    shapes = []
    for p in scene.get("parallelograms", []):
        u, v = np.multiply(0.5, p["edge-u"]), np.multiply(0.5, p["edge-v"])
        matrix = np.eye(4)
        # Mitsuba's rectangle reaches from -1 to 1 and faces +z.
        matrix[:3, :4] = np.stack([u, v, np.cross(u, v), p["corner"] + u + v], axis=1)
        shape = {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix)}
        material = scene["materials"][p["material"]]
        if "emissive" in material:
            shape |= {
                "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
                "emitter": {"type": "area", "radiance": rgb(material["emissive"]["radiance"])},
            }
        else:
            shape |= {"bsdf": mitsuba_bsdf(material)}
        shapes.append(shape)
    for s in scene.get("spheres", []):
        shapes.append({
            "type": "sphere", "center": s["center"], "radius": s["radius"],
            "bsdf": mitsuba_bsdf(scene["materials"][s["material"]]),
        })
    if "obj" in scene:
        shapes.append({"type": "obj", "filename": scene["obj"], "face_normals": True, "bsdf": mitsuba_bsdf(scene["materials"]["stone"])})
    if "environment" in scene:
        # Its middle lies towards +z, ours towards +x.
        turn = mi.ScalarTransform4f().rotate([0, 1, 0], 90)
        shapes.append({"type": "envmap", "filename": scene["environment"]["file"], "to_world": turn})
    camera, (width, height) = scene["camera"], scene["size"]
    sensor = {
        "type": "perspective", "fov": camera["fov-y-degrees"], "fov_axis": "y", "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(camera["position"], camera["look-at"], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "component_format": "float32"},
        "sampler": {"type": sampler},
    }
    integrator = {"type": "path", "max_depth": DEPTH + 1, "rr_depth": 1000}
    file = {"type": "scene", "integrator": integrator, "sensor": sensor} | {f"shape{i}": s for i, s in enumerate(shapes)}
    return mi.load_dict(file)


def pixels(path):
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap, dtype=np.float64)


def rel_mse(picture, reference):
    return float(np.mean((picture - reference) ** 2 / (reference**2 + EPSILON)))


def eosphor(program, scene, samples, seed, folder):
    output = folder / "picture.exr"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "render", scene, "-o", output, "--samples", str(samples), "--seed", str(seed), "--threads", "1", "--quiet"]
    subprocess.run([str(x) for x in command], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, pixels(output)


def mitsuba(scene, samples, seed):
    before = time.process_time()
    picture = mi.render(scene, spp=samples, seed=seed)
    dr.eval(picture)
    dr.sync_thread()
    return time.process_time() - before, np.array(picture, dtype=np.float64)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--eosphor", required=True)
    parser.add_argument("--shared", default=pathlib.Path(__file__).resolve().parents[3] / "shared")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--reference", type=int, default=16384, help="samples of references")
    parser.add_argument("scenes", nargs="*")
    flags = parser.parse_args()
    shared = pathlib.Path(flags.shared) / "scenes"
    sky = shared / "environments" / "venice_sunset_1k.hdr"
    scenes = {
        "cornell": cornell,
        "metal-spheres": lambda: metal_spheres(sky),
        "sponza": lambda: sponza(shared / "sponza-dabrovic" / "sponza.obj", sky),
    }
    dr.set_thread_count(1)
    print(f"Mitsuba {mi.__version__}, {mi.variant()}; relMSE with epsilon {EPSILON}; means over {flags.seeds} seeds")
    for name in flags.scenes or scenes:
        scene = scenes[name]()
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            file = eosphor_scene(scene, folder)
            _, ours = eosphor(flags.eosphor, file, flags.reference, 999, folder)
            # Passes, since a picture of all samples would take all memory.
            reference = mitsuba_scene(scene, "independent")
            passes = max(flags.reference // 1024, 1)
            theirs = sum(mitsuba(reference, 1024, 999 + k)[1] for k in range(passes)) / passes
            apart = [float(x) for x in np.mean(ours, axis=(0, 1)) / np.mean(theirs, axis=(0, 1)) - 1]
            print(f"{name}: means apart by {[f'{x:+.4f}' for x in apart]}, relMSE of one reference against the other {rel_mse(ours, theirs):.5f}")
            samplers = {sampler: mitsuba_scene(scene, sampler) for sampler in SAMPLERS}
            for samples in (64, 256):
                for of in samplers.values():
                    mitsuba(of, samples, 7)
                rows = {}
                for seed in range(1, flags.seeds + 1):
                    seconds, picture = eosphor(flags.eosphor, file, samples, seed, folder)
                    rows.setdefault("eosphor", []).append((seconds, rel_mse(picture, ours)))
                    for sampler, of in samplers.items():
                        seconds, picture = mitsuba(of, samples, seed)
                        rows.setdefault(sampler, []).append((seconds, rel_mse(picture, theirs)))
                best = min(np.mean([s for s, _ in v]) * np.mean([e for _, e in v]) for k, v in rows.items() if k != "eosphor")
                for who, of in rows.items():
                    seconds, error = (float(np.mean([x[k] for x in of])) for k in (0, 1))
                    paths = scene["size"][0] * scene["size"][1] * samples / seconds / 1e6
                    print(f"  {samples:4} samples {who:12} {seconds:7.2f} s  {paths:6.3f} M paths/s  relMSE {error:.5f}  s x relMSE {seconds * error:.5f}  over the best of Mitsuba's {seconds * error / best:.2f}", flush=True)


main()
