# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene whose export is looked at."""

from __future__ import annotations

import pytest


@pytest.fixture
def parts(parts):
    """The helpers of scenes, with a small scene set up."""
    parts.set_up()
    return parts
