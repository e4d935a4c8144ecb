# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that stands in the evaluated scene: each mesh and all hair sent once, and an instance for every place of it."""

from __future__ import annotations

import functools
from array import array
from collections.abc import Callable, Hashable
from typing import Any

import bpy
import numpy as np

from petzval.description import RAYS, Matrix4

from . import curves, dicing, grids, hair, mesh, object_info, points
from .baking import Baked
from .camera import rows
from .culling import Culling
from .image import Images
from .kept import Kept, uid
from .light import Lights, is_portal
from .light_groups import LightGroups
from .linking import Links
from .material import Materials
from .memory import Room
from .motion import Motion
from .report import Report
from .shutter import Blur
from .visibility import hidden_from

#: Objects whose surface Blender can hand over as a mesh, as strands, or as points.
WITH_SURFACE = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD"}
#: Object types of which all has the first material; *Surfaces* of a view layer does not apply to them.
SMALL = {"CURVES", "POINTCLOUD"}
#: Objects that are seen in a Blender render, but not here yet.
NOT_YET = {"GPENCIL": "grease pencil", "GREASEPENCIL": "grease pencil"}


def _asset(holder: bpy.types.Object) -> str:
    """The name of an object's topmost parent, as Cycles names assets."""
    while holder.parent is not None:
        holder = holder.parent
    return holder.name


def _shadow_terminator(holder: bpy.types.Object) -> tuple[float, float]:
    """An object's shadow terminator: geometry offset and shading offset. Before 4.2 Cycles keeps its own."""
    own = holder if hasattr(holder, "shadow_terminator_geometry_offset") else getattr(holder, "cycles", None)
    geometry = getattr(own, "shadow_terminator_geometry_offset", 0.1)
    shading = getattr(own, "shadow_terminator_shading_offset", getattr(own, "shadow_terminator_offset", 0.0))
    return geometry, shading


def _occlusion_distance(holder: bpy.types.Object, place: bpy.types.DepsgraphObjectInstance) -> float:
    """An object's own distance of Cycles's Fast GI Approximation, else that of the object that instances it; 0 is none."""
    own = getattr(getattr(holder, "cycles", None), "ao_distance", 0.0)
    return own or getattr(getattr(_stands_for(place), "cycles", None), "ao_distance", 0.0)


def _stands_for(place: bpy.types.DepsgraphObjectInstance) -> bpy.types.Object:
    """The object whose collections an instance belongs to: the one that is instanced by another belongs to that one's."""
    found = place.parent if place.is_instance and place.parent is not None else place.object
    return found.original


def _instancers(place: bpy.types.DepsgraphObjectInstance) -> tuple[bpy.types.Object, ...]:
    """The object that shows an instance, whose visibility to kinds of ray counts too."""
    return (place.parent,) if place.is_instance and place.parent is not None else ()


def _sources(holder: bpy.types.Object, place: bpy.types.DepsgraphObjectInstance) -> tuple[bpy.types.ID | None, ...]:
    """The datablocks that an object's shape comes from."""
    return holder, holder.data, place.parent if place.is_instance else None


class InstanceGroup:
    """Instances of one object by one instancer, of which only the matrix and the random number differ: they are sent to the engine together."""

    def __init__(self) -> None:
        #: Calls of the builder with everything else, one for each mesh, curves or hair of the object.
        self.calls: list[Callable[..., None]] = []
        #: Sixteen numbers each, row by row.
        self._matrices = array("d")
        self._randoms = array("f")

    def add(self, place: bpy.types.DepsgraphObjectInstance) -> None:
        """Takes the matrix and the random number of one more instance."""
        for row in place.matrix_world:
            self._matrices.extend(row)
        self._randoms.append(object_info.random(place.object, place))

    def send(self) -> None:
        """Sends all instances, by one call for each mesh, curves or hair."""
        matrices = np.frombuffer(self._matrices).reshape(-1, 4, 4)
        randoms = np.frombuffer(self._randoms, np.float32)
        for call in self.calls:
            call(rows(matrices[0]), randoms[0], (matrices[1:], randoms[1:]))


