# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `petzval`: picks the subcommand, and says errors the one way.

Each subcommand is a module with `add_parser(subparsers)` and `run(arguments) -> int`, imported only when it is asked
for: `petzval lens` loads neither Blender nor the renderer's half. Errors go to stderr as one line `petzval: what,
where, what to do` with exit status 1, bad usage likewise with 2; a broken-off command ends with 130.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import re
import shutil
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from . import interrupts
from .errors import CommandError, complain
from .processors import ProcessorError

#: Subcommand: its module and its line in `petzval --help`.
COMMANDS = {
    "doctor": ("doctor_command", "say what is installed, what is missing, and what to do"),
    "lens": ("lens_command", "check or convert a lens file, show its first-order data, trace rays through it"),
    "glass": ("glass_command", "say what is known of a glass, draw its dispersion, list the glasses"),
    "surface": ("surface_command", "trace rays at single surfaces"),
    "calibration": (
        "calibration_command",
        "describe, convert or map a camera calibration of OpenCV, ROS, COLMAP and others",
    ),
    "render": ("render_command", "render a .blend through a lens"),
    "plan": ("plan_command", "say what a render would simulate of the lens, and why"),
    "farm": ("farm_command", "one picture on many machines: plan it in parts, render a part, merge them"),
    "dataset": ("dataset_command", "pictures with ground truth: depth, normals, masks, flow, camera parameters"),
    "sensor": ("sensor_command", "photograph a rendered picture with a sensor that counts photons, into a raw file"),
    "merge": ("merge_command", "join renders of one picture with other samples"),
    "cost": ("cost_command", "measure what accuracy costs: one picture by every camera, timed and compared"),
}

EXIT_ERROR = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130


class _Parser(argparse.ArgumentParser):
    """Says bad usage in one line, and takes -1e-3 and -1,0,0 for values and not for options."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._negative_number_matcher = re.compile(r"-[\d.]")

    def error(self, message: str) -> NoReturn:
        complain(f"bad usage: {message}; see {self.prog} --help")
        raise SystemExit(EXIT_USAGE)


def _parser(wanted: str | None) -> argparse.ArgumentParser:
    """The parser; of the subcommands only the wanted one is more than its name."""
    parser = _Parser(prog="petzval", description="Renders Blender scenes through real lenses.", allow_abbrev=False)
    parser.add_argument("--version", action="store_true", help="print the version and exit")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    for name, (module, summary) in COMMANDS.items():
        if name == wanted:
            importlib.import_module(f".{module}", __package__).add_parser(subparsers)
        else:
            subparsers.add_parser(name, help=summary)
    return parser


def _open_closed_streams() -> None:
    """Sends standard streams that are closed nowhere: the next file that is opened would take their place."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        continue
    os.close(descriptor)
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _run(argv: Sequence[str]) -> int:
    wanted = next((word for word in argv if not word.startswith("-")), None)
    if sys.stdout is None:
        # A render answers by its files; what it says meanwhile is lost.
        if wanted != "render":
            raise CommandError("the standard output is closed: open it, or send it into a file")
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    parser = _parser(wanted)
    arguments = parser.parse_args(argv)
    if arguments.version:
        from . import _native

        print(f"petzval {_native.__version__}, engine for {_native.PROCESSOR}")
        return 0
    if arguments.command is None:
        parser.error("a command is missing")
    # Commands have files to clean up; those that need Blender listen for signals in their own way.
    interrupts.raise_at_ctrl_c()
    status: int = importlib.import_module(f".{COMMANDS[arguments.command][0]}", __package__).run(arguments)
    return status


def _engine_is_missing() -> bool:
    """Prints an error if the compiled module cannot be loaded."""
    try:
        importlib.import_module("._native", __package__)
    except ProcessorError as error:
        complain(str(error))
        return True
    except ImportError as error:
        complain(f"no compiled engine: {error}: build it (make build), or install the wheel again")
        return True
    return False


def _is_engine_error(error: Exception) -> bool:
    native = sys.modules.get(f"{__package__}._native")
    return native is not None and isinstance(error, native.PetzvalError)


def run_command(argv: Sequence[str] | None = None) -> int:
    """Runs one command; returns its exit status. Says errors instead of raising them."""
    try:
        _open_closed_streams()
        status = _run(sys.argv[1:] if argv is None else argv)
        sys.stdout.flush()
        return status
    except CommandError as error:
        complain(str(error))
        return error.status
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader has gone.
        _mute_stdout()
    except OSError as error:
        # Commands name the files that they write; what is left is the standard output.
        complain(f"{error.filename or 'standard output'}: {error.strerror or error}: is there room, is it open")
        _mute_stdout()
    except ImportError:
        if f"{__package__}._native" in sys.modules or not _engine_is_missing():
            raise
    except Exception as error:
        if not _is_engine_error(error):
            raise
        complain(str(error))
    return EXIT_ERROR


def _mute_stdout() -> None:
    """Sends the interpreter's own flush at its end to the null device."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main() -> int:
    """The command's entry: like `run_command`, and leaves Blender's module for good where it was used.

    At the interpreter's own exit bpy hangs (4.5) or crashes (4.2) while a render engine is registered.
    """
    status = run_command()
    bpy = sys.modules.get("bpy")
    if bpy is None:
        return status
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
