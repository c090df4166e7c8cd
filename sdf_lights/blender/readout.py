# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Facts about a lamp's shape for panels: volume, power, bounds, size. Nothing here may delay drawing.

A thread computes whatever takes longer than a redraw, once for each shape, and caches it. First comes a volume, within
a time budget. Then comes the question whether rays are certain to miss nothing, which may take seconds. The next edit
ends the thread.
"""

from __future__ import annotations

import atexit
import functools
import math
import threading
import time
from typing import NamedTuple

import bpy
import numpy as np

from ..graph import formula
from ..interruption import Interrupted, Watch, watched
from ..sdf.emission import Emission
from ..sdf.program import NoClosedForm
from ..sdf.shapes import BOUND, EXACT, Shape

_POINTS = 1 << 14  # points of one round of the volume estimate
_ROUNDS = 8
_BUDGET = 0.25  # seconds of one estimate
_REST = 0.15  # seconds without a new shape before an estimate begins, so a slider is released first
_MOST_KEPT = 64

_EXACTNESS = {EXACT: "exact distance", BOUND: "distance never overestimated"}


class Volume(NamedTuple):
    """Cubic metres in the shape's local space, and the standard error; 0 if exact.

    ``glow`` is the mean of the relative emission over the volume; 1 if it is uniform.
    """

    value: float
    error: float
    glow: float = 1.0


_POLL = 0.1  # seconds between two checks for a result

_certain: dict[Shape, bool] = {}
_found: dict[tuple[Shape, Emission | None], Volume] = {}
_wanted: list[tuple[float, Shape, Emission | None]] = []
_finders: list["_Finder"] = []  # at most one


def is_certified(shape: Shape) -> bool:
    """Whether rays are certain to miss nothing of a shape. For fields, this is computed while Blender is idle; until
    then they count as certain."""
    return shape.certified and _certain.get(shape, True)


def _keep_checking(shape: Shape, pattern: Emission | None) -> None:
    """Find out whether a shape is certain, if another shape has ended the thread that computed it."""
    if shape.certified and (shape, pattern) in _found and shape not in _certain:
        _want(shape, pattern)


def volume_of(shape: Shape, pattern: Emission | None = None) -> Volume | None:
    """The volume; None if it is not known yet. Panels are redrawn when it is known.

    With a ``pattern``, its mean is computed too.
    """
    exact = shape.volume() if pattern is None else None
    if exact is not None:
        return Volume(exact, 0.0)
    if (shape, pattern) in _found:
        return _found[shape, pattern]
    _want(shape, pattern)
    return None


def _want(shape: Shape, pattern: Emission | None) -> None:
    if bpy.app.background or any(finder.busy and finder.lit == (shape, pattern) for finder in _finders):
        return
    if not bpy.app.timers.is_registered(_find):
        bpy.app.timers.register(_find, first_interval=_REST)
    _wanted[:] = [(time.monotonic(), shape, pattern)]


class _Finder:
    """A thread that computes the facts of a shape for panels. ``news``: it has new results since ``news`` was last
    False."""

    def __init__(self, shape: Shape, pattern: Emission | None):
        self.lit, self._ended, self.news = (shape, pattern), False, False
        self._thread = threading.Thread(target=self._work, name="SDF Lights: readout", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        return self._thread.is_alive()

    def end(self) -> None:
        """End the thread and wait for it."""
        self._ended = True
        self._thread.join()

    def _work(self) -> None:
        from ..emitter.building.build import is_certified  # not at the top: it imports Numba, which takes a second

        try:
            with watched(Watch(lambda: self._ended)):
                if self.lit not in _found:
                    _keep(_found, self.lit, estimate(*self.lit, _BUDGET))
                    self.news = True
                _keep(_certain, self.lit[0], is_certified(self.lit[0]))
                self.news = True
        except Interrupted:
            pass


def _keep(known: dict, key, value) -> None:
    while len(known) >= _MOST_KEPT:
        del known[next(iter(known))]
    known[key] = value


def _find() -> float | None:
    """A timer: begins the wanted work after a pause in edits, and redraws panels when there are new results."""
    if _wanted:
        asked, *wanted = _wanted[-1]
        if time.monotonic() - asked < _REST:
            return _REST
        _wanted.clear()
        end()
        _finders.append(_Finder(*wanted))
    if not _finders:
        return None
    finder = _finders[0]
    busy = finder.busy
    if finder.news:
        finder.news = False
        _redraw()
    if not busy and not _wanted:
        _finders.clear()
        return None
    return _POLL


def end() -> None:
    """End the thread, if there is one."""
    while _finders:
        _finders.pop().end()


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"PROPERTIES", "VIEW_3D"}:
                area.tag_redraw()


def estimate(shape: Shape, pattern: Emission | None, budget: float) -> Volume:
    """The fraction of random points of the bounding box that are inside. Takes as many points as the time (seconds)
    allows."""
    low, high = shape.bounds()
    placed = pattern.placed(shape) if pattern is not None else None
    random, inside, tried, glow, started = np.random.default_rng(0), 0, 0, 0.0, time.perf_counter()
    points = _POINTS // 16  # until their time is known
    for _ in range(_ROUNDS):
        found = random.uniform(low, high, (points, 3))
        found = found[shape.distance(found) <= 0.0]
        inside += len(found)
        if placed is not None and len(found):
            glow += float(placed.evaluate(found).mean(axis=-1).sum())
        tried += points
        if (time.perf_counter() - started) * (1.0 + _POINTS / points) > budget:
            break
        points = _POINTS
    share, box = inside / tried, float(np.prod(high - low))
    error = math.sqrt(max(share * (1.0 - share), 1.0 / tried) / tried) * box
    return Volume(share * box, error, 1.0 if placed is None else glow / max(inside, 1))


def power_of(
    light: bpy.types.Light, shape: Shape, matrix: np.ndarray, pattern: Emission | None = None, wait: bool = False
) -> float | None:
    """Watts of a lamp with this shape and emission under a matrix (4 × 4); None if its volume is not known yet and
    ``wait`` is off."""
    exposed = 2.0**light.exposure
    if light.sdf_lamp.normalize:
        return light.energy * exposed
    volume = volume_of(shape, pattern) or (estimate(shape, pattern, _BUDGET) if wait else None)
    scale = abs(float(np.linalg.det(matrix[:3, :3])))
    return (
        None
        if volume is None
        else (4.0 * math.pi * light.sdf_lamp.density * exposed * volume.value * volume.glow * scale)
    )


@functools.lru_cache(maxsize=256)
def _shape_facts(shape: Shape, certified: bool) -> tuple[str, ...]:
    try:
        kind = f"closed form, {_counted(len(shape.program()), 'instruction')}"
    except NoClosedForm:
        kind = f"field, {_counted(len(formula.order(shape.formula())), 'operation')}"
    field = _EXACTNESS.get(shape.exactness, "sign only") if certified else "not certified"
    parts = _counted(shape.size, "part") + (f", {shape.depth} deep" if shape.size > 1 else "")
    return f"Field: {field}", f"Tree: {parts}", f"Rays: {kind}"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" + ("s" if count != 1 else "")


def facts(shape: Shape, matrix: np.ndarray, light: bpy.types.Light, pattern: Emission | None = None) -> list[str]:
    """Lines about a lamp with this shape and emission under a matrix (4 × 4)."""
    scale = abs(float(np.linalg.det(matrix[:3, :3])))
    volume = volume_of(shape)
    _keep_checking(shape, None)
    lines = [
        "Volume: …"
        if volume is None
        else f"Volume: {volume.value * scale:.4g} m³"
        if not volume.error
        else f"Volume: about {volume.value * scale:.3g} m³ ± {_percent(volume)}"
    ]
    power = power_of(light, shape, matrix, pattern)
    about = "about " if not light.sdf_lamp.normalize and pattern is not None else ""
    lines.append("Power: …" if power is None else f"Power: {about}{power:.4g} W")
    low, high = _bounds(shape, matrix.tobytes())
    lines.append("Bounds: " + " × ".join(f"{extent:.3g}" for extent in np.maximum(high - low, 0.0)) + " m")
    return lines


def details(shape: Shape) -> tuple[str, ...]:
    """Lines about the representation and tracing of a shape."""
    return _shape_facts(shape, is_certified(shape))


@functools.lru_cache(maxsize=256)
def _bounds(shape: Shape, matrix: bytes):
    return shape.bounds(np.frombuffer(matrix).reshape(4, 4))


def _percent(volume: Volume) -> str:
    return f"{100.0 * volume.error / volume.value:.1g} %" if volume.value > 0.0 else "?"


CLASSES = ()


def register():
    atexit.register(end)


def unregister():
    atexit.unregister(end)
    if bpy.app.timers.is_registered(_find):
        bpy.app.timers.unregister(_find)
    end()
    for known in (_certain, _found, _wanted):
        known.clear()
    _bounds.cache_clear()
    _shape_facts.cache_clear()
