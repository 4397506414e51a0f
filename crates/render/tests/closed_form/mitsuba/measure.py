#!/usr/bin/env python3
"""Radiance of the scenes beside this file by Mitsuba 3: by the integrator `direct` prints measured.txt, by `path`
measured-paths.txt.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python measure.py > measured.txt      # some minutes
    venv/bin/python measure.py path > measured-paths.txt
    venv/bin/python measure.py sky                 # makes sky.exr

It reads as much of the scene format as these scenes use. A probe is what comes back along one ray: the mean of a picture
that is 0.01 degrees wide. It has many pixels, since Mitsuba adds up the samples of one in single precision.
"""

import json
import pathlib
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
HERE = pathlib.Path(__file__).resolve().parent

# Pixels along a side, and samples of each. The pixels' spread tells how far their mean may be off.
SIDE, SAMPLES = 64, 1024

# Up to 8 bounces: Mitsuba counts the lamp and the point that is seen. No roulette.
PATHS = sys.argv[1:] == ["path"]
INTEGRATOR = {"type": "path", "max_depth": 9, "rr_depth": 64} if PATHS else {"type": "direct"}

ON_PLANE = [([1.5, 1.2, 2.5], [x, 0, z]) for x, z in [(0.2, -0.3), (1.0, 0.1), (-0.9, 0.55), (0.4, -1.6), (1.6, 1.2)]]

PROBES = {
    "point": ON_PLANE,
    "sun": ON_PLANE[:2],
    "spot": [probe for probe in ON_PLANE if probe[1] in ([0.2, 0, -0.3], [1.0, 0, 0.1], [-0.9, 0, 0.55])],
    "ball": ON_PLANE,
    "room": [
        # The lamp, the floor in its light and in the half shadow of the screen and of the ball, the walls, the ball, the
        # screen, and the ceiling, which the lamp does not reach.
        ([0, 1, 0.9], [0.03, 1.96, 0.02]),
        ([0, 1, 0.9], [-0.1, 0, 0.55]),
        ([-0.5, 1, 0.9], [0.6, 0, 0.68]),
        ([0, 1, 0.9], [-0.75, 0, -0.5]),
        ([0, 1, 0.9], [0.35, 0, -0.4]),
        ([0, 1, 0.9], [0.3, 1.2, -1]),
        ([0.4, 1, 0.9], [-1, 0.7, 0.13]),
        ([-0.4, 1.4, 0.9], [1, 0.9, -0.23]),
        ([0, 1.6, 0.9], [-0.35, 0.72, -0.06]),
        ([0.05, 0.5, -0.6], [0.45, 0.55, 0.3125]),
        ([0, 1, 0.9], [0.7, 2, 0.6]),
    ],
}


# The last two: through the ball, and the caustic behind it.
PROBES["glass-room"] = PROBES["room"] + [([0, 1.2, 0.9], [-0.4, 0.35, -0.3]), ([0.3, 1.5, 0.5], [-0.45, 0, -0.42])]
PROBES["sky"] = [
    # The plane in the sun and in shadows, both balls, the screen, and the sky with its sun.
    ([1.5, 1.2, 2.5], [0.1, 0, 0.9]),
    ([1.5, 1.2, 2.5], [-1.2, 0, 0.3]),
    ([1.5, 1.2, 2.5], [0.2, 0, -0.9]),
    ([1.5, 1.2, 2.5], [0.3, 0, 0.2]),
    ([1.5, 1.2, 2.5], [-0.5, 0.8, 0.3]),
    ([1.5, 1.2, 2.5], [-0.3, 0.2, 0.2]),
    ([1.5, 1.2, 2.5], [0.65, 0.5, 0.4]),
    ([0.0, 1.0, 2.5], [0.1, 0.9, -1.2]),
    ([0.0, 3.0, 0.0], [-1.0, 4.0, 0.5]),
    ([0.0, 3.0, 0.0], [0.2, 3.5, -1.0]),
]
if PATHS:
    PROBES = {name: PROBES[name] for name in ("room", "glass-room", "sky")}
else:
    del PROBES["glass-room"], PROBES["sky"]


def rgb(color):
    return {"type": "rgb", "value": color}


def emission(mtl):
    lines = (line.split() for line in mtl.read_text().splitlines())
    return next([float(x) for x in line[1:]] for line in lines if line[:1] == ["Ke"])


def appearance(material):
    """What a shape of this material is beside its form."""
    if "emissive" in material:
        return {
            "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
            "emitter": {"type": "area", "radiance": rgb(material["emissive"]["radiance"])},
        }
    if "dielectric" in material:
        return {"bsdf": {"type": "dielectric", "int_ior": material["dielectric"]["ior"], "ext_ior": 1.0}}
    matte = {"type": "diffuse", "reflectance": rgb(material["matte"]["color"])}
    return {"bsdf": {"type": "twosided", "inner": matte}}


def light(entry):
    [(kind, of)] = entry.items()
    if kind == "point":
        return {"type": "point", "position": of["position"], "intensity": rgb(of["color"])}
    if kind == "directional":
        return {"type": "directional", "direction": of["direction"], "irradiance": rgb(of["color"])}
    target = np.add(of["position"], of["direction"]).tolist()
    to_world = mi.ScalarTransform4f().look_at(of["position"], target, [1, 0, 0])
    # It is full within beam_width; between the two Mitsuba fades in a way of its own.
    return {
        "type": "spot",
        "to_world": to_world,
        "intensity": rgb(of["color"]),
        "beam_width": of["inner-degrees"],
        "cutoff_angle": of["outer-degrees"],
    }


