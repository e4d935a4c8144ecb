# SPDX-License-Identifier: GPL-3.0-or-later
"""An OpenEXR file's parts as bytes, whatever their compression: two files of the same pixels have the same, if one program wrote both."""

from __future__ import annotations

from pathlib import Path

#: Attributes that say when, how long, and of which file.
_OF_THE_MOMENT = {"Date", "Time", "RenderTime", "File"}


def exr_bytes(path: Path) -> list[tuple[dict[str, bytes], list[bytes]]]:
    """The attributes and the blocks of pixels of each part."""
    data = path.read_bytes()
    assert data[:4] == bytes([0x76, 0x2F, 0x31, 0x01]), path
    multipart = bool(data[5] & 0x10)

    def number(at: int, size: int = 4) -> int:
        return int.from_bytes(data[at : at + size], "little")

    headers, at = [], 8
    while data[at] and (multipart or not headers):
        header = {}
        while data[at]:
            name, at = data[at : (end := data.index(0, at))].decode(), end + 1
            at = data.index(0, at) + 1
            header[name], at = data[at + 4 : at + 4 + number(at)], at + 4 + number(at)
        headers.append(header)
        at += 1
    at += multipart
    parts = []
    for header in headers:
        lines_a_block = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32}[header["compression"][0]]
        low, high = number_of(header["dataWindow"], 4), number_of(header["dataWindow"], 12)
        count = -(-(high - low + 1) // lines_a_block)
        offsets = [number(at + 8 * i, 8) for i in range(count)]
        at += 8 * count
        blocks = []
        for offset in offsets:
            begin = offset + 4 * multipart
            blocks.append(data[begin : begin + 8 + number(begin + 4)])
        kept = {name: value for name, value in header.items() if name not in _OF_THE_MOMENT}
        parts.append((kept, blocks))
    return parts


def number_of(data: bytes, at: int) -> int:
    """A whole number of four bytes with a sign."""
    return int.from_bytes(data[at : at + 4], "little", signed=True)


def assert_same_picture(one: Path, other: Path) -> None:
    """Every pixel of every pass is the same to the last bit, and what the files say of them is."""
    parts, others = exr_bytes(one), exr_bytes(other)
    assert len(parts) == len(others)
    for (header, blocks), (other_header, other_blocks) in zip(parts, others, strict=True):
        differing = [name for name in header | other_header if header.get(name) != other_header.get(name)]
        assert not differing, [(name, header.get(name), other_header.get(name)) for name in differing]
        assert blocks == other_blocks, header.get("name")
