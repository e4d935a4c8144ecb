# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings."""

from __future__ import annotations

import bpy

from ..description import SettingsDescription


def picture_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """Columns and rows of the whole picture, without border."""
    r = scene.render
    return (
        max(int(r.resolution_x * r.resolution_percentage / 100), 1),
        max(int(r.resolution_y * r.resolution_percentage / 100), 1),
    )


def settings(scene: bpy.types.Scene) -> SettingsDescription:
    own = scene.petzval
    width, height = picture_size(scene)
    return SettingsDescription(
        width=width,
        height=height,
        samples=own.samples,
        seed=own.seed,
        sample_offset=own.sample_offset,
        threads=scene.render.threads if scene.render.threads_mode == "FIXED" else 0,
        max_bounces=own.max_bounces,
        filter_width_px=own.filter_width_px,
        transparent_film=scene.render.film_transparent,
    )
