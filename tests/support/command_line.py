# SPDX-License-Identifier: GPL-3.0-or-later
"""Answers and complaints of the command line, and the reference lenses that it is asked about."""

from __future__ import annotations

import json

from support.places import REFERENCE

LENSES = sorted((REFERENCE / "lenses").glob("*.lens"))
LINES_NM = {"F": 486.1327, "d": 587.5618, "C": 656.2725}

# What the contract promises of the whole command: the reference to twelve digits.
RELATIVE = 1e-12

GOOD_LENS = """\
# name: Two lenses and a stop
#radius thickness glass diameter conic isstop
50 4 1.5168/64.17 20 0 0
-50 5 air 20 0 0
0 5 air 10 0 1
0 90 air 20 0 0
"""


def answer(done):
    """The one JSON object of a command that must have gone well."""
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def assert_complains(done, *words, status=1):
    """One line on stderr, in the one form, with these words; nothing on stdout."""
    assert done.returncode == status, (done.stdout, done.stderr)
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("petzval: ")
    for word in words:
        assert word in lines[0], lines[0]
