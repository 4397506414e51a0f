"""The scenes of compare_pictures.py, as both.py reads them. Each is a function of (shared scenes, a folder for files made)."""

import pathlib
from collections import Counter

import mitsuba as mi
import numpy as np

from both import box, lamp, matte

WHITE = matte([0.73, 0.71, 0.68])


def wall(corner, u, v, material):
    return {"corner": corner, "edge-u": u, "edge-v": v, "material": material}


def room(light=True):
    """Five walls of the room of Cornell University, in numbers of about 2, and its lamp."""
    walls = [
        wall([-1, 0, 1], [2, 0, 0], [0, 0, -2], "white"),
        wall([-1, 2, -1], [2, 0, 0], [0, 0, 2], "white"),
        wall([-1, 0, -1], [2, 0, 0], [0, 2, 0], "white"),
        wall([-1, 0, 1], [0, 0, -2], [0, 2, 0], "red"),
        wall([1, 0, -1], [0, 0, 2], [0, 2, 0], "green"),
    ]
    return {
        "materials": {
            "white": WHITE, "red": matte([0.63, 0.065, 0.05]), "green": matte([0.14, 0.45, 0.091]), "lamp": lamp([17, 12, 4]),
        },
        "parallelograms": walls + ([wall([-0.25, 1.98, -0.2], [0.5, 0, 0], [0, 0, 0.4], "lamp")] if light else []),
        "camera": {"position": [0, 1, 3.9], "look-at": [0, 1, 0], "fov-y-degrees": 39},
        "size": [128, 128],
        "depth": 8,
    }


def turned_box(middle, degrees, height, material="white"):
    side = lambda degrees: 0.6 * np.array([np.cos(np.radians(degrees)), 0, -np.sin(np.radians(degrees))])
    u, v = side(degrees), side(degrees - 90)
    return box(np.array(middle) - (u + v) / 2, v, u, [0, height, 0], material)


def cornell(shared, folder):
    """Two matte boxes in the room."""
    scene = room()
    scene["parallelograms"] += turned_box((0.33, 0, 0.35), -18, 0.6) + turned_box((-0.35, 0, -0.3), 17, 1.2)
    return scene


def cornell_metal_glass(shared, folder):
    """A box of rough metal, and spheres of rough and of clear glass."""
    scene = room()
    scene["materials"] |= {
        "metal": {"pbr": {"color": [0.95, 0.8, 0.5], "metallic": 1, "roughness": 0.4}},
        "rough-glass": {"pbr": {"color": [1, 1, 1], "transmission": 1, "solid": True, "roughness": 0.4}},
        "glass": {"pbr": {"color": [1, 1, 1], "transmission": 1, "solid": True, "roughness": 0}},
    }
    scene["parallelograms"] += turned_box((-0.35, 0, -0.3), 17, 1.2, "metal")
    scene["spheres"] = [
        {"center": [0.42, 0.35, 0.3], "radius": 0.35, "material": "rough-glass"},
        {"center": [-0.45, 0.22, 0.6], "radius": 0.22, "material": "glass"},
    ]
    return scene


