# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a material at one point of a surface: the code of its formulas fills registers, from which operands are
read."""

import numpy as np

from ....jit import address_of_record, call_surface_code, kernel, table
from ....replaced import replaced_on_gpu
from ....vec import dot, normalize, vec
from .material_records import NONE
from .records import surface_table

_constants = table("constants", np.float64)
_addresses = table("graph_addresses", np.int64)
_registers = table("registers", np.float64)


@kernel
def number(block, workspace, operand):
    """Value of an operand: a register or a constant."""
    return _registers(workspace)[operand] if operand >= 0 else _constants(block)[~operand]


@kernel
def vector(block, workspace, operand):
    """Value of an operand of three slots."""
    if operand >= 0:
        registers = _registers(workspace)
        return (registers[operand], registers[operand + 1], registers[operand + 2])
    constants, i = _constants(block), ~operand
    return (constants[i], constants[i + 1], constants[i + 2])


@kernel(forceinline=True)  # see ``camera_ray``
def normal(block, workspace, operand):
    """The unit normal of an input; the shading normal if there is none or it vanishes."""
    n = vec(surface_table(workspace)[0].n)
    if operand == NONE:
        return n
    given = normalize(vector(block, workspace, operand))
    square = dot(given, given)
    return given if 0.5 < square < 2.0 else n


@replaced_on_gpu
@kernel
def run(block, workspace, graph, slots):
    """Fill the registers with the code of a graph, whose parameters begin at ``slots`` among the constants."""
    call_surface_code(
        _addresses(block)[graph],
        address_of_record(block),
        address_of_record(workspace),
        workspace.surface_address,
        block.constants_address + 8 * slots,
        workspace.registers_address,
    )
