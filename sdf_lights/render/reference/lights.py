# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights, the world and emissive triangles, by textbook sampling.

Every class has ``sample(rng, x) -> (wi, distance, radiance, pdf)`` for points x (N, 3), with pdf 0 where nothing
reaches x, and ``hit(origins, directions) -> (distance, radiance, pdf)``, distance inf where a ray misses. Where
``singular``, light comes from a single direction: ``radiance`` is then an irradiance, pdf is 1 and no ray hits it.
"""

from __future__ import annotations

import numpy as np

from ..images import colors
from ..scene import AreaLight, PointLight, Ray, Scene, SpotLight, SunLight, World
from .emission import Emission
from .images import interpolated
from .vectors import disk, dot, luminance, normalize, to_world, uniform_cone, uniform_sphere


class Emitter:
    """A light of the reference: ``sample`` draws directions towards it, ``hit`` finds it along rays.

    ``singular``: rays cannot hit it.
    """

    singular = False
    nodes: Emission | None = None  # what multiplies its radiance

    def __init__(self, visibility: Ray, cast_shadow: bool = True):
        self.visibility, self.cast_shadow = Ray(visibility), cast_shadow

    def modulated(self, radiance, origins, directions, distance, kind):
        """``radiance`` (N, 3) that rays of a kind of ``scene.Ray`` meet (0 in light sampling), times what its nodes give there."""
        if self.nodes is None:
            return radiance
        far = ~np.isfinite(distance) | (distance >= BACKGROUND)
        length = np.where(far, 0.0, distance)
        place = np.where(far[:, None], directions, origins + length[:, None] * directions)
        normal = np.broadcast_to(self.normal, directions.shape) if isinstance(self, Area) else -directions
        return radiance * self.nodes.at(place, -directions, normal, kind, length)

    def sample(self, rng: np.random.Generator, x: np.ndarray):
        """For points x (N, 3): (directions wi, distances, radiance (N, 3), pdf per solid angle)."""
        raise NotImplementedError

    def hit(self, origins: np.ndarray, directions: np.ndarray):
        """For rays: (distances, inf where there is no hit; radiance (N, 3); pdf of ``sample`` at the origin)."""
        return np.full(len(origins), np.inf), np.zeros(origins.shape), np.zeros(len(origins))


class Ball(Emitter):
    """Point and spot lights: a point, a sphere, or with soft falloff a disk that faces the lit point.

    P watts are a radiant intensity of P / 4π, and so a radiance of P / (4π · πr²).
    """

    def __init__(self, light: PointLight):
        super().__init__(light.visibility, light.cast_shadow)
        matrix = np.asarray(light.matrix, float)
        self.center, self.radius, self.disk = matrix[:3, 3], light.radius, light.soft_falloff
        self.intensity = light.power / (4.0 * np.pi) * np.asarray(light.color, float)
        self.singular = light.radius == 0.0
        self.to_local = None
        if isinstance(light, SpotLight):
            self.to_local = np.linalg.inv(matrix[:3, :3])
            self.cosine = np.cos(light.angle / 2.0)
            self.smooth = (1.0 - self.cosine) * light.blend

    def _radiance(self, wi):
        """Intensity (for a point) or radiance sent along −wi; a spot fades by a smooth step in the cosine."""
        value = self.intensity if self.singular else self.intensity / (np.pi * self.radius**2)
        if self.to_local is None:
            return np.broadcast_to(value, wi.shape)
        z = normalize(wi @ self.to_local.T)[:, 2] - self.cosine
        f = np.clip(z / self.smooth, 0.0, 1.0) if self.smooth > 0.0 else (z > 0.0).astype(float)
        return value * (f * f * (3.0 - 2.0 * f))[:, None]

    def sample(self, rng, x):
        to = self.center - x
        square = np.maximum(dot(to, to), 1e-300)
        axis = to / np.sqrt(square)[:, None]
        if self.singular:
            return axis, np.sqrt(square), self._radiance(axis) / square[:, None], np.ones(len(x))
        if self.disk:
            place = self.radius * disk(rng, len(x))
            towards = to + to_world(np.concatenate([place, np.zeros((len(x), 1))], 1), axis)
            distance = np.linalg.norm(towards, axis=1)
            wi = towards / distance[:, None]
        else:
            r2 = self.radius**2
            inside = square <= r2
            sine2 = np.minimum(r2 / square, 1.0)
            cone = uniform_cone(rng, axis, sine2 / (1.0 + np.sqrt(1.0 - sine2)))
            wi = np.where(inside[:, None], uniform_sphere(rng, len(x)), cone)
        distance, radiance, pdf = self.hit(x, wi)
        return wi, distance, radiance, pdf

    def hit(self, origins, directions):
        if self.singular:
            return super().hit(origins, directions)
        to = self.center - origins
        square, along, r2 = dot(to, to), dot(to, directions), self.radius**2
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.disk:
                distance = square / along
                found = (along > 0.0) & (distance**2 - square <= r2)
                pdf = distance**2 * np.sqrt(square) / (along * np.pi * r2)
                radiance = self._radiance(directions)
            else:
                root = along**2 - square + r2
                inside = square <= r2
                distance = along + np.where(inside, 1.0, -1.0) * np.sqrt(np.maximum(root, 0.0))
                found = (root >= 0.0) & (distance > 0.0)
                sine2 = np.minimum(r2 / square, 1.0)
                height = sine2 / (1.0 + np.sqrt(1.0 - sine2))
                pdf = 1.0 / (2.0 * np.pi * np.where(inside, 2.0, height))
                whole = np.broadcast_to(self.intensity / (np.pi * r2), directions.shape)
                radiance = np.where(inside[:, None], whole, self._radiance(directions))
        return np.where(found, distance, np.inf), np.where(found[:, None], radiance, 0.0), np.where(found, pdf, 0.0)


class Area(Emitter):
    """Rectangle or ellipse that shines along its local −z: P watts are a radiance of P / (π · area).

    A smaller spread s (half angle) scales radiance by (tan s − tan θ) / (tan s − s), as the slats of a grid would.
    """

    def __init__(self, light: AreaLight):
        super().__init__(light.visibility, light.cast_shadow)
        matrix = np.asarray(light.matrix, float)
        self.center, axes = matrix[:3, 3], matrix[:3, :2] * (0.5 * np.asarray(light.size, float))
        self.half = np.linalg.norm(axes, axis=0)
        self.u, self.v = (axes / np.maximum(self.half, 1e-300)).T
        self.normal = -matrix[:3, 2] / max(np.linalg.norm(matrix[:3, 2]), 1e-300)
        self.ellipse = light.ellipse
        self.area = float(np.prod(self.half)) * (np.pi if light.ellipse else 4.0)
        self.radiance = light.power / (np.pi * max(self.area, 1e-300)) * np.asarray(light.color, float)
        half_spread = 0.5 * light.spread
        self.singular = half_spread <= 0.0  # a parallel beam
        self.tan_spread = np.tan(half_spread) if half_spread < 0.5 * np.pi - 1e-6 else np.inf
        self.spread_gain = 1.0 / max(self.tan_spread - half_spread, 1e-12) if np.isfinite(self.tan_spread) else 1.0

    def _inside(self, offset):
        """Whether points, relative to the centre, project onto the light."""
        a, b = (offset @ axis / max(half, 1e-300) for axis, half in ((self.u, self.half[0]), (self.v, self.half[1])))
        return a**2 + b**2 <= 1.0 if self.ellipse else (np.abs(a) <= 1.0) & (np.abs(b) <= 1.0)

    def sample(self, rng, x):
        if self.singular:
            height = (x - self.center) @ self.normal
            lit = self._inside(x - self.center) & (height > 0.0)
            return (
                np.broadcast_to(-self.normal, x.shape),
                height,
                np.broadcast_to(np.pi * self.radiance, x.shape),
                np.where(lit, 1.0, 0.0),
            )
        place = self.half * (disk(rng, len(x)) if self.ellipse else 2.0 * rng.random((len(x), 2)) - 1.0)
        towards = self.center + place[:, :1] * self.u + place[:, 1:] * self.v - x
        distance = np.maximum(np.linalg.norm(towards, axis=1), 1e-300)
        wi = towards / distance[:, None]
        return wi, distance, *self._arrive(wi, distance)

    def _arrive(self, wi, distance):
        cosine = -dot(wi, np.broadcast_to(self.normal, wi.shape))
        facing = cosine > 0.0
        cosine = np.where(facing, cosine, 1.0)
        gain = np.where(facing, 1.0, 0.0)
        if np.isfinite(self.tan_spread):
            tangent = np.sqrt(np.maximum(1.0 - cosine**2, 0.0)) / cosine
            gain = gain * np.maximum(self.tan_spread - tangent, 0.0) * self.spread_gain
        pdf = np.where(facing, distance**2 / (cosine * max(self.area, 1e-300)), 0.0)
        return gain[:, None] * self.radiance, pdf

    def hit(self, origins, directions):
        if self.singular:
            return super().hit(origins, directions)
        cosine = -(directions @ self.normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (origins - self.center) @ self.normal / cosine
            inside = self._inside(origins + distance[:, None] * directions - self.center)
        found = (cosine > 0.0) & (distance > 0.0) & inside
        distance = np.where(found, distance, np.inf)
        radiance, pdf = self._arrive(directions, np.where(found, distance, 1.0))
        return distance, np.where(found[:, None], radiance, 0.0), np.where(found, pdf, 0.0)


class Sun(Emitter):
    """Irradiance ``strength`` on what faces the sun, from a disk of even radiance in the sky."""

    def __init__(self, light: SunLight):
        super().__init__(light.visibility, light.cast_shadow)
        self.direction = normalize(np.asarray(light.matrix, float)[:3, 2])
        self.irradiance = light.strength * np.asarray(light.color, float)
        half = min(0.5 * light.angle, 0.5 * np.pi)
        self.singular = half == 0.0
        if not self.singular:
            self.one_minus_cos = 2.0 * np.sin(0.5 * half) ** 2
            self.radiance = self.irradiance / (np.pi * np.sin(half) ** 2)

    def sample(self, rng, x):
        axis = np.broadcast_to(self.direction, x.shape)
        far = np.full(len(x), np.inf)
        if self.singular:
            return axis, far, np.broadcast_to(self.irradiance, x.shape), np.ones(len(x))
        pdf = np.full(len(x), 1.0 / (2.0 * np.pi * self.one_minus_cos))
        return uniform_cone(rng, axis, self.one_minus_cos), far, np.broadcast_to(self.radiance, x.shape), pdf

    def hit(self, origins, directions):
        """The distance of a hit is a huge number, for inf means that there is none."""
        if self.singular:
            return super().hit(origins, directions)
        difference = directions - self.direction
        found = 0.5 * dot(difference, difference) <= self.one_minus_cos
        return (
            np.where(found, BACKGROUND, np.inf),
            np.where(found[:, None], self.radiance, 0.0),
            np.where(found, 1.0 / (2.0 * np.pi * self.one_minus_cos), 0.0),
        )


def direction_of(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Unit directions (N, 3) of equirectangular coordinates."""
    angle, latitude = (0.5 - u) * 2.0 * np.pi, (v - 0.5) * np.pi
    return np.stack([np.cos(latitude) * np.cos(angle), np.cos(latitude) * np.sin(angle), np.sin(latitude)], -1)


