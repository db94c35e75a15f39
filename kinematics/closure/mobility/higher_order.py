"""Local mobility beyond the first order: the modes of motion through a singular pose.

Joint rates that close the loops at first order span the freedoms F of a pose. Where they are
more than the linkage really has, the closed poses do not form a smooth surface there: near
that pose they form a cone, whose section by a small sphere in F, its *link*, determines the
modes (J. Milnor, "Singular points of complex hypersurfaces", 1968; A. Müller, "Local
kinematic analysis of closed-loop linkages", 2019); see
`kinematics.closure.mobility.motion_modes`. If it is empty, no pose is left: the linkage moves
only infinitesimally, up to the order at which the loops stop closing, which is the exponent k
of the least residual ``c ε^k`` at the distance ε.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from kinematics.closure.mobility.finite_pose import finite_pose
from kinematics.closure.mobility.first_order import first_order, step_along
from kinematics.closure.mobility.motion_modes import ModeSearch, closest_pose, find_modes
from kinematics.closure.mobility.reachable_modes import ReachableMode, reachable_modes
from kinematics.closure.series import expand, loop_matrix
from kinematics.model.arrays import Chain
from kinematics.model.chain import move_chain
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import first_basis, first_largest
from kinematics.numerics.tolerances import (
    LOOP_RANK_RELATIVE,
    NEAR_SINGULAR_RESIDUAL,
)

# Radii of the sphere about the pose (radians, characteristic lengths). They shrink until two
# of them give the same modes.
SPHERE_RADII = (0.06, 0.02, 0.006)
# Highest order at which loops are tested.
MAX_ORDER = 8
# Most starts of the search for the least residual.
MAX_STARTS = 240
# Most starts times the square of the number of joints, with which the cost of a start grows.
MAX_WORK = 400_000
# Seed of the directions in which the search starts.
SEED = 4


class LocalMobility(NamedTuple):
    """Degrees of freedom of a linkage near a pose; n joints.

    Attributes:
        freedom: degrees of freedom at first order.
        order: at which the loops stop closing if no motion leaves the pose, otherwise 0.
        modes: the motions through the pose, and those that they lead to; none if it is the
            only pose.
        doubt: why there may be more modes; empty if nothing speaks for it.
    """

    freedom: int
    order: int
    modes: tuple[ReachableMode, ...]
    doubt: str = ""

    @property
    def mobility(self) -> int:
        """Most degrees of freedom of a mode, 0 without one."""
        return max((mode.mobility for mode in self.modes), default=0)


def analyse_local_mobility(
    chain: Chain, turning: Flags, tolerance: float = LOOP_RANK_RELATIVE
) -> LocalMobility:
    """Find the modes of motion through the reference pose of a chain with closed loops.

    Args:
        chain: joints that one another's motion depends on; spatial, nothing chosen as
            independent.
        turning: joints that are in the same place after a full turn (n,).
        tolerance: relative size of singular values of the loop matrix that count as zero.
    """
    kernel, _ = first_order(loop_matrix(chain), tolerance)
    N, freedom = first_basis(kernel.T).T, kernel.shape[1]
    if freedom == 0:
        return LocalMobility(0, 1, ())
    if freedom == 1:
        order = _order_of_single_freedom(chain, N)
        if (
            order
            or closest_pose(chain, N, SPHERE_RADII[0], N[:, 0])[1] > NEAR_SINGULAR_RESIDUAL
        ):
            return LocalMobility(1, order or MAX_ORDER, ())
        far = step_along(chain, SPHERE_RADII[0] * N[:, 0])
        return LocalMobility(1, 0, (ReachableMode(1, far, True),))
    search, seen = ModeSearch(()), None
    for distance in SPHERE_RADII:
        search = find_modes(chain, N, distance)
        mobilities = [mode.mobility for mode in search.modes]
        if seen == mobilities:
            break
        seen = mobilities
    else:
        text = "other ones are found nearer to the pose"
        search = search._replace(doubt=search.doubt or text)
    if not search.modes:
        return LocalMobility(freedom, _estimate_order(chain, N), ())
    if len(search.modes) == 1:
        (mode,) = search.modes
        far = finite_pose(chain, mode.poses)
        return LocalMobility(
            freedom, 0, (ReachableMode(mode.mobility, far, True),), search.doubt
        )
    return LocalMobility(freedom, 0, *reachable_modes(chain, search, distance, turning))


def _order_of_single_freedom(chain: Chain, N: Array) -> int:
    """Find the order at which a single freedom stops closing the loops; 0 if none is found."""
    joint = first_largest(np.abs(N[:, 0]))
    moved = move_chain(chain, np.array([joint]), np.eye(1))
    return expand(moved, np.ones((1, 1)), MAX_ORDER - 1).open_order


def _start_directions(N: Array) -> Iterator[Array]:
    """Yield directions in the freedoms of a pose, evenly in two of them, at random in more."""
    rng = np.random.default_rng(SEED)
    freedom = N.shape[1]
    if freedom == 2:
        for angle in np.linspace(0.0, 2 * np.pi, 32, endpoint=False) + 0.05:
            yield N @ [np.cos(angle), np.sin(angle)]
        return
    for _ in range(min(48 * (freedom - 1), MAX_STARTS, MAX_WORK // len(N) ** 2)):
        v = N @ rng.standard_normal(freedom)
        yield v / np.linalg.norm(v)


def _estimate_order(chain: Chain, N: Array) -> int:
    """Estimate the order at which no direction closes the loops, from the least residuals.

    The residual at the distance ε is ``c ε^k``: k follows from two distances.
    """
    least = []
    for distance in (0.1, 0.05):
        residuals = [
            closest_pose(chain, N, distance, start)[1] for start in _start_directions(N)
        ]
        least.append(min(residuals))
    return int(np.clip(np.rint(np.log2(least[0] / least[1])), 2, MAX_ORDER))
