# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared parts of the gallery's scenes: a stage with materials, lamps, a camera and a sky; lengths are metres.

Shapes and painted textures are those of the demo scene (demo_mesh.py, demo_props.py, demo_room.py, demo_textures.py).
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import demo_textures as paint
from demo_materials import glow, linear, packed_image, principled
from demo_mesh import instance, placement, to_mesh, to_object

TEXTURE = (1024, 1024)


def _image(name, array, data=False):
    return packed_image(name, array, data=data)


def _wood(name, dark, middle, light, seed, scale, rings=7.0, polish=0.0):
    color, rough = paint.wood(TEXTURE, dark, middle, light, seed, rings, 0.4)
    return principled(
        name.capitalize(),
        color=(_image(name, color), scale),
        roughness=(_image(f"{name} roughness", rough - polish, True), scale),
    )


def _floor():
    color, rough = paint.floorboards(TEXTURE, 3)
    scale = (0.8, 0.55)
    return principled(
        "Oak floor", color=(_image("floor", color), scale), roughness=(_image("floor roughness", rough, True), scale)
    )


def _brass():
    color, rough = paint.brass(TEXTURE, 5)
    return principled(
        "Brass",
        color=(_image("brass", color), (3, 6)),
        roughness=(_image("brass roughness", rough, True), (3, 6)),
        metallic=1.0,
    )


def _leather():
    color, rough = paint.leather(TEXTURE, (0.16, 0.05, 0.025), (0.36, 0.15, 0.07), 6)
    return principled(
        "Leather",
        color=(_image("leather", color), (3, 3)),
        roughness=(_image("leather roughness", rough, True), (3, 3)),
    )


def _plain(name, tone, roughness, **more):
    return principled(name, color=linear(*tone), roughness=roughness, **more)


def _painted(name, picture, roughness, scale=(1.0, 1.0)):
    return principled(name, color=(_image(name, picture), scale), roughness=roughness)


# Made when first asked for, so that a scene holds only what it shows.
_MAKERS = {
    "walnut": lambda: _wood("walnut", (0.13, 0.06, 0.032), (0.27, 0.14, 0.072), (0.40, 0.23, 0.12), 1, (0.8, 0.8), 9),
    "mahogany": lambda: _wood("mahogany", (0.15, 0.035, 0.015), (0.33, 0.1, 0.04), (0.47, 0.18, 0.075), 5, (2, 2), 5),
    "dark wood": lambda: _wood("dark wood", (0.05, 0.02, 0.01), (0.13, 0.06, 0.03), (0.2, 0.1, 0.05), 6, (1.6, 1.2)),
    "boxwood": lambda: _wood("boxwood", (0.52, 0.33, 0.14), (0.72, 0.52, 0.27), (0.82, 0.65, 0.38), 11, (6, 6), 6, 0.1),
    "ebony": lambda: _wood(
        "ebony", (0.03, 0.018, 0.014), (0.065, 0.036, 0.026), (0.11, 0.06, 0.04), 12, (6, 6), 6, 0.14
    ),
    "maple": lambda: _wood("maple", (0.56, 0.38, 0.2), (0.74, 0.57, 0.36), (0.83, 0.69, 0.48), 13, (2.5, 2.5), 8, 0.12),
    "oak": lambda: _wood("oak", (0.2, 0.11, 0.055), (0.4, 0.25, 0.13), (0.52, 0.36, 0.21), 14, (1.4, 1.4), 9, 0.05),
    "floor": _floor,
    "brass": _brass,
    "leather": _leather,
    "plaster": lambda: _painted("Plaster", paint.plaster(TEXTURE, (0.74, 0.7, 0.62), 4), 0.9, (0.45, 0.45)),
    "paint": lambda: _painted("Old paint", paint.plaster((512, 512), (0.78, 0.76, 0.7), 24), 0.5, (1.3, 1.3)),
    "ceiling": lambda: _plain("Ceiling", (0.85, 0.83, 0.79), 0.9),
    "rug": lambda: _painted("Rug", paint.rug((1536, 1024), 7), 0.95),
    "books": lambda: _painted("Book cloth", paint.book_atlas(2048, 9), 0.6),
    "pages": lambda: _painted("Page edges", paint.page_edges((512, 512), 12), 0.85, (14, 4)),
    "globe": lambda: _painted("Globe map", paint.globe_map((1024, 2048), 21), 0.4),
    "leaf": lambda: _painted("Leaf", paint.leaf((512, 256), 41), 0.45),
    "stem": lambda: _plain("Stem", (0.3, 0.36, 0.16), 0.6),
    "terracotta": lambda: _plain("Terracotta", (0.62, 0.36, 0.24), 0.85),
    "soil": lambda: _plain("Soil", (0.16, 0.12, 0.09), 0.95),
    "linen": lambda: _painted("Linen", paint.weave(TEXTURE, (0.78, 0.72, 0.6), (0.7, 0.62, 0.5), 51, 96), 0.95, (5, 5)),
    "curtain": lambda: _painted(
        "Curtain", paint.weave(TEXTURE, (0.45, 0.16, 0.12), (0.36, 0.1, 0.09), 52, 128), 0.9, (4, 4)
    ),
    "painting": lambda: _painted("Painting", paint.landscape(TEXTURE, 8), 0.5),
    "iron": lambda: _plain("Iron", (0.16, 0.16, 0.17), 0.5, metallic=0.7),
    "black": lambda: principled("Black", color=(0.01, 0.01, 0.011), roughness=0.5),
    "white": lambda: _plain("White", (0.9, 0.89, 0.87), 0.6),
    "felt": lambda: _plain("Felt", (0.1, 0.28, 0.2), 0.95),
}


