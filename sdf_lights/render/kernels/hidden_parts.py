# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of a lamp surfaces see: see ``emitter.sampling.hidden``."""

from __future__ import annotations

from ...emitter.lamps import lamps
from ...emitter.sampling.cut_tables import placements
from ...emitter.sampling.hidden import cell_of
from ...emitter.sampling.projection import interior_point
from ...emitter.tree.moments import lamp_cells
from ...jit import kernel
from ...vec import add, length, scale, sub, transform_point, vec
from .ray_origins import clear_self_primitive
from .rays import SHADOW_OPAQUE, occluded, ray_table, start_anew
from .samplers import get_3d, pixel_seed

SEED = 0x4C41  # other numbers than those of pixels


@kernel
def look_at_parts(block, workspace, lamp, points, looks, places, found):
    """Let ``looks`` of the ``places`` (n, 3) look at each of so many even points of a lamp. ``found`` (cells, 2):
    counts of these looks, and of those that nothing opaque ends."""
    scene, scratch = block[0], workspace[0]
    place, seed = placements(scene)[lamp], pixel_seed(SEED, lamp, 0)
    clear_self_primitive(ray_table(scratch)[0])
    for index in range(points):
        u = get_3d(index, seed, 0)
        offset = interior_point(scene, lamp, u[0], u[1], u[2])
        cell = cell_of(lamp_cells(scene)[place.first_cell], transform_point(place.inverse, offset))
        point = add(vec(lamps(scene)[lamp].center), offset)
        for look in range(looks):
            at = (index * looks + look) % len(places)
            way = sub((places[at, 0], places[at, 1], places[at, 2]), point)
            distance = length(way)
            found[cell, 0] += 1
            if not distance > 0.0:
                continue
            start_anew(scene, scratch)
            hidden = occluded(scene, scratch, point, scale(way, 1.0 / distance), 0.0, distance, SHADOW_OPAQUE)
            found[cell, 1] += int(not hidden)
