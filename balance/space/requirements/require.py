"""Several requirements in one design space: their intersection, and how sure it is."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from balance.space.conditions.fresh_momenta import momentum_left
from balance.space.momentum.regressor import parameters_per_body
from balance.space.requirements.exact_intersection import exact_rank, has_exact_rank
from balance.space.requirements.region_conditions import (
    CommonData,
    RegionConditions,
    collect_region,
)
from balance.space.requirements.required_space import (
    RequiredSpace,
    space_of,
    with_requirements,
)
from balance.space.requirements.requirement import read_requirements
from balance.space.spaces.certainty import Certainty
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import GRAVITY
from balance.support.tolerances import MOMENTUM_RESIDUAL, MOMENTUM_RESIDUAL_ILL_CONDITIONED
from kinematics.errors import LinkageError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Notice
from kinematics.wording import size_text

Array = NDArray[np.float64]


def require(
    linkage: LinkageLike, requirements: str | Sequence[str], *, spatial: bool = False,
    gravity: Sequence[float] = GRAVITY,
) -> RequiredSpace:  # fmt: skip
    """Compute the mass distributions that satisfy several requirements at once.

    Each requirement has a quantity and a region in which it vanishes, and is a list of linear
    conditions on the same parameters; the conditions of all are stacked in one frame and scale,
    and one rank decision gives their common null space. Text of a requirement:
    ``QUANTITY [AXES] [about POINT] [REGION]``, such as ``"force"``, ``"dynamic at u1=0.3"``,
    ``"moment about 0,0,0.2 along u2=u3"``, ``"dynamic up to order 2 about u1=0.3"``,
    ``"force x,y along u2=u1**2"``, ``"gravity"``, ``"decoupled"``; see docs/requirements.md.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        requirements: one or several texts; each may hold several requirements, with ``;``
            between. Their order does not matter.
        spatial: count all ten parameters per body, even if the linkage is planar.
        gravity: direction of gravity (3,), in the inertial frame.

    Returns:
        The space, with the rank of each requirement alone and what it adds to the others.
        Where all conditions are rational in the numbers of the file, exact arithmetic confirms
        the rank (``"verified"``); otherwise floating point decides (``"estimated"``).

    Raises:
        UsageError: a requirement cannot be read.
        LinkageError: the linkage cannot take a pose, or follow a motion, of a requirement.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, section 3.3, for force balance with
        dynamic balance in a pose.

    Example:
        >>> import balance
        >>> space = balance.require("robot.urdf", "force; dynamic at u1=0")
        >>> space.nullity, [item.rank for item in space.requirements]
        (7, [3, 4])
    """
    linkage = as_linkage(linkage)
    listed = read_requirements(requirements)
    g = np.asarray(gravity, dtype=np.float64)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        raise UsageError(f"gravity has three coordinates that are not all 0, not {gravity!r}")
    x, y, z = (Fraction(str(component)) for component in g.tolist())
    masses = all(item.masses_alone for item in listed)
    common = CommonData(linkage, linkage.planar and not spatial, masses, (x, y, z))
    regions = tuple(collect_region(common, item) for item in listed)
    return intersect(common, regions)


def intersect(common: CommonData, regions: Sequence[RegionConditions]) -> RequiredSpace:
    """Intersect the spaces of requirements, and state how sure the integers are.

    Args:
        common: what the requirements share.
        regions: the conditions of each, in canonical order.
    """
    notices = _notices(regions)
    space = space_of(common, regions, notices)
    bound, reason = _exact_bound(common, regions, space.rank)
    if bound is not None and bound < space.rank:
        space = space_of(common, regions, notices, bound)
    certainty = _certainty(common, regions, space, bound, reason)
    return with_requirements(space, certainty, common, regions)


def _exact_bound(
    common: CommonData, regions: Sequence[RegionConditions], expected: int
) -> tuple[int | None, str]:
    """Compute the exact rank, None where it cannot be done, and the reason of the level."""
    rounded = [item.requirement.text for item in regions if not has_exact_rank(item)]
    if rounded:
        return None, f"floating point decides where '{rounded[0]}' is asked for"
    try:
        bound = exact_rank(common, regions, expected)
    except LinkageError as error:
        return None, f"not by exact arithmetic: {error}"
    return bound, "balanced at finite poses, and of the same rank by exact arithmetic"


def _notices(regions: Sequence[RegionConditions]) -> list[Notice]:
    """List the requirements of which conditions may be missing."""
    return [
        Notice(
            "not_settled",
            f"requirement '{region.requirement.text}': poses further on need more conditions "
            "than were found: the rank may be too low",
        )
        for region in regions if not region.settled
    ]  # fmt: skip


def _certainty(
    common: CommonData, regions: Sequence[RegionConditions], space: DesignSpace,
    bound: int | None, reason: str,
) -> Certainty:  # fmt: skip
    """State how sure the integers of an intersection are.

    Args:
        common: what the requirements share.
        regions: the conditions of each.
        space: the intersection.
        bound: its rank by exact arithmetic, if that can be done.
        reason: why the level is what it is, but for doubts.
    """
    residual, poses = _residual_of(common, regions, space)
    doubts = list(space.doubts)
    # Round-off turns the basis by its size over the smallest singular value kept.
    if residual > min(MOMENTUM_RESIDUAL / space.kept, MOMENTUM_RESIDUAL_ILL_CONDITIONED):
        doubts.append(f"momenta of {size_text(residual)} of the conditions are left")
    if bound is not None and bound != space.rank:
        doubts.append(f"exact arithmetic finds rank {bound} instead of {space.rank}")
    verified = bound == space.rank and not doubts and space.settled
    if doubts:
        reason = doubts[0]
    return Certainty(
        "verified" if verified else "estimated", reason, bound, None, residual, poses,
        tuple(doubts),
    )  # fmt: skip


def _residual_of(
    common: CommonData, regions: Sequence[RegionConditions], space: DesignSpace
) -> tuple[float, int]:
    """Measure the largest momentum left at poses that were not used, and count these."""
    worst, poses, basis = 0.0, 0, space.decision.basis
    for region in regions:
        if region.chain is not None:
            requirement = region.requirement
            columns = basis
            if requirement.masses_alone and not common.masses:
                size, few = (parameters_per_body(common.planar, x) for x in (False, True))
                columns = basis.reshape(-1, size, basis.shape[1])[:, :few]
                columns = columns.reshape(-1, basis.shape[1])
            left, count = momentum_left(
                region.chain, columns, requirement.masses_alone, region.select
            )
            worst, poses = max(worst, left), poses + count
    return worst, poses
