# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the scene to the tables of ``records``. All units and conventions of Blender's lights are applied here, once."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ....affine import inverse_linear
from ...scene import AreaLight, PointLight, Ray, Scene, SpotLight, SunLight
from .environment import image_distribution
from .records import AREA, BALL, LAMP, SUN, TABLES, TRIANGLE, WORLD
from .tree_build import Bounds, build_tree

BLEND_LEAST = 1e-6  # a smooth step this narrow is a step


@dataclass
class Triangles:
    """Triangles that emit light, in world space; both sides do."""

    instance: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (n,)
    primitive: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # (n,) index in the mesh
    corners: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3)))  # (n, corner, xyz)
    radiance: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # (n, RGB), an estimate where textured
    textured: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # (n,)


def pack_lights(
    scene: Scene, lamp_bounds: np.ndarray | None = None, lamp_power: np.ndarray | None = None,
    triangles: Triangles | None = None,
) -> dict[str, np.ndarray]:
    """Tables (see ``records.TABLES``) of all emitters of ``scene``.

    ``lamp_bounds`` is (lamps, 2, 3): corners of the box of each SDF lamp in world space; ``lamp_power`` (lamps, RGB) or
    (lamps,) in watts. A light whose transform or power is not finite is left out, with a warning in ``scene.warnings``.
    """
    lamp_bounds = np.zeros((0, 2, 3)) if lamp_bounds is None else np.asarray(lamp_bounds, float)
    lamp_power = np.zeros(0) if lamp_power is None else np.asarray(lamp_power, float)
    triangles = triangles or Triangles()
    lamps, lights = len(lamp_bounds), len(scene.lights)
    world = lamps + lights

    tables = {name: np.zeros(0, dtype) for name, dtype in TABLES.items()}
    emitters = np.zeros(world + 1 + len(triangles.instance), TABLES["light_emitters"])
    emitters["visibility"], emitters["cast_shadow"] = int(Ray.ALL), 1
    emitters["leaf"] = emitters["infinite"] = -1
    tables["light_emitters"] = emitters
    header = tables["light_header"] = np.zeros(1, TABLES["light_header"])
    header["lamp_count"], header["light_count"], header["world_emitter"] = lamps, lights, world

    bounds = [_lamp_bounds(emitters, scene, lamp_bounds, lamp_power)]
    infinite = []
    bounds += _pack_lights(tables, scene, lamps, infinite)
    _pack_world(tables, scene, world, infinite)
    bounds.append(_pack_triangles(tables, scene, triangles, world + 1))

    bounds = _join([b for b in bounds if b is not None and len(b.emitter)])
    if bounds is not None:
        shining = np.isfinite(bounds.intensity) & (bounds.intensity > 0.0)
        shining &= np.isfinite(bounds.lo).all(axis=1) & np.isfinite(bounds.hi).all(axis=1)
        bounds = Bounds(**{name: value[shining] for name, value in vars(bounds).items()})
        tree = build_tree(bounds)
        tables["light_nodes"] = tree.nodes
        emitters["leaf"][bounds.emitter] = tree.nodes["order"][tree.leaf]
    tables["light_infinite"] = np.array(infinite, TABLES["light_infinite"])
    emitters["infinite"][tables["light_infinite"]["emitter"]] = np.arange(len(infinite))
    return tables


def hit_capacity(tables: dict[str, np.ndarray]) -> int:
    """Rows that ``light_hits`` may write."""
    return max(int(tables["light_header"]["light_count"][0]), 1)


