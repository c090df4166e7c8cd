# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All lamps in sequence, as the tables that the kernels read."""

from __future__ import annotations

import numpy as np

from ..lamps import FIELD, LAMP, TABLES
from ..tree.interior import Tree
from .build import BuiltLamp


def pack_lamps(built: list[BuiltLamp]) -> dict[str, np.ndarray]:
    """Tables of ``TABLES`` for lamps in the order given. Lamps of the same shape share all but their rows."""
    rows = np.concatenate([lamp.row for lamp in built] or [np.zeros(0, LAMP)])
    parts = {name: [np.zeros(0, dtype)] for name, dtype in TABLES.items()}
    used = dict.fromkeys(TABLES, 0)
    places: dict[int, tuple] = {}

    def append(name: str, array: np.ndarray) -> int:
        parts[name].append(array)
        used[name] += len(array)
        return used[name] - len(array)

    def place(tree: Tree | None, program: np.ndarray) -> tuple:
        first_instruction = append("lamp_instructions", program)
        if tree is None:
            return first_instruction, len(program), 0, 0, 0, 0
        terms, parameters = tree.arrays
        terms = terms.copy()
        terms["parameters"] += append("lamp_parameters", parameters)
        return (
            first_instruction,
            len(program),
            append("lamp_terms", terms),
            append("lamp_nodes", tree.nodes),
            len(tree.nodes),
            append("lamp_lists", tree.lists),
        )

    for row, lamp in zip(rows, built):
        if lamp.emission is not None:
            glow = lamp.glow.copy()
            glow["parameters"] = append("lamp_parameters", lamp.emission.compiled.parameters)
            row["glow"] = append("lamp_glows", glow)
        key = id(lamp.program if lamp.tree is None else lamp.tree)
        if key not in places:
            places[key] = place(lamp.tree, lamp.program)
        for field, value in zip(
            ("first_instruction", "instruction_count", "first_term", "first_node", "node_count", "first_list"),
            places[key],
        ):
            row[field] = value
    return {**{name: _joined(arrays) for name, arrays in parts.items()}, "lamps": rows}


def _joined(arrays: list[np.ndarray]) -> np.ndarray:
    """The concatenated arrays, beginning at a cache line: a node of a tree takes one line."""
    rows, dtype = sum(map(len, arrays)), arrays[0].dtype
    memory = np.empty(rows * dtype.itemsize + 64, np.uint8)
    start = -memory.ctypes.data % 64
    return np.concatenate(arrays, out=memory[start : start + rows * dtype.itemsize].view(dtype))


def pack_scalars(built: list[BuiltLamp]) -> dict[str, int]:
    """Values of ``SCALARS``."""
    # The walk through a tree solves programs in the rows above the intervals found so far.
    needed = [int(lamp.row["rows"][0]) * (1 if lamp.row["kind"][0] == FIELD else 2) for lamp in built]
    return {"lamp_rows": max(needed, default=1), "region_set": 0}


def new_spans(rows: int, count: int) -> np.ndarray:
    """Scratch for ``trace``, for one thread: ``lamp_rows`` rows of intervals, and a row of lengths for each lamp."""
    return np.zeros((rows + count, 2))
