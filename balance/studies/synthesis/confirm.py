"""Confirmation of synthesised mechanisms by the design space and by Pinocchio."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.floating_base.dynamics import CarriedBodies
from balance.motion.motion_tolerances import SYNTHESIS_MOMENTUM, SYNTHESIS_SHAKING
from balance.motion.verification.trajectory import drive
from balance.motion.verification.verification import Verification
from balance.motion.verification.verify_motions import verify
from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.spaces.compute_space import design_space
from balance.studies.synthesis.constrained_motion import MotionTable
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.wording import size_text

# Random motions of a mechanism.
MOTIONS = 2
# Poses of each motion at which inputs must be decoupled.
COUPLING_POSES = 20


class Confirmation(NamedTuple):
    """What other routes say of the written file.

    Attributes:
        confirmed: whether all of them find the mechanism balanced.
        momentum: largest momentum along the motions by Pinocchio, relative to the sum of those
            of the bodies; None if it could not be computed.
        shaking: largest shaking force and moment, relative to the inertia of the bodies; None
            likewise.
        space: what the design space says: of every motion, or of force balance if the inputs
            follow a table.
        reason: why it is not confirmed; empty if it is.
        coupling: largest term between two inputs of the inertia that they feel along the
            motions, over the geometric mean of their own; None if it was not asked for.
    """

    confirmed: bool
    momentum: float | None
    shaking: float | None
    space: str
    reason: str
    coupling: float | None = None


def confirm_balance(
    urdf: bytes, *, certified: bool = True, decoupled: bool = False
) -> Confirmation:
    """Confirm that a mechanism is balanced in every motion.

    Args:
        certified: whether exact arithmetic certifies the design space. Not of special lengths:
            in rounded digits they are no longer special.
        decoupled: whether the inputs must be decoupled, too: the inertia that they feel
            diagonal in all poses of the motions.
    """
    try:
        linkage = _load(urdf)
        space = design_space(linkage)
        space = certify(space) if certified else space
        checked = verify(linkage, trajectories=MOTIONS, tolerance=SYNTHESIS_SHAKING)
    except LinkageError as error:
        return Confirmation(False, None, None, "", str(error))
    level = space.certainty.level if isinstance(space, CertifiedSpace) else "floating point"
    words = f"{space.as_given.verdict}, {level}"
    coupling = input_coupling(checked) if decoupled else None
    return _judge(checked, space.as_given.balanced is True, words, coupling)


def confirm_along(urdf: bytes, table: MotionTable) -> Confirmation:
    """Confirm that a mechanism is force-balanced, and balanced along a motion.

    Args:
        table: the motion of its inputs.
    """
    try:
        linkage = _load(urdf)
        space = certify(design_space(linkage, None, "force"))
        motion = drive(linkage, table.time, table.u, table.ud, table.udd)
        checked = verify(linkage, tolerance=SYNTHESIS_SHAKING, motions=[motion])
    except LinkageError as error:
        return Confirmation(False, None, None, "", str(error))
    words = f"force {space.as_given.verdict} in every motion, {space.certainty.level}"
    return _judge(checked, space.as_given.balanced is True, words)


def _load(urdf: bytes) -> Linkage:
    """Read a file that was written."""
    return load(Document("the synthesised mechanism", urdf))


def input_coupling(checked: Verification) -> float:
    """Compute the largest ``|M_ij| / √(M_ii M_jj)`` between inputs along verified motions.

    M is the inertia of the linkage that its inputs feel, with its loops closed.
    """
    linkage = checked.linkage
    chain = input_chain(linkage)
    count, largest = linkage.mobility, 0.0
    bodies, rest = CarriedBodies(linkage, chain, np.eye(count)), np.zeros(count)
    for run in checked.runs:
        for q in run.trajectory.q[:: max(1, len(run.trajectory.q) // COUPLING_POSES)]:
            pose = forward_kinematics(chain, q / chain.units)
            M = bodies.at(pose, rest).input_inertia
            sizes = np.sqrt(np.diagonal(M))
            largest = max(
                largest, float(np.abs(M / np.outer(sizes, sizes) - np.eye(count)).max())
            )
    return largest


def _judge(
    checked: Verification, balanced: bool, words: str, coupling: float | None = None
) -> Confirmation:
    """Join the verdicts."""
    momentum = max(
        float(np.abs(run.momentum / [*[checked.length] * 3, 1, 1, 1]).max() / run.impulse.max())
        for run in checked.runs
    )
    shaking = max(checked.force_residual, checked.moment_residual)
    reasons = []
    if not balanced:
        reasons.append("its masses are not in the design space")
    if not momentum <= SYNTHESIS_MOMENTUM:
        reasons.append(f"it keeps {size_text(momentum)} of the momentum of its bodies")
    if not checked.balanced:
        reasons.append(f"it shakes by {size_text(shaking)} of the inertia of its bodies")
    if coupling is not None and not coupling <= SYNTHESIS_MOMENTUM:
        reasons.append(f"its inputs are coupled by {size_text(coupling)} of their inertia")
    return Confirmation(not reasons, momentum, shaking, words, "; ".join(reasons), coupling)
