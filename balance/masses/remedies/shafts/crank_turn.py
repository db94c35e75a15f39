"""One turn of a crank at its unit rate, for remedies that hold at constant speed."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.trajectory import Trajectory
from kinematics.errors import LinkageError
from kinematics.model.linkage import GROUND, Joint, Linkage
from kinematics.model.motion import motion_of

# Samples of one turn.
STEPS = 120


class CrankTurn(NamedTuple):
    """One turn of a crank that turns on the base.

    Attributes:
        joint: the joint of the crank.
        trajectory: the motion at 1 rad/s; its last sample is the first again.
    """

    joint: Joint
    trajectory: Trajectory


@lru_cache(maxsize=1)
def turn_of_crank(request: RemedyRequest) -> CrankTurn | str:
    """Turn the crank of a linkage of one freedom once, or say why there is none."""
    linkage = request.linkage
    if request.freedoms != 1:
        return f"{request.freedoms} degrees of freedom: one crank turns at constant speed"
    moving = [joint for joint in linkage.joints if joint.name in linkage.inputs]
    crank = next((joint for joint in moving if joint.kind == "revolute"), None)
    if crank is None or crank.in_loop or crank.numbered or crank.parent != GROUND:
        return "no input turns on the base, so that nothing turns with it at constant speed"
    try:
        return CrankTurn(crank, revolve(request, linkage, crank.name))
    except LinkageError as error:
        return str(error)


def revolve(request: RemedyRequest, linkage: Linkage, crank: str) -> Trajectory:
    """Turn the crank of a linkage with or without a remedy once, at 1 rad/s.

    Raises:
        PoseError: it cannot turn fully.
    """
    limits = motion_of(linkage, request.motion or None)
    return revolve_crank(linkage, 1.0, crank, limits, STEPS)[0]
