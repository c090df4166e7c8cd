# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A Menger sponge in a cube centred at the origin: half size, levels (a whole number).

The sponge of n levels is a cube without the points that have, at one of the levels 1 … n, two coordinates in a *middle
third*. For coordinates from 0 to 1, a coordinate is in the middle third of level k if its k-th digit in base 3 is 1.

A ray passes the parts of a cell in the order of its crossings with the planes between them. Parts with two coordinates
in the middle third are empty; the others are divided further. A random ray meets about (20/9)ᵏ solid cells of level k.
So the cost grows with the number of intervals, and not as 3ᵏ. Cells of the second to last level are not walked through:
the crossings of their middle thirds show directly where they are empty.

Planes are numbered, from 0 to 3ⁿ across the cube, and a plane's crossing is always the same function of its number. So
neighbouring cells abut to the last bit, and every uncertainty stays within rounding.
"""

import math

import numpy as np

from ...jit import kernel, stack_array

_ROW = 10  # float64 of a cell whose parts are not all visited yet
_WAITING = 12 * _ROW  # maximum number of such cells: the number of levels
_STILL = 1e-30  # rate of a coordinate, relative to the fastest, below which it counts as constant in the cube
_NEVER = 1e300  # parameter beyond the end of every ray
_ROUNDING = 1e-12  # tolerance for corners of boxes, relative to the cube's size


def most_spans(size) -> int:
    """Bound of the number of intervals of a ray.

    A gap between two of them begins at a plane where a coordinate enters a middle third. At level k each coordinate has
    3ᵏ⁻¹ such planes, and a ray crosses a plane once.
    """
    return 1 + 3 * (3 ** int(size[1]) - 1) // 2


@kernel
def _planes(o, d, still, half_size, count):
    """Crossings of the planes across one coordinate, oriented so that the ray passes them upwards: plane j at first +
    j·rate.

    Returns (first, rate); rate is negative if the ray misses the cube.
    """
    if abs(d) <= still:
        if abs(o) > half_size:
            return 0.0, -1.0
        # Treated as moving so slowly that it never comes near a plane: from the middle between two of them.
        cell = min(math.floor((o / half_size + 1.0) * (0.5 * count)), count - 1.0)
        return -(cell + 0.5) * _NEVER, _NEVER
    if d < 0.0:  # the sponge is symmetric
        o, d = -o, -d
    return (-half_size - o) / d, 2.0 * half_size / (count * d)


@kernel(forceinline=True)
def _third(first, rate, plane, width, t):
    """Third of a cell that contains the ray at t, along one coordinate, and where the ray leaves that third within the
    cell.

    ``plane`` is the lower plane of the cell, and ``width`` the number of planes per third.
    """
    lower, upper = first + (plane + width) * rate, first + (plane + 2.0 * width) * rate
    third = (1.0 if t >= lower else 0.0) + (1.0 if t >= upper else 0.0)
    return third, lower if t < lower else upper if t < upper else math.inf


@kernel(forceinline=True)
def _next(third, leave, first, rate, plane, width, t):
    """As ``_third``, for a ray that was in ``third`` until now, and leaves it at ``leave``."""
    upper = first + (plane + 2.0 * width) * rate
    after = upper if third == 0.0 else math.inf
    return third + (1.0 if leave <= t else 0.0), after if leave <= t else leave


@kernel(forceinline=True)
def _sorted(a, b, c):
    low, high = min(a, b), max(a, b)
    return min(low, c), max(low, min(high, c)), max(high, c)


@kernel(forceinline=True)
def _cut(spans, place, start, low, high):
    """Cut the gap from ``low`` to ``high``, if there is one, out of the interval that begins at ``start``.

    The part before the gap is written to row ``place``. Returns the row and the start of the part after it.
    """
    spans[place, 0], spans[place, 1] = start, low
    place += 1 if low > start and high > low else 0
    return place, max(start, high) if high > low else start


@kernel(forceinline=True)
def _cut_cell(spans, place, start, x0, dx, y0, dy, z0, dz, i, j, k, t, stop):
    """Cut the gaps of the last two levels of a cell out of the interval that begins at ``start``; as ``_cut``.

    The cell has the lower planes i, j and k, and the ray is in it from t to ``stop``.
    """
    a, u = _third(x0, dx, i, 3.0, t)
    b, v = _third(y0, dy, j, 3.0, t)
    c, w = _third(z0, dz, k, 3.0, t)
    while t < stop:
        leave = min(u, v, w, stop)
        # Two coordinates are in a middle third from the second entry to the first exit, and from the third to the
        # second.
        x, y, z = i + 3.0 * a + 1.0, j + 3.0 * b + 1.0, k + 3.0 * c + 1.0
        _, second_entry, third_entry = _sorted(x0 + x * dx, y0 + y * dy, z0 + z * dz)
        first_exit, second_exit, _ = _sorted(x0 + (x + 1.0) * dx, y0 + (y + 1.0) * dy, z0 + (z + 1.0) * dz)
        empty = (a == 1.0) + (b == 1.0) + (c == 1.0) >= 2
        place, start = _cut(
            spans, place, start, t if empty else max(second_entry, t), leave if empty else min(first_exit, leave)
        )
        place, start = _cut(spans, place, start, max(third_entry, t), min(second_exit, leave))
        t = max(t, leave)
        a, u = _next(a, u, x0, dx, i, 3.0, t)
        b, v = _next(b, v, y0, dy, j, 3.0, t)
        c, w = _next(c, w, z0, dz, k, 3.0, t)
    return place, start


@kernel
def sponge_spans(o, d, half_size, levels, spans, first):
    """Write the intervals (start, end) inside a sponge of 2·``half_size`` around the origin to rows from ``first``.

    Returns their number, at most ``most_spans(levels)``; one row more is scratch. The ray o + s·d is in the sponge's
    local space; d may have any length but zero.
    """
    count = 3.0**levels
    still = _STILL * max(abs(d[0]), abs(d[1]), abs(d[2]))
    x0, dx = _planes(o[0], d[0], still, half_size, count)
    y0, dy = _planes(o[1], d[1], still, half_size, count)
    z0, dz = _planes(o[2], d[2], still, half_size, count)
    start, end = max(x0, y0, z0), min(x0 + count * dx, y0 + count * dy, z0 + count * dz)
    if min(dx, dy, dz) <= 0.0 or start >= end:
        return 0
    if levels == 0:
        spans[first, 0], spans[first, 1] = start, end
        return 1
    # The ray is in the third (a, b, c) of a cell with the lower planes i, j and k. It leaves the thirds at u, v and w,
    # and the cell at ``stop``. A sponge of one level counts as a third of a larger cell: its first.
    waiting = stack_array(_WAITING)
    place, row, t, stop, width, entered = first, 0, start, end, max(count / 3.0, 3.0), True
    i, j, k = 0.0, 0.0, 0.0
    a, b, c = 0.0, 0.0, 0.0
    u, v, w = 0.0, 0.0, 0.0
    while True:
        if not entered:
            a, u = _next(a, u, x0, dx, i, width, t)
            b, v = _next(b, v, y0, dy, j, width, t)
            c, w = _next(c, w, z0, dz, k, width, t)
        elif width > 3.0:
            a, u = _third(x0, dx, i, width, t)
            b, v = _third(y0, dy, j, width, t)
            c, w = _third(z0, dz, k, width, t)
        else:
            place, start = _cut_cell(spans, place, start, x0, dx, y0, dy, z0, dz, i, j, k, t, stop)
            t = stop
        if t >= stop:
            if row == 0:
                break
            row -= _ROW
            i, j, k = waiting[row], waiting[row + 1], waiting[row + 2]
            a, b, c = waiting[row + 3], waiting[row + 4], waiting[row + 5]
            u, v, w, stop = waiting[row + 6], waiting[row + 7], waiting[row + 8], waiting[row + 9]
            width, entered = 3.0 * width, False
            continue
        leave = min(u, v, w, stop)
        entered = leave > t and (a == 1.0) + (b == 1.0) + (c == 1.0) < 2
        if entered:
            waiting[row], waiting[row + 1], waiting[row + 2] = i, j, k
            waiting[row + 3], waiting[row + 4], waiting[row + 5] = a, b, c
            waiting[row + 6], waiting[row + 7], waiting[row + 8], waiting[row + 9] = u, v, w, stop
            row += _ROW
            i, j, k, stop = i + a * width, j + b * width, k + c * width, leave
            width /= 3.0
        else:
            place, start = _cut(spans, place, start, t, leave)
            t = max(t, leave)
    if end > start:
        spans[place, 0], spans[place, 1] = start, end
        place += 1
    return place - first


@kernel
def classify_sponge(c, h, half_size, levels):
    """Flags (inside, outside) of a sponge for the box with centre c and half sizes h, as in the package.

    The box is inside if at no level two of its sides reach into a middle third. It is outside if at some level two of
    them lie in one. Only a box that is empty by two levels together stays undecided without need.
    """
    scale = 0.5 / half_size
    low = (0.5 + (c[0] - h[0]) * scale, 0.5 + (c[1] - h[1]) * scale, 0.5 + (c[2] - h[2]) * scale)
    high = (0.5 + (c[0] + h[0]) * scale, 0.5 + (c[1] + h[1]) * scale, 0.5 + (c[2] + h[2]) * scale)
    if max(low[0], low[1], low[2]) >= 1.0 - _ROUNDING or min(high[0], high[1], high[2]) <= _ROUNDING:
        return 0, 1
    inside = min(low[0], low[1], low[2]) >= -_ROUNDING and max(high[0], high[1], high[2]) <= 1.0 + _ROUNDING
    cells, slack = 1.0, _ROUNDING
    for _ in range(levels):
        reaching, within = 0, 0
        for axis in range(3):
            start, end = low[axis] * cells + slack, high[axis] * cells - slack
            third = math.floor(start + 1.0 / 3.0) + 1.0 / 3.0  # the first middle third that does not end before the box
            if end > third:
                reaching += 1
                if start >= third and end <= third + 1.0 / 3.0:
                    within += 1
        if within >= 2:
            return 0, 1
        inside = inside and reaching < 2
        cells, slack = 3.0 * cells, 3.0 * slack
    return (1 if inside else 0), 0


@kernel
def sponge_plane(c, h, longest, half_size, levels):
    """Coordinate of a plane between cells that splits the side of a box with centre c and half size h; infinite: none.

    It is the one closest to the middle, among the largest cells. A box whose greatest half size is ``longest`` is split
    by planes of one level in all directions before those of the next.
    """
    count = 1.0
    for _ in range(levels + 1):
        number = min(max(math.floor((c / half_size + 1.0) * (0.5 * count) + 0.5), 0.0), count)
        position = (2.0 * number / count - 1.0) * half_size
        if abs(position - c) < h - _ROUNDING * half_size:
            return position
        count *= 3.0
        if 3.0 * half_size < (longest - _ROUNDING * half_size) * count:
            break
    return math.inf


@kernel
def write_spans(size, o, d, spans, first):
    """See the package."""
    return sponge_spans(o, d, size[0], int(size[1]), spans, first)


@kernel
def classify(size, c, h):
    """See the package."""
    return classify_sponge(c, h, size[0], int(size[1]))


@kernel
def face(size, axis, c, h):
    """See the package."""
    return sponge_plane(c[axis], h[axis], max(h[0], h[1], h[2]), size[0], int(size[1]))


def half_size(size) -> np.ndarray:
    """See the package."""
    return np.full(3, size[0])
