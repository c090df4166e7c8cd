# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas of a material over arrays of points, with look-ups in the scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...graph.folding import Folding
from ...graph.formula import CONSTANT, Formula, Vector
from ...graph.functions import Function
from ...graph.numpy_evaluation import Inputs, evaluate_inputs
from ..ies import intensity
from ..images import Texture
from ..kernels.geometry import attribute_values
from ..material import NODES, Attribute, Material, Node, Table
from ..scene import Domain, Primitive, Projection
from ..sky import kernels
from . import probes
from .camera_rays import Camera
from .geometry import Placed, Surface
from .images import lookup
from .strands import NONE
from .vectors import normalize
from .voxels import Voxels

# Bump mapping takes differences over this fraction of a pixel, as in Blender, or over this many metres if a pixel's
# width is unknown.
BUMP_FILTER, BUMP_DISTANCE = 0.1, 1e-4


class Graph:
    """The closures of a material with numbers for its parameters; attributes, tables and textures become indices in
    lists. ``roots``: other formulas with its parameters."""

    def __init__(self, material: Material, roots: Sequence[Vector] = ()):
        self.places: list[Attribute | Table | Texture] = []
        numbers = []
        for value in material.parameters:
            if isinstance(value, (Attribute, Table, Texture)):
                self.places.append(value)
                value = len(self.places) - 1
            numbers.append(float(value) if np.isfinite(value) else 0.0)
        self._folding = Folding(numbers)
        self._nodes: dict[int, Node] = {}
        self.surface, self.normal = self._folded(material.surface), self._folded(material.normal)
        self.roots = [self._folded(root) for root in roots]
        self.formulas = list(dict.fromkeys(self._formulas()))

    def _folded(self, value):
        """A value of an input in which constant parts are constants."""
        if isinstance(value, Node):
            if id(value) not in self._nodes:
                inputs = {name: self._folded(entry) for name, entry in value.inputs.items()}
                self._nodes[id(value)] = Node(value.kind, inputs, value.settings)
            return self._nodes[id(value)]
        if isinstance(value, Vector):
            folded = tuple(map(self._folding.fold, value))
            constant = all(formula.kind == CONSTANT for formula in folded)
            return tuple(formula.value for formula in folded) if constant else Vector(*folded)
        if isinstance(value, Formula):
            folded = self._folding.fold(value)
            return folded.value if folded.kind == CONSTANT else folded
        return value

    def nodes(self) -> Iterator[Node]:
        """Every reachable closure."""
        pending, seen = [self.surface], set()
        while pending:
            node = pending.pop()
            if isinstance(node, Node) and id(node) not in seen:
                seen.add(id(node))
                yield node
                pending.extend(node.inputs.values())

    def _formulas(self) -> Iterator[Formula]:
        inputs = (value for node in self.nodes() for value in node.inputs.values())
        for value in [self.surface, self.normal, *self.roots, *inputs]:
            if isinstance(value, Vector):
                yield from value
            elif isinstance(value, Formula):
                yield value