def plates(shared, folder):
    """Plates of metal of rising roughness that mirror lamps of falling size and rising radiance (Veach 1997, figure 9.4)."""
    camera = np.array([0.0, 2.0, 15.0])
    lamps = np.array([0.0, 2.5, 0.0])
    parallelograms = []
    for k in range(4):
        middle = np.array([0.0, -1.6 - 0.65 * k, 0.5 + 1.5 * k])
        to = lambda p: (p - middle) / np.linalg.norm(p - middle)
        normal = to(camera) + to(lamps)
        normal /= np.linalg.norm(normal)
        u = np.array([8.0, 0, 0])
        v = np.cross(normal, [1, 0, 0]) * 1.1
        parallelograms.append(wall(list(middle - u / 2 - v / 2), list(u), list(v), f"plate{k}"))
    parallelograms += [
        wall([-10, -4.2, 8], [20, 0, 0], [0, 0, -10], "wall"),
        wall([-10, -4.2, -2], [20, 0, 0], [0, 12, 0], "wall"),
        wall([-6, 10, -2], [12, 0, 0], [0, 0, 10], "above"),
    ]
    metal = lambda rough: {"pbr": {"color": [0.9, 0.85, 0.8], "metallic": 1, "roughness": rough}}
    spheres = [
        {"center": [x, 2.5, 0], "radius": radius, "material": f"lamp{k}"}
        for k, (x, radius) in enumerate([(-3.75, 0.08), (-1.25, 0.18), (1.25, 0.4), (3.75, 0.9)])
    ]
    return {
        "materials": {f"plate{k}": metal(rough) for k, rough in enumerate([0.14, 0.22, 0.35, 0.55])}
        | {f"lamp{k}": lamp([float(1 / s["radius"] ** 2)] * 3) for k, s in enumerate(spheres)}
        | {"wall": matte([0.4, 0.4, 0.4]), "above": lamp([0.3, 0.3, 0.4])},
        "parallelograms": parallelograms,
        "spheres": spheres,
        "camera": {"position": list(camera), "look-at": [0, -2.3, 2.5], "fov-y-degrees": 26},
        "size": [160, 112],
        "depth": 8,
    }


def sponza(shared, folder):
    """Its walls, all matte, below a sky."""
    return {
        "materials": {"stone": matte([0.6, 0.55, 0.5])},
        "meshes": [{"file": str(shared / "sponza-dabrovic" / "sponza.obj"), "material": "stone"}],
        "environment": {"file": str(shared / "environments" / "venice_sunset_1k.hdr")},
        "camera": {"position": [-11, 3, 0.2], "look-at": [5, 4, 0], "fov-y-degrees": 60},
        "size": [128, 72],
        "depth": 8,
    }


def textured_emitter(shared, folder):
    """A screen with a picture lights a room; a plate beside it mirrors it."""
    rng = np.random.default_rng(3)
    picture = (rng.random((12, 16, 3)) ** 3 * 255).astype(np.uint8)
    # An edge that tells up from down and left from right.
    picture[:2], picture[:, :2] = [255, 40, 10], [10, 60, 255]
    file = folder / "screen.png"
    mi.Bitmap(picture).write(str(file))
    scene = room(light=False)
    scene["materials"] |= {
        "screen": lamp([1, 1, 1]) | {"textures": {"emission": {"file": str(file), "wrap": "clamp"}}},
        "plate": {"pbr": {"color": [0.9, 0.9, 0.9], "metallic": 1, "roughness": 0.25}},
        "plastic": {"pbr": {"color": [0.6, 0.6, 0.6], "roughness": 0.4}},
    }
    scene["parallelograms"] += [
        wall([-0.8, 0.5, -0.9], [1.6, 0, 0], [0, 1.2, 0], "screen"),
        wall([-0.9, 0.01, 0.9], [1.8, 0, 0], [0, 0.15, -0.9], "plate"),
    ]
    scene["spheres"] = [{"center": [0.55, 0.5, 0.2], "radius": 0.25, "material": "plastic"}]
    return scene


def obj(path, triangles):
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for t in triangles for x, y, z in t]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(triangles))]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def many_triangles(shared, folder):
    """1,000 triangles of ten radiances that shine to all sides, some next to the walls."""
    rng = np.random.default_rng(4)
    scene = room(light=False)
    scene["parallelograms"] += turned_box((0.33, 0, 0.35), -18, 0.6) + turned_box((-0.35, 0, -0.3), 17, 1.2)
    scene["meshes"] = []
    for k in range(10):
        middle = rng.uniform([-0.97, 0.05, -0.97], [0.97, 1.97, 0.9], (100, 1, 3))
        triangles = np.clip(middle + rng.normal(0, 0.012 + 0.002 * k, (100, 3, 3)), [-0.995, 0.005, -0.995], [0.995, 1.995, 1])
        scene["materials"][f"lamp{k}"] = lamp([float(x) for x in rng.uniform(0.5, 8, 3)])
        scene["meshes"].append({"file": obj(folder / f"lamps{k}.obj", triangles), "material": f"lamp{k}"})
    return scene


