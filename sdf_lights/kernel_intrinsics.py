# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Code that kernels call and that Numba does not have: memory by address, functions by address, bits of numbers.

``jit`` declares it for kernels. This module imports Numba, so it is imported only to compile.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numba.np.numpy_support import from_dtype


def type_of(made):
    """Numba's type of an intrinsic that a function made, perhaps while Numba compiles."""
    cpu_target.typing_context.refresh()
    return cpu_target.typing_context.resolve_value_type(made)


def _caller(kinds):
    """Intrinsic that calls a C function without a result at an address; ``kinds`` are the types of its
    arguments."""
    signature = types.void(*[types.int64] * (1 + len(kinds)))

    def codegen(context, builder, signature, arguments):
        function = builder.inttoptr(arguments[0], ir.FunctionType(ir.VoidType(), kinds).as_pointer())
        builder.call(
            function,
            [
                builder.inttoptr(value, kind) if isinstance(kind, ir.PointerType) else value
                for kind, value in zip(kinds, arguments[1:])
            ],
        )
        return context.get_dummy_value()

    return lambda typingctx, *arguments: (signature, codegen)


@intrinsic
def call_address3(typingctx, address, a, b, c):
    """Call the C function ``void f(void*, void*, void*)`` at an address; all arguments are integers."""
    return _caller([cgutils.voidptr_t] * 3)(typingctx)


@intrinsic
def call_address4(typingctx, address, a, b, c, d):
    """As ``call_address3``, with four arguments."""
    return _caller([cgutils.voidptr_t] * 4)(typingctx)


@intrinsic
def call_field(typingctx, address, count, points, parameters, values):
    """Call a compiled formula (see ``graph.codegen_native.Compiled``) at an address; all arguments are integers."""
    return _caller([ir.IntType(64)] + [cgutils.voidptr_t] * 3)(typingctx)


@intrinsic
def call_surface_code(typingctx, address, block, workspace, surface, parameters, values):
    """Call code of ``graph.codegen_native.compiled_at_surface`` at an address; all arguments are integers."""
    return _caller([ir.IntType(64)] * 3 + [cgutils.voidptr_t] * 2)(typingctx)


@intrinsic(prefer_literal=True)
def call_part(typingctx, address, block, workspace, given, count):
    """Call a ``CallablePart`` at an address, for a block and a workspace, with a tuple of numbers. Returns a tuple
    of a literal ``count`` of results."""
    kind = types.UniTuple(types.float64, count.literal_value)

    def codegen(context, builder, signature, arguments):
        word, double = ir.IntType(64), ir.DoubleType()
        numbers = cgutils.alloca_once(builder, double, size=ir.Constant(word, max(len(given), 1)))
        results = cgutils.alloca_once(builder, double, size=ir.Constant(word, count.literal_value))
        for index, number in enumerate(given):
            value = context.cast(builder, builder.extract_value(arguments[3], index), number, types.float64)
            builder.store(value, builder.gep(numbers, [ir.Constant(word, index)]))
        function = builder.inttoptr(arguments[0], ir.FunctionType(ir.VoidType(), [word] * 4).as_pointer())
        builder.call(function, [builder.ptrtoint(pointer, word) for pointer in (*arguments[1:3], numbers, results)])
        return context.make_tuple(
            builder,
            kind,
            [builder.load(builder.gep(results, [ir.Constant(word, index)])) for index in range(count.literal_value)],
        )

    return kind(address, block, workspace, given, count), codegen


@intrinsic
def address_of_record(typingctx, record):
    """Address of a record, as an integer."""

    def codegen(context, builder, signature, arguments):
        return builder.ptrtoint(arguments[0], context.get_value_type(types.int64))

    return types.int64(record), codegen


def record_at(dtype):
    """Intrinsic that returns the record of ``dtype`` at an address."""
    record = from_dtype(np.dtype(dtype))

    @intrinsic
    def view(typingctx, address):
        def codegen(context, builder, signature, arguments):
            return builder.inttoptr(arguments[0], context.get_value_type(record))

        return record(address), codegen

    return view


def array_at(dtype, count: int):
    """Intrinsic that returns the 1-D array of ``count`` numbers of ``dtype`` at an address, which may be a
    float."""
    array_type = types.Array(from_dtype(np.dtype(dtype)), 1, "C")
    itemsize = np.dtype(dtype).itemsize

    @intrinsic
    def view(typingctx, address):
        """The numbers at an address."""

        def codegen(context, builder, signature, arguments):
            array = context.make_array(array_type)(context, builder)
            place = context.cast(builder, arguments[0], signature.args[0], types.int64)
            data = builder.inttoptr(place, context.get_data_type(array_type.dtype).as_pointer())
            size = context.get_constant(types.intp, itemsize)
            shape = [context.get_constant(types.intp, count)]
            populate_array(array, data=data, shape=shape, strides=[size], itemsize=size, meminfo=None)
            return array._getvalue()

        return array_type(address), codegen

    return view


