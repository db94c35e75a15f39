"""The crank of a planar linkage of one freedom, and its motion over all that it can reach."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from balance.masses.remedies.balancers.on_base import NoBalancer
from balance.masses.remedies.request import RemedyRequest
from balance.motion.motion_tolerances import CONDITIONING_NOTICE
from balance.motion.verification.crank_revolution import crank_limits, revolve_crank
from balance.motion.verification.trajectory import Trajectory, drive, order_inputs
from kinematics.errors import LinkageError, PoseError
from kinematics.model.linkage import Joint, Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array

# Samples over the range of a crank that cannot turn fully, and the part of the range taken:
# at its ends, the dead centres, the ratio is infinite.
SAMPLES = 721
RANGE_SHARE = 0.9
# Most times that the range is shortened.
MAX_SHORTER = 30


def refuse_several_freedoms(request: RemedyRequest) -> None:
    """Raise NoBalancer unless the linkage is planar and has one degree of freedom."""
    if not request.linkage.planar:
        raise NoBalancer(
            "refused",
            "a spatial linkage: its moment changes its direction, which one wheel "
            "about a fixed axis cannot follow; active wheels can",
        )
    if request.freedoms != 1:
        count = f"{request.freedoms} degrees of freedom"
        raise NoBalancer("refused", f"{count}, but a ratio is a function of one")


def crank_rates(linkage: Linkage, limits: Motion | None) -> tuple[str, Array]:
    """Choose the crank: the first revolute input that moves, else the first that does.

    Returns:
        Its name, and the rates of all inputs (mobility,) for its unit rate.
    """
    basis = np.ones((1, 1)) if limits is None else order_inputs(limits, linkage)
    kinds = {joint.name: joint.kind for joint in linkage.joints}
    moving = [name for k, name in enumerate(linkage.inputs) if basis[k, 0] != 0.0]
    crank = next((name for name in moving if kinds[name] == "revolute"), moving[0])
    column = basis[:, 0] / basis[linkage.inputs.index(crank), 0]
    return crank, np.asarray(column)


def sweep_crank(
    linkage: Linkage, limits: Motion | None, crank: str, rates: Array
) -> tuple[Trajectory, bool]:
    """Move the crank at a unit rate: a full turn if it can, else over most of its range."""
    with suppress(LinkageError):
        return revolve_crank(linkage, 1.0, crank, limits)[0], True
    ends = (RANGE_SHARE * end for end in crank_limits(linkage, crank, rates))
    low, high = (_regular_end(linkage, rates, end) for end in ends)
    return _move(linkage, rates, np.linspace(low, high, SAMPLES)), False


def _move(linkage: Linkage, rates: Array, u: Array) -> Trajectory:
    """Move the crank at a unit rate through displacements (N,)."""
    ud = np.tile(rates, (u.size, 1))
    return drive(linkage, u, np.outer(u, rates), ud, 0.0 * ud)


def _regular_end(linkage: Linkage, rates: Array, end: float) -> float:
    """Shorten a way from the reference pose until no singular pose is on it."""
    for _ in range(MAX_SHORTER):
        with suppress(PoseError):
            way = _move(linkage, rates, np.linspace(0.0, end, SAMPLES // 2))
            if way.conditioning > CONDITIONING_NOTICE:
                break
        end *= RANGE_SHARE
    return end


def crank_joint(linkage: Linkage, crank: str) -> Joint:
    """Find the joint of the crank."""
    return linkage.joints[int(linkage.positions_of([crank])[0])]
