# SPDX-License-Identifier: GPL-3.0-or-later
"""The images, materials and meshes that a builder of the engine holds, so that an edited scene sends again only its changes."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import bpy

from .image_parts import Part, Timing


def uid(one: bpy.types.ID | None) -> int:
    """A number that a datablock keeps, evaluated or not, renamed or moved by undo; 0 of none."""
    return 0 if one is None else one.original.session_uid


class ImageKey(NamedTuple):
    """The source of an image of the engine."""

    #: The datablock.
    image: int
    #: A frame or a tile; tiles together by their numbers.
    part: Part | tuple[int, ...]


@dataclass
class Piece:
    """A piece that was sent: the engine's index, None where there was nothing to send; and the datablocks that it was made of."""

    index: int | None
    sources: frozenset[int] = frozenset()
    is_used: bool = True


@dataclass
class Kept:
    """All pieces of one builder, by their sources."""

    builder: Any
    images: dict[ImageKey, int] = field(default_factory=dict)
    #: The frames of sequences and movies that a material, world or light shows, with their timing.
    timed: dict[int, dict[ImageKey, Timing]] = field(default_factory=dict)
    #: The index of a material by datablock.
    materials: dict[int, int] = field(default_factory=dict)
    #: The attributes that a material asks of meshes.
    wanted: dict[int, frozenset[str]] = field(default_factory=dict)
    #: Meshes, curves, points and boxes.
    meshes: dict[Hashable, Piece] = field(default_factory=dict)
    #: Something fills space: a material's volume, or smoke.
    fills_space: bool = False
    #: Datablocks whose shape changed since the last time; pieces made of them are not taken as they were.
    reshaped: frozenset[int] = frozenset()
    #: The number of pieces that were sent or forgotten.
    changes: int = 0
    #: The frames that were shown the time before.
    _frames: set[ImageKey] = field(default_factory=set)

    def begin(self, changed: Changes, scene_frame: int) -> None:
        """Forgets changed pieces, and frames that are not those of the scene's frame; pieces that are not asked for until `sweep` go
        then."""
        if changed.images & {key.image for key in self.images}:
            # Materials name images by their index.
            changed = Changes(changed.images, changed.shapes, set(self.materials))
        self._forget_images({key for key in self.images if key.image in changed.images})
        for key in changed.materials & self.materials.keys():
            self.builder.forget_material(self.materials.pop(key))
            self.wanted.pop(key, None)
            self.changes += 1
        self._frames = {key for shown in self.timed.values() for key in shown}
        as_now = {
            key
            for shown in self.timed.values()
            for key, timing in shown.items()
            if key.part == timing.frame(scene_frame)
        }
        # Worlds and lights are told anew each time.
        self.timed = {key: shown for key, shown in self.timed.items() if key in self.materials}
        self._forget_frames(as_now)
        self._drop(key for key, piece in self.meshes.items() if not piece.sources.isdisjoint(changed.shapes))
        self.reshaped = frozenset(changed.shapes)
        for piece in self.meshes.values():
            piece.is_used = False

    def behind(self, scene_frame: int, *, of_view: bool) -> set[int]:
        """The materials that show another frame of a sequence or movie than they do at a frame of the scene. `of_view`: without those that
        views are not to refresh."""
        return {
            holder
            for holder, shown in self.timed.items()
            if any(
                key.part != timing.frame(scene_frame) and (timing.is_refreshed or not of_view)
                for key, timing in shown.items()
            )
        }

    def sweep(self) -> None:
        """Forgets the meshes that were not asked for, and the frames that nothing shows any more."""
        self._drop(key for key, piece in self.meshes.items() if not piece.is_used)
        self._forget_frames(set())

    def mesh(self, key: Hashable, sources: Iterable[bpy.types.ID | None], send: Callable[[], int | None]) -> int | None:
        """The engine's index of a mesh, sent if it is not there yet. The address of an evaluated mesh may be in `key`: one that is of
        something that was reshaped is not taken for another that had its place in memory."""
        made_of = frozenset(map(uid, sources))
        piece = self.meshes.get(key)
        if piece is not None and not piece.is_used and not made_of.isdisjoint(self.reshaped):
            self._drop([key])
            piece = None
        if piece is None:
            piece = self.meshes[key] = Piece(send())
            self.changes += 1
        piece.sources |= made_of
        piece.is_used = True
        return piece.index

    def _forget_frames(self, wanted: set[ImageKey]) -> None:
        """Forgets the frames of the time before that nothing shows, but those that are `wanted`."""
        shown = wanted.union(*self.timed.values())
        in_use = {self.images[key] for key in shown & self.images.keys()}
        gone = {(key.image, key.part) for key in self._frames - shown}
        self._forget_images(
            {key for key, index in self.images.items() if (key.image, key.part) in gone and index not in in_use}
        )

    def _forget_images(self, keys: set[ImageKey]) -> None:
        """One image may have two keys: an opaque one is the same with its colours multiplied by alpha."""
        for index in {self.images.pop(key) for key in keys}:
            self.builder.forget_image(index)
            self.changes += 1

    def _drop(self, keys: Iterable[Hashable]) -> None:
        for key in list(keys):
            piece = self.meshes.pop(key)
            self.changes += 1
            if piece.index is not None:
                self.builder.forget_mesh(piece.index)


@dataclass
class Changes:
    """Datablocks that changed, by `uid`."""

    images: set[int] = field(default_factory=set)
    #: Meshes and the like, and objects whose modifiers, particles or shape keys did.
    shapes: set[int] = field(default_factory=set)
    materials: set[int] = field(default_factory=set)

    @classmethod
    def of(cls, depsgraph: bpy.types.Depsgraph) -> Changes:
        """The changes of a dependency graph's last evaluation."""
        found = cls()
        for update in depsgraph.updates:
            one = update.id
            if isinstance(one, bpy.types.Image):
                found.images.add(uid(one))
            elif isinstance(one, bpy.types.Material):
                found.materials.add(uid(one))
            elif update.is_updated_geometry:
                found.shapes.add(uid(one))
        return found
