# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What drawing a lamp needs to know of its shape and its formula does not say: box, slope, volume.

Where these have closed forms they are there at once. Otherwise a thread finds them as the path tracer does; meanwhile the
volume is estimated from the box, and from what the lamp's shape filled of its box before.
"""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ... import jit
from ...sdf.lipschitz import global_lipschitz
from ...sdf.shapes import Shape

KEPT = 512  # shapes whose facts are remembered
TYPICAL = 0.3  # part of its box that a shape fills, before it is measured


class Facts(NamedTuple):
    """``low``, ``high``: corners of a box (3,) around the shape, in its own space. ``lipschitz``: bound on the slope of
    its field there. ``volume`` in m³ of its own space. ``problem``: a sentence on why it cannot be drawn, or empty."""

    low: np.ndarray
    high: np.ndarray
    lipschitz: float = 1.0
    volume: float = 1.0
    problem: str = ""


NO_FACTS = Facts(np.zeros(3), np.zeros(3))


def at_once(shape: Shape) -> Facts | None:
    """The facts of a shape that has closed forms for them, else None. Takes microseconds."""
    volume = shape.volume()
    if volume is None or not math.isfinite(shape.lipschitz):
        return None
    low, high = shape.bounds()
    problem = _problem(low, high)
    if not problem and not volume > 0.0:
        problem = "its shape has no interior, so it gives no light: make its parts overlap."
    return Facts(low, high, shape.lipschitz, volume, problem)


def measured(shape: Shape) -> Facts:
    """The facts of any shape. Takes up to a second, and longer where kernels have to be compiled."""
    low, high = shape.bounds()
    problem = _problem(low, high)
    if problem:
        return NO_FACTS._replace(problem=problem)
    volume, low, high, problem = _inside(shape, low, high)
    if problem:
        return Facts(low, high, problem=problem)
    lipschitz = shape.lipschitz
    if not math.isfinite(lipschitz):
        lipschitz = global_lipschitz(shape.formula(), low, high, shape.parameters())
    if not math.isfinite(lipschitz):
        return Facts(low, high, problem="nothing bounds how fast its field changes, so it cannot be drawn.")
    return Facts(low, high, lipschitz, volume)


def _problem(low: np.ndarray, high: np.ndarray) -> str:
    if not np.isfinite([low, high]).all():
        return "its shape has no limits: intersect it with a box or another shape."
    if not np.all(high > low):
        return "its shape has no interior, so it gives no light: make its parts overlap."
    return ""


def _inside(shape: Shape, low: np.ndarray, high: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, str]:
    """Volume, a tighter box, and a problem."""
    identity = np.eye(4)
    if not jit.AVAILABLE:
        from ...render.reference.lamps import SdfLamp
        from ...render.scene import Lamp

        try:
            return SdfLamp(Lamp("", shape, identity)).volume, low, high, ""
        except ValueError as error:
            return 0.0, low, high, f"{error}."
    from ...emitter.lamps import LampError, build_lamp

    try:
        built = build_lamp("", shape, identity)
    except LampError as error:
        return 0.0, low, high, str(error).partition(": ")[2]
    if built.tree is not None:
        tight_low, tight_high = built.tree.bounds(identity)
        low, high = np.maximum(low, tight_low), np.minimum(high, tight_high)
    return float(built.row["volume"][0]), low, high, ""


class FactFinder:
    """Facts of lamps, of which some are found by a thread. ``on_news()`` is called by that thread."""

    def __init__(self, on_news: Callable[[], None] = lambda: None):
        self._on_news = on_news
        self._lock = threading.Lock()
        self._known: OrderedDict[Shape, Facts] = OrderedDict()
        self._wanted: OrderedDict[str, Shape] = OrderedDict()  # by lamp: of a slider that moves only the last place counts
        self._last: dict[str, Facts] = {}
        self._thread: threading.Thread | None = None

    def find(self, lamp: str, shape: Shape, wait: bool = False) -> Facts | None:
        """Facts of the shape of that lamp, or for a while an estimate; None where there is nothing to go by yet.

        ``wait``: no estimate.
        """
        facts = at_once(shape)
        if facts is None:
            with self._lock:
                facts = self._known.get(shape)
            if facts is None and wait:
                facts = self._keep(shape, measured(shape))
        if facts is None:
            self._want(lamp, shape)
            return self._estimate(lamp, shape)
        self._last[lamp] = facts
        return facts

    @property
    def busy(self) -> bool:
        with self._lock:
            return self._thread is not None

    def stop(self) -> None:
        """Forgets what is still wanted, and waits for the thread."""
        with self._lock:
            self._wanted.clear()
            thread = self._thread
        if thread is not None:
            thread.join()

    def _estimate(self, lamp: str, shape: Shape) -> Facts | None:
        low, high = shape.bounds()
        if not math.isfinite(shape.lipschitz) or _problem(low, high):
            return None
        last, filled = self._last.get(lamp), TYPICAL
        if last is not None and not last.problem:
            filled = last.volume / np.prod(last.high - last.low)
        return Facts(low, high, shape.lipschitz, float(filled * np.prod(high - low)))

    def _want(self, lamp: str, shape: Shape) -> None:
        with self._lock:
            self._wanted[lamp] = shape
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="SDF Lights: shapes", daemon=True)
                self._thread.start()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._wanted:
                    self._thread = None
                    break
                _, shape = self._wanted.popitem(last=False)
                known = shape in self._known
            if not known:
                try:
                    facts = measured(shape)
                except Exception as error:
                    facts = NO_FACTS._replace(
                        problem=f"measuring its shape failed ({type(error).__name__}: {error}): simplify it.")
                self._keep(shape, facts)
            self._on_news()

    def _keep(self, shape: Shape, facts: Facts) -> Facts:
        with self._lock:
            self._known[shape] = facts
            while len(self._known) > KEPT:
                self._known.popitem(last=False)
        return facts
