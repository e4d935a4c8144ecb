# SPDX-License-Identifier: GPL-3.0-or-later
"""The reports on a lens, in the order of menus and of the command's help."""

from __future__ import annotations

import importlib
import json
import pkgutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..description import LensReportSettings, LensSettings
from .report import Found, LensReport


def _reports() -> Iterator[LensReport]:
    """The report of each module beside this one that has one."""
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        if module.name != Path(__file__).stem:
            report = getattr(importlib.import_module(f"{__package__}.{module.name}"), "REPORT", None)
            if report is not None:
                yield report


REPORTS: tuple[LensReport, ...] = tuple(sorted(_reports(), key=lambda report: report.place))


def find(
    report: LensReport,
    lens: Any,
    lens_settings: LensSettings,
    settings: LensReportSettings,
    options: Mapping[str, Any] | None = None,
) -> Found:
    """The engine's answer; `options` of the report, else its own. Raises `PetzvalError`."""
    from .. import _native

    asked = dict(report.options if options is None else options)
    return json.loads(_native.lens_report_json(report.name, lens, lens_settings, settings, asked))
