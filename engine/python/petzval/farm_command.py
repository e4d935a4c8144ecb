# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm plan|part|merge|status|run`: one picture on many machines. Reads arguments; the package `farm` does the work."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from . import argument_types as types
from .farm.engines import ENGINES


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `farm` with its actions."""
    farm = subparsers.add_parser("farm", help="one picture on many machines", allow_abbrev=False)
    actions = farm.add_subparsers(dest="action", metavar="ACTION", required=True)
    _add_plan(actions)
    p = _with_job(actions.add_parser("part", help="render parts of a job", allow_abbrev=False))
    p.add_argument("parts", type=types.natural, nargs="+", metavar="K", help="their numbers, from 0")
    p.add_argument("--again", action="store_true", help="also where it is finished")
    p.add_argument("--checkpoint-every", type=types.positive, metavar="S", help="seconds; default: 8, and the writing")
    _add_machine(p)
    p = _with_job(
        actions.add_parser(
            "merge", help="join the parts that are there, name those that are missing", allow_abbrev=False
        )
    )
    p.add_argument("--again", action="store_true", help="also where the pictures are made of just these parts")
    p.add_argument("--json", action="store_true", help="one JSON object on stdout")
    _add_machine(p)
    p = _with_job(actions.add_parser("status", help="name the parts that are missing", allow_abbrev=False))
    p.add_argument("--json", action="store_true", help="one JSON object on stdout")
    p = _with_job(actions.add_parser("run", help="render all parts and merge them", allow_abbrev=False))
    where = p.add_mutually_exclusive_group(required=True)
    where.add_argument("--local", type=types.count, metavar="N", help="in N processes of this machine")
    where.add_argument("--dask", metavar="ADDRESS", help="on the workers of a Dask cluster")
    _add_machine(p)


def _add_plan(actions: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    from . import render_command, scene_options

    p = actions.add_parser(
        "plan",
        help="make a job of a scene",
        description="Packs a .blend with everything that it reads into a folder, parted so that any machine can render any part.",
        allow_abbrev=False,
    )
    scene_options.add(p)
    render_command.add_options(p)
    render_command.add_frames(p)
    p.add_argument("--parts", type=types.count, default=8, metavar="N", help="of each picture; default: 8")
    p.add_argument("-o", "--output", required=True, metavar="JOB", help="the job's folder, a new one")
    p.add_argument("--picture", metavar="NAME.exr|png", help="the picture's name; default: SCENE.exr")
    p.add_argument(
        "--for",
        dest="engines",
        action="append",
        default=[],
        choices=tuple(ENGINES),
        help="write the files of a scheduler, too; may be repeated. "
        + "; ".join(f"{k}: {v}" for k, v in ENGINES.items()),
    )
    p.add_argument(
        "--processor", choices=("v2", "v3"), help="the engine that all machines use; default: that of this machine"
    )
    p.add_argument(
        "--max-seconds",
        type=types.positive,
        metavar="S",
        help="of a part at a time: it is kept then, to be gone on with",
    )
    p.add_argument(
        "--max-memory", type=types.positive, metavar="MB", help="of a part: one that needs more is not rendered"
    )
    p.add_argument("--json", action="store_true", help="one JSON object on stdout")


def _with_job(p: argparse.ArgumentParser) -> argparse.ArgumentParser:
    p.add_argument("job", metavar="JOB", help="the folder that `petzval farm plan` made")
    return p


def _add_machine(p: argparse.ArgumentParser) -> None:
    p.add_argument("--threads", type=types.natural, metavar="N", help="0: one for each core")
    p.add_argument("--blender", metavar="PATH", help="run in this Blender rather than in bpy")


def run(a: argparse.Namespace) -> int:
    """Does the action; the exit status."""
    if a.action == "plan":
        status = _plan(a)
    elif a.action == "part":
        from .farm import part

        status = part.render(
            Path(a.job), a.parts, blender=a.blender, threads=a.threads, again=a.again, every_s=a.checkpoint_every
        )
    elif a.action == "merge":
        from .farm import merging

        status = merging.merge(Path(a.job), blender=a.blender, threads=a.threads, again=a.again, as_json=a.json)
    elif a.action == "status":
        from .farm import merging

        return merging.status(Path(a.job), as_json=a.json)
    elif a.local is not None:
        from .farm import local

        return local.run(Path(a.job), a.local, blender=a.blender, threads=a.threads)
    else:
        from .farm import dask

        return dask.run(Path(a.job), a.dask, blender=a.blender, threads=a.threads)
    return status


def _plan(a: argparse.Namespace) -> int:
    from .farm import planning

    status, job = planning.plan(a)
    if job is None:
        return status or 1
    if a.json:
        print(json.dumps({"job": str(job.folder), "parts": len(job.parts), "files": len(job.files)}))
    else:
        total = sum(size for size, _ in job.files.values())
        print(f"{job.folder}: {len(job.parts)} parts, {len(job.files)} files of {total / 1e6:.1f} MB")
    return 0
