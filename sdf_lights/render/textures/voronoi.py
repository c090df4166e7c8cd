# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Voronoi Texture: Worley 1996, "A cellular texture basis function"; edges and smooth minima after Quilez.

    distance(feature, dimensions, hashing)(metric, normalize, x, y, z, w, …) -> distance
    cell(feature, dimensions, hashing)(…the same…) -> (distance, r, g, b, x, y, z, w) of the point that it belongs to
    edge(dimensions, hashing)(normalize, x, y, z, w, detail, roughness, lacunarity, randomness) -> distance
    radius(dimensions, hashing)(x, y, z, w, randomness) -> half the distance between neighbouring points

where … is ``detail, roughness, lacunarity, smoothness, exponent, randomness``; coordinates beyond the dimensions are
not read. ``feature`` is one of ``FEATURES``. ``hashing``: ``FLOATS`` in Blender before 5.0, ``WHOLE`` since.

A cell is four integers, its point a number from 0 to 1 on each axis. Cells are visited in the order of Cycles, because
smooth minima depend on it.
"""

import functools
import math

from ...jit import kernel, specialised
from .hashing import bits, cell_2, cell_3, cell_4, color_1, color_2, color_3, color_4, point_1, point_2, point_4

F1, F2, SMOOTH = range(3)
FEATURES = {"F1": F1, "F2": F2, "SMOOTH_F1": SMOOTH}
EUCLIDEAN, MANHATTAN, CHEBYCHEV, MINKOWSKI = range(4)
METRICS = {"EUCLIDEAN": EUCLIDEAN, "MANHATTAN": MANHATTAN, "CHEBYCHEV": CHEBYCHEV, "MINKOWSKI": MINKOWSKI}
WHOLE, FLOATS = range(2)

MOST_DETAIL = 15.0

# Constants of a copy of the kernels: see the end of the file. REACH_…: number of cells to visit on both sides.
DIMENSIONS, HASHING, FEATURE, COLORED = 3, WHOLE, F1, 1
REACH_Y, REACH_Z, REACH_W = 1, 1, 0


@kernel(forceinline=True)
def _point(i, j, k, l):
    """The point of a cell, relative to the cell's corner."""
    if DIMENSIONS == 1:
        return point_1(bits(i)), 0.0, 0.0, 0.0
    if DIMENSIONS == 2:
        x, y = point_2(bits(i), bits(j)) if HASHING == FLOATS else cell_2(i, j)
        return x, y, 0.0, 0.0
    if DIMENSIONS == 3:
        x, y, z = color_3(bits(i), bits(j), bits(k)) if HASHING == FLOATS else cell_3(i, j, k)
        return x, y, z, 0.0
    return point_4(bits(i), bits(j), bits(k), bits(l)) if HASHING == FLOATS else cell_4(i, j, k, l)


@kernel(forceinline=True)
def _color(i, j, k, l):
    """The colour of a cell."""
    if DIMENSIONS == 1:
        return color_1(bits(i))
    if DIMENSIONS == 2:
        return color_2(bits(i), bits(j)) if HASHING == FLOATS else cell_3(i, j, 0)
    if DIMENSIONS == 3:
        return color_3(bits(i), bits(j), bits(k)) if HASHING == FLOATS else cell_3(i, j, k)
    if HASHING == FLOATS:
        return color_4(bits(i), bits(j), bits(k), bits(l))
    r, g, b, _ = cell_4(i, j, k, l)
    return r, g, b


@kernel(forceinline=True)
def _place(cell, step, randomness):
    """The point of the cell that is ``step`` cells from ``cell``, relative to the corner of ``cell``."""
    x, y, z, w = _point(cell[0] + step[0], cell[1] + step[1], cell[2] + step[2], cell[3] + step[3])
    x = step[0] + x * randomness
    if DIMENSIONS > 1:
        y = step[1] + y * randomness
    if DIMENSIONS > 2:
        z = step[2] + z * randomness
    if DIMENSIONS > 3:
        w = step[3] + w * randomness
    return x, y, z, w


@kernel(forceinline=True)
def _between(p, q):
    return p[0] - q[0], p[1] - q[1], p[2] - q[2], p[3] - q[3]


@kernel(forceinline=True)
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]


