# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of node cases by both engines, and their differences."""

from __future__ import annotations

import functools
import hashlib
import os
import pathlib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import bpy
import host
import numpy as np

from . import node_scenes, pictures, references
from .node_cases import EXPLAINED, LIGHT, RAYS, WORLD, Case
from .node_limits import LIMIT, over
from .node_scenes import Grid, grid_of, lit

CYCLES, OURS = ENGINES = ("CYCLES", host.ENGINE)
TILE, LIT_TILE, ALONE = 32, 32, 32  # pixels a side
BLOCK = 8  # pixels a side, over which pictures with noise are averaged before they are compared
SEEDS = 4  # renders of each engine, where there is noise
MORE = 4  # factor on samples when cases that noise leaves in doubt are rendered again
# samples if all rays go through the centre of a pixel, or within a hundredth of a pixel of it, as engines allow
SHARP = 16
BOUNCES = 8  # of light, where there are lights
ASIDE = 0.01  # pixels that rays are moved to the side, to find jumps
COARSE = 0.06  # doubt in a 99th percentile, above which noise hides too much
JUMPS = "beside jumps: our own picture changes as much there where rays move by a hundredth of a pixel"
DARK = 0.01  # a value that differences are relative to if a picture is black


@dataclass(frozen=True)
class Difference:
    """A mean of relative differences and their 99th percentile, and the uncertainty of each by noise."""

    mean: float
    p99: float
    mean_doubt: float = 0.0
    p99_doubt: float = 0.0


@dataclass
class Pair:
    """One case by both engines: (size, size, RGB) with row 0 at the bottom, by engine, one for each seed.

    ``error`` is a sentence if a case could not be built or rendered, ``warnings`` are those of our engine. ``change``
    is the change of our pixels when rays are moved slightly, if it was measured.
    """

    case: Case
    pictures: dict[str, list[np.ndarray]] = field(default_factory=dict)
    error: str = ""
    warnings: list[str] = field(default_factory=list)
    change: np.ndarray | None = None

    def mean(self, engine: str) -> np.ndarray:
        return np.mean(self.pictures[engine], axis=0)

    @property
    def whole(self) -> bool:
        return all(self.pictures.get(engine) for engine in ENGINES)

    def difference(self) -> Difference | None:
        return difference_of(self.pictures[OURS], self.pictures[CYCLES]) if self.whole and not self.error else None

    def explained(self) -> str:
        """The reason why the pictures differ, if it is known."""
        if self.change is not None:
            theirs, ours = self.mean(CYCLES), self.mean(OURS)
            beyond = relative(np.maximum(np.abs(ours - theirs) - self.change, 0.0), theirs)
            if max(beyond.mean(), np.quantile(beyond, 0.99)) <= LIMIT:
                return JUMPS
        return EXPLAINED.get(self.case.name, "")

    @property
    def doubtful(self) -> bool:
        """Whether more samples could change the verdict: noise is coarse, or there is some difference beside it, and it
        is not yet far over the limit."""
        found = self.difference()
        if found is None or self.case.name in EXPLAINED:
            return False
        # Twice the doubt, because a few seeds may agree by chance.
        if max(found.mean - 2.0 * found.mean_doubt, found.p99 - 2.0 * found.p99_doubt) > 2.0 * LIMIT:
            return False
        coarse = found.mean_doubt > LIMIT or found.p99_doubt > COARSE
        return coarse or found.mean > 0.5 * LIMIT or found.p99 > max(found.p99_doubt, LIMIT)

    def row(self) -> dict:
        found = self.difference()
        light = {engine: float(self.mean(engine).mean()) if self.pictures.get(engine) else None for engine in ENGINES}
        return dict(
            case=self.case.name,
            node=self.case.node,
            place=self.case.place,
            mean_difference=found and found.mean,
            p99=found and found.p99,
            mean_doubt=found and found.mean_doubt,
            p99_doubt=found and found.p99_doubt,
            light_cycles=light[CYCLES],
            light_ours=light[OURS],
            explained=self.explained(),
            error=self.error,
            warning=" ".join(self.warnings),
        )


