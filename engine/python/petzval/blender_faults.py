# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of Blender as a Python module that would end a render, and the measures against them."""

from __future__ import annotations

from typing import Any


def keep_fluids(scene: Any) -> list[str]:
    """Has Blender keep the scene's evaluated data after a render, where an object is a simulated fluid: to free a fluid ends the
    process of Blender as a Python module ("can't clean grid cache, some grids are still in use"), before the picture is written,
    whichever engine renders. The Blender program frees it well. The names of the fluids' domains, which this Blender does not simulate,
    either: the picture holds baked data alone."""
    import bpy

    # The module has no program. (Blender 4.3 has no `bpy.app.module`.)
    if bpy.app.binary_path:
        return []
    fluids = [(thing.name, one) for thing in scene.objects for one in thing.modifiers if one.type == "FLUID"]
    if fluids:
        scene.render.use_persistent_data = True
    return [name for name, one in fluids if one.fluid_type == "DOMAIN"]
