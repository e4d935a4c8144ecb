# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of panels in docs/panel.md and README.md, taken in Blender's window."""
