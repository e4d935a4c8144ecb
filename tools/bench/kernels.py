# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's own kernels, as criterion measures them."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

from .programs import Failed

#: Groups of benches, and the command that runs each.
GROUPS = {
    "tree": "cargo bench -p petzval-benches --bench tree",
    "camera sample": "cargo bench -p petzval-benches --bench camera",
}


def run(top: Path) -> None:
    """Measures them anew, so that they are of the same commit as the rest of the page."""
    for command in GROUPS.values():
        if subprocess.run(command.split(), cwd=top, check=False).returncode:
            raise Failed(f"{command} failed: see above")


def read(top: Path) -> dict[str, dict[str, float]]:
    """Nanoseconds an element, by group and name (the whole, where a bench has no count)."""
    folder = Path(os.environ.get("CARGO_TARGET_DIR", top / "target")) / "criterion"
    found: dict[str, dict[str, float]] = {}
    for about in sorted(folder.glob("**/new/benchmark.json")):
        bench = json.loads(about.read_text())
        if bench["group_id"] in GROUPS:
            middle = json.loads((about.parent / "estimates.json").read_text())["median"]["point_estimate"]
            count = (bench.get("throughput") or {}).get("Elements", 1)
            name = "/".join(part for part in (bench["function_id"], bench["value_str"]) if part)
            found.setdefault(bench["group_id"], {})[name] = middle / count
    return found
