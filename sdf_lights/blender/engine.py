# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: F12, background and animation renders, previews of materials, and Rendered viewports.

An instance lives for one render and keeps nothing, or for as long as a viewport is in Rendered shading: see
``viewport/rendered.py``. ``render()`` copies the scene out of Blender, and from then on
touches Blender only to show progress, to ask whether to stop, and to hand over pixels.
"""

import os

import bpy

from ..render.errors import RenderError
from ..render.settings import Device
from . import feedback
from .guard import guarded
from .naming import ENGINE, LABEL
from .passes import enabled_passes, register_passes
from .viewport.engine import ViewportEngine

# A preview is as large as a thumbnail and drawn while the user waits.
PREVIEW = dict(device=Device.CPU, samples=64, noise_threshold=0.05, min_samples=8, time_limit=2.0, max_bounces=6, denoise=False)

MEGABYTE = 1 << 20


class SDFLightsRenderEngine(ViewportEngine, bpy.types.RenderEngine):
    bl_idname = ENGINE
    bl_label = LABEL
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene, render_layer):
        with guarded(self):
            register_passes(self, scene, render_layer)

    def render(self, depsgraph):
        with guarded(self):
            self._render(depsgraph)

    def _render(self, depsgraph):
        # Not before something is rendered: this imports Numba and every kernel.
        from ..render import libraries, session
        from .sync import sync

        if bpy.app.binary_path:
            libraries.add_search_folder(os.path.dirname(bpy.app.binary_path))

        self.update_stats("", "Synchronizing")
        scene = sync(depsgraph)
        if self.is_preview:
            for name, value in PREVIEW.items():
                setattr(scene.settings, name, value)
        reported = self._report_warnings(scene.warnings, 0)
        with _Result(self, depsgraph.view_layer.name, scene) as result:
            film = session.render(
                scene, tuple(result.passes), cancelled=self.test_break, on_progress=self._show, on_update=result.update)
            result.write(film)
        self._report_warnings(scene.warnings, reported)
        if not self.is_preview:
            feedback.record(depsgraph.scene.name, scene.warnings, film.made_by)

    def _report_warnings(self, warnings: list[str], first: int) -> int:
        """Report the warnings from number ``first`` on; returns how many there are. Thumbnails keep quiet."""
        if not self.is_preview:
            for warning in warnings[first:]:
                self.report({"WARNING"}, warning)
        return len(warnings)

    def _show(self, progress) -> None:
        self.update_progress(progress.fraction)
        self.update_memory_stats(memory_used=progress.memory / MEGABYTE, memory_peak=progress.memory / MEGABYTE)
        self.update_stats("", status(progress))


def status(progress) -> str:
    """Line about a ``session.Progress`` for the header of the image editor."""
    parts = []
    if progress.remaining is not None and progress.fraction < 1.0:
        parts.append(f"Remaining: {clock(progress.remaining)}")
    if progress.memory:
        parts.append(f"Mem: {progress.memory / MEGABYTE:.0f}M")
    if progress.noise is not None:
        parts.append(f"Noise: {progress.noise:.4f}")
    parts.append(progress.text)
    return " | ".join(parts)


def clock(seconds: float) -> str:
    """``1:02:03`` or ``02:03``."""
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes:02}:{seconds:02}"


class _Result:
    """Blender's render result for one view layer, as a context: it is ended whatever happens."""

    def __init__(self, engine: SDFLightsRenderEngine, layer: str, scene):
        self._engine, self._layer, self._scene = engine, layer, scene
        self._result = None
        self.passes: dict[str, str] = {}  # names in the result by names in the table

    def __enter__(self):
        engine = self._engine
        self._result = engine.begin_result(0, 0, engine.resolution_x, engine.resolution_y, layer=self._layer)
        if not self._result.layers:
            raise RenderError(f"View layer '{self._layer}' is not part of this render: enable its Use for Rendering.")
        width, height = self._result.resolution_x, self._result.resolution_y
        x0, y0, x1, y1 = self._scene.border or (0, 0, self._scene.width, self._scene.height)
        if (width, height) != (x1 - x0, y1 - y0):
            # Blender's rounding decides: a picture of another size could not be written.
            if x0 + width > self._scene.width or y0 + height > self._scene.height:
                raise RenderError(f"Blender asks for {width} × {height} pixels of a frame of {self._scene.width} × "
                                  f"{self._scene.height}: change the resolution or the render region a little.")
            self._scene.border = x0, y0, x0 + width, y0 + height
        self.passes = enabled_passes(self._result.layers[0].passes.keys())
        return self

    def __exit__(self, kind, error, traceback):
        if self._result is not None:
            # The picture is kept when it was cancelled, as far as it got, but not when it failed.
            self._engine.end_result(self._result, cancel=error is not None)
            self._result = None

    def write(self, film) -> None:
        """Copy the passes of ``film``."""
        passes = self._result.layers[0].passes
        for name, blender_name in self.passes.items():
            passes[blender_name].rect.foreach_set(film.read(name).ravel())

    def update(self, film) -> None:
        """Show the picture so far."""
        self.write(film)
        self._engine.update_result(self._result)


CLASSES = (SDFLightsRenderEngine,)


def register():
    pass


def unregister():
    pass
