# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance grids: a narrow band of voxels in blocks of 8³, tiles elsewhere, and a coarse grid of the blocks'
corners.

The field is φ = f + sgn(c) max(|c| − m, 0). The fine part f is trilinear in the voxels of blocks and is ± the width of
the band in tiles. The coarse part c is trilinear in the blocks. Wherever f varies, |c| ≤ m: so at every point one part
varies alone. Each component of a trilinear gradient does not depend on its own coordinate and is linear in each other,
so its square norm is convex in every coordinate: it is greatest at the corners of a voxel. That gives the exact
Lipschitz constant L. Outside of the grid's box, at the distance d from the nearest point of it, the field is √(φ² +
d²), which is no steeper.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, call
from ...graph.functions import Function, TableFunction
from ...graph.tables import Table, table
from ...jit import doubles_at, floats_at, kernel
from ..shapes.base import LARGEST, NONE, Shape, Slots, Term
from .grid_rays import zeros_between

SIDE = 8  # voxels of a block
CORNERS = SIDE + 1
BLOCK = CORNERS**3
HEAD = 16
_TILES = -1.0, -2.0  # what stands for the place of a block that is a tile, outside and inside
# Numbers of the head: the corner of the grid (3), a voxel's size, blocks along each axis (3), where the coarse values
# and the places of blocks begin (2), where the masks of blocks begin (``grid_rays``), the width of the band, m, L, the
# greatest slope along an axis, 1 / size


@kernel
def _trilinear(numbers, at, stride_y, stride_z, s, t, u):
    """The value and its derivatives by s, t and u in a cell whose corner with the least coordinates is number
    ``at``."""
    a, b = np.float64(numbers[at]), np.float64(numbers[at + 1])
    c, d = np.float64(numbers[at + stride_y]), np.float64(numbers[at + stride_y + 1])
    at += stride_z
    e, f = np.float64(numbers[at]), np.float64(numbers[at + 1])
    g, h = np.float64(numbers[at + stride_y]), np.float64(numbers[at + stride_y + 1])
    ab, cd, ef, gh = a + s * (b - a), c + s * (d - c), e + s * (f - e), g + s * (h - g)
    low, high = ab + t * (cd - ab), ef + t * (gh - ef)
    x_low, x_high = (b - a) + t * ((d - c) - (b - a)), (f - e) + t * ((h - g) - (f - e))
    return (
        low + u * (high - low),
        x_low + u * (x_high - x_low),
        (cd - ab) + u * ((gh - ef) - (cd - ab)),
        high - low,
    )


@kernel
def _inner(numbers, values, x, y, z):
    """φ and its gradient in the grid's box; the coordinates count voxels."""
    bx, by, bz = int(numbers[4]), int(numbers[5]), int(numbers[6])
    i, j, k = int(0.125 * x), int(0.125 * y), int(0.125 * z)
    i, j, k = min(max(i, 0), bx - 1), min(max(j, 0), by - 1), min(max(k, 0), bz - 1)
    place = numbers[int(numbers[8]) + i + bx * (j + by * k)]
    band, value, gx, gy, gz = numbers[10], 0.0, 0.0, 0.0, 0.0
    if place >= 0.0:
        s, t, u = x - 8.0 * i, y - 8.0 * j, z - 8.0 * k
        a, b, c = min(int(s), 7), min(int(t), 7), min(int(u), 7)
        at = int(place) + a + 9 * (b + 9 * c)
        value, gx, gy, gz = _trilinear(values, at, 9, 81, s - a, t - b, u - c)
        if abs(value) < band * (1.0 - 1e-12):
            return value, gx, gy, gz
        value, gx, gy, gz = (band, 0.0, 0.0, 0.0) if value > 0.0 else (-band, 0.0, 0.0, 0.0)
    else:
        value = band if place == -1.0 else -band
    at = int(numbers[7]) + i + (bx + 1) * (j + (by + 1) * k)
    s, t, u = 0.125 * x - i, 0.125 * y - j, 0.125 * z - k
    coarse, cx, cy, cz = _trilinear(numbers, at, bx + 1, (bx + 1) * (by + 1), s, t, u)
    excess = abs(coarse) - numbers[11]
    if excess > 0.0:
        value += excess if coarse > 0.0 else -excess
        return value, 0.125 * cx, 0.125 * cy, 0.125 * cz
    return value, gx, gy, gz


