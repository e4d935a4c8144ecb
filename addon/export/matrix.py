# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's matrices as plain tuples."""

from __future__ import annotations

from ..description import Matrix4


def rows(matrix) -> Matrix4:
    """Row by row."""
    return tuple(tuple(row) for row in matrix)
