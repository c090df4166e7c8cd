# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds and means of media that vary in space, in the cells of coarse grids, and rays through these cells. For the
medium of the world, which has no end, they are those of sections of each ray.

Bounds come from the values of the formulas at some points, with a margin, so they are not certain. Estimates stay
unbiased where a medium leaves them: see ``tracking.py``.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ....vec import absolute, average, largest, madd, transform_point, transform_vector, vec
from ..geometry import instance_at
from .beams import distance_in, fade, gathered
from .point import evaluate
from .records import NOTHING, WORLD, cell_table, first_grid_table, grid_table, medium_table

# What ``section`` writes: the distance where it ends, and the sums of all media in it, as in ``records.CELL``.
END, MAJORANT, SPREAD, LEAST, MEAN, SCATTERING, GLOW = 0, 1, 2, 3, 6, 9, 10
SECTION = 11  # numbers
# What ``enter_cells`` writes of each medium: the ray in the space of its grid, and the row of this. Then follow the
# number of sections of the world's medium, and these.
GRID_ROW, LOCAL_RAY = 6, 7
WORLD_SECTIONS = 8 * LOCAL_RAY + 1  # of ``records.MOST_MEDIA`` media
MOST_SECTIONS = 64
LOCAL_RAYS = WORLD_SECTIONS + MOST_SECTIONS * SECTION

# Of ``divide_world_ray``. A section is ``GROWTH`` times as long as its distance, and shorter where the optical depth of
# its change is above ``CHANGE``. Nothing matters beyond ``FARTHEST`` steps, or behind an optical depth ``DEEPEST``.
GROWTH, CHANGE, HALVINGS, PROBES, FARTHEST, DEEPEST = 0.35, 0.5, 8, 4, 1e6, 20.0
UNEVEN = 0.15
# Of bounds, also those of ``grids``: ``MARGIN`` is the part of the difference between the greatest and the least value
# around that is added for values between the points, ``LEAST_SHARE`` the part of the greatest value in all that a cell
# has at least. A section has ``NEIGHBOUR`` times the bound of ``NEIGHBOURS`` sections before and behind it at least.
MARGIN, LEAST_SHARE, NEIGHBOURS, NEIGHBOUR = 0.25, 0.01, 3, 0.5

_NUDGE = 1e-6  # of a cell: by how much sections at least advance
_ADVANCE = 1e-14  # and of the distance along the ray, above its rounding
_OPAQUE = 1e-6  # transmittance below which what follows along a ray does not matter


@kernel
def enter_cells(block, workspace, inside, start, d, length, rays):
    """Write the ray in the space of the grids of all media around it to ``rays`` (``LOCAL_RAYS`` numbers), up to a
    distance. The ray is that of ``point.set_ray``."""
    for entry in range(inside.count):
        at, owner = LOCAL_RAY * entry, inside.owner[entry]
        rays[at + GRID_ROW] = -1.0
        if medium_table(block)[inside.medium[entry]].varies == NOTHING:
            continue
        if owner == WORLD:
            rays[at + GRID_ROW] = 0.0
            divide_world_ray(block, workspace, inside.medium[entry], start, d, length, block.media_step, rays)
            continue
        instance = instance_at(block, owner)
        p, way = transform_point(instance.inverse, start), transform_vector(instance.inverse, d)
        for axis in range(3):
            rays[at + axis], rays[at + 3 + axis] = p[axis], way[axis]
        row = first_grid_table(block)[owner]
        while grid_table(block)[row].medium != inside.medium[entry]:
            row += 1
        rays[at + GRID_ROW] = row


