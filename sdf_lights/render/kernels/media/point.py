# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that vary in space, at a point: the code of their formulas gives their coefficients there."""

from __future__ import annotations

import numpy as np

from ....emitter import hashing
from ....jit import kernel, table
from ....vec import ZERO, add, average, negate, put, vec
from ..geometry import BUMP_DISTANCE, surface_table
from ..path import MEDIA_SETS, path_table, put_depths
from ..samplers import get_3d
from ..shading.material_records import VOLUME
from ..shading.operands import run
from ..workspace import secondary_table
from .records import NOTHING, medium_table, part_table, random_table, weight_table

MOST = 1e9  # 1/m: no coefficient is larger
LEAST = 1e-30  # 1/m: none is smaller, except 0, so that reciprocals are finite, in float32 too
SHORTEST = 1e-30  # length of a ray that has none; 0 would mean an infinite one
GLOW_SEED, LIGHT_SEED, TRAVEL_SEED, SHADOW_SEED, LAMP_SEED, FADE_SEED = range(4, 10)  # sets beside those of ``path``

volume_table = table("volumes", VOLUME)
_registers = table("registers", np.float64)


@kernel
def begin(workspace, purpose):
    """Begin the random numbers of one use in the present vertex of the path. Their count is not known beforehand."""
    path = path_table(workspace)[0]
    u = get_3d(path.index, path.seed, 2 * MEDIA_SETS + (path.dimension << 4) + purpose)
    random_table(workspace)[0] = hashing.seeded(u[0], u[1], u[2])


@kernel
def draw(workspace):
    """The next random number."""
    state = random_table(workspace)
    state[0] = hashing.following(state[0])
    return hashing.uniform(state[0])


@kernel
def set_ray(workspace, d, kind):
    """Fill the surface of the second workspace with what formulas read at all points of a ray along d."""
    surface = surface_table(secondary_table(workspace)[0])[0]
    back = negate(d)
    put(surface.wo, back)
    put(surface.n, back)
    put(surface.ng, back)
    put(surface.dpdu, ZERO)
    put(surface.dpdv, ZERO)
    put(surface.object_normal, ZERO)
    surface.barycentric[0] = surface.barycentric[1] = 0.0
    surface.bump_step, surface.ray_length = BUMP_DISTANCE, SHORTEST
    surface.backfacing = surface.ray_singular = surface.primitive = surface.strand = 0
    surface.ray_kind = kind
    put_depths(path_table(workspace)[0], surface)


@kernel
def _amount(value):
    """A coefficient: 0 if it is negative or not a number."""
    return min(value, MOST) if value >= LEAST else 0.0


@kernel
def _signed(value):
    """An emission, which is negative where a black body is out of gamut: 0 if it is not a number."""
    return _amount(value) - _amount(-value)


@kernel
def _color(registers, place):
    return (_amount(registers[place]), _amount(registers[place + 1]), _amount(registers[place + 2]))


@kernel
def evaluate(block, workspace, medium, owner, x):
    """Scattering, extinction and emission (RGB) of a medium that varies, in the instance ``owner``, at x. Adds the
    scattering of its parts to the workspace's weights. The ray is that of ``set_ray``."""
    secondary, row = secondary_table(workspace)[0], medium_table(block)[medium]
    surface = surface_table(secondary)[0]
    put(surface.position, x)
    surface.instance = max(owner, 0)
    volume = volume_table(block)[row.varies]
    run(block, secondary, volume.graph, volume.slots)
    registers, weights, scattering = _registers(secondary), weight_table(workspace), ZERO
    for index in range(row.part_count):
        own = _color(registers, 3 * index)
        scattering = add(scattering, own)
        weights[row.first_part + index] += average(own)
    extinction = add(scattering, _color(registers, 3 * row.part_count))
    place = 3 * row.part_count + 3
    emission = (_signed(registers[place]), _signed(registers[place + 1]), _signed(registers[place + 2]))
    return scattering, extinction, emission


@kernel
def coefficients(block, workspace, inside, x):
    """Scattering, extinction and emission (RGB) of all media around x; and the weights of their phase functions there,
    in the workspace."""
    scattering, extinction, emission = vec(inside.scattering), vec(inside.extinction), vec(inside.emission)
    weights = weight_table(workspace)
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        for index in range(medium.first_part, medium.first_part + medium.part_count):
            weights[index] = 0.0
    for entry in range(inside.count):
        medium = medium_table(block)[inside.medium[entry]]
        if medium.varies == NOTHING:
            for index in range(medium.first_part, medium.first_part + medium.part_count):
                weights[index] = part_table(block)[index].weight
            continue
        found = evaluate(block, workspace, inside.medium[entry], inside.owner[entry], x)
        scattering, extinction = add(scattering, found[0]), add(extinction, found[1])
        emission = add(emission, found[2])
    return scattering, extinction, emission


@kernel
def weight_here(block, workspace, index):
    """``phase.part_weight`` at the point of the last ``coefficients``."""
    return weight_table(workspace)[index]


@kernel
def measure(block, workspace, medium, owner, points, values):
    """Coefficients at points (n, 3) in the world: ``values`` (n, 9), scattering, extinction, emission."""
    set_ray(workspace, (0.0, 0.0, -1.0), 0)
    for index in range(len(points)):
        found = evaluate(block, workspace, medium, owner, (points[index, 0], points[index, 1], points[index, 2]))
        for axis in range(3):
            values[index, axis], values[index, 3 + axis] = found[0][axis], found[1][axis]
            values[index, 6 + axis] = found[2][axis]
