# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose shape is that of an object: a text, a curve.

A module of this folder that defines how a type of objects is read puts a row into ``READERS``. All modules are found.
"""

from __future__ import annotations

import contextlib
import contextvars
import importlib
import pkgutil
from collections.abc import Callable

import bpy

from ...render.errors import RenderError
from ...sdf.shapes import Shape

Reader = Callable[[bpy.types.Object, bpy.types.Depsgraph, object], Shape]

READERS: dict[str, Reader] = {}
"""By the type of the object: from an object, its dependency graph and ``Light.sdf_lamp`` to the shape, in the object's space.
It raises RenderError with a sentence that names the object."""

REMARKS: dict[str, Callable[[bpy.types.Object, object], list[str]]] = {}
"""By the type of the object: a function of an object and a ``Light.sdf_lamp`` that returns sentences. They name what the lamp
leaves out of the object."""

KINDS: dict[str, str] = {}  # what Blender calls these types


def reads(**kinds: str):
    """Decorator of a reader of types of objects, each with what Blender calls it."""

    def decorate(reader: Reader) -> Reader:
        for kind, title in kinds.items():
            READERS[kind], KINDS[kind] = reader, title
        return reader

    return decorate


_depsgraph: contextvars.ContextVar[bpy.types.Depsgraph | None] = contextvars.ContextVar("depsgraph", default=None)


@contextlib.contextmanager
def within(depsgraph: bpy.types.Depsgraph):
    """Within, objects are read as this dependency graph has them: that of a render, which has a thread of its own."""
    token = _depsgraph.set(depsgraph)
    try:
        yield
    finally:
        _depsgraph.reset(token)


def shape_of(obj: bpy.types.Object | None, lamp) -> Shape:
    """The shape of an object in its own space, as a ``Light.sdf_lamp`` wants it. Raises RenderError with a sentence."""
    if obj is None:
        raise RenderError("It has no object: choose one in Shape > Object.")
    if obj.type not in READERS:
        raise RenderError(f"Object '{obj.name}' is not a {listed()}: choose another one in Shape > Object.")
    depsgraph = _depsgraph.get() or bpy.context.view_layer.depsgraph
    if not obj.is_evaluated:
        obj = obj.evaluated_get(depsgraph)
    return READERS[obj.type](obj, depsgraph, lamp)


def remarks(lamp) -> list[str]:
    """Sentences that name what a lamp leaves out of its object."""
    obj = lamp.object if lamp.source == "OBJECT" else None
    return REMARKS[obj.type](obj, lamp) if obj is not None and obj.type in REMARKS else []


def listed() -> str:
    """The types of objects, as part of a sentence."""
    *most, last = sorted({title.lower() for title in KINDS.values()})
    return f"{', '.join(most)} or {last}" if most else last


for _, _name, _ in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_name}")