def sky(path):
    """Makes the picture of the scene `sky`: 32 x 16 texels, brighter towards the horizon, with a sun that is one texel."""
    down, across = np.meshgrid(np.arange(16), np.arange(32), indexing="ij")
    height = np.clip(1.0 - (down + 0.5) / 8.0, 0.0, 1.0)[..., None]
    blue = np.array([0.3, 0.5, 1.0]) * height + np.array([1.2, 1.0, 0.8]) * (1.0 - height)
    ground = np.array([0.2, 0.15, 0.1])
    picture = np.where((down < 8)[..., None], blue * (1.0 + 0.3 * np.cos(across * np.pi / 16))[..., None], ground)
    picture[5, 27] = [120.0, 100.0, 60.0]
    mi.Bitmap(picture.astype(np.float32)).write(str(path))


def environment(entry):
    """The picture as Mitsuba has it: its middle lies towards +z, and its first and last rows are single directions. It is enlarged,
    so that both interpolate the same colours."""
    picture = np.array(mi.Bitmap(str(HERE / entry["file"])), dtype=np.float64)
    rows, columns = picture.shape[:2]
    width, height = 64 * columns, 64 * rows + 1
    turn = 2 * np.pi * (np.arange(width) + 0.5) / width
    x, z = np.sin(turn), -np.cos(turn)
    u = (0.5 + np.arctan2(z, x) / (2 * np.pi)) * columns - 0.5
    v = np.arange(height) / (height - 1) * rows - 0.5
    left, top = np.floor(u).astype(int), np.floor(v).astype(int)
    right_share, low_share = (u - left)[None, :, None], (v - top)[:, None, None]
    row = lambda k: picture[np.clip(k, 0, rows - 1)]
    mix = lambda rows: rows[:, left % columns] * (1 - right_share) + rows[:, (left + 1) % columns] * right_share
    large = mix(row(top)) * (1 - low_share) + mix(row(top + 1)) * low_share
    bitmap = mi.Bitmap(large.astype(np.float32))
    return {"type": "envmap", "bitmap": bitmap, "scale": entry["strength"]}


def scene_of(file):
    materials = file["materials"]
    shapes = [light(entry) for entry in file.get("lights", [])]
    for p in file.get("parallelograms", []):
        u, v = np.multiply(0.5, p["edge-u"]), np.multiply(0.5, p["edge-v"])
        matrix = np.eye(4)
        # Mitsuba's rectangle reaches from -1 to 1 and faces +z.
        matrix[:3, :4] = np.stack([u, v, np.cross(u, v), p["corner"] + u + v], axis=1)
        rectangle = {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix)}
        shapes.append(rectangle | appearance(materials[p["material"]]))
    for s in file.get("spheres", []):
        sphere = {"type": "sphere", "center": s["center"], "radius": s["radius"]}
        shapes.append(sphere | appearance(materials[s["material"]]))
    for m in file.get("meshes", []):
        path = HERE / m["file"]
        place = mi.ScalarTransform4f().translate(m["transform"]["translate"])
        mesh = {"type": "obj", "filename": str(path), "face_normals": True, "to_world": place}
        lamp = {"emissive": {"radiance": emission(path.with_suffix(".mtl"))}}
        shapes.append(mesh | appearance(lamp))
    if "environment" in file:
        shapes.append(environment(file["environment"]))
    return {"type": "scene", "integrator": INTEGRATOR} | {f"shape{i}": s for i, s in enumerate(shapes)}


def probe(scene, start, end):
    """Mean and its standard deviation, for each channel."""
    sensor = mi.load_dict({
        "type": "perspective",
        "fov": 0.01,
        "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(start, end, [0.3, 0.9, 0.2]),
        "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}, "component_format": "float32"},
        "sampler": {"type": "independent"},
    })
    pixels = np.array(mi.render(scene, sensor=sensor, spp=SAMPLES), dtype=np.float64).reshape(SIDE * SIDE, -1)[:, :3]
    return pixels.mean(axis=0), pixels.std(axis=0, ddof=1) / SIDE


if sys.argv[1:] == ["sky"]:
    sky(HERE / "sky.exr")
    sys.exit()
print(f"# Mitsuba {mi.__version__} ({mi.variant()}), integrator {INTEGRATOR['type']}, {SIDE * SIDE * SAMPLES} samples; printed by measure.py")
print("# scene, ray from, ray towards, radiance, largest relative standard error")
for name, probes in PROBES.items():
    scene = mi.load_dict(scene_of(json.loads((HERE / f"{name}.json").read_text())))
    for start, end in probes:
        mean, deviation = probe(scene, start, end)
        error = np.max(deviation / np.maximum(mean, 1e-9)) if mean.max() > 0 else 0.0
        numbers = [f"{x:g}" for x in start + end] + [f"{x:.6g}" for x in mean] + [f"{error:.1e}"]
        print(name, *numbers, flush=True)
        if error > (0.02 if PATHS else 2e-3):
            sys.exit(f"{name}: {error:.1e} is too much noise; take more samples")
