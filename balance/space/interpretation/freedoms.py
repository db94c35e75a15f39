"""Readable bases of inertia transfers and of the parallel part, as primitives.

Any basis of a design space is right, but one of singular vectors moves every parameter of
every body. Here a transfer is written in the frame of its joint, and the parallel part in few
terms.

A point mass on the axis, displacements along and across it, and rods: along the axis, in ±
pairs across it, and oblique to it; or rods in six directions, if that takes fewer terms.

Among all combinations ``z = D x`` that lie in the space, the one with the least ``Σ |x|`` has
few terms (S. S. Chen, D. L. Donoho and M. A. Saunders, 1998). A linear programme finds its
terms, and a singular vector of their columns finds their values, to round-off.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.multipole import NOUNS, Primitive
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
    SOLUTION_OUTSIDE,
    SOLUTIONS_EQUAL,
    TERM_ABSENT,
)
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Joint
from kinematics.model.plane import plane_axes
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import echelon
from kinematics.numerics.linalg.ties import first_largest, rank_least_first
from kinematics.numerics.linalg.vectors import distinct_vectors, project_out
from kinematics.wording import repr_lines

NUMBERS = ("no", "a", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
PLURALS = {
    "point mass": "point masses",
    "displacement": "displacements",
    "rod": "rods",
    "± pair": "± pairs",
}
# Part by which the cost of the last term is raised, so that the optimum is unique: well above
# the accuracy of the linear programme, well below differences that matter.
COST_RISE = 1e-3
GOLDEN_RATIO = 0.5 * (1.0 + 5.0**0.5)
# Most entries of all linear programmes that search for more solutions than needed.
MAX_PROGRAMME_ENTRIES = 300_000


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


class SparseSearch(NamedTuple):
    """Search for sparse x with ``conditions @ x = 0`` and a new part ``shadow @ x``.

    Attributes:
        columns: parameters of the terms, of unit size in the units of the chain.
        conditions: distance of each column from the design space, as a vector.
        shadow: the coordinates of each in the parallel space (p, columns).
        parallel: basis of the parallel space, orthonormal in the units of the chain.
        cost: of each column.
    """

    columns: Array
    conditions: Array
    shadow: Array
    parallel: Array
    cost: Array

    @classmethod
    def of(cls, basis: Array, serial: int, columns: Array, cost: Array) -> SparseSearch:
        """Prepare the search in a design space.

        Args:
            basis: of the space (parameters, nullity).
            serial: number of its columns, the first ones, that are not new.
            columns: parameters of the terms (parameters, columns), in the same units.
            cost: of each column.
        """
        Q = np.linalg.qr(basis, "complete")[0]
        parallel, outside = Q[:, serial : basis.shape[1]], Q[:, basis.shape[1] :]
        return cls(columns, outside.T @ columns, parallel.T @ columns, parallel, cost)

    def independent(self) -> list[Array]:
        """Find one solution for each new dimension; those of few terms come first."""
        pool = self._spanning()
        entries = 2 * self.conditions.size
        for w in self._directions(MAX_PROGRAMME_ENTRIES // entries) if len(pool) > 1 else []:
            other = self.sparse(w)
            pool += [other] if other is not None else []
        ranks = rank_least_first([float(self.cost @ np.abs(x)) for x in pool])
        pool = sorted((pool[k] for k in ranks), key=np.count_nonzero)
        chosen: list[Array] = []
        for x in pool:
            if self._new(chosen, x):
                chosen.append(x)
        return chosen

    def _spanning(self) -> list[Array]:
        """Find columns that are solutions, and then other solutions until they span."""
        vectors: list[Array] = []
        count = len(self.shadow)
        alone = np.linalg.norm(self.conditions, axis=0) <= SOLUTION_OUTSIDE
        alone &= np.linalg.norm(self.shadow, axis=0) > SOLUTIONS_EQUAL
        for k in sorted(np.flatnonzero(alone).tolist(), key=lambda k: self.cost[k]):
            x = np.zeros(alone.size)
            x[k] = 1.0
            if self.balances(x) and self._new(vectors, x):
                vectors.append(x)
        while len(vectors) < count:
            span = _span(self.shadow @ np.array(vectors).T) if vectors else np.empty((count, 0))
            outside = np.linalg.qr(span, "complete")[0][:, span.shape[1] :]
            residual = outside.T @ self.shadow
            gains = np.linalg.norm(residual, axis=0) / self.cost
            w = outside @ residual[:, first_largest(gains)]
            w /= np.linalg.norm(w)
            few = self.sparse(w)
            if few is None or not self._new(vectors, few):
                few = self.dense(w)
            vectors.append(few)
        return vectors

    def _new(self, solutions: list[Array], x: Array) -> bool:
        """Whether a solution has a part that others do not have."""
        return _span(self.shadow @ np.array([*solutions, x]).T).shape[1] > len(solutions)

    def _directions(self, most: int) -> list[Array]:
        """List at most ``most`` directions in which columns are new, cheapest columns first."""
        directions = np.empty((0, len(self.shadow)))
        for k in np.argsort(self.cost, kind="stable"):
            w, size = self.shadow[:, k], np.linalg.norm(self.shadow[:, k])
            if len(directions) < most and size > SOLUTIONS_EQUAL:
                if np.abs(directions @ w).max(initial=0.0) < (1.0 - SOLUTIONS_EQUAL) * size:
                    directions = np.vstack([directions, w / size])
        return list(directions)

    def sparse(self, w: Array) -> Array | None:
        """Find the cheapest x in the space with ``w @ shadow @ x = 1``; None if none is found.

        A linear programme finds its terms, the singular vector of their columns its values.
        Of equally cheap solutions it takes one with early terms.
        """
        from scipy.optimize import linprog

        A = np.vstack([self.conditions, w @ self.shadow])
        b = np.append(np.zeros(len(self.conditions)), 1.0)
        cost = np.tile(self.cost * _distinct_cost_factors(self.cost.size), 2)
        solved = linprog(cost, A_eq=np.hstack([A, -A]), b_eq=b, method="highs-ds")
        if solved.x is None:
            return None
        x = np.subtract(*solved.x.reshape(2, -1))
        support = np.flatnonzero(np.abs(x) > TERM_ABSENT * np.abs(x).max())
        x = np.zeros_like(x)
        x[support] = np.linalg.svd(self.conditions[:, support])[2][-1]
        return x if abs(w @ self.shadow @ x) > SOLUTIONS_EQUAL and self.balances(x) else None

    def dense(self, w: Array) -> Array:
        """Find some x for the direction w of the parallel space, with any number of terms."""
        x: Array = np.linalg.lstsq(self.columns, self.parallel @ w)[0].astype(np.float64)
        return x

    def balances(self, x: Array) -> bool:
        """Decide whether a combination lies in the design space, to round-off."""
        outside = np.linalg.norm(self.conditions @ x)
        return bool(outside <= SOLUTION_OUTSIDE * np.linalg.norm(self.shadow @ x))


def _distinct_cost_factors(count: int) -> Array:
    """Compute factors of costs (count,) that rise a little, so that no two sums are equal.

    The multiples of the golden ratio, modulo 1, make sums of steps differ as well.
    """
    k = np.arange(count, dtype=np.float64)
    return np.asarray(1.0 + COST_RISE * (k + np.mod(k * GOLDEN_RATIO, 1.0)) / (count + 1.0))


def _span(vectors: Array) -> Array:
    """Compute an orthonormal basis of the span of columns (n, m), of any sizes but zero."""
    U, values, _ = np.linalg.svd(vectors / np.linalg.norm(vectors, axis=0))
    return U[:, : np.count_nonzero(values > SOLUTIONS_EQUAL)]
