# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tree over vertices of light paths: how it is built, how a point chooses a node, and how densely that samples a
place.

The tree is a partition of all places and normals, made from light paths of its own. So the density that it gives a
place does not depend on the vertices that a pass has there.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import kernel
from ....vec import dot, sub, vec
from ..shading.records import surface_table
from .records import choice_table, node_table, top_table

NEAR = 0.5  # part of its distance beyond which the spread of a node makes a point go down to a child
LEAST = 0.3  # of the spread: what a cosine times the distance counts at least, where some vertex may be in front
BENDING = 0.05  # variance of the normals from which on a node is split by them
FINEST = 12  # vertices of a node whose area still tells a density
FEWEST = 4  # vertices of a node that is split
REACH = 1.5  # radii of a node around its centroid beyond which a place belongs to no vertex that is known


@kernel
def expectation(node, x, n):
    """Estimate of the irradiance that the vertices of a node give the point x with normal n; 0 if none can."""
    way = sub(vec(node.centroid), x)
    square, r = dot(way, way), node.spread
    near = dot(n, way)
    if near + node.radius <= 0.0:
        return 0.0
    a = max(near, LEAST * min(r, near + node.radius))
    m = vec(node.normal)
    far = -dot(m, way) + math.sqrt(max(1.0 - dot(m, m), 0.0) * square)
    if far + node.radius <= 0.0:
        return 0.0
    b = max(far, LEAST * min(r, far + node.radius))
    bottom = square + r * r
    return node.flux * a * b / (bottom * bottom) if bottom > 0.0 else 0.0


@kernel
def goes_down(node, x):
    """Whether a point chooses again, among the children of a node."""
    if node.axis < 0:
        return False
    way = sub(vec(node.centroid), x)
    return node.spread * node.spread > NEAR * NEAR * dot(way, way)


@kernel
def side_of(node, position, normal):
    """Which child of a node a place with a geometric normal belongs to: 0 or 1."""
    axis = node.axis
    if axis == 0:
        value = position[0]
    elif axis == 1:
        value = position[1]
    elif axis == 2:
        value = position[2]
    elif axis == 3:
        value = normal[0]
    elif axis == 4:
        value = normal[1]
    else:
        value = normal[2]
    return 1 if value > node.split else 0


@kernel
def choose(block, workspace, row):
    """Find what the surface of the workspace expects of each top node, for this row of choices."""
    surface = surface_table(workspace)[0]
    expect(block, workspace, int(row), vec(surface.position), vec(surface.n))
    return 0.0


@kernel
def expect(block, workspace, row, x, n):
    """Find what the point x with normal n expects of each top node, for this row of choices; returns the sum."""
    choice, nodes, tops, total = choice_table(workspace)[row], node_table(block), top_table(block), 0.0
    choice.count = len(tops)
    for index in range(len(tops)):
        weight = expectation(nodes[tops[index]], x, n)
        choice.weight[index] = weight
        total += weight
    choice.total = total
    return total


@kernel
def draw(block, workspace, row, x, n, u):
    """The node that a number u chooses for the point that ``choose`` was for, and its probability; 0: none."""
    choice, nodes = choice_table(workspace)[row], node_table(block)
    left, index = u * choice.total, 0
    while index < choice.count - 1 and left >= choice.weight[index]:
        left -= choice.weight[index]
        index += 1
    weight = choice.weight[index]
    if not weight > 0.0:
        return 0, 0.0
    u = min(left / weight, 1.0 - 2.0**-53)
    probability, at = weight / choice.total, top_table(block)[index]
    while goes_down(nodes[at], x):
        child = nodes[at].child
        one, two = expectation(nodes[child], x, n), expectation(nodes[child + 1], x, n)
        total = one + two
        if not total > 0.0:
            return at, 0.0
        part = one / total
        if u < part:
            at, u, probability = child, u / part, probability * part
        else:
            at, u, probability = child + 1, (u - part) / (1.0 - part), probability * (1.0 - part)
        u = min(u, 1.0 - 2.0**-53)
    return at, probability


