# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""LLVM's code of formulas, for ``codegen_native``, which says what it does.

This module imports LLVM, which takes 45 MB, so it is imported only to compile.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import llvmlite.binding as llvm
from llvmlite import ir

from ..kernel_code import FASTMATH, base_processor
from . import vector_math
from .formula import (
    CALL,
    CONSTANT,
    ITERATE,
    PARAMETER,
    RESULT,
    STATE,
    VARIABLE,
    Formula,
    axis_of,
    body,
    order,
)
from .functions import Function
from .native_names import LANES, SYMBOL, Place, library_symbol, part_symbol
from .operations import OPERATIONS, Native

_DOUBLE, _INDEX = ir.DoubleType(), ir.IntType(64)
_LANES, _MASK = ir.VectorType(_DOUBLE, LANES), ir.VectorType(ir.IntType(1), LANES)
_TRUE = ir.Constant(ir.IntType(1), 1)
_FIRST = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
_POINTER = _DOUBLE.as_pointer()
_FUNCTION = ir.FunctionType(ir.VoidType(), [_INDEX, _POINTER, _POINTER, _POINTER])
_FLAGS = tuple(FASTMATH)


def _declared(module: ir.Module, name: str, result, operands) -> ir.Function:
    known = module.globals.get(name)
    return known or ir.Function(module, ir.FunctionType(result, [o.type for o in operands]), name)


def _each_lane(name: str, builder, operands):
    """The library's function, called for one lane after the other."""
    vector = ir.Constant(_LANES, ir.Undefined)
    for lane in range(LANES):
        scalars = [builder.extract_element(o, _INDEX(lane)) for o in operands]
        function = _declared(builder.module, library_symbol(name), _DOUBLE, scalars)
        vector = builder.insert_element(vector, builder.call(function, scalars), _INDEX(lane))
    return vector


def _vector_function(module: ir.Module, name: str, arity: int) -> ir.Function:
    """A function of ``LANES`` numbers: by ``vector_math`` if that is valid for all of them, else by the library."""
    function = ir.Function(module, ir.FunctionType(_LANES, [_LANES] * arity), f"lanes_{name}")
    function.linkage = "internal"
    entry, fast, slow = (function.append_basic_block(block) for block in ("entry", "fast", "slow"))
    builder = ir.IRBuilder(entry)
    value, holds = vector_math.FUNCTIONS[name](*(vector_math.Number(builder, o) for o in function.args))
    builder.cbranch(_any(builder, builder.not_(holds.value)), slow, fast)
    builder.position_at_end(fast)
    builder.ret(value.value)
    builder.position_at_end(slow)
    builder.ret(_each_lane(name, builder, function.args))
    return function


def _library(name: str):
    def emit(builder, *operands):
        if operands[0].type == _DOUBLE:
            return builder.call(_declared(builder.module, library_symbol(name), _DOUBLE, operands), operands)
        if name not in vector_math.FUNCTIONS:
            return _each_lane(name, builder, operands)
        known = builder.module.globals.get(f"lanes_{name}")
        return builder.call(known or _vector_function(builder.module, name, len(operands)), operands)

    return emit


def _instruction(name: str):
    """Emits a function that LLVM has built in."""

    def emit(builder, operand):
        suffix = "f64" if operand.type == _DOUBLE else f"v{LANES}f64"
        return builder.call(_declared(builder.module, f"llvm.{name}.{suffix}", operand.type, [operand]), [operand])

    return emit


def _comparison(symbol: str):
    return lambda builder, a, b: builder.fcmp_ordered(symbol, a, b)


def _choice(symbol: str):
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(symbol, a, b), a, b)


def _arithmetic(name: str):
    return lambda builder, *operands: getattr(builder, name)(*operands, flags=_FLAGS)


def _selection(unused: str):
    return lambda builder, condition, then, otherwise: builder.select(condition, then, otherwise)


_WAYS = {
    Native.ARITHMETIC: _arithmetic,
    Native.INTRINSIC: _instruction,
    Native.LIBRARY: _library,
    Native.COMPARISON: _comparison,
    Native.CHOICE: _choice,
    Native.SELECT: _selection,
}
_EMIT = {kind: _WAYS[operation.native[0]](operation.native[1]) for kind, operation in OPERATIONS.items()}


