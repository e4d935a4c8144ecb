# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of `petzval render`, `plan` and `cost` that runs where Blender is: opens the scene, sets the camera, renders,
saves.

Imported in bpy, or run as a script by `blender -b --python render_in_blender.py -- OPTIONS`.
"""

from __future__ import annotations

import glob
import json
import math
import os
import signal
import sys
import time
from typing import Any, TextIO

_INTERRUPTED = 130
# A terminal and the program before this one may both hand on one Ctrl-C; only a later one means: at once.
_ONE_KEYPRESS_SECONDS = 1.0


def render(options: dict) -> int:
    """Renders as `render_command` has checked the options, or plans as `plan_command` has, or measures as `cost_command`
    has; gives the exit status and has said what went wrong."""
    voice = _own_stderr(options.get("stderr_fd"))
    try:
        error, interrupted = _render(options, voice)
    except KeyboardInterrupt:
        return _INTERRUPTED
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
    """The terminal's stderr for Petzval alone; what Blender says there goes to stdout from here on."""
    voice = os.fdopen(os.dup(2) if fd is None else fd, "w", buffering=1, errors="replace")
    sys.stdout.flush()
    os.dup2(1, 2)
    return voice


def _render(options: dict, voice: TextIO) -> tuple[str | None, bool]:
    """What went wrong, if something did; and whether the render was broken off."""
    try:
        import bpy
    except ImportError as error:
        return f"no Blender in this Python: {error}: pip install bpy, or name a Blender with --blender", False

    from petzval import load_addon
    from petzval.progress_bar import ProgressBar

    addon = load_addon()
    if not hasattr(bpy.types.Scene, "petzval"):
        addon.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=options["scene"], load_ui=False, use_scripts=False)
    except RuntimeError as error:
        return f"cannot open {options['scene']}: {_one_line(error)}: is it a .blend of this Blender or older", False
    scene = bpy.context.scene
    scene.render.engine = addon.engine.ENGINE
    found: dict[str, Any] = {}
    error = _apply(scene, options, addon, found)
    if error:
        return error, False
    watch = addon.loop.WATCH
    watch.study = study = _study(options.get("study"), scene, watch)
    watch.checkpoint, watch.checkpoint_every_s = options["checkpoint"], options["checkpoint_every_s"]
    if voice.isatty() and (study is None or study.is_long):
        watch.on_progress = ProgressBar(voice)
    _stop_on_interrupt(watch)
    problem = None
    try:
        bpy.ops.render.render(write_still=study is None, scene=scene.name)
    except RuntimeError as failed:
        problem = _one_line(failed)
    interrupted = watch.stop.is_set()
    if watch.on_progress is not None:
        watch.on_progress.end()
    if study is not None:
        return problem or _save(study, options["answer"], interrupted), interrupted
    last = addon.statistics.last(scene.name)
    if problem is None and last is None and not interrupted:
        problem = f"nothing was rendered: {options['scene']}: look at what Blender said"
    if problem is None and not os.path.isfile(options["output"]):
        problem = f"cannot write {options['output']}: is there room, and may you write there"
    if problem is None and options["stats"] and last is not None:
        try:
            _write_stats(options["stats"], last, found)
        except OSError as failed:
            problem = f"cannot write {options['stats']}: {failed.strerror}: name another file"
    if problem is None:
        _end_checkpoints(options["checkpoint"], interrupted, voice)
    return problem, interrupted


def _end_checkpoints(file: str, interrupted: bool, voice: TextIO) -> None:
    """What was kept of a render goes when its picture is written; of one that was broken off it is said where it is."""
    # View layers have files of their own (addon/checkpoints.py).
    for kept in [file, *glob.glob(glob.escape(file) + "." + 12 * "[0-9a-f]")]:
        if not os.path.isfile(kept):
            continue
        if interrupted:
            print(f"petzval: kept in {kept}: the same command goes on from there", file=voice)
        else:
            os.unlink(kept)


def _study(asked: dict | None, scene: Any, watch: Any) -> Any:
    """What is to be done instead of a render, if something is."""
    if asked is None:
        return None
    if asked["what"] == "plan":
        from petzval.plan_study import PlanStudy

        return PlanStudy()
    from petzval.cost.runs import Study

    return Study(asked | {"exposure_stops": scene.view_settings.exposure}, watch)


