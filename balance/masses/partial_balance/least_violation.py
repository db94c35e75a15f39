"""The matter within a budget that leaves the least of several requirements unmet.

What a requirement leaves is the size of its conditions on the masses, ``|R_i z|``, over the sum
of the sizes that the bodies of the file have in them one by one: 0 if it is met, and at most
about 1. The sum of the squares, ``Σ_i w_i r_i²``, is convex in the added matter, and is
minimised as partial balance is. By the envelope theorem the derivative of the least sum by a
weight is the square that the requirement leaves: this multiplier tells which one costs most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from os import PathLike
from typing import Literal, NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.link_regions import regions_of
from balance.masses.counterweights.moved_matter import nothing_taken
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.write_counterweights import counterweights_file
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.partial_balance.added_weights import check_budget, counterweights_at
from balance.masses.partial_balance.least_shaking import (
    LeastShaking,
    least_shaking,
)
from balance.masses.partial_balance.motion_loads import AddedParameters
from balance.masses.partial_balance.shaking_program import ShakingProgram, quadratic_factor
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.requirements.contradiction import contradiction, contradiction_words
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.requirements.require import require as required_space
from balance.space.requirements.required_space import RequiredSpace
from balance.space.requirements.requirement import read_requirements
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import GRAVITY
from balance.support.tolerances import SHAKING_GAP_PROVED
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import number_text, repr_lines, size_text

# Part of a budget that is none: what the solver leaves where matter does not help.
NOTHING_ADDED = 1e-9
VIOLATION_SCHEMA = "balance.violation/1"


class Violation(NamedTuple):
    """What is left of one requirement.

    Attributes:
        text: the requirement.
        weight: the weight of its square in the sum.
        before: what the masses of the file leave, without a unit.
        after: what is left with the added matter.
    """

    text: str
    weight: float
    before: float
    after: float

    @property
    def cost(self) -> float:
        """Its part of the sum, ``weight · after²``; ``after²`` is its multiplier."""
        return self.weight * self.after**2


@dataclass(frozen=True, eq=False)
class LeastViolation:
    """Result of `least_violation`.

    Attributes:
        space: the space of the requirements.
        verdict: ``"optimal"``: no matter within the budget leaves less, to 1e-6 of what the
            file leaves; or ``"undecided"``.
        violations: what is left of each requirement, in the order of ``space.requirements``.
        bound: no matter within the budget has a smaller root of the sum; proved without the
            solver.
        weights: the counterweight of each link that gets matter.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        budget: most mass that may be added, kg.
        between: one requirement that no matter within the budget meets, or the first two that
            none meets together; empty if there are none.
        links: links that may get matter.
    """

    space: RequiredSpace
    verdict: Literal["optimal", "undecided"]
    violations: tuple[Violation, ...]
    bound: float
    weights: tuple[Counterweight, ...]
    z: Array
    budget: float
    between: tuple[str, ...]
    links: tuple[str, ...] = ()

    @property
    def moved(self) -> dict[str, float]:
        """Mass taken from links: matter is only added."""
        return {}

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the matter of each link."""
        added = (f"{weight.link} +{number_text(weight.mass)} kg" for weight in self.weights)
        return repr_lines(f"LeastViolation of {self.space.linkage.name}", self.words, *added)

    @property
    def total(self) -> float:
        """Root of the weighted sum of squares that is left."""
        return float(np.sqrt(sum(item.cost for item in self.violations)))

    @property
    def dearest(self) -> Violation | None:
        """The requirement that costs most; None if all are met."""
        costs = [item.cost for item in self.violations]
        if self.total <= SHAKING_GAP_PROVED:
            return None
        return self.violations[first_largest(costs, relative=SHAKING_GAP_PROVED)]

    @property
    def words(self) -> str:
        """What is left, and which requirement costs most, in one line."""
        before = np.sqrt(sum(item.weight * item.before**2 for item in self.violations))
        mass = sum(weight.mass for weight in self.weights)
        share = size_text(self.total / (before or 1.0), ".3g", floor=SHAKING_GAP_PROVED)
        text = f"{self.verdict}: {number_text(mass)} kg leave {share} of what the file leaves"
        dearest = self.dearest
        if dearest is None:
            return f"{self.verdict}: {number_text(mass)} kg meet all requirements"
        part = dearest.cost / self.total**2
        text = f"{text}; '{dearest.text}' costs most, {part:.0%} of the sum of squares"
        if len(self.violations) == 1:
            return text
        return f"{text}; {contradiction_words(self.between, 'counterweight of this budget')}"

    @property
    def mass(self) -> float:
        """Mass of the added matter, kg."""
        return float(sum(weight.mass for weight in self.weights))

    def to_urdf(self, path: str | PathLike[str] | None = None, *, merge: bool = False) -> bytes:
        """Return the file of the linkage with the matter, and no other change.

        Args:
            path: file to write it to; None for none.
            merge: whether it goes into the masses of its links; else it is in links of its own.

        Raises:
            FileError: the linkage has no file, or the new one cannot be written.
        """
        return counterweights_file(self, path, merge)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/violation.schema.json``."""
        dearest = self.dearest
        return {
            "schema": VIOLATION_SCHEMA,
            "model": self.space.linkage.name,
            "at": self.space.linkage.at,
            "gravity": [float(x) for x in self.space.common.gravity],
            "verdict": self.verdict,
            "words": self.words,
            "budget": self.budget,
            "mass": self.mass,
            "requirements": [
                {
                    "text": item.text,
                    "weight": item.weight,
                    "before": item.before,
                    "after": item.after,
                    "multiplier": item.after**2,
                    "cost": item.cost,
                }
                for item in self.violations
            ],
            "dearest": None if dearest is None else dearest.text,
            "contradict": list(self.between),
            "total": self.total,
            "bound": self.bound,
            "weights": [weight.to_dict() for weight in self.weights],
        }


def least_violation(
    space: RequiredSpace | LinkageLike,
    links: Sequence[str],
    budget: float,
    *,
    require: str | Sequence[str] | None = None,
    gravity: Sequence[float] = GRAVITY,
    regions: Mapping[str, Region | str] | None = None,
    weights: Sequence[float] | None = None,
) -> LeastViolation:
    """Compute the matter within a budget that leaves the least of several requirements unmet.

    The masses in the file stay; matter is added inside regions of links, as in
    `balance.partial`. Minimised is ``Σ_i w_i r_i²``; see the module for r.

    Args:
        space: the space of the requirements, from `balance.require`; or a linkage, or what
            `kinematics.load` accepts, with ``require``.
        links: names of the links that may get matter.
        budget: most mass to add, kg, above 0.
        require: the requirements, as for `balance.require`.
        gravity: direction of gravity (3,) for these, in the inertial frame.
        regions: where matter may be added, by link; see `balance.partial`.
        weights: w of each requirement, in the order in which they are written, or for a space
            in that of ``space.requirements``; 1 by default.

    Returns:
        What is left of each requirement, the matter, and the proof that no other does better.

    Raises:
        BodyError: a link is unknown, or its region cannot be found.
        UsageError: the budget or a weight is no positive number, no body has mass, or nothing
            is required.

    Source:
        S. Boyd, L. Vandenberghe, Convex Optimization, 2004, sections 5.6 and 5.8.

    Example:
        >>> import balance
        >>> balance.masses.least_violation(
        ...     "robot.urdf", ["crank"], 0.5, require="force; moment at u1=0.2"
        ... ).verdict
        'optimal'
    """
    check_budget(budget)
    if budget == 0.0:
        raise UsageError("a budget of 0 kg adds nothing: see `as_given` of the space")
    if not isinstance(space, RequiredSpace):
        if isinstance(space, DesignSpace) or not require:
            raise UsageError("give the space of balance.require, or a linkage and require")
        weights = _weights_in_order(require, weights)
        space = required_space(space, require, gravity=gravity)
    elif require:
        raise UsageError("a space has its requirements: leave out require, or give a linkage")
    spatial = recompute_spatial(space) if space.planar else space
    assert isinstance(spatial, RequiredSpace)
    matter = AddedParameters.of(spatial, regions_of(space, links, regions or {}))
    blocks = _relative_rows(spatial, matter)
    factors = _checked_weights(weights, len(blocks))
    program = _program(matter, blocks, factors)
    best = least_shaking(program, budget)
    assert isinstance(best, LeastShaking)
    gap = (best.value - best.bound) / program.scale
    nothing = float(matter.masses @ best.s) <= NOTHING_ADDED * budget
    added = np.zeros(matter.count) if nothing else best.s
    points = np.stack([np.zeros(matter.count), added])
    sizes = [
        [float(np.linalg.norm(block.sum(axis=1) @ np.append(s, 1.0))) for s in points]
        for block in blocks
    ]
    violations = tuple(
        Violation(item.text, w, before, after)
        for item, w, (before, after) in zip(space.requirements, factors, sizes, strict=True)
    )
    missed = best.value > SHAKING_GAP_PROVED * program.scale and len(blocks) > 1
    between = _contradiction(space.texts, matter, blocks, budget) if missed else ()
    return LeastViolation(
        space,
        "optimal" if gap <= SHAKING_GAP_PROVED else "undecided",
        violations,
        best.bound,
        () if nothing else counterweights_at(space, matter, added),
        freeze(matter.parameters(added)),
        float(budget),
        between,
        tuple(spatial.bodies[b] for b in matter.regions),
    )


def _program(
    matter: AddedParameters, blocks: Sequence[Array], factors: Sequence[float]
) -> ShakingProgram:
    """Build the program of some requirements and their weights."""
    rows = [np.sqrt(w) * block.sum(axis=1) for w, block in zip(factors, blocks, strict=True)]
    alone = [
        np.sqrt(w) * np.linalg.norm(block[..., -1], axis=0).sum()
        for w, block in zip(factors, blocks, strict=True)
    ]
    none = nothing_taken(len(matter.regions))
    return ShakingProgram(matter, quadratic_factor(rows), float(np.linalg.norm(alone)), none)


def _contradiction(
    texts: Sequence[str], matter: AddedParameters, blocks: Sequence[Array], budget: float
) -> tuple[str, ...]:
    """Find requirements that no matter within a budget meets: one, or the first two."""

    def excluded(chosen: Sequence[int]) -> bool:
        program = _program(matter, [blocks[k] for k in chosen], [1.0] * len(chosen))
        if not program.scale > 0.0:
            return False
        best = least_shaking(program, budget)
        assert isinstance(best, LeastShaking)
        return best.value > SHAKING_GAP_PROVED * program.scale

    return contradiction(texts, excluded)


def missed_by(answer: LeastViolation, z: Array) -> float:
    """Compute what other masses miss, by the measure of a least violation.

    Args:
        answer: the least violation, for its requirements, weights and sizes.
        z: parameters (bodies, 10) about the inertial origin, SI units.

    Returns:
        Root of the weighted sum of squares.
    """
    space = recompute_spatial(answer.space) if answer.space.planar else answer.space
    assert isinstance(space, RequiredSpace)
    frame, size = input_chain(space.linkage).frame, len(space.labels)
    given, other = (
        to_chain(np.asarray(x), frame, False, False)[:, :size]
        for x in (given_parameters(space), z)
    )
    total = 0.0
    for region, item in zip(space.regions, answer.violations, strict=True):
        rows = region.rows.reshape(len(region.rows), len(space.bodies), size)
        alone = np.linalg.norm(np.einsum("rbp,bp->rb", rows, given), axis=0).sum() or 1.0
        violation = float(np.linalg.norm(np.einsum("rbp,bp->r", rows, other)) / alone)
        total += item.weight * violation**2
    return float(np.sqrt(total))


def _weights_in_order(
    requirements: str | Sequence[str], weights: Sequence[float] | None
) -> list[float] | None:
    """Bring weights of requirements from the order of the texts to that of their space.

    Raises:
        UsageError: a requirement cannot be read, there are not as many weights as
            requirements, or one requirement has two.
    """
    if weights is None:
        return None
    texts = [requirements] if isinstance(requirements, str) else requirements
    written = [read_requirements(part)[0].text for part in ";".join(texts).split(";")]
    if len(weights) != len(written) or len(set(written)) < len(written):
        raise UsageError(
            f"{len(weights)} weights for {len(written)} requirements: give one for each, and "
            "each requirement once"
        )
    by_text = dict(zip(written, weights, strict=True))
    return [by_text[item.text] for item in read_requirements(requirements)]


def _relative_rows(space: RequiredSpace, matter: AddedParameters) -> list[Array]:
    """Compute the conditions of each requirement on added matter, by body.

    Returns:
        Columns for the coordinates of the matter and for the file (conditions, bodies,
        count + 1), over the sum of the sizes of the file's bodies.
    """
    blocks, size = [], len(space.labels)
    for region in space.regions:
        rows = region.rows.reshape(len(region.rows), len(space.bodies), size)
        columns = np.zeros((*rows.shape[:2], matter.count + 1))
        for k, (b, D) in enumerate(matter.added.items()):
            columns[:, b, 10 * k : 10 * (k + 1)] = rows[:, b] @ D[:size]
        columns[..., -1] = np.einsum("rbp,bp->rb", rows, matter.scaled[:, :size])
        total = float(np.linalg.norm(columns[..., -1], axis=0).sum())
        blocks.append(columns / (total or 1.0))
    return blocks


def _checked_weights(weights: Sequence[float] | None, count: int) -> list[float]:
    """Return the weights, 1 by default.

    Raises:
        UsageError: there are not as many as requirements, or one is no positive number.
    """
    given = [1.0] * count if weights is None else [float(w) for w in weights]
    if len(given) != count or not all(isfinite(w) and w > 0.0 for w in given):
        raise UsageError(f"give {count} weights above 0, one for each requirement")
    return given
