# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts and curves as lamps: what is filled is extruded, all else is a tube; or both are glass tubes of a neon sign."""

from __future__ import annotations

import functools
import threading
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.shapes import SHAPES, Shape
from . import REMARKS, reads
from .splines import Path, path_of

if TYPE_CHECKING:  # they need Numba, whose import takes a second
    from ...sdf.data.outline import Outline
    from ...sdf.data.tube import Tube

NEON = "NEON"
MOST_POINTS = 1 << 18  # some thousand letters, which take some seconds


@reads(FONT="Text", CURVE="Curve")
def _read(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, lamp) -> Shape:
    try:
        paths = _paths_of(obj, depsgraph)
    except RuntimeError as error:
        raise RenderError(f"{_named(obj)} cannot be read: {error}") from None
    return _shape(obj, paths, lamp, depsgraph)


def _shape(obj: bpy.types.Object, paths: list[Path], lamp, depsgraph: bpy.types.Depsgraph) -> Shape:
    data = obj.data
    if not paths:
        cure = "write something into it" if obj.type == "FONT" else "draw a curve in it"
        raise RenderError(f"{_named(obj)} is empty, so it has no inside: {cure}.")
    points = sum(len(path.points) for path in paths)
    if points > MOST_POINTS:
        raise RenderError(
            f"{_named(obj)} has {points:,} points, but a lamp can have at most {MOST_POINTS:,}: lower its resolution, or divide it."
        )
    if not all(np.isfinite(path.points).all() and np.isfinite(path.radii).all() for path in paths):
        raise RenderError(f"{_named(obj)} has a point that is not a finite number: remove it.")
    if lamp.object_form == NEON:
        return _neon(_kept(paths), lamp.neon_radius, lamp.neon_gap)
    text = obj.type == "FONT"
    filled = text or data.dimensions == "2D" and data.fill_mode != "NONE"
    closed = [path for path in paths if path.closed and len(path.points) > 2]
    if filled and closed:
        found = _solid(_loops(closed), text, data.offset, data.extrude, data.bevel_depth, lamp.thickness)
        if found is None:
            raise RenderError(f"{_named(obj)} has no area, so it has no inside: move its points apart.")
        return found
    if not data.bevel_depth > 0.0:
        cure = (
            "give it a bevel depth, or close it" if not closed else "give it a bevel depth, or make it 2D and fill it"
        )
        raise RenderError(f"{_named(obj)} has no inside: {cure}; or make a neon tube of it.")
    taper = _taper(data, depsgraph)
    return _tube(_kept(paths), float(data.bevel_depth), taper)


