#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The index of the lens library: docs/lenses.md with a drawing of each lens, and the table in lenses/README.md.

Run by `make lens-index` in an environment that has petzval and matplotlib. `--check` writes nothing and ends with 1 where the texts are
not those of the lenses as they are, or a drawing is missing; `--no-drawings` writes the texts alone.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pages

from petzval import lens_library as texts

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/lenses.md"
DRAWINGS = ROOT / "docs/images/lenses"
README = ROOT / "lenses/README.md"
BEGIN, END = "<!-- table of tools/lens_index.py -->", "<!-- end of the table -->"
#: The largest size of a drawing, bytes: enough for a page.
LARGEST_DRAWING = 60_000

HEAD = """# The lens library

{count} lenses come with Petzval, in [`lenses/`](../lenses/README.md). `petzval lens list` prints them, the arrow beside *Lens File* in
the camera's panel chooses one; [the format](lens-file.md) holds those of your own.

Each was typed from its source and is held against it: where the source states focal length, f-number or back focus, the surfaces give
them, to half of a unit of the last digit, or the table below says why not. Tests ask for that of every lens, and for light at the
centre, at 0.7 of the field and at its edge, focused far and near. The {first} of the first choice pass at least a tenth of the light
of the axis into every corner of their film, at every zoom and distance.

Numbers are those at the d line, 587.6 nm, wide open; of a zoom in the first position of its table. The f-number is that of the
diaphragm, or where a rim is narrower, that of the beam which comes through. Drawings show rays from the axis, 0.7 of the half field and
the half field.
"""