def _save(study: Any, file: str, interrupted: bool) -> str | None:
    """Leaves what was found for the command; the error, if any."""
    if study.found is None:
        return None if interrupted else "nothing was measured: look at what Blender said"
    with open(file, "w", encoding="utf-8") as out:
        json.dump(study.found, out)
    return None


def _stop_on_interrupt(watch: Any) -> None:
    """Ctrl-C asks the render to stop and to keep what is there; once more, later, ends everything."""
    first: list[float] = []

    def asked(_signal: int, _frame: object) -> None:
        now = time.monotonic()
        if first and now - first[0] > _ONE_KEYPRESS_SECONDS:
            os._exit(_INTERRUPTED)
        first.append(now)
        watch.stop.set()

    signal.signal(signal.SIGINT, asked)
    signal.signal(signal.SIGTERM, asked)


def _apply(scene: Any, o: dict, addon: Any, found: dict) -> str | None:
    """Sets what the command line asked for; the error, if any. What had to be found goes into `found`."""
    r = scene.render
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
    for name in ("samples", "min_samples", "time_limit", "seed", "sample_offset"):
        if o[name] is not None:
            setattr(scene.petzval, name, o[name])
    if o["blue_noise"] is not None:
        scene.petzval.use_blue_noise = o["blue_noise"] == "on"
    if o["noise_threshold"] is not None:
        scene.petzval.use_noise_threshold = o["noise_threshold"] > 0.0
        scene.petzval.noise_threshold = o["noise_threshold"] or scene.petzval.noise_threshold
    if o["pipeline"]:
        scene.petzval.pipeline = o["pipeline"].upper()
    if o["integrator"]:
        scene.petzval.integrator = o["integrator"]
    if o["quality"] is not None:
        scene.petzval.quality = o["quality"]
    if o["ghost_reflections"] is not None:
        scene.petzval.ghost_reflections = str(o["ghost_reflections"])
    for name, word in o["effects"].items():
        setattr(scene.petzval.effects, name, word.upper())
    if o["output"] is not None:
        _apply_output(r, o["output"], o["mergeable"] or o["passes"])
    for layer in scene.view_layers if o["mergeable"] else ():
        layer.petzval.use_pass_mergeable = True
    try:
        _apply_camera(scene, scene.camera.data, o, addon)
    except RuntimeError as error:  # only the mask is a file that is read here
        return f"cannot read {o['aperture_mask']}: {_one_line(error)}: give --aperture-mask a picture"
    if o["autofocus"] and scene.camera.data.petzval.model not in addon.description.OF_LENS_FILE:
        return f"camera '{scene.camera.name}': only a lens can focus by itself: name one with --lens"
    return _apply_sharp(scene, o["sharp"], addon, found) if o["sharp"] else None


def _apply_sharp(scene: Any, points: list[list[float]], addon: Any, found: dict) -> str | None:
    """Turns the film so that three points of the world are sharp; the error, if any."""
    try:
        film = addon.sharp_points.solve(scene.camera, scene, points)
    except (addon.export.errors.ExportError, addon.native.engine().PetzvalError) as error:
        return str(error)
    found["sharp"] = film
    addon.sharp_points.apply(scene.camera.data, film)
    tilt, swing = math.degrees(film["tilt_rad"]), math.degrees(film["swing_rad"])
    print(f"Petzval: film turned by {tilt:.3f} (tilt) and {swing:.3f} degrees (swing) for the three sharp points")
    return None


def _apply_output(r: Any, output: str, of_layers: bool) -> None:
    r.filepath = output
    # The name is taken as it is; a placeholder for the frame's number is for animations.
    r.use_file_extension = False
    r.use_overwrite = True
    # The engine's picture is what was asked for, not what a compositor or a video strip makes of it.
    r.use_compositing = False
    r.use_sequencer = False
    r.use_multiview = False
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
    if not of_layers:  # which has all channels of all passes
        settings.color_mode = "RGBA" if r.film_transparent else "RGB"


