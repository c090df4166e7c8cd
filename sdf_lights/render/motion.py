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

from ..affine import Arc
from ..sdf.interpolation import change, interpolated
from .scene import Emitter, Instance, Lamp, Mesh, Scene, Shutter

# Greatest angle between two poses: a chord then deviates from its arc by at most 1e-5 of the radius.
LARGEST_TURN = math.radians(0.5)
MOST_STEPS = 128  # of Embree, less one
TABLE = 1024  # parts of an exposure
# Greatest logarithm of the ratio of two lengths of a light or lamp between two states. Its volume, area and density are
# powers of them, which kernels interpolate linearly: by at most 0.04 % of them, in the mean over such a step.
LARGEST_GROWTH = 1.0 / 64.0
# A lamp whose shape or emission changes has one after the other, each for an equal part of the shutter's time: as many
# as their numbers change by this fraction, at most so many unless Blender has more poses.
SMALLEST_CHANGE, MOST_SHAPES = 0.02, 32
_LINEAR = ("power", "density", "color", "camera_brightness")  # tables are proportional to these numbers
LEAST_POWER = 1e-9  # of a lamp at any time, relative to that at the frame


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


def poses(matrices: np.ndarray, least: int = 1) -> np.ndarray:
    """(N, 4, 4) poses for ``motion``, through the (K, 4, 4) ``matrices`` at even times. Between two of them are at
    least ``least`` steps, a power of two."""
    matrices = np.asarray(matrices, float)
    steps = [Arc(a, b) for a, b in zip(matrices, matrices[1:])]
    divisions = max(least, *(_power_of_two(step.angle / LARGEST_TURN) for step in steps))
    divisions = min(divisions, max(MOST_STEPS // len(steps), 1))
    inner = [step.at(part / divisions) for step in steps for part in range(divisions)]
    return np.stack([*inner, matrices[-1]])


def _power_of_two(count: float) -> int:
    """The least one that is not below ``count``, and at most ``MOST_STEPS``. So objects with fewer poses have one at
    some of the times of objects with more."""
    return 1 << math.ceil(math.log2(min(max(count, 1.0), MOST_STEPS)))


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


def lamp_at(lamp: Lamp, time: float) -> Lamp:
    """As ``object_at``. A lamp that moves always has some power, so scenes have the same lamps at all times."""
    there = object_at(lamp, time)
    if there is lamp:
        return lamp
    density = None if lamp.density is None else max(there.density or 0.0, LEAST_POWER * lamp.density)
    return dataclasses.replace(there, power=max(there.power, LEAST_POWER * lamp.power), density=density)


def changes_shape(lamp: Lamp) -> bool:
    """Whether the shape of a lamp, or the pattern of its emission, changes while the shutter is open."""
    return any(shape_and_emission(state) != shape_and_emission(lamp.motion[0]) for state in lamp.motion)


def shape_and_emission(thing) -> tuple:
    """Shape and emission of a lamp; nothing of a light or the camera."""
    return (thing.shape, thing.emission) if isinstance(thing, Lamp) else ()


def _growth(start: Emitter, end: Emitter) -> float:
    """Logarithm of the greatest ratio of a length of one to that of the other."""
    found = 0.0
    for item in dataclasses.fields(start):
        a, b = getattr(start, item.name), getattr(end, item.name)
        if item.name == "matrix":
            a, b = (np.linalg.svd(matrix[:3, :3], compute_uv=False) for matrix in (a, b))
        elif item.name in _LINEAR or not (isinstance(a, float) or _numbers(a)) or type(a) is not type(b):
            continue
        sizes = np.abs(np.array([a, b], float)).reshape(2, -1)
        sizes = sizes[:, (sizes[0] != sizes[1]) & np.isfinite(sizes).all(axis=0)]
        with np.errstate(divide="ignore"):
            found = max(found, np.abs(np.diff(np.log(sizes), axis=0)).max(initial=0.0))
    return found


def resampled(things: tuple) -> tuple:
    """``motion`` of a lamp, a light or the camera, from K of itself at even times: as many as its rotation and the
    change of its shape need."""
    if len(things) < 2:
        return ()
    steps = len(things) - 1
    changes = any(shape_and_emission(thing) != shape_and_emission(things[0]) for thing in things)
    growth = max(map(_growth, things, things[1:])) if isinstance(things[0], Emitter) else 0.0
    least = _power_of_two(growth / LARGEST_GROWTH)
    if changes:
        wanted = max(
            change(*pair)
            for a, b in zip(things, things[1:])
            for pair in zip(shape_and_emission(a), shape_and_emission(b))
        )
        # Two at least, for what jumps to the form at the nearer time.
        least = max(least, 2, _power_of_two(min(wanted / SMALLEST_CHANGE, MOST_SHAPES / steps)))
    matrices = poses(np.stack([thing.matrix for thing in things]), least)
    divisions = (len(matrices) - 1) // steps
    result = []
    for index, matrix in enumerate(matrices):
        first = min(index // divisions, steps - 1)
        thing = blend(things[first], things[first + 1], index / divisions - first)
        if changes:  # that of the middle of the time for which it is taken
            part = min((index + 0.5) / divisions - first, 1.0)
            names = ("shape", "emission")
            middle = {
                name: interpolated(getattr(things[first], name), getattr(things[first + 1], name), part)
                for name in names
            }
            thing = dataclasses.replace(thing, **middle)
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
        "lamps": [lamp_at(lamp, time) for lamp in scene.lamps],
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
