# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All zeros of a signed distance grid along a ray.

The ray walks from block to block, in a block from cell to cell of 2³ voxels, and in a cell from voxel to voxel: the
walk of Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing", on several levels (Museth 2014,
"Hierarchical digital differential analyzer for efficient ray-marching in OpenVDB"). Tiles are passed at once. A mask of
64 bits for each block tells the cells with values of both signs, so the others are passed without a look at their
voxels. In a voxel, the field along the ray is a cubic. Its zeros lie between its extrema, which a quadratic gives, and
Newton's iteration in these brackets finds each to rounding.

Coordinates count voxels. The parameter of the ray is that of the caller. A zero is a change between values above zero
and others, so their number agrees with the signs at both ends.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel

STEPS = 60  # of an iteration in a bracket, at most; it takes three or four
PRECISION = 1e-15  # of a zero, relative to the part of the ray in its voxel


@kernel(forceinline=True)
def _note(places, room, count, t):
    """Write a zero if there is room. Returns the new number."""
    if count < room:
        places[count] = t
    return count + 1


@kernel
def _zero(c0, c1, c2, c3, low, high, at_low, at_high):
    """The zero of a cubic between two points whose values have different signs, where it is monotonic."""
    rising = at_low <= 0.0
    w = low + (high - low) * (at_low / (at_low - at_high))
    for _ in range(STEPS):
        if not low < w < high:
            w = 0.5 * (low + high)
        value = c0 + w * (c1 + w * (c2 + w * c3))
        if (value <= 0.0) == rising:
            low = w
        else:
            high = w
        step = value / (c1 + w * (2.0 * c2 + w * (3.0 * c3)))
        if abs(step) <= PRECISION or high - low <= PRECISION:
            break
        w -= step
    return w


@kernel(forceinline=True)
def _voxel(values, at, x, y, z, ex, ey, ez, start, span, inside, places, room, count):
    """Note the zeros in one voxel, whose corner with the least coordinates is number ``at``.

    The ray enters at (x, y, z) from that corner, at its parameter ``start``, and moves by (ex, ey, ez) in ``span``.
    Returns (whether it ends inside, number of zeros so far).
    """
    a, b = np.float64(values[at]), np.float64(values[at + 1])
    c, d = np.float64(values[at + 9]), np.float64(values[at + 10])
    e, f = np.float64(values[at + 81]), np.float64(values[at + 82])
    g, h = np.float64(values[at + 90]), np.float64(values[at + 91])
    above = min(min(min(a, b), min(c, d)), min(min(e, f), min(g, h))) > 0.0
    if above or max(max(max(a, b), max(c, d)), max(max(e, f), max(g, h))) <= 0.0:
        return not above, (_note(places, room, count, start) if above == inside else count)
    # Along x, then y, then z: polynomials in w, which goes from 0 to 1, of degrees 1, 2 and 3.
    a0, a1 = a + (b - a) * x, (b - a) * ex
    e0, e1 = e + (f - e) * x, (f - e) * ex
    d0, d1 = c + (d - c) * x - a0, (d - c) * ex - a1
    h0, h1 = g + (h - g) * x - e0, (h - g) * ex - e1
    p0, p1, p2 = a0 + d0 * y, a1 + d1 * y + d0 * ey, d1 * ey
    r0, r1, r2 = e0 + h0 * y - p0, e1 + h1 * y + h0 * ey - p1, h1 * ey - p2
    c0, c1, c2, c3 = p0 + r0 * z, p1 + r1 * z + r0 * ez, p2 + r2 * z + r1 * ez, r2 * ez
    if (c0 <= 0.0) != inside:  # rounding: the zero is at the face
        count, inside = _note(places, room, count, start), not inside
    low, at_low = 0.0, c0
    if abs(c1) < 2.0 * abs(c2) + 3.0 * abs(c3):  # else it is monotonic
        square = c2 * c2 - 3.0 * c1 * c3
        if square > 0.0:
            q = -(c2 + math.copysign(math.sqrt(square), c2))
            first, second = q / (3.0 * c3), c1 / q
            for w in (min(first, second), max(first, second)):
                if low < w < 1.0:
                    value = c0 + w * (c1 + w * (c2 + w * c3))
                    if (value <= 0.0) != inside:
                        zero = _zero(c0, c1, c2, c3, low, w, at_low, value)
                        count, inside = _note(places, room, count, start + span * zero), not inside
                    low, at_low = w, value
    value = c0 + c1 + c2 + c3
    if (value <= 0.0) != inside:
        zero = _zero(c0, c1, c2, c3, low, 1.0, at_low, value)
        count, inside = _note(places, room, count, start + span * zero), not inside
    return inside, count


@kernel(forceinline=True)
def _cell(values, at, a, b, c, x, y, z, vx, vy, vz, wx, wy, wz, t, last, inside, places, room, count):
    """Note the zeros between t and ``last``, in a cell of 2³ voxels: (a, b, c) is its first voxel in a block whose
    values begin at ``at``, and (x, y, z) + t (vx, vy, vz) the ray in that block. Returns as ``_voxel``."""
    middle_x, middle_y, middle_z = a + 1.0, b + 1.0, c + 1.0
    # Where the ray crosses the planes in the middle, in order.
    first, second, third = (middle_x - x) * wx, (middle_y - y) * wy, (middle_z - z) * wz
    first, second = min(first, second), max(first, second)
    second, third = min(second, third), max(second, third)
    first, second = min(first, second), max(first, second)
    for end in (first, second, third, last):
        if t < end:
            end = min(end, last)
            middle = 0.5 * (t + end)
            i = a + (1 if x + middle * vx >= middle_x else 0)
            j = b + (1 if y + middle * vy >= middle_y else 0)
            k = c + (1 if z + middle * vz >= middle_z else 0)
            span = end - t
            inside, count = _voxel(
                values,
                at + i + 9 * (j + 9 * k),
                x + t * vx - i,
                y + t * vy - j,
                z + t * vz - k,
                span * vx,
                span * vy,
                span * vz,
                t,
                span,
                inside,
                places,
                room,
                count,
            )
            t = end
    return inside, count


