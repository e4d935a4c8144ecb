# SPDX-License-Identifier: GPL-3.0-or-later
"""Point clouds, and points that geometry nodes make, as the engine's arrays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from . import attributes

#: Cycles' radius of points without one.
RADIUS = 0.01


@dataclass
class PointArrays:
    """The arguments of `SceneBuilder.add_points`."""

    #: Place and radius, object space.
    points: np.ndarray
    #: Attributes by name: (points, 4).
    attributes: dict[str, np.ndarray] = field(default_factory=dict)

    def send(
        self,
        builder: Any,
        name: str,
        moved: tuple[np.ndarray, np.ndarray] | None,
        poses: list[np.ndarray] | None,
    ) -> int:
        """Adds the points to a `SceneBuilder`; returns their index."""
        return builder.add_points(
            name, self.points, attributes=self.attributes or None, moved_points=moved, poses=poses
        )


def extract(cloud: bpy.types.PointCloud, wanted: Iterable[str]) -> PointArrays | None:
    """The arrays of a cloud in object space, and the attributes of these names; None where there are no points."""
    if len(cloud.points) == 0:
        return None
    arrays = PointArrays(balls(cloud))
    for name in sorted(wanted):
        # As in Cycles, the radius is no attribute.
        attribute = cloud.attributes.get(name) if name and name != "radius" else None
        if attribute is not None and attribute.data_type in attributes.KINDS:
            arrays.attributes[name] = attributes.four(attribute)
    return arrays


def balls(cloud: bpy.types.PointCloud) -> np.ndarray:
    """Places and radii, (points, 4), object space."""
    found = np.full((len(cloud.points), 4), RADIUS, np.float32)
    places = np.empty((len(cloud.points), 3), np.float32)
    cloud.attributes["position"].data.foreach_get("vector", places.reshape(-1))
    found[:, :3] = places
    radius = cloud.attributes.get("radius")
    if radius is not None:
        radii = np.empty(len(cloud.points), np.float32)
        radius.data.foreach_get("value", radii)
        found[:, 3] = radii
    return found
