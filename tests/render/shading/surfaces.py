# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One surface under test: a material packed into a block, a workspace, and loops over the shading kernels.

These kernels are not cached on disk: the cache does not see changes in what a file outside the package imports.
"""

import math

import numpy as np
from scipy.stats import qmc

from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.cpu.shading import (
    TABLES, WORKSPACE_COUNTS, WORKSPACE_TABLES, evaluate, pack_materials, sample, shade, transparency)
from sdf_lights.render.cpu.shading.records import surface_table
from sdf_lights.render.material import Material
from sdf_lights.render.scene import Image, Scene
from sdf_lights.vec import add, dot, madd, mul, negate, normalize, scale, vec

MAX_BOUNCES = 64


@kernel(cache=False)
def _draw(workspace, u, wi, value, pdf, kind):
    for i in range(len(u)):
        d, f, pdf[i], _, kind[i] = sample(workspace, u[i, 0], u[i, 1], u[i, 2])
        for axis in range(3):
            wi[i, axis] = d[axis]
            value[i, axis] = f[axis]


@kernel(cache=False)
def _evaluate(workspace, wi, value, pdf):
    for i in range(len(wi)):
        f, pdf[i], _ = evaluate(workspace, (wi[i, 0], wi[i, 1], wi[i, 2]))
        for axis in range(3):
            value[i, axis] = f[axis]


@kernel(cache=False)
def _sphere_radiance(block, workspace, x, y):
    """Radiance along −z through (x, y) of a unit sphere in a world of radiance 1."""
    surface = surface_table(workspace)[0]
    p, d = (x, y, math.sqrt(1.0 - x * x - y * y)), (0.0, 0.0, -1.0)
    throughput, radiance = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    for _ in range(MAX_BOUNCES):
        inside = dot(d, p) > 0.0
        n = negate(p) if inside else p
        for axis in range(3):
            surface.n[axis] = surface.ng[axis] = n[axis]
            surface.wo[axis] = -d[axis]
        surface.backfacing = int(inside)
        shade(block, workspace)
        radiance = add(radiance, mul(throughput, vec(surface.emission)))
        d, value, pdf, _, _ = sample(workspace, np.random.random(), np.random.random(), np.random.random())
        if pdf == 0.0:
            break
        throughput = mul(throughput, scale(value, 1.0 / pdf))
        if dot(d, p) > 0.0:
            return add(radiance, throughput)
        p = normalize(madd(p, -2.0 * dot(p, d), d))
    return radiance


@kernel(cache=False)
def _sphere(block, workspace, count, seed):
    np.random.seed(seed)
    total = (0.0, 0.0, 0.0)
    for i in range(count):
        radius, phi = math.sqrt((i + np.random.random()) / count), 2.0 * math.pi * np.random.random()
        total = add(total, _sphere_radiance(block, workspace, radius * math.cos(phi), radius * math.sin(phi)))
    return scale(total, 1.0 / count)


class Surface:
    """A material on a surface with normal z. ``images``: (h, w, 4) arrays."""

    def __init__(self, node, images=()):
        self.scene = Scene(
            camera=None, width=1, height=1, materials=[Material("test", node)],
            images=[Image(f"image {index}", pixels) for index, pixels in enumerate(images)])
        self.tables = pack_materials(self.scene)
        self.work = {name: np.zeros(WORKSPACE_COUNTS[name], dtype) for name, dtype in WORKSPACE_TABLES.items()}
        self._block, self._workspace = np.zeros(1, block_dtype(TABLES)), np.zeros(1, block_dtype(WORKSPACE_TABLES))
        for name, table in self.tables.items():
            fill_table(self._block, name, table)
        for name, table in self.work.items():
            fill_table(self._workspace, name, table)
        self.block, self.workspace = self._block[0], self._workspace[0]
        self.hit = self.work["surface"][0]
        self.hit["n"] = self.hit["ng"] = self.hit["wo"] = (0.0, 0.0, 1.0)
        self.hit["dpdu"], self.hit["dpdv"] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        self.hit["uv_du"][:], self.hit["uv_dv"][:] = (1.0, 0.0), (0.0, 1.0)
        self.hit["object_normal"] = (0.0, 0.0, 1.0)
        self.hit["world_to_object"][:, :3] = np.eye(3)

    @property
    def record(self):
        """The packed material."""
        return self.tables["materials"][0]

    @property
    def closures(self):
        return self.work["closures"][: self.hit["closure_count"]]

    def shade(self, cosine=None, backfacing=False, **fields):
        """Shade, seen under ``cosine``; ``fields`` are set first."""
        if cosine is not None:
            self.hit["wo"] = (math.sqrt(1.0 - cosine * cosine), 0.0, cosine)
        self.hit["backfacing"] = backfacing
        for name, value in fields.items():
            self.hit[name] = value
        shade(self.block, self.workspace)
        return self

    def transparency(self):
        return np.array(transparency(self.block, self.workspace))

    def draw(self, u):
        """wi (n, 3), f·|cos| (n, 3), pdf (n,), kind (n,) for the numbers u (n, 3)."""
        n = len(u)
        result = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n, np.int64)
        _draw(self.workspace, np.ascontiguousarray(u), *result)
        return result

    def evaluate(self, wi):
        value, pdf = np.zeros((len(wi), 3)), np.zeros(len(wi))
        _evaluate(self.workspace, np.ascontiguousarray(wi), value, pdf)
        return value, pdf

    def albedo(self, power=15, seed=1):
        """Directional albedo (RGB) by 2**power Sobol samples."""
        _, value, pdf, _ = self.draw(qmc.Sobol(3, seed=seed).random_base2(power))
        return np.sum(value / np.where(pdf > 0.0, pdf, np.inf)[:, None], axis=0) / 2**power

    def sphere(self, count=200_000, seed=1):
        """Mean radiance of a sphere's disk in a white world."""
        return np.array(_sphere(self.block, self.workspace, count, seed))
