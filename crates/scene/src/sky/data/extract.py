#!/usr/bin/env python3
"""Makes hosek-wilkie.f32 of the data sets in Mitsuba's wheel, which are those of Hosek and Wilkie in other order.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python extract.py

Little-endian single precision, linear Rec. 709 (red, green, blue), one array after the other:

    shape of the sky   10 turbidities x 2 albedos x 6 control points of elevation x 3 channels x 9
    mean radiance      10 turbidities x 2 albedos x 6 control points of elevation x 3 channels
    sun                10 turbidities x 45 segments of elevation x 3 channels x 4 powers of elevation x 6 of limb darkening
"""

import importlib.util
import pathlib
import struct

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
WHEEL = pathlib.Path(importlib.util.find_spec("mitsuba").origin).parent
TYPES = {10: "<f4", 11: "<f8"}


def tensors(data):
    """The arrays of a file of tensors by name."""
    assert data[:12] == b"tensor_file\0"
    (count,) = struct.unpack("<I", data[14:18])
    at, found = 18, {}
    for _ in range(count):
        (length,) = struct.unpack_from("<H", data, at)
        name = data[at + 2 : at + 2 + length].decode()
        at += 2 + length
        dimensions, kind, offset = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{dimensions}Q", data, at + 11)
        at += 11 + 8 * dimensions
        found[name] = np.frombuffer(data, TYPES[kind], int(np.prod(shape)), offset).reshape(shape)
    return found


sets = tensors((WHEEL / "data/sunsky/sunsky_datasets.bin").read_bytes())
names = {"sky_params_rgb": (10, 2, 6, 3, 9), "sky_rad_rgb": (10, 2, 6, 3), "sun_rad_rgb": (10, 45, 3, 4, 6)}
for name, shape in names.items():
    assert sets[name].shape == shape, (name, sets[name].shape)
numbers = np.concatenate([sets[name].ravel() for name in names]).astype("<f4")
assert np.isfinite(numbers).all()
(HERE / "hosek-wilkie.f32").write_bytes(numbers.tobytes())