def absorbing_glass(triangles, folder):
    """Over a floor, below a lamp. About the origin, and large: Mitsuba moves origins of rays by 9e-5 (1 + the largest coordinate)."""
    glass = {
        "color": [1, 1, 1], "transmission": 1, "solid": True, "roughness": 0, "ior": 1.5,
        "attenuation-color": [0.3, 0.7, 0.5], "attenuation-distance": 30,
    }
    return {
        "materials": {"floor": matte([0.5, 0.45, 0.4]), "glass": {"pbr": glass}, "lamp": lamp([6, 6, 5])},
        "meshes": [{"file": obj(folder / "glass.obj", triangles), "material": "glass"}],
        "parallelograms": [
            wall([-300, -75, 300], [600, 0, 0], [0, 0, -600], "floor"),
            wall([-100, 225, -100], [200, 0, 0], [0, 0, 200], "lamp"),
        ],
        "background": [0.4, 0.5, 0.7],
        "camera": {"position": [30, 75, 320], "look-at": [-5, -10, 0], "fov-y-degrees": 36},
        "size": [128, 96],
        "depth": 12,
    }


def points_and_faces(kind, file):
    read = mi.traverse(mi.load_dict({"type": kind, "filename": str(file)}))
    return np.array(read["vertex_positions"]).reshape(-1, 3), np.array(read["faces"]).reshape(-1, 3)


def dragon(shared, folder):
    """What the Stanford dragon encloses, in some 200,000 triangles: a closed body that does not intersect itself.
    closed.py makes it within some ten seconds, the same each time, and needs libigl and scikit-image."""
    from closed import closed

    points, faces = points_and_faces("ply", shared / "dragon" / "dragon_vrip.ply")
    points, faces = closed(1000 * (points - [0, 0.125, 0]), faces, 1.0)
    return absorbing_glass(points[faces], folder)


def dragon_scan(shared, folder):
    """The reduced scan, without its sheets, which have no thickness. It is open and intersects itself, where Mitsuba and eosphor mean
    different things: docs/path-tracing.md. Not one of those that must agree."""
    points, faces = points_and_faces("ply", shared / "dragon" / "dragon_vrip_res3.ply")
    count = Counter(tuple(sorted(map(int, f))) for f in faces)
    triangles = (1000 * (points - [0, 0.125, 0]))[[f for f in faces if count[tuple(sorted(map(int, f)))] == 1]]
    return absorbing_glass(triangles, folder)


def glass_bunny(shared, folder):
    """The dragon's glass about a body that is closed and does not intersect itself."""
    points, faces = points_and_faces("obj", shared / "bunny" / "bunny-watertight.obj")
    return absorbing_glass((68 * (points - [0, 1.05, 0]))[faces], folder)


