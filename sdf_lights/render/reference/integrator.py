# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing of a wave of rays: every step is one NumPy expression over all live paths.

The balance heuristic combines light sampling and BSDF sampling, for each emitter separately. At a vertex up to
``SPLIT`` emitters are sampled, each of them once if there are no more than that: choosing one at random would only add
noise.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..scene import Ray, Scene, catchers_only
from .bsdfs.ray_portal import THROUGH_PORTAL
from .gather import contribute, gather_emitters, gather_sky, gather_surface
from .geometry import Surface
from .hits import Hits
from .materials import Shading
from .media import Phase, points_of
from .next_event import sample_lights
from .paths import EVERY_SET, Paths, Samples, together
from .scene_data import SceneData
from .strands import NONE
from .subsurface import INSIDE, pass_below
from .varying_media import Rays

FIRST_ROULETTE = 3


class Integrator:
    """Traces paths through a scene. ``use_embree`` as in ``Geometry``; ``bare``: the scene has only the shadow catchers
    of another one."""

    def __init__(self, scene: Scene, use_embree: bool | None = None, bare: bool = False):
        self.data = SceneData(scene, use_embree)
        self.bare: Integrator | None = None
        if self.data.catchers.any() and not bare:
            self.bare = Integrator(catchers_only(self.data.scene), use_embree, True)
        self._caught: list[tuple[Paths, Hits]] = []

    def trace(self, x: np.ndarray, y: np.ndarray, rng: np.random.Generator, stop=lambda: False) -> Samples | None:
        """One sample for each of the pixels with the integer coordinates x, y (N,) of the full frame; None if
        stopped."""
        count = len(x)
        samples = Samples(count)
        origin, direction, near, far = self.data.camera.rays(x, y, rng)
        start, carried = origin + near[:, None] * direction, np.ones((count, 3))
        inside, channel = self.data.media.outside(count), np.zeros(count, int)
        if self.data.media.count:
            inside, channel = self.data.media.around(start), rng.integers(3, size=count)
            carried = 3.0 * np.eye(3)[channel]
        paths = Paths(
            np.arange(count),
            origin,
            start,
            direction,
            near,
            far,
            np.where(far < 0.0, 0.0, 1.0)[:, None] * carried,
            np.zeros(count),
            np.full(count, int(Ray.CAMERA)),
            np.zeros((count, 5), int),
            np.zeros(count, bool),
            np.zeros(count, bool),
            np.full(count, np.inf),
            np.full(count, EVERY_SET),
            inside,
            channel,
            np.zeros(count, int),
            np.full(count, NONE),
            np.zeros(count, bool),
        )
        while len(paths.sample):
            if stop():
                return None
            paths = self._step(paths, samples, rng)
        return samples if self.bare is None else self._trace_catchers(samples, rng, stop)

    def _trace_catchers(self, samples: Samples, rng: np.random.Generator, stop) -> Samples | None:
        """Follow the paths that have hit catchers through the scene with only catchers."""
        alone = Samples(len(samples.alpha))
        for paths, hits in self._caught:
            paths.inside = self.bare.data.media.outside(len(paths.sample))
            paths = self.bare._meet(paths, hits, paths.near + hits.distance, alone, rng)
            while len(paths.sample):
                if stop():
                    return None
                paths = self.bare._step(paths, alone, rng)
        self._caught = []
        samples.bare = alone.combined
        samples.uncaught = np.where(samples.caught, samples.uncaught, samples.alpha)
        return samples

    def _catch(self, paths: Paths, hits: Hits, samples: Samples) -> None:
        """Keep the paths that hit their first shadow catcher."""
        met = (
            (paths.kind == Ray.CAMERA)
            & self.data.catchers[hits.instance]
            & ~self.data.holdout[hits.instance]
            & ~paths.catches
        )
        if self.bare is None or not met.any():
            return
        part = paths.select(np.flatnonzero(met))
        self._caught.append((part, hits.select(met)))
        rows = part.sample
        samples.caught[rows] = True
        samples.uncaught[rows] = np.maximum(samples.alpha[rows] - part.throughput.mean(1), 0.0)
        if (
            not self.data.settings.transparent_film
            and not self.data.sky.black
            and self.data.sky.visibility & Ray.CAMERA
        ):
            samples.backdrop[rows] = part.throughput * self.data.sky.radiance(part.direction, part.kind)
        paths.catches = paths.catches | met

    def _step(self, paths: Paths, samples: Samples, rng: np.random.Generator) -> Paths:
        """Trace all paths to their next surface, add emission, scatter; returns the continuing paths."""
        hits = self.data.geometry.intersect(
            paths.start, paths.direction, paths.far - paths.near, paths.kind, paths.left[:, None]
        )
        end = np.minimum(paths.near + hits.distance, paths.far)
        if self.data.media.count:
            return self._step_in_media(paths, hits, end, samples, rng)
        gather_emitters(self.data, paths, end, samples)
        found = hits.found
        gather_sky(self.data, paths.select(~found), samples)
        paths, end, hits = paths.select(found), end[found], hits.select(found)
        self._catch(paths, hits, samples)
        return self._meet(paths, hits, end, samples, rng)

    def _step_in_media(self, paths: Paths, hits: Hits, end: np.ndarray, samples: Samples, rng) -> Paths:
        """As ``_step``, for rays that may collide before they hit a surface at the distances ``end``."""
        found = hits.found
        # An open mesh does not fill infinite space.
        paths.inside = np.where(found[:, None], paths.inside, self.data.media.outside(len(found)))
        begin = paths.origin + paths.near[:, None] * paths.direction
        rays = Rays(begin, paths.direction, paths.kind, paths.bounces)
        flight = self.data.media.fly(rng, paths.inside, paths.channel, rays, end - paths.near)
        collides, stopped, end = flight.collides, flight.stopped, paths.near + flight.distance
        gather_emitters(self.data, paths, end, samples)
        contribute(self.data, paths, flight.glow, paths.bounces[:, 0], samples)
        paths.throughput = paths.throughput * flight.weight[:, None]
        gather_sky(self.data, paths.select(~found & ~collides & ~stopped), samples)
        parts = [self._scatter_in_medium(paths.select(collides), end[collides], samples, rng)]
        part = paths.select(stopped)
        part.near, part.start = end[stopped], part.origin + end[stopped, None] * part.direction
        parts.append(part)
        met = np.flatnonzero(found & ~collides & ~stopped)
        paths, end, hits = paths.select(met), end[met], hits.select(met)
        surface = self.data.geometry.surface(hits, paths.direction)
        only = self.data.media.only_bounds(surface)
        there, there_end = np.flatnonzero(~only), end[~only]
        part = paths.select(there)
        self._catch(part, hits.select(there), samples)
        parts.append(self._meet(part, hits.select(there), there_end, samples, rng))
        paths, surface = paths.select(only), surface.select(only)
        paths.inside = self.data.media.crossed(paths.inside, surface, np.ones(len(paths.sample), bool))
        paths.near, paths.start = end[only], self.data.geometry.offset(surface.position, surface.ng, paths.direction)
        paths.left = surface.number
        return together([*parts, paths])

    def _scatter_in_medium(self, paths: Paths, end: np.ndarray, samples: Samples, rng) -> Paths:
        """The paths that continue from collisions at the distances ``end``."""
        position = paths.origin + end[:, None] * paths.direction
        rays = Rays(position, paths.direction, paths.kind, paths.bounces)
        albedo, weights = self.data.media.scattering(paths.inside, paths.channel, rays, position)
        rows = np.flatnonzero(~paths.last & (albedo > 0.0))
        paths, position, weights = paths.select(rows), position[rows], weights[rows]
        paths.throughput = paths.throughput * albedo[rows, None]
        points = points_of(position, paths.direction)
        phase = Phase(self.data.media, paths.inside, weights, paths.direction)
        sample_lights(self.data, paths, points, phase, samples, rng)
        wi = phase.sample(rng)
        value, pdf = phase.evaluate(wi)
        bounces = paths.bounces + (np.arange(5) == 0)
        volume = paths.volume + 1
        return dataclasses.replace(
            paths,
            origin=position,
            start=position,
            direction=wi,
            near=np.zeros(len(rows)),
            far=np.full(len(rows), np.inf),
            throughput=paths.throughput * value / pdf[:, None],
            pdf=pdf,
            kind=np.full(len(rows), int(Ray.VOLUME)),
            bounces=bounces,
            volume=volume,
            last=(bounces[:, 0] > self.data.settings.max_bounces) | (volume > self.data.settings.volume_bounces),
            least_pdf=np.minimum(paths.least_pdf, pdf),
            light_set=self.data.media.light_set(paths.inside),
            left=np.full(len(rows), NONE),
            stopped=np.zeros(len(rows), bool),
        )

    def _meet(self, paths: Paths, hits: Hits, end: np.ndarray, samples: Samples, rng: np.random.Generator) -> Paths:
        """Scatter paths at the surfaces that they have hit, at the distances ``end``; returns the continuing ones."""
        surface = self.data.geometry.surface(hits, paths.direction)
        surface.ray_kind, surface.depth, surface.ray_pdf = paths.kind, paths.bounces, paths.pdf
        surface.ray_singular = (paths.pdf <= 0.0) & (paths.kind != Ray.CAMERA)

        camera = paths.kind == Ray.CAMERA
        held = camera & self.data.holdout[surface.instance]
        shading = self.data.materials.shade(
            surface, end * self.data.camera.pixel_angle + self.data.camera.pixel_width, rng
        )
        shading.darken_microfacets(
            paths.kind == Ray.DIFFUSE, self.data.settings.caustics_reflective, self.data.settings.caustics_refractive
        )
        shading.blur(paths.least_pdf, self.data.settings.filter_glossy)
        weight = np.where(held, 1.0, shading.holdout) * camera * paths.throughput.mean(1)
        samples.alpha[paths.sample] -= weight
        rows = np.flatnonzero(~held)
        paths, surface, shading, end = paths.select(rows), surface.select(rows), shading.select(rows), end[rows]

        gather_surface(self.data, paths, surface, shading, end, samples)
        self._record(paths, surface, shading, end, samples)
        bright = ~paths.last & shading.scatters
        sample_lights(self.data, paths.select(bright), surface.select(bright), shading.select(bright), samples, rng)
        return self._scatter(paths, surface, shading, end, samples, rng)

    def _record(self, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples) -> None:
        """Data passes: the first surface that the camera sees and that is solid enough."""
        camera = paths.kind == Ray.CAMERA
        samples.diffuse_albedo[paths.sample[camera]] += (paths.throughput * shading.diffuse_albedo)[camera]
        first = camera & (shading.transparency.mean(1) <= self.data.scene.clearest) & ~samples.found[paths.sample]
        rows = paths.sample[first]
        samples.found[rows], samples.depth[rows] = True, end[first]
        samples.position[rows], samples.normal[rows] = surface.position[first], surface.ns[first]
        samples.albedo[rows] = shading.albedo[first]

    def _emerge(self, paths: Paths, surface: Surface, entered: list, wi, weight, samples: Samples, rng) -> Paths:
        """The paths that continue from the exits of light that has ``entered`` surfaces along wi; lights are sampled
        there."""
        emerged = [paths.select(np.zeros(0, int))]
        for rows, lobe in entered:
            alive = ~paths.last[rows] & (weight[rows].max(1) > 0.0)
            rows, lobe = rows[alive], lobe.select(np.flatnonzero(alive))
            part = paths.select(rows)
            hits, direction, throughput = pass_below(
                self.data.geometry, lobe, surface.select(rows), wi[rows], part.throughput * weight[rows], rng
            )
            part.throughput = throughput
            found = np.flatnonzero(hits.found)
            hits, part = hits.select(found), part.select(found)
            exits = self.data.geometry.surface(hits, -direction[found])
            exits.ray_kind, exits.depth = np.zeros(len(found), int), part.bounces
            shading = self.data.materials.exits(exits, np.zeros(len(found)))
            sample_lights(self.data, part, exits, shading, samples, rng)
            emerged.append(self._scatter(part, exits, shading, np.zeros(len(found)), samples, rng))
        return together(emerged)

    def _scatter(
        self, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples, rng
    ) -> Paths:
        """The paths that continue from their surfaces. Those that only gather emission go straight on or end."""
        wi, weight, pdf, kind = shading.sample(rng)
        below = ~paths.last & ((kind & INSIDE) != 0)
        if below.any():
            emerged = self._emerge(paths, surface, shading.entered, wi, weight, samples, rng)
            weight = np.where(below[:, None], 0.0, weight)
            return together([self._go_on(paths, surface, shading, end, wi, weight, pdf, kind, rng), emerged])
        return self._go_on(paths, surface, shading, end, wi, weight, pdf, kind, rng)

    def _go_on(self, paths: Paths, surface: Surface, shading: Shading, end, wi, weight, pdf, kind, rng) -> Paths:
        """The paths that are scattered along wi, or go straight on."""
        # Paths that only gather emission go straight on; with a portal, by chance.
        gathers = paths.last & ~shading.portal
        straight, through = gathers | (kind == 0), ~gathers & (kind == THROUGH_PORTAL)
        passes = straight | through
        weight = np.where(gathers[:, None], shading.transparency, weight)
        weight = np.where((paths.last & ~passes)[:, None], 0.0, weight)
        throughput = paths.throughput * weight
        bounces = paths.bounces.copy()
        for column, bit in enumerate((Ray.ALL, Ray.DIFFUSE, Ray.GLOSSY, Ray.TRANSMISSION)):
            bounces[:, column] += ~passes & ((kind & bit) != 0)
        bounces[:, 4] += passes
        settings = self.data.settings
        limits = np.array(
            [settings.max_bounces, settings.diffuse_bounces, settings.glossy_bounces, settings.transmission_bounces]
        )
        passed_all = bounces[:, 4] >= settings.transparent_bounces
        alive = throughput.any(1) & ~(paths.last & (paths.bounces[:, 4] >= max(settings.transparent_bounces, 1)))
        last = paths.last | (bounces[:, :4] > limits).any(1) | (passes & passed_all)
        roulette = ~passes & ~last & (bounces[:, 0] >= FIRST_ROULETTE)
        survival = np.where(roulette, np.clip(np.abs(throughput).max(1), 1e-300, 1.0), 1.0)
        alive &= rng.random(len(survival)) < survival
        throughput = throughput / survival[:, None]
        direction = np.where(straight[:, None], paths.direction, wi)
        material = self.data.geometry.material(surface.instance, surface.triangle)
        away = through & (((shading.exit - surface.position) ** 2).sum(1) > 1e-9)
        start = np.where(
            away[:, None], shading.exit, self.data.geometry.offset(surface.position, surface.ng, direction)
        )
        return Paths(
            paths.sample,
            np.where(straight[:, None], paths.origin, np.where(through[:, None], shading.exit, surface.position)),
            start,
            direction,
            np.where(straight, end, 0.0),
            np.where(straight, paths.far, np.inf),
            throughput,
            np.where(passes & shading.portal, 0.0, np.where(straight, paths.pdf, pdf)),
            np.where(passes, paths.kind, kind),
            bounces,
            last,
            paths.catches,
            np.where(passes | (pdf <= 0.0), paths.least_pdf, np.minimum(paths.least_pdf, pdf)),
            np.where(passes, paths.light_set, self.data.light_sets[surface.instance]),
            self.data.media.crossed(paths.inside, surface, passes | ((kind & Ray.TRANSMISSION) != 0)),
            paths.channel,
            paths.volume,
            surface.number,
            passes & (paths.stopped | self.data.materials.stops[material]),
        ).select(alive)
