# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Toon over arrays of points. See ``bsdfs/__init__.py``."""

import numpy as np

from ...scene import Ray
from ..closures import Lobe, grey
from ..vectors import dot, reflect, uniform_cone


class Toon(Lobe):
    """Uniform in a cone of half angle ``size`` (N,), falling off within ``smooth`` (N,) of it; about the normal, or the
    mirror direction if it is ``glossy``."""

    glossy = False

    @property
    def diffuse(self):
        return not self.glossy

    def kind(self, wi):
        return np.full(len(wi), int(Ray.GLOSSY if self.glossy else Ray.DIFFUSE))

    def _axis(self, wo):
        return reflect(wo, self.normal) if self.glossy else self.normal

    @property
    def _widest(self):
        return np.minimum(self.size + self.smooth, 0.5 * np.pi)

    def evaluate(self, wo, wi):
        angle = np.arccos(np.clip(dot(self._axis(wo), wi), -1.0, 1.0))
        pdf = 1.0 / (2.0 * np.pi * (1.0 - np.cos(self._widest)))
        seen = (
            (dot(self.normal, wi) > 0.0)
            & (angle < self._widest)
            & (~np.array(self.glossy) | (dot(self.normal, wo) > 0.0))
        )
        pdf = np.where(seen, pdf, 0.0)
        fall = np.clip(1.0 - (angle - self.size) / np.maximum(self.smooth, 1e-12), 0.0, 1.0)
        return grey(pdf * np.where(angle < self.size, 1.0, fall)), pdf

    def direction(self, rng, wo):
        return uniform_cone(rng, self._axis(wo), 1.0 - np.cos(self._widest))


def add(builder, node, weight):
    """The lobe of a Toon node."""
    size = np.clip(builder.points.input(node, "size"), 1e-5, 1.0) * 0.5 * np.pi
    builder.lobes.append(
        Toon(
            weight * builder.color(node),
            builder.points.normal(node),
            size=size,
            smooth=builder.fraction(node, "smooth") * 0.5 * np.pi,
            glossy=node.settings.get("component") == "GLOSSY",
        )
    )


NODES = {"toon": add}
