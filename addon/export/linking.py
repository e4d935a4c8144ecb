# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: the sets of objects that emitters light, and of those that stand in their way."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from .report import Report

#: The number of sets, as in Cycles; the first of them is everything.
MOST_SETS = 64
ROLES = ("receiver", "blocker")
_ALL = (1 << 64) - 1


class Links:
    """All of a dependency graph, by objects of the file."""

    def __init__(self, depsgraph: bpy.types.Depsgraph, report: Report) -> None:
        self._sets: dict[str, dict[bpy.types.Collection, int]] = {role: {} for role in ROLES}
        for holder in depsgraph.objects:
            for role in ROLES:
                self._note(role, _collection(holder, role), report)
        # By role: for each set, whether it is all but some, and those that are named.
        self._members = {
            role: [(number, *_named(collection)) for collection, number in sets.items()]
            for role, sets in self._sets.items()
        }

    def _note(self, role: str, collection: bpy.types.Collection | None, report: Report) -> None:
        sets = self._sets[role]
        if collection is None or collection in sets:
            return
        if len(sets) + 1 >= MOST_SETS:
            report.warn(f"Light linking: more than {MOST_SETS - 1} {role} collections, '{collection.name}' is left out")
            return
        sets[collection] = len(sets) + 1

    @property
    def any(self) -> bool:
        """True if anything is linked."""
        return any(self._sets.values())

    def sets(self, holder: bpy.types.Object) -> tuple[int, int]:
        """The sets of an emitter: the objects that it lights, and those that block its light."""
        return tuple(self._sets[role].get(_collection(holder, role), 0) for role in ROLES)

    def of(self, holder: bpy.types.Object) -> tuple[int, int, int, int] | None:
        """The sets of an object: those of receivers and of blockers that it is in, a bit each, and its own as an emitter. None
        where nothing is linked."""
        if not self.any:
            return None
        return (*(self._membership(role, holder.original) for role in ROLES), *self.sets(holder))

    def _membership(self, role: str, holder: bpy.types.Object) -> int:
        mask = _ALL
        for number, included, excluded in self._members[role]:
            if holder in excluded or (included and holder not in included):
                mask &= ~(1 << number)
        return mask


def _collection(holder: bpy.types.Object, role: str) -> bpy.types.Collection | None:
    linking = getattr(holder.original, "light_linking", None)
    return getattr(linking, f"{role}_collection", None)


def _named(collection: bpy.types.Collection) -> tuple[set[bpy.types.Object], set[bpy.types.Object]]:
    """Objects that a collection includes, and those that it excludes."""
    found: dict[str, set[bpy.types.Object]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for one, held in zip(collection.objects, collection.collection_objects, strict=True):
        found[held.light_linking.link_state].add(one.original)
    for one, state in _below(collection):
        found[state].update(inner.original for inner in one.objects)
    return found["INCLUDE"], found["EXCLUDE"]


def _below(collection: bpy.types.Collection) -> Iterator[tuple[bpy.types.Collection, str]]:
    """Collections within one, each with the state that it has there: its objects' own does not count."""
    for child, held in zip(collection.children, collection.collection_children, strict=True):
        yield child, held.light_linking.link_state
        yield from _below(child)