def instances(shared, folder):
    """Forty cows, turned and stretched, of plastic and of metal, below a sky."""
    rng = np.random.default_rng(5)
    placed = []
    for k in range(40):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        linear = turn @ np.diag(rng.uniform(0.25, 0.7, 3))
        place = [1.3 * (k % 8 - 3.5) + rng.uniform(-0.3, 0.3), 0.7 + rng.uniform(0, 0.5), 1.4 * (k // 8 - 2.5)]
        placed.append({
            "mesh": ["plastic", "metal"][k % 2],
            "transform": {"matrix": np.hstack([linear, np.array(place)[:, None]]).tolist()},
        })
    file = str(shared / "spot" / "spot.obj")
    return {
        "materials": {
            "floor": matte([0.5, 0.5, 0.5]),
            "plastic": {"pbr": {"color": [0.5, 0.2, 0.15], "roughness": 0.5}},
            "metal": {"pbr": {"color": [0.95, 0.8, 0.5], "metallic": 1, "roughness": 0.45}},
        },
        "meshes": [{"file": file, "name": name, "material": name} for name in ("plastic", "metal")],
        "instances": placed,
        "parallelograms": [wall([-8, 0, 6], [16, 0, 0], [0, 0, -14], "floor")],
        "environment": {"file": str(shared / "environments" / "venice_sunset_1k.hdr")},
        "camera": {"position": [0, 4, 8], "look-at": [0, 0.5, 0], "fov-y-degrees": 40},
        "size": [128, 96],
        "depth": 8,
    }


def metal_spheres(environment, roughnesses=(0.1, 0.25, 0.4, 0.6, 0.8)):
    """Spheres of metal from smooth to rough over a matte plane, below a sky."""
    metal = lambda rough: {"pbr": {"color": [0.95, 0.8, 0.5], "metallic": 1, "roughness": rough}}
    return {
        "materials": {"floor": matte([0.5, 0.5, 0.5])} | {f"metal{i}": metal(r) for i, r in enumerate(roughnesses)},
        "parallelograms": [{"corner": [-4, 0, 4], "edge-u": [8, 0, 0], "edge-v": [0, 0, -8], "material": "floor"}],
        "spheres": [{"center": [1.1 * (i - 2), 0.5, 0], "radius": 0.5, "material": f"metal{i}"} for i in range(5)],
        "environment": {"file": str(environment)},
        "camera": {"position": [0, 1.6, 5], "look-at": [0, 0.4, 0], "fov-y-degrees": 32},
        "size": [128, 72],
        "depth": 8,
        # Noise counts here, not the last percent of the look.
        "lobes": "near",
    }


def under_sky(elevation):
    """A box on a floor that reaches to the horizon, under a clear sky: sides in the sun and in the shade, and the box's shadow. The sky
    itself is not seen: without noise, the texels that eosphor has of it would be told from Mitsuba's function (0.01 %)."""
    def scene(shared, folder):
        wide = 1e4
        return {
            "materials": {"floor": matte([0.3, 0.3, 0.3]), "box": matte([0.7, 0.7, 0.7])},
            "parallelograms": [wall([-wide, 0, wide], [2 * wide, 0, 0], [0, 0, -2 * wide], "floor")]
            + box([-1, 0, 1], [2, 0, 0], [0, 0, -2], [0, 2, 0], "box"),
            "environment": {
                "sky": {"sun-elevation-degrees": elevation, "sun-azimuth-degrees": 225, "turbidity": 3, "albedo": 0.3},
            },
            "camera": {"position": [5, 7, 8], "look-at": [0.6, 0.4, 0], "fov-y-degrees": 36},
            "size": [128, 96],
            "depth": 8,
        }
    return scene


def moved_sponza(distance):
    """Sponza and its camera, so many units farther along x: a picture that should be the same."""

    def make(shared, folder):
        scene = sponza(shared, folder)
        mesh, camera = scene["meshes"][0], scene["camera"]
        lines = pathlib.Path(mesh["file"]).read_text(errors="replace").splitlines()
        path = folder / "moved.obj"
        path.write_text("".join(moved_line(line, distance) for line in lines if not line.startswith(("mtllib", "usemtl"))))
        mesh["file"] = str(path)
        for key in ("position", "look-at"):
            camera[key] = [camera[key][0] + distance, *camera[key][1:]]
        return scene

    return make


def moved_line(line, distance):
    if line.startswith("v "):
        x, y, z = map(float, line.split()[1:4])
        line = f"v {x + distance:.9g} {y:.9g} {z:.9g}"
    return line + "\n"


SCENES = {
    "cornell": cornell,
    "cornell-metal-glass": cornell_metal_glass,
    "plates": plates,
    "sponza": sponza,
    "textured-emitter": textured_emitter,
    "many-triangles": many_triangles,
    "dragon": dragon,
    "glass-bunny": glass_bunny,
    "instances": instances,
    "sky-15": under_sky(15),
    "sky-50": under_sky(50),
}
# Rendered where they are named.
MORE = {"dragon-scan": dragon_scan, "sponza-128": moved_sponza(128), "sponza-1024": moved_sponza(1024)}
