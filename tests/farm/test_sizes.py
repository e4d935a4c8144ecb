# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes of parts."""

from __future__ import annotations

import pytest

from petzval.farm.sizes import cut, slots_of


@pytest.mark.once
@pytest.mark.parametrize("tiles", [1, 6, 15, 240, 2040])
def test_all_slots_are_shared_out_and_the_last_are_few(tiles):
    for parts in (1, 2, 7, 64):
        if parts > tiles:
            continue
        slots = slots_of(tiles, parts)
        pieces = cut(slots, parts)
        assert slots <= tiles
        assert [begin for begin, _ in pieces] == [0, *(end for _, end in pieces[:-1])] and pieces[-1][1] == slots
        lengths = [end - begin for begin, end in pieces]
        assert min(lengths) >= 1
        # Steps between whole numbers: one may be off.
        assert all(lengths[i] + 1 >= lengths[i + 1] for i in range(parts - 1))
        if parts > 1 and slots == 8 * parts:
            assert 2.0 <= lengths[0] / lengths[-1] <= 4.0
