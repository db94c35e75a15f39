"""Random rounding of floating-point functions: Monte Carlo arithmetic at their boundary.

A library for linear algebra adds in an order of its own, fuses multiplications with additions
on one processor and not on another, and has elementary functions with errors of its own. Its
result is that of exact arithmetic for data changed in their last bits. The functions of this
file draw such results at random:

- Sums of products (``@``, ``np.dot``, ``np.einsum``): the terms are added in random order, and
  each product that a double does not hold exactly changes by up to half a unit in its last
  place, as a fused multiplication changes it. So a sum that cancels leaves another round-off,
  and a sum of products of short numbers, which every processor computes exactly, stays.
- Linear algebra (``np.linalg``, ``scipy.linalg``): each entry of the matrix other than zero
  changes by up to one unit in its last place (backward stability), unless each row and column
  has one entry at most, in which case all processors agree.
- Norms and elementary functions (sine, exponential), and what compiled kernels return or write:
  the last bit of the result changes, unless 26 bits hold it, or it is the norm of such numbers
  or of a single one.

Square roots, sums and elementwise arithmetic are rounded correctly, in an order that NumPy
fixes, on all processors: they stay. Integers are computed exactly, as floats too, and stay.

Sources: D. S. Parker, Monte Carlo arithmetic, UCLA CSD-970002 (1997). J. Vignes, Discrete
stochastic arithmetic for validating results of numerical software, Numerical Algorithms 37
(2004), of which CADNA is the library. F. Févotte, B. Lathuilière, VERROU: a CESTAC evaluation
without recompilation, SCAN (2016).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import Any
from zlib import crc32

import numpy as np

# Half a unit in the last place of 1.
HALF_UNIT = 2.0**-53
# Bits of the mantissa of a double, and those after its leading 26: a product of two numbers
# without the latter is exact.
MANTISSA, LONG = np.uint64(2**52 - 1), np.uint64(2**27 - 1)
# Odd factors that mix bits (those of SplitMix64).
FACTORS = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0xD1B54A32D192ED03], np.uint64)


class RandomRounding:
    """Random numbers that are functions of a seed and of the numbers to round.

    A processor gives one result for one input: so do these, and equal numbers stay equal.
    """

    def __init__(self) -> None:
        """Begin without perturbation."""
        self.seed: int | None = None

    def bits(self, values: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
        """Draw 64 bits for each number by its mantissa, and for each place if any are given.

        Args:
            values: contiguous doubles.
            places: indices of the same shape.
        """
        drawn = values.view(np.uint64) & MANTISSA
        if places is not None:
            drawn += places * FACTORS[2]
        drawn += FACTORS[:1] * np.uint64(self.seed + 1)
        for factor in FACTORS[:2]:
            drawn *= factor
            drawn ^= drawn >> np.uint64(29)
        return drawn * FACTORS[0]

    def units(self, values: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
        """Draw -1, 0, 0 or 1 for each number."""
        quarter = self.bits(values, places) >> np.uint64(62)
        return ((quarter.view(np.int64) + 1) >> 1) - 1

    def chooses(self, name: str, count: int) -> bool:
        """Whether the seed is one of those, one in ``count``, that choose a name."""
        return (self.seed + crc32(name.encode())) % count == 0

    def order(self, count: int) -> np.ndarray:
        """Draw a permutation."""
        return _order(self.seed, count)


@cache
def _order(seed: int, count: int) -> np.ndarray:
    """Draw the permutation of a seed."""
    return np.random.default_rng([seed, count]).permutation(count)


rounding = RandomRounding()


def perturb_last_bits(values: Any) -> Any:
    """Change floats by -1, 0 or 1 units in the last place; those of up to 26 bits stay."""
    if isinstance(values, tuple):
        items = [perturb_last_bits(value) for value in values]
        return type(values)(*items) if hasattr(values, "_fields") else tuple(items)
    if isinstance(values, np.ndarray):
        if values.dtype not in (np.float64, np.complex128) or values.size == 0:
            return values
        numbers = np.ascontiguousarray(values).view(np.float64)
        whole = numbers.view(np.int64)
        # The bits of doubles of one sign are in the order of their size.
        moved = whole + rounding.units(numbers) * _long(numbers)
        return moved.view(values.dtype).reshape(values.shape)
    if isinstance(values, float | complex):  # also np.float64 and np.complex128
        return type(values)(perturb_last_bits(np.array([values]))[0])
    return values


def _long(values: np.ndarray) -> np.ndarray:
    """Which doubles have more than 26 significant bits; infinities and NaNs have not."""
    return (values.view(np.uint64) & LONG) != 0


def _is_real(*arrays: Any) -> bool:
    """Whether all arguments are arrays of doubles with entries, that are not all integers."""
    return all(
        isinstance(a, np.ndarray) and a.dtype == np.float64 and a.size > 0 for a in arrays
    ) and not all((a == np.rint(a)).all() for a in arrays)


def _products_error(product: Callable[..., Any], *factors: np.ndarray) -> Any:
    """Sum the magnitudes of the products that are not exact.

    They are those of numbers other than powers of two, unless both are short.
    """
    factors = tuple(map(np.ascontiguousarray, factors))
    inexact = [np.abs(x) * ((x.view(np.uint64) & MANTISSA) != 0) for x in factors]
    total = product(*inexact)
    long = [_long(x) for x in factors]
    if len(factors) > 2 or any(where.all() for where in long):
        return total
    return total - product(*(x * ~where for x, where in zip(inexact, long, strict=True)))


def _matmul(plain: Callable[..., Any], a: Any, b: Any, **options: Any) -> Any:
    """``a @ b`` with terms in random order, and products rounded at random."""
    if not _is_real(a, b) or a.shape[-1] == 1:
        return plain(a, b, **options)
    order = rounding.order(a.shape[-1])
    result = plain(a[..., order], b[order] if b.ndim == 1 else b[..., order, :])
    return _written(_add_noise(result, _products_error(plain, a, b)), options)


def _add_noise(result: Any, error: Any) -> Any:
    """Change sums of products by a random part of the error of their products."""
    values = np.ascontiguousarray(np.atleast_1d(result))
    fractions = rounding.bits(values) * 2.0**-63 - 1.0
    changed = values + (HALF_UNIT * error) * np.copysign(1.0, values) * fractions
    return changed[0] if np.ndim(result) == 0 else changed


def _einsum(plain: Callable[..., Any], *operands: Any, **options: Any) -> Any:
    """``np.einsum`` with products rounded at random, and summed axes in random order."""
    words, *arrays = operands
    if not isinstance(words, str) or len(arrays) < 2 or not _is_real(*arrays):
        return plain(*operands, **options)
    result = plain(words, *_shuffled(words, arrays), **options)
    error = _products_error(lambda *factors: plain(words, *factors), *arrays)
    return _written(_add_noise(result, error), options)


def _written(result: Any, options: dict[str, Any]) -> Any:
    """The result, written to the array of the option ``out`` if there is one."""
    if "out" not in options:
        return result
    options["out"][...] = result
    return options["out"]


def _shuffled(words: str, arrays: list[np.ndarray]) -> list[np.ndarray]:
    """Arrays with each axis that is summed over in random order, one for all of them."""
    inputs, _, output = words.replace(" ", "").partition("->")
    if "->" not in words:
        return arrays
    axes = [
        _axes(labels, array.ndim)
        for labels, array in zip(inputs.split(","), arrays, strict=True)
    ]
    for label in sorted(set(inputs) - set(output) - set(",.")):
        lengths = {
            array.shape[k]
            for where, array in zip(axes, arrays, strict=True)
            for k in where.get(label, ())
        }
        if lengths == {1} or len(lengths) > 1:
            continue
        order = rounding.order(lengths.pop())
        for i, where in enumerate(axes):
            for k in where.get(label, ()):
                arrays[i] = np.take(arrays[i], order, axis=k)
    return arrays


def _axes(labels: str, dimensions: int) -> dict[str, list[int]]:
    """The axes of each label of an operand of ``np.einsum``."""
    head, dots, tail = labels.partition("...")
    axes: dict[str, list[int]] = {}
    for k, label in enumerate(head):
        axes.setdefault(label, []).append(k)
    for k, label in enumerate(reversed(tail)):
        axes.setdefault(label, []).append(dimensions - 1 - k)
    return axes


def _summing(plain: Callable[..., Any], a: Any, b: Any, *rest: Any, **options: Any) -> Any:
    """Another product of two arrays, with products rounded at random."""
    result = plain(a, b, *rest, **options)
    if not _is_real(a, b):
        return result
    error = _products_error(lambda x, y: plain(x, y, *rest, **options), a, b)
    return _add_noise(result, error)


def _shake(matrix: Any) -> Any:
    """A matrix with entries changed in their last bit; one with single entries stays."""
    values = np.asarray(matrix)
    if values.dtype not in (np.float64, np.complex128) or values.ndim < 2 or values.size == 0:
        return matrix
    there = values != 0.0
    if there.sum(axis=-1).max() <= 1 and there.sum(axis=-2).max() <= 1:
        return matrix
    parts = np.ascontiguousarray(values).view(np.float64)
    places = np.arange(parts.size, dtype=np.uint64).reshape(parts.shape)
    moved = parts.view(np.int64) + rounding.units(parts, places) * (parts != 0.0)
    return moved.view(values.dtype)


def _decomposition(plain: Callable[..., Any], matrix: Any, *others: Any, **options: Any) -> Any:
    """A function of a matrix, whose entries are rounded at random first."""
    return plain(_shake(matrix), *others, **options)


def _norm(plain: Callable[..., Any], x: Any, *rest: Any, **options: Any) -> Any:
    """``np.linalg.norm``, changed in its last bit, unless it is of short numbers or of one."""
    result = plain(x, *rest, **options)
    values = np.asarray(x)
    if values.dtype != np.float64 or values.size == 0:
        return result
    axis = options.get("axis", rest[1] if len(rest) > 1 else None)
    keep = options.get("keepdims", False)
    exact = ~_long(np.ascontiguousarray(values)).any(axis=axis, keepdims=keep)
    exact |= np.count_nonzero(values, axis=axis, keepdims=keep) <= 1
    if np.ndim(result) == 0:
        return result if exact else perturb_last_bits(result)
    return np.where(exact, result, perturb_last_bits(result))


def _elementary(plain: Callable[..., Any], *values: Any, **options: Any) -> Any:
    """A function of numbers, the last bits of its result changed."""
    return _written(perturb_last_bits(plain(*values, **options)), options)


MODELS = {
    _matmul: "np.matmul np.dot operator.matmul",
    _einsum: "np.einsum",
    _summing: "np.tensordot",
    _norm: "np.linalg.norm",
    _decomposition: (
        "np.linalg.svd np.linalg.solve np.linalg.inv np.linalg.lstsq np.linalg.qr "
        "np.linalg.eigvalsh np.linalg.eigh np.linalg.eig np.linalg.eigvals np.linalg.det "
        "np.linalg.slogdet np.linalg.pinv np.linalg.matrix_rank np.linalg.cholesky "
        "np.linalg.cond scipy.linalg.eigh scipy.linalg.svd scipy.linalg.expm "
        "scipy.linalg.null_space"
    ),
    _elementary: (
        "np.sin np.cos np.tan np.arcsin np.arccos np.arctan np.arctan2 np.sinh np.cosh "
        "np.tanh np.exp np.expm1 np.log np.log1p np.log2 np.log10 np.hypot np.roots "
        "math.sin math.cos math.tan math.asin math.acos math.atan math.atan2 math.exp "
        "math.log math.log10 math.hypot"
    ),
}
# The model of every function that is perturbed, by the name that sources call it by.
PERTURBED = {name: model for model, names in MODELS.items() for name in names.split()}


def perturbed(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    """A function that rounds its results at random while `rounding` has a seed.

    Args:
        name: one of `PERTURBED`.
        plain: the function itself.
    """
    model = PERTURBED[name]

    @wraps(plain)
    def function(*arguments: Any, **options: Any) -> Any:
        if rounding.seed is None:
            return plain(*arguments, **options)
        return model(plain, *arguments, **options)

    return function
