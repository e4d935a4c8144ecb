# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of `petzval render` that runs where Blender is: opens the scene, sets the camera, renders, saves.

Imported in bpy, or run as a script by `blender -b --python render_in_blender.py -- OPTIONS`.
"""

from __future__ import annotations

import json
import os
import sys
import time

_INTERRUPTED = 130


def render(options: dict) -> int:
    """Renders as `render_command` has checked the options; gives the exit status and has said what went wrong."""
    import bpy

    from petzval import load_addon

    addon = load_addon()
    if not hasattr(bpy.types.Scene, "petzval"):
        addon.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=options["scene"], load_ui=False, use_scripts=False)
    except RuntimeError as error:
        return _complain(f"cannot open {options['scene']}: {_one_line(error)}: is it a .blend of this Blender or older")
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    error = _apply(scene, options)
    if error:
        return _complain(error)
    loop = sys.modules[f"{addon.__name__}.loop"]
    loop.watcher = _progress_bar() if sys.stderr.isatty() else None
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        problem = None
    except RuntimeError as error:
        problem = _one_line(error)
    except KeyboardInterrupt:
        problem = None
    outcome = loop.last.get(scene.name)
    if outcome is None or not outcome.stats or outcome.error:
        return _complain(outcome.error if outcome and outcome.error else problem or "nothing was rendered")
    if problem:
        return _complain(problem)
    if options["stats"]:
        _write_stats(options["stats"], outcome)
    return _INTERRUPTED if outcome.interrupted else 0


def finish(status: int) -> None:
    """Ends the process: bpy with a render engine registered hangs or crashes when Python ends by itself."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def _apply(scene, o: dict) -> str | None:
    """Sets what the command line asked for; the error, if any."""
    r = scene.render
    if o["resolution"]:
        r.resolution_x, r.resolution_y = o["resolution"]
        r.resolution_percentage = 100
    if o["frame"] is not None:
        scene.frame_set(o["frame"])
    if o["threads"] is not None:
        r.threads_mode = "FIXED" if o["threads"] else "AUTO"
        if o["threads"]:
            r.threads = o["threads"]
    for name in ("samples", "seed", "sample_offset"):
        if o[name] is not None:
            setattr(scene.petzval, name, o[name])
    r.filepath = o["output"]
    r.use_file_extension = False
    settings = r.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    if o["output"].lower().endswith(".exr"):
        settings.file_format = "OPEN_EXR"
        settings.color_depth = "32"
    else:
        settings.file_format = "PNG"
    settings.color_mode = "RGBA" if r.film_transparent else "RGB"
    if scene.camera is None:
        return f"no camera in scene '{scene.name}' of {o['scene']}: add one, or make one active"
    if scene.camera.type != "CAMERA":
        return f"'{scene.camera.name}' in {o['scene']} is no camera: make a camera the active one"
    _apply_camera(scene, scene.camera.data, o)
    return None


def _apply_camera(scene, data, o: dict) -> None:
    own = data.petzval
    if o["camera"]:
        own.model = o["camera"].upper()
    if o["lens"]:
        own.model = "LENS"
        own.lens_file = o["lens"]
    if o["focal_length_mm"] is not None:
        if own.model == "LENS":
            own.focal_mode = "MILLIMETRES"
            own.focal_length_mm = o["focal_length_mm"]
        else:
            data.lens = o["focal_length_mm"]
    if o["f_number"] is not None:
        own.wide_open = False
        own.f_number = o["f_number"]
    if o["blades"] is not None:
        own.blades = o["blades"]
    if o["scale_mm"]:
        own.scale_auto = False
        own.scale_locked = False
        own.scale_x, own.scale_y, own.scale_z = o["scale_mm"]
    if o["focus_distance_mm"] == "inf":
        own.focus_mode = "INFINITY"
    elif o["focus_distance_mm"] is not None:
        own.focus_mode = "FOCUS"
        data.dof.focus_object = None
        data.dof.focus_distance = o["focus_distance_mm"] / own.scale_mm_per_unit(scene)[2]
    if o["film_mm"]:
        own.film_width_mm, own.film_height_mm = o["film_mm"]
    for option, name in (("tilt_rad", "tilt"), ("swing_rad", "swing")):
        if o[option] is not None:
            setattr(own, name, o[option])
    if o["shift_mm"]:
        own.shift_x_mm, own.shift_y_mm = o["shift_mm"]
    if o["spectrum"] is not None:
        own.use_spectrum = o["spectrum"]


def _write_stats(path: str, outcome) -> None:
    import resource

    stats = {
        **outcome.stats,
        "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "plan": [],
        "warnings": outcome.warnings,
        "interrupted": outcome.interrupted,
    }
    with open(path, "w", encoding="utf-8") as out:
        json.dump(stats, out, indent=2)
        out.write("\n")


def _progress_bar():
    """A callable that draws one line on stderr: how much is done, and how long the rest will take."""
    started = time.monotonic()

    def show(part: float, sample: int, samples: int) -> None:
        width = 30
        done = int(part * width)
        left = (time.monotonic() - started) * (1.0 - part) / part if part > 0.01 else None
        rest = f"{left:.0f} s left" if left is not None else ""
        end = "\n" if part >= 1.0 else ""
        bar = "#" * done + "." * (width - done)
        sys.stderr.write(f"\r[{bar}] {part:4.0%}  sample {sample}/{samples}  {rest:<12}{end}")
        sys.stderr.flush()

    return show


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).removeprefix("Error: ").split())


def _complain(text: str) -> int:
    sys.stderr.write(f"petzval: {text}\n")
    return 1


def _main() -> None:
    options = json.loads(sys.argv[sys.argv.index("--") + 1])
    sys.path.insert(0, options["package_parent"])
    finish(render(options))


if __name__ == "__main__":
    _main()
