"""Counterweights: the least matter, added inside regions of links, that balances a linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from balance.added_masses.added_matter import homogeneous
from balance.added_masses.counterweight import Counterweight, counterweight_of
from balance.added_masses.exclusion import Exclusion, check_exclusion, describe_exclusion
from balance.added_masses.link_regions import regions_of
from balance.added_masses.lumps import Lumps, lumps_of, refine_lumps
from balance.added_masses.program import (
    AddedObjective,
    AddedProgram,
    AddedSolution,
    added_objective,
    build_added_program,
    solve_added,
)
from balance.added_masses.quadratic_minimum import minimise_in_region
from balance.added_masses.regions import Region
from balance.certification.certified_space import CertifiedSpace
from balance.certification.certify_space import certify
from balance.designs.feasibility import Verdict
from balance.designs.pseudo_inertia_cone import given_parameters
from balance.designs.verdicts import TOO_NARROW, UNSETTLED
from balance.inertial_parameters.conversions import to_chain
from balance.spaces.compute_space import design_space
from balance.spaces.design_space import DesignSpace
from balance.tolerances import (
    CONDITION_LEFT,
    COUNTERWEIGHT_RESIDUAL,
    INSIDE_REGION,
    LUMP_MASS_ZERO,
)
from kinematics.linalg.vectors import project_out
from kinematics.model.arrays import freeze
from kinematics.spatial.inertia import from_pseudo_inertia
from kinematics.wording import html_facts, repr_lines

__all__ = ["COUNTERWEIGHTS_SCHEMA", "Counterweights", "Relaxation", "counterweights", "decide"]

Array = NDArray[np.float64]

COUNTERWEIGHTS_SCHEMA = "balance.counterweights/1"


@dataclass(frozen=True)
class Relaxation:
    """One change of an infeasible request that makes it feasible.

    Attributes:
        link: the link.
        factor: factor by which its region must grow about its centre; None if matter must be
            added to this link too, in its default region.
        mass: mass that is then added, kg.
    """

    link: str
    factor: float | None
    mass: float

    @property
    def words(self) -> str:
        """The change in words."""
        if self.factor is None:
            return f"adding matter to '{self.link}' too would do ({self.mass:.4g} kg in all)"
        return (
            f"a region of '{self.link}' {self.factor:.4g} times as large would do "
            f"({self.mass:.4g} kg in all)"
        )


@dataclass(frozen=True, eq=False)
class Counterweights:
    """Result of `counterweights`: added matter, or a certificate that none balances.

    Attributes:
        space: the design space; spatial for dynamic balance of a planar linkage.
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        minimise: the objective.
        value: its value in SI units (see `counterweights`); None without counterweights.
        gap: largest part of the value by which it may exceed the global minimum, proved by
            the dual; None likewise.
        regions: where matter may be added, by name of the link.
        chosen: links whose region is the default.
        weights: the counterweight of each link to which matter is added.
        z: parameters (bodies, 10) of given and added masses about the inertial origin, SI
            units; None without counterweights.
        residual: size of the conditions' residual over the sum of the bodies' parts; None
            likewise.
        certificate: functional (parameters,) that proves infeasibility; see
            `balance.added_masses.exclusion`.
        check: result of its check without the solver.
        relaxations: single changes that would help, the smallest first; empty if feasible.
        given_mass: mass of the bodies in the file, kg.
        words: the verdict in one line.
    """

    space: DesignSpace
    verdict: Verdict
    minimise: AddedObjective
    value: float | None
    gap: float | None
    regions: Mapping[str, Region]
    chosen: tuple[str, ...]
    weights: tuple[Counterweight, ...]
    z: Array | None
    residual: float | None
    certificate: Array | None
    check: Exclusion | None
    relaxations: tuple[Relaxation, ...]
    given_mass: float
    words: str

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the counterweights."""
        title = f"Counterweights for {self.space.linkage.name}"
        return repr_lines(title, self.words, *(weight.words for weight in self.weights))

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        facts = ((weight.link, weight.words) for weight in self.weights)
        title = f"Counterweights for {self.space.linkage.name}"
        return html_facts(title, ("verdict", self.words), *facts)

    @property
    def added_mass(self) -> float:
        """Mass of all counterweights, kg."""
        return sum(weight.mass for weight in self.weights)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/counterweights.schema.json``."""
        space = self.space
        return {
            "schema": COUNTERWEIGHTS_SCHEMA,
            "model": space.linkage.name,
            "at": space.linkage.at,
            "algebra": "planar" if space.planar else "spatial",
            "balance": space.balance,
            "verdict": self.verdict,
            "minimise": self.minimise,
            "value": self.value,
            "gap": self.gap,
            "regions": {
                name: {
                    "text": region.text, "kind": region.kind, "default": name in self.chosen,
                    "place": region.place.tolist(),
                }
                for name, region in self.regions.items()
            },
            "given_mass": self.given_mass,
            "added_mass": self.added_mass,
            "counterweights": [weight.to_dict() for weight in self.weights],
            "residual": self.residual,
            "certificate": None if self.certificate is None else self.certificate.tolist(),
            "check": self.check._asdict() if self.check else None,
            "relaxations": [
                {"link": one.link, "factor": one.factor, "mass": one.mass}
                for one in self.relaxations
            ],
            "words": self.words,
        }  # fmt: skip


def counterweights(
    space: DesignSpace, add: Sequence[str],
    regions: Mapping[str, Region | str] | None = None, minimise: AddedObjective = "mass",
    *, relax: bool = True,
) -> Counterweights:  # fmt: skip
    """Compute the least matter that balances a linkage when added to some of its links.

    The masses in the file stay. Added matter is any measure inside a region of each link's
    frame, ``Σ_b ∫ A_b(x) dμ_b = r``, so that the program is convex: its answer is a global
    optimum with a proved gap, or infeasible with a certificate. For dynamic balance of a
    planar linkage, all six components of the momentum count.

    Args:
        space: a design space.
        add: names of the links to which matter may be added.
        regions: where, by name: a `Region` of the link frame, or its text, such as
            ``ball(0,0,0,0.1)``, ``box(-0.2:0,-0.1:0.1,0:0.1)``,
            ``cylinder(x,y,z,ax,ay,az,r,length)``, ``ellipsoid(x,y,z,a,b,c)`` in metres, or
            ``collision``, the convex hull of the link's collision elements. By default a ball
            about the joint that carries the link, of half its length.
        minimise: ``"mass"``: added mass, kg; ``"inertia"``: the largest principal moment of
            inertia of any of these links with its counterweight, about the origin of its
            frame, kg m²; ``"rotor"``: trace of the generalised inertia matrix at the reference
            pose, kg m². The last two have a price on mass, 0.01 squares of ``space.length``.
        relax: whether to look for single changes that help if there is no answer.

    Returns:
        The counterweights, or the certificate.

    Raises:
        BodyError: a body is unknown, or part of the ground.
        UsageError: no link is named, one is named twice, or a region is wrong.
        ValueError: there is no such objective.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf", balance="force")
        >>> found = balance.counterweights(space, ["crank", "rocker"])
        >>> found.verdict
        'feasible'
    """
    if minimise not in get_args(AddedObjective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(AddedObjective))}")
    own = regions_of(space, add, regions or {})
    if space.planar and space.balance == "dynamic":
        wider = design_space(space.linkage, space.motion, spatial=True)
        space = certify(wider) if isinstance(space, CertifiedSpace) else wider
    found = decide(space, own, minimise)
    known = regions or {}
    found = replace(found, chosen=tuple(name for name in found.regions if name not in known))
    if found.verdict != "infeasible" or not relax:
        return found
    from balance.added_masses.relaxations import single_relaxations

    helps = single_relaxations(space, own)
    text = f"{found.words}; {helps[0].words}" if helps else found.words
    return replace(found, relaxations=helps, words=text)


def decide(
    space: DesignSpace, regions: Mapping[int, Region], minimise: AddedObjective = "mass"
) -> Counterweights:
    """Decide whether matter in some regions balances a linkage, and minimise it.

    Args:
        space: the design space, whose conditions are used as they are.
        regions: region by position of the body.
        minimise: the objective; see `counterweights`.
    """
    names = {space.bodies[b]: region for b, region in regions.items()}
    given_mass = float(given_parameters(space)[:, 0].sum())
    blank = Counterweights(
        space, "undecided", minimise, None, None, names, (), (), None, None, None, None, (),
        given_mass, "undecided: neither an answer nor a certificate stands up to its check",
    )  # fmt: skip
    program = build_added_program(space, regions, minimise)
    if _left_over(program):
        return _proved(blank, regions, program.left)
    solution = solve_added(program)
    if solution.infeasible or not np.isfinite(solution.moments).all():
        return _proved(blank, regions, program.lift @ solution.dual)
    return _balanced(blank, program, solution)


def _left_over(program: AddedProgram) -> bool:
    """Whether the given masses leave something in which no added matter has a part."""
    parts = program.given.reshape(len(program.space.bodies), -1)
    size = float(np.linalg.norm(parts, axis=1).sum())
    return float(np.linalg.norm(program.left)) > CONDITION_LEFT * size


def _proved(blank: Counterweights, regions: Mapping[int, Region], w: Array) -> Counterweights:
    """Return the verdict by a certificate, if its check accepts it."""
    w = freeze(w / (float(np.linalg.norm(w)) or 1.0))
    check = check_exclusion(blank.space, regions, w)
    if not check.accepted:
        return blank
    if not blank.space.encloses:
        return replace(blank, words=f"undecided: {TOO_NARROW}")
    text = describe_exclusion(blank.space, regions, w)
    return replace(blank, verdict="infeasible", certificate=w, check=check, words=text)


def _balanced(
    blank: Counterweights, program: AddedProgram, solution: AddedSolution
) -> Counterweights:
    """Return the verdict with counterweights, if their check accepts them."""
    space, kinds = program.space, list(program.regions.values())
    least = LUMP_MASS_ZERO * max(0.0, float(solution.moments[:, 3, 3].sum()))
    force = space.balance == "force"
    rough = [
        lumps_of(region, P, force, least)
        for region, P in zip(kinds, solution.moments, strict=True)
    ]
    lumps = refine_lumps(kinds, program.rows, program.target, rough)
    z = _with_lumps(program, lumps)
    residual = balance_residual(space, z)
    inside = all(
        not one.masses.size or float(region.excess(one.points).max()) <= INSIDE_REGION
        for region, one in zip(kinds, lumps, strict=True)
    )
    if not (inside and residual <= COUNTERWEIGHT_RESIDUAL):
        return blank
    if not space.sure:
        return replace(blank, words=f"undecided: {UNSETTLED}")
    value, priced = added_objective(program, [one.moments for one in lumps])
    prices = [minimise_in_region(*item)[0] for item in zip(kinds, solution.forms, strict=True)]
    added = sum(float(one.masses.sum()) for one in lumps)
    bound = solution.bound + added * min(0.0, *prices)
    weights = tuple(
        counterweight_of(space.bodies[b], region, one, program.unit)
        for (b, region), one in zip(program.regions.items(), lumps, strict=True)
        if one.masses.size
    )
    total = sum(weight.mass for weight in weights)
    return replace(
        blank, verdict="feasible", value=value, z=freeze(z), residual=residual,
        weights=weights, gap=max(0.0, priced - bound) / priced if priced > 0.0 else 0.0,
        words=f"feasible: {total:.4g} kg added to {blank.given_mass:.4g} kg balance it",
    )  # fmt: skip


def _with_lumps(program: AddedProgram, lumps: Sequence[Lumps]) -> Array:
    """Add lumps to the given masses: parameters (bodies, 10), SI units."""
    z = given_parameters(program.space).copy()
    for (b, region), one in zip(program.regions.items(), lumps, strict=True):
        H = program.space.frames[b] @ region.place
        p = homogeneous(one.points) @ H.T
        z[b] += program.unit * from_pseudo_inertia(np.einsum("n,ni,nj->ij", one.masses, p, p))
    return z


def balance_residual(space: DesignSpace, z: Array) -> float:
    """Compute how far a distribution is from the design space, over the bodies' sizes.

    Args:
        space: the design space.
        z: parameters (bodies, 10) about the inertial origin, SI units.
    """
    own = to_chain(z, space.chain.frame, space.planar, space.balance == "force")
    size = float(np.linalg.norm(own, axis=1).sum())
    rest = project_out(own.reshape(-1), space.scaled_basis)
    return float(np.linalg.norm(rest)) / (size or 1.0)
