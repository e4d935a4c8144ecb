# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of what the engine reports of a lens, one kind a file: `draw(found, figure)` fills a figure of `page`."""
