# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens prove`: a certificate of the fates of all rays through a lens, and the check of one. Reads arguments, asks the engine or the checker."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from .argument_types import natural, number, part, positive
from .errors import CommandError, writing
from .lens_loading import load, say
from .lens_setting import add_focus, add_setting, setting_of
from .places import find_lens

#: Cells that --check follows by default: some seconds.
_SAMPLE = 300


def add_parser(actions: Any, kinds: str) -> None:
    """Adds `prove` to those of `petzval lens`."""
    prove = actions.add_parser(
        "prove", help="prove of all rays where they pass and where they are stopped", allow_abbrev=False
    )
    prove.add_argument("lens", nargs="?", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    prove.add_argument(
        "--check", metavar="CERT.json", help="check this certificate instead; FILE, if given, must be its lens"
    )
    prove.add_argument(
        "--sample", type=natural, default=_SAMPLE, metavar="N",
        help=f"cells that --check follows itself, chosen by hash; 0: all; default: {_SAMPLE}",
    )  # fmt: skip
    prove.add_argument(
        "--undecided", type=part, default=0.001, metavar="PART",
        help="part of the volume (film x pupil x wavelength) that may be left undecided; default: 0.001",
    )  # fmt: skip
    prove.add_argument(
        "--seconds",
        type=positive,
        default=600.0,
        metavar="S",
        help="end after this time with what is proved; default: 600",
    )
    prove.add_argument("--threads", type=natural, default=0, metavar="N", help="default: one for each processor")
    prove.add_argument(
        "--film-radius", type=positive, metavar="MM", help="of the film's disc; default: half the film's diagonal"
    )
    prove.add_argument(
        "--wavelengths",
        nargs=2,
        type=number,
        default=(380.0, 780.0),
        metavar="NM",
        help="from and to; default: 380 780",
    )
    add_setting(prove)
    add_focus(prove)
    prove.add_argument("-o", "--output", metavar="CERT.json", help="write the certificate")
    prove.set_defaults(run=_prove)


def _prove(arguments: argparse.Namespace) -> int:
    if arguments.check:
        return _check(arguments)
    if not arguments.lens:
        arguments.usage_error("give a lens, or --check CERT.json")
    from . import _native
    from .proof_check.check import file_hash, partition_hash

    lens = load(arguments.lens)
    setting = setting_of(arguments)
    answer = _native.lens_proof_json(
        lens,
        setting,
        {
            "film_radius_mm": arguments.film_radius,
            "focus_distance_mm": arguments.focus_distance,
            "wavelengths_nm": list(arguments.wavelengths),
            "undecided": arguments.undecided,
            "seconds": arguments.seconds,
            "threads": arguments.threads,
        },
    )
    found = json.loads(answer)
    found["lens_sha256"] = file_hash(Path(find_lens(arguments.lens)))
    found["partition_sha256"] = partition_hash(found["columns"])
    if arguments.output:
        from . import atomic_files

        out = Path(arguments.output)
        with writing(out):
            atomic_files.write_text(out, json.dumps(found, separators=(",", ":")) + "\n")
    say(lens.remarks)
    print(_summary(found))
    return 0


def _summary(found: dict[str, Any]) -> str:
    cells = sum(len(column[4]) for column in found["columns"])
    lines = [
        f"{found['name']}: film of radius {found['film_radius_mm']:g} mm, disc of radius {found['disc_radius_mm']:g} mm, "
        f"{found['wavelengths_nm'][0]:g} to {found['wavelengths_nm'][1]:g} nm",
        f"passes     {100 * found['passes']:z8.3f} %",
        f"stopped    {100 * found['stopped']:z8.3f} %",
        *(f"  surface {i:2d} {100 * share:z6.3f} %" for i, share in enumerate(found["stopped_by_surface"]) if share),
        f"undecided  {100 * found['undecided']:z8.3f} %",
        f"{len(found['columns'])} columns, {cells} cells, {found['seconds']:.1f} s",
    ]
    return "\n".join(lines)


def _check(arguments: argparse.Namespace) -> int:
    from .proof_check.check import CheckError, check

    file = Path(arguments.check)
    try:
        certificate = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise CommandError(f"cannot read {file}: {error}: give a certificate of `petzval lens prove -o`") from None
    lens_file = Path(find_lens(arguments.lens)) if arguments.lens else None
    try:
        done = check(certificate, lens_file, arguments.sample or None)
    except (CheckError, KeyError, IndexError, TypeError, ValueError) as error:
        raise CommandError(f"{file} is no proof: {error}") from None
    print(
        f"ok: {certificate['name']}, {done.columns} columns, {done.cells} cells fill all rays; {100 * done.undecided:.3f} % undecided; "
        f"{done.followed} cells followed, {done.followed - done.unconfirmed} confirmed, none contradicted"
    )
    return 0
