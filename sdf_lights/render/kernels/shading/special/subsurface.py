# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsurface scattering: the closure, and the entry of light. ``kernels/subsurface`` follows the light from there.

As in Cycles, no energy is lost at the entry, and the exit is diffuse. In a thin wall light is scattered at once
(OpenPBR 1.1).

Fields of the closure: ``distribution`` is the method, ``f0`` the colour of the surface, ``edge`` the radius in metres,
``a`` the anisotropy; ``alpha`` and ``ior`` are those of the boundary where light enters.
"""

import math

from .....jit import kernel
from .....vec import dot, frame, madd, negate, put, scale, to_world, vec
from ..closures import (
    add_diffuse,
    add_lambert,
    begin,
    finish,
    lobe_table,
    positive,
    saturate,
    saturated,
    specular_normal,
)
from ..diffuse import cosine_hemisphere
from ..material_records import (
    BASE_COLOR,
    DIFFUSE_ROUGHNESS,
    NORMAL,
    ROUGHNESS,
    SUBSURFACE_ANISOTROPY,
    SUBSURFACE_IOR,
    SUBSURFACE_RADIUS,
    SUBSURFACE_SCALE,
    THIN_WALL,
)
from ..microfacet import visible_normal
from ..operands import normal, number, vector
from ..records import (
    BURLEY,
    INTO_SUBSURFACE,
    RANDOM_WALK,
    RANDOM_WALK_SKIN,
    SINGULAR,
    SUBSURFACE,
    TRANSMISSION,
    closure_table,
    surface_table,
)
from ..special_lobes import LOBE_SUBSURFACE, METHOD, ONCE, WITH_SUBSURFACE, WITH_THIN_SCATTERING

SMALLEST_RADIUS = 1e-8  # metres; a colour with a smaller radius is diffuse
LOWEST_IOR, HIGHEST_IOR = 1.01, 3.8
HIGHEST_ANISOTROPY, HIGHEST_OF_OTHERS = 0.99, 0.9  # of RANDOM_WALK, and of the other methods


@kernel
def _add(workspace, features, weight, color, radius, anisotropy, ior, alpha, n):
    """Add the closure; colours with a tiny radius get diffuse ones."""
    surface = surface_table(workspace)[0]
    method = features >> METHOD & 3
    once = features & ONCE != 0 and surface.depth[1] > 0
    deep = (
        0.0 if once or radius[0] < SMALLEST_RADIUS else weight[0],
        0.0 if once or radius[1] < SMALLEST_RADIUS else weight[1],
        0.0 if once or radius[2] < SMALLEST_RADIUS else weight[2],
    )
    if deep != weight:
        add_lambert(workspace, madd(weight, -1.0, deep), n, False)
    index = begin(workspace, deep, n)
    if index < 0:
        return
    closure = closure_table(workspace)[index]
    closure.kind, closure.singular, closure.distribution = SUBSURFACE, 1, method
    put(closure.f0, color)
    put(closure.edge, radius)
    closure.a = min(
        max(anisotropy, -HIGHEST_ANISOTROPY), HIGHEST_ANISOTROPY if method == RANDOM_WALK else HIGHEST_OF_OTHERS
    )
    closure.alpha = 1.0 if method == RANDOM_WALK_SKIN else alpha
    closure.ior = min(max(ior, LOWEST_IOR), HIGHEST_IOR)
    surface.subsurface += 1
    finish(workspace, index, deep)


@kernel
def add_lobe(block, workspace, lobe, weight):
    """Subsurface Scattering."""
    row, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = row.args
    color = positive(vector(block, workspace, args[0]))
    radius = positive(scale(vector(block, workspace, args[2]), number(block, workspace, args[1])))
    _add(
        workspace,
        row.features,
        scale(color, weight),
        color,
        radius,
        number(block, workspace, args[5]),
        number(block, workspace, args[3]),
        saturate(number(block, workspace, args[4])),
        specular_normal(surface, normal(block, workspace, args[6])),
    )
    return 0.0


@kernel
def _add_thin(block, workspace, args, weight, color, anisotropy):
    """Light that a sheet with dense scattering reflects and transmits."""
    n = normal(block, workspace, args[NORMAL])
    back, through = saturate(0.5 - 0.5 * anisotropy), saturate(0.5 + 0.5 * anisotropy)
    roughness = saturate(number(block, workspace, args[DIFFUSE_ROUGHNESS]))
    add_diffuse(workspace, scale(weight, back), color, roughness, n)
    add_lambert(workspace, scale(weight, through), n, True)


@kernel
def add_principled(block, workspace, lobe, r, g, b, ior):
    """Subsurface scattering of Principled, with this weight; ``ior`` is that of its specular layer."""
    row, surface = lobe_table(block)[int(lobe)], surface_table(workspace)[0]
    args = row.args
    color = saturated(vector(block, workspace, args[BASE_COLOR]))
    anisotropy = number(block, workspace, args[SUBSURFACE_ANISOTROPY])
    if row.features & WITH_THIN_SCATTERING and number(block, workspace, args[THIN_WALL]) > 0.0:
        _add_thin(block, workspace, args, (r, g, b), color, anisotropy)
    elif row.features & WITH_SUBSURFACE:
        if row.features >> METHOD & 3 == RANDOM_WALK_SKIN:
            ior = number(block, workspace, args[SUBSURFACE_IOR])
        roughness = saturate(number(block, workspace, args[ROUGHNESS]))
        radius = positive(
            scale(vector(block, workspace, args[SUBSURFACE_RADIUS]), number(block, workspace, args[SUBSURFACE_SCALE]))
        )
        _add(
            workspace,
            row.features,
            (r, g, b),
            color,
            radius,
            anisotropy,
            ior,
            roughness * roughness,
            specular_normal(surface, normal(block, workspace, args[NORMAL])),
        )
    return 0.0


@kernel
def evaluate(block, workspace, index, x, y, z):
    """Zero: it is singular."""
    return 0.0, 0.0, 0.0, 0.0


@kernel
def _refracted(closure, wo, u1, u2):
    """Direction of light below a rough boundary; the zero vector if wo is below it."""
    n = vec(closure.normal)
    cosine = dot(n, wo)
    if cosine <= 0.0:
        return (0.0, 0.0, 0.0)
    t, b = frame(n)
    h = to_world(visible_normal((dot(t, wo), dot(b, wo), cosine), closure.alpha, closure.alpha, u1, u2), t, b, n)
    ratio, c = 1.0 / closure.ior, dot(h, wo)
    below = math.sqrt(max(1.0 - ratio * ratio * (1.0 - c * c), 1e-14))
    return madd(scale(wo, -ratio), ratio * c - below, h)


@kernel
def sample(block, workspace, index, u1, u2, u3):
    """wi, the direction of light below the surface, f · |cos|, pdf and kind."""
    surface, closure = surface_table(workspace)[0], closure_table(workspace)[int(index)]
    surface.entered = int(index)
    if closure.distribution == BURLEY:
        wi = negate(vec(surface.ng))
    elif closure.distribution == RANDOM_WALK_SKIN and u3 < 0.5:
        n = negate(vec(closure.normal))
        t, b = frame(n)
        wi = to_world(cosine_hemisphere(u1, u2), t, b, n)
    else:
        wi = _refracted(closure, vec(surface.wo), u1, u2)
    pdf = 1.0 if dot(wi, wi) > 0.0 else 0.0
    return wi[0], wi[1], wi[2], 1.0, 1.0, 1.0, pdf, INTO_SUBSURFACE | TRANSMISSION | SINGULAR


LOBES = {LOBE_SUBSURFACE: (add_lobe, (SUBSURFACE,))}
CLOSURES = (SUBSURFACE,)