@kernel
def _finer(block, at, y, normal):
    """The child of a node that a place y with this geometric normal belongs to; −1 if its area tells no density."""
    node = node_table(block)[at]
    if node.axis < 0:
        return -1
    child = node.child + side_of(node, y, normal)
    return child if node_table(block)[child].known >= FINEST else -1


@kernel
def find(block, y, normal):
    """Of a place y with this geometric normal: its top node, and its smallest node whose area tells a density."""
    nodes, top = node_table(block), 0
    while nodes[top].top < 0:
        top = nodes[top].child + side_of(nodes[top], y, normal)
    # No break in the loop: after one, Mesa 22.3 in software reads what other threads have found later.
    finest, finer = top, _finer(block, top, y, normal)
    while finer >= 0:
        finest = finer
        finer = _finer(block, finest, y, normal)
    return top, finest


@kernel
def density(block, workspace, row, x, n, y, normal):
    """``density_at`` a place y with this geometric normal."""
    top, finest = find(block, y, normal)
    return density_at(block, workspace, row, x, n, y, normal, top, finest)


@kernel
def density_at(block, workspace, row, x, n, y, normal, top, finest):
    """Estimate of the density by area (1/m²) with which ``draw`` and one of the node's vertices give a place y with
    this geometric normal, which ``find`` has found; 0 where they cannot. Those of the node's vertices tell that are
    near y."""
    choice, nodes, at = choice_table(workspace)[row], node_table(block), top
    if not choice.total > 0.0:
        return 0.0
    probability = choice.weight[nodes[at].top] / choice.total
    while probability > 0.0 and goes_down(nodes[at], x):
        child = nodes[at].child
        one, two = expectation(nodes[child], x, n), expectation(nodes[child + 1], x, n)
        if not one + two > 0.0:
            return 0.0
        part = one / (one + two)
        if side_of(nodes[at], y, normal) == 0:
            at, probability = child, probability * part
        else:
            at, probability = child + 1, probability * (1.0 - part)
    node = nodes[at]
    off = sub(y, vec(node.centroid))
    if dot(off, off) > (REACH * node.radius) ** 2:
        return 0.0
    finest = max(at, finest)  # children come after their parents
    return probability * nodes[finest].known / (node.known * nodes[finest].area)


@kernel
def _measure(node, vertices, order, first, count):
    """Fill a node from its vertices."""
    node.first, node.count, node.known, node.axis, node.top = first, count, count, -1, -1
    flux = 0.0
    for axis in range(3):
        node.centroid[axis] = node.normal[axis] = 0.0
    for index in range(first, first + count):
        vertex = vertices[order[index]]
        flux += vertex.importance
        for axis in range(3):
            node.centroid[axis] += vertex.importance * vertex.position[axis]
            node.normal[axis] += vertex.importance * vertex.normal[axis]
    node.flux = flux
    for axis in range(3):
        node.centroid[axis] /= flux
        node.normal[axis] /= flux
    xx = yy = zz = xy = xz = yz = most = 0.0
    for index in range(first, first + count):
        vertex = vertices[order[index]]
        x, y, z = sub(vec(vertex.position), vec(node.centroid))
        weight = vertex.importance / flux
        xx, yy, zz = xx + weight * x * x, yy + weight * y * y, zz + weight * z * z
        xy, xz, yz = xy + weight * x * y, xz + weight * x * z, yz + weight * y * z
        most = max(most, x * x + y * y + z * z)
    node.spread, node.radius = math.sqrt(xx + yy + zz), math.sqrt(most)
    minors = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz
    node.area = max(12.0 * math.sqrt(max(minors, 0.0)), 1e-3 * node.radius * node.radius, 1e-18)


