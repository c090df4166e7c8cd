# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light paths of a render: whether a scene can use them, their tree, and the vertices of each pass of samples."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...graph.formula import VARIABLE, order
from ..kernels.light_paths import tree
from ..kernels.light_paths.distant import measure
from ..kernels.light_paths.places import find_places
from ..kernels.light_paths.records import (
    CONNECTS,
    CONNECTS_ALL,
    FOLLOW_ALL,
    FOLLOW_DIFFUSE,
    MOST_NODES,
    MOST_TOPS,
    NODE,
    TARGET,
    VERTEX,
)
from ..kernels.light_paths.trace import trace_light_paths, weight_by_visibility
from ..kernels.lights.kinds import KINDS, TRIANGLE
from ..kernels.motion import NOT_ROLLING, stop_at
from ..kernels.outputs.records import LOBES
from ..kernels.shading.material_records import (
    LOBE_ALPHA,
    LOBE_DIFFUSE,
    LOBE_GLASS,
    LOBE_GLOSSY,
    LOBE_PRINCIPLED,
    LOBE_REFRACTION,
    LOBE_TRANSLUCENT,
)
from ..kernels.shading.records import (
    GLOSSY,
    HAS_EMISSION,
    HAS_TRANSPARENCY,
    STOPS_LIGHT_RAYS,
    TRACES_RAYS,
    TRANSMISSION,
)
from ..kernels.shading.special_lobes import (
    LOBE_SHEEN,
    LOBE_SUBSURFACE,
    LOBE_VELVET,
    ONCE,
    WITH_FACETS,
    WITH_SUBSURFACE,
    WITH_THIN_SCATTERING,
    WITH_THIN_WALL,
)
from ..sample_allocation import GOLDEN
from ..scene import ALL_SETS, MANY_BOUNCES, Instance, Lamp, Light, Primitive, Ray, Scene, catches_shadows
from ..settings import LARGEST_BATCH, LampPaths
from .block import PackedScene, Workspace

# Samples of pixels for each light path of a pass, which takes about 4 % of the time of these samples; pixels for each
# light path of the tree. The tree does not depend on the number of samples, so ranges of samples have the tree of the
# whole. A pilot has fewer of both.
SHARED, TREE_SHARED = 8, 1
# Samples of a denoised picture that have a light path each, the first ones. All pixels share the noise of light paths,
# so a denoiser cannot see it, and with few light paths it is what is left.
DENOISED_SAMPLES = 1 << 16
PILOT_SHARED, PILOT_TREE_SHARED = 16, 8
MOST_PATHS, MOST_TREE_PATHS = 16384, 8192
# In moving scenes: how many times the light paths of a set have; and the time at which the camera looks for the places
# that a tree and targets are for.
TIMES, MIDDLE = 8, 0.5
PILOT_NUMBER = 1 << 30  # of light paths: beyond those of samples
MOST_VERTICES = 32  # of a path
CONNECTIONS = 2  # for each ray that scatters where paths split
PATH_COST = 2.0  # of a light path, in samples of pixels
# Of the world and suns: targets of their light paths, and places among which these are chosen; what a place counts at
# least, as a part of the mean; the neighbour whose distance is the radius of a target, and the least radius, as a part
# of the scene's; the least power, as a part of all.
TARGETS, PLACES, LEAST_REACHED, NEIGHBOUR, LEAST_RADIUS, LEAST_POWER = 64, 512, 0.05, 4, 1.0 / 1024.0, 0.02
PILOTS = 256
CHUNK = 256  # paths that a thread takes at once
# The least chance with which a path goes on where connections find its light: if nothing else comes that way, and if
# some light does that light paths cannot follow, whose noise grows with it.
MOST_ROULETTE, SOME_ROULETTE = 0.02, 0.3
SIMPLE_LOBES = (*range(LOBE_ALPHA + 1), LOBE_SHEEN, LOBE_VELVET)
UNBLURRED_LOBES = tuple(
    set(SIMPLE_LOBES) - {LOBE_GLOSSY, LOBE_GLASS, LOBE_REFRACTION, LOBE_PRINCIPLED}
)  # by Filter Glossy
BROAD_LOBES = (LOBE_DIFFUSE, LOBE_TRANSLUCENT)
LEAST_CLAMP = 1.0  # of indirect light: a stronger clamp changes the brightness of a picture clearly
LEAST_FILTER = 1.0  # limit of Filter Glossy: well above 1/π, the greatest density of diffuse scattering
END_OF_KNOWN, THIN = LOBE_SUBSURFACE + 1, WITH_THIN_WALL | WITH_THIN_SCATTERING

