# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots without matplotlib, for Blender, whose Python has numpy alone. `figure.Figure` understands as much of matplotlib's figure and
axes as `lens_reports` and `lens_drawing` ask for, so that one drawing serves both. Letters are outlines that somebody gives."""
