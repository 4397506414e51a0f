#!/usr/bin/env python3
"""Tone curves in double precision, from their publications and not from our code: prints truth.txt. Needs numpy.

neutral  Khronos PBR Neutral, the specification in PBR_Neutral/README.md of github.com/KhronosGroup/ToneMapping
aces     Stephen Hill's fit of the ACES reference rendering transform and sRGB's output transform (BakingLab, ACES.hlsl)
agx      Troy Sobotka's log-sigmoid (github.com/sobotka/AgX: pivot 10 / 16.5, 0.5; slope 2; powers 3 and 3.25) between the
         matrices in Rec. 2020 of Blender's AgX (github.com/EaryChow/AgX_LUT_Gen), as Filament and three.js have them
`truth.py agx` prints how far three.js's polynomial is from the sigmoid instead.
"""
import sys

import numpy as np


def neutral(c):
    f90, desaturation = 0.04, 0.15
    start = 0.8 - f90
    x = c.min()
    c = c - (x - x * x / (4 * f90) if x <= 2 * f90 else f90)
    p = c.max()
    if p <= start:
        return c
    new = 1 - (1 - start) ** 2 / (p + 1 - 2 * start)
    g = 1 / (desaturation * (p - new) + 1)
    return c * new / p * g + new * (1 - g)


def aces(c):
    before = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
    after = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
    v = before @ c
    return after @ ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081))


def xyz_of(primaries):
    """The matrix to XYZ of a space with these primaries and the white of D65."""
    columns = np.array([[x / y, 1, (1 - x - y) / y] for x, y in primaries]).T
    x, y = 0.3127, 0.3290
    return columns * np.linalg.solve(columns, [x / y, 1, (1 - x - y) / y])


REC709 = xyz_of([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)])
REC2020 = xyz_of([(0.708, 0.292), (0.170, 0.797), (0.131, 0.046)])
INSET = np.array([[0.856627153315983, 0.0951212405381588, 0.0482516061458583],
                  [0.137318972929847, 0.761241990602591, 0.101439036467562],
                  [0.11189821299995, 0.0767994186031903, 0.811302368396859]])
OUTSET_INVERSE = np.array([[0.899796955911611, 0.0871996192028351, 0.013003424885555],
                           [0.11142098895748, 0.875575586156966, 0.0130034248855548],
                           [0.11142098895748, 0.0871996192028349, 0.801379391839686]])


def sigmoid(t):
    """Through (0, 0), (pivot, 0.5) with the slope, and (1, 1)."""
    pivot, middle, slope = 10 / 16.5, 0.5, 2.0
    power, end, reached = (3.0, pivot, middle) if t < pivot else (3.25, 1 - pivot, 1 - middle)
    # slope d / (1 + a d^n)^(1/n) reaches what it must at the end.
    a = ((slope * end / reached) ** power - 1) / end**power
    d = t - pivot
    return middle + slope * d / (1 + a * abs(d) ** power) ** (1 / power)


def polynomial(t):
    return 15.5 * t**6 - 40.14 * t**5 + 31.96 * t**4 - 6.868 * t**3 + 0.4298 * t**2 + 0.1191 * t - 0.00232


def agx(c, curve=sigmoid):
    v = INSET @ np.linalg.solve(REC2020, REC709 @ c)
    low, high = np.log2(0.18) - 10, np.log2(0.18) + 6.5
    t = np.clip((np.log2(np.maximum(v, 1e-30)) - low) / (high - low), 0, 1)
    v = np.linalg.solve(OUTSET_INVERSE, np.array([curve(x) for x in t]))
    return np.linalg.solve(REC709, REC2020 @ np.maximum(v, 0) ** 2.2)


def srgb(x):
    return np.where(x > 0.0031308, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055, x * 12.92)


GREYS = [0, 1e-4, 1e-3, 0.003, 0.01, 0.02, 0.05, 0.08, 0.1, 0.18, 0.25, 0.5, 0.75, 0.8, 0.9, 1, 1.5, 2, 4, 10, 16, 30, 100]
COLOURS = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0.2, 0.1, 0.05], [0.05, 0.4, 0.9], [0.9, 0.6, 0.1], [8, 0.5, 0.1],
           [0, 20, 1], [0.3, 0, 50], [100, 100, 0], [0.02, 0.5, 0.02]]

if __name__ == "__main__":
    if sys.argv[1:] == ["agx"]:
        codes = [srgb(np.clip([agx(np.full(3, x)), agx(np.full(3, x), polynomial)], 0, 1))[:, 0] for x in np.geomspace(1e-4, 30, 4000)]
        far = [abs(a - b) * 255 for a, b in codes]
        print(f"greys: at most {max(far):.2f} of 255 apart, at {np.geomspace(1e-4, 30, 4000)[int(np.argmax(far))]:.4g}")
        sys.exit()
    print(f"# curve, linear colour before, linear colour after, cut to 0 and 1; printed by truth.py")
    for name, curve in [("neutral", neutral), ("aces", aces), ("agx", agx)]:
        for c in [[x] * 3 for x in GREYS] + COLOURS:
            after = np.clip(curve(np.array(c, dtype=float)), 0, 1)
            print(name, *(f"{x:g}" for x in c), *(f"{x + 0:.9f}" for x in after))