def difference_of(ours: list[np.ndarray], theirs: list[np.ndarray]) -> Difference:
    """Difference of pictures from Cycles', one of each, or several with different seeds if there is noise.

    A difference is relative to Cycles' value there, or to the mean of its picture, whichever is greater. Noisy pictures
    are compared by blocks, and the difference between their seeds is subtracted, as for variances: the root of the
    difference of the squares. Noise is estimated from few blocks and seeds only. So half of its mean remains as doubt,
    and for the percentile one and a half times its greatest values.
    """
    shade = np.mean(theirs, axis=0)
    if len(theirs) == 1:
        found = relative(ours[0] - shade, shade)
        return Difference(float(found.mean()), float(np.quantile(found, 0.99)))
    shade = blocks(shade)
    found = relative(blocks(np.mean(ours, axis=0)) - shade, shade)
    noise = relative(
        np.hypot(*(_standard_error([blocks(picture) for picture in made]) for made in (ours, theirs))), shade
    )
    mean, doubt = float(found.mean()), float(noise.mean())
    p99, p99_doubt = float(np.quantile(found, 0.99)), float(np.quantile(noise, 0.99))
    return Difference(_without(mean, doubt), _without(p99, p99_doubt), 0.5 * doubt, 1.5 * p99_doubt)


def _standard_error(pictures: list[np.ndarray]) -> np.ndarray:
    """Of the mean of pictures, from how they differ."""
    return np.std(pictures, axis=0, ddof=1) / len(pictures) ** 0.5


def relative(difference: np.ndarray, shade: np.ndarray) -> np.ndarray:
    return np.abs(difference) / np.maximum(np.maximum(np.abs(shade), np.abs(shade).mean()), DARK)


