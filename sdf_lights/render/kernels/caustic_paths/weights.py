# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of caustic paths, and what they leave to paths from the camera.

The light of a lamp that k ≥ 1 mirrors or sharp pieces of glass, and nothing else, have scattered before the surface x,
which the camera sees first, is found twice: by a ray that the BSDF of x has drawn with the density p(ω|x), and by light
paths that start at a point of the lamp and are aimed at mirrors. Both share it by the power heuristic (Veach 1997,
section 9.2.4): the weight of the light path is R² / (1 + R²), with the ratio of the densities of both per étendue,

    R = N (P / ΣP) (L / V) p(d) · A |ng · ω| / (n p(ω|x)).

A set has N light paths, the lamp the part P of the power of all and the volume V, and the ray from the last mirror to
the lamp passes through it on the length L before the next surface. p(d) is the density with which light paths start
along that line; as it depends on the start, that of the point of the line nearest to the middle of the lamp is taken. A
pixel sees the area A at x, and n samples of the BSDF belong to a set. Mirrors draw alike on both sides. R depends on
the path alone, so any R gives the right mean. A
narrow lobe may be in the place of the mirrors: see ``lobes.py``.
"""

from __future__ import annotations

import math

import numpy as np

from ....emitter.lamps import lamps as lamp_table
from ....jit import kernel
from ....vec import dot, length, madd, negate, scale, sub, vec
from ..camera import PERSPECTIVE, camera_table
from ..geometry import surface_at
from ..light_paths.mirrors import is_reversible, mirrored
from ..path import CAMERA, MIXED, path_table
from ..shading import shade
from ..shading.records import DIFFUSE, SINGULAR, surface_table
from ..workspace import secondary_table, spans_of
from .lobes import has_narrow_lobe, is_source, left_by_lobe, ratio_of_lobe, weight_of
from .records import (
    BY_LOBE,
    MAY_DIFFER,
    MOST_MIRRORS,
    NARROW,
    UNAIMED,
    UNKNOWN,
    chance_table,
    density_table,
    material_table,
    target_table,
)


@kernel
def cone_around(target, z):
    """Axis (unit) of the cone around a ball as seen from z, and the least cosine to it: −1 from inside."""
    way = sub(vec(target.position), z)
    distance = length(way)
    if distance <= target.radius:
        return (0.0, 0.0, 1.0), -1.0
    sine = target.radius / distance
    return scale(way, 1.0 / distance), math.sqrt(1.0 - sine * sine)


@kernel
def direction_density(block, lamp, z, direction):
    """Density (1/sr) with which caustic paths of a lamp leave a point z in this direction."""
    targets, chances = target_table(block), chance_table(block)
    total = UNAIMED * 0.5
    for index in range(len(targets)):
        axis, least = cone_around(targets[index], z)
        if least <= -1.0 or dot(axis, direction) >= least:
            total += (1.0 - UNAIMED) * chances[lamp * len(targets) + index] / (1.0 - least)
    return total / (2.0 * math.pi)


@kernel
def area_of_pixel(block, direction, distance, ng):
    """Area (m²) of the surface with the geometric normal ng that a pixel shows, at this distance along a camera ray."""
    camera = camera_table(block)[0]
    m = camera.matrix
    cosine = -(m[0, 2] * direction[0] + m[1, 2] * direction[1] + m[2, 2] * direction[2])
    area = abs(camera.step[0] * camera.step[1]) * cosine / max(abs(dot(ng, direction)), 1e-9)
    return area * (distance * cosine) ** 2 if camera.projection == PERSPECTIVE else area


@kernel
def rival_of(block, ng, area, wi, pdf):
    """A |ng · ω| / (n p(ω|x)) of a surface, of which a pixel shows this ``area``, towards ω = wi."""
    return area * abs(dot(ng, wi)) / (block.caustic_samples * pdf)


@kernel
def ratio_of(block, workspace, lamp, origin, d, count, t_to, rival):
    """R of a line along d from ``origin``, a point of a mirror, through a lamp, whose ``count`` intervals are in the
    workspace. The next surface is at ``t_to``."""
    spans, through = spans_of(workspace), 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        through += max(min(c + h, t_to) - max(c - h, 0.0), 0.0)
    nearest = madd(origin, dot(sub(vec(lamp_table(block)[lamp].center), origin), d), d)
    return density_table(block)[lamp] * through * direction_density(block, lamp, nearest, negate(d)) * rival


@kernel
def lines_of(block, surface):
    """``lines`` of a surface, and ``lamp_pdf``: the sum, and the mean, of the targets around it; 0 where its material
    has no narrow lobes that caustic paths know."""
    targets, y, lines, lamp_pdf = target_table(block), vec(surface.position), 0.0, 0.0
    if not block.caustic_lobes or material_table(block)[surface.material] != NARROW:
        return 0.0, 0.0
    for index in range(len(targets)):
        target = targets[index]
        way = sub(y, vec(target.position))
        if dot(way, way) <= target.radius * target.radius:
            lines += target.lines
            lamp_pdf += target.lines * target.lamp_pdf
    return lines, lamp_pdf / lines if lines > 0.0 else 0.0


@kernel
def knows_mirror(block, workspace, wi):
    """Whether a light path could come to the surface of the workspace from wi, and leave along its wo, by mirrors or
    sharp glass alone. This is asked for paths from the camera and for light paths, with the same answer."""
    surface = surface_table(workspace)[0]
    return surface.strand == 0 and material_table(block)[surface.material] != UNKNOWN and is_reversible(workspace, wi)


@kernel
def _is_drawn(block, workspace, wi):
    """Whether a light path that comes from wi would be sent along the wo of the workspace's surface, as the material
    looks from there."""
    surface, secondary = surface_table(workspace)[0], secondary_table(workspace)[0]
    u, v = surface.barycentric[0], surface.barycentric[1]
    instance, primitive = np.int64(surface.instance), np.int64(surface.primitive)
    surface_at(block, surface_table(secondary)[0], instance, primitive, u, v, wi, DIFFUSE, 0.0)
    shade(block, secondary)
    _, chance, _ = mirrored(secondary, vec(surface.wo))
    return chance > 0.0


@kernel
def follow(block, workspace, x, y, z, pdf, kind):
    """Note whether a path from the camera, which its surface scatters along (x, y, z), is still one whose light caustic
    paths find, too: ``path.caustic``. Its ray is still the one that has come."""
    path, surface, wi = path_table(workspace)[0], surface_table(workspace)[0], (x, y, z)
    if int(kind) & SINGULAR == 0:
        before, path.caustic = path.caustic, 0
        if before == 1 and path.lines > 0.0 and (path.reused == MIXED or has_narrow_lobe(workspace)):
            path.caustic = BY_LOBE
        if path.kind == CAMERA and path.transparent == 0:
            ng = vec(surface.ng)
            area = area_of_pixel(block, vec(path.direction), path.length, ng)
            path.caustic, path.rival = 1, rival_of(block, ng, area, wi, pdf)
    elif path.caustic > 0:
        known = path.caustic <= MOST_MIRRORS and knows_mirror(block, workspace, wi)
        if known and material_table(block)[surface.material] == MAY_DIFFER:
            known = _is_drawn(block, workspace, wi)
        path.caustic = path.caustic + 1 if known else 0
    return 0.0


@kernel
def left_to_path(block, workspace, lamp, count, t_to):
    """The part of the light of a lamp along the path's ray, behind mirrors or a narrow lobe, that caustic paths leave
    to the path. The ``count`` intervals of the lamp are in the workspace."""
    path, number = path_table(workspace)[0], int(lamp)
    if not is_source(block, number):
        return 1.0
    if path.caustic == BY_LOBE:
        return 1.0 - weight_of(ratio_of_lobe(path.lines, path.lamp_pdf, path.pdf, path.rival))
    ratio = ratio_of(block, workspace, number, vec(path.origin), vec(path.direction), int(count), t_to, path.rival)
    return 1.0 - weight_of(ratio)


@kernel
def meet(block, workspace, _):
    """Note the ``lines`` of the surface that a ray from the first one that the camera sees has met, if it may have
    narrow lobes."""
    path, surface = path_table(workspace)[0], surface_table(workspace)[0]
    path.lines = path.lamp_pdf = 0.0
    if path.transparent == 0:
        path.lines, path.lamp_pdf = lines_of(block, surface)
    return 0.0


@kernel
def left_to_vertex(block, workspace, x, y, z, pdf, pdf_there):
    """The part of the light of a lamp, which a vertex of a light path scatters first, that caustic paths leave to its
    connection with the surface that the camera sees. They scatter along (x, y, z) with the density ``pdf``, and with
    ``pdf_there`` to the lamp; the second workspace has the surface of the vertex."""
    path, surface, secondary = path_table(workspace)[0], surface_table(workspace)[0], secondary_table(workspace)[0]
    lines, lamp_pdf = lines_of(block, surface_table(secondary)[0])
    ng = vec(surface.ng)
    rival = rival_of(block, ng, area_of_pixel(block, vec(path.direction), path.length, ng), (x, y, z), pdf)
    return left_by_lobe(secondary, lines, lamp_pdf, pdf_there, rival)
