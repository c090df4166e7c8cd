# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths of a render: whether a scene can use them, their tree, and the vertices of each pass of samples."""

from __future__ import annotations

import threading

import numpy as np

from ..film import Film
from ..kernels.light_paths import tree
from ..kernels.light_paths.records import MOST_TOPS, NODE, VERTEX
from ..kernels.light_paths.trace import dim_unseen, find_pilots, trace_light_paths
from ..kernels.shading.material_compiler import LOBE_DIFFUSE
from ..scene import Scene
from .block import PackedScene, Workspace

PATHS = 8192  # of each pass
MOST_VERTICES = 12  # of a path
NODES = 2048
PILOTS = 64
CHUNK = 512  # paths that a thread takes at once


def diffuse_materials(packed: PackedScene) -> np.ndarray:
    """(materials,) 1 where all that a material scatters is diffuse."""
    kinds = packed.table("lobes")["kind"]
    return np.array(
        [int((kinds[first:end] == LOBE_DIFFUSE).all()) for first, end in packed.table("materials")["lobes"]], np.int64
    )


def can_connect(scene: Scene) -> bool:
    return scene.settings.light_paths


class LightPaths:
    @classmethod
    def of(cls, scene: Scene, packed: PackedScene, film: Film) -> LightPaths | None:
        return cls(scene, packed) if can_connect(scene) else None

    def __init__(self, scene: Scene, packed: PackedScene):
        self._packed = packed
        self._materials = diffuse_materials(packed)
        self._size = scene.width, scene.height
        self._width = max(min(scene.settings.max_bounces, MOST_VERTICES), 1)
        self._raw = np.empty(PATHS * self._width, VERTEX)
        self._lengths = np.zeros(PATHS, np.int64)
        self._nodes: np.ndarray | None = None

    def renew(self, number: int, workspaces: list[Workspace]) -> None:
        """Trace the light paths of the pass ``number``."""
        if self._nodes is None:
            self._build(workspaces)
        self._trace(number + 1, workspaces)
        vertices = np.empty(self._lengths.sum(), VERTEX)
        tree.place(self._nodes, self._raw, self._lengths, self._width, vertices)
        self._packed.set_light_paths(
            {
                "light_path_nodes": self._nodes,
                "light_path_tops": self._tops,
                "light_path_vertices": vertices,
                "light_path_materials": self._materials,
            }
        )
        for workspace in workspaces:
            workspace.scene[:1] = self._packed.block

    def _build(self, workspaces: list[Workspace]) -> None:
        self._trace(0, workspaces)
        kept = np.arange(len(self._raw)).reshape(PATHS, self._width)
        vertices = self._raw[kept[np.arange(self._width) < self._lengths[:, None]]]
        pilots = np.zeros((PILOTS, 3))
        found = find_pilots(workspaces[0].scene, workspaces[0].block, *self._size, pilots)
        if found:
            dim_unseen(workspaces[0].scene, workspaces[0].block, vertices, pilots[:found])
        nodes, tops = np.zeros(NODES, NODE), np.zeros(MOST_TOPS, np.int64)
        count, top_count = tree.build(vertices, pilots[:found], nodes, tops)
        self._nodes, self._tops = nodes[:count].copy(), tops[:top_count].copy()

    def _trace(self, number: int, workspaces: list[Workspace]) -> None:
        starts = iter(range(0, PATHS, CHUNK))

        def work(workspace: Workspace) -> None:
            for start in starts:
                trace_light_paths(
                    workspace.scene,
                    workspace.block,
                    start,
                    min(start + CHUNK, PATHS),
                    PATHS,
                    number,
                    self._width,
                    self._raw,
                    self._lengths,
                )

        threads = [threading.Thread(target=work, args=(workspace,)) for workspace in workspaces]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
