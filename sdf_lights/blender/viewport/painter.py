# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws lamps by raymarching their formulas on the GPU: the back faces of each lamp's box, one shader per formula.

Needs a graphics context: call it while Blender draws, or after ``gpu.init()``.
"""

from __future__ import annotations

import functools
from collections import OrderedDict
from collections.abc import Sequence
from typing import NamedTuple

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ...affine import inverse
from ...graph.tables import Table, address_slots, as_float32, with_places
from ...render.scene import Lamp
from ...sdf.emission import Emission, Placed
from ...sdf.shapes import Shape
from . import shaders
from .facts import Facts, varies

# The shortest step along a ray: a fraction of the box's diagonal, or of a pixel if that is longer.
LEAST_STEP, LEAST_STEP_OF_PIXEL = 1e-4, 0.25
# Fraction of the box by which it is drawn larger.
MARGIN = 1e-4
# Minimum width in pixels of details that must be found on the screen.
WIDTH = 2.0
# Number of cached textures with the tables of a lamp.
KEPT_TABLES = 32
# Number of cached shaders and buffers.
KEPT = 256

_CUBE = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
_FACES = [
    (0, 2, 1),
    (1, 2, 3),
    (4, 5, 6),
    (5, 7, 6),
    (0, 1, 4),
    (1, 5, 4),
    (2, 6, 3),
    (3, 6, 7),
    (0, 4, 2),
    (2, 4, 6),
    (1, 3, 5),
    (3, 7, 5),
]
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


class View(NamedTuple):
    """``view`` and ``projection`` (4 × 4) in OpenGL's convention, of a picture of ``size`` pixels."""

    view: np.ndarray
    projection: np.ndarray
    size: tuple[int, int]

    @property
    def perspective(self) -> bool:
        """Whether the projection is a perspective."""
        return self.projection[3, 3] == 0.0

    @property
    def clip(self) -> tuple[float, float]:
        """Least and greatest depth along the view axis."""
        (a, b), (c, d) = self.projection[2:, 2:]
        return tuple(-(ndc * d - b) / (a - ndc * c) if a != ndc * c else np.inf for ndc in (-1.0, 1.0))


class Depth(NamedTuple):
    """Depth buffer of the scene: a texture of the pixels from ``origin`` on, and the number of pixels that each of its
    own spans."""

    texture: gpu.types.GPUTexture
    origin: tuple[int, int]
    scale: float