class Stage:
    """An empty scene that things are put into."""

    def __init__(self, name: str) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.scene.name = name
        self.collection = self.scene.collection
        self._materials = {}

    def material(self, key):
        """A material by its key, or one that is made already."""
        if isinstance(key, bpy.types.Material):
            return key
        if key not in self._materials:
            self._materials[key] = _MAKERS[key]()
        return self._materials[key]

    def put(self, shape, name, materials, **where):
        """A shape as an object; `where` are the arguments of `placement`: x, y, z in metres, rx, ry, rz in degrees."""
        return to_object(shape, name, [self.material(m) for m in materials], self.collection, placement(**where))

    def mesh(self, shape, name, materials, weld=True):
        """A mesh alone, for many objects."""
        made = to_mesh(shape, name, weld)
        for one in materials:
            made.materials.append(self.material(one))
        return made

    def again(self, mesh, name, matrix):
        """One more object of a mesh."""
        return instance(mesh, name, self.collection, matrix)

    def lamp(self, name, kind, at, power, color=(1.0, 1.0, 1.0), aim=None, **settings):
        """A lamp of `power` watts (a sun: watts per square metre), that looks at `aim`."""
        data = bpy.data.lights.new(name, kind)
        data.energy, data.color = power, color
        for key, value in settings.items():
            setattr(data, key, value)
        made = bpy.data.objects.new(name, data)
        made.location = at
        if aim is not None:
            made.rotation_euler = (Vector(aim) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
        self.collection.objects.link(made)
        return made

    def camera(self, at, look_at, lens_mm, film_mm=(36.0, 24.0), focus_m=None, f_number=2.8):
        """The scene's camera. The distance of focus counts along its axis."""
        data = bpy.data.cameras.new("Camera")
        data.sensor_fit, data.lens = "HORIZONTAL", lens_mm
        data.sensor_width, data.sensor_height = film_mm
        data.clip_start, data.clip_end = 0.01, 20000.0
        if focus_m is not None:
            data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, focus_m, f_number
        made = bpy.data.objects.new("Camera", data)
        made.location = at
        made.rotation_euler = (Vector(look_at) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
        self.collection.objects.link(made)
        self.scene.camera = made
        render = self.scene.render
        render.resolution_x, render.resolution_y = 1200, round(1200 * film_mm[1] / film_mm[0])
        return made

    def targets(self, **names):
        """Says which objects there are to focus on: the scene's property `focus_targets`, metres along the camera's axis by name."""
        bpy.context.view_layer.update()
        camera = self.scene.camera.matrix_world
        ahead = -Vector(camera.col[2][:3])
        found = {}
        for name, point in names.items():
            where = Vector(point) if point is not None else bpy.data.objects[name].matrix_world.translation
            found[name] = (where - camera.translation).dot(ahead)
        self.scene["focus_targets"] = found

    def save(self, path) -> None:
        """Writes the scene, without its neighbour of yesterday."""
        scene = self.scene
        scene.render.engine = "CYCLES"
        scene.cycles.samples, scene.cycles.max_bounces = 128, 8
        scene.cycles.use_denoising = False
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(path).resolve()), compress=True)


def _link(tree, node_out, node_in):
    tree.links.new(node_out, node_in)


