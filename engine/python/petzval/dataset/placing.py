# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses by the content of a scene: random ones that stand clear of it, an object's, and those along a curve. Needs Blender."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np

from ..errors import CommandError
from . import poses
from .poses import Matrix, Vector
from .spec import Path_, Random

#: Candidates for each wanted pose before the search is given up.
_MOST_TRIES = 200
#: Directions of the rays that find whether a place is inside of something: none along an axis, as sides of boxes are.
_WAYS = np.array([(0.57, 0.43, 0.71), (-0.81, 0.31, 0.5), (0.23, -0.89, 0.39)])
#: Surfaces on one way, at most.
_MOST_CROSSED = 1000


class Surroundings:
    """All surfaces of a scene that a render shows, for looking up the nearest one."""

    def __init__(self, depsgraph: Any) -> None:
        from mathutils.bvhtree import BVHTree

        corners: list[Any] = []
        faces: list[Any] = []
        self._owners: list[str] = []
        for place in depsgraph.object_instances:
            holder = place.object
            if (
                holder.type not in {"MESH", "CURVE", "SURFACE", "FONT", "META"}
                or not place.show_self
                or holder.hide_render
            ):
                continue
            mesh = holder.to_mesh()
            if mesh is None:
                continue
            mesh.calc_loop_triangles()
            begin = len(corners)
            matrix = place.matrix_world.copy()
            corners.extend(matrix @ vertex.co for vertex in mesh.vertices)
            faces.extend(tuple(begin + i for i in triangle.vertices) for triangle in mesh.loop_triangles)
            self._owners.extend([holder.name] * len(mesh.loop_triangles))
            holder.to_mesh_clear()
        self._tree = BVHTree.FromPolygons(corners, faces, all_triangles=True) if faces else None

    def too_near(self, at: Matrix, clearance: float) -> str | None:
        """The object that is nearer than `clearance`, if there is one."""
        if self._tree is None or clearance <= 0.0:
            return None
        _, _, face, _ = self._tree.find_nearest(tuple(at), clearance)
        return None if face is None else self._owners[face]

    def inside_of(self, at: Matrix) -> str | None:
        """The object that a place is inside of: one whose surface most ways cross an odd number of times."""
        if self._tree is None:
            return None
        odd: Counter[str] = Counter()
        for way in _WAYS / np.linalg.norm(_WAYS, axis=1, keepdims=True):
            crossed: Counter[str] = Counter()
            start = np.array(at)
            for _ in range(_MOST_CROSSED):
                _, _, face, distance = self._tree.ray_cast(tuple(start), tuple(way))
                if face is None:
                    break
                crossed[self._owners[face]] += 1
                start = start + (distance + 1e-5 * max(1.0, float(np.abs(start).max()))) * way
            odd.update(name for name, count in crossed.items() if count % 2)
        # An edge may count twice.
        return min((name for name, count in odd.items() if count > len(_WAYS) / 2), default=None)


def random(
    asked: Random, centre: Vector, target: Vector | None, around: Surroundings
) -> tuple[list[Matrix], Counter[str]]:
    """The poses, and the number of refused candidates by reason. Raises `CommandError` where too few are found."""
    chance = np.random.default_rng(asked.seed)
    found: list[Matrix] = []
    refused: Counter[str] = Counter()
    for _ in range(_MOST_TRIES * asked.count):
        if len(found) == asked.count:
            break
        # The same numbers for each candidate, whatever becomes of it.
        numbers = chance.random(8)
        at = _place(asked, centre, numbers[:3])
        if name := around.too_near(at, asked.clearance):
            refused[f"nearer than {asked.clearance:g} to '{name}'"] += 1
        elif asked.rejects_inside and (name := around.inside_of(at)):
            refused[f"inside of '{name}'"] += 1
        else:
            found.append(_looking(at, target, asked.jitter_deg, numbers[3:]))
    if len(found) < asked.count:
        said = ", ".join(f"{count} {why}" for why, count in refused.most_common(5))
        raise CommandError(
            f"[random] found {len(found)} of {asked.count} poses; candidates refused: {said}: move the box, make clearance smaller, or set "
            "rejects-inside = false where the scene lies inside of a closed room"
        )
    return found, refused


