"""Change of the reference pose: joints, bodies and frames are carried to a closed pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinematics.closure.newton import forward_kinematics
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import LinkPose, Loop, UnassembledLinkage
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.model.spatial.screws import Ad
from kinematics.numerics.array_types import Array


def rereference(
    draft: UnassembledLinkage, chain: Chain, q: Array, *, closed: bool = True
) -> UnassembledLinkage:
    """Make joint positions the reference pose of a linkage.

    Args:
        chain: its arrays, of all joints and spatial.
        q: joint positions (n,), in the units of the chain.
        closed: whether they close the loops, which then have no gaps.

    Returns:
        The linkage with screws, inertial parameters and frames at that pose.
    """
    H = [_to_inertial_frame(chain, h) for h in forward_kinematics(chain, q).H]
    before = [H[j.parent] if j.parent >= 0 else np.eye(4) for j in draft.joints]
    joints = tuple(
        replace(
            joint,
            screw=freeze(Ad(h) @ joint.screw),
            point=freeze(h[:3, :3] @ joint.point + h[:3, 3]),
        )
        for joint, h in zip(draft.joints, before, strict=True)
    )
    bodies = tuple(
        replace(
            body,
            inertia=freeze(displace_parameters(body.inertia, H[body.link])),
            frame=freeze(H[body.link] @ body.frame),
        )
        for body in draft.bodies
    )
    places = {
        name: place
        if place.link < 0
        else LinkPose(place.link, freeze(H[place.link] @ place.pose))
        for name, place in draft.places.items()
    }
    positions = draft.displaced
    if q.any():
        positions = freeze(q * chain.units + (0.0 if positions is None else positions))
    return replace(
        draft,
        joints=joints,
        bodies=bodies,
        places=places,
        displaced=positions,
        loops=tuple(
            replace(loop, gap=freeze(np.eye(4) if closed else _gap_there(loop, H)))
            for loop in draft.loops
        ),
    )


def _gap_there(loop: Loop, H: list[Array]) -> Array:
    """Compute the gap of a loop at another pose, ``H_successor gap H_end⁻¹``."""
    successor = H[loop.successor] if loop.successor >= 0 else np.eye(4)
    return np.asarray(successor @ loop.gap @ np.linalg.inv(H[loop.end]))


def _to_inertial_frame(chain: Chain, H: Array) -> Array:
    """Convert a displacement in the coordinates of the chain to one of inertial space."""
    out, o = H.copy(), chain.frame.origin
    out[:3, 3] = chain.frame.length * H[:3, 3] + o - H[:3, :3] @ o
    return out
