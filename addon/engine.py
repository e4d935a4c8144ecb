# SPDX-License-Identifier: GPL-3.0-or-later
"""The RenderEngine class: Blender's calls, a few lines each."""

from __future__ import annotations

import traceback

import bpy

from .data import passes
from .export import sampling
from .export.errors import ExportError
from .export.stereo import View
from .native import EngineMissing, engine
from .render import loop, persistent, planning, preview, statistics
from .render.bake import Bake
from .render.photograph import Photograph
from .render.results import deliver_black, views
from .viewport import RenderedView

#: The one name of the engine.
ENGINE = "PETZVAL"


class PetzvalRenderEngine(bpy.types.RenderEngine):
    """Photographs the scene through a real lens."""

    bl_idname = ENGINE
    bl_label = "Petzval"
    bl_use_preview = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    # Blender would draw Freestyle's lines by another engine, which crashes without a window.
    bl_use_custom_freestyle = True

    # There is no __init__: Blender's own takes whatever arguments its version has.

    def update_render_passes(self, scene=None, renderlayer=None):
        levels = passes.matte_levels(renderlayer)
        mattes = (one for layer in passes.wanted_mattes(renderlayer) for one in passes.of_matte(layer, levels))
        groups = passes.of_light_groups(renderlayer)
        has_threshold = sampling.of_render(scene).noise_threshold > 0.0
        merging = passes.for_merging(renderlayer, has_threshold=has_threshold)
        parts = passes.wanted_parts(renderlayer, bpy.app.version)
        parts += passes.wanted_indices(renderlayer, bpy.app.version)
        parts += (*passes.wanted_strays(renderlayer), *(passes.SHADOW,) * passes.wants_shadow(renderlayer))
        parts += (passes.NOISY,) * passes.is_denoised(scene, renderlayer)
        for one in (passes.COMBINED, *passes.wanted(renderlayer), *parts, *mattes, *groups, *merging):
            self.register_pass(scene, renderlayer, one.name, one.channels, one.channel_names, one.kind)

    def update(self, data=None, depsgraph=None):
        """Called before a render, and before the images of an object are baked."""
        self._bake = None

    def bake(self, depsgraph, obj, pass_type, pass_filter, width, height):
        """One image of an object's surface; where that fails or is stopped the image keeps its pixels."""
        try:
            if getattr(self, "_bake", None) is None or self._bake.holder != obj:
                self._bake = Bake(self, depsgraph, obj)
            self._bake.image(pass_type, pass_filter, width, height)
        except loop.Stopped:
            pass
        except KeyboardInterrupt:
            loop.WATCH.stop.set()
        except Exception as error:
            self.report({"ERROR"}, _complaint(error))

    def view_update(self, context, depsgraph):
        """The scene was changed, in a 3D view in rendered shading."""
        self._rendered_view().update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        """Draws a view in rendered shading."""
        self._rendered_view().draw(context, depsgraph)

    def _rendered_view(self) -> RenderedView:
        found = getattr(self, "_view", None)
        if found is None:
            found = self._view = RenderedView(self)
        return found

    def render(self, depsgraph):
        """One view layer, view by view."""
        said: set[str] = set()
        for view in views(self, depsgraph):
            self._render(depsgraph, view, said)

    def _render(self, depsgraph, view: View, said: set[str]) -> None:
        """One view. An exception would only be printed, so everything ends as a report and a picture."""
        try:
            if self.is_preview:
                preview.render(self, depsgraph)
            else:
                Photograph(self, depsgraph, view, said).take()
        except loop.Stopped:
            deliver_black(self, depsgraph, view.name)
        except KeyboardInterrupt:
            loop.WATCH.stop.set()
            deliver_black(self, depsgraph, view.name)
        except Exception as error:
            _fail(self, depsgraph, view, _complaint(error))


def _complaint(error: Exception) -> str:
    """The message of an error, in a line; of an unexpected error the traceback is printed."""
    if isinstance(error, ExportError | EngineMissing):
        return str(error)
    if not _is_engine_error(error):
        traceback.print_exc()
    return " ".join(str(error).split()) or type(error).__name__


def _is_engine_error(error: Exception) -> bool:
    try:
        return isinstance(error, engine().PetzvalError)
    except EngineMissing:
        return False


def _fail(host: PetzvalRenderEngine, depsgraph: bpy.types.Depsgraph, view: View, message: str) -> None:
    """An error report, and a black picture: writing a picture without pixels crashes Blender."""
    deliver_black(host, depsgraph, view.name)
    host.report({"ERROR"}, message)


def register() -> None:
    bpy.utils.register_class(PetzvalRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(PetzvalRenderEngine)
    statistics.forget()
    planning.forget()
    persistent.forget()
