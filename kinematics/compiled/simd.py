"""SIMD vectors for `kinematics.compiled.jit`: load, store, broadcast, ``+`` and ``*``.

LLVM vectorises long loops over contiguous arrays. It does not vectorise many short sums side by
side, as in products of polynomials; these are written with the functions of this file. A
*lane* is one of the numbers of a vector. `load` reads a vector from a flat array, ``+`` and
``*`` work on all lanes, `store` writes it back. `kinematics.compiled.simd_types` compiles them;
without a compiler they are slices of NumPy arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LANES", "load", "padded", "spread", "store"]

Array = NDArray[np.float64]

# Numbers of a vector: two 512-bit registers, so that two independent accumulators hide the
# latency of additions.
LANES = 16


def load(array: Array, at: int) -> Array:
    """Read the vector ``array[at : at + LANES]`` of a flat array."""
    return array[at : at + LANES]


def store(array: Array, at: int, values: Array) -> None:
    """Write a vector to ``array[at : at + LANES]`` of a flat array."""
    array[at : at + LANES] = values


def spread(value: float) -> Array:
    """Broadcast one number to all lanes."""
    return np.full(LANES, value)


def padded(count: int) -> int:
    """Round a count of numbers up to a multiple of `LANES`."""
    return (count + LANES - 1) // LANES * LANES
