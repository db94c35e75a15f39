"""A linkage at another reference pose than that of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from kinematics.assembly.assemble import assemble
from kinematics.assembly.rereference import rereference
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import CoordinateError
from kinematics.model.chain import arrange_loops
from kinematics.model.linkage import Linkage

__all__ = ["move_reference_pose"]


def move_reference_pose(
    linkage: Linkage, at: Mapping[str, float], *, exactly: bool = False
) -> Linkage:
    """Move a linkage to another pose, which becomes its reference pose.

    The inputs fix the pose. The other joints follow along the straight line of input
    displacements from the reference pose, without a change of branch.

    Args:
        linkage: an assembled linkage.
        at: coordinates of inputs at the new pose, counted from the pose of the file, in
            radians and metres; inputs that are not named stay where they are.
        exactly: as for `kinematics.assembly.assemble.assemble`.

    Returns:
        The linkage with the same inputs; whatever it holds refers to the new pose.

    Raises:
        CoordinateError: a name is not that of an input, or an input cannot drive the linkage
            at that pose.
        PoseError: the loops cannot be closed all the way to that pose.
        MobilityError: it is a pose at which branches of motion meet.
    """
    inputs = linkage.inputs
    if unknown := [name for name in at if name not in inputs]:
        problem = "not an independent coordinate, which a pose is given by"
        raise CoordinateError(linkage.source, unknown, problem, inputs)
    before = linkage.displaced
    here = dict.fromkeys(inputs, 0.0)
    if before is not None:
        here = dict(zip(inputs, before[linkage.positions_of(inputs)].tolist(), strict=True))
    q = joint_positions(linkage, {name: value - here[name] for name, value in at.items()})
    chain = arrange_loops(linkage)
    there = assemble(rereference(linkage, chain, q / chain.units), inputs, exactly=exactly)
    pose = {name: float(at.get(name, here[name])) for name in inputs}
    # Both assemblies may have made the same notices.
    return replace(there, at=pose, notices=tuple(dict.fromkeys(there.notices)))
