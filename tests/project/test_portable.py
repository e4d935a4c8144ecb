# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing in Python needs a Linux: names that only POSIX has stand where another system goes another way, and the package and the add-on load
and render without them."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from support.places import ROOT, SCENES

pytestmark = pytest.mark.once

#: Modules of Python that Windows has not.
MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
#: Names of modules that Windows has without these.
NAMES = {
    "os": {
        "chown", "fchmod", "fchown", "fork", "forkpty", "getegid", "geteuid", "getgid", "getpgid", "getpgrp", "getuid", "killpg", "lchown",
        "mkfifo", "nice", "openpty", "pread", "pwrite", "sched_getaffinity", "sched_setaffinity", "setpgid", "setsid", "statvfs", "sysconf",
        "uname", "wait3", "wait4",
    },
    "signal": {"SIGALRM", "SIGHUP", "SIGKILL", "SIGQUIT", "SIGUSR1", "SIGUSR2", "alarm", "pause", "pthread_kill", "pthread_sigmask", "sigwait"},
    "socket": {"AF_UNIX"},
    "select": {"select", "poll", "epoll"},  # Windows selects among sockets alone.
    "time": {"tzset"},
}  # fmt: skip
#: Words of subprocess.Popen that Windows does not take, and paths of Linux.
KEYWORDS = {"preexec_fn", "start_new_session", "process_group", "pass_fds", "user", "group", "umask"}
FOLDERS = ("/proc/", "/sys/", "/dev/", "/tmp", "/etc/", "/usr/")
#: The files that ask for the system first.
ASKING = {
    "engine/python/petzval/processes.py", "engine/python/petzval/processors.py", "engine/python/petzval/interrupts.py",
    "engine/python/petzval/render_in_blender.py", "addon/data/process_memory.py",
}  # fmt: skip


def posix_only(source: str) -> set[str]:
    """The modules, names and folders of a Python source that Windows has not."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names} & MODULES
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found |= {node.module} & MODULES | {alias.name for alias in node.names} & NAMES.get(node.module, set())
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found |= {node.attr} & NAMES.get(node.value.id, set())
        elif isinstance(node, ast.Call):
            of_popen = isinstance(node.func, ast.Attribute) and ast.unparse(node.func).startswith("subprocess.")
            found |= {word.arg for word in node.keywords if word.arg in KEYWORDS and of_popen}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith(FOLDERS):
            found.add(node.value)
    return found


def sources() -> list[Path]:
    found = [*(ROOT / "addon").rglob("*.py"), *(ROOT / "engine/python/petzval").rglob("*.py")]
    return [path for path in found if "_bundled" not in path.parts]


def test_only_files_that_ask_for_the_system_use_what_posix_alone_has():
    used = {path.relative_to(ROOT).as_posix(): posix_only(path.read_text()) for path in sources()}
    assert len(used) > 100
    assert {name: words for name, words in used.items() if words and name not in ASKING} == {}
    assert all(used[name] for name in ASKING), "a file of ASKING asks no more"


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import resource", {"resource"}), ("from os import fork, getcwd", {"fork"}), ("import os\nos.getuid()", {"getuid"}),
        ("import signal as s\nimport signal\nsignal.SIGKILL", {"SIGKILL"}), ("subprocess.Popen(x, pass_fds=(1,))", {"pass_fds"}),
        ("open('/proc/self/statm')", {"/proc/self/statm"}), ("os.getpid()\nx.user\nf(user=1)", set()),
    ],
)  # fmt: skip
def test_what_posix_alone_has_is_found(source, found):
    assert posix_only(source) == found


#: Takes away what Windows has not, from what Python has loaded too; then loads all of Petzval, and renders.
PROGRAM = """
import importlib, os, pkgutil, select, signal, subprocess, sys
import bpy, numpy
MODULES, NAMES, blend, picture = {modules!r}, {names!r}, {blend!r}, {picture!r}
for name in MODULES:
    sys.modules[name] = None
for module, names in NAMES.items():
    for name in names:
        vars(importlib.import_module(module)).pop(name, None)
import petzval
for one in pkgutil.walk_packages(petzval.__path__, "petzval."):
    if not one.name.endswith("__main__") and "_bundled" not in one.name and "dask" not in one.name:
        importlib.import_module(one.name)
addon = petzval.load_addon()
addon.register()
bpy.ops.wm.open_mainfile(filepath=blend)
scene = bpy.context.scene
scene.render.engine = addon.engine.ENGINE
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 9, 100
scene.cycles.samples = 1
scene.render.filepath = picture
scene.render.image_settings.file_format = "PNG"
bpy.ops.render.render(write_still=True)
assert importlib.import_module(addon.__name__ + ".data.process_memory").peak_bytes() is None
print("rendered", flush=True)
os._exit(0)
"""


def test_the_addon_loads_and_renders_without_what_posix_alone_has(tmp_path):
    pytest.importorskip("bpy")
    picture = tmp_path / "é out.png"
    program = PROGRAM.format(
        modules=sorted(MODULES - {"posix"}), names={module: sorted(names) for module, names in NAMES.items()},
        blend=str(SCENES / "demo.blend"), picture=str(picture),
    )  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0 and "rendered" in done.stdout, done.stdout[-3000:] + done.stderr[-3000:]
    assert picture.read_bytes().startswith(b"\x89PNG")
