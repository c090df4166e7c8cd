# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing of a wave of rays: every step is one NumPy expression over all live paths.

The balance heuristic combines light sampling and BSDF sampling, for each emitter separately. At a vertex up to
``SPLIT`` emitters are sampled, each of them once if there are no more than that: choosing one at random would only add
noise.
"""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass

import numpy as np

from ..scene import ALL_SETS, OPEN_SET, Primitive, Ray, Scene, catchers_only
from ..scene import Emitter as Control
from .bsdfs.ray_portal import THROUGH_PORTAL
from .camera_rays import Camera
from .geometry import Geometry, Surface
from .hits import Hits
from .lights import Emitter, Sky, Triangles, blender_light
from .materials import Materials, Shading
from .media import Media, Phase, points_of
from .sdf_lamps import SdfLamp
from .strands import NONE
from .subsurface import INSIDE, pass_below
from .vectors import dot

SPLIT = 8
NO_CONTROL = Control()
FIRST_ROULETTE = 3


@dataclass
class Paths:
    """Live paths, as rows of arrays. ``sample`` is the row of ``Samples`` to which a path adds.

    ``origin`` is the point of the last scattering, with the density ``pdf`` (0: singular, or the camera), and ``kind``
    the kind of ray. ``near`` is the distance along the ray through transparent surfaces so far, ``start`` the point
    there.
    """

    sample: np.ndarray
    origin: np.ndarray
    start: np.ndarray
    direction: np.ndarray
    near: np.ndarray
    far: np.ndarray
    throughput: np.ndarray
    pdf: np.ndarray
    kind: np.ndarray
    bounces: np.ndarray  # (N, 5): all, diffuse, glossy, transmission, transparent
    last: np.ndarray  # only gathers emission
    catches: np.ndarray  # has hit a shadow catcher
    least_pdf: np.ndarray  # of all directions so far that are not singular
    light_set: np.ndarray  # of the instance of the last scattering; EVERY_SET for the camera
    inside: np.ndarray  # (N, columns of ``Media``): the media around
    channel: np.ndarray  # of RGB, which alone has light in a scene with media
    volume: np.ndarray  # bounces in media
    left: np.ndarray  # number of the curve or sphere that the ray leaves, which it does not hit again

    def select(self, rows: np.ndarray) -> "Paths":
        """Some of the paths, given as indices or as a mask."""
        return Paths(**{name: value[rows] for name, value in vars(self).items()})


def _together(parts: list[Paths]) -> Paths:
    return Paths(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


EVERY_SET = -1


def competes(visibility: Ray, control: Control = NO_CONTROL) -> bool:
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


class Samples:
    """The contribution of one sample of each of ``count`` pixels to the passes."""

    def __init__(self, count: int):
        self.combined, self.lamps, self.emission, self.environment = np.zeros((4, count, 3))
        self.position, self.normal, self.albedo, self.diffuse_albedo = np.zeros((4, count, 3))
        self.alpha, self.depth, self.found = np.ones(count), np.zeros(count), np.zeros(count, bool)
        # Of shadow catchers: see ``passes.CATCHER_SUMS``, and the light of paths that have hit one.
        self.bare, self.backdrop, self.light = np.zeros((3, count, 3))
        self.caught, self.uncaught = np.zeros(count, bool), np.zeros(count)


class Integrator:
    """The scene in the form that paths need. ``use_embree`` as in ``Geometry``; ``bare``: the scene has only the shadow
    catchers of another one."""

    def __init__(self, scene: Scene, use_embree: bool | None = None, bare: bool = False):
        self.scene, self.settings = scene, scene.settings
        self.geometry = Geometry(scene, use_embree)
        self.materials = Materials(scene, self.geometry)
        self.media = Media(scene, self.geometry)
        self.camera = Camera(scene)
        self.lamps: list[SdfLamp] = []
        for lamp in scene.lamps:
            try:
                self.lamps.append(SdfLamp(lamp))
            except ValueError as error:
                scene.warnings.append(f"The SDF lamp {lamp.name!r} is left out: {error}.")
        self.lights: list[Emitter] = [blender_light(light, scene) for light in scene.lights]
        self.sky = Sky(scene.world, scene)
        self.control: dict[int, Control] = {
            id(emitter): source
            for emitter, source in [*((lamp, lamp.lamp) for lamp in self.lamps), *zip(self.lights, scene.lights)]
        }
        self.control[id(self.sky)] = Control(max_bounces=scene.world.max_bounces)
        instances = scene.instances
        self.light_sets = np.array([*(instance.light_set for instance in instances), OPEN_SET], int)
        self.shadow_linking = any(instance.blockers != ALL_SETS for instance in instances)
        self.triangles = self._emissive_triangles()
        # The emitters for light sampling.
        self.emitters = [*self.lamps, *self.lights]
        if not self.sky.black:
            self.emitters.append(self.sky)
        if self.triangles is not None:
            self.emitters.append(self.triangles)
        self.holdout = np.array([i.holdout for i in scene.instances] or [False])
        self.catchers = np.array([i.catcher for i in scene.instances] or [False])
        self.bare: Integrator | None = None
        if self.catchers.any() and not bare:
            self.bare = Integrator(catchers_only(scene), use_embree, True)
        self._caught: list[tuple[Paths, Hits]] = []

    def _emissive_triangles(self) -> Triangles | None:
        """The emissive triangles for light sampling; others are found only by chance."""
        geometry, instances, triangles, corners = self.geometry, [], [], []
        for index, instance in enumerate(self.scene.instances):
            mesh = self.scene.meshes[instance.mesh]
            # Curves and spheres are only found by chance, as in Cycles.
            rows = np.arange(len(mesh.triangles) if mesh.primitive == Primitive.TRIANGLES else 0)
            material = geometry.material(np.full(len(rows), index), rows)
            rows = rows[self.materials.emissive[material]] if len(rows) else rows
            instances.append(np.full(len(rows), index))
            triangles.append(rows)
            local = geometry.corners[geometry.first[instance.mesh] + rows]
            matrix = geometry.matrices[index]
            corners.append(local @ matrix[:3, :3].T + matrix[:3, 3])
        if not sum(map(len, triangles)):
            return None
        return Triangles(*map(np.concatenate, (instances, triangles, corners)))

    # --- the loop -----------------------------------------------------------------------------------------------------

    def trace(self, x: np.ndarray, y: np.ndarray, rng: np.random.Generator, stop=lambda: False) -> Samples | None:
        """One sample for each of the pixels with the integer coordinates x, y of the full frame; None if stopped."""
        count = len(x)
        samples = Samples(count)
        origin, direction, near, far = self.camera.rays(x, y, rng)
        start, carried = origin + near[:, None] * direction, np.ones((count, 3))
        inside, channel = self.media.outside(count), np.zeros(count, int)
        if self.media.count:
            inside, channel = self.media.around(start), rng.integers(3, size=count)
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
            paths.inside = self.bare.media.outside(len(paths.sample))
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
        met = (paths.kind == Ray.CAMERA) & self.catchers[hits.instance] & ~self.holdout[hits.instance] & ~paths.catches
        if self.bare is None or not met.any():
            return
        part = paths.select(np.flatnonzero(met))
        self._caught.append((part, hits.select(met)))
        rows = part.sample
        samples.caught[rows] = True
        samples.uncaught[rows] = np.maximum(samples.alpha[rows] - part.throughput.mean(1), 0.0)
        if not self.settings.transparent_film and not self.sky.black and self.sky.visibility & Ray.CAMERA:
            samples.backdrop[rows] = part.throughput * self.sky.radiance(part.direction, part.kind)
        paths.catches = paths.catches | met

    def _step(self, paths: Paths, samples: Samples, rng: np.random.Generator) -> Paths:
        """Trace all paths to their next surface, add emission, scatter; returns the continuing paths."""
        hits = self.geometry.intersect(
            paths.start, paths.direction, paths.far - paths.near, paths.kind, paths.left[:, None]
        )
        end = np.minimum(paths.near + hits.distance, paths.far)
        if self.media.count:
            return self._step_in_media(paths, hits, end, samples, rng)
        self._gather_emitters(paths, end, samples)
        found = hits.found
        self._gather_sky(paths.select(~found), samples)
        paths, end, hits = paths.select(found), end[found], hits.select(found)
        self._catch(paths, hits, samples)
        return self._meet(paths, hits, end, samples, rng)

    def _step_in_media(self, paths: Paths, hits: Hits, end: np.ndarray, samples: Samples, rng) -> Paths:
        """As ``_step``, for rays that may collide before they hit a surface at the distances ``end``."""
        found = hits.found
        # An open mesh does not fill infinite space.
        paths.inside = np.where(found[:, None], paths.inside, self.media.outside(len(found)))
        collision = paths.near + self.media.free_path(rng, paths.inside, paths.channel)
        collides, end = collision < end, np.minimum(collision, end)
        self._gather_emitters(paths, end, samples)
        glow = self.media.emission(paths.inside)
        length = np.where(glow.any(1), end - paths.near, 0.0)
        self._contribute(paths, glow * length[:, None], paths.bounces[:, 0], samples)
        self._gather_sky(paths.select(~found & ~collides), samples)
        parts = [self._scatter_in_medium(paths.select(collides), end[collides], samples, rng)]
        met = np.flatnonzero(found & ~collides)
        paths, end, hits = paths.select(met), end[met], hits.select(met)
        surface = self.geometry.surface(hits, paths.direction)
        only = self.media.only_bounds(surface)
        there, there_end = np.flatnonzero(~only), end[~only]
        part = paths.select(there)
        self._catch(part, hits.select(there), samples)
        parts.append(self._meet(part, hits.select(there), there_end, samples, rng))
        paths, surface = paths.select(only), surface.select(only)
        paths.inside = self.media.crossed(paths.inside, surface, np.ones(len(paths.sample), bool))
        paths.near, paths.start = end[only], self.geometry.offset(surface.position, surface.ng, paths.direction)
        paths.left = surface.number
        return _together([*parts, paths])

    def _scatter_in_medium(self, paths: Paths, end: np.ndarray, samples: Samples, rng) -> Paths:
        """The paths that continue from collisions at the distances ``end``."""
        albedo = self.media.albedo(paths.inside, paths.channel)
        rows = np.flatnonzero(~paths.last & (albedo > 0.0))
        paths, end = paths.select(rows), end[rows]
        paths.throughput = paths.throughput * albedo[rows, None]
        position = paths.origin + end[:, None] * paths.direction
        points, phase = points_of(position, paths.direction), Phase(self.media, paths.inside, paths.direction)
        self._sample_lights(paths, points, phase, samples, rng)
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
            last=(bounces[:, 0] > self.settings.max_bounces) | (volume > self.settings.volume_bounces),
            least_pdf=np.minimum(paths.least_pdf, pdf),
            light_set=self.media.light_set(paths.inside),
            left=np.full(len(rows), NONE),
        )

    def _meet(self, paths: Paths, hits: Hits, end: np.ndarray, samples: Samples, rng: np.random.Generator) -> Paths:
        """Scatter paths at the surfaces that they have hit, at the distances ``end``; returns the continuing ones."""
        surface = self.geometry.surface(hits, paths.direction)
        surface.ray_kind, surface.depth, surface.ray_pdf = paths.kind, paths.bounces, paths.pdf
        surface.ray_singular = (paths.pdf <= 0.0) & (paths.kind != Ray.CAMERA)

        camera = paths.kind == Ray.CAMERA
        held = camera & self.holdout[surface.instance]
        shading = self.materials.shade(surface, end * self.camera.pixel_angle + self.camera.pixel_width, rng)
        shading.darken_microfacets(
            paths.kind == Ray.DIFFUSE, self.settings.caustics_reflective, self.settings.caustics_refractive
        )
        shading.blur(paths.least_pdf, self.settings.filter_glossy)
        weight = np.where(held, 1.0, shading.holdout) * camera * paths.throughput.mean(1)
        samples.alpha[paths.sample] -= weight
        rows = np.flatnonzero(~held)
        paths, surface, shading, end = paths.select(rows), surface.select(rows), shading.select(rows), end[rows]

        self._gather_surface(paths, surface, shading, end, samples)
        self._record(paths, surface, shading, end, samples)
        bright = ~paths.last & shading.scatters
        self._sample_lights(paths.select(bright), surface.select(bright), shading.select(bright), samples, rng)
        return self._scatter(paths, surface, shading, end, samples, rng)

    # --- emission that a ray meets ------------------------------------------------------------------------------------

    def _weight(
        self, paths: Paths, light_pdf: np.ndarray, visibility: Ray = Ray.ALL, control: Control = NO_CONTROL
    ) -> np.ndarray:
        """Balance heuristic for emission that rays have hit, with the density ``paths.pdf``; 1 if that is 0."""
        pdf = paths.pdf
        if not competes(visibility, control):
            return np.where(pdf > 0.0, 0.0, 1.0)
        light_pdf = light_pdf * self._share
        weight = np.where(pdf > 0.0, pdf / np.where(pdf > 0.0, pdf + light_pdf, 1.0), 1.0)
        return np.where((pdf > 0.0) & (paths.bounces[:, 0] - 1 > control.max_bounces), 0.0, weight)

    def _sees(self, paths: Paths, emitter, control: Control) -> np.ndarray:
        """(N,) whether the rays can hit an emitter."""
        kinds = emitter.visibility & (Ray.CAMERA if control.sampled_only else Ray.ALL)
        return ((paths.kind & kinds) != 0) & is_lit(control.receivers, paths.light_set)

    @property
    def _share(self) -> float:
        """Mean number of light samples of an emitter at a vertex."""
        return min(len(self.emitters), SPLIT) / max(len(self.emitters), 1)

    def _contribute(
        self, paths: Paths, radiance: np.ndarray, scatters: np.ndarray, samples: Samples, lamp=False, sky=False
    ):
        value = paths.throughput * radiance
        for limit, which in ((self.settings.clamp_direct, scatters <= 1), (self.settings.clamp_indirect, scatters > 1)):
            if limit > 0.0:
                value = value * np.where(which, np.minimum(1.0, limit / np.maximum(value.sum(1), 1e-300)), 1.0)[:, None]
        samples.combined[paths.sample] += value
        samples.light[paths.sample] += value * paths.catches[:, None]
        own = value * ~paths.catches[:, None]
        if lamp:
            samples.lamps[paths.sample] += own
        seen = samples.environment if sky else samples.emission
        seen[paths.sample] += own * (scatters == 0)[:, None]

    def _gather_emitters(self, paths: Paths, end: np.ndarray, samples: Samples) -> None:
        """Lamps and lights along the rays, up to the distance ``end``."""
        count = len(end)
        for lamp in self.lamps:
            spans = lamp.spans(paths.origin, paths.direction)
            control = self.control[id(lamp)]
            weight = self._sees(paths, lamp, control) * self._weight(
                paths, lamp.pdf(spans, count), lamp.visibility, control
            )
            radiance = lamp.radiance(spans, paths.origin, paths.direction, paths.near, end)
            weight = np.where(paths.kind == Ray.CAMERA, lamp.lamp.camera_brightness, 1.0) * weight
            self._contribute(paths, radiance * weight[:, None], paths.bounces[:, 0], samples, lamp=True)
        for light in self.lights:
            distance, radiance, pdf = light.hit(paths.origin, paths.direction)
            radiance = light.modulated(radiance, paths.origin, paths.direction, distance, paths.kind)
            met = (distance > paths.near) & ((distance < end) | ~np.isfinite(end) & np.isfinite(distance))
            control = self.control[id(light)]
            met &= self._sees(paths, light, control)
            weight = met * self._weight(paths, pdf, light.visibility, control)
            self._contribute(paths, radiance * weight[:, None], paths.bounces[:, 0], samples)

    def _gather_sky(self, paths: Paths, samples: Samples) -> None:
        if self.settings.transparent_film:
            camera = paths.kind == Ray.CAMERA
            samples.alpha[paths.sample] -= camera * paths.throughput.mean(1)
            hidden = paths.select(camera & ~paths.catches & ((self.sky.visibility & Ray.CAMERA) != 0))
            if len(hidden.sample) and not self.sky.black:
                radiance = self.sky.radiance(hidden.direction, hidden.kind)
                samples.environment[hidden.sample] += hidden.throughput * radiance
            paths = paths.select(~camera)
        if self.sky.black:
            return
        visible = (paths.kind & self.sky.visibility) != 0
        weight = visible * self._weight(
            paths, self.sky.pdf(paths.direction), self.sky.visibility, self.control[id(self.sky)]
        )
        radiance = self.sky.radiance(paths.direction, paths.kind) * weight[:, None]
        self._contribute(paths, radiance, paths.bounces[:, 0], samples, sky=True)

    def _gather_surface(self, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples):
        weight = np.ones(len(end))
        if self.triangles is not None:
            known = self.materials.emissive[self.geometry.material(surface.instance, surface.triangle)]
            known &= surface.number == NONE
            density = self.triangles.density(end, np.abs(dot(surface.ng, surface.wo)))
            weight = np.where(known, self._surface_weight(paths, surface, density), 1.0)
        for index in np.unique(surface.instance) if len(end) else ():
            rows = surface.instance == index
            weight[rows] *= is_lit(self.scene.instances[index].receivers, paths.light_set[rows])
        self._contribute(paths, shading.emission * weight[:, None], paths.bounces[:, 0], samples)

    def _surface_weight(self, paths: Paths, surface: Surface, density: np.ndarray) -> np.ndarray:
        """As ``_weight``, for the emissive triangles that were hit: each instance has its own visibility and
        linking."""
        weight = np.ones(len(density))
        for index in np.unique(surface.instance) if len(density) else ():
            instance, rows = self.scene.instances[index], np.flatnonzero(surface.instance == index)
            weight[rows] = self._weight(paths.select(rows), density[rows], instance.visibility, instance)
        return weight

    def _record(self, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples) -> None:
        """Data passes: the first surface that the camera sees and that is more solid than transparent."""
        camera = paths.kind == Ray.CAMERA
        samples.diffuse_albedo[paths.sample[camera]] += (paths.throughput * shading.diffuse_albedo)[camera]
        first = camera & (shading.transparency.mean(1) < 0.5) & ~samples.found[paths.sample]
        rows = paths.sample[first]
        samples.found[rows], samples.depth[rows] = True, end[first]
        samples.position[rows], samples.normal[rows] = surface.position[first], surface.ns[first]
        samples.albedo[rows] = shading.albedo[first]

    # --- light sampling -----------------------------------------------------------------------------------------------

    def _sample_lights(self, paths: Paths, surface: Surface, shading: Shading, samples: Samples, rng) -> None:
        """Next event estimation: the k-th of ``rounds`` draws is uniform in the k-th part of the list of emitters."""
        total, count = len(self.emitters), len(paths.sample)
        rounds = min(total, SPLIT)
        for k in range(rounds):
            choice = np.minimum(((k + rng.random(count)) * total / rounds).astype(int), total - 1)
            for index in np.unique(choice):
                rows = np.flatnonzero(choice == index)
                part = paths.select(rows), surface.select(rows), shading.select(rows)
                self._sample_emitter(self.emitters[index], *part, samples, rng)

    def _sample_emitter(self, emitter, paths, surface, shading, samples, rng) -> None:
        control = self.control.get(id(emitter), NO_CONTROL)
        sets = self.light_sets[surface.instance]
        if isinstance(shading, Phase):
            sets = self.media.light_set(shading.inside)
        lit = is_lit(control.receivers, sets)
        lit &= paths.bounces[:, 0] <= control.max_bounces
        paths, surface, shading = (part.select(np.flatnonzero(lit)) for part in (paths, surface, shading))
        sets = sets[lit]
        x, count = surface.position, len(paths.sample)
        spans = hits = owner = None
        if isinstance(emitter, SdfLamp):
            wi = emitter.sample(rng, x)
        elif emitter is self.triangles:
            wi, distance, pdf, index, u, v = emitter.sample_points(rng, x)
            owner = emitter.instances[index]
            hits = Hits(distance, owner, emitter.triangles[index], u, v, x + distance[:, None] * wi)
        else:
            wi, distance, radiance, pdf = emitter.sample(rng, x)
            radiance = emitter.modulated(radiance, x, wi, distance, 0)
        scattered, scatter_pdf = self._scattered(shading, wi, emitter, owner)
        seen = scattered.max(1) > 0.0
        if owner is not None:
            for number in np.unique(owner):
                receivers = self.scene.instances[number].receivers
                seen &= (owner != number) | is_lit(receivers, sets)
        rows = np.flatnonzero(seen)
        paths, surface, x, wi = paths.select(rows), surface.select(rows), x[rows], wi[rows]
        scattered, scatter_pdf, count = scattered[rows], scatter_pdf[rows], len(rows)
        casts = self._casters(control, None if owner is None else owner[rows], count)
        if isinstance(emitter, SdfLamp):
            spans = emitter.spans(x, wi)
            pdf = emitter.pdf(spans, count)
            last = np.zeros(count)
            np.maximum.at(last, spans.ray, spans.far)
            radiance = functools.partial(emitter.radiance, spans, x, wi)
            light = self._march(paths, surface, wi, last, casts, rng, radiance)
        else:
            pdf, distance = pdf[rows], distance[rows]
            end = distance - 4.0 * self.geometry.epsilon
            if hits is not None:
                hits = hits.select(rows)
                lit = self.geometry.surface(hits, wi)
                lit.depth = paths.bounces
                radiance = self.materials.shade(lit, np.zeros(count)).emission
                # The ray starts an offset away from x, which brings a triangle seen at a grazing angle nearer by more than that.
                end = distance - 4.0 * self.geometry.epsilon / np.maximum(np.abs(dot(lit.ng, wi)), 1e-5)
            else:
                radiance = radiance[rows]
            light = radiance
            if emitter.cast_shadow:
                light = light * self._march(paths, surface, wi, end, casts, rng)
        if owner is not None:
            rivals = np.array([competes(instance.visibility, instance) for instance in self.scene.instances])
            scatter_pdf = np.where(rivals[owner[rows]], scatter_pdf, 0.0)
        elif not competes(emitter.visibility, control) or getattr(emitter, "singular", False):
            scatter_pdf = np.zeros(count)
        density = pdf * self._share + scatter_pdf
        light = scattered * light * np.where(pdf > 0.0, 1.0 / np.where(pdf > 0.0, density, 1.0), 0.0)[:, None]
        self._contribute(paths, light, paths.bounces[:, 0] + 1, samples, lamp=spans is not None)

    def _scattered(self, shading: Shading | Phase, wi: np.ndarray, emitter, owner: np.ndarray | None):
        """``shading.evaluate`` for the light of an emitter; for emissive triangles, ``owner`` (N,) is their
        instance."""
        if owner is None:
            return shading.evaluate(wi, emitter.visibility)
        scattered, pdf = np.zeros(wi.shape), np.zeros(len(wi))
        for visibility in {self.scene.instances[number].visibility for number in np.unique(owner)}:
            own = np.array([instance.visibility == visibility for instance in self.scene.instances])[owner]
            value, pdf = shading.evaluate(wi, visibility)
            scattered[own] = value[own]
        return scattered, pdf

    def _casters(self, control: Control, owner: np.ndarray | None, count: int) -> np.ndarray | None:
        """(N, instances) which of them cast the shadows of an emitter, or of the triangles of an ``owner``; None: all
        do."""
        if owner is None and control.blockers == ALL_SETS or owner is not None and not self.shadow_linking:
            return None
        sets = [instance.shadow_set for instance in self.scene.instances]
        masks = [control.blockers] if owner is None else [instance.blockers for instance in self.scene.instances]
        table = np.array([[mask >> number & 1 for number in sets] for mask in masks], bool)
        return table[np.zeros(count, int) if owner is None else owner]

    def _march(
        self,
        paths: Paths,
        surface: Surface,
        wi: np.ndarray,
        end: np.ndarray,
        casts: np.ndarray | None,
        rng,
        radiance=None,
    ) -> np.ndarray:
        """Transmittance (N, 3) of media and of transparent surfaces, as many as the ``paths`` may still pass, from ``surface`` to
        the distance ``end`` along ``wi``. With ``radiance(start, end)``, instead the radiance along the way, each part
        times the transmittance up to there. ``casts`` as in ``_casters``."""
        count = len(end)
        transmittance, light = np.ones((count, 3)), np.zeros((count, 3))
        near, alive = np.zeros(count), np.arange(count)
        start = self.geometry.light_start(surface, wi)
        left = np.maximum(self.settings.transparent_bounces - paths.bounces[:, 4], 0)
        inside, media = paths.inside, self.media
        refused = np.stack([surface.number, np.full(count, NONE)], -1)
        if media.count and len(surface.instance) and (surface.instance >= 0).all():
            inside = media.crossed(inside, surface, dot(surface.ns, wi) < 0.0)
        while len(alive):
            mask = np.full(len(alive), int(Ray.SHADOW))
            hits = self.geometry.intersect(start[alive], wi[alive], (end - near)[alive], mask, refused[alive])
            found = hits.found
            reached = np.copy(end)
            reached[alive] = np.where(found, near[alive] + hits.distance, end[alive])
            if media.count:
                there, channel = inside[alive], paths.channel[alive]
                if radiance is None:
                    transmittance[alive] *= media.transmittance(there, channel, reached[alive] - near[alive])
                else:  # the way ends at a collision, if there is one
                    collision = near[alive] + media.free_path(rng, there, channel)
                    found = found & (collision >= reached[alive])
                    reached[alive] = np.minimum(reached[alive], collision)
            if radiance is not None:
                begin = np.full(count, np.inf)
                begin[alive] = near[alive]
                light += transmittance * radiance(begin, reached)
            hits, alive = hits.select(found), alive[found]
            blocker = self.geometry.surface(hits, wi[alive])
            passes = self.materials.transparency(blocker)
            counts = np.ones(len(alive), bool) if casts is None else casts[alive, hits.instance]
            if media.count:
                counts &= ~media.only_bounds(blocker)
                inside = inside.copy()
                inside[alive] = media.crossed(inside[alive], blocker, counts >= 0)
            passes = passes * (left[alive] > 0)[:, None]
            transmittance[alive] *= np.where(counts[:, None], passes, 1.0)
            left[alive] -= counts
            refused[alive, 1] = blocker.number
            through = transmittance[alive].max(1) > 0.0
            alive = alive[through]
            near[alive] = reached[alive]
            start[alive] = self.geometry.offset(blocker.position[through], blocker.ng[through], wi[alive])
        return transmittance if radiance is None else light

    # --- scattering ---------------------------------------------------------------------------------------------------

    def _emerge(self, paths: Paths, surface: Surface, entered: list, wi, weight, samples: Samples, rng) -> Paths:
        """The paths that continue from the exits of light that has ``entered`` surfaces along wi; lights are sampled
        there."""
        emerged = [paths.select(np.zeros(0, int))]
        for rows, lobe in entered:
            alive = ~paths.last[rows] & (weight[rows].max(1) > 0.0)
            rows, lobe = rows[alive], lobe.select(np.flatnonzero(alive))
            part = paths.select(rows)
            hits, direction, throughput = pass_below(
                self.geometry, lobe, surface.select(rows), wi[rows], part.throughput * weight[rows], rng
            )
            part.throughput = throughput
            found = np.flatnonzero(hits.found)
            hits, part = hits.select(found), part.select(found)
            exits = self.geometry.surface(hits, -direction[found])
            exits.ray_kind, exits.depth = np.zeros(len(found), int), part.bounces
            shading = self.materials.exits(exits, np.zeros(len(found)))
            self._sample_lights(part, exits, shading, samples, rng)
            emerged.append(self._scatter(part, exits, shading, np.zeros(len(found)), samples, rng))
        return _together(emerged)

    def _scatter(
        self, paths: Paths, surface: Surface, shading: Shading, end: np.ndarray, samples: Samples, rng
    ) -> Paths:
        """The paths that continue from their surfaces. Those that only gather emission go straight on or end."""
        wi, weight, pdf, kind = shading.sample(rng)
        below = ~paths.last & ((kind & INSIDE) != 0)
        if below.any():
            emerged = self._emerge(paths, surface, shading.entered, wi, weight, samples, rng)
            weight = np.where(below[:, None], 0.0, weight)
            return _together([self._go_on(paths, surface, shading, end, wi, weight, pdf, kind, rng), emerged])
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
        settings = self.settings
        limits = np.array(
            [settings.max_bounces, settings.diffuse_bounces, settings.glossy_bounces, settings.transmission_bounces]
        )
        passed_all = bounces[:, 4] >= settings.transparent_bounces
        alive = (throughput.max(1) > 0.0) & ~(paths.last & (paths.bounces[:, 4] >= settings.transparent_bounces))
        last = paths.last | (bounces[:, :4] > limits).any(1) | (passes & passed_all)
        roulette = ~passes & ~last & (bounces[:, 0] >= FIRST_ROULETTE)
        survival = np.where(roulette, np.clip(throughput.max(1), 1e-300, 1.0), 1.0)
        alive &= rng.random(len(survival)) < survival
        throughput = throughput / survival[:, None]
        direction = np.where(straight[:, None], paths.direction, wi)
        away = through & (((shading.exit - surface.position) ** 2).sum(1) > 1e-9)
        start = np.where(away[:, None], shading.exit, self.geometry.offset(surface.position, surface.ng, direction))
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
            np.where(passes, paths.light_set, self.light_sets[surface.instance]),
            self.media.crossed(paths.inside, surface, passes | ((kind & Ray.TRANSMISSION) != 0)),
            paths.channel,
            paths.volume,
            surface.number,
        ).select(alive)
