# SPDX-License-Identifier: GPL-3.0-or-later
"""The .blend files under a folder, for the tools that compare scenes by others."""

from __future__ import annotations

from pathlib import Path


def under(folder: Path) -> list[Path]:
    """The files, sorted by path. A folder may be called like one: archives of textures unpack into `wood.blend/textures`."""
    return [path for path in sorted(folder.rglob("*.blend")) if path.is_file()]