@kernel(forceinline=True)
def _size(metric, exponent, p):
    """A value that grows with the length of a vector and is cheaper."""
    if metric == EUCLIDEAN:
        return _dot(p, p)
    x, y, z, w = abs(p[0]), abs(p[1]), abs(p[2]), abs(p[3])
    if metric == MANHATTAN:
        return x + y + z + w
    if metric == CHEBYCHEV:
        return max(max(x, y), max(z, w))
    total = x**exponent
    if DIMENSIONS > 1:
        total += y**exponent
    if DIMENSIONS > 2:
        total += z**exponent
    if DIMENSIONS > 3:
        total += w**exponent
    return total


@kernel(forceinline=True)
def _length(metric, exponent, size):
    if metric == EUCLIDEAN:
        return math.sqrt(size)
    if metric == MINKOWSKI:
        return size ** (1.0 / exponent) if exponent != 0.0 else math.inf
    return size


@kernel(forceinline=True)
def _cell_of(x, y, z, w):
    """The cell of a point, and the point relative to the cell's corner."""
    i = int(math.floor(x))
    x -= i
    j, k, l = 0, 0, 0
    if DIMENSIONS > 1:
        j = int(math.floor(y))
        y -= j
    if DIMENSIONS > 2:
        k = int(math.floor(z))
        z -= k
    if DIMENSIONS > 3:
        l = int(math.floor(w))
        w -= l
    return (i, j, k, l), (x, y if DIMENSIONS > 1 else 0.0, z if DIMENSIONS > 2 else 0.0, w if DIMENSIONS > 3 else 0.0)


@kernel(forceinline=True)
def _given(cell, step, randomness, distance):
    """Distance, colour and position of the point of the cell that is ``step`` cells from ``cell``."""
    if COLORED:
        r, g, b = _color(cell[0] + step[0], cell[1] + step[1], cell[2] + step[2], cell[3] + step[3])
        x, y, z, w = _place(cell, step, randomness)
        return distance, r, g, b, cell[0] + x, cell[1] + y, cell[2] + z, cell[3] + w
    return distance, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@kernel(forceinline=True)
def _nearest(metric, cell, p, exponent, randomness):
    """Offset in cells to the cell of the nearest point, and its distance as ``_size``."""
    least, nearest = math.inf, (0, 0, 0, 0)
    for l in range(-REACH_W, REACH_W + 1):
        for k in range(-REACH_Z, REACH_Z + 1):
            for j in range(-REACH_Y, REACH_Y + 1):
                for i in range(-1, 2):
                    size = _size(metric, exponent, _between(_place(cell, (i, j, k, l), randomness), p))
                    if size < least:
                        least, nearest = size, (i, j, k, l)
    return nearest, least


@kernel
def _f1(metric, cell, p, smoothness, exponent, randomness):
    nearest, least = _nearest(metric, cell, p, exponent, randomness)
    return _given(cell, nearest, randomness, _length(metric, exponent, least))


@kernel
def _f2(metric, cell, p, smoothness, exponent, randomness):
    least, nearest = math.inf, (0, 0, 0, 0)
    second, other = math.inf, (0, 0, 0, 0)
    for l in range(-REACH_W, REACH_W + 1):
        for k in range(-REACH_Z, REACH_Z + 1):
            for j in range(-REACH_Y, REACH_Y + 1):
                for i in range(-1, 2):
                    size = _size(metric, exponent, _between(_place(cell, (i, j, k, l), randomness), p))
                    if size < least:
                        second, other = least, nearest
                        least, nearest = size, (i, j, k, l)
                    elif size < second:
                        second, other = size, (i, j, k, l)
    return _given(cell, other, randomness, _length(metric, exponent, second))


