# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustic paths of a render: whether a scene can use them, whether they pay, and the picture of each set of samples.

The picture of a set is kept apart from the sums of samples, which tell the noise of paths from the camera.

By default (``caustic_paths`` is *Automatic*) a few caustic paths tell what they find. If this is nothing, they are not
used. Else, with C_i for what path i of a set of N adds, R_i from ``weights.py``, and the weight w_i, the squared errors
of the picture for the samples of a set are estimated as

    V + Σ (w_i C_i)² + Σ R_i ((1 − w_i) C_i)²     with caustic paths, and     V + Σ R_i C_i²     without,

all relative to the square of the brightness there.

The last term is the noise of the same light by paths from the camera. These hardly ever find it, so their own samples
would not tell. V is all other noise, from two samples of some pixels. The number of paths is the best of a few by error
× time. Time is counted in rays.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...graph.formula import VARIABLE, order
from ...graph.functions import Function
from ..film import Film
from ..kernels.camera import filter_radius
from ..kernels.caustic_paths.records import KNOWN, MAY_DIFFER, MOST_MIRRORS, NARROW, RECORD, UNKNOWN
from ..kernels.caustic_paths.trace import add_to_image, trace_caustic_paths
from ..kernels.outputs.records import LIGHT, LOBES
from ..kernels.shading.material_records import NO_GRAPH
from ..kernels.shading.records import NEEDS_RAY
from ..sample_allocation import own_cost
from ..scene import Projection, Scene
from ..settings import MOST_BRANCHES, START_BRANCHES, CausticPaths
from .block import PackedScene, Workspace
from .caustic_targets import Sources, chances_of, find_targets, may_be_mirrors, put_lines
from .light_paths import CHUNK, PILOT_NUMBER, in_chunks, powers_of, treats_rays_alike

SET = 8  # samples of pixels that share one picture of the caustics
SAMPLE_COST = 2.5  # of a sample of a pixel, in rays, until some have told: about the least
RAYS = 5.0  # of a caustic path, until the pilot has told
SHARES = 0.01, 0.02, 0.04, 0.08, 0.16, 0.32  # parts of the time of samples, among which the best is chosen
ALWAYS_SHARE = 0.04  # where it is not chosen
# Paths of the pilot: for each pixel and sample of the render, which takes 0.5 % of its time, at least, and at most.
PILOT_PART, FEWEST, MOST = 0.0025, 256, 4096
LEAST_SAMPLES = 2 * SET  # of a render that tries them: the last set may be used in part
LEAST_GAIN = 1.3  # error × time without caustic paths over that with them, from which on they are used
TRIMMED = 0.02  # part of the pixels that the estimate of other noise leaves out: bright dots may be caustics
KEPT_CHANCE = 0.3  # part of a target's chance that does not depend on what the pilot has found there
# Records that tell how bright a caustic is, at most; the neighbours whose light is counted; and the least radius around
# these, in pixels.
MOST_RECORDS, NEIGHBOURS, LEAST_RADIUS = 1024, 8, 1.0
OF_PATCH = 8  # pixels with samples in a patch whose brightness without caustics is their mean
FLOOR = 0.02  # part of the square of the mean brightness that is added to the squares which errors are relative to
BATCH = 64 * CHUNK  # paths that are traced before they are added to the picture
SAME_FROM_ALL_SIDES = {"position", "barycentric"}


def supports_caustic_paths(scene: Scene, packed: PackedScene) -> bool:
    """Whether caustic paths may share light with paths from the camera, and whether that is asked for.

    - Light paths know the scene: see ``treats_rays_alike``. Nothing moves. Filter Glossy would blur mirrors behind
      diffuse bounces.
    - The camera is perspective or orthographic: other projections would need their inverse, and its derivatives.
    - No pass has parts of the light, but that of all SDF lamps.
    """
    settings, block = scene.settings, packed.block[0]
    return bool(
        settings.caustic_paths is not CausticPaths.NEVER
        and settings.max_bounces > 0
        and not packed.moves
        and settings.filter_glossy == 0.0
        and scene.camera.projection in (Projection.PERSPECTIVE, Projection.ORTHOGRAPHIC)
        and not block["outputs"] & (LOBES | LIGHT)
        and not (packed.table("materials")["flags"] & NEEDS_RAY).any()
        and treats_rays_alike(scene, packed)
    )