@kernel
def _field(numbers, values, x, y, z):
    """φ and its gradient."""
    inverse = numbers[14]
    px, py, pz = (x - numbers[0]) * inverse, (y - numbers[1]) * inverse, (z - numbers[2]) * inverse
    qx = min(max(px, 0.0), 8.0 * numbers[4])
    qy = min(max(py, 0.0), 8.0 * numbers[5])
    qz = min(max(pz, 0.0), 8.0 * numbers[6])
    value, gx, gy, gz = _inner(numbers, values, qx, qy, qz)
    gx, gy, gz = gx * inverse, gy * inverse, gz * inverse
    if px == qx and py == qy and pz == qz:
        return value, gx, gy, gz
    dx, dy, dz = (px - qx) * numbers[3], (py - qy) * numbers[3], (pz - qz) * numbers[3]
    if dx != 0.0:
        gx = 0.0
    if dy != 0.0:
        gy = 0.0
    if dz != 0.0:
        gz = 0.0
    far = math.sqrt(value * value + dx * dx + dy * dy + dz * dz)
    return far, (value * gx + dx) / far, (value * gy + dy) / far, (value * gz + dz) / far


@kernel
def grid_distance(address, voxels, x, y, z):
    """The field at a point, of the kind ``TableFunction``."""
    if x != x:
        return math.nan
    if not (abs(x) < 1e100 and abs(y) < 1e100 and abs(z) < 1e100):
        return math.nan if x != x or y != y or z != z else math.inf
    numbers, values = doubles_at(address), floats_at(voxels)
    inverse = numbers[14]
    px, py, pz = (x - numbers[0]) * inverse, (y - numbers[1]) * inverse, (z - numbers[2]) * inverse
    bx, by, bz = numbers[4], numbers[5], numbers[6]
    if 0.0 <= px < 8.0 * bx and 0.0 <= py < 8.0 * by and 0.0 <= pz < 8.0 * bz:
        # Near the surface, where most rays ask: as ``_field``, without what it does elsewhere.
        i, j, k = int(px), int(py), int(pz)
        place = numbers[int(numbers[8]) + (i >> 3) + int(bx) * ((j >> 3) + int(by) * (k >> 3))]
        if place >= 0.0:
            at = int(place) + (i & 7) + 9 * ((j & 7) + 9 * (k & 7))
            value, _, _, _ = _trilinear(values, at, 9, 81, px - i, py - j, pz - k)
            if abs(value) < numbers[10] * (1.0 - 1e-12):
                return value
    return _field(numbers, values, x, y, z)[0]


@kernel
def grid_slope(address, voxels, x, y, z):
    """Its derivatives."""
    if not (abs(x) < 1e100 and abs(y) < 1e100 and abs(z) < 1e100):
        return 0.0, 0.0, 0.0
    _, gx, gy, gz = _field(doubles_at(address), floats_at(voxels), x, y, z)
    return gx, gy, gz


@kernel
def grid_zeros(parameters, ox, oy, oz, dx, dy, dz, start, end, places, room):
    """All zeros along a ray, of the kind ``Term.zeros``; the parameters are those of ``Shape.terms``."""
    matrix = doubles_at(parameters)  # three rows, then the addresses of both tables
    numbers, values = doubles_at(matrix[12]), floats_at(matrix[13])
    inverse, found = numbers[14], doubles_at(places)
    x = (matrix[0] * ox + matrix[1] * oy + matrix[2] * oz + matrix[3] - numbers[0]) * inverse
    y = (matrix[4] * ox + matrix[5] * oy + matrix[6] * oz + matrix[7] - numbers[1]) * inverse
    z = (matrix[8] * ox + matrix[9] * oy + matrix[10] * oz + matrix[11] - numbers[2]) * inverse
    vx = (matrix[0] * dx + matrix[1] * dy + matrix[2] * dz) * inverse
    vy = (matrix[4] * dx + matrix[5] * dy + matrix[6] * dz) * inverse
    vz = (matrix[8] * dx + matrix[9] * dy + matrix[10] * dz) * inverse
    for position, rate, most in ((x, vx, numbers[4]), (y, vy, numbers[5]), (z, vz, numbers[6])):
        if rate != 0.0:
            first, last = -position / rate, (8.0 * most - position) / rate
            start, end = max(start, min(first, last)), min(end, max(first, last))
        elif position < 0.0 or position > 8.0 * most:
            return 0.0, 0.0
    if not start < end:
        return 0.0, 0.0
    qx = min(max(x + start * vx, 0.0), 8.0 * numbers[4])
    qy = min(max(y + start * vy, 0.0), 8.0 * numbers[5])
    qz = min(max(z + start * vz, 0.0), 8.0 * numbers[6])
    inside = _inner(numbers, values, qx, qy, qz)[0] <= 0.0
    count, looked = zeros_between(numbers, values, x, y, z, vx, vy, vz, start, end, inside, found, int(room))
    return np.float64(count), np.float64(looked)