SCATTERED = Ray.DIFFUSE | Ray.GLOSSY | Ray.TRANSMISSION | Ray.SHADOW
BY_PATH = {"ray_kind", "ray_length", "ray_singular", "depth"}  # what a material may ask of the ray that meets it


def supports_light_paths(scene: Scene, packed: PackedScene) -> bool:
    """Whether connections may take light from paths, and whether that is asked for, if ``powers_of`` and
    ``materials_of`` allow it: see ``tables_of``.

    - There are lamps or lights from which light paths start: see ``powers_of``. What others emit is left to
      paths, and so is what light paths cannot follow: see ``materials_of``.
    - A light path does not know yet what kind of ray it is seen by: see ``is_alike``. For the same reason no material
      asks for the ray that meets it. None traces rays.
    - Strands are opaque. What is transparent is so to light rays, too.
    - No pass wants light by the lobe that scattered it first: a connection is of all lobes together.
    - No material has a BSDF that light paths do not know: see ``materials_of``.
    - Indirect light is not clamped strongly. A clamp takes less from connections than from paths, so the picture would
      be brighter than in Cycles.
    - The time of a path does not depend on its pixel.
    - A light path has ``MOST_VERTICES`` at most, and passes transparent surfaces where there are some.
    """
    settings, block = scene.settings, packed.block[0]
    return bool(
        settings.lamp_paths is not LampPaths.NEVER
        and settings.max_bounces > 0
        and vertices_of(scene, packed) <= MOST_VERTICES
        and block["rolling_shutter"] == NOT_ROLLING
        and (settings.transparent_bounces > 0 or not block["transparent_shadows"])
        and treats_rays_alike(scene, packed)
        and not block["outputs"] & LOBES
        and not (packed.table("lobes")["features"] & ONCE).any()
        and not (packed.table("materials")["flags"][_on_strands(scene)] & HAS_TRANSPARENCY).any()
    )


def clamps_strongly(scene: Scene) -> bool:
    """Whether indirect light is clamped so strongly that a picture has another brightness, if its paths are sampled in
    another way."""
    return 0.0 < scene.settings.clamp_indirect < LEAST_CLAMP


def treats_rays_alike(scene: Scene, packed: PackedScene) -> bool:
    """``is_alike``; no material asks for the ray that meets it, or traces rays; and indirect light is not clamped
    strongly."""
    return bool(
        not clamps_strongly(scene)
        and is_alike(scene, packed)
        and not (packed.table("materials")["flags"] & (STOPS_LIGHT_RAYS | TRACES_RAYS)).any()
        and not any(
            node.kind == VARIABLE and node.value[0] in BY_PATH
            for roots in packed.graphs.structures
            for node in order(*roots)
        )
    )


def is_alike(scene: Scene, packed: PackedScene) -> bool:
    """Whether light that reaches a surface is the same for all kinds of rays that see it, so that one path may use what
    another has found there.

    Each object is met by all kinds of rays but the camera's or by none, and no caustics are off. Nothing scatters in a
    volume or catches shadows. Linking does not matter: an emitter that does not light all is no source.
    """
    return bool(
        not packed.block[0]["has_media"]
        and not catches_shadows(scene)
        and packed.block[0]["caustics"] == GLOSSY | TRANSMISSION
        # As integers: operations of enumerations take long, and there may be many thousands of instances.
        and all(rays & SCATTERED in (SCATTERED, 0) for rays in {int(each.visibility) for each in scene.instances})
    )


def tables_of(scene: Scene, packed: PackedScene) -> dict[str, np.ndarray] | None:
    """The tables of a scene's light paths that all of them share; None if they cannot be used, or should not."""
    if not supports_light_paths(scene, packed):
        return None
    powers, materials = powers_of(scene, packed), materials_of(packed)
    if not (powers.any() and materials[_used(scene)].all()):
        return None
    return {
        "light_path_materials": materials,
        "light_path_sources": (powers > 0.0).astype(np.int64),
        "light_path_power": np.cumsum(powers),
    }


