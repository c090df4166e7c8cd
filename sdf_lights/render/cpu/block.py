# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene packed for the kernels, and the scratch memory of a thread."""

from __future__ import annotations

import numpy as np

from ... import emitter as lamps
from ...emitter.sampling import cut as cuts
from ...emitter.sampling import external, hidden
from ...jit import fill_table, new_tables
from ..errors import RenderError
from ..film import Film
from ..kernels import camera, geometry, lamp_tree, lights, motion, path, shading
from ..kernels import film as film_kernels
from ..kernels.caustic_paths import code_table as caustic_path_code
from ..kernels.caustic_paths import records as caustic_path_records
from ..kernels.light_paths import code_table as light_path_code
from ..kernels.light_paths import records as light_path_records
from ..kernels.media import code_table as media_code
from ..kernels.media import grids as media_grids
from ..kernels.media import pack as media
from ..kernels.media import records as media_records
from ..kernels.outputs import code_table as output_code
from ..kernels.outputs.pack import pack_outputs, workspace_counts
from ..kernels.packing import (
    BLOCK,
    TABLES,
    build_lamps,
    clear_lamps,
    emissive_triangles,
    emitter_tables,
    instance_boxes,
    integrator_scalars,
    lamp_boxes,
    pack_elsewhere,
    wide_boxes,
)
from ..kernels.path_reuse import code_table as path_reuse_code
from ..kernels.path_reuse import records as path_reuse_records
from ..kernels.shading import special
from ..kernels.shading.records import HAS_SUBSURFACE, HAS_TRANSPARENCY
from ..kernels.strands import code_table as strand_code
from ..kernels.subsurface import code_table as subsurface_code
from ..kernels.workspace import WORKSPACE, WORKSPACE_TABLES
from ..medium import some_varies
from ..scene import Lamp, Scene, catchers_only, catches_shadows
from ..settings import LampSampling
from ..strands import has_strands
from .accelerator import accelerator_of

# Large tables of which kernels read only what they have written: boxes of regions that have keys, and as many closures
# as a surface has. To clear them would take longer than the rest of the set-up of many scenes.
UNCLEARED = frozenset({"lamp_boxes", "closures"})


