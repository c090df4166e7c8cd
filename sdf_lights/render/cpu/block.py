# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One record for the kernels to reach a whole scene by, and one for each thread's scratch memory."""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...emitter import cut as cuts
from ...emitter import surfaces
from ...jit import block_dtype, fill_table
from ..film import Film
from ..scene import Instance, Lamp, Mesh, Scene
from ..settings import LampSampling
from . import accumulate, camera, geometry, integrator, lamp_tree, lights, path, rays, shading
from .shading.records import HAS_EMISSION, HAS_TRANSPARENCY
from .workspace import WORKSPACE, WORKSPACE_TABLES

TABLES = {
    **lamps.TABLES, **cuts.TABLES, **surfaces.TABLES, **lamp_tree.TABLES, **camera.TABLES, **geometry.TABLES,
    **lights.TABLES,
    **shading.TABLES, **accumulate.TABLES, "control": np.dtype(np.int64)}
SCALARS = [
    *lamps.SCALARS, *camera.SCALARS, *geometry.SCALARS, *rays.SCALARS, *integrator.SCALARS, *accumulate.SCALARS]
BLOCK = block_dtype(TABLES, SCALARS)

# What the density of a BSDF counts, with the samplings that do not find that out.
LAMP_BETA = {LampSampling.MIS: 1.0, LampSampling.BSDF: np.inf}
LAMP_SLOT = {LampSampling.SURFACE: cuts.SURFACE, LampSampling.BOUNDING: cuts.BOUNDING}


class PackedScene:
    """A scene as the kernels read it: ``block`` (one record) and everything that it points at.

    Appends to ``scene.warnings`` what had to be left out.
    """

    def __init__(self, scene: Scene, film: Film):
        self._images = scene.images  # whose pixels the tables point at
        materials = shading.pack_materials(scene)
        self._flags = materials["materials"]["flags"]
        self._accelerator = rays.Accelerator(scene, self._flags & HAS_TRANSPARENCY != 0)
        layers = shading.uv_layers(scene)
        self._emissive = emissive_triangles(scene, materials["materials"])
        self.control = np.zeros(1, np.int64)
        self._tables: dict[str, np.ndarray] = {}
        self.block = np.zeros(1, BLOCK)
        self._fill({**materials, **geometry.pack_geometry(scene, self._accelerator.baked, layers),
                    "control": self.control}, {"uv_layer_count": len(layers)})
        self._accelerator.fill(self.block)
        self._boxes = instance_boxes(scene)
        self.relight(scene)
        self.aim(scene, film)
        # A name that no module declares, or one without its table, is a mistake of this file.
        assert self._tables.keys() == TABLES.keys(), self._tables.keys() ^ TABLES.keys()

    def _fill(self, tables: dict[str, np.ndarray], scalars: dict[str, float]) -> None:
        tables = {name: np.ascontiguousarray(array).view(TABLES[name]) for name, array in tables.items()}
        for name, array in tables.items():
            fill_table(self.block, name, array)
        self._tables |= tables
        for name, value in scalars.items():
            self.block[name] = value

    def relight(self, scene: Scene) -> None:
        """Take the lamps and lights of ``scene``, whose meshes, materials and world are the same as before.

        Workspaces made before do not fit any more.
        """
        built, sources = build_lamps(scene)
        tables = emitter_tables(scene, built, self._emissive)
        self.light_hits = lights.hit_capacity(tables)
        chosen = set(map(id, sources))
        self._built = [index for index, lamp in enumerate(scene.lamps) if id(lamp) in chosen]
        self.lamps = built  # whose compiled fields the tables point at
        packed = cuts.pack_cuts(built, sources)
        packed["lamp_placements"]["clear"] = clear_lamps(tables["lamps"], *self._boxes)
        self._fill({**tables, **packed}, lamps.pack_scalars(built))
        self._surfaces = surfaces.NONE
        self.span_rows = int(self.block["lamp_rows"][0])

    def aim(self, scene: Scene, film: Film) -> None:
        """Take the camera and the settings of ``scene``, the rays that its lamps are visible to, and another film.

        All else is the same as before.
        """
        self._show(np.array([int(scene.lamps[index].visibility) for index in self._built], np.int64))
        self._fill({**camera.pack_camera(scene), **accumulate.pack_film(film)},
                   {**camera.camera_scalars(scene), **accumulate.film_scalars(film)})
        self._fill({}, integrator_scalars(scene, self._flags, self._tables))
        if self._surfaces is surfaces.NONE and scene.settings.lamp_sampling == LampSampling.SURFACE:
            self._surfaces = surfaces.pack_surfaces(self.lamps, [scene.lamps[index] for index in self._built])
        self._fill(self._surfaces.tables, {})

    def _show(self, visibility: np.ndarray) -> None:
        """Make the lamps visible to these rays (lamps,), if they are not yet."""
        rows = self._tables["lamps"]
        if np.array_equal(rows["visibility"], visibility):
            return
        rows["visibility"] = self._tables["light_emitters"]["visibility"][:len(rows)] = visibility
        low, high = rows["center"] - rows["half"], rows["center"] + rows["half"]
        self._fill(lamp_tree.pack_lamp_tree(low, high, visibility), {})

    def release(self) -> None:
        """Free Embree's structures and the copies of the scene; kernels must not run on this block again."""
        self._accelerator = None
        self._tables, self._images, self.lamps, self._surfaces = {}, [], [], surfaces.NONE
        self.block[:] = 0


