# SPDX-License-Identifier: GPL-3.0-or-later
"""`python3 -m supply`, tools/ on the path: `notices OUT` writes the licences of all linked crates, and `sbom OUT` their bill of materials; `advisories RUSTSEC PYPA` takes the
advisories of locked packages from checkouts of the two databases into advisories.json; `lock` adds to tools/requirements the hashes of all
files of the pinned packages, from the package index that pip uses."""

from __future__ import annotations

import argparse
import html
import json
import re
import subprocess
import sys
import tomllib
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from . import ADVISORIES, REQUIREMENTS, locked_crates, normal, notices, pinned_packages, sbom


def main() -> int:
    parser = argparse.ArgumentParser(prog="supply", description="What Petzval is built from.")
    actions = parser.add_subparsers(dest="action", required=True)
    for name in ("notices", "sbom"):
        action = actions.add_parser(name)
        action.add_argument("out", type=Path)
        action.add_argument("--target", help="a target of Rust; default: this machine's")
    take = actions.add_parser("advisories")
    take.add_argument("rustsec", type=Path, help="a checkout of the RustSec advisory database")
    take.add_argument("pypa", type=Path, help="a checkout of the PyPA advisory database")
    actions.add_parser("lock").add_argument("environments", nargs="+", help="as tools/setup-python.sh calls them")
    options = parser.parse_args()
    if options.action == "notices":
        options.out.write_text(notices(options.target), encoding="utf-8")
    elif options.action == "sbom":
        options.out.write_text(json.dumps(sbom(options.target), indent=1) + "\n", encoding="utf-8")
    elif options.action == "lock":
        for name in options.environments:
            lock(name)
    else:
        taken = {"rust": _rust(options.rustsec), "python": _python(options.pypa)}
        ADVISORIES.write_text(_laid_out(taken), encoding="utf-8")
    return 0


# Hashes ----------------------------------------------------------------------------------------------------------


#: Files that some machine takes on which Blender runs: 64-bit Linux with glibc, Windows, macOS; or any.
_MACHINES = re.compile(r"-(any|manylinux\w*_(x86_64|aarch64)|win_amd64|win_arm64|macosx_\w+)(\.|$)")


def lock(environment: str) -> None:
    """Writes locked/ENVIRONMENT.txt: all packages that pip would install now, with the hashes of their wheels. The environment need
    not exist: any other with bpy of the same Python will do."""
    folder = REQUIREMENTS.parent.parent
    own = folder / f".venv-{environment}/bin/python"
    python = own if own.exists() else folder / ".venv-bpy45/bin/python"
    command = [python, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed", "--report", "-"]
    told = json.loads(
        subprocess.run(
            [*command, "-r", REQUIREMENTS / f"{environment}.txt"], capture_output=True, text=True, check=True
        ).stdout
    )
    version = told["environment"]["python_version"].replace(".", "")
    packages = sorted((normal(one["metadata"]["name"]), one["metadata"]["version"]) for one in told["install"])
    # Environments without bpy may be of any Python.
    tags = rf"-(py2\.py3|py3\d*|cp3\d+-abi3|cp{version if environment.startswith('bpy') else '3[0-9]+'})[-.]"
    lines = [
        f"# All packages of the environment, with hashes: PYTHONPATH=tools python3 -m supply lock {environment}",
        "# The list that is written by hand is ../" + f"{environment}.txt.",
    ]
    for name, version in packages:
        hashes = sorted({digest for file, digest in _files(name, version)
                         if file.endswith(".whl") and re.search(tags, file) and _MACHINES.search(file)})  # fmt: skip
        if not hashes:
            raise SystemExit(f"supply: {name} {version}: the index has no wheel of it")
        lines.append(f"{name}=={version} " + " ".join(f"--hash=sha256:{h}" for h in hashes))
    out = REQUIREMENTS / "locked" / f"{environment}.txt"
    out.parent.mkdir(exist_ok=True)
    out.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _files(name: str, version: str) -> Iterator[tuple[str, str]]:
    """Names and SHA-256 digests of the files of a version, from the index that pip uses by itself."""
    from pip._internal.models.index import PyPI

    request = urllib.request.Request(
        f"{PyPI.simple_url}/{normal(name)}/", headers={"Accept": "application/vnd.pypi.simple.v1+json"}
    )
    with urllib.request.urlopen(request) as answer:
        told = json.load(answer)
    for file in told["files"]:
        parts = file["filename"].split("-")
        if len(parts) > 2 and parts[1] == version and "sha256" in file["hashes"]:
            yield html.unescape(file["filename"]), file["hashes"]["sha256"]


# Advisories ------------------------------------------------------------------------------------------------------


def _git(folder: Path, *arguments: str) -> str:
    return subprocess.run(["git", "-C", folder, *arguments], capture_output=True, text=True, check=True).stdout


def _source(folder: Path, name: str) -> str:
    return f"{name}, commit {_git(folder, 'log', '-1', '--format=%h of %cs').strip()}"


def _rust(folder: Path) -> dict[str, Any]:
    names = sorted({name for name, _ in locked_crates()})
    found = []
    for path in _git(folder, "ls-tree", "-r", "--name-only", "HEAD", "crates").split():
        package = path.split("/")[1]
        if package not in names or not path.endswith(".md"):
            continue
        text = _git(folder, "show", f"HEAD:{path}")
        head = tomllib.loads(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1])
        title = re.search(r"^# (.*)$", text, re.MULTILINE)
        if not head["advisory"].get("withdrawn"):
            versions = head.get("versions", {})
            found.append({"id": head["advisory"]["id"], "package": package, "title": title[1] if title else "",
                          "patched": versions.get("patched", []), "unaffected": versions.get("unaffected", [])})  # fmt: skip
    return {"source": _source(folder, "RustSec advisory database (CC0)"), "packages": names, "advisories": found}


def _python(folder: Path) -> dict[str, Any]:
    import yaml

    names = sorted({name for name, _ in pinned_packages()})
    found = []
    for path in _git(folder, "ls-tree", "-r", "--name-only", "HEAD", "vulns").split():
        if normal(path.split("/")[1]) not in names:
            continue
        told = yaml.safe_load(_git(folder, "show", f"HEAD:{path}"))
        for affected in () if told.get("withdrawn") else told["affected"]:
            events = [
                event for one in affected.get("ranges", ()) if one["type"] == "ECOSYSTEM" for event in one["events"]
            ]
            ranges: list[list[str | None]] = []
            for event in events:
                if "introduced" in event:
                    ranges.append([event["introduced"], None])
                elif "fixed" in event:
                    ranges[-1][1] = event["fixed"]
            found.append({"id": told["id"], "package": normal(path.split("/")[1]), "affected": ranges})
    return {"source": _source(folder, "PyPA advisory database (CC-BY 4.0)"), "packages": names, "advisories": found}


def _laid_out(taken: dict[str, dict[str, Any]]) -> str:
    """JSON with a line for each advisory."""
    kinds = []
    for kind, told in taken.items():
        rows = sorted(told["advisories"], key=lambda one: (one["package"], one["id"]))
        lines = ",\n".join("   " + json.dumps(row, ensure_ascii=False) for row in rows)
        kinds.append(f' "{kind}": {{\n  "source": {json.dumps(told["source"])},\n  "packages": {json.dumps(told["packages"])},\n'
                     f'  "advisories": [\n{lines}\n  ]\n }}')  # fmt: skip
    return "{\n" + ",\n".join(kinds) + "\n}\n"


if __name__ == "__main__":
    sys.exit(main())
