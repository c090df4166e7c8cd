# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects one emitter out of all, with the exact probability of the selection.

Suns and the world are infinite emitters, selected by their irradiance, a uniform world by a part of it. The rest are in
the light tree (Conty Estevez and Kulla 2018). Its nodes estimate the irradiance of everything below: the intensity at
its centroid, spread by its variance. Estimates are poor for nodes that are large relative to their distance. There a
choice between two children, made once at every level, is far from the contributions of the emitters below. So a *cut*
of the tree (Walter et al. 2005, "Lightcuts") is made for every lit point. Nodes are replaced by their children, in the
order of the variance that they are expected to add, until little variance is left or there are ``MOST_NODES``; of few
emitters, all are there at once. One of them is drawn in proportion to its estimate, and below it one child at each
level. Every probability is positive.

With light linking there are several trees: number 0 has every emitter, and each of the others has those that light some
surfaces (``linking.py``).

The nodes stay in the order of the leaves, so neighbours in space stay neighbours along the random number of the
selection.
"""

import math

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ....vec import dot, negate, sub, vec
from .linking import place_in
from .records import MOST_NODES, infinite_table, node_table, tree_table

# Added to the cosine: light from behind the normal matters because of shading normals and transmitted light.
BELOW = 0.02
# Relative variance that a cut may leave: shadows and the emitters themselves have more.
TOLERANCE = 0.05
FEW = 6  # emitters of a tree whose cuts have all of them at once: to look for fewer nodes takes longer
# Minimum factor for light outside the cone of emission: rounding of the cone.
OUTSIDE = 1e-4
# Bounds of a probability between two choices.
LEAST = 1e-6
# Bounds of the probability to select an infinite emitter if there are others too.
LEAST_INFINITE = 0.05
BELOW_ONE = 1.0 - 2.0**-53


@kernel
def _cos_difference(sin_a, cos_a, sin_b, cos_b):
    """cos max(a − b, 0)."""
    return 1.0 if cos_a > cos_b else cos_a * cos_b + sin_a * sin_b


@kernel
def _cone(node, to_x, square):
    """Estimate of the emission of a node with normals, relative to that along them: ``to_x`` points from its centroid
    to x."""
    radius = float(node.radius)
    if square <= radius * radius:
        return 1.0
    inverse = 1.0 / math.sqrt(square)
    sin_b, cos_b = radius * inverse, math.sqrt(1.0 - radius * radius * inverse * inverse)
    cosine = dot(to_x, vec(node.axis)) * inverse
    if node.two_sided:
        cosine = abs(cosine)
    cos_o = float(node.cos_o)
    sin_o = math.sqrt(max(1.0 - cos_o * cos_o, 0.0))
    sin_sum = sin_o * cos_b + cos_o * sin_b
    if sin_sum < 0.0:  # beyond a straight angle every direction is possible
        return 1.0
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    cosine = _cos_difference(sine, cosine, sin_sum, cos_o * cos_b - sin_o * sin_b)
    return max(cosine, OUTSIDE) if cosine > node.cos_e else OUTSIDE


@kernel
def estimate(node, x, n):
    """Irradiance at x, facing n, from all emitters of a node, positive; and its doubt: the irradiance times the
    relative variance that a selection among its emitters by their estimates is expected to remove."""
    spread = vec(node.spread)
    way = sub(vec(node.centroid), x)
    extent = spread[0] + spread[1] + spread[2]
    square = dot(way, way)
    inverse = 1.0 / max(square + extent, 1e-30)
    value, error, splits = node.intensity * inverse, 0.0, node.child >= 0
    if splits:
        ratio = extent / max(square, 1e-30)
        error = min(1.2 * ratio * ratio, 1.5)
    if node.cos_o > -1.0:
        value *= _cone(node, negate(way), square)
        error += 0.5 * (1.0 - node.cos_o)
    if n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0:
        # Mean of max(0, ·) over evenly spread heights with that variance.
        height = dot(way, n)
        half = math.sqrt(3.0 * (n[0] * n[0] * spread[0] + n[1] * n[1] * spread[1] + n[2] * n[2] * spread[2]))
        if height < half:
            if splits:
                error += 0.5 * min((half - height) / half, 2.0)
            height = 0.25 * (height + half) * (height + half) / half if height > -half else 0.0
        value *= max(height, 0.0) * math.sqrt(inverse) + BELOW
    return value, value * error if splits else 0.0


@kernel
def _first_probability(nodes, child, x, n):
    """Probability of the first of the two children of a node."""
    a, _ = estimate(nodes[child], x, n)
    b, _ = estimate(nodes[child + 1], x, n)
    total = a + b
    if not 0.0 < total < math.inf:
        return 0.5
    return min(max(a / total, LEAST), 1.0 - LEAST)


@kernel
def _importance(infinite, n):
    """Weight of an infinite emitter in the selection at a surface that faces n."""
    if infinite.directional == 0 or (n[0] == 0.0 and n[1] == 0.0 and n[2] == 0.0):
        return infinite.importance
    return infinite.importance * max(dot(n, vec(infinite.direction)), BELOW)


@kernel
def _total_importance(table, tree, n):
    total = 0.0
    for i in range(tree.first, tree.end):
        total += _importance(table[i], n)
    return total


@kernel
def _put(cut, k, nodes, index, x, n):
    cut.node[k], cut.order[k] = index, nodes[index].order
    cut.weight[k], cut.doubt[k] = estimate(nodes[index], x, n)


@kernel
def _split(cut, count, splits, least, nodes, x, n):
    """Replace the nodes whose doubt is ``least`` or more, ``splits`` of ``count``, by their children, in order."""
    to = count + splits - 1
    for k in range(count - 1, -1, -1):
        if to == k:
            return
        if cut.doubt[k] >= least:
            child = nodes[cut.node[k]].child
            _put(cut, to, nodes, child + 1, x, n)
            _put(cut, to - 1, nodes, child, x, n)
            to -= 2
        else:
            cut.node[to], cut.order[to] = cut.node[k], cut.order[k]
            cut.weight[to], cut.doubt[to] = cut.weight[k], cut.doubt[k]
            to -= 1


@kernel
def _doubtful(cut, count, least):
    """Number of nodes with a doubt of ``least`` or more."""
    found = 0
    for k in range(count):
        found += cut.doubt[k] >= least
    return found


@kernel
def _is_for(cut, root, x, n):
    return (
        cut.count > 0
        and cut.root == root
        and cut.x[0] == x[0]
        and cut.x[1] == x[1]
        and cut.x[2] == x[2]
        and cut.n[0] == n[0]
        and cut.n[1] == n[1]
        and cut.n[2] == n[2]
    )


@kernel
def _take_all(cut, nodes, tree, x, n):
    """Let ``cut`` be all emitters of the tree."""
    total, least = 0.0, nodes[tree.root].order
    for index in range(tree.root, tree.root + tree.nodes):
        if nodes[index].child < 0:
            k = nodes[index].order - least
            _put(cut, k, nodes, index, x, n)
            total += cut.weight[k]
    cut.count, cut.total = (tree.nodes + 1) // 2, total


@replaced_on_gpu
@kernel
def fit_cut(nodes, tree, x, n, cut):
    """Make ``cut`` that of the point x with normal n in the ``tree``, unless it already is."""
    root = tree.root
    if _is_for(cut, root, x, n):
        return
    cut.root = root
    for axis in range(3):
        cut.x[axis], cut.n[axis] = x[axis], n[axis]
    if tree.nodes < 2 * FEW:
        _take_all(cut, nodes, tree, x, n)
    else:
        _choose_nodes(cut, nodes, root, x, n)
    if not 0.0 < cut.total < math.inf:
        cut.count, cut.node[0], cut.order[0], cut.weight[0], cut.total = 1, root, 0, 1.0, 1.0


@kernel
def _choose_nodes(cut, nodes, root, x, n):
    """Choose the nodes of a cut below ``root``."""
    _put(cut, 0, nodes, root, x, n)
    count, total = 1, 0.0
    while True:
        total, doubt = 0.0, 0.0
        for k in range(count):
            total += cut.weight[k]
            doubt += cut.doubt[k]
        if not TOLERANCE * total < doubt < math.inf:
            break
        least = 0.5 * doubt / count
        splits = _doubtful(cut, count, least)
        while splits > MOST_NODES - count:
            least *= 2.0
            splits = _doubtful(cut, count, least)
        if splits == 0:
            break
        _split(cut, count, splits, least, nodes, x, n)
        count += splits
    cut.count, cut.total = count, total


@kernel
def _infinite_probability(tree, importance, cut):
    """Probability of selecting among the infinite emitters."""
    if tree.first == tree.end:
        return 0.0
    if tree.nodes == 0:
        return 1.0
    p = importance / (importance + cut.total)
    return min(max(p, LEAST_INFINITE), 1.0 - LEAST_INFINITE)


@kernel
def _has_one(nodes, tree):
    """Whether a tree has one emitter alone, which is in its root."""
    return tree.first == tree.end and tree.nodes > 0 and nodes[tree.root].child < 0


@replaced_on_gpu
@kernel
def select(block, number, x, n, u, cut):
    """Select an emitter of tree ``number`` for the point x with normal n (the zero vector: any direction counts, as for
    a surface that transmits light). Returns the emitter, its probability and u remapped to [0, 1); emitter −1: there is
    none.

    ``cut`` (``LIGHT_CUT``) is scratch memory, which ``selection_probability`` at the same x and n can use again.
    """
    nodes, infinite, tree = node_table(block), infinite_table(block), tree_table(block)[number]
    if _has_one(nodes, tree):
        return ~nodes[tree.root].child, 1.0, u
    if tree.nodes > 0:
        fit_cut(nodes, tree, x, n, cut)
    probability = 1.0
    if tree.first == tree.end:
        if tree.nodes == 0:
            return -1, 0.0, u
    else:
        importance = _total_importance(infinite, tree, n)
        p = _infinite_probability(tree, importance, cut)
        if u < p:
            u /= p
            last = tree.end - 1
            for i in range(tree.first, last):
                share = _importance(infinite[i], n) / importance
                if u < share:
                    return infinite[i].emitter, p * share, min(u / share, BELOW_ONE)
                u -= share
            share = _importance(infinite[last], n) / importance
            return infinite[last].emitter, p * share, min(max(u / share, 0.0), BELOW_ONE)
        u = min((u - p) / (1.0 - p), BELOW_ONE)
        probability = 1.0 - p
    u *= cut.total
    k = 0
    while k < cut.count - 1 and u >= cut.weight[k]:
        u -= cut.weight[k]
        k += 1
    probability *= cut.weight[k] / cut.total
    u = min(u / cut.weight[k], BELOW_ONE)
    child = nodes[cut.node[k]].child
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
def irradiance(block, number, x):
    """Estimate of the irradiance at x of all emitters of a tree together, without shadows, for any normal."""
    tree, total = tree_table(block)[number], 0.0
    for i in range(tree.first, tree.end):
        total += infinite_table(block)[i].irradiance
    if tree.nodes > 0:
        value, _ = estimate(node_table(block)[tree.root], x, (0.0, 0.0, 0.0))
        total += value
    return total


@replaced_on_gpu
@kernel
def selection_probability(block, number, x, n, emitter, cut):
    """Probability that ``select`` selects ``emitter`` of the same tree at the same x and n; 0 for an emitter without
    light."""
    nodes, infinite, tree = node_table(block), infinite_table(block), tree_table(block)[number]
    leaf, endless = place_in(block, number, emitter)
    if endless < 0 and leaf < 0:
        return 0.0
    if _has_one(nodes, tree):
        return 1.0
    if tree.nodes > 0:
        fit_cut(nodes, tree, x, n, cut)
    importance = _total_importance(infinite, tree, n)
    p = _infinite_probability(tree, importance, cut)
    if endless >= 0:
        return p * _importance(infinite[endless], n) / importance
    # The last node of the cut whose leaves do not begin after the emitter's.
    k, end = 0, cut.count
    while end - k > 1:
        middle = (k + end) // 2
        if cut.order[middle] <= leaf:
            k = middle
        else:
            end = middle
    probability = (1.0 - p) * cut.weight[k] / cut.total
    child = nodes[cut.node[k]].child
    while child >= 0:
        q = _first_probability(nodes, child, x, n)
        if leaf < nodes[child + 1].order:
            probability *= q
        else:
            probability *= 1.0 - q
            child += 1
        child = nodes[child].child
    return probability
