# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights: one module per kind. All modules of this folder are found automatically.

A module is an ``interfaces.Light``. It names its class of ``scene`` (``LIGHT``) and its table (``TABLE``) with the
record of a light (``RECORD``). ``rows(block)`` is that table.
"""

from __future__ import annotations

import importlib
import pkgutil

from .....jit import dispatched, kernel
from ..records import no_sample

LAMP, WORLD, TRIANGLE, FIRST = range(4)  # kinds of emitters; from FIRST on they are the modules

# ``jit`` counts all modules of this folder as sources.
_MODULES = [importlib.import_module(f".{item.name}", __name__) for item in pkgutil.iter_modules(__path__)]
KINDS = dict(enumerate(_MODULES, FIRST))


def kind_of(light) -> int:
    """The kind of one of ``scene.lights``."""
    return next(kind for kind, module in KINDS.items() if isinstance(light, module.LIGHT))


def _cases(name: str) -> list[dict]:
    """For ``dispatched``: the kinds of lights with this function."""
    return [
        {"NUMBER": kind, "ROWS": module.rows, "CASE": getattr(module, name)}
        for kind, module in KINDS.items()
        if hasattr(module, name)
    ]


NUMBER, ROWS, CASE, REST = -1, None, None, None  # set by ``dispatched``


@kernel(forceinline=True)
def _sample(kind, block, index, x, u1, u2):
    if kind == NUMBER:
        return CASE(ROWS(block)[index], x, u1, u2)
    return REST(kind, block, index, x, u1, u2)


@kernel
def _no_sample(kind, block, index, x, u1, u2):
    return no_sample()


@kernel(forceinline=True)
def _hit(kind, block, index, o, d):
    if kind == NUMBER:
        return CASE(ROWS(block)[index], o, d)
    return REST(kind, block, index, o, d)


@kernel
def _miss(kind, block, index, o, d):
    return -1.0, (0.0, 0.0, 0.0), 0.0


@kernel(forceinline=True)
def _normal(kind, block, index, back):
    if kind == NUMBER:
        return CASE(ROWS(block)[index], back)
    return REST(kind, block, index, back)


@kernel
def _facing(kind, block, index, back):
    return back


@kernel(forceinline=True)
def _leave(kind, block, index, u1, u2, u3, u4):
    if kind == NUMBER:
        return CASE(ROWS(block)[index], u1, u2, u3, u4)
    return REST(kind, block, index, u1, u2, u3, u4)


@kernel
def _stays(kind, block, index, u1, u2, u3, u4):
    return (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0


# For one of Blender's lights, number ``index`` of its kind, as in ``interfaces.Light``.
sample = dispatched(_sample, _cases("sample"), _no_sample)
hit = dispatched(_hit, _cases("hit"), _miss)
normal = dispatched(_normal, _cases("normal"), _facing)
leave = dispatched(_leave, _cases("leave"), _stays)