def _paths_of(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> list[Path]:
    try:
        curve = obj.to_curve(depsgraph, apply_modifiers=True)
        return [path_of(spline) for spline in curve.splines if len(spline.points) + len(spline.bezier_points)]
    finally:
        obj.to_curve_clear()


# -- texts without an object -------------------------------------------------------------------------------------------

_letters: dict[str, list[Path]] = {}  # of texts that were read, at size 1


def has_letters(text: str) -> bool:
    """Whether ``read_letters`` knows a text."""
    return text in _letters


def read_letters(text: str) -> None:
    """Read the outlines of a text in Blender's font, by a text object that lives as long as this takes.

    Raises RenderError where Blender does not allow that now, as while it draws and in threads of renders.
    """
    if text in _letters:
        return
    waiting = RenderError(f"Text {text!r:.40} is not read yet: look again in a moment.")
    if threading.current_thread() is not threading.main_thread():
        raise waiting
    curve = bpy.data.curves.new(".SDF Letters", "FONT")
    obj = bpy.data.objects.new(".SDF Letters", curve)
    try:
        curve.body, curve.align_x, curve.align_y = text, "CENTER", "CENTER"
        _letters[text] = _paths_of(obj, bpy.context.view_layer.depsgraph)
    except AttributeError:
        raise waiting from None
    finally:
        bpy.data.objects.remove(obj)
        bpy.data.curves.remove(curve)


def shape_of_text(text: str, size: float, lamp) -> Shape:
    """The letters of a text around the origin, as a ``Light.sdf_lamp`` wants them. Raises RenderError with a
    sentence."""
    read_letters(text)
    paths = [Path(size * path.points, path.radii, path.closed) for path in _letters[text]]
    if not paths:
        raise RenderError(f"Text {text!r:.40} has no letters that can be seen: write some.")
    if lamp.object_form == NEON:
        return _neon(_kept(paths), lamp.neon_radius, lamp.neon_gap)
    found = _solid(_loops(paths), True, 0.0, 0.0, 0.0, lamp.thickness)
    if found is None:
        raise RenderError(f"Text {text!r:.40} has no area, so it has no inside: write other letters.")
    return found


def _loops(paths: list[Path]) -> tuple[bytes, ...]:
    return tuple(np.ascontiguousarray(path.points[:, :2]).tobytes() for path in paths)


def _named(obj: bpy.types.Object) -> str:
    return f"{'Text' if obj.type == 'FONT' else 'Curve'} '{obj.name}'"


def _kept(paths: list[Path]) -> tuple:
    """Paths as a key of a cache."""
    return tuple((path.points.tobytes(), path.radii.tobytes(), path.closed) for path in paths)


def _paths(kept: tuple) -> list[Path]:
    return [Path(np.frombuffer(points).reshape(-1, 3), np.frombuffer(radii), closed) for points, radii, closed in kept]


@functools.lru_cache(maxsize=64)
def _outline(loops: tuple[bytes, ...], text: bool) -> Outline | None:
    from ...sdf.data.outline import Outline

    try:
        return Outline.of([np.frombuffer(loop).reshape(-1, 2) for loop in loops], nonzero=text)
    except ValueError:
        return None


def _solid(loops, text: bool, offset: float, extrude: float, bevel: float, thickness: float) -> Shape | None:
    """Blender's bevel is that of a ball that rolls along the outline: it grows outwards."""
    from ...sdf.data.outline import Outline

    outline = _outline(loops, text)
    if outline is None:
        return None
    bevel = max(bevel, 0.0)
    height = 2.0 * (abs(extrude) + bevel)
    if not height > 0.0:
        height = thickness
    return SHAPES["extrusion"](Outline(outline.data, offset + bevel), height, bevel)  # type: ignore[call-arg]


def _taper(data: bpy.types.Curve, depsgraph: bpy.types.Depsgraph) -> tuple[bytes, bytes, str] | None:
    """Places along the taper object, from 0 to 1, its heights there, and how these join the radius."""
    obj = data.taper_object
    if obj is None or obj.type != "CURVE":
        return None
    if not obj.is_evaluated:
        obj = obj.evaluated_get(depsgraph)
    try:
        splines = obj.to_curve(depsgraph, apply_modifiers=True).splines
        path = path_of(splines[0]) if len(splines) else None
    finally:
        obj.to_curve_clear()
    if path is None or len(path.points) < 2:
        return None
    x, order = path.points[:, 0], np.argsort(path.points[:, 0], kind="stable")
    size = float(np.ptp(x))
    if not size > 0.0:
        return None
    places, heights = (x[order] - x.min()) / size, np.abs(path.points[order, 1])
    return places.tobytes(), heights.tobytes(), getattr(data, "taper_radius_mode", "OVERRIDE")


@functools.lru_cache(maxsize=64)
def _tube(kept: tuple, depth: float, taper: tuple[bytes, bytes, str] | None) -> Tube:
    from ...sdf.data.tube import Tube

    paths = []
    for points, radii, closed in _paths(kept):
        radii = depth * radii
        if taper is not None:
            places, heights, mode = np.frombuffer(taper[0]), np.frombuffer(taper[1]), taper[2]
            ends = np.concatenate([points, points[:1]]) if closed else points
            lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
            along = lengths[: len(points)] / max(lengths[-1], 1e-300)
            height = np.interp(along, places, heights)
            radii = {"MULTIPLY": radii * height, "ADD": radii + depth * height}.get(mode, depth * height)
        paths.append((points, np.maximum(radii, 0.0), closed))
    return Tube.of(paths)


@functools.lru_cache(maxsize=64)
def _neon(kept: tuple, radius: float, gap: float) -> Tube:
    from ...sdf.data.tube import Tube, with_gap

    paths = []
    for points, _, closed in _paths(kept):
        if closed and gap > 0.0 and len(points) > 2:
            points, closed = with_gap(points, gap + 2.0 * radius), False  # its ends are round
        paths.append((points, radius, closed))
    return Tube.of(paths)


def _remarks(obj: bpy.types.Object, lamp) -> list[str]:
    data, found = obj.data, []
    ignored = [
        modifier.name
        for modifier in obj.modifiers
        if (modifier.show_viewport or modifier.show_render)
        and not (obj.type == "CURVE" and getattr(modifier, "use_apply_on_spline", False))
    ]
    if ignored:
        cure = (
            "turn on Apply on Spline"
            if obj.type == "CURVE"
            else "convert the text to a curve, and turn on Apply on Spline"
        )
        found.append(f"{_named(obj)}: modifier '{ignored[0]}' works on its mesh, so it is not in the lamp: {cure}.")
    if lamp.object_form != NEON:
        if data.bevel_mode != "ROUND" and (data.bevel_depth > 0.0 or data.bevel_mode == "OBJECT"):
            found.append(f"{_named(obj)}: its bevel is not round, but the lamp always has a round one: choose Round.")
        trimmed = data.bevel_factor_start > 0.0 or data.bevel_factor_end < 1.0
        if trimmed and data.bevel_depth > 0.0:
            found.append(
                f"{_named(obj)}: its bevel starts or ends within the curve, and the lamp is as long as all of it."
            )
    return found


REMARKS |= {"FONT": _remarks, "CURVE": _remarks}
