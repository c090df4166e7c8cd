# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the GPU has in the place of kernels, and of their constants.

All other kernels are translated as they stand. A kernel that is replaced is marked where it is defined
(``replaced.replaced_on_gpu``); what takes its place is another kernel, with the same parameters, or a ``Native`` that writes GLSL.
Groups say for which scenes it does.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable

from ...emitter import hashing
from ...emitter import lamps as emitter_lamps
from ...emitter.emission import varying
from ...emitter.intersection import cover, fields, intervals, primitives, sponge
from ...emitter.sampling import cut, cut_points
from ...emitter.tree import crossings
from ...jit import float_bits, stack_array
from ..kernels import gather, geometry, lamp_tree, next_event, rays, sampler, textures
from ..kernels.lights import rectangle, tree, triangle
from ..kernels.shading import values
from ..kernels.workspace import cut_of, light_cut_of, spans_of
from . import crossings as field_crossings
from . import images, lamps, parts, still
from .layout import Array
from .translate import BOOL, FLOAT, INT, UINT, VECTOR, Native, Ref, Tuple, Value

# Constants that stand for the rounding of float64: (module that uses it, name) -> its value in float32.
ROUNDING = {
    (primitives, "QUARTIC_ROUNDING"): 4e-7,
    (primitives, "POLISH"): 3e-2,
    (sponge, "_ROUNDING"): 1e-6,
    (cover, "SIGN"): 1e-30,
    (cover, "LARGEST"): 1e30,
    (field_crossings, "SIGN"): 1e-30,
    (emitter_lamps, "SMALLEST_INTERVAL"): 2e-6,
    (rectangle, "SMALL"): 3e-3,
    (triangle, "SMALL"): 3e-2,
}


def _spans(function, arguments):
    rows = Array(Array("float", 2, packed=True), packed=True)
    return Value(Ref(rows, "spans_rows[{}]"), "0")


def _ray(any_hit: str) -> Native:
    def call(function, arguments):
        block, workspace, *rest = arguments
        texts = [
            *function.passed(rest[:2]),
            *(function.converted(value, FLOAT).text for value in rest[2:4]),
            function.converted(rest[4], INT).text,
        ]
        return Value(BOOL, f"hit_scene({workspace.constant.prefix}ray_row, {', '.join(texts)}, {any_hit})")

    return Native(call)


def _field_value(function, arguments):
    _, row, _, _, p = arguments
    return Value(FLOAT, f"field_value({', '.join(function.passed([row, p]))})")


def _stack(function, arguments):
    return function.translator.local_array(int(arguments[0].constant))


def _note(function, arguments):
    return Value(None, f"note_length({', '.join(function.passed(arguments[1:4]))})")


def _only_row(name: str) -> Native:
    """The one row of a table of the workspace, of which a thread needs no more: its path does not divide."""

    def call(function, arguments):
        table = function.translator.tables.table(name, None, arguments[0])
        return Value(Ref(table.type.layout.inner, table.type.lvalue))

    return Native(call)


# Kernels of this package whose GLSL is written by hand.
IN_GLSL = {
    field_crossings.choose: Native("choose_field"),
    field_crossings.field_at: Native("field", FLOAT),
    field_crossings.halves: Native("unpackHalf2x16", Tuple((FLOAT, FLOAT))),
    lamps.colour: Native("lamp_colour", VECTOR),
}

ALWAYS = {
    **IN_GLSL,
    sampler.pixel_seed: Native("pixel_seed", UINT),
    sampler.draw1: Native("draw1", FLOAT),
    sampler.draw2: Native("draw2", Tuple((FLOAT,) * 2)),
    sampler.draw3: Native("draw3", VECTOR),
    sampler.draw4: Native("draw4", Tuple((FLOAT,) * 4)),
    hashing.seeded: Native("counted_seeded", UINT),
    hashing.following: Native("counted_following", UINT),
    hashing.uniform: Native("counted_uniform", FLOAT),
    hashing.uniform_point: Native("counted_point", VECTOR),
    rays.intersect: _ray("false"),
    rays.occluded: _ray("true"),
    geometry.instance_at: still.instance_at,
    geometry.form_of: still.form_of,
    textures.texel: images.texel,
    textures.decoded: images.decoded,
    float_bits: Native("floatBitsToUint", UINT),
    stack_array: Native(_stack),
    spans_of: Native(_spans),
    cut_of: _only_row("lamp_cuts"),
    light_cut_of: _only_row("light_cut"),
    crossings.crossings: field_crossings.crossings,
    fields.value: Native(_field_value),
    emitter_lamps.note_length: Native(_note),
    emitter_lamps.solve_all: parts.solve_all,
    varying.line_integral: lamps.line_integral,
    cut_points.sample_point: lamps.sample_point,
    cut_points.project_afar: cut.project,
    lamp_tree.lamps_along: lamps.lamps_along,
    tree.fit_cut: lamps.fit_light_cut,
}
WITH_BOXES = {cut.prepare: lamps.prepare}
WITHOUT_BOXES = {cut.sample: lamps.sample, cut.density: lamps.density}
BY_PROJECTION = {next_event.prepare_lamp: lamps.prepare_lamp}  # where boxes are asked for, and do not pay
ONE_EMITTER = {tree.select: lamps.select_only, tree.selection_probability: lamps.only_probability}
ONE_LIGHT_RAY = {next_event.renew_lamp: lamps.keep_lamp}  # of one emitter, without transparent shadows
NO_LAMPS = {next_event.light_lamp: lamps.no_light, gather.lamp_reach: lamps.no_reach}

GROUPS = ALWAYS, WITH_BOXES, WITHOUT_BOXES, BY_PROJECTION, ONE_EMITTER, ONE_LIGHT_RAY, NO_LAMPS


# Kernels that are written as GLSL for each scene: the graphs of materials, and lamps of many parts.
WRITTEN = values.run, intervals.solve


def together(*groups: dict) -> dict[Callable, object]:
    """What takes the place of kernels, by their Python functions, as the translator looks them up."""
    return {inspect.unwrap(kernel): value for group in groups for kernel, value in group.items()}
