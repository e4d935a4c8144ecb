# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as a .blend that Cycles and Petzval both render. Imported where bpy is."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from . import places, scene


def build(folder: Path) -> None:
    """Writes a scene's scene.blend into its folder, beside the plain data if there is any, unless it is there."""
    target = Path(folder) / "scene.blend"
    if target.exists():
        return
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if maker := places.MAKERS.get(target.parent.name):
        maker()
        _settings(scene.CAMERA["bounces"])
    else:
        _from_arrays(target.parent)
    target.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(target), compress=False)


def _from_arrays(folder: Path) -> None:
    about, arrays = scene.read(folder)
    materials = {name: _material(name, facts) for name, facts in about["materials"].items()}
    for one in about["objects"]:
        material = materials[one["material"]] if one["material"] else _emitter(one["name"], one["emits"])
        _object(one["name"], arrays, material, smooth=one["emits"] is None)
    bpy.context.scene.world = _world(arrays["sky"])
    _camera(about["camera"])
    _settings(about["camera"]["bounces"])


def _surface(name: str, kind: str, distribution: str | None = None, **values: Any) -> bpy.types.Material:
    """A material of one shader node."""
    made = bpy.data.materials.new(name)
    tree = places.emptied_tree(made)
    node = tree.nodes.new(kind)
    if distribution:
        node.distribution = distribution
    for socket, value in values.items():
        node.inputs[socket].default_value = value
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def _material(name: str, facts: dict) -> bpy.types.Material:
    if facts["kind"] == "glass":
        return _surface(name, "ShaderNodeBsdfGlass", "GGX", IOR=facts["ior"], Roughness=0.0)
    colour = (*facts["rgb"], 1.0)
    if facts["kind"] == "diffuse":
        return _surface(name, "ShaderNodeBsdfDiffuse", Color=colour)
    # Blender's roughness is the root of the width.
    return _surface(name, "ShaderNodeBsdfAnisotropic", "GGX", Color=colour, Roughness=math.sqrt(facts["alpha"]))


def _emitter(name: str, radiance: list[float]) -> bpy.types.Material:
    strength = max(radiance)
    colour = (*(part / strength for part in radiance), 1.0)
    return _surface(name, "ShaderNodeEmission", Color=colour, Strength=strength)


def _object(name: str, arrays: dict[str, np.ndarray], material: bpy.types.Material, smooth: bool) -> None:
    vertices, triangles = arrays[name + ".vertices"], arrays[name + ".triangles"]
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth() if smooth else mesh.shade_flat()
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    # Cycles bends shadows of coarse smooth meshes a little, which no other program does.
    made.shadow_terminator_geometry_offset = made.shadow_terminator_shading_offset = 0.0
    bpy.context.scene.collection.objects.link(made)


def _world(sky: np.ndarray) -> bpy.types.World:
    rows, columns, _ = sky.shape
    image = bpy.data.images.new("sky", columns, rows, float_buffer=True)
    pixels = np.ones((rows, columns, 4), np.float32)
    pixels[..., :3] = sky[::-1]
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    made = bpy.data.worlds.new("sky")
    tree = places.emptied_tree(made)
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return made


def _camera(facts: dict) -> None:
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.sensor_width, data.lens = "HORIZONTAL", facts["film_width_mm"], facts["focal_length_mm"]
    data.dof.focus_distance, data.dof.aperture_fstop = facts["focus_m"], facts["f_number"]
    data.clip_start, data.clip_end = 0.01, 1000.0
    made = bpy.data.objects.new("camera", data)
    made.location, made.rotation_euler = facts["eye"], (0.5 * math.pi, 0.0, 0.0)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.scene.camera = made


def _settings(bounces: int) -> None:
    """Sets the settings that no program decides, and Cycles without all that trades truth for speed."""
    own = bpy.context.scene
    render, cycles = own.render, own.cycles
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode, image.exr_codec = "OPEN_EXR", "32", "RGB", "NONE"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
