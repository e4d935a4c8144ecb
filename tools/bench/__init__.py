# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares Petzval with Cycles and Mitsuba on a scene that all of them can render: `make bench`."""

#: The mark before the answer of a measuring process, among the lines of the program that it runs.
MARK = "BENCH "
