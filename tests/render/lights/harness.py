# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of the lights' tables alone, and the lights' kernels over arrays.

The kernels here are not cached: the cache follows the imports of the package alone, so one of a test would outlive a
change of what it calls.
"""

import numpy as np

from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.kernels import lights
from sdf_lights.render.scene import Camera, Ray, Scene

UP = (0.0, 0.0, 1.0)
NONE = (0.0, 0.0, 0.0)


def place(x=0.0, y=0.0, z=0.0, axis=None, scale=(1.0, 1.0, 1.0)):
    """Matrix of an object at (x, y, z) whose local z is ``axis``."""
    matrix = np.eye(4)
    if axis is not None:
        w = np.asarray(axis, float) / np.linalg.norm(axis)
        u = np.cross(np.eye(3)[np.argmin(np.abs(w))], w)
        u /= np.linalg.norm(u)
        matrix[:3, :3] = np.stack([u, np.cross(w, u), w], axis=1)
    matrix[:3, :3] *= scale
    matrix[:3, 3] = x, y, z
    return matrix


def scene_of(*members, **fields):
    scene = Scene(camera=Camera(np.eye(4)), width=1, height=1, **fields)
    scene.lights += members
    return scene


class Packed:
    """The tables of a scene's lights and a block that points at them."""

    def __init__(self, scene, **arguments):
        self.tables = lights.pack_lights(scene, **arguments)
        self.blocks = np.zeros(1, block_dtype(lights.TABLES))
        self._cuts = np.zeros(1, lights.WORKSPACE_TABLES["light_cut"])
        for name, array in self.tables.items():
            fill_table(self.blocks, name, array)

    def sample(self, emitter, x, u, n=NONE, dark=False):
        """(wi, distance, radiance, pdf, singular) as arrays, from one point x or a point for each of ``u``; wi is NaN
        where the sample carries no light, unless ``dark`` keeps directions of radiance 0."""
        wi, radiance = np.empty((len(u), 3)), np.empty((len(u), 3))
        distance, pdf, singular = np.empty(len(u)), np.empty(len(u)), np.empty(len(u), bool)
        _sample(self.blocks, emitter, _each(x, len(u)), n, u, wi, distance, radiance, pdf, singular)
        wi[~(pdf > 0.0) | ~((radiance.max(axis=1) > 0.0) | dark)] = np.nan
        return wi, distance, radiance, pdf, singular

    def hits(self, emitter, x, d, t_max=np.inf, kind=int(Ray.ALL)):
        """(distance, radiance, pdf) of the rays x + t d at one light, zero where they miss it; x as for ``sample``."""
        out = np.zeros((len(d), 5))
        rows = np.zeros(lights.hit_capacity(self.tables), lights.HIT)
        _hits(self.blocks, emitter, _each(x, len(d)), np.ascontiguousarray(d), t_max, kind, rows, out)
        return out[:, 0], out[:, 1:4], out[:, 4]

    def leave(self, emitter, u):
        """(origin, direction, flux, reach) of the rays that leave a light; u (n, 4)."""
        out = np.zeros((len(u), 10))
        _leave(self.blocks, emitter, u, out)
        return out[:, :3], out[:, 3:6], out[:, 6:9], out[:, 9]

    def select(self, x, n, u):
        """(emitter, probability, remapped u) as arrays."""
        out = np.empty((len(u), 3))
        _select(self.blocks, tuple(map(float, x)), n, u, self._cuts, out)
        return out[:, 0].astype(int), out[:, 1], out[:, 2]

    def probabilities(self, x, n, count=None):
        out = np.empty(len(self.tables["light_emitters"]) if count is None else count)
        _probabilities(self.blocks, tuple(map(float, x)), n, self._cuts, out)
        return out

    def world(self, d, n=NONE, x=NONE):
        """Radiance and pdf of the world in directions d."""
        radiance, pdf = np.empty((len(d), 3)), np.empty(len(d))
        _world(self.blocks, tuple(map(float, x)), n, np.ascontiguousarray(d), radiance, pdf)
        return radiance, pdf


def _each(x, count):
    return np.ascontiguousarray(np.broadcast_to(np.asarray(x, float), (count, 3)))


def grid(side):
    """Midpoints of side² equal squares."""
    u = (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2)


def irradiance(packed, emitter, x, n, side=256):
    """∫ L max(n·ω, 0) dω by sampling the light on a regular grid of random numbers."""
    wi, _, radiance, pdf, _ = packed.sample(emitter, x, grid(side), n)
    lit = np.isfinite(wi[:, 0])
    value = np.zeros(len(wi))
    value[lit] = radiance[lit, 0] * np.maximum(wi[lit] @ np.asarray(n), 0.0) / pdf[lit]
    return value.mean()


@kernel
def _sample(blocks, emitter, x, n, u, wi, distance, radiance, pdf, singular):
    for i in range(len(u)):
        at = (x[i, 0], x[i, 1], x[i, 2])
        w, distance[i], r, pdf[i], singular[i] = lights.sample_light(blocks[0], emitter, at, n, u[i, 0], u[i, 1])
        wi[i, 0], wi[i, 1], wi[i, 2] = w
        radiance[i, 0], radiance[i, 1], radiance[i, 2] = r


@kernel
def _hits(blocks, emitter, x, d, t_max, kind, rows, out):
    for i in range(len(d)):
        at, direction = (x[i, 0], x[i, 1], x[i, 2]), (d[i, 0], d[i, 1], d[i, 2])
        for j in range(lights.light_hits(blocks[0], 0, at, direction, t_max, kind, rows)):
            if rows[j].emitter == emitter:
                out[i, 0], out[i, 4] = rows[j].distance, rows[j].pdf
                out[i, 1], out[i, 2], out[i, 3] = rows[j].radiance[0], rows[j].radiance[1], rows[j].radiance[2]


@kernel
def _leave(blocks, emitter, u, out):
    for i in range(len(u)):
        o, d, flux, out[i, 9] = lights.leave_light(blocks[0], emitter, u[i, 0], u[i, 1], u[i, 2], u[i, 3])
        for axis in range(3):
            out[i, axis], out[i, 3 + axis], out[i, 6 + axis] = o[axis], d[axis], flux[axis]


@kernel
def _select(blocks, x, n, u, cuts, out):
    for i in range(len(u)):
        out[i, 0], out[i, 1], out[i, 2] = lights.select(blocks[0], 0, x, n, u[i], cuts[0])


@kernel
def _probabilities(blocks, x, n, cuts, out):
    for i in range(len(out)):
        out[i] = lights.selection_probability(blocks[0], 0, x, n, i, cuts[0])


@kernel
def _world(blocks, x, n, d, radiance, pdf):
    for i in range(len(d)):
        direction = (d[i, 0], d[i, 1], d[i, 2])
        radiance[i, 0], radiance[i, 1], radiance[i, 2] = lights.world_radiance(blocks[0], direction)
        pdf[i] = lights.world_pdf(blocks[0], x, n, direction)
