# SPDX-License-Identifier: GPL-3.0-or-later
"""TOML files whose every key is known: wrong names and types are refused with their line."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import CommandError

#: A key's way through tables: names, and numbers in arrays of tables.
KeyPath = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*\[(\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(r"^(\s*)([A-Za-z0-9_.\-\"']+)\s*=")


class Table:
    """A table of a TOML file. Each method takes a key out of it; `end` refuses keys that are left."""

    def __init__(
        self, file: Path, values: dict[str, Any], places: dict[KeyPath, tuple[int, int]], path: KeyPath = ()
    ) -> None:
        self._file, self._values, self._places, self._path = file, values, places, path
        self._known: list[str] = []

    @classmethod
    def read(cls, file: Path) -> Table:
        """The whole of a file. Raises `CommandError`."""
        try:
            text = file.read_text(encoding="utf-8")
        except OSError as error:
            raise CommandError(f"cannot read {file}: {error.strerror or error}: name a TOML file") from None
        except UnicodeDecodeError:
            raise CommandError(f"{file}: it is no UTF-8, as TOML is: save it as that") from None
        try:
            values = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
            at = f":{found[1]}:{found[2]}" if found else ""
            what = re.sub(r"\s*\(at .*\)", "", str(error))
            raise CommandError(f"{file}{at}: no TOML: {what[:1].lower()}{what[1:]}") from None
        return cls(file, values, _places(text))

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def keys(self) -> list[str]:
        """The keys that were not taken yet."""
        return list(self._values)

    def wrong(self, what: str, key: str | None = None) -> CommandError:
        """An error of this table, or of one of its keys."""
        path = self._path if key is None else (*self._path, key)
        said = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")
        line, column = next(
            (self._places[path[:n]] for n in range(len(path), 0, -1) if path[:n] in self._places), (0, 0)
        )
        at = f":{line}:{column}" if line else ""
        return CommandError(f"{self._file}{at}: {said + ': ' if said else ''}{what}")

    def take(self, key: str, default: Any = None) -> Any:
        """A value of any kind."""
        self._known.append(key)
        return self._values.pop(key, default)

    def text(self, key: str, default: str | None = None) -> str | None:
        """A text that is not empty."""
        value = self.take(key, default)
        if value is not None and (not isinstance(value, str) or not value):
            raise self.wrong("must be a text in quotation marks", key)
        return value

    def word(self, key: str, words: Sequence[str], default: str) -> str:
        """The value of a key that is one of several words; false is "off" where that is one of them."""
        value = self.take(key, default)
        if value is False and "off" in words:
            return "off"
        if value not in words:
            raise self.wrong(f"must be one of {', '.join(words)}", key)
        return str(value)

    def words(self, key: str, words: Sequence[str], default: Sequence[str]) -> tuple[str, ...]:
        """Several of several words."""
        value = self.take(key, list(default))
        if not isinstance(value, list) or any(one not in words for one in value) or len(set(value)) < len(value):
            raise self.wrong(f"must be a list of {', '.join(words)}, each once", key)
        return tuple(value)

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts, or one."""
        value = self.take(key, [])
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not all(isinstance(one, str) and one for one in value):
            raise self.wrong("must be a text, or a list of texts", key)
        return tuple(value)

    def switch(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.take(key, default)
        if not isinstance(value, bool):
            raise self.wrong("must be true or false", key)
        return value

    def whole(self, key: str, default: int | None = None, least: int = 0, most: int = 2**31 - 1) -> int | None:
        """A whole number."""
        value = self.take(key, default)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most):
            raise self.wrong(f"must be a whole number from {least} to {most}", key)
        return value

    def number(self, key: str, default: float, above: float | None = None) -> float:
        """A finite number."""
        value = self.take(key, default)
        if not _is_number(value) or (above is not None and value <= above):
            raise self.wrong("must be a number" + ("" if above is None else f" above {above:g}"), key)
        return float(value)

    def numbers(self, key: str, count: int, default: Sequence[float] | None = None) -> tuple[float, ...] | None:
        """A list of so many finite numbers."""
        value = self.take(key, default)
        if value is None:
            return None
        if not isinstance(value, list | tuple) or len(value) != count or not all(map(_is_number, value)):
            raise self.wrong(f"must be a list of {count} numbers", key)
        return tuple(map(float, value))

    def table(self, key: str) -> Table | None:
        """A table inside of this one."""
        value = self.take(key)
        if value is not None and not isinstance(value, dict):
            raise self.wrong(f"must be a table: [{key}]", key)
        return None if value is None else Table(self._file, value, self._places, (*self._path, key))

    def tables(self, key: str) -> list[Table]:
        """An array of tables, or a single one."""
        value = self.take(key, [])
        if isinstance(value, dict):
            return [Table(self._file, value, self._places, (*self._path, key))]
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise self.wrong(f"must be tables: [[{key}]]", key)
        return [Table(self._file, one, self._places, (*self._path, key, i)) for i, one in enumerate(value)]

    def end(self) -> None:
        """Refuses keys that nothing has taken."""
        for key in self._values:
            near = difflib.get_close_matches(key, self._known, n=1)
            hint = f"; did you mean {near[0]}" if near else ""
            raise self.wrong(f"unknown key; there are {', '.join(sorted(set(self._known)))}{hint}", key)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")


def _places(text: str) -> dict[KeyPath, tuple[int, int]]:
    """Lines and columns of headers and keys, from 1. Keys inside of inline tables have none of their own."""
    found: dict[KeyPath, tuple[int, int]] = {}
    counts: dict[KeyPath, int] = {}
    here: KeyPath = ()
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            names: KeyPath = tuple(part.strip(" \"'") for part in header[2].split("."))
            # A table below an array of tables belongs to its last.
            if names[:-1] in counts:
                names = (*names[:-1], counts[names[:-1]] - 1, names[-1])
            here = names
            if header[1]:
                here = (*names, counts.get(names, 0))
                counts[names] = counts.get(names, 0) + 1
            found.setdefault(here, (number, line.index("[") + 1))
        elif key := _KEY.match(line):
            names = tuple(part.strip(" \"'") for part in key[2].split("."))
            found.setdefault((*here, *names), (number, len(key[1]) + 1))
    return found
