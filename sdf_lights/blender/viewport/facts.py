# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Facts about a lamp that drawing needs beside its formulas: box, slope, volume; and, for an emission that varies, its
mean and sampling rate.

Facts with closed forms are available at once. A thread computes the others as the path tracer does. Meanwhile the
volume is estimated from the box, and from the fraction of its box that the lamp's shape filled before. The emission
keeps its last mean.
"""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ... import jit
from ...graph.lipschitz import global_lipschitz
from ...interruption import Interrupted, Watch, watched
from ...sdf.emission import Emission
from ...sdf.shapes import Shape

KEPT = 512  # shapes whose facts are cached
TYPICAL = 0.3  # fraction of its box that a shape fills, before it is measured
TYPICAL_POINTS = 32.0  # samples of an emission along the diagonal of its box, before it is measured


class Facts(NamedTuple):
    """``low``, ``high``: corners of a box (3,) around the shape, in its local space. ``lipschitz``: bound of the slope
    of its field there. ``volume`` in m³ of its local space. ``mean`` (3,) of the relative emission over the volume.
    ``rate``: samples per metre of a ray in the shape's local space; 0 if the emission is uniform. ``problem``: a
    sentence with the reason why it cannot be drawn, or empty."""

    low: np.ndarray
    high: np.ndarray
    lipschitz: float = 1.0
    volume: float = 1.0
    mean: np.ndarray = np.ones(3)
    rate: float = 0.0
    problem: str = ""


Lit = tuple[Shape, Emission | None]  # the key of the facts

NO_FACTS = Facts(np.zeros(3), np.zeros(3))
EMPTY = "its shape has no interior, so it gives no light: make its parts overlap."
DARK = "its emission is zero everywhere inside, so it gives no light: make its last line positive somewhere."


def varies(emission: Emission | None) -> bool:
    """Whether the brightness varies in space."""
    return emission is not None and emission.varies


def at_once(shape: Shape, emission: Emission | None = None) -> Facts | None:
    """The facts of a shape and an emission if they have closed forms, else None. Takes microseconds."""
    volume = shape.volume()
    if volume is None or not math.isfinite(shape.lipschitz) or varies(emission):
        return None
    low, high = shape.bounds()
    mean = np.ones(3) if emission is None else emission.placed(shape).evaluate(np.zeros(3))
    problem = _problem(low, high)
    if not problem and not volume > 0.0:
        problem = EMPTY
    if not problem and not mean.max() > 0.0:
        problem = DARK
    return Facts(low, high, shape.lipschitz, volume, mean, problem=problem)


def measured(shape: Shape, emission: Emission | None = None) -> Facts:
    """The facts of any shape and emission. Takes up to a second, and longer if kernels must be compiled."""
    low, high = shape.bounds()
    problem = _problem(low, high)
    if problem:
        return NO_FACTS._replace(problem=problem)
    found = _inside(shape, emission, low, high)
    if found.problem:
        return found
    lipschitz = shape.lipschitz
    if not math.isfinite(lipschitz):  # shapes that may jump are drawn too, only less exactly
        lipschitz = global_lipschitz(shape.formula(), found.low, found.high, shape.parameters(), jumps=False)
    if not math.isfinite(lipschitz):
        return found._replace(
            problem=(
                "nothing bounds how fast its field changes, so it cannot be drawn: use shapes or operators whose field "
                "has a bound."
            )
        )
    return found._replace(lipschitz=lipschitz)


def _problem(low: np.ndarray, high: np.ndarray) -> str:
    if not np.isfinite([low, high]).all():
        return "its shape has no limits: intersect it with a box or another shape."
    if not np.all(high > low):
        return EMPTY
    return ""


def _inside(shape: Shape, emission: Emission | None, low: np.ndarray, high: np.ndarray) -> Facts:
    """All facts except the slope, and perhaps a tighter box, from the lamp as the path tracer builds it."""
    identity = np.eye(4)
    if not jit.AVAILABLE:
        from ...render.reference.sdf_lamps import SdfLamp
        from ...render.scene import Lamp

        try:
            lamp = SdfLamp(Lamp("", shape, identity, density=1.0, emission=emission))
        except ValueError as error:
            return Facts(low, high, problem=f"{error}.")
        return Facts(low, high, volume=lamp.volume, mean=lamp.emission, rate=_typical_rate(emission, low, high))
    from ...emitter.building.build import LampError, build_lamp

    try:
        lamp = build_lamp("", shape, identity, density=1.0, emission=emission)
    except LampError as error:
        return Facts(low, high, problem=str(error).partition(": ")[2])
    if lamp.tree is not None:
        tight_low, tight_high = lamp.tree.bounds(identity)
        low, high = np.maximum(low, tight_low), np.minimum(high, tight_high)
    rate = float(lamp.glow["rate"][0]) if len(lamp.glow) else 0.0
    return Facts(low, high, volume=float(lamp.row["volume"][0]), mean=lamp.row["emission"][0], rate=rate)


def _typical_rate(emission: Emission | None, low: np.ndarray, high: np.ndarray) -> float:
    return TYPICAL_POINTS / float(np.linalg.norm(high - low)) if varies(emission) else 0.0


class FactFinder:
    """Facts of lamps; a thread computes some of them. The thread calls ``on_news()``."""

    def __init__(self, on_news: Callable[[], None] = lambda: None):
        self._on_news = on_news
        self._lock = threading.Lock()
        self._known: OrderedDict[Lit, Facts] = OrderedDict()
        self._wanted: OrderedDict[str, Lit] = OrderedDict()  # by lamp: of a moving slider, only the last value counts
        self._last: dict[str, Facts] = {}
        self._thread: threading.Thread | None = None
        self._ended = False  # the thread's present work is outdated

    def find(self, lamp: str, shape: Shape, emission: Emission | None = None, wait: bool = False) -> Facts | None:
        """Facts of the shape and the emission of that lamp, or a temporary estimate; None if there is no basis for an
        estimate yet.

        ``wait``: no estimate.
        """
        lit = shape, emission
        facts = at_once(*lit)
        if facts is None:
            with self._lock:
                facts = self._known.get(lit)
            if facts is None and wait:
                facts = self._keep(lit, measured(*lit))
        if facts is None:
            self._want(lamp, lit)
            return self._estimate(lamp, *lit)
        self._last[lamp] = facts
        return facts

    @property
    def busy(self) -> bool:
        """Whether its thread is working."""
        with self._lock:
            return self._thread is not None

    def stop(self) -> None:
        """Drop the remaining work, and wait for the thread."""
        with self._lock:
            self._wanted.clear()
            self._ended, thread = True, self._thread
        if thread is not None:
            thread.join()
        self._ended = False

    def _estimate(self, lamp: str, shape: Shape, emission: Emission | None) -> Facts | None:
        last, filled, mean = self._last.get(lamp), TYPICAL, np.ones(3)
        if last is not None and not last.problem:
            filled, mean = last.volume / np.prod(last.high - last.low), last.mean
        facts = at_once(shape)
        if facts is None:
            low, high = shape.bounds()
            if not math.isfinite(shape.lipschitz) or _problem(low, high):
                return None
            facts = Facts(low, high, shape.lipschitz, float(filled * np.prod(high - low)))
        return facts._replace(mean=mean, rate=_typical_rate(emission, facts.low, facts.high))

    def _want(self, lamp: str, lit: Lit) -> None:
        with self._lock:
            self._wanted[lamp] = lit
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="SDF Lights: shapes", daemon=True)
                self._thread.start()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._wanted:
                    self._thread = None
                    break
                _, lit = self._wanted.popitem(last=False)
                known = lit in self._known
            if not known:
                try:
                    with watched(Watch(lambda: self._ended)):
                        facts = measured(*lit)
                except Interrupted:
                    continue
                except Exception as error:
                    facts = NO_FACTS._replace(
                        problem=f"measuring its shape failed ({type(error).__name__}: {error}): simplify it."
                    )
                self._keep(lit, facts)
            self._on_news()

    def _keep(self, lit: Lit, facts: Facts) -> Facts:
        with self._lock:
            self._known[lit] = facts
            while len(self._known) > KEPT:
                self._known.popitem(last=False)
        return facts