def _spread(builder: ir.IRBuilder, value):
    """One value in every lane."""
    kind = ir.VectorType(value.type, LANES)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INDEX(0))
    return builder.shuffle_vector(first, first, _FIRST)


def _rounds(builder: ir.IRBuilder, count, limit: int):
    """Number of iterations of a loop from the value of its count, as ``numpy_evaluation.rounds``."""
    low, high = ir.Constant(_DOUBLE, 0.0), ir.Constant(_DOUBLE, float(limit))
    count = builder.select(builder.fcmp_ordered(">", count, low), count, low)  # not ordered: NaN
    return builder.fptosi(builder.select(builder.fcmp_ordered("<", count, high), count, high), _INDEX)


def _any(builder: ir.IRBuilder, mask):
    """Whether the condition holds in any lane."""
    if not isinstance(mask.type, ir.VectorType):
        return mask
    bits = builder.bitcast(mask, ir.IntType(LANES))
    return builder.icmp_unsigned("!=", bits, bits.type(0))


class _Scope:
    """Values computed for the whole formula, or in one iteration of a loop.

    ``values`` holds one double or ``LANES`` of them for each node (for a loop, a list of these). Those of an
    iteration are valid only inside it.
    """

    def __init__(self, builder: ir.IRBuilder, outside: "_Lanes | _Surface", parameters, values: dict, spread: dict):
        self.builder, self.outside, self.parameters = builder, outside, parameters
        self.values, self.spread = values, spread

    def lanes(self, node: Formula):
        """Value of the node in every lane."""
        value = self.values[node]
        if isinstance(value.type, ir.VectorType):
            return value
        if node.kind == CONSTANT:
            return ir.Constant(_LANES, [node.value] * LANES)
        if node not in self.spread:
            self.spread[node] = _spread(self.builder, value)
        return self.spread[node]

    def emit(self, nodes: list[Formula], mask=None) -> None:
        """Instructions for ``nodes``, operands first. Values of lanes outside ``mask`` do not matter."""
        for node in nodes:
            if node not in self.values:
                self.values[node] = self._emitted(node, mask)

    def _emitted(self, node: Formula, mask):
        if node.kind == CONSTANT:
            return ir.Constant(_DOUBLE, node.value)
        if node.kind == VARIABLE:
            return self.outside.variable(self.builder, node)
        if node.kind == PARAMETER:
            return self.builder.load(self.builder.gep(self.parameters, [_INDEX(node.value)]))
        if node.kind == RESULT:
            return self.values[node.operands[0]][node.value]
        if node.kind == CALL:
            return self.outside.call(self.builder, node.value, [self.values[operand] for operand in node.operands])
        scalar = not any(isinstance(self.values[operand].type, ir.VectorType) for operand in node.operands)
        if node.kind == ITERATE:
            return self._loop(node, scalar, mask)
        operands = [self.values[operand] if scalar else self.lanes(operand) for operand in node.operands]
        return _EMIT[node.kind](self.builder, *operands)

    def _loop(self, node: Formula, scalar: bool, mask) -> list:
        """States after the loop of an ``ITERATE`` node; ``scalar`` if they are the same in every lane."""
        builder, loop = self.builder, node.value
        count, initial = node.operands[0], node.operands[1 : 1 + len(loop.steps)]
        captures = node.operands[1 + len(loop.steps) :]
        read = self.values.get if scalar else self.lanes
        first = [read(state) for state in initial]
        inner = _Scope(
            builder,
            self.outside,
            self.parameters,
            {c: self.values[c] for c in captures},
            {} if scalar else {c: self.lanes(c) for c in captures},
        )
        if scalar:
            mask = None  # the loop runs as long as one lane needs it
        if loop.going is not None and mask is None:
            mask = _TRUE if scalar else ir.Constant(_MASK, [_TRUE] * LANES)
        rounds = _rounds(builder, self.values[count], loop.limit)
        before = builder.block
        head, check, step, done = (builder.append_basic_block() for _ in range(4))
        builder.branch(head)

        builder.position_at_end(head)
        index = builder.phi(_INDEX)
        states = [builder.phi(value.type) for value in first]
        entered = builder.phi(mask.type) if loop.going is not None else mask
        builder.cbranch(builder.icmp_signed("<", index, rounds), check, done)

        builder.position_at_end(check)
        nodes = body(node)
        inner.values |= {n: states[n.value[1]] for n in nodes if n.kind == STATE and n.value[0] == loop.level}
        going = entered
        if loop.going is not None:
            inner.emit(order(loop.going, known=set(captures)), entered)
            condition = inner.values[loop.going]
            going = builder.and_(entered, condition if scalar else inner.lanes(loop.going))
            builder.cbranch(_any(builder, going), step, done)
        else:
            builder.branch(step)

        builder.position_at_end(step)
        inner.emit(nodes, going)
        following = [inner.values[s] if scalar else inner.lanes(s) for s in loop.steps]
        if loop.going is not None:
            following = [builder.select(going, new, old) for new, old in zip(following, states)]
        next_index = builder.add(index, _INDEX(1))
        incoming = [(index, _INDEX(0), next_index), *zip(states, first, following)]
        if loop.going is not None:
            incoming.append((entered, mask, going))
        for phi, at_first, later in incoming:
            phi.add_incoming(at_first, before)
            phi.add_incoming(later, builder.block)
        builder.branch(head)

        builder.position_at_end(done)
        return states


