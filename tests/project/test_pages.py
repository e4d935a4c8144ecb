# SPDX-License-Identifier: GPL-3.0-or-later
"""Generated pages say what they were made from (tools/pages), and are listed and made again when that has changed."""

from __future__ import annotations

import re
import subprocess
from datetime import date
from pathlib import Path

import pages
import pytest
from pages.__main__ import again, listing
from pages.history import age, state

from support.places import ROOT

pytestmark = pytest.mark.once

HERE = pages.Made("bench", "0123456789ab", True, "2026-11-24", "Some (R) Model, 2 cores", "43 min")
LENS = pages.Page("docs/lens.md", "lens", ("lenses", ":(exclude)lenses/README.md"))
VIEW = pages.Page("docs/view.md", "view", ("addon",), options=("HOW=all",))
#: A page whose recipe stamps nothing.
IDLE = pages.Page("docs/idle.md", "idle", ("addon",))
MAKEFILE = """
STAMPED = sed -i "s/commit [0-9a-f]*/commit $$(git rev-parse HEAD | cut -c1-12)/"
lens:
\t@echo lens >>ran; $(STAMPED) docs/lens.md docs/twin.md
view:
\t@echo view $(HOW) >>ran; exit 3
idle:
\t@echo idle >>ran
"""


# The pages of docs/ ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", pages.PAGES.values(), ids=pages.PAGES)
def test_a_page_says_where_it_came_from(page):
    made = pages.provenance((ROOT / page.file).read_text(encoding="utf-8"))
    assert made is not None, f"{page.file} does not end with a footer: make {page.target}"
    assert (made.target, made.part) == (page.target, page.part)


@pytest.mark.parametrize("page", pages.PAGES.values(), ids=pages.PAGES)
def test_what_a_page_measures_and_its_target_are_there(page):
    makefile = (ROOT / "Makefile").read_text()
    assert re.search(rf"^{page.target}:", makefile, re.MULTILINE)
    for option in page.options:
        assert f"$({option.partition('=')[0]})" in makefile
    for spec in page.measures:
        if not spec.startswith(":(exclude"):
            assert list(ROOT.glob(spec.removeprefix(":(glob)"))), f"{page.file}: there is no {spec}"


def test_every_page_with_a_footer_is_known():
    pattern = re.compile(r"made by `make ", re.IGNORECASE)
    found = {str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md") if pattern.search(path.read_text())}
    assert found == set(pages.PAGES)


# Footers ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "made",
    [
        HERE,
        HERE._replace(is_changed=False, time="", part="Tables and pictures"),
        HERE._replace(commit="", is_changed=False, machine=pages.UNRECORDED, time="3 s"),
    ],
)
def test_a_footer_is_read_as_it_was_written(made):
    text = pages.stamped("# A page\n\n| a | b |\n|---|---|\n", made)
    assert pages.provenance(text) == made
    # The one before goes.
    assert pages.stamped(text, HERE) == pages.stamped("# A page\n\n| a | b |\n|---|---|\n", HERE)
    assert pages.stamped(text, None) == pages.without_footer(text) == "# A page\n\n| a | b |\n|---|---|\n"


def test_a_footer_is_plain_english_at_the_end():
    text = pages.stamped("Text.\n", HERE)
    assert text == (
        "Text.\n\n---\n\n*Made by `make bench` from commit 0123456789ab with uncommitted changes on 2026-11-24: "
        "Some (R) Model, 2 cores, 43 min.*\n"
    )
    assert pages.provenance(text + "\nMore.\n") is None


# History ---------------------------------------------------------------------------------------------------------


