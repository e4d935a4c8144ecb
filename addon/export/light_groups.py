# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: a number for each that the view layer names."""

from __future__ import annotations

import bpy


class LightGroups:
    """The groups of a view layer, from number 1 on. An emitter of a group that it does not name is in none, as in Cycles."""

    def __init__(self, view_layer: bpy.types.ViewLayer) -> None:
        #: The names in the order of their numbers.
        self.names = [one.name for one in view_layer.lightgroups]
        self._numbers = {name: number for number, name in enumerate(self.names, 1)}

    def number(self, holder: bpy.types.Object | bpy.types.World | None) -> int:
        """The number of an emitter's light group; 0 for none."""
        return 0 if holder is None else self._numbers.get(holder.lightgroup, 0)
