# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The boxes of a lamp's tree that its cuts use: found once for all points of a region with similar normals.

A region is a cube whose size is proportional to its distance from the lamp. Starting from the whole lamp, the box that
contributes most to the variance is replaced by its parts until the rest is small. Each thread stores the boxes of the
regions that it has met. They depend only on the region, so the picture does not depend on the thread that met it first.

A *clipped* box accepts only points of the interior. A *solid* box, full or one leaf on the boundary, accepts all its
points, so its samples are exact for any known volumes. Boxes next to the lit point are solid, so errors of volumes
matter only where many of them average out.

Boxes are stored in single precision, relative to the region: coordinates are those of the tree minus the region's
centre, other lengths are in units of the region's size. The density uses these rounded values, so they only need to be
the same everywhere.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel, stack_array
from ...vec import add, dot, length, scale, transform_vector, vec
from ..hashing import bits
from ..tree.moments import lamp_cells
from ..tree.nodes import INSIDE
from . import hidden
from .cut_tables import LEAST_BRIGHT, MOST_BOXES, lamp_steps

MOST_ENTRIES = 2 * MOST_BOXES
REGIONS = 4096  # number of regions whose boxes a thread stores: a power of two

# The index of the boxes of a region. Separate from them, because boxes take megabytes that nothing has to clear.
KEYS = np.dtype(
    [
        ("key", np.uint64),  # hash of lamp, region, normal and tolerance; 0: empty
        ("recent", np.int64),  # 1: of the two regions that share a slot, this was used last
    ]
)
BOXES = np.dtype(
    [  # of a region
        ("count", np.int64),
        ("entries", np.int64),
        ("variance", np.float64),  # expected relative variance, if the emission were uniform
        ("rough", np.float64),  # expected relative variance from varying emission
        ("center", np.float64, (3,)),  # of the region, in tree space
        ("unit", np.float64),  # 1 / size of the region, per metre
        ("metric", np.float64, (3, 3)),  # scalar product of the world in tree space, in square sizes of the region
        # The first axis is the coordinate.
        ("low", np.float32, (3, MOST_BOXES)),
        ("high", np.float32, (3, MOST_BOXES)),
        ("centroid", np.float32, (3, MOST_BOXES)),  # of the accepted volume
        ("extent", np.float32, MOST_BOXES),  # mean square distance from the centroid, in square sizes of the region
        ("volume", np.float32, MOST_BOXES),  # accepted volume, as a fraction of the lamp
        ("fill", np.float32, MOST_BOXES),  # light from a unit of the accepted volume
        ("seen", np.float32, MOST_BOXES),  # the part of the box that places of the scene see: see ``hidden``
        ("cell", np.int32, MOST_BOXES),  # index in the lamp's cells
        ("solid", np.int32, MOST_BOXES),
        ("entry", np.int32, MOST_BOXES),
        # The path down to the boxes.
        ("first", np.int32, MOST_ENTRIES),  # the two entries below; −1 for a box
        ("axis", np.int32, MOST_ENTRIES),
        ("box", np.int32, MOST_ENTRIES),
    ],
    align=True,
)

ROUGHEST = 0.5  # relative variance of a lamp's emission in boxes, above which boxes do not follow it
LEAST_FILL = 0.02  # minimum interior fraction of a solid box: sampling may have missed some
SOFT = 0.8  # corrects the mean over a ball around the lit point
REGION = 0.5  # size of a region relative to its distance from the lamp
NEAR = 1.0  # minimum distance of a region, relative to the thickness of the lamp
SHIFT = 0.381966  # of the grid of regions, in its cells
BLUR = 0.25  # mean square distance of points from the region's centre, in its square sizes
AMBIENT = 0.2  # added to cosines when boxes are chosen: the normals of a region differ

# Odd 64-bit random numbers, which hash the key of a region.
_PRIMES = tuple(
    np.uint64(number)
    for number in (
        0x9E3779B97F4A7C15,
        0xC2B2AE3D27D4EB4F,
        0x165667B19E3779F9,
        0xD6E8FEB86659FD93,
        0xA0761D6478BD642F,
        0xE7037ED1A0B428DB,
        0x8EBC6AF09C88C6E3,
    )
)


@kernel
def corner(boxes, k):
    """Lower corner of box k, relative to the region's centre."""
    return (np.float64(boxes.low[0, k]), np.float64(boxes.low[1, k]), np.float64(boxes.low[2, k]))


@kernel
def far_corner(boxes, k):
    """Upper corner of box k, relative to the region's centre."""
    return (np.float64(boxes.high[0, k]), np.float64(boxes.high[1, k]), np.float64(boxes.high[2, k]))


@kernel
def spread_variance(ratio):
    """Relative variance of the light from a box, from its extent over the square distance."""
    return min(1.2 * ratio * ratio, 1.5)


