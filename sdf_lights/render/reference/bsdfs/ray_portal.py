# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Portals over arrays of points. See ``bsdfs/__init__.py``."""

import numpy as np

from ..closures import Lobe
from ..vectors import dot, normalize

THROUGH_PORTAL = 1 << 13  # kind of a ray that continues at another position


class Portal(Lobe):
    """The ray continues from ``position`` (N, 3) along ``towards`` (N, 3)."""

    def kind(self, wi):
        return np.full(len(wi), THROUGH_PORTAL)

    def evaluate(self, wo, wi):
        return np.zeros(wo.shape), np.zeros(len(wo))

    def sample(self, rng, wo):
        count = len(wo)
        return self.towards, np.ones((count, 3)), np.ones(count), np.ones(count, bool)


def add(builder, node, weight):
    """The lobe of a Ray Portal node."""
    surface, points = builder.surface, builder.points
    position = surface.position if node["position"] is None else points.value(node["position"], 3)
    towards = -surface.wo
    if node["direction"] is not None:
        given = normalize(points.value(node["direction"], 3))
        towards = np.where((dot(given, given) > 0.5)[:, None], given, towards)
    builder.lobes.append(Portal(weight * builder.color(node), surface.ns, position=position, towards=towards))


NODES = {"ray_portal": add}
