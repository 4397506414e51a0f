#!/usr/bin/env python3
"""Radiance of the sky and the sun by Mitsuba 3's emitter `sunsky`: prints mitsuba.txt.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python measure.py > mitsuba.txt
"""

import math
import random

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
HALF_ANGLE = math.radians(0.5358 / 2)
RINGS, SPOKES = 48, 96
DIRECTIONS = 200


def emitter(turbidity, albedo, elevation, **more):
    e = math.radians(elevation)
    direction = [math.cos(e), 0, math.sin(e)]
    return mi.load_dict(
        {"type": "sunsky", "turbidity": turbidity, "albedo": albedo, "sun_direction": direction, **more}
    )


def radiance(of, direction):
    si = mi.SurfaceInteraction3f()
    si.wi = -mi.Vector3f(*direction)
    return np.array(of.eval(si), dtype=float)


def from_sun(elevation, angle, around):
    """A unit vector at an angle from the sun's middle."""
    e = math.radians(elevation)
    up, side = math.sin(angle) * math.sin(around), math.sin(angle) * math.cos(around)
    c = math.cos(angle)
    return [c * math.cos(e) - up * math.sin(e), side, c * math.sin(e) + up * math.cos(e)]


def irradiance(turbidity, elevation):
    """Of a surface that faces the sun, by a sum over its disk with limb darkening."""
    sun = emitter(turbidity, 0.3, elevation, sky_scale=0.0, complex_sun=True)
    total = np.zeros(3)
    for ring in range(RINGS):
        angle = HALF_ANGLE * math.sqrt((ring + 0.5) / RINGS)
        for spoke in range(SPOKES):
            total += radiance(sun, from_sun(elevation, angle, 2 * math.pi * (spoke + 0.5) / SPOKES))
    return total / (RINGS * SPOKES) * 2 * math.pi * (1 - math.cos(HALF_ANGLE))


def put(kind, *numbers):
    print(kind, *("%.6g" % x for x in numbers))


rng = random.Random(7)
directions = []
while len(directions) < DIRECTIONS:
    # Half of them are near the horizon, where the sky changes fast.
    z = max(rng.random() ** 3 if len(directions) % 2 else rng.random(), 1e-3)
    around = rng.uniform(0, 2 * math.pi)
    flat = math.sqrt(1 - z * z)
    # As they are printed.
    direction = [float("%.6g" % x) for x in [flat * math.cos(around), flat * math.sin(around), z]]
    directions.append(direction)

print("# direction: x towards the sun, y beside it, z up; of unit length but for rounding")
for direction in directions:
    put("direction", *direction)
albedos = [0.0, 0.3, 1.0]
for row, elevation in enumerate([2, 15, 45, 80]):
    for column, turbidity in enumerate([2, 5, 9, 3.4]):
        albedo = albedos[(row + column) % 3]
        print("# sky: turbidity, albedo, elevation of the sun; then the radiance from each direction (red, green, blue)")
        put("sky", turbidity, albedo, elevation)
        sky = emitter(turbidity, albedo, elevation, sun_scale=0.0)
        for direction in directions:
            put("radiance", *radiance(sky, direction / np.linalg.norm(direction)))
        print("# sun: turbidity, elevation; radiance of its middle; irradiance by the disk with limb darkening, and as Mitsuba's default has it")
        e = math.radians(elevation)
        middle = radiance(
            emitter(turbidity, albedo, elevation, sky_scale=0.0, complex_sun=True), [math.cos(e), 0, math.sin(e)]
        )
        even = radiance(emitter(turbidity, albedo, elevation, sky_scale=0.0), [math.cos(e), 0, math.sin(e)])
        even *= 2 * math.pi * (1 - math.cos(HALF_ANGLE))
        put("sun", turbidity, elevation, *middle, *irradiance(turbidity, elevation), *even)
