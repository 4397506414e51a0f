#!/usr/bin/env python3
"""Pictures of glTF models by eosphor and by Cycles (Blender's path tracer), side by side.

    python3.11 -m venv venv && venv/bin/pip install bpy==5.0.1
    venv/bin/python compare_gltf.py --eosphor ../../target/release/eosphor --pictures DIR [--samples 128] [MODEL...]

Each model of the shared folders gltf and gltf-materials-motion is imported by Blender's own importer into an empty scene. One
camera, found from the bounding box, sees it from the front right and above; the models' own cameras are not used, their lights
are. The model is lit by white surroundings of radiance 1 (`white`) and by the environment studio_small_03 (`studio`). Both
programs have box filters of one pixel, at most 8 bounces, no clamping, no denoiser, and write linear floats. Blender turns +y up
into +z up, (x, y, z) into (x, -z, y), and so do the camera and the environment, which needs no rotation. Models with animations
are shown at --frame of 24 in a second.

The figures are, over the pixels that the model covers: the ratio of the means (eosphor's over Cycles', red, green, blue) and the
relative differences of means of 8 x 8 pixels: the median, the 90th percentile, the largest. "background" is the largest
difference of such means where there is no model. It writes for each model a strip of eosphor's picture, Cycles' picture, and grey
plus their relative difference times 5, and the figures to figures.jsonl. No verdict: the two have different models of materials.
docs/beside-cycles.md says where, and why. With --as-specified, absorption, the tint of glass and the default material are set in
Blender as glTF has them.
"""

import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

import bpy
import numpy as np
from mathutils import Vector

BLOCK = 8
FOLDERS = ("gltf", "gltf-materials-motion")
# From the middle of the model to the camera, in glTF's axes.
TOWARDS_CAMERA = Vector((0.45, 0.35, 1.0))
FOV_Y = 40
ENVIRONMENT = "environments/studio_small_03_1k.hdr"


def models(shared):
    files = [f for folder in FOLDERS for f in sorted((shared / folder).glob("*/*.gl*"))]
    return {f.stem: f for f in files}


def gltf_json(file):
    data = file.read_bytes()
    if data[:4] == b"glTF":
        data = data[20 : 20 + struct.unpack_from("<I", data, 12)[0]]
    return json.loads(data)


def to_blender(v):
    return Vector((v[0], -v[2], v[1]))


def to_gltf(v):
    return Vector((v[0], v[2], -v[1]))


def import_model(file, frame):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # Compatible: the candelas of the file are watts per steradian, as in eosphor.
    bpy.ops.import_scene.gltf(
        filepath=str(file), export_import_convert_lighting_mode="COMPAT", disable_bone_shape=True, merge_vertices=False, loglevel=50
    )
    bpy.context.scene.frame_set(frame)
    # Otherwise shadow rays start from a surface that is smoother than the triangles.
    for each in bpy.context.scene.objects:
        each.shadow_terminator_geometry_offset = 0


def default_material():
    """glTF's: a rough white metal. Blender has a grey matte surface, and dielectric where there are vertex colours."""
    material = bpy.data.materials.new("glTF's default")
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 1, 1, 1)
    return material


def as_specified():
    """What the importer sets otherwise than the specification says, and can be set right."""
    for each in bpy.context.scene.objects:
        if each.type == "MESH" and not any(each.data.materials):
            each.data.materials.clear()
            each.data.materials.append(default_material())
    for material in bpy.data.materials:
        nodes = material.node_tree.nodes if material.node_tree else []
        for node in nodes:
            inputs = node.inputs
            if node.type == "VOLUME_ABSORPTION":
                # Cycles absorbs density * (1 - colour); Beer's law for the attenuation colour is density * -ln(colour).
                extinction = [-math.log(max(x, 1e-6)) * inputs["Density"].default_value for x in inputs["Color"].default_value[:3]]
                largest = max(extinction) or 1
                inputs["Density"].default_value = largest
                inputs["Color"].default_value = [1 - x / largest for x in extinction] + [1]
            elif node.type == "BSDF_PRINCIPLED":
                if inputs["Transmission Weight"].default_value == 1 and not inputs["Base Color"].is_linked:
                    # Cycles takes the square root at each surface.
                    inputs["Base Color"].default_value = [x * x for x in inputs["Base Color"].default_value[:3]] + [1]
                if material.name.startswith(("glTF's default", "DefaultMaterial")):
                    inputs["Metallic"].default_value = inputs["Roughness"].default_value = 1