@kernel
def _rank(boxes, k, normal):
    """Estimate the light from box k at the region's centre, and its relative variance if its emission were uniform."""
    low, high, metric = corner(boxes, k), far_corner(boxes, k), boxes.metric
    w = (np.float64(boxes.centroid[0, k]), np.float64(boxes.centroid[1, k]), np.float64(boxes.centroid[2, k]))
    square = dot(w, transform_vector(metric, w)) + BLUR
    half = 0.5 * (
        abs(normal[0]) * (high[0] - low[0]) + abs(normal[1]) * (high[1] - low[1]) + abs(normal[2]) * (high[2] - low[2])
    )
    height = 0.5 * (dot(normal, low) + dot(normal, high))
    waste = 0.0
    if height <= -half:
        height = 0.0
    elif height < half:
        waste = 0.5 * (half - height) / half
        height = 0.5 * (height + half) * (1.0 - waste)
    ratio = boxes.extent[k] / square
    inverse = 1.0 / (square + SOFT * boxes.extent[k] * min(ratio, 1.0))
    weight = (
        hidden.weight_of(boxes.seen[k])
        * boxes.volume[k]
        * boxes.fill[k]
        * (height * math.sqrt(inverse) + AMBIENT)
        * inverse
    )
    return weight, spread_variance(ratio) + waste + hidden.variance_of(boxes.seen[k])


@kernel
def _solid(boxes, k, whole, fill):
    """Accept all of box k, whose corners are known; ``whole`` is the volume of the lamp in tree space."""
    boxes.solid[k], boxes.fill[k] = 1, fill
    volume, extent = 1.0 / whole, 0.0
    for axis in range(3):
        low, high = np.float64(boxes.low[axis, k]), np.float64(boxes.high[axis, k])
        volume *= high - low
        extent += boxes.metric[axis, axis] * (high - low) ** 2 / 12.0
        boxes.centroid[axis, k] = 0.5 * (low + high)
    boxes.volume[k], boxes.extent[k] = volume, extent


@kernel
def put(boxes, k, entry, cells, index):
    """Make a cell of the tree box k, below ``entry``. Returns whether it can be split."""
    cell, whole = cells[index], cells[0].volume
    boxes.cell[k], boxes.entry[k] = index, entry
    boxes.first[entry], boxes.box[entry] = -1, k
    size = 1.0
    for axis in range(3):
        boxes.low[axis, k] = cell.low[axis] - boxes.center[axis]
        boxes.high[axis, k] = cell.high[axis] - boxes.center[axis]
        size *= cell.high[axis] - cell.low[axis]
    bright = max(cell.mass / cell.volume, LEAST_BRIGHT) if cell.volume > 0.0 else 1.0
    if cell.first < 0:
        _solid(boxes, k, whole, bright * max(cell.volume / size, LEAST_FILL))
        return cell.state == INSIDE
    boxes.solid[k], boxes.fill[k], boxes.volume[k] = 0, bright, cell.volume / whole
    extent = 0.0
    for axis in range(3):
        boxes.centroid[axis, k] = cell.centroid[axis] - boxes.center[axis]
        extent += boxes.metric[axis, axis] * cell.spread[axis]
    boxes.extent[k] = extent
    return True


@kernel
def _halve(boxes, k, other, entry, whole):
    """Split box k, part of a full leaf, along its longest side. Returns whether both parts can be split again."""
    axis, longest = 0, -1.0
    for m in range(3):
        size = boxes.metric[m, m] * (boxes.high[m, k] - boxes.low[m, k]) ** 2
        if size > longest:
            axis, longest = m, size
    for m in range(3):
        boxes.low[m, other], boxes.high[m, other] = boxes.low[m, k], boxes.high[m, k]
    middle = 0.5 * (boxes.low[axis, k] + boxes.high[axis, k])
    boxes.high[axis, k] = boxes.low[axis, other] = middle
    boxes.axis[boxes.entry[k]] = axis
    boxes.cell[other] = boxes.cell[k]
    boxes.first[entry] = boxes.first[entry + 1] = -1
    boxes.box[entry], boxes.box[entry + 1] = k, other
    boxes.entry[k], boxes.entry[other] = entry, entry + 1
    _solid(boxes, k, whole, boxes.fill[k])
    _solid(boxes, other, whole, boxes.fill[k])


@kernel
def part_in_two(boxes, k, cells):
    """Replace box k by its two parts; the second goes behind the last box. Returns whether each can be split again."""
    other, entry = boxes.count, boxes.entries
    boxes.count += 1
    boxes.entries += 2
    boxes.first[boxes.entry[k]] = entry
    cell = cells[boxes.cell[k]]
    if cell.first < 0:
        _halve(boxes, k, other, entry, cells[0].volume)
        return True, True
    boxes.axis[boxes.entry[k]] = cell.axis
    first = put(boxes, k, entry, cells, cell.first)
    return first, put(boxes, other, entry + 1, cells, cell.first + 1)


