# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU's replacements of kernels and of their constants.

All other kernels are translated unchanged. A replaced kernel is marked at its definition
(``replaced.replaced_on_gpu``). Its replacement is another kernel with the same parameters, or a ``Native`` that writes
GLSL. Groups tell for which scenes it is used.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable

from ... import bits
from ...emitter import hashing
from ...emitter import lamps as emitter_lamps
from ...emitter.emission import varying as emissions
from ...emitter.intersection import cover, fields, intervals
from ...emitter.primitives import sponge, torus
from ...emitter.sampling import cut, cut_points
from ...emitter.tree import crossings
from ...jit import call_part, float_bits, stack_array
from ..kernels import gather, geometry, integrator, lamp_tree, next_event, ray_origins, rays, textures
from ..kernels.light_paths import connections
from ..kernels.lights import emitters, linking, rectangle, tree, triangle
from ..kernels.media import cells, in_scattering, light_rays, stack, travel, varying
from ..kernels.outputs import catchers as output_catchers
from ..kernels.outputs import data as output_data
from ..kernels.outputs import light as output_light
from ..kernels.shading import operands
from ..kernels.subsurface import disk
from ..kernels.subsurface import records as subsurface
from ..kernels.workspace import cut_of, light_cut_of, spans_of
from . import catchers, closed_lamp_parts, images, lamp_kernels, light_paths, still, varying_media
from . import crossings as field_crossings
from .layout import Array
from .translate import BOOL, CONSTANT, FLOAT, INT, UINT, ULONG, VECTOR, WORKSPACE, Native, Ref, Tuple, Value, known

# Constants that stand for the rounding of float64: (module that uses it, name) -> its value in float32.
ROUNDING = {
    (torus, "QUARTIC_ROUNDING"): 4e-7,
    (torus, "POLISH"): 3e-2,
    (sponge, "_ROUNDING"): 1e-6,
    (cover, "SIGN"): 1e-30,
    (cover, "LARGEST"): 1e30,
    (field_crossings, "SIGN"): 1e-30,
    (emitter_lamps, "SMALLEST_INTERVAL"): 2e-6,
    (cells, "_NUDGE"): 1e-4,
    (cells, "_ADVANCE"): 1e-6,
    (rectangle, "SMALL"): 3e-3,
    (triangle, "SMALL"): 3e-2,
}

# Rows of tables of the workspace: paths do not split here, so there are fewer. (module that uses it, name) -> row.
ROWS = {
    (stack, "LIGHT_RAY"): 1,
    (light_rays, "LIGHT_RAY"): 1,
    (travel, "KEPT_RAY"): 1,
    (disk, "KEPT_RAY"): 1,
    (next_event, "LIGHT_RAY"): 1,
    (in_scattering, "LIGHT_RAY"): 1,
    (varying, "LIGHT_RAY"): 1,
    (varying, "LIGHT_RAY_OUTPUT"): 1,
    (varying, "KEPT_RAY"): 1,
    (output_light, "LIGHT_RAY"): 1,
    (connections, "LATER"): 0,
    (output_catchers, "CAUGHT"): 1,
    (output_catchers, "CAUGHT_RAY"): 2,
}

# First sets of random numbers, where the CPU's are beyond int32.
SETS = {(output_data, "OCCLUSION_SETS"): 1 << 30}


def _spans(function, arguments):
    flat = function.translator.tables.table("spans", None, known(WORKSPACE))
    rows = Array(Array("float", 2, packed=True), packed=True)
    return Value(Ref(rows, flat.type.lvalue), flat.text)


def _ray(any_hit: str) -> Native:
    def call(function, arguments):
        block, workspace, *rest = arguments
        texts = [
            *(function.converted(value, VECTOR).text for value in rest[:2]),
            *(function.converted(value, FLOAT).text for value in rest[2:4]),
            function.converted(rest[4], INT).text,
        ]
        return Value(BOOL, f"hit_scene({_first_ray(function, workspace)}, {', '.join(texts)}, {any_hit})")

    return Native(call)


def _first_ray(function, workspace) -> str:
    """The record of the ray in a workspace."""
    return function.translator.tables.table("ray", None, workspace).type.lvalue.replace("{}", "0")


def _instance_ray(function, arguments):
    _, workspace, index, *rest = arguments
    texts = [
        *(function.converted(value, VECTOR).text for value in rest[:2]),
        *(function.converted(value, FLOAT).text for value in rest[2:]),
        function.converted(index, INT).text,
    ]
    return Value(BOOL, f"hit_instance({_first_ray(function, workspace)}, {', '.join(texts)})")


def _part(function, arguments):
    """A call of a function that the CPU compiles separately: here it is an ordinary kernel."""
    kernel, block, workspace, given, _ = arguments
    name, result = function.translator.function(kernel.constant, [block, workspace, *given.items])
    if result.type == CONSTANT:
        return known((result.constant,))
    text = f"{name}({', '.join(function.passed(list(given.items)))})"
    if isinstance(result.type, Tuple):
        return Value(result.type, text)
    return Value(Tuple((result.type,)), text, items=(Value(result.type, text),))


