# SPDX-License-Identifier: GPL-3.0-or-later
"""The transfer of a render into Blender's result: tiles while it goes on, at its end all passes that the view layer asks for."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from ..data import passes, tiles
from ..export import camera as camera_export
from ..export import memory, sampling, stereo
from ..native import engine
from . import loop


def region(render: bpy.types.RenderSettings) -> tiles.Window:
    """The part of the picture that is rendered."""
    border = None
    if render.use_border:
        border = (render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y)
    return tiles.region(*camera_export.resolution(render), border)


def views(host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> list[stereo.View]:
    """The views that are to be rendered."""
    if not depsgraph.scene_eval.render.use_multiview or loop.WATCH.study is not None:
        return [stereo.ONLY]
    result = host.begin_result(0, 0, 1, 1, layer=depsgraph.view_layer_eval.name)
    names = [one.name for one in result.views]
    host.end_result(result, cancel=True)
    return [stereo.View(name, index, len(names)) for index, name in enumerate(names)]


def deliver(
    host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, finished: list[tiles.Tile], view: str = ""
) -> None:
    """Hands tiles, placed in the rendered region, to Blender; without the name of a view, to all."""
    layer = depsgraph.view_layer_eval.name
    for tile in finished:
        height, width = tile.pixels.shape[:2]
        result = host.begin_result(tile.x, tile.y, width, height, layer=layer, view=view)
        for one in result.layers[0].passes:
            if one.name == passes.COMBINED.name:
                one.rect.foreach_set(tiles.flat(tile))
        host.end_result(result)


def deliver_black(host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, view: str = "") -> None:
    """A picture without light: writing one without pixels crashes Blender.

    One pixel is handed over. Blender makes the others, which are black; a picture that does not fit into memory is never filled.
    """
    deliver(host, depsgraph, [tiles.Tile(0, 0, np.zeros((1, 1, 4), np.float32))], view)


class Results:
    """The passes that a view layer asks for, in one of a render's views."""

    def __init__(
        self, host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, view: stereo.View = stereo.ONLY
    ) -> None:
        self._host, self._depsgraph, self._view = host, depsgraph, view.name
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        self._window = region(scene.render)
        self._data = passes.wanted(layer)
        has_threshold = sampling.of_render(scene).noise_threshold > 0.0
        self._merging = passes.for_merging(layer, has_threshold=has_threshold)
        self._mattes, self._matte_levels = passes.wanted_mattes(layer), passes.matte_levels(layer)
        self._light_groups = passes.of_light_groups(layer)
        self._parts = passes.wanted_parts(layer, bpy.app.version)
        self._indices = passes.wanted_indices(layer, bpy.app.version)
        self._strays = passes.wanted_strays(layer)
        self.has_shadow = passes.wants_shadow(layer)
        self.is_denoised = passes.is_denoised(scene, layer)
        #: The engine's parts that guide the denoiser.
        self.guides: list[str] = []

    @property
    def has_data(self) -> bool:
        """True if the engine is to keep the data of the surfaces that pixels see."""
        return bool(self._data)

    @property
    def has_vectors(self) -> bool:
        """True if the engine is to keep the movement of the surfaces that pixels see."""
        return any(one.engine_name == "VECTOR" for one in self._data)

    @property
    def has_denoising_data(self) -> bool:
        """True if the picture may be denoised later, by the passes that guide that."""
        return any(one in passes.DENOISING for one in self._parts)

    @property
    def is_mergeable(self) -> bool:
        """True if the picture is to be joined with others: its stray light belongs to the whole."""
        return len(self._merging) > 1

    def for_job(self) -> dict[str, Any]:
        """The passes that the engine is to keep, as `Job` takes them."""
        return {
            "mattes": [one.engine_name for one in (*self._mattes, *self._indices)],
            "matte_levels": self._matte_levels,
            "light_groups": len(self._light_groups),
            "parts": list(
                dict.fromkeys([*(name for one in self._parts for name in passes.engine_names(one)), *self.guides])
            ),
        }

    def check_memory(self, width: int, height: int, *, halves: bool, is_kept: bool) -> None:
        """Raises `ExportError` where the picture does not fit into memory; `is_kept`: on disk, too, from a copy of the film."""
        share = loop.WATCH.share
        is_joined = share is not None and not share.parts
        # Where films are joined, those of groups and parts of light stay packed.
        groups = 0 if is_joined else len(self._light_groups) + len(self.for_job()["parts"])
        mattes = bool(self._mattes or self._indices)
        film = engine().film_bytes_a_pixel(
            surfaces=self.has_data, vectors=self.has_vectors, mattes=mattes, halves=halves, groups=groups
        )
        every = (*self._data, *self._merging, *self._light_groups, *self._parts, *self._indices, *self._strays)
        numbers = 4 + sum(one.channels for one in every) + 4 * len(self._mattes) * ((self._matte_levels + 1) // 2)
        denoising = memory.BYTES_OF_DENOISING if self.is_denoised else 0
        numbers += passes.NOISY.channels if self.is_denoised else 0
        limit = self._depsgraph.scene_eval.petzval.memory_limit
        memory.check_picture(limit, width, height, film * (2 if is_kept else 1) + denoising, numbers)

    def show(self, finished: list[tiles.Tile]) -> None:
        """Tiles, while the render goes on."""
        inside = (tiles.clipped(tile, self._window) for tile in finished)
        deliver(self._host, self._depsgraph, [tile for tile in inside if tile is not None], self._view)

    def show_all(self, job: Any, pictures: dict[str, np.ndarray], plan: dict, picture_of: dict[str, str]) -> None:
        """The finished picture with its passes of data, at once: a result without a pass would blacken it. `pictures` by the names of their
        passes; those that the job knows are added. `plan` as the engine tells it; `picture_of`: the data that decide the picture, whichever
        of its samples it holds."""
        layer = self._depsgraph.view_layer_eval.name
        width, height = self._window.width, self._window.height
        result = self._host.begin_result(0, 0, width, height, layer=layer, view=self._view)
        there = {one.name: one for one in result.layers[0].passes}
        # One by one: all of them together are as large as Blender's own.
        for name, pixels in self._passes(job, pictures):
            if name in there:
                clipped = tiles.clipped(tiles.Tile(0, 0, pixels), self._window)
                there[name].rect.foreach_set(tiles.flat(clipped))
                if loop.WATCH.taken is not None:
                    loop.WATCH.taken(layer, self._view, name, clipped.pixels)
        self._host.end_result(result)
        self._name_mattes(job)
        self._name_effects(plan)
        self._name_samples(json.loads(job.stats_json()), picture_of)
        self._name_view(pictures[passes.COMBINED.name])

    def _passes(self, job: Any, pictures: dict[str, np.ndarray]) -> Iterator[tuple[str, np.ndarray]]:
        """All passes by their names."""
        yield from pictures.items()
        if self.has_shadow and passes.SHADOW.name not in pictures:
            yield passes.SHADOW.name, np.ones_like(pictures[passes.COMBINED.name][..., :3])
        yield from ((one.name, job.data(one.engine_name)) for one in (*self._data, *self._merging))
        yield from ((one.name, job.light_group(i)[..., :3]) for i, one in enumerate(self._light_groups, 1))
        yield from ((one.name, job.index(one.engine_name)) for one in self._indices)
        yield from ((one.name, passes.channels_of(one, job)) for one in self._parts)
        yield from ((one.name, job.stray(one.engine_name)) for one in self._strays)
        for layer in self._mattes:
            channels = job.matte(layer.engine_name)
            for i, one in enumerate(passes.of_matte(layer, self._matte_levels)):
                yield one.name, channels[..., 4 * i : 4 * i + 4]

    def _name_effects(self, plan: dict) -> None:
        """Writes the simulated effects of the lens into the picture's metadata."""
        whole = self._host.get_result()
        for row in plan["effects"]:
            whole.stamp_data_add_field(f"petzval/effects/{row['effect']}", f"{row['decision']}: {row['why']}")
        whole.stamp_data_add_field("petzval/camera", json.dumps(plan["camera"]))
        whole.stamp_data_add_field("petzval/quality", f"{plan['quality']:g}")

    def _name_samples(self, stats: dict, picture_of: dict[str, str]) -> None:
        """Says in the picture's metadata which samples of which picture it holds: for joining it with others."""
        whole = self._host.get_result()
        first, most = self._depsgraph.scene_eval.petzval.sample_offset, stats["samples_most"]
        whole.stamp_data_add_field("petzval/ranges", f"{stats['seed']}:{first}+{most}")
        if stats["samples"] == most:
            whole.stamp_data_add_field("petzval/samples", str(most))
        if picture_of:
            whole.stamp_data_add_field("petzval/picture", "; ".join(f"{k}={v}" for k, v in picture_of.items()))

    def _name_view(self, combined: np.ndarray) -> None:
        """Says in the picture's metadata which pixels are those of the view: Blender writes the metadata of the last view into the files of
        all."""
        if self._view:
            part = tiles.clipped(tiles.Tile(0, 0, combined), self._window)
            # Red, as the rows lie in a file.
            red = np.ascontiguousarray(part.pixels[::-1, :, 0], dtype="<f4")
            layer = self._depsgraph.view_layer_eval.name
            self._host.get_result().stamp_data_add_field(f"petzval/view/{self._view}/{layer}", f"{zlib.crc32(red):08x}")

    def _name_mattes(self, job: Any) -> None:
        """Writes the names of the mattes' numbers into the picture's metadata."""
        whole = self._host.get_result()
        for layer in self._mattes:
            name = f"{self._depsgraph.view_layer_eval.name}.{layer.name}"
            for key, value in job.matte_metadata(layer.engine_name, name):
                whole.stamp_data_add_field(key, value)
