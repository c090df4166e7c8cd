# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The record through which kernels reach a whole scene, and the packing of its lamps, lights and settings.

Every module of kernels declares its tables and scalars. Here they become one record type.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ... import emitter as lamps
from ...emitter.sampling import cut as cuts
from ...emitter.sampling import external, strategies
from ...jit import block_dtype
from ..material import Node
from ..motion import LEAST_POWER, at, changes_shape, lamp_at, light_steps, shape_and_emission
from ..scene import Instance, Lamp, Mesh, Primitive, Scene
from ..settings import LampSampling
from ..strands import margin
from . import camera, emission_graphs, film, geometry, integrator, lamp_tree, lights, motion, rays, shading
from .caustic_paths import records as caustic_path_records
from .light_paths import records as light_path_records
from .lights import kinds
from .media import pack as media
from .media import records as media_records
from .outputs import records as output_records
from .path_reuse import records as path_reuse_records
from .shading.records import GLOSSY, HAS_EMISSION, HAS_TRANSPARENCY, STOPS_LIGHT_RAYS, TRANSMISSION
from .shared_places import EVERYWHERE
from .subsurface import records as subsurface_records


def _together(*parts: dict[str, np.dtype]) -> dict[str, np.dtype]:
    """One dictionary of tables. Two modules may not share a name: the later table would replace the earlier one, and
    kernels would read wrong data."""
    found: dict[str, np.dtype] = {}
    for part in parts:
        for name, dtype in part.items():
            if found.setdefault(name, dtype) != dtype:
                raise ValueError(f"two modules declare the table {name!r}: rename one")
    return found


TABLES = _together(
    lamps.TABLES,
    cuts.TABLES,
    external.TABLES,
    lamp_tree.TABLES,
    camera.TABLES,
    geometry.TABLES,
    lights.TABLES,
    shading.TABLES,
    film.TABLES,
    motion.TABLES,
    output_records.TABLES,
    media_records.TABLES,
    subsurface_records.TABLES,
    light_path_records.TABLES,
    caustic_path_records.TABLES,
    path_reuse_records.TABLES,
    {"control": np.dtype(np.int64)},
)
SCALARS = [
    *media_records.SCALARS,
    *subsurface_records.SCALARS,
    *lamps.SCALARS,
    *strategies.SCALARS,
    *camera.SCALARS,
    *rays.SCALARS,
    *geometry.SCALARS,
    *emission_graphs.SCALARS,
    *shading.SCALARS,
    *integrator.SCALARS,
    *film.SCALARS,
    *motion.SCALARS,
    *output_records.SCALARS,
    *light_path_records.SCALARS,
    *caustic_path_records.SCALARS,
    *path_reuse_records.SCALARS,
]
BLOCK = block_dtype(TABLES, SCALARS)

# The strategy of light rays, and the factor on the BSDF's density with strategies that do not compute it.
LAMP_STRATEGIES = {
    LampSampling.CUT: (strategies.BOXES, strategies.NO_BSDF_RAYS),
    LampSampling.MIS: (strategies.PROJECTION, 1.0),
    LampSampling.PROJECTION: (strategies.PROJECTION, strategies.NO_BSDF_RAYS),
    LampSampling.EXTERNAL: (strategies.EXTERNAL, strategies.NO_BSDF_RAYS),
    LampSampling.BSDF: (strategies.NO_LIGHT_RAYS, 1.0),
}


def build_lamps(scene: Scene) -> tuple[list[lamps.BuiltLamp], list[Lamp], list[int]]:
    """The lamps of ``scene`` that can give light, built; their sources; and their indices in ``scene.lamps``. The
    others get warnings.

    The source of a lamp is the lamp itself. If it gives no light at the frame, but at another time, it has the shape of
    that time.
    """
    built, sources, indices = [], [], []
    for index, lamp in enumerate(scene.lamps):
        try:
            made, source = _build_at_any_time(lamp)
        except lamps.LampError as error:
            scene.warnings.append(str(error))
            continue
        built.append(made)
        sources.append(source)
        indices.append(index)
    scene.warnings += lamps.doubts(built)
    return built, sources, indices


