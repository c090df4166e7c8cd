# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimators of the irradiance from a lamp at an unoccluded point, which compare samplers of directions.

    E = ∫ L(ω) max(0, n·ω) dω,     L(ω) = ρ Σ ∫ profile(x + r·ω) dr over the intervals inside

An estimator is a kernel ``f(block, lamp, x, n, u, spans, shell) -> value`` whose mean over uniform u (``DIMENSIONS``
numbers) is E; ``Technique`` names them all. ``shell`` is the profile, the emission at a point relative to the lamp's
uniform ρ. Values are of the red channel.
"""

from __future__ import annotations

import enum
import math
import time
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from sdf_lights.emitter.building.build import build_lamp
from sdf_lights.emitter.building.pack import new_spans, pack_lamps, pack_scalars
from sdf_lights.emitter.hashing import following, seeded, uniform_point
from sdf_lights.emitter.lamps import SCALARS, TABLES, intensity, lamps, radiance, trace, varies
from sdf_lights.emitter.primitives.disk import disk_point
from sdf_lights.emitter.sampling import cut as cuts
from sdf_lights.emitter.sampling.cut import BOXES, CUT, KEYS, REGIONS
from sdf_lights.emitter.sampling.projection import direction_pdf, interior_offset, sample_direction
from sdf_lights.jit import block_dtype, fill_table, kernel, table
from sdf_lights.sdf.emission import Emission, EmissionExpression
from sdf_lights.vec import add, dot, frame, madd, normalize, to_world

from . import bounding, surfaces

BLOCK = block_dtype({**TABLES, **cuts.TABLES, **surfaces.TABLES}, SCALARS)

# As in the renderer: kernels would have to count references to arrays passed to them.
WORKSPACE_TABLES = {"spans": np.dtype(np.float64), **cuts.WORKSPACE_TABLES}
WORKSPACE = block_dtype(WORKSPACE_TABLES)
_spans, _regions, _boxes, _cuts = (table(name, dtype) for name, dtype in WORKSPACE_TABLES.items())

DIMENSIONS = 7  # a direction by the cosine (2), a point in the lamp (3), a position in the intervals of each ray (2)
CHUNK = 1 << 17
CANDIDATES = 8  # of resampling
RADIAL = 1.3  # see ``radial``

EVEN = (1.0, 0.0, 1.0, 0.0)
TORUS_SHELL = (3.2, 3.0 / 0.35, 1.0, 0.35)  # the varying emission of the published check
SHELL_EMISSION = EmissionExpression("3.2 * exp(-3 / 0.35 * depth)").emission()  # the same, inside that torus


@kernel
def profile(x, shell):
    """gain · exp(−falloff · |φ|), φ the distance to the torus of the given radii around the world's z axis.

    ``shell`` is (gain, falloff, major radius, minor radius). Numbers instead of a kernel keep the estimators cached.
    """
    ring = math.sqrt(x[0] * x[0] + x[1] * x[1]) - shell[2]
    return shell[0] * math.exp(-shell[1] * abs(math.sqrt(ring * ring + x[2] * x[2]) - shell[3]))


@kernel
def _radiance(block, lamp, x, d, spans, count, u, shell):
    """Unbiased estimate of L; for a ``shell``, from one point in each interval."""
    if varies(block, lamp):
        return radiance(block, lamp, x, d, spans, count, 0.0, np.inf, u)[0]
    total = 0.0
    for index in range(count):
        c, h = spans[index, 0], spans[index, 1]
        # A different position in each interval from one number: each is uniform, which is enough for an unbiased sum.
        place = (u + index * 0.6180339887498949) % 1.0
        total += 2.0 * h * profile(madd(x, c + (2.0 * place - 1.0) * h, d), shell)
    return total * lamps(block)[lamp].emission[0]


@kernel
def _ray(block, lamp, x, n, d, spans, u, shell):
    """Value L·max(0, n·ω) of a direction, and its density under projection sampling."""
    count = trace(block, lamp, x, d, spans)
    value = _radiance(block, lamp, x, d, spans, count, u, shell) * max(dot(n, d), 0.0)
    return value, direction_pdf(block, lamp, x, n, d, spans, count)


@kernel
def _cosine_direction(n, u1, u2):
    """Direction of density cos θ/π about n. Malley's method: a uniform point of the disk, lifted to the hemisphere."""
    x, y = disk_point(u1, u2)
    t, b = frame(n)
    return to_world((x, y, math.sqrt(max(1.0 - x * x - y * y, 0.0))), t, b, n)


