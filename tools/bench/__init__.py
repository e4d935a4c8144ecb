# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares Petzval with Cycles and Mitsuba on a scene that all of them can render: `make bench`."""

#: Before what a measuring process has to say, among the lines of the program that it runs.
MARK = "BENCH "
