# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of `petzval render`, `plan` and `cost` that runs where Blender is: opens the scene, sets the camera, renders,
saves.

Imported in bpy, or run as a script by `blender -b --python render_in_blender.py -- OPTIONS`.
"""

from __future__ import annotations

import json
import math
import os
import struct
import sys
import zlib
from pathlib import Path
from typing import Any, TextIO

_BAD_USAGE, _INTERRUPTED = 2, 130


class _Options(dict[str, Any]):
    """The options of a command; None for those of other commands."""

    def __missing__(self, name: str) -> None:
        return None


#: The engine's integrators by the command's words.
_INTEGRATORS = {"path": "PATH", "bdpt": "BIDIRECTIONAL"}


class OutOfRange(Exception):
    """A value that Blender would silently clamp; the message says from where to where values go."""


#: Blender's names of settings whose option is called otherwise.
_OPTIONS = {"resolution_x": "resolution", "resolution_y": "resolution", "film_width": "film", "film_height": "film",
            "lens": "focal-length", "sensor_width": "film", "sensor_height": "film", "focus_distance": "focus-distance",
            "shift_x": "shift", "shift_y": "shift", "wavelength": "spectrum", "autofocus_point": "autofocus"}  # fmt: skip


class _Strict:
    """The settings of something in Blender, which takes no value that it would change."""

    def __init__(self, owner: Any) -> None:
        object.__setattr__(self, "_owner", owner)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._owner, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._owner, name, value)
        kept = getattr(self._owner, name)
        values, kept_values = (value, kept) if hasattr(kept, "__len__") else ((value,), (kept,))
        for asked, got in zip(values, kept_values, strict=False):
            # Blender's numbers are of single precision.
            if type(asked) in (int, float) and not math.isclose(asked, got, rel_tol=1e-6, abs_tol=1e-12):
                raise OutOfRange(self._said(name, asked))

    def _said(self, name: str, asked: float) -> str:
        kind = self._owner.bl_rna.properties[name]
        unit, factor = (" degrees", 180.0 / math.pi) if kind.subtype == "ANGLE" else ("", 1.0)
        numbers = (asked, kind.hard_min, kind.hard_max)
        shown, low, high = (str(one) if isinstance(one, int) else f"{factor * one:.6g}" for one in numbers)
        option = _OPTIONS.get(name, name.replace("_", "-"))
        return f"bad usage: --{option} {shown}: must be from {low} to {high}{unit}; see petzval render --help"


def render(options: dict[str, Any]) -> int:
    """Renders as `render_command` has checked the options, or plans as `plan_command` has, or measures as `cost_command`
    has; returns the exit status after the error was printed."""
    from petzval.errors import AGAIN, TryAgain

    voice = _own_stderr(options.get("stderr_fd"))
    try:
        error, interrupted = _render(_Options(options), voice)
    except KeyboardInterrupt:
        return _INTERRUPTED
    except OutOfRange as refused:
        print("petzval:", refused, file=voice, flush=True)
        return _BAD_USAGE
    except TryAgain as failed:
        print("petzval:", _one_line(failed), file=voice, flush=True)
        return AGAIN
    if error:
        print("petzval:", " ".join(error.split()), file=voice, flush=True)
        return 1
    return _INTERRUPTED if interrupted else 0


def finish(status: int) -> None:
    """Ends the process: bpy with a render engine registered hangs or crashes when Python ends by itself."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def _own_stderr(fd: int | None) -> TextIO:
    """The terminal's stderr for Petzval alone; Blender's output there goes to stdout from here on."""
    from petzval import processes

    own = os.dup(2) if fd is None else processes.taken_over(fd)
    voice = os.fdopen(own, "w", buffering=1, errors="replace")
    sys.stdout.flush()
    os.dup2(1, 2)
    return voice