class Repository:
    """A checkout with two folders and pages about them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.git("init", "-q")
        (root / "Makefile").write_text(MAKEFILE)
        self.commit("lenses/a.lens", "One")
        self.commit("addon/a.py", "Two")
        for page in (LENS, VIEW, IDLE):
            self.stamp(page)

    def git(self, *arguments: str) -> str:
        named = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
        return subprocess.run(
            ["git", *named, *arguments], cwd=self.root, capture_output=True, text=True, check=True
        ).stdout

    def commit(self, file: str, subject: str) -> None:
        path = self.root / file
        path.parent.mkdir(exist_ok=True)
        path.write_text(subject)
        self.git("add", file)
        self.git("commit", "-q", "-m", subject)

    def stamp(self, page: pages.Page, file: str | None = None, **changes) -> None:
        path = self.root / (file or page.file)
        path.parent.mkdir(exist_ok=True)
        path.write_text(pages.stamped("# A page\n", pages.made(page, root=self.root)._replace(**changes)))

    def ran(self) -> list[str]:
        return (self.root / "ran").read_text().splitlines() if (self.root / "ran").exists() else []

    def said(self, page: pages.Page) -> list[str]:
        return listing([state(page, self.root)], date.today())


@pytest.fixture
def repository(tmp_path):
    return Repository(tmp_path)


def test_a_page_is_stale_after_a_commit_that_touches_what_it_measures(repository):
    assert repository.said(LENS)[0].endswith("today  up to date")
    repository.commit("addon/a.py", "Elsewhere")
    repository.commit("lenses/README.md", "Left out")
    assert not state(LENS, repository.root).is_stale and state(VIEW, repository.root).is_stale
    for number in range(7):
        repository.commit("lenses/a.lens", f"Lens {number}")
    assert state(LENS, repository.root).is_stale
    first, *commits = repository.said(LENS)
    assert first.endswith("7 commits since touch what it shows")
    assert commits[0].endswith(" Lens 6") and commits[4].endswith(" Lens 2") and commits[5:] == ["    and 2 more"]


def test_uncommitted_changes_are_said(repository):
    assert not pages.made(LENS, root=repository.root).is_changed
    (repository.root / "addon/a.py").write_text("changed")
    assert not pages.made(LENS, root=repository.root).is_changed
    assert pages.made(VIEW, root=repository.root).is_changed
    repository.stamp(VIEW)
    assert " with uncommitted changes " in repository.said(VIEW)[0]


def test_an_unknown_commit_is_named(repository):
    repository.stamp(LENS, commit="0123456789ab")
    assert state(LENS, repository.root).is_stale
    assert "0123456789ab" in repository.said(LENS)[0] and repository.said(LENS)[0].endswith(
        "commit unknown here: remake"
    )
    (repository.root / LENS.file).write_text("# No footer\n")
    assert state(LENS, repository.root).is_stale and repository.said(LENS)[0].endswith("no footer  remake")


def test_a_page_outside_of_a_checkout_has_an_unknown_commit(tmp_path, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    made = pages.made(LENS, root=tmp_path).took(100.0)
    assert made.commit == "" and not made.is_changed and made.time == "2 min"


def test_stale_pages_alone_are_made_again_and_failures_are_reported(repository, capfd):
    repository.stamp(LENS, "docs/twin.md")
    twin = pages.Page("docs/twin.md", "lens", LENS.measures)
    every = (VIEW, IDLE, LENS, twin)
    assert again(every, repository.root) == 0 and repository.ran() == []
    assert "4 of 4 pages were up to date" in capfd.readouterr().out
    repository.commit("lenses/a.lens", "A lens")
    assert again(every, repository.root) == 0
    # Once for both of its pages.
    assert repository.ran() == ["lens"]
    assert not state(LENS, repository.root).is_stale and not state(twin, repository.root).is_stale
    repository.commit("addon/a.py", "A panel")
    repository.commit("lenses/a.lens", "Another")
    capfd.readouterr()
    assert again(every, repository.root) == 1
    assert repository.ran() == ["lens", "view all", "idle", "lens"]
    out = capfd.readouterr().out
    assert "docs/view.md: FAILED with 2" in out and "docs/idle.md: FAILED: it keeps its old footer" in out
    assert "docs/lens.md, docs/twin.md: made again" in out and "0 of 4 pages were up to date" in out


def test_ages_are_in_days():
    today = date(2026, 11, 24)
    assert [age(day, today) for day in ("2026-11-24", "2026-11-23", "2026-11-04")] == ["today", "1 day", "20 days"]
