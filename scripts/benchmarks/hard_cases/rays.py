# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays on which entries and exits are easily missed: their number, and the length between them.

Balls have closed forms to compare with. The tests' oracle judges everything else: an independent march, 100 times finer
than a coarse one, a thousand times finer where the two differ, and again a thousand times finer where they still do.
The limit is the guarantee of the search: zeros farther apart than its resolution are all found, so a ray may lose that
much of its length.
"""

from __future__ import annotations

import functools
import zlib

import numpy as np

from sdf_lights.emitter.intersection.cover import RESOLUTION
from sdf_lights.sdf.shapes import BoxFrame, Sphere, Transformed
from sdf_lights.sdf.shapes.displacement import NoiseDisplacement
from sdf_lights.sdf.shapes.orbits import Mandelbulb
from support.lamps import oracle
from support.lamps.hard_cases import HARD_CASES, SMOOTH, Case, directions, grazing, inside
from support.lamps.rays import Traced
from support.lamps.shapes_under_test import FieldOf, scaled, turned

from . import Figure, case

RAYS, QUICK_RAYS = 20_000, 1_000


def skimming(shape, rng, n):
    """Rays towards and past balls of radius 1 around the origin, 1e-12 to 1e-2 inside and outside of their tangents."""
    toward = directions(rng, n)
    side = np.cross(toward, directions(rng, n))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    off = 1.0 + rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(-12.0, -2.0, n)
    return off[:, None] * side - 3.0 * toward, toward


def close_up(distances):
    """Rays like those of a camera 1e-4 to 1e-2 in front of the surface, relative to the size."""

    def rays(shape, rng, n):
        origins, along = grazing(shape, rng, n)
        low, high = shape.bounds()
        size = np.linalg.norm(high - low)
        # ``grazing`` starts 0.7 of the size before a point beside the surface.
        origins = origins + (0.7 - 10.0 ** rng.uniform(*np.log10(distances), (n, 1))) * size * along
        spread = along + 0.5 * directions(rng, n)
        return origins, spread / np.linalg.norm(spread, axis=1, keepdims=True)

    return rays


MORE = {
    "stretched 1 : 10,000": Case(Transformed(SMOOTH, turned(0.7, 1) @ scaled(100.0, 1.0, 0.01))),
    "Mandelbulb": Case(Mandelbulb()),
    "Mandelbulb, close": Case(Mandelbulb(), close_up((1e-4, 1e-2))),
    "sparse frame": Case(FieldOf(BoxFrame((0.6, 0.5, 0.4), 0.004))),
    "high-frequency noise": Case(NoiseDisplacement(Sphere(0.7), 0.05, 0.03, 4.0)),
    "noise, from inside": Case(HARD_CASES["noise"].shape, inside),
}


@functools.lru_cache(maxsize=2)
def tangents(quick: bool) -> tuple[np.ndarray, np.ndarray]:
    """(n,) error of the number of intervals of ``skimming`` rays, and of their length, of the ball as a field."""
    ball = FieldOf(Sphere(1.0))
    origins, toward = skimming(ball, np.random.default_rng(1), 10 * (QUICK_RAYS if quick else RAYS))
    found = Traced(ball).trace(origins, toward)
    # Exact for the rounded rays, except for the last rounding: the squared distance of a line is |o × d|² / |d|².
    wide_o, wide_d = origins.astype(np.longdouble), toward.astype(np.longdouble)
    square = (wide_d * wide_d).sum(axis=1)
    left = 1.0 - (np.cross(wide_o, wide_d) ** 2).sum(axis=1) / square
    length = (2.0 * np.sqrt(np.maximum(left, 0.0) / square)).astype(float)
    return found[:, 0] - (length > 0.0), found[:, 1] - length, length


@case("near-tangent-crossings")
def near_tangent_crossings(quick):
    """rays, of those 1e-12 to 1e-2 from a tangent of a ball, with a wrong number of intervals"""
    wrong, _, length = tangents(quick)
    # The size is that of the bounding box's half diagonal. Intervals shorter than the resolution may be lost.
    sure = (length == 0.0) | (length > RESOLUTION * np.sqrt(3.0))
    return Figure(
        float(np.mean(wrong[sure] != 0.0)), 0.0, dict(rays=int(sure.sum()), of_all=float(np.mean(wrong != 0.0)))
    )


@case("near-tangent-lengths")
def near_tangent_lengths(quick):
    """largest error of the length of such a ray in the ball, relative to its half diagonal"""
    _, error, _ = tangents(quick)
    return Figure(float(np.abs(error).max() / np.sqrt(3.0)), RESOLUTION, dict(rays=len(error)))


@functools.lru_cache(maxsize=2)
def judged(name: str, quick: bool) -> tuple[oracle.Verdict, int, float]:
    """The oracle's verdict on the rays of a case, their number, and the unresolved fraction of their length."""
    chosen = {**HARD_CASES, **MORE}[name]
    count = QUICK_RAYS if quick else RAYS
    origins, toward = chosen.rays(chosen.shape, np.random.default_rng(zlib.crc32(name.encode())), count)
    traced = Traced(chosen.shape)
    assert chosen.shape.certified and traced.tree.certified, f"{name}: its bounds are not proven"
    found = traced.trace(origins, toward)
    verdict = oracle.judge(
        chosen.shape, origins, toward, found[:, 0].astype(int), found[:, 1], oracle.find(chosen.shape, origins, toward)
    )
    return verdict, count, float(found[:, 2].sum() / max(found[:, 1].sum(), 1e-300))


