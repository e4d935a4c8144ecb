# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that several files photograph by both programs; each fixture gives the helpers of scenes."""

from __future__ import annotations

import pytest


@pytest.fixture
def stage(blender):
    """A smooth ball seen from the side, in a sky of many colours."""
    from support import ball_in_sky

    return ball_in_sky.set_up(blender)


@pytest.fixture
def room(blender):
    """A floor and three balls in a row: matte, rough metal and glass; a lamp above, and a dim sky."""
    from support import ball_row

    return ball_row.set_up(blender)


@pytest.fixture
def studio(blender):
    """A matte floor, a wall and a ball, in a dim sky."""
    from support import lamp_studio

    return lamp_studio.set_up(blender)