@kernel
def _smooth(metric, cell, p, smoothness, exponent, randomness):
    """Distances that differ by less than ``smoothness`` have a smooth minimum; so have colours and positions."""
    reach = 2 if smoothness > 0.0 else 1
    reach_y, reach_z, reach_w = reach * REACH_Y, reach * REACH_Z, reach * REACH_W
    least, r, g, b, x, y, z, w = math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for l in range(-reach_w, reach_w + 1):
        for k in range(-reach_z, reach_z + 1):
            for j in range(-reach_y, reach_y + 1):
                for i in range(-reach, reach + 1):
                    place = _place(cell, (i, j, k, l), randomness)
                    size = _size(metric, exponent, _between(place, p))
                    limit = max(0.0, least + smoothness)
                    if metric == EUCLIDEAN and size >= limit * limit:
                        continue
                    distance = _length(metric, exponent, size)
                    if distance >= least + smoothness:
                        continue
                    share, less = 1.0, 0.0
                    if least - distance < smoothness:
                        share = 0.5 + 0.5 * (least - distance) / smoothness
                        share *= share * (3.0 - 2.0 * share)
                        less = smoothness * share * (1.0 - share)
                        least += share * (distance - least) - less
                        less /= 1.0 + 3.0 * smoothness
                    else:
                        least = distance
                    if COLORED:
                        cell_r, cell_g, cell_b = _color(cell[0] + i, cell[1] + j, cell[2] + k, cell[3] + l)
                        r += share * (cell_r - r) - less
                        g += share * (cell_g - g) - less
                        b += share * (cell_b - b) - less
                        x += share * (place[0] - x) - less
                        if DIMENSIONS > 1:
                            y += share * (place[1] - y) - less
                        if DIMENSIONS > 2:
                            z += share * (place[2] - z) - less
                        if DIMENSIONS > 3:
                            w += share * (place[3] - w) - less
    return least, r, g, b, cell[0] + x, cell[1] + y, cell[2] + z, cell[3] + w


@kernel
def _octaves(detail, roughness):
    """Number of octaves, and the weight of the last one: the fractional part of ``detail``."""
    detail = min(max(0.0, detail), MOST_DETAIL)
    whole = int(detail)
    if roughness == 0.0:
        return 1, 1.0
    if detail > whole:
        return whole + 2, detail - whole
    return whole + 1, 1.0


@kernel
def _cell(metric, normalize, x, y, z, w, detail, roughness, lacunarity, smoothness, exponent, randomness):
    roughness, randomness = min(max(0.0, roughness), 1.0), min(max(0.0, randomness), 1.0)
    smoothness = 0.5 * min(max(0.0, smoothness), 1.0)
    octaves, rest = _octaves(detail, roughness)
    scale, amplitude, most = 1.0, 1.0, 0.0
    distance, r, g, b, px, py, pz, pw = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for octave in range(octaves):
        cell, p = _cell_of(x * scale, y * scale, z * scale, w * scale)
        if FEATURE == F1:
            found = _f1(metric, cell, p, smoothness, exponent, randomness)
        elif FEATURE == F2:
            found = _f2(metric, cell, p, smoothness, exponent, randomness)
        else:
            found = _smooth(metric, cell, p, smoothness, exponent, randomness)
        share = amplitude if octave < octaves - 1 else amplitude * rest
        distance += share * found[0]
        most += share
        if COLORED:
            r += share * found[1]
            g += share * found[2]
            b += share * found[3]
            inverse = 1.0 / scale if scale != 0.0 else 0.0
            px += share * (found[4] * inverse - px)
            py += share * (found[5] * inverse - py)
            pz += share * (found[6] * inverse - pz)
            pw += share * (found[7] * inverse - pw)
        scale *= lacunarity
        amplitude *= roughness
    if normalize:
        corner = 0.5 + 0.5 * randomness
        far = _length(
            metric,
            exponent,
            _size(
                metric,
                exponent,
                (
                    corner,
                    corner if DIMENSIONS > 1 else 0.0,
                    corner if DIMENSIONS > 2 else 0.0,
                    corner if DIMENSIONS > 3 else 0.0,
                ),
            ),
        )
        distance /= most * (2.0 * far if FEATURE == F2 else far)
        r, g, b = r / most, g / most, b / most
    return distance, r, g, b, px, py, pz, pw


@kernel
def _distance(metric, normalize, x, y, z, w, detail, roughness, lacunarity, smoothness, exponent, randomness):
    found = _cell(metric, normalize, x, y, z, w, detail, roughness, lacunarity, smoothness, exponent, randomness)
    return found[0]


@kernel
def _edge_of_octave(cell, p, randomness):
    if DIMENSIONS == 1:
        left, own, right = (
            _place(cell, (-1, 0, 0, 0), randomness),
            _place(cell, (0, 0, 0, 0), randomness),
            _place(cell, (1, 0, 0, 0), randomness),
        )
        return min(abs(0.5 * (own[0] + left[0]) - p[0]), abs(0.5 * (own[0] + right[0]) - p[0]))
    nearest, _ = _nearest(EUCLIDEAN, cell, p, 1.0, randomness)
    to_nearest = _between(_place(cell, nearest, randomness), p)
    least = math.inf
    for l in range(-REACH_W, REACH_W + 1):
        for k in range(-REACH_Z, REACH_Z + 1):
            for j in range(-REACH_Y, REACH_Y + 1):
                for i in range(-1, 2):
                    to_point = _between(_place(cell, (i, j, k, l), randomness), p)
                    across = _between(to_point, to_nearest)
                    square = _dot(across, across)
                    if square > 0.0001:
                        # Twice the distance to the plane between both points, times the length of ``across``.
                        twice = _dot(to_point, to_point) - _dot(to_nearest, to_nearest)
                        if twice * twice < least * square:
                            least = twice * twice / square
    return 0.5 * math.sqrt(least)