class PackedScene:
    """A scene in the form that kernels read: ``block`` (one record) and everything that it points to.

    Appends a warning to ``scene.warnings`` for everything left out.
    """

    def __init__(self, scene: Scene, film: Film, block: np.ndarray | None = None):
        """``block``: memory for it. Without it, a scene with shadow catchers has a second block with only the
        catchers."""
        self._images = scene.images  # the tables point to its pixels
        self._tables: dict[str, np.ndarray] = {}
        catches = block is None and catches_shadows(scene)
        self._blocks = np.zeros(2 if catches else 1, BLOCK) if block is None else block
        self.block = self._blocks[:1]
        self._bare: PackedScene | None = None
        self._copies: list[np.ndarray] = []  # of the block, (1,) each, for threads of a moving scene
        materials = self._pack_shading(scene)
        self._flags = materials["materials"]["flags"]
        deep = self._flags & HAS_SUBSURFACE != 0
        self._accelerator = accelerator_of(scene, self._flags & HAS_TRANSPARENCY != 0, deep)
        self._emissive = emissive_triangles(scene, materials["materials"])
        self.control = np.zeros(1, np.int64)
        strands = has_strands(scene)
        code = {"strand_code": strand_code.addresses(strands, (BLOCK, WORKSPACE)), "control": self.control}
        self._boxes = instance_boxes(scene)
        shapes = geometry.pack_geometry(scene, self._accelerator.baked)
        geometry.find_shared_places(shapes, wide_boxes(scene, *self._boxes))
        self._fill(shapes | code, {"has_strands": strands})
        self._accelerator.fill(self.block)
        tables, scalars = media.pack_media(scene)
        tables["media_code"] = media_code.addresses(scalars["has_media"], some_varies(scene), (BLOCK, WORKSPACE))
        self._fill(tables, scalars)
        self._fill(
            {
                "inner_scenes": self._accelerator.inner_scenes,
                "subsurface_code": subsurface_code.addresses(bool(deep.any()), (BLOCK, WORKSPACE)),
            },
            {"has_subsurface": bool(deep.any())},
        )
        self.set_light_paths({}, {})
        self.set_caustic_paths({}, {})
        self.set_path_reuse(0)
        self._segments: list[motion.Moving] = []
        self.update_lights(scene)
        self.update_camera(scene, film)
        self._pack_motion(scene)
        if some_varies(scene):
            workspace = Workspace(self)  # owns the memory of its block
            grids = media_grids.fill_grids(scene, self.block, workspace.block, self._tables)
            self._fill(grids, {"media_step": media_grids.least_section(*self._boxes)})
        # A name that no module declares, or one without its table, is a bug in this file.
        assert self._tables.keys() == TABLES.keys(), self._tables.keys() ^ TABLES.keys()
        if catches:
            self._bare = PackedScene(catchers_only(scene), film, self._blocks[1:])
            self._separate_bare()

    def _separate_bare(self) -> None:
        """Let the block of the catchers write no passes, and share no stored boxes of lamps in the workspaces."""
        self._bare.block["outputs"], self._bare.block["region_set"] = 0, 1

    def _pack_shading(self, scene: Scene) -> dict[str, np.ndarray]:
        """Tables of materials, and of the nodes of lights and of the world."""
        tables, self._graphs = shading.pack_materials(scene)
        tables["graph_addresses"] = self._graphs.addresses((BLOCK, WORKSPACE))
        tables["special_code"] = special.addresses(tables["lobes"], (BLOCK, WORKSPACE))
        self._fill(tables, {"emission_graphs": bool((tables["emissions"]["graph"] != shading.NO_GRAPH).any())})
        return tables

    def _fill(self, tables: dict[str, np.ndarray], scalars: dict[str, float]) -> None:
        tables = {name: np.ascontiguousarray(array).view(TABLES[name]) for name, array in tables.items()}
        for name, array in tables.items():
            fill_table(self.block, name, array)
        self._tables |= tables
        for name, value in scalars.items():
            self.block[name] = value

    def _fill_all(self, tables: dict[str, np.ndarray], scalars: dict[str, float]) -> None:
        """As ``_fill``, also for threads that have blocks of their own. None of these tables moves."""
        self._fill(tables, scalars)
        for block in self._copies:
            for name in tables:
                fill_table(block, name, self._tables[name])
            for name, value in scalars.items():
                block[name] = value

    @property
    def graphs(self) -> shading.Graphs:
        """The formulas of all materials."""
        return self._graphs

    def table(self, name: str) -> np.ndarray:
        """A table that kernels read."""
        return self._tables[name]

    def lamps_of(self, scene: Scene) -> list[Lamp]:
        """The lamps of ``scene`` by their emitters: without those that give no light."""
        return [scene.lamps[index] for index in self._built]

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The corners of a box around all that rays may hit."""
        center, half = self._boxes
        if not len(center):
            return np.zeros(3), np.zeros(3)
        return (center - half).min(axis=0), (center + half).max(axis=0)

    def set_hidden_parts(self, seen: list[np.ndarray | None]) -> bool:
        """Take the sums of ``emitter.sampling.hidden`` of each lamp, or None. Returns whether they differ: then boxes
        of regions that workspaces know are those of other sums."""
        first = np.full(len(seen), hidden.NONE)
        known = [each for each in seen if each is not None]
        first[[each is not None for each in seen]] = hidden.ROWS * np.arange(len(known))
        sums = np.concatenate([np.zeros(0, hidden.SEEN), *known])
        placed = self._tables["lamp_placements"]
        if np.array_equal(placed["first_seen"], first) and np.array_equal(self._tables["lamp_seen"], sums):
            return False
        placed["first_seen"] = first
        self._fill({"lamp_seen": sums}, {})
        return True

    def set_path_reuse(self, step: int, connects: bool = False) -> None:
        """Let the paths of neighbouring pixels share their branches; 0: not. Of so many paths, one shares an arrival
        that is not diffuse. ``connects``: they share vertices of light paths, too."""
        code = {"path_reuse_code": path_reuse_code.addresses(step > 0, connects, (BLOCK, WORKSPACE))}
        self._fill_all(code, {"reuses_paths": step > 0, "reuse_step": step})

    def set_light_paths(self, tables: dict[str, np.ndarray], scalars: dict[str, float]) -> None:
        """Connect paths with the vertices of light paths in these tables of ``light_paths.records``; with nothing
        without them."""
        connects = "light_path_vertices" in tables
        code = {"light_path_code": light_path_code.addresses(connects, (BLOCK, WORKSPACE))}
        self._fill_all(_empty(light_path_records.TABLES) | tables | code, scalars | {"light_paths": connects})

    def set_caustic_paths(self, tables: dict[str, np.ndarray], scalars: dict[str, float]) -> None:
        """Share light behind mirrors with the caustic paths of these tables of ``caustic_paths.records``; with none
        without them."""
        shares = "caustic_power" in tables
        code = {"caustic_code": caustic_path_code.addresses(shares, (BLOCK, WORKSPACE))}
        self._fill(_empty(caustic_path_records.TABLES) | tables | code, scalars | {"caustic_paths": shares})

    def update_lights(self, scene: Scene) -> None:
        """Take the lamps and lights of ``scene``. Its meshes, materials and world must be unchanged.

        Earlier workspaces become invalid.
        """
        self._copies = []
        if self._bare is not None:
            self._bare.update_lights(catchers_only(scene))
            self._separate_bare()
        if any(light.emission is not None for light in scene.lights) or len(scene.lights) + 1 != len(
            self._tables["emissions"]
        ):
            self._pack_shading(scene)
        built, sources, self._built = build_lamps(scene)
        self._elsewhere = pack_elsewhere(scene, sources, self._tables["materials"])
        tables = emitter_tables(scene, built, sources, self._emissive, self._tables, self._graphs, self._elsewhere)
        self.light_hits = lights.hit_capacity(tables)
        self.lamps = built  # the tables point to their compiled fields
        packed = cuts.pack_cuts(built, sources)
        everywhere = [tables, *(self._elsewhere.tables if self._elsewhere else ())]
        clear = np.all([clear_lamps(each["lamps"], *self._boxes) for each in everywhere], axis=0)
        for each in (packed, *everywhere[1:]):
            each["lamp_placements"]["clear"] = clear
        elsewhere = self._elsewhere.built if self._elsewhere else []
        self._fill({**tables, **packed}, lamps.pack_scalars([*built, *elsewhere]))
        self._external = external.NONE
        self.span_rows = int(self.block["lamp_rows"][0])

    def update_camera(self, scene: Scene, film: Film) -> None:
        """Take the camera, the settings and the ray visibility of lamps of ``scene``, and another film.

        Everything else must be unchanged.
        """
        if self._bare is not None:
            self._bare.update_camera(catchers_only(scene), film)
            self._separate_bare()
        self._show(np.array([int(scene.lamps[index].visibility) for index in self._built], np.int64))
        self._fill(camera.pack_camera(scene), camera.camera_scalars(scene))
        self._fill({}, integrator_scalars(scene, self._flags, self._tables))
        self.set_film(scene, film)
        self._fill({}, media.camera_scalars(scene.camera, self._tables["media_bounds"], scene, *self._boxes))
        if self._external is external.NONE and scene.settings.lamp_sampling is LampSampling.EXTERNAL:
            self._external = self._pack_external(self.lamps_of(scene))
        self._fill(self._external.tables, {})

    def set_film(self, scene: Scene, film: Film) -> None:
        """Add the next samples to this film."""
        self._fill_all(film_kernels.pack_film(film), film_kernels.film_scalars(film))
        emitters = [*self.lamps_of(scene), *scene.lights, scene.world]
        tables, scalars = pack_outputs(scene, film, emitters, self._emissive.instance)
        tables["output_code"] = output_code.addresses(film, (BLOCK, WORKSPACE))
        scalars["shows_environment"] = film.sums["environment"].size > 0
        self._fill_all(tables, scalars)
        self.output_counts = workspace_counts(film)

    def _pack_motion(self, scene: Scene) -> None:
        """The shutter, and the tables that move while it is open."""
        tables, scalars = motion.pack_shutter(scene)
        tables |= {"moving": np.zeros(0), "moving_places": np.zeros(0, np.int64), "moving_keys": np.zeros(0)}
        steps: list[int] = []
        if self._elsewhere:
            self._elsewhere.follow_suns(self._tables["light_infinite"])
            for segment in self._elsewhere.segments:
                base = self._elsewhere.base(segment, self._tables)
                self._segments.append(motion.Moving(base, segment.tables, segment.first_step))
                steps += (len(segment.tables) - 1) * [len(self._segments) - 1]
        elif scene.shutter is not None:
            self._segments, steps = [motion.Moving({}, [])], [0]
        tables["shutter_segments"] = np.array(steps or [0], np.int64)
        scalars["segments"] = max(len(self._segments), 1)
        self._fill(tables, scalars)
        self.moves = scene.shutter is not None

    def own_blocks(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Blocks for a thread, and the objects that they keep alive. In a moving scene, each thread has separate
        blocks, at its own time: one for each segment of the shutter."""
        if not self.moves:
            return self._blocks, []
        blocks, kept = [], []
        for packed in [self, self._bare] if self._bare else [self]:
            instances = packed._tables["instances"].copy()
            for segment in packed._segments:
                own = segment.own() | {"instances": instances}
                block = packed.block.copy()
                for name, array in (segment.fixed | own).items():
                    fill_table(block, name, array)
                for name, value in segment.scalars.items():
                    block[name] = value
                block["region_set"] = len(blocks)
                blocks.append(block)
                kept += own.values()
        found = np.concatenate(blocks)
        self._copies += [found[row : row + 1] for row in range(len(self._segments))]
        return found, kept

    def _pack_external(self, sources: list[Lamp]) -> external.Packed:
        found = external.registered()
        if found is None:
            raise RenderError(
                "The scene uses an external sampling of lamps, but none is registered: choose another sampling."
            )
        return external.pack_external(found, self.lamps, sources, (BLOCK, WORKSPACE))

    def _show(self, visibility: np.ndarray) -> None:
        """Make the lamps visible to these rays (lamps,), unless they already are."""
        rows = self._tables["lamps"]
        if np.array_equal(rows["visibility"], visibility):
            return
        emitters = self._tables["light_emitters"][: len(rows)]
        rows["visibility"] = emitters["visibility"] = emitters["met"] = visibility
        for each in self._elsewhere.tables if self._elsewhere else ():
            each["lamps"]["visibility"] = visibility
        low, high = lamp_boxes([self._tables, *(self._elsewhere.tables if self._elsewhere else ())])
        self._fill(lamp_tree.pack_lamp_tree(low, high, visibility), {})

    def release(self) -> None:
        """Free Embree's structures and the copies of the scene. Kernels must not run on this block again."""
        self._accelerator = None
        self._tables, self._images, self.lamps, self._external = {}, [], [], external.NONE
        self._elsewhere = self._bare = None
        self._segments, self._copies = [], []
        self._blocks[:] = 0


