# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the files of an animation's frames."""

from __future__ import annotations

from pathlib import Path


def numbered(file: Path, frame: int) -> Path:
    """A file's name with the number of a frame for the last #### in it, as many digits as there are; without any, at its end."""
    stem = file.stem if "#" in file.stem else f"{file.stem}_####"
    end = stem.rindex("#") + 1
    begin = len(stem[:end].rstrip("#"))
    digits = f"{'-' if frame < 0 else ''}{abs(frame):0{end - begin}d}"
    return file.with_name(f"{stem[:begin]}{digits}{stem[end:]}{file.suffix}")