def _render(options: dict[str, Any], voice: TextIO) -> tuple[str | None, bool]:
    """The error message of a render, if any; and whether the render was broken off."""
    try:
        import bpy
    except ImportError as error:
        return f"no Blender in this Python: {error}: pip install bpy, or name a Blender with --blender", False

    from petzval import blender_faults, interrupts, load_addon
    from petzval.progress_bar import ProgressBar

    addon = load_addon()
    if not hasattr(bpy.types.Scene, "petzval"):
        addon.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=options["scene"], load_ui=False, use_scripts=False)
    except RuntimeError as error:
        return f"cannot open {options['scene']}: {_one_line(error)}: is it a .blend of this Blender or older", False
    scene = bpy.context.scene
    for name in blender_faults.keep_fluids(scene):
        print(
            f"petzval: object {name!r}: Blender as a Python module simulates no fluid; bake it, or name a Blender with --blender",
            file=voice,
        )
    scene.render.engine = addon.engine.ENGINE
    watch = addon.render.loop.WATCH
    watch.study = study = _study(options.get("study"), scene, watch)
    watch.checkpoint_every_s = options["checkpoint_every"]
    watch.share = None
    if voice.isatty() and (study is None or study.is_long):
        watch.on_progress = ProgressBar(voice)
    interrupts.ask(watch.stop.set)
    if study is not None:
        watch.checkpoint = ""
        problem = apply(scene, options, addon, {}) or take(scene, watch, writes=False)
        return problem or _save(study, options["answer"], watch.stop.is_set()), watch.stop.is_set()
    if options["farm"]:
        from petzval.farm import in_blender

        return in_blender.run(scene, options, addon, voice), watch.stop.is_set()
    if options["dataset"]:
        from petzval.dataset import in_blender as dataset

        return dataset.run(scene, options, addon, voice), watch.stop.is_set()
    problem, stopped = None, False
    for one in options["takes"]:
        problem, stopped = _picture(scene, _Options(options | one), addon, voice)
        if problem or stopped:
            break
    return problem, stopped


def _picture(scene: Any, options: dict[str, Any], addon: Any, voice: TextIO) -> tuple[str | None, bool]:
    """Renders one picture, with all that is written beside it. The error, if any; and whether the render was broken off: a signal
    that comes when the picture is written breaks nothing off."""
    watch = addon.render.loop.WATCH
    found: dict[str, Any] = {}
    # For each frame: what is animated is set anew by it.
    wrong = apply(scene, options, addon, found)
    if wrong:
        return wrong, False
    watch.checkpoint = options["checkpoint"] or ""
    watch.written_checkpoints.clear()
    watch.raw_problem = ""
    addon.render.statistics.forget()
    problem = render_into(options["output"], scene, addon, options, voice)
    last = addon.render.statistics.last(scene.name)
    if problem is None and options["stats"] and last is not None:
        try:
            _write_stats(Path(options["stats"]), last, found)
        except OSError as failed:
            problem = f"cannot write {options['stats']}: {failed.strerror or failed}: name another file"
    problem = problem or watch.raw_problem or None
    stopped = watch.stop.is_set()
    _end_checkpoints(watch.written_checkpoints, voice, is_done=problem is None and not stopped, stopped=stopped)
    return problem, stopped


def take(scene: Any, watch: Any, *, writes: bool) -> str | None:
    """Renders the scene, into its file if `writes`; returns the error, if any."""
    import bpy

    try:
        bpy.ops.render.render(write_still=writes, scene=scene.name)
    except RuntimeError as failed:
        return _one_line(failed)
    finally:
        if watch.on_progress is not None:
            watch.on_progress.end()
    return None


class _NothingToKeep(Exception):
    """The render was broken off before its first sample."""


def render_into(output: str, scene: Any, addon: Any, options: dict[str, Any], voice: TextIO) -> str | None:
    """Renders into a file that is replaced only by a whole picture; the error, if any."""
    from petzval import view_files

    watch, problem = addon.render.loop.WATCH, None
    _apply_output(scene.render, output, options["mergeable"] or options["passes"])
    if refused := view_files.problem(scene.render):
        return refused
    try:
        with view_files.replacing(Path(output), scene.render, lambda part: _check_picture(part, output)) as part:
            _write_into(scene.render, str(part))
            problem = take(scene, watch, writes=True)
            last = addon.render.statistics.last(scene.name)
            if problem is None and last is None and not watch.stop.is_set():
                problem = f"nothing was rendered: {options['scene']}: look at what Blender said"
            if problem is not None and part.name in problem:
                raise OSError("Blender cannot write it")
            if problem is not None or last is None or not last.stats["samples_mean"]:
                raise _NothingToKeep
    except _NothingToKeep:
        if problem is None:
            print(f"petzval: broken off before the first sample: {output} is not written", file=voice)
    except OSError as failed:
        kept = "".join(f"; the render is kept in {one.path}" for one in watch.written_checkpoints)
        problem = f"cannot write {output}: {failed.strerror or failed}: is there room, and may you write there{kept}"
    return problem


def _check_picture(file: Path, output: str) -> None:
    """Raises `OSError` where a picture that Blender wrote is not whole: it does not always say when a disk is full."""
    from petzval import _native

    whole = OSError("the picture is not whole on the disk")
    try:
        if output.lower().endswith(".exr"):
            _native.check_exr(file)
        elif not _is_whole_png(file.read_bytes()):
            raise whole
    except (_native.PetzvalError, struct.error):
        raise whole from None