def _empty(kinds: dict[str, np.dtype]) -> dict[str, np.ndarray]:
    """Tables without rows."""
    return {name: np.zeros(0, dtype) for name, dtype in kinds.items()}


class Workspace:
    """Scratch memory of one thread: ``block`` is one record of tables. ``scene`` is the block of the scene for the
    thread."""

    def __init__(self, packed: PackedScene, secondary: bool = True):
        if secondary:
            self.scene, self._own = packed.own_blocks()
        self._span_rows = packed.span_rows
        counts = {
            "spans": 2 * (packed.span_rows + len(packed.lamps)),
            "light_hits": packed.light_hits,
            **path.COUNTS,
            **(path_reuse_records.COUNTS if secondary else {}),
            **shading.WORKSPACE_COUNTS,
            **cuts.WORKSPACE_COUNTS,
            **lights.WORKSPACE_COUNTS,
            **light_path_records.WORKSPACE_COUNTS,
            **media_records.workspace_counts(packed._tables),
            **packed.output_counts,
            **lamp_tree.workspace_counts(len(packed.lamps)),
        }
        self._tables = new_tables({name: WORKSPACE_TABLES[name] for name in counts}, counts, UNCLEARED)
        self.block = np.zeros(1, WORKSPACE)
        for name, array in self._tables.items():
            fill_table(self.block, name, array)
        self._secondary = None
        if secondary:
            self._secondary = Workspace(packed, secondary=False)
            fill_table(self.block, "secondary", self._secondary.block)
            self._points, self._of_points = _point_workspaces()
            fill_table(self.block, "points", self._points)

    def arrivals(self) -> np.ndarray:
        """(1,) ``path_reuse.records.ARRIVAL`` of this thread, which counts arrivals."""
        return self._tables["reuse_arrival"]

    def forget_regions(self) -> None:
        """Forget the boxes of lamps that regions have."""
        self._tables["lamp_regions"][:] = 0
        if self._secondary is not None:
            self._secondary.forget_regions()

    def lamp_lengths(self) -> np.ndarray:
        """(lamps, 2) lengths along rays of this thread: unresolved in each lamp, and inside it."""
        return self._tables["spans"].reshape(-1, 2)[self._span_rows :]


def _point_workspaces() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Workspaces for the points of path reuse and for the arrival as they see it, and the tables that they share."""
    blocks = np.zeros(2 * path_reuse_records.GROUP, WORKSPACE)
    counts = {name: shading.WORKSPACE_COUNTS[name] for name in ("surface", "closures")}
    dtypes = {name: WORKSPACE_TABLES[name] for name in counts}
    tables = new_tables(dtypes, {name: len(blocks) * count for name, count in counts.items()}, UNCLEARED)
    for name, array in tables.items():
        blocks[name + "_address"] = array.ctypes.data + counts[name] * array.itemsize * np.arange(len(blocks))
        blocks[name + "_count"] = counts[name]
    return blocks, tables
