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
    ball.data.materials.append(plain("Ball", "BsdfDiffuse", Color=shaders.RED))
    green = plain("Green", "BsdfDiffuse", Color=shaders.GREEN)
    parts.mesh_object("Wall", [(-0.4, -1, -1), (-0.4, 3, -1), (-0.4, 3, 2), (-0.4, -1, 2)], [(0, 1, 2, 3)], green)
    grey = plain("Grey", "BsdfDiffuse", Color=(0.6, 0.6, 0.6, 1.0))
    parts.mesh_object("Floor", [(-4, -4, -1), (7, -4, -1), (7, 6, -1), (-4, 6, -1)], [(0, 1, 2, 3)], grey)
    _lamp("Lamp", "AREA", (2.5, -1.0, 3.0), 120.0, (0.5, 0.2, 0.3)).data.size = 1.5
    sun = _lamp("Sun", "SUN", (0.0, 0.0, 5.0), 1.0, (0.3, -0.4, 0.0))
    sun.data.angle = 0.6
    return tile


def image(name: str = "Baked", width: int = COLUMNS * SIDE, height: int = ROWS * SIDE) -> bpy.types.Image:
    """A new image of numbers, into which all materials of the scene are baked."""
    made = new_image(name, width, height)
    for material in bpy.data.materials:
        show(material, made)
    return made


def new_image(name: str, width: int, height: int) -> bpy.types.Image:
    """An image of numbers, which no material shows."""
    return bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=True)


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
    same_for_both(samples, seed)
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
    """Means of blocks by Petzval and by Cycles, each the mean of two seeds, and the standard error of their difference by what the seeds
    differ by: the root of the mean square over the blocks of a material. `take` is called with engine and seed."""
    ours, theirs = ([blocks(take(engine, seed)) for seed in (0, 7)] for engine in ("PETZVAL", "CYCLES"))
    error = 0.5 * np.hypot(ours[0] - ours[1], theirs[0] - theirs[1])
    side = SIDE // BLOCK
    pooled = np.sqrt(blocks(error**2, side) if error.shape[0] % side == 0 else (error**2).mean((0, 1), keepdims=True))
    error = np.repeat(np.repeat(pooled, side, 0), side, 1)[: error.shape[0], : error.shape[1]]
    return 0.5 * (ours[0] + ours[1]), 0.5 * (theirs[0] + theirs[1]), error


def same(ours: np.ndarray, theirs: np.ndarray, error: np.ndarray, limit: float = 0.01, noise: float = 0.04) -> None:
    """Asserts that blocks agree: to the limit, of the block or of the mean of all, whichever is more, beyond four standard errors. One block
    of some dozens is off by three by chance. These may be no more than the part `noise` of the same."""
    scale = np.maximum(np.abs(theirs), np.abs(theirs).mean((0, 1)))
    beyond = np.abs(ours - theirs) - limit * scale - 4.0 * error
    print(
        ours.mean((0, 1)),
        theirs.mean((0, 1)),
        "worst",
        (np.abs(ours - theirs) / np.maximum(scale, 1e-9)).max(),
        error.max(),
    )
    assert beyond.max() <= 1e-5, (np.argwhere(beyond > 1e-5), ours, theirs)
    # What noise hides is no agreement.
    assert (4.0 * error / np.maximum(scale, 1e-9)).max() <= noise, (error, scale)


def same_for_both(samples: int, seed: int) -> None:
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
    """Brighter above than below."""
    world = bpy.data.worlds.new("Sky")
    tree = parts.with_nodes(world)
    made = Tree(tree, tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    up = made.node("SeparateXYZ", None, Vector=made.coordinates("Generated")).outputs["Z"]
    strength = made.math("ADD", made.math("MULTIPLY", up, 0.25), 0.35)
    made.shows(made.node("Background", None, Color=(0.6, 0.8, 1.0, 1.0), Strength=strength).outputs[0])
    return world


def _lamp(name: str, kind: str, location, energy: float, turn) -> bpy.types.Object:
    lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    lamp.data.energy, lamp.location, lamp.rotation_euler = energy, location, turn
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def plain(name: str, kind: str, **inputs) -> bpy.types.Material:
    made, tree, surface = parts.material(name)
    tree.links.new(shaders.node(tree, kind, None, **inputs), surface)
    return made


def _bumpy(name: str) -> bpy.types.Material:
    """Matte, checked by its UV map, with waves as a bump."""
    material, tree, surface = parts.material(name)
    made = Tree(tree, surface)
    check = made.node(
        "TexChecker", None, Vector=made.node("UVMap").outputs[0], Color1=shaders.RED, Color2=shaders.GOLD, Scale=24.0
    )
    wave = made.node("TexWave", None, Scale=2.0)
    bump = made.node("Bump", None, Strength=0.8, Distance=0.1, Height=wave.outputs["Fac"])
    made.shows(made.node("BsdfDiffuse", None, Color=check.outputs["Color"], Normal=bump.outputs[0]).outputs[0])
    return material


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
    "metal": lambda name: plain(name, "BsdfPrincipled", Base_Color=shaders.GOLD, Metallic=1.0, Roughness=0.5),
    "plastic": lambda name: plain(name, "BsdfPrincipled", Base_Color=shaders.GREEN, Roughness=0.3),
    "glass": lambda name: plain(name, "BsdfGlass", Color=shaders.WHITE, Roughness=0.3, IOR=1.4),
    "glowing": _glowing,
    "veil": _veil,
}