def _is_whole_png(data: bytes) -> bool:
    """True if all chunks are there, each with the checksum that it names."""
    at = 8
    while data[at : at + 8]:
        length, kind = struct.unpack_from(">I4s", data, at)
        (checksum,) = struct.unpack_from(">I", data, at + 8 + length)
        if zlib.crc32(data[at + 4 : at + 8 + length]) != checksum:
            return False
        at += 12 + length
        if kind == b"IEND":
            return True
    return False


def _end_checkpoints(checkpoints: list[Any], voice: TextIO, *, is_done: bool, stopped: bool) -> None:
    """Deletes the checkpoints of a render that is done; prints the places of those of a render that was broken off."""
    for checkpoint in checkpoints:
        if is_done:
            checkpoint.delete()
        elif stopped:
            print(f"petzval: kept in {checkpoint.path}: the same command goes on from there", file=voice)


def _study(asked: dict[str, Any] | None, scene: Any, watch: Any) -> Any:
    """The study that runs instead of a render, if one is asked for."""
    if asked is None:
        return None
    if asked["what"] == "plan":
        from petzval.plan_study import PlanStudy

        return PlanStudy()
    from petzval.cost.runs import Study

    return Study(asked | {"exposure_stops": scene.view_settings.exposure}, watch)


def _save(study: Any, file: str, interrupted: bool) -> str | None:
    """Writes the results for the command; returns the error, if any."""
    if study.found is None:
        return None if interrupted else "nothing was measured: look at what Blender said"
    with open(file, "w", encoding="utf-8") as out:
        json.dump(study.found, out)
    return None


def apply(scene: Any, o: dict[str, Any], addon: Any, found: dict[str, Any]) -> str | None:
    """Sets the options of the command line; returns the error, if any. Values that had to be found go into `found`."""
    r, own = _Strict(scene.render), _Strict(scene.petzval)
    if scene.camera is None:
        return f"no camera in scene '{scene.name}' of {o['scene']}: add one, or make one active"
    if scene.camera.type != "CAMERA":
        return f"'{scene.camera.name}' in {o['scene']} is no camera: make a camera the active one"
    if o["resolution"]:
        r.resolution_x, r.resolution_y = o["resolution"]
        r.resolution_percentage = 100
    if o["frame"] is not None:
        scene.frame_set(o["frame"])
    if o["threads"] is not None:
        r.threads_mode = "FIXED" if o["threads"] else "AUTO"
        if o["threads"]:
            r.threads = o["threads"]
    _apply_sampling(scene, own, o, addon)
    if o["blue_noise"] is not None:
        own.use_blue_noise = o["blue_noise"] == "on"
    elif o["sample_offset"] is not None:
        # Ranges of samples are to make the whole, the first of them, too.
        own.use_blue_noise = False
    if o["denoise"] is not None:
        # Cycles keeps these; a scene has one set of them.
        cycles = _Strict(scene.cycles)
        cycles.use_denoising = o["denoise"] != "off"
        if o["denoise"] != "off" and hasattr(scene.cycles, "denoising_quality"):
            cycles.denoising_quality = o["denoise"].upper()
    if o["pipeline"]:
        own.pipeline = o["pipeline"].upper()
    if o["integrator"]:
        own.integrator = _INTEGRATORS[o["integrator"]]
    if o["light_tracing"]:
        own.use_light_tracing = o["light_tracing"] == "on"
    if o["quality"] is not None:
        own.quality = o["quality"]
    if o["ghost_reflections"] is not None:
        own.ghost_reflections = str(o["ghost_reflections"])
    for name, word in o["effects"].items():
        setattr(scene.petzval.effects, name, word.upper())
    for layer in scene.view_layers if o["mergeable"] else ():
        layer.petzval.use_pass_mergeable = True
    try:
        for camera in addon.export.stereo.cameras(scene):
            _apply_camera(scene, camera, o, addon)
    except RuntimeError as error:  # only the mask is a file that is read here
        return f"cannot read {o['aperture_mask']}: {_one_line(error)}: give --aperture-mask a picture"
    if o["focus_object"]:
        wrong = _apply_focus_object(scene, o)
        if wrong:
            return wrong
    from petzval.description import OF_LENS_FILE

    if o["autofocus"] and scene.camera.data.petzval.model not in OF_LENS_FILE:
        return f"camera '{scene.camera.name}': only a lens can focus by itself: name one with --lens"
    return _apply_sharp(scene, o["sharp"], addon, found) if o["sharp"] else None


