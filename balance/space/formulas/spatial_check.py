"""Finite poses of a loop modulo a power of a prime, and conditions there.

Numbers are those of K. Hensel (1904): modulo ``p^n`` a displacement by a multiple of p is
small, and Newton's method gains a digit in each step.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from balance.space.formulas.interpolation import cosine_sine
from balance.space.formulas.spatial_motion import SpatialMotion
from balance.space.formulas.spatial_parts import SpatialParts
from balance.space.formulas.spatial_pose import (
    JointValues,
    ModularFrame,
    Move,
    SpatialPose,
    Value,
    moved,
    place_parts,
)


def displaced_pose(
    linkage: SpatialParts,
    values: Sequence[Value],
    joints: JointValues,
    p: int,
    modulus: int,
    rng: random.Random,
) -> SpatialPose | None:
    """Move a loop by multiples of p, drawn at random, and close it again.

    Args:
        linkage: a loop.
        values: of its dimensions.
        joints: positions of its joints; the ground is what fits to them.
        p: the prime.
        modulus: its power.
        rng: draws the displacements of the free joints.

    Returns:
        The pose; None if it does not close, which a pose of a linkage that moves does.
    """
    start = place_parts(linkage, values, joints, modulus)
    motion = SpatialMotion(linkage, start, modulus, related=False)
    ground = start.last
    assert ground is not None
    joints = [*joints[:-1], ()]
    steps = [0] * len(motion.rates)
    for column in motion.columns:
        steps[column] = p * rng.randrange(1, p)
    for _ in range(modulus.bit_length() // p.bit_length() + 2):
        joints = _moved_joints(linkage, joints, steps, modulus)
        pose = place_parts(linkage, values, joints, modulus)
        assert pose.last is not None
        gap = _gap(moved(pose.last, joints[-1], modulus), ground, modulus)
        if not any(gap):
            return SpatialPose(pose.parts, moved(pose.last, joints[-1], modulus))
        steps = motion.closing_step(gap)
    return None


def _moved_joints(
    linkage: SpatialParts, joints: JointValues, steps: Sequence[int], q: int
) -> JointValues:
    """Move joints by small steps, one for each rate."""
    half, at = pow(2, -1, q), iter(steps)
    out = []
    for joint, before in zip(linkage.joints, joints, strict=True):
        if joint.kind == "prismatic":
            more: tuple[Move, ...] = (Move(2, shift=next(at)),)
        else:
            axes = (0, 1, 2) if joint.kind == "spherical" else (2,)
            more = tuple(Move(axis, cosine_sine(next(at) * half % q, q)) for axis in axes)
        out.append(before + more)
    return out


def _gap(frame: ModularFrame, ground: ModularFrame, q: int) -> list[int]:
    """Compute the twist, to first order, from one frame to another; 0 between equals."""
    R = [
        [sum(frame[axis][i] * ground[axis][j] for axis in range(3)) % q for j in range(3)]
        for i in range(3)
    ]
    turned = [sum(x * y for x, y in zip(row, ground.o, strict=True)) for row in R]
    half = pow(2, -1, q)
    omega = [(R[2][1] - R[1][2]) * half, (R[0][2] - R[2][0]) * half, (R[1][0] - R[0][1]) * half]
    return [x % q for x in (*omega, *(a - b for a, b in zip(frame.o, turned, strict=True)))]


def annihilated(
    rows: Sequence[Sequence[int]],
    solved: Sequence[int],
    momenta: Sequence[Sequence[int]],
    q: int,
) -> bool:
    """Return whether all parameters that fulfil conditions have no momentum.

    Args:
        rows: of the conditions, each 1 at its solved parameter, where the others are 0.
        solved: these parameters.
        momenta: rows that give momenta from parameters.
        q: the modulus.
    """
    for momentum in momenta:
        rest = list(momentum)
        for row, column in zip(rows, solved, strict=True):
            if factor := momentum[column]:
                rest = [(x - factor * y) % q for x, y in zip(rest, row, strict=True)]
        if any(rest):
            return False
    return True