def _field_value(function, arguments):
    _, row, _, _, p = arguments
    return Value(FLOAT, f"field_value({', '.join(function.passed([row, p]))})")


def _stack(function, arguments):
    return function.array(int(arguments[0].constant))


def _note(function, arguments):
    return Value(None, f"note_length({', '.join(function.passed(arguments[1:4]))})")


def _only_row(name: str) -> Native:
    """The only row of a table of the workspace: a thread needs no more, because its path does not split."""

    def call(function, arguments):
        table = function.translator.tables.table(name, None, arguments[0])
        return Value(Ref(table.type.layout.inner, table.type.lvalue))

    return Native(call)


# Kernels of this package with hand-written GLSL.
IN_GLSL = {
    field_crossings.choose: Native("choose_field"),
    field_crossings.field_at: Native("field", FLOAT),
    field_crossings.halves: Native("unpackHalf2x16", Tuple((FLOAT, FLOAT))),
    lamp_kernels.colour: Native("lamp_colour", VECTOR),
    catchers.is_bare: Native(lambda function, arguments: Value(BOOL, "bare")),
}

ALWAYS = {
    **IN_GLSL,
    bits.reverse_32: Native("bitfieldReverse", UINT),
    bits.reverse_64: Native("reverse_64", ULONG),
    bits.unit_float: Native("unit_float", FLOAT),
    hashing.seeded: Native("counted_seeded", UINT),
    hashing.following: Native("counted_following", UINT),
    hashing.uniform: Native("counted_uniform", FLOAT),
    hashing.uniform_point: Native("counted_point", VECTOR),
    rays.intersect: _ray("false"),
    rays.occluded: _ray("true"),
    ray_origins.number_of: Native("number_of", UINT),
    geometry.instance_at: still.instance_at,
    geometry.form_of: still.form_of,
    geometry.shares: still.shares,
    textures.texel: images.texel,
    textures.decoded: images.decoded,
    subsurface.intersect_instance: Native(_instance_ray),
    call_part: Native(_part),
    float_bits: Native("floatBitsToUint", UINT),
    stack_array: Native(_stack),
    spans_of: Native(_spans),
    cut_of: _only_row("lamp_cuts"),
    light_cut_of: _only_row("light_cut"),
    crossings.crossings: field_crossings.crossings,
    fields.value: Native(_field_value),
    emitter_lamps.note_length: Native(_note),
    emitter_lamps.solve_all: closed_lamp_parts.solve_all,
    emissions.attenuated_integral: lamp_kernels.attenuated_integral,
    emissions.line_integral: lamp_kernels.line_integral,
    emissions.colours: lamp_kernels.colours,
    cut_points.sample_point: lamp_kernels.sample_point,
    cut_points.project_afar: cut.project,
    lamp_tree.lamps_along: lamp_kernels.lamps_along,
    tree.fit_cut: lamp_kernels.fit_light_cut,
}
WITH_BOXES = {cut.prepare: lamp_kernels.prepare}
WITHOUT_BOXES = {cut.sample: lamp_kernels.sample, cut.density: lamp_kernels.density}
BY_PROJECTION = {next_event.prepare_lamp_cut: lamp_kernels.prepare_lamp_cut}  # if boxes are used but do not pay
ONE_EMITTER = {tree.select: lamp_kernels.select_only, tree.selection_probability: lamp_kernels.single_light_probability}
ONE_LIGHT_RAY = {
    next_event.restore_lamp_cut: lamp_kernels.keep_only_lamp
}  # of one emitter, without transparent shadows
NO_LAMPS = {next_event.sample_lamp_light: lamp_kernels.no_light, gather.last_lamp_exit: lamp_kernels.no_lamp_exit}
WITHOUT_VARYING_WORLD = {
    cells.divide_world_ray: varying_media.no_sections,
    cells.world_section_at: varying_media.no_section_at,
}
ALL_MEDIA_VARY = {varying.none_varies: varying_media.one_varies}

LIGHT_PATHS = {integrator.may_connect_again: light_paths.may_connect_again}
CATCHERS = {emitters.may_light: catchers.may_light, linking.is_in_light_tree: catchers.is_in_light_tree}

GROUPS = (
    ALWAYS,
    WITH_BOXES,
    WITHOUT_BOXES,
    BY_PROJECTION,
    ONE_EMITTER,
    ONE_LIGHT_RAY,
    NO_LAMPS,
    WITHOUT_VARYING_WORLD,
    ALL_MEDIA_VARY,
    CATCHERS,
    LIGHT_PATHS,
)


# Kernels that are written as GLSL for each scene: the graphs of materials, and lamps with many parts.
WRITTEN = operands.run, intervals.solve


def together(*groups: dict) -> dict[Callable, object]:
    """The replacements of kernels, by Python function, for the translator."""
    return {inspect.unwrap(kernel): value for group in groups for kernel, value in group.items()}
