"""Relations of a family in exact arithmetic: whether they are enough, and all needed.

Walks and random members hold in floating point. Here the dimensions of the topology are drawn
modulo a prime, with no relations but those of the family, as for `balance.formulas`: the rank
of the conditions says whether the relations make them special, and without one of them,
whether that one is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import NamedTuple

from balance.space.formulas.derive import formulas
from balance.space.formulas.formula_data import Formulas
from balance.space.formulas.geometry_samples import GeometrySamples
from balance.space.formulas.modular_pose import UnclosedError
from balance.space.formulas.problem import PlanarProblem, Problem, problem_of
from balance.space.formulas.relations import DimensionRelation
from balance.space.spaces.compute_space import design_space
from balance.studies.discovery.families import Family
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.related_dimensions import (
    BRANCHES,
    PolynomialCondition,
    RelatedDimensions,
    condition_of,
)
from balance.studies.discovery.structure import TopologyArrays
from balance.studies.discovery.to_linkage import to_linkage
from balance.support.options import Balance
from kinematics.errors import ExactError, LinkageError

# Kinds of relations that formulas have: equal lengths, and coordinates that are zero.
LINEAR = ("equal", "zero", "straight")


class ExactFamily(NamedTuple):
    """What exact arithmetic says on the relations of a family.

    Attributes:
        enough: whether all geometries with these relations have the nullity of the family.
        needed: whether they have another one without any one of them, but for zeros.
        buildable: the lengths for which masses can be built, in words; empty if not derived.
        reason: why this is not decided; empty if it is.
    """

    enough: bool
    needed: bool
    buildable: str
    reason: str


def decide_exactly(
    structure: TopologyArrays, family: Family, balance: Balance | None = "dynamic"
) -> ExactFamily:
    """Decide whether the relations of a family are enough, and all of them needed.

    Args:
        structure: of its topology.
        family: the family; its first member says which dimensions are zero.
        balance: what is asked for in all poses; None where it is another requirement.
    """
    if balance is None:
        return _undecided("formulas are of dynamic balance and force balance everywhere")
    if family.topology.space != "plane" or family.topology.gears:
        return _undecided("formulas are of planar linkages without gears")
    first = family.members[0]
    linear = all(each.kind in LINEAR for each in first.relations)
    if not linear and not family.complete:
        return _undecided("its relations are fewer than its codimension")
    try:
        return _decided(structure, balance, family)
    except (ExactError, UnclosedError) as error:
        return _undecided(str(error) or "dimensions with these relations have another rank")
    except LinkageError as error:
        return _undecided(str(error))


def _undecided(reason: str) -> ExactFamily:
    return ExactFamily(False, False, "", reason)


def _decided(structure: TopologyArrays, balance: Balance, family: Family) -> ExactFamily:
    """Decide for a family; where its relations are linear, with the lengths of masses."""
    first = family.members[0]
    linkage = to_linkage(family.topology, structure, first.geometry)
    space = design_space(linkage, balance=balance)
    if space.nullity != family.nullity - structure.uncounted:
        return _undecided(f"the first member has nullity {space.nullity} as a linkage")
    problem = problem_of(space, force=balance == "force")
    if any(each.kind not in LINEAR for each in first.relations):
        return _decided_by_polynomials(problem, family)
    letters = {joint.name: joint.letter for joint in problem.parts.joints}
    table = {ord(name): letter for name, letter in letters.items()}
    where = [
        words.translate(table)
        for words, each in zip(family.relations, first.relations, strict=True)
        if each.kind == "equal"
    ]
    relations = problem.parse(where)
    enough = _have_the_rank(problem, relations)
    needed = (
        enough
        and bool(relations)
        and not any(
            _have_the_rank(problem, [each for each in relations if each is not relation])
            for relation in relations
        )
    )
    if not enough:
        return ExactFamily(False, False, "", "")
    answer = formulas(linkage, balance, where=where, buildable=find_spec("sympy") is not None)
    if not answer.confirmed:
        return _undecided("a check of the formulas under these relations failed")
    return ExactFamily(enough, needed, _bounds_by_joints(answer), "")


def _decided_by_polynomials(problem: Problem, family: Family) -> ExactFamily:
    """Decide for a family with equal angles, or products or squares of lengths.

    Raises:
        ExactError: its relations are no polynomials, or cannot be solved.
    """
    assert isinstance(problem, PlanarProblem)
    quantities, linkage = quantities_of(family.topology), problem.parts
    conditions = [
        condition_of(each, quantities, linkage)
        for each in family.members[0].relations
        if each.kind not in ("zero", "straight")  # coordinates that are 0 in the member
    ]

    def have_the_rank(conditions: Sequence[PolynomialCondition]) -> bool:
        related = RelatedDimensions(linkage, conditions)
        for _ in range(BRANCHES if conditions else 1):
            try:
                GeometrySamples(problem.source, related, problem.target)
            except UnclosedError:
                continue
            return True
        return False

    if not have_the_rank(conditions):
        return ExactFamily(False, False, "", "")
    others = [[f for f in conditions if f is not each] for each in conditions]
    return ExactFamily(True, not any(map(have_the_rank, others)), "", "")


def _have_the_rank(problem: Problem, relations: Sequence[DimensionRelation]) -> bool:
    """Tell whether dimensions drawn under relations have the rank of the member."""
    try:
        problem.samples(relations, None)
    except UnclosedError:
        return False
    return True


def _bounds_by_joints(answer: Formulas) -> str:
    """Write bounds on lengths, each named by its two joints."""
    bounds = answer.bounds
    if bounds is None or bounds.verdict == "unknown":
        return ""
    if bounds.verdict != "some":
        return f"for {bounds.verdict.replace('none', 'no')} lengths"
    names = {joint.letter: joint.name for joint in answer.parts.joints}
    ends = {
        each.name: "".join(sorted(names[letter] for letter in each.joints))
        for each in answer.parts.dimensions
    }
    lengths = tuple(ends[name] for name in bounds.lengths)
    return f"where {replace(bounds, lengths=lengths).text()}"