def _used(scene: Scene) -> list[int]:
    """The materials of all that stands in the scene."""
    return [material for instance in scene.instances for material in instance.materials]


def _on_strands(scene: Scene) -> list[int]:
    """The materials of all that is not triangles."""
    return [
        material
        for instance in scene.instances
        if scene.meshes[instance.mesh].primitive != Primitive.TRIANGLES
        for material in instance.materials
    ]


def _is_everywhere(emitter: Lamp | Light | Instance) -> bool:
    """Whether an emitter lights all, all cast its shadows, and all rays find it, after any number of bounces."""
    return (
        emitter.receivers == emitter.blockers == ALL_SETS
        and emitter.max_bounces >= MANY_BOUNCES
        and not emitter.sampled_only
        and emitter.visibility & SCATTERED == SCATTERED
    )


def powers_of(scene: Scene, packed: PackedScene) -> np.ndarray:
    """(emitters,) watts where light paths start, else 0: of lamps, emissive triangles, and lights whose kind has
    ``leave``, and 1 for the world and suns; of these, all that light everything."""
    emitters, lamps = packed.table("light_emitters"), packed.lamps_of(scene)
    members: list[Lamp | Light] = [*lamps, *scene.lights]
    found = np.zeros(len(emitters))
    found[: len(lamps)] = packed.table("lamps")["power"][: len(lamps)]
    for kind, module in KINDS.items():
        if hasattr(module, "leave"):
            rows = emitters["kind"] == kind
            found[rows] = module.flux(packed.table(module.TABLE))[emitters["index"][rows]]
    triangles = packed.table("light_triangles")
    glow = np.zeros(len(scene.instances) or 1, bool)
    for index in np.unique(triangles["instance"]):
        glow[index] = _is_everywhere(scene.instances[index])
    found[emitters["kind"] == TRIANGLE] = (
        np.abs(triangles["radiance"]).mean(axis=1) * 2.0 * math.pi * triangles["area"] * glow[triangles["instance"]]
    )
    distant = emitters["infinite"] >= 0
    found[distant] = 1.0  # as far as it comes: see ``_aim``
    found *= ((emitters["leaf"] >= 0) | distant) & (emitters["cast_shadow"] != 0)
    found[: len(members)] *= [_is_everywhere(each) for each in members]
    header = packed.table("light_header")
    world = scene.world
    if world.visibility & SCATTERED != SCATTERED or world.max_bounces < MANY_BOUNCES or header["portal_count"][0] > 0:
        found[header["world_emitter"][0]] = 0.0
    return found


def vertices_of(scene: Scene, packed: PackedScene) -> int:
    """The most vertices that a light path can have: a surface that is partly transparent may have one, too."""
    passed = scene.settings.transparent_bounces if packed.block["transparent_shadows"][0] else 0
    return scene.settings.max_bounces + passed


def materials_of(packed: PackedScene) -> np.ndarray:
    """(materials,) sums of CONNECTS, CONNECTS_ALL, FOLLOW_DIFFUSE and FOLLOW_ALL.

    - Light paths follow no closure that may be sharp but a mirror's or glass's, and none that they do not know.
    - Filter Glossy blurs lobes by all of the path from the camera, of which a light path knows only what is usual. From
      the limit ``LEAST_FILTER`` on, this hardly matters. Below, light paths follow no lobes.
    """
    table, filtered = packed.table("lobes"), packed.block[0]["filter_glossy"]
    kinds, features = table["kind"], table["features"]
    first, end = packed.table("materials")["lobes"].T

    def has(lobes: np.ndarray) -> np.ndarray:
        """(materials,) whether any of these ``lobes``, (all lobes,) bool, is a material's."""
        before = np.append(0, np.cumsum(lobes))
        return before[end] > before[first]

    followed = SIMPLE_LOBES if filtered == 0.0 or filtered >= LEAST_FILTER else UNBLURRED_LOBES
    unknown = has((kinds >= END_OF_KNOWN) | (kinds == LOBE_PRINCIPLED) & (features & THIN != 0))
    simple = ~has(~np.isin(kinds, followed) | (features & (WITH_FACETS | WITH_SUBSURFACE) != 0))
    broad = ~has(~np.isin(kinds, BROAD_LOBES))
    connects_all = broad | simple & (filtered >= LEAST_FILTER)
    known = CONNECTS | CONNECTS_ALL * connects_all | FOLLOW_DIFFUSE | FOLLOW_ALL * simple
    return np.where(unknown, 0, known).astype(np.int64)