@kernel
def _edge(normalize, x, y, z, w, detail, roughness, lacunarity, randomness):
    roughness, randomness = min(max(0.0, roughness), 1.0), min(max(0.0, randomness), 1.0)
    octaves, rest = _octaves(detail, roughness)
    far = 0.5 + 0.5 * randomness
    scale, amplitude, most, distance = 1.0, 1.0, far, 8.0
    for octave in range(octaves):
        cell, p = _cell_of(x * scale, y * scale, z * scale, w * scale)
        inverse = 1.0 / scale if scale != 0.0 else 0.0
        found = _edge_of_octave(cell, p, randomness) * inverse
        share = amplitude if octave < octaves - 1 else amplitude * rest
        most += share * (far * inverse - most)
        distance += share * (min(distance, found) - distance)
        scale *= lacunarity
        amplitude *= roughness
    return distance / most if normalize else distance


@kernel
def _radius(x, y, z, w, randomness):
    randomness = min(max(0.0, randomness), 1.0)
    cell, p = _cell_of(x, y, z, w)
    (a, b, c, d), _ = _nearest(EUCLIDEAN, cell, p, 1.0, randomness)
    center = _place(cell, (a, b, c, d), randomness)
    least = math.inf
    for l in range(-REACH_W, REACH_W + 1):
        for k in range(-REACH_Z, REACH_Z + 1):
            for j in range(-REACH_Y, REACH_Y + 1):
                for i in range(-1, 2):
                    if i != 0 or j != 0 or k != 0 or l != 0:
                        across = _between(_place(cell, (a + i, b + j, c + k, d + l), randomness), center)
                        least = min(least, _dot(across, across))
    return 0.5 * math.sqrt(least)


def _copied(kernels, given: dict, suffix: str) -> dict:
    """``given``, and copies of kernels that use it and each other, by name: callees come first."""
    found = dict(given)
    for part in kernels:
        found[part.__name__] = specialised(part, f"voronoi{part.__name__}_{suffix}", **found)
    return found


def _name(dimensions: int, hashing: int) -> str:
    return f"{dimensions}d_floats" if hashing == FLOATS else f"{dimensions}d"


@functools.cache
def _in_space(dimensions: int, hashing: int) -> dict:
    reaches = {name: int(dimensions > axis) for axis, name in enumerate(("REACH_Y", "REACH_Z", "REACH_W"), 1)}
    kernels = (_point, _color, _place, _size, _cell_of, _nearest, _edge_of_octave, _edge, _radius)
    return _copied(kernels, {"DIMENSIONS": dimensions, "HASHING": hashing, **reaches}, _name(dimensions, hashing))


@functools.cache
def _of_feature(feature: int, colored: int, dimensions: int, hashing: int) -> dict:
    given = {**_in_space(dimensions, hashing), "FEATURE": feature, "COLORED": colored}
    suffix = f"{('f1', 'f2', 'smooth')[feature]}_{'cell' if colored else 'distance'}_{_name(dimensions, hashing)}"
    return _copied((_given, _f1, _f2, _smooth, _cell, _distance), given, suffix)


def distance(feature: int, dimensions: int, hashing: int):
    """Kernel of the distance of a feature."""
    return _of_feature(feature, 0, dimensions, hashing)["_distance"]


def cell(feature: int, dimensions: int, hashing: int):
    """Kernel of the colour and the position of a feature."""
    return _of_feature(feature, 1, dimensions, hashing)["_cell"]


def edge(dimensions: int, hashing: int):
    """Kernel of the distance to the edge of the cell."""
    return _in_space(dimensions, hashing)["_edge"]


def radius(dimensions: int, hashing: int):
    """Kernel of the radius of spheres that touch."""
    return _in_space(dimensions, hashing)["_radius"]
