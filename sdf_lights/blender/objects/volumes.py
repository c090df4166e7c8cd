# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects as lamps: the level set in their .vdb file, by a signed distance grid."""

from __future__ import annotations

import collections
import pathlib

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.shapes import Shape
from ...sdf.shapes.operators import Transformed
from ..vdb_files import axes_of, is_whole, vdb
from . import reads

_KEPT = 16

_grids: collections.OrderedDict[tuple, Shape | str] = collections.OrderedDict()  # or a sentence on what is wrong


@reads(VOLUME="Volume")
def _read(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, lamp) -> Shape:
    volume = obj.data
    name = f"Volume '{obj.name}'"
    if not volume.filepath:
        raise RenderError(f"{name} has no file: choose a .vdb file in its data, or make a mesh of it by a modifier.")
    volume.grids.load()
    # That of the frame, of a sequence.
    path = pathlib.Path(volume.grids.frame_filepath or bpy.path.abspath(volume.filepath, library=volume.library))
    try:
        about = path.stat()
    except (OSError, ValueError):
        raise RenderError(f"{name} has no file '{path.name}': find it again.") from None
    key = str(path), about.st_mtime_ns, about.st_size
    if key not in _grids:
        module = vdb()
        if module is None:
            raise RenderError(
                f"{name} cannot be read, because this Python has no module 'openvdb': render in Blender from blender.org, "
                "which has it, or make a mesh of the volume by a Volume to Mesh modifier."
            )
        _grids[key] = _shape(module, path)
        while len(_grids) > _KEPT:
            _grids.popitem(last=False)
    _grids.move_to_end(key)
    found = _grids[key]
    if isinstance(found, str):
        raise RenderError(f"{name} {found}")
    return found


def _shape(module, path: pathlib.Path) -> Shape | str:
    """The first level set of a file, or the rest of a sentence on why there is none."""
    from ...interruption import Interrupted
    from ...sdf.data.level_set import level_set_grid  # it needs Numba, whose import takes a second
    from ...sdf.data.voxels import GridError

    damaged = (
        f"has the file '{path.name}', which is damaged or is not a .vdb file: write it again, or choose another one."
    )
    try:
        if not is_whole(path):
            return damaged
        grids = module.readAllGridMetadata(str(path))
        chosen = [grid for grid in grids if grid.gridClass == "level set" and isinstance(grid, module.FloatGrid)]
        if not chosen:
            return (
                "has no level set of floats: a density has no surface. Give a mesh a Volume to Mesh modifier with this volume, "
                "and make that the lamp."
            )
        grid = module.read(str(path), chosen[0].name)
        if not grid.transform.isLinear:
            return "has a transform that is not linear: write it again with one that is."
        matrix = axes_of(grid)
        if matrix is None or not grid.activeVoxelCount():
            return "has an empty level set: choose another file."
        size = float(np.linalg.norm(matrix[:3, :3], axis=0).min())
        first, last = grid.evalActiveVoxelBoundingBox()

        def read(start: np.ndarray, counts: np.ndarray) -> np.ndarray:
            values = np.empty(counts, np.float32)
            grid.copyToArray(values, ijk=tuple(int(number) for number in start))
            return values

        shape = level_set_grid(read, np.array(first), np.array(last), float(grid.background), size)
    except GridError as error:
        return str(error)
    except Interrupted:
        raise
    except Exception:  # the module raises what its C++ throws, of many kinds
        return damaged
    matrix[:3, :3] /= size
    return shape if np.allclose(matrix, np.eye(4), atol=1e-9) else Transformed(shape, matrix)
