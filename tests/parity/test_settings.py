# SPDX-License-Identifier: GPL-3.0-or-later
"""Every setting of Blender's and Cycles' has an answer, and those that show in a picture still show alike: docs/settings.md."""

from __future__ import annotations

from typing import Any

import pytest
from settings_walk import compare, page
from settings_walk.known import Known
from settings_walk.walk import Row, rows, walked

from support.places import ROOT

pytestmark = pytest.mark.once

PAGE = (ROOT / "docs" / "settings.md").read_text(encoding="utf-8")
#: The least change that counts: in a small picture with few samples smaller ones say little.
LEAST = 0.05
#: Samples of a pixel, and of one where those leave a doubt.
SAMPLES = (8, 64, 256)


def all_of(known: Known) -> list[Row]:
    from settings_walk import owners, stage

    stage.build()
    return rows(owners.settings(known.values), known)


def test_every_setting_has_an_answer(blender):
    """On the page, which is measured, or a reason; also those that a newer Blender brings."""
    found, shown = all_of(Known()), page.cells_of(PAGE)
    assert len(found) > 900
    unanswered = [
        f"{row.owner}.{row.name}" for row in found if row.reason is None and (row.owner, row.name) not in shown
    ]
    assert not unanswered, "make settings"
    for (owner, name), (*_, last) in shown.items():
        assert last.startswith(("alike", "apart", "here alone")), (owner, name)
        assert last == "alike" or ": " in last, f"{owner}.{name} has no cause"


def test_rules_are_of_settings_that_there_are(blender):
    """No reason, cause, value or context is left over."""
    known = Known()
    found = all_of(known)
    for rule in known.reasons + known.causes:
        for name in rule.names:
            one = type(rule)(rule.owner, [name], but=rule.but)
            assert any(one.is_of(row.owner, row.name) for row in found), (rule.owner, name)
    used = {context for row in found for context in known.acts_in(row.owner, row.name)}
    assert used == set(known.contexts)
    assert all(known.contexts[context] or context == "stage" for context in used)


def test_what_shows_still_shows_alike(blender):
    """One value of each setting whose change is large, in a small picture with few samples: nothing is ignored or turned round."""
    known, shown = Known(), page.cells_of(PAGE)

    def is_large(row: Row) -> bool:
        cells = shown.get((row.owner, row.name))
        return cells is not None and cells[-1] == "alike" and float(cells[2].removesuffix(" %")) > 100.0 * LEAST

    left = [row for row in all_of(known) if is_large(row)]
    assert len(left) > 50
    for row in left:
        del row.values[1:]
    # What few rare bright paths have parted is parted otherwise by more.
    for samples in SAMPLES:
        for row in left:
            row.found.clear()
        walked(left, known, samples, lambda line: None, looks=1)
        left = [row for row in left if any(is_grossly_apart(one) for one in row.found)]
    assert not left, [(row.owner, row.name, row.worst) for row in left]


def is_grossly_apart(one: dict[str, Any]) -> bool:
    """True if a setting does something else than in Cycles, or nothing in one of both."""
    assert "failed" not in one, one
    apart = compare.Change(**one["apart"])
    return apart.shows and apart.size > 0.5 * max(one["cycles"]["size"], one["here"]["size"])
