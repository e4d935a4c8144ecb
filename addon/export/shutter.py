# SPDX-License-Identifier: GPL-3.0-or-later
"""The shutter's open time, and the places of everything at even keys over that time, for motion blur."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Matrix

from petzval.description import Matrix4

from . import curves, hair, mesh, points, velocity
from .camera import rows
from .motion import WITH_POSITIONS, Key, key, may_deform
from .report import Report

#: The part of the shutter's time that has gone by at the frame.
_OPENS = {"START": 0.0, "CENTER": 0.5, "END": 1.0}
#: Points at which the shutter's curve is read.
_CURVE_POINTS = 256
#: Rounding of a place on its way to the world's coordinates and back, of single precision, as a share of these.
_ROUNDING = 1e-6


class Shutter(NamedTuple):
    """The time of an exposure, in frames."""

    begin: float
    length: float

    @property
    def middle(self) -> float:
        return self.begin + 0.5 * self.length

    def at(self, part: float) -> tuple[int, float]:
        """The frame and subframe after a part of it, 0 to 1."""
        return split(self.begin + part * self.length)


def split(time: float) -> tuple[int, float]:
    """A time as a whole frame and the part of a frame beyond it."""
    frame = math.floor(time)
    return frame, time - frame


def of(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> Shutter | None:
    """The shutter of a scene in its frame; None where the scene or the view layer asks for no motion blur, or it is taken out."""
    render = scene.render
    # Older layers have no say.
    is_off = scene.petzval.effects.motion_blur == "OFF" or not getattr(layer, "use_motion_blur", True)
    if is_off or not render.use_motion_blur or render.motion_blur_shutter <= 0.0:
        return None
    now = scene.frame_current + scene.frame_subframe
    length = render.motion_blur_shutter
    return Shutter(now - _OPENS[_position(scene)] * length, length)


def _position(scene: bpy.types.Scene) -> str:
    # Before Blender 4.2 it was a setting of Cycles.
    own = scene.render if hasattr(scene.render, "motion_blur_position") else getattr(scene, "cycles", None)
    return getattr(own, "motion_blur_position", "CENTER")


def openness(render: bpy.types.RenderSettings) -> list[float]:
    """The openness of the shutter at even times, 0 to 1; empty where it is constant."""
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    curve = mapping.curves[0]
    found = [mapping.evaluate(curve, i / (_CURVE_POINTS - 1)) for i in range(_CURVE_POINTS)]
    return [] if min(found) == max(found) else found


def rolling(scene: bpy.types.Scene) -> float | None:
    """The part of the exposure for which each row is exposed, of a shutter that rolls from the top down; None: no rolling shutter."""
    cycles = getattr(scene, "cycles", None)
    if getattr(cycles, "rolling_shutter_type", "NONE") != "TOP":
        return None
    return cycles.rolling_shutter_duration


def key_count(holder: bpy.types.Object, parent: bpy.types.Object | None = None) -> int:
    """Keys of an object, made by `parent` if that is another, as Cycles has them; 0: it is not blurred."""
    settings = [one.cycles for one in (holder, parent) if one is not None and hasattr(one, "cycles")]
    if not all(one.use_motion_blur for one in settings):
        return 0
    return 2 ** max([1, *(one.motion_steps for one in settings)]) + 1


def key_count_of(place: bpy.types.DepsgraphObjectInstance) -> int:
    return key_count(place.object, place.parent if place.is_instance else None)


def _blurs_shape(place: bpy.types.DepsgraphObjectInstance) -> bool:
    """True if a changing shape blurs the instance, by Cycles' settings."""
    both = (place.object, place.parent if place.is_instance else None)
    settings = [one.cycles for one in both if one is not None and hasattr(one, "cycles")]
    return all(one.use_deform_motion for one in settings)


def _deforms(place: bpy.types.DepsgraphObjectInstance) -> bool:
    return _blurs_shape(place) and may_deform(place.object)


