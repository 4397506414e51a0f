#!/usr/bin/env python3
"""How soon eosphor and Mitsuba 3 have how little noise: CPU seconds times relative mean squared error (relMSE), of the same scenes.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python time_to_error.py --eosphor ../../target/release/eosphor [--seeds N] [SCENE...]

Both trace paths of at most 8 bounces without roulette, on one thread, and take turns. Each picture is compared with one of its own
program and many samples, so that no difference of models counts as noise; how far those two are apart is printed, too. Mitsuba runs
as `llvm_ad_rgb` (DRJIT_LIBLLVM_PATH names the library; version 17 or later on processors without AVX-512) with each of its samplers,
and its first picture, which is compiled, is not timed: its time is that of rendering alone, without reading the scene, building
the hierarchy and compiling. Of eosphor's there are both: that of rendering, which is compared, and that of the whole process.
"""

import argparse
import pathlib
import tempfile
import time

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import drjit as dr  # noqa: E402
import pictures  # noqa: E402
from both import eosphor, eosphor_in_parts, eosphor_scene, mitsuba_scene  # noqa: E402

EPSILON = 0.01
SAMPLERS = ["independent", "multijitter", "ldsampler"]


def rel_mse(picture, reference):
    return float(np.mean((picture - reference) ** 2 / (reference**2 + EPSILON)))


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
        "cornell": lambda: pictures.cornell(shared, None),
        # Rough enough that no caustics are left to chance: a few pixels would decide which of the two has less noise.
        "metal-spheres": lambda: pictures.metal_spheres(sky, [alpha**0.5 for alpha in (0.1, 0.25, 0.4, 0.6, 0.8)]),
        "metal-spheres-smooth": lambda: pictures.metal_spheres(sky),
        "sponza": lambda: pictures.sponza(shared, None),
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
                    whole, seconds, picture = eosphor_in_parts(flags.eosphor, file, samples, seed, folder)
                    rows.setdefault("eosphor", []).append((seconds, rel_mse(picture, ours)))
                    rows.setdefault("the process", []).append((whole, rel_mse(picture, ours)))
                    for sampler, of in samplers.items():
                        seconds, picture = mitsuba(of, samples, seed)
                        rows.setdefault(sampler, []).append((seconds, rel_mse(picture, theirs)))
                best = min(np.mean([s for s, _ in v]) * np.mean([e for _, e in v]) for k, v in rows.items() if k in SAMPLERS)
                for who, of in rows.items():
                    seconds, error = (float(np.mean([x[k] for x in of])) for k in (0, 1))
                    paths = scene["size"][0] * scene["size"][1] * samples / seconds / 1e6
                    print(f"  {samples:4} samples {who:12} {seconds:7.2f} s  {paths:6.3f} M paths/s  relMSE {error:.5f}  s x relMSE {seconds * error:.5f}  over the best of Mitsuba's {seconds * error / best:.2f}", flush=True)


main()