def pilot_paths(scene: Scene) -> int:
    """How many paths the pilot has; 0 for a render so short that caustic paths are not tried."""
    x0, y0, x1, y1 = scene.border or (0, 0, scene.width, scene.height)
    settings, pixels = scene.settings, (x1 - x0) * (y1 - y0)
    if settings.caustic_paths is CausticPaths.ALWAYS:
        return min(max(pixels, FEWEST), MOST)
    wanted = int(PILOT_PART * settings.samples * pixels)
    return min(wanted, MOST) if wanted >= FEWEST and settings.samples >= LEAST_SAMPLES else 0


def materials_of(packed: PackedScene) -> np.ndarray:
    """(materials,) UNKNOWN, MAY_DIFFER, KNOWN or NARROW.

    A bump depends on the distance along the ray, which is another for light paths. What depends on the direction may
    show a mirror to one side alone."""
    found = []
    for graph in packed.table("materials")["graph"]:
        nodes = order(*packed.graphs.structures[graph]) if graph != NO_GRAPH else ()
        names = {node.value[0] for node in nodes if node.kind == VARIABLE}
        looks = any(isinstance(node.value, Function) and node.value.scene for node in nodes)
        if "bump_step" in names:
            found.append(UNKNOWN)
        else:
            found.append(MAY_DIFFER if looks or names - SAME_FROM_ALL_SIDES else KNOWN)
    known = np.array(found, np.int64)
    known[(known == KNOWN) & may_be_mirrors(packed, known)] = NARROW  # closures tell how narrow they are
    return known


def follows_lobes(packed: PackedScene) -> dict[str, float]:
    """The scalar that tells whether narrow lobes scatter caustic paths. A light ray passes transparent surfaces, and
    does not tell whether it has. So no scene with some has these."""
    return {"caustic_lobes": float(not packed.block[0]["transparent_shadows"])}


