# SPDX-License-Identifier: GPL-3.0-or-later
"""The lenses as pictures: a popover with a search, a group to choose, and a thumbnail for each lens."""

from __future__ import annotations

import re
from typing import Any

import bpy
from bpy.props import EnumProperty, PointerProperty, StringProperty

from ..data import favourites, lens_files
from ..drawing import thumbnails
from ..native import EngineMissing
from .mixin import ENGINES

_COLUMNS = 5
# More do not fit on a screen.
_MOST = 30
_ICON_SCALE = 5.0
# Characters under a picture.
_NAME = 17
_F_NUMBER = re.compile(r"\b[Ff]/\d+(\.\d+)?")

# Blender does not keep the strings of enum items that are made on demand.
_items: list[tuple[str, str, str]] = []


def _groups(_settings: Any, _context: bpy.types.Context | None) -> list[tuple[str, str, str]]:
    if not _items:
        _items.append(("FIRST", "First Choice", "One good lens of each kind"))
        _items.append(("FAVOURITES", "Favourites", "The lenses with your star"))
        _items.append(("ALL", "All", "Every lens that comes with Petzval"))
        try:
            _items.extend((group, group.title(), f"Lenses of this kind: {group}") for group in lens_files.groups())
        except EngineMissing:
            return _items
    return _items


class PetzvalGallery(bpy.types.PropertyGroup):
    """The gallery's view of the lenses: of this session alone."""

    words: StringProperty(
        name="Search",
        description="Words of a lens's name, kind, design, focal length or f-number, such as 'wide 28' or 'nikkor f/1.4'",
        options={"TEXTEDIT_UPDATE", "SKIP_SAVE"},
    )
    group: EnumProperty(name="Kind", description="Which lenses are shown", items=_groups, options={"SKIP_SAVE"})


def chosen(group: str, words: str) -> list[dict[str, Any]]:
    """The lenses to be shown, as the library has them; those of the user's own files have a path for `id`, and a name."""
    shipped = lens_files.shipped()
    if words.strip():
        # A search goes through all of them.
        return [entry for entry in shipped if lens_files.is_meant(entry, words)]
    if group == "FAVOURITES":
        return favourite_entries()
    if group == "FIRST":
        return [entry for entry in shipped if entry["is_first_choice"]]
    return [entry for entry in shipped if group in ("ALL", entry["group"])]


def favourite_entries() -> list[dict[str, Any]]:
    """The user's favourites; of a lens in a file of the user's, name and path alone."""
    shipped = {lens_files.file_name(entry): entry for entry in lens_files.shipped()}
    return [
        shipped.get(key) or {"id": key, "name": bpy.path.display_name_from_filepath(key), "is_own": True}
        for key in favourites.all_of_them()
    ]


def key_of(entry: dict[str, Any]) -> str:
    """The key of a lens, as a camera's settings keep it."""
    return entry["id"] if entry.get("is_own") else lens_files.file_name(entry)


class PETZVAL_PT_lens_gallery(bpy.types.Panel):
    """Choose a lens by its picture"""

    bl_label = "Lenses"
    bl_space_type = "PROPERTIES"
    bl_region_type = "HEADER"
    bl_ui_units_x = 28
    bl_options = {"INSTANCED"}
    COMPAT_ENGINES = ENGINES

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        layout = self.layout
        settings = context.window_manager.petzval_gallery
        row = layout.row(align=True)
        row.prop(settings, "words", text="", icon="VIEWZOOM")
        part = row.row(align=True)
        part.active = not settings.words.strip()
        part.prop(settings, "group", text="")
        try:
            entries = chosen(settings.group, settings.words)
        except EngineMissing as error:
            layout.label(text=str(error), icon="ERROR")
            return
        if not entries:
            nothing = "No favourites yet: the star beside the lens makes one" if not settings.words else "Nothing found"
            layout.label(text=nothing, icon="INFO")
            return
        grid = layout.grid_flow(row_major=True, columns=_COLUMNS, even_columns=True, even_rows=True, align=True)
        for entry in entries[:_MOST]:
            _cell(grid.column(align=True), entry)
        for _ in range(_COLUMNS - len(entries)):
            # A few would be as wide as all.
            grid.column(align=True)
        if len(entries) > _MOST:
            layout.label(text=f"{len(entries) - _MOST} more: search, or choose a kind", icon="INFO")


def caption(name: str) -> str:
    """A lens's name for under its picture, with its f-number."""
    if len(name) <= _NAME:
        return name
    opening = _F_NUMBER.search(name)
    if opening is None:
        return f"{name[: _NAME - 1].rstrip(' ,')}…"
    words = name[: opening.start()].replace(" mm", "").rstrip(" ,")
    room = _NAME - 1 - len(opening[0])
    words = words if len(words) <= room else f"{words[: room - 1].rstrip(' ,')}…"
    return f"{words} {opening[0]}"


def _cell(column: bpy.types.UILayout, entry: dict[str, Any]) -> None:
    key = key_of(entry)
    number = thumbnails.icon(key)
    if not number:
        # A popover is not drawn anew when a timer has drawn what it lacks.
        thumbnails.draw(key)
        number = thumbnails.icon(key)
    column.template_icon(number, scale=_ICON_SCALE)
    choose = column.operator("petzval.set_lens", text=caption(entry["name"]), emboss=True)
    choose.lens = key


CLASSES = (PetzvalGallery, PETZVAL_PT_lens_gallery)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.petzval_gallery = PointerProperty(type=PetzvalGallery, options={"SKIP_SAVE"})


def unregister() -> None:
    del bpy.types.WindowManager.petzval_gallery
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    _items.clear()