def build_lamps(scene: Scene) -> tuple[list[lamps.BuiltLamp], list[Lamp]]:
    """The lamps of ``scene`` that can give light, built, and what they were built from; of others it gets warnings."""
    built, sources = [], []
    for lamp in scene.lamps:
        try:
            built.append(lamps.build_lamp(
                lamp.name, lamp.shape, lamp.matrix, lamp.power, lamp.density, lamp.color, int(lamp.visibility),
                lamp.emission))
            sources.append(lamp)
        except lamps.LampError as error:
            scene.warnings.append(str(error))
    scene.warnings += lamps.doubts(built)
    return built, sources


def emitter_tables(scene: Scene, built: list[lamps.BuiltLamp], emissive: lights.Triangles) -> dict[str, np.ndarray]:
    """Tables of the lamps, of the tree that rays find them by, and of all other lights."""
    lamp_tables = lamps.pack_lamps(built)
    rows = lamp_tables["lamps"]
    low, high = rows["center"] - rows["half"], rows["center"] + rows["half"]
    light_tables = lights.pack_lights(
        scene, np.stack([low, high], axis=1), 4.0 * np.pi * rows["volume"][:, None] * rows["emission"], emissive)
    light_tables["light_emitters"]["visibility"][:len(built)] = rows["visibility"]
    return {**lamp_tables, **lamp_tree.pack_lamp_tree(low, high, rows["visibility"]), **light_tables}


