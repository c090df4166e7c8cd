# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths of a render: whether a scene can use them, their tree, and the vertices of each pass of samples."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...graph.formula import VARIABLE, order
from ..kernels.light_paths import tree
from ..kernels.light_paths.records import CONNECTS, MOST_TOPS, NODE, ONLY_DIFFUSE, VERTEX
from ..kernels.light_paths.trace import dim_unseen, find_pilots, trace_light_paths
from ..kernels.outputs.records import LOBES
from ..kernels.shading.material_records import LOBE_ALPHA, LOBE_DIFFUSE, LOBE_TRANSLUCENT
from ..kernels.shading.records import GLOSSY, HAS_EMISSION, TRANSMISSION
from ..kernels.shading.special_lobes import LOBE_SHEEN, LOBE_VELVET, WITH_FACETS, WITH_THIN_WALL
from ..scene import ALL_SETS, MANY_BOUNCES, Ray, Scene, catches_shadows
from ..settings import LARGEST_BATCH, LampPaths
from .block import PackedScene, Workspace

# Samples of pixels for each light path of a pass, and for each of the tree: both take about 2 % of the time of these
# samples.
SHARED, TREE_SHARED = 16, 32
MOST_PATHS, MOST_TREE_PATHS = 16384, 8192
PILOT_NUMBER = 1 << 30  # of light paths: beyond those of samples
MOST_VERTICES = 32  # of a path
NODES = 2048
PILOTS = 256
CHUNK = 256  # paths that a thread takes at once

SCATTERED = Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION | Ray.SHADOW
BY_PATH = {"ray_kind", "ray_length", "ray_singular", "depth"}  # what a material may ask of the ray that meets it


def can_connect(scene: Scene, packed: PackedScene) -> bool:
    """Whether connections find all light that they take from paths, and whether that is asked for.

    - Light comes from SDF lamps alone: no other paths start with light. Each lamp lights all, and all cast its shadows,
      after any number of bounces.
    - Each object is met by all kinds of rays but the camera's or by none, as a light path does not know yet what kind
      of ray it is seen by. For the same reason no material asks for the ray that meets it, no caustics are off, and no
      glossy filter is on.
    - Nothing moves, scatters in a volume or below a surface, is a strand, or catches shadows, and no closure may be
      sharp that a light path cannot follow: a portal, a thin wall, anisotropic or thin films.
    - No pass wants light by the lobe that scattered it first: what connections take from a ray is of diffuse lobes
      alone.
    - A light path has ``MOST_VERTICES`` at most, and passes transparent surfaces where there are some.
    """
    settings, world, block = scene.settings, scene.world, packed.block[0]
    lobes = packed.table("lobes")
    return bool(
        settings.lamp_paths is not LampPaths.NEVER
        and settings.max_bounces > 0
        and vertices_of(scene, packed) <= MOST_VERTICES
        and (settings.transparent_bounces > 0 or not block["transparent_shadows"])
        and block["lamp_count"] > 0
        and not scene.lights
        and (world.strength <= 0.0 or world.image is None and world.emission is None and max(world.color) <= 0.0)
        and not (packed.table("materials")["flags"] & HAS_EMISSION).any()
        and all(
            lamp.receivers == lamp.blockers == ALL_SETS
            and lamp.max_bounces >= MANY_BOUNCES
            and not lamp.sampled_only
            and lamp.visibility & SCATTERED == SCATTERED
            for lamp in scene.lamps
        )
        and all(
            each.visibility & SCATTERED in (SCATTERED, 0) and each.receivers == each.blockers == ALL_SETS
            for each in scene.instances
        )
        and not any(block[name] for name in ("has_media", "has_subsurface", "has_strands"))
        and not packed.moves
        and not catches_shadows(scene)
        and not block["outputs"] & LOBES
        and settings.filter_glossy == 0.0
        and block["caustics"] == GLOSSY | TRANSMISSION
        and np.isin(lobes["kind"], (*range(LOBE_ALPHA + 1), LOBE_SHEEN, LOBE_VELVET)).all()
        and not (lobes["features"] & (WITH_FACETS | WITH_THIN_WALL)).any()
        and not any(
            node.kind == VARIABLE and node.value[0] in BY_PATH
            for roots in packed.graphs.structures
            for node in order(*roots)
        )
    )


def vertices_of(scene: Scene, packed: PackedScene) -> int:
    """The most vertices that a light path can have: a surface that is partly transparent may have one, too."""
    passed = scene.settings.transparent_bounces if packed.block["transparent_shadows"][0] else 0
    return scene.settings.max_bounces + passed


def materials_of(packed: PackedScene) -> np.ndarray:
    """(materials,) CONNECTS and ONLY_DIFFUSE of each. Light that a material passes on diffusely is left to paths: of
    which side of it a light path comes, a path from the camera does not know."""
    kinds = packed.table("lobes")["kind"]
    lobes = [kinds[first:end] for first, end in packed.table("materials")["lobes"]]
    return np.array(
        [
            CONNECTS * int(LOBE_TRANSLUCENT not in each) | ONLY_DIFFUSE * int((each == LOBE_DIFFUSE).all())
            for each in lobes
        ],
        np.int64,
    )


