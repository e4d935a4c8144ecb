# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of report on a lens: its name, its options, its picture."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .table import Table

#: The report that the engine found; of a report of several settings a list of such.
Found = Any
#: The fields that a report shows where none are asked for.
SOME_FIELDS = "0, and 0.7 and all of the design's half field"
ALL_FIELDS = "from 0 to the design's half field"


def _nothing(_parser: argparse.ArgumentParser) -> None:
    """A report without options adds none."""


@dataclass(frozen=True)
class LensReport:
    """A kind of report. `petzval lens NAME` and Blender's Lens Report offer it; the engine has it by the same name."""

    name: str
    #: The report in Blender's menu.
    label: str
    #: The content of the report, for the command's help.
    help: str
    #: Blender's description.
    description: str
    #: The place in menus and in the command's help, from small to large.
    place: int
    size_in: Callable[[Found], tuple[float, float]]
    draw: Callable[[Found, Any], None]
    #: The words above the picture.
    title: Callable[[Found], str]
    #: The report's main numbers; `petzval lens NAME` prints them where no picture is asked for.
    table: Callable[[Found], Table]
    #: True where curves go over the field, false where a few fields are shown.
    is_over_the_field: bool = False
    #: The engine's options where none are given, as in Blender.
    options: Mapping[str, Any] = field(default_factory=dict)
    add_options: Callable[[argparse.ArgumentParser], None] = _nothing
    #: The engine's options that the command's arguments ask for; may end with the parser's usage error.
    options_of: Callable[[argparse.Namespace], Mapping[str, Any]] = lambda _arguments: {}
    #: The report as the command's arguments have it drawn.
    drawn_as: Callable[[argparse.Namespace, LensReport], LensReport] = lambda _arguments, report: report
    #: True where one picture has a curve for each of several f-numbers (`arguments.f_numbers`).
    has_f_numbers: bool = False
    #: Remarks on the result, for the command.
    remarks: Callable[[Found], list[str]] = lambda _found: []

    @property
    def fields(self) -> str:
        """The fields that are shown where none are asked for."""
        return ALL_FIELDS if self.is_over_the_field else SOME_FIELDS


def together(found: Found) -> str:
    """The wavelengths of a report that shows all of them together."""
    return " ".join(f"{nm:.4g}" for nm in found["wavelengths_nm"]) + " nm together"
