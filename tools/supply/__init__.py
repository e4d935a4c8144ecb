# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts that Petzval is built from: the crates of its engine and the packages of its Python environments, with their licences, sources
and known vulnerabilities. Reads Cargo.lock, `cargo metadata`, tools/requirements and advisories.json; needs no network."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
ADVISORIES = Path(__file__).with_name("advisories.json")
REQUIREMENTS = ROOT / "tools/requirements"

#: Licences, by their SPDX identifiers, of code that may be linked into a program under GPL-3.0-or-later
#: (https://www.gnu.org/licenses/license-list.html).
COMPATIBLE = frozenset({
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "GPL-3.0-or-later",
    "ISC", "MIT", "MIT-0", "MPL-2.0", "Unicode-3.0", "Unlicense", "Zlib",
})  # fmt: skip
#: Advisories that are known and borne, each with the reason.
ACCEPTED = {
    "RUSTSEC-2024-0436": "paste is a finished macro crate that runs at compile time alone; exr takes it by way of pulp",
}
#: Names of files that hold a crate's licence.
_LICENCE_FILES = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


@dataclass(frozen=True)
class Crate:
    """A crate that the engine is linked from."""

    name: str
    version: str
    licence: str
    source: str
    authors: str
    folder: Path

    def texts(self) -> dict[str, str]:
        """The licence files of a crate's package, by name."""
        files = sorted(path for path in self.folder.iterdir() if path.is_file() and _LICENCE_FILES.match(path.name))
        return {path.name: path.read_text(encoding="utf-8", errors="replace") for path in files}


def linked_crates(target: str | None = None) -> list[Crate]:
    """The crates of others that are part of the module compiled for a target of Rust, or this machine, sorted by name."""
    if target is None:
        version = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
        target = re.search(r"^host: (\S+)$", version, re.MULTILINE)[1]
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    told = json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout)
    packages = {package["id"]: package for package in told["packages"]}
    edges = {node["id"]: node["deps"] for node in told["resolve"]["nodes"]}
    first = next(key for key, package in packages.items() if package["name"] == "petzval-python")
    seen, waiting = {first}, [first]
    while waiting:
        for edge in edges[waiting.pop()]:
            is_linked = any(kind["kind"] is None for kind in edge["dep_kinds"])
            if is_linked and edge["pkg"] not in seen:
                seen.add(edge["pkg"])
                waiting.append(edge["pkg"])
    found = [packages[key] for key in seen if packages[key]["source"] is not None]
    return sorted(
        (Crate(one["name"], one["version"], one["license"] or "", one["source"], ", ".join(one["authors"]), Path(one["manifest_path"]).parent)
         for one in found), key=lambda crate: (crate.name, crate.version),
    )  # fmt: skip


def is_compatible(licence: str) -> bool:
    """True if a licence expression lets code be linked into Petzval: one of its alternatives, with all of its parts."""
    plain = licence.replace("/", " OR ").replace("(", " ").replace(")", " ")
    # `A AND (B OR C)` has no brackets left: each part of `AND` is one alternative list.
    if " AND " in licence and "(" in licence:
        return all(is_compatible(part) for part in _parts_of_and(licence))
    return any(all(one.strip() in COMPATIBLE for one in way.split(" AND ")) for way in plain.split(" OR "))


def _parts_of_and(licence: str) -> Iterator[str]:
    depth, part = 0, ""
    for word in re.split(r"(\(|\)| AND )", licence):
        depth += (word == "(") - (word == ")")
        if word == " AND " and depth == 0:
            yield part.strip().removeprefix("(").removesuffix(")")
            part = ""
        else:
            part += word
    yield part.strip().removeprefix("(").removesuffix(")")


def sbom(target: str | None = None) -> dict[str, Any]:
    """The bill of materials of the compiled module in the form CycloneDX 1.5 (ECMA-424): every linked crate with its source, licence and
    digest. It names no time and no machine, so that the same sources give the same bytes."""
    digests = locked_crates()
    own = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]
    components = [
        {
            "type": "library",
            "name": crate.name,
            "version": crate.version,
            "purl": f"pkg:cargo/{crate.name}@{crate.version}",
            "bom-ref": f"pkg:cargo/{crate.name}@{crate.version}",
            "licenses": [{"expression": crate.licence.replace("/", " OR ")}],
            "hashes": [{"alg": "SHA-256", "content": digests[crate.name, crate.version]["checksum"]}],
        }
        for crate in linked_crates(target)
    ]
    petzval = {"type": "application", "name": "petzval", "version": own["version"], "bom-ref": "petzval",
               "licenses": [{"expression": own["license"]}]}  # fmt: skip
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": petzval},
        "components": components,
    }


