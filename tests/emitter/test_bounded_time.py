# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of many parts and of long loops: what they cost to build, and that the work can be stopped at any time.

Times are of processors, so that other work on the machine does not count.
"""

import gc
import threading
import time

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.emitter.tree import interior
from sdf_lights.interruption import Interrupted, Watch, check, say, watched
from sdf_lights.sdf.expression import evaluate
from support.lamps.hard_cases import scattered

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

STOPS = 0.35  # seconds within which a thread has to look: it is one of several, and half a second is what users wait
LONG_LOOP = """
q = p
for i in range(1000):
    q = q + 0.001 * sin({} * q)
field(length(q) - 1.5) & box(2)
"""
SHAPES = {
    "2000 primitives": lambda: scattered(2000, seed=1, smooth=False),
    "2000 primitives, blended": lambda: scattered(2000, seed=1),
    "a loop of 1000 rounds": lambda: evaluate(LONG_LOOP.format(3)),
}


@pytest.fixture(scope="module", autouse=True)
def compiled():
    for shape in (scattered(5), scattered(5, smooth=False), evaluate(LONG_LOOP.format(3).replace("1000", "3"))):
        build_lamp("Small", shape, np.eye(4))
    gc.freeze()  # what thousands of other tests have left takes Python's garbage collection a second to look through
    yield
    gc.unfreeze()


def spent(count: int, smooth: bool, seed: int = 2) -> float:
    started = time.process_time()
    build_lamp("Lamp", scattered(count, seed, smooth), np.eye(4))
    return time.process_time() - started


@pytest.mark.parametrize("smooth", [False, True])
def test_the_cost_grows_little_faster_than_the_parts(smooth):
    """n log n from 250 to 2000 parts is a factor of 11; the square would be 64."""
    few, many = min(spent(250, smooth, seed) for seed in (2, 3)), spent(2000, smooth)
    assert many < 25.0 * few
    assert many < 15.0


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "a loop of 1000 rounds")) for name in SHAPES]
)
def test_building_asks_whether_to_go_on(name):
    """No thread works for long without asking: a build ends soon after nobody wants it any more."""
    shape = SHAPES[name]()
    last: dict[int, float] = {}
    pauses = []

    def stop() -> bool:
        thread, now = threading.get_ident(), time.thread_time()
        pauses.append(now - last.get(thread, now))
        last[thread] = now
        return False

    started = time.process_time()
    with watched(Watch(stop)) as watch:
        build_lamp("Lamp", shape, np.eye(4))
    assert watch.doing == "Building lamp “Lamp”"
    assert len(pauses) > 10 and max(pauses) < STOPS
    assert time.process_time() - started < 40.0


def test_what_was_stopped_is_built_as_if_nothing_had_been():
    shape = evaluate(LONG_LOOP.format(2).replace("1000", "20"))
    whole = interior.tree(shape)
    for after in (1, 30, 500):
        interior.tree.cache_clear()
        left = iter(range(after))
        with pytest.raises(Interrupted), watched(Watch(lambda: next(left, None) is None)):
            interior.tree(shape)
    again = interior.tree(shape)
    assert again is not whole
    assert all(np.array_equal(getattr(again, name), getattr(whole, name)) for name in ("nodes", "lists", "boxes"))


@pytest.mark.parametrize("smooth", [False, True])
def test_parts_of_the_work_change_no_bit(monkeypatch, smooth):
    shape = scattered(20, seed=5, smooth=smooth)
    whole = interior.tree(shape)
    interior.tree.cache_clear()
    monkeypatch.setattr(interior, "ROWS", 1)
    monkeypatch.setattr(interior, "SLICE", 1.0)
    again = interior.tree(shape)
    assert again is not whole
    assert all(np.array_equal(getattr(again, name), getattr(whole, name)) for name in ("nodes", "lists", "boxes"))


def test_nobody_has_to_watch():
    check()
    say("anything")
    with watched(Watch(lambda: True)), pytest.raises(Interrupted):
        check()
    check()