def _apply_camera(scene: Any, data: Any, o: dict, addon: Any) -> None:
    own = data.petzval
    if o["camera"] or o["lens"]:
        own.model = (o["camera"] or "lens").upper().replace("-", "_")
    if o["lens"]:
        own.lens_file = o["lens"]
    if o["focal_length_mm"] is not None:
        if own.model in addon.description.OF_LENS_FILE:
            own.focal_mode = "LENGTH"
            own.focal_length = o["focal_length_mm"]
        else:
            data.lens = o["focal_length_mm"]
    if o["f_number"] is not None:
        own.wide_open = False
        own.pupil_diameter = 0.0
        own.f_number = o["f_number"]
    if o["pupil_diameter_mm"] is not None:
        own.wide_open = False
        own.pupil_diameter = o["pupil_diameter_mm"]
    if o["blades"] is not None:
        own.blades = o["blades"]
    for name, option in (("blade_curvature", "blade_curvature"), ("blade_rotation", "blade_rotation_rad")):
        if o[option] is not None:
            setattr(own, name, o[option])
    if o["aperture_mask"]:
        own.aperture_mask = addon.export.aperture_mask.load(o["aperture_mask"])
    elif o["blades"] is not None:
        own.aperture_mask = None
    if o["coating"]:
        own.coating = o["coating"].upper().replace("-", "_")
    if o["expose_by"]:
        own.exposes_by_f_number = o["expose_by"] == "f-number"
    if o["scale_mm"]:
        own.scale_from_scene = False
        own.scale_locked = False
        own.scale = o["scale_mm"]
    if o["anchor"]:
        own.anchor = o["anchor"].upper().replace("-", "_")
    if o["focus_relation"]:
        own.focus_relation = o["focus_relation"].upper()
    if o["autofocus"]:
        own.focus_mode, own.autofocus_point = "AUTO", o["autofocus"]
    if o["focus_distance_mm"] == "inf":
        own.focus_mode = "INFINITY"
    elif o["focus_distance_mm"] is not None:
        own.focus_mode = "CAMERA"
        data.dof.focus_object = None
        # Blender's distance is in units of the scene.
        data.dof.focus_distance = o["focus_distance_mm"] / addon.export.camera.scale(own, scene)[2]
    if o["film_mm"]:
        own.film_mode = "SIZE"
        own.film_width, own.film_height = o["film_mm"]
    if o["shutter_s"] or o["iso"]:
        own.physical_exposure = True
        own.shutter, own.iso = o["shutter_s"] or own.shutter, o["iso"] or own.iso
    if o["film_diagonal_mm"] is not None:
        from petzval.film_formats import with_diagonal

        shape = (own.film_width, own.film_height)
        if own.film_mode != "SIZE":
            shape = addon.export.camera.resolution(scene.render)
        own.film_mode = "SIZE"
        own.film_width, own.film_height = with_diagonal(*shape, o["film_diagonal_mm"])
    if own.model not in addon.description.OF_LENS_FILE and (o["film_mm"] or o["film_diagonal_mm"] is not None):
        # A camera without a lens has Blender's sensor, which is as high as the picture's shape says.
        data.sensor_fit, data.sensor_width, data.sensor_height = "HORIZONTAL", own.film_width, own.film_height
    if isinstance(o["spectrum"], float):
        own.spectrum, own.wavelength = "SINGLE", o["spectrum"]
    elif o["spectrum"]:
        own.spectrum = o["spectrum"]
    if o["precision"]:
        own.precision = o["precision"].upper()
    for option, name in (("tilt_rad", "tilt"), ("swing_rad", "swing")):
        if o[option] is not None:
            setattr(own, name, o[option])
    if o["shift_mm"]:
        own.shift_x, own.shift_y = o["shift_mm"]


def _write_stats(path: str, last: Any, found: dict) -> None:
    from petzval import _native

    stats = {**last.stats, **found, "processor": _native.PROCESSOR, "peak_memory_mb": _peak_memory_mb(),
             "warnings": last.warnings, "interrupted": last.stopped}  # fmt: skip
    with open(path, "w", encoding="utf-8") as out:
        json.dump(stats, out, indent=2)
        out.write("\n")


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
    # As render_command reads it.
    status = render(options)
    finish({0: 70, 1: 71}.get(status, status))


if __name__ == "__main__":
    _main()
