# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps in every 3D viewport: draw handlers, and the data that they keep between redraws.

Before it draws the scene, Blender binds the frame buffer of the scene's colours, which are scene-linear. This module
keeps it until the scene is drawn, and then adds the glow. So the view transform, exposure and look of the viewport
apply to lamps as to everything else. Outlines and boxes go into the frame buffer of the overlays.
"""

from __future__ import annotations

import math
import time
from collections import OrderedDict

import blf
import bpy
import gpu
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from ...render.scene import Lamp, Ray
from ..naming import ENGINE
from . import rendered, shaders
from .drawing import draw_rectangle
from .facts import FactFinder, Facts
from .lamp_data import Collected, Placed, collect
from .painter import EDGES, Depth, Drawn, Painter, View, code_of, radiance_per_metre
from .surfaces import Surfaces

# Seconds of compilation in one redraw before the rest waits for the next; at least one shader is compiled.
COMPILE_BUDGET = 0.03
# Seconds without a change after which the view counts as still.
STILL = 0.25
POLL = 0.1
# Radiance of a lamp at its mean thickness, in Solid shading.
SHAPE_RADIANCE = 1.5
# In Solid shading: the least radiance of the thinnest lamps; the fractions of a surrounding cube filled by thick lamps,
# and by a ball.
LEAST_RADIANCE, THIN, BALL = 0.25, 0.03, math.pi / 6.0
OUTLINE_WIDTH = 1.5


class _Targets:
    """Textures that lamps are drawn into before they are added to the screen, by size."""

    def __init__(self):
        self._kept: OrderedDict[tuple[int, int], tuple] = OrderedDict()

    def get(self, size: tuple[int, int]):
        if size not in self._kept:
            glow, mask = (gpu.types.GPUTexture(size, format=kind) for kind in ("RGBA16F", "RGBA8"))
            self._kept[size] = gpu.types.GPUFrameBuffer(color_slots=(glow, mask)), glow, mask
            while len(self._kept) > 4:
                self._kept.popitem(last=False)
        self._kept.move_to_end(size)
        return self._kept[size]


class Overlay:
    """The data that the draw handlers keep. None of it belongs to a file: ``forget`` may be called at any time."""

    def __init__(self):
        self.painter, self.finder = Painter(), FactFinder()
        self.errors: dict[str, str] = {}
        self._targets = _Targets()
        self._surfaces = Surfaces()
        self._scene_buffer = None
        self._collected: dict[tuple, Collected] = {}
        self._announced: set = set()
        self._labels: dict[int, list[tuple[np.ndarray, str]]] = {}
        self._views: dict[int, tuple] = {}  # the view of each region, and since when

    # -- events --------------------------------------------------------------------------------------------------

    def changed(self, depsgraph: bpy.types.Depsgraph | None) -> None:
        """Something in the file may have changed: the updates of the dependency graph, or anything."""
        self._collected.clear()
        self._surfaces.changed(depsgraph is None or any(update.is_updated_geometry for update in depsgraph.updates))

    def forget(self) -> None:
        """Drop all data kept between redraws, for instance when another file is opened."""
        self.finder.stop()
        self._surfaces.changed(True)
        self._collected.clear()
        self._labels.clear()
        self._views.clear()
        self.errors.clear()

    def shown(self, context) -> list[Placed]:
        """Lamps that a viewport showed at its last redraw, by the proxy or by the path tracer."""
        traced = rendered.shows_lamps(context)
        drawn = context.scene.sdf_lights_overlay.show_lamps and _shows_lamps(context.space_data)
        return self._visible(context) if traced or drawn else []

    # -- drawing -------------------------------------------------------------------------------------------------

    def before_scene(self) -> None:
        """Before Blender draws the scene: record the frame buffer of its colours."""
        self._scene_buffer = gpu.state.active_framebuffer_get()

    def after_scene(self, context) -> None:
        """After Blender has drawn the scene: draw the lamps into its colours."""
        scene_buffer, self._scene_buffer = self._scene_buffer, None
        region, space = context.region, context.space_data
        settings = context.scene.sdf_lights_overlay
        self._labels.pop(region.as_pointer(), None)
        if not settings.show_lamps or not _shows_lamps(space):
            return
        placed, traced = self._visible(context), rendered.shows_lamps(context)
        if traced:  # only outlines are left to draw
            marks = _marks(context) if space.overlay.show_overlays else {}
            placed = [item for item in placed if item.owner in marks]
        if not placed:
            return
        overlay_buffer = gpu.state.active_framebuffer_get()
        view = _view_of(context, overlay_buffer)
        drawn, boxes = self._prepare(placed, context)
        moving = self._is_moving(region, view, drawn)
        scale = int(settings.resolution) * (2 if moving and settings.coarse_motion else 1)
        if drawn:
            depth = None
            if not space.overlay.show_overlays:
                depth = self._surfaces.depth(context, view, scale)
            elif not _sees_through(space):
                depth = _scene_depth(overlay_buffer, view, drawn, scale)
            glow_buffer = None if traced else scene_buffer or overlay_buffer
            self._draw(drawn, view, depth, scale, glow_buffer, context)
        if boxes and space.overlay.show_overlays:
            _draw_boxes(boxes, view)
            self._labels[region.as_pointer()] = [
                (item.lamp.matrix[:3, :3] @ (0.5 * (facts.low + facts.high)) + item.lamp.matrix[:3, 3], text)
                for item, facts, text in boxes
            ]

    def labels(self, context) -> None:
        """Words beside the boxes of lamps that are drawn only as boxes."""
        region = context.region
        for place, text in self._labels.get(region.as_pointer(), ()):
            at = location_3d_to_region_2d(region, context.region_data, Vector(place))
            if at is not None:
                blf.size(0, 11.0 * context.preferences.system.ui_scale)
                blf.color(0, 1.0, 1.0, 1.0, 1.0)
                blf.enable(0, blf.SHADOW)  # the lamp below it may be white
                blf.shadow(0, 5, 0.0, 0.0, 0.0, 1.0)
                blf.position(0, at.x, at.y, 0.0)
                blf.draw(0, text)
                blf.disable(0, blf.SHADOW)

    def _visible(self, context) -> list[Placed]:
        depsgraph, space = context.evaluated_depsgraph_get(), context.space_data
        key = context.scene.name_full, context.view_layer.name
        if key not in self._collected:
            self._collected[key] = collect(depsgraph)
            self.errors = dict(self._collected[key].errors)
        found = []
        shown: dict[str, bool] = {}
        for item in self._collected[key].lamps:
            if item.owner not in shown:
                owner = context.view_layer.objects.get(item.owner)
                shown[item.owner] = owner is None or owner.visible_in_viewport_get(space)
            if shown[item.owner]:
                found.append(item)
        return found

    def _prepare(self, placed: list[Placed], context):
        """Lamps to raymarch, and lamps drawn as boxes, with a word that tells why."""
        settings, shading = context.scene.sdf_lights_overlay, context.space_data.shading
        flat = shading.type in {"SOLID", "WIREFRAME"}
        exposure = context.scene.sdf_lights.exposure if context.scene.render.engine == ENGINE else 1.0
        marks = _marks(context)
        drawn, boxes, waiting = [], [], False
        started = time.perf_counter()
        for item in placed:
            facts = self.finder.find(item.key, item.lamp.shape, item.lamp.emission)
            if facts is None:
                low, high = item.lamp.shape.bounds()
                if np.isfinite([low, high]).all():
                    boxes.append((item, Facts(low, high), "Measuring…"))
                continue
            if facts.problem:
                self.errors[item.light] = f"Lamp '{item.owner}' is not shown in the viewport: {facts.problem}"
                if np.any(facts.high > facts.low):
                    boxes.append((item, facts, "Cannot be drawn"))
                continue
            if not self.painter.is_compiled(item.lamp):
                code = code_of(item.lamp)
                if code not in self._announced:
                    self._announced.add(code)
                    waiting = True
                elif time.perf_counter() - started < COMPILE_BUDGET:
                    self.painter.compile(item.lamp)
                else:
                    waiting = True
            problem = self.painter.problem(item.lamp)
            if problem:
                self.errors[item.light] = f"Lamp '{item.owner}' is shown as a box: {problem}"
                boxes.append((item, facts, "Cannot be drawn"))
            elif not self.painter.is_compiled(item.lamp):
                boxes.append((item, facts, "Compiling…"))
            elif not item.lamp.visibility & Ray.CAMERA:
                boxes.append((item, facts, ""))
            else:
                brightness, least = exposure, np.zeros(3)
                if flat and settings.brightness == "SHAPE":
                    brightness, least = _shape_brightness(item.lamp, facts)
                else:
                    brightness *= item.lamp.camera_brightness
                if item.problem:
                    boxes.append((item, facts, "Last good shape"))
                drawn.append(Drawn(item.lamp, facts, brightness, marks.get(item.owner, (0.0, 0.0)), tuple(least)))
        if waiting or self.finder.busy:
            _redraw_later(0.0 if waiting else POLL)
        return drawn, boxes

    def _is_moving(self, region, view: View, drawn: list[Drawn]) -> bool:
        shown = (
            view.view.tobytes(),
            view.projection.tobytes(),
            *(hash((item.lamp.matrix.tobytes(), item.lamp.shape, item.lamp.emission)) for item in drawn),
        )
        last, since = self._views.get(region.as_pointer(), (shown, 0.0))
        now = time.perf_counter()
        if shown != last:
            since = now
        self._views[region.as_pointer()] = shown, since
        if now - since >= STILL:
            return False
        _redraw_later(STILL)
        return True

    def _draw(self, drawn, view: View, depth, scale: int, glow_buffer, context) -> None:
        """Draw lamps: their glow into ``glow_buffer``, if there is one, and outlines."""
        size = tuple(max(-(-pixels // scale), 1) for pixels in view.size)
        target, glow, mask = self._targets.get(size)
        with target.bind():
            target.viewport_set(0, 0, *size)
            target.clear(color=(0.0, 0.0, 0.0, 0.0))
            self.painter.draw(drawn, View(view.view, _stretched(view.projection, view.size, size, scale), size), depth)
        # The textures may reach beyond the screen on the right and at the top.
        place = 0.0, 0.0, size[0] * scale / view.size[0], size[1] * scale / view.size[1]
        if glow_buffer is not None:
            with glow_buffer.bind():
                draw_rectangle(shaders.composite_shader(), place, "ADDITIVE_PREMULT", {"glow": glow})
        if context.space_data.overlay.show_overlays and any(any(item.mask) for item in drawn):
            theme = context.preferences.themes[0].view_3d
            width = OUTLINE_WIDTH * context.preferences.system.ui_scale / (np.array(size) * scale)
            draw_rectangle(
                shaders.outline_shader(),
                place,
                "ALPHA",
                {"mask": mask},
                width=tuple(width),
                selected_color=(*theme.object_selected, 1.0),
                active_color=(*theme.object_active, 1.0),
            )


def _shows_lamps(space) -> bool:
    """Whether lamps are shown. Without overlays, they stay in the modes whose picture contains them."""
    if not space.show_object_viewport_light:
        return False
    return space.overlay.show_overlays or space.shading.type in {"MATERIAL", "RENDERED"}


def _sees_through(space) -> bool:
    shading = space.shading
    return (shading.type == "SOLID" and shading.show_xray) or (
        shading.type == "WIREFRAME" and shading.show_xray_wireframe
    )


def _view_of(context, buffer) -> View:
    data, (_, _, width, height) = context.region_data, buffer.viewport_get()
    view, projection = (
        np.array([tuple(row) for row in matrix], np.float64) for matrix in (data.view_matrix, data.window_matrix)
    )
    return View(view, projection, (width, height))


def _stretched(projection: np.ndarray, full: tuple[int, int], size: tuple[int, int], scale: int) -> np.ndarray:
    """The projection for ``size`` pixels of ``scale`` × ``scale``, which may reach beyond the ``full`` picture."""
    result = projection.copy()
    for axis in range(2):
        part = full[axis] / (size[axis] * scale)
        result[axis] = part * projection[axis] + (part - 1.0) * projection[3]
    return result


def _scene_depth(buffer, view: View, drawn: list[Drawn], scale: int) -> Depth | None:
    """The depth buffer around the lamps. It is copied, because it cannot be read while it is drawn to."""
    low, high = np.array(view.size), np.zeros(2, int)
    for item in drawn:
        corners = _corners(item.facts) @ (view.projection @ view.view @ item.lamp.matrix).T
        if np.any(corners[:, 3] <= 0.0):
            low, high = np.zeros(2, int), np.array(view.size)
            break
        pixels = (0.5 * corners[:, :2] / corners[:, 3:] + 0.5) * view.size
        low = np.minimum(low, np.floor(pixels.min(axis=0)) - scale)
        high = np.maximum(high, np.ceil(pixels.max(axis=0)) + scale)
    low, high = np.clip(low, 0, view.size).astype(int), np.clip(high, 0, view.size).astype(int)
    if np.any(high <= low):
        return None
    width, height = (int(extent) for extent in high - low)
    data = buffer.read_depth(int(low[0]), int(low[1]), width, height)
    data.dimensions = width * height
    return Depth(gpu.types.GPUTexture((width, height), format="R32F", data=data), (int(low[0]), int(low[1])), scale)


def _corners(facts: Facts) -> np.ndarray:
    """Corners of the box (8, 4), homogeneous; x varies fastest."""
    choice = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return np.hstack([np.where(choice, facts.high, facts.low), np.ones((8, 1))])


def _marks(context) -> dict[str, tuple[float, float]]:
    """The mask values of selected objects and the active one."""
    marks = {obj.name_full: (1.0, 0.0) for obj in context.selected_objects}
    active = context.view_layer.objects.active
    if active is not None and active.name_full in marks:
        marks[active.name_full] = (0.0, 1.0)
    return marks


def _shape_brightness(lamp: Lamp, facts: Facts) -> tuple[float, np.ndarray]:
    """Factor that makes the lamp's brightest colour ``SHAPE_RADIANCE`` at its mean thickness; and the least light (RGB)
    of a lamp that is thin everywhere."""
    size = float((np.linalg.norm(lamp.matrix[:3, :3], axis=0) * (facts.high - facts.low)).mean())
    color = radiance_per_metre(lamp, facts)
    filled = facts.volume * abs(float(np.linalg.det(lamp.matrix[:3, :3]))) / max(size, 1e-100) ** 3
    if not (color.max() > 0.0 and 0.0 < filled < np.inf):
        return 0.0, np.zeros(3)
    # A wire of the lamp's volume, three times as long as the lamp's size, has this thickness. For a ball it is the
    # diameter.
    thickness = size * min(1.0, math.sqrt(filled / BALL))
    least = LEAST_RADIANCE * max(1.0 - filled / THIN, 0.0)
    return SHAPE_RADIANCE / (color.max() * thickness), least * color / color.max()


def _draw_boxes(boxes, view: View) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("lineWidth", 1.0)
    shader.uniform_float("viewportSize", view.size)
    shader.uniform_float("color", (1.0, 0.8, 0.4, 0.7))
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    for item, facts, _ in boxes:
        batch = batch_for_shader(shader, "LINES", {"pos": _corners(facts)[:, :3].tolist()}, indices=EDGES)
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(Matrix(item.lamp.matrix.tolist()))
            batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


# -- redraws -------------------------------------------------------------------------------------------------------


def tag_viewports() -> None:
    """Redraw every 3D viewport."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _redraw_later(seconds: float) -> None:
    # Blender ignores a redraw tag during a redraw.
    if not bpy.app.timers.is_registered(tag_viewports):
        bpy.app.timers.register(tag_viewports, first_interval=seconds)