class Drawn(NamedTuple):
    """A lamp to draw. ``mask``: its value in the mask (selected, active). ``least``: minimum light (RGB) where it is
    visible; if that is not black, the lamp is also at least about ``WIDTH`` pixels wide."""

    lamp: Lamp
    facts: Facts
    exposure: float = 1.0
    mask: tuple[float, float] = (0.0, 0.0)
    least: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Painter:
    """Draws lamps, and caches the shaders of their formulas."""

    def __init__(self):
        self._shaders: OrderedDict[shaders.LampCode, object] = OrderedDict()
        self._tables: OrderedDict[tuple[Table, ...], gpu.types.GPUTexture] = OrderedDict()
        self._no_depth: gpu.types.GPUTexture | None = None

    def problem(self, lamp: Lamp) -> str:
        """Why the lamp has no shader, as the rest of a sentence; empty if it has one or was not drawn yet."""
        found = self._shaders.get(code_of(lamp))
        return str(found) if isinstance(found, shaders.ShaderError) else ""

    def is_compiled(self, lamp: Lamp) -> bool:
        """Whether the lamp has a shader, or its shader has failed."""
        return code_of(lamp) in self._shaders

    def compile(self, lamp: Lamp) -> None:
        """Compile the shader of a lamp, if it has none."""
        code = code_of(lamp)
        if code not in self._shaders:
            try:
                shader = shaders.lamp_shader(code)
                self._shaders[code] = shader, batch_for_shader(shader, "TRIS", {"corner": _CUBE}, indices=_FACES)
            except shaders.ShaderError as error:
                self._shaders[code] = error.with_traceback(None)
            while len(self._shaders) > KEPT:
                self._shaders.popitem(last=False)

    def draw(self, lamps: Sequence[Drawn], view: View, depth: Depth | None = None) -> None:
        """Add the light of the lamps to the bound frame buffer: colour and mask. Lamps without a shader are left
        out."""
        if self._no_depth is None:
            self._no_depth = gpu.types.GPUTexture((1, 1), format="R32F")
        gpu.state.blend_set("ADDITIVE_PREMULT")
        gpu.state.depth_test_set("NONE")
        gpu.state.depth_mask_set(False)
        try:
            for item in lamps:
                self._draw(item, view, depth)
        finally:
            gpu.state.face_culling_set("NONE")
            gpu.state.blend_set("NONE")

    def _texture_of(self, tables: tuple[Table, ...]) -> gpu.types.GPUTexture:
        found = self._tables.get(tables)
        if found is None:
            numbers = np.concatenate([as_float32(table) for table in tables])
            rows = -(-len(numbers) // shaders.TABLE_WIDTH)
            pixels = np.zeros(rows * shaders.TABLE_WIDTH, np.float32)
            pixels[: len(numbers)] = numbers
            data = gpu.types.Buffer("FLOAT", len(pixels), pixels)
            found = gpu.types.GPUTexture((shaders.TABLE_WIDTH, rows), format="R32F", data=data)
            self._tables[tables] = found
            while len(self._tables) > KEPT_TABLES:
                self._tables.popitem(last=False)
        self._tables.move_to_end(tables)
        return found

    def _draw(self, item: Drawn, view: View, depth: Depth | None) -> None:
        code = code_of(item.lamp)
        found = self._shaders.get(code)
        if found is None or isinstance(found, shaders.ShaderError):
            return
        self._shaders.move_to_end(code)
        shader, batch = found
        block = uniforms(item, view, depth)
        tables = tables_of(item.lamp)[0]
        buffer = gpu.types.GPUUniformBuf(gpu.types.Buffer("FLOAT", block.size, block.ravel()))
        # Back faces also exist for an eye inside the box. A mirrored box shows its other side.
        mirrored = np.linalg.det((view.view @ item.lamp.matrix)[:3, :3]) < 0.0
        gpu.state.face_culling_set("BACK" if mirrored else "FRONT")
        shader.bind()
        shader.uniform_block("lamp", buffer)
        shader.uniform_sampler("scene_depth", depth.texture if depth else self._no_depth)
        if tables:
            shader.uniform_sampler("tables", self._texture_of(tables))
        shader.uniform_int("depth_origin", depth.origin if depth else (0, 0))
        shader.uniform_float("projection", Matrix((view.projection @ view.view @ item.lamp.matrix).tolist()))
        batch.draw(shader)


@functools.lru_cache(maxsize=KEPT)
def _placed(emission: Emission, shape: Shape) -> Placed:
    return emission.placed(shape)


def _varying(lamp: Lamp) -> Placed | None:
    """The emission of a lamp, if it varies."""
    return _placed(lamp.emission, lamp.shape) if varies(lamp.emission) else None


def _numbers(lamp: Lamp) -> np.ndarray:
    """Parameters of the shape, then those of the emission. Addresses of tables are replaced by their start in the
    concatenated tables."""
    placed = _varying(lamp)
    return _with_places(lamp.shape, placed)[1]


def tables_of(lamp: Lamp) -> tuple[tuple[Table, ...], np.ndarray]:
    """Tables that a lamp's formulas read, and the numbers of its shader."""
    return _with_places(lamp.shape, _varying(lamp))


def _with_places(shape: Shape, placed: Placed | None) -> tuple[tuple[Table, ...], np.ndarray]:
    own, slots = shape.parameters(), address_slots(shape.formula())
    if placed is not None:
        slots |= {len(own) + slot for slot in address_slots(*placed.colour)}
    numbers, tables = with_places(np.concatenate([own, placed.parameters if placed is not None else []]), slots)
    return tuple(tables), numbers


def code_of(lamp: Lamp) -> shaders.LampCode:
    """The key of a lamp's shader: the same for all numbers."""
    placed = _varying(lamp)
    return shaders.LampCode(
        lamp.shape.formula(), len(lamp.shape.parameters()), len(_numbers(lamp)), placed and placed.colour
    )


def emission_scale(lamp: Lamp, facts: Facts) -> np.ndarray:
    """ρ of a lamp (RGB) at relative emission 1: see ``render.scene.Lamp``."""
    density = lamp.density
    if density is None:
        volume = facts.volume * abs(np.linalg.det(lamp.matrix[:3, :3]))
        density = lamp.power / (4.0 * np.pi * volume * facts.mean.mean())
    return density * np.asarray(lamp.color)


def radiance_per_metre(lamp: Lamp, facts: Facts) -> np.ndarray:
    """Mean of ρ over the volume of a lamp (RGB)."""
    return emission_scale(lamp, facts) * facts.mean


def pixel_size(lamp: Lamp, facts: Facts, view: View) -> float:
    """Size of a pixel at the middle of the lamp, in the shape's local space."""
    center = np.append(0.5 * (facts.low + facts.high), 1.0)
    clip = view.projection @ view.view @ lamp.matrix @ center
    scale = np.abs(np.linalg.det(lamp.matrix[:3, :3])) ** (1.0 / 3.0)
    return 2.0 * abs(clip[3]) / (view.projection[1, 1] * view.size[1] * scale)


def least_step(lamp: Lamp, facts: Facts, view: View) -> float:
    """Shortest step along a ray, in the shape's local space: finer details are invisible in this view."""
    diagonal = np.linalg.norm(facts.high - facts.low)
    return min(max(LEAST_STEP * diagonal, LEAST_STEP_OF_PIXEL * pixel_size(lamp, facts, view)), 0.02 * diagonal)


def widening(item: Drawn, view: View) -> float:
    """Width by which a lamp is enlarged on each side, in its shape's local space."""
    if not any(item.least) or not item.lamp.shape.exact_outside:  # elsewhere the field is not a distance
        return 0.0
    return 0.5 * WIDTH * pixel_size(item.lamp, item.facts, view)


def uniforms(item: Drawn, view: View, depth: Depth | None) -> np.ndarray:
    """The uniform block of a lamp: (vectors, 4) float32, in the order of ``shaders``."""
    lamp, facts = item.lamp, item.facts
    to_view = view.view @ lamp.matrix
    from_view = inverse(to_view)
    extent = facts.high - facts.low
    numbers = _numbers(lamp)
    scale = emission_scale(lamp, facts) if varies(lamp.emission) else radiance_per_metre(lamp, facts)
    wider = widening(item, view)
    margin = MARGIN * extent + wider
    block = np.zeros((shaders.HEADER + shaders.vectors_of(len(numbers)), 4))
    block[0] = *(facts.low - margin), least_step(lamp, facts, view)
    block[1] = *(facts.high + margin), facts.lipschitz
    block[2] = (*from_view[:3, 3], 1.0) if view.perspective else (*-from_view[:3, 2], 0.0)
    block[3] = -to_view[2]
    block[4, :2] = view.clip
    block[4, 2] = depth.scale if depth else 0.0
    block[5] = view.projection[2:, 2:].ravel()
    block[6] = *(item.exposure * scale), facts.rate
    block[7, :2] = item.mask
    block[8:11, :3] = lamp.matrix[:3, :3].T
    block[11] = *item.least, wider
    block[shaders.HEADER :].ravel()[: len(numbers)] = numbers
    limit = np.finfo(np.float32).max
    return np.clip(block, -limit, limit).astype(np.float32)
