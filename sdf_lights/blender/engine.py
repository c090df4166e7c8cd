# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: F12, background and animation renders, previews of materials, and Rendered viewports.

An instance lives for one render and keeps nothing. With Persistent Data it lives for all frames (``sync/kept.py``). In
Rendered shading it lives as long as the viewport (``viewport/rendered.py``). ``render()`` copies the scene out of
Blender. After that it uses Blender only to show progress, to ask whether to stop, and to return pixels.
"""

import atexit
import functools
import os
import sys

import bpy

from ..garbage import nothing_to_collect
from ..render.errors import RenderError
from ..render.memory import trim_heap
from ..render.passes import MATTES
from ..render.settings import Device
from . import command_line, feedback, findings, lamp_preview
from .guard import guarded
from .naming import ENGINE, LABEL
from .passes import enabled_passes, register_passes
from .viewport.engine import ViewportEngine

# A preview is as large as a thumbnail, and the user waits while it renders.
PREVIEW = dict(
    device=Device.CPU, samples=64, noise_threshold=0.05, min_samples=8, time_limit=2.0, max_bounces=6, denoise=False
)

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
            try:
                self._render(depsgraph)
            except Exception:
                # as a Python module, Blender reports failure to its caller
                if bpy.app.background and bpy.app.binary_path:
                    fail_at_exit()
                raise
            finally:
                trim_heap()

    def _render(self, depsgraph):
        # Not at the top: this imports every kernel.
        with nothing_to_collect():
            from ..render import libraries, session
            from .sync import Kept, sync_views

        if bpy.app.binary_path:
            libraries.add_search_folder(os.path.dirname(bpy.app.binary_path))

        command_line.begin_log()
        self.update_stats("", "Synchronizing")
        layer = depsgraph.view_layer.name
        views = self._views(layer)
        kept = None
        if depsgraph.scene.render.use_persistent_data and not self.is_preview:
            kept = self._kept = getattr(self, "_kept", None) or Kept()
        else:
            self._kept = None
        scene, cameras = sync_views(depsgraph, self, tuple(views), kept)
        command_line.apply(scene.settings)
        if self.is_preview:
            for name, value in PREVIEW.items():
                setattr(scene.settings, name, value)
            if scene.lamps:  # a preview of a light: Blender's scenes for other previews have none
                scene = lamp_preview.framed(scene)
                cameras = [scene.camera] * len(cameras)
        reported = self._report_warnings(scene.warnings, 0)
        strict = _strict() and not self.is_preview
        if strict and scene.warnings:
            raise RenderError(findings.failure(len(scene.warnings)))
        log = command_line.LOG
        of = f"frame {depsgraph.scene.frame_current} of view layer '{layer}'"
        log.info("%s: %d objects, %d SDF lamps", of, len(scene.instances), len(scene.lamps))
        log.debug("%s: %s", of, scene.settings)
        for index, (view, scene.camera) in enumerate(zip(views, cameras)):
            if index > 0 and self.test_break():
                break
            self.active_view_set(view)
            with _Result(self, layer, view, scene) as result:
                film = session.render(
                    scene,
                    tuple(result.passes),
                    cancelled=self.test_break,
                    on_update=result.update,
                    on_progress=functools.partial(self._show, index / len(views), 1.0 / len(views)),
                )
                result.write(film)
                result.describe(film)
            log.info("%s: %d samples by the %s", of, film.samples, film.made_by)
        self._report_warnings(scene.warnings, reported)
        if not self.is_preview:
            feedback.record(depsgraph.scene.name, scene.warnings, film.made_by)
        if strict and scene.warnings:
            raise RenderError(findings.failure(len(scene.warnings)))

    def _report_warnings(self, warnings: list[str], first: int) -> int:
        """Report the warnings from number ``first`` on. Returns the number of warnings. Thumbnails report nothing."""
        if not self.is_preview:
            for warning in findings.in_order(warnings[first:]):
                self.report({"WARNING"}, warning)
        return len(warnings)

    def _views(self, layer: str) -> list[str]:
        """Names of the rendered views, such as two eyes; one empty name without stereo."""
        result = self.begin_result(0, 0, 1, 1, layer=layer)
        names = [view.name for view in result.views]
        self.end_result(result, cancel=True)
        return names or [""]

    def _show(self, begin: float, part: float, progress) -> None:
        """Report ``progress`` of this ``part`` of the render, after the part ``begin``."""
        self.update_progress(begin + part * progress.fraction)
        self.update_memory_stats(memory_used=progress.memory / MEGABYTE, memory_peak=progress.memory / MEGABYTE)
        self.update_stats("", status(progress))


def _strict() -> bool:
    return bpy.app.background and command_line.strict()


@functools.cache
def fail_at_exit() -> None:
    """Let this process end with exit code 1. Blender before 5.2 ends with 0 even if its renders fail."""

    def leave() -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(1)

    atexit.register(leave)


def status(progress) -> str:
    """Line about a ``session.Progress``, for the header of the image editor."""
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
    """Blender's render result for one view of one view layer, as a context. It is always ended."""

    def __init__(self, engine: SDFLightsRenderEngine, layer: str, view: str, scene):
        self._engine, self._layer, self._view, self._scene = engine, layer, view, scene
        self._result = None
        self.passes: dict[str, str] = {}  # Blender's pass names by table names

    def __enter__(self):
        engine = self._engine
        self._result = engine.begin_result(
            0, 0, engine.resolution_x, engine.resolution_y, layer=self._layer, view=self._view
        )
        if not self._result.layers:
            raise RenderError(f"View layer '{self._layer}' is not part of this render: enable its Use for Rendering.")
        width, height = self._result.resolution_x, self._result.resolution_y
        x0, y0, x1, y1 = self._scene.border or (0, 0, self._scene.width, self._scene.height)
        if (width, height) != (x1 - x0, y1 - y0):
            # Blender's rounding decides: a picture of a different size cannot be written.
            if x0 + width > self._scene.width or y0 + height > self._scene.height:
                raise RenderError(
                    f"Blender asks for {width} × {height} pixels of a frame of {self._scene.width} × "
                    f"{self._scene.height}: change the resolution or the render region slightly."
                )
            self._scene.border = x0, y0, x0 + width, y0 + height
        self.passes = enabled_passes(self._result.layers[0].passes.keys(), self._scene.passes)
        return self

    def __exit__(self, kind, error, traceback):
        if self._result is not None:
            # A cancelled picture is kept as far as it got. A failed picture is not kept.
            self._engine.end_result(self._result, cancel=error is not None)
            self._result = None

    def write(self, film) -> None:
        """Copy the passes of ``film``."""
        passes = self._result.layers[0].passes
        for name, blender_name in self.passes.items():
            passes[blender_name].rect.foreach_set(film.read(name).ravel())

    def describe(self, film) -> None:
        """Write into files the samples that they have, and the names of the Cryptomatte numbers."""
        from ..render import cryptomatte, merging

        whole, settings = self._engine.get_result(), self._scene.settings
        # If all pixels are clean early, the requested number is the weight: noise must not influence it.
        stopped = settings.time_limit > 0.0 or self._engine.test_break()
        samples = film.samples if stopped else settings.samples
        share = merging.Share(settings.seed, settings.sample_offset, samples)
        for field, value in share.metadata(self._layer).items():
            whole.stamp_data_add_field(field=field, value=value)
        names = {
            "object": [instance.name for instance in self._scene.instances],
            "asset": [instance.asset or instance.name for instance in self._scene.instances],
            "material": [material.name for material in self._scene.materials],
        }
        for kind in film.matte_places:
            told = cryptomatte.metadata(f"{self._layer}.{MATTES[kind]}", names[kind])
            for field, value in told.items():
                whole.stamp_data_add_field(field=field, value=value)

    def update(self, film) -> None:
        """Show the present picture."""
        self.write(film)
        self._engine.update_result(self._result)


CLASSES = (SDFLightsRenderEngine,)


def register():
    pass


def unregister():
    pass