class Stage:
    """Sends the instances of a dependency graph to the engine's builder."""

    def __init__(
        self,
        kept: Kept,
        materials: Materials,
        images: Images,
        groups: LightGroups,
        report: Report,
        check_stop: Callable[[], None],
        motion: Motion | None = None,
        blur: Blur | None = None,
        *,
        only_catchers: bool = False,
        baked: Baked | None = None,
    ) -> None:
        self._baked = baked
        self._builder = kept.builder
        self._kept = kept
        self._motion = motion
        self._blur = blur
        self._materials = materials
        self._images = images
        self._groups = groups
        self._report = report
        self._check_stop = check_stop
        #: Something lights some objects alone.
        self.links_light = False
        #: The camera sees a hole somewhere.
        self.holds_out = False
        #: Shadows are caught somewhere.
        self.catches_shadows = False
        self._only_catchers = only_catchers
        self._view_layer: bpy.types.ViewLayer | None = None
        self._drawn: dict[str, Any] = {}
        self._is_render = True
        self._scene: bpy.types.Scene | None = None
        self._depsgraph: bpy.types.Depsgraph | None = None
        self._room = Room(0.0)
        #: The group of the instance that is looked at; None: the instance is sent by itself.
        self._instance_group: InstanceGroup | None = None

    def send(
        self,
        depsgraph: bpy.types.Depsgraph,
        seen_in: bpy.types.SpaceView3D | None = None,
        camera: bpy.types.Object | None = None,
    ) -> None:
        """All objects and their instances, as they are visible in this graph, and in this 3D view or to this camera where one is given."""
        links = Links(depsgraph, self._report)
        lights = Lights(self._images, links, self._groups)
        self._drawn = curves.shape(depsgraph.scene_eval)
        self._view_layer = depsgraph.view_layer
        self._room = Room(depsgraph.scene_eval.petzval.memory_limit)
        self._is_render = depsgraph.mode == "RENDER"
        self._scene, self._depsgraph = depsgraph.scene_eval, depsgraph
        layer = depsgraph.view_layer_eval
        shows_hair = layer.use_strand
        groups: dict[Hashable, InstanceGroup] = {}
        culling = Culling(depsgraph, camera)
        for place in filter(culling.keeps, depsgraph.object_instances):
            self._check_stop()
            key = self._group_key(place)
            self._instance_group = known = groups.get(key) if key is not None else None
            if key is not None and known is None:
                self._instance_group = groups[key] = InstanceGroup()
            if self._instance_group is not None:
                self._instance_group.add(place)
            if known is not None:
                continue
            holder = place.object
            if seen_in is not None and not _stands_for(place).visible_in_viewport_get(seen_in):
                continue
            hidden = hidden_from(holder, *_instancers(place))
            if _stands_for(place).indirect_only_get(view_layer=self._view_layer):
                hidden = (*hidden, "CAMERA")
            if shows_hair and holder.particle_systems:
                self._particles(holder, place, links, hidden)
            if not place.show_self or (holder.type == "CURVES" and not shows_hair):
                continue
            self.links_light |= links.any
            is_left_out = (holder.type == "VOLUME" and not layer.use_volumes) or (
                holder.type in WITH_SURFACE - SMALL and not layer.use_solid
            )
            if is_left_out:
                continue
            if holder.type in WITH_SURFACE:
                self._surface(holder, place, links, hidden)
            elif holder.type == "VOLUME":
                self._volume(holder, place, links, hidden)
            elif holder.type == "LIGHT":
                if is_portal(holder.data):
                    continue
                if self._blur is not None:
                    self._blur.moves_light(place)
                self._builder.add_light(lights.describe(holder, place.matrix_world, hidden))
            elif holder.type in NOT_YET:
                self._report.warn(f"Object '{holder.name}': {NOT_YET[holder.type]} are not supported yet, left out")
        for group in groups.values():
            self._check_stop()
            group.send()

    def _group_key(self, place: bpy.types.DepsgraphObjectInstance) -> Hashable | None:
        """The key of an instance's group; None of an instance that is sent by itself: lamps, instances that may move, and those with
        a number of their own."""
        holder = place.object
        if not place.is_instance or holder.type == "LIGHT" or self._motion is not None or self._blur is not None:
            return None
        if object_info.NUMBERS.of is not None:
            return None
        data = holder.data
        return uid(holder), 0 if data is None else data.as_pointer(), uid(place.parent), place.show_self

    def _surface(
        self,
        holder: bpy.types.Object,
        place: bpy.types.DepsgraphObjectInstance,
        links: Links,
        hidden: tuple[str, ...],
    ) -> None:
        index = self._mesh(holder, place)
        if index is None:
            return
        slots = holder.material_slots or ([None] if self._materials.override else [])
        materials = [self._materials.index(slot and slot.material) for slot in slots]
        self._place(holder, place, links, hidden, index, materials[:1] if holder.type in SMALL else materials)

    def _volume(
        self,
        holder: bpy.types.Object,
        place: bpy.types.DepsgraphObjectInstance,
        links: Links,
        hidden: tuple[str, ...],
    ) -> None:

        def send() -> int | None:
            box = grids.of_volume(holder, self._report)
            return None if box is None else self._add_box(holder.data.name, box)

        key = (holder.data.as_pointer(), "volume")
        index = self._kept.mesh(key, _sources(holder, place), send)
        if index is None:
            return
        slots = [slot.material for slot in holder.material_slots] or [None]
        self._place(holder, place, links, hidden, index, [self._materials.volume_index(one) for one in slots])

    def _add_box(self, name: str, box: grids.Box) -> int:
        corners, triangles = box.shape()
        return self._builder.add_mesh(name, corners, triangles, grids=box.grids, keeps_opacity=box.keeps_opacity)

    def _place(
        self,
        holder: bpy.types.Object,
        place: bpy.types.DepsgraphObjectInstance,
        links: Links,
        hidden: tuple[str, ...],
        index: int,
        materials: list[int],
    ) -> None:
        is_baked = self._baked is not None and self._baked.is_at(place)
        is_catcher = holder.is_shadow_catcher or (is_baked and self._baked.catches_shadows)
        self.catches_shadows |= is_catcher
        if self._only_catchers and not is_catcher:
            # In the way of the camera, and of nothing else.
            hidden = tuple(kind for kind in RAYS if kind != "CAMERA" or kind in hidden)
        is_holdout = (
            (self._only_catchers and not is_catcher)
            # What an instance says itself does not count: as in Cycles, its instancer alone says so.
            or (holder.is_holdout and not place.is_instance)
            or _stands_for(place).holdout_get(view_layer=self._view_layer)
        )
        self.holds_out |= is_holdout
        name, color, number = holder.name, tuple(holder.color), object_info.index(holder, place)
        settings = {
            "hidden_from": hidden,
            "links": links.of(holder),
            "asset_name": _asset(holder),
            "light_group": self._groups.number(holder),
            "shadow_terminator": _shadow_terminator(holder),
            "is_holdout": is_holdout,
            "is_catcher": is_catcher,
            "is_baked": is_baked,
            "occlusion_distance": _occlusion_distance(holder, place),
        }
        if self._instance_group is None:
            self._builder.add_instance(
                name,
                index,
                rows(place.matrix_world),
                materials,
                moved=self._motion.matrices(place) if self._motion is not None else None,
                keys=self._blur.matrices(place) if self._blur is not None else None,
                info=(color, number, object_info.random(holder, place)),
                **settings,
            )
            return

        def send(matrix: Matrix4, random: float, others: tuple[np.ndarray, np.ndarray]) -> None:
            info = (color, number, float(random))
            self._builder.add_instance(name, index, matrix, materials, info=info, others=others, **settings)

        self._instance_group.calls.append(send)

    def _mesh(self, holder: bpy.types.Object, place: bpy.types.DepsgraphObjectInstance) -> int | None:
        data = holder.data
        # Curves, texts and metaballs come twice: as they are, and as the mesh that Blender has made of them.
        if not isinstance(data, (bpy.types.Mesh, bpy.types.Curves, bpy.types.PointCloud)):
            return None
        # A mesh whose users ask for different attributes is sent with each set.
        wanted = self._materials.of_rays.union(
            *(self._materials.wanted(slot.material) for slot in holder.material_slots)
        )

        def send() -> int | None:
            if isinstance(data, bpy.types.Curves):
                return self._strands(data, place, wanted)
            if isinstance(data, bpy.types.PointCloud):
                return self._cloud(data, place, wanted)
            # A bake is laid out over the triangles that Blender has.
            is_diced = self._baked is None
            diced = dicing.of(holder, self._scene, self._is_render, self._room, self._report) if is_diced else None
            # Shapes at other times are those of the whole modifier; of an instance the modifier may be its instancer's.
            has_cage = self._motion is None and self._blur is None and not place.is_instance and not data.is_editmode
            with dicing.cage(holder, self._depsgraph) if diced and has_cage else mesh.shape(holder, data) as shape:
                self._room.take(holder.name, mesh.triangle_count(shape))
                return self._add(data.name, shape, place, wanted, grids.of_smoke(holder, self._report), diced)

        return self._kept.mesh((data.as_pointer(), wanted), _sources(holder, place), send)

    def _strands(
        self, data: bpy.types.Curves, place: bpy.types.DepsgraphObjectInstance, wanted: frozenset[str]
    ) -> int | None:
        arrays = curves.extract(data, wanted, self._drawn)
        if arrays is None:
            return None
        moved = self._motion.positions(place, arrays.keys[:, :3]) if self._motion is not None else None
        poses = self._blur.balls(place, arrays.keys) if self._blur is not None else None
        return arrays.send(self._builder, data.name, moved, poses)

    def _add(
        self,
        name: str,
        data: bpy.types.Mesh,
        place: bpy.types.DepsgraphObjectInstance,
        wanted: frozenset[str],
        smoke: list[grids.Grid],
        diced: dicing.Dicing | None,
    ) -> int | None:
        arrays = mesh.extract(data, wanted, self._check_stop)
        if arrays is None:
            return None
        self._check_stop()
        moved = self._motion.positions(place, arrays.positions) if self._motion is not None else None
        return self._builder.add_mesh(
            name,
            arrays.positions,
            arrays.triangles,
            loops=arrays.loops_if_asked,
            corner_normals=arrays.corner_normals,
            uv_maps=arrays.uv_maps or None,
            attributes=arrays.attributes or None,
            material_slots=arrays.material_slots,
            moved_positions=moved,
            poses=self._blur.poses(place, arrays) if self._blur is not None else None,
            grids=smoke or None,
            dicing=diced,
        )

    def _cloud(
        self, data: bpy.types.PointCloud, place: bpy.types.DepsgraphObjectInstance, wanted: frozenset[str]
    ) -> int | None:
        arrays = points.extract(data, wanted)
        if arrays is None:
            return None
        moved = self._motion.positions(place, arrays.points[:, :3]) if self._motion is not None else None
        poses = self._blur.balls(place, arrays.points) if self._blur is not None else None
        return arrays.send(self._builder, data.name, moved, poses)

    def _particles(
        self,
        holder: bpy.types.Object,
        place: bpy.types.DepsgraphObjectInstance,
        links: Links,
        hidden: tuple[str, ...],
    ) -> None:
        """The hair of an object's particle systems, each with its own material."""
        slots = [slot.material for slot in holder.material_slots] or [None]
        first_number = 0
        for system in hair.systems(place, self._is_render):
            material = slots[min(max(system.settings.material - 1, 0), len(slots) - 1)]
            wanted = self._materials.wanted(material)
            send = functools.partial(self._add_hair, holder, place, system, wanted, first_number)
            key = (uid(holder), system.hair.name, wanted)
            index = self._kept.mesh(key, _sources(holder, place), send)
            first_number += len(system.particles)
            self.links_light |= links.any
            self._place(holder, place, links, hidden, index, [self._materials.index(material)])

    def _add_hair(
        self,
        holder: bpy.types.Object,
        place: bpy.types.DepsgraphObjectInstance,
        system: hair.System,
        wanted: frozenset[str],
        first_number: int,
    ) -> int:
        arrays = hair.extract(holder, system, wanted, self._drawn, first_number)
        moved = self._motion.hair(place, system.hair.name, arrays.keys[:, :3]) if self._motion is not None else None
        poses = self._blur.balls(place, arrays.keys, system.hair.name) if self._blur is not None else None
        return arrays.send(self._builder, f"{holder.name}, {system.hair.name}", moved, poses)
