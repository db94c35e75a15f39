"""Candidates for relations between inputs: subspaces of displacements, in whole numbers.

A subspace of dimension d of the n free inputs is one of two kinds:

- spanned by d vectors that share no input, ``u_i = (a/b) u_j`` or ``u_i = 0``; for d = 1 this
  is every direction, ``u = (c_1, …, c_n) y``;
- for d = n - 1, one relation of any number of terms, ``Σ c_i u_i = 0``.

All numbers lie between -3 and 3; smaller ones come first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import islice, product
from math import gcd
from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.rational import rational_null_space

Vector = tuple[int, ...]

# Largest whole number in a relation.
LARGEST = 3
# Most candidates of one dimension; all of them for three inputs.
MOST_CANDIDATES = 400


class Candidate(NamedTuple):
    """A subspace of the displacements of inputs.

    Attributes:
        rows: its relations ``rows @ u = 0`` in whole numbers, one tuple each.
        columns: a basis of it.
    """

    rows: tuple[Vector, ...]
    columns: tuple[Vector, ...]

    @property
    def basis(self) -> Array:
        """The basis as columns (inputs, dimension)."""
        return np.array(self.columns, dtype=np.float64).T

    def holds(self, vectors: Array) -> Flags:
        """Decide which of some vectors (count, inputs) of whole numbers lie in it."""
        rows = np.array(self.rows).reshape(-1, vectors.shape[1])
        return ~np.any(vectors @ rows.T, axis=1)

    def words(self, names: Sequence[str]) -> tuple[str, ...]:
        """Write the relations in the words of ``--motion``."""
        return tuple(_relation(row, names) for row in self.rows)


def candidates(inputs: int, dimension: int) -> list[Candidate]:
    """List subspaces of a dimension, those with the smallest numbers first.

    Args:
        inputs: number of free inputs n.
        dimension: of the subspaces, 0 < d < n.

    Returns:
        At most 400 of them.
    """
    one_relation = dimension == inputs - 1 > 1
    subspaces = _one_relation(inputs) if one_relation else _disjoint(inputs, dimension)
    return list(islice(subspaces, MOST_CANDIDATES))


def _primitive(inputs: int, largest: int) -> Iterator[Vector]:
    """Generate directions whose largest number is given, the smallest sums first.

    One after another: 22 inputs have 3²² directions of -1, 0 and 1.
    """
    for total in range(largest, inputs * largest + 1):
        for v in _vectors_of_sum(inputs, total, largest):
            first = next(x for x in v if x)
            if first > 0 and max(map(abs, v)) == largest and gcd(*v) == 1:
                yield v


def _vectors_of_sum(count: int, total: int, largest: int) -> Iterator[Vector]:
    """Generate vectors whose absolute values have a sum, those with large numbers first."""
    if not count:
        yield ()
        return
    for x in range(min(largest, total), -min(largest, total) - 1, -1):
        if total - abs(x) <= (count - 1) * largest:
            for rest in _vectors_of_sum(count - 1, total - abs(x), largest):
                yield (x, *rest)


def count_candidates(inputs: int) -> int:
    """Count the subspaces of all dimensions that are candidates.

    Args:
        inputs: number of free inputs n.
    """
    return sum(len(candidates(inputs, dimension)) for dimension in range(1, inputs))


def _one_relation(inputs: int) -> Iterator[Candidate]:
    """Generate the subspaces that one relation leaves."""
    for largest in range(1, LARGEST + 1):
        for row in _primitive(inputs, largest):
            yield Candidate((row,), _null_space([row], inputs))


def _disjoint(inputs: int, dimension: int) -> Iterator[Candidate]:
    """Generate the subspaces spanned by vectors that share no input."""
    for largest in range(1, LARGEST + 1):
        for values in product(range(largest, -largest - 1, -1), repeat=inputs):
            if max(map(abs, values)) != largest:
                continue
            for groups in _groups([i for i, x in enumerate(values) if x], dimension):
                columns = tuple(
                    tuple(x if i in group else 0 for i, x in enumerate(values))
                    for group in groups
                )
                if all(gcd(*v) == 1 and next(x for x in v if x) > 0 for v in columns):
                    yield Candidate(_relations(columns), columns)


def _groups(items: Sequence[int], count: int) -> Iterator[tuple[frozenset[int], ...]]:
    """Generate the partitions of items into a number of groups."""
    if len(items) < count or not count:
        if not items and not count:
            yield ()
        return
    first, rest = items[0], items[1:]
    for groups in _groups(rest, count - 1):
        yield (frozenset([first]), *groups)
    for groups in _groups(rest, count):
        for k in range(count):
            yield (*groups[:k], groups[k] | {first}, *groups[k + 1 :])


def _relations(columns: Sequence[Vector]) -> tuple[Vector, ...]:
    """Relations of two terms, or one, that a basis of vectors without common inputs obeys."""
    rows = []
    for i in range(len(columns[0])):
        row = [0] * len(columns[0])
        row[i] = 1
        column = next((v for v in columns if v[i]), None)
        if column is not None:
            pivot = min((j for j, x in enumerate(column) if x), key=lambda j: abs(column[j]))
            if i == pivot:
                continue
            share = gcd(column[i], column[pivot])
            row[i], row[pivot] = column[pivot] // share, -column[i] // share
        rows.append(tuple(row))
    return tuple(rows)


def _null_space(rows: Sequence[Vector], inputs: int) -> tuple[Vector, ...]:
    """Whole-number basis of the vectors that some relations leave."""
    basis = []
    for vector in rational_null_space([list(map(Fraction, row)) for row in rows], inputs):
        whole = 1
        for x in vector:
            whole *= x.denominator // gcd(whole, x.denominator)
        basis.append(tuple(int(x * whole) for x in vector))
    return tuple(basis)


def _relation(row: Vector, names: Sequence[str]) -> str:
    """Write ``row @ u = 0``, solved for the input with the smallest number."""
    terms = [i for i, x in enumerate(row) if x]
    first = min(terms, key=lambda i: abs(row[i]))
    sign = -1 if row[first] > 0 else 1
    left = _term(abs(row[first]), names[first])
    right = "".join(
        ("+" if sign * row[i] > 0 else "-") + _term(abs(row[i]), names[i])
        for i in terms
        if i != first
    )
    return f"{left}={right.removeprefix('+') or '0'}" if right else f"{names[first]}=0"


def _term(factor: int, name: str) -> str:
    return name if factor == 1 else f"{factor}*{name}"
