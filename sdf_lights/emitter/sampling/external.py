# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A strategy for drawing directions towards lamps that is registered from outside, for comparison with the built-in
ones.

It is compiled separately, only if a scene uses it, and called by its address. So the path tracer is neither larger nor
slower because of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...frozen import frozen
from ...jit import CallablePart, call_part, kernel, table

SAMPLE, DENSITY = range(2)  # slots of the addresses

TABLES = {"external_code": np.dtype(np.int64), "external_rows": np.dtype(np.uint8)}

_code = table("external_code", np.int64)


@frozen
class External:
    """Kernels in world space, whose arguments after the workspace are floats, and their tables.

    ``sample(block, workspace, lamp, x, y, z, u1, u2, u3)`` returns a unit direction from the point (x, y, z).
    ``density(block, workspace, lamp, x, y, z, dx, dy, dz, count)`` returns the density of a direction per solid angle,
    from the ``count`` intervals that ``trace`` left in the workspace. ``pack(built, sources)`` makes the rows of the
    table "external_rows", one for each lamp, and the owner of the memory that they point to.
    """

    sample: Callable
    density: Callable
    pack: Callable[[list, list], tuple[np.ndarray, object]]


class Packed(NamedTuple):
    """Tables of ``TABLES``, and the owner of their memory."""

    tables: dict[str, np.ndarray]
    owner: object = None


NONE = Packed({name: np.zeros(0, dtype) for name, dtype in TABLES.items()})

_registered: list[External] = []


def register(found: External | None) -> None:
    """Register ``found`` for scenes that use an external strategy; None removes it."""
    _registered[:] = [] if found is None else [found]


def registered() -> External | None:
    """The external sampler of renders; None if none is registered."""
    return _registered[0] if _registered else None


def pack_external(found: External, built: list, sources: list, records: tuple) -> Packed:
    """Tables for lamps that were built from ``sources``, for blocks and workspaces of these ``records``."""
    rows, owner = found.pack(built, sources)
    parts = CallablePart(found.sample, (), 7, records), CallablePart(found.density, (), 8, records)
    return Packed(
        {"external_code": np.array([part.address for part in parts]), "external_rows": rows.view(np.uint8)},
        (parts, rows, owner),
    )


@kernel
def sample(block, workspace, lamp, x, u1, u2, u3):
    """Unit direction from x; its density is ``density``."""
    return call_part(_code(block)[SAMPLE], block, workspace, (lamp, x[0], x[1], x[2], u1, u2, u3), 3)


@kernel
def density(block, workspace, lamp, x, d, count):
    """Density per solid angle of ``sample`` giving d, from the intervals that ``trace`` left in the workspace."""
    return call_part(_code(block)[DENSITY], block, workspace, (lamp, x[0], x[1], x[2], d[0], d[1], d[2], count), 1)[0]
