"""A design space with other numbers in place of those that exact arithmetic replaces.

An angle has no rational rotation, so exact arithmetic takes one within 2^-64 of it. If that
has more conditions than floating point finds, either a special geometry needs that angle, and
is lost, or the file is special but for less than round-off elsewhere, and floating point does
not see it. Other angles, further away, tell: without them the first loses its special geometry
for floating point too, and the second keeps it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.space.many.placing_kernels import points_on_axes
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import LinkageError
from kinematics.files.urdf.rational_screws import change_replaced_numbers
from kinematics.model.arrays import freeze


def with_changed_numbers(space: DesignSpace) -> DesignSpace | None:
    """Compute the design space of the linkage with other replaced numbers, in floating point.

    Returns:
        The space; None if the linkage does not assemble with these numbers.
    """
    linkage = space.linkage
    screws = change_replaced_numbers(linkage)
    units = np.array([[float(x) for x in screw] for screw in screws])
    turns = np.any(units[:, :3], axis=1)
    n = np.where(turns[:, None], units[:, :3], units[:, 3:])
    units /= np.sqrt(np.sum(n**2, axis=1, keepdims=True))
    near = np.array([joint.point for joint in linkage.joints])
    points = np.empty_like(near)
    points_on_axes(units, near, points)
    joints = tuple(
        replace(joint, screw=freeze(screw), point=freeze(point))
        for joint, screw, point in zip(linkage.joints, units, points, strict=True)
    )
    try:
        moved = assemble(replace(linkage, joints=joints), linkage.inputs, exactly=True)
        if space.planar and not moved.planar:
            return None
        return design_space(moved, **space.options)
    except LinkageError:
        return None