class Shape(NamedTuple):
    """A mesh at one key, or the keys of strands or points with their radii."""

    positions: np.ndarray
    #: The normals; None where there are none, or all faces are flat.
    normals: mesh.Values | None = None


class Standing(NamedTuple):
    """One instance at one key."""

    matrix: Matrix4
    #: The shape, shared by all instances; None where it is constant.
    shape: Shape | None
    #: The keys of hair and their radii, by particle system.
    hair: dict[str, Shape]


def _read(depsgraph: bpy.types.Depsgraph) -> dict[Key, Standing]:
    """The instances in the graph's frame, by key."""
    found: dict[Key, Standing] = {}
    known: dict[int, Shape | None] = {}
    known_hair: dict[str, dict[str, Shape]] = {}
    is_render = depsgraph.mode == "RENDER"
    for place in depsgraph.object_instances:
        holder = place.object
        of_hair: dict[str, Shape] = {}
        if holder.particle_systems:
            if holder.name_full not in known_hair:
                known_hair[holder.name_full] = {
                    system.hair.name: Shape(hair.keys(holder, system).reshape(-1, 4))
                    for system in hair.systems(place, is_render)
                }
            of_hair = known_hair[holder.name_full]
        if not (place.show_self or of_hair) or not key_count_of(place):
            continue
        data = holder.data
        shape = None
        if isinstance(data, WITH_POSITIONS) and _deforms(place):
            pointer = data.as_pointer()
            if pointer not in known:
                known[pointer] = _shape(data)
            shape = known[pointer]
        found[key(place)] = Standing(rows(place.matrix_world), shape, of_hair)
    return found


def _shape(data: bpy.types.Mesh | bpy.types.Curves | bpy.types.PointCloud) -> Shape | None:
    if isinstance(data, bpy.types.PointCloud):
        return Shape(points.balls(data)) if len(data.points) else None
    if isinstance(data, bpy.types.Curves):
        return Shape(curves.keys(data)) if len(data.points) else None
    return None if data.is_editmode else Shape(mesh.positions(data), mesh.normals(data))


