# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are replaced only by complete ones: every file that Petzval writes by Python goes through `replacing`."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from . import _native

#: Replacements under way, whose temporary files a process that ends at once must remove.
_under_way: list[_native.FileReplacement] = []


@contextlib.contextmanager
def replacing(file: Path, check: Callable[[Path], None] | None = None) -> Iterator[Path]:
    """A temporary file for the block to write. It takes the place of `file` when neither the block nor `check`, which is handed the
    temporary file, has raised; otherwise it is removed, and the old file stays. Raises `OSError`."""
    replacement = _native.FileReplacement(file)
    _under_way.append(replacement)
    try:
        part = Path(replacement.part)
        yield part
        if check is not None:
            check(part)
        replacement.commit()
    finally:
        replacement.abandon()
        _under_way.remove(replacement)


def write_text(file: Path, text: str) -> None:
    """Writes text in UTF-8, with the same line ends on every system. Raises `OSError`; the old file stays then."""
    with replacing(file) as part:
        part.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(file: Path, data: bytes) -> None:
    """Writes bytes. Raises `OSError`; the old file stays then."""
    with replacing(file) as part:
        part.write_bytes(data)


def create_text(file: Path, text: str) -> None:
    """Writes text in UTF-8 into a file that is not there yet: the first of several processes does. Raises `FileExistsError` in the others, which
    may find it before it is whole, and `OSError`."""
    with file.open("x", encoding="utf-8", newline="\n") as out:
        out.write(text)


def write_json(file: Path, value: Any, indent: int | None = None) -> None:
    """Writes a value as JSON. Raises `OSError`; the old file stays then."""
    write_text(file, json.dumps(value, indent=indent) + "\n")


def abandon_all() -> None:
    """Removes the temporary files of this process, which is about to end."""
    for replacement in list(_under_way):
        # One that is being renamed by another thread is in its hands.
        with contextlib.suppress(RuntimeError):
            replacement.abandon()
