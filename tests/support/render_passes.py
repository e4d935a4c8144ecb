# SPDX-License-Identifier: GPL-3.0-or-later
"""A room with a surface of each kind, its passes by Petzval and by Cycles, and how far apart these are. Imported inside of
tests: it needs bpy."""

from __future__ import annotations

import bpy
import numpy as np

from support import kept_references
from support import scenes as parts
from support.multilayer import exr_channels

#: Columns and rows, and a block's side.
WIDTH, HEIGHT, BLOCK = 64, 48, 16
LOBES = ("diffuse", "glossy", "transmission")
#: Blender 5's names by what they are before that.
OLD = {
    "DiffDir": "Diffuse Direct", "DiffInd": "Diffuse Indirect", "DiffCol": "Diffuse Color",
    "GlossDir": "Glossy Direct", "GlossInd": "Glossy Indirect", "GlossCol": "Glossy Color",
    "TransDir": "Transmission Direct", "TransInd": "Transmission Indirect", "TransCol": "Transmission Color",
    "VolumeDir": "Volume Direct", "VolumeInd": "Volume Indirect", "Emit": "Emission", "Env": "Environment",
    "AO": "Ambient Occlusion", "IndexOB": "Object Index", "IndexMA": "Material Index",
}  # fmt: skip


def photograph(path, engine: str = "PETZVAL", samples: int | None = 64) -> dict[str, np.ndarray]:
    """Every pass of the first view layer by Blender 5's name: (height, width, channels). `samples` if not as they are set."""
    scene = bpy.context.scene
    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.engine, scene.render.filepath = engine, str(path)
    if samples is not None:
        scene.petzval.samples = scene.cycles.samples = samples
    cycles = scene.cycles
    cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", False, False
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    scene.petzval.filter_width = 0.0
    cycles.pixel_filter_type = "BOX"
    try:
        kept_references.render_still()
    finally:
        scene.render.engine = "PETZVAL"
    return read(path)


def read(path) -> dict[str, np.ndarray]:
    """What `photograph` gives, of a file."""
    first = bpy.context.scene.view_layers[0].name
    found: dict[str, dict[str, np.ndarray]] = {}
    for name, pixels in exr_channels(path).items():
        layer, _, rest = name.partition(".")
        one, _, channel = rest.rpartition(".")
        if layer == first:
            found.setdefault(OLD.get(one, one), {})[channel.upper()] = pixels
    order = "RXUGYVBZA"
    return {one: np.stack([c[k] for k in sorted(c, key=lambda k: order.find(k))], -1) for one, c in found.items()}


def ask_for_light(layer) -> None:
    for lobe in LOBES:
        for what in ("direct", "indirect", "color"):
            setattr(layer, f"use_pass_{lobe}_{what}", True)
    layer.use_pass_emit = layer.use_pass_environment = True
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True


def summed(passes) -> np.ndarray:
    """What the passes of light add up to."""
    lobes = (lobe.title() for lobe in LOBES)
    lit = sum(passes[f"{one} Color"] * (passes[f"{one} Direct"] + passes[f"{one} Indirect"]) for one in lobes)
    rest = ("Volume Direct", "Volume Indirect", "Emission", "Environment")
    # Through a lens, what strays in it.
    strays = ("Ghosts", "Glare", "Diffraction")
    return lit + sum(passes[one] for one in rest) + sum(passes.get(one, 0.0) for one in strays)


def lit_by(passes, name: str) -> np.ndarray:
    """Light of a lobe, with its colour: where the colour is dim, the quotient is noise."""
    lobe, _, what = name.partition(" ")
    return (
        passes[name] * passes[f"{lobe} Color"]
        if what in {"Direct", "Indirect"} and lobe.lower() in LOBES
        else passes[name]
    )


def blocks(pixels: np.ndarray) -> np.ndarray:
    return pixels.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, -1).mean((1, 3))