def _join(parts: list[Bounds]) -> Bounds | None:
    if not parts:
        return None
    return Bounds(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


def _bounds(emitter, lo, hi, intensity, axis=(0.0, 0.0, 1.0), cos_o=-1.0, cos_e=0.0, two_sided=False) -> Bounds:
    """Bounds of emitters; what is the same for all may be given once."""
    emitter = np.atleast_1d(np.asarray(emitter, np.int64))
    count = len(emitter)
    return Bounds(
        emitter, np.broadcast_to(lo, (count, 3)), np.broadcast_to(hi, (count, 3)), np.broadcast_to(axis, (count, 3)),
        np.full(count, float(cos_o)), np.full(count, float(cos_e)), np.broadcast_to(intensity, count),
        np.full(count, two_sided))


def _lamp_bounds(emitters, scene, bounds, power) -> Bounds:
    count = len(bounds)
    emitters["kind"][:count] = LAMP
    emitters["index"][:count] = np.arange(count)
    emitters["visibility"][:count] = [int(lamp.visibility) for lamp in scene.lamps][:count] or int(Ray.ALL)
    mean = np.abs(power.reshape(count, -1)).mean(axis=1) if count else np.zeros(0)
    return _bounds(np.arange(count), bounds[:, 0], bounds[:, 1], mean / (4.0 * math.pi))


def _pack_lights(tables, scene, first, infinite) -> list[Bounds]:
    emitters, bounds = tables["light_emitters"], []
    rows = {BALL: [], AREA: [], SUN: []}
    for emitter, light in enumerate(scene.lights, first):
        kind = BALL if isinstance(light, PointLight) else AREA if isinstance(light, AreaLight) else SUN
        emitters[emitter]["kind"], emitters[emitter]["index"] = kind, len(rows[kind])
        emitters[emitter]["visibility"], emitters[emitter]["cast_shadow"] = int(light.visibility), light.cast_shadow
        strength = light.strength if isinstance(light, SunLight) else light.power
        rgb = strength * np.asarray(light.color, float)
        row = np.zeros((), TABLES[{BALL: "light_balls", AREA: "light_areas", SUN: "light_suns"}[kind]])
        rows[kind].append(row)
        if not (np.isfinite(light.matrix).all() and np.isfinite(rgb).all()):
            scene.warnings.append(
                f"Light “{light.name}” is left out: its transform or power is not a finite number. Set them anew.")
        elif kind == BALL:
            bounds.append(_pack_ball(row, emitter, light, rgb))
        elif kind == AREA:
            bounds.append(_pack_area(row, emitter, light, rgb))
        else:
            _pack_sun(row, emitter, light, rgb, infinite)
    for kind, name in ((BALL, "light_balls"), (AREA, "light_areas"), (SUN, "light_suns")):
        tables[name] = np.array(rows[kind], TABLES[name])
    return bounds


def _unit(vector) -> np.ndarray:
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else np.zeros(3)


def _pack_ball(row, emitter, light, rgb) -> Bounds:
    """Radiant flux to radiance, or to radiant intensity. The object's scale does not change size or power."""
    radius = max(light.radius, 0.0)
    row["center"], row["radius"], row["disk"] = light.matrix[:3, 3], radius, light.soft_falloff
    row["radiance"] = rgb / (4.0 * math.pi**2 * radius**2 if radius > 0.0 else 4.0 * math.pi)
    row["spread"] = 2.0
    reach = np.full(3, radius)
    cone = {}
    if isinstance(light, SpotLight):
        cone = _pack_spot(row, light)
    center = row["center"]
    return _bounds(emitter, center - reach, center + reach, np.abs(rgb).mean() / (4.0 * math.pi), **cone)


def _pack_spot(row, light) -> dict:
    """The cone in local space, so that scale makes it elliptic, as in Cycles, and a round cone around it."""
    linear = light.matrix[:3, :3]
    scales = np.linalg.norm(linear, axis=0)
    half = 0.5 * min(max(light.angle, 0.0), math.pi)
    row["spot"], row["cos_half"] = 1, math.cos(half)
    row["smooth"] = 1.0 / max((1.0 - math.cos(half)) * light.blend, BLEND_LEAST)
    if abs(np.linalg.det(linear)) <= 1e-12 * scales.prod() or scales.prod() == 0.0:
        linear, scales = np.eye(3), np.ones(3)
    row["to_local"] = inverse_linear(linear)
    row["axis"] = axis = -_unit(linear[:, 2])
    orthogonal = np.abs(linear.T @ linear - np.diag(scales**2)).max() <= 1e-6 * scales.max() ** 2
    if not orthogonal or half >= 0.5 * math.pi:
        return {}
    tangent = math.tan(half) * max(scales[0], scales[1]) / scales[2]
    # A hair wider than the cone itself, for the rounding of directions at its rim.
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    row["spread"] = tangent * tangent * cosine / (1.0 + 1.0 / cosine) * (1.0 + 1e-9) + 1e-15
    return dict(axis=axis, cos_o=1.0, cos_e=cosine)


def _pack_area(row, emitter, light, rgb) -> Bounds:
    """The object's scale changes the size, not the power. A sheared light becomes the rectangle of the same base and
    height."""
    linear = light.matrix[:3, :3]
    u, v = linear[:, 0] * light.size[0], linear[:, 1] * light.size[1]
    unit_u = _unit(u)
    v = v - np.dot(v, unit_u) * unit_u
    unit_v = _unit(v)
    normal = np.cross(unit_u, unit_v)
    if np.dot(normal, linear[:, 2]) > 0.0:
        normal = -normal
    half = 0.5 * np.linalg.norm(u), 0.5 * np.linalg.norm(v)
    area = half[0] * half[1] * (math.pi if light.ellipse else 4.0)
    row["center"], row["u"], row["v"], row["normal"] = light.matrix[:3, 3], unit_u, unit_v, normal
    row["half_u"], row["half_v"], row["ellipse"] = half[0], half[1], light.ellipse
    radiance = rgb / (math.pi * area) if area > 0.0 else np.zeros(3)
    row["radiance"] = radiance

    spread = 0.5 * min(max(light.spread, 0.0), math.pi)
    row["tan_spread"], gain = math.inf, 1.0
    if spread == 0.0:
        row["tan_spread"] = 0.0
    elif spread < 0.5 * math.pi - 1e-6:
        tangent = math.tan(spread)
        # tan s − s in its series, where the difference has lost its digits.
        row["tan_spread"], row["spread_gain"] = tangent, 1.0 / (tangent - spread if spread > 0.05 else spread**3 / 3.0)
        gain = tangent * float(row["spread_gain"])
    reach = np.abs(unit_u) * half[0] + np.abs(unit_v) * half[1]
    center = light.matrix[:3, 3]
    # Intensity along the axis; a parallel beam has none, and its irradiance stands in at a distance of its own size.
    intensity = np.abs(radiance).mean() * area * gain
    return _bounds(
        emitter, center - reach, center + reach, intensity, axis=normal, cos_o=1.0 if area > 0.0 else -1.0,
        cos_e=math.cos(spread))


def _pack_sun(row, emitter, light, rgb, infinite) -> None:
    """Strength is irradiance on a surface that faces the sun."""
    row["direction"] = _unit(light.matrix[:3, 2])
    half = 0.5 * min(max(light.angle, 0.0), math.pi)
    row["one_minus_cos"] = 2.0 * math.sin(0.5 * half) ** 2
    row["radiance"] = rgb / (math.pi * math.sin(half) ** 2 if half > 0.0 else 1.0)
    irradiance = float(np.abs(rgb).mean())
    if not row["direction"].any():
        row["radiance"] = 0.0
    elif irradiance > 0.0:
        infinite.append((emitter, irradiance, row["direction"], 1))


def _pack_world(tables, scene, emitter, infinite) -> None:
    world, header = scene.world, tables["light_header"]
    row = tables["light_emitters"][emitter]
    row["kind"], row["visibility"] = WORLD, int(world.visibility)
    color = world.strength * np.asarray(world.color, float)
    if not np.isfinite(color).all():
        scene.warnings.append("The world is black: its colour or strength is not a finite number. Set it anew.")
        return
    mean = np.abs(color).mean()
    header["world_color"], header["rotation"] = color, world.rotation
    if world.image is not None and mean > 0.0:
        pixels = np.asarray(scene.images[world.image].pixels, np.float32)[..., :3]
        if not np.isfinite(pixels).all():
            name = scene.images[world.image].name
            scene.warnings.append(f"Image “{name}” has pixels that are not finite numbers: they are black in the world.")
            pixels = np.where(np.isfinite(pixels).all(axis=2, keepdims=True), pixels, np.float32(0.0))
        rows, columns, image_mean = image_distribution(pixels * np.abs(color).astype(np.float32))
        header["height"], header["width"] = pixels.shape[:2]
        header["rows"], header["columns"] = columns.shape[0], columns.shape[1] - 1
        tables["light_image"] = np.ascontiguousarray(pixels).ravel()
        tables["light_image_rows"], tables["light_image_columns"] = rows, columns.ravel()
        mean = image_mean
    if mean > 0.0:
        infinite.append((emitter, math.pi * mean, (0.0, 0.0, 0.0), 0))


def _pack_triangles(tables, scene, triangles, first) -> Bounds | None:
    count = len(triangles.instance)
    if not count:
        return None
    corners = np.asarray(triangles.corners, float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    rows = tables["light_triangles"] = np.zeros(count, TABLES["light_triangles"])
    rows["corners"], rows["radiance"], rows["area"] = corners, triangles.radiance, 0.5 * length
    rows["instance"], rows["primitive"] = triangles.instance, triangles.primitive
    rows["textured"] = triangles.textured
    emitter = first + np.arange(count)
    emitters = tables["light_emitters"]
    emitters["kind"][emitter], emitters["index"][emitter] = TRIANGLE, np.arange(count)
    if scene.instances:
        seen_by = np.array([int(instance.visibility) for instance in scene.instances], np.int32)
        emitters["visibility"][emitter] = seen_by[triangles.instance]

    instances = int(triangles.instance.max()) + 1
    sizes = np.zeros(instances, np.int64)
    np.maximum.at(sizes, triangles.instance, triangles.primitive.astype(np.int64) + 1)
    offsets = tables["light_triangle_offset"] = np.concatenate(([0], np.cumsum(sizes)))
    lookup = tables["light_triangle_map"] = np.full(offsets[-1], -1, np.int32)
    lookup[offsets[triangles.instance] + triangles.primitive] = emitter

    axis = normal / np.where(length > 0.0, length, 1.0)[:, None]
    intensity = np.abs(np.asarray(triangles.radiance, float)).mean(axis=1) * 0.5 * length
    return _bounds(emitter, corners.min(axis=1), corners.max(axis=1), intensity, axis=axis, cos_o=1.0, two_sided=True)
