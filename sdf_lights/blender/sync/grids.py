# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of voxels: of Volume objects and of smoke simulations, and the boxes around them.

As in Cycles, the box of an object is around the active voxels of all grids that its material reads, but for those below
*Clipping*. An object whose material reads none has no box.
"""

from __future__ import annotations

import itertools
import pathlib
import tempfile
import weakref
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np

from ...render.material import Attribute
from ...render.scene import AttributeValues, Domain, Mesh
from ...render.voxels import TooManyVoxels, packed
from ..vdb_files import axes_of, is_whole, vdb
from .common import Warnings

KIND = "grid"  # of ``Attribute``
# Voxels of the box around those that are active: as far as interpolation reaches, and one more behind in Cycles of 5.0
# and 5.1.
REACH = {"LINEAR": 1, "CUBIC": 2}
BEHIND = 1 if (5, 0) <= bpy.app.version[:2] < (5, 2) else 0
# Before 5.0, the voxel i of a file lies between i and i + 1 in Cycles.
SHIFT = 0.0 if bpy.app.version >= (5, 0, 0) else 0.5
_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
_FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
     (1, 5, 7), (1, 7, 3)], np.int32
)  # fmt: skip

# What OpenVDB's module raises in place of the exceptions of its C++.
_ERRORS = ArithmeticError, LookupError, OSError, ReferenceError, RuntimeError, TypeError, ValueError

_read_before: weakref.WeakValueDictionary[tuple, Grid] = weakref.WeakValueDictionary()


@dataclass(eq=False)
class Grid(AttributeValues):
    """One grid, as an attribute of instances: ``low`` to ``high`` (3,) are its voxels above Blender's *Clipping*.
    ``matrix`` (4, 4) maps the numbers of voxels to object space."""

    low: np.ndarray
    high: np.ndarray
    matrix: np.ndarray


def _packed(
    read: Callable, low: np.ndarray, high: np.ndarray, background: np.ndarray, matrix: np.ndarray
) -> np.ndarray:
    """``voxels.packed`` of everything that is in the boxes of ``boxed``."""
    most = max(REACH.values())
    return packed(read, low - most, high + most, background, matrix)


class Found(NamedTuple):
    """The grids of an object: their names, and what reads some of them. It leaves out those without a box.
    ``in_object_space``: see ``volumes.medium_of``."""

    names: frozenset[str]
    read: Callable[[list[str]], dict[str, Grid]]
    in_object_space: bool = False


NONE = Found(frozenset(), lambda names: {})


class Grids:
    """Finds the grids of objects. Warns once of each object that it cannot read."""

    def __init__(self, depsgraph: bpy.types.Depsgraph, warn: Warnings):
        self._depsgraph, self._warn = depsgraph, warn

    def of(self, obj: bpy.types.Object) -> Found | None:
        """The grids of an evaluated object, or of an instance; None if it is neither a volume nor a smoke domain."""
        if obj.type == "VOLUME":
            return self._of_volume(obj)
        domain = smoke_domain(obj)
        return None if domain is None else _of_smoke(obj, domain)

    def _of_volume(self, obj: bpy.types.Object) -> Found:
        name, volume = obj.original.name, obj.data
        grids = volume.grids
        if not grids.load():
            self._warn(
                f"Object '{name}': its volume cannot be read ({grids.error_message}), so it is left out: choose its "
                "file again."
            )
            return NONE
        if not len(grids):
            if not volume.filepath and not len(obj.modifiers):
                self._warn(
                    f"Object '{name}' is a volume without a file, so it is left out: choose a .vdb file in its data."
                )
            return NONE
        module = vdb()
        if module is None:
            self._warn(
                f"Object '{name}' is a volume, which cannot be read, because this Python has no module 'openvdb': it is "
                "left out; render in Blender from blender.org, which has it."
            )
            return NONE
        made = not grids.frame_filepath or len(obj.modifiers) or _is_simplified(self._depsgraph.scene_eval)

        def read(wanted: list[str]) -> dict[str, Grid]:
            if not made:
                path = pathlib.Path(grids.frame_filepath)
                return self._all(name, wanted, lambda grid: _from_file(module, path, grid, volume.render.clipping))
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "grids.vdb"
                grids.save(str(path))
                return self._all(name, wanted, lambda grid: _of_vdb(module, path, grid, volume.render.clipping))

        return Found(frozenset(grid.name for grid in grids), read, volume.render.space == "OBJECT")

    def _all(self, owner: str, wanted: list[str], read: Callable[[str], Grid | None]) -> dict[str, Grid]:
        """Those of the wanted grids that have a box and can be read."""
        found = {}
        for name in wanted:
            try:
                grid = read(name)
                if grid is not None:
                    found[name] = grid
                continue
            except TooManyVoxels:
                reason = "has too many voxels: make its voxels larger"
            except _Unusable as error:
                reason = str(error)
            except _ERRORS:
                reason = "is damaged: write its file again"
            self._warn(f"Object '{owner}': its grid '{name}' {reason}; it is left out.")
        return found


class _Unusable(Exception):
    """A grid with the rest of a sentence on what is wrong."""


def _is_simplified(scene: bpy.types.Scene) -> bool:
    return scene.render.use_simplify and scene.render.simplify_volumes < 1.0


def _from_file(module, path: pathlib.Path, name: str, clipping: float) -> Grid | None:
    about = path.stat()
    key = str(path), about.st_mtime_ns, about.st_size, name, clipping
    found = _read_before.get(key)
    if found is None:
        if not is_whole(path):
            raise _Unusable("is damaged: write its file again")
        found = _of_vdb(module, path, name, clipping)
        if found is not None:
            _read_before[key] = found
    return found


def _of_vdb(module, path: pathlib.Path, name: str, clipping: float) -> Grid | None:
    """A grid of a file; None if no active voxel is above ``clipping``."""
    grid = module.read(str(path), name)
    if not hasattr(grid, "copyToArray") or not isinstance(grid.background, float | int | bool | tuple):
        raise _Unusable("has values that are no numbers or vectors: write it with numbers")
    matrix = axes_of(grid)
    if matrix is None:
        raise _Unusable("has a transform that is not linear: write it again with one that is")
    if not grid.activeVoxelCount():
        return None
    low, high = map(np.array, grid.evalActiveVoxelBoundingBox())
    bounds: list[tuple[np.ndarray, np.ndarray]] = []
    matrix[:3, 3] += SHIFT * matrix[:3, :3].sum(axis=1)
    background = np.atleast_1d(np.array(grid.background, np.float32))

    def read(start: np.ndarray, counts: np.ndarray) -> np.ndarray:
        values = np.empty((*counts, 3) if len(background) > 1 else tuple(counts), np.float32)
        grid.copyToArray(values, ijk=tuple(map(int, start)))
        first, last = np.maximum(low, start), np.minimum(high + 1, start + counts)
        if (first < last).all():
            found = _bounds_above(values[tuple(map(slice, first - start, last - start))], clipping)
            bounds.extend((first + least, first + most) for least, most in found)
        return values

    values = _packed(read, low, high, background, matrix)
    if not bounds:
        return None
    return Grid(Domain.WHOLE, values, *_around(bounds), matrix)


def _bounds_above(values: np.ndarray, clipping: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The least and the greatest indices (3,) of values (x, y, z, …) above ``clipping``; none if there are none."""
    above = np.abs(values) > clipping
    above = above if above.ndim == 3 else above.any(axis=-1)
    lines = [np.flatnonzero(above.any(axis=axes)) for axes in ((1, 2), (0, 2), (0, 1))]
    return [(np.array([line[0] for line in lines]), np.array([line[-1] for line in lines]))] if len(lines[0]) else []


