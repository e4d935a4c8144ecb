# SPDX-License-Identifier: GPL-3.0-or-later
"""A tile of six materials that is baked by Petzval and by Cycles, and how far apart the two images are. Imported inside of tests: it
needs bpy."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from support import scenes as parts
from support import shaders
from support.node_tree import Tree

#: Pixels of a material's side, columns and rows of materials, and pixels of a block's side.
SIDE, COLUMNS, ROWS, BLOCK = 16, 3, 2, 8
#: Faces of a material's side.
FACES = 4
BOUNCES = 6
#: What the surface's materials are, from the lower left, row by row.
MATERIALS = ("bumpy", "metal", "plastic", "glass", "glowing", "veil")


def set_up() -> bpy.types.Object:
    """The tile, waved and smooth; a ball over it, a coloured wall beside it, a floor below; a lamp, a sun and a sky."""
    scene = parts.set_up()
    scene.world = _sky()
    scene.camera.location, scene.camera.rotation_euler = (1.5, -4.0, 3.0), (0.9, 0.0, 0.1)
    tile = _tile([_MADE[name](name) for name in MATERIALS])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.5, location=(1.4, 0.9, 1.0))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(_plain("Ball", "BsdfDiffuse", Color=shaders.RED))
    green = _plain("Green", "BsdfDiffuse", Color=shaders.GREEN)
    parts.mesh_object("Wall", [(-0.4, -1, -1), (-0.4, 3, -1), (-0.4, 3, 2), (-0.4, -1, 2)], [(0, 1, 2, 3)], green)
    grey = _plain("Grey", "BsdfDiffuse", Color=(0.6, 0.6, 0.6, 1.0))
    parts.mesh_object("Floor", [(-4, -4, -1), (7, -4, -1), (7, 6, -1), (-4, 6, -1)], [(0, 1, 2, 3)], grey)
    _lamp("Lamp", "AREA", (2.5, -1.0, 3.0), 120.0, (0.5, 0.2, 0.3)).data.size = 1.5
    sun = _lamp("Sun", "SUN", (0.0, 0.0, 5.0), 1.0, (0.3, -0.4, 0.0))
    sun.data.angle = 0.3
    return tile


def image(name: str = "Baked", width: int = COLUMNS * SIDE, height: int = ROWS * SIDE) -> bpy.types.Image:
    """A new image of numbers, into which all materials of the scene are baked."""
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=True)
    for material in bpy.data.materials:
        show(material, made)
    return made


def show(material: bpy.types.Material, made: bpy.types.Image) -> None:
    """Makes an image the one that a material is baked into."""
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = made
    material.node_tree.nodes.active = node


def bake(
    holder: bpy.types.Object,
    into: bpy.types.Image | None,
    kind: str,
    engine: str,
    samples: int,
    seed: int = 0,
    pass_filter: set[str] | None = None,
    **settings,
) -> np.ndarray | None:
    """What Blender's operator makes of an image, (height, width, 4). `settings` are Blender's of bakes; what is not given is as in a new scene,
    but without margin."""
    scene = bpy.context.scene
    _same_for_both(samples, seed)
    defaults = {
        "margin": 0, "view_from": "ABOVE_SURFACE", "use_clear": True, "normal_space": "OBJECT", "target": "IMAGE_TEXTURES",
        "use_selected_to_active": False, "use_cage": False, "cage_object": None, "cage_extrusion": 0.0,
    }  # fmt: skip
    for name, value in (defaults | settings).items():
        setattr(scene.render.bake, name, value)
    for one in scene.objects:
        one.select_set(one == holder or (one.get("baked_from", False) and scene.render.bake.use_selected_to_active))
    bpy.context.view_layer.objects.active = holder
    scene.render.engine = engine
    try:
        bpy.ops.object.bake(type=kind, **({} if pass_filter is None else {"pass_filter": pass_filter}))
    finally:
        scene.render.engine = "PETZVAL"
    return None if into is None else pixels(into)


def pixels(of: bpy.types.Image) -> np.ndarray:
    """An image's pixels, (height, width, 4), first row at the bottom."""
    found = np.empty(len(of.pixels), np.float32)
    of.pixels.foreach_get(found)
    return found.reshape(of.size[1], of.size[0], 4)