def petzval(*arguments: str) -> str:
    """The output of the command."""
    command = [sys.executable, "-m", "petzval", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"lens-index: petzval {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def cell(text: str) -> str:
    return text.replace("|", "\\|")


def by_group(found: dict[str, Any]) -> list[tuple[str, list[dict[str, Any]]]]:
    lenses = found["lenses"]
    pairs = [(group, [entry for entry in lenses if entry["group"] == group]) for group in found["groups"]]
    return [(group, members) for group, members in pairs if members]


def table(entries: list[dict[str, Any]], link) -> list[str]:
    lines = ["| lens | focal length, mm | f-number | field | film, mm |", "|---|---:|---:|---:|---|"]
    for entry in entries:
        facts = [texts.focal_text(entry), texts.f_number_text(entry), texts.field_text(entry), texts.film_text(entry)]
        lines.append(f"| {link(entry)} | " + " | ".join(facts) + " |")
    return lines


WORDS = {
    "focal_length": "focal length, mm",
    "zoom": "focal length, mm",
    "f_number": "f-number",
    "back_focus": "back focus, mm",
}


def section(entry: dict[str, Any]) -> list[str]:
    """The section of one lens."""
    star = " ★" if entry["is_first_choice"] else ""
    lines = [f"### {entry['name']}{star}", "", f'<a id="{entry["id"]}"></a>']
    lines += [f"![{cell(entry['name'])}](images/lenses/{entry['id']}.svg)", ""]
    facts = [f"`{entry['id']}`", entry["design"] or "", f"field {texts.field_text(entry)}°"]
    if entry["film_mm"]:
        facts.append(f"film {texts.film_text(entry)} mm")
    if entry["focuses_inside"]:
        facts.append("focuses by groups inside")
    lines += [", ".join(fact for fact in facts if fact) + f". Source: {entry['source']}.", ""]
    lines += ["| | published | computed | |", "|---|---:|---:|---|"]
    for row in entry["published"]:
        said = row["text"] if row["text"] is not None else "not published"
        why = f"differs: {row['why']}" if row["why"] else "agrees" if row["agrees"] else ""
        lines.append(f"| {WORDS[row['key']]} | {said} | {texts.number(row['computed'])} | {cell(why)} |")
    if entry["notes"]:
        lines += ["", entry["notes"]]
    return [*lines, ""]


def page(found: dict[str, Any]) -> str:
    """The text of docs/lenses.md."""
    lenses = found["lenses"]
    first = [entry for entry in lenses if entry["is_first_choice"]]

    def link(entry: dict[str, Any]) -> str:
        return f"[{cell(entry['name'])}](#{entry['id']})"

    lines = [HEAD.format(count=len(lenses), first=len(first)), "## First choice", "", *table(first, link), ""]
    for group, members in by_group(found):
        lines += [f"## {group.capitalize()}", "", *table(members, link), ""]
        for entry in members:
            lines += section(entry)
    return "\n".join(lines).rstrip() + "\n"


def readme(found: dict[str, Any], before: str) -> str:
    """lenses/README.md with the table of today."""

    def link(entry: dict[str, Any]) -> str:
        star = " ★" if entry["is_first_choice"] else ""
        return f"[`{entry['id']}`]({entry['id']}.lens) {cell(entry['name'])}{star}"

    lines = [BEGIN, ""]
    for group, members in by_group(found):
        lines += [f"**{group.capitalize()}**", "", *table(members, link), ""]
    head, _, rest = before.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return head + "\n".join(lines) + END + tail


def compact(svg: str) -> str:
    """The drawing in fewer bytes: places to a tenth of a point, nothing about the program."""
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<!DOCTYPE[^>]*>\s*", "", svg)

    def places(match: re.Match[str]) -> str:
        data = re.sub(r"-?\d+\.\d+", lambda place: f"{float(place[0]):.1f}".removesuffix(".0"), match[2])
        data = " ".join(data.split())
        # After a move, places without a letter are joined by lines.
        return f'{match[1]}"{data if re.search("[CQ]", data) else data.replace(" L ", " ")}"'

    svg = re.sub(r'(\bd=)"([^"]*)"', places, svg)
    return "\n".join(line.strip() for line in svg.splitlines()) + "\n"


def draw(found: dict[str, Any]) -> None:
    """All drawings; those of lenses that are gone are removed."""
    DRAWINGS.mkdir(parents=True, exist_ok=True)
    names = {f"{entry['id']}.svg" for entry in found["lenses"]}
    for old in DRAWINGS.glob("*.svg"):
        if old.name not in names:
            old.unlink()
    for entry in found["lenses"]:
        out = DRAWINGS / f"{entry['id']}.svg"
        petzval("lens", "draw", entry["id"], "-o", str(out))
        out.write_text(compact(out.read_text(encoding="utf-8")), encoding="utf-8")
        if out.stat().st_size > LARGEST_DRAWING:
            raise SystemExit(f"lens-index: {out} has {out.stat().st_size} bytes")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--no-drawings", action="store_true")
    arguments = parser.parse_args()
    began = time.monotonic()
    found = json.loads(petzval("lens", "list", "--json"))
    texts = {PAGE: page(found), README: readme(found, README.read_text(encoding="utf-8"))}
    if arguments.check:
        wrong = [path for path, text in texts.items() if not path.exists() or _read(path) != text]
        drawings = {path.stem for path in DRAWINGS.glob("*.svg") if path.stat().st_size <= LARGEST_DRAWING}
        missing = {entry["id"] for entry in found["lenses"]} ^ drawings
        for path in wrong:
            print(f"lens-index: {path.relative_to(ROOT)} is not of today: make lens-index")
        for name in sorted(missing):
            print(f"lens-index: {name}: drawing and lens do not stand side by side: make lens-index")
        return 1 if wrong or missing else 0
    name = str(PAGE.relative_to(ROOT))
    if arguments.no_drawings:
        origin = pages.kept(name)
    else:
        origin = pages.made(name)
        draw(found)
        origin = origin.took(time.monotonic() - began)
    # The wheel holds it, and is built anew for each newer file.
    if README.read_text(encoding="utf-8") != texts[README]:
        README.write_text(texts[README], encoding="utf-8")
    PAGE.write_text(pages.stamped(texts[PAGE], origin), encoding="utf-8")
    return 0


def _read(path: Path) -> str:
    """A page as the lenses have it, without the footer that says when it was made."""
    return pages.without_footer(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    sys.exit(main())
