"""The compiled form of `kinematics.numerics.compiled.simd`: vector registers."""

from __future__ import annotations

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    choose_greater,
    in_rows,
    load_broadcast,
    load_vector,
    quarter_turn,
    square_root,
    store_vector,
)

_VECTOR = ir.VectorType(ir.DoubleType(), VECTOR_WIDTH)


class _VectorType(types.Type):
    """The type of a vector in compiled code, as `load_vector` returns it."""


_vector_type = _VectorType("lanes")


@register_model(_VectorType)
class _VectorModel(models.PrimitiveModel):
    """Its representation: a vector register, or several."""

    def __init__(self, manager: object, lanes: object) -> None:
        """Represent the type by LLVM's vector type."""
        super().__init__(manager, lanes, _VECTOR)


def _register_operator(operation: object, instruction: str) -> None:
    """Compile an operator of Python on vectors to an instruction of LLVM."""

    @infer_global(operation)
    class Signature(AbstractTemplate):
        """The operator on two vectors gives a vector."""

        def generic(self, args: tuple, kws: dict) -> object:
            """Return the signature, or None for other arguments."""
            return (
                signature(_vector_type, *args) if args == (_vector_type, _vector_type) else None
            )

    @lower_builtin(operation, _vector_type, _vector_type)
    def lower(context, builder, sig, args):
        return getattr(builder, instruction)(*args, flags=("contract",))


_register_operator(operator.add, "fadd")
_register_operator(operator.mul, "fmul")
_register_operator(operator.sub, "fsub")
_register_operator(operator.truediv, "fdiv")


def _vector_pointer(context, builder, kind, array, at):
    """Compute the pointer to the vector that begins at an element of a flat array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [at]), _VECTOR.as_pointer())


@intrinsic
def _load(typing, array, at):
    def generate(context, builder, sig, args):
        vector = builder.load(_vector_pointer(context, builder, sig.args[0], *args))
        vector.align = 8
        return vector

    return _vector_type(array, types.intp), generate


@intrinsic
def _store(typing, array, at, values):
    def generate(context, builder, sig, args):
        place = _vector_pointer(context, builder, sig.args[0], *args[:2])
        builder.store(args[2], place).align = 8
        return context.get_dummy_value()

    return types.void(array, types.intp, values), generate


def _in_all_lanes(builder, number):
    """Build a vector of one number."""
    none = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(none, number, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), VECTOR_WIDTH), [0] * VECTOR_WIDTH)
    return builder.shuffle_vector(first, none, zeros)


@intrinsic
def _broadcast(typing, value):
    def generate(context, builder, sig, args):
        return _in_all_lanes(builder, args[0])

    return _vector_type(types.float64), generate


@intrinsic
def _load_broadcast(typing, array, at):
    def generate(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        return _in_all_lanes(builder, builder.load(builder.gep(data, [args[1]])))

    return _vector_type(array, types.intp), generate


@infer_global(in_rows)
class _InRows(AbstractTemplate):
    """A flat array and a number give an array of two axes.

    An overload would be a function that returns an array, which kernels that count no
    references may not call.
    """

    def generic(self, args: tuple, kws: dict) -> object:
        """Return the signature, or None for other arguments."""
        array, columns = args
        flat = isinstance(array, types.Array) and (array.ndim, array.layout) == (1, "C")
        return signature(array.copy(ndim=2), array, types.intp) if flat else None


@lower_builtin(in_rows, types.Array, types.intp)
def _in_rows(context, builder, sig, args):
    # An array of Numba: who owns it (2), entries, bytes of one, data, shape and strides.
    flat, count = args
    entries, size = (builder.extract_value(flat, part) for part in (2, 3))
    rows = ir.Constant(context.get_value_type(sig.return_type), ir.Undefined)
    for part in range(5):
        rows = builder.insert_value(rows, builder.extract_value(flat, part), part)
    divisor = builder.select(
        builder.icmp_unsigned("==", count, count.type(0)), count.type(1), count
    )
    pairs = (builder.udiv(entries, divisor), count), (builder.mul(count, size), size)
    for part, pair in enumerate(pairs, 5):
        for axis, length in enumerate(pair):
            rows = builder.insert_value(rows, length, (part, axis))
    return impl_ret_borrowed(context, builder, sig.return_type, rows)


@intrinsic
def _root(typing, x):
    def generate(context, builder, sig, args):
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        name = f"llvm.sqrt.v{VECTOR_WIDTH}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), args)

    return _vector_type(x), generate


@intrinsic
def _quarter_turn(typing, x):
    def generate(context, builder, sig, args):
        # Lane i of the shuffled vector is entry places[i] of both, one after the other.
        places = [i + 1 if i % 2 == 0 else VECTOR_WIDTH + i - 1 for i in range(VECTOR_WIDTH)]
        mask = ir.Constant(ir.VectorType(ir.IntType(32), VECTOR_WIDTH), places)
        return builder.shuffle_vector(builder.fneg(args[0]), args[0], mask)

    return _vector_type(x), generate


@intrinsic
def _choose(typing, a, b, x, y):
    def generate(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(">", *args[:2]), *args[2:])

    return _vector_type(a, b, x, y), generate


@overload(load_vector)
def _(array, at):
    return lambda array, at: _load(array, at)


@overload(store_vector)
def _(array, at, values):
    return lambda array, at, values: _store(array, at, values)


@overload(broadcast)
def _(value):
    return lambda value: _broadcast(value)


@overload(load_broadcast)
def _(array, at):
    return lambda array, at: _load_broadcast(array, at)


@overload(square_root)
def _(x):
    return lambda x: _root(x)


@overload(quarter_turn)
def _(x):
    return lambda x: _quarter_turn(x)


@overload(choose_greater)
def _(a, b, x, y):
    return lambda a, b, x, y: _choose(a, b, x, y)