class Blur:
    """The places and shapes of instances at keys over the exposure."""

    def __init__(self, report: Report, seconds: float) -> None:
        self._report = report
        #: The time for which the shutter is open, s.
        self._seconds = seconds
        self._keys: list[dict[Key, Standing]] = []

    def read(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Reads the next key: the graph is at its time."""
        now = _read(depsgraph)
        if self._keys:
            # What has not changed since is kept once.
            before = self._keys[-1]
            for which, one in now.items():
                old = before.get(which)
                if old is None:
                    continue
                if old.shape is not None and one.shape is not None and _same(old.shape, one.shape):
                    now[which] = one._replace(shape=old.shape)
                for system in one.hair.keys() & old.hair.keys():
                    if _is_stiff(old, one, system):
                        one.hair[system] = old.hair[system]
        self._keys.append(now)

    def matrices(self, place: bpy.types.DepsgraphObjectInstance) -> list[Matrix4] | None:
        """The matrices of an instance at its keys; None where it stands still."""
        found = [one.matrix for one in self._of(place)]
        return found if any(one != found[0] for one in found) else None

    def poses(
        self, place: bpy.types.DepsgraphObjectInstance, now: mesh.MeshArrays
    ) -> list[tuple[np.ndarray, mesh.Values | None]] | None:
        """The vertices of an instance's mesh and the normals of its corners at its keys; None where it keeps its shape."""
        shapes = self._shapes(place, now.positions)
        if shapes is None:
            return None
        has_normals = now.corner_normals is not None and all(now.fits(one.normals) for one in shapes)
        return [(one.positions, one.normals if has_normals else None) for one in shapes]

    def balls(
        self, place: bpy.types.DepsgraphObjectInstance, now: np.ndarray, system: str | None = None
    ) -> list[np.ndarray] | None:
        """The points of an instance's cloud, or the keys of its strands, and their radii at its keys; None where it keeps both. `system`:
        those of a particle system's hair."""
        shapes = self._shapes(place, now) if system is None else self._hair(place, system, now)
        return None if shapes is None else [one.positions for one in shapes]

    def _hair(self, place: bpy.types.DepsgraphObjectInstance, system: str, now: np.ndarray) -> list[Shape] | None:
        found = self._of(place) if _blurs_shape(place) else []
        return self._changing(place, [one.hair.get(system) for one in found], now)

    def _shapes(self, place: bpy.types.DepsgraphObjectInstance, now: np.ndarray) -> list[Shape] | None:
        count = key_count_of(place)
        way = velocity.of(place.object.data, 0.5 * self._seconds) if count and _blurs_shape(place) else None
        if way is not None and len(way) == len(now):
            way = np.pad(way, ((0, 0), (0, now.shape[1] - 3)))
            return [Shape(now - way), Shape(now), Shape(now + way)] if way.any() else None
        return self._changing(place, [one.shape for one in self._of(place)], now)

    def _changing(
        self, place: bpy.types.DepsgraphObjectInstance, shapes: list[Shape | None], now: np.ndarray
    ) -> list[Shape] | None:
        """The shapes, where they are all there, have as many vertices as now, and differ."""
        if not shapes or any(one is None for one in shapes) or all(one is shapes[0] for one in shapes):
            return None
        if any(one.positions.shape != now.shape for one in shapes):
            self._report.warn(
                f"Object '{place.object.name}': it has other vertices while the shutter is open, how it changes is not blurred"
            )
            return None
        return shapes

    def moves_light(self, place: bpy.types.DepsgraphObjectInstance) -> None:
        """Warns of a lamp that moves: it does not blur, as in Cycles."""
        if self.matrices(place) is not None:
            self._report.warn(
                f"Light '{place.object.name}': it moves while the shutter is open; as in Cycles it stands still, where it is in "
                "the middle of that time"
            )

    def _of(self, place: bpy.types.DepsgraphObjectInstance) -> list[Standing]:
        """An instance at each of its own keys; nothing where it is not blurred or not always there."""
        count = key_count_of(place)
        if count == 0 or not self._keys:
            return []
        which, step = key(place), (len(self._keys) - 1) // (count - 1)
        found = [one.get(which) for one in self._keys[::step]]
        return [] if any(one is None for one in found) else found


def _same(one: Shape, other: Shape) -> bool:
    if one.positions.shape != other.positions.shape or not np.array_equal(one.positions, other.positions):
        return False
    if one.normals is None or other.normals is None:
        return one.normals is other.normals
    return one.normals[0] == other.normals[0] and np.array_equal(one.normals[1], other.normals[1])


def _is_stiff(before: Standing, now: Standing, system: str) -> bool:
    """True where a particle system's hair has its shape of before, within the rounding of the world's coordinates, by which Blender tells it."""
    one, other = before.hair[system].positions, now.hair[system].positions
    if one.shape != other.shape:
        return False
    origin = Matrix(now.matrix).inverted_safe().translation
    reach = np.abs(one[:, :3]).max(initial=0.0) + max(map(abs, origin))
    return bool(np.abs(other - one).max(initial=0.0) <= _ROUNDING * reach)


def most_keys(depsgraph: bpy.types.Depsgraph, camera: bpy.types.Object | None) -> int:
    """The largest number of keys of anything in the graph, the camera among it."""
    found = [key_count_of(place) for place in depsgraph.object_instances]
    return max([0 if camera is None else key_count(camera), *found])


def sweep(shutter: Shutter, count: int, frame_set: Callable[[int, float], None], look: Callable[[int], None]) -> None:
    """Calls `look` with the number of each key while the scene is at its time."""
    for number in range(count):
        frame_set(*shutter.at(number / (count - 1)))
        look(number)