def _apply_sampling(scene: Any, own: _Strict, o: dict[str, Any], addon: Any) -> None:
    """Sets the number of samples: options that are not given stay as in the file, but a given number of samples is exactly that."""
    sampling = addon.export.sampling
    asked = {name: o[name] for name in ("samples", "min_samples", "time_limit", "sample_offset") if o[name] is not None}
    if asked or o["noise_threshold"] is not None:
        # From here on Petzval's own count, for all of them.
        sampling.make_own(scene, sampling.OF_RENDER)
    if o["samples"] is not None:
        asked = {"time_limit": 0.0} | asked
        own.use_noise_threshold = False
        if hasattr(scene, "cycles"):
            scene.cycles.use_layer_samples = "IGNORE"
    if o["noise_threshold"] is not None:
        own.use_noise_threshold = o["noise_threshold"] > 0.0
        own.noise_threshold = o["noise_threshold"] or own.noise_threshold
    for name, value in asked.items():
        setattr(own, name, value)
    if o["seed"] is not None:
        own.seed = o["seed"]


def _apply_focus_object(scene: Any, o: dict[str, Any]) -> str | None:
    """Focuses on the origin of an object; the error, if any."""
    import difflib

    name, data = o["focus_object"], scene.camera.data
    chosen = scene.objects.get(name)
    if chosen is None:
        near = difflib.get_close_matches(name, scene.objects.keys(), n=3, cutoff=0.4)
        said = f"; there is {', '.join(near)}" if near else ""
        return f"no object '{name}' in scene '{scene.name}' of {o['scene']}: change --focus-object{said}"
    if chosen == scene.camera:
        return f"'{name}' is the camera itself: change --focus-object"
    data.petzval.focus_mode, data.dof.focus_object = "CAMERA", chosen
    return None


def _apply_sharp(scene: Any, points: list[list[float]], addon: Any, found: dict[str, Any]) -> str | None:
    """Turns the film so that three points of the world are sharp; the error, if any."""
    try:
        film = addon.queries.sharp_points.solve(scene.camera, scene, points)
    except (addon.export.errors.ExportError, addon.native.engine().PetzvalError) as error:
        return str(error)
    found["sharp"] = film
    addon.queries.sharp_points.apply(scene.camera.data, film)
    tilt, swing = math.degrees(film["tilt_rad"]), math.degrees(film["swing_rad"])
    print(f"Petzval: film turned by {tilt:.3f} (tilt) and {swing:.3f} degrees (swing) for the three sharp points")
    return None


def _write_into(r: Any, file: str) -> None:
    """Has Blender write into `file`."""
    import bpy

    # Braces hold templates since Blender 5; doubled, they are braces.
    r.filepath = file.replace("{", "{{").replace("}", "}}") if bpy.app.version >= (5, 0) else file


def _apply_output(r: Any, output: str, of_layers: bool) -> None:
    """Has Blender write pictures of the kind of `output`, their views as the scene has them."""
    # The name is taken as it is; a placeholder for the frame's number is for animations.
    r.use_file_extension = False
    r.use_overwrite = True
    # The engine's picture is what was asked for, not what a compositor or a video strip makes of it.
    r.use_compositing = False
    r.use_sequencer = False
    settings = r.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE" if of_layers else "IMAGE"
    if of_layers:
        settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.color_depth = "32"
    elif output.lower().endswith(".exr"):
        settings.file_format = "OPEN_EXR"
        settings.color_depth = "32"
    else:
        settings.file_format = "PNG"
        settings.color_depth = "8"
    if output.lower().endswith(".exr"):
        # Blender's own may lose something, and what the engine found is to be in the file.
        settings.exr_codec = "ZIP"
    # Layers have all channels of all passes. A scene that is saved in black and white stays so, as when Blender saves it.
    if not of_layers and settings.color_mode != "BW":
        settings.color_mode = "RGBA" if r.film_transparent else "RGB"


