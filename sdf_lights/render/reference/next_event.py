# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Next event estimation: light that is sampled at the points of paths."""

from __future__ import annotations

import functools

import numpy as np

from ..scene import ALL_SETS, Ray
from ..scene import Emitter as Control
from .gather import NO_CONTROL, contribute, is_lit, mis_applies
from .geometry import Surface
from .hits import Hits
from .materials import Shading
from .media import Phase
from .paths import Paths, Samples
from .scene_data import SPLIT, SceneData
from .sdf_lamps import SdfLamp
from .strands import NONE
from .varying_media import Rays
from .vectors import dot


def sample_lights(data: SceneData, paths: Paths, surface: Surface, shading: Shading, samples: Samples, rng) -> None:
    """Next event estimation: the k-th of ``rounds`` draws is uniform in the k-th part of the list of emitters."""
    total, count = len(data.emitters), len(paths.sample)
    rounds = min(total, SPLIT)
    for k in range(rounds):
        choice = np.minimum(((k + rng.random(count)) * total / rounds).astype(int), total - 1)
        for index in np.unique(choice):
            rows = np.flatnonzero(choice == index)
            part = paths.select(rows), surface.select(rows), shading.select(rows)
            _sample_emitter(data, data.emitters[index], *part, samples, rng)


def _sample_emitter(data: SceneData, emitter, paths, surface, shading, samples, rng) -> None:
    control = data.control.get(id(emitter), NO_CONTROL)
    sets = data.light_sets[surface.instance]
    if isinstance(shading, Phase):
        sets = data.media.light_set(shading.inside)
    lit = is_lit(control.receivers, sets)
    lit &= paths.bounces[:, 0] <= control.max_bounces
    paths, surface, shading = (part.select(np.flatnonzero(lit)) for part in (paths, surface, shading))
    sets = sets[lit]
    x, count = surface.position, len(paths.sample)
    spans = hits = owner = None
    if isinstance(emitter, SdfLamp):
        wi = emitter.sample(rng, x)
    elif emitter is data.triangles:
        wi, distance, pdf, index, u, v = emitter.sample_points(rng, x)
        owner = emitter.instances[index]
        hits = Hits(distance, owner, emitter.triangles[index], u, v, x + distance[:, None] * wi)
    else:
        wi, distance, radiance, pdf = emitter.sample(rng, x)
        radiance = emitter.modulated(radiance, x, wi, distance, 0)
    scattered, scatter_pdf = _scattered(data, shading, wi, emitter, owner)
    seen = scattered.max(1) > 0.0
    if owner is not None:
        for number in np.unique(owner):
            receivers = data.scene.instances[number].receivers
            seen &= (owner != number) | is_lit(receivers, sets)
    rows = np.flatnonzero(seen)
    paths, surface, x, wi = paths.select(rows), surface.select(rows), x[rows], wi[rows]
    scattered, scatter_pdf, count = scattered[rows], scatter_pdf[rows], len(rows)
    casts = _casters(data, control, None if owner is None else owner[rows], count)
    if isinstance(emitter, SdfLamp):
        spans = emitter.spans(x, wi)
        pdf = emitter.pdf(spans, count)
        last = np.zeros(count)
        np.maximum.at(last, spans.ray, spans.far)
        radiance = functools.partial(emitter.radiance, spans, x, wi)
        light = _transmitted(data, paths, surface, wi, last, casts, rng, radiance)
    else:
        pdf, distance = pdf[rows], distance[rows]
        end = distance - 4.0 * data.geometry.epsilon
        if hits is not None:
            hits = hits.select(rows)
            lit = data.geometry.surface(hits, wi)
            lit.depth = paths.bounces
            radiance = data.materials.shade(lit, np.zeros(count)).emission
            # The ray starts an offset away from x, which brings a triangle seen at a grazing angle nearer by more than
            # that.
            end = distance - 4.0 * data.geometry.epsilon / np.maximum(np.abs(dot(lit.ng, wi)), 1e-5)
        else:
            radiance = radiance[rows]
        light = radiance
        if emitter.cast_shadow:
            light = light * _transmitted(data, paths, surface, wi, end, casts, rng)
    if owner is not None:
        rivals = np.array([mis_applies(instance.visibility, instance) for instance in data.scene.instances])
        scatter_pdf = np.where(rivals[owner[rows]], scatter_pdf, 0.0)
    elif not mis_applies(emitter.visibility, control) or getattr(emitter, "singular", False):
        scatter_pdf = np.zeros(count)
    density = pdf * data.light_samples + scatter_pdf
    light = scattered * light * np.where(pdf > 0.0, 1.0 / np.where(pdf > 0.0, density, 1.0), 0.0)[:, None]
    contribute(data, paths, light, paths.bounces[:, 0] + 1, samples, lamp=spans is not None)