def _build_at_any_time(lamp: Lamp) -> tuple[lamps.BuiltLamp, Lamp]:
    try:
        return _build(lamp), lamp
    except lamps.LampError:
        for state in lamp.motion:
            source = replace(lamp, shape=state.shape, emission=state.emission, power=state.power, density=state.density)
            try:
                return _build(source), source
            except lamps.LampError:
                pass
        raise


def _build(lamp: Lamp) -> lamps.BuiltLamp:
    return lamps.build_lamp(
        lamp.name,
        lamp.shape,
        lamp.matrix,
        lamp.power,
        lamp.density,
        lamp.color,
        int(lamp.visibility),
        lamp.emission,
    )


def emitter_tables(
    scene: Scene,
    built: list[lamps.BuiltLamp],
    sources: list[Lamp],
    emissive: lights.Triangles,
    materials: dict[str, np.ndarray],
    graphs: shading.Graphs,
    elsewhere: Elsewhere | None = None,
) -> dict[str, np.ndarray]:
    """Tables of the lamps ``built`` from ``sources``, of the tree by which rays find them, and of all other lights.
    With ``elsewhere``, the trees hold at all times."""
    rows = max((image.pixels.shape[0] for image in scene.images), default=0) if scene.world.emission is not None else 0
    world_map = emission_graphs.kept_world_map(scene, materials | camera.pack_camera(scene), graphs, BLOCK, rows)
    lamp_tables = lamps.pack_lamps(built)
    rows = lamp_tables["lamps"]
    low, high = lamp_boxes([lamp_tables, *(elsewhere.tables if elsewhere else ())])
    light_tables = lights.pack_lights(
        scene,
        np.stack([low, high], axis=1),
        4.0 * np.pi * rows["volume"][:, None] * rows["emission"],
        emissive,
        world_map,
        sources,
        elsewhere.bounds if elsewhere else (),
    )
    return {**lamp_tables, **lamp_tree.pack_lamp_tree(low, high, rows["visibility"]), **light_tables}


