# SPDX-License-Identifier: GPL-3.0-or-later
"""Multilayer EXR files by Petzval and by Cycles: their channels, mattes and vectors. Imports bpy when it is called."""

from __future__ import annotations

import numpy as np


def exr_channels(path) -> dict[str, np.ndarray]:
    """Every channel, named layer.pass.channel, (height, width), first row at the bottom; of several views with the view's name and a
    colon before."""
    data = path.read_bytes()
    assert data[:4] == bytes([0x76, 0x2F, 0x31, 0x01])
    # From 5.0 on Blender writes one part for each layer.
    multipart = bool(data[5] & 0x10)

    def number(at: int, size: int = 4) -> int:
        return int.from_bytes(data[at : at + size], "little")

    def text(at: int) -> tuple[str, int]:
        end = data.index(0, at)
        return data[at:end].decode(), end + 1

    parts, at = [], 8
    while data[at] and (multipart or not parts):
        header = {}
        while data[at]:
            name, at = text(at)
            _, at = text(at)
            header[name], at = data[at + 4 : at + 4 + number(at)], at + 4 + number(at)
        parts.append(header)
        at += 1
    at += multipart
    found: dict[str, np.ndarray] = {}
    views = len({header.get("view") for header in parts}) > 1
    for header in parts:
        assert header["compression"] == bytes(1)
        left, top, right, bottom = np.frombuffer(header["dataWindow"], "<i4")
        width, height = right - left + 1, bottom - top + 1
        prefix = header.get("name", b"").decode()
        channels, here = [], 0
        while header["channels"][here]:
            end = header["channels"].index(0, here)
            name = header["channels"][here:end].decode()
            name = name if name.count(".") >= 2 else f"{prefix}.{name}"
            name = f"{header['view'].decode()}:{name}" if views else name
            channels.append((name, "<f2" if header["channels"][end + 1] == 1 else "<f4"))
            here = end + 17
        for row in range(height):
            chunk = number(at + 8 * row, 8) + 4 * multipart
            y, chunk = number(chunk) - top, chunk + 8
            for name, kind in channels:
                values = np.frombuffer(data, kind, width, chunk)
                chunk += values.nbytes
                found.setdefault(name, np.zeros((height, width), np.float32))[height - 1 - y] = values
        at += 8 * height
    return found


def photograph(parts, scene, path, engine: str = "PETZVAL", samples: int = 64, *, denoise: bool = False):
    """Every channel by pass and channel, lower case, and the whole file."""
    import bpy

    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.engine = engine
    scene.petzval.samples = scene.cycles.samples = samples
    scene.cycles.device = "CPU"
    scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = denoise, False
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return {name.partition(".")[2].lower(): pixels for name, pixels in exr_channels(path).items()}, path.read_bytes()


def mattes(channels, layer: str) -> dict[int, np.ndarray]:
    """Coverage by id, and nothing said twice."""
    found: dict[int, np.ndarray] = {}
    passes = sorted({name.partition(".")[0] for name in channels if name.startswith(f"crypto{layer.lower()}")})
    assert passes
    for one in passes:
        for name, value in (("r", "g"), ("b", "a")):
            ids, coverage = channels[f"{one}.{name}"].view(np.uint32), channels[f"{one}.{value}"]
            assert np.array_equal(ids == 0, coverage == 0.0)
            for which in np.unique(ids[ids != 0]):
                here = np.where(ids == which, coverage, 0.0)
                assert not (here * found.get(which, 0.0)).any()
                found[int(which)] = found.get(which, 0.0) + here
    return found


def vectors(channels) -> np.ndarray:
    return np.stack([channels[f"vector.{c}"] for c in "xyzw"], axis=-1)
