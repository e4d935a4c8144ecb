# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of `petzval dataset` that runs where Blender is: all pictures, one after another, with one start of Blender."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from .. import _native
from .. import render_in_blender as rendering
from ..description import OF_LENS_FILE, changed
from ..errors import CommandError
from . import assembling, cameras, instances, labels, placing, pose_files, poses, records, writing
from .spec import CameraSpec, FromFile, Listed, Orbit, Path_, Spec, read

_AT_ORIGIN = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Picture:
    """One picture that is to be: which camera stands where, when."""

    name: str
    number: int
    camera: CameraSpec
    frame: int
    pose: poses.Matrix
    #: The pictures of the same camera before and after; None: there is none.
    before: tuple[int, poses.Matrix] | None = None
    after: tuple[int, poses.Matrix] | None = None


def run(scene: Any, options: dict[str, Any], addon: Any, voice: TextIO) -> str | None:
    """Renders by the options; returns the error, if any."""
    try:
        _Run(scene, options, addon, voice).run()
    except (CommandError, rendering.OutOfRange) as error:
        return str(error)
    except OSError as error:
        return f"cannot write {error.filename or options['dataset']['spec']}: {error.strerror or error}: is there room, and may you write there"
    return None


class _Run:
    """All of a data set."""

    def __init__(self, scene: Any, options: dict[str, Any], addon: Any, voice: TextIO) -> None:
        self._scene, self._addon, self._voice = scene, addon, voice
        self._asked = options["dataset"]
        self._spec: Spec = read(Path(self._asked["spec"]))
        self._folder = self._spec.output
        self._watch = addon.render.loop.WATCH
        self._scene_hash = records.hash_of_file(self._spec.scene)
        self._start = scene.frame_current
        self._holders: dict[str, Any] = {}
        self._done = 0
        self._known: dict[str, dict[str, Any]] = {}

    def run(self) -> None:
        """Renders the missing pictures, and writes the files that are about all of them."""
        self._ready_scene()
        pictures = self._pictures()
        keys = {one.name: self._key(one) for one in pictures}
        whole = (
            {} if self._asked["again"] else {name: records.whole(self._folder, name, key) for name, key in keys.items()}
        )
        if self._asked["dry_run"]:
            self._tell(pictures, whole)
            return
        missing = [one for one in pictures if not whole.get(one.name)]
        print(f"{len(pictures) - len(missing)} of {len(pictures)} pictures are there", flush=True)
        for kind in ("records", ".work"):
            (self._folder / kind).mkdir(parents=True, exist_ok=True)
        table = instances.Instances(self._folder / "instances.json", self._scene_hash, self._spec.classes)
        self._name_unmatched()
        bar = self._watch.on_progress
        for one in missing:
            if bar is not None:
                self._watch.on_progress = _Overall(bar, self._done, len(missing))
            whole[one.name] = self._picture(one, keys[one.name], table)
            if self._watch.stop.is_set():
                break
            self._done += 1
            print(f"{one.name}: written, {self._done} of {len(missing)}", flush=True)
        found = [record for one in pictures if (record := whole.get(one.name)) is not None]
        assembling.assemble(self._folder, self._spec, found)
        if self._watch.stop.is_set():
            self._voice.write(
                f"petzval: broken off: {len(found)} of {len(pictures)} pictures are whole; the same command goes on\n"
            )

    def _ready_scene(self) -> None:
        render = self._scene.render
        # A picture is all of what one camera sees.
        render.use_border = render.use_multiview = render.use_persistent_data = False
        # Dates and durations in files would be other ones in each run.
        for one in render.bl_rna.properties:
            if one.identifier.startswith("use_stamp"):
                setattr(render, one.identifier, False)
        self._watch.checkpoint = ""
        if not any(layer.use for layer in self._scene.view_layers):
            raise CommandError(f"scene '{self._scene.name}' renders no view layer: turn one on")

    # Which pictures there are.

    def _pictures(self) -> list[Picture]:
        spec = self._spec
        frames, matrices = self._poses()
        digits = max(len(str(len(matrices) - 1)), 4)
        found = []
        for camera in spec.cameras:
            in_rig = camera.in_rig.resolved(self._place_of)
            own = [one @ in_rig for one in matrices]
            for i, (frame, pose) in enumerate(zip(frames, own, strict=True)):
                name = f"{i:0{digits}d}" if len(spec.cameras) == 1 else f"{camera.name}_{i:0{digits}d}"
                before = (frames[i - 1], own[i - 1]) if i else None
                after = (frames[i + 1], own[i + 1]) if i + 1 < len(own) else None
                found.append(Picture(name, i, camera, frame, pose, before, after))
        return found

    def _poses(self) -> tuple[list[int], list[poses.Matrix]]:
        """Frames and poses, as many of each."""
        spec, source = self._spec, self._spec.source
        self._scene.frame_set(spec.frames[0] if spec.frames else self._start)
        if isinstance(source, Path_):
            assert spec.frames is not None
            return list(spec.frames), placing.along(source, self._scene, spec.frames, self._place_of)
        own_frames: list[int | None]
        if isinstance(source, Listed | FromFile):
            listed = (
                source.poses
                if isinstance(source, Listed)
                else pose_files.read(source.file, source.format, self._metres())
            )
            try:
                matrices = [one.resolved(self._place_of) for one in listed]
            except ValueError as error:
                raise CommandError(f"{spec.file}: pose: {error}") from None
            own_frames = [one.frame for one in listed]
        else:
            if isinstance(source, Orbit):
                centre = self._resolved(source.centre)
                matrices = poses.orbit(centre, source.radius, source.elevation_deg, source.count, source.start_deg)
            else:
                import bpy

                around = placing.Surroundings(bpy.context.evaluated_depsgraph_get())
                target = None if source.target is None else self._resolved(source.target)
                matrices, refused = placing.random(source, self._resolved(source.centre), target, around)
                for why, count in refused.most_common():
                    print(f"[random] {count} candidates refused: {why}", flush=True)
            own_frames = [None] * len(matrices)
        if spec.frames is not None:
            if any(one is not None for one in own_frames):
                raise CommandError(f"{spec.file}: the poses have frames of their own: leave out frames")
            if len(spec.frames) != len(matrices):
                raise CommandError(
                    f"{spec.file}: there are {len(matrices)} poses and {len(spec.frames)} frames: give as many of both"
                )
            return list(spec.frames), matrices
        return [self._start if one is None else one for one in own_frames], matrices

    def _resolved(self, place: poses.Vector | str) -> poses.Vector:
        return self._place_of(place) if isinstance(place, str) else place

    def _place_of(self, name: str) -> poses.Vector:
        chosen = self._scene.objects.get(name)
        if chosen is None:
            import difflib

            near = difflib.get_close_matches(name, self._scene.objects.keys(), n=3, cutoff=0.4)
            hint = f"; there is {', '.join(near)}" if near else ""
            raise CommandError(f"{self._spec.file}: no object '{name}' in scene '{self._scene.name}'{hint}")
        x, y, z = chosen.matrix_world.translation
        return (x, y, z)

    def _metres(self) -> float:
        return float(self._scene.unit_settings.scale_length)

    def _key(self, one: Picture) -> str:
        spec = self._spec
        options = {name: value for name, value in one.camera.options.items() if name not in ("threads", "scene")}
        is_flow = spec.write.flow != "off"
        return records.key_of(
            {
                "scene": self._scene_hash, "engine": _native.__version__, "blender": self._blender_version(), "options": options,
                "from": one.camera.based_on, "labels": asdict(spec.labels), "write": asdict(spec.write),
                "classes": [asdict(made) for made in spec.classes], "frame": one.frame, "number": one.number,
                "pose": one.pose.round(9).tolist(),
                "beside": [(then[0], then[1].round(9).tolist()) for then in (one.before, one.after) if then] if is_flow else None,
            }
        )  # fmt: skip

    @staticmethod
    def _blender_version() -> str:
        import bpy

        version: str = bpy.app.version_string
        return version

    def _tell(self, pictures: list[Picture], whole: dict[str, Any]) -> None:
        for one in pictures:
            x, y, z = one.pose[:3, 3]
            state = "there" if whole.get(one.name) else "to render"
            print(f"{one.name}: frame {one.frame}, camera {one.camera.name} at {x:.4g}, {y:.4g}, {z:.4g}: {state}")
        count = sum(not whole.get(one.name) for one in pictures)
        print(f"{count} of {len(pictures)} pictures to render into {self._folder}", flush=True)

    def _name_unmatched(self) -> None:
        import bpy

        # Those of instanced collections, too, which the scene does not list.
        objects = list(bpy.data.objects)
        for made in self._spec.classes:
            for what in instances.unmatched(objects, made):
                self._voice.write(
                    f"petzval: {self._spec.file}: classes.{made.name}: {what} matches nothing in scene '{self._scene.name}'\n"
                )

    # One picture.

    def _holder(self, camera: CameraSpec) -> Any:
        """The camera object that stands for one of the rig: a copy without the animation and constraints of the scene's own."""

        if camera.name not in self._holders:
            scene = self._scene
            base = scene.objects.get(camera.based_on) if camera.based_on else self._first_camera()
            if base is None or base.type != "CAMERA":
                named = f"'{camera.based_on}'" if camera.based_on else "an active camera"
                raise CommandError(
                    f"{self._spec.file}: camera {camera.name}: no {named} in scene '{scene.name}': name a camera with from"
                )
            made = base.copy()
            made.data = base.data.copy()
            made.name = f"petzval dataset {camera.name}"
            made.parent = None
            made.animation_data_clear()
            made.constraints.clear()
            scene.collection.objects.link(made)
            self._holders[camera.name] = made
        holder = self._holders[camera.name]
        # Markers would bring another camera with each frame.
        for marker in self._scene.timeline_markers:
            marker.camera = None
        self._scene.camera = holder
        return holder

    def _first_camera(self) -> Any:
        if not hasattr(self, "_base"):
            self._base = self._scene.camera
        return self._base

    def _picture(self, one: Picture, key: str, table: instances.Instances) -> records.Record | None:
        """Renders a picture and all that is written of it; None where it was broken off."""
        scene = self._scene
        self._first_camera()
        holder = self._holder(one.camera)
        size = scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage
        asked = rendering._Options(one.camera.options | {"frame": one.frame})
        asked["seed"] = (asked["seed"] if asked["seed"] is not None else scene.petzval.seed) + one.number
        seed = scene.petzval.seed
        try:
            if wrong := rendering.apply(scene, asked, self._addon, {}):
                raise CommandError(wrong)
            self._stand(holder, one.pose)
            self._check_focus(holder)
            records.forget(self._folder, one.name)
            return self._taken(one, key, table, holder, asked)
        finally:
            scene.petzval.seed = seed
            scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = size

    @staticmethod
    def _stand(holder: Any, pose: poses.Matrix) -> None:
        import bpy
        from mathutils import Matrix

        holder.matrix_world = Matrix(pose.tolist())
        bpy.context.view_layer.update()

    def _check_focus(self, holder: Any) -> None:
        own = holder.data.petzval
        if own.focus_mode == "AUTO" and own.model in OF_LENS_FILE:
            raise CommandError(
                f"camera '{holder.name}' focuses by itself, so that each picture has other intrinsic parameters: give focus-distance"
            )

    def _taken(
        self, one: Picture, key: str, table: instances.Instances, holder: Any, asked: Any
    ) -> records.Record | None:
        scene, spec, watch = self._scene, self._spec, self._watch
        width, height = self._addon.export.camera.resolution(scene.render)
        pose = np.array(holder.matrix_world)
        scale = self._addon.export.camera.scale(holder.data.petzval, scene)
        if len(set(scale)) > 1:
            raise CommandError(
                f"camera '{holder.name}' has another scale along each axis: metres would be of several lengths: change --scale"
            )
        fps = scene.render.fps / scene.render.fps_base
        record = records.Record(
            key, one.name, one.camera.name, one.frame, (one.frame - scene.frame_start) / fps, pose.tolist(), scale[0] / 1000.0, width,
            height, None,
        )  # fmt: skip
        colours: list[Any] = []
        sharp = labels.sharp(holder, spec.labels.f_number)
        try:
            if spec.write.cameras:
                record.intrinsics = self._intrinsics(one, sharp, width, height)
            if spec.write.picture != "off" and not self._photograph(one, record, asked, colours):
                return None
            if writing.needs_passes(spec.write):
                scene.camera = sharp if spec.labels.rays == "centre" else holder
                passes = labels.taken(
                    scene,
                    self._addon,
                    spec.labels,
                    beside=self._beside(one),
                    number_of=lambda place: self._number(place, table),
                )
                if passes is None:
                    return None
                table.classified(self._classes())
                table.save()
                writing.write_passes(
                    self._folder, spec, record, passes, table, one.before is not None, one.after is not None, colours
                )
        finally:
            scene.camera = holder
            labels.removed(sharp)
        if watch.stop.is_set():
            return None
        records.write(self._folder, record)
        return record

    def _intrinsics(self, one: Picture, sharp: Any, width: int, height: int) -> dict[str, Any]:
        """The intrinsics of a camera, computed once for each of its settings."""
        export = self._addon.export
        described = export.camera.describe(sharp, self._scene, width, height, export.report.Report())
        base = self._scene.objects.get(one.camera.based_on) or self._first_camera()
        # Where it stands changes nothing, and nothing is known of it by its copy's name.
        described = changed(described, {"object_name": base.name, "matrix_world": _AT_ORIGIN})
        key = records.key_of([asdict(described), width, height])
        if key not in self._known:
            self._known[key] = cameras.intrinsics(described, width, height).as_json()
        return self._known[key]

    def _photograph(self, one: Picture, record: records.Record, asked: Any, colours: list[Any]) -> bool:
        """Renders the picture itself, and keeps its colours; whether it is whole."""
        end = self._spec.write.picture
        work = self._folder / ".work" / f"{one.name}.{end}"

        def keep(_layer: str, _view: str, name: str, pixels: Any) -> None:
            if name == "Combined":
                colours[:] = [np.flipud(pixels)]

        self._watch.taken = keep
        self._addon.render.statistics.forget()
        try:
            problem = rendering.render_into(str(work), self._scene, self._addon, asked, self._voice)
        finally:
            self._watch.taken = None
        if problem is not None:
            raise CommandError(problem)
        if self._watch.stop.is_set():
            work.unlink(missing_ok=True)
            return False
        (self._folder / "pictures").mkdir(exist_ok=True)
        os.replace(work, self._folder / "pictures" / work.name)
        record.files["picture"] = f"pictures/{work.name}"
        return True

    def _beside(self, one: Picture) -> Any:
        """The pictures before and after, for flow; where there is none, the picture itself."""
        if self._spec.write.flow == "off":
            return None
        kind = self._addon.render.loop.Beside
        own = (one.frame, one.pose)
        return tuple(
            kind(float(frame), tuple(map(tuple, pose.tolist())))
            for frame, pose in (one.before or own, one.after or own)
        )

    def _number(self, place: Any, table: instances.Instances) -> int:
        key = self._addon.export.motion.key(place)
        instancer = place.parent.name_full if place.is_instance and place.parent is not None else None
        about = {"object": place.object.name_full, "instancer": instancer}
        return table.number("|".join(map(str, key)), about)

    def _classes(self) -> dict[str, Any]:
        import bpy

        return {one.name_full: instances.class_of_object(one, self._spec.classes) for one in bpy.data.objects}


class _Overall:
    """The progress of one picture as that of all."""

    def __init__(self, bar: Any, done: int, of: int) -> None:
        self._bar, self._done, self._of = bar, done, of

    def __call__(self, part: float, text: str) -> None:
        self._bar((self._done + min(part, 0.999)) / self._of, f"picture {self._done + 1} of {self._of}  {text}")

    def end(self) -> None:
        """The line stays."""
        self._bar.end()