@kernel
def uniform_directions(block, lamp, x, n, u, spans, shell):
    """Uniform directions of the whole sphere."""
    z = 1.0 - 2.0 * u[0]
    ring = math.sqrt(max(1.0 - z * z, 0.0))
    angle = 2.0 * math.pi * u[1]
    d = (ring * math.cos(angle), ring * math.sin(angle), z)
    return 4.0 * math.pi * _ray(block, lamp, x, n, d, spans, u[5], shell)[0]


@kernel
def cosine_directions(block, lamp, x, n, u, spans, shell):
    """Directions in proportion to the cosine, like the samples of a diffuse BSDF."""
    d = _cosine_direction(n, u[0], u[1])
    cosine = dot(n, d)
    return math.pi * _ray(block, lamp, x, n, d, spans, u[5], shell)[0] / cosine if cosine > 0.0 else 0.0


@kernel
def point_in_volume(block, lamp, x, n, u, spans, shell):
    """A uniform point of the lamp, treated as a point light; its variance is infinite if x is inside."""
    way = interior_offset(block, lamp, x, u[2], u[3], u[4])
    square = dot(way, way)
    cosine = max(dot(n, normalize(way)), 0.0)
    return intensity(block, lamp)[0] * profile(add(x, way), shell) * cosine / square if square > 0.0 else 0.0


@kernel
def projection(block, lamp, x, n, u, spans, shell):
    """Projection sampling: the whole line through a uniform point, by its directional density."""
    d = sample_direction(block, lamp, x, n, u[2], u[3], u[4])
    value, pdf = _ray(block, lamp, x, n, d, spans, u[5], shell)
    return value / pdf if pdf > 0.0 else 0.0


@kernel
def bounding_projection(block, lamp, x, n, u, spans, shell):
    """Projection sampling of the lamp's bounding box."""
    d = bounding.sample(block, lamp, x, u[2], u[3], u[4])
    value = _ray(block, lamp, x, n, d, spans, u[5], shell)[0]
    return value / bounding.density(block, lamp, x, d) if value > 0.0 else 0.0


@kernel
def surface_area(block, lamp, x, n, u, spans, shell):
    """The whole line through a uniform point of the surface, by its directional density."""
    d = surfaces.sample(block, lamp, x, spans, u[2], u[3], u[4])
    count = trace(block, lamp, x, d, spans)
    pdf = surfaces.density(block, lamp, x, d, spans, count)
    value = _radiance(block, lamp, x, d, spans, count, u[5], shell) * max(dot(n, d), 0.0)
    return value / pdf if pdf > 0.0 else 0.0


@kernel
def combined(block, lamp, x, n, u, spans, shell, bsdf_mis_scale):
    """One cosine-weighted and one projection sample, by the balance heuristic with β cosine samples for one."""
    total = 0.0
    d = _cosine_direction(n, u[0], u[1])
    for technique in range(1 if bsdf_mis_scale == 0.0 else 0, 2):
        if technique == 1:
            d = sample_direction(block, lamp, x, n, u[2], u[3], u[4])
        value, pdf = _ray(block, lamp, x, n, d, spans, u[5 + technique], shell)
        pdf_sum = pdf + bsdf_mis_scale * max(dot(n, d), 0.0) / math.pi
        total += value * (1.0 if technique == 1 else bsdf_mis_scale) / pdf_sum if pdf_sum > 0.0 else 0.0
    return total


@kernel
def resampled(block, lamp, x, n, u, spans, shell):
    """Resampled importance sampling: one of ``CANDIDATES`` uniform points, by the light of a uniform lamp.

    Talbot, Cline and Egbert 2005, "Importance resampling for global illumination".
    """
    state = seeded(u[2], u[3], u[4])
    total, chosen = 0.0, (0.0, 0.0, 0.0)
    pick = u[5]
    for candidate in range(CANDIDATES):
        p = (u[2], u[3], u[4]) if candidate == 0 else uniform_point(state)
        state = following(state)
        way = interior_offset(block, lamp, x, p[0], p[1], p[2])
        square = dot(way, way)
        weight = max(dot(n, normalize(way)), 0.0) / square if square > 0.0 else 0.0
        total += weight
        if weight > 0.0:
            part = weight / total
            if pick < part:
                chosen, pick = add(x, way), pick / part
            else:
                pick = (pick - part) / (1.0 - part)
    return intensity(block, lamp)[0] * profile(chosen, shell) * total / CANDIDATES if total > 0.0 else 0.0