def _is_wide(value: ir.Value) -> bool:
    return isinstance(value.type, ir.VectorType)


class _Lanes(NamedTuple):
    """Reads coordinates of ``LANES`` points: in ``points`` (3, stride), from the column ``first`` on, n in all."""

    points: ir.Value
    n: ir.Value
    stride: ir.Value
    first: ir.Value

    def variable(self, builder: ir.IRBuilder, node: Formula):
        index = builder.add(builder.mul(self.stride, _INDEX(axis_of(node))), self.first)
        return builder.load(builder.bitcast(builder.gep(self.points, [index]), _LANES.as_pointer()), align=8)

    def call(self, builder: ir.IRBuilder, function: Function, operands: list):
        """The function called for one point after the other, with each result placed in its lane."""
        with builder.goto_entry_block():
            given = builder.alloca(_DOUBLE, max(len(operands), 1))
            results = builder.alloca(_DOUBLE, function.results)
            wide = {index: builder.alloca(_LANES) for index, operand in enumerate(operands) if _is_wide(operand)}
            found = [builder.alloca(_LANES) for _ in range(function.results)]
        symbol = part_symbol(function, len(operands))
        known = builder.module.globals.get(symbol) or ir.Function(builder.module, _CALLED, symbol)
        for index, operand in enumerate(operands):
            builder.store(operand, wide.get(index) or builder.gep(given, [_INDEX(index)]))
        for vector in found:
            builder.store(ir.Constant(_LANES, [0.0] * LANES), vector)

        def lane_of(vector):
            return builder.gep(builder.bitcast(vector, _DOUBLE.as_pointer()), [lane])

        left = builder.sub(self.n, self.first)
        count = builder.select(builder.icmp_signed("<", left, _INDEX(LANES)), left, _INDEX(LANES))
        before, one, done = builder.block, *(builder.append_basic_block() for _ in range(2))
        builder.branch(one)
        builder.position_at_end(one)
        lane = builder.phi(_INDEX)
        lane.add_incoming(_INDEX(0), before)
        for index, vector in wide.items():
            builder.store(builder.load(lane_of(vector)), builder.gep(given, [_INDEX(index)]))
        builder.call(known, [_INDEX(0), _INDEX(0), *(builder.ptrtoint(at, _INDEX) for at in (given, results))])
        for index, vector in enumerate(found):
            builder.store(builder.load(builder.gep(results, [_INDEX(index)])), lane_of(vector))
        following = builder.add(lane, _INDEX(1))
        lane.add_incoming(following, one)
        builder.cbranch(builder.icmp_signed("<", following, count), one, done)
        builder.position_at_end(done)
        return [builder.load(vector) for vector in found]


