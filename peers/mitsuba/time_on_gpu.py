#!/usr/bin/env python3
"""Milliseconds that eosphor and Mitsuba 3 take for the same pictures on one GPU, by turns.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python time_on_gpu.py --eosphor ../../target/release/eosphor [--shared DIR] [--repeats N] [SCENE...]

Both trace paths of at most 8 bounces without roulette. Mitsuba runs as `cuda_ad_rgb`; its first picture, which is compiled, is not timed,
and a time ends when the picture is on the device. eosphor's is that of `bench render`: with its way back to the host. Medians of
N pictures in each of three turns, and how far they are apart. Means of both pictures are printed, so that it is seen that they are of
one scene.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import mitsuba as mi
import numpy as np

mi.set_variant("cuda_ad_rgb")
import drjit as dr  # noqa: E402
import pictures  # noqa: E402
from both import eosphor_scene, mitsuba_scene, pixels  # noqa: E402

TURNS = 3


def mitsuba(scene, samples, repeats):
    times = []
    for seed in range(repeats):
        dr.sync_thread()
        before = time.perf_counter()
        picture = mi.render(scene, spp=samples, seed=seed)
        dr.eval(picture)
        dr.sync_thread()
        times.append(1e3 * (time.perf_counter() - before))
    return times, np.array(picture, dtype=np.float64)


def eosphor(program, file, samples, repeats):
    command = [program, "bench", "render", file, "--samples", samples, "--backend", "cuda", "--repeats", repeats, "--json"]
    output = subprocess.run([str(x) for x in command], check=True, capture_output=True, text=True).stdout
    return json.loads(output)["milliseconds"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--eosphor", required=True)
    parser.add_argument("--shared", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[3] / "shared")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--sampler", default="independent")
    parser.add_argument("scenes", nargs="*")
    flags = parser.parse_args()
    shared = flags.shared.resolve() / "scenes"
    sky = shared / "environments" / "venice_sunset_1k.hdr"
    hd, square = [1920, 1080], [800, 800]
    scenes = {
        "cornell": (lambda folder: pictures.cornell(shared, folder), square),
        "many-triangles": (lambda folder: pictures.many_triangles(shared, folder), square),
        "metal-spheres": (lambda folder: pictures.metal_spheres(sky), hd),
        "sponza": (lambda folder: pictures.sponza(shared, folder), hd),
        "instances": (lambda folder: pictures.instances(shared, folder), hd),
    }
    print(f"Mitsuba {mi.__version__}, {mi.variant()}, {flags.sampler}; {flags.samples} samples; {TURNS} turns of {flags.repeats}")
    for name in flags.scenes or scenes:
        make, size = scenes[name]
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            scene = make(folder) | {"size": size, "lobes": "near"}
            file, of = eosphor_scene(scene, folder), mitsuba_scene(scene, flags.sampler)
            mitsuba(of, flags.samples, 2)
            ours, theirs = [], []
            for _ in range(TURNS):
                times, picture = mitsuba(of, flags.samples, flags.repeats)
                theirs.append(float(np.median(times)))
                ours.append(eosphor(flags.eosphor, file, flags.samples, flags.repeats))
            output = folder / "picture.exr"
            command = [flags.eosphor, "render", file, "-o", output, "--samples", flags.samples, "--backend", "cuda", "--quiet"]
            subprocess.run([str(x) for x in command], check=True, stdout=subprocess.DEVNULL)
            shown = lambda times: f"{np.median(times):.1f} ms ({min(times):.1f} to {max(times):.1f})"
            means = " ".join(f"{a / b:.4f}" for a, b in zip(pixels(output).mean(axis=(0, 1)), picture.mean(axis=(0, 1))))
            print(
                f"{name} {size[0]} x {size[1]}: eosphor {shown(ours)}, Mitsuba {shown(theirs)}, "
                f"ratio {np.median(ours) / np.median(theirs):.3f}; means over theirs {means}",
                flush=True,
            )


if __name__ == "__main__":
    main()
