"""All modes that a linkage can change to from a singular pose, at it or further along a curve.

Modes of one degree of freedom are followed all around: branches on one curve are one mode, and
where a curve passes another singular pose, the modes that cross there are added. Modes of more
degrees of freedom are those that meet at the first pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.mobility.finite_pose import finite_pose
from kinematics.closure.mobility.first_order import first_order
from kinematics.closure.mobility.mode_curves import ModeCurve, trace_curve, within_turn
from kinematics.closure.mobility.motion_modes import Mode, ModeSearch, find_modes
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain, freeze
from kinematics.numerics.linalg.ties import first_basis

Array = NDArray[np.float64]

# Most modes, and most singular poses, that are looked at.
MAX_MODES, MAX_NODES = 24, 12
# Relative size of singular values that count as zero at a singular pose on a curve: the pose is
# known to this part of the size of the linkage.
NODE_RANK_RELATIVE = 1e-5
# Difference of joint positions of two singular poses that are the same.
SAME_NODE = 1e-3


class ReachableMode(NamedTuple):
    """A mode, and a pose on it.

    Attributes:
        mobility: its degrees of freedom.
        q: joint positions (n,) of a well conditioned closed pose on it, chain units.
        here: whether it passes the first singular pose itself.
    """

    mobility: int
    q: Array
    here: bool


class ReachableModes(NamedTuple):
    """Modes that a linkage can change to.

    Attributes:
        modes: those that meet at the pose, in their order; then others, in the order in which
            singular poses are met.
        doubt: why there may be more; empty if nothing speaks for it.
    """

    modes: tuple[ReachableMode, ...]
    doubt: str


def reachable_modes(
    chain: Chain, search: ModeSearch, distance: float, turning: NDArray[np.bool_]
) -> ReachableModes:
    """List the modes at a singular pose, and those further along modes of one freedom.

    Args:
        chain: joints in loops that are closed; the singular pose is its reference pose.
        search: the modes that meet there, from `find_modes`.
        distance: of the poses on each mode from the singular pose.
        turning: joints that are in the same place after a full turn (n,).
    """
    doubts = [search.doubt]
    curves: list[ModeCurve] = []
    reached: list[ReachableMode] = []
    nodes = [np.zeros(chain.parent.size)]

    def visit(local: Sequence[Mode], node: Array, at_node: Chain) -> None:
        here = node is nodes[0]
        for mode in local:
            if len(reached) == MAX_MODES:
                doubts.append(f"no more than {MAX_MODES} are listed")
                return
            near = mode.poses[0]
            if mode.mobility == 1:
                pose = near._replace(q=node + near.q)
                if any(curve.passes(chain, pose.q, turning) for curve in curves):
                    continue
                curves.append(trace_curve(chain, pose, turning))
            elif not here:
                continue
            far = node + finite_pose(at_node, mode.poses)
            reached.append(ReachableMode(mode.mobility, far, here))

    visit(search.modes, nodes[0], chain)
    for curve in curves:  # grows on the way
        if not curve.ended:
            doubts.append("a mode was not followed to its end")
        for node in curve.nodes:
            visited = any(
                np.abs(within_turn(node - x, turning)).max() <= SAME_NODE for x in nodes
            )
            if visited:
                continue
            if len(nodes) > MAX_NODES:
                doubts.append(f"no more than {MAX_NODES} singular poses were looked at")
                break
            nodes.append(node)
            at_node = _chain_at(chain, node)
            N, _ = first_order(loop_matrix(at_node), NODE_RANK_RELATIVE)
            if N.shape[1] > 1:
                there = find_modes(at_node, first_basis(N.T).T, distance)
                doubts.append(there.doubt)
                visit(there.modes, node, at_node)
    return ReachableModes(tuple(reached), next(filter(None, doubts), ""))


def _chain_at(chain: Chain, q: Array) -> Chain:
    """Make a closed pose (n,) the reference pose of a chain."""
    return replace(chain, screws=freeze(forward_kinematics(chain, q).screws))
