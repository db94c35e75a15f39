"""Several numbers at a time: the vectors of the processor, for `kinematics.compiled.jit`.

LLVM makes vectors of long loops over contiguous arrays. Where many short sums stand side by
side, as in products of polynomials, it does not, and they are written with these functions:
`load` takes so many numbers out of a flat array, ``+`` and ``*`` work on all of them, `store`
puts them back. Without a compiler they are slices of NumPy arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LANES", "load", "padded", "spread", "store"]

Array = NDArray[np.float64]

# Two vectors of the widest kind: their sums do not wait for each other.
LANES = 16


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
