#!/usr/bin/env python3
"""Writes posed.txt: triangles of animated test files, evaluated by the text of the glTF 2.0 specification with numpy.

Nothing of it is Eosphor's. Run it as `python3 posed.py FOLDER > posed.txt`, with numpy 2 and the folder of the test scenes.
A line is: file, frame (24 a second), number of the triangle, then nine numbers of positions and nine of normals (not of unit
length), in world space, corner by corner in the file's order. A line that begins with a file's name and "size" has the largest
side of the box around all vertices, of all frames.
"""
import json
import struct
import sys

import numpy as np

FILES = ["CesiumMan", "RiggedSimple", "MorphStressTest", "RecursiveSkeletons", "AnimatedMorphCube"]
FRAMES = [0, 7, 22, 41]
TRIANGLES = 14
TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class File:
    def __init__(self, path):
        data = open(path, "rb").read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[20 + length + 8 :]

    def view(self, view, offset, kind, count, width):
        view = self.json["bufferViews"][view]
        item = np.dtype(kind).itemsize * width
        stride = view.get("byteStride", item)
        start = view.get("byteOffset", 0) + offset
        rows = [np.frombuffer(self.binary, kind, width, start + k * stride) for k in range(count)]
        return np.array(rows).reshape(count, width)

    def read(self, number):
        a = self.json["accessors"][number]
        kind, width = TYPES[a["componentType"]], WIDTHS[a["type"]]
        rows = np.zeros((a["count"], width), kind)
        if "bufferView" in a:
            rows = self.view(a["bufferView"], a.get("byteOffset", 0), kind, a["count"], width).copy()
        if "sparse" in a:
            s = a["sparse"]
            at = s["indices"]
            places = self.view(at["bufferView"], at.get("byteOffset", 0), TYPES[at["componentType"]], s["count"], 1)
            values = self.view(s["values"]["bufferView"], s["values"].get("byteOffset", 0), kind, s["count"], width)
            rows[places[:, 0]] = values
        values = rows.astype(np.float64)
        if a.get("normalized"):
            values = np.maximum(values / np.iinfo(kind).max, -1.0)
        return values


def slerp(a, b, t):
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    d = np.dot(a, b)
    if d < 0:
        b, d = -b, -d
    angle = np.arccos(min(d, 1.0))
    if angle < 1e-9:
        return a + t * (b - a)
    return (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)


def sample(file, sampler, time, is_rotation, count):
    times, values = file.read(sampler["input"])[:, 0], file.read(sampler["output"])
    values = values.reshape(len(times), -1)
    kind = sampler.get("interpolation", "LINEAR")
    assert kind in ("LINEAR", "STEP"), kind
    time = min(max(time, times[0]), times[-1])
    k = max(min(int(np.searchsorted(times, time, "right")) - 1, len(times) - 2), 0)
    if len(times) == 1 or kind == "STEP":
        return values[k if time < times[-1] else -1]
    t = (time - times[k]) / (times[k + 1] - times[k])
    if is_rotation:
        return slerp(values[k], values[k + 1], t)
    return (1 - t) * values[k] + t * values[k + 1]


def local(node):
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1])) / np.linalg.norm(node.get("rotation", [0, 0, 0, 1]))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    m = np.eye(4)
    m[:3, :3] = turn @ np.diag(node.get("scale", [1, 1, 1]))
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def posed(file, time):
    """Position and normal of every corner of every triangle of every node that shows a mesh, in the order of the tree."""
    nodes = [dict(node) for node in file.json["nodes"]]
    animation = file.json["animations"][0]
    for channel in animation["channels"]:
        path, node = channel["target"]["path"], nodes[channel["target"]["node"]]
        value = sample(file, animation["samplers"][channel["sampler"]], time, path == "rotation", None)
        node[path] = value.tolist()
    world, order = {}, []

    def walk(number, parent):
        world[number] = parent @ local(nodes[number])
        order.append(number)
        for child in nodes[number].get("children", []):
            walk(child, world[number])

    for root in file.json["scenes"][file.json.get("scene", 0)]["nodes"]:
        walk(root, np.eye(4))
    triangles = []
    for number in order:
        node = nodes[number]
        if "mesh" not in node:
            continue
        mesh = file.json["meshes"][node["mesh"]]
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            p = file.read(attributes["POSITION"])
            n = file.read(attributes["NORMAL"]) if "NORMAL" in attributes else None
            weights = node.get("weights", mesh.get("weights", []))
            for target, weight in zip(primitive.get("targets", []), weights):
                if "POSITION" in target:
                    p = p + weight * file.read(target["POSITION"])
                if "NORMAL" in target and n is not None:
                    n = n + weight * file.read(target["NORMAL"])
            maps = np.repeat(world[number][None], len(p), axis=0)
            if "skin" in node:
                skin = file.json["skins"][node["skin"]]
                inverse = file.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
                joints = np.array([world[j] @ inverse[k] for k, j in enumerate(skin["joints"])])
                index, weight = file.read(attributes["JOINTS_0"]).astype(int), file.read(attributes["WEIGHTS_0"])
                weight = weight / weight.sum(axis=1, keepdims=True)
                maps = np.einsum("vk,vkij->vij", weight, joints[index])
            p = np.einsum("vij,vj->vi", maps[:, :3, :3], p) + maps[:, :3, 3]
            faces = file.read(primitive["indices"]).astype(int).reshape(-1, 3)
            if n is None:
                flat = np.cross(p[faces[:, 1]] - p[faces[:, 0]], p[faces[:, 2]] - p[faces[:, 0]])
                corners = np.repeat(flat[:, None], 3, axis=1)
            else:
                n = np.einsum("vij,vj->vi", np.linalg.inv(maps[:, :3, :3]).transpose(0, 2, 1), n)
                corners = n[faces]
            triangles.append(np.concatenate([p[faces], corners], axis=1).reshape(-1, 18))
    return np.concatenate(triangles)


def main():
    for name in FILES:
        file = File(f"{sys.argv[1]}/gltf-materials-motion/{name}/{name}.glb")
        size = 0.0
        for frame in FRAMES:
            triangles = posed(file, frame / 24)
            points = triangles[:, :9].reshape(-1, 3)
            size = max(size, (points.max(axis=0) - points.min(axis=0)).max())
            # Numbers that meet all parts of the mesh.
            for number in sorted({k * 7919 % len(triangles) for k in range(TRIANGLES)}):
                print(name, frame, number, " ".join(f"{x:.7g}" for x in triangles[number]))
        print(name, "size", f"{size:.7g}")


main()
