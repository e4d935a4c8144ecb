# SPDX-License-Identifier: GPL-3.0-or-later
"""One kind of work, done over and over in this Blender: `python -m soak.work KIND COUNT`, tools/ and tests/ on the path.

Prints a line of JSON for each of fifty footprints on the way, the first of them before the work begins.
"""

from __future__ import annotations

import dataclasses
import gc
import json
import os
import sys
import time
from collections.abc import Callable

import bpy
import numpy as np

import petzval
from support.footprint import Footprint
from support.viewer import Viewer, add_texture, balls, build, color

#: Footprints of a run.
LOOKS = 50
LENSES = ("double-gauss-f2-tronnier.lens", "cooke-triplet-50mm.lens", "wide-angle-smith-f3.4.lens")


class Studio:
    """The scene that is edited: every kind of edit leaves as much behind as it found, after each second time at the latest."""

    def __init__(self) -> None:
        self.viewer: Viewer = build(bpy)
        self.scene = bpy.context.scene
        self.camera = self.scene.camera.data
        self.balls = balls(bpy)
        self.image = add_texture(bpy, self.balls[2])
        self.random = np.random.default_rng(1)
        bpy.ops.object.empty_add(location=(0.0, 0.0, 0.0))
        self.scene.frame_end = 1000
        for frame in (1, 1000):
            self.balls[0].location.y = 1e-3 * frame
            self.balls[0].keyframe_insert("location", index=1, frame=frame)

    def object_moved(self, i: int) -> None:
        self.balls[0].location.z = 0.2 * np.sin(i)

    def colour(self, i: int) -> None:
        color(self.balls[1]).default_value = (*self.random.random(3), 1.0)

    def vertex(self, i: int) -> None:
        mesh = self.balls[1].data
        mesh.vertices[i % 50].co.z += 0.01 * (-1) ** (i // 50)
        mesh.update()

    def image_painted(self, i: int) -> None:
        self.image.pixels = list(self.random.random(64))
        self.image.update_tag()

    def lamp(self, i: int) -> None:
        bpy.data.lights[0].energy = 300.0 + i % 100

    def lamp_added_or_removed(self, i: int) -> None:
        lamp = bpy.data.lights.get("Second")
        if lamp is None:
            lamp = bpy.data.lights.new("Second", ("POINT", "SUN", "SPOT", "AREA")[i % 4])
            self.scene.collection.objects.link(bpy.data.objects.new("Second", lamp))
        else:
            bpy.data.lights.remove(lamp)

    def object_added_or_removed(self, i: int) -> None:
        cube = bpy.data.objects.get("Cube")
        if cube is None:
            bpy.ops.mesh.primitive_cube_add(location=(0.0, -1.0, -0.5), size=0.6)
        else:
            bpy.data.meshes.remove(cube.data)

    def curves_added_or_removed(self, i: int) -> None:
        hair = bpy.data.hair_curves.get("Hair")
        if hair is not None:
            bpy.data.hair_curves.remove(hair)
            return
        hair = bpy.data.hair_curves.new("Hair")
        hair.add_curves([4] * 20)
        places = np.linspace(0.0, 1.0, 80, dtype=np.float32)
        hair.attributes["position"].data.foreach_set("vector", np.outer(places, (1.0, 0.3, 1.0)).ravel())
        radius = hair.attributes.get("radius") or hair.attributes.new("radius", "FLOAT", "POINT")
        radius.data.foreach_set("value", np.full(80, 0.02, dtype=np.float32))
        self.scene.collection.objects.link(bpy.data.objects.new("Hair", hair))

    def camera_moved(self, i: int) -> None:
        self.scene.camera.location.x = 0.1 * np.sin(i)

    def f_number(self, i: int) -> None:
        self.camera.petzval.wide_open, self.camera.petzval.f_number = False, 4.0 + i % 5

    def focus(self, i: int) -> None:
        self.camera.dof.focus_distance = 4.0 + i % 5

    def lens(self, i: int) -> None:
        self.camera.petzval.lens_file = LENSES[i % len(LENSES)]

    def camera_model(self, i: int) -> None:
        # Bidirectional paths go through a real lens alone.
        self.scene.petzval.integrator = "PATH"
        self.camera.petzval.model = ("PINHOLE", "THIN", "LENS")[i % 3]

    def modifier(self, i: int) -> None:
        ball = self.balls[1]
        found = ball.modifiers.get("Array")
        if found is None:
            ball.modifiers.new("Array", "ARRAY").count = 2 + i % 2
        else:
            ball.modifiers.remove(found)

    def node(self, i: int) -> None:
        tree = self.balls[1].active_material.node_tree
        found = tree.nodes.get("Noise")
        if found is None:
            node = tree.nodes.new("ShaderNodeTexNoise")
            node.name = "Noise"
            tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Roughness"])
        else:
            tree.nodes.remove(found)

    def material(self, i: int) -> None:
        new = bpy.data.materials.get("Other")
        slot = self.balls[0].material_slots[0]
        if new is None:
            new = bpy.data.materials.new("Other")
            new.use_nodes = True
            slot.material = new
        else:
            slot.material = self.balls[1].active_material
            bpy.data.materials.remove(new)

    def world(self, i: int) -> None:
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3 + 0.01 * (i % 10)

    def visibility(self, i: int) -> None:
        self.balls[0].hide_viewport = not self.balls[0].hide_viewport

    def frame(self, i: int) -> None:
        self.scene.frame_set(1 + i % 1000)

    def bounces(self, i: int) -> None:
        self.scene.cycles.max_bounces = 2 + i % 8

    def integrator(self, i: int) -> None:
        is_lens = self.camera.petzval.model == "LENS"
        self.scene.petzval.integrator = "BIDIRECTIONAL" if is_lens and i % 2 else "PATH"

    def volume(self, i: int) -> None:
        tree = self.scene.world.node_tree
        found = tree.nodes.get("Fog")
        if found is None:
            node = tree.nodes.new("ShaderNodeVolumePrincipled")
            node.name, node.inputs["Density"].default_value = "Fog", 0.02
            tree.links.new(node.outputs[0], tree.nodes["World Output"].inputs["Volume"])
        else:
            tree.nodes.remove(found)

    def exposure(self, i: int) -> None:
        self.scene.view_settings.exposure = 0.1 * (i % 5)


#: Every kind of edit; a number of kinds without 2 and 3 among its factors, so that kinds of two and of three values see all of them.
EDITS: tuple[Callable[[Studio, int], None], ...] = tuple(
    edit for name, edit in vars(Studio).items() if not name.startswith("_")
)


def edits(studio: Studio) -> Callable[[int], None]:
    """Edits of a 3D view, each of which is looked at until it has a picture."""
    viewer = studio.viewer

    def edit(i: int) -> None:
        # Of each kind the number of times that it was done, so that it takes turns.
        EDITS[i % len(EDITS)](studio, i // len(EDITS))
        viewer.update()
        viewer.look(samples=1)
        viewer.session.wait(60.0)
        if viewer.session.error:
            raise SystemExit(f"edit {i}, {EDITS[i % len(EDITS)].__name__}: {viewer.session.error}")

    return edit


def renders(studio: Studio) -> Callable[[int], None]:
    """Final renders, each with other settings: cameras, integrators, passes, denoising."""
    viewer, scene = studio.viewer, studio.scene
    viewer.close()
    layer = bpy.context.view_layer

    def render(i: int) -> None:
        scene.render.resolution_x, scene.render.resolution_y = 48, 32
        scene.petzval.samples = 1
        studio.camera_model(i)
        studio.lens(i // 3)
        studio.integrator(i // 5)
        layer.use_pass_z = layer.use_pass_normal = i % 7 == 0
        layer.use_pass_cryptomatte_object = i % 11 == 0
        scene.cycles.use_denoising = i % 13 == 0
        scene.render.use_motion_blur = i % 17 == 0
        scene.render.use_persistent_data = i % 200 >= 100
        studio.colour(i)
        bpy.ops.render.render()

    return render


def frames(studio: Studio) -> Callable[[int], None]:
    """Frames of an animation."""
    scene = studio.scene
    studio.viewer.close()
    studio.camera.petzval.model = "LENS"
    scene.render.resolution_x, scene.render.resolution_y = 32, 20
    scene.petzval.samples = 1
    scene.cycles.use_denoising = False

    def frame(i: int) -> None:
        scene.frame_set(1 + i % 1000)
        bpy.ops.render.render()

    return frame


KINDS = {"edits": edits, "renders": renders, "frames": frames}


def main() -> None:
    kind, count = sys.argv[1], int(sys.argv[2])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    petzval.load_addon().register()
    bpy.context.scene.render.engine = "PETZVAL"
    step, began = KINDS[kind](Studio()), time.monotonic()
    for i in range(count + 1):
        if i * LOOKS // count != (i - 1) * LOOKS // count:
            # The same before each look: what is kept from one render to the next depends on its settings.
            step(0)
            gc.collect()
            row = {"done": i, "seconds": time.monotonic() - began, "kinds": len(EDITS)}
            row |= dataclasses.asdict(Footprint.now())
            print(json.dumps(row), flush=True)
        if i < count:
            step(i)
    # bpy with an engine registered does not end by itself.
    os._exit(0)


if __name__ == "__main__":
    main()
