# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing one emitter out of all, with the exact probability of the choice.

Suns and the world are infinite emitters, chosen by their irradiance. The rest hang in the light tree, where at each
node a child is chosen by its importance: intensity × cosines / distance², with bounds of the cosines over the child
(Conty Estevez and Kulla 2018; Pharr, Jakob and Humphreys 2023, "Physically based rendering", 12.6.3). Every
probability is positive.
"""

import math

from ....jit import kernel
from ....vec import dot, vec
from .records import emitter_table, infinite_table, node_table

# Least factor for light from behind the normal: shading normals and transmitted light make it matter.
BELOW = 0.02
# Least factor for light to outside the cone of emission: rounding of the cone.
OUTSIDE = 1e-4
# Bounds of a probability between two choices.
LEAST = 1e-6
# Bounds of the probability to choose an infinite emitter where there are others too.
LEAST_INFINITE = 0.05
BELOW_ONE = 1.0 - 2.0**-53


@kernel
def _cos_difference(sin_a, cos_a, sin_b, cos_b):
    """cos max(a − b, 0)."""
    return 1.0 if cos_a > cos_b else cos_a * cos_b + sin_a * sin_b


@kernel
def _importance(node, x, n):
    """Estimate of the irradiance at x, facing n, from all emitters of a node; positive."""
    lo, hi = node.lo, node.hi
    hx, hy, hz = 0.5 * (hi[0] - lo[0]), 0.5 * (hi[1] - lo[1]), 0.5 * (hi[2] - lo[2])
    wx, wy, wz = lo[0] + hx - x[0], lo[1] + hy - x[1], lo[2] + hz - x[2]
    r2 = hx * hx + hy * hy + hz * hz
    square = wx * wx + wy * wy + wz * wz
    if square <= r2:
        return node.intensity / max(r2, 1e-30)
    inverse = 1.0 / math.sqrt(square)
    sin_b, cos_b = math.sqrt(r2) * inverse, math.sqrt(1.0 - r2 / square)
    factor = 1.0
    cos_o = float(node.cos_o)
    if cos_o > -1.0:
        axis = node.axis
        cosine = -(wx * axis[0] + wy * axis[1] + wz * axis[2]) * inverse
        if node.two_sided:
            cosine = abs(cosine)
        sin_o = float(node.sin_o)
        sin_sum = sin_o * cos_b + cos_o * sin_b
        # Beyond a straight angle every direction is within reach.
        if sin_sum >= 0.0:
            sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
            cosine = _cos_difference(sine, cosine, sin_sum, cos_o * cos_b - sin_o * sin_b)
            factor = max(cosine, OUTSIDE) if cosine > node.cos_e else OUTSIDE
    if n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0:
        cosine = (wx * n[0] + wy * n[1] + wz * n[2]) * inverse
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        factor *= max(_cos_difference(sine, cosine, sin_b, cos_b), BELOW)
    return node.intensity * factor * inverse * inverse


@kernel
def _first_probability(nodes, child, x, n):
    """Probability of the first of the two children of a node."""
    a = _importance(nodes[child], x, n)
    b = _importance(nodes[child + 1], x, n)
    total = a + b
    if not 0.0 < total < math.inf:
        return 0.5
    return min(max(a / total, LEAST), 1.0 - LEAST)


@kernel
def _irradiance(infinite, n):
    if infinite.directional == 0 or (n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0):
        return infinite.irradiance
    return infinite.irradiance * max(dot(n, vec(infinite.direction)), BELOW)


@kernel
def _total_irradiance(table, n):
    total = 0.0
    for i in range(len(table)):
        total += _irradiance(table[i], n)
    return total


@kernel
def _infinite_probability(infinite, nodes, x, n, irradiance):
    """Probability of choosing among the infinite emitters."""
    if len(infinite) == 0:
        return 0.0
    if len(nodes) == 0:
        return 1.0
    p = irradiance / (irradiance + _importance(nodes[0], x, n))
    return min(max(p, LEAST_INFINITE), 1.0 - LEAST_INFINITE)


@kernel
def select(block, x, n, u):
    """Choose an emitter for the point x with normal n (the zero vector: any direction counts, as for a surface that
    transmits light). Returns the emitter, its probability and u remapped to [0, 1); emitter −1: there is none."""
    nodes, infinite = node_table(block), infinite_table(block)
    if len(infinite) == 0:
        if len(nodes) == 0:
            return -1, 0.0, u
        probability = 1.0
    else:
        irradiance = _total_irradiance(infinite, n)
        p = _infinite_probability(infinite, nodes, x, n, irradiance)
        if u < p:
            u /= p
            last = len(infinite) - 1
            for i in range(last):
                share = _irradiance(infinite[i], n) / irradiance
                if u < share:
                    return infinite[i].emitter, p * share, min(u / share, BELOW_ONE)
                u -= share
            share = _irradiance(infinite[last], n) / irradiance
            return infinite[last].emitter, p * share, min(max(u / share, 0.0), BELOW_ONE)
        u = min((u - p) / (1.0 - p), BELOW_ONE)
        probability = 1.0 - p
    child = nodes[0].child
    while child >= 0:
        q = _first_probability(nodes, child, x, n)
        if u < q:
            u /= q
            probability *= q
        else:
            u = (u - q) / (1.0 - q)
            probability *= 1.0 - q
            child += 1
        u = min(u, BELOW_ONE)
        child = nodes[child].child
    return ~child, probability, u


@kernel
def selection_probability(block, x, n, emitter):
    """Probability that ``select`` chooses ``emitter`` at the same x and n; 0 for one that gives no light."""
    nodes, infinite = node_table(block), infinite_table(block)
    row = emitter_table(block)[emitter]
    if row.infinite < 0 and row.leaf < 0:
        return 0.0
    irradiance = _total_irradiance(infinite, n)
    p = _infinite_probability(infinite, nodes, x, n, irradiance)
    if row.infinite >= 0:
        return p * _irradiance(infinite[row.infinite], n) / irradiance
    probability = 1.0 - p
    node = row.leaf
    while nodes[node].parent >= 0:
        parent = nodes[node].parent
        child = nodes[parent].child
        q = _first_probability(nodes, child, x, n)
        probability *= q if node == child else 1.0 - q
        node = parent
    return probability