class Points(Inputs):
    """Points on surfaces that share a material, and the values of its formulas there. Without ``rng`` nodes trace no
    rays."""

    def __init__(
        self,
        graph: Graph,
        surface: Surface,
        geometry: Placed,
        images: list,
        footprint: np.ndarray,
        rng: np.random.Generator | None = None,
    ):
        self.graph, self.surface, self.geometry, self.images = graph, surface, geometry, images
        self.count, self.rng = len(surface.distance), rng
        self.mesh = geometry.mesh_of[surface.instance]
        self.step = np.where(footprint > 0.0, BUMP_FILTER * footprint, BUMP_DISTANCE)
        self._values = dict(zip(graph.formulas, evaluate_inputs(graph.formulas, self)))

    # --- inputs of closures -------------------------------------------------------------------------------------------

    def input(self, node: Node, name: str) -> np.ndarray:
        """Values of an input, (N,) or (N, 3) like its default."""
        return self.value(node[name], 1 if isinstance(NODES[node.kind][name], float) else 3)

    def value(self, value, width: int) -> np.ndarray:
        """A formula, a vector or a number at all points: (N,) or (N, ``width``)."""
        if isinstance(value, Vector):
            array = np.stack([np.broadcast_to(self._values[formula], self.count) for formula in value], -1)
            return array if width == 3 else array.mean(-1)
        if isinstance(value, Formula):
            array = np.broadcast_to(self._values[value], self.count)
            return array if width == 1 else np.repeat(array[:, None], 3, 1)
        if isinstance(value, Node):  # a closure at a value input has no value: black
            value = 0.0
        array = np.asarray(value, float)
        return np.full(self.count, float(array.mean())) if width == 1 else np.broadcast_to(array, (self.count, 3))

    def normal(self, node: Node, name: str = "normal") -> np.ndarray:
        """Unit normals of an input; the shading normal if it has none."""
        if node[name] is None:
            return self.surface.ns
        return self.unit_or_own(self.value(node[name], 3))

    def unit_or_own(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (N, 3) as unit normals; the shading normal if they vanish."""
        given = normalize(vectors)
        square = (given * given).sum(-1)
        return np.where((square > 0.5)[:, None], given, self.surface.ns)

    # --- variables ----------------------------------------------------------------------------------------------------

    def variable(self, name: str, component: int) -> np.ndarray:
        surface = self.surface
        if name in ("dpdu", "dpdv"):
            return self.edges()[:, int(name == "dpdv"), component]
        values = {
            "position": surface.position,
            "incoming": surface.wo,
            "true_normal": surface.ng,
            "normal": surface.ns,
            "barycentric": surface.barycentric[:, 1:],
            "backfacing": surface.backfacing[:, None],
            "bump_step": self.step[:, None],
            "ray_length": surface.distance[:, None],
            "ray_kind": surface.ray_kind[:, None],
            "ray_singular": surface.ray_singular[:, None],
            "depth": surface.depth,
        }.get(name)
        if name == "object_normal":
            values = self._object_normal()
        return super().variable(name, component) if values is None else values[:, component].astype(float)

    def edges(self) -> np.ndarray:
        """World edges (N, 2, 3) of the triangles from their first vertex; the tangents of curves, and the directions
        across them."""
        surface = self.surface
        corners = self.geometry.corners[self.geometry.first[self.mesh] + surface.triangle]
        matrix = self.geometry.matrices[surface.instance][:, :3, :3]
        edges = np.einsum("nij,nkj->nki", matrix, corners[:, 1:] - corners[:, :1])
        if not self.geometry.strands.there:
            return edges
        flat = (surface.strand == Primitive.RIBBONS)[:, None]
        across = np.cross(surface.tangent, np.where(flat, surface.wo, surface.ng))
        round_ = (surface.number != NONE)[:, None, None]
        return np.where(round_, np.stack([surface.tangent, across], 1), edges)

    def _object_normal(self) -> np.ndarray:
        row = self.geometry.first[self.mesh] + self.surface.triangle
        smooth = np.einsum("nk,nkj->nj", self.surface.barycentric, self.geometry.normals[row])
        corners = self.geometry.corners[row]
        flat = normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        found = np.where(self.surface.smooth[:, None], smooth, flat)
        outside = self.surface.ng * np.where(self.surface.backfacing, -1.0, 1.0)[:, None]
        linear = self.geometry.matrices[self.surface.instance][:, :3, :3]
        of_strand = normalize(np.einsum("nji,nj->ni", linear, outside))
        return np.where((self.surface.number != NONE)[:, None], of_strand, found)

    # --- functions ----------------------------------------------------------------------------------------------------

    def call(self, function: Function, operands: list) -> tuple[np.ndarray, ...]:
        if not function.scene:
            return super().call(function, operands)
        operands = [np.broadcast_to(operand, self.count) for operand in operands]
        return tuple(getattr(self, "_" + function.name)(function.static, *operands))

    def _attribute(self, static, place, u, v):
        attribute = self.graph.places[int(place[0])]
        (missing_alpha,) = static
        result = np.broadcast_to([0.0, 0.0, 0.0, float(missing_alpha), 0.0], (self.count, 5)).copy()
        scene = self.geometry.scene
        for instance in np.unique(self.surface.instance):
            rows = self.surface.instance == instance
            mesh = scene.meshes[scene.instances[instance].mesh]
            found = scene.instances[instance].attributes.get(attribute) or attribute_values(mesh, attribute)
            if found is None:
                continue
            triangle = self.surface.triangle[rows]
            values = np.asarray(found.values, float)
            if found.domain == Domain.VERTEX:
                values = values[mesh.triangles[triangle]]
            elif found.domain == Domain.CORNER:
                values = values.reshape(len(mesh.triangles), 3, -1)[triangle]
            else:
                values = np.repeat(values[triangle if found.domain == Domain.TRIANGLE else triangle * 0][:, None], 3, 1)
            share = np.stack([1.0 - u[rows] - v[rows], u[rows], v[rows]], -1)
            values = np.einsum("nk,nkj->nj", share, values)
            result[rows, :4] = _four(values)
            result[rows, 4] = values[:, 0] if values.shape[1] <= 2 else values[:, :3].mean(1)
        return result.T

    def _attribute_here(self, static, place):
        return self._attribute((1,), place, *self.surface.barycentric[:, 1:].T)

    def _grid(self, static, place, *point):
        attribute, (mode,) = self.graph.places[int(place[0])], static
        inner, scene = np.stack(self._to_object_point((), *point), -1), self.geometry.scene
        result = np.zeros((self.count, 5))
        for instance in np.unique(self.surface.instance):
            found = scene.instances[instance].attributes.get(attribute)
            if found is None:
                continue
            rows, voxels = self.surface.instance == instance, Voxels(np.asarray(found.values)[0])
            values = voxels.between(inner[rows], mode)
            if voxels.channels == 4:
                alpha = values[:, 3:]
                values = np.where(alpha > 1e-6, values / np.where(alpha > 1e-6, alpha, 1.0), values)
                values[:, 3] = alpha[:, 0]
            result[rows, :4] = _four(values)
            result[rows, 4] = result[rows, :3].mean(1)
        return result.T

    def _moved(self, matrices: np.ndarray, vector, point: bool):
        matrix = matrices[self.surface.instance]
        moved = np.einsum("nij,nj->ni", matrix[:, :3, :3], np.stack(vector, -1))
        return (moved + matrix[:, :3, 3] * point).T

    def _to_object_point(self, static, *vector):
        return self._moved(np.linalg.inv(self.geometry.matrices), vector, True)

    def _to_object_vector(self, static, *vector):
        return self._moved(np.linalg.inv(self.geometry.matrices), vector, False)

    def _to_object_normal(self, static, *vector):
        return normalize(self._moved(self.geometry.matrices.transpose(0, 2, 1), vector, False).T).T

    def _from_object_point(self, static, *vector):
        return self._moved(self.geometry.matrices, vector, True)

    def _from_object_vector(self, static, *vector):
        return self._moved(self.geometry.matrices, vector, False)

    def _from_object_normal(self, static, *vector):
        return normalize(self._moved(np.linalg.inv(self.geometry.matrices).transpose(0, 2, 1), vector, False).T).T

    def _object_info(self, static):
        used, place = np.unique(self.surface.instance, return_inverse=True)
        instances = [self.geometry.scene.instances[index] for index in used]
        rows = [(*np.asarray(i.matrix)[:3, 3], *i.color, i.index, i.random) for i in instances]
        return np.array(rows, float).reshape(-1, 9)[place.ravel()].T

    def _sizes(self, corner: int) -> tuple[np.ndarray, np.ndarray]:
        """Radii (N,) of curves or spheres at a vertex of what was hit, in local space; the factor (N,) to the world, of
        a diagonal."""
        surface, radius, factor = self.surface, np.zeros(self.count), np.ones(self.count)
        curved = surface.number != NONE
        for index in np.unique(surface.instance[curved]):
            rows = np.flatnonzero(curved & (surface.instance == index))
            mesh = self.geometry.scene.meshes[self.geometry.mesh_of[index]]
            radius[rows] = np.asarray(mesh.radii, float)[mesh.triangles[surface.triangle[rows], corner]]
            factor[rows] = np.linalg.norm(self.geometry.matrices[index][:3, :3].sum(1)) / np.sqrt(3.0)
        return radius, factor

    def _strand_info(self, static):
        surface, (first, factor) = self.surface, self._sizes(0)
        thickness = 2.0 * (first + surface.barycentric[:, 1] * (self._sizes(1)[0] - first))
        tangent, wo = surface.tangent, surface.wo
        square = np.maximum((tangent * tangent).sum(1), 1e-300)
        across = normalize(wo - ((tangent * wo).sum(1) / square)[:, None] * tangent)
        values = [np.ones(self.count), thickness * (factor if static[0] else 1.0), *across.T]
        return np.array(values) * (surface.strand > 0)

    def _point_info(self, static):
        surface, (radius, factor) = self.surface, self._sizes(0)
        corners = self.geometry.corners[self.geometry.first[self.mesh] + surface.triangle]
        (center,) = np.moveaxis(corners[:, :1], 1, 0)
        matrix = self.geometry.matrices[surface.instance]
        center = np.einsum("nij,nj->ni", matrix[:, :3, :3], center) + matrix[:, :3, 3]
        return np.array([*center.T, radius * factor]) * ((surface.number != NONE) & (surface.strand == 0))

    def _seen(self, *vector):
        """In the view of the camera: x to the right, y up, z into the picture."""
        matrix = np.asarray(self.geometry.scene.camera.matrix, float)[:3, :3]
        return (np.stack(vector, -1) @ matrix * (1.0, 1.0, -1.0)).T

    def _to_camera_vector(self, static, *vector):
        return self._camera_axes() @ self._seen(*vector)

    def _camera_axes(self) -> np.ndarray:
        """(3, 3) from the result of ``_seen`` to the camera space of nodes."""
        projection = self.geometry.scene.camera.projection
        if projection is Projection.MIRROR_BALL:
            return np.array([(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)])
        if projection not in (Projection.PERSPECTIVE, Projection.ORTHOGRAPHIC):
            return np.array([(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
        return np.eye(3)

    def _to_camera_point(self, static, *point):
        matrix = np.asarray(self.geometry.scene.camera.matrix, float)
        return self._to_camera_vector(static, *(axis - offset for axis, offset in zip(point, matrix[:3, 3])))

    def _from_camera_vector(self, static, x, y, z):
        matrix = np.asarray(self.geometry.scene.camera.matrix, float)[:3, :3]
        x, y, z = self._camera_axes().T @ np.stack(np.broadcast_arrays(x, y, z))
        return (np.stack([x, y, -z], -1) @ matrix.T).T

    def _from_camera_point(self, static, x, y, z):
        matrix = np.asarray(self.geometry.scene.camera.matrix, float)
        return self._from_camera_vector(static, x, y, z) + matrix[:3, 3:]

    def _to_window(self, static, *point):
        position = np.asarray(self.geometry.scene.camera.matrix, float)[:3, 3]
        seen = self._seen(*(axis - offset for axis, offset in zip(point, position))).T
        x, y = Camera(self.geometry.scene).window_place(seen * (1.0, 1.0, -1.0))
        return x, y, np.zeros(self.count)

    def _table(self, static, start, rows, position):
        columns, extrapolates = static
        values = _four(np.asarray(self.graph.places[int(start[0])].values, float).reshape(-1, columns))
        x = position * (len(values) - 1)
        inside = np.clip(x, 0.0, len(values) - 1.0)
        row = np.minimum(inside.astype(int), len(values) - 2)
        share = (x if extrapolates else inside) - row
        return (values[row] + share[:, None] * (values[row + 1] - values[row])).T

    def _image(self, static, place, u, v):
        used = place >= 0.0
        result = np.zeros((self.count, 4))
        if used.any():
            texture = self.graph.places[int(place[used][0])]
            result[used] = lookup(self.images, texture, u[used], v[used])
        return result.T

    def _sky(self, static, place, x, y, z):
        kind, with_sun = static
        result = np.empty((self.count, 3))
        values = np.ravel(self.graph.places[int(place[0])].values)
        kernels.fill(kind, bool(with_sun), values, np.stack([x, y, z], -1), result)
        return result.T

    def _ies(self, static, place, x, y, z):
        values = np.ravel(self.graph.places[int(place[0])].values)
        return (np.array([intensity(values, 0, direction) for direction in zip(x, y, z)], float),)

    def _wireframe(self, static, *point):
        corners = self.geometry.corners[self.geometry.first[self.mesh] + self.surface.triangle]
        matrix = self.geometry.matrices[self.surface.instance]
        corners = np.einsum("nij,nkj->nki", matrix[:, :3, :3], corners) + matrix[:, None, :3, 3]
        to = np.stack(point, -1)[:, None] - corners
        along = normalize((np.roll(corners, -1, 1) - corners).reshape(-1, 3)).reshape(-1, 3, 3)
        across = to - (to * along).sum(-1, keepdims=True) * along
        return (np.linalg.norm(across, axis=-1).min(1),)

    def _occlusion(self, static, distance, samples, *direction):
        if self.rng is None:
            return (np.ones(self.count),)
        return (
            probes.occlusion(
                self.geometry,
                self.surface,
                self.rng,
                bool(static[0]),
                distance,
                samples,
                normalize(np.stack(direction, -1)),
            ),
        )

    def _bevel(self, static, radius, samples, *normal):
        own = np.stack(normal, -1)
        return (
            own if self.rng is None else probes.bevel(self.geometry, self.surface, self.rng, radius, samples, own)
        ).T

    def _raycast(self, static, x, y, z, dx, dy, dz, distance, *place):
        if self.rng is None:
            return np.concatenate([np.zeros((2, self.count)), distance[None], np.zeros((7, self.count))])
        shift = np.linalg.norm(np.stack(place, -1) - self.surface.position, axis=-1)
        return probes.raycast(
            self.geometry,
            self.surface,
            bool(static[0]),
            np.stack([x, y, z], -1),
            np.stack([dx, dy, dz], -1),
            distance,
            shift,
        )


def _four(values: np.ndarray) -> np.ndarray:
    """(N, 4) from (N, 1 to 4): a single number is grey, and a missing alpha is 1."""
    count, width = values.shape
    if width == 4:
        return values
    if width == 1:
        return np.concatenate([np.repeat(values, 3, 1), np.ones((count, 1))], 1)
    return np.concatenate([values, np.zeros((count, 3 - width)), np.ones((count, 1))], 1)
