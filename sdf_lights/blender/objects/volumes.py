# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects as lamps: the level set in their .vdb file, by a signed distance grid.

Blender has OpenVDB as a Python module: ``openvdb``, and in older versions ``pyopenvdb``. The module bpy from the
package index has none.
"""

from __future__ import annotations

import collections
import importlib
import pathlib
import struct

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.shapes import Shape
from ...sdf.shapes.operators import Transformed
from . import reads

MODULES = "openvdb", "pyopenvdb"
MAGIC, OLDEST, UUID = (
    0x56444220,
    222,
    36,
)  # of a .vdb file: its first word, a version of the format, bytes of its identity
_KEPT = 16

_grids: collections.OrderedDict[tuple, Shape | str] = collections.OrderedDict()  # or a sentence on what is wrong


def vdb():
    """OpenVDB's Python module; None where there is none."""
    for name in MODULES:
        try:
            return importlib.import_module(name)
        except ImportError:
            pass
    return None


def is_whole(path: pathlib.Path) -> bool:
    """Whether a .vdb file has all bytes that its grids say they have: OpenVDB may search for long in one that has not.

    Its parts are those of ``io::File`` and ``GridDescriptor`` of OpenVDB. Raises OSError if it cannot be opened.
    """
    size = path.stat().st_size
    with open(path, "rb") as file:

        def numbers(layout: str) -> tuple:
            return struct.unpack(f"<{layout}", file.read(struct.calcsize(f"<{layout}")))

        def skip() -> None:
            (count,) = numbers("I")
            if count > size:
                raise ValueError("a text is longer than the file")
            file.seek(count, 1)

        try:
            magic, version, _, _, has_offsets = numbers("qIIIb")
            if magic != MAGIC or version < OLDEST or not has_offsets:
                return False
            file.seek(UUID, 1)
            for _ in range(numbers("I")[0]):
                skip(), skip(), skip()  # name, type, value
                if file.tell() > size:
                    return False
            for _ in range(numbers("i")[0]):
                skip(), skip(), skip()  # names and type
                _, _, end = numbers("qqq")
                if not file.tell() <= end <= size:
                    return False
                file.seek(end)
        except (struct.error, ValueError):
            return False
    return True


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
        origin = np.array(grid.transform.indexToWorld((0.0, 0.0, 0.0)))
        axes = [np.array(grid.transform.indexToWorld(tuple(row))) - origin for row in np.eye(3)]
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = np.column_stack(axes), origin
        size = float(np.linalg.norm(axes, axis=1).min())
        if not grid.activeVoxelCount() or not (
            np.isfinite(matrix).all() and abs(np.linalg.det(matrix / max(size, 1e-30))) > 1e-6
        ):
            return "has an empty level set: choose another file."
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
