# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion while the shutter is open: positions at a given time, and the lines that join Blender's poses.

Cycles decomposes poses: it rotates along the shortest arc, and translates and scales along straight lines. Here,
additional poses are placed on these arcs, as close as linear interpolation of matrices requires. So Embree, kernels and
the reference all interpolate linearly, and agree.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from .scene import Instance, Mesh, Scene, Shutter

# Greatest angle between two poses: a chord then deviates from its arc by at most 1e-5 of the radius.
LARGEST_TURN = math.radians(0.5)
MOST_STEPS = 128  # of Embree, less one
TABLE = 1024  # parts of an exposure


def exposure(density: np.ndarray) -> np.ndarray:
    """(TABLE + 1,) ``Shutter.times`` for the opening of the shutter at even times; the whole time if it never opens."""
    x = np.linspace(0.0, 1.0, TABLE + 1)
    density = np.interp(x, np.linspace(0.0, 1.0, len(density)), np.maximum(np.asarray(density, float), 0.0))
    cdf = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    if not 0.0 < cdf[-1] < math.inf:
        return np.linspace(0.0, 1.0, 2)
    # No part of the exposure comes while it is closed at the start, in between, or at the end.
    used = np.flatnonzero(np.concatenate([np.diff(cdf) > 0.0, [False]]))
    used = np.concatenate([used, [used[-1] + 1]])
    return np.interp(np.linspace(0.0, cdf[-1], TABLE + 1), cdf[used], x[used])


