# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``frozen`` makes what ``dataclasses.dataclass(frozen=True)`` makes; imports leave Python's search for garbage on."""

import copy
import dataclasses
import gc
import pickle

import pytest

from sdf_lights.frozen import frozen
from sdf_lights.garbage import nothing_to_collect, rarely_all_searched


def _pair(decorator, name: str):
    class Pair:
        first: float
        second: float = 2.0
        rest: list = dataclasses.field(default_factory=list, metadata={"unit": "NONE"})

        def __post_init__(self):
            object.__setattr__(self, "first", float(self.first))

    Pair.__name__ = Pair.__qualname__ = name
    return decorator(Pair)


@frozen
class Point:
    """A place."""

    x: float
    y: float = 0.0


OURS, THEIRS = _pair(frozen, "Pair"), _pair(dataclasses.dataclass(frozen=True), "Pair")


@pytest.mark.parametrize(
    "values, named",
    [((1,), {}), ((1, 3), {}), ((), {"first": 1, "rest": [4]}), ((1, 2, [3]), {})],
)
def test_has_the_values_of_a_frozen_dataclass(values, named):
    ours, theirs = OURS(*values, **named), THEIRS(*values, **named)
    assert repr(ours) == repr(theirs)
    assert dataclasses.asdict(ours) == dataclasses.asdict(theirs)
    assert ours == OURS(*values, **named) and ours != theirs
    assert repr(dataclasses.replace(ours, second=5.0)) == repr(dataclasses.replace(theirs, second=5.0))


@pytest.mark.parametrize(
    "values, named",
    [((), {}), ((1, 2, [], 4), {}), ((1,), {"first": 1}), ((1,), {"third": 1})],
)
def test_refuses_what_a_frozen_dataclass_refuses(values, named):
    for kind in (OURS, THEIRS):
        with pytest.raises(TypeError):
            kind(*values, **named)


def test_cannot_change():
    point = Point(1.0)
    for change in (lambda: setattr(point, "x", 2.0), lambda: setattr(point, "z", 2.0), lambda: delattr(point, "x")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            change()
    assert point == Point(1.0, 0.0)


def test_is_a_key_and_can_be_copied():
    assert {Point(1.0): "there"}[Point(1.0, 0.0)] == "there"
    assert hash(Point(1.0)) == hash((1.0, 0.0))
    assert copy.deepcopy(Point(1.0)) == pickle.loads(pickle.dumps(Point(1.0))) == Point(1.0)


def test_a_class_keeps_its_own_methods():
    class Own:
        values: tuple

        def __init__(self, *values):
            object.__setattr__(self, "values", values)

    assert frozen(Own)(1, 2).values == (1, 2)

    class Derived(Own):
        pass

    assert frozen(Derived)(1, 2) == frozen(Derived)(1, 2)


def _failing():
    with nothing_to_collect():
        assert not gc.isenabled()
        raise KeyError


@pytest.mark.parametrize("was_on", [True, False])
def test_garbage_is_collected_after_a_block_as_before(was_on):
    before = gc.isenabled()
    try:
        (gc.enable if was_on else gc.disable)()
        with pytest.raises(KeyError):
            _failing()
        assert gc.isenabled() == was_on and not gc.get_freeze_count()
    finally:
        (gc.enable if before else gc.disable)()


def test_all_objects_are_searched_as_often_as_before_after_a_block():
    kept = gc.get_threshold()
    with rarely_all_searched():
        assert gc.get_threshold()[:2] == kept[:2] and gc.get_threshold()[2] >= 1000
    assert gc.get_threshold() == kept