def math_node(tree, operation, a, b=None):
    """A Math node; its inputs are sockets or numbers. Returns its output."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, (a, b), strict=False):
        if value is None:
            continue
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node.outputs[0]


def ramp_node(tree, factor, stops):
    """A Color Ramp with stops of (position, linear colour). Returns its colour."""
    node = tree.nodes.new("ShaderNodeValToRGB")
    elements = node.color_ramp.elements
    while len(elements) < len(stops):
        elements.new(0.5)
    for element, (position, colour) in zip(elements, stops, strict=True):
        element.position, element.color = position, (*colour, 1.0)
    tree.links.new(factor, node.inputs["Fac"])
    return node.outputs["Color"]


def noise_node(tree, vector, scale, detail=2.0, roughness=0.5):
    """A Noise Texture. Returns its value, about 0.5."""
    node = tree.nodes.new("ShaderNodeTexNoise")
    node.inputs["Scale"].default_value = scale
    node.inputs["Detail"].default_value = detail
    node.inputs["Roughness"].default_value = roughness
    if vector is not None:
        tree.links.new(vector, node.inputs["Vector"])
    return node.outputs[0]


def mix_node(tree, factor, a, b):
    """A colour mixed of two, each a socket or a linear colour."""
    node = tree.nodes.new("ShaderNodeMix")
    node.data_type = "RGBA"
    for socket, value in ((node.inputs[0], factor), (node.inputs[6], a), (node.inputs[7], b)):
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value if isinstance(value, float) else (*value, 1.0)
    return node.outputs[2]


def day_sky(stage, strength=1.0, clouds=0.8) -> None:
    """A blue sky with fair-weather clouds, pale at the horizon; below it a dull green."""
    world = bpy.data.worlds.new("Sky")
    stage.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(direction, split.inputs[0])
    x, y, z = split.outputs
    blue = ramp_node(
        tree,
        math_node(tree, "MULTIPLY_ADD", z, 0.5),
        [(0.0, (0.1, 0.12, 0.06)), (0.495, (0.16, 0.18, 0.1)), (0.5, (0.62, 0.74, 0.86)), (0.56, (0.36, 0.55, 0.85)),
         (0.75, (0.12, 0.28, 0.66)), (1.0, (0.07, 0.18, 0.52))],
    )  # fmt: skip
    tree.nodes[-1].name = "Blue"
    # MULTIPLY_ADD: z / 2 + 1 / 2.
    half = next(n for n in tree.nodes if n.type == "MATH")
    half.inputs[2].default_value = 0.5
    # Clouds lie in a layer: towards the horizon they crowd and flatten.
    away = math_node(tree, "MAXIMUM", math_node(tree, "ADD", z, 0.07), 0.02)
    layer = tree.nodes.new("ShaderNodeCombineXYZ")
    for source, socket in ((x, 0), (y, 1)):
        tree.links.new(math_node(tree, "DIVIDE", source, away), layer.inputs[socket])
    thick = noise_node(tree, layer.outputs[0], 0.9, 6.0, 0.55)
    white = ramp_node(tree, thick, [(0.5, (0.0,) * 3), (0.66, (1.0,) * 3)])
    above = ramp_node(tree, z, [(0.0, (0.0,) * 3), (0.06, (1.0,) * 3)])
    factor = math_node(tree, "MULTIPLY", math_node(tree, "MULTIPLY", white, above), clouds)
    shade = ramp_node(tree, thick, [(0.55, (1.05, 1.04, 1.0)), (0.8, (0.6, 0.63, 0.7))])
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = strength
    tree.links.new(mix_node(tree, factor, blue, shade), background.inputs["Color"])


def plain_world(stage, colour, strength=1.0) -> None:
    """One radiance from everywhere."""
    world = bpy.data.worlds.new("World")
    stage.scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = strength


def bulb(name, colour, strength):
    """A material that glows."""
    return glow(name, colour, strength)


def print_pattern(size, ground, ink, accent, seed):
    """A printed cloth or glaze of equal kind at any scale: sprigs of many sizes, for sharpness to be read from."""
    h, w = size
    rng = np.random.default_rng(seed)
    field = paint.noise(h, w, 0.75, (1, 1), seed, low=4)
    edges = np.abs(field - 0.5)
    picture = np.ones((h, w, 3)) * ground
    picture = paint.mix(picture, ink, paint.smooth(0.035, 0.02, edges))
    y, x = np.mgrid[0:h, 0:w]
    for _ in range(90):
        cx, cy, r = rng.uniform(0, w), rng.uniform(0, h), h * 0.5 ** rng.uniform(3.6, 6.0)
        dx, dy = (x - cx + w / 2) % w - w / 2, (y - cy + h / 2) % h - h / 2
        turn, away = np.arctan2(dy, dx), np.hypot(dx, dy) / r
        petals = int(rng.integers(5, 9))
        flower = away < 0.6 + 0.4 * np.cos(petals * turn + rng.uniform(0, 6))
        picture[away < 1.12] = ground
        picture[flower] = accent if rng.random() < 0.5 else ink
        picture[away < 0.22] = ground
    return np.clip(picture * (0.92 + 0.16 * paint.noise(h, w, 0.5, (1, 1), seed + 1))[..., None], 0, 1)


def main(build, views=("",)) -> None:
    """`NAME.py OUT.blend [VIEW]`: builds the scene as that view wants it and writes it."""
    path = sys.argv[1] if len(sys.argv) > 1 else None
    view = sys.argv[2] if len(sys.argv) > 2 else views[0]
    if path is None or view not in views:
        sys.exit(f"usage: {Path(sys.argv[0]).name} OUT.blend" + (f" [{'|'.join(views)}]" if len(views) > 1 else ""))
    stage = build(view) if len(views) > 1 else build()
    stage.save(path)


def turned(at, yaw_degrees=0.0, scale=1.0, pitch_degrees=0.0):
    """A matrix: scaled, pitched, turned about Z, and put at a place."""
    from mathutils import Matrix

    return (
        Matrix.Translation(at)
        @ Matrix.Rotation(math.radians(yaw_degrees), 4, "Z")
        @ Matrix.Rotation(math.radians(pitch_degrees), 4, "X")
        @ Matrix.Scale(scale, 4)
    )
