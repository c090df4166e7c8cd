# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs of materials as GLSL; replaces ``kernels.shading.operands.run``, which calls machine code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import codegen_glsl
from ...graph.formula import Formula
from ...graph.functions import Function
from ..kernels.shading.material_records import NO_GRAPH
from ..kernels.shading.records import SURFACE, VARIABLE_FIELDS
from .translate import BLOCK, FLOAT, INT, Native, Translator, Tuple, Value, known
from .translate.values import CONSTANT, safe_name


class GraphSource:
    """Writes the graphs that a program runs. ``native`` represents the kernel that runs them. ``volumes``: which of
    them are those of volumes alone; a workspace in which others run has no code for these, and the other way round."""

    def __init__(self, structures: Sequence[tuple[Formula, ...]], volumes: frozenset[int] = frozenset()):
        self._structures, self._volumes = structures, volumes
        self._scopes: dict[str, object] = {}  # prefix of a workspace's names -> that workspace
        self._run: dict[str, set[int]] = {}  # and the graphs that run there

    @property
    def native(self) -> Native:
        """The GLSL for a call of the kernel that runs a graph."""

        def call(function, arguments):
            _, workspace, graph, slots = arguments
            scope = workspace.constant
            self._scopes[scope.prefix] = scope
            everything = frozenset(range(len(self._structures)))
            called = everything if graph.possible is None else graph.possible & everything
            for group in (self._volumes, everything - self._volumes):
                if called & group:
                    self._run.setdefault(scope.prefix, set()).update(group)
            texts = [function.converted(value, INT).text for value in (graph, slots)]
            return Value(None, f"{scope.prefix}run_graph({', '.join(texts)})")

        return Native(call)

    def registers(self) -> int:
        """Length of the array of registers."""
        # At least four: the translator reads an array of three floats as a vector.
        return max(4, *map(len, self._structures), 0)

    def declarations(self) -> str:
        """GLSL prototypes of the functions that ``source`` defines."""
        return "\n".join(f"void {prefix}run_graph(int graph, int slots);" for prefix in self._scopes)

    def source(self, translator: Translator) -> str:
        """The declared functions; the kernels that they call are added to the translator's."""
        parts, helpers = [], set()
        for prefix, scope in list(self._scopes.items()):
            cases = []
            for index in sorted(self._run.get(scope.prefix, ())):
                structure = self._structures[index]
                lines, used = self._body(translator, scope, structure)
                helpers |= used
                parts.append("\n".join([f"void {prefix}graph_{index}(int slots)", "{", *lines, "}"]))
                cases.append(f"    case {index}: {prefix}graph_{index}(slots); break;")
            parts.append(
                "\n".join(
                    [f"void {prefix}run_graph(int graph, int slots)", "{", "    switch (graph) {", *cases, "    }", "}"]
                )
            )
        return "\n".join([*codegen_glsl.helpers("graph", helpers), *parts])

    def _body(self, translator: Translator, scope, structure) -> tuple[list[str], set[str]]:
        constants = translator.tables.table("constants", None, known(BLOCK))
        slot = f"{constants.type.reader}float_at({constants.text} + slots + {{}})"

        def variable(node: Formula) -> str:
            name, component = node.value
            field = VARIABLE_FIELDS[name]
            text = f"{scope.prefix}surface_row.{safe_name(field)}"
            dtype = SURFACE.fields[field][0]
            text = f"{text}[{component}]" if dtype.shape else text
            return text if dtype.base.kind == "f" else f"float({text})"

        def call(function: Function, operands: list[str], declare) -> list[str]:
            arguments = [known(BLOCK), known(scope)] if function.scene else []
            given = [*map(known, function.static), *(Value(FLOAT, text) for text in operands)]
            name, result = translator.function(function.kernel, arguments + given)
            if result.type == CONSTANT:
                values = result.constant if isinstance(result.constant, tuple) else (result.constant,)
                return [codegen_glsl.literal(float(value)) for value in values]
            texts = [*map(str, function.static), *operands]
            local = declare(translator.glsl_type(result.type), f"{name}({', '.join(texts)})")
            if not isinstance(result.type, Tuple):
                return [local if result.type == FLOAT else f"float({local})"]
            if result.type.vector:
                return [f"{local}[{index}]" for index in range(function.results)]
            return [f"float({local}.v{index})" for index in range(function.results)]

        lines, values, helpers = codegen_glsl.statements(structure, "graph", slot, variable, call)
        stores = [f"    {scope.prefix}registers_rows[{index}] = {value};" for index, value in enumerate(values)]
        return lines + stores, helpers


def graphs_of_volumes(tables: dict[str, np.ndarray]) -> frozenset[int]:
    """Numbers of the graphs that only volumes have, of the tables of ``shading.pack_materials``."""
    materials, emissions = tables["materials"], tables["emissions"]
    others = [materials["graph"], materials["shadow_graph"], emissions["graph"], emissions["aov_graph"]]
    return frozenset(tables["volumes"]["graph"].tolist()) - frozenset(np.concatenate(others).tolist()) - {NO_GRAPH}
