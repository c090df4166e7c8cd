# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects one emitter for all points of a ray together, from which a medium scatters light.

As ``tree.select``, by the light that an emitter sends to the ray: ∫ I/r² dt. That is the intensity times the angle
under which the emitter sees the ray, divided by its distance to the ray (Kulla and Fajardo 2012), times the
transmittance at the closest point.
"""

import math

import numpy as np

from ....jit import kernel
from ....vec import sub, vec
from ..media.beams import gathered, view_angle
from .records import infinite_table, node_table, tree_table
from .tree import BELOW_ONE, LEAST, LEAST_INFINITE

_FAINTEST = 1e-3  # minimum transmittance of a distant emitter, because the estimate may be wrong


@kernel
def _estimate(node, o, d, length, extinction):
    """The light that the emitters of a node send to a ray, up to a factor."""
    way = sub(vec(node.centroid), o)
    near = way[0] * d[0] + way[1] * d[1] + way[2] * d[2]
    spread = node.spread[0] + node.spread[1] + node.spread[2]
    square = max(way[0] * way[0] + way[1] * way[1] + way[2] * way[2] - near * near, 0.0) + spread
    height = math.sqrt(max(square, 1e-24))
    closest = min(max(near, 0.0), length)
    depth = extinction * (closest + math.sqrt(square + (near - closest) * (near - closest)))
    value = node.intensity * view_angle(near, height, length) / height
    return value * max(math.exp(-depth), _FAINTEST)


@kernel
def select_along(block, number, o, d, length, extinction, u):
    """Select an emitter of tree ``number`` for the ray o + t·d, 0 < t < ``length``, in a medium of this ``extinction``
    (a mean, 1/m).

    Returns the emitter, the probability, u remapped to [0, 1), and whether the emitter is of finite extent, with its
    centre. Emitter −1: there is none.
    """
    nodes, infinite, tree = node_table(block), infinite_table(block), tree_table(block)[number]
    probability, distant, finite = 1.0, 0.0, 0.0
    for index in range(tree.first, tree.end):
        distant += infinite[index].irradiance
    distant *= gathered(extinction, length)
    if tree.nodes > 0:
        finite = _estimate(nodes[tree.root], o, d, length, extinction)
    nowhere = (0.0, 0.0, 0.0)
    if tree.end > tree.first:
        p = 1.0
        if tree.nodes > 0:
            p = (
                min(max(distant / (distant + finite), LEAST_INFINITE), 1.0 - LEAST_INFINITE)
                if distant < math.inf
                else 0.5
            )
        if u < p:
            u = min(u / p, BELOW_ONE)
            total = 0.0
            for index in range(tree.first, tree.end):
                total += infinite[index].irradiance
            left, chosen = u * total, tree.first
            while chosen < tree.end - 1 and left >= infinite[chosen].irradiance:
                left -= infinite[chosen].irradiance
                chosen += 1
            share = infinite[chosen].irradiance
            return infinite[chosen].emitter, p * share / total, min(max(left / share, 0.0), BELOW_ONE), False, nowhere
        u = min((u - p) / (1.0 - p), BELOW_ONE)
        probability = 1.0 - p
    if tree.nodes == 0:
        return np.int64(-1), 0.0, u, False, nowhere
    index = tree.root
    while nodes[index].child >= 0:
        child = nodes[index].child
        a = _estimate(nodes[child], o, d, length, extinction)
        b = _estimate(nodes[child + 1], o, d, length, extinction)
        q = min(max(a / (a + b), LEAST), 1.0 - LEAST) if 0.0 < a + b < math.inf else 0.5
        if u < q:
            u, index, probability = min(u / q, BELOW_ONE), child, probability * q
        else:
            u, index, probability = min((u - q) / (1.0 - q), BELOW_ONE), child + 1, probability * (1.0 - q)
    center = nodes[index].centroid
    return np.int64(~nodes[index].child), probability, u, True, (float(center[0]), float(center[1]), float(center[2]))
