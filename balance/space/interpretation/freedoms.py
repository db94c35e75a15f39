"""Readable bases of inertia transfers and of the parallel part, as primitives.

Any basis of a design space is right, but one of singular vectors moves every parameter of
every body. Here a transfer is written in the frame of its joint, and the parallel part in few
terms.

A point mass on the axis, displacements along and across it, and rods: along the axis, in ±
pairs across it, and oblique to it; or rods in six directions, if that takes fewer terms.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.multipole import NOUNS, Primitive
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
from balance.support.tolerances import (
    AXIS_OFFSET_CLEAR,
    ECHELON_PIVOT,
    GEOMETRY_EQUAL,
)
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Joint
from kinematics.model.plane import plane_axes
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import echelon
from kinematics.numerics.linalg.vectors import distinct_vectors, project_out
from kinematics.wording import repr_lines

NUMBERS = ("no", "a", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
PLURALS = {
    "point mass": "point masses",
    "displacement": "displacements",
    "rod": "rods",
    "± pair": "± pairs",
}


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
        _basis_in_terms(space, transfer, terms) for terms in _joint_frame_terms(space, transfer)
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
    rounded = np.array([round_to_fraction(value) for value in values])
    return np.asarray(rounded * np.sign(rounded[np.flatnonzero(rounded)[0]]))


def _joint_frame_terms(space: DesignSpace, transfer: Transfer) -> Iterator[list[Term]]:
    """Yield ways to decompose the parameters of one body, with as many terms as parameters.

    The body is the first of the transfer. There is a way for each direction in which its
    joints turn or slide, or mass may be displaced.

    Args:
        transfer: one of its transfers.
    """
    body = transfer.bodies[0]
    joints = [space.linkage.joints[j] for j in space.linkage.positions_of(transfer.joints)]
    # Where bodies are rigidly joined, or rest, the frame of the body is used.
    point = joints[0].point if joints else space.frames[space.bodies.index(body)][:3, 3]
    place = " on the axis" if len(joints) == 1 and not space.planar else " at the centre"
    for n in _directions(space, transfer, joints):
        axes = _axes(space, n, point)
        masses = _masses(body, point, axes, place)
        if not joints:
            masses = [term._replace(name=NOUNS[term.primitives[0].kind]) for term in masses]
        if space.balance == "force":
            yield masses
        elif space.planar:
            yield [*masses, Term("rod", (_rod(body, axes[0]),))]
        else:
            yield [*masses, *_six_rods(body, *axes)]
            if joints:
                yield [*masses, *_rods_by_axis(body, *axes)]


def _directions(space: DesignSpace, transfer: Transfer, joints: list[Joint]) -> list[Array]:
    """List unit vectors along the joints and the possible displacements, without repetition.

    In a plane only those in it; its own axes if there is none.
    """
    moved = transfer.basis.reshape(len(space.bodies), len(space.labels), -1)
    count = 2 if space.planar else 3
    moved = moved[space.bodies.index(transfer.bodies[0])]
    free = moved[1 : 1 + count] @ _null_space_of_row(moved[0])
    some = [joint.direction for joint in joints]
    some += list(free.T @ space.axes[:count])
    if space.planar:
        some = [project_out(a, space.axes[2]) for a in some]
    unit = [
        a / size for a in some if (size := np.linalg.norm(a)) > GEOMETRY_EQUAL * space.length
    ]
    first = distinct_vectors(
        unit, lambda few, a: np.linalg.norm(np.cross(few, a), axis=1) <= GEOMETRY_EQUAL
    )
    directions = [unit[k] for k in first]
    return directions or [space.axes[0] if space.planar else space.axes[2]]


def _null_space_of_row(row: Array) -> Array:
    """Compute combinations (n, d) that make a row of numbers (n,) vanish."""
    if not row.any():
        return np.eye(row.size)
    return np.linalg.svd(row[None])[2][1:].T


def _axes(space: DesignSpace, n: Array, point: Array) -> Array:
    """Choose axes as rows: the first along n, the second towards another joint."""
    if space.planar:
        return np.array([n, np.cross(space.axes[2], n)])
    for joint in space.linkage.joints:
        across = np.cross(n, joint.point - point)
        if np.linalg.norm(across) > AXIS_OFFSET_CLEAR * space.length:
            across /= np.linalg.norm(across)
            return np.array([n, np.cross(across, n), across])
    x, y, _ = plane_axes(n)
    return np.array([n, x, y])


def _masses(body: str, point: Array, axes: Array, place: str) -> list[Term]:
    """List the point mass and its displacements."""
    terms = [Term(f"point mass{place}", (Primitive("mass", body, 1.0, point),))]
    for k, a in enumerate(axes):
        name = f"displacement {'across' if k else 'along'} the axis"
        terms.append(Term(name, (Primitive("displacement", body, 1.0, point, a),)))
    return terms


def _rods_by_axis(body: str, n: Array, x: Array, y: Array) -> list[Term]:
    """List six independent terms of rods with the axis n among them."""
    across, oblique = "± pair of rods across the axis", "± pair of rods oblique to the axis"
    return [
        Term("rod along the axis", (_rod(body, n),)),
        Term(across, (_rod(body, x), _rod(body, y, -1.0))),
        Term(across, (_rod(body, x + y), _rod(body, x - y, -1.0))),
        Term("rod across the axis", (_rod(body, x),)),
        Term(oblique, (_rod(body, n + x), _rod(body, n - x, -1.0))),
        Term(oblique, (_rod(body, n + y), _rod(body, n - y, -1.0))),
    ]


def _six_rods(body: str, n: Array, x: Array, y: Array) -> list[Term]:
    """List rods in six directions, with equal names."""
    return [Term("rod", (_rod(body, b),)) for b in (n, x, y, n + x, n + y, x + y)]


def _rod(body: str, b: Array, value: float = 1.0) -> Primitive:
    """Make a rod along b, which may have any length."""
    return Primitive("rod", body, value, None, b / np.linalg.norm(b))