def _place(asked: Random, centre: Vector, numbers: Matrix) -> Matrix:
    """Evenly in the box, or in the shell's volume."""
    if asked.box is not None:
        low, high = np.array(asked.box)
        made: Matrix = low + numbers * (high - low)
        return made
    low, high = (radius**3 for radius in asked.radius)
    radius = (low + numbers[0] * (high - low)) ** (1.0 / 3.0)
    lowest, highest = (math.sin(math.radians(one)) for one in asked.elevation_deg)
    height = lowest + numbers[1] * (highest - lowest)
    turn, across = 2.0 * math.pi * numbers[2], math.sqrt(max(1.0 - height * height, 0.0))
    found: Matrix = np.array(centre) + radius * np.array([across * math.cos(turn), across * math.sin(turn), height])
    return found


def _looking(at: Matrix, target: Vector | None, jitter_deg: float, numbers: Matrix) -> Matrix:
    """A pose that looks at the target, turned by up to the jitter; without a target in any direction, the horizon level."""
    if target is None:
        height, turn = 2.0 * numbers[0] - 1.0, 2.0 * math.pi * numbers[1]
        across = math.sqrt(max(1.0 - height * height, 0.0))
        return poses.looking_at(at, at + np.array([across * math.cos(turn), across * math.sin(turn), height]))
    pose = poses.looking_at(at, target)
    x, y, z = (jitter_deg * (2.0 * one - 1.0) for one in numbers[2:5])
    pose[:3, :3] = pose[:3, :3] @ poses.euler_deg((x, y, z))
    return pose


def along(asked: Path_, scene: Any, frames: tuple[int, ...], place_of: Any) -> list[Matrix]:
    """The poses of an object in frames of the scene; along a curve at even distances. The scene is left in another frame."""
    import bpy

    chosen = scene.objects.get(asked.object)
    if chosen is None:
        raise CommandError(f"[path] no object '{asked.object}' in scene '{scene.name}': name one that is there")
    if chosen.type == "CURVE":
        return _along_curve(asked, chosen, len(frames), place_of)
    found = []
    for frame in frames:
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        pose = poses.orthonormal(np.array(chosen.evaluated_get(graph).matrix_world))
        if asked.target is not None:
            pose = poses.looking_at(
                pose[:3, 3], place_of(asked.target) if isinstance(asked.target, str) else asked.target
            )
        found.append(pose)
    return found


def _along_curve(asked: Path_, curve: Any, count: int, place_of: Any) -> list[Matrix]:
    """Poses evenly along a curve, looking along it with z up, or at a target."""
    import bpy

    graph = bpy.context.evaluated_depsgraph_get()
    holder = curve.evaluated_get(graph)
    mesh = holder.to_mesh()
    matrix = np.array(holder.matrix_world)
    points = np.array([tuple(vertex.co) for vertex in mesh.vertices]).reshape(-1, 3)
    has_faces = len(mesh.polygons) > 0
    holder.to_mesh_clear()
    if len(points) < 2 or has_faces:
        raise CommandError(f"[path] curve '{curve.name}' is no line: take a curve without bevel and extrusion")
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    is_cyclic = bool(curve.data.splines[0].use_cyclic_u)
    if is_cyclic:
        points = np.vstack([points, points[:1]])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, lengths[-1], count, endpoint=not is_cyclic) if count > 1 else np.zeros(1)
    places = np.stack([np.interp(at, lengths, points[:, i]) for i in range(3)], axis=1)
    segment = np.clip(np.searchsorted(lengths, at, side="right") - 1, 0, len(points) - 2)
    ahead = points[segment + 1] - points[segment]
    target = place_of(asked.target) if isinstance(asked.target, str) else asked.target
    return [
        poses.looking_at(one, one + way if target is None else target) for one, way in zip(places, ahead, strict=True)
    ]
