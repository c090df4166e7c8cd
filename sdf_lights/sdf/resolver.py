# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the language gets the shapes that data make: ``text("OPEN")``, ``object("Sign")``, ``image("//logo.png")``.

The language knows a kind, a name and settings. A ``Resolver`` finds the data: objects of Blender, or arrays.
"""

from __future__ import annotations

import difflib
import pathlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..graph.tables import Table, table
from .shapes import SHAPES, Box, Shape

Found = Shape | Table  # the shape of a thing, or, for ``COLOURS``, the table of its colours (``data.texture``)
COLOURS = "image_color"

_MOST_COMPARED = 1000  # names: each takes some microseconds


class Request(NamedTuple):
    """``kind`` is a word of ``builtin_data.DATA``, or ``COLOURS`` of an image; ``settings`` are its other arguments, by
    name."""

    kind: str
    name: str
    settings: tuple[tuple[str, float | str], ...] = ()

    def get(self, setting: str) -> float | str:
        """The value of a setting."""
        return dict(self.settings)[setting]


class Unresolved(Exception):
    """The data do not exist, or no shape can be made of them. The message names the problem, and ``cure`` the cure."""

    def __init__(self, problem: str, cure: str):
        super().__init__(problem)
        self.cure = cure


class Resolver(Protocol):
    """What answers requests."""

    def find(self, request: Request) -> Found:
        """The shape in the thing's own space, or its colours. Raises ``Unresolved``."""


def missing(kind: str, name: str, known: Iterable[str]) -> Unresolved:
    """There is no thing of this name; the cure is the known name that is most like it."""
    known = list(known)
    close = difflib.get_close_matches(name[:80], known[:_MOST_COMPARED], 1)
    cure = f"did you mean {close[0]!r}?" if close else "make one, or write the name of another"
    if known and not close:
        cure += f", such as {known[0]!r}"
    return Unresolved(f"there is no {kind} {name!r:.80}", cure)


class PlaceholderResolver:
    """Returns a box for every request. It serves to check the parts of an expression that do not depend on data."""

    def __init__(self):
        self.asked = False

    def find(self, request: Request) -> Found:
        """A box, or a white pixel."""
        self.asked = True
        return Box() if request.kind != COLOURS else table(np.array([1, 1, 0, 1, 1, 1, 1, 1], np.float32))


class NoResolver:
    """Refuses every request. It is used where no resolver is given, as outside of Blender."""

    def find(self, request: Request) -> Found:
        """Raises ``Unresolved``."""
        raise Unresolved(
            f"{request.kind}({request.name!r:.40}) needs a resolver, which knows what that is",
            "open the lamp in Blender, or give Expression.shape a resolver such as Arrays",
        )


class Arrays:
    """Things from NumPy: ``images`` (height, width, channels), linear, with the upper row first,
    ``meshes`` as vertices (n, 3) and triangles (m, 3), and ``shapes`` for names of objects. Texts need Blender's fonts.
    """

    def __init__(
        self,
        images: Mapping[str, np.ndarray] | None = None,
        meshes: Mapping[str, tuple[np.ndarray, np.ndarray]] | None = None,
        shapes: Mapping[str, Shape] | None = None,
    ):
        self.images, self.meshes, self.shapes = dict(images or {}), dict(meshes or {}), dict(shapes or {})

    def find(self, request: Request) -> Found:
        """The shape in the thing's own space, or its colours. Raises ``Unresolved``."""
        if request.kind == COLOURS and request.name in self.images:
            from .data.texture import texture_table

            return texture_table(self.images[request.name][::-1])
        if request.kind == "image" and request.name in self.images:
            return extruded(self.images[request.name][::-1], request)
        if request.kind in ("mesh", "object") and request.name in self.meshes:
            return self._grid(request)
        if request.kind == "object" and request.name in self.shapes:
            return self.shapes[request.name]
        if request.kind == "network":
            return _network(request)
        if request.kind == "text":
            raise Unresolved("a text needs Blender's fonts", "open the lamp in Blender, or use image or mesh")
        known = self.images if request.kind in ("image", COLOURS) else self.meshes
        raise missing(
            request.kind.partition("_")[0], request.name, [*known, *(self.shapes if request.kind == "object" else ())]
        )

    def _grid(self, request: Request) -> Shape:
        from .data.voxels import GridError, mesh_grid

        try:
            return mesh_grid(*self.meshes[request.name], float(request.get("voxel_size")))
        except GridError as error:
            problem, _, cure = str(error).rstrip(".").rpartition(": ")
            raise Unresolved(f"mesh {request.name!r} {problem}", cure) from None


def _network(request: Request) -> Shape:
    from .data.network import NetworkError, read

    try:
        return read(pathlib.Path(request.name)).shape()
    except NetworkError as error:
        problem, _, cure = str(error).rstrip(".").rpartition(": ")
        raise Unresolved(f"network {request.name!r:.80} {problem}", cure) from None


def extruded(pixels: np.ndarray, request: Request) -> Shape:
    """The outline of pixels (height, width, channels), the lowest row first, extruded. Raises ``Unresolved``."""
    from .data.outline import Outline, outline_table
    from .data.picture import PictureError, outline_of

    try:
        segments = outline_of(pixels, str(request.get("part")), float(request.get("threshold")))
    except PictureError as error:
        problem, _, cure = str(error).rpartition(": ")
        raise Unresolved(f"image {request.name!r:.80} {problem}", cure) from None
    outline = Outline(outline_table(segments * float(request.get("width"))))
    return SHAPES["extrusion"](outline, float(request.get("thickness")), 0.0)  # type: ignore[call-arg]


class _Recorder:
    """Another resolver, with what it was asked and what it answered."""

    def __init__(self, resolver: Resolver):
        self._resolver = resolver
        self.answers: dict[Request, Found | str] = {}

    def find(self, request: Request) -> Found:
        try:
            self.answers[request] = found = self._resolver.find(request)
        except Unresolved as error:
            self.answers[request] = f"{error}: {error.cure}"
            raise
        return found

    def has_answers(self, answers: Mapping[Request, Shape | Table | str]) -> bool:
        """Whether the resolver answers so."""
        for request in answers:
            try:
                self.find(request)
            except Unresolved:
                pass
        return self.answers == answers


class Cache:
    """Results by a key, and by what a resolver answered while they were made. The last ``size`` are kept."""

    def __init__(self, size: int):
        self._size = size
        self._kept: OrderedDict[Hashable, tuple[Any, dict[Request, Found | str]]] = OrderedDict()

    def get(self, key: Hashable, resolver: Resolver, make: Callable[[Resolver], Any]) -> Any:
        """What ``make(resolver)`` gives."""
        if key in self._kept:
            result, answers = self._kept[key]
            if not answers or _Recorder(resolver).has_answers(answers):
                self._kept.move_to_end(key)
                return result
        recorder = _Recorder(resolver)
        result = make(recorder)
        self._kept[key] = result, recorder.answers
        self._kept.move_to_end(key)
        while len(self._kept) > self._size:
            self._kept.popitem(last=False)
        return result
