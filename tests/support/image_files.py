# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files of tests: pictures without symmetry, tiles, sequences and movies. Imported inside of tests: it needs bpy."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np


def picture(width: int, height: int, seed: int, *, has_alpha: bool = False) -> np.ndarray:
    """(height, width, 4), smooth, another one for each seed."""
    phase = np.random.default_rng(seed).uniform(0.0, 6.0, (3, 2))
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    colours = [0.5 + 0.25 * np.sin(5.0 * x + a) + 0.2 * np.cos(4.0 * y + b) for a, b in phase]
    alpha = np.clip(0.2 + x, 0.0, 1.0) if has_alpha else np.ones_like(x)
    return np.stack([*colours, alpha], -1)


def plain(colour: tuple[float, float, float], width: int = 4, height: int = 4) -> np.ndarray:
    """One colour, opaque."""
    return np.broadcast_to([*colour, 1.0], (height, width, 4))


def save(path: Path, pixels: np.ndarray) -> Path:
    """Writes pixels, (height, width, 4) from below, as they stand: eight bits as PNG or JPEG, or floats as EXR, by the name's ending."""
    kind = {".png": "PNG", ".jpg": "JPEG", ".exr": "OPEN_EXR"}[path.suffix]
    height, width = pixels.shape[:2]
    made = bpy.data.images.new("made", width, height, alpha=True, float_buffer=kind == "OPEN_EXR")
    made.colorspace_settings.name = "Non-Color"
    made.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    made.filepath_raw, made.file_format = str(path), kind
    made.save()
    bpy.data.images.remove(made)
    return path


def sequence(folder: Path, frames: dict[int, np.ndarray], name: str = "frame_{:04d}.png") -> bpy.types.Image:
    """An image sequence of these frames."""
    paths = [save(folder / name.format(frame), pixels) for frame, pixels in frames.items()]
    image = bpy.data.images.load(str(paths[0]))
    image.source = "SEQUENCE"
    return image


def tiled(folder: Path, tiles: dict[int, np.ndarray | None], name: str = "tile.<UDIM>.png") -> bpy.types.Image:
    """An image of tiles; the file of one that is None is missing."""
    for number, pixels in tiles.items():
        if pixels is not None:
            save(folder / name.replace("<UDIM>", str(number)), pixels)
    first = min(tiles)
    image = bpy.data.images.load(str(folder / name.replace("<UDIM>", str(first))))
    image.source, image.filepath = "TILED", str(folder / name)
    known = {tile.number for tile in image.tiles}
    for number in sorted(tiles):
        if number not in known:
            image.tiles.new(number)
    return image


def movie(path: Path, frames: list[tuple[float, float, float]]) -> bpy.types.Image:
    """A movie whose frames have one colour each, without loss. Renders by Cycles in a scene of its own."""
    scene, world = bpy.data.scenes.new("Movie"), bpy.data.worlds.new("Movie")
    scene.world = world
    if world.node_tree is None or bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    colour = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND").inputs["Color"]
    for number, rgb in enumerate(frames, 1):
        colour.default_value = (*rgb, 1.0)
        assert colour.keyframe_insert("default_value", frame=number)
    camera = bpy.data.objects.new("Movie", bpy.data.cameras.new("Movie"))
    scene.collection.objects.link(camera)
    scene.camera, scene.frame_start, scene.frame_end = camera, 1, len(frames)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 16, 100
    scene.view_settings.view_transform, scene.render.dither_intensity = "Raw", 0.0
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "AVI", "FFV1"
    scene.render.filepath, scene.render.use_file_extension = str(path), False
    bpy.ops.render.render(animation=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    bpy.data.objects.remove(camera)
    return bpy.data.images.load(str(path))