class _Surface(NamedTuple):
    """Reads the variables of one point of a surface, and calls functions from there."""

    block: ir.Value
    workspace: ir.Value
    surface: ir.Value
    places: Mapping[str, Place]
    symbol_of: Callable[[Function, int], str]

    def variable(self, builder: ir.IRBuilder, node: Formula):
        name, component = node.value
        offset, dtype = self.places[name]
        size = 8 if dtype == "f8" else 4
        address = builder.add(self.surface, _INDEX(offset + size * component))
        kind = _DOUBLE if dtype == "f8" else ir.IntType(32)
        value = builder.load(builder.inttoptr(address, kind.as_pointer()))
        return value if dtype == "f8" else builder.sitofp(value, _DOUBLE)

    def call(self, builder: ir.IRBuilder, function: Function, operands: list) -> list:
        count = max(len(operands), 1)
        with builder.goto_entry_block():
            given = builder.alloca(_DOUBLE, count)
            results = builder.alloca(_DOUBLE, function.results)
        for index, operand in enumerate(operands):
            builder.store(operand, builder.gep(given, [_INDEX(index)]))
        symbol = self.symbol_of(function, len(operands))
        known = builder.module.globals.get(symbol) or ir.Function(builder.module, _CALLED, symbol)
        builder.call(
            known,
            [self.block, self.workspace, builder.ptrtoint(given, _INDEX), builder.ptrtoint(results, _INDEX)],
        )
        return [builder.load(builder.gep(results, [_INDEX(index)])) for index in range(function.results)]


_CALLED = ir.FunctionType(ir.VoidType(), [_INDEX] * 4)


def surface_module(formulas: tuple[Formula, ...], places: Mapping[str, Place], symbol_of) -> ir.Module:
    """The module of ``codegen_native.compiled_at_surface``."""
    module = ir.Module()
    module.triple = llvm.get_process_triple()
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [_INDEX] * 3 + [_POINTER] * 2), SYMBOL)
    block, workspace, surface, parameters, values = function.args
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    body_block = function.append_basic_block("body")
    builder.position_at_end(body_block)
    scope = _Scope(builder, _Surface(block, workspace, surface, places, symbol_of), parameters, {}, {})
    scope.emit(order(*formulas))
    for index, formula in enumerate(formulas):
        builder.store(scope.values[formula], builder.gep(values, [_INDEX(index)]))
    builder.ret_void()
    builder.position_at_end(function.entry_basic_block)
    builder.branch(body_block)
    return module


BLOCK = 2048  # operations
LARGE = 8 * BLOCK  # from this number of operations on, compile time matters more than the speed of the code


def module(formulas: tuple[Formula, ...]) -> ir.Module:
    """The module of ``codegen_native.compiled``."""
    module = ir.Module()
    module.triple = llvm.get_process_triple()
    function = ir.Function(module, _FUNCTION, SYMBOL)
    n, points, parameters, values = function.args
    entry, points_left, done = (function.append_basic_block(name) for name in ("entry", "points", "done"))

    builder = ir.IRBuilder(entry)
    stride = builder.and_(builder.add(n, _INDEX(LANES - 1)), _INDEX(-LANES))
    builder.cbranch(builder.icmp_signed(">", n, _INDEX(0)), points_left, done)

    builder.position_at_end(points_left)
    first = builder.phi(_INDEX)

    def lanes_at(array, index):
        return builder.bitcast(builder.gep(array, [index]), _LANES.as_pointer())

    scope = _Scope(builder, _Lanes(points, n, stride, first), parameters, {}, {})
    nodes = order(*formulas)
    for start in range(0, len(nodes), BLOCK):
        if start:
            # LLVM takes quadratic time for a long block, and joins blocks unless a condition is between them.
            after = builder.append_basic_block()
            builder.cbranch(builder.icmp_signed(">", n, first), after, done)
            builder.position_at_end(after)
        scope.emit(nodes[start : start + BLOCK])
    for index, formula in enumerate(formulas):
        place = builder.add(builder.mul(stride, _INDEX(index)), first)
        builder.store(scope.lanes(formula), lanes_at(values, place), align=8)
    following = builder.add(first, _INDEX(LANES))
    first.add_incoming(_INDEX(0), entry)
    first.add_incoming(following, builder.block)
    builder.cbranch(builder.icmp_signed("<", following, n), points_left, done)

    builder.position_at_end(done)
    builder.ret_void()
    return module


def object_code(made: ir.Module, operations: int) -> bytes:
    """The object file of a module for this many operations."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    base = base_processor()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(
        opt=2 if operations < LARGE else 1,
        codemodel="jitdefault",
        jit=True,
        cpu=base or llvm.get_host_cpu_name(),
        features="" if base else llvm.get_host_cpu_features().flatten(),
    )
    return machine.emit_object(llvm.parse_assembly(str(made)))