@kernel
def _divide(node, vertices, order):
    """Choose how a node is split, and put its vertices in that order; returns how many are on the first side."""
    m = vec(node.normal)
    spread = np.zeros(6)
    for index in range(node.first, node.first + node.count):
        vertex = vertices[order[index]]
        for axis in range(3):
            spread[axis] += vertex.importance * (vertex.position[axis] - node.centroid[axis]) ** 2
            spread[3 + axis] += vertex.importance * (vertex.normal[axis] - node.normal[axis]) ** 2
    start = 3 if 1.0 - dot(m, m) > BENDING else 0
    axis = start
    for each in range(start, start + 3):
        if spread[each] > spread[axis]:
            axis = each
    node.axis = axis
    node.split = node.centroid[axis] if axis < 3 else node.normal[axis - 3]
    low, high = node.first, node.first + node.count
    while low < high:
        vertex = vertices[order[low]]
        if side_of(node, vec(vertex.position), vec(vertex.normal)) == 0:
            low += 1
        else:
            high -= 1
            order[low], order[high] = order[high], order[low]
    return low - node.first


@kernel
def _cost(node, pilots):
    """How much a node disturbs those who see it: its flux, less where it looks small."""
    total, square = 0.0, node.spread * node.spread
    for index in range(len(pilots)):
        x, y, z = pilots[index, 0], pilots[index, 1], pilots[index, 2]
        way = sub(vec(node.centroid), (x, y, z))
        distance = dot(way, way)
        total += 1.0 if square >= distance else square / distance
    return node.flux * total


@kernel
def build(vertices, pilots, nodes, tops):
    """Build the tree over ``vertices`` into ``nodes``; returns how many nodes and how many tops there are.

    ``pilots``: (count, 3) places that the camera sees. The node that disturbs them most is split first.
    """
    order = np.arange(len(vertices))
    costs = np.zeros(len(nodes))
    _measure(nodes[0], vertices, order, 0, len(vertices))
    costs[0] = _cost(nodes[0], pilots)
    count, leaves, top_count = 1, 1, 0
    while True:
        if leaves == len(tops) and top_count == 0:
            top_count = _mark(nodes, count, tops)
        if count + 2 > len(nodes):
            break
        at = np.argmax(costs[:count])
        if not costs[at] > 0.0:
            break
        node = nodes[at]
        costs[at] = 0.0
        if node.count < 2 * FEWEST:
            continue
        less = _divide(node, vertices, order)
        if less < FEWEST or node.count - less < FEWEST:
            node.axis = -1
            continue
        node.child = count
        _measure(nodes[count], vertices, order, node.first, less)
        _measure(nodes[count + 1], vertices, order, node.first + less, node.count - less)
        costs[count], costs[count + 1] = _cost(nodes[count], pilots), _cost(nodes[count + 1], pilots)
        count, leaves = count + 2, leaves + 1
    if top_count == 0:
        top_count = _mark(nodes, count, tops)
    return count, top_count


@kernel
def _mark(nodes, count, tops):
    """Make the leaves so far the top nodes."""
    found = 0
    for index in range(count):
        if nodes[index].axis < 0:
            nodes[index].top, tops[found] = found, index
            found += 1
    return found


@kernel
def place(nodes, raw, lengths, width, vertices):
    """Sort the vertices of a pass, ``lengths[i]`` of the path i from ``raw[i · width]`` on, by the leaves of the
    tree."""
    leaf = np.empty(len(raw), np.int32)
    for node in nodes:
        node.count = 0
    for index in range(len(lengths)):
        for row in range(index * width, index * width + lengths[index]):
            at = 0
            while nodes[at].axis >= 0:
                at = nodes[at].child + side_of(nodes[at], vec(raw[row].position), vec(raw[row].normal))
            leaf[row] = at
            nodes[at].count += 1
    for at in range(len(nodes) - 1, -1, -1):  # children come after their parents
        if nodes[at].axis >= 0:
            nodes[at].count = nodes[nodes[at].child].count + nodes[nodes[at].child + 1].count
    nodes[0].first = 0
    for at in range(len(nodes)):
        if nodes[at].axis >= 0:
            child = nodes[at].child
            nodes[child].first = nodes[at].first
            nodes[child + 1].first = nodes[at].first + nodes[child].count
    filled = np.zeros(len(nodes), np.int64)
    for index in range(len(lengths)):
        for row in range(index * width, index * width + lengths[index]):
            at = leaf[row]
            vertices[nodes[at].first + filled[at]] = raw[row]
            filled[at] += 1
