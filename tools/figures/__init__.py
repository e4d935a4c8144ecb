# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of Wu et al. 2011, and three that the paper could not make: photographed, measured, and held against exact rays.

A module `figNN_SUBJECT.py` has `FIGURE`, a `figure.Figure`: the pictures to take, and a function that reads its caption from
numbers that are computed, and raises `Contradiction` where a picture contradicts them. `make figures` writes
docs/figures.md; the same at a low resolution is a test (tests/project/test_figures.py).
"""
