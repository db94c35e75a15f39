"""The serial design space joint by joint: inertia transfers between bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.conversions import from_chain
from balance.space.transfers.serial_part import Transfers
from balance.support.tolerances import TRANSFER_ENTRY_ROUND_OFF
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage, names_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import first_names


class Transfer(NamedTuple):
    """Inertial parameters that bodies can exchange across one joint.

    Attributes:
        joints: names of the joints of one degree of freedom that it passes through, in the
            linkage's order: several for a joint of several, and where links without
            parameters lie between; none where bodies are rigidly joined, or do not move.
        bodies: names of the bodies that take part, in their order.
        ground: whether the ground takes part too, which can take any inertia.
        basis: mass distributions of all bodies (parameters, dimension), one column per
            transfer, in the rows and units of `SpaceRecord.basis`.
        scaled: the same in the units of the chain, where columns are orthonormal.
    """

    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    ground: bool
    basis: Array
    scaled: Array

    def __repr__(self) -> str:
        """One line: how many transfers across which joints between which bodies."""
        bodies = [*(["ground"] if self.ground else []), *self.bodies]
        where = f"across {first_names(self.joints)}" if self.joints else "between rigid parts"
        return f"Transfer {where} ({first_names(bodies)}): {self.dimension} independent"

    @property
    def dimension(self) -> int:
        """Number of independent transfers."""
        return self.basis.shape[1]


def by_joint(
    linkage: Linkage, chain: Chain, transfers: Transfers, force: bool
) -> tuple[Transfer, ...]:
    """Sort transfers by joint, in SI units; those of rigid parts come last.

    Args:
        chain: the chain that the transfers are of.
        transfers: those of the chain.
        force: whether they are those of force balance.
    """
    G = from_chain(chain.frame, chain.planar, force)
    all_joints = names_of(linkage.joints)
    all_bodies = names_of(linkage.bodies)
    result = []
    for owner in dict.fromkeys([*transfers.owner_of_joint.tolist(), *transfers.owner.tolist()]):
        rows = transfers.rows[transfers.owner == owner].reshape(-1, len(all_bodies), len(G))
        scaled = np.where(np.abs(rows) <= TRANSFER_ENTRY_ROUND_OFF, 0.0, rows)
        basis = np.einsum("pq,cbq->bpc", G, scaled)
        joints = np.flatnonzero(transfers.owner_of_joint == owner).astype(np.int64)
        result.append(
            Transfer(
                tuple(all_joints[j] for j in chain.joints[joints]),
                tuple(
                    all_bodies[b]
                    for b in _participating_bodies(chain, transfers, joints, owner)
                ),
                _touches_ground(chain, transfers, joints, owner),
                freeze(basis.reshape(len(all_bodies) * len(G), len(rows))),
                freeze(scaled.reshape(len(rows), len(all_bodies) * len(G)).T),
            )
        )
    return tuple(result)


def _participating_bodies(
    chain: Chain, transfers: Transfers, joints: IntArray, owner: int
) -> list[int]:
    """List one body on each rigid part at the joints; without joints all bodies of one part."""
    part = transfers.rigid_part[chain.links].tolist()
    if not joints.size:
        return [b for b, p in enumerate(part) if p == -1 - owner]
    joined = {
        *transfers.rigid_part[joints].tolist(),
        *transfers.rigid_part[chain.parent[joints]].tolist(),
    }
    moving = joined - {transfers.owner_of_joint.size}
    return sorted(part.index(p) for p in moving if p in part)


def _touches_ground(chain: Chain, transfers: Transfers, joints: IntArray, owner: int) -> bool:
    """Whether one of the joints is at the ground, or the rigid part is the ground."""
    ground = transfers.owner_of_joint.size
    around = [
        *transfers.rigid_part[joints].tolist(),
        *transfers.rigid_part[chain.parent[joints]].tolist(),
    ]
    return ground in around or owner == -1 - ground
