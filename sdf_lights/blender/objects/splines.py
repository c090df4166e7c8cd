# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points along Blender's splines, at their own resolution: poly, Bézier and NURBS.

Blender gives a curve's evaluated points only as a mesh, with its bevel and filling, so they are found here as it does
(``source/blender/blenkernel/intern/curve_nurbs.cc``, ``curve_bezier.cc``).
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np


class Path(NamedTuple):
    """``points`` (n, 3) of a spline, ``radii`` (n,) as factors, and whether the last leads to the first."""

    points: np.ndarray
    radii: np.ndarray
    closed: bool


def path_of(spline: bpy.types.Spline) -> Path:
    """The points along a spline."""
    closed = spline.use_cyclic_u
    if spline.type == "BEZIER":
        return _bezier(spline, closed)
    rows = _numbers(spline.points, "co", 4)
    radii = _numbers(spline.points, "radius", 1)[:, 0]
    order = spline.order_u
    whole = not (closed and spline.use_bezier_u) or len(rows) % max(order - 1, 1) == 0
    if spline.type == "NURBS" and len(rows) >= order and whole:  # else Blender joins the points by straight lines
        return _nurbs(rows, radii, order, closed, spline.use_endpoint_u, spline.use_bezier_u, spline.resolution_u)
    return Path(rows[:, :3], radii, closed and len(rows) > 2)


def _numbers(points, name: str, size: int) -> np.ndarray:
    values = np.empty(len(points) * size, np.float32)
    points.foreach_get(name, values)
    return values.reshape(-1, size).astype(np.float64)


def _bezier(spline: bpy.types.Spline, closed: bool) -> Path:
    points = spline.bezier_points
    co, left, right = (_numbers(points, name, 3) for name in ("co", "handle_left", "handle_right"))
    radii = _numbers(points, "radius", 1)[:, 0]
    straight = np.array([(point.handle_left_type == "VECTOR", point.handle_right_type == "VECTOR") for point in points])
    count = len(co) if closed else len(co) - 1
    t = np.arange(max(spline.resolution_u, 1)) / max(spline.resolution_u, 1)
    basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], axis=1)
    found, sizes = [], []
    for index in range(count):
        after = (index + 1) % len(co)
        if straight[index, 1] and straight[after, 0]:
            found.append(co[index : index + 1])
            sizes.append(radii[index : index + 1])
        else:
            found.append(basis @ np.stack([co[index], right[index], left[after], co[after]]))
            sizes.append(radii[index] + t * (radii[after] - radii[index]))
    if not closed or not count:
        found.append(co[-1:])
        sizes.append(radii[-1:])
    return Path(np.concatenate(found), np.concatenate(sizes), closed)


def _knots(points: int, order: int, closed: bool, end: bool, bezier: bool) -> np.ndarray:
    inner = order - 1 if bezier else 1
    head = order - (1 if closed else 0) if end else min(2, inner) if bezier else 1
    total = points + order + (order - 1 if closed else 0)
    knots, current, left = [], 0.0, head
    if end and closed:
        knots.append(current)
        current += 1.0
    # A closed curve with end points comes to its first point again, whatever follows.
    while len(knots) < (total - 2 * (order - 1) if end and closed else total):
        knots.append(current)
        left -= 1
        if left == 0:
            current, left = current + 1.0, inner
    if end and closed:
        knots += [current] * (order - 1) + [current + 1.0] * (order - 1)
    found = np.array(knots)
    if end and not closed:
        found[-order:] = found[-order]
    return found


def _nurbs(rows, radii, order: int, closed: bool, end: bool, bezier: bool, resolution: int) -> Path:
    knots = _knots(len(rows), order, closed, end, bezier)
    values = np.column_stack([rows[:, :3] * rows[:, 3:], rows[:, 3], radii * rows[:, 3]])
    if closed:
        values = np.concatenate([values, values[: order - 1]])
    first, last = knots[order - 1], knots[len(values)]
    spans = np.unique(np.clip(knots, first, last))
    steps = np.arange(max(resolution, 1)) / max(resolution, 1)
    t = (spans[:-1, None] + steps * np.diff(spans)[:, None]).ravel()
    if not closed:
        t = np.append(t, last)
    # Cox and de Boor, each degree from the one below.
    basis = ((knots[:-1] <= t[:, None]) & (t[:, None] < knots[1:])).astype(np.float64)
    at_end = t >= last
    basis[at_end] = 0.0
    basis[at_end, np.searchsorted(knots, last) - 1] = 1.0
    for degree in range(1, order):
        count = len(knots) - 1 - degree
        left, right = knots[degree : degree + count] - knots[:count], knots[degree + 1 :] - knots[1 : count + 1]
        with np.errstate(all="ignore"):
            rising = np.where(left > 0.0, (t[:, None] - knots[:count]) / left, 0.0)
            falling = np.where(right > 0.0, (knots[degree + 1 :] - t[:, None]) / right, 0.0)
        basis = rising * basis[:, :count] + falling * basis[:, 1 : count + 1]
    found = basis[:, : len(values)] @ values
    weights = found[:, 3:4]
    with np.errstate(all="ignore"):  # of weights 0: lamps refuse what is not a number
        return Path(found[:, :3] / weights, found[:, 4] / weights[:, 0], closed)
