"""Pages lead where they say: links, anchors and pictures, as a reader of the repository has them. `make docs` asks the same of the book."""

import subprocess
from pathlib import PurePosixPath
from urllib.parse import unquote, urlsplit

import links
import pytest

from support.places import ROOT

pytestmark = pytest.mark.once

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "lenses").rglob("*.md"))]


def dead(page: PurePosixPath, text: str, read) -> list[str]:
    """The links of a page that lead nowhere; `read` gives the text of a page, "" of another file, None of what is not there."""
    found = []
    for target in links.targets(text):
        parts = urlsplit(target)
        if parts.scheme or parts.netloc:
            continue
        path = links.inside(page.parent, target) if parts.path else page
        there = read(path) if path is not None else None
        if there is None or (parts.fragment and unquote(parts.fragment) not in links.anchors(there)):
            found.append(f"{page}: {target}")
    return found


@pytest.fixture(scope="module")
def tracked() -> set[str]:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a checkout")
    return set(listed.stdout.splitlines())


def test_every_link_leads_somewhere():
    def read(path):
        place = ROOT / path
        if place.suffix == ".md" and place.exists():
            return place.read_text()
        return "" if place.exists() else None

    found = []
    for page in PAGES:
        found += dead(PurePosixPath(page.relative_to(ROOT)), page.read_text(), read)
    assert not found, "\n".join(found)


def test_what_is_linked_is_in_the_repository(tracked):
    """A picture that lies about on one machine alone is none."""
    folders = {str(parent) for path in tracked for parent in PurePosixPath(path).parents}
    missing = set()
    for page in PAGES:
        for target in links.targets(page.read_text()):
            path = links.inside(PurePosixPath(page.relative_to(ROOT)).parent, target)
            if path is not None and str(path) not in tracked and str(path) not in folders:
                missing.add(f"{page.relative_to(ROOT)}: {target}")
    assert not missing, "\n".join(sorted(missing))


def test_every_page_is_in_the_contents_once():
    listed = [target for _, pages in links.chapters((ROOT / "docs/README.md").read_text()) for _, target in pages]
    assert len(listed) == len(set(listed))
    pages = {str(page.relative_to(ROOT / "docs")) for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert {target for target in listed if not target.startswith("..")} == pages - {"README.md"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[a](b.md) [c](b.md#two-words) ![d](e.png) [f](https://elsewhere.example/x.md)", []),
        ("[a](c.md)", ["docs/a.md: c.md"]),
        ("[a](b.md#three)", ["docs/a.md: b.md#three"]),
        ('<img src="f.png">', ["docs/a.md: f.png"]),
        ("```\n[a](c.md)\n```\n`[a](c.md)` [b](../../../b.md)", ["docs/a.md: ../../../b.md"]),
    ],
)
def test_a_dead_link_is_found(text, expected):
    there = {"docs/b.md": "# One\n\n## Two words\n", "docs/e.png": ""}
    assert dead(PurePosixPath("docs/a.md"), text, lambda path: there.get(str(path))) == expected


def test_headings_are_named_as_on_github():
    assert links.anchors("# Blender's `f/1.4` & more\n## Same\n## Same\n<a id='x'></a><a id=\"y.z\"></a>") == {
        "blenders-f14--more",
        "same",
        "same-1",
        "y.z",
    }
