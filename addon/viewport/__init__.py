# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading in a 3D view: changes are sent on, a thread renders, the screen shows its last picture."""

from __future__ import annotations

from .rendered_view import RenderedView

__all__ = ["RenderedView"]
