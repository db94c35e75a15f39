"""Remedy: a relation between inputs, under which the linkage balances with fewer freedoms.

A relation that balances a subspace of displacements balances every direction in it. Directions
are therefore tried first, and larger subspaces only if none of the directions in them is proved
infeasible; of those, the largest dimension that balances is the answer.

The moment of inertia of a body about the normal of the plane enters the momentum with its
angular velocity alone. Conditions on a planar linkage that hold moments of inertia at all are
therefore few under a relation: one if all bodies turn in fixed ratios, such as J_1 = J_3.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.constraints.relation_candidates import (
    LARGEST,
    Candidate,
    candidates,
    count_candidates,
)
from balance.masses.remedies.judge_variant import judge_variant, verify_file
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.interpretation.freedoms import reduced_echelon
from balance.space.momentum.regressor import momentum_regressor
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    AS_GIVEN_RESIDUAL,
    BODY_AT_REST,
    ECHELON_PIVOT,
    FRACTION_IN_TEXT,
    TERMS_RANK,
)
from kinematics.errors import LinkageError
from kinematics.files.urdf.edit_xml import Splice, Text
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import element_lines, number_words
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

KEY = "input_relation"
# Most inputs whose relations are tried unasked.
MOST_INPUTS = 6
# Most relations that are judged: each takes a search for least matter.
MOST_JUDGED = 3
# Parameters of a body in the plane: m, mcx, mcy, E.
PLANAR = 4
# Displacement at which angular velocities are compared with those at the reference pose.
STEP = 0.05


def apply_input_relation(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by relations between its inputs, ``a u_i = b u_j`` with |a|, |b| ≤ 3.

    Relations of two inputs become mimic joints in the file. Others need a gear or a slider; the
    file is that of the linkage, and the relation is an option of the command.

    Yields:
        A result for each of the first relations that leave the most freedoms; those that
        balance the masses of the file come first.
    """
    if request.freedoms < 2:
        yield refused(KEY, "the linkage has one freedom: a relation would leave none")
        return
    if feasible(request.space).verdict == "feasible":
        yield refused(KEY, "no relation is needed: masses of its own links balance the linkage")
        return
    names, _ = free_inputs(request)
    if len(names) > MOST_INPUTS and KEY not in request.only:
        count = count_candidates(len(names))
        parameters = request.space.rank + request.space.nullity
        reason = (
            f"{count} relations of {len(names)} inputs are too many to try unasked, each a "
            f"design space of {parameters} parameters: --only {KEY} tries them"
        )
        yield refused(KEY, reason)
        return
    search = search_relations(request)
    if not search.balanced:
        verdict = "undecided" if search.undecided else "infeasible"
        relations = f"of {search.tried} relations with whole numbers up to {LARGEST}"
        reason = f"no masses whatever under any {relations}"
        if search.undecided:
            # Their number is for round-off to decide.
            reason = (
                f"under some {relations} neither masses nor a proof that there are none were "
                "found; balance design --motion RELATION may decide the one that you can build"
            )
        yield replace(refused(KEY, reason), verdict=verdict)  # type: ignore[arg-type]
        return
    for relation in search.balanced[:MOST_JUDGED]:
        others = [
            alternative.words for alternative in search.balanced if alternative is not relation
        ]
        yield _judge(request, relation, others)


def _judge(
    request: RemedyRequest, relation: InputRelation, others: list[tuple[str, ...]]
) -> AppliedRemedy:
    """Judge the linkage under one relation."""
    needs = [str(need) for need in inertia_needs(relation.space)]
    ratios = turning_ratios(relation.space)
    driven = _driven(request, relation)
    details = {
        "relations": list(relation.words),
        "built_as": "mimic" if driven is not None else "gear or slider",
        "motion": [] if driven is not None else list(relation.words),
        "needs": needs,
        "turning_ratios": ratios,
        "other_relations": [list(words) for words in others],
    }
    words = ", ".join(relation.words)
    if ratios is not None:
        turning = ", ".join(f"{name} {x:g}" for name, x in ratios.items())
        words += f" (angular velocities: {turning})"
    inputs = tuple(x for x in request.linkage.inputs if x not in (driven or {}))
    base = request.base if driven is None else _with_mimics(request.base, driven)
    motion = relation.words if driven is None else ()
    if relation.space.as_given.balanced:
        blank = AppliedRemedy(KEY, words, "undecided", "", details=details)
        result = verify_file(request, blank, base.data, (*request.motion, *motion), inputs)
    else:
        result = judge_variant(
            request,
            Variant(
                KEY, words, base, request.links, motion=motion, inputs=inputs, details=details
            ),
        )
    asks = f"; needs {', '.join(needs)}" if needs else ""
    if driven is None:
        options = " ".join(f"--motion {x}" for x in relation.words)
        asks += f"; a gear or slider must hold it: {options}"
    return replace(result, reason=result.reason + asks)


