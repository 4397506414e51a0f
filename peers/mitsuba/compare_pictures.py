#!/usr/bin/env python3
"""Whether eosphor and Mitsuba 3 see the same light: means of blocks of 8 x 8 pixels of eleven scenes.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy scipy libigl==2.6.3 scikit-image==0.26.0
    venv/bin/python compare_pictures.py --eosphor ../../target/release/eosphor [--seeds 16] [--samples 256] [--pictures DIR] [SCENE...]

Each program renders each scene with each seed. The spread over seeds says how far means may be apart by chance: Welch's t of the two
means of a block, per channel, told as the deviation of a normal distribution that is as likely. It holds that at most 0.5 % of blocks are
beyond 3, none beyond 5, and that the picture's mean is within 3 and 0.1 %. "worst by chance" is how often the worst of so many blocks
would be as bad without any difference (Sidak). Paths have at most 8 bounces (12 in dragon and bunny) and no roulette. Rough lobes are those of
lobes.py, whose masking and energy are as in docs/path-tracing.md; all else is Mitsuba's own: diffuse, dielectric, volpath with
albedo 0, emitters, instances, the camera. Environments are resampled without loss (both.for_mitsuba). libigl and scikit-image make the
body of the dragon (closed.py); the other scenes do without.

--pictures writes for each scene a strip of eosphor's picture, Mitsuba's, and grey plus their relative difference times 5.
The variant is llvm_ad_rgb (DRJIT_LIBLLVM_PATH names the library) or that of --variant.
"""

import argparse
import pathlib
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np
from scipy import stats

BLOCK = 8
# Samples that Mitsuba makes at once.
PASS = 256


def blocks(pictures):
    """Means of blocks: seeds, rows, columns, channels."""
    seeds, height, width, channels = pictures.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = pictures[:, : rows * BLOCK, : columns * BLOCK]
    return cut.reshape(seeds, rows, BLOCK, columns, BLOCK, channels).mean(axis=(2, 4))


def deviations(ours, theirs):
    """Over the first axis: deviations of a normal distribution that are as likely as Welch's t."""
    n, m = len(ours), len(theirs)
    a, b = ours.var(axis=0, ddof=1) / n, theirs.var(axis=0, ddof=1) / m
    apart = ours.mean(axis=0) - theirs.mean(axis=0)
    # What has no noise, as the middle of a lamp, is equal up to rounding.
    floor = 1e-5 * np.abs(theirs.mean(axis=0)) + 1e-12
    variance = a + b + floor**2
    freedom = np.maximum(variance**2 / (a**2 / (n - 1) + b**2 / (m - 1) + 1e-300), 2)
    freedom = np.minimum(freedom, n + m - 2)
    t = apart / np.sqrt(variance)
    return np.sign(t) * stats.norm.isf(np.maximum(stats.t.sf(np.abs(t), freedom), 1e-300))


def judge(ours, theirs):
    """A line, and whether all holds."""
    z = deviations(blocks(ours), blocks(theirs))
    count = z.size
    beyond, worst = float((np.abs(z) > 3).mean()), float(np.abs(z).max())
    by_chance = -np.expm1(count * np.log1p(-2 * stats.norm.sf(worst)))
    row, column, channel = np.unravel_index(np.abs(z).argmax(), z.shape)
    means = ours.mean(axis=(1, 2)), theirs.mean(axis=(1, 2))
    of_mean = deviations(*means)
    ratio = means[0].mean(axis=0) / means[1].mean(axis=0) - 1
    relative = lambda m: m.std(axis=0, ddof=1) / np.sqrt(len(m)) / m.mean(axis=0)
    sigma = np.hypot(relative(means[0]), relative(means[1]))
    holds = beyond <= 0.005 and worst <= 5 and np.all(np.abs(of_mean) <= 3) and np.all(np.abs(ratio) <= 0.001)
    percent = lambda values: " ".join(f"{100 * x:+.3f}" for x in values)
    line = (
        f"{count} means, beyond 3: {100 * beyond:.2f} %, rms {np.sqrt((z**2).mean()):.3f}, worst {worst:.2f} "
        f"(row {row}, column {column}, channel {channel}; by chance {by_chance:.2g}); "
        f"picture {percent(ratio)} % +- {percent(sigma)}, z {' '.join(f'{x:+.1f}' for x in of_mean)}"
    )
    return line, holds


def strip(ours, theirs, path):
    """Both pictures and their difference."""
    scale = 0.7 / np.quantile(theirs, 0.9)
    shown = lambda p: np.clip(p * scale, 0, 1) ** (1 / 2.2)
    apart = np.clip(0.5 + 5 * 0.5 * (ours - theirs) / (theirs + 0.02 / scale), 0, 1)
    picture = np.repeat(np.repeat(np.concatenate([shown(ours), shown(theirs), apart], axis=1), 3, axis=0), 3, axis=1)
    mi.Bitmap((picture * 255).astype(np.uint8)).write(str(path))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--eosphor", required=True)
    parser.add_argument("--shared", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[3] / "shared")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--mitsuba-samples", type=int, help="as --samples where not given; it needs more for the same noise")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*")
    flags = parser.parse_args()
    mi.set_variant(flags.variant)
    import both
    import lobes  # noqa: F401: registers them
    import pictures

    import drjit as dr

    if "llvm" in flags.variant:
        dr.set_thread_count(flags.threads)
    their_samples = flags.mitsuba_samples or flags.samples
    print(f"Mitsuba {mi.__version__}, {mi.variant()}; {flags.seeds} seeds of {flags.samples} samples, Mitsuba's of {their_samples}")
    failed = []
    for name in flags.scenes or pictures.SCENES:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            scene = (pictures.SCENES | pictures.MORE)[name](flags.shared / "scenes", folder)
            file, of = both.eosphor_scene(scene, folder), both.mitsuba_scene(scene, "independent")
            ours, theirs, seconds = [], [], [0.0, 0.0]
            for seed in range(flags.first_seed, flags.first_seed + flags.seeds):
                spent, picture = both.eosphor(flags.eosphor, file, flags.samples, seed, folder, flags.threads)
                seconds[0] += spent
                ours.append(picture)
                before = time.process_time()
                passes = max(their_samples // PASS, 1)
                each = their_samples // passes
                parts = [np.array(mi.render(of, spp=each, seed=1000 * seed + k), dtype=np.float64) for k in range(passes)]
                theirs.append(sum(parts) / passes)
                seconds[1] += time.process_time() - before
        ours, theirs = np.array(ours), np.array(theirs)
        line, holds = judge(ours, theirs)
        failed += [] if holds else [name]
        print(f"{name}: {'holds' if holds else 'DIFFERS'}: {line}; {seconds[0]:.0f} s and {seconds[1]:.0f} s", flush=True)
        if flags.pictures:
            flags.pictures.mkdir(parents=True, exist_ok=True)
            strip(ours.mean(axis=0), theirs.mean(axis=0), flags.pictures / f"{name}.png")
            np.savez_compressed(flags.pictures / f"{name}.npz", ours=ours.astype(np.float32), theirs=theirs.astype(np.float32))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