def instance_boxes(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """(instances, 3) centers and half sizes of boxes around what is in the scene, in the world."""
    used = [instance for instance in scene.instances if len(scene.meshes[instance.mesh].positions)]
    bounds = {}
    for mesh in {instance.mesh for instance in used}:
        positions = scene.meshes[mesh].positions
        bounds[mesh] = np.stack([positions.min(axis=0), positions.max(axis=0)]).astype(np.float64)
    if not used:
        return np.zeros((0, 3)), np.zeros((0, 3))
    low, high = np.stack([bounds[instance.mesh] for instance in used], axis=1)
    matrices = np.stack([instance.matrix[:3] for instance in used])
    center = (matrices[:, :, :3] * (0.5 * (low + high))[:, None]).sum(axis=2) + matrices[:, :, 3]
    return center, (np.abs(matrices[:, :, :3]) * (0.5 * (high - low))[:, None]).sum(axis=2)


def clear_lamps(rows: np.ndarray, center: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(lamps,) whether the box around each lamp, of ``LAMP`` rows, meets none of those of ``instance_boxes``."""
    return np.array([(np.abs(row["center"] - center) > row["half"] + half).any(axis=1).all() for row in rows], bool)


def integrator_scalars(scene: Scene, flags: np.ndarray, tables: dict[str, np.ndarray]) -> dict[str, float]:
    settings = scene.settings
    names = ("seed", "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_bounces",
             "clamp_direct", "clamp_indirect", "caustics", "transparent_film")
    finite = bool(len(tables["light_areas"]) or (tables["light_balls"]["radius"] > 0.0).any()
                  or (tables["light_suns"]["one_minus_cos"] > 0.0).any())
    world = scene.world.strength > 0.0 and (scene.world.image is not None or max(scene.world.color) > 0.0)
    emissive = bool((flags & HAS_EMISSION).any())
    return {
        **{name: getattr(settings, name) for name in names}, "finite_lights": finite,
        "emitters_hit": finite or world or emissive, "transparent_shadows": bool((flags & HAS_TRANSPARENCY).any()),
        "lamp_count": len(tables["lamps"]), "lamp_cuts": settings.lamp_sampling == LampSampling.CUT,
        "lamp_slot": LAMP_SLOT.get(settings.lamp_sampling, cuts.PROJECTION),
        "lamp_beta": LAMP_BETA.get(settings.lamp_sampling, 0.0)}


def emissive_triangles(scene: Scene, materials: np.ndarray) -> lights.Triangles:
    """Every triangle of every instance whose material emits and is to be sampled, in world space."""
    emits = (materials["flags"] & HAS_EMISSION != 0) & (materials["sample_emission"] != 0)
    # Only a plain Emission of constant colour is the same everywhere and in all directions.
    varies = (materials["instructions"][:, 0] != materials["instructions"][:, 1]) | np.array(
        [material.surface is None or material.surface.kind != "emission" for material in scene.materials] or [True])
    parts: list[tuple] = []
    for index, instance in enumerate(scene.instances):
        if not emits[list(instance.materials)].any():
            continue
        mesh = scene.meshes[instance.mesh]
        material = _triangle_materials(mesh, instance)
        chosen = np.flatnonzero(emits[material])
        corners = mesh.positions[mesh.triangles[chosen]].astype(np.float64)
        corners = corners @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]
        parts.append((np.full(len(chosen), index), chosen, corners, materials["emission"][material[chosen]],
                      varies[material[chosen]]))
    if not parts:
        return lights.Triangles()
    return lights.Triangles(*(np.concatenate(columns) for columns in zip(*parts)))


def _triangle_materials(mesh: Mesh, instance: Instance) -> np.ndarray:
    """(triangles,) index of each triangle's material."""
    slots = np.zeros(len(mesh.triangles), np.int64) if mesh.slots is None else mesh.slots
    return np.array(instance.materials)[np.clip(slots, 0, len(instance.materials) - 1)]


def _new_table(name: str, count: int) -> np.ndarray:
    """A table of a workspace, with nothing in it."""
    if name == "ray":
        return rays.new_rays(count)
    dtype = WORKSPACE_TABLES[name]
    # Clearing the megabytes of boxes takes longer than packing a lamp; their keys say that there is nothing.
    return np.empty(count, dtype) if name == "lamp_boxes" else np.zeros(count, dtype)


class Workspace:
    """Scratch memory of one thread: ``block`` is one record of tables."""

    def __init__(self, packed: PackedScene, aside: bool = True):
        self._span_rows = packed.span_rows
        counts = {
            "spans": 2 * (packed.span_rows + len(packed.lamps)), "light_hits": packed.light_hits,
            **path.COUNTS, **shading.WORKSPACE_COUNTS, **cuts.WORKSPACE_COUNTS, **lights.WORKSPACE_COUNTS,
            **lamp_tree.workspace_counts(len(packed.lamps))}
        self._tables = {name: _new_table(name, count) for name, count in counts.items()}
        self.block = np.zeros(1, WORKSPACE)
        for name, array in self._tables.items():
            fill_table(self.block, name, array)
        if aside:
            self._aside = Workspace(packed, aside=False)
            fill_table(self.block, "aside", self._aside.block)

    def lamp_lengths(self) -> np.ndarray:
        """(lamps, 2) lengths that rays of this thread could not resolve in each lamp, and had inside it."""
        return self._tables["spans"].reshape(-1, 2)[self._span_rows:]
