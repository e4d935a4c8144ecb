# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of lenses: the user's favourites on top, then the first choice of those that come with Petzval, then all by groups."""

from __future__ import annotations

from typing import Any

import bpy

from ..data import lens_files
from ..native import EngineMissing
from .lens_gallery import favourite_entries, key_of

#: Menus have to be there before the engine is asked for its groups: at least as many as those.
MOST_GROUPS = 16


class PETZVAL_MT_lenses(bpy.types.Menu):
    """The lenses that come with Petzval"""

    bl_idname = "PETZVAL_MT_lenses"
    bl_label = "Lenses"

    def draw(self, _context):
        layout = self.layout
        try:
            entries, groups = lens_files.shipped(), lens_files.groups()
        except EngineMissing as error:
            layout.label(text=str(error), icon="ERROR")
            return
        layout.operator("petzval.import_lens", text="Import Lens File...", icon="FILE_FOLDER")
        layout.separator()
        liked = favourite_entries()
        if liked:
            layout.label(text="Favourites", icon="SOLO_ON")
            for entry in liked:
                layout.operator("petzval.set_lens", text=entry["name"]).lens = key_of(entry)
            layout.separator()
        layout.label(text="First Choice")
        _choices(layout, [entry for entry in entries if entry["is_first_choice"]])
        layout.separator()
        for menu, group in zip(GROUP_MENUS, groups, strict=False):
            if any(entry["group"] == group for entry in entries):
                layout.menu(menu.bl_idname, text=group.title())


def _choices(layout: bpy.types.UILayout, entries: list[dict[str, Any]]) -> None:
    # By itself the operator would open its search.
    layout.operator_context = "EXEC_DEFAULT"
    for entry in entries:
        layout.operator("petzval.choose_lens", text=entry["name"]).lens = lens_files.file_name(entry)


def _draw_group(place: int):
    def draw(self, _context):
        group = lens_files.groups()[place]
        _choices(self.layout, [entry for entry in lens_files.shipped() if entry["group"] == group])

    return draw


def _group_menu(place: int) -> type[bpy.types.Menu]:
    name = f"PETZVAL_MT_lenses_{place}"
    parts = {"bl_idname": name, "bl_label": "Lenses", "draw": _draw_group(place), "__module__": __name__}
    return type(name, (bpy.types.Menu,), parts)


GROUP_MENUS = tuple(_group_menu(place) for place in range(MOST_GROUPS))