@kernel
def _slopes(numbers, at, row, plane, part):
    """Bounds of the derivatives in a cell, times ``part``."""
    ax, bx, ay, by, az, bz = math.inf, -math.inf, math.inf, -math.inf, math.inf, -math.inf
    for pair in range(4):
        b, c = pair & 1, pair >> 1
        first = at + row * b + plane * c
        slope = part * (np.float64(numbers[first + 1]) - np.float64(numbers[first]))
        ax, bx = min(ax, slope), max(bx, slope)
        first = at + b + plane * c
        slope = part * (np.float64(numbers[first + row]) - np.float64(numbers[first]))
        ay, by = min(ay, slope), max(by, slope)
        first = at + b + row * c
        slope = part * (np.float64(numbers[first + plane]) - np.float64(numbers[first]))
        az, bz = min(az, slope), max(bz, slope)
    return ax, bx, ay, by, az, bz


@kernel
def _cells(at_zeros, numbers, values, low_x, high_x, low_y, high_y, low_z, high_z):
    """Bounds of φ and its gradient over all voxels that touch a box inside of the grid, given in voxels.

    With ``at_zeros``, the gradient is that in the voxels where φ may be zero, or 0 if there are none.
    """
    i0, i1 = int(math.floor(low_x)), int(math.ceil(high_x))
    j0, j1 = int(math.floor(low_y)), int(math.ceil(high_y))
    k0, k1 = int(math.floor(low_z)), int(math.ceil(high_z))
    least, most = math.inf, -math.inf
    ax, bx, ay, by, az, bz = math.inf, -math.inf, math.inf, -math.inf, math.inf, -math.inf
    nx, ny = int(numbers[4]), int(numbers[5])
    band, margin, known = numbers[10], numbers[11], -1
    for k in range(k0, k1):
        for j in range(j0, j1):
            for i in range(i0, i1):
                block = (i >> 3) + nx * ((j >> 3) + ny * (k >> 3))
                place = numbers[int(numbers[8]) + block]
                tile = place < 0.0
                if tile:
                    low = high = -band if place == -2.0 else band
                else:
                    at = int(place) + (i & 7) + 9 * ((j & 7) + 9 * (k & 7))
                    low, high = math.inf, -math.inf
                    for corner in range(8):
                        value = np.float64(values[at + (corner & 1) + 9 * (corner >> 1 & 1) + 81 * (corner >> 2)])
                        low, high = min(low, value), max(high, value)
                least, most = min(least, low), max(most, high)
                if low >= band or high <= -band:
                    if not at_zeros:
                        ax, bx, ay, by, az, bz = (
                            min(ax, 0.0),
                            max(bx, 0.0),
                            min(ay, 0.0),
                            max(by, 0.0),
                            min(az, 0.0),
                            max(bz, 0.0),
                        )
                    if block == known:
                        continue
                    known = block
                    at = int(numbers[7]) + (i >> 3) + (nx + 1) * ((j >> 3) + (ny + 1) * (k >> 3))
                    row, plane = nx + 1, (nx + 1) * (ny + 1)
                    low, high = math.inf, -math.inf
                    for corner in range(8):
                        value = numbers[at + (corner & 1) + row * (corner >> 1 & 1) + plane * (corner >> 2)]
                        low, high = min(low, value), max(high, value)
                    if low >= -margin and high <= margin:
                        continue
                    # In the whole block, and on both sides where the coarse part has both signs.
                    least = min(least, low + margin - band if low < -margin else band)
                    most = max(most, high - margin + band if high > margin else -band)
                    if at_zeros:
                        continue
                    sx, tx, sy, ty, sz, tz = _slopes(numbers, at, row, plane, 0.125)
                    ax, bx, ay, by, az, bz = (
                        min(ax, sx),
                        max(bx, tx),
                        min(ay, sy),
                        max(by, ty),
                        min(az, sz),
                        max(bz, tz),
                    )
                elif not at_zeros or low <= 0.0 <= high:
                    sx, tx, sy, ty, sz, tz = _slopes(values, at, 9, 81, 1.0)
                    ax, bx, ay, by, az, bz = (
                        min(ax, sx),
                        max(bx, tx),
                        min(ay, sy),
                        max(by, ty),
                        min(az, sz),
                        max(bz, tz),
                    )
    if at_zeros and ax > bx:
        ax, bx, ay, by, az, bz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return least, most, ax, bx, ay, by, az, bz


