# SPDX-License-Identifier: GPL-3.0-or-later
"""The last plan of each scene: the simulated effects of its lens, and why. Kept in memory, for panels and programs. No bpy."""

from __future__ import annotations

from typing import Any

#: The engine's `Plan.json` as a dictionary, by the scene's name.
_last: dict[str, dict[str, Any]] = {}


def keep(scene_name: str, plan: dict[str, Any]) -> None:
    """Remembers a plan as the scene's last."""
    _last[scene_name] = plan


def last(scene_name: str) -> dict[str, Any] | None:
    """The scene's last plan in this session."""
    return _last.get(scene_name)


def forget() -> None:
    """Drops all plans."""
    _last.clear()
