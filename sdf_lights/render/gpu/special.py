# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures of ``kernels/shading/special/``: the CPU calls one by its address; the GPU chooses among those of a
scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ...jit import kernel
from ..kernels.shading import dispatch, special
from ..kernels.shading.records import BURLEY
from ..kernels.subsurface import disk, walk
from .translate import BLOCK, FLOAT, INT, Native, Tuple, Value, known

_ADD = None, ("lobe", INT), ("weight", FLOAT)
_EVALUATE = Tuple((FLOAT,) * 4), ("closure", INT), ("x", FLOAT), ("y", FLOAT), ("z", FLOAT)
_SAMPLE = Tuple((FLOAT,) * 7 + (INT,)), ("closure", INT), ("u1", FLOAT), ("u2", FLOAT), ("u3", FLOAT)


@kernel
def _unrefined(block, workspace, lobe, closure, roughness):
    """Replaces ``dispatch.refine`` if no material needs it."""
    return roughness, -1.0, -1.0, -1.0


@kernel
def _opaque(block, workspace):
    """Replaces ``dispatch.transparency``, likewise."""
    return 0.0, 0.0, 0.0


@kernel
def _shaded_transparency(block, workspace):
    return special.TRANSPARENCY(block, workspace, 0.0)


@kernel
def _no_wall(block, workspace, lobe, r, g, b):
    """Replaces ``dispatch.thin_wall``, likewise."""
    return 0.0


@kernel
def _no_scattering(block, workspace, lobe, r, g, b, ior):
    """Replaces ``dispatch.subsurface``, likewise."""
    return 0.0


@kernel
def _nowhere(block, workspace, closure):
    """Replaces a method of subsurface scattering that no material uses."""
    return 0.0


def natives(lobes: np.ndarray) -> dict:
    """The replacements of the kernels of ``dispatch``, and of subsurface scattering, for a scene with these lobes
    (n,)."""
    found, closures, refined, thin, deep = special.kinds(lobes)
    methods = special.methods(lobes)
    return {
        dispatch.add: _choice("special_add", _ADD, {kind: special.LOBES[kind][0] for kind in found}),
        dispatch.evaluate: _choice(
            "special_evaluate", _EVALUATE, {kind: special.CLOSURES[kind].evaluate for kind in closures}
        ),
        dispatch.sample: _choice("special_sample", _SAMPLE, {kind: special.CLOSURES[kind].sample for kind in closures}),
        dispatch.refine: special.REFINE if refined else _unrefined,
        dispatch.thin_wall: special.THIN_WALL if thin else _no_wall,
        dispatch.transparency: _shaded_transparency if thin else _opaque,
        dispatch.subsurface: special.SCATTERING if deep else _no_scattering,
        disk.scatter: disk.scatter if BURLEY in methods else _nowhere,
        walk.walk: walk.walk if methods - {BURLEY} else _nowhere,
    }


def _choice(name: str, signature: tuple, kernels: dict[int, Callable]) -> Native:
    """One of ``kernels``, selected by the kind in a call, after the block and the workspace."""
    return Native(partial(_call, name, signature, kernels))


def _call(name: str, signature: tuple, kernels: dict[int, Callable], function, arguments: list[Value]) -> Value:
    translator, (result, *parameters), workspace = function.translator, signature, arguments[1]
    name = workspace.constant.prefix + name
    if name not in translator.named:
        translator.named.add(name)
        lines = []
        for kind in sorted(kernels):
            own, value = translator.function(
                kernels[kind], [known(BLOCK), workspace, *(Value(type_, text) for text, type_ in parameters)]
            )
            text = f"{own}({', '.join(text for text, _ in parameters)})"
            text = (
                f"{text}; return"
                if result is None
                else f"return {function.converted(Value(value.type, text), result).text}"
            )
            lines.append(f"    if (kind == {kind}) {{ {text}; }}")
        if result is not None:
            zeros = ", ".join("0" if item == INT else "0.0" for item in result.items)
            lines.append(f"    return {translator.glsl_type(result)}({zeros});")
        given = ", ".join(["int kind", *(f"{type_} {text}" for text, type_ in parameters)])
        translator.functions.append(
            "\n".join(
                [f"{'void' if result is None else translator.glsl_type(result)} {name}({given})", "{", *lines, "}"]
            )
        )
    kinds = [INT, *(type_ for _, type_ in parameters)]
    texts = [function.converted(value, type_).text for value, type_ in zip(arguments[2:], kinds, strict=True)]
    return Value(result, f"{name}({', '.join(texts)})")
