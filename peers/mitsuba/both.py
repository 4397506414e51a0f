"""Scenes for both programs: eosphor's scene format, as much of it as is used here, and the same for Mitsuba 3.

A scene is a dictionary with eosphor's keys, besides `size`, `depth`, and `lobes` ("exact": lobes.py; "near": Mitsuba's own, where
only noise counts). Environments and textures are files. The variant of Mitsuba must be set before this is imported.
"""

import json
import pathlib
import resource
import subprocess

import drjit as dr
import mitsuba as mi
import numpy as np

KEYS = ("materials", "meshes", "instances", "parallelograms", "spheres", "environment", "camera")


def rgb(color):
    return {"type": "rgb", "value": [float(x) for x in color]}


def matte(color):
    return {"matte": {"color": color}}


def lamp(radiance):
    return {"emissive": {"radiance": radiance}}


def box(corner, u, v, w, material):
    """Six parallelograms that face outwards; u, v and w are right-handed."""
    c, u, v, w = (np.array(x, dtype=float) for x in (corner, u, v, w))
    sides = [(c, v, u), (c, w, v), (c, u, w), (c + w, u, v), (c + u, v, w), (c + v, w, u)]
    return [{"corner": list(a), "edge-u": list(b), "edge-v": list(d), "material": material} for a, b, d in sides]


def eosphor_scene(scene, folder):
    """The file."""
    file = {"eosphor": 2} | {k: scene[k] for k in KEYS if k in scene}
    file["settings"] = {"size": scene["size"], "integrator": "path", "depth": scene["depth"], "roulette": 64, "normals": "flat"}
    if "background" in scene:
        file["settings"]["background"] = scene["background"]
    path = folder / "scene.json"
    path.write_text(json.dumps(file))
    return path


def mitsuba_texture(texture):
    """Its first row is the lowest in Mitsuba, and the uppermost in eosphor."""
    picture = mi.Bitmap(np.ascontiguousarray(np.array(mi.Bitmap(texture["file"]))[::-1]))
    filters = texture.get("filter", "bilinear")
    return {"type": "bitmap", "bitmap": picture, "filter_type": filters, "wrap_mode": texture.get("wrap", "repeat")}


def mitsuba_bsdf(material, lobes):
    two_sided = lambda inner: {"type": "twosided", "inner": inner}
    if "matte" in material:
        return two_sided({"type": "diffuse", "reflectance": rgb(material["matte"]["color"])})
    pbr = material["pbr"]
    if pbr.get("transmission", 0) == 1:
        assert pbr["solid"]
        if pbr["roughness"] == 0:
            return {"type": "dielectric", "int_ior": pbr.get("ior", 1.5), "ext_ior": 1.0}
        return {"type": "eosphor_glass", "pbr": json.dumps(pbr)}
    if lobes == "near":
        return {
            "type": "principled", "base_color": rgb(pbr["color"]), "metallic": pbr.get("metallic", 0),
            "roughness": pbr["roughness"], "specular": 0.5,
        }
    return two_sided({"type": "eosphor_opaque", "pbr": json.dumps(pbr)})


def mitsuba_surface(material, lobes):
    """BSDF, emitter and medium of a shape."""
    if "emissive" in material:
        texture = material.get("textures", {}).get("emission")
        radiance = rgb(material["emissive"]["radiance"])
        if texture:
            assert material["emissive"]["radiance"] == [1, 1, 1]
            radiance = mitsuba_texture(texture)
        return {
            "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
            "emitter": {"type": "area", "radiance": radiance},
        }
    surface = {"bsdf": mitsuba_bsdf(material, lobes)}
    distance = material.get("pbr", {}).get("attenuation-distance")
    if distance:
        extinction = [-float(np.log(x)) / distance for x in material["pbr"]["attenuation-color"]]
        largest = max(extinction)
        surface["interior"] = {
            "type": "homogeneous", "albedo": 0.0, "scale": largest, "sigma_t": rgb([x / largest for x in extinction]),
        }
    return surface


def mitsuba_mesh(file):
    kind = pathlib.Path(file).suffix[1:]
    return {"type": kind, "filename": str(file), "face_normals": True}


def matrix(transform):
    """3 x 4, row by row."""
    return mi.ScalarTransform4f(np.vstack([np.array(transform["matrix"]), [0, 0, 0, 1]]))


def mitsuba_shapes(scene):
    lobes = scene.get("lobes", "exact")
    surface = lambda name: mitsuba_surface(scene["materials"][name], lobes)
    shapes = {}
    for k, p in enumerate(scene.get("parallelograms", [])):
        u, v = np.multiply(0.5, p["edge-u"]), np.multiply(0.5, p["edge-v"])
        to_world = np.eye(4)
        # Mitsuba's rectangle reaches from -1 to 1 and faces +z.
        to_world[:3, :4] = np.stack([u, v, np.cross(u, v), p["corner"] + u + v], axis=1)
        shapes[f"parallelogram{k}"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f(to_world)} | surface(p["material"])
    for k, s in enumerate(scene.get("spheres", [])):
        shapes[f"sphere{k}"] = {"type": "sphere", "center": s["center"], "radius": s["radius"]} | surface(s["material"])
    instances = scene.get("instances", [])
    for k, mesh in enumerate(scene.get("meshes", [])):
        of_mesh = mitsuba_mesh(mesh["file"]) | surface(mesh["material"])
        placed = [i for i in instances if i["mesh"] == mesh.get("name")]
        if not placed:
            shapes[f"mesh{k}"] = of_mesh
            continue
        shapes[f"group{k}"] = {"type": "shapegroup", "mesh": of_mesh}
        for n, instance in enumerate(placed):
            shapes[f"instance{k}-{n}"] = {
                "type": "instance", "group": {"type": "ref", "id": f"group{k}"}, "to_world": matrix(instance["transform"]),
            }
    return shapes


