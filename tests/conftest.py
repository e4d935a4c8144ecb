# SPDX-License-Identifier: GPL-3.0-or-later
"""The fixtures of all tests: a fresh Blender, scenes, the command line, the real program; and an orderly end.

The bpy module keeps one Blender for the whole process: `blender` resets it before each test. At exit, bpy with a
render engine registered hangs (4.5) or crashes (4.2), so the process ends by `os._exit` once pytest has said all.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

# A failed assertion of a helper says as much as one of a test.
pytest.register_assert_rewrite("support")

from support.places import ROOT  # noqa: E402

# Set before bpy is imported: nothing of the user's Blender is read, and what bpy leaves behind lies in one folder.
# pytest's own folders stay where they are, so that a failed test's files can be looked at.
os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
_SESSION_FOLDER = Path(tempfile.mkdtemp(prefix="petzval-tests-"))
os.environ["BLENDER_USER_RESOURCES"] = str(_SESSION_FOLDER / "blender")
os.environ["TMPDIR"] = str(_SESSION_FOLDER)
tempfile.tempdir = str(_SESSION_FOLDER)

# A job started in the background ignores Ctrl-C, and hands that down; the tests of Ctrl-C need it heard.
signal.signal(signal.SIGINT, signal.default_int_handler)

_exit_status: int | None = None
_addon_registered = False


#: The cache key of pytest for the time of each file, s, and the time of a file without one.
_KEPT, _UNKNOWN_S = "petzval/seconds", 10.0
#: The times of this run, by test; kept by the process that starts the others, which hears of every test.
_seconds: dict[str, float] = {}


def pytest_configure(config):
    # Several processes take files in the order that is given below, not those of the most tests first.
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """`first_only("kind")` is `once` for all but the first value of that parameter: where nothing that a version of Blender
    changes depends on it; `first_only("a", "b")` of two that are given together. What is left to `make test-all` is `once`, too."""
    for item in items:
        for mark in item.iter_markers("first_only"):
            given = mark.args if len(mark.args) > 1 else mark.args[0]
            values = next(m.args[1] for m in item.iter_markers("parametrize") if m.args[0] == given)
            first = list(values)[0] if len(mark.args) > 1 else (list(values)[0],)
            if tuple(item.callspec.params[name] for name in mark.args) != first:
                item.add_marker(pytest.mark.once)
        if item.get_closest_marker("recipe"):
            item.add_marker(pytest.mark.once)
    # The longest files first: one that begins last would be waited for by all the other processes.
    kept = config.cache.get(_KEPT, {}) if hasattr(config, "cache") else {}
    items.sort(key=lambda item: (-kept.get(item.path.name, _UNKNOWN_S), item.path.name))


def pytest_runtest_logreport(report):
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration


@pytest.fixture
def blender():
    """bpy, reset to an empty factory scene, with the add-on registered."""
    global _addon_registered
    import bpy

    import petzval

    if _addon_registered:
        # The preferences stay. To reset them, too, takes six times as long: Blender's own add-ons are turned off and on.
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        petzval.load_addon().register()
        _addon_registered = True
    return bpy


@pytest.fixture
def parts(blender):
    """The helpers of scenes; the file is empty."""
    from support import scenes

    return scenes


@pytest.fixture(scope="session")
def petzval_cli():
    """Runs `petzval ARGUMENTS...` in a process of its own: `petzval_cli("lens", "info", path, "--json")`.

    Returns the finished process, its output as text.
    """

    def run(*arguments, stdin: str | None = None, timeout_s: float = 120.0) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "petzval", *map(str, arguments)],
            input=stdin if stdin is not None else "",
            capture_output=True,
            text=True,
            cwd=ROOT,
            timeout=timeout_s,
            check=False,
        )

    return run


@pytest.fixture(scope="session")
def cli_scenes(tmp_path_factory):
    """The folder with scene.blend and no-camera.blend; a script in it would write `ran`."""
    from support import render_commands

    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("cli-render")
    render_commands.save_scenes(folder)
    return folder


@pytest.fixture
def cli_render(petzval_cli, cli_scenes, tmp_path):
    """`render(options...)` into out.exr: (finished process, picture, statistics)."""

    def run(*options, name: str = "out.exr", scene: str = "scene.blend"):
        out, stats = tmp_path / name, tmp_path / f"{name}.json"
        done = petzval_cli("render", cli_scenes / scene, *options, "-o", out, "--stats", stats)
        return done, out, json.loads(stats.read_text()) if stats.exists() else None

    return run


@pytest.fixture
def cli_renders(cli_scenes, tmp_path):
    """`renders([options...], ...)`: each as `cli_render` does it, all in one process."""
    from support import render_commands

    def run(*several) -> list[render_commands.Render]:
        folder = Path(tempfile.mkdtemp(dir=tmp_path))
        return render_commands.render_all(cli_scenes / "scene.blend", list(several), folder)

    return run


@pytest.fixture(scope="session")
def real_blender_environment() -> dict[str, str]:
    """The environment of the real Blender, with a user folder of its own: the bpy module would load an extension that lies in its
    folder in place of the checkout."""
    return os.environ | {"BLENDER_USER_RESOURCES": str(_SESSION_FOLDER / "real-blender")}


@pytest.fixture(scope="session")
def run_blender(real_blender_environment):
    """Runs the real Blender (at least 4.2): `run_blender("-b", scene, "--python", script)`.

    With `window=True` it has a window of 1600 x 1000 on a virtual screen. Skips where there is no real Blender.
    Returns the finished process, stdout and stderr together as text.
    """
    if subprocess.run([ROOT / "tools/setup-blender.sh", "--where"], capture_output=True, check=False).returncode:
        pytest.skip("no real Blender: run tools/setup-blender.sh")

    def run(*arguments, window: bool = False, timeout_s: float = 300.0) -> subprocess.CompletedProcess[str]:
        start = [ROOT / "tools/blender", *(["--in-window"] if window else [])]
        try:
            return subprocess.run(
                [*map(str, start), *map(str, arguments)],
                env=real_blender_environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                cwd=ROOT,
                timeout=timeout_s,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            said = error.output or b""
            said = said if isinstance(said, str) else said.decode(errors="replace")
            pytest.fail(f"Blender was not done after {timeout_s} s; it had said:\n{said}")

    return run


@pytest.fixture(scope="session")
def extension_zip() -> Path:
    """The built extension; skips where `make extension` has not run."""
    # Of this machine; others' may lie beside it.
    machine = "arm64" if platform.machine() in ("aarch64", "arm64") else "x64"
    found = sorted((ROOT / "dist").glob(f"petzval-*-{sys.platform.replace('darwin', 'macos')}-{machine}.zip"))
    if not found:
        pytest.skip("no extension zip in dist/: run make extension")
    return found[-1]


@pytest.fixture(scope="session")
def installed_extension(run_blender, extension_zip) -> str:
    """The add-on installed into the real Blender as a user would; the value is its module's name.

    `run_blender("--addons", installed_extension, ...)` has it enabled, with factory settings too.
    """
    done = run_blender("--command", "extension", "install-file", "-r", "user_default", "--enable", extension_zip)
    assert done.returncode == 0, done.stdout
    return "bl_ext.user_default.petzval"


@pytest.fixture(scope="session")
def other_peoples_scenes() -> Path:
    """A folder of scenes that are not this project's to hand on; skips where PETZVAL_SCENES names none."""
    folder = Path(os.environ.get("PETZVAL_SCENES", ""))
    if not os.environ.get("PETZVAL_SCENES") or not folder.is_dir():
        pytest.skip("no folder of other people's scenes: set PETZVAL_SCENES")
    return folder


