# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of instances a frame before and a frame after, for the Vector pass."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from petzval.description import Matrix4

from . import curves, hair, mesh, points, velocity
from .camera import rows
from .report import Report

Key = tuple

#: The data with vertices, keys or points that may move.
WITH_POSITIONS = (bpy.types.Mesh, bpy.types.Curves, bpy.types.PointCloud)


def key(place: bpy.types.DepsgraphObjectInstance) -> Key:
    """The key of an instance that is the same at every frame: its object, and which of the instances of its emitter."""
    if not place.is_instance:
        return (place.object.name_full,)
    return place.object.name_full, place.parent.name_full, tuple(place.persistent_id)


class Placed(NamedTuple):
    """One instance at one frame."""

    matrix: Matrix4
    #: The positions of the mesh's vertices, curves' keys or points, object space; shared by all instances. None where they cannot move.
    positions: np.ndarray | None
    #: The positions of the keys of hair, by particle system.
    hair: dict[str, np.ndarray]


class Frame(dict[Key, Placed]):
    """Instances at one frame."""

    @classmethod
    def read(cls, depsgraph: bpy.types.Depsgraph) -> Frame:
        """The places and positions of everything that has a surface, in the graph's frame."""
        found = cls()
        known: dict[int, np.ndarray | None] = {}
        known_hair: dict[str, dict[str, np.ndarray]] = {}
        is_render = depsgraph.mode == "RENDER"
        for place in depsgraph.object_instances:
            holder = place.object
            data = holder.data
            of_hair: dict[str, np.ndarray] = {}
            if holder.particle_systems:
                if holder.name_full not in known_hair:
                    known_hair[holder.name_full] = {
                        system.hair.name: hair.places(holder, system).reshape(-1, 3)
                        for system in hair.systems(place, is_render)
                    }
                of_hair = known_hair[holder.name_full]
            if not (place.show_self or of_hair) or not isinstance(data, WITH_POSITIONS):
                continue
            pointer = data.as_pointer()
            if pointer not in known:
                # What is being edited stands still.
                if isinstance(data, bpy.types.Curves):
                    known[pointer] = curves.positions(data) if len(data.points) else None
                elif isinstance(data, bpy.types.PointCloud):
                    known[pointer] = np.ascontiguousarray(points.balls(data)[:, :3]) if len(data.points) else None
                else:
                    deforms = may_deform(holder) and not data.is_editmode
                    known[pointer] = mesh.positions(data) if deforms else None
            found[key(place)] = Placed(rows(place.matrix_world), known[pointer], of_hair)
        return found


def may_deform(holder: bpy.types.Object) -> bool:
    """True if the mesh can have another shape at another frame: most cannot, and need not be read."""
    original = holder.original
    plain = original.type == "MESH" and not original.modifiers and original.data.shape_keys is None
    return not plain or original.data.animation_data is not None


class Motion:
    """The movement between two frames, for the builder."""

    def __init__(self, before: Frame, after: Frame, frame_s: float, report: Report) -> None:
        self._frames = before, after
        self._frame_s = frame_s
        self._report = report

    def matrices(self, place: bpy.types.DepsgraphObjectInstance) -> tuple[Matrix4, Matrix4] | None:
        """The matrices of an instance in the neighbouring frames; None where it does not move, or is not there in one."""
        both = self._placed(place)
        if both is None:
            return None
        now = rows(place.matrix_world)
        return None if all(one.matrix == now for one in both) else (both[0].matrix, both[1].matrix)

    def positions(
        self, place: bpy.types.DepsgraphObjectInstance, now: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """The vertices of an instance's mesh in the neighbouring frames; None where it keeps its shape."""
        way = velocity.of(place.object.data, self._frame_s)
        if way is not None and len(way) == len(now):
            return (now - way, now + way) if way.any() else None
        both = self._placed(place)
        if both is None or any(one.positions is None for one in both):
            return None
        return self._moved(place, (both[0].positions, both[1].positions), now)

    def hair(
        self, place: bpy.types.DepsgraphObjectInstance, system: str, now: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """The keys of a particle system's hair in the neighbouring frames; None where it keeps its shape."""
        both = self._placed(place)
        if both is None or any(system not in one.hair for one in both):
            return None
        return self._moved(place, (both[0].hair[system], both[1].hair[system]), now)

    def _moved(
        self, place: bpy.types.DepsgraphObjectInstance, moved: tuple[np.ndarray, np.ndarray], now: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        if any(then.shape != now.shape for then in moved):
            name = place.object.name
            self._report.warn(
                f"Object '{name}': it has other vertices in the frames beside, its Vector pass leaves out how it changes"
            )
            return None
        return None if all(np.array_equal(then, now) for then in moved) else moved

    def _placed(self, place: bpy.types.DepsgraphObjectInstance) -> tuple[Placed, Placed] | None:
        which = key(place)
        before, after = (frame.get(which) for frame in self._frames)
        return None if before is None or after is None else (before, after)
