# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of `petzval farm` that runs where Blender is: packs a scene, renders a part, joins the parts of frames."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

from petzval import atomic_files
from petzval import render_in_blender as rendering
from petzval.errors import TryAgain
from petzval.farm import bevels, packing, sizes

#: Objects that a warning names.
_MOST_NAMED = 5


def run(scene: Any, options: dict[str, Any], addon: Any, voice: TextIO) -> str | None:
    """Runs a step by the options; returns the error, if any. The result goes to the file `answer`. Raises `TryAgain`."""
    asked = options["farm"]
    work = {"pack": _pack, "part": _part, "merge": _merge}[asked["what"]]
    try:
        found = work(scene, options, addon, voice)
    except rendering.OutOfRange as refused:
        return str(refused)
    if isinstance(found, str):
        return found
    atomic_files.write_json(Path(options["answer"]), found)
    return None


def _pack(scene: Any, options: dict[str, Any], addon: Any, _: TextIO) -> dict[str, Any] | str:
    """Copies the scene's files into the job's folder, and returns the numbers that the parts are cut by."""
    import bpy

    wrong = rendering.apply(scene, options, addon, {})
    if wrong:
        return wrong
    about = _about(scene, addon)
    frame = scene.frame_current
    moves = (
        bool(options["frames"])
        or scene.render.use_motion_blur
        or any(layer.use_pass_vector for layer in scene.view_layers)
    )
    # What the options have set is no part of the file.
    bpy.ops.wm.open_mainfile(filepath=options["scene"], load_ui=False, use_scripts=False)
    is_moving = bool(options["frames"])
    warnings = [*_random_textures(bpy), *(_unbaked(bpy) if is_moving else ())]
    has_bevels = any(made.type == "BEVEL" for one in bpy.data.objects for made in one.modifiers)
    packer = packing.Packer(bpy, options["scene"])
    try:
        target = Path(options["farm"]["target"])
        main, files = packer.pack(target)
        if has_bevels:
            blends = [target / name for name in files if name.endswith(".blend")]
            warnings += _apply_bevels(bpy, blends, frame, moves=moves)
    except OSError as failed:
        named = f"{failed.filename}: " if failed.filename else ""
        return f"cannot pack {options['scene']}: {named}{failed.strerror or failed}"
    return {
        **about,
        "scene": main,
        "files": files,
        "warnings": [*warnings, *packer.warnings],
        "blender": bpy.app.version_string,
    }


def _random_textures(bpy: Any) -> list[str]:
    """Warnings of textures that are other ones in each process."""
    return [
        f"texture '{one.name}' is of type Noise, which is random in each process: where a modifier uses it, parts are not of one scene"
        for one in bpy.data.textures
        if one.type == "NOISE"
    ]


def _apply_bevels(bpy: Any, blends: list[Path], frame: int, *, moves: bool) -> list[str]:
    """Applies the Bevel modifiers of the packed .blends, and saves these. Warnings of those that stay. Raises `OSError`."""
    names = []
    for blend in blends:
        packing.open_blend(bpy, str(blend))
        done, left = bevels.apply_all(bpy, frame, moves=moves)
        names += [f"'{name}'" for name in left]
        if done:
            packing.save_blend(bpy, str(blend), compress=True)
    if not names:
        return []
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return [
        f"the modifier Bevel of {', '.join(names[:_MOST_NAMED])}{more} may make other corners in each process: where a part is refused for it, "
        f"apply the modifier and plan again"
    ]


def _unbaked(bpy: Any) -> list[str]:
    """Warnings of simulations that a part of one frame cannot know."""
    caches = [
        (block, cache)
        for block in bpy.data.objects
        for owner in (*block.modifiers, *block.particle_systems)
        if (cache := getattr(owner, "point_cache", None)) is not None
    ]
    return [
        f"object '{block.name}' is simulated, and its cache is not baked: each part renders its frame alone: bake it first"
        for block, cache in caches
        if not cache.is_baked
    ]


