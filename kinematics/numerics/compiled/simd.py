"""SIMD vectors for `kinematics.numerics.compiled.jit`: load, store, broadcast and arithmetic.

LLVM vectorises long loops over contiguous arrays. It does not vectorise many short sums side by
side, as in products of polynomials; these are written with the functions of this file. A
*lane* is one of the numbers of a vector. `load_vector` reads a vector from a flat array, and
`load_broadcast` one number into all lanes; ``+``, ``-``, ``*``, ``/``, `square_root`,
`quarter_turn` and `choose_greater` work on all lanes; `store_vector` writes it back. Work on
many geometries has one geometry in each lane. `in_rows` gives a flat array rows.
`kinematics.numerics.compiled.simd_types` compiles them; without a compiler they are slices of
NumPy arrays.
"""

from __future__ import annotations

import numpy as np

from kinematics.numerics.array_types import Array

# Numbers of a vector: two 512-bit registers, so that two independent accumulators hide the
# latency of additions.
VECTOR_WIDTH = 16
# Bytes of a line of the cache.
CACHE_LINE = 64


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


def load_broadcast(array: Array, at: int) -> Array:
    """Read one number of a flat array into all lanes; compiled code takes no negative index.

    ``broadcast(array[at])`` would first ask for the sign of the index.

    Args:
        array: in; flat (n,).
        at: index of the number, not negative.
    """
    return np.full(VECTOR_WIDTH, array[at])


def in_rows(array: Array, columns: int) -> Array:
    """View a flat array as rows (…, columns), of which it has a whole number.

    ``reshape`` does the same; in compiled code it is a call that takes as long as thirty
    multiplications.
    """
    return array.reshape(array.size // max(columns, 1), columns)


def square_root(x: Array) -> Array:
    """Compute the square root of each lane."""
    return np.sqrt(x)


def quarter_turn(x: Array) -> Array:
    """Turn vectors of the plane by a right angle: lanes (x, y) become (-y, x)."""
    pairs = x.reshape(-1, 2)
    return np.stack([-pairs[:, 1], pairs[:, 0]], axis=1).ravel()


def choose_greater(a: Array, b: Array, x: Array, y: Array) -> Array:
    """Choose x in the lanes where a exceeds b, and y in the others, also where one is NaN.

    Args:
        a: in; the vector that is compared.
        b: in; the one that it is compared with.
        x: in; numbers of the lanes where ``a > b``.
        y: in; those of the others.
    """
    return np.where(a > b, x, y)


def round_up_to_vectors(count: int) -> int:
    """Round a count of numbers up to a multiple of `VECTOR_WIDTH`."""
    return (count + VECTOR_WIDTH - 1) // VECTOR_WIDTH * VECTOR_WIDTH


def lanes(*shape: int) -> Array:
    """Make zeros whose last axis is that of the lanes, from a line of the cache on.

    Args:
        shape: length of each axis but the last.

    Returns:
        Shape (*shape, VECTOR_WIDTH).
    """
    whole = (*shape, VECTOR_WIDTH)
    return aligned_zeros(int(np.prod(whole))).reshape(whole)


def aligned_zeros(size: int) -> Array:
    """Make a flat array of zeros from a line of the cache on.

    Vectors that straddle lines take twice as long to load; NumPy aligns arrays to 16 bytes.
    """
    numbers = np.zeros(size + CACHE_LINE // 8)
    skipped = -(numbers.ctypes.data // 8) % (CACHE_LINE // 8)
    return numbers[skipped : skipped + size]