def pytest_terminal_summary(terminalreporter):
    """Hands the tests that could not run to `make test`, which lists them once at the end."""
    notes = os.environ.get("PETZVAL_NOT_RUN")
    if not notes:
        return
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    with open(notes, "a", encoding="utf-8") as out:
        for report in terminalreporter.stats.get("skipped", ()):
            reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
            out.write(f"{report.nodeid} ({python}): {reason.removeprefix('Skipped: ')}\n")


def pytest_sessionfinish(session, exitstatus):
    global _exit_status
    _exit_status = int(exitstatus)
    if hasattr(session.config, "workerinput"):
        return
    _keep_seconds(session.config)
    if os.environ.get("PETZVAL_DURATIONS"):
        python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
        with open(os.environ["PETZVAL_DURATIONS"], "a", encoding="utf-8") as out:
            out.writelines(f"{s:8.1f}  {test} ({python})\n" for test, s in _seconds.items() if s >= 0.5)


def _keep_seconds(config) -> None:
    """Keeps the times for the order of the next run. A file of which a part has run takes at least half as long as was known of it."""
    files: dict[str, float] = {}
    for test, seconds in _seconds.items():
        name = test.partition("::")[0].rpartition("/")[2]
        files[name] = files.get(name, 0.0) + seconds
    kept = config.cache.get(_KEPT, {}) if hasattr(config, "cache") else {}
    if files and hasattr(config, "cache"):
        config.cache.set(_KEPT, kept | {name: max(round(s, 1), kept.get(name, 0.0) / 2) for name, s in files.items()})


@pytest.hookimpl(trylast=True)
def pytest_unconfigure():
    """Ends the process, exit status kept, where bpy was used; the closing line of pytest is out by now."""
    with_bpy = "bpy" in sys.modules
    if _addon_registered:
        try:
            sys.modules["petzval_addon"].unregister()
        except Exception as error:
            print(f"petzval: the add-on does not unregister: {error!r}", file=sys.stderr)
    shutil.rmtree(_SESSION_FOLDER, ignore_errors=True)
    sys.stdout.flush()
    sys.stderr.flush()
    if with_bpy and _exit_status is not None:
        os._exit(_exit_status)
