"""The whole linkage on a free joint through its common centre of mass.

Counterweights balance the force, so that the common centre of mass c stays in place on the
frame. A hinge through it along the normal n joins the frame to the ground, without a drive:
no force and no moment reaches the ground, and from rest the frame turns by

    φ̇ = -h / J,        h: angular momentum on the frame at rest,    J: inertia of all about c.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.balancers.on_base import (
    BalancerDrive,
    Course,
    ForceBalanced,
    NoBalancer,
    balance_force,
    build_or_refuse,
    fine_motion,
    motion_columns,
    random_force_balanced_motions,
    refuse_other_moments,
    verify_with_balancers,
    with_input_inertia,
)
from balance.masses.remedies.balancers.varying_ratio import CsvFiles, integrate
from balance.masses.remedies.momentum_along import MovedMasses, move_masses
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import free_name, names_taken
from balance.motion.verification.trajectory import Trajectory, drive
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import Ad, exp
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, vector_text

KEY = "free_joint"
# Motions along which its file is verified: that of the file, and random ones.
VERIFIED = 3


def apply_free_joint(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by a free hinge of its frame through the centre of mass.

    The frame has no mass: one with mass turns less. What the linkage does is then relative to
    a frame that turns.

    Yields:
        One result; a file has a motion with the frame for ``balance verify --csv``.

    Source:
        G. Becht, MSc thesis, TU Delft, 2020, chapter 2.
    """
    if request.balance == "force":
        yield refused(KEY, "a hinge takes no moment, and only the force is to be balanced")
        return
    yield build_or_refuse(KEY, _build_hinge, request)


class TurningFrame(NamedTuple):
    """A frame that turns about an axis through the common centre of mass.

    Attributes:
        names: of the ground, of the link on the hinge, and of the joint that carries the
            frame on it.
        joint: name of the hinge.
        linkage: the linkage on the frame.
        centre: common centre of mass (3,), metres.
        axis: of the hinge, unit vector (3,).
    """

    names: tuple[str, str, str]
    joint: str
    linkage: Linkage
    centre: Array
    axis: Array

    @property
    def links(self) -> tuple[str, ...]:
        """Links that the frame adds: the ground, and the link on the hinge."""
        return self.names[:2]

    @property
    def drives(self) -> tuple[BalancerDrive, ...]:
        """The hinge, which no motor drives."""
        return (BalancerDrive(self.names[1], self.joint, 0.0),)

    @property
    def mass(self) -> float:
        """Mass that the frame adds, kg: none."""
        return 0.0

    def elements(self, root: str) -> tuple[Element, ...]:
        """Make the ground, and the hinge that carries the old root."""
        there, back = np.eye(4), np.eye(4)
        there[:3, 3], back[:3, 3] = self.centre, -self.centre
        ground, turning, fixed = self.names
        axis = (number_words(self.axis), "")
        at, home = make_elements.origin(there), make_elements.origin(back)
        return (
            make_elements.link(ground),
            make_elements.link(turning),
            make_elements.joint(self.joint, "continuous", ground, turning, at, axis),
            make_elements.joint(fixed, "fixed", turning, root, home),
        )

    def courses(self, run: MovedMasses) -> tuple[Course, ...]:
        """Turn so that no angular momentum is left: ``φ̇ = -h / J``."""
        h, change = (x[:, :3] @ self.axis for x in (run.momentum.total, run.momentum.rate))
        J, slope = inertia_about(self.linkage, run.trajectory, self.centre, self.axis)
        speed = -h / J
        rate = -(change + speed * slope) / J
        return ((integrate(run.trajectory.time, speed, rate), speed, rate),)