def _around(bounds: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    lows, highs = zip(*bounds)
    return np.min(lows, axis=0), np.max(highs, axis=0)


# -- smoke -------------------------------------------------------------------------------------------------------------

_SMOKE = {
    "density": ("density_grid", 1),
    "flame": ("flame_grid", 1),
    "temperature": ("temperature_grid", 1),
    "color": ("color_grid", 4),
    "heat": ("heat_grid", 1),
    "velocity": ("velocity_grid", 3),
}
_COARSE = {"heat", "velocity"}  # have no noise


def smoke_domain(obj: bpy.types.Object) -> bpy.types.FluidDomainSettings | None:
    """The settings of the smoke domain of an object; None if it is none."""
    for modifier in obj.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            domain = modifier.domain_settings
            if domain is not None and domain.domain_type == "GAS":
                return domain
    return None


def _of_smoke(obj: bpy.types.Object, domain: bpy.types.FluidDomainSettings) -> Found:
    def of(name: str) -> Grid | None:
        field, channels = _SMOKE[name]
        stored = getattr(domain, field)
        fineness = domain.noise_scale if domain.use_noise and name not in _COARSE else 1
        counts = fineness * np.array(domain.domain_resolution)
        if not len(stored) or len(stored) != channels * counts.prod():
            return None
        values = np.empty(len(stored), np.float32)
        stored.foreach_get(values)
        values = values.reshape(*counts[::-1], channels).transpose(2, 1, 0, 3)
        return dense(values, obj.data.texspace_location, obj.data.texspace_size, domain.clipping)

    return Found(frozenset(_SMOKE), lambda names: {name: grid for name in names if (grid := of(name)) is not None})


def dense(values: np.ndarray, middle, size, clipping: float) -> Grid | None:
    """The grid of all voxels (x, y, z, channels) of a box of object space, from ``middle`` − ``size`` to
    ``middle`` + ``size``. Voxels are active above ``clipping``; None if none is."""
    counts, middle, size = np.array(values.shape[:3]), np.array(middle), np.array(size)
    bounds = _bounds_above(values, clipping)
    if not bounds or not (size > 0.0).all():
        return None
    matrix = np.diag([*(2.0 * size / counts), 1.0])
    matrix[:3, 3] = middle - size + size / counts

    def read(start: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        found = np.zeros((*wanted, values.shape[3]), np.float32)
        first, last = np.clip(start, 0, counts), np.clip(start + wanted, 0, counts)
        found[tuple(map(slice, first - start, last - start))] = values[tuple(map(slice, first, last))]
        return found

    low, high = _around(bounds)
    return Grid(Domain.WHOLE, _packed(read, low, high, np.zeros(values.shape[3]), matrix), low, high, matrix)


# -- boxes -------------------------------------------------------------------------------------------------------------


class Boxed(NamedTuple):
    """The box around the grids of an object, and the grids by the attributes of its instances."""

    mesh: Mesh
    values: dict[Attribute, AttributeValues]


def boxed(found: Found, wanted: Iterable[Attribute], name: str, interpolation: str) -> Boxed | None:
    """Read the ``wanted`` ones among the grids; None if there are none."""
    reach = REACH[interpolation]
    names = sorted(attribute.name for attribute in wanted if attribute.kind == KIND and attribute.name in found.names)
    grids = found.read(names)
    if not grids:
        return None
    # Of several grids, in the space of the voxels of the first one.
    first = next(iter(grids.values()))
    places = []
    for grid in grids.values():
        corners = np.where(_CORNERS == 0, grid.low - reach, grid.high + reach + BEHIND)
        to_first = np.linalg.inv(first.matrix) @ grid.matrix
        places.append(corners @ to_first[:3, :3].T + to_first[:3, 3])
    low, high = np.min(places, axis=(0, 1)), np.max(places, axis=(0, 1))
    positions = np.where(_CORNERS == 0, low, high) @ first.matrix[:3, :3].T + first.matrix[:3, 3]
    faces = _FACES if np.linalg.det(first.matrix) > 0.0 else _FACES[:, ::-1]
    mesh = Mesh(name, positions.astype(np.float32), np.ascontiguousarray(faces))
    return Boxed(mesh, {Attribute(KIND, each): grid for each, grid in grids.items()})


class Fixed:
    """The box of grids at other times: as at the frame, see ``mesh.Readable``."""

    def read(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """None: nothing is read."""
        return