@kernel
def grid_bounds(at_zeros, address, voxels, x_low, x_high, y_low, y_high, z_low, z_high):
    """Bounds of the field and its derivatives in a box; with ``at_zeros``, of the derivatives where the field is
    zero."""
    numbers, values = doubles_at(address), floats_at(voxels)
    x, y, z = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high), 0.5 * (z_low + z_high)
    hx, hy, hz = 0.5 * (x_high - x_low), 0.5 * (y_high - y_low), 0.5 * (z_high - z_low)
    radius = math.sqrt(hx * hx + hy * hy + hz * hz)
    lipschitz, along = numbers[12], numbers[13]
    if not (radius < 1e100 and abs(x) < 1e100 and abs(y) < 1e100 and abs(z) < 1e100):
        return -math.inf, math.inf, -along, along, -along, along, -along, along
    value = _field(numbers, values, x, y, z)[0]
    reach = lipschitz * radius + 1e-9 * (abs(value) + radius + abs(x) + abs(y) + abs(z))
    low, high = value - reach, value + reach
    # Wider by more than rounding moves a point: so it is also in a box of voxels.
    inverse, wider = numbers[14], 1e-9 * (abs(x) + abs(y) + abs(z) + radius + numbers[3])
    ax, bx = (x_low - wider - numbers[0]) * inverse, (x_high + wider - numbers[0]) * inverse
    ay, by = (y_low - wider - numbers[1]) * inverse, (y_high + wider - numbers[1]) * inverse
    az, bz = (z_low - wider - numbers[2]) * inverse, (z_high + wider - numbers[2]) * inverse
    if (
        min(min(ax, ay), az) >= 0.0
        and bx <= 8.0 * numbers[4]
        and by <= 8.0 * numbers[5]
        and bz <= 8.0 * numbers[6]
        and max(max(bx - ax, by - ay), bz - az) <= 9.0
    ):
        least, most, sx, tx, sy, ty, sz, tz = _cells(at_zeros, numbers, values, ax, bx, ay, by, az, bz)
        if least <= most:
            margin = 1e-9
            return (
                max(low, least - margin * numbers[10]),
                min(high, most + margin * numbers[10]),
                sx * inverse - margin,
                tx * inverse + margin,
                sy * inverse - margin,
                ty * inverse + margin,
                sz * inverse - margin,
                tz * inverse + margin,
            )
    return low, high, -along, along, -along, along, -along, along


