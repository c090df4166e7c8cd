# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lamps mean by names of data: objects and images of the file, and texts in Blender's font.

A lamp keeps a pointer to each thing that its texts name. So files keep these things, they come along where a lamp is
appended, and a thing that gets another name is still found.
"""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import bpy

from ..render.errors import RenderError
from ..sdf.builtin_data import DATA
from ..sdf.resolver import COLOURS, Found, Request, Unresolved, missing
from ..sdf.shapes import Shape
from . import network_lamps, objects, picture_lamps
from .objects import curves

Names = Iterable[tuple[str, str]]  # kinds and names


_PARTS = {"opaque": "ALPHA", "bright": "BRIGHT", "dark": "DARK"}


class _Wanted(NamedTuple):
    """Settings of a request, as readers of objects and pictures take them from a ``Light.sdf_lamp``."""

    object_form: str = "SOLID"
    thickness: float = 0.1
    voxel_size: float = 0.0
    neon_radius: float = 0.0
    neon_gap: float = 0.0
    image: bpy.types.Image | None = None
    image_part: str = "ALPHA"
    image_threshold: float = 0.5
    image_size: float = 1.0


def _wanted(request: Request, image: bpy.types.Image | None = None) -> _Wanted:
    given = dict(request.settings)
    radius = float(given.get("neon_radius", 0.0))
    return _Wanted(
        curves.NEON if radius > 0.0 else "SOLID",
        float(given.get("thickness", 0.1)),
        float(given.get("voxel_size", 0.0)),
        radius,
        float(given.get("gap", 0.0)),
        image,
        _PARTS.get(given.get("part"), "ALPHA"),
        float(given.get("threshold", 0.5)),
        float(given.get("width", 1.0)),
    )


class FileResolver:
    """Knows the data of the file that is open, for a lamp (None: for any). ``pinned`` are things by kind and name."""

    def __init__(self, lamp=None, pinned: Mapping[tuple[str, str], bpy.types.ID] | None = None):
        self._light = lamp.id_data.original if lamp is not None else None
        held = self._light.sdf_lamp.data if self._light is not None else ()
        self._pinned = {(item.kind, item.name): item.thing() for item in held} | dict(pinned or {})

    def find(self, request: Request) -> Found:
        """The shape in the thing's own space, or its colours. Raises ``Unresolved``."""
        try:
            return _READERS[request.kind](self, request)
        except RenderError as error:
            problem, _, cure = str(error).rstrip(".").rpartition(": ")
            raise Unresolved(problem[0].lower() + problem[1:], cure) from None

    def thing(self, kind: str, name: str) -> bpy.types.ID | None:
        """The object or image of a name."""
        return self._pinned.get((kind, name)) or _found(kind, name, self._light)

    def _object(self, request: Request, types: Iterable[str]) -> bpy.types.Object:
        obj = self.thing(request.kind, request.name)
        if obj is None or obj.type not in types:
            if obj is not None and self._light is not None and obj.data == self._light:
                raise Unresolved("a lamp cannot be made of itself", "write the name of a text, a curve or a mesh")
            known = [other.name for other in bpy.data.objects if other.type in types]
            raise missing("mesh" if request.kind == "mesh" else objects.listed(), request.name, known)
        return obj


def _of_text(resolver: FileResolver, request: Request) -> Shape:
    given = dict(request.settings)
    return curves.shape_of_text(request.name, float(given["size"]), _wanted(request))


def _of_object(resolver: FileResolver, request: Request) -> Shape:
    return objects.shape_of(resolver._object(request, types_of(request.kind)), _wanted(request))


def _of_image(resolver: FileResolver, request: Request) -> Found:
    image = resolver.thing("image", request.name)
    if image is None:
        if _is_file(request.name, resolver._light):
            raise Unresolved(f"image {request.name!r:.80} is not loaded yet", "look again in a moment")
        raise missing(
            "image or file", request.name, [image.name for image in bpy.data.images if image.source != "VIEWER"]
        )
    if request.kind == COLOURS:
        return picture_lamps.colours_of(image)
    return picture_lamps.shape_of(_wanted(request, image))


def _of_network(resolver: FileResolver, request: Request) -> Shape:
    return network_lamps.of_file(pathlib.Path(_path(request.name, resolver._light)) if request.name else None)


def types_of(kind: str) -> tuple[str, ...]:
    """Types of objects that a word takes."""
    return ("MESH", "META") if kind == "mesh" else tuple(objects.READERS)


