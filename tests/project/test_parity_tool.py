# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of two pictures by `make parity`: the differences of blocks, and the part of them by noise."""

from __future__ import annotations

import numpy as np
from parity.blocks import PASS, PICTURE, block_noise, block_ratios, floor_of


def test_a_block_that_is_off_is_found():
    theirs = np.full((24, 32, 3), 0.5)
    ours = theirs.copy()
    ours[8:16, 24:32, 1] *= 1.03
    ratios = block_ratios(ours, theirs)
    assert ratios.shape == (3, 4, 3)
    assert abs(ratios[1, 3, 1] - 1.03) < 1e-12
    ratios[1, 3, 1] = 1.0
    assert np.abs(ratios - 1.0).max() < 1e-12


def test_what_is_dark_or_negative_is_compared_with_the_mean():
    theirs = np.zeros((24, 32, 1))
    theirs[:8] = 3.0
    ours = theirs.copy()
    ours[16:] = 0.01
    # Of a mean of 1: a hundredth, and as much as is there at least.
    assert abs(block_ratios(ours, theirs, PASS).max() - 1.01) < 1e-12
    assert abs(block_ratios(ours, theirs, PICTURE).max() - 2.0) < 1e-12
    # A vector's sign is none of the difference's.
    assert np.abs(block_ratios(-ours, -theirs, PASS) - 1.0).max() < 0.011
    assert floor_of("picture") == floor_of("frame 8") == PICTURE
    assert floor_of("Normal") == floor_of("Combined_Key") == PASS


def test_noise_of_blocks_is_what_seeds_make_of_it():
    """Of unlike noise in both programs: what the estimate says, is what blocks of means of the halves are apart."""
    dice = np.random.default_rng(5)
    found, said = [], []
    for _ in range(40):
        ours, theirs = ([1.0 + size * dice.normal(size=(24, 32, 3)) for _ in range(2)] for size in (0.3, 0.1))
        found.append(np.abs(block_ratios(sum(ours) / 2, sum(theirs) / 2) - 1.0).max())
        said.append(block_noise(ours, theirs))
    # The worst of 36 normal numbers, and of as many lengths of a pair of them, which are a little longer.
    assert 0.9 < np.mean(said) / np.mean(found) < 1.4
