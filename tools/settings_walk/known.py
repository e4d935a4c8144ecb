# SPDX-License-Identifier: GPL-3.0-or-later
"""The content of known.toml: values, contexts, reasons and causes of settings."""

from __future__ import annotations

import fnmatch
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("known.toml")
#: The context of settings that act in the stage as it is.
PLAIN = "stage"


@dataclass(frozen=True)
class Rule:
    """A line of the file that holds for settings by patterns."""

    owner: str
    names: list[str]
    why: str = ""
    but: list[str] = field(default_factory=list)
    never: bool = False

    def is_of(self, owner: str, name: str) -> bool:
        return (
            fnmatch.fnmatchcase(owner, self.owner)
            and not any(fnmatch.fnmatchcase(owner, one) for one in self.but)
            and any(fnmatch.fnmatchcase(name, one) for one in self.names)
        )


class Known:
    """The file, read."""

    def __init__(self, file: Path = FILE) -> None:
        told = tomllib.loads(file.read_text(encoding="utf-8"))
        self.contexts: dict[str, list[list[Any]]] = {PLAIN: [], **told["contexts"]}
        self.values: list[dict[str, Any]] = told["values"]
        self.reasons = [Rule(**row) for row in told["reason"]]
        self.causes = [Rule(**row) for row in told.get("cause", [])]
        self._acts = [(Rule(row["owner"], row["names"]), row["in"]) for row in told["acts"]]

    def acts_in(self, owner: str, name: str) -> list[str]:
        """The contexts in which a setting acts."""
        return next((contexts for rule, contexts in self._acts if rule.is_of(owner, name)), [PLAIN])

    def context(self, name: str, owner: str) -> list[list[Any]]:
        """The settings of a context; `self` is the owner of the setting."""
        return [[owner if one == "self" else one, *rest] for one, *rest in self.contexts[name]]

    def reason(self, owner: str, name: str) -> Rule | None:
        """The reason why the setting changes no picture."""
        return next((rule for rule in self.reasons if rule.is_of(owner, name)), None)

    def cause(self, owner: str, name: str) -> Rule | None:
        """The cause by which the setting changes the pictures of the programs each in its own way."""
        return next((rule for rule in self.causes if rule.is_of(owner, name)), None)
