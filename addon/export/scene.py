# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that is in the scene: each object and instance, each piece of data sent once."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..description import Report
from ..native import engine
from . import light, mesh, world
from .image import Images
from .material import Materials
from .matrix import rows

_SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# What has nothing to see by itself.
_INVISIBLE = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}


def scene(depsgraph: bpy.types.Depsgraph, report: Report, stopped: Callable[[], bool]):
    """The engine's SceneBuilder, filled; None where the user stopped it."""
    builder = engine().SceneBuilder()
    images = Images(builder, report)
    sender = _Sender(builder, Materials(builder, images, report), report)
    world.send(depsgraph.scene.world, builder, images, report)
    for instance in depsgraph.object_instances:
        if stopped():
            return None
        sender.send(instance)
    return builder


class _Sender:
    def __init__(self, builder, materials: Materials, report: Report) -> None:
        self._builder = builder
        self._materials = materials
        self._report = report
        # Mesh number by evaluated data; None where it has no triangles.
        self._meshes: dict[tuple, int | None] = {}

    def send(self, instance: bpy.types.DepsgraphObjectInstance) -> None:
        obj = instance.object
        if not instance.show_self:
            return
        if obj.type == "LIGHT":
            self._builder.add_light(light.describe(obj, instance.matrix_world, self._report))
        elif obj.type in _SURFACES:
            number = self._mesh(instance, obj)
            if number is not None:
                self._builder.add_instance(
                    obj.name,
                    number,
                    rows(instance.matrix_world),
                    self._materials.of(obj),
                    visible_camera=obj.visible_camera,
                    visible_shadow=obj.visible_shadow,
                )
        elif obj.type not in _INVISIBLE:
            self._report.warn(f"object '{obj.name}': {obj.type.lower()} objects are not supported yet; left out")
        for system in () if instance.is_instance else obj.particle_systems:
            if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                self._report.warn(f"object '{obj.name}': particle hair is not supported yet; left out")

    def _mesh(self, instance, obj: bpy.types.Object) -> int | None:
        # Evaluated meshes are told apart by their data; what becomes a mesh only here, by its object as well.
        owner = 0 if obj.type == "MESH" or instance.is_instance else obj.original.as_pointer()
        key = (obj.data.as_pointer(), owner)
        if key not in self._meshes:
            self._meshes[key] = self._convert(obj)
        return self._meshes[key]

    def _convert(self, obj: bpy.types.Object) -> int | None:
        if obj.type == "MESH":
            return self._add(obj.data.name, obj.data)
        try:
            converted = obj.to_mesh()
        except RuntimeError as error:
            self._report.warn(f"object '{obj.name}': it cannot become a mesh ({error}); left out")
            return None
        try:
            return self._add(obj.data.name, converted) if converted else None
        finally:
            obj.to_mesh_clear()

    def _add(self, name: str, data: bpy.types.Mesh) -> int | None:
        a = mesh.arrays(data)
        if a is None:
            return None
        return self._builder.add_mesh(
            name,
            a.positions,
            a.triangles,
            corner_normals=a.corner_normals,
            uv_maps=a.uv_maps,
            material_slots=a.material_slots,
        )