_GLSL = """\
float grid_cell(int at, int row, int plane, vec3 p)
{
    vec4 low = vec4(table_number(at), table_number(at + row), table_number(at + plane), table_number(at + plane + row));
    at++;
    vec4 high = vec4(table_number(at), table_number(at + row), table_number(at + plane), table_number(at + plane + row));
    vec4 x = mix(low, high, p.x);
    vec2 y = mix(x.xz, x.yw, p.y);
    return mix(y.x, y.y, p.z);
}

float grid(int table, int voxels, float x, float y, float z)
{
    vec3 corner = vec3(table_number(table), table_number(table + 1), table_number(table + 2));
    float size = table_number(table + 3);
    ivec3 blocks = ivec3(table_number(table + 4), table_number(table + 5), table_number(table + 6));
    float band = table_number(table + 10);
    vec3 p = (vec3(x, y, z) - corner) / size;
    vec3 q = clamp(p, vec3(0.0), 8.0 * vec3(blocks));
    ivec3 block = min(ivec3(0.125 * q), blocks - 1);
    int index = block.x + blocks.x * (block.y + blocks.y * block.z);
    float place = table_number(table + int(table_number(table + 8)) + index);
    float value = place < -1.5 ? -band : band;
    if (place > 0.0) {
        vec3 r = q - 8.0 * vec3(block);
        ivec3 cell = min(ivec3(r), ivec3(7));
        value = grid_cell(voxels + int(place) + cell.x + 9 * (cell.y + 9 * cell.z), 9, 81, r - vec3(cell));
    }
    if (abs(value) >= band) {
        int row = blocks.x + 1;
        int plane = row * (blocks.y + 1);
        int at = table + int(table_number(table + 7)) + block.x + row * block.y + plane * block.z;
        float coarse = grid_cell(at, row, plane, 0.125 * q - vec3(block));
        value += sign(coarse) * max(abs(coarse) - table_number(table + 11), 0.0);
    }
    vec3 d = (p - q) * size;
    return d == vec3(0.0) ? value : sqrt(value * value + dot(d, d));
}
"""

GRID = TableFunction(
    "grid",
    grid_distance,
    bounds=Function("grid_bounds", grid_bounds, static=(0,), results=8),
    zero_bounds=Function("grid_bounds", grid_bounds, static=(1,), results=8),
    derivatives=Function("grid_slope", grid_slope, results=3),
    tables=2,
    glsl=_GLSL,
    operations=120.0,
)


GRID_ZEROS = Function("grid_zeros", grid_zeros, results=2)


def _steepness(values: np.ndarray, size: float, varying: np.ndarray | None = None) -> tuple[float, float]:
    """Greatest length of the gradient in cells of the blocks (n, z, y, x), and the greatest slope along an axis."""
    x, y, z = (np.abs(np.diff(values, axis=axis)) for axis in (3, 2, 1))
    if varying is not None and not varying.any():
        return 0.0, 0.0
    along, most = 0.0, 0.0
    for c in (0, 1):
        for b in (0, 1):
            for a in (0, 1):
                ends = [slice(k, k - 1 or None) for k in (a, b, c)]
                square = x[:, ends[2], ends[1]] ** 2
                square = square + y[:, ends[2], :, ends[0]] ** 2
                square += z[:, :, ends[1], ends[0]] ** 2
                most = max(most, float((square if varying is None else square[varying]).max()))
    for slopes in (x, y, z):
        along = max(along, float(slopes.max()))
    return math.sqrt(most) / size, along / size


def cells_that_vary(values: np.ndarray, band: float) -> np.ndarray:
    """Which cells (n, SIDE, SIDE, SIDE) of blocks (n, CORNERS, CORNERS, CORNERS) are not clamped everywhere."""
    low = high = values
    for axis in (1, 2, 3):
        first, last = [slice(None)] * 4, [slice(None)] * 4
        first[axis], last[axis] = slice(None, -1), slice(1, None)
        low = np.minimum(low[tuple(first)], low[tuple(last)])
        high = np.maximum(high[tuple(first)], high[tuple(last)])
    return (low < band) & (high > -band)


def _masks(values: np.ndarray) -> np.ndarray:
    """Masks (n, 2) of blocks (n, CORNERS, CORNERS, CORNERS): the bit a + 4 (b + 4 c) tells whether there are values of
    both signs in the cell (a, b, c) of 2³ voxels. Each half has 32 bits."""
    n, each = len(values), SIDE // 2
    above, below = np.zeros((n, each, each, each), bool), np.zeros((n, each, each, each), bool)
    for c in range(3):
        for b in range(3):
            for a in range(3):
                part = values[:, c : SIDE + c : 2, b : SIDE + b : 2, a : SIDE + a : 2] > 0.0
                above |= part
                below |= ~part
    bits = (above & below).reshape(n, 2, 32).astype(np.float64)
    return bits @ 2.0 ** np.arange(32)


