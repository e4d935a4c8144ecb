# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports on a lens, one kind a file with its `REPORT`; `registry.REPORTS` lists them. `draw(found, figure)` fills a figure of `page`."""