def _about(scene: Any, addon: Any) -> dict[str, Any]:
    width, height = addon.export.camera.resolution(scene.render)
    region = addon.render.results.region(scene.render)
    settings = addon.export.settings.describe(scene, width, height)
    is_adaptive = settings.noise_threshold > 0.0
    side = sizes.BLOCK if is_adaptive else sizes.TILE
    across = (width, height) if is_adaptive else (region.width, region.height)
    denoised = any(addon.data.passes.is_denoised(scene, layer) for layer in scene.view_layers if layer.use)
    return {
        "width": width,
        "height": height,
        "samples": settings.samples,
        "seed": settings.seed,
        "tiles": -(-across[0] // side) * -(-across[1] // side),
        "looks_at_all": is_adaptive and denoised and addon.export.sampling.of_render(scene).is_after_denoising,
    }


def _part(scene: Any, options: dict[str, Any], addon: Any, _: TextIO) -> dict[str, Any] | str:
    """Renders parts into their films, frame by frame. Each has its marker once its films are there, whatever becomes of those behind it."""
    watch = addon.render.loop.WATCH
    for frame in options["farm"]["frames"]:
        wrong = _ready(scene, options, addon, {"frame": frame["frame"]})
        if wrong:
            return wrong
        # A checkpoint of each part's own.
        watch.checkpoint = ""
        asked = [
            (one, addon.render.loop.Part(tuple(one["slots"]), one["film"], one["checkpoint"])) for one in frame["parts"]
        ]
        share = addon.render.loop.Share([part for _, part in asked], agreement=frame["agreement"])
        wrong = _render_parts(scene, options, addon, share, {id(part): one for one, part in asked})
        if wrong:
            return wrong
    return {}


def _render_parts(
    scene: Any, options: dict[str, Any], addon: Any, share: Any, asked: dict[int, dict[str, Any]]
) -> str | None:
    """Renders the parts of a frame; the error, if any."""
    watch, most = addon.render.loop.WATCH, options["farm"]["most_seconds"]
    watch.share, done, unwritten = share, set(), []
    late = threading.Event()

    def finished(part: Any) -> None:
        one = asked[id(part)]
        films = {Path(film).name: Path(film).stat().st_size for film in part.written}
        told = {"part": one["number"], "films": films, "seconds": round(part.seconds, 3)}
        try:
            atomic_files.write_json(Path(one["marker"]), told)
        except OSError as failed:
            unwritten.append(f"cannot write {one['marker']}: {failed.strerror or failed}")
            watch.stop.set()
            return
        done.add(id(part))
        for checkpoint in part.checkpoints:
            checkpoint.delete()
        print(f"part {one['number']}: finished in {part.seconds:.1f} s", flush=True)

    with _clock(most, watch, late) as begin:
        share.begun, share.finished = begin, finished
        addon.render.statistics.forget()
        problem = rendering.take(scene, watch, writes=False)
    if problem is None and not watch.stop.is_set() and not share.problem:
        for part in share.parts:
            if part.written and id(part) not in done:
                finished(part)
    if share.problem or unwritten:
        raise TryAgain(f"{share.problem or unwritten[0]}: is there room, and may you write there")
    if len(done) == len(share.parts):
        return None
    if late.is_set():
        raise TryAgain(f"the part takes longer than {most:g} s: it is kept, and goes on where it was at the next try")
    if problem is not None:
        return problem
    if watch.stop.is_set():
        raise KeyboardInterrupt
    return "nothing was rendered: look at what Blender said"


@contextlib.contextmanager
def _clock(most_seconds: float | None, watch: Any, late: threading.Event) -> Iterator[Any]:
    """Gives a function that is told of each part that begins: one that takes longer is stopped."""
    clock: threading.Timer | None = None

    def stop() -> None:
        late.set()
        watch.stop.set()

    def end() -> None:
        if clock is not None:
            clock.cancel()

    def begin(part: Any) -> None:
        nonlocal clock
        end()
        if most_seconds:
            # View layers before have had their time.
            clock = threading.Timer(max(most_seconds - part.seconds, 0.0), stop)
            clock.daemon = True
            clock.start()

    try:
        yield begin
    finally:
        end()


def _merge(scene: Any, options: dict[str, Any], addon: Any, voice: TextIO) -> dict[str, Any] | str:
    """Joins the parts of frames to their pictures, one by one."""
    watch, told = addon.render.loop.WATCH, []
    for frame in options["farm"]["frames"]:
        wrong = _ready(scene, options, addon, {"frame": frame["frame"]})
        if wrong:
            return wrong
        watch.checkpoint = ""
        joined = [(part, film, tuple(slots)) for part, film, slots in frame["parts"]]
        share = addon.render.loop.Share(agreement=frame["agreement"], joined=joined, is_whole=frame["is_whole"])
        watch.share = share
        addon.render.statistics.forget()
        output = Path(frame["picture"])
        problem = rendering.render_into(str(output), scene, addon, options, voice)
        if problem is not None:
            return problem
        told.append(
            {"frame": frame["frame"], "taken": share.taken, "refused": share.refused, "is_whole": share.is_whole}
        )
        if watch.stop.is_set():
            raise KeyboardInterrupt
    return {"frames": told}


def _ready(scene: Any, options: dict[str, Any], addon: Any, take: dict[str, Any]) -> str | None:
    """Sets the scene for a part of a frame; the error, if any."""
    import bpy

    asked = options["farm"]
    if bpy.app.version_string != asked["blender"]:
        return (
            f"the job was planned with Blender {asked['blender']}, and this is {bpy.app.version_string}: use that one"
        )
    wrong = rendering.apply(scene, type(options)(options | take), addon, {})
    # Parts end when their samples are there, not by a clock.
    sampling = addon.export.sampling
    if sampling.follows_cycles(scene, sampling.OF_RENDER):
        scene.cycles.time_limit = 0.0
    else:
        scene.petzval.time_limit = 0.0
    # What was sent for a frame before has other numbers than what is sent for one alone, by which scenes are compared.
    scene.render.use_persistent_data = False
    if asked.get("most_memory_mb"):
        scene.petzval.memory_limit = asked["most_memory_mb"] / 1000.0
    return wrong
