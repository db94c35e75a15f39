"""Readable bases of inertia transfers and of the parallel part, as primitives.

Any basis of a design space is right, but one of singular vectors moves every parameter of
every body. Here a transfer is written in the frame of its joint, and the parallel part in few
terms.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.inertial_parameters.multipole import Primitive
from balance.space.interpretation.joint_frame_terms import joint_frame_terms
from balance.space.interpretation.sparse_basis import SparseSearch
from balance.space.interpretation.terms import (
    Term,
    candidate_terms,
    describe_terms,
    round_to_fraction,
    term_vectors,
)
from balance.space.spaces.design_space import DesignSpace
from balance.space.transfers.by_joint import Transfer
from balance.support.tolerances import ECHELON_PIVOT, FRACTION_ROUND_OFF
from kinematics.model.arrays import freeze
from kinematics.numerics.linalg.rational import echelon
from kinematics.wording import repr_lines

Array = NDArray[np.float64]

NUMBERS = ("no", "a", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
PLURALS = {
    "point mass": "point masses", "displacement": "displacements", "rod": "rods",
    "± pair": "± pairs",
}  # fmt: skip


class Freedom(NamedTuple):
    """One way to change the masses of a linkage that leaves it balanced.

    Attributes:
        primitives: what is added to which body.
        words: the same in words.
        vector: the same in the rows of ``DesignSpace.basis`` (parameters,), SI units.
    """

    primitives: tuple[Primitive, ...]
    words: str
    vector: Array

    def __repr__(self) -> str:
        """One line in words."""
        return repr_lines(f"Freedom: {self.words}")

    def to_dict(self) -> dict[str, object]:
        """Convert words and primitives to plain data, ready for JSON."""
        return {"words": self.words, "primitives": [p.to_dict() for p in self.primitives]}


def _combine(space: DesignSpace, terms: Sequence[Term], words: str) -> Freedom:
    """Combine terms with their values into a freedom."""
    primitives = tuple(p for term in terms for p in term.primitives)
    vector = term_vectors(space, primitives, False).sum(axis=1)
    return Freedom(primitives, words, freeze(vector))


def transfer_freedoms(space: DesignSpace, transfer: Transfer) -> tuple[Freedom, ...]:
    """Express a transfer as primitives in the frame of its joint, one freedom per column.

    A freedom adds to the first of the bodies and takes from the others, or from the ground.
    For a revolute joint whose axis is parallel to those below it these are a point mass on
    the axis, a displacement and a rod along it, and two ± pairs of rods across it.

    Args:
        transfer: one of its transfers.
    """
    if not transfer.dimension:
        return ()
    bases = [
        _basis_in_terms(space, transfer, terms) for terms in joint_frame_terms(space, transfer)
    ]
    # Of equally short bases the last one, which names the axis.
    best = min(reversed(bases), key=_count_primitives)
    return tuple(
        _combine(space, terms, " with a ".join(dict.fromkeys(t.name for t in terms)))
        for terms in best
    )


def _count_primitives(reading: Sequence[Sequence[Term]]) -> int:
    """Count the primitives of a basis."""
    return sum(len(term.primitives) for terms in reading for term in terms)


def _basis_in_terms(
    space: DesignSpace, transfer: Transfer, frame_terms: Sequence[Term]
) -> list[list[Term]]:
    """Compute a basis of a transfer in terms on each body, each vector with its own terms."""
    terms = [term.on(body) for body in transfer.bodies for term in frame_terms]
    D = _columns(space, terms)
    scale = np.linalg.norm(D, axis=0)
    columns = transfer.scaled
    coordinates = np.linalg.lstsq(D / scale, columns / np.linalg.norm(columns, axis=0))[0]
    return [_with_values(terms, _normalise(x / scale)) for x in reduced_echelon(coordinates.T)]


def reduced_echelon(rows: Array) -> Array:
    """Compute the reduced row echelon form of independent rows; round-off becomes zero."""
    A = np.array(echelon(rows.tolist(), _largest_in_column)[0])
    A[np.abs(A) <= ECHELON_PIVOT * np.abs(A).max(axis=1, keepdims=True)] = 0.0
    return A


def _largest_in_column(
    rows: Sequence[Sequence[float]], pivots: Sequence[int]
) -> tuple[int, int] | None:
    """Find the next pivot, or None; entries up to ``ECHELON_PIVOT`` are round-off."""
    first = pivots[-1] + 1 if pivots else 0
    for column in range(first, len(rows[0]) if rows else 0):
        sizes = [abs(row[column]) for row in rows]
        if max(sizes) > ECHELON_PIVOT:
            return sizes.index(max(sizes)), column
    return None


def summarise(freedoms: Sequence[Freedom]) -> str:
    """Describe freedoms in one line, equal ones counted."""
    counts = Counter(freedom.words for freedom in freedoms)
    return ", ".join(_count_phrase(words, n) for words, n in counts.items())


def _count_phrase(words: str, count: int) -> str:
    """Write ``a point mass on the axis``, ``two ± pairs of rods across the axis``."""
    if count == 1:
        return f"a {words}"
    number = NUMBERS[count] if count < len(NUMBERS) else str(count)
    noun = next(noun for noun in PLURALS if words.startswith(noun))
    return f"{number} {PLURALS[noun]}{words[len(noun) :]}"


def parallel_freedoms(space: DesignSpace) -> tuple[Freedom, ...]:
    """Compute a readable basis of the parallel part, one freedom per column of ``parallel``.

    Together with ``serial`` they span the design space. Those of fewer terms come first;
    the values in each are relative to the largest, and the first is positive.
    """
    count = space.basis.shape[1] - space.serial_nullity
    if count == 0:
        return ()
    terms = candidate_terms(space)
    D = _columns(space, terms)
    scale = np.linalg.norm(D, axis=0)
    costs = np.array([term.cost for term in terms])
    search = SparseSearch.of(space.scaled_basis, space.serial_nullity, D / scale, costs)
    return tuple(
        _combine(space, some, describe_terms(some))
        for x in search.independent()
        for some in [_with_values(terms, _normalise(x / scale))]
    )


def _columns(space: DesignSpace, terms: Sequence[Term]) -> Array:
    """Compute the parameters of terms in the units of the chain (parameters, terms)."""
    first = np.cumsum([0, *(len(term.primitives) for term in terms[:-1])])
    D = term_vectors(space, [p for term in terms for p in term.primitives], True)
    return np.add.reduceat(D, first, axis=1)


def _with_values(terms: Sequence[Term], x: Array) -> list[Term]:
    """Multiply the terms by their values, those of value zero left out."""
    return [terms[k].times(float(x[k])) for k in np.flatnonzero(x).tolist()]


def _normalise(values: Array) -> Array:
    """Divide values by the largest, make the first positive, and remove round-off."""
    values = values / np.abs(values).max()
    rounded = np.array([round_to_fraction(value, FRACTION_ROUND_OFF) for value in values])
    return np.asarray(rounded * np.sign(rounded[np.flatnonzero(rounded)[0]]))
