# SPDX-License-Identifier: GPL-3.0-or-later
"""The random number of an object, as Cycles' Object Info node gives it."""

from __future__ import annotations

from collections.abc import Callable

import bpy

_MASK = 0xFFFFFFFF


class Numbers:
    """The numbers of instances for a program that drives Blender from outside: another number for each instance than its object's pass
    index."""

    #: Gives the number, 0 to 2^24; None: pass indices count.
    of: Callable[[bpy.types.DepsgraphObjectInstance], int] | None = None


#: Read whenever a scene is sent.
NUMBERS = Numbers()


def index(holder: bpy.types.Object, place: bpy.types.DepsgraphObjectInstance) -> int:
    """The number of an instance in the Object Index pass."""
    return holder.pass_index if NUMBERS.of is None else NUMBERS.of(place)


def random(holder: bpy.types.Object, place: bpy.types.DepsgraphObjectInstance) -> float:
    """0 to 1: by the name of an object, or by Blender's number of an instance."""
    number = place.random_id if place.is_instance else _hash(_of_name(holder.name), 0)
    return (number & _MASK) / _MASK


def _of_name(name: str) -> int:
    number = 0
    for byte in name.encode():
        number = (number * 37 + byte) & _MASK
    return number


def _hash(x: int, y: int) -> int:
    """Two numbers to one: the end of Jenkins's lookup3."""
    a = b = c = (0xDEADBEEF + (2 << 2) + 13) & _MASK
    b = (b + y) & _MASK
    a = (a + x) & _MASK

    def turned(number: int, by: int) -> int:
        return (number << by | number >> (32 - by)) & _MASK

    c = ((c ^ b) - turned(b, 14)) & _MASK
    a = ((a ^ c) - turned(c, 11)) & _MASK
    b = ((b ^ a) - turned(a, 25)) & _MASK
    c = ((c ^ b) - turned(b, 16)) & _MASK
    a = ((a ^ c) - turned(c, 4)) & _MASK
    b = ((b ^ a) - turned(a, 14)) & _MASK
    return ((c ^ b) - turned(b, 24)) & _MASK