class CausticTracer:
    """Caustic paths of a packed scene, the same ones on any number of threads."""

    @classmethod
    def of(cls, scene: Scene, packed: PackedScene, workspaces: list[Workspace]) -> CausticTracer | None:
        """None where the scene cannot use them, or should not; paths from the camera have all light then."""
        packed.set_caustic_paths({}, {})
        if not (pilot_paths(scene) and supports_caustic_paths(scene, packed)):
            return None
        lamps = packed.table("lamps")[: len(packed.lamps_of(scene))]
        if not len(lamps):
            return None
        sources = Sources.of(lamps, powers_of(scene, packed)[: len(lamps)])
        known = materials_of(packed)
        usable = may_be_mirrors(packed, known)
        if not (sources.powers.any() and usable.any()):
            return None
        packed.set_caustic_paths({}, follows_lobes(packed))
        targets = find_targets(scene, packed, workspaces[0], usable, sources)
        found = cls(scene, packed, workspaces, sources, known, targets) if len(targets) else None
        return found if found is not None and found._try() else None

    def __init__(
        self,
        scene: Scene,
        packed: PackedScene,
        workspaces: list[Workspace],
        sources: Sources,
        known: np.ndarray,
        targets: np.ndarray,
    ):
        self._scene, self._packed, self._workspaces = scene, packed, workspaces
        self._sources, self._known, self._targets = sources, known, targets
        self._chances = chances_of(targets, sources)
        self._window = np.array(scene.border or (0, 0, scene.width, scene.height), float)
        self._shape = int(self._window[3] - self._window[1]), int(self._window[2] - self._window[0])
        self._pixels = self._shape[0] * self._shape[1]
        self._paths = 0  # of a set
        self._set: int | None = None
        self._image = np.zeros((*self._shape, 3))
        self._records = np.zeros(BATCH * MOST_MIRRORS, RECORD)
        self._counts = np.zeros((BATCH, 2), np.int64)
        self._automatic = scene.settings.caustic_paths is CausticPaths.AUTOMATIC
        self._found = np.zeros(0, RECORD)  # by the pilot
        self._scale, self._cost = 1.0, RAYS  # of the pilot, in sets that ratios are for; and rays of a path
        self._sample_cost, self._tried = SAMPLE_COST, 0  # rays of a sample; and paths of a set that ratios are for

    def _try(self) -> bool:
        """Trace the paths of the pilot. Returns False if these show that caustic paths are of no use."""
        paths = pilot_paths(self._scene)
        self._tried = self._number(ALWAYS_SHARE, RAYS)
        self._set_up(self._tried)
        self._found, rays = self._traced(PILOT_NUMBER, paths, 0, paths)
        self._packed.set_caustic_paths({}, {})
        self._scale, self._cost = paths / self._tried, rays / paths
        return bool(len(self._found)) or not self._automatic

    def begin(self, try_without: Callable[[], Film | None]) -> bool:
        """Decide on the number of caustic paths, and let the scene share its light with them; False if they are not
        used. ``try_without`` gives a film with two samples of some pixels without them, or None."""
        alone = try_without()
        if alone is not None:
            known = np.flatnonzero(alone.count)
            met = alone.divided[known, 2].sum() / max(alone.count[known].sum(), 1)
            self._sample_cost = max(own_cost(alone, known) + float(met), SAMPLE_COST)
        share: float | None = ALWAYS_SHARE
        if self._automatic:
            share = None if alone is None else self._best_share(alone)
        if share is None:
            return False
        self._favour()
        self._paths = self._number(share, self._cost)
        self._set_up(self._paths)
        return True

    def use(self, film: Film, sample: int, end: int, stop: Callable[[], bool]) -> int | None:
        """Add the caustics of the set to which this sample belongs to the ``film``, for the samples up to the end of
        the set or to ``end``, which is returned. None if stopped before that.

        The set depends on the sample's number in the pattern of the seed alone, so renders that share the samples of a
        picture have the caustic paths of one render. Each is as large as its samples are worth."""
        offset = self._scene.settings.sample_offset
        first = sample + offset - (sample + offset) % SET
        if self._set != first:  # a range may begin inside a set, and take it in several batches
            self._set = None
            self._image[:] = 0.0
            for start in range(0, self._paths, BATCH):
                if stop():
                    return None
                records, _ = self._traced(first, self._paths, start, min(start + BATCH, self._paths))
                x0, y0 = int(self._window[0]), int(self._window[1])
                add_to_image(self._packed.block, records, x0, y0, self._image)
            self._set = first
        end = min(first + SET - offset, end)
        film.add_caustics(self._image.reshape(-1, 3), end - sample)
        return end

    def _number(self, share: float, cost: float) -> int:
        """The number of paths of a set that take this part of the time of its samples. ``cost``: rays of a path."""
        return max(round(share * SET * self._pixels * self._sample_cost / cost / CHUNK), 1) * CHUNK

    def _set_up(self, paths: int) -> None:
        """Let the scene share light with so many paths of a set."""
        scene, sources = self._scene, self._sources
        volumes = self._packed.table("lamps")["volume"][: len(sources.powers)]
        tables = {
            "caustic_targets": self._targets,
            "caustic_chances": self._chances.ravel(),
            "caustic_power": np.cumsum(sources.powers),
            "caustic_density": paths * sources.powers / (sources.powers.sum() * volumes),
            "caustic_materials": self._known,
        }
        put_lines(self._targets, self._chances, sources, paths)
        # Sample allocation lets paths divide often where caustics make them noisy.
        branches = scene.settings.indirect_paths or MOST_BRANCHES
        samples = {"caustic_samples": float(SET * branches)}
        self._packed.set_caustic_paths(tables, samples | follows_lobes(self._packed))

    def _traced(self, number: int, total: int, first: int, last: int) -> tuple[np.ndarray, int]:
        """The records of caustic paths ``first`` to before ``last`` of ``total``, ``BATCH`` at most, of a set, and the
        number of rays."""
        reach = filter_radius(self._scene.settings)
        window = self._window + np.array([-reach, -reach, reach, reach])

        def trace(workspace: Workspace, start: int, end: int) -> None:
            scene, scratch = workspace.scene, workspace.block
            trace_caustic_paths(scene, scratch, start, end, total, number, window, self._records, self._counts)

        in_chunks(trace, first, last, self._workspaces)
        counts = self._counts[: last - first]
        rows = self._records.reshape(BATCH, MOST_MIRRORS)[: last - first]
        return rows[np.arange(MOST_MIRRORS) < counts[:, :1]], int(counts[:, 1].sum())

    def _best_share(self, alone: Film) -> float | None:
        """The part of the time of samples with which error × time is least; None if that is hardly less than without.
        ``alone``: a film with two samples of some pixels."""
        known = np.flatnonzero(alone.count >= 2)
        _, of_all, total, _ = alone.squares[known].T
        mean = 0.5 * float(np.sort(total)[: int((1.0 - TRIMMED) * len(total))].mean())
        noise = np.maximum(of_all - total**2 / 2.0, 0.0) / _square(0.5 * total, mean)
        rest = float(np.sort(noise)[: int((1.0 - TRIMMED) * len(noise))].mean()) * self._pixels / SET
        if not self._scene.settings.indirect_paths:
            rest *= START_BRANCHES / MOST_BRANCHES  # as for caustics: see ``_set_up``
        # What paths of the pilot would have added in a set, and sums over the paths of a set by those of the pilot.
        every = -(-len(self._found) // MOST_RECORDS)
        records = self._found[::every]
        light, ratio = records["light"].sum(axis=1) * self._scale, records["ratio"]
        squares = (
            every * light**2 / self._scale / _square(self._lit(alone, records) + every * _brightness(records), mean)
        )
        without = rest + float((squares * ratio).sum())
        best, found = without / LEAST_GAIN, None
        for share in SHARES:
            more = self._number(share, self._cost) / self._tried
            weight = 1.0 - 1.0 / (1.0 + (ratio * more) ** 2)
            left = float((squares * (weight**2 / more + (1.0 - weight) ** 2 * ratio)).sum())
            product = (rest + left) * (1.0 + share)
            if product < best:
                best, found = product, share
        return found

    def _lit(self, alone: Film, records: np.ndarray) -> np.ndarray:
        """(records,) the brightness without caustics at their places, as a sum of RGB: means of patches of a film with
        samples of some pixels."""
        known = np.flatnonzero(alone.count)
        side = max(math.ceil(math.sqrt(OF_PATCH * self._pixels / len(known))), 1)
        rows, columns = (-(-length // side) for length in self._shape)
        patch = known // self._shape[1] // side * columns + known % self._shape[1] // side
        light = np.bincount(patch, alone.squares[known, 2], rows * columns)
        count = np.bincount(patch, alone.count[known], rows * columns)
        whole = light.sum() / count.sum()
        means = np.where(count > 0, light / np.maximum(count, 1), whole)
        x, y = (
            np.clip((records[axis] - self._window[place]) // side, 0, most - 1).astype(np.int64)
            for place, (axis, most) in enumerate((("x", columns), ("y", rows)))
        )
        return means[y * columns + x]

    def _favour(self) -> None:
        """Aim more at targets by way of which the pilot has found more light."""
        aimed = self._found[self._found["target"] >= 0]
        light = aimed["light"].sum(axis=1) * aimed["weight"]
        found = np.bincount(aimed["target"], light, len(self._targets))
        if found.sum() > 0.0:
            powers = self._sources.powers / self._sources.powers.sum()
            factor = KEPT_CHANCE + (1.0 - KEPT_CHANCE) * found / found.sum() / (powers @ self._chances)
            self._chances = self._chances * factor
            self._chances /= self._chances.sum(axis=1, keepdims=True)


def _square(brightness: np.ndarray, mean: float) -> np.ndarray:
    """What squared errors are relative to."""
    return brightness**2 + FLOOR * mean**2 + 1e-300


def _brightness(records: np.ndarray) -> np.ndarray:
    """(n,) about how bright the caustic is at the places of records (n,) of the pilot, as a sum of RGB: the light of
    some neighbours over the area of the disk around them. Caustics are bright along lines, which a grid would blur."""
    light, places = records["light"].sum(axis=1), np.stack([records["x"], records["y"]], axis=1)
    found = np.empty(len(records))
    near = min(NEIGHBOURS, len(records))
    for index, place in enumerate(places):
        square = ((places - place) ** 2).sum(axis=1)
        nearest = np.argpartition(square, near - 1)[:near]
        found[index] = light[nearest].sum() / (np.pi * max(float(square[nearest].max()), LEAST_RADIUS**2))
    return found