@kernel(forceinline=True)
def _leaves(position, rate, inverse, index, side):
    """Where the ray leaves the interval ``index`` of length ``side`` along an axis."""
    if rate == 0.0:
        return math.inf
    return (side * (index + (1.0 if rate > 0.0 else 0.0)) - position) * inverse


@kernel(forceinline=True)
def _inverse(rate):
    """1 / rate; 0 where the ray crosses no planes, so that their places are numbers."""
    return 1.0 / rate if rate != 0.0 else 0.0


@kernel(forceinline=True)
def _index(position, count):
    """The interval of ``count`` of length 1 that a position is in."""
    return min(max(int(position), 0), count - 1)


@kernel(forceinline=True)
def _block(values, at, low, high, x, y, z, vx, vy, vz, wx, wy, wz, t, last, inside, places, room, count):
    """Note the zeros between t and ``last`` in a block. ``low`` and ``high`` are the halves of its mask, else as
    ``_cell``. Returns (whether the ray ends inside, number of zeros so far, number of cells that it looked into)."""
    a, b, c = _index(0.5 * (x + t * vx), 4), _index(0.5 * (y + t * vy), 4), _index(0.5 * (z + t * vz), 4)
    tx, ty, tz = _leaves(x, vx, wx, a, 2.0), _leaves(y, vy, wy, b, 2.0), _leaves(z, vz, wz, c, 2.0)
    looked = 0
    while t < last:
        end = min(min(tx, ty), min(tz, last))
        bit = a + 4 * (b + 4 * c)
        if t < end and (low if bit < 32 else high) >> (bit & 31) & 1:
            looked += 1
            inside, count = _cell(
                *(values, at, 2 * a, 2 * b, 2 * c, x, y, z, vx, vy, vz, wx, wy, wz, t, end),
                *(inside, places, room, count),
            )
        t = max(t, end)
        if tx <= ty and tx <= tz:
            a += 1 if vx > 0.0 else -1
            tx += 2.0 * abs(wx)
            if a < 0 or a > 3:
                break
        elif ty <= tz:
            b += 1 if vy > 0.0 else -1
            ty += 2.0 * abs(wy)
            if b < 0 or b > 3:
                break
        else:
            c += 1 if vz > 0.0 else -1
            tz += 2.0 * abs(wz)
            if c < 0 or c > 3:
                break
    return inside, count, looked


@kernel
def zeros_between(numbers, values, x, y, z, vx, vy, vz, t, last, inside, places, room):
    """Write the zeros between two points of the ray (x, y, z) + t (vx, vy, vz) in the grid's box to ``places``, in
    order, at most ``room``; before them t, if the ray is ``inside`` there.

    Returns (number of all of them, number of cells that the ray looked into).
    """
    counts_x, counts_y, counts_z = int(numbers[4]), int(numbers[5]), int(numbers[6])
    blocks, masks = int(numbers[8]), int(numbers[9])
    count = _note(places, room, 0, t) if inside else 0
    wx, wy, wz = _inverse(vx), _inverse(vy), _inverse(vz)
    i = _index(0.125 * (x + t * vx), counts_x)
    j = _index(0.125 * (y + t * vy), counts_y)
    k = _index(0.125 * (z + t * vz), counts_z)
    tx, ty, tz = _leaves(x, vx, wx, i, 8.0), _leaves(y, vy, wy, j, 8.0), _leaves(z, vz, wz, k, 8.0)
    looked = 0
    while t < last:
        end = min(min(tx, ty), min(tz, last))
        place = numbers[blocks + i + counts_x * (j + counts_y * k)]
        if place < 0.0:
            if inside != (place == -2.0):
                count, inside = _note(places, room, count, t), not inside
        elif t < end:
            mask = masks + 2 * int(place * (1.0 / 729.0) + 0.5)
            low, high = int(numbers[mask]), int(numbers[mask + 1])
            if low | high:
                inside, count, more = _block(
                    *(values, int(place), low, high, x - 8.0 * i, y - 8.0 * j, z - 8.0 * k, vx, vy, vz, wx, wy, wz),
                    *(t, end, inside, places, room, count),
                )
                looked += more
        t = max(t, end)
        if tx <= ty and tx <= tz:
            i += 1 if vx > 0.0 else -1
            tx += 8.0 * abs(wx)
            if i < 0 or i >= counts_x:
                break
        elif ty <= tz:
            j += 1 if vy > 0.0 else -1
            ty += 8.0 * abs(wy)
            if j < 0 or j >= counts_y:
                break
        else:
            k += 1 if vz > 0.0 else -1
            tz += 8.0 * abs(wz)
            if k < 0 or k >= counts_z:
                break
    return count, looked