@kernel
def radial(block, lamp, x, n, u, spans, shell):
    """MIS of cosine and projection with weights that change along the ray, r²/(r² + c²) for projection: uniform lamps.

    Close parts are left to the cosine, so both weights are bounded. c is ``RADIAL`` sizes of the lamp, less far away.
    """
    row = lamps(block)[lamp]
    size = (0.75 / math.pi * row.volume) ** (1.0 / 3.0)
    c = RADIAL * size * size / (size + cuts.distance_to_bounds(row, x))
    total = 0.0
    d = _cosine_direction(n, u[0], u[1])
    for technique in range(2):
        if technique == 1:
            d = sample_direction(block, lamp, x, n, u[2], u[3], u[4])
        count = trace(block, lamp, x, d, spans)
        near, length = 0.0, 0.0
        for index in range(count):
            a, b = spans[index, 0] - spans[index, 1], spans[index, 0] + spans[index, 1]
            near += c * (math.atan(b / c) - math.atan(a / c))
            length += b - a
        if technique == 0:
            total += math.pi * near
        elif count > 0:
            total += max(dot(n, d), 0.0) * (length - near) / direction_pdf(block, lamp, x, n, d, spans, count)
    return total * row.emission[0]


@kernel
def cell_cut(block, lamp, x, n, u, spans, shell, keys, store, cut, tolerance, limit):
    """One sample of the cut, which is fitted anew, and a cosine-weighted one where that counts."""
    cuts.prepare(block, lamp, x, n, 0, 1, tolerance, limit, keys, store, cut)
    total = 0.0
    d = _cosine_direction(n, u[0], u[1])
    for technique in range(1 if cut.bsdf_mis_scale == 0.0 else 0, 2):
        if technique == 1:
            d = cuts.sample(block, lamp, x, store, cut, u[2], u[3], u[4])
        cosine = dot(n, d)
        if cosine <= 0.0:
            continue
        count = trace(block, lamp, x, d, spans)
        if count == 0:
            continue
        value = _radiance(block, lamp, x, d, spans, count, u[5 + technique], shell) * cosine
        pdf_sum = cuts.density(block, lamp, d, store, cut, spans, count) + cut.bsdf_mis_scale * cosine / math.pi
        total += value * (1.0 if technique == 1 else cut.bsdf_mis_scale) / pdf_sum
    return total


class Technique(enum.IntEnum):
    """``RADIAL`` is for uniform emission, ``SURFACE`` for blocks that were made with their ``surface``."""

    UNIFORM = 0
    COSINE = 1
    POINT = 2
    PROJECTION = 3
    MIS = 4
    BOUNDING = 5
    MIS_BETA = 6
    RIS = 7
    RADIAL = 8
    CUT = 9
    SURFACE = 10


UNIFORM, COSINE, POINT, PROJECTION, MIS, BOUNDING, MIS_BETA, RIS, RADIAL_MIS, _, SURFACE = map(int, Technique)


@kernel
def _values(technique, blocks, lamp, x, n, numbers, workspaces, shell, tolerance, limit, out):
    block, workspace = blocks[0], workspaces[0]
    flat, keys, store, cut = _spans(workspace), _regions(workspace), _boxes(workspace), _cuts(workspace)
    spans = flat.reshape(len(flat) // 2, 2)
    for i in range(len(numbers)):
        u = (numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3], numbers[i, 4], numbers[i, 5], numbers[i, 6])
        if technique == UNIFORM:
            out[i] = uniform_directions(block, lamp, x, n, u, spans, shell)
        elif technique == COSINE:
            out[i] = cosine_directions(block, lamp, x, n, u, spans, shell)
        elif technique == POINT:
            out[i] = point_in_volume(block, lamp, x, n, u, spans, shell)
        elif technique == PROJECTION:
            out[i] = projection(block, lamp, x, n, u, spans, shell)
        elif technique == MIS:
            out[i] = combined(block, lamp, x, n, u, spans, shell, 1.0)
        elif technique == BOUNDING:
            out[i] = bounding_projection(block, lamp, x, n, u, spans, shell)
        elif technique == MIS_BETA:
            out[i] = combined(block, lamp, x, n, u, spans, shell, cuts.tuned_mis_scale(block, lamp, x))
        elif technique == RIS:
            out[i] = resampled(block, lamp, x, n, u, spans, shell)
        elif technique == RADIAL_MIS:
            out[i] = radial(block, lamp, x, n, u, spans, shell)
        elif technique == SURFACE:
            out[i] = surface_area(block, lamp, x, n, u, spans, shell)
        else:
            out[i] = cell_cut(block, lamp, x, n, u, spans, shell, keys, store, cut[0], tolerance, limit)


