"""The hook of `make docs`, beside MkDocs' own work: the chapters from docs/README.md, pages of the sources that chapters link to, formulas
as MathML, and a look at every link of the finished pages. docs/ itself is written for a reader of the repository."""

import html
import logging
import re
import sys
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

sys.path.insert(0, str(Path(__file__).parent))
from links import HTML_LINK, LINK, chapters, each_line, inside  # noqa: E402  (a hook is no module of a package)

ROOT = Path(__file__).resolve().parents[2]
DOCS = PurePosixPath("docs")
LOG = logging.getLogger("mkdocs.hooks.book")
LANGUAGES = {".rs": "rust", ".py": "python", ".toml": "toml", ".sh": "sh", ".json": "json", ".lens": "text"}


def on_config(config):
    """The table of contents is that of docs/README.md."""
    parts = chapters((ROOT / DOCS / "README.md").read_text())
    config.nav = [{"Contents": "README.md"}] + [
        {part: [{title: page_of(PurePosixPath("docs") / target, DOCS) for title, target in pages}]}
        for part, pages in parts
        if pages
    ]
    for entry in config.nav[1:]:
        for part, pages in entry.items():
            entry[part] = [{title: page} for title, page in pages[0].items()]
    return config


def on_files(files, config):
    """A page for each file of the repository that a page links to, and that lies outside of docs/."""
    waiting = [(DOCS / file.src_uri, file.content_string) for file in files.documentation_pages()]
    while waiting:
        place, text = waiting.pop()
        for path in outside(text, place.parent):
            uri = page_of(path, DOCS)
            if files.get_file_from_path(uri) is None:
                content = source_page(path)
                files.append(File.generated(config, uri, content=content))
                if path.suffix == ".md":
                    waiting.append((path, content))
    return files


def on_page_markdown(markdown, page, **_):
    """Links that leave docs/ go to the pages made for them."""
    uri = PurePosixPath(page.file.src_uri)
    place = DOCS / uri if uri.parts[0] != "source" else PurePosixPath(*uri.parts[1:])

    def change(line):
        # A comment on a line of its own marks a table that a tool writes; Markdown in Python would take the table for HTML.
        return f"\n{line}\n" if line.startswith("<!--") and line.endswith("-->") else rewritten(line, place.parent, uri)

    return each_line(markdown, change)


def on_page_content(content, **_):
    """Formulas as MathML, which browsers draw by themselves."""

    def formula(found):
        tex, display = html.unescape(found["tex"]), found["open"] == "\\["
        return convert(tex[2:-2], display="block" if display else "inline")

    return re.sub(
        r'<(?P<tag>span|div) class="arithmatex">(?P<tex>(?P<open>\\[(\[]).*?)</(?P=tag)>', formula, content, flags=re.S
    )


def on_post_build(config):
    """Every link and picture of every page leads somewhere, those in raw HTML too."""
    site = Path(config.site_dir)
    for name in ("404.html", "sitemap.xml", "sitemap.xml.gz"):  # of a server
        (site / name).unlink(missing_ok=True)
    pages = {path: Links.of(path) for path in site.rglob("*.html")}
    dead, elsewhere = [], set()
    for path, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                elsewhere.add(target)
                continue
            aim = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            aim = aim / "index.html" if aim.is_dir() else aim
            if not aim.exists() or (
                parts.fragment and aim in pages and unquote(parts.fragment) not in pages[aim].names
            ):
                dead.append(f"{path.relative_to(site)}: {target}")
    (site / "external-links.txt").write_text("".join(f"{link}\n" for link in sorted(elsewhere)))
    LOG.info("%d pages; %d links to elsewhere, not looked at, in external-links.txt", len(pages), len(elsewhere))
    if dead:
        raise PluginError("links that lead nowhere:\n" + "\n".join(sorted(dead)))


def page_of(path, docs):
    """The page of the book, from its root, for a file or folder of the repository."""
    path = PurePosixPath(*normal(path))
    if path.is_relative_to(docs):
        return (
            "README.md"
            if (ROOT / path).is_dir() and not (ROOT / path / "README.md").exists()
            else str(path.relative_to(docs))
        )
    if (ROOT / path).is_dir():
        return f"source/{path}/README.md"
    return f"source/{path}" if path.suffix == ".md" else f"source/{path}.md"


def outside(text, folder):
    """The files and folders outside of docs/ that a page in `folder` links to; missing ones are left for the builder to find."""
    found = []

    def note(line):
        for pattern in (LINK, HTML_LINK):
            for match in pattern.finditer(line):
                path = inside(folder, match["target"])
                if path and not path.is_relative_to(DOCS) and (ROOT / path).exists():
                    found.append(path)
        return line

    each_line(text, note)
    return found


def rewritten(line, folder, uri):
    def other(match):
        path = inside(folder, match["target"])
        if path is None or not (ROOT / path).exists():
            return match[0]
        fragment = urlsplit(match["target"]).fragment
        target = relative(page_of(path, DOCS), uri.parent) + (f"#{fragment}" if fragment else "")
        return match[0].replace(match["target"], target)

    return HTML_LINK.sub(other, LINK.sub(other, line))


def source_page(path):
    """The text of a file or a folder's list as a page."""
    where = ROOT / path
    if where.is_dir():
        if (where / "README.md").exists():
            return (where / "README.md").read_text()
        rows = sorted(
            entry.name + "/" * entry.is_dir() for entry in where.iterdir() if not entry.name.startswith((".", "__"))
        )
        return f"# {path}\n\n" + "".join(f"- `{row}`\n" for row in rows)
    text = where.read_text()
    if path.suffix == ".md":
        return text
    language = LANGUAGES.get(path.suffix, "text")
    return f"---\nsearch:\n  exclude: true\n---\n# {path}\n\n~~~~~~~~{language}\n{text}\n~~~~~~~~\n"


def relative(target, folder):
    up = [part for part in folder.parts if part]
    parts = target.split("/")
    while up and len(parts) > 1 and up[0] == parts[0]:
        up, parts = up[1:], parts[1:]
    return "../" * len(up) + "/".join(parts)


def normal(path):
    parts = []
    for part in path.parts:
        if part == ".." and parts:
            parts.pop()
        elif part != ".":
            parts.append(part)
    return parts


class Links(HTMLParser):
    """The links of a page, and the names in it that links may point to."""

    def __init__(self):
        super().__init__()
        self.targets, self.names = set(), {""}

    @classmethod
    def of(cls, path):
        page = cls()
        page.feed(path.read_text())
        return page

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.names.add(value)
            if name in ("href", "src") and value and not value.startswith(("data:", "javascript:")):
                self.targets.add(value)
