"""Search for relations between inputs under which some mass distribution balances a linkage.

A relation that balances a subspace of displacements balances every direction in it. Directions
are therefore tried first, and larger subspaces only if none of the directions in them is proved
infeasible; of those, the largest dimension that balances is the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.constraints.relation_candidates import Candidate, candidates
from balance.masses.remedies.request import RemedyRequest
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import LinkageError
from kinematics.model.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InputRelation:
    """A relation between inputs.

    Attributes:
        candidate: the subspace of the free inputs.
        names: the free inputs.
        space: the design space under it.
        verdict: of `balance.masses.feasible` on that space.
    """

    candidate: Candidate
    names: tuple[str, ...]
    space: DesignSpace
    verdict: str

    @property
    def words(self) -> tuple[str, ...]:
        """The relations in the words of ``--motion``."""
        return self.candidate.words(self.names)


@dataclass(frozen=True, eq=False)
class RelationSearch:
    """What a search has found.

    Attributes:
        balanced: relations that leave the most freedoms, those that balance the masses of the
            file first, and then those of the smallest numbers.
        undecided: number of relations without a verdict.
        tried: number of relations that were tried, or excluded by one that was.
    """

    balanced: tuple[InputRelation, ...]
    undecided: int
    tried: int


class _Trial(NamedTuple):
    """What became of a candidate; the spaces of those that fail are not kept.

    Attributes:
        verdict: of `balance.masses.feasible`, or ``"blocked"`` if the linkage cannot follow it.
        relation: the relation, if it balances.
    """

    verdict: str
    relation: InputRelation | None = None


def free_inputs(request: RemedyRequest) -> tuple[tuple[str, ...], Array]:
    """Choose the inputs that the relations of a request leave free.

    Returns:
        Their names, and the displacements of all inputs for a unit one of each
        (inputs, free inputs).
    """
    linkage = request.linkage
    motion = Motion.parse(request.motion, linkage.inputs)
    columns = [int(np.flatnonzero(row)[0]) if np.count_nonzero(row) == 1 and row.max() == 1.0
               else -1 for row in motion.basis]  # fmt: skip
    rows = [columns.index(k) for k in range(motion.basis.shape[1])]
    return tuple(linkage.inputs[row] for row in rows), motion.basis


def search_relations(request: RemedyRequest) -> RelationSearch:
    """Search for relations under which masses can balance a linkage.

    Args:
        request: the request; its progress is called with the directions done and all of them.

    Returns:
        The relations of the largest remaining mobility.
    """
    names, basis = free_inputs(request)
    lines = candidates(len(names), 1)
    tried = [_try(request, names, basis, line, (k, len(lines))) for k, line in enumerate(lines)]
    proved = np.array([case.verdict in ("infeasible", "blocked") for case in tried])
    vectors = np.array([line.columns[0] for line in lines])
    count, undecided = len(lines), _undecided(tried)
    for dimension in range(len(names) - 1, 1, -1):
        wide = candidates(len(names), dimension)
        open_ones = [case for case in wide if not case.holds(vectors[proved]).any()]
        trials = [_try(request, names, basis, case) for case in open_ones]
        count, undecided = count + len(wide), undecided + _undecided(trials)
        if balanced := _balanced(trials):
            return RelationSearch(balanced, undecided, count)
    return RelationSearch(_balanced(tried), undecided, count)


def _try(
    request: RemedyRequest, names: tuple[str, ...], basis: Array, candidate: Candidate,
    step: tuple[int, int] | None = None,
) -> _Trial:  # fmt: skip
    """Decide whether a relation balances."""
    motion = Motion(request.linkage.inputs, (), basis @ candidate.basis)
    try:
        space = design_space(request.linkage, motion, request.balance, spatial=request.spatial)
    except LinkageError:
        return _Trial("blocked")
    finally:
        if step is not None and request.progress is not None:
            request.progress(step[0] + 1, step[1])
    verdict = feasible(space).verdict
    if verdict != "feasible":
        return _Trial(verdict)
    return _Trial(verdict, InputRelation(candidate, names, space, verdict))


def _undecided(trials: Sequence[_Trial]) -> int:
    return sum(trial.verdict == "undecided" for trial in trials)


def _balanced(trials: Sequence[_Trial]) -> tuple[InputRelation, ...]:
    """Relations that balance, those that need no change of masses first."""
    good = [case.relation for case in trials if case.relation is not None]
    return tuple(sorted(good, key=lambda case: not case.space.as_given.balanced))
