"""Several numbers at a time: the vectors of the processor, for `kinematics.kernels`.

LLVM makes vectors of long loops over contiguous arrays. Where many short sums stand side by
side, as in products of polynomials, it does not, and they are written with these functions:
`load` takes so many numbers out of a flat array, ``+`` and ``*`` work on all of them, `store`
puts them back. Without a compiler they are slices of NumPy arrays.
"""

from __future__ import annotations

import operator

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model
from numpy.typing import NDArray

__all__ = ["LANES", "load", "padded", "spread", "store"]

Array = NDArray[np.float64]

# Two vectors of the widest kind: their sums do not wait for each other.
LANES = 16
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)


def load(array: Array, at: int) -> Array:
    """The numbers ``array[at : at + LANES]`` of a flat array."""
    return array[at : at + LANES]


def store(array: Array, at: int, values: Array) -> None:
    """Put numbers where `load` takes them from."""
    array[at : at + LANES] = values


def spread(value: float) -> Array:
    """One number on all lanes."""
    return np.full(LANES, value)


def padded(count: int) -> int:
    """The number of lanes that hold so many numbers: a multiple of `LANES`."""
    return -(-count // LANES) * LANES


class _Lanes(types.Type):
    """The type of what `load` returns, in compiled code."""


_lanes = _Lanes("lanes")


@register_model(_Lanes)
class _Model(models.PrimitiveModel):
    """It is a vector register, or several."""

    def __init__(self, manager: object, lanes: object) -> None:
        """Of LLVM's own type."""
        super().__init__(manager, lanes, _VECTOR)


def _arithmetic(operation: object, instruction: str) -> None:
    """Let an operator of Python be an instruction of LLVM on lanes."""

    @infer_global(operation)
    class Signature(AbstractTemplate):
        """Lanes and lanes give lanes."""

        def generic(self, args: tuple, kws: dict) -> object:
            """The signature, or None for other arguments."""
            return signature(_lanes, *args) if args == (_lanes, _lanes) else None

    @lower_builtin(operation, _lanes, _lanes)
    def lower(context, builder, sig, args):
        return getattr(builder, instruction)(*args, flags=("contract",))


_arithmetic(operator.add, "fadd")
_arithmetic(operator.mul, "fmul")


def _place(context, builder, kind, array, at):
    """Pointer to the lanes that begin at an element of a flat array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [at]), _VECTOR.as_pointer())


@intrinsic
def _load(typing, array, at):
    def generate(context, builder, sig, args):
        found = builder.load(_place(context, builder, sig.args[0], *args))
        found.align = 8
        return found

    return _lanes(array, types.intp), generate


@intrinsic
def _store(typing, array, at, values):
    def generate(context, builder, sig, args):
        place = _place(context, builder, sig.args[0], *args[:2])
        builder.store(args[2], place).align = 8
        return context.get_dummy_value()

    return types.void(array, types.intp, values), generate


@intrinsic
def _spread(typing, value):
    def generate(context, builder, sig, args):
        none = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(none, args[0], ir.Constant(ir.IntType(32), 0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(first, none, zeros)

    return _lanes(types.float64), generate


@overload(load)
def _(array, at):
    return lambda array, at: _load(array, at)


@overload(store)
def _(array, at, values):
    return lambda array, at, values: _store(array, at, values)


@overload(spread)
def _(value):
    return lambda value: _spread(value)
