# SPDX-License-Identifier: GPL-3.0-or-later
"""A layout that draws nothing and notes what a panel puts into it; complains of what Blender would only print.

Imported inside of tests: it needs bpy.
"""

from __future__ import annotations

from types import SimpleNamespace

import bpy

_PROP = bpy.types.UILayout.bl_rna.functions["prop"].parameters
ICONS = set(_PROP["icon"].enum_items.keys())


class Layout:
    """Stands for `UILayout`; parts of it note in the same list. `shown`: (name of the struct, property); `said`: texts."""

    def __init__(self, whole: Layout | None = None) -> None:
        whole = whole or self
        self.whole = whole
        if whole is self:
            self.shown, self.said, self.operators, self.active_parts = [], [], [], []
        self.alert = self.use_property_split = self.use_property_decorate = False
        self.active = self.enabled = True
        self.alignment, self.emboss, self.operator_context = "EXPAND", "NORMAL", "INVOKE_DEFAULT"
        self.scale_x = self.scale_y = 1.0

    def _part(self, *_, heading="", **__) -> Layout:
        self._say(heading)
        return Layout(self.whole)

    row = column = split = box = grid_flow = column_flow = _part

    def _say(self, text, icon="NONE") -> None:
        assert isinstance(text, str), text
        assert icon in ICONS, icon
        if text:
            self.whole.said.append(text)

    def prop(self, data, property, *, text=None, icon="NONE", index=-1, **_) -> None:
        found = data.bl_rna.properties.get(property)
        assert found is not None, f"{data.bl_rna.identifier} has no {property}"
        assert index < max(getattr(found, "array_length", 0), 1)
        self._say(text or "", icon)
        self.whole.shown.append((data.bl_rna.identifier, property))
        if not (self.active and self.enabled):
            self.whole.active_parts.append(property)

    def prop_search(self, data, property, search_data, search_property, **named) -> None:
        assert search_data.bl_rna.properties.get(search_property) is not None
        self.prop(data, property, text=named.get("text"))

    def prop_decorator(self, data, property, **_) -> None:
        assert property in data.bl_rna.properties

    def template_ID(self, data, property, **_) -> None:
        self.prop(data, property)

    def template_curve_mapping(self, data, property, **_) -> None:
        self.prop(data, property)

    def template_list(self, kind, _name, data, property, active_data, active_property, **_) -> None:
        assert property in data.bl_rna.properties and active_property in active_data.bl_rna.properties
        self.whole.shown.append((data.bl_rna.identifier, property))

    def template_node_view(self, tree, node, socket) -> None:
        assert node in tree.nodes.values() and socket in node.inputs.values()
        self.whole.shown.append((tree.bl_rna.identifier, socket.name))

    def template_icon(self, icon_value, scale=0.0) -> None:
        assert isinstance(icon_value, int) and scale > 0.0

    def label(self, *, text="", icon="NONE", **_) -> None:
        self._say(text, icon)

    def operator(self, name, *, text=None, icon="NONE", **_):
        module, _, function = name.partition(".")
        rna = getattr(getattr(bpy.ops, module), function).get_rna_type()
        self._say(text or "", icon)
        self.whole.operators.append(name)
        return _Properties(rna)

    def operator_menu_enum(self, name, property, *, text="", icon="NONE", **_):
        found = self.operator(name, text=text, icon=icon)
        setattr(found, property, None)
        return found

    def menu(self, name, *, text=None, icon="NONE", **_) -> None:
        assert hasattr(bpy.types, name), name
        self._say(text or "", icon)

    def popover(self, panel, *, text="", icon="NONE", **_) -> None:
        assert hasattr(bpy.types, panel), panel
        self._say(text, icon)

    def separator(self, **_) -> None:
        pass


class _Properties:
    def __init__(self, rna) -> None:
        object.__setattr__(self, "_rna", rna)

    def __setattr__(self, name, value) -> None:
        assert name in self._rna.properties, f"{self._rna.identifier} has no {name}"
        object.__setattr__(self, name, value)


def context(**more) -> SimpleNamespace:
    """Blender's context with what a properties editor adds."""
    now = bpy.context
    given = {
        "scene": now.scene,
        "view_layer": now.view_layer,
        "engine": now.scene.render.engine,
        "window_manager": now.window_manager,
        # Without a window it is 0.
        "preferences": SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
        "region": SimpleNamespace(width=400),
        "world": now.scene.world,
        **dict.fromkeys(("camera", "light", "material", "object")),
    }
    return SimpleNamespace(**given | more)


def panels(bl_context: str | None = None) -> list[type]:
    """Petzval's own panels, of one tab or all."""
    found = [cls for name in dir(bpy.types) if name.startswith("PETZVAL_") for cls in [getattr(bpy.types, name)]]
    found = [cls for cls in found if issubclass(cls, bpy.types.Panel)]
    return [cls for cls in found if bl_context is None or getattr(cls, "bl_context", "") == bl_context]


def draw(bl_context: str, now: SimpleNamespace) -> Layout:
    """All panels of a tab that show in that context, in one layout."""
    whole = Layout()
    for cls in panels(bl_context):
        if not cls.poll(now):
            continue
        # Methods of the panel's own, on something that is not one: Blender makes those.
        panel = SimpleNamespace(
            layout=Layout(whole), bl_space_type="PROPERTIES", bl_context=cls.bl_context, names=getattr(cls, "names", ())
        )
        for step in ("draw_header", "draw_header_preset", "draw"):
            if hasattr(cls, step):
                getattr(cls, step)(panel, now)
    return whole