class LightPaths:
    """Light paths of a packed scene, the same ones on any number of threads. ``use`` gives the scene those of some
    samples.

    In a moving scene, the light paths of a set have ``TIMES`` times, one in each part of the exposure, and paths from
    the camera have one of them. Other sets have other times, so the time of a path is as likely as without light paths.
    """

    @classmethod
    def of(cls, scene: Scene, packed: PackedScene, workspaces: list[Workspace]) -> LightPaths | None:
        """None where the scene cannot use them, or should not; nothing is connected then."""
        packed.set_light_paths({}, {})
        tables = tables_of(scene, packed)
        return None if tables is None else cls(scene, packed, workspaces, tables)

    def __init__(self, scene: Scene, packed: PackedScene, workspaces: list[Workspace], tables: dict[str, np.ndarray]):
        self._scene, self._packed, self._workspaces, self._lasting = scene, packed, workspaces, tables
        self._width = vertices_of(scene, packed)
        x0, y0, x1, y1 = scene.border or (0, 0, scene.width, scene.height)
        self._pixels = (x1 - x0) * (y1 - y0)
        self._own = DENOISED_SAMPLES if scene.settings.denoise else 0
        self._scalars = self._settled()
        self._fixed: dict[str, np.ndarray] = {}
        self._aimed = False
        self._tree_paths = 0  # of the tree in ``_fixed``
        self._connected: int | None = None
        self.rest()
        self.automatic = scene.settings.lamp_paths is LampPaths.AUTOMATIC

    def use(self, sample: int) -> int:
        """Connect the next paths with the light paths of the set to which this sample belongs; returns the end of the
        set.

        The set depends on the sample's number in the pattern of the seed alone, so renders that share the samples of a
        picture have the light paths of one render. Each is as large as its samples are worth.
        """
        offset = self._scene.settings.sample_offset
        number, size = sample + offset, 1
        power = 1 << number.bit_length() >> 1  # no set has one within: the greatest power of two up to ``number``
        shared = 1 if power * self._pixels < self._own else SHARED
        # Samples of one set have few times.
        while not self._packed.moves and 2 * size <= min(number, LARGEST_BATCH, MOST_PATHS * shared // self._pixels):
            size *= 2
        first = number - number % size
        if self._connected != first:  # a range may begin inside a set, and take it in several batches
            self._build(TREE_SHARED)
            self._connect(first + 1, _paths(self._pixels * size / shared, MOST_PATHS), CONNECTIONS)
            self._connected = first
        return first + size - offset

    def has_lamps(self) -> bool:
        """Whether SDF lamps are among the sources."""
        return bool(self._lasting["light_path_sources"][: len(self._packed.lamps_of(self._scene))].any())

    def pilot_cost(self, samples: int) -> float:
        """About the time for the tree and the light paths of a pilot with so many, in samples of pixels."""
        paths = _paths(self._pixels / PILOT_TREE_SHARED, MOST_TREE_PATHS)
        return PATH_COST * (paths + samples * _paths(self._pixels / PILOT_SHARED, MOST_PATHS))

    def use_pilot(self, sample: int) -> None:
        """As ``use``, for a pilot, with light paths that no set has."""
        self._connected = None
        self._build(PILOT_TREE_SHARED)
        self._connect(PILOT_NUMBER + sample, _paths(self._pixels / PILOT_SHARED, MOST_PATHS), CONNECTIONS)

    def rest(self) -> None:
        """Connect the next paths with nothing."""
        self._connected = None
        self._packed.set_light_paths(self._lasting, self._scalars)

    def _settled(self) -> dict[str, float]:
        """Scalars of ``light_paths.records``: how much a path from the camera may count on light paths."""
        scene = self._scene
        sources, materials = self._lasting["light_path_sources"], self._lasting["light_path_materials"]
        block, emitters = self._packed.block[0], self._packed.table("light_emitters")
        shining = (emitters["leaf"] >= 0) | (emitters["infinite"] >= 0) | (emitters["kind"] == TRIANGLE)
        alone = bool(sources[shining].all())
        emits = self._packed.table("materials")["flags"] & HAS_EMISSION != 0
        sampled = self._packed.table("materials")["sample_emission"] != 0
        alone = alone and not (emits & ~sampled).any() and not emits[_on_strands(scene)].any()
        follows = bool((materials[_used(scene)] & FOLLOW_ALL).all()) and not block["has_strands"]
        roulette = (MOST_ROULETTE if follows else SOME_ROULETTE) if alone else 1.0
        return {
            "light_path_follows": follows,
            "light_path_all": alone and follows,
            "light_path_roulette": roulette,
        }

    def _connect(self, number: int, paths: int, connections: int) -> None:
        """Connect the next paths with the vertices of light paths, so many for each ray that scatters."""
        if not len(self._fixed["light_path_tops"]):
            return
        times = self._times(number)
        raw, lengths = self._trace(number, paths, times)
        vertices, nodes = np.empty(lengths.sum(), VERTEX), []
        ends = np.cumsum(lengths.reshape(max(len(times), 1), -1).sum(axis=1))
        parts = zip(np.split(raw, len(ends)), np.split(lengths, len(ends)), np.split(vertices, ends[:-1]), ends)
        for traced, each, placed, end in parts:
            nodes.append(self._fixed["light_path_nodes"].copy())
            tree.place(nodes[-1], traced, each, self._width, placed)
            nodes[-1]["first"] += end - len(placed)
        tables = {
            "light_path_nodes": np.concatenate(nodes),
            "light_path_vertices": vertices,
            "light_path_times": times,
        }
        scalars = {"light_path_connections": connections, "light_path_node_count": len(nodes[0])}
        self._packed.set_light_paths(self._lasting | self._fixed | tables, self._scalars | scalars)

    def _times(self, number: int) -> np.ndarray:
        """(times,) the times of the light paths of this number, within [0, 1]; none if nothing moves."""
        if not self._packed.moves:
            return np.zeros(0)
        # The times of a pixel's samples are spread by powers of two. If those of sets were, too, a pixel would miss
        # some.
        start = (number * GOLDEN + self._scene.settings.seed * math.sqrt(2.0)) % 1.0
        shutter = self._packed.table("shutter_times")
        uniform = (np.arange(TIMES) + start) / TIMES
        return np.clip(np.interp(uniform, np.linspace(0.0, 1.0, len(shutter)), shutter), 0.0, 1.0)

    def _scene_at(self, time: float) -> np.ndarray:
        """(1,) the block of the first thread at a time."""
        blocks = self._workspaces[0].scene
        first = stop_at(blocks, self._workspaces[0].block, time) if self._packed.moves else 0
        return blocks[first : first + 1]

    def _aim(self) -> None:
        """Find the targets of light paths from the world and suns, and what power comes near to these."""
        packed, scene = self._packed, self._scene
        emitters = np.flatnonzero(self._lasting["light_path_sources"])
        distant = emitters[packed.table("light_emitters")["infinite"][emitters] >= 0]
        self._aimed = True
        if not len(distant):
            return
        low, high = packed.bounds()
        targets = np.zeros(1 + TARGETS, TARGET)
        targets["position"][0], targets["radius"][0] = (low + high) / 2.0, max(np.linalg.norm(high - low) / 2.0, 1e-9)
        powers = np.diff(self._lasting["light_path_power"], prepend=0.0)
        places = np.zeros((PLACES, 3))
        self._take_targets(targets[:1], powers)
        kernels, scratch = self._scene_at(MIDDLE), self._workspaces[0].block
        places = places[: find_places(kernels, scratch, scene.width, scene.height, 2, 0.0, places)]
        if len(places):
            reached = np.zeros((len(distant), len(places)))
            for number, emitter in enumerate(distant):
                measure(kernels, scratch, emitter, number, places, reached[number])
            chance = reached.sum(axis=0) + LEAST_REACHED * reached.mean() + 1e-300
            steps = (np.arange(TARGETS) + 0.5) / TARGETS
            chosen = places[np.minimum(np.searchsorted(np.cumsum(chance) / chance.sum(), steps), len(places) - 1)]
            targets["position"][1:] = chosen
            apart = np.linalg.norm(chosen[:, None] - chosen[None], axis=2)
            least = targets["radius"][0] * LEAST_RADIUS
            targets["radius"][1:] = np.maximum(np.sort(apart, axis=1)[:, NEIGHBOUR], least)
            spread = np.sqrt(((chosen - chosen.mean(axis=0)) ** 2).sum(axis=1).mean())
            powers[distant] = reached.mean(axis=1) * math.pi * max(spread, least) ** 2
        else:
            targets = targets[:1]
        powers[distant] = np.maximum(powers[distant], LEAST_POWER * powers[emitters].sum() + 1e-30)
        self._take_targets(targets, powers)

    def _take_targets(self, targets: np.ndarray, powers: np.ndarray) -> None:
        self._lasting |= {"light_path_targets": targets, "light_path_power": np.cumsum(powers)}
        self.rest()

    def _build(self, shared: int) -> None:
        """Make the tree, if it is not there, by light paths that no sample has: weights must not depend on the vertices
        that they are for."""
        paths = _paths(self._pixels / shared, MOST_TREE_PATHS)
        if self._tree_paths == paths:
            return
        self._tree_paths = paths
        if not self._aimed:
            self._aim()
        raw, lengths = self._trace(0, paths, self._times(0))
        rows = np.arange(len(raw)).reshape(len(lengths), self._width)
        vertices = raw[rows[np.arange(self._width) < lengths[:, None]]]
        pilots = np.zeros((PILOTS, 3))
        scene, scratch = self._scene_at(MIDDLE), self._workspaces[0].block
        pilots = pilots[: find_places(scene, scratch, self._scene.width, self._scene.height, 1, 0.0, pilots)]
        nodes, tops, count, top_count = np.zeros(MOST_NODES, NODE), np.zeros(MOST_TOPS, np.int64), 0, 0
        if len(vertices) and len(pilots):
            weight_by_visibility(scene, scratch, vertices, pilots)
            count, top_count = tree.build(vertices, pilots, nodes, tops)
        self._fixed = {
            "light_path_nodes": nodes[:count].copy(),
            "light_path_tops": tops[:top_count].copy(),
        }

    def _trace(self, number: int, paths: int, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Trace the light paths of this number and with these times: rows of ``_width`` vertices for each path, and how
        many it has."""
        raw, lengths = np.empty(paths * self._width, VERTEX), np.zeros(paths, np.int64)

        def trace(workspace: Workspace, first: int, last: int) -> None:
            trace_light_paths(
                workspace.scene, workspace.block, first, last, paths, number, times, self._width, raw, lengths
            )

        in_chunks(trace, 0, paths, self._workspaces)
        return raw, lengths


def _paths(wanted: float, most: int) -> int:
    """A number of light paths, in whole chunks."""
    return CHUNK * min(max(round(wanted / CHUNK), 1), most // CHUNK)


def in_chunks(work: Callable[[Workspace, int, int], None], first: int, last: int, workspaces: list[Workspace]) -> None:
    """Do the work for ``first`` to before ``last``, ``CHUNK`` at once, with each workspace in a thread, the first one
    in this thread; the first error is raised here."""
    starts, taking = iter(range(first, last, CHUNK)), threading.Lock()

    def take(workspace: Workspace) -> None:
        while True:
            with taking:
                start = next(starts, None)
            if start is None:
                return
            work(workspace, start, min(start + CHUNK, last))

    others = workspaces[1 : math.ceil((last - first) / CHUNK)]  # for few chunks, to start threads takes longer
    with ThreadPoolExecutor(len(workspaces)) as pool:
        waiting = [pool.submit(take, workspace) for workspace in others]
        take(workspaces[0])
        for done in waiting:
            done.result()
