# SPDX-License-Identifier: GPL-3.0-or-later
"""The reports on a lens, in the order of menus and of the command's help."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ..description import LensReportSettings, LensSettings
from . import distortion, fans, illumination, mtf, psf, spots, transmission
from .report import Found, LensReport

REPORTS: tuple[LensReport, ...] = (
    spots.REPORT,
    fans.REPORT,
    mtf.REPORT,
    psf.REPORT,
    distortion.REPORT,
    illumination.REPORT,
    transmission.REPORT,
)


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