def notices(target: str | None = None) -> str:
    """The licences of all linked crates, as they must accompany the compiled module. Equal texts stand once."""
    owners: dict[str, list[str]] = {}
    rows = []
    for crate in linked_crates(target):
        texts = crate.texts()
        rows.append(
            f"{crate.name} {crate.version}: {crate.licence}"
            + ("" if texts else f" (its package holds no text; by {crate.authors or 'its authors'})")
        )
        for name, text in texts.items():
            owners.setdefault(text.strip(), []).append(f"{crate.name} {crate.version}, {name}")
    parts = ["Petzval's engine is linked from these crates, under these licences:", "\n".join(rows)]
    parts += ["\n".join(["-" * 80, *names, "-" * 80, text]) for text, names in owners.items()]
    return "\n\n".join(parts) + "\n"


def locked_crates() -> dict[tuple[str, str], dict[str, Any]]:
    """All crates of others in Cargo.lock, by name and version."""
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    return {(one["name"], one["version"]): one for one in lock["package"] if "source" in one}


def pinned_packages() -> dict[tuple[str, str], list[Path]]:
    """All pinned Python packages, by name and version, with the lists that name them."""
    found: dict[tuple[str, str], list[Path]] = {}
    for path in sorted(REQUIREMENTS.rglob("*.txt")):
        for name, version in re.findall(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)", path.read_text(), re.MULTILINE):
            found.setdefault((normal(name), version), []).append(path)
    return found


def normal(name: str) -> str:
    """A package's name as indices have it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _numbers(version: str) -> tuple[int, ...]:
    """A version's numbers; a version before a release, as 1.0-rc.1, is less than it."""
    main, _, before = version.partition("-")
    numbers = [int(part) for part in re.findall(r"\d+", main.partition("+")[0])][:4]
    return (*numbers, *[0] * (4 - len(numbers)), -1 if before else 0)


def satisfies(version: str, requirement: str) -> bool:
    """True if a version meets a requirement of the advisories: comparisons with commas between, or `^1.2`."""
    own = _numbers(version)
    for part in requirement.split(","):
        operator, other = re.match(r"\s*(\^|>=|<=|>|<|=)?\s*(\S+)", part).groups()
        limit = _numbers(other)
        if operator == "^":
            first = next((i for i, number in enumerate(limit[:3]) if number), 2)
            good = own >= limit and own[: first + 1] == limit[: first + 1]
        else:
            good = {">=": own >= limit, "<=": own <= limit, ">": own > limit, "<": own < limit}.get(
                operator, own == limit
            )
        if not good:
            return False
    return True


def advisories() -> dict[str, Any]:
    """The vendored data: for "rust" and "python" its source, the packages that were looked up, and their advisories."""
    return json.loads(ADVISORIES.read_text())


def vulnerable() -> list[str]:
    """The advisories that hold for locked packages, each in a line; those of `ACCEPTED` are left out."""
    told, found = advisories(), []
    for name, version in locked_crates():
        for one in _of(told["rust"], name):
            is_fixed = any(satisfies(version, wanted) for wanted in (*one["patched"], *one["unaffected"]))
            if not is_fixed and one["id"] not in ACCEPTED:
                found.append(f"{one['id']}: {name} {version}: {one['title']}")
    for name, version in pinned_packages():
        own = _numbers(version)
        for one in _of(told["python"], name):
            if any(
                _numbers(low or "0") <= own and (high is None or own < _numbers(high)) for low, high in one["affected"]
            ):
                found.append(f"{one['id']}: {name} {version}")
    return found


def not_looked_up() -> list[str]:
    """Crates and packages of which the vendored advisories know nothing, since they were added later."""
    told = advisories()
    crates = {name for name, _ in locked_crates()} - set(told["rust"]["packages"])
    packages = {name for name, _ in pinned_packages()} - set(told["python"]["packages"])
    return sorted(crates | packages)


def _of(told: dict[str, Any], package: str) -> Iterable[dict[str, Any]]:
    return (one for one in told["advisories"] if one["package"] == package)
