# SPDX-License-Identifier: GPL-3.0-or-later
"""The demands of a compiled module on the system that loads it: its libraries, the oldest system, the processor, and on a Mac its
signature. Reads ELF, PE and Mach-O by themselves, so that the modules of every system are checked on any."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass, field


class BinaryError(ValueError):
    """A file is no compiled module of a system that is known, or is broken."""


@dataclass
class Module:
    """The facts of a compiled module, from its own headers."""

    #: linux, windows or macos.
    system: str
    #: x64 or arm64.
    machine: str
    #: Libraries that are loaded with it.
    libraries: list[str] = field(default_factory=list)
    #: The oldest system: of glibc, Windows or macOS; empty where nothing says so.
    oldest: tuple[int, ...] = ()
    #: The names that it imports.
    imports: set[str] = field(default_factory=set)
    #: The names that it exports.
    exports: set[str] = field(default_factory=set)
    #: True if the ad hoc signature of a Mac's module is that of these bytes.
    is_signed: bool = False


def read(data: bytes) -> Module:
    """Reads a compiled module. Raises `BinaryError`."""
    try:
        if data[:4] == b"\x7fELF":
            return _elf(data)
        if data[:2] == b"MZ":
            return _pe(data)
        if data[:4] == b"\xcf\xfa\xed\xfe":
            return _mach_o(data)
    except (struct.error, IndexError, KeyError, UnicodeDecodeError) as error:
        raise BinaryError(f"a broken module: {error}") from None
    raise BinaryError("no compiled module of a 64-bit Linux, Windows or Mac")


def _text(data: bytes, at: int) -> str:
    return data[at : data.index(b"\0", at)].decode()


# Linux -----------------------------------------------------------------------------------------------------------


def _elf(data: bytes) -> Module:
    machine = {62: "x64", 183: "arm64"}[struct.unpack_from("<H", data, 18)[0]]
    module = Module("linux", machine)
    at, size, count = struct.unpack_from("<Q", data, 40)[0], *struct.unpack_from("<HH", data, 58)
    # Type, place, length, the section linked to, the number of entries.
    sections = []
    for i in range(count):
        _, kind, _, _, offset, length, link, info = struct.unpack_from("<IIQQQQII", data, at + i * size)
        sections.append((kind, offset, length, link, info))
    for kind, offset, length, link, info in sections:
        strings = sections[link][1] if link < count else 0
        if kind == 6:  # dynamic
            for entry in range(offset, offset + length, 16):
                tag, value = struct.unpack_from("<QQ", data, entry)
                if tag == 1:
                    module.libraries.append(_text(data, strings + value))
        elif kind == 0x6FFFFFFE:  # versions that are needed
            needed = offset
            for _ in range(info):
                _, names, _, first, following = struct.unpack_from("<HHIII", data, needed)
                version = needed + first
                for _ in range(names):
                    _, _, _, name, further = struct.unpack_from("<IHHII", data, version)
                    words = _text(data, strings + name)
                    if words.startswith("GLIBC_") and words[6:7].isdigit():
                        module.oldest = max(module.oldest, tuple(map(int, words[6:].split("."))))
                    version += further
                needed += following
        elif kind == 11:  # dynamic symbols
            for entry in range(offset + 24, offset + length, 24):
                name, info_byte, _, section = struct.unpack_from("<IBBH", data, entry)
                if info_byte >> 4:
                    (module.exports if section else module.imports).add(_text(data, strings + name))
    return module


# Windows ---------------------------------------------------------------------------------------------------------


def _pe(data: bytes) -> Module:
    head = struct.unpack_from("<I", data, 60)[0]
    if data[head : head + 4] != b"PE\0\0":
        raise BinaryError("a broken module: no PE header")
    kind, count = struct.unpack_from("<HH", data, head + 4)
    optional, length = head + 24, struct.unpack_from("<H", data, head + 20)[0]
    module = Module("windows", {0x8664: "x64", 0xAA64: "arm64"}[kind])
    module.oldest = struct.unpack_from("<HH", data, optional + 48)
    sections = [struct.unpack_from("<IIII", data, optional + length + 40 * i + 8) for i in range(count)]

    def place(address: int) -> int:
        for size, start, kept, offset in sections:
            if start <= address < start + max(size, kept):
                return address - start + offset
        raise BinaryError("a broken module: an address outside")

    exports, imports = (struct.unpack_from("<I", data, optional + 112 + 8 * i)[0] for i in range(2))
    if imports:
        entry = place(imports)
        while True:
            names, _, _, library, addresses = struct.unpack_from("<IIIII", data, entry)
            if not library:
                break
            module.libraries.append(_text(data, place(library)).lower())
            at = place(names or addresses)
            while value := struct.unpack_from("<Q", data, at)[0]:
                if not value >> 63:
                    module.imports.add(_text(data, place(value) + 2))
                at += 8
            entry += 20
    if exports:
        table = place(exports)
        number, names = struct.unpack_from("<I", data, table + 24)[0], struct.unpack_from("<I", data, table + 32)[0]
        for i in range(number):
            module.exports.add(_text(data, place(struct.unpack_from("<I", data, place(names) + 4 * i)[0])))
    return module


# macOS -----------------------------------------------------------------------------------------------------------


def _mach_o(data: bytes) -> Module:
    module = Module("macos", {0x01000007: "x64", 0x0100000C: "arm64"}[struct.unpack_from("<I", data, 4)[0]])
    count, at = struct.unpack_from("<I", data, 16)[0], 32
    for _ in range(count):
        kind, size = struct.unpack_from("<II", data, at)
        if kind in (0x0C, 0x80000018, 0x8000001F):  # libraries that are loaded: needed, weak, handed on
            module.libraries.append(_text(data, at + struct.unpack_from("<I", data, at + 8)[0]))
        elif kind == 0x32:  # the build's version
            oldest = struct.unpack_from("<I", data, at + 12)[0]
            module.oldest = (oldest >> 16, oldest >> 8 & 255)
        elif kind == 0x24:  # the oldest macOS, as older linkers have it
            oldest = struct.unpack_from("<I", data, at + 8)[0]
            module.oldest = (oldest >> 16, oldest >> 8 & 255)
        elif kind == 2:  # symbols
            symbols, number, strings, _ = struct.unpack_from("<IIII", data, at + 8)
            for entry in range(symbols, symbols + 16 * number, 16):
                name, flags, _, _, value = struct.unpack_from("<IBBHQ", data, entry)
                if not flags & 0xE0 and flags & 1:
                    is_outside = flags & 0x0E == 0 and value == 0
                    (module.imports if is_outside else module.exports).add(
                        _text(data, strings + name).removeprefix("_")
                    )
        elif kind == 0x1D:  # the signature
            module.is_signed = _is_signed(data, struct.unpack_from("<I", data, at + 8)[0])
        at += size
    return module


def _is_signed(data: bytes, at: int) -> bool:
    """True if the pages' digests in a signature are those of the pages: a Mac with Apple's processor loads nothing else."""
    magic, _, count = struct.unpack_from(">III", data, at)
    if magic != 0xFADE0CC0:
        return False
    for i in range(count):
        kind, offset = struct.unpack_from(">II", data, at + 12 + 8 * i)
        if kind != 0:  # the code directory
            continue
        table = at + offset
        digests, pages, limit = (struct.unpack_from(">I", data, table + place)[0] for place in (16, 28, 32))
        length, method, page = data[table + 36], data[table + 37], 1 << data[table + 39]
        if method != 2:  # SHA-256
            return False
        for number in range(pages):
            part = data[number * page : min((number + 1) * page, limit)]
            start = table + digests + number * length
            if hashlib.sha256(part).digest() != data[start : start + length]:
                return False
        return limit == at
    return False
