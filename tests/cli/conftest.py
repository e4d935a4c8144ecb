# SPDX-License-Identifier: GPL-3.0-or-later
"""A lens file that commands are tried on."""

from __future__ import annotations

import pytest

from support.command_line import GOOD_LENS


@pytest.fixture
def good_lens(tmp_path):
    """The path of a lens file without a fault."""
    path = tmp_path / "good.lens"
    path.write_text(GOOD_LENS)
    return path