def _apply_camera(scene: Any, camera: Any, o: dict[str, Any], addon: Any) -> None:
    from petzval.description import OF_LENS_FILE

    own, data = _Strict(camera.petzval), _Strict(camera)
    if o["camera"] or o["lens"]:
        own.model = (o["camera"] or "lens").upper().replace("-", "_")
    if o["lens"]:
        own.lens_file = o["lens"]
    if o["calibration"]:
        own.model, own.calibration_file, own.calibration_camera, own.calibration_body = (
            "CALIBRATED",
            o["calibration"],
            "",
            "",
        )
    if o["calibration_camera"]:
        own.calibration_camera = o["calibration_camera"]
    if o["calibration_body"]:
        own.calibration_body = o["calibration_body"]
    if own.model == "CALIBRATED" and any(o[name] is not None for name in o["opening"]):
        data.dof.use_dof = True
    if o["focal_length"] is not None:
        if own.model in OF_LENS_FILE:
            own.focal_mode = "LENGTH"
            own.focal_length = o["focal_length"]
        else:
            data.lens = o["focal_length"]
    if any(o[name] is not None for name in o["opening"]):
        own.wide_open, own.pupil_diameter = False, 0.0
    for name in o["properties"]:
        if o[name] is not None:
            setattr(own, name, o[name])
    if o["aperture_mask"]:
        own.aperture_mask = addon.export.aperture_mask.load(o["aperture_mask"])
    elif o["blades"] is not None:
        own.aperture_mask = None
    if o["coating"]:
        own.coating = o["coating"].upper().replace("-", "_")
    if o["expose_by"]:
        own.exposes_by_f_number = o["expose_by"] == "f-number"
    if o["white_balance"]:
        own.white_balance = o["white_balance"] == "on"
    if o["scale"]:
        own.scale_from_scene = False
        own.scale_locked = False
        own.scale = o["scale"]
    if o["anchor"]:
        own.anchor = o["anchor"].upper().replace("-", "_")
    if o["focus_relation"]:
        own.focus_relation = o["focus_relation"].upper()
    if o["autofocus"]:
        own.focus_mode, own.autofocus_point = "AUTO", o["autofocus"]
    if o["focus_distance"] == "inf":
        own.focus_mode = "INFINITY"
    elif o["focus_distance"] is not None:
        own.focus_mode = "CAMERA"
        data.dof.focus_object = None
        # Blender's distance is in units of the scene.
        data.dof.focus_distance = o["focus_distance"] / addon.export.camera.scale(own, scene)[2]
    if o["film"] == "lens":
        own.film_mode = "LENS"
    elif o["film"]:
        own.film_mode = "SIZE"
        own.film_width, own.film_height = o["film"]
    if o["shutter"] or o["iso"]:
        own.physical_exposure = True
        own.shutter, own.iso = o["shutter"] or own.shutter, o["iso"] or own.iso
    if o["sensor"]:
        own.use_sensor, own.sensor = True, o["sensor"]
    if o["raw"]:
        # Its number, if it has one, is entered.
        own.raw_file = o["raw"]
    if o["film_diagonal"] is not None:
        from petzval.film_formats import with_diagonal

        shape = (own.film_width, own.film_height)
        if own.film_mode != "SIZE":
            shape = addon.export.camera.resolution(scene.render)
        own.film_mode = "SIZE"
        own.film_width, own.film_height = with_diagonal(*shape, o["film_diagonal"])
    if own.model not in OF_LENS_FILE and (isinstance(o["film"], list) or o["film_diagonal"] is not None):
        # A camera without a lens has Blender's sensor, which is as high as the picture's shape says.
        data.sensor_fit, data.sensor_width, data.sensor_height = "HORIZONTAL", own.film_width, own.film_height
    if isinstance(o["spectrum"], float):
        own.spectrum, own.wavelength = "SINGLE", o["spectrum"]
    elif o["spectrum"]:
        own.spectrum = o["spectrum"]
    if o["precision"]:
        own.precision = o["precision"].upper()
    if o["shift"]:
        own.shift_x, own.shift_y = o["shift"]


def _write_stats(path: Path, last: Any, found: dict[str, Any]) -> None:
    from petzval import _native, atomic_files

    stats = {**last.stats, **found, "processor": _native.PROCESSOR, "peak_memory_mb": _peak_memory_mb(),
             "warnings": last.warnings, "interrupted": last.stopped}  # fmt: skip
    atomic_files.write_json(path, stats, indent=2)


def _peak_memory_mb() -> float | None:
    try:
        import resource
    except ImportError:  # Windows has none
        return None
    # Kilobytes, but bytes on a Mac.
    unit = 1024.0**2 if sys.platform == "darwin" else 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def _one_line(error: BaseException) -> str:
    return " ".join(part for part in str(error).split() if part != "Error:")


def _main() -> None:
    options = json.loads(sys.argv[sys.argv.index("--") + 1])
    sys.path.insert(0, options["package_parent"])
    from petzval import interrupts, processes

    interrupts.listen_by_handlers()
    # Signals that come earlier are heard by the program before this one.
    os.write(processes.taken_over(options["ready_fd"]), b".")
    # As scene_options reads it.
    status = render(options)
    from petzval.errors import AGAIN

    finish({0: 70, 1: 71, _BAD_USAGE: 72, AGAIN: 73}.get(status, status))


if __name__ == "__main__":
    _main()