def grid_tables(
    corner: np.ndarray, size: float, coarse: np.ndarray, blocks: np.ndarray, values: np.ndarray, band: float
) -> tuple[Table, Table]:
    """Tables of a grid whose first voxel is at ``corner`` (3,), with voxels of ``size`` metres.

    ``coarse`` (z + 1, y + 1, x + 1) are distances at the corners of blocks,
    ``blocks`` (n, 3) the indices x, y and z of blocks with voxels, ``values`` (n, CORNERS, CORNERS, CORNERS) theirs,
    the last axis x, which agree where blocks touch, and are ``band`` or −``band`` where they touch tiles. A tile has
    the sign of its corners.
    """
    band = float(np.float32(band))
    values = np.clip(np.asarray(values, np.float32).astype(np.float64), -band, band)
    coarse = np.asarray(coarse, np.float64)
    varying = cells_that_vary(values, band)
    # Where f varies the coarse part may not: m is the greatest |c| at corners of such cells.
    touched = np.zeros(values.shape, bool)
    for c in (0, 1):
        for b in (0, 1):
            for a in (0, 1):
                touched[:, c : SIDE + c, b : SIDE + b, a : SIDE + a] |= varying
    i, j, k = blocks.T
    spread = np.linspace(0.0, 1.0, CORNERS)
    eight = np.stack([coarse[k + c, j + b, i + a] for c in (0, 1) for b in (0, 1) for a in (0, 1)], axis=1).reshape(
        -1, 2, 2, 2
    )
    weights = np.stack([1.0 - spread, spread])
    finely = np.einsum("ncba,ci,bj,ak->nijk", eight, weights, weights, weights, optimize=True)
    margin = float(np.abs(finely[touched]).max(initial=0.0)) * (1.0 + 1e-12)
    fine, fine_along = _steepness(values, size)
    rough, rough_along = _steepness(coarse[None], SIDE * size)
    counts = np.array(coarse.shape)[::-1] - 1
    places = np.where(coarse[:-1, :-1, :-1] > 0.0, *_TILES)
    places[k, j, i] = BLOCK * np.arange(len(blocks))
    head = np.zeros(HEAD)
    head[:3], head[3], head[4:7] = corner, size, counts
    head[7:10] = HEAD, HEAD + coarse.size, HEAD + coarse.size + places.size
    head[14] = 1.0 / size
    rounded = 1.0 + 1e-9
    head[10:14] = band, margin, max(fine, rough, 1.0) * rounded, max(fine_along, rough_along, 1.0) * rounded
    voxels = values.astype(np.float32).ravel() if len(blocks) else np.zeros(1, np.float32)
    masks = _masks(values)
    return table(np.concatenate([head, coarse.ravel(), places.ravel(), masks.ravel()])), table(voxels)


@frozen
class Grid(Shape, abstract=True):
    """What a signed distance grid is negative in."""

    exactness = NONE

    data: Table = dataclasses.field(metadata=dict(description="where its blocks are, see ``grid_tables``"))
    values: Table = dataclasses.field(metadata=dict(description="their voxels"))

    @property
    def lipschitz(self) -> float:  # type: ignore[override]
        return float(self.data.array[12])

    @property
    def voxel_size(self) -> float:
        """Metres."""
        return float(self.data.array[3])

    @property
    def bytes(self) -> int:
        """Size in memory."""
        return self.data.bytes + self.values.bytes

    @property
    def voxels(self) -> int:
        """How many are in blocks."""
        return len(self.values.array) // BLOCK * SIDE**3

    def build(self, p: Vector, slot: Slots) -> Formula:
        (distance,) = call(GRID, slot(self.data.address), slot(self.values.address), *p)
        return distance

    def terms(self, matrix: np.ndarray, factor: float) -> list[Term]:
        (term,) = super().terms(matrix, factor)
        return [term._replace(zeros=GRID_ZEROS)]

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        head = self.data.array[:HEAD]
        half = 0.5 * SIDE * head[3] * head[4:7]
        middle = head[:3] + half
        if matrix is not None:
            middle, half = matrix[:3, :3] @ middle + matrix[:3, 3], np.abs(matrix[:3, :3]) @ half
        return middle - half, middle + half

    def growth(self, matrix: np.ndarray | None = None) -> np.ndarray:
        # Outside of the grid the field is at least the distance to it.
        return np.ones(3) if matrix is None else np.linalg.norm(matrix[:3, :3], axis=1)

    def relation(self) -> str:
        low, high = self.bounds()
        if not (np.abs(low).max() <= LARGEST and np.abs(high).max() <= LARGEST):
            return f"Grid: a voxel is not within {LARGEST:g} m of the origin: move it nearer."
        return ""
