# SPDX-License-Identifier: GPL-3.0-or-later
"""A 3D view without a screen, and a scene to edit in it."""

from __future__ import annotations

import dataclasses

SIZE = (96, 64)
# Of the scene for the engine: not where the camera is.
ORIGIN = (1.0, -2.0, 0.5)


class Viewer:
    """A view without a screen: hears of edits as Blender tells them, and renders."""

    def __init__(self, bpy):
        import petzval

        addon = petzval.load_addon()
        from importlib import import_module

        part = lambda name: import_module(f"{addon.__name__}.{name}")  # noqa: E731
        self.bpy, self.native = bpy, part("native").engine()
        self.sync_of, self.session_of = part("viewport.sync").SceneSync, part("viewport.session").Session
        self.changes_of = part("export.kept").Changes.of
        self.wanted_of = part("viewport.session").Wanted
        self.staging, self.settings = part("render.staging"), part("export.settings")
        self.report_of = part("export.report").Report
        self.sync, self.session = self.sync_of(self.native), self.session_of(self.native)
        self.drafts = 0
        # Blender tells views of both.
        bpy.app.handlers.depsgraph_update_post.append(self._updated)
        bpy.app.handlers.frame_change_post.append(self._updated)

    def _updated(self, _scene, depsgraph):
        draft = self.sync.update(depsgraph, self.changes_of(depsgraph), None, ORIGIN)
        if draft is not None:
            self.drafts += 1
            self.session.build(draft)

    def update(self) -> bool:
        """Blender evaluates; whether a new scene was sent since the last time."""
        self.bpy.context.view_layer.update()
        sent, self.drafts = self.drafts > 0, 0
        return sent

    def look(self, samples=8, wishes=None, denoising=None, denoise_from=1, threshold=0.0):
        scene, depsgraph = self.bpy.context.scene, self.bpy.context.evaluated_depsgraph_get()
        camera = self.staging.camera(depsgraph.scene_eval, *SIZE, self.report_of())
        settings = self.settings.describe(scene, *SIZE, is_viewport=True)
        settings = dataclasses.replace(settings, samples=samples, seed=3, noise_threshold=threshold)
        self.session.look(self.wanted_of(camera, settings, wishes or {}, denoising, denoise_from))

    def picture(self, samples=8):
        """The finished picture of the scene as it is."""
        self.look(samples)
        assert self.session.wait(60.0)
        assert not self.session.error, self.session.error
        assert self.session.picture.samples == samples
        return self.session.picture.pixels

    def afresh(self, samples=8):
        """The picture of a scene that is sent anew."""
        other = self.session_of(self.native)
        depsgraph = self.bpy.context.evaluated_depsgraph_get()
        other.build(self.sync_of(self.native).update(depsgraph, self.changes_of(depsgraph), None, ORIGIN))
        other.look(self.session._asked)
        try:
            assert other.wait(60.0) and not other.error, other.error
            return other.picture.pixels
        finally:
            other.close()

    def close(self):
        self.bpy.app.handlers.depsgraph_update_post.remove(self._updated)
        self.bpy.app.handlers.frame_change_post.remove(self._updated)
        self.session.close()


def build(bpy) -> Viewer:
    """Three painted balls on a floor, a lamp and a world, in an empty file; and their view."""
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    bpy.ops.object.camera_add(location=(0.0, -6.0, 1.0), rotation=(1.45, 0.0, 0.0))
    scene.camera = bpy.context.object
    scene.camera.data.petzval.model = "PINHOLE"
    bpy.ops.mesh.primitive_plane_add(size=20.0, location=(0.0, 0.0, -1.0))
    for x in (-1.5, 0.0, 1.5):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(x, 0.0, 0.0), radius=0.7, segments=16, ring_count=8)
        material = bpy.data.materials.new("Paint")
        material.use_nodes = True
        bpy.context.object.data.materials.append(material)
    bpy.ops.object.light_add(type="POINT", location=(2.0, -3.0, 4.0))
    bpy.context.object.data.energy = 500.0
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    scene.world = world
    found = Viewer(bpy)
    # As when a view begins to be rendered.
    found._updated(scene, bpy.context.evaluated_depsgraph_get())
    return found


def balls(bpy):
    return sorted(
        (one for one in bpy.context.scene.objects if one.name.startswith("Sphere")), key=lambda o: o.location.x
    )


def color(ball):
    return ball.active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]


def add_texture(bpy, ball):
    image = bpy.data.images.new("Checks", 4, 4)
    image.pixels = [v for i in range(16) for v in ((1.0, 0.2, 0.1, 1.0) if (i + i // 4) % 2 else (0.1, 0.2, 1.0, 1.0))]
    tree = ball.active_material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return image
