"""Counterweights: the least matter, added inside regions of links, that balances a linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import get_args

from balance.masses.counterweights.answer import Counterweights
from balance.masses.counterweights.decide import decide
from balance.masses.counterweights.link_regions import regions_of
from balance.masses.counterweights.program import AddedObjective
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.relaxations import single_relaxations
from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace


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
        >>> answer = balance.counterweights(space, ["crank", "rocker"])
        >>> answer.verdict
        'feasible'
    """
    if minimise not in get_args(AddedObjective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(AddedObjective))}")
    body_regions = regions_of(space, add, regions or {})
    if space.planar and space.balance == "dynamic":
        wider = design_space(space.linkage, space.motion, spatial=True)
        space = certify(wider) if isinstance(space, CertifiedSpace) else wider
    answer = decide(space, body_regions, minimise)
    given = regions or {}
    answer = replace(answer, chosen=tuple(name for name in answer.regions if name not in given))
    if answer.verdict != "infeasible" or not relax:
        return answer
    helps = single_relaxations(space, body_regions)
    text = f"{answer.words}; {helps[0].words}" if helps else answer.words
    return replace(answer, relaxations=helps, words=text)