def _without(found: float, noise: float) -> float:
    return max(found * found - noise * noise, 0.0) ** 0.5


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means over squares of ``BLOCK`` pixels a side."""
    rows, columns = (size // BLOCK for size in picture.shape[:2])
    return picture[: rows * BLOCK, : columns * BLOCK].reshape(rows, BLOCK, columns, BLOCK, -1).mean(axis=(1, 3))


def groups(cases: list[Case]) -> list[list[Case]]:
    """Cases that are rendered together; each world and each light has its own scene."""
    found: dict[tuple, list[Case]] = {}
    for index, case in enumerate(cases):
        alone = case.place in {WORLD, LIGHT}
        found.setdefault((case.place, index) if alone else (lit(case), case.place == RAYS), []).append(case)
    return list(found.values())


def render_all(
    cases: list[Case],
    samples: int,
    device: str = "CPU",
    told: Callable[[str], None] = lambda text: None,
    fresh: bool = False,
    rounds: int = 2,
    engines=ENGINES,
) -> Iterator[Pair]:
    """Pictures of all cases by both engines: ``SEEDS`` renders with so many samples if there is noise, and up to
    ``rounds`` times of more if that leaves a case in doubt; one group after the other.

    Cycles' noisy pictures are kept in the user's cache, like references; ``fresh``: rendered again.
    """
    for group in groups(cases):
        told(f"{group[0].name} and {len(group) - 1} more" if len(group) > 1 else group[0].name)
        pairs, doubtful, count = {}, group, samples
        for _ in range(1 + rounds):
            pairs |= {pair.case.name: pair for pair in _rendered(doubtful, count, device, fresh, engines)}
            doubtful, count = [case for case in doubtful if _noisy(case) and pairs[case.name].doubtful], MORE * count
            if not doubtful:
                break
            told(f"{count} samples of {len(doubtful)} in doubt")
        found = [pairs[case.name] for case in group]
        if CYCLES in engines and not _noisy(group[0]):
            _explain_jumps([pair for pair in found if pair.whole and over(pair.row())], device)
        yield from found


def _noisy(case: Case) -> bool:
    return lit(case) or case.place == RAYS


def _rendered(cases: list[Case], samples: int, device: str, fresh: bool, engines) -> list[Pair]:
    """Pictures of cases that share a grid."""
    first = cases[0]
    alone = first.place in {WORLD, LIGHT}
    grid = _grid(cases)
    noisy = _noisy(first)
    scene, problems = node_scenes.build(grid)
    pairs = [Pair(case, error=problems.get(case.name, "")) for case in cases]
    for engine in engines:
        for seed in range(SEEDS if noisy else 1):

            def render() -> np.ndarray:
                node_scenes.settings(
                    scene, engine, samples if noisy else SHARP, BOUNCES if lit(first) else 0, noisy, device
                )
                scene.cycles.seed = scene.sdf_lights.seed = seed
                return pictures.render().pixels

            keeps = engine == CYCLES and noisy
            able = [index for index, pair in enumerate(pairs) if not pair.error]
            # Rays from a surface hit its neighbours in the grid; lights stay in their cells.
            near = " ".join(case.name for case in cases) if first.place == RAYS else ""
            files = {index: _file(f"{seed} {samples} {cases[index].name} {near}") for index in able} if keeps else {}
            if keeps and not fresh and all(path.is_file() for path in files.values()):
                tiles = {index: np.load(path).astype(float) for index, path in files.items()}
            else:
                tiles = {
                    index: picture if alone else grid.tile(picture, index)
                    for index, picture in _pictures(render, grid, pairs, able).items()
                }
                for index in files.keys() & tiles.keys():
                    _keep(files[index], tiles[index])
            for index, tile in tiles.items():
                pairs[index].pictures.setdefault(engine, []).append(tile)
    _note_warnings(pairs, warnings_of(scene.name))
    return pairs


def _grid(cases: list[Case]) -> Grid:
    alone = cases[0].place in {WORLD, LIGHT}
    return grid_of(cases, ALONE if alone else LIT_TILE if lit(cases[0]) else TILE)


def _explain_jumps(pairs: list[Pair], device: str) -> None:
    """Explain pictures that differ only beside jumps, where our own change as much when all its rays move slightly.

    Engines may place their rays this far beside the centres of pixels (``node_scenes.settings``).
    """
    if not pairs:
        return
    alone = pairs[0].case.place in {WORLD, LIGHT}
    grid = _grid([pair.case for pair in pairs])
    scene, _ = node_scenes.build(grid)
    node_scenes.settings(scene, OURS, SHARP, 0, False, device)
    straight, *others = (moved(scene, step) for step in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)))
    change = np.max([np.abs(picture - straight) for picture in others], axis=0)
    for index, pair in enumerate(pairs):
        pair.change = change if alone else grid.tile(change, index)


def moved(scene, step: tuple[int, int]) -> np.ndarray:
    """Our picture with all rays ``ASIDE`` pixels to the side, to the right and up."""
    with node_scenes.camera_moved(scene, *(ASIDE * part for part in step)):
        return pictures.render().pixels


def _pictures(
    render: Callable[[], np.ndarray], grid: Grid, pairs: list[Pair], indices: list[int]
) -> dict[int, np.ndarray]:
    """The picture of the grid for each of these tiles. If an engine fails, it renders half of them at a time, until the
    faulty tile is found."""
    if not indices:
        return {}
    try:
        with node_scenes.only(grid, indices):
            picture = render()
        return dict.fromkeys(indices, picture)
    except RuntimeError as error:
        if len(indices) == 1:
            pairs[indices[0]].error = str(error).removeprefix("Error: ").strip()
            return {}
    middle = len(indices) // 2
    return _pictures(render, grid, pairs, indices[:middle]) | _pictures(render, grid, pairs, indices[middle:])


def _note_warnings(pairs: list[Pair], sentences: list[str]) -> None:
    """Give each sentence to the case whose material it names, or to the only one."""
    by_name = {pair.case.name: pair for pair in pairs}
    for sentence in sentences:
        named = [name for name in re.findall(r"'([^']+)'", sentence) if name in by_name]
        if named or len(pairs) == 1:
            (by_name[named[0]] if named else pairs[0]).warnings.append(sentence)


@functools.cache
def _scripts() -> bytes:
    """The scripts that build pictures."""
    here = pathlib.Path(__file__).parent
    paths = sorted([*here.glob("node_*.py"), *(host.REPOSITORY / "scripts" / "scenery").glob("*.py")])
    return b"".join(path.read_bytes() for path in paths)


def _file(key: str) -> pathlib.Path:
    """Where a picture of Cycles is in the user's cache: it depends on the version of Blender, the scripts and a key."""
    digest = hashlib.sha256(f"{bpy.app.version_string} {key}".encode() + _scripts())
    return references.folder() / f"nodes-{digest.hexdigest()[:24]}.npy"


def _keep(path: pathlib.Path, picture: np.ndarray) -> None:
    part = path.with_suffix(".part.npy")
    np.save(part, picture.astype(np.float32))
    os.replace(part, path)


def warnings_of(scene: str) -> list[str]:
    """What the last render of a scene by our engine had to say."""
    return host.program("blender.feedback").of_last_render(scene)
