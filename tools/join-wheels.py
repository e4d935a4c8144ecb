#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one wheel of several that differ in their compiled module: join-wheels.py FOLDER LEVEL...

FOLDER/LEVEL/ holds the wheel compiled for that level of processor. The one that comes out, in FOLDER, has the modules as
`petzval/_engines/LEVEL/_native.abi3.so` (on Windows `_native.pyd`) and all else from the first.
"""

import base64
import csv
import hashlib
import io
import sys
import zipfile
from pathlib import Path

MODULES = ("petzval/_native.abi3.so", "petzval/_native.pyd")
ENGINES = "petzval/_engines/"


def record_row(name: str, data: bytes) -> list[str]:
    """A file's row in RECORD."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return [name, f"sha256={digest}", str(len(data))]


def module_of(wheel: Path, level: str) -> tuple[zipfile.ZipInfo, bytes]:
    """The compiled module under its new name."""
    with zipfile.ZipFile(wheel) as archive:
        (module,) = (name for name in MODULES if name in archive.namelist())
        info, data = archive.getinfo(module), archive.read(module)
    info.filename = f"{ENGINES}{level}/{Path(module).name}"
    return info, data


def join(folder: Path, levels: list[str]) -> Path:
    wheels = []
    for level in levels:
        (wheel,) = (folder / level).glob("petzval-*.whl")
        wheels.append(wheel)
    if len({wheel.name for wheel in wheels}) != 1:
        sys.exit(f"petzval: wheels of different names: {', '.join(map(str, wheels))}: build them all again")
    joined = folder / wheels[0].name
    modules = [module_of(wheel, level) for wheel, level in zip(wheels, levels, strict=True)]
    with zipfile.ZipFile(wheels[0]) as source, zipfile.ZipFile(joined, "w") as target:
        record = None
        rows = []
        # The modules stand where the one stood: RECORD comes last, as wheels have it. What an earlier build may have
        # left in the package is none of this wheel's.
        for info in source.infolist():
            if info.filename.endswith(".dist-info/RECORD"):
                record = info
            elif info.filename in MODULES or not info.filename.startswith(ENGINES):
                files = modules if info.filename in MODULES else [(info, source.read(info))]
                for one, data in files:
                    target.writestr(one, data, zipfile.ZIP_DEFLATED)
                    rows.append(record_row(one.filename, data))
        if record is None:
            sys.exit(f"petzval: {wheels[0]} has no RECORD: build it again")
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([*rows, [record.filename, "", ""]])
        target.writestr(record, text.getvalue(), zipfile.ZIP_DEFLATED)
    return joined


if __name__ == "__main__":
    join(Path(sys.argv[1]), sys.argv[2:])
