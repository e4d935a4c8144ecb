# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair curves, and curves that geometry nodes make, as the engine's arrays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from . import attributes

#: Cycles' radius of curves without one.
RADIUS = 0.005
#: Blender's number of curves that are straight from point to point.
_POLY = 1


@dataclass
class CurveArrays:
    """The arguments of `SceneBuilder.add_curves`."""

    #: Place and radius, object space.
    keys: np.ndarray
    #: The index of the first key, by strand; then the number of keys.
    first_keys: np.ndarray
    shape: dict[str, Any]
    first_number: int = 0
    #: UV maps by name: (strands, 2).
    uv_maps: dict[str, np.ndarray] = field(default_factory=dict)
    #: Attributes by name: True if by key, else by strand; and (keys or strands, 4).
    attributes: dict[str, tuple[bool, np.ndarray]] = field(default_factory=dict)

    def send(
        self,
        builder: Any,
        name: str,
        moved: tuple[np.ndarray, np.ndarray] | None,
        poses: list[np.ndarray] | None,
    ) -> int:
        """Adds the curves to a `SceneBuilder`; returns their index."""
        return builder.add_curves(
            name,
            self.keys,
            self.first_keys,
            **self.shape,
            first_number=self.first_number,
            uv_maps=self.uv_maps or None,
            attributes=self.attributes or None,
            moved_keys=moved,
            poses=poses,
        )


def shape(scene: bpy.types.Scene) -> dict[str, Any]:
    """The shape of curves by Cycles's settings; ribbons where there is no Cycles."""
    settings = getattr(scene, "cycles_curves", None)
    kind = getattr(settings, "shape", "RIBBONS")
    if kind == "RIBBONS":
        return {"shape": "RIBBON", "pieces": (1 << getattr(settings, "subdivisions", 2)) + 1}
    return {"shape": kind}


def extract(curves: bpy.types.Curves, wanted: Iterable[str], drawn: dict[str, Any]) -> CurveArrays | None:
    """The arrays of curves in object space, and the attributes of these names; None where there are no strands."""
    if len(curves.curves) == 0:
        return None
    first_keys = np.empty(len(curves.curves) + 1, np.int32)
    curves.curve_offset_data.foreach_get("value", first_keys)
    arrays = CurveArrays(keys(curves), first_keys, drawn if not _is_straight(curves) else {"shape": "THICK_LINEAR"})
    for attribute in curves.attributes:
        if attribute.domain == "CURVE" and attribute.data_type == "FLOAT2":
            arrays.uv_maps[attribute.name] = _read(attribute, "vector", 2, np.float32)
    for name in sorted(wanted):
        if name == attributes.CURVE_NORMAL:
            arrays.attributes[name] = (True, _normals(curves))
            continue
        attribute = curves.attributes.get(name) if name else None
        if attribute is not None and attribute.data_type in attributes.KINDS:
            arrays.attributes[name] = (attribute.domain == "POINT", attributes.four(attribute))
    return arrays


def keys(curves: bpy.types.Curves) -> np.ndarray:
    """Places and radii, (points, 4), object space."""
    found = np.full((len(curves.points), 4), RADIUS, np.float32)
    found[:, :3] = positions(curves)
    radius = curves.attributes.get("radius")
    if radius is not None and radius.domain == "POINT":
        found[:, 3] = _read(radius, "value", 1, np.float32)[:, 0]
    return found


def positions(curves: bpy.types.Curves) -> np.ndarray:
    """The points, (points, 3), object space."""
    return _read(curves.attributes["position"], "vector", 3, np.float32)


def _normals(curves: bpy.types.Curves) -> np.ndarray:
    """The normals by which Blender orients the curves, (points, 4), object space."""
    found = np.zeros((len(curves.points), 4), np.float32)
    normals = np.empty((len(curves.points), 3), np.float32)
    curves.normals.foreach_get("vector", normals.reshape(-1))
    found[:, :3] = normals
    return found


def _is_straight(curves: bpy.types.Curves) -> bool:
    """True if Cycles draws the curves straight from point to point: from Blender 5 on, by the type of the first curve."""
    kinds = curves.attributes.get("curve_type")
    return bpy.app.version >= (5, 0, 0) and kinds is not None and kinds.data[0].value == _POLY


def _read(attribute: bpy.types.Attribute, name: str, width: int, kind: type) -> np.ndarray:
    values = np.empty((len(attribute.data), width), kind)
    attribute.data.foreach_get(name, values.reshape(-1))
    return values
