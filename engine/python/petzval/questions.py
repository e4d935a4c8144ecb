# SPDX-License-Identifier: GPL-3.0-or-later
"""The question of a command in JSON: read from a file or stdin, with the errors that are found in it."""

from __future__ import annotations

import json
import sys
from typing import Any

from .errors import CommandError

#: Bytes of a question: some million rays.
_LONGEST = 1 << 30


def read_list(path: str, name: str, example: str) -> tuple[str, dict[str, Any]]:
    """The text of a file (`-`: of stdin) and the object in it, which has a list `name`.

    Raises `CommandError`; `example` is an item of the list as it should be.
    """
    text = _read(path, name)
    try:
        question = json.loads(text)
    except json.JSONDecodeError as error:
        raise CommandError(f"not JSON: {path}, line {error.lineno}, column {error.colno}: {error.msg}") from None
    except (ValueError, RecursionError):
        raise CommandError(f"not JSON: {path}: a number is too long, or lists lie too deep: write it shorter") from None
    if not isinstance(question, dict) or not isinstance(question.get(name), list):
        raise CommandError(f'no list of {name}: {path}: give {{"{name}": [{example}]}}')
    return text, question


def _read(path: str, name: str) -> str:
    from . import _native

    try:
        data = sys.stdin.buffer.read(_LONGEST + 1) if path == "-" else _native.read_bounded(path, _LONGEST)
        if len(data) > _LONGEST:
            raise CommandError(f"too long: {path}: more than {_LONGEST} bytes: ask in parts")
        return data.decode("utf-8")
    except OSError as error:
        raise CommandError(
            f"cannot read: {path}: {error.strerror or error}: name a file of {name}, or - for stdin"
        ) from None
    except UnicodeDecodeError:
        raise CommandError(f"not text: {path}: give JSON in UTF-8") from None


def vector_text(vector: list[float]) -> str:
    """Coordinates in a readable line."""
    return " ".join(f"{value:z.9g}" for value in vector)
