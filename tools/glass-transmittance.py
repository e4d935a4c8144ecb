# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds to lenses/glass/*.json the internal transmittance of the glasses: `through_10mm`, pairs of wavelength in µm and transmittance of 10
mm.

    git clone https://github.com/polyanskiy/refractiveindex.info-database
    python3 tools/glass-transmittance.py refractiveindex.info-database/database/data/glass

The folder holds one of each maker with a .yml a glass; its `tabulated k` is taken from 350 to 800 nm where the glass's formula there is
ours, to the last coefficient. Bouguer's law: exp(-4 pi k t / l). Needs PyYAML.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import yaml

GLASSES = Path(__file__).resolve().parent.parent / "lenses" / "glass"
MAKERS = ("schott", "ohara", "hoya", "hikari", "cdgm", "sumita")
THICKNESS_MM = 10.0
#: The range that a camera can see, and so much beside it that nothing hangs on how the ends go on.
RANGE_UM = (0.35, 0.8)


def through(file: Path, coefficients: list[float]) -> list[list[float]] | None:
    """The transmittance by wavelength; None where the file has none, or is about another melt."""
    blocks = yaml.safe_load(file.read_text(encoding="utf-8"))["DATA"]
    formulas = [[float(word) for word in str(b["coefficients"]).split()] for b in blocks if "coefficients" in b]
    tables = [b["data"] for b in blocks if b["type"] == "tabulated k"]
    if not tables or not any(_same(formula, coefficients) for formula in formulas):
        return None
    rows = [[float(word) for word in line.split()] for line in tables[0].splitlines() if line.strip()]
    points = [
        [um, float(f"{math.exp(-4.0 * math.pi * k * THICKNESS_MM / (um * 1e-3)):.5g}")]
        for um, k in rows
        if RANGE_UM[0] <= um <= RANGE_UM[1]
    ]
    return points or None


def _same(theirs: list[float], ours: list[float]) -> bool:
    """True if two formulas have the same coefficients: formula 2 of the file is our `sellmeier`; others have the same order."""
    return len(theirs) == len(ours) and all(
        math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-15) for a, b in zip(theirs, ours, strict=True)
    )


def main() -> None:
    """Rewrites the files, a line a glass as they have it."""
    folder = Path(sys.argv[1])
    for maker in MAKERS:
        path = GLASSES / f"{maker}.json"
        catalogue = json.loads(path.read_text(encoding="utf-8"))
        known = 0
        for name, glass in catalogue["glasses"].items():
            glass.pop("through_10mm", None)
            file = folder / maker / f"{name.rsplit(':', 1)[-1]}.yml"
            points = through(file, glass["coefficients"]) if file.is_file() else None
            if points:
                glass["through_10mm"] = points
                known += 1
        lines = [
            f"{json.dumps(name)}: {json.dumps(glass, separators=(',', ':'))}"
            for name, glass in catalogue["glasses"].items()
        ]
        head = [f'"{key}": {json.dumps(catalogue[key])},' for key in catalogue if key != "glasses"]
        text = "{\n" + "\n".join(head) + '\n"glasses": {\n' + ",\n".join(lines) + "\n}\n}\n"
        path.write_text(text, encoding="utf-8")
        print(f"{maker}: {known} of {len(catalogue['glasses'])}")


if __name__ == "__main__":
    main()