def inertia_about(
    linkage: Linkage, motion: Trajectory, centre: Array, axis: Array
) -> tuple[Array, Array]:
    """Compute the inertia of all bodies about an axis along a motion (N,), and its rate.

    With the inertia J_b of a body about its own centre and the axis, which a planar motion
    keeps, ``J = Σ J_b + m_b |r_b|²`` with the distances r_b of the centres from the axis.
    """
    poses: list[Array] = []
    twists: list[Array] = []
    q, qd = motion.q, motion.qd
    still = np.tile(np.eye(4), (len(q), 1, 1)), np.zeros((len(q), 6))
    for j, joint in enumerate(linkage.joints):
        H, V = (poses[joint.parent], twists[joint.parent]) if joint.parent >= 0 else still
        twists.append(V + (Ad(H) @ joint.screw) * qd[:, j, None])
        poses.append(H @ exp(joint.screw, q[:, j]))
    J, rate = np.zeros((2, len(q)))
    for body in linkage.bodies:
        z = body.inertia
        if body.link < 0 or not z[0] > 0.0:
            continue
        start = z[1:4] / z[0]
        xx, yy, zz, xy, xz, yz = z[4:]
        E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        about = axis @ E @ axis - z[0] * float(np.sum(np.cross(axis, start) ** 2))
        H, V = poses[body.link], twists[body.link]
        at = H[:, :3, :3] @ start + H[:, :3, 3]
        arm = np.cross(axis, at - centre)
        speed = np.cross(axis, V[:, 3:] + np.cross(V[:, :3], at))
        J += about + z[0] * np.einsum("ki,ki->k", arm, arm)
        rate += 2.0 * z[0] * np.einsum("ki,ki->k", arm, speed)
    return J, rate


def _build_hinge(request: RemedyRequest) -> AppliedRemedy:
    """Build the hinge, and verify the linkage on it.

    Raises:
        NoBalancer: the linkage is spatial, its force cannot be balanced, no moment is left, or
            one about other axes.
        LinkageError: the linkage cannot be moved.
    """
    if not request.linkage.planar:
        raise NoBalancer("refused", "a spatial linkage: its frame would turn about all axes")
    balanced = balance_force(request)
    linkage = balanced.linkage
    runs = [fine_motion(request), *random_force_balanced_motions(request)]
    momenta = [run.momentum for run in runs]
    refuse_other_moments(linkage, momenta, "a hinge along it carries")
    frame = _frame(balanced)
    swing = max(float(np.ptp(frame.courses(run)[0][0])) for run in runs)
    words = (
        f"the frame on a free hinge at {vector_text(np.round(frame.centre, 6))} m, its common "
        f"centre of mass; it turns by up to {number_text(swing, '.3g')} rad, and what the "
        "linkage does is relative to it"
    )
    blank = AppliedRemedy(KEY, words, "undecided", "")
    checked = runs[:VERIFIED]
    done, moved = verify_with_balancers(request, blank, balanced, [frame], checked)
    motion = motion_columns((*linkage.inputs, frame.joint), moved[0])
    details = {
        "centre": frame.centre.tolist(),
        "joint": frame.joint,
        "ground": frame.names[0],
        "swing": swing,
    }
    return _with_free_inertia(
        request, replace(done, files=CsvFiles({"motion.csv": motion}), details=details), frame
    )


def _frame(balanced: ForceBalanced) -> TurningFrame:
    """Make the frame of a linkage without shaking force, with names that are free."""
    linkage, taken = balanced.linkage, names_taken(balanced.document)
    names = []
    for wanted in ("ground", "turning_frame", "turning_frame_mount", "free_joint"):
        names.append(free_name(wanted, taken))
        taken.add(names[-1])
    total = np.sum([body.inertia[:4] for body in linkage.bodies], axis=0)
    ground, turning, fixed, hinge = names
    axis = linkage.chain.frame.R[2]
    return TurningFrame((ground, turning, fixed), hinge, linkage, total[1:] / total[0], axis)


def _with_free_inertia(
    request: RemedyRequest, done: AppliedRemedy, frame: TurningFrame
) -> AppliedRemedy:
    """Take from the inertia of each input what the frame lets go: ``h² / J``."""
    linkage = frame.linkage
    unit = np.eye(len(linkage.inputs))
    still = np.zeros_like(unit)
    run = move_masses(linkage, drive(linkage, np.zeros(len(unit)), still, unit, still))
    J, _ = inertia_about(linkage, run.trajectory, frame.centre, frame.axis)
    freed = (run.momentum.total[:, :3] @ frame.axis) ** 2 / J
    felt = dict(zip(linkage.inputs, (-freed).tolist(), strict=True))
    return with_input_inertia(request, done, felt)