def poses(matrices: np.ndarray) -> np.ndarray:
    """(N, 4, 4) poses for ``motion``, through the (K, 4, 4) ``matrices`` at even times."""
    matrices = np.asarray(matrices, float)
    steps = [_Step(a, b) for a, b in zip(matrices, matrices[1:])]
    divisions = max(step.divisions for step in steps)
    divisions = min(divisions, max(MOST_STEPS // len(steps), 1))
    inner = [step.at(part / divisions) for step in steps for part in range(divisions)]
    return np.stack([*inner, matrices[-1]])


class _Step:
    """From one pose to the next."""

    def __init__(self, start: np.ndarray, end: np.ndarray):
        self._start, self._end = start, end
        self._turn, self._stretch = zip(*(_polar(pose[:3, :3]) for pose in (start, end)))
        self._axis, self._angle = _axis_angle(self._turn[0].T @ self._turn[1])
        # Powers of two: objects with fewer poses then have one at some of the times of objects with more.
        self.divisions = 1 << max(math.ceil(math.log2(max(self._angle / LARGEST_TURN, 1.0))), 0)

    def at(self, part: float) -> np.ndarray:
        if self.divisions == 1 or part == 0.0:
            return self._start + part * (self._end - self._start)
        pose = np.eye(4)
        stretch = self._stretch[0] + part * (self._stretch[1] - self._stretch[0])
        pose[:3, :3] = self._turn[0] @ _rotation(self._axis, part * self._angle) @ stretch
        pose[:3, 3] = self._start[:3, 3] + part * (self._end[:3, 3] - self._start[:3, 3])
        return pose


def _polar(linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and stretch (3, 3) whose product is ``linear``; mirroring belongs to the stretch."""
    left, scales, right = np.linalg.svd(linear)
    sign = np.sign(np.linalg.det(left @ right)) or 1.0
    return sign * left @ right, sign * right.T @ np.diag(scales) @ right


def _axis_angle(rotation: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit axis and angle, 0 to π, of a rotation."""
    twist = 0.5 * np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = float(np.linalg.norm(twist)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return twist / sine, angle
    # Half a turn: the axis is the eigenvector of 1.
    square = 0.5 * (rotation + np.eye(3))
    column = square[:, int(np.argmax(square.diagonal()))]
    return column / max(float(np.linalg.norm(column)), 1e-300), angle


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def between(values: np.ndarray, time: float) -> np.ndarray:
    """Linear interpolation of ``values`` (K, …) at even times; ``time`` is in [0, 1]."""
    place = min(max(time, 0.0), 1.0) * (len(values) - 1)
    first = min(int(place), len(values) - 2)
    return values[first] + (place - first) * (values[first + 1] - values[first])


def blend(a, b, part: float):
    """Interpolation by ``part`` between two dataclasses of one kind: numbers are linear, other fields are those of
    ``a``."""
    changes = {}
    for item in dataclasses.fields(a):
        old, new = getattr(a, item.name), getattr(b, item.name)
        if isinstance(old, np.ndarray) or isinstance(old, float) and isinstance(new, float) or _numbers(old):
            changes[item.name] = _blend_values(old, new, part)
    return dataclasses.replace(a, **changes)


def _numbers(value) -> bool:
    return isinstance(value, tuple) and bool(value) and all(isinstance(item, float) for item in value)


def _blend_values(old, new, part: float):
    a, b = np.asarray(old, float), np.asarray(new, float)
    if a.shape != b.shape:
        return old
    with np.errstate(invalid="ignore"):
        mixed = np.where(a == b, a, a + part * (b - a))
    if isinstance(old, tuple):
        return tuple(mixed.tolist())
    return float(mixed) if isinstance(old, float) else mixed


def object_at(thing, time: float):
    """A lamp, a light or the camera at a time, without motion."""
    if not thing.motion:
        return thing
    place = min(max(time, 0.0), 1.0) * (len(thing.motion) - 1)
    first = min(int(place), len(thing.motion) - 2)
    return dataclasses.replace(blend(thing.motion[first], thing.motion[first + 1], place - first), motion=())


def resampled(things: tuple) -> tuple:
    """``motion`` of a lamp, a light or the camera, from K of itself at even times: as many as its rotation needs."""
    if len(things) < 2:
        return ()
    matrices = poses(np.stack([thing.matrix for thing in things]))
    divisions = (len(matrices) - 1) // (len(things) - 1)
    result = []
    for index, matrix in enumerate(matrices):
        first = min(index // divisions, len(things) - 2)
        thing = blend(things[first], things[first + 1], index / divisions - first)
        result.append(dataclasses.replace(thing, matrix=matrix, motion=()))
    return tuple(result)


def at(scene: Scene, time: float, chosen: np.ndarray | None = None) -> Scene:
    """The scene at a time, without motion. Of its surfaces only the instances ``chosen`` (instances,) are moved, if
    given."""
    instances, meshes = list(scene.instances), list(scene.meshes)
    indices = range(len(instances)) if chosen is None else np.flatnonzero(chosen)
    for index in indices:
        instances[index] = _instance_at(instances[index], time)
    for index in {instances[index].mesh for index in indices}:
        meshes[index] = _mesh_at(meshes[index], time)
    return dataclasses.replace(scene, meshes=meshes, instances=instances, shutter=None, **lighting_at(scene, time))


def lighting_at(scene: Scene, time: float) -> dict:
    """Camera, lamps and lights at a time."""
    return {
        "camera": object_at(scene.camera, time),
        "lamps": [object_at(lamp, time) for lamp in scene.lamps],
        "lights": [object_at(light, time) for light in scene.lights],
    }


def _mesh_at(mesh: Mesh, time: float) -> Mesh:
    if mesh.motion is None:
        return mesh
    normals = mesh.normals if mesh.motion_normals is None else between(mesh.motion_normals, time)
    return dataclasses.replace(
        mesh,
        positions=between(mesh.motion, time),
        normals=normals,
        radii=mesh.radii if mesh.motion_radii is None else between(mesh.motion_radii, time),
        motion=None,
        motion_normals=None,
        motion_radii=None,
    )


def _instance_at(instance: Instance, time: float) -> Instance:
    if instance.motion is None:
        return instance
    return dataclasses.replace(instance, matrix=between(instance.motion, time), motion=None)


def light_steps(scene: Scene, emissive: np.ndarray) -> int:
    """Number of shutter steps at whose ends camera, lamps, lights and the instances ``emissive`` (instances,) are
    known; 0 if none of them moves."""
    counts = [len(thing.motion) - 1 for thing in (scene.camera, *scene.lamps, *scene.lights) if thing.motion]
    for instance in (scene.instances[index] for index in np.flatnonzero(emissive)):
        moved = (instance.motion, scene.meshes[instance.mesh].motion)
        counts += [len(poses) - 1 for poses in moved if poses is not None]
    return max(counts, default=0)


def part_of(seed: int, index: int) -> float:
    """Fraction of the exposure at which a back end takes sample ``index`` of all pixels: van der Corput's sequence with
    a random shift."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, 1])))
    return (int(f"{index:032b}"[::-1], 2) / 2**32 + rng.random()) % 1.0


def time_of(shutter: Shutter, u: float, height: float) -> float:
    """Time at which the fraction ``u`` of the exposure has passed, in the line whose lower edge is at ``height``, 0 to
    1 from the frame's bottom."""
    table = shutter.times
    time = float(np.interp(u, np.linspace(0.0, 1.0, len(table)), table))
    if shutter.rolling is None:
        return time
    line = 1.0 - height
    return (time - 0.5) * shutter.rolling + (line - 0.5) * (1.0 - shutter.rolling) + 0.5