def lamp_boxes(tables: list[dict[str, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """(lamps, 3) corners of boxes around each lamp in all of the ``tables``."""
    rows = [each["lamps"] for each in tables]
    return (
        np.min([row["center"] - row["half"] for row in rows], axis=0),
        np.max([row["center"] + row["half"] for row in rows], axis=0),
    )


class Segment(NamedTuple):
    """A part of the shutter's time in which no lamp changes its shape: tables that move, at the ends of its steps."""

    first_step: int
    tables: list[dict[str, np.ndarray]]


class Elsewhere(NamedTuple):
    """Tables that move, at even times of the shutter, and bounds of the emitters there."""

    segments: list[Segment]
    bounds: list[lights.Bounds]
    suns: list[dict[int, np.ndarray]]  # direction to each, for each of ``tables``
    built: list[lamps.BuiltLamp]  # the tables point to their compiled fields

    @property
    def tables(self) -> list[dict[str, np.ndarray]]:
        """The tables of all segments."""
        return [table for segment in self.segments for table in segment.tables]

    def follow_suns(self, rows: np.ndarray) -> None:
        """Add the table ``light_infinite`` (``rows``, (suns,)) to the tables, from its state at the frame."""
        for table, suns in zip(self.tables, self.suns):
            table["light_infinite"] = rows.copy()
            for row in table["light_infinite"]:
                row["direction"] = suns.get(int(row["emitter"]), row["direction"])

    def base(self, segment: Segment, tables: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The tables of a segment without motion; ``tables`` are those of the frame."""
        own = {} if len(self.segments) == 1 else {**lamps.TABLES, **cuts.TABLES}
        return {name: (segment.tables[0] if name in own else tables)[name] for name in segment.tables[0]}


def pack_elsewhere(scene: Scene, sources: list[Lamp], materials: np.ndarray) -> Elsewhere | None:
    """Camera and lights at even times, for the lamps ``sources`` that give light and the ``materials`` (n,); None if
    none of it moves."""
    if scene.shutter is None:
        return None
    emits = (materials["flags"] & HAS_EMISSION != 0) & (materials["sample_emission"] != 0)
    emissive = np.array([emits[list(instance.materials)].any() for instance in scene.instances], bool)
    steps = light_steps(scene, emissive)
    if steps == 0:
        return None
    result = Elsewhere([], [], [], [])
    changing = [changes_shape(lamp) for lamp in sources]
    middles = [(step + 0.5) / steps for step in range(steps)]
    forms = [
        tuple(shape_and_emission(lamp_at(lamp, time) if changes else lamp) for lamp, changes in zip(sources, changing))
        for time in middles
    ]
    first = 0
    for end in range(1, steps + 1):
        if end == steps or forms[end] != forms[first]:
            segment = Segment(first, [])
            for step in range(first, end + 1):
                _pack_step(result, segment, scene, sources, forms[first], step / steps, emissive, materials)
            result.segments.append(segment)
            first = end
    return result


def _pack_step(
    result: Elsewhere,
    segment: Segment,
    scene: Scene,
    sources: list[Lamp],
    forms: tuple,
    time: float,
    emissive: np.ndarray,
    materials: np.ndarray,
) -> None:
    """Add the tables and bounds at one time of a segment."""
    there = at(scene, time, emissive)
    built, places = [], []
    for lamp, (shape, emission) in zip(sources, forms):
        place = replace(lamp_at(lamp, time), shape=shape, emission=emission)
        try:
            made = _build(place)
        except lamps.LampError:  # its shape is empty now
            place = replace(place, shape=lamp.shape, emission=lamp.emission, power=LEAST_POWER * lamp.power)
            made = _build(place)
        built.append(made)
        places.append(place)
    tables = lamps.pack_lamps(built)
    rows = tables["lamps"]
    low, high = lamp_boxes([tables])
    near, bounds, suns = lights.pack_near(
        there,
        np.stack([low, high], axis=1),
        4.0 * np.pi * rows["volume"][:, None] * rows["emission"],
        emissive_triangles(there, materials),
        places,
    )
    del near["light_infinite"]
    placed = cuts.pack_cuts(built, places)
    if segment.tables:
        for name in cuts.OF_REGIONS:
            placed["lamp_placements"][name] = segment.tables[0]["lamp_placements"][name]
    result.suns.append(dict(zip(suns["emitter"].tolist(), suns["direction"])))
    segment.tables.append({**tables, **placed, **near, **camera.pack_camera(there)})
    result.built.extend(built)
    if bounds is not None:
        result.bounds.append(bounds)


def instance_boxes(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """(instances, 3) centers and half sizes of world boxes around the instances, over all their motion."""
    used = [instance for instance in scene.instances if len(scene.meshes[instance.mesh].positions)]
    bounds = {}
    for mesh in {instance.mesh for instance in used}:
        positions = geometry.positions_of(scene.meshes[mesh])
        beyond = margin(scene.meshes[mesh])
        bounds[mesh] = np.stack(geometry.bounds_of(positions))
        bounds[mesh] += np.array([[-beyond], [beyond]])
    if not used:
        return np.zeros((0, 3)), np.zeros((0, 3))
    low, high = np.stack([bounds[instance.mesh] for instance in used], axis=1)
    matrices = np.stack([instance.matrix[:3] for instance in used])
    center = (matrices[:, :, :3] * (0.5 * (low + high))[:, None]).sum(axis=2) + matrices[:, :, 3]
    half = (np.abs(matrices[:, :, :3]) * (0.5 * (high - low))[:, None]).sum(axis=2)
    for index in (index for index, instance in enumerate(used) if instance.motion is not None):
        poses = used[index].motion[:, :3]
        at = poses[:, :, :3] @ (0.5 * (low + high)[index]) + poses[:, :, 3]
        reach = np.abs(poses[:, :, :3]) @ (0.5 * (high - low)[index])
        first, last = (at - reach).min(axis=0), (at + reach).max(axis=0)
        center[index], half[index] = 0.5 * (first + last), 0.5 * (last - first)
    return center, half


def wide_boxes(scene: Scene, center: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Least and greatest coordinates (instances, 2, 3) of ``instance_boxes``, and some roundings more, for all
    instances: also for those without positions, whose box is inside out."""
    used = np.array([len(scene.meshes[instance.mesh].positions) > 0 for instance in scene.instances], bool)
    half = half + rays.OFFSET * (np.abs(center) + half).max(axis=1, initial=0.0)[:, None]
    boxes = np.repeat(EVERYWHERE[None, ::-1], len(used), 0)
    boxes[used] = np.stack([center - half, center + half], 1)
    return boxes


def clear_lamps(rows: np.ndarray, center: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(lamps,) whether the box around each lamp, of ``LAMP`` rows, intersects none of ``instance_boxes``."""
    return np.array([(np.abs(row["center"] - center) > row["half"] + half).any(axis=1).all() for row in rows], bool)


def integrator_scalars(scene: Scene, flags: np.ndarray, tables: dict[str, np.ndarray]) -> dict[str, float]:
    """Scalars of the block: settings of the integrator, and features of the scene. ``flags`` (materials,) are those of
    ``material_records.MATERIAL``."""
    settings = scene.settings
    names = (
        "seed",
        "sample_offset",
        "max_bounces",
        "diffuse_bounces",
        "glossy_bounces",
        "transmission_bounces",
        "volume_bounces",
        "transparent_bounces",
        "clamp_direct",
        "clamp_indirect",
        "filter_glossy",
        "transparent_film",
    )
    finite = any(kinds.KINDS[kinds.kind_of(light)].has_size(light) for light in scene.lights)
    world = scene.world.strength > 0.0 and (scene.world.image is not None or max(scene.world.color) > 0.0)
    emissive = bool((flags & HAS_EMISSION).any())
    return {
        **{name: getattr(settings, name) for name in names},
        "clearest": scene.clearest,
        "finite_lights": finite,
        "shows_environment": 0,
        "caustics": settings.caustics_reflective * GLOSSY | settings.caustics_refractive * TRANSMISSION,
        "emitters_hit": finite or world or emissive or media.glows(scene),
        "transparent_shadows": bool((flags & HAS_TRANSPARENCY).any()),
        "stops_light_rays": bool((flags & STOPS_LIGHT_RAYS).any()),
        "lamp_count": len(tables["lamps"]),
        **dict(zip(("lamp_strategy", "lamp_bsdf_mis_scale"), LAMP_STRATEGIES[settings.lamp_sampling])),
    }


def emissive_triangles(scene: Scene, materials: np.ndarray) -> lights.Triangles:
    """Every triangle of every instance whose material, of ``materials`` (n,), emits and is sampled, in world space."""
    emits = (materials["flags"] & HAS_EMISSION != 0) & (materials["sample_emission"] != 0)
    # Only a plain Emission of constant colour is uniform in space and direction.
    varies = (materials["graph"] != shading.NO_GRAPH) | np.array(
        [
            material.surface is None or isinstance(material.surface, Node) and material.surface.kind != "emission"
            for material in scene.materials
        ]
        or [True]
    )
    parts: list[tuple] = []
    emitting = set(np.flatnonzero(emits).tolist())
    for index, instance in enumerate(scene.instances):
        if emitting.isdisjoint(instance.materials):
            continue
        mesh = scene.meshes[instance.mesh]
        if mesh.primitive != Primitive.TRIANGLES:  # only found by chance, as in Cycles
            continue
        material = _triangle_materials(mesh, instance)
        chosen = np.flatnonzero(emits[material])
        corners = mesh.positions[mesh.triangles[chosen]].astype(np.float64)
        corners = corners @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]
        parts.append(
            (
                np.full(len(chosen), index),
                chosen,
                corners,
                materials["emission"][material[chosen]],
                varies[material[chosen]],
            )
        )
    if not parts:
        return lights.Triangles()
    return lights.Triangles(*(np.concatenate(columns) for columns in zip(*parts)))


def _triangle_materials(mesh: Mesh, instance: Instance) -> np.ndarray:
    """(triangles,) index of each triangle's material."""
    slots = np.zeros(len(mesh.triangles), np.int64) if mesh.slots is None else mesh.slots
    return np.array(instance.materials)[np.clip(slots, 0, len(instance.materials) - 1)]