def _driven(
    request: RemedyRequest, relation: InputRelation
) -> dict[str, tuple[str, float]] | None:
    """Find the joint and the ratio that each driven input follows.

    Returns:
        By name of the driven input; None if a relation has more than two terms, or an input
        is no joint of its own in the file.
    """
    rows = relation.candidate.rows
    if any(sum(map(bool, row)) > 2 for row in rows):
        return None
    # Each row is solved for the input that no other row has; the others are free.
    driven = [
        next(k for k, x in enumerate(row) if x and sum(bool(r[k]) for r in rows) == 1)
        for row in rows
    ]
    undriven = next(k for k in range(len(relation.names)) if k not in driven)
    sources = {}
    for row, i in zip(rows, driven, strict=True):
        source = next((k for k, x in enumerate(row) if x and k != i), undriven)
        sources[relation.names[i]] = relation.names[source], -row[source] / row[i]
    single = {x.name for x in build_tree(request.base.data).children if x.tag == "joint"}
    return (
        sources if single >= {*sources, *(source for source, _ in sources.values())} else None
    )


def _with_mimics(document: Document, driven: dict[str, tuple[str, float]]) -> Document:
    """Make joints of a URDF file follow others; a joint that rests follows with ratio 0."""
    text, splices = Text(document.data), []
    for joint in build_tree(document.data).children:
        if joint.tag != "joint" or joint.name not in driven:
            continue
        source, ratio = driven[joint.name]
        mimic = Element("mimic", {"joint": source, "multiplier": number_words([ratio])})
        place = joint.span[1] - text.size(text.margin(joint.span[1]))
        margin = text.margin(joint.children[-1].span[0])
        line = "".join(f"{margin}{line}" for line in element_lines(mimic, ""))
        splices += [Splice(place, place, line), *_without_mark(text, joint)]
    return Document(document.name, text.replace(splices))


def _without_mark(text: Text, joint: Element) -> list[Splice]:
    """Remove ``independent`` from the start tag of a joint, which follows another now."""
    first = joint.span[0]
    head = text.data[first : joint.children[0].span[0]].decode(text.codec, "replace")
    mark = re.search(r"""\s+independent\s*=\s*("[^"]*"|'[^']*')""", head.partition(">")[0])
    if mark is None:
        return []
    start = first + text.size(head[: mark.start()])
    return [Splice(start, start + text.size(mark[0]), "")]


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
    columns = [
        int(np.flatnonzero(row)[0]) if np.count_nonzero(row) == 1 and row.max() == 1.0 else -1
        for row in motion.basis
    ]
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
    request: RemedyRequest,
    names: tuple[str, ...],
    basis: Array,
    candidate: Candidate,
    step: tuple[int, int] | None = None,
) -> _Trial:
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


class _InertiaNeed(NamedTuple):
    """A condition ``Σ factor J = constant`` on moments of inertia.

    Attributes:
        factors: of the moment of inertia of each body about its own centre of mass.
        constant: kg m², for the masses and centres of mass in the file; None if these do not
            fulfil the conditions without moments of inertia.
    """

    factors: dict[str, float]
    constant: float | None

    def __str__(self) -> str:
        """Write it with positive terms on both sides, such as ``J(a) = 2 J(b)``."""
        sides = [
            [_term(sign * x, name) for name, x in self.factors.items() if sign * x > 0.0]
            for sign in (1.0, -1.0)
        ]
        if self.constant is None:
            sides[1].append("terms of the masses")
        elif self.constant:
            sides[self.constant < 0.0].append(f"{number_text(abs(self.constant), '.6g')} kg m²")
            sides.reverse()
        left, right = (" + ".join(side) or "0" for side in sides)
        return f"{left} = {right}"


