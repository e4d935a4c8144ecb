# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared parts of the camera's Lens panel."""

from __future__ import annotations

from petzval.description import OF_LENS_FILE

from .mixin import PetzvalPanel

LENS_PANEL = "PETZVAL_CAMERA_PT_lens"


class CameraPanel(PetzvalPanel):
    """A mixin of panels of the camera."""

    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera is not None


class LensPart(CameraPanel):
    """A part that only a real lens has."""

    bl_parent_id = LENS_PANEL

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model in OF_LENS_FILE


class AperturePart(CameraPanel):
    """A part that a thin lens has too, and if it is `of_blur` a calibrated camera with depth of field."""

    of_blur = False

    bl_parent_id = LENS_PANEL

    @classmethod
    def poll(cls, context):
        settings = context.camera.petzval if super().poll(context) else None
        if settings is None or settings.model == "PINHOLE":
            return False
        return settings.model != "CALIBRATED" or (cls.of_blur and context.camera.dof.use_dof)


# Of an unscaled interface: what a character of a label takes in the mean, and what icon and margins take of a line.
_CHARACTER_PX, _MARGIN_PX = 7, 60


def lines_of(context, text: str) -> list[str]:
    """The text broken to the width of the panel."""
    width = context.region.width / context.preferences.system.ui_scale
    most = max(int((width - _MARGIN_PX) / _CHARACTER_PX), 16)
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + len(word) >= most:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def complain(context, layout, text: str) -> None:
    """The engine's complaint in red, broken where it must be."""
    column = layout.column(align=True)
    column.alert = True
    for number, line in enumerate(lines_of(context, text)):
        column.label(text=line, icon="BLANK1" if number else "ERROR")


def fact(layout, name: str, text: str) -> None:
    """A row that only says something."""
    row = layout.split(factor=0.45)
    row.alignment = "RIGHT"
    row.label(text=name)
    row.label(text=text)
