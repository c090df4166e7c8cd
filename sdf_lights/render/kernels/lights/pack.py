# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the scene to the tables of all emitters. Units and conventions of Blender's lights are applied in their
modules."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...medium import hides_horizon
from ...scene import ALL_SETS, MANY_BOUNCES, Emitter, Lamp, Ray, Scene, catches_shadows
from ..rays import SHADOW_OPAQUE
from . import environment, portals, records, triangle
from .extent import DistantLight
from .kinds import KINDS, LAMP, TRIANGLE, WORLD, kind_of
from .linking import pack_trees, shadow_bit, shadow_bits
from .records import INFINITE, NODE
from .tree_build import Bounds, build_tree, joined
from .triangle import Triangles

TABLES = {
    **records.TABLES,
    **triangle.TABLES,
    **portals.TABLES,
    **{module.TABLE: module.RECORD for module in KINDS.values()},
}
NEVER = 1  # in ``met``, until it is set: scattered rays do not find the emitter


def pack_lights(
    scene: Scene,
    lamp_bounds: np.ndarray | None = None,
    lamp_power: np.ndarray | None = None,
    triangles: Triangles | None = None,
    world_map=None,
    sources: list[Lamp] | None = None,
    elsewhere: Sequence[Bounds] = (),
) -> dict[str, np.ndarray]:
    """Tables (see ``TABLES``) of all emitters of ``scene``.

    ``lamp_bounds`` is (lamps, 2, 3): corners of the box of each SDF lamp in world space. ``lamp_power`` is (lamps, RGB)
    or (lamps,) in watts, and ``sources`` are the lamps that they came from (None: ``scene.lamps``). ``world_map`` (a
    ``world_sun.WorldMap``) is the map of the world's nodes, for sampling. ``elsewhere``: bounds of the emitters at
    other times, from ``pack_near``; light trees hold for all of them. A light whose transform or power is not finite is
    left out, with a warning in ``scene.warnings``.
    """
    tables, bounds, infinite = pack_near(scene, lamp_bounds, lamp_power, triangles, sources)
    emitters, world = tables["light_emitters"], int(tables["light_header"]["world_emitter"][0])
    portals.pack(tables, scene)
    irradiance, importance = environment.pack(tables, scene, world, world_map)
    emitters["met"][world] &= emitters["visibility"][world]
    if irradiance > 0.0:
        sky = np.array([(world, irradiance, importance, (0.0, 0.0, 0.0), 0)], INFINITE)
        infinite = np.concatenate([infinite, sky])
    bounds = joined([bounds, *elsewhere]) if elsewhere else bounds
    sources = (scene.lamps if sources is None else sources)[: int(tables["light_header"]["lamp_count"][0])]
    triangles = triangles or Triangles()
    lights = len(scene.lights)
    if bounds is not None:
        shining = np.isfinite(bounds.intensity) & (bounds.intensity > 0.0)
        shining &= np.isfinite(bounds.lo).all(axis=1) & np.isfinite(bounds.hi).all(axis=1)
        bounds = _chosen(bounds, shining)
    if hides_horizon(scene.world.medium):  # except from the light of what casts no shadow
        infinite = infinite[emitters["cast_shadow"][infinite["emitter"]] == 0]

    def build(lit):
        leaf, place = np.full((2, len(emitters)), -1)
        own = infinite if lit is None else infinite[lit[infinite["emitter"]]]
        place[own["emitter"]] = np.arange(len(own))
        below = bounds if bounds is None or lit is None else _chosen(bounds, lit[bounds.emitter])
        if below is None or not len(below.emitter):
            return np.zeros(0, NODE), own, leaf, place
        tree = build_tree(below)
        leaf[below.emitter] = tree.nodes["order"][tree.leaf]
        return tree.nodes, own, leaf, place

    def is_in_light_tree(number):
        lit = np.ones(len(emitters), bool)
        lit[:world] = [member.receivers >> number & 1 for member in (*sources, *scene.lights)] + [1] * (
            world - len(sources) - lights
        )
        if len(triangles.instance):
            glow = np.array([instance.receivers >> number & 1 for instance in scene.instances], bool)
            lit[world + 1 :] = glow[triangles.instance]
        return lit

    pack_trees(tables, scene, is_in_light_tree, build)
    return tables


