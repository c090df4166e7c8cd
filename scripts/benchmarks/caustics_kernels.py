# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths for caustics: vertices that light has reached by mirrors and glass alone, and pictures of these.

Light paths of the program leave a lamp in all directions. Aimed ones leave it towards a ball around the mirror or
glass.
"""

from __future__ import annotations

import math

import host
import numpy as np

from sdf_lights.jit import kernel
from sdf_lights.render.kernels.camera import camera_ray, camera_table, pixel_of, view_depth
from sdf_lights.render.kernels.geometry import find_surface, surface_at, surface_table
from sdf_lights.render.kernels.light_paths.records import PLACE, VERTEX
from sdf_lights.render.kernels.light_paths.trace import _mirrored, _scattered, _start, trace_light_paths
from sdf_lights.render.kernels.path import CAMERA
from sdf_lights.render.kernels.ray_origins import clear_self_primitive, spawn_ray
from sdf_lights.render.kernels.rays import SHADOW_OPAQUE, hit_instance, intersect, occluded, ray_table, start_anew
from sdf_lights.render.kernels.samplers import get_2d, get_3d, pixel_seed
from sdf_lights.render.kernels.shading import evaluate, sample, shade
from sdf_lights.render.kernels.shading.records import DIFFUSE, SCATTERED, SINGULAR
from sdf_lights.render.kernels.visibility import shadow_ray
from sdf_lights.render.kernels.workspace import secondary_table
from sdf_lights.vec import dot, frame, length, mul, negate, put, scale, sub, to_world, vec

ALIKE = 0.9  # cosine of normals of one surface
FIRST_SET = 2  # of random numbers at surfaces, as in ``trace_light_paths``


@kernel
def _aimed(origin, center, radius, u):
    """A direction from outside a ball to it, and the fraction of all directions that it is drawn from."""
    way = sub(center, origin)
    distance = length(way)
    axis = scale(way, 1.0 / distance)
    least = math.sqrt(1.0 - (radius / distance) ** 2)
    t, b = frame(axis)
    z, phi = 1.0 - u[0] * (1.0 - least), 2.0 * math.pi * u[1]
    s = math.sqrt(max(1.0 - z * z, 0.0))
    return to_world((s * math.cos(phi), s * math.sin(phi), z), t, b, axis), 0.5 * (1.0 - least)


@kernel
def _trace_aimed(block, workspace, index, total, seed, center, radius, vertex):
    """Follow a light path of an SDF lamp over mirrors and glass to something else, the ``vertex``; 1 if it is there."""
    surface, secondary = surface_table(workspace)[0], secondary_table(workspace)[0]
    clear_self_primitive(ray_table(workspace)[0])
    _, origin, _, flux, _ = _start(block, workspace, index, total, seed)
    direction, fraction = _aimed(origin, center, radius, get_2d(index, seed, 1))
    flux = scale(flux, fraction)
    for scatters in range(1, block.max_bounces + 1):
        start_anew(block, workspace)
        if not intersect(block, workspace, origin, direction, 0.0, np.inf, DIFFUSE):
            return 0
        ray, wi = ray_table(workspace)[0], negate(direction)
        instance, primitive, u, v = hit_instance(ray), np.int64(ray.primitive), float(ray.u), float(ray.v)
        find_surface(block, workspace, wi, DIFFUSE, 0.0)
        shade(block, workspace)
        if surface.evaluable > 0:
            put(vertex.position, vec(surface.position))
            put(vertex.normal, vec(surface.ng))
            put(vertex.wi, wi)
            put(vertex.flux, flux)
            vertex.instance, vertex.primitive, vertex.u, vertex.v = instance, primitive, u, v
            return int(scatters > 1)
        numbers = get_3d(index, seed, FIRST_SET + scatters)
        direction, _, pdf, _, kind = sample(block, workspace, numbers[0], numbers[1], numbers[2])
        if pdf <= 0.0 or kind & SINGULAR == 0:
            return 0
        _, pdf, _ = _mirrored(workspace, direction)
        if pdf <= 0.0:
            return 0
        origin = spawn_ray(workspace, surface, direction)
        # The way of a path from the camera, which the BSDF is for.
        surface_at(block, surface_table(secondary)[0], instance, primitive, u, v, direction, DIFFUSE, 0.0)
        shade(block, secondary)
        factor, _ = _scattered(block, secondary, wi, kind, pdf)
        flux = mul(flux, factor)
    return 0


@kernel
def trace_aimed(block, workspace, total, number, center, radius, raw, lengths):
    """As ``trace_light_paths``: so many light paths towards a ball, with one vertex each at most."""
    scene, scratch = block[0], workspace[0]
    seed, middle = pixel_seed(PLACE + number, PLACE + 2, scene.seed), vec(center)
    for index in range(total):
        lengths[index] = _trace_aimed(scene, scratch, index, total, seed, middle, radius, raw[index])


@kernel
def connect_to_camera(block, workspace, vertices, picture):
    """Add the light of ``vertices`` that a pinhole camera sees to the ``picture`` (height, width, RGB).

    A vertex is seen from one direction alone. The value of a pixel is the mean over its area A on the window, one metre
    before the camera. So the light of the vertex counts as cos_y / (d² A cos³) of its flux, with the angle to the axis.
    """
    scene, scratch = block[0], workspace[0]
    camera, surface = camera_table(scene)[0], surface_table(scratch)[0]
    eye = camera.matrix[0, 3], camera.matrix[1, 3], camera.matrix[2, 3]
    for index in range(len(vertices)):
        vertex = vertices[index]
        y, normal, wi = vec(vertex.position), vec(vertex.normal), vec(vertex.wi)
        px, py = pixel_of(camera, y, False)
        depth = view_depth(scene, y)
        if depth <= 0.0 or not (0.0 <= px < picture.shape[1] and 0.0 <= py < picture.shape[0]):
            continue
        way = sub(eye, y)
        distance = length(way)
        wo = scale(way, 1.0 / distance)
        cosine = dot(normal, wo)
        if cosine <= 0.0:
            continue
        surface_at(scene, surface, vertex.instance, vertex.primitive, vertex.u, vertex.v, wo, CAMERA, 0.0)
        shade(scene, scratch)
        value, _, _ = evaluate(scene, scratch, wi, SCATTERED)
        start = spawn_ray(scratch, surface, wo)
        direction, t_max = shadow_ray(y, start, wo, distance)
        start_anew(scene, scratch)
        if occluded(scene, scratch, start, direction, 0.0, t_max, SHADOW_OPAQUE):
            continue
        area = camera.step[0] * camera.step[1] * (depth / distance) ** 3
        light = scale(mul(value, vec(vertex.flux)), cosine / (distance * distance * abs(dot(normal, wi)) * area))
        for channel in range(3):
            picture[int(py), int(px), channel] += light[channel]


@kernel
def merge_at_first_hits(block, workspace, number, vertices, radius, picture, diffuse):
    """Add the light of ``vertices``, sorted by x, within the ``radius`` of what a random ray through each pixel meets;
    and note whether that is ``diffuse``."""
    scene, scratch = block[0], workspace[0]
    surface, seed = surface_table(scratch)[0], pixel_seed(PLACE + number, PLACE + 1, scene.seed)
    for index in range(picture.shape[0] * picture.shape[1]):
        row, column = index // picture.shape[1], index % picture.shape[1]
        u = get_2d(index, seed, 0)
        origin, direction, t_min, t_max = camera_ray(scene, column + u[0], row + u[1], 0.5, 0.5)
        clear_self_primitive(ray_table(scratch)[0])
        start_anew(scene, scratch)
        if not intersect(scene, scratch, origin, direction, t_min, t_max, CAMERA):
            continue
        find_surface(scene, scratch, negate(direction), CAMERA, 0.0)
        shade(scene, scratch)
        if surface.evaluable == 0:
            continue
        diffuse[row, column] = 1
        x, normal = vec(surface.position), vec(surface.ng)
        first, last = 0, len(vertices)
        while first < last:
            middle = (first + last) // 2
            if vertices[middle].position[0] < x[0] - radius:
                first = middle + 1
            else:
                last = middle
        while first < len(vertices) and vertices[first].position[0] <= x[0] + radius:
            vertex = vertices[first]
            first += 1
            way = sub(vec(vertex.position), x)
            cosine = abs(dot(normal, vec(vertex.wi)))
            if dot(way, way) > radius * radius or dot(normal, vec(vertex.normal)) < ALIKE or cosine <= 0.0:
                continue
            value, _, _ = evaluate(scene, scratch, vec(vertex.wi), SCATTERED)
            light = scale(mul(value, vec(vertex.flux)), 1.0 / (cosine * math.pi * radius * radius))
            for channel in range(3):
                picture[row, column, channel] += light[channel]


class Tracer:
    """Light paths of the scene of a dependency graph, on one thread."""

    def __init__(self, depsgraph):
        block, light_paths = host.program("render.cpu.block"), host.program("render.cpu.light_paths")
        scene = host.program("blender.sync").sync(depsgraph)
        self.height, self.width = scene.height, scene.width
        self._packed = block.PackedScene(scene, host.program("render.film").Film(scene, ()))
        self._workspace = block.Workspace(self._packed)
        found = light_paths.LightPaths.of(scene, self._packed, [self._workspace])
        assert found is not None, "this scene cannot have light paths"

    def _call(self, kernel, *arguments) -> None:
        kernel(self._workspace.scene, self._workspace.block, *arguments)

    def pixel_width(self, distance: float) -> float:
        """Metres that a pixel spans at this distance."""
        return distance * float(self._packed.block[0]["camera_pixel_angle"])

    def vertices(self, number: int, paths: int) -> np.ndarray:
        """Vertices of so many light paths that something has scattered, but nothing except mirrors and glass."""
        raw, lengths = np.empty(paths, VERTEX), np.zeros(paths, np.int64)
        # Mirrors and glass leave no vertices, so these are first ones.
        self._call(trace_light_paths, 0, paths, paths, number, 1, raw, lengths)
        found = raw[lengths > 0]
        return _sorted(found[found["scatters"] > 1])

    def aimed_vertices(self, number: int, paths: int, center: np.ndarray, radius: float) -> np.ndarray:
        """The same of light paths towards a ball."""
        raw, lengths = np.empty(paths, VERTEX), np.zeros(paths, np.int64)
        self._call(trace_aimed, paths, number, center, radius, raw, lengths)
        return _sorted(raw[lengths > 0])

    def connect(self, vertices: np.ndarray) -> np.ndarray:
        """The caustic (height, width, RGB) by connections to the camera."""
        picture = np.zeros((self.height, self.width, 3))
        self._call(connect_to_camera, vertices, picture)
        return picture

    def merge(self, number: int, vertices: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
        """The caustic by merging, and which pixels show something that is diffuse."""
        picture, diffuse = np.zeros((self.height, self.width, 3)), np.zeros((self.height, self.width), np.int64)
        self._call(merge_at_first_hits, number, vertices, radius, picture, diffuse)
        return picture, diffuse > 0


def _sorted(vertices: np.ndarray) -> np.ndarray:
    return vertices[np.argsort(vertices["position"][:, 0])]
