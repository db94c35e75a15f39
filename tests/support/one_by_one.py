"""Ordinary design spaces of the geometries that `balance.space.design_space_many` takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import balance
from balance.space.spaces.design_space import DesignSpace
from kinematics.closure.assembly.assemble import assemble
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage


def one_by_one(
    linkage: Linkage, screws: np.ndarray, **options: object
) -> Iterator[DesignSpace]:
    """Assemble the linkage with each set of screws, and compute its space."""
    for some in screws:
        joints = []
        for joint, screw in zip(linkage.joints, some, strict=True):
            n, v = screw[:3], screw[3:]
            point = np.cross(n, v) + n * (n @ joint.point) if n.any() else joint.point
            joints.append(replace(joint, screw=freeze(screw), point=freeze(point)))
        moved = assemble(replace(linkage, joints=tuple(joints)), linkage.inputs)
        yield balance.design_space(moved, **options)


def integers(space: DesignSpace) -> tuple[int, int, int, int]:
    """Rank, nullity, serial nullity and kmax, as `ManySpaces` writes them."""
    kmax = -1 if space.kmax is None else space.kmax
    return space.rank, space.nullity, space.serial_nullity, kmax