class LampBlock:
    """A lamp of ``power`` in watts in a separate block, with the tables for all techniques.

    If its ``emission`` varies, the line integral is that of the renderer. The ``shell`` of estimators must then be
    ``EVEN``, and those that need the emission at a point cannot be used. With ``surface`` the surface is measured,
    which takes up to a second.
    """

    def __init__(
        self,
        shape,
        matrix: np.ndarray,
        power: float = 4.0 * math.pi,
        emission: Emission | None = None,
        surface: bool = False,
    ):
        self.built = build_lamp("lamp", shape, matrix, power=power, emission=emission)
        sources = [SimpleNamespace(shape=shape, matrix=matrix)]
        rows, self._owner = (
            surfaces.pack_surfaces([self.built], sources) if surface else (np.zeros(0, surfaces.SURFACE), ())
        )
        self.tables = {**pack_lamps([self.built]), **cuts.pack_cuts([self.built], sources), "external_rows": rows}
        self.blocks = np.zeros(1, BLOCK)
        for name, array in self.tables.items():
            fill_table(self.blocks, name, array)
        for name, value in pack_scalars([self.built]).items():
            self.blocks[name] = value


def values(
    technique: Technique,
    blocks: np.ndarray,
    lamp: int,
    x,
    n,
    numbers: np.ndarray,
    shell: tuple[float, float, float, float] = EVEN,
    tolerance: float = cuts.TOLERANCE,
    limit: int = cuts.LIMIT,
) -> tuple[np.ndarray, float]:
    """Value of an estimator for each row of ``numbers`` (count, ``DIMENSIONS``), and the seconds of processor time.

    ``blocks`` is a one-element array of ``BLOCK``; x and n are a world point and the unit normal there.
    """
    scratch = {
        "spans": new_spans(int(blocks["lamp_rows"][0]), int(blocks["lamps_count"][0])).ravel(),
        "lamp_regions": np.zeros(REGIONS, KEYS),
        "lamp_boxes": np.empty(REGIONS, BOXES),
        "lamp_cuts": np.zeros(1, CUT),
    }
    workspaces = np.zeros(1, WORKSPACE)
    for name, array in scratch.items():
        fill_table(workspaces, name, array)
    out = np.empty(len(numbers))
    start = time.thread_time()
    _values(
        int(technique),
        blocks,
        lamp,
        tuple(map(float, x)),
        tuple(map(float, n)),
        numbers,
        workspaces,
        shell,
        tolerance,
        limit,
        out,
    )
    return out, time.thread_time() - start


@dataclass(frozen=True)
class Estimate:
    """Mean and variance of one sample, the standard error of the mean, and the seconds spent in the estimator."""

    mean: float
    variance: float
    error: float
    seconds: float


def run(
    technique: Technique,
    blocks: np.ndarray,
    lamp: int,
    x,
    n,
    samples: int,
    seed: int,
    shell: tuple[float, float, float, float] = EVEN,
) -> Estimate:
    """Mean and variance of ``samples`` values of an estimator; arguments as of ``values``.

    Deterministic for a seed, except for the time.
    """
    rng = np.random.default_rng(seed)
    total = square = seconds = 0.0
    shift, done = None, 0
    while done < samples:
        found, spent = values(
            technique, blocks, lamp, x, n, rng.random((min(CHUNK, samples - done), DIMENSIONS)), shell
        )
        seconds += spent
        if shift is None:
            shift = found.mean()  # sums relative to a first guess of the mean, so that small variances do not cancel
        total += np.sum(found - shift)
        square += np.sum((found - shift) ** 2)
        done += len(found)
    mean = total / done
    variance = max(square / done - mean * mean, 0.0) * done / max(done - 1, 1)
    return Estimate(shift + mean, variance, math.sqrt(variance / done), seconds)
