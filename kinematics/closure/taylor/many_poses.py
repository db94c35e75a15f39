"""Taylor expansions of a closed motion about many poses, in one compiled pass.

    q(u) = q_pose + Σ_α c_α u^α          at each pose

The poses lie side by side in the lanes of vectors; see
`kinematics.closure.taylor.lane_expansion`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.assembly.assemble import moving_chain
from kinematics.closure.newton_kernels import place_poses
from kinematics.closure.taylor.lane_expansion import (
    lane_expansion_workspace,
    planar_lanes,
    spatial_lanes,
)
from kinematics.closure.taylor.layout import packed_layout
from kinematics.closure.taylor.monomials import monomial_powers, monomial_table
from kinematics.closure.taylor.taylor_motion import scaled_chain
from kinematics.errors import PoseError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage, names_of
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.tolerances import CLOSURE_CONDITION, GIVEN_POSE_RESIDUAL
from kinematics.wording import count_noun, first_names, repr_lines


@dataclass(frozen=True, eq=False)
class ManyTaylorMotions:
    """Closed motions of a linkage as Taylor polynomials about many poses.

    Points u are displacements of the inputs from a pose, or coordinates y of a restricted
    motion, ``u = motion.basis @ y``; SI units.

    Attributes:
        linkage: the linkage.
        motion: the motion that was expanded.
        joints: names of all joints of the linkage.
        exponents: multi-indices α (M, w), by degree.
        coefficients: ``c_α`` of every joint position at each pose (poses, M, n), SI units; the
            first is the pose. NaN, but for that, where the equations hardly determine a motion.
        condition: condition number of the closure equations at each pose (poses,), in units of
            the chain.
    """

    linkage: Linkage
    motion: Motion
    joints: tuple[str, ...]
    exponents: IntArray
    coefficients: Array = field(repr=False)
    condition: Array = field(repr=False)

    def __repr__(self) -> str:
        """Two lines: how many poses, order, joints and inputs."""
        return repr_lines(
            f"ManyTaylorMotions of {self.linkage.name}: "
            f"{count_noun(len(self.coefficients), 'pose')}, order {self.order}, "
            f"{count_noun(len(self.joints), 'joint')}",
            f"inputs {first_names(self.motion.inputs)}",
        )

    @property
    def order(self) -> int:
        """Highest degree."""
        return int(self.exponents.sum(axis=1).max())

    def evaluate(self, u: ArrayLike) -> Array:
        """Compute the positions of all joints at a point next to each pose.

        Args:
            u: points (poses, w) or one for all poses (w,), rad and m.

        Returns:
            Shape (poses, n), rad and m.
        """
        count, width = len(self.coefficients), self.exponents.shape[1]
        points = np.broadcast_to(np.asarray(u, dtype=np.float64), (count, width))
        powers = monomial_powers(self.exponents, points)
        q: Array = np.einsum("pm,pmn->pn", powers, self.coefficients)
        return q


def taylor_motion_many(
    linkage: Linkage,
    poses: ArrayLike,
    order: int,
    motion: str | Sequence[str] | Motion | None = None,
) -> ManyTaylorMotions:
    """Compute the Taylor expansions of the closed motion about many poses, at once.

    The coefficients are those of `kinematics.taylor_motion` for the same linkage with each of
    the poses as its reference pose.

    Args:
        linkage: an assembled linkage; see `kinematics.tool` for its inverse kinematics.
        poses: positions of all joints (poses, n), which close the loops; displacements from
            the reference pose, in radians and metres.
        order: highest degree, at least 1.
        motion: restriction of the inputs, as relations or as a `Motion`.

    Returns:
        The polynomials, in radians and metres.

    Raises:
        PoseError: the poses have another shape, are not finite or leave the loops open, or
            joints that the motion leaves idle are not at 0.
        MotionError: the motion is not one of this linkage's inputs.
        MobilityError: the linkage cannot follow the motion.
        LinkageError: there are too many coefficients.
        ValueError: the order is less than 1.

    Source:
        As `kinematics.taylor_motion`.

    Example:
        >>> import kinematics
        >>> linkage = kinematics.load("robot.urdf")
        >>> motion = kinematics.taylor_motion(linkage, order=3)
        >>> poses = [motion.polish([u]) for u in (0.0, 0.1, 0.2)]
        >>> many = kinematics.taylor_motion_many(linkage, poses, order=3)
        >>> many.coefficients.shape
        (3, 4, 4)
        >>> many.evaluate([0.1]).round(4)[0].tolist()
        [0.1, -0.1192, 0.0329, 0.0521]
    """
    if order < 1:
        raise ValueError(f"the order is at least 1, not {order}")
    given = motion_of(linkage, motion)
    motion = given or Motion.free(linkage.inputs)
    chain, scales = scaled_chain(moving_chain(linkage, given), linkage, motion)
    q = _check_shape(linkage, poses, chain)
    table = monomial_table(chain.width, order)
    layout = packed_layout(chain, order)
    screws = _carry_screws(linkage, chain, q)
    # q_k = Dq_k / k for the part of degree k, and in SI units
    parts = monomial_powers(table.exponents, 1.0 / scales)
    parts /= np.maximum(table.exponents.sum(axis=1), 1)
    units = parts[:, None] * chain.units
    coefficients = np.zeros((len(q), len(table.exponents), len(linkage.joints)))
    condition = np.empty(len(q))
    expand = planar_lanes if chain.planar else spatial_lanes
    work = lane_expansion_workspace(layout, chain.screws.shape[1])
    expand(
        layout.whole, layout.real, screws, units, chain.joints, coefficients, condition, work
    )
    coefficients[~(condition < CLOSURE_CONDITION)] = np.nan
    coefficients[:, 0] = q
    np.maximum(condition, 1.0, out=condition)  # round-off leaves less of one equation
    for result in coefficients, condition:
        result.flags.writeable = False
    return ManyTaylorMotions(
        linkage, motion, names_of(linkage.joints), table.exponents, coefficients, condition
    )


def _check_shape(linkage: Linkage, poses: ArrayLike, chain: Chain) -> Array:
    """Convert poses to an array (poses, n), and check that idle joints are at 0."""
    q = np.asarray(poses, dtype=np.float64)
    count = len(linkage.joints)
    if q.ndim != 2 or q.shape[1] != count or not np.isfinite(q).all():
        raise PoseError(
            f"{linkage.source}: poses are {count} finite joint positions each, not an array "
            f"of shape {q.shape}"
        )
    idle = np.delete(np.arange(count), chain.joints)
    moved = np.argwhere(np.abs(q[:, idle]) > GIVEN_POSE_RESIDUAL)
    if len(moved):
        pose, joint = moved[0]
        raise PoseError(
            f"{linkage.source}: joint '{linkage.joints[idle[joint]].name}' is idle in this "
            f"motion, and not at 0 in pose {pose}"
        )
    return q


def _carry_screws(linkage: Linkage, chain: Chain, q: Array) -> Array:
    """Carry the joint screws of a chain to poses (poses, n); check that its loops are closed.

    Returns:
        Shape (poses, moving joints, 6 or 3), chain units.
    """
    m, dim = (3, 3) if chain.planar else (4, 6)
    n = chain.parent.size
    screws, errors = np.empty((len(q), n, dim)), np.empty(len(q))
    workspace = np.empty((n, m, m)), np.empty((4, m, m)), np.empty(len(chain.ends) * dim)
    positions = freeze(q[:, chain.joints] / chain.units)
    place_poses(chain.walked, positions, screws, errors, workspace)
    wrong = np.flatnonzero(~(errors <= GIVEN_POSE_RESIDUAL))
    if wrong.size:
        raise PoseError(
            f"{linkage.source}: pose {wrong[0]} leaves the loops open by "
            f"{errors[wrong[0]]:.2g} (radians and characteristic lengths)"
        )
    screws.flags.writeable = False
    return screws