@kernel
def _cell(block, row, rays, at, t):
    """Row of the cell of a grid at the distance t of a ray, and the distance where the ray leaves it."""
    grid = grid_table(block)[row]
    side = grid.side
    fastest = 0.0
    for axis in range(3):
        fastest = max(fastest, abs(rays[at + 3 + axis]) / grid.size[axis])
    least = max(_NUDGE / (side * fastest), _ADVANCE * t) if fastest > 0.0 else math.inf
    end, cell = math.inf, np.int64(0)
    for axis in range(2, -1, -1):
        speed = rays[at + 3 + axis] / grid.size[axis]
        where = (rays[at + axis] + t * rays[at + 3 + axis] - grid.low[axis]) / grid.size[axis]
        ahead = where + (speed * least if speed != 0.0 else 0.0)
        index = np.int64(min(max(math.floor(ahead * side), 0.0), side - 1.0))
        cell = cell * side + index
        # Outermost cells have no end outwards: a ray that has missed the surface there would take the least steps.
        if speed > 0.0 and index < side - 1:
            end = min(end, ((index + 1) / side - where) / speed)
        elif speed < 0.0 and index > 0:
            end = min(end, (index / side - where) / speed)
    return grid.first + cell, t + max(end, least)


@kernel
def _probe(block, workspace, medium, x, found, at, count):
    """Add the coefficients of the world's medium at x to a section at ``at``, as its probe number ``count``."""
    scattering, extinction, emission = evaluate(block, workspace, medium, WORLD, x)
    most, least = largest(extinction), extinction
    if count > 0:
        most = max(most, found[at + MAJORANT])
        least = (
            min(extinction[0], found[at + LEAST]),
            min(extinction[1], found[at + LEAST + 1]),
            min(extinction[2], found[at + LEAST + 2]),
        )
    share = 1.0 / (count + 1)
    found[at + MAJORANT] = most
    for axis in range(3):
        before = found[at + MEAN + axis] if count > 0 else 0.0
        found[at + LEAST + axis], found[at + MEAN + axis] = least[axis], before + (extinction[axis] - before) * share
    before = found[at + SCATTERING] if count > 0 else 0.0
    found[at + SCATTERING] = before + (average(scattering) - before) * share
    found[at + GLOW] = max(largest(absolute(emission)), found[at + GLOW] if count > 0 else 0.0)


@replaced_on_gpu
@kernel
def divide_world_ray(block, workspace, medium, start, d, length, step, rays):
    """Cut a ray through the world's medium into sections, by the values at some points of each, and write these behind
    the rays of ``enter_cells``. No grid could hold bounds of a medium without end, as of fog that is denser and denser
    towards the ground, and below. ``step``: the least length of a section, unless the medium changes in it."""
    count, t, depth, limit = 0, 0.0, 0.0, min(length, FARTHEST * step)
    while count < MOST_SECTIONS and t < limit and depth < DEEPEST:
        at = WORLD_SECTIONS + SECTION * count
        size = min(max(step, t * GROWTH), limit - t)
        for halving in range(HALVINGS + 1):
            last = halving == HALVINGS or count == MOST_SECTIONS - 1
            if count == MOST_SECTIONS - 1:
                size = limit - t
            for probe in range(PROBES):  # both ends, and uneven points between, so that patterns are not missed
                x = madd(start, t + size * (probe + UNEVEN * (probe % 2)) / (PROBES - 1 + UNEVEN), d)
                _probe(block, workspace, medium, x, rays, at, probe)
            varied = 0.0
            for axis in range(3):
                varied = max(varied, rays[at + MAJORANT] - rays[at + LEAST + axis])
            if last or varied * size < CHANGE:
                break
            size *= 0.5
        t += size
        rays[at + END] = t
        depth += size * min(rays[at + MEAN], rays[at + MEAN + 1], rays[at + MEAN + 2])
        count += 1
    rays[WORLD_SECTIONS - 1] = count
    # Points of neighbours help to bound what varies faster than there are points.
    glow = 0.0
    for index in range(count):
        glow = max(glow, rays[WORLD_SECTIONS + SECTION * index + GLOW])
    for index in range(count):
        at, around, scattering = WORLD_SECTIONS + SECTION * index, 0.0, 0.0
        for other in range(max(index - NEIGHBOURS, 0), min(index + NEIGHBOURS + 1, count)):
            around = max(around, rays[WORLD_SECTIONS + SECTION * other + MAJORANT])
            scattering = max(scattering, rays[WORLD_SECTIONS + SECTION * other + SCATTERING])
        spread = 0.0
        for axis in range(3):
            margin = MARGIN * (rays[at + MAJORANT] - rays[at + LEAST + axis])
            rays[at + LEAST + axis] = max(rays[at + LEAST + axis] - margin, 0.0)
            spread = max(spread, rays[at + MAJORANT] + margin - rays[at + LEAST + axis])
        least = min(rays[at + LEAST], rays[at + LEAST + 1], rays[at + LEAST + 2])
        rays[at + SPREAD] = max(spread, NEIGHBOUR * around - least)
        rays[at + SCATTERING] = max(rays[at + SCATTERING], LEAST_SHARE * scattering)
        rays[at + GLOW] = glow
    for index in range(count):
        at = WORLD_SECTIONS + SECTION * index
        rays[at + MAJORANT] = min(rays[at + LEAST], rays[at + LEAST + 1], rays[at + LEAST + 2]) + rays[at + SPREAD]


