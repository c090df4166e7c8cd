# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random programs of the language: rays through what is called certified miss nothing that a dense march sees."""

import pytest

from sdf_lights.emitter.tree.interior import tree
from sdf_lights.sdf.expression import evaluate
from support.lamps.marched import Verdict, missed, verdict
from support.lamps.rays import Traced
from support.shapes import random_programs


def judge(seeds) -> tuple[int, int, list[int]]:
    """How many of the programs are lamps, how many of these are certified, and which of those are wrong."""
    found = {seed: verdict(seed) for seed in seeds}
    lamps = [seed for seed in found if found[seed] is not Verdict.NO_LAMP]
    wrong = [seed for seed in found if found[seed] is Verdict.WRONG]
    return len(lamps), sum(found[seed] is not Verdict.NOT_CERTIFIED for seed in lamps), wrong


def test_certified_programs_lose_nothing():
    lamps, certified, wrong = judge(range(24))
    assert not wrong, [random_programs.program(seed) for seed in wrong]
    assert lamps >= 15 and certified >= 7


@pytest.mark.slow
def test_certified_programs_lose_nothing_of_a_hundred():
    lamps, certified, wrong = judge(range(1000, 1100))
    assert not wrong, [random_programs.program(seed) for seed in wrong]
    assert lamps >= 60 and certified >= 30


REPORTED = (
    "circular_difference(union(apollonian_gasket(radius=0.3635), triangular_prism(radius=0.6083)), "
    "(field(tan((p.x if p.z > 0.131 else length(p)))) & box(4)), radius=0.08461)"
)
TORN = {
    "a condition": "field((length(p) - 0.5) if p.z > 0.1 else (length(p) - 0.3))",
    "a remainder of what varies": "field(mod(p.x, 0.3 + 0.1 * sin(9 * p.y)) - 0.1) & box(0.5)",
    "a pole": "field(tan(5 * p.x) - p.y) & box(0.5)",
    "a rounded displacement": "field(length(p) - 0.5 + 0.05 * round(3 * p.x))",
    "a wave that does not close": "field(length(p) - 0.5 + 0.1 * sin(2.5 * atan2(p.y, p.x)))",
    "cells that do not fit": "field(sphere(0.2)(polar(p, 5.5) - (0.5, 0.2, 0))) & box(1)",
    "a loop that points leave": (
        "q = p\nfor i in range(8):\n    if q.x > 0.3: break\n    q = q * 1.3 + 0.05\nfield(length(q) - 0.6) & box(1)"
    ),
    "as it was reported": REPORTED,
}


@pytest.mark.parametrize("name", TORN)
def test_what_jumps_is_not_certified(name):
    assert not tree(evaluate(TORN[name])).certified


WHOLE = {
    "cells": "q = vec3(mod(p.x + 0.3, 0.6) - 0.3, p.y, p.z)\nfield(box(0.1)(q)) & sphere(1)",
    "parts of a turn": "field(sphere(0.2)(polar(p, 6) - (0.5, 0, 0))) & box(1)",
    "noise": "field(length(p) - 0.5 + 0.05 * noise(4 * p)) & box(1)",
    "a fold by a condition": "field((p.x if p.x > 0 else -p.x) + length(p.yz) - 0.5)",
    "a triangle wave": "field(length(p) - 0.5 + 0.05 * abs(fract(3 * p.x) - 0.5))",
    "a wave that closes": "field(max(length(p) - 0.5 + 0.05 * sin(3 * atan2(p.y, p.x)), 0.2 - length(p.xy)))",
    "a Möbius strip": (
        "q = rotate(vec2(length(p.xy) - 0.6, p.z), degrees(0.5 * atan2(p.y, p.x)))\n"
        "max(max(abs(q.x) - 0.2, abs(q.y) - 0.05), length(vec2(length(p.xy) - 0.6, p.z)) - 0.3)"
    ),
}


@pytest.mark.parametrize("name", WHOLE)
def test_what_joins_again_is_certified(name):
    shape = evaluate(WHOLE[name])
    traced = Traced(shape)
    assert traced.tree.certified
    assert missed(shape, traced, 40) <= 0.0