def corners():
    """Of all vertices, in glTF's axes: the least and the largest."""
    graph = bpy.context.evaluated_depsgraph_get()
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for instance in graph.object_instances:
        if instance.object.type != "MESH":
            continue
        mesh = instance.object.to_mesh()
        points = np.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", points)
        matrix = np.array(instance.matrix_world)
        world = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        if len(world):
            low, high = np.minimum(low, world.min(axis=0)), np.maximum(high, world.max(axis=0))
        instance.object.to_mesh_clear()
    a, b = to_gltf(low), to_gltf(high)
    return np.minimum(a, b), np.maximum(a, b)


def camera_for(low, high, aspect):
    """Eye and target in glTF's axes: all corners of the box are in the picture."""
    middle = Vector((low + high) / 2)
    back = TOWARDS_CAMERA.normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    up = back.cross(right)
    tangent_y = math.tan(math.radians(FOV_Y / 2))
    distance = 0
    for k in range(8):
        corner = Vector([(low, high)[k >> axis & 1][axis] for axis in range(3)]) - middle
        sideways = max(abs(corner.dot(right)) / (tangent_y * aspect), abs(corner.dot(up)) / tangent_y)
        distance = max(distance, sideways + corner.dot(back))
    return middle + back * distance * 1.04, middle


def set_world(environment):
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    nodes.clear()
    background, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    links.new(background.outputs[0], output.inputs["Surface"])
    if environment:
        texture = nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(str(environment))
        links.new(texture.outputs["Color"], background.inputs["Color"])


def set_camera(eye, target):
    scene = bpy.context.scene
    data = bpy.data.cameras.new("view")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(FOV_Y)
    distance = (eye - target).length
    data.clip_start, data.clip_end = distance * 1e-4, distance * 1e4
    camera = bpy.data.objects.new("view", data)
    camera.location = to_blender(eye)
    camera.rotation_euler = to_blender(target - eye).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def set_render(flags):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = flags.size
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", flags.threads
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGB", "32"
    scene.view_settings.view_transform = "Standard"
    cycles.device, cycles.samples = "CPU", flags.samples
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = flags.depth
    cycles.transparent_max_bounces = 64
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    # Would make highlights wider after the first bounce, and skip weak lights.
    cycles.blur_glossy = cycles.light_sampling_threshold = 0


def by_cycles(flags, folder):
    output = folder / "cycles.exr"
    bpy.context.scene.render.filepath = str(output)
    bpy.ops.render.render(write_still=True)
    return pixels(output)[..., :3]


def by_eosphor(flags, file, view, environment, frame, folder):
    """The picture, and which pixels the model covers."""
    eye, target = view
    text = lambda v: ",".join(f"{x:.9g}" for x in v)
    fov_x = 2 * math.degrees(math.atan(math.tan(math.radians(FOV_Y / 2)) * flags.size[0] / flags.size[1]))
    command = [
        flags.eosphor, "render", file, "--backend", "cpu", "--threads", flags.threads, "--quiet", "--no-metadata",
        "--size", "x".join(map(str, flags.size)), f"--fov={fov_x:.9g}",
        f"--eye={text(eye)}", f"--look-at={text(target)}", "--up=0,1,0",
        "--headlight", "off",
    ]
    command += ["--frame", frame] if frame else []
    command += ["--environment", environment] if environment else ["--background", "1,1,1"]

    def run(name, *more):
        subprocess.run([str(x) for x in (*command, "-o", folder / name, *more)], check=True, stdout=subprocess.DEVNULL)
        return pixels(folder / name)

    covered = run("covered.exr", "--alpha", "--samples", 16, "--depth", 0)[..., 3]
    return run("eosphor.exr", "--samples", flags.samples, "--depth", flags.depth)[..., :3], covered