@intrinsic(prefer_literal=True)
def load_numbers(typingctx, address, count):
    """A tuple of a literal ``count`` of doubles at an address."""
    kind = types.UniTuple(types.float64, count.literal_value)

    def codegen(context, builder, signature, arguments):
        start = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        return context.make_tuple(
            builder,
            kind,
            [
                builder.load(builder.gep(start, [ir.Constant(ir.IntType(64), index)]))
                for index in range(count.literal_value)
            ],
        )

    return kind(types.int64, count), codegen


@intrinsic
def store_numbers(typingctx, address, numbers):
    """Write a number, or each of a tuple, as doubles at an address."""
    kinds = list(numbers) if isinstance(numbers, types.BaseTuple) else [numbers]

    def codegen(context, builder, signature, arguments):
        start = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        for index, kind in enumerate(kinds):
            number = arguments[1]
            if isinstance(numbers, types.BaseTuple):
                number = builder.extract_value(number, index)
            number = context.cast(builder, number, kind, types.float64)
            builder.store(number, builder.gep(start, [ir.Constant(ir.IntType(64), index)]))
        return context.get_dummy_value()

    return types.void(address, numbers), codegen


@intrinsic
def call_numbers(typingctx, address, operands, results):
    """Call a ``CallablePart`` that needs no records; all arguments are integers."""
    signature, codegen = _caller([ir.IntType(64)] * 4)(typingctx)

    def without_records(context, builder, _, arguments):
        nothing = ir.Constant(ir.IntType(64), 0)
        return codegen(context, builder, signature, (arguments[0], nothing, nothing, *arguments[1:]))

    return types.void(*[types.int64] * 3), without_records


@intrinsic
def float_of_bits(typingctx, bits):
    """The double with the bits of an integer."""

    def codegen(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), codegen


@intrinsic
def float_bits(typingctx, number):
    """The bits of a number in single precision, as uint32."""

    def codegen(context, builder, signature, arguments):
        return builder.bitcast(builder.fptrunc(arguments[0], ir.FloatType()), ir.IntType(32))

    return types.uint32(types.float64), codegen


@intrinsic(prefer_literal=True)
def stack_array(typingctx, count):
    """Uninitialised float64 array of a literal ``count`` elements on the stack, valid until the function
    returns."""
    array_type = types.Array(types.float64, 1, "C")
    size = count.literal_value

    def codegen(context, builder, signature, arguments):
        array = context.make_array(array_type)(context, builder)
        element = context.get_data_type(types.float64)
        data = cgutils.alloca_once(builder, element, size=ir.Constant(ir.IntType(64), size))
        data.align = 64
        itemsize = context.get_constant(types.intp, 8)
        populate_array(
            array,
            data=data,
            shape=[context.get_constant(types.intp, size)],
            strides=[itemsize],
            itemsize=itemsize,
            meminfo=None,
        )
        return array._getvalue()

    return array_type(count), codegen


def table(name: str, dtype, columns: int = 0):
    """Intrinsic that returns the array of ``jit.table``."""

    def read(context, builder, signature, arguments, field):
        block_type = signature.args[0]
        getter = context.get_getattr(block_type, field)
        return getter(context, builder, block_type, arguments[0], field)

    @intrinsic
    def view(typingctx, block):
        # An intrinsic, because a compiled function for each table would cost a tenth of all compile time.
        array_type = types.Array(from_dtype(np.dtype(dtype)), 2 if columns else 1, "C")

        def codegen(context, builder, signature, arguments):
            address = read(context, builder, signature, arguments, name + "_address")
            count = read(context, builder, signature, arguments, name + "_count")
            array = context.make_array(array_type)(context, builder)
            element = context.get_data_type(array_type.dtype)
            data = builder.inttoptr(address, element.as_pointer())
            size = context.get_constant(types.intp, context.get_abi_sizeof(element))
            shape, strides = [count], [size]
            if columns:
                width = context.get_constant(types.intp, columns)
                shape, strides = [builder.udiv(count, width), width], [builder.mul(size, width), size]
            populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
            return array._getvalue()

        return array_type(block), codegen

    return view