class LightPaths:
    """Light paths of a packed scene, the same ones on any number of threads. ``use`` gives the scene those of some
    samples."""

    @classmethod
    def of(cls, scene: Scene, packed: PackedScene, workspaces: list[Workspace]) -> LightPaths | None:
        """None where the scene cannot use them, or should not; nothing is connected then."""
        packed.set_light_paths({})
        return cls(scene, packed, workspaces) if can_connect(scene, packed) else None

    def __init__(self, scene: Scene, packed: PackedScene, workspaces: list[Workspace]):
        self._scene, self._packed, self._workspaces = scene, packed, workspaces
        self._width = vertices_of(scene, packed)
        x0, y0, x1, y1 = scene.border or (0, 0, scene.width, scene.height)
        self._pixels = (x1 - x0) * (y1 - y0)
        self._materials = materials_of(packed)
        self._fixed: dict[str, np.ndarray] = {}
        self.rest()
        self.automatic = scene.settings.lamp_paths is LampPaths.AUTOMATIC

    def use(self, sample: int) -> int:
        """Connect the next paths with the light paths of the set to which this sample belongs; returns the end of the
        set.

        The set depends on the sample's number alone. Each is as large as its samples are worth.
        """
        size = 1
        while 2 * size <= min(sample, LARGEST_BATCH, MOST_PATHS * SHARED // self._pixels):
            size *= 2
        first = sample - sample % size
        self._connect(first + self._scene.settings.sample_offset, size)
        return first + size

    def use_pilot(self, sample: int) -> None:
        """As ``use``, for a pilot, with light paths that no set has."""
        self._connect(PILOT_NUMBER + sample, 1)

    def rest(self) -> None:
        """Connect the next paths with nothing."""
        self._packed.set_light_paths({"light_path_materials": self._materials})

    def _connect(self, number: int, samples: int) -> None:
        if not self._fixed:
            self._build()
        if not len(self._fixed["light_path_tops"]):
            return
        raw, lengths = self._trace(number + 1, _paths(self._pixels * samples / SHARED, MOST_PATHS))
        vertices = np.empty(lengths.sum(), VERTEX)
        tree.place(self._fixed["light_path_nodes"], raw, lengths, self._width, vertices)
        self._packed.set_light_paths(self._fixed | {"light_path_vertices": vertices})

    def _build(self) -> None:
        """Make the tree by light paths that no sample has: weights must not depend on the vertices that they are
        for."""
        samples = self._scene.settings.samples
        raw, lengths = self._trace(0, _paths(self._pixels * samples / TREE_SHARED, MOST_TREE_PATHS))
        rows = np.arange(len(raw)).reshape(len(lengths), self._width)
        vertices = raw[rows[np.arange(self._width) < lengths[:, None]]]
        pilots = np.zeros((PILOTS, 3))
        scene, scratch = self._workspaces[0].scene, self._workspaces[0].block
        pilots = pilots[: find_pilots(scene, scratch, self._scene.width, self._scene.height, pilots)]
        nodes, tops, count, top_count = np.zeros(NODES, NODE), np.zeros(MOST_TOPS, np.int64), 0, 0
        if len(vertices) and len(pilots):
            dim_unseen(scene, scratch, vertices, pilots)
            count, top_count = tree.build(vertices, pilots, nodes, tops)
        self._fixed = {
            "light_path_nodes": nodes[:count].copy(),
            "light_path_tops": tops[:top_count].copy(),
            "light_path_materials": self._materials,
        }

    def _trace(self, number: int, paths: int) -> tuple[np.ndarray, np.ndarray]:
        """Trace the light paths of this number: rows of ``_width`` vertices for each path, and how many it has."""
        raw, lengths = np.empty(paths * self._width, VERTEX), np.zeros(paths, np.int64)
        starts = iter(range(0, paths, CHUNK))
        taking = threading.Lock()

        def work(workspace: Workspace) -> None:
            while True:
                with taking:
                    start = next(starts, None)
                if start is None:
                    return
                trace_light_paths(
                    workspace.scene, workspace.block, start, start + CHUNK, paths, number, self._width, raw, lengths
                )

        _each(work, self._workspaces)
        return raw, lengths


def _paths(wanted: float, most: int) -> int:
    """A number of light paths, in whole chunks."""
    return CHUNK * min(max(round(wanted / CHUNK), 1), most // CHUNK)


def _each(work: Callable[[Workspace], None], workspaces: list[Workspace]) -> None:
    """Do the work in a thread for each workspace; the first error is raised here."""
    with ThreadPoolExecutor(len(workspaces)) as pool:
        for done in [pool.submit(work, workspace) for workspace in workspaces]:
            done.result()