@kernel
def _set(block, place, boxes, k, normal, steps, splits, follows, weight, even, uneven):
    """Record the light of box k, and how much variance a split can remove: by geometry, and by its emission if the box
    ``follows`` it."""
    boxes.seen[k] = 1.0
    if place.first_seen != hidden.NONE:
        center = vec(boxes.center)
        boxes.seen[k] = hidden.seen_of(block, place, add(center, corner(boxes, k)), add(center, far_corner(boxes, k)))
    weight[k], variance = _rank(boxes, k, normal)
    even[k] = weight[k] * variance if splits else 0.0
    uneven[k] = weight[k] * steps[boxes.cell[k]].rough if splits and follows else 0.0


@kernel
def _divide(block, place, normal, tolerance, limit, boxes):
    """Find at most ``limit`` boxes for the region; ``normal`` is in tree space, in units of the region's size.

    Boxes are split until the expected relative variance is below ``tolerance``.
    """
    cells, steps = lamp_cells(block)[place.first_cell :], lamp_steps(block)[place.first_cell :]
    weight, even, uneven = stack_array(MOST_BOXES), stack_array(MOST_BOXES), stack_array(MOST_BOXES)
    follows = place.rough <= ROUGHEST
    boxes.count = boxes.entries = 1
    _set(block, place, boxes, 0, normal, steps, put(boxes, 0, 0, cells, 0), follows, weight, even, uneven)
    while True:
        total, left, rough, worst, most = 0.0, 0.0, 0.0, 0, -1.0
        for k in range(boxes.count):
            total += weight[k]
            left += even[k]
            rough += uneven[k]
            if even[k] + uneven[k] > most:
                worst, most = k, even[k] + uneven[k]
        boxes.variance, boxes.rough = (left / total, rough / total) if total > 0.0 else (0.0, 0.0)
        if not follows:
            boxes.rough = place.rough
        if left + rough <= tolerance * total or boxes.count >= limit:
            break
        other = boxes.count
        first, second = part_in_two(boxes, worst, cells)
        _set(block, place, boxes, worst, normal, steps, first, follows, weight, even, uneven)
        _set(block, place, boxes, other, normal, steps, second, follows, weight, even, uneven)
    for k in range(boxes.count):
        boxes.fill[k] *= hidden.weight_of(boxes.seen[k])


@kernel
def _whole(value):
    return np.uint64(np.int64(math.floor(value)))


@kernel
def region(block, lamp, place, origin, normal, two_sided, tolerance, limit, keys, store):
    """Slot of the boxes for the region of a point in tree space; ``normal`` is that of the surface, in tree space.

    Regions are aligned with the tree, so they move with the lamp. Their sizes are world sizes.
    """
    root, unit = lamp_cells(block)[place.first_cell], vec(place.unit)
    low, high = vec(root.low), vec(root.high)
    away = (
        max(low[0] - origin[0], origin[0] - high[0], 0.0) / unit[0],
        max(low[1] - origin[1], origin[1] - high[1], 0.0) / unit[1],
        max(low[2] - origin[2], origin[2] - high[2], 0.0) / unit[2],
    )
    target = REGION * max(length(away), NEAR * place.thickness)
    size = 0.5 * target / math.frexp(target)[0]  # a power of two
    step = scale(unit, size)
    # The grid is shifted, so that neither the middle of a lamp nor round numbers lie on its borders.
    at = (
        math.floor(origin[0] / step[0] + SHIFT),
        math.floor(origin[1] / step[1] + SHIFT),
        math.floor(origin[2] / step[2] + SHIFT),
    )
    turn = (
        math.floor(2.0 * normal[0] * unit[0] + 0.5),
        math.floor(2.0 * normal[1] * unit[1] + 0.5),
        math.floor(2.0 * normal[2] * unit[2] + 0.5),
    )
    side = np.uint64(turn[0] + 8.0 * turn[1] + 64.0 * turn[2] + 512.0) * np.uint64(4 * MOST_BOXES) + np.uint64(
        2 * limit + two_sided
    )
    key = bits(
        _whole(at[0]) * _PRIMES[0]
        + _whole(at[1]) * _PRIMES[1]
        + _whole(at[2]) * _PRIMES[2]
        + _whole(size * 2.0**40) * _PRIMES[3]
        + side * _PRIMES[4]
        + np.uint64(lamp + (block.region_set << 32)) * _PRIMES[5]
        + _whole(tolerance * 2.0**40) * _PRIMES[6]
    ) | np.uint64(1)
    slot = np.int64(key >> np.uint64(1)) & (len(keys) - 1)
    if keys[slot].key != key and (keys[slot ^ 1].key == key or keys[slot].recent):
        slot ^= 1
    keys[slot].recent, keys[slot ^ 1].recent = 1, 0
    if keys[slot].key != key:
        keys[slot].key = key
        boxes = store[slot]
        boxes.unit = 1.0 / size
        facing = (0.5 * turn[0] / unit[0], 0.5 * turn[1] / unit[1], 0.5 * turn[2] / unit[2])
        for axis in range(3):
            boxes.center[axis] = (at[axis] + 0.5 - SHIFT) * step[axis]
            for other in range(3):
                boxes.metric[axis, other] = place.metric[axis, other] / (size * size)
        _divide(block, place, scale(facing, 1.0 / size), tolerance, limit, boxes)
    return slot