def _scattered(data: SceneData, shading: Shading | Phase, wi: np.ndarray, emitter, owner: np.ndarray | None):
    """``shading.evaluate`` for the light of an emitter; for emissive triangles, ``owner`` (N,) is their
    instance."""
    if owner is None:
        return shading.evaluate(wi, emitter.visibility)
    scattered, pdf = np.zeros(wi.shape), np.zeros(len(wi))
    for visibility in {data.scene.instances[number].visibility for number in np.unique(owner)}:
        own = np.array([instance.visibility == visibility for instance in data.scene.instances])[owner]
        value, pdf = shading.evaluate(wi, visibility)
        scattered[own] = value[own]
    return scattered, pdf


def _casters(data: SceneData, control: Control, owner: np.ndarray | None, count: int) -> np.ndarray | None:
    """(N, instances) which of them cast the shadows of an emitter, or of the triangles of an ``owner``; None: all
    do."""
    if owner is None and control.blockers == ALL_SETS or owner is not None and not data.shadow_linking:
        return None
    sets = [instance.shadow_set for instance in data.scene.instances]
    masks = [control.blockers] if owner is None else [instance.blockers for instance in data.scene.instances]
    table = np.array([[mask >> number & 1 for number in sets] for mask in masks], bool)
    return table[np.zeros(count, int) if owner is None else owner]


def _transmitted(
    data: SceneData,
    paths: Paths,
    surface: Surface,
    wi: np.ndarray,
    end: np.ndarray,
    casts: np.ndarray | None,
    rng,
    radiance=None,
) -> np.ndarray:
    """Transmittance (N, 3) of media and of transparent surfaces, as many as the
    ``paths`` may still pass, from ``surface`` to the distance ``end`` along ``wi``. With ``radiance(start, end)``,
    instead the radiance along the way, each part times the transmittance up to there. ``casts`` as in ``_casters``."""
    count = len(end)
    transmittance, light = np.ones((count, 3)), np.zeros((count, 3))
    near, alive = np.zeros(count), np.arange(count)
    start = data.geometry.light_start(surface, wi)
    left = np.maximum(data.settings.transparent_bounces - paths.bounces[:, 4], 0)
    inside, media = paths.inside, data.media
    refused = np.stack([surface.number, np.full(count, NONE)], -1)
    if media.count and len(surface.instance) and (surface.instance >= 0).all():
        inside = media.crossed(inside, surface, dot(surface.ns, wi) < 0.0)
    while len(alive):
        mask = np.full(len(alive), int(Ray.SHADOW))
        hits = data.geometry.intersect(start[alive], wi[alive], (end - near)[alive], mask, refused[alive])
        found = hits.found
        reached = np.copy(end)
        reached[alive] = np.where(found, near[alive] + hits.distance, end[alive])
        stopped = np.zeros(0, int)
        if media.count:
            fly = media.transmittance if radiance is None else media.fly
            rays = Rays(start[alive], wi[alive], mask, paths.bounces[alive])
            flight = fly(rng, inside[alive], paths.channel[alive], rays, reached[alive] - near[alive])
            reached[alive] = near[alive] + flight.distance
        if radiance is not None:
            begin = np.full(count, np.inf)
            begin[alive] = near[alive]
            light += transmittance * radiance(begin, reached)
        if media.count:
            transmittance[alive] *= np.where(flight.collides, 0.0, flight.weight)[:, None]
            found, stopped = found & ~flight.collides & ~flight.stopped, alive[flight.stopped]
            near[stopped], start[stopped] = reached[stopped], rays.at(flight.distance)[flight.stopped]
        hits, alive = hits.select(found), alive[found]
        blocker = data.geometry.surface(hits, wi[alive])
        passes = data.materials.transparency(blocker)
        counts = np.ones(len(alive), bool) if casts is None else casts[alive, hits.instance]
        if media.count:
            counts &= ~media.only_bounds(blocker)
            inside = inside.copy()
            inside[alive] = media.crossed(inside[alive], blocker, counts >= 0)
        passes = passes * (left[alive] > 0)[:, None]
        transmittance[alive] *= np.where(counts[:, None], passes, 1.0)
        left[alive] -= counts
        refused[alive, 1] = blocker.number
        through = transmittance[alive].any(1)
        alive = alive[through]
        near[alive] = reached[alive]
        start[alive] = data.geometry.offset(blocker.position[through], blocker.ng[through], wi[alive])
        alive = np.concatenate([alive, stopped])
    return transmittance if radiance is None else light
