# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as files: OpenEXR (32-bit floats), PNG (8 or 16 bits), Middlebury .flo. Arrays have their first row at the top."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .. import atomic_files

Array = npt.NDArray[np.float32]

#: Rows of a block of OpenEXR's compression ZIP.
_BLOCK = 16


def write_exr(file: Path, channels: Mapping[str, npt.NDArray[np.floating]], comment: str) -> None:
    """Writes one part of scan lines, compression ZIP (openexr.com, "OpenEXR File Layout"): channels in the order of their names, as
    readers expect."""
    names = sorted(channels)
    planes = [np.ascontiguousarray(channels[name], "<f4") for name in names]
    height, width = planes[0].shape
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for name in names) + b"\0"
    attributes = [
        ("channels", "chlist", listed), ("comments", "string", comment.encode()), ("compression", "compression", b"\3"),
        ("dataWindow", "box2i", box), ("displayWindow", "box2i", box), ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)), ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]  # fmt: skip
    header = struct.pack("<II", 20000630, 2)
    for name, kind, value in attributes:
        header += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value
    header += b"\0"
    # Row by row, in each all channels after one another.
    rows = np.stack(planes, axis=1)
    blocks = []
    for y in range(0, height, _BLOCK):
        data = rows[y : y + _BLOCK].tobytes()
        packed = _zipped(data)
        blocks.append(struct.pack("<ii", y, len(packed)) + packed)
    at = len(header) + 8 * len(blocks)
    offsets = b""
    for block in blocks:
        offsets += struct.pack("<Q", at)
        at += len(block)
    atomic_files.write_bytes(file, header + offsets + b"".join(blocks))


def _zipped(data: bytes) -> bytes:
    """Bytes as compression ZIP has them: those at even places first, then the differences of neighbours; as they are where that is shorter."""
    plain = np.frombuffer(data, np.uint8)
    sorted_ = np.concatenate([plain[0::2], plain[1::2]]).astype(np.int16)
    sorted_[1:] = sorted_[1:] - sorted_[:-1] + 128
    packed = zlib.compress(sorted_.astype(np.uint8).tobytes(), 6)
    return packed if len(packed) < len(data) else data


def write_png(file: Path, pixels: npt.NDArray[np.unsignedinteger]) -> None:
    """Writes (height, width) or (height, width, 3) of 8 or 16 bits (W3C, Portable Network Graphics)."""
    height, width = pixels.shape[:2]
    bits = 8 * pixels.dtype.itemsize
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(height, -1).view(np.uint8)
    # Differences between neighbouring rows pack best where masks have large areas.
    filtered = np.empty((height, rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = 2
    filtered[0, 1:] = rows[0]
    filtered[1:, 1:] = rows[1:] - rows[:-1]
    header = struct.pack(">IIBBBBB", width, height, bits, 2 if pixels.ndim == 3 else 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    packed = b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
    atomic_files.write_bytes(file, b"\x89PNG\r\n\x1a\n" + packed)


def write_flo(file: Path, flow: Array, known: npt.NDArray[np.bool_]) -> None:
    """Writes flow (height, width, 2) as Middlebury's .flo; unknown flow is 1e10, above its bound of 1e9 (vision.middlebury.edu/flow,
    flow-code)."""
    height, width = flow.shape[:2]
    values = np.where(known[..., None], flow, 1e10).astype("<f4")
    atomic_files.write_bytes(file, b"PIEH" + struct.pack("<ii", width, height) + values.tobytes())
