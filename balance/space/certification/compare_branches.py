"""Other poses nearby at which open loops close: whether the answer is another one there.

A file may leave its loops open by so much that several branches are about as near. They have
the same design space, unless one of them is special: a parallelogram has fewer conditions than
the antiparallelogram of the same bars.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.spaces.compute_space import design_space
from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.assembly.closed_component import pose_words
from kinematics.closure.assembly.rereference import rereference
from kinematics.errors import LinkageError
from kinematics.model.chain import arrange_loops
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import NAMED_POSITION


def compare_branches(space: CertifiedSpace) -> CertifiedSpace:
    """Compare the rank of a design space with those at other closed poses nearby.

    Args:
        space: the space at the pose that closes the loops of the file with the least motion.

    Returns:
        The space; with a notice ``other_branch`` if another pose has another rank. It names
        both poses, as ``--at`` takes them.
    """
    linkage = space.linkage
    if linkage.at is not None or linkage.displaced is None:
        return space
    for q in linkage.other_poses:
        try:
            rank = design_space(_move_to(linkage, q), **space.options).rank
        except LinkageError:
            continue
        if rank != space.rank:
            differ = np.flatnonzero(np.abs(q - linkage.displaced) > NAMED_POSITION).tolist()
            here, there = (pose_words(linkage, x, differ) for x in (linkage.displaced, q))
            text = (
                f"the pose that closes the loops with the least motion needs {space.rank} "
                f"conditions, another one nearby {rank}: --at {here} is the one taken, --at "
                f"{there} the other"
            )
            notice = Notice("other_branch", text)
            return replace(space, notices=(*space.notices, notice))
    return space


def _move_to(linkage: Linkage, q: Array) -> Linkage:
    """Assemble a linkage at other positions of its joints, from the pose of the file (n,)."""
    chain = arrange_loops(linkage)
    here = np.zeros(q.size) if linkage.displaced is None else linkage.displaced
    return assemble(rereference(linkage, chain, (q - here) / chain.units), linkage.inputs)
