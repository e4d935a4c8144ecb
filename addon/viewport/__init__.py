# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading in a 3D view: what changed is sent on, a thread renders, the screen shows what there is."""

from __future__ import annotations

from .rendered_view import RenderedView

__all__ = ["RenderedView"]
