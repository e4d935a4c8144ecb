# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a picture's views, in stereo or multiview: one for each as Blender names them, or one for all."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from . import atomic_files


def suffixes(render: Any) -> list[str]:
    """The suffixes that Blender appends to a picture's name, view by view, by a scene's render settings; one empty suffix where all views,
    or the only one, lie in one file."""
    if not render.use_multiview or render.image_settings.views_format != "INDIVIDUAL":
        return [""]
    # Of a pair of eyes Blender has two views; it keeps others for multiview.
    views = [one for one in render.views if one.use and (render.views_format == "MULTIVIEW" or one.name in _EYES)]
    return [one.file_suffix for one in views] if len(views) > 1 else [""]


_EYES = ("left", "right")


def problem(render: Any) -> str | None:
    """The reason why a scene's views cannot be written, and what to do; None where they can."""
    own = suffixes(render)
    same = next((one for one in own if own.count(one) > 1), None)
    return (
        None if same is None else f"two views of the scene have the file suffix '{same}': give each its own in Blender"
    )


def with_suffix(file: Path, suffix: str) -> Path:
    """A file's name with that of a view before its ending."""
    return file.with_name(f"{file.stem}{suffix}{file.suffix}")


@contextlib.contextmanager
def replacing(file: Path, render: Any, check: Callable[[Path], None]) -> Iterator[Path]:
    """`atomic_files.replacing` for all files that Blender writes for one picture: the block has Blender write into the path that it is
    given. Raises `OSError`."""
    own = suffixes(render)
    if len(own) == 1:
        with atomic_files.replacing(file, check) as part:
            yield part
        return
    with contextlib.ExitStack() as files:
        parts = [files.enter_context(atomic_files.replacing(with_suffix(file, one), check)) for one in own]
        written = [with_suffix(parts[0], one) for one in own]
        try:
            yield parts[0]
            for part, one in zip(parts, written, strict=True):
                one.replace(part)
        finally:
            for one in written:
                one.unlink(missing_ok=True)
