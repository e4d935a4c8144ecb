# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender properties: of a camera, a scene, a view layer."""