def inertia_needs(space: DesignSpace) -> tuple[_InertiaNeed, ...]:
    """Find the conditions on moments of inertia that balance leaves in a planar linkage.

    Returns:
        Independent conditions; none for spatial linkages and for force balance.
    """
    if not space.planar or space.balance == "force":
        return ()
    rows = np.linalg.svd(space.scaled_basis)[0][:, space.nullity :].T
    spins = rows[:, PLANAR - 1 :: PLANAR]
    U, sizes, _ = np.linalg.svd(spins)
    rank = int((sizes > TERMS_RANK).sum())
    # Combinations of the conditions with moments of inertia, and those without.
    with_spin, without = U[:, :rank].T @ rows, U[:, rank:].T @ rows
    factors = np.empty((0, spins.shape[1]))
    if rank:
        factors = reduced_echelon(with_spin[:, PLANAR - 1 :: PLANAR])
    mix = factors @ np.linalg.pinv(with_spin[:, PLANAR - 1 :: PLANAR])
    constants = _constants(space, mix @ with_spin, without)
    return tuple(
        _InertiaNeed(_named(space.bodies, row), constant)
        for row, constant in zip(factors, constants, strict=True)
    )


def turning_ratios(space: DesignSpace) -> dict[str, float] | None:
    """Compute the angular velocities of all bodies of a planar linkage with one freedom.

    Args:
        space: a design space whose motion has one freedom.

    Returns:
        Angular velocity of each body over that of the freedom; None if they change with the
        pose, or the linkage is spatial or has more freedoms.
    """
    motion = space.motion
    if not space.planar or motion is None or motion.basis.shape[1] != 1:
        return None
    rates = []
    for size in (0.0, STEP):
        X = momentum_regressor(space.linkage, size * motion.basis[:, 0], spatial=False)
        rates.append(motion.basis[:, 0] @ X[:, 0, PLANAR - 1 :: PLANAR])
    if np.abs(rates[0] - rates[1]).max() > FRACTION_IN_TEXT * np.abs(rates[0]).max():
        return None
    return {
        name: round(x, 9) + 0.0 if abs(x) > BODY_AT_REST else 0.0
        for name, x in zip(space.bodies, rates[0].tolist(), strict=True)
    }


def _constants(space: DesignSpace, rows: Array, without: Array) -> list[float | None]:
    """Compute the right sides for the masses and centres of mass in the file, kg m²."""
    given = np.array([body.inertia for body in space.linkage.bodies])
    z = to_chain(given, space.chain.frame, True, False)
    moments = np.einsum("bi,bi->b", z[:, 1:3], z[:, 1:3])
    about_origin = np.divide(moments, z[:, 0], where=z[:, 0] > 0.0, out=np.zeros(len(z)))
    about_centre = z[:, 3] - about_origin
    z[:, 3] = about_origin
    size = float(np.abs(z).sum())
    if size == 0.0 or np.abs(without @ z.ravel()).max(initial=0.0) > AS_GIVEN_RESIDUAL * size:
        return [None] * len(rows)
    sides = -(rows @ z.ravel())
    sides[np.abs(sides) <= AS_GIVEN_RESIDUAL * (size + np.abs(about_centre).sum())] = 0.0
    return (sides * space.chain.frame.length**2).tolist()


def _named(bodies: Sequence[str], row: Array) -> dict[str, float]:
    """Factors by body, in the smallest whole numbers if they are simple fractions."""
    nonzero = row[np.abs(row) > ECHELON_PIVOT]
    fractions = [Fraction(x).limit_denominator(12) for x in nonzero.tolist()]
    near = np.abs(np.array([float(x) for x in fractions]) - nonzero)
    whole = 1
    if near.max(initial=0.0) <= FRACTION_IN_TEXT:
        whole = int(np.lcm.reduce([x.denominator for x in fractions]))
    factors = [float(x) * whole for x in fractions] if whole > 1 else nonzero.tolist()
    names = [name for name, x in zip(bodies, row, strict=True) if abs(x) > ECHELON_PIVOT]
    return dict(zip(names, factors, strict=True))


def _term(factor: float, name: str) -> str:
    return (
        f"J({name})"
        if abs(factor - 1.0) <= FRACTION_IN_TEXT
        else f"{number_text(factor, '.6g')} J({name})"
    )