_READERS: dict[str, Callable[[FileResolver, Request], Found]] = {
    "text": _of_text,
    "object": _of_object,
    "mesh": _of_object,
    "image": _of_image,
    "network": _of_network,
    COLOURS: _of_image,
}


def builtin_call_of(lamp) -> tuple[str, str, dict[str, float | str]]:
    """The word, the name and the settings that say the shape of a lamp of an object, an image or a network.
    Raises RenderError."""
    if lamp.source == "NETWORK":
        if not lamp.network:
            raise RenderError("Its network is the example of the add-on, which has no file: choose a file first.")
        return "network", lamp.network, {}
    if lamp.source == "IMAGE":
        part = next(word for word, part in _PARTS.items() if part == lamp.image_part)
        settings = {"width": lamp.image_size, "thickness": lamp.thickness, "threshold": lamp.image_threshold}
        return "image", lamp.image.name, settings | {"part": part}
    obj = lamp.object
    if obj.type in ("MESH", "META"):
        return "mesh", obj.name, {"voxel_size": lamp.voxel_size}
    if lamp.object_form == curves.NEON:
        return "object", obj.name, {"neon_radius": lamp.neon_radius, "gap": lamp.neon_gap}
    return "object", obj.name, {"thickness": lamp.thickness}


# -- things of a file --------------------------------------------------------------------------------------------------


def _path(name: str, light: bpy.types.Light | None) -> str:
    return os.path.normpath(bpy.path.abspath(name, library=light.library if light is not None else None))


def _is_file(name: str, light: bpy.types.Light | None) -> bool:
    return name not in ("", ".") and "\0" not in name and os.path.isfile(_path(name, light))


def _found(kind: str, name: str, light: bpy.types.Light | None) -> bpy.types.ID | None:
    of = DATA[kind].of
    if of != "image":
        return bpy.data.objects.get(name) if of == "object" else None
    if name in bpy.data.images:
        return bpy.data.images[name]
    path = _path(name, light) if "/" in name or "\\" in name or "." in name else ""
    return next((image for image in bpy.data.images if path and image.filepath and _path_of(image) == path), None)


def _path_of(image: bpy.types.Image) -> str:
    return os.path.normpath(bpy.path.abspath(image.filepath, library=image.library))


def is_behind(lamp, names: Names) -> bool:
    """Whether ``pin`` has something to do."""
    wanted = set(names)
    pinned = {(item.kind, item.name) for item in lamp.data if item.thing() is not None}
    if any(DATA[kind].of == "text" and not curves.has_letters(name) for kind, name in wanted):
        return True
    return bool(pinned - wanted) or any(
        (kind, name) not in pinned
        and (_found(kind, name, lamp.id_data) or kind == "image" and _is_file(name, lamp.id_data))
        for kind, name in wanted
    )


def pin(lamp, names: Names) -> None:
    """Lets a lamp hold pointers to all that it names, loads images from files, and reads texts."""
    wanted = dict.fromkeys(sorted(names))
    for index in reversed(range(len(lamp.data))):
        item = lamp.data[index]
        if (item.kind, item.name) not in wanted or item.thing() is None:
            lamp.data.remove(index)
        else:
            del wanted[item.kind, item.name]
    for kind, name in wanted:
        if DATA[kind].of == "text":
            curves.read_letters(name)
        thing = _found(kind, name, lamp.id_data)
        if thing is None and kind == "image" and _is_file(name, lamp.id_data):
            thing = _loaded(name, lamp.id_data)
        if thing is not None:
            item = lamp.data.add()
            item.kind, item.name = kind, name
            setattr(item, DATA[kind].of, thing)


def _loaded(name: str, light: bpy.types.Light) -> bpy.types.Image | None:
    try:
        image = bpy.data.images.load(_path(name, light))
    except RuntimeError:
        return None
    if name.startswith("//") and light.library is None:
        image.filepath = name
    return image


def remarks(lamp) -> list[str]:
    """Sentences on what is named in a lamp and has another name by now, and on what of its object is not in it."""
    found = objects.remarks(lamp)
    for item in lamp.data:
        thing = item.thing()
        if thing is None or thing.name == item.name:
            continue
        if item.kind != "image" or _path_of(thing) != _path(item.name, lamp.id_data):
            found.append(f"{item.name!r} is called {thing.name!r} now: write the new name in the expression.")
    return found