def register(key: str, name: str, what: str, slow: bool) -> None:
    def crossings(quick):
        verdict, count, unresolved = judged(name, quick)
        return Figure(
            float(verdict.wrong), 0.0, dict(rays=count, too_fine_to_judge=float(verdict.below), unresolved=unresolved)
        )

    def lengths(quick):
        verdict, count, _ = judged(name, quick)
        return Figure(verdict.length_error, RESOLUTION, dict(rays=count))

    crossings.__doc__ = f"rays with a wrong number of intervals: {what}"
    lengths.__doc__ = f"mean error of the length inside, relative to half of the diagonal: {what}"
    case(f"{key}-crossings", slow)(crossings)
    case(f"{key}-lengths", slow)(lengths)


for _key, _name, _what, _slow in (
    ("grazing-torus", "torus, grazing", "almost tangent to a torus", False),
    ("grazing-blend", "smooth combination, grazing", "almost tangent to a smooth combination", False),
    ("thin-shells", "onions 1e-4 thick", "four shells 1e-4 thick", False),
    ("thin-shells-grazing", "onions 1e-4 thick, grazing", "almost tangent to four shells 1e-4 thick", False),
    ("size-1e-3", "smooth combination, size 1e-3", "a smooth combination 1e-3 large", False),
    ("size-1e4", "smooth combination, size 1e4", "a smooth combination 1e4 large", False),
    ("from-far-away", "smooth combination, from far away", "from 10,000 diagonals away", False),
    ("stretched-1-to-10000", "stretched 1 : 10,000", "a smooth combination stretched by 100, 1 and 0.01", False),
    ("sheared-and-mirrored", "smooth combination, sheared and mirrored", "sheared, stretched and mirrored", False),
    ("coincident-faces", "coincident faces", "faces that coincide in unions and differences", False),
    ("coincident-faces-blended", "coincident faces, smooth", "coincident faces in a smooth union", False),
    ("sparse-frame", "sparse frame", "a frame of bars 1 : 150", False),
    ("thin-spokes", "thin spokes", "24 spokes 1 : 100", False),
    ("sponge", "Menger sponge of 5 levels", "Menger's sponge of 5 levels", False),
    ("noise", "noise", "a ball displaced by three octaves of noise", True),
    ("noise-from-inside", "noise, from inside", "the same, from inside", True),
    ("high-frequency-noise", "high-frequency noise", "four octaves of noise from 1/25 of its size on", True),
    ("mandelbulb", "Mandelbulb", "a Mandelbulb", True),
    ("mandelbulb-close-up", "Mandelbulb, close", "a Mandelbulb 1e-4 to 1e-2 of its size away", True),
):
    register(_key, _name, _what, _slow)
