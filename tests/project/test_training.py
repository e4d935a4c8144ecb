# SPDX-License-Identifier: GPL-3.0-or-later
"""The work by whose profile the release wheel is laid out: `make wheels` does it, `make test` sees that it can be asked for."""

from __future__ import annotations

import pytest

pytest.importorskip("bpy")
import train_engine

pytestmark = pytest.mark.once


@pytest.mark.parametrize("options", train_engine.RENDERS)
def test_renders_are_asked_for_in_words_of_the_command_line(options, tmp_path):
    assert train_engine.options_of_render(options, tmp_path / "demo.exr")["scene"]


def test_every_lens_report_is_part_of_it():
    from petzval.lens_reports.registry import REPORTS

    assert {report.name for report in REPORTS} <= {*train_engine.REPORTS, "tolerance"}
