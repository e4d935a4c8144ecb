# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear pictures for sensors, and raw files read back: what the tests of sensors write and read by themselves."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np

#: A sensor whose every number is known: a flat quantum efficiency, and noise of each kind that shows.
KNOWN = {
    "name": "Known",
    "source": "made up",
    "first_nm": 300.0,
    "step_nm": 100.0,
    "monochrome": [1.0] * 7,
    "curves_per": "photon",
    "peak_quantum_efficiency": 0.62,
    "pixel_pitch_um": 5.86,
    "mosaic": "monochrome",
    "bits": 12,
    "black_level_dn": 200,
    "base_iso": 100,
    "gain_dn_per_e": 0.25,
    "full_well_e": 14000,
    "read_noise": [{"from_iso": 0, "upstream_e": 6.8, "downstream_dn": 1.0}],
    "dark_current_e_per_s": 120.0,
    "dsnu_e": 4.0,
    "prnu_percent": 1.2,
}


def sensor_file(folder: Path, name: str = "known.json", **changed: Any) -> str:
    """`KNOWN` with other values in a file; None leaves one out."""
    values = {key: value for key, value in {**KNOWN, **changed}.items() if value is not None}
    path = folder / name
    path.write_text(json.dumps(values))
    return str(path)


def save_exr(path: Path, pixels: np.ndarray) -> Path:
    """Writes rows, columns, RGB as an uncompressed OpenEXR file of single precision, first row at the top."""
    height, width, _ = pixels.shape

    def attribute(name: str, kind: str, data: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(name + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
    head += attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box)
    head += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0"
    line = 12 * width
    begin = len(head) + 8 * height
    offsets = struct.pack(f"<{height}Q", *(begin + y * (8 + line) for y in range(height)))
    planes = np.ascontiguousarray(pixels[..., ::-1].transpose(0, 2, 1), dtype="<f4")
    lines = (struct.pack("<ii", y, line) + planes[y].tobytes() for y in range(height))
    path.write_bytes(head + offsets + b"".join(lines))
    return path


def read_png(path: Path) -> np.ndarray:
    """The numbers of a PNG of 16 bits without filters: rows, columns, planes."""
    data, at, packed = path.read_bytes(), 8, b""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + length)[0]
        if kind == b"IHDR":
            width, height, bits, colours = struct.unpack_from(">IIBB", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    assert bits == 16
    planes = {0: 1, 2: 3}[colours]
    lines = np.frombuffer(zlib.decompress(packed), dtype=np.uint8).reshape(height, 1 + 2 * planes * width)
    assert not lines[:, 0].any()
    return np.ascontiguousarray(lines[:, 1:]).view(">u2").reshape(height, width, planes).astype(np.int64)


def lab(linear: np.ndarray) -> np.ndarray:
    """CIE L*a*b* under D65 of linear Rec.709 (IEC 61966-2-1, CIE 015:2018)."""
    matrix = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.072175], [0.0193339, 0.119192, 0.9503041]]
    )
    ratio = linear @ matrix.T / matrix.sum(axis=1)
    small = (6 / 29) ** 3
    f = np.where(ratio > small, np.cbrt(np.maximum(ratio, 0.0)), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def ciede2000(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Difference of two colours in L*a*b* (CIE 142-2001; Sharma, Wu and Dalal 2005)."""
    (l1, a1, b1), (l2, a2, b2) = np.moveaxis(one, -1, 0), np.moveaxis(other, -1, 0)
    mean_c7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2) ** 7
    stretch = 1.5 - 0.5 * np.sqrt(mean_c7 / (mean_c7 + 25.0**7))
    a1, a2 = a1 * stretch, a2 * stretch
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.arctan2(b1, a1) % (2 * np.pi), np.arctan2(b2, a2) % (2 * np.pi)
    turn = (h2 - h1 + np.pi) % (2 * np.pi) - np.pi
    turn = np.where(c1 * c2 == 0.0, 0.0, turn)
    dh = 2 * np.sqrt(c1 * c2) * np.sin(turn / 2)
    mean_l, mean_c, mean_h = (l1 + l2) / 2, (c1 + c2) / 2, h1 + turn / 2
    mean_h = np.where(c1 == 0.0, h2, np.where(c2 == 0.0, h1, mean_h))
    degrees = np.degrees(mean_h) % 360
    t = (
        1
        - 0.17 * np.cos(mean_h - np.pi / 6)
        + 0.24 * np.cos(2 * mean_h)
        + 0.32 * np.cos(3 * mean_h + np.radians(6))
        - 0.2 * np.cos(4 * mean_h - np.radians(63))
    )
    sl = 1 + 0.015 * (mean_l - 50) ** 2 / np.sqrt(20 + (mean_l - 50) ** 2)
    sc, sh = 1 + 0.045 * mean_c, 1 + 0.015 * mean_c * t
    turned = np.radians(60) * np.exp(-(((degrees - 275) / 25) ** 2))
    rt = -2 * np.sqrt(mean_c**7 / (mean_c**7 + 25.0**7)) * np.sin(turned)
    dl, dc = (l2 - l1) / sl, (c2 - c1) / sc
    return np.sqrt(dl**2 + dc**2 + (dh / sh) ** 2 + rt * dc * dh / sh)