def pixels(path):
    """Rows from above, as they stand in the file."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    width, height = image.size
    values = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, -1)[::-1].astype(np.float64)


def blocks(picture):
    """Means of blocks; what does not fill a block at the border is left out."""
    rows, columns = picture.shape[0] // BLOCK, picture.shape[1] // BLOCK
    cut = picture[: rows * BLOCK, : columns * BLOCK]
    return cut.reshape(rows, BLOCK, columns, BLOCK, -1).mean(axis=(1, 3))


def figures(ours, theirs, covered):
    a, b, share = blocks(ours), blocks(theirs), blocks(covered)[..., 0]
    on = covered > 0.5
    floor = 0.02 * np.quantile(theirs[on], 0.9)
    apart = (np.abs(a - b) / (b + floor)).mean(axis=2)
    inside = apart[share > 0.5] if (share > 0.5).any() else apart
    outside = apart[share == 0]
    return {
        "ratio": [round(float(x), 4) for x in ours[on].mean(axis=0) / theirs[on].mean(axis=0)],
        "median": round(float(np.median(inside)), 4),
        "p90": round(float(np.quantile(inside, 0.9)), 4),
        "worst": round(float(inside.max()), 4),
        "background": round(float(outside.max()), 4) if len(outside) else 0.0,
    }


def strip(ours, theirs, path):
    """Both pictures and their difference."""
    scale = 0.8 / np.quantile(theirs.max(axis=2), 0.9)
    shown = lambda p: np.clip(p * scale, 0, 1) ** (1 / 2.2)
    apart = np.clip(0.5 + 5 * 0.5 * (ours - theirs) / (theirs + 0.02 / scale), 0, 1)
    picture = np.concatenate([shown(ours), shown(theirs), apart], axis=1)[::-1]
    height, width = picture.shape[:2]
    image = bpy.data.images.new("strip", width, height)
    image.pixels.foreach_set(np.dstack([picture, np.ones((height, width))]).astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def compare(name, file, flags):
    frame = flags.frame if gltf_json(file).get("animations") else 0
    for light in flags.lights:
        environment = flags.shared / "scenes" / ENVIRONMENT if light == "studio" else None
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            import_model(file, frame)
            if flags.as_specified:
                as_specified()
            view = camera_for(*corners(), flags.size[0] / flags.size[1])
            set_world(environment)
            set_camera(*view)
            set_render(flags)
            started = time.monotonic()
            theirs = by_cycles(flags, folder)
            between = time.monotonic()
            ours, covered = by_eosphor(flags, file, view, environment, frame, folder)
            seconds = [round(between - started, 1), round(time.monotonic() - between, 1)]
        line = {"model": name, "light": light} | figures(ours, theirs, covered) | {"seconds": seconds}
        print(json.dumps(line), file=flags.log, flush=True)
        print(json.dumps(line), flush=True)
        strip(ours, theirs, flags.pictures / f"{name}-{light}.png")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--eosphor", required=True)
    parser.add_argument("--shared", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[3] / "shared")
    parser.add_argument("--pictures", type=pathlib.Path, required=True)
    parser.add_argument("--size", type=int, nargs=2, default=(320, 240))
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--depth", type=int, default=8)
    parser.add_argument("--frame", type=int, default=12)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--lights", nargs="+", choices=("white", "studio"), default=("white", "studio"))
    parser.add_argument("--as-specified", action="store_true", help="mend what the importer sets otherwise than glTF says")
    parser.add_argument("models", nargs="*")
    flags = parser.parse_args()
    flags.pictures.mkdir(parents=True, exist_ok=True)
    flags.log = open(flags.pictures / "figures.jsonl", "a", encoding="utf-8")
    files = models(flags.shared / "scenes")
    failed = 0
    for name in flags.models or files:
        try:
            compare(name, files[name], flags)
        except (RuntimeError, subprocess.CalledProcessError) as error:
            failed += 1
            print(f"{name}: {error}", file=sys.stderr, flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