def pack_near(
    scene: Scene,
    lamp_bounds: np.ndarray | None = None,
    lamp_power: np.ndarray | None = None,
    triangles: Triangles | None = None,
    sources: list[Lamp] | None = None,
) -> tuple[dict[str, np.ndarray], Bounds | None, np.ndarray]:
    """As ``pack_lights``, without the world and the light tree: tables, data for the tree, and suns (INFINITE)."""
    lamp_bounds = np.zeros((0, 2, 3)) if lamp_bounds is None else np.asarray(lamp_bounds, float)
    lamp_power = np.zeros(0) if lamp_power is None else np.asarray(lamp_power, float)
    triangles = triangles or Triangles()
    lamps, lights = len(lamp_bounds), len(scene.lights)
    world = lamps + lights

    tables = {name: np.zeros(0, dtype) for name, dtype in TABLES.items()}
    emitters = np.zeros(world + 1 + len(triangles.instance), TABLES["light_emitters"])
    emitters["visibility"], emitters["cast_shadow"] = int(Ray.ALL), 1
    emitters["blockers"], emitters["max_bounces"] = SHADOW_OPAQUE, MANY_BOUNCES
    emitters["camera_brightness"] = 1.0
    emitters["kind"][world], emitters["kind"][world + 1 :] = WORLD, TRIANGLE
    emitters["index"][world + 1 :] = np.arange(len(triangles.instance))
    emitters["leaf"] = emitters["infinite"] = -1
    tables["light_emitters"] = emitters
    header = tables["light_header"] = np.zeros(1, TABLES["light_header"])
    header["lamp_count"], header["light_count"], header["world_emitter"] = lamps, lights, world

    sources = (scene.lamps if sources is None else sources)[:lamps]
    bounds = [_lamp_bounds(emitters, sources, lamp_bounds, lamp_power)]
    infinite = []
    bounds += _pack_lights(tables, scene, lamps, infinite)
    if len(triangles.instance):
        emitter = world + 1 + np.arange(len(triangles.instance))
        bounds.append(_bounds(emitter, **triangle.pack(tables, scene, triangles, world + 1)._asdict()))

    emitters["max_bounces"][world] = scene.world.max_bounces
    _control(emitters, scene, [*sources, *scene.lights])
    _control_triangles(emitters, scene, triangles, world + 1)
    emitters["met"] = np.where(emitters["met"] == NEVER, int(Ray.CAMERA), int(Ray.ALL)) & emitters["visibility"]
    return tables, _join([b for b in bounds if b is not None and len(b.emitter)]), np.array(infinite, INFINITE)


def _chosen(bounds: Bounds, rows: np.ndarray) -> Bounds:
    return Bounds(**{name: value[rows] for name, value in vars(bounds).items()})


def _control(emitters, scene: Scene, members: list[Emitter]) -> None:
    """Fill the fields of light control for lamps and lights."""
    bits = shadow_bits(scene)
    for emitter, member in enumerate(members):
        row = emitters[emitter]
        row["blockers"] = shadow_bit(bits, member.blockers)
        row["max_bounces"] = member.max_bounces
        row["beside_catchers"] = not member.lights_catchers
        row["alone"] = row["blockers"] != SHADOW_OPAQUE
        row["met"] = NEVER if member.sampled_only else 0


def _control_triangles(emitters, scene: Scene, triangles: Triangles, first: int) -> None:
    if catches_shadows(scene):
        own = np.array([not instance.catcher for instance in scene.instances], np.int32)
        emitters["beside_catchers"][first:] = own[triangles.instance]
    if any(instance.blockers != ALL_SETS for instance in scene.instances):
        bits = shadow_bits(scene)
        own = np.array([shadow_bit(bits, instance.blockers) for instance in scene.instances], np.int32)
        emitters["blockers"][first:] = own[triangles.instance]
        emitters["alone"][first:] = emitters["blockers"][first:] != SHADOW_OPAQUE


def hit_capacity(tables: dict[str, np.ndarray]) -> int:
    """Maximum number of rows of ``light_hits``."""
    return max(int(tables["light_header"]["light_count"][0]), 1)


def _join(parts: list[Bounds]) -> Bounds | None:
    if not parts:
        return None
    return Bounds(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


def _bounds(emitter, lo, hi, intensity, axis=(0.0, 0.0, 1.0), cos_o=-1.0, cos_e=0.0, two_sided=False) -> Bounds:
    """Bounds of emitters; values that all share may be given once."""
    emitter = np.atleast_1d(np.asarray(emitter, np.int64))
    count = len(emitter)
    return Bounds(
        emitter,
        np.broadcast_to(lo, (count, 3)),
        np.broadcast_to(hi, (count, 3)),
        np.broadcast_to(axis, (count, 3)),
        np.full(count, float(cos_o)),
        np.full(count, float(cos_e)),
        np.broadcast_to(intensity, count),
        np.full(count, two_sided),
    )


def _lamp_bounds(emitters, sources, bounds, power) -> Bounds:
    count = len(bounds)
    emitters["kind"][:count] = LAMP
    emitters["index"][:count] = np.arange(count)
    emitters["visibility"][:count] = [int(lamp.visibility) for lamp in sources] or int(Ray.ALL)
    emitters["camera_brightness"][:count] = [lamp.camera_brightness for lamp in sources] or 1.0
    mean = np.abs(power.reshape(count, -1)).mean(axis=1) if count else np.zeros(0)
    return _bounds(np.arange(count), bounds[:, 0], bounds[:, 1], mean / (4.0 * math.pi))


def _pack_lights(tables, scene, first, infinite) -> list[Bounds]:
    emitters, bounds = tables["light_emitters"], []
    rows = {kind: [] for kind in KINDS}
    for emitter, light in enumerate(scene.lights, first):
        kind = kind_of(light)
        module = KINDS[kind]
        emitters[emitter]["kind"], emitters[emitter]["index"] = kind, len(rows[kind])
        emitters[emitter]["visibility"], emitters[emitter]["cast_shadow"] = int(light.visibility), light.cast_shadow
        rgb = light.strength * np.asarray(light.color, float)
        row = np.zeros((), module.RECORD)
        rows[kind].append(row)
        if not (np.isfinite(light.matrix).all() and np.isfinite(rgb).all()):
            scene.warnings.append(
                f"Light “{light.name}” is left out, because its transform or power is not a finite number: set them "
                "again."
            )
            continue
        found = module.pack(row, light, rgb)
        if isinstance(found, DistantLight):
            infinite.append((emitter, found.irradiance, found.irradiance, found.direction, 1))
        elif found is not None:
            bounds.append(_bounds(emitter, **found._asdict()))
    for kind, module in KINDS.items():
        tables[module.TABLE] = np.array(rows[kind], module.RECORD)
    return bounds