def for_mitsuba(environment):
    """A picture that Mitsuba reads as eosphor reads the environment. Both interpolate linearly, but eosphor's texels lie about the middles
    of equal parts of the height, and Mitsuba's first and last rows on the poles. A picture of three times the width and twice the height
    and one row has texels at the middles of all of the first and on the poles."""
    picture = np.array(mi.Bitmap(environment).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False))
    height, width = picture.shape[:2]
    rows = np.clip(np.arange(2 * height + 1) / 2 - 0.5, 0, height - 1)
    columns = (np.arange(3 * width) + 0.5) / 3 - 0.5
    low = np.floor(rows).astype(int)
    part = (rows - low)[:, None, None]
    picture = picture[low] * (1 - part) + picture[np.minimum(low + 1, height - 1)] * part
    low = np.floor(columns).astype(int)
    part = (columns - low)[None, :, None]
    picture = picture[:, low % width] * (1 - part) + picture[:, (low + 1) % width] * part
    return mi.Bitmap(picture.astype(np.float32))


# Mitsuba's radiance is in W/(m^2 sr nm), of which one is 683 lm/W times the sum of the curve of luminous efficiency in nm; a radiance
# of 1 stands for 30,000 cd/m^2 in eosphor.
SKY_UNIT = 683 * 106.750259 / 30_000
SUN_DEGREES = 0.5358


def sunsky(environment):
    """The same model, with darkening towards the edge of the sun, as eosphor has it. Both count the ground's albedo for the light of the
    sky, but Mitsuba shows no ground: it is black below the horizon.

    One less the cosine of the sun's radius is 183.4 steps of single precision, of which Mitsuba has 183: it loses the edge of its disk
    and with that 0.08 % of the light. Here the disk has 183 steps, and its light is that of 183.4."""
    sky, scale = environment["sky"], SKY_UNIT * environment.get("strength", 1)
    up, around = np.radians(sky["sun-elevation-degrees"]), np.radians(sky["sun-azimuth-degrees"])
    # Clockwise from north, which is -z; east is +x.
    sun = [np.cos(up) * np.sin(around), np.sin(up), -np.cos(up) * np.cos(around)]
    steps = (1 - np.cos(np.radians(SUN_DEGREES / 2))) * 2**24
    aperture = np.degrees(2 * np.arccos(1 - np.floor(steps) / 2**24))
    return {
        "type": "sunsky", "turbidity": sky["turbidity"], "albedo": sky["albedo"], "sun_direction": [float(x) for x in sun],
        "sky_scale": scale, "sun_scale": scale * sky.get("sun-strength", 1) * float(steps / np.floor(steps)),
        "sun_aperture": float(aperture), "complex_sun": True, "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90),
    }


def mitsuba_scene(scene, sampler):
    shapes = mitsuba_shapes(scene)
    if "sky" in scene.get("environment", {}):
        shapes["environment"] = sunsky(scene["environment"])
    elif "environment" in scene:
        # Its middle lies towards +z, ours towards +x.
        turn = mi.ScalarTransform4f().rotate([0, 1, 0], 90)
        shapes["environment"] = {"type": "envmap", "bitmap": for_mitsuba(scene["environment"]["file"]), "to_world": turn}
    if "background" in scene:
        shapes["environment"] = {"type": "constant", "radiance": rgb(scene["background"])}
    camera, (width, height) = scene["camera"], scene["size"]
    sensor = {
        "type": "perspective", "fov": camera["fov-y-degrees"], "fov_axis": "y", "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(camera["position"], camera["look-at"], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "component_format": "float32"},
        "sampler": {"type": sampler},
    }
    has_media = any("interior" in s for s in shapes.values())
    integrator = {"type": "volpath" if has_media else "path", "max_depth": scene["depth"] + 1, "rr_depth": 1000}
    # Not in parallel: threads would wait for the lobes of Python, and Python for them.
    return mi.load_dict({"type": "scene", "integrator": integrator, "sensor": sensor} | shapes, parallel=False)


def pixels(path):
    # Reading EXR waits for a second thread for ever where there is none.
    threads = dr.thread_count()
    dr.set_thread_count(2)
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    dr.set_thread_count(threads)
    return np.array(bitmap, dtype=np.float64)


def eosphor(program, scene, samples, seed, folder, threads=1):
    """CPU seconds and the picture."""
    seconds, _, picture = eosphor_in_parts(program, scene, samples, seed, folder, threads)
    return seconds, picture


def eosphor_in_parts(program, scene, samples, seed, folder, threads=1):
    """CPU seconds, those of rendering alone, and the picture."""
    output = folder / "picture.exr"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "render", scene, "-o", output, "--samples", samples, "--seed", seed, "--threads", threads, "--json"]
    report = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    rendering = json.loads(report.stdout)["seconds"]["render_cpu"]
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, rendering, pixels(output)
