"""Links in pages of the repository, as a reader of the files has them. Used by the book's builder and by tests/project/test_docs.py."""

import re
from pathlib import PurePosixPath
from urllib.parse import unquote, urlsplit

LINK = re.compile(r"\]\((?P<target>[^()\s]*(?:\([^()\s]*\)[^()\s]*)*)\)")
HTML_LINK = re.compile(r'(?:href|src)="(?P<target>[^"]*)"')
HEADING = re.compile(r"^#{1,6} +(?P<title>.*?) *#*$")
FENCE = re.compile(r"^ *(?P<fence>`{3,}|~{3,})")


def each_line(text, change):
    """The text with each line outside of code blocks changed."""
    fence, lines = None, []
    for line in text.split("\n"):
        found = FENCE.match(line)
        if found and fence is None:
            fence = found["fence"]
        elif found and fence[0] == found["fence"][0] and len(found["fence"]) >= len(fence):
            fence = None
        elif fence is None:
            line = change(line)
        lines.append(line)
    return "\n".join(lines)


def inside(folder, target):
    """The file or folder of the repository that a link in `folder` names; None: elsewhere, or within the page."""
    parts = urlsplit(target)
    if parts.scheme or parts.netloc or not parts.path:
        return None
    place = []
    for part in (folder / unquote(parts.path)).parts:
        if part == "..":
            if not place:
                return None
            place.pop()
        elif part != ".":
            place.append(part)
    return PurePosixPath(*place)


def targets(text):
    """All that a page links to, in Markdown and in raw HTML."""
    found = []

    def note(line):
        line = re.sub(r"`[^`]*`", "", line)
        found.extend(match["target"] for pattern in (LINK, HTML_LINK) for match in pattern.finditer(line))
        return line

    each_line(text, note)
    return found


def anchors(text):
    """The anchors of a page: its headings as GitHub names them, and its ids."""
    names, seen = set(), {}

    def note(line):
        names.update(re.findall(r'id="([^"]*)"', line))
        found = HEADING.match(line)
        if found:
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", found["title"]).replace("`", "").replace("*", "")
            name = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
            count = seen[name] = seen.get(name, -1) + 1
            names.add(f"{name}-{count}" if count else name)
        return line

    each_line(text, note)
    return names


def chapters(contents):
    """The parts of the book, and each one's pages as (title, target), from the lists of docs/README.md."""
    parts = []
    for line in contents.splitlines():
        heading, item = re.match(r"## (.*)", line), re.match(r"- \[([^\]]*)\]\(([^)]*)\)", line)
        if heading:
            parts.append((heading[1], []))
        elif item and parts:
            parts[-1][1].append((item[1], item[2]))
    return parts
