# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that rays meet: lamps, lights, the world and surfaces, weighted against light sampling."""

from __future__ import annotations

import numpy as np

from ..scene import ALL_SETS, Ray
from ..scene import Emitter as Control
from .geometry import Surface
from .materials import Shading
from .paths import Paths, Samples
from .scene_data import SceneData
from .strands import NONE
from .vectors import dot

NO_CONTROL = Control()


def mis_applies(visibility: Ray, control: Control = NO_CONTROL) -> bool:
    """Whether every scattered ray can hit an emitter, so that light sampling and BSDF sampling share its light.

    An emitter hidden from some rays is left to light sampling, and to singular scattering; so is one with shadow
    linking.
    """
    scattered = Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION
    return visibility & scattered == scattered and control.blockers == ALL_SETS and not control.sampled_only


def is_lit(receivers: int, light_set: np.ndarray) -> np.ndarray:
    """Whether an emitter lights the sets (N,) of instances."""
    if receivers == ALL_SETS or not len(light_set):
        return np.ones(len(light_set), bool)
    return np.array([receivers >> number & 1 for number in range(light_set.max() + 1)] + [1], bool)[light_set]


def balance_weight(
    data: SceneData, paths: Paths, light_pdf: np.ndarray, visibility: Ray = Ray.ALL, control: Control = NO_CONTROL
) -> np.ndarray:
    """Balance heuristic (N,) for emission that rays have hit, with the density ``paths.pdf``; 1 if that is 0. Where
    no light rays find it, as behind what stops them or after the bounces of a light, the power heuristic of Cycles."""
    pdf = paths.pdf
    if not mis_applies(visibility, control):
        return np.where(pdf > 0.0, 0.0, 1.0)
    light_pdf = light_pdf * data.light_samples
    weight = np.where(pdf > 0.0, pdf / np.where(pdf > 0.0, pdf + light_pdf, 1.0), 1.0)
    power = weight**2 / (weight**2 + (1.0 - weight) ** 2)
    return np.where((pdf > 0.0) & (paths.stopped | _used_up(paths, control)), power, weight)


def _used_up(paths: Paths, control: Control) -> np.ndarray:
    """(N,) whether the vertex where the ray starts is beyond the emitter's bounces."""
    return paths.bounces[:, 0] - 1 > control.max_bounces


def sees(data: SceneData, paths: Paths, emitter, control: Control) -> np.ndarray:
    """(N,) whether the rays can hit an emitter."""
    kinds = emitter.visibility & (Ray.CAMERA if control.sampled_only else Ray.ALL)
    return ((paths.kind & kinds) != 0) & is_lit(control.receivers, paths.light_set)


def contribute(
    data: SceneData, paths: Paths, radiance: np.ndarray, scatters: np.ndarray, samples: Samples, lamp=False, sky=False
) -> None:
    """Add radiance (N, 3), times the throughput of its paths, to the passes.
    ``scatters`` (N,): how often the light has been scattered; ``lamp``, ``sky``: where it comes from."""
    value = paths.throughput * radiance
    for limit, which in ((data.settings.clamp_direct, scatters <= 1), (data.settings.clamp_indirect, scatters > 1)):
        if limit > 0.0:
            value = value * np.where(which, np.minimum(1.0, limit / np.maximum(value.sum(1), 1e-300)), 1.0)[:, None]
    samples.combined[paths.sample] += value
    samples.light[paths.sample] += value * paths.catches[:, None]
    own = value * ~paths.catches[:, None]
    if lamp:
        samples.lamps[paths.sample] += own
    seen = samples.environment if sky else samples.emission
    seen[paths.sample] += own * (scatters == 0)[:, None]


def gather_emitters(data: SceneData, paths: Paths, end: np.ndarray, samples: Samples) -> None:
    """Lamps and lights along the rays, up to the distances ``end`` (N,)."""
    count = len(end)
    for lamp in data.lamps:
        spans = lamp.spans(paths.origin, paths.direction)
        control = data.control[id(lamp)]
        weight = sees(data, paths, lamp, control) * balance_weight(
            data, paths, lamp.pdf(spans, count), lamp.visibility, control
        )
        weight = np.where((paths.pdf > 0.0) & _used_up(paths, control), 0.0, weight)
        radiance = lamp.radiance(spans, paths.origin, paths.direction, paths.near, end)
        weight = np.where(paths.kind == Ray.CAMERA, lamp.lamp.camera_brightness, 1.0) * weight
        contribute(data, paths, radiance * weight[:, None], paths.bounces[:, 0], samples, lamp=True)
    for light in data.lights:
        distance, radiance, pdf = light.hit(paths.origin, paths.direction)
        radiance = light.modulated(radiance, paths.origin, paths.direction, distance, paths.kind)
        met = (distance > paths.near) & ((distance < end) | ~np.isfinite(end) & np.isfinite(distance))
        control = data.control[id(light)]
        met &= sees(data, paths, light, control)
        weight = met * balance_weight(data, paths, pdf, light.visibility, control)
        contribute(data, paths, radiance * weight[:, None], paths.bounces[:, 0], samples)


def gather_sky(data: SceneData, paths: Paths, samples: Samples) -> None:
    """The world behind the rays, which hit no surface."""
    if data.settings.transparent_film:
        camera = paths.kind == Ray.CAMERA
        samples.alpha[paths.sample] -= camera * paths.throughput.mean(1)
        hidden = paths.select(camera & ~paths.catches & ((data.sky.visibility & Ray.CAMERA) != 0))
        if len(hidden.sample) and not data.sky.black:
            radiance = data.sky.radiance(hidden.direction, hidden.kind)
            samples.environment[hidden.sample] += hidden.throughput * radiance
        paths = paths.select(~camera)
    if data.sky.black:
        return
    visible = (paths.kind & data.sky.visibility) != 0
    pdf = np.where(paths.stopped & (data.sky.pixels is None), 0.0, data.sky.pdf(paths.direction))  # as in Cycles
    weight = visible * balance_weight(data, paths, pdf, data.sky.visibility, data.control[id(data.sky)])
    radiance = data.sky.radiance(paths.direction, paths.kind) * weight[:, None]
    contribute(data, paths, radiance, paths.bounces[:, 0], samples, sky=True)


def gather_surface(
    data: SceneData, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples
) -> None:
    """Emission of the surfaces that rays hit at the distances ``end`` (N,)."""
    weight = np.ones(len(end))
    if data.triangles is not None:
        known = data.materials.emissive[data.geometry.material(surface.instance, surface.triangle)]
        known &= surface.number == NONE
        density = data.triangles.density(end, np.abs(dot(surface.ng, surface.wo)))
        weight = np.where(known, _surface_weight(data, paths, surface, density), 1.0)
    for index in np.unique(surface.instance) if len(end) else ():
        rows = surface.instance == index
        weight[rows] *= is_lit(data.scene.instances[index].receivers, paths.light_set[rows])
    contribute(data, paths, shading.emission * weight[:, None], paths.bounces[:, 0], samples)


def _surface_weight(data: SceneData, paths: Paths, surface: Surface, density: np.ndarray) -> np.ndarray:
    """As ``_weight``, for the emissive triangles that were hit: each instance has its own visibility and
    linking."""
    weight = np.ones(len(density))
    for index in np.unique(surface.instance) if len(density) else ():
        instance, rows = data.scene.instances[index], np.flatnonzero(surface.instance == index)
        weight[rows] = balance_weight(data, paths.select(rows), density[rows], instance.visibility, instance)
    return weight