@replaced_on_gpu
@kernel
def world_section_at(rays, t):
    """Where the section of the world's medium at the distance t begins among the numbers of ``rays``; less than 0
    beyond the last one."""
    for index in range(np.int64(rays[WORLD_SECTIONS - 1])):
        if rays[WORLD_SECTIONS + SECTION * index + END] > t:
            return WORLD_SECTIONS + SECTION * index
    return -1


@kernel
def section(block, inside, rays, t, found):
    """Write what is known of the media around a ray from the distance t on, up to the end of a cell, to ``found``
    (``SECTION`` numbers)."""
    extinction = vec(inside.extinction)
    found[END], found[MAJORANT], found[SPREAD] = math.inf, largest(extinction), 0.0
    for axis in range(3):
        found[LEAST + axis] = found[MEAN + axis] = extinction[axis]
    found[SCATTERING], found[GLOW] = average(vec(inside.scattering)), largest(absolute(vec(inside.emission)))
    for entry in range(inside.count):
        at = LOCAL_RAY * entry
        if rays[at + GRID_ROW] < 0.0:
            continue
        if inside.owner[entry] == WORLD:
            here = world_section_at(rays, t)
            if here >= 0:
                found[END] = min(found[END], rays[here + END])
                for number in range(MAJORANT, SECTION):
                    found[number] += rays[here + number]
            continue
        place, end = _cell(block, np.int64(rays[at + GRID_ROW]), rays, at, t)
        found[END] = min(found[END], end)
        cell = cell_table(block)[place]
        found[MAJORANT] += cell.majorant
        found[SPREAD] += cell.spread
        for axis in range(3):
            found[LEAST + axis] += cell.least[axis]
            found[MEAN + axis] += cell.mean[axis]
        found[SCATTERING] += cell.scattering
        found[GLOW] += cell.glow


@kernel
def integrate_cells(block, inside, rays, found, length, target, until):
    """The estimate S(t) = ∫ s exp(−∫ e) dt along a ray, where s and e are the means of the cells: the light that is
    scattered before t.

    Returns the optical depth, S, the distance, S' there, and whether media glow: up to ``length``, or to the distance
    where S is the ``target``, or to the distance ``until``, if these are not negative.
    """
    t, depth, total, left, slope, glows = 0.0, 0.0, 0.0, 1.0, 0.0, False
    while t < length and left > _OPAQUE:
        section(block, inside, rays, t, found)
        end = min(found[END], length)
        glows = glows or found[GLOW] > 0.0
        e = (found[MEAN] + found[MEAN + 1] + found[MEAN + 2]) * (1.0 / 3.0)
        s, size = found[SCATTERING], end - t
        slope = s * left
        own = slope * gathered(e, size) if slope > 0.0 else 0.0
        if target >= 0.0 and total + own > target:
            u = min(max((target - total) / own, 0.0), 1.0 - 2.0**-53)
            way = distance_in(e, e * size, u) if e > 0.0 else u * size
            return depth, target, t + way, slope * fade(e, way), glows
        if until >= 0.0 and until <= end:
            return depth, total, until, slope * fade(e, until - t), glows
        total += own
        if e > 0.0:
            depth += e * size
            left *= fade(e, size)
        t = end
    return depth, total, min(t, length), slope, glows
