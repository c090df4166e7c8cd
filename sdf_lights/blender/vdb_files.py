# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenVDB's Python module, and whether .vdb files are whole.

Blender has the module as ``openvdb``, older versions as ``pyopenvdb``. The package bpy has it in a folder of its own,
where Python does not look.
"""

from __future__ import annotations

import importlib
import importlib.machinery
import importlib.util
import pathlib
import struct
import sys

import bpy
import numpy as np

MODULES = "openvdb", "pyopenvdb"
MAGIC, OLDEST, UUID = (
    0x56444220,
    222,
    36,
)  # of a .vdb file: its first word, a version of the format, bytes of its identity


def vdb():
    """OpenVDB's Python module; None where there is none."""
    for name in MODULES:
        try:
            return importlib.import_module(name)
        except ImportError:
            pass
    # A name that was set to None in sys.modules is meant to be absent.
    return None if MODULES[0] in sys.modules else _of_package(MODULES[0])


def _of_package(name: str):
    """A module of the Python that belongs to the package bpy; None if it has none."""
    folder = pathlib.Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
    places = [*folder.glob("python*/site-packages"), folder / "site-packages"]
    for ending in importlib.machinery.EXTENSION_SUFFIXES:
        for path in (place / f"{name}{ending}" for place in places):
            spec = importlib.util.spec_from_file_location(name, path) if path.is_file() else None
            if spec is None:
                continue
            try:
                module = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
            except ImportError:
                continue
            sys.modules[name] = module
            return module
    return None


def axes_of(grid) -> np.ndarray | None:
    """(4, 4) matrix of a grid from the numbers of voxels to its space; None if there is none that can be inverted."""
    if not grid.transform.isLinear:
        return None
    matrix = np.eye(4)
    matrix[:3, 3] = origin = np.array(grid.transform.indexToWorld((0.0, 0.0, 0.0)))
    axes = [np.array(grid.transform.indexToWorld(tuple(row))) - origin for row in np.eye(3)]
    matrix[:3, :3] = np.column_stack(axes)
    size = float(np.linalg.norm(axes, axis=1).min())
    if not np.isfinite(matrix).all() or not abs(np.linalg.det(matrix[:3, :3] / max(size, 1e-30))) > 1e-6:
        return None
    return matrix


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