def blocks(picture: np.ndarray, side: int = BLOCK) -> np.ndarray:
    """Means of blocks, (rows, columns, channels)."""
    height, width, channels = picture.shape
    return picture.reshape(height // side, side, width // side, side, channels).mean((1, 3))


def both(take: Callable[[str, int], np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means of blocks by Petzval and by Cycles, of two seeds each, and the noise of either's: half of what its seeds differ by. `take` is
    called with engine and seed."""
    ours, theirs = ([blocks(take(engine, seed)) for seed in (0, 7)] for engine in ("PETZVAL", "CYCLES"))
    noise = 0.5 * np.hypot(ours[0] - ours[1], theirs[0] - theirs[1])
    return 0.5 * (ours[0] + ours[1]), 0.5 * (theirs[0] + theirs[1]), noise


def _same_for_both(samples: int, seed: int) -> None:
    """Nothing that trades truth for speed, in either engine."""
    scene = bpy.context.scene
    own, cycles = scene.petzval, scene.cycles
    own.samples = cycles.samples = samples
    own.seed = cycles.seed = seed
    own.clamp_indirect, own.use_noise_threshold = 0.0, False
    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.max_bounces = BOUNCES
    for kind in ("diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)


def _tile(materials: list[bpy.types.Material]) -> bpy.types.Object:
    columns, rows = COLUMNS * FACES, ROWS * FACES
    x, y = np.meshgrid(np.linspace(0, COLUMNS, columns + 1), np.linspace(0, ROWS, rows + 1))
    z = 0.12 * np.sin(2.1 * x) * np.cos(1.7 * y)
    corner = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], -1).reshape(-1, 4)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    uv = (vertices[faces.reshape(-1), :2] / (COLUMNS, ROWS)).reshape(-1, 2)
    tile = parts.mesh_object("Tile", vertices, faces, *materials, uv=uv)
    column, row = np.meshgrid(np.arange(columns) // FACES, np.arange(rows) // FACES)
    tile.data.polygons.foreach_set("material_index", (row * COLUMNS + column).reshape(-1).astype(np.int32))
    tile.data.shade_smooth()
    # Neither engine knows it by its own axes alone.
    tile.rotation_euler, tile.location, tile.scale = (0.05, -0.1, 0.2), (0.1, -0.2, 0.1), (1.0, 1.1, 0.9)
    bpy.context.view_layer.update()
    return tile


def _sky() -> bpy.types.World:
    world = bpy.data.worlds.new("Sky")
    tree = parts.with_nodes(world)
    out = tree.nodes.new("ShaderNodeOutputWorld")
    made = Tree(tree, out.inputs["Surface"])
    background = tree.nodes.new("ShaderNodeBackground")
    coordinates = made.node("ShaderNodeTexCoord", None) if False else tree.nodes.new("ShaderNodeTexCoord")
    ramp = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(coordinates.outputs["Generated"], ramp.inputs[0])
    lift = tree.nodes.new("ShaderNodeMath")
    lift.operation, lift.inputs[1].default_value, lift.inputs[2].default_value = "MULTIPLY_ADD", 0.25, 0.35
    tree.links.new(ramp.outputs["Z"], lift.inputs[0])
    background.inputs["Color"].default_value = (0.6, 0.8, 1.0, 1.0)
    tree.links.new(lift.outputs[0], background.inputs["Strength"])
    tree.links.new(background.outputs[0], out.inputs["Surface"])
    return world


def _lamp(name: str, kind: str, location, energy: float, turn) -> bpy.types.Object:
    lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    lamp.data.energy, lamp.location, lamp.rotation_euler = energy, location, turn
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def _plain(name: str, kind: str, **inputs) -> bpy.types.Material:
    made, tree, surface = parts.material(name)
    tree.links.new(shaders.node(tree, kind, None, **inputs), surface)
    return made


def _bumpy(name: str) -> bpy.types.Material:
    """Matte, checked by its UV map, with waves as a bump."""
    made, tree, surface = parts.material(name)
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    uv = tree.nodes.new("ShaderNodeUVMap")
    check = tree.nodes.new("ShaderNodeTexChecker")
    check.inputs["Color1"].default_value, check.inputs["Color2"].default_value = shaders.RED, shaders.GOLD
    check.inputs["Scale"].default_value = 24.0
    wave = tree.nodes.new("ShaderNodeTexWave")
    wave.inputs["Scale"].default_value = 2.0
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.8, 0.1
    tree.links.new(uv.outputs[0], check.inputs["Vector"])
    tree.links.new(check.outputs["Color"], shader.inputs["Color"])
    tree.links.new(wave.outputs["Fac"], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    tree.links.new(shader.outputs[0], surface)
    return made


def _glowing(name: str) -> bpy.types.Material:
    made, tree, surface = parts.material(name)
    matte = shaders.node(tree, "BsdfDiffuse", None, Color=shaders.GOLD)
    glow = shaders.node(tree, "Emission", None, Color=(0.2, 0.5, 1.0, 1.0), Strength=0.7)
    tree.links.new(shaders.add(tree, matte, glow), surface)
    return made


def _veil(name: str) -> bpy.types.Material:
    """Two fifths transparent, the rest paper and lacquer."""
    made, tree, surface = parts.material(name)
    paper = shaders.node(tree, "BsdfTranslucent", None, Color=shaders.GREEN)
    lacquer = shaders.node(tree, "BsdfAnisotropic", None, Color=shaders.WHITE, Roughness=0.6)
    clear = shaders.node(tree, "BsdfTransparent", None, Color=(0.9, 0.9, 1.0, 1.0))
    solid = shaders.mix(tree, 0.5, paper, lacquer)
    tree.links.new(shaders.mix(tree, 0.4, solid, clear), surface)
    return made


_MADE: dict[str, Callable[[str], bpy.types.Material]] = {
    "bumpy": _bumpy,
    "metal": lambda name: _plain(
        name, "BsdfPrincipled", Base_Color=shaders.GOLD, Metallic=1.0, Roughness=0.4
    ),
    "plastic": lambda name: _plain(name, "BsdfPrincipled", Base_Color=shaders.GREEN, Roughness=0.3),
    "glass": lambda name: _plain(name, "BsdfGlass", Color=shaders.WHITE, Roughness=0.3, IOR=1.4),
    "glowing": _glowing,
    "veil": _veil,
}
