# SPDX-License-Identifier: GPL-3.0-or-later
"""Next tile, progress, stop: watches a render while it runs. No bpy."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from petzval.description import Matrix4

from ..data.tiles import Tile

# Long enough to cost nothing, short enough that Esc feels immediate.
POLL_SECONDS = 0.02
# Showing tiles takes at most this part of the time; they wait and go together when Blender is slow to take them.
SHOWING_SHARE = 0.2

Result = TypeVar("Result")


class Stopped(Exception):
    """The user asked to stop before there was anything to keep."""


@dataclass(frozen=True)
class Subject:
    """Everything that a render is made of, ready to be rendered, in the words of the engine's `Job`."""

    scene: Any
    camera: Any
    settings: Any
    over_the_shutter: list
    wishes: dict[str, Any]
    #: The opening of the shutter; None where nothing moves.
    shutter: Any
    #: Time to read the scene, s.
    sync_seconds: float


@dataclass
class Part:
    """A part of a picture that is rendered on several machines."""

    #: The tiles that are rendered: from one slot to before another, of so many; see the engine's `Job`.
    slots: tuple[int, int, int]
    #: The file that the film is written to. View layers and their auxiliary renders have files of their own, named after it.
    film: str
    #: The checkpoint of the part while it is rendered, named as `film` is.
    checkpoint: str
    #: The films and the checkpoints that were written.
    written: list[str] = field(default_factory=list)
    checkpoints: list[Any] = field(default_factory=list)
    #: Time of all view layers so far, s.
    seconds: float = 0.0


@dataclass
class Share:
    """Parts of a picture that is rendered on several machines, or the films that are to be joined."""

    #: The parts that are rendered, one after another of each view layer; none: parts are joined.
    parts: list[Part] = field(default_factory=list)
    #: Called when a part begins, and when all films of it are written.
    begun: Callable[[Part], None] = lambda _: None
    finished: Callable[[Part], None] = lambda _: None
    #: The file that says which scene the parts are of: the first of them writes it, the others agree with it. Named as films are.
    agreement: str = ""
    #: The films that are joined: number of the part, file and slots.
    joined: list[tuple[int, str, tuple[int, int, int]]] = field(default_factory=list)
    #: True if the films that are joined are to be the whole picture: only then is it denoised, and stray light laid over it.
    is_whole: bool = False
    #: Parts that were not taken, each with the reason; and the number of films that were.
    refused: dict[int, str] = field(default_factory=dict)
    taken: int = 0
    #: The reason why a film could not be written.
    problem: str = ""


@dataclass(frozen=True)
class Beside:
    """A neighbour of the frame that is rendered, for the Vector pass."""

    #: The frame that everything is looked at in.
    frame: float
    #: The matrix of the scene's camera in this frame, row by row.
    camera_matrix: Matrix4


class Watch:
    """The interface of a program that drives Blender from outside: it may ask to stop, and be told of the progress."""

    def __init__(self) -> None:
        self.stop = threading.Event()
        self.on_progress: Callable[[float, str], None] | None = None
        #: The file in which renders are kept while they go on, and taken up again; empty: none; None: as the scene has it.
        #: It stays at the end.
        self.checkpoint: str | None = None
        self.checkpoint_every_s: float | None = None
        #: The checkpoints of the renders of such a file: whoever writes the picture deletes them.
        self.written_checkpoints: list[Any] = []
        #: The function that is called instead of a render, with its `Subject`, once for each view layer.
        self.study: Callable[[Subject], None] | None = None
        #: The part of the picture that is rendered; None: the whole picture.
        self.share: Share | None = None
        #: The frames before and after, instead of the neighbours of the one that is rendered.
        self.beside: tuple[Beside, Beside] | None = None
        #: The function that gets each pass of a finished picture: the names of its view layer, of its view and of the pass, and its pixels
        #: (height, width, channels), first row at the bottom.
        self.taken: Callable[[str, str, str, Any], None] | None = None
        #: The reason why a raw file could not be written; the picture is there all the same.
        self.raw_problem = ""


#: The watch that every render of this process reads.
WATCH = Watch()


def stoppable(
    work: Callable[[], Result], stop_asked: Callable[[], bool], meanwhile: Callable[[], None] = lambda: None
) -> Result:
    """The result of a long call that cannot be stopped itself; raises `Stopped` and leaves it behind when asked to. `meanwhile` is called
    now and then."""
    outcome: list[tuple[bool, Any]] = []

    def run() -> None:
        try:
            outcome.append((True, work()))
        except BaseException as error:  # handed on to the caller's thread
            outcome.append((False, error))

    thread = threading.Thread(target=run, name="petzval", daemon=True)
    thread.start()
    thread.join(POLL_SECONDS)
    while thread.is_alive():
        if stop_asked():
            raise Stopped
        meanwhile()
        thread.join(POLL_SECONDS)
    good, value = outcome[0]
    if not good:
        raise value
    return value


def follow(
    job: Any,
    *,
    stop_asked: Callable[[], bool],
    show: Callable[[list[Tile]], None],
    tell: Callable[[float, int], None],
    limit_s: float = 0.0,
) -> bool:
    """Follows a job to its end, or to its stop when asked; True where it was stopped. After `limit_s` seconds, where that is not
    0, it ends with the samples taken, but with no less than one everywhere; that is no stop.

    `show` gets the tiles that changed, `tell` the progress and the samples done. What is there at the end is for the
    caller to take: `Job.image`.
    """
    stopped, is_late = False, False
    next_show, began_all = 0.0, time.monotonic()
    try:
        while not job.wait(POLL_SECONDS):
            if stop_asked():
                stopped = True
                break
            if limit_s > 0.0 and time.monotonic() - began_all >= limit_s and job.samples_done() > 0:
                is_late = True
                break
            tell(job.progress(), job.samples_done())
            began = time.monotonic()
            if began >= next_show:
                show([Tile(x, y, pixels) for x, y, _width, _height, pixels in job.take_tiles()])
                ended = time.monotonic()
                next_show = ended + (ended - began) / SHOWING_SHARE
    except KeyboardInterrupt:
        # The bpy module raises it here on Ctrl-C; the program around it decides what comes next.
        WATCH.stop.set()
        stopped = True
    if stopped or is_late:
        job.stop()
        while not job.wait(POLL_SECONDS):
            pass
    return stopped