BACKGROUND = 1e30  # distance of what is infinitely far away


class Sky(Emitter):
    """The world. An image is sampled by texels in proportion to their brightness and solid angle."""

    def __init__(self, world: World, scene: Scene):
        super().__init__(world.visibility)
        self.color = world.strength * np.asarray(world.color, float)
        self.rotation = np.asarray(world.rotation, float)
        self.pixels = self.points = None
        if world.emission is not None:
            self.points = Emission(world.emission, scene)
            rows = 64
            v, u = (np.mgrid[0:rows, 0 : 2 * rows] + 0.5).reshape(2, -1) / [[rows], [2 * rows]]
            directions = direction_of(u, v)
            self.pixels = self.points.radiance(directions, 0).reshape(rows, 2 * rows, 3)
            self._build_table()
        elif world.image is not None and 0 <= world.image < len(scene.images):
            self.pixels = colors(scene.images[world.image]).astype(float)
            self._build_table()

    @property
    def black(self) -> bool:
        return not np.any(self.color > 0.0)

    def _build_table(self):
        rows, columns = self.pixels.shape[:2]
        bright = np.maximum(luminance(self.pixels[..., :3]), 0.0)
        # Interpolation carries light into neighbouring texels, and every direction keeps some probability.
        spread = (
            sum(
                np.roll(np.pad(bright, ((1, 1), (0, 0)), "edge"), (i, j), (0, 1))[1:-1]
                for i in (-1, 0, 1)
                for j in (-1, 0, 1)
            )
            / 9.0
        )
        spread += 0.1 * spread.mean() + 1e-12
        edges = np.sin((np.arange(rows + 1) / rows - 0.5) * np.pi)
        weights = spread * np.diff(edges)[:, None]
        self.table = np.cumsum(weights.ravel() / weights.sum())
        self.density = spread / weights.sum() * columns / (2.0 * np.pi)  # by solid angle

    def radiance(self, directions: np.ndarray, kind: np.ndarray | int = 0) -> np.ndarray:
        """``kind``: ``scene.Ray`` of the rays; 0 in light sampling."""
        if self.points is not None:
            return self.color * self.points.radiance(directions, kind)
        if self.pixels is None:
            return np.broadcast_to(self.color, directions.shape)
        u, v = self._coordinates(directions)
        return self.color * interpolated(self.pixels, u, v, "Linear", "REPEAT")[:, :3]

    def _coordinates(self, directions):
        x, y, z = self.rotation @ directions.T
        return 0.5 - np.arctan2(y, x) / (2.0 * np.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi

    def pdf(self, directions: np.ndarray) -> np.ndarray:
        if self.pixels is None:
            return np.full(len(directions), 0.25 / np.pi)
        rows, columns = self.density.shape
        u, v = self._coordinates(directions)
        row = np.clip((v * rows).astype(int), 0, rows - 1)
        return self.density[row, (u * columns).astype(int) % columns]

    def sample(self, rng, x):
        count = len(x)
        far = np.full(count, np.inf)
        if self.pixels is None:
            wi = uniform_sphere(rng, count)
        else:
            rows, columns = self.density.shape
            texel = np.minimum(np.searchsorted(self.table, rng.random(count), side="right"), self.table.size - 1)
            row, column = np.divmod(texel, columns)
            low, high = (np.sin(((row + k) / rows - 0.5) * np.pi) for k in (0, 1))
            z = low + rng.random(count) * (high - low)
            angle = (0.5 - (column + rng.random(count)) / columns) * 2.0 * np.pi
            s = np.sqrt(np.maximum(1.0 - z * z, 0.0))
            wi = np.stack([s * np.cos(angle), s * np.sin(angle), z], -1) @ self.rotation
        return wi, far, self.radiance(wi), self.pdf(wi)

    def hit(self, origins, directions):
        return np.full(len(origins), BACKGROUND), self.radiance(directions), self.pdf(directions)


class Triangles(Emitter):
    """All triangles whose material emits, uniformly by area. The integrator evaluates what they emit.

    ``instances`` and ``triangles`` (K,) name them, ``corners`` (K, 3, 3) are in world space.
    """

    def __init__(self, instances: np.ndarray, triangles: np.ndarray, corners: np.ndarray):
        super().__init__(Ray.ALL)
        self.instances, self.triangles, self.corners = instances, triangles, corners
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = 0.5 * np.linalg.norm(cross, axis=1)
        self.normals = normalize(cross)
        self.area = float(areas.sum())
        self.table = np.cumsum(areas / max(self.area, 1e-300))

    def sample_points(self, rng: np.random.Generator, x: np.ndarray):
        """(wi, distance, pdf, index of the triangle, u, v)."""
        count = len(x)
        index = np.minimum(np.searchsorted(self.table, rng.random(count), side="right"), len(self.table) - 1)
        root, v = np.sqrt(rng.random(count)), rng.random(count)
        u, v = root * (1.0 - v), root * v
        corners = self.corners[index]
        towards = (1.0 - u - v)[:, None] * corners[:, 0] + u[:, None] * corners[:, 1] + v[:, None] * corners[:, 2] - x
        distance = np.maximum(np.linalg.norm(towards, axis=1), 1e-300)
        wi = towards / distance[:, None]
        return wi, distance, self.density(distance, np.abs(dot(wi, self.normals[index]))), index, u, v

    def density(self, distance: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Solid angle density of a point sampled at ``distance`` on a triangle seen at ``cosine``."""
        return np.where(cosine > 1e-9, distance**2 / (np.maximum(cosine, 1e-9) * self.area), 0.0)


def blender_light(light, scene: Scene | None = None) -> Emitter:
    """The emitter of a light; its nodes may look things up in its ``scene``."""
    kinds = {AreaLight: Area, SunLight: Sun}
    emitter = kinds.get(type(light), Ball)(light)
    if light.emission is not None:
        emitter.nodes = Emission(light.emission, scene)
    return emitter
