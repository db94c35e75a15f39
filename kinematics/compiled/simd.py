"""SIMD vectors for `kinematics.compiled.jit`: load, store, broadcast, ``+`` and ``*``.

LLVM vectorises long loops over contiguous arrays. It does not vectorise many short sums side by
side, as in products of polynomials; these are written with the functions of this file. A
*lane* is one of the numbers of a vector. `load_vector` reads a vector from a flat array, ``+``
and ``*`` work on all lanes, `store_vector` writes it back.
`kinematics.compiled.simd_types` compiles them; without a compiler they are slices of NumPy
arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["VECTOR_WIDTH", "load_vector", "round_up_to_vectors", "broadcast", "store_vector"]

Array = NDArray[np.float64]

# Numbers of a vector: two 512-bit registers, so that two independent accumulators hide the
# latency of additions.
VECTOR_WIDTH = 16


def load_vector(array: Array, at: int) -> Array:
    """Read the vector ``array[at : at + VECTOR_WIDTH]`` of a flat array.

    Args:
        array: in; flat (n,).
        at: index of the first number.

    Returns:
        The vector (VECTOR_WIDTH,): a register in compiled code, a view without a compiler.
    """
    return array[at : at + VECTOR_WIDTH]


def store_vector(array: Array, at: int, values: Array) -> None:
    """Write a vector to ``array[at : at + VECTOR_WIDTH]`` of a flat array.

    Args:
        array: out; flat (n,).
        at: index of the first number.
        values: in; the vector (VECTOR_WIDTH,).
    """
    array[at : at + VECTOR_WIDTH] = values


def broadcast(value: float) -> Array:
    """Broadcast one number to all lanes."""
    return np.full(VECTOR_WIDTH, value)


def round_up_to_vectors(count: int) -> int:
    """Round a count of numbers up to a multiple of `VECTOR_WIDTH`."""
    return (count + VECTOR_WIDTH - 1) // VECTOR_WIDTH * VECTOR_WIDTH
