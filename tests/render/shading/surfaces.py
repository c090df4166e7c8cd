# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One surface under test: a material packed into a block, a workspace, and loops over the shading kernels.

These kernels are not cached on disk: the cache does not see changes in what a file outside the package imports.
"""

import math

import numpy as np
from scipy.stats import qmc

from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.kernels import geometry
from sdf_lights.render.kernels.shading import (
    SCALARS,
    TABLES,
    WORKSPACE_COUNTS,
    WORKSPACE_TABLES,
    evaluate,
    pack_materials,
    sample,
    shade,
    special,
    transparency,
)
from sdf_lights.render.kernels.shading.records import DIFFUSE, GLOSSY, TRANSMISSION, surface_table
from sdf_lights.render.material import Material
from sdf_lights.render.scene import Image, Instance, Mesh, Scene
from sdf_lights.vec import add, dot, madd, mul, negate, normalize, scale, vec

MAX_BOUNCES = 64
SCATTERED = DIFFUSE | GLOSSY | TRANSMISSION
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def refracts(wo: np.ndarray, wi: np.ndarray, normal: np.ndarray, ior: float) -> np.ndarray:
    """Where (N,) microfacets of a surface that wo (3,) sees can reflect or refract it to ``wi`` (N, 3). Beyond, as in
    Cycles, only light rays find light."""
    h = wo + ior * wi
    ahead = h @ wo
    return (wi @ normal >= 0.0) | (ahead * (h * wi).sum(1) < 0.0) & (ahead * (h @ normal) > 0.0)


@kernel
def _draw(block, workspace, u, wi, value, pdf, kind):
    for i in range(len(u)):
        d, f, pdf[i], _, kind[i] = sample(block, workspace, u[i, 0], u[i, 1], u[i, 2])
        for axis in range(3):
            wi[i, axis] = d[axis]
            value[i, axis] = f[axis]


@kernel
def _evaluate(block, workspace, wi, value, pdf):
    for i in range(len(wi)):
        f, pdf[i], _ = evaluate(block, workspace, (wi[i, 0], wi[i, 1], wi[i, 2]), SCATTERED)
        for axis in range(3):
            value[i, axis] = f[axis]


@kernel
def _shade_sphere(block, workspace, p, d):
    """Shade the point p of a unit sphere, which a ray of direction d has met."""
    surface = surface_table(workspace)[0]
    inside = dot(d, p) > 0.0
    n = negate(p) if inside else p
    for axis in range(3):
        surface.n[axis] = surface.ng[axis] = n[axis]
        surface.wo[axis] = -d[axis]
    surface.radial[0], surface.radial[1], surface.radial[2] = -p[1], p[0], 0.0
    surface.backfacing = int(inside)
    shade(block, workspace)


@kernel
def _sphere_radiance(block, workspace, x, y):
    """Radiance along −z through (x, y) of a unit sphere in a world of radiance 1."""
    surface = surface_table(workspace)[0]
    p, d = (x, y, math.sqrt(1.0 - x * x - y * y)), (0.0, 0.0, -1.0)
    throughput, radiance = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    for _ in range(MAX_BOUNCES):
        _shade_sphere(block, workspace, p, d)
        radiance = add(radiance, mul(throughput, vec(surface.emission)))
        d, value, pdf, _, _ = sample(block, workspace, np.random.random(), np.random.random(), np.random.random())
        if pdf == 0.0:
            break
        throughput = mul(throughput, scale(value, 1.0 / pdf))
        if dot(d, p) > 0.0:
            return add(radiance, throughput)
        p = normalize(madd(p, -2.0 * dot(p, d), d))
    return radiance


@kernel
def _lit_radiance(block, workspace, x, y, wi):
    """The same of a sphere that a sun of irradiance π lights from wi, after one reflection."""
    p = (x, y, math.sqrt(1.0 - x * x - y * y))
    _shade_sphere(block, workspace, p, (0.0, 0.0, -1.0))
    if dot(p, wi) <= 0.0:
        return (0.0, 0.0, 0.0)
    value, _, _ = evaluate(block, workspace, wi, SCATTERED)
    return scale(value, math.pi)


@kernel
def _sphere(block, workspace, count, seed, wi):
    np.random.seed(seed)
    total = (0.0, 0.0, 0.0)
    for i in range(count):
        radius, phi = math.sqrt((i + np.random.random()) / count), 2.0 * math.pi * GOLDEN * i
        x, y = radius * math.cos(phi), radius * math.sin(phi)
        if wi == (0.0, 0.0, 0.0):
            total = add(total, _sphere_radiance(block, workspace, x, y))
        else:
            total = add(total, _lit_radiance(block, workspace, x, y, wi))
    return scale(total, 1.0 / count)


class Surface:
    """A material on a triangle with normal z. ``images``: (h, w, 4) arrays; ``parameters``: those of the material's
    formulas; ``tangent``: the triangle's; ``matrix``: (4, 4) of its instance."""

    def __init__(self, node, images=(), parameters=(), tangent=None, matrix=np.eye(4)):
        mesh = Mesh("triangle", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
        if tangent is not None:
            mesh.tangents[""] = np.tile(np.float32(tangent), (1, 3, 1))
        self.scene = Scene(
            camera=None,
            width=1,
            height=1,
            materials=[Material("test", node, parameters=list(parameters))],
            meshes=[mesh],
            instances=[Instance(0, np.array(matrix, float), (0,))],
            images=[Image(f"image {index}", pixels) for index, pixels in enumerate(images)],
        )
        materials, self.graphs = pack_materials(self.scene)
        self.tables = materials | geometry.pack_geometry(self.scene, np.array([False]))
        self.work = {name: np.zeros(WORKSPACE_COUNTS[name], dtype) for name, dtype in WORKSPACE_TABLES.items()}
        records = block_dtype(TABLES | geometry.TABLES, SCALARS), block_dtype(WORKSPACE_TABLES)
        self.tables["graph_addresses"] = self.graphs.addresses(records)
        self.tables["special_code"] = special.addresses(self.tables["lobes"], records)
        self._block, self._workspace = (np.zeros(1, record) for record in records)
        for name, table in self.tables.items():
            fill_table(self._block, name, table)
        for name, table in self.work.items():
            fill_table(self._workspace, name, table)
        self._block["caustics"] = GLOSSY | TRANSMISSION
        self.block, self.workspace = self._block[0], self._workspace[0]
        self.hit = self.work["surface"][0]
        self.hit["n"] = self.hit["ng"] = self.hit["wo"] = (0.0, 0.0, 1.0)
        self.hit["dpdu"], self.hit["dpdv"] = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        self.hit["object_normal"] = (0.0, 0.0, 1.0)
        self.hit["bump_step"] = 1e-4

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
        _draw(self.block, self.workspace, np.ascontiguousarray(u), *result)
        return result

    def evaluate(self, wi):
        value, pdf = np.zeros((len(wi), 3)), np.zeros(len(wi))
        _evaluate(self.block, self.workspace, np.ascontiguousarray(wi), value, pdf)
        return value, pdf

    def albedo(self, power=15, seed=1):
        """Directional albedo (RGB) by 2**power Sobol samples."""
        _, value, pdf, _ = self.draw(qmc.Sobol(3, seed=seed).random_base2(power))
        return np.sum(value / np.where(pdf > 0.0, pdf, np.inf)[:, None], axis=0) / 2**power

    def sphere(self, count=200_000, seed=1, light=None):
        """Mean radiance of a sphere's disk in a white world, or lit by a sun of strength π in the direction ``light``,
        once."""
        wi = (0.0, 0.0, 0.0) if light is None else tuple(float(x) for x in np.divide(light, np.linalg.norm(light)))
        return np.array(_sphere(self.block, self.workspace, count, seed, wi))
