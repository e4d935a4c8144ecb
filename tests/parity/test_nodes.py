# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node that the engine knows, with all of its options, against Cycles in the same Blender."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from support import node_cases
from support.node_tiles import Stage

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """All cases, photographed once."""
    import bpy

    import petzval
    from petzval import _native

    bpy.ops.wm.read_factory_settings(use_empty=True)
    graph = importlib.import_module(f"{petzval.load_addon().__name__}.export.graph")
    return Stage(bpy, graph, _native, node_cases.ALL, tmp_path_factory.mktemp("nodes"))


@pytest.mark.parametrize("case", node_cases.ALL, ids=lambda case: case.name)
def test_a_node_gives_what_it_gives_in_cycles(stage, case):
    if case.name in stage.unknown:
        pytest.skip("this Blender does not know the node or option")
    given, reports = stage.given(case)
    expected = stage.expected(case)
    assert not reports
    # Values far from 1 in proportion, values near 0 as if they were 1.
    error = np.abs(given - expected) / np.maximum(1.0, np.abs(expected))
    wrong = (error.max(axis=1) > case.tolerance).mean()
    worst = int(error.max(axis=1).argmax())
    assert wrong <= case.jumps, (
        f"{wrong:.0%} of the points differ; at worst {given[worst]}, in Cycles {expected[worst]}"
    )
