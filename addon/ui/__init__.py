# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: small, without arithmetic; what they show is asked of the engine."""

from __future__ import annotations

from . import builtin, camera, render


def register() -> None:
    render.register()
    camera.register()
    builtin.register()


def unregister() -> None:
    builtin.unregister()
    camera.unregister()
    render.unregister()
