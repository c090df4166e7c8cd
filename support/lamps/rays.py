# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Interior trees of shapes, and the walk of many rays through them, without a lamp."""

from __future__ import annotations

import numpy as np

from sdf_lights.emitter.intersection import fields
from sdf_lights.emitter.intersection.intervals import regularize, rows_needed
from sdf_lights.emitter.lamps import SMALLEST_INTERVAL
from sdf_lights.emitter.tree import crossings, interior, nodes
from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.sdf.program import INSTRUCTION
from sdf_lights.sdf.shapes.base import Shape
from support.rivals import marching

BLOCK = block_dtype({**fields.TABLES, **nodes.TABLES, "lamp_instructions": INSTRUCTION})
ROW = np.dtype(
    [
        ("first_node", np.int64),
        ("first_list", np.int64),
        ("first_term", np.int64),
        ("first_instruction", np.int64),
        ("instruction_count", np.int64),
        ("rows", np.int64),
        ("low", np.float64, (3,)),
        ("high", np.float64, (3,)),
    ],
    align=True,
)
ROWS = 256  # intervals of a ray at most


class Traced:
    """The tree of a shape as tables; rays are in the shape's local space."""

    def __init__(self, shape: Shape, rows: int = ROWS):
        self.shape = shape
        self.tree = tree = interior.tree(shape)
        terms, parameters = np.zeros(0, fields.TERM), np.zeros(0)
        if tree.field is not None:
            terms, parameters = tree.field.terms, tree.field.parameters
        self.tables = dict(
            lamp_terms=terms,
            lamp_parameters=parameters,
            lamp_lists=tree.lists,
            lamp_nodes=tree.nodes,
            lamp_instructions=tree.program,
        )
        self.blocks, self.rows = np.zeros(1, BLOCK), np.zeros(1, ROW)
        for name, table in self.tables.items():
            fill_table(self.blocks, name, np.ascontiguousarray(table))
        self.rows["instruction_count"], self.rows["rows"] = len(tree.program), rows
        self.rows["low"], self.rows["high"] = -tree.half, tree.half
        scratch = rows_needed(tree.program)[0] if len(tree.program) else 0
        self.spans = np.empty((rows + scratch, 2))

    def segments(self, origins, directions):
        """Rays (n, 3), (n, 3) in tree space, from their closest approach to its origin, and (n, 2) their range in the
        box, at t ≥ 0 of the given ray."""
        origins = origins - self.tree.center
        closest = -(origins * directions).sum(axis=1) / (directions * directions).sum(axis=1)
        origins = origins + closest[:, None] * directions
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.sort([(corner - origins) / directions for corner in (-self.tree.half, self.tree.half)], axis=0)
        ends = np.where(np.isnan(ends), [[[-np.inf]], [[np.inf]]], ends)  # along a face: inside
        return origins, directions, np.stack([np.maximum(ends[0].max(axis=1), -closest), ends[1].min(axis=1)], axis=1)

    def trace(self, origins, directions):
        """(n, 4): number of intervals, their length, the length unresolved, and the evaluations of each ray."""
        out = np.zeros((len(origins), 4))
        smallest = SMALLEST_INTERVAL * np.linalg.norm(self.tree.half)
        _trace(self.blocks, self.rows, *self.segments(origins, directions), smallest, self.spans, out)
        return out

    def march(self, rule, origins, directions, least=1e-3, lipschitz=None):
        """(n, 3): number of intervals, their length, and the evaluations of each ray; ``lipschitz`` is the shape's."""
        out = np.zeros((len(origins), 3))
        _march(
            self.blocks,
            self.rows,
            len(self.tree.field.terms),
            rule,
            lipschitz or self.shape.lipschitz,
            least,
            *self.segments(origins, directions),
            out,
        )
        return out

    def intervals(self, o, d):
        """(count, 2) intervals of one ray, t ≥ 0, whose direction has unit length."""
        o, d = np.array([o], float), np.array([d], float)
        out = self.trace(o, d)
        return self.spans[: int(out[0, 0])] - ((o - self.tree.center) * d).sum()


@kernel
def _trace(blocks, rows, origins, directions, segments, smallest, spans, out):
    block, row = blocks[0], rows[0]
    for ray in range(len(origins)):
        o = (origins[ray, 0], origins[ray, 1], origins[ray, 2])
        d = (directions[ray, 0], directions[ray, 1], directions[ray, 2])
        if segments[ray, 0] < segments[ray, 1]:
            count, unresolved, evaluations = crossings.walk(block, row, o, d, segments[ray, 0], segments[ray, 1], spans)
            count = regularize(spans, count, smallest)
            out[ray, 0], out[ray, 2], out[ray, 3] = count, unresolved, evaluations
            for k in range(count):
                out[ray, 1] += spans[k, 1] - spans[k, 0]


@kernel
def _march(blocks, rows, count, rule, lipschitz, least, origins, directions, segments, out):
    marching.march(blocks[0], rows[0], count, rule, lipschitz, least, origins, directions, segments, out)
