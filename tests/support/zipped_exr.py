# SPDX-License-Identifier: GPL-3.0-or-later
"""Channels of any names out of an OpenEXR file of one part, in tiles compressed by ZIP, as the engine writes maps. Needs no Blender."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np


def read(path: Path) -> tuple[dict[str, np.ndarray], str]:
    """Channels by name, (height, width), first row at the top, and the comments of the header."""
    data = Path(path).read_bytes()
    assert data[:4] == bytes([0x76, 0x2F, 0x31, 0x01]) and not data[5] & 0x10, path

    def text(at: int) -> tuple[str, int]:
        end = data.index(0, at)
        return data[at:end].decode(), end + 1

    header, at = {}, 8
    while data[at]:
        name, at = text(at)
        _, at = text(at)
        size = int.from_bytes(data[at : at + 4], "little")
        header[name], at = data[at + 4 : at + 4 + size], at + 4 + size
    at += 1
    assert header["compression"] == bytes([3]), header["compression"]
    left, top, right, bottom = np.frombuffer(header["dataWindow"], "<i4")
    width, height = right - left + 1, bottom - top + 1
    names, here = [], 0
    while header["channels"][here]:
        end = header["channels"].index(0, here)
        names.append(header["channels"][here:end].decode())
        assert header["channels"][end + 1] == 2, "a channel is not of 32-bit floats"
        here = end + 17
    found = {name: np.zeros((height, width), np.float32) for name in names}
    side_x, side_y = np.frombuffer(header["tiles"], "<i4", 2)
    count = -(-width // side_x) * -(-height // side_y)
    for offset in np.frombuffer(data, "<u8", count, at).astype(int):
        column, row, _, _, size = np.frombuffer(data, "<i4", 5, offset)
        x, y = column * side_x, row * side_y
        across, rows = min(side_x, width - x), min(side_y, height - y)
        packed = data[offset + 20 : offset + 20 + size]
        full = int(rows * across * len(names) * 4)
        if size < full:
            # Bytes are the differences of their neighbours, and the even ones stand before the odd ones.
            steps = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            steps[1:] -= 128
            plain = (np.cumsum(steps) & 0xFF).astype(np.uint8)
            half = (full + 1) // 2
            woven = np.empty(full, np.uint8)
            woven[0::2], woven[1::2] = plain[:half], plain[half:]
            packed = woven.tobytes()
        lines = np.frombuffer(packed, "<f4").reshape(rows, len(names), across)
        for i, name in enumerate(names):
            found[name][y : y + rows, x : x + across] = lines[:, i]
    return found, header.get("comments", b"").decode()
