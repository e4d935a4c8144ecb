# SPDX-License-Identifier: GPL-3.0-or-later
"""The systems for which Petzval is built, and the demands that a module for each may have."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
#: The largest extension, as the issue of them is a download: bytes.
LARGEST_ZIP = 12_000_000
#: Levels of x86-64 that wheels have an engine for, lowest first (petzval/processors.py).
LEVELS = ("x86-64-v2", "x86-64-v3")


@dataclass(frozen=True)
class Platform:
    """A system and a kind of processor, as Blender's manifests name them."""

    name: str
    #: Rust's name. On Windows that of LLVM's libraries, which zig brings; the others of GNU need GCC's.
    triple: str
    #: Zig's name, with the oldest system.
    zig: str
    #: The platform tag of a wheel.
    tag: str
    #: The oldest system that its Blender runs on, or for Windows the version that linkers write.
    oldest: tuple[int, ...]

    @property
    def system(self) -> str:
        return self.name.partition("-")[0]

    @property
    def machine(self) -> str:
        return self.name.partition("-")[2]

    @property
    def levels(self) -> tuple[str, ...]:
        return LEVELS if self.machine == "x64" else ()


#: glibc 2.28, and macOS 11: the demands of Blender 4.2. Windows 10 brings the C library of the module, Blender has it from 8.1 on.
PLATFORMS = {
    one.name: one
    for one in (
        Platform("linux-x64", "x86_64-unknown-linux-gnu", "x86_64-linux-gnu.2.28", "manylinux_2_28_x86_64", (2, 28)),
        Platform("linux-arm64", "aarch64-unknown-linux-gnu", "aarch64-linux-gnu.2.28", "manylinux_2_28_aarch64", (2, 28)),
        Platform("windows-x64", "x86_64-pc-windows-gnullvm", "x86_64-windows-gnu", "win_amd64", (6, 3)),
        Platform("windows-arm64", "aarch64-pc-windows-gnullvm", "aarch64-windows-gnu", "win_arm64", (6, 3)),
        Platform("macos-x64", "x86_64-apple-darwin", "x86_64-macos.11.0-none", "macosx_11_0_x86_64", (11, 0)),
        Platform("macos-arm64", "aarch64-apple-darwin", "aarch64-macos.11.0-none", "macosx_11_0_arm64", (11, 0)),
    )
}  # fmt: skip

#: Libraries that every such system has, or Blender's Python.
LIBRARIES = {
    "linux": re.compile(r"(libc|libm|ld-linux-x86-64|ld-linux-aarch64)\.so\.\d|lib(pthread|dl|rt)\.so\.\d|libgcc_s\.so\.1"),
    "windows": re.compile(r"(kernel32|ntdll|bcrypt|bcryptprimitives|advapi32|ws2_32|userenv|python3)\.dll|api-ms-win-(core|crt)-[\w-]+\.dll"),
    "macos": re.compile(r"/usr/lib/libSystem\.B\.dylib"),
}  # fmt: skip


def platform_of(file: str) -> Platform:
    """The platform of a wheel, by its file's name. Raises `KeyError`."""
    tag = Path(file).stem.rpartition("-")[2]
    return next((one for one in PLATFORMS.values() if one.tag in tag.split(".")), None) or PLATFORMS[tag]


def host() -> str:
    """Rust's name of this machine."""
    told = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    return re.search(r"^host: (\S+)$", told, re.MULTILINE)[1]
