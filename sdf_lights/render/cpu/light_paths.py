# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths of a render: whether a scene can use them, their tree, and the vertices of each pass of samples."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...graph.formula import VARIABLE, order
from ..kernels.light_paths import tree
from ..kernels.light_paths.records import MOST_TOPS, NODE, VERTEX
from ..kernels.light_paths.trace import dim_unseen, find_pilots, trace_light_paths
from ..kernels.outputs.records import LOBES
from ..kernels.shading.material_compiler import LOBE_ALPHA, LOBE_DIFFUSE
from ..kernels.shading.records import GLOSSY, HAS_EMISSION, TRANSMISSION
from ..kernels.shading.special_lobes import LOBE_SHEEN, LOBE_VELVET, WITH_FACETS, WITH_THIN_WALL
from ..scene import ALL_SETS, MANY_BOUNCES, Ray, Scene, catches_shadows
from .block import PackedScene, Workspace

PATHS = 8192  # of each pass
MOST_VERTICES = 32  # of a path
NODES = 2048
PILOTS = 256
CHUNK = 512  # paths that a thread takes at once

SCATTERED = Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION | Ray.SHADOW
BY_PATH = {"ray_kind", "ray_length", "ray_singular", "depth"}  # what a material may ask of the ray that meets it


def can_connect(scene: Scene, packed: PackedScene) -> bool:
    """Whether connections find all light that they take from paths, and whether that is asked for.

    - Light comes from SDF lamps alone: no other paths start with light. Each lamp lights all, and all cast its shadows, after
      any number of bounces.
    - Each object is met by all kinds of rays but the camera's or by none, as a light path does not know yet what kind of ray
      it is seen by. For the same reason no material asks for the ray that meets it, no caustics are off, and no glossy filter is
      on.
    - Nothing moves, scatters in a volume or below a surface, is a strand, or catches shadows, and no closure may be sharp that
      a light path cannot follow: a portal, a thin wall, anisotropic or thin films.
    - No pass wants light by the lobe that scattered it first: what connections take from a ray is of diffuse lobes alone.
    - A light path has ``MOST_VERTICES`` at most, and passes transparent surfaces where there are some.
    """
    settings, world, block = scene.settings, scene.world, packed.block[0]
    lobes = packed.table("lobes")
    return bool(
        settings.lamp_paths
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


def diffuse_materials(packed: PackedScene) -> np.ndarray:
    """(materials,) 1 where all that a material scatters is diffuse."""
    kinds = packed.table("lobes")["kind"]
    return np.array(
        [int((kinds[first:end] == LOBE_DIFFUSE).all()) for first, end in packed.table("materials")["lobes"]], np.int64
    )


class LightPaths:
    """Light paths of a packed scene. ``renew`` gives it those of another pass, the same ones on any number of threads."""

    @classmethod
    def of(cls, scene: Scene, packed: PackedScene) -> LightPaths | None:
        """None where the scene cannot use them; nothing is connected then."""
        packed.set_light_paths(None)
        return cls(scene, packed) if can_connect(scene, packed) else None

    def __init__(self, scene: Scene, packed: PackedScene):
        self._packed, self._size = packed, (scene.width, scene.height)
        self._width = vertices_of(scene, packed)
        self._raw = np.empty(PATHS * self._width, VERTEX)
        self._lengths = np.zeros(PATHS, np.int64)
        self._fixed: dict[str, np.ndarray] = {}

    def renew(self, number: int, workspaces: list[Workspace]) -> None:
        """Trace the light paths of the pass ``number``, by which they differ."""
        if not self._fixed:
            self._build(workspaces)
        if not len(self._fixed["light_path_tops"]):
            return
        self._trace(number + 1, workspaces)
        vertices = np.empty(self._lengths.sum(), VERTEX)
        tree.place(self._fixed["light_path_nodes"], self._raw, self._lengths, self._width, vertices)
        self._packed.set_light_paths(self._fixed | {"light_path_vertices": vertices})

    def _build(self, workspaces: list[Workspace]) -> None:
        """Make the tree by light paths that no pass has: weights must not depend on the vertices that they are for."""
        self._trace(0, workspaces)
        rows = np.arange(len(self._raw)).reshape(PATHS, self._width)
        vertices = self._raw[rows[np.arange(self._width) < self._lengths[:, None]]]
        pilots = np.zeros((PILOTS, 3))
        scene, scratch = workspaces[0].scene, workspaces[0].block
        pilots = pilots[: find_pilots(scene, scratch, *self._size, pilots)]
        nodes, tops, count, top_count = np.zeros(NODES, NODE), np.zeros(MOST_TOPS, np.int64), 0, 0
        if len(vertices) and len(pilots):
            dim_unseen(scene, scratch, vertices, pilots)
            count, top_count = tree.build(vertices, pilots, nodes, tops)
        self._fixed = {
            "light_path_nodes": nodes[:count].copy(),
            "light_path_tops": tops[:top_count].copy(),
            "light_path_materials": diffuse_materials(self._packed),
        }

    def _trace(self, number: int, workspaces: list[Workspace]) -> None:
        starts = iter(range(0, PATHS, CHUNK))

        def work(workspace: Workspace) -> None:
            for start in starts:
                trace_light_paths(
                    workspace.scene,
                    workspace.block,
                    start,
                    start + CHUNK,
                    PATHS,
                    number,
                    self._width,
                    self._raw,
                    self._lengths,
                )

        _each(work, workspaces)


def _each(work: Callable[[Workspace], None], workspaces: list[Workspace]) -> None:
    """Do the work in a thread for each workspace; the first error is raised here."""
    with ThreadPoolExecutor(len(workspaces)) as pool:
        for done in [pool.submit(work, workspace) for workspace in workspaces]:
            done.result()