def same(ours, theirs, names, mean: float, block: float) -> None:
    """In the mean of a pass, and block by block; what has next to no light is compared with the picture's."""
    floor = 0.01 * theirs["Combined"][..., :3].mean()
    off = {}
    for name in names:
        a, b = lit_by(ours, name), lit_by(theirs, name)
        apart = abs(a.mean((0, 1)) - b.mean((0, 1))) / (abs(b.mean((0, 1))) + floor)
        worst = abs(blocks(a) - blocks(b)) / (abs(blocks(b)) + abs(b.mean()) + floor)
        print(f"{name}: {a.mean((0, 1))} {b.mean((0, 1))} off {apart.max():.4f}, block {worst.max():.4f}")
        if apart.max() > mean or worst.max() > block:
            off[name] = apart.max(), worst.max()
    assert not off, off


def surface(name: str, kind: str, **inputs) -> bpy.types.Material:
    """A material of one shader node; its inputs by name, spaces as underscores."""
    made, tree, output = parts.material(name)
    node = tree.nodes.new(f"ShaderNode{kind}")
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[0], output)
    return made


def ball(name: str, place, made: bpy.types.Material, radius: float = 0.45) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place, segments=32, ring_count=16)
    one = bpy.context.object
    one.name = name
    bpy.ops.object.shade_smooth()
    one.data.materials.append(made)
    return one


def floor(made: bpy.types.Material, height: float = -0.5) -> bpy.types.Object:
    corners = [(-6, -1, height), (6, -1, height), (6, 11, height), (-6, 11, height)]
    return parts.mesh_object("Floor", corners, [(0, 1, 2, 3)], made, uv=[(0, 0), (1, 0), (1, 1), (0, 1)])


def room() -> bpy.types.Scene:
    """A matte floor, metal, plastic, glass and a leaf under a lamp, a glowing panel and a sky."""
    scene = parts.set_up(width=WIDTH, height=HEIGHT)
    scene.camera.location, scene.camera.data.lens = (0.0, -0.5, 0.6), 28.0
    floor(surface("Matte", "BsdfDiffuse", Color=(0.7, 0.5, 0.3, 1.0)))
    metal = surface("Metal", "BsdfPrincipled", Base_Color=(0.9, 0.6, 0.3, 1.0), Metallic=1.0, Roughness=0.4)
    ball("Metal", (-1.1, 3.0, 0.0), metal)
    ball(
        "Plastic", (0.0, 3.0, 0.0), surface("Plastic", "BsdfPrincipled", Base_Color=(0.1, 0.4, 0.7, 1.0), Roughness=0.4)
    )
    ball("Glass", (1.1, 3.0, 0.0), surface("Glass", "BsdfGlass", Roughness=0.3))
    leaf = surface("Leaf", "BsdfTranslucent", Color=(0.3, 0.7, 0.2, 1.0))
    parts.square("Leaf", (0.5, 4.2, 1.0), 0.9, leaf).rotation_euler.z = 0.3
    parts.square("Panel", (-1.0, 4.5, 1.1), 0.8, parts.emitter((0.5, 0.7, 1.0), 3.0))
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 150.0, 1.0
    holder = bpy.data.objects.new("Lamp", lamp)
    holder.location, holder.rotation_euler = (0.5, 2.0, 3.0), (0.2, 0.0, 0.0)
    scene.collection.objects.link(holder)
    scene.world = parts.grey_world(0.3)
    # Noise of caustics would hide all else.
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
    return scene


def mixed(name: str, share: float, first: bpy.types.ShaderNode | str, second: str, **inputs) -> bpy.types.Material:
    """A material of two shader nodes; the inputs are those of the first."""
    made, tree, output = parts.material(name)
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs["Fac"].default_value = share
    for place, kind in enumerate((first, second), 1):
        node = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in inputs.items() if place == 1 else ():
            node.inputs[key.replace("_", " ")].default_value = value
        tree.links.new(node.outputs[0], mix.inputs[place])
    tree.links.new(mix.outputs[0], output)
    return made


def fog(place, size: float, density: float) -> bpy.types.Object:
    """A cube of it."""
    made, tree, _ = parts.material("Fog")
    node = tree.nodes.new("ShaderNodeVolumeScatter")
    node.inputs["Density"].default_value = density
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    one = bpy.context.object
    one.name = "Fog"
    one.data.materials.append(made)
    return one
