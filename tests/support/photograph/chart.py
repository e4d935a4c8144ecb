# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts of small lamps in the dark, photographed in Blender through `bpy.ops.render.render`, and spots measured.

A lamp is a small sphere that glows evenly: its light goes to every direction alike, as from the point that `truth`
traces from, and the middle of its image is the image of its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from support.places import ROOT

from . import native, truth

LENSES = ROOT / "lenses"
#: Variance in pixels of the charts' pixel filter, a Blackman-Harris window that ends two pixels from its middle.
_AT = np.linspace(-2.0, 2.0, 4001)
_WINDOW = sum(
    part * np.cos(np.pi * order * _AT / 2.0) for order, part in enumerate((0.35875, 0.48829, 0.14128, 0.01168))
)
FILTER_VARIANCE = float((_WINDOW * _AT**2).sum() / _WINDOW.sum())


def read_exr(bpy, path: Path) -> np.ndarray:
    """(height, width, 3) scene-linear, rows from below."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[:, :, :3].astype(float)


class Studio:
    """A dark scene with a camera at the origin, which looks along -z."""

    def __init__(self, bpy, folder: Path, pixels: tuple[int, int], samples: int = 256) -> None:
        self.bpy, self.folder, self.scene = bpy, folder, bpy.context.scene
        render = self.scene.render
        render.engine = "PETZVAL"
        render.resolution_x, render.resolution_y = pixels
        render.resolution_percentage = 100
        render.threads_mode = "AUTO"
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "IMAGE"
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"
        render.image_settings.color_mode = "RGB"
        self.scene.petzval.samples = samples
        self.scene.cycles.use_denoising = False
        self.scene.petzval.max_bounces = 0
        # What `truth` traces loses nothing; tests/lens/test_coatings.py has what glass takes.
        self.scene.petzval.effects.transmission = "OFF"
        # Nor does it stray: tests/lens/test_ghosts.py and the engine's own have that.
        for stray in ("ghosts", "glare", "diffraction"):
            setattr(self.scene.petzval.effects, stray, "OFF")
        # A Blackman-Harris window that ends two pixels from its middle has no part at one wave a pixel: the pixels' sum
        # and centroid are then those of the light itself. With a narrower one, centroids are off by up to 0.05 pixel.
        self.scene.petzval.filter_width = 2.0
        self.data = bpy.data.cameras.new("Camera")
        self.holder = bpy.data.objects.new("Camera", self.data)
        self.scene.collection.objects.link(self.holder)
        self.scene.camera = self.holder
        self.data.petzval.spectrum = "SINGLE"
        self.pixels = pixels
        self._sphere = None

    def lens(
        self,
        name: str,
        film_mm: tuple[float, float],
        focus: float | None,
        **extra,
    ) -> truth.Camera:
        """Sets the lens (`extra` as in `truth.Camera`), and gives what exact rays need to know of it.

        `focus`: Blender units before the camera, None is infinity.
        """
        own = self.data.petzval
        own.model = "LENS"
        own.lens_file = str(LENSES / f"{name}.lens")
        own.film_mode = "SIZE"
        own.film_width, own.film_height = film_mm
        if "focal_length_mm" in extra:
            own.focal_mode = "LENGTH"
            own.focal_length = extra["focal_length_mm"]
        if "f_number" in extra:
            own.wide_open = False
            own.f_number = extra["f_number"]
        own.blades = extra.get("blades", 0)
        own.blade_rotation = extra.get("blade_rotation_rad", 0.0)
        own.tilt, own.swing = extra.get("tilt_rad", 0.0), extra.get("swing_rad", 0.0)
        own.shift_x, own.shift_y = extra.get("shift_mm", (0.0, 0.0))
        if focus is None:
            own.focus_mode = "INFINITY"
        else:
            own.focus_mode = "CAMERA"
            self.data.dof.focus_distance = focus
        mm_per_unit = 1000.0 * self.scene.unit_settings.scale_length
        return exact_camera(LENSES / f"{name}.lens", film_mm, focus, self.pixels, mm_per_unit=mm_per_unit, **extra)

    def lamp(self, at: Sequence[float], radius: float, matrix=None) -> None:
        """A glowing sphere at a place in the camera's space; `matrix`: from there to the world, none for the origin."""
        from mathutils import Vector

        holder = self.bpy.data.objects.new("Lamp", self._sphere_mesh())
        holder.location = Vector(at) if matrix is None else matrix @ Vector(at)
        holder.scale = (radius, radius, radius)
        self.scene.collection.objects.link(holder)

    def _sphere_mesh(self):
        if self._sphere is None:
            import bmesh

            shape = bmesh.new()
            bmesh.ops.create_icosphere(shape, subdivisions=3, radius=1.0)
            self._sphere = self.bpy.data.meshes.new("Lamp")
            shape.to_mesh(self._sphere)
            shape.free()
            self._sphere.materials.append(self.glow("Glow", (1.0, 1.0, 1.0)))
        return self._sphere

    def glow(self, name: str, colour: tuple[float, float, float]):
        material = self.bpy.data.materials.new(name)
        if material.node_tree is None:  # before 5.0 a material starts without
            material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        emission = tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = (*colour, 1.0)
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        return material

    def white_world(self) -> None:
        world = self.bpy.data.worlds.new("White")
        self.scene.world = world
        if world.node_tree is None:
            world.use_nodes = True
        world.node_tree.nodes.clear()
        background = world.node_tree.nodes.new("ShaderNodeBackground")
        background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        output = world.node_tree.nodes.new("ShaderNodeOutputWorld")
        world.node_tree.links.new(background.outputs[0], output.inputs["Surface"])

    def shoot(self) -> np.ndarray:
        """The photograph, (height, width, 3) scene-linear, rows from below."""
        path = self.folder / "photograph.exr"
        path.unlink(missing_ok=True)
        self.scene.render.filepath = str(path)
        assert self.bpy.ops.render.render(write_still=True) == {"FINISHED"}
        return read_exr(self.bpy, path)


def exact_camera(lens, film_mm, focus, pixels, *, mm_per_unit=1000.0, film_z_mm=None, **extra) -> truth.Camera:
    """What exact rays need; the film stands where the engine says, and the picture is the film's largest part."""
    width, height = pixels
    picture_width = min(film_mm[0], film_mm[1] * width / height)
    settings = {key: extra[key] for key in ("focal_length_mm", "f_number", "blades") if key in extra}
    if film_z_mm is None:
        asked = native.camera(
            lens,
            film_width_mm=film_mm[0],
            film_height_mm=film_mm[1],
            focus_distance=focus,
            scale_mm_per_unit=(mm_per_unit,) * 3,
            **settings,
        )
        film_z_mm = native.info(asked, width, height)["film_z_mm"]
    return truth.Camera(
        lens=Path(lens),
        film_z_mm=film_z_mm,
        picture_mm=(picture_width, picture_width * height / width),
        pixels=pixels,
        mm_per_unit=mm_per_unit,
        **extra,
    )


def spots(picture: np.ndarray, expected: Sequence[np.ndarray]) -> list[truth.Spot]:
    """The light of a picture divided among the places where it is expected: each pixel's goes to the nearest."""
    grey = picture.mean(axis=2)
    row, column = np.nonzero(grey)
    at = np.column_stack([column + 0.5, row + 0.5])
    light = grey[row, column]
    owner = np.argmin(((at[:, None, :] - np.asarray(expected)[None]) ** 2).sum(axis=2), axis=1)
    return [truth.Spot(at[owner == number], light[owner == number]) for number in range(len(expected))]
