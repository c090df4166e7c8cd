# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose shape is a network of sines, from a file."""

from __future__ import annotations

import pathlib
from collections import OrderedDict

import bpy

from ..render.errors import RenderError
from ..sdf.shapes import Shape

_KEPT = 16

_shapes: OrderedDict[tuple, Shape | str] = (
    OrderedDict()
)  # by the file as it was, or a sentence on what is wrong with it


def shape_of(lamp) -> Shape:
    """The shape of a ``Light.sdf_lamp`` that is made from a network. Raises RenderError with a sentence."""
    return of_file(path_of(lamp))


def path_of(lamp) -> pathlib.Path | None:
    """The file that a ``Light.sdf_lamp`` names; None for the network that the add-on has."""
    if not lamp.network:
        return None
    return pathlib.Path(bpy.path.abspath(lamp.network, library=lamp.id_data.library))


def of_file(path: pathlib.Path | None) -> Shape:
    """The shape of a file, or of the add-on's own one. Raises RenderError with a sentence that names the file."""
    from ..sdf.data import network  # it needs Numba, whose import takes a second

    path = path or network.EXAMPLE
    try:
        about = path.stat()
        key = str(path), about.st_mtime_ns, about.st_size
    except (OSError, ValueError):
        key = str(path), 0, 0
    found = _shapes.get(key)
    if found is None:
        try:
            found = network.read(path).shape()
        except network.NetworkError as error:
            found = f"Network '{path.name}' {error}"
        except MemoryError:
            found = f"Network '{path.name}' does not fit into memory: fit a smaller one."
        _shapes[key] = found
        while len(_shapes) > _KEPT:
            _shapes.popitem(last=False)
    _shapes.move_to_end(key)
    if isinstance(found, str):
        raise RenderError(found)
    return found


def forget() -> None:
    """Files are read again when they are next asked for."""
    _shapes.clear()
