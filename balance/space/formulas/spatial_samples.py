"""Conditions of spatial linkages at random dimensions, and their check at finite poses.

Numbers are those of K. Hensel (1904): modulo ``p^n`` a displacement by a multiple of p is
small, and Newton's method gains a digit in each step.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

from balance.space.formulas.geometry_samples import EXTENTS, ConditionSamples
from balance.space.formulas.interpolation import cosine_sine
from balance.space.formulas.modular_conditions import ModularRow
from balance.space.formulas.modular_pose import UnclosedError
from balance.space.formulas.spatial_dimensions import SpatialDimensions
from balance.space.formulas.spatial_motion import SpatialMotion
from balance.space.formulas.spatial_parts import SpatialParts
from balance.space.formulas.spatial_pose import (
    JointValues,
    ModularFrame,
    Move,
    SpatialPose,
    Value,
    draw_joint_values,
    moved,
    place_parts,
)
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS, echelon_modulo

# Numbers of orders after which the rank has stayed the same and counts as final.
SURE_EXTENTS = 3
# Digits of a displacement beyond the orders of the series that the rank needs.
SPARE_DIGITS = 3
# Poses drawn until one has the mobility of the linkage.
MAX_DRAWS = 20


class SpatialSamples(ConditionSamples):
    """Echelon forms at dimensions whose conditions have a known rank."""

    free: SpatialDimensions

    def __init__(
        self,
        linkage: SpatialParts,
        free: SpatialDimensions,
        force: bool,
        target: int,
        deadline: float | None = None,
    ) -> None:
        """Find how many orders and rays the rank needs.

        Raises:
            UnclosedError: dimensions drawn at random have another mobility, or another rank.
        """
        self.linkage, self.free, self.force, self.target = linkage, free, force, target
        super().__init__(deadline)
        self.width = len(linkage.body_parts) * (4 if force else 10)
        p = PRIMES_OF_61_BITS[0]
        point = free.draw(p, self.rng)
        counts: list[int] = []
        for self.extent in EXTENTS:
            self.check_time()
            counts.append(len(self._reduced(point, p)))
            if counts[-1] > target or counts[-SURE_EXTENTS:] == [target] * SURE_EXTENTS:
                break
        if counts[-1] != target:
            raise UnclosedError
        self.extent = EXTENTS[counts.index(target)]
        self.start(self._reduced(point, p))

    def draw_joints(self, point: Sequence[int], p: int) -> JointValues:
        """Draw positions of the joints at values of the free dimensions."""
        tangents: dict[int, int] = {}
        if (loop := self.free.proportional) is not None:
            twists = {i: x for i, x in zip(self.free.free, point, strict=True)}
            t, u = twists[loop.first_twist], twists[loop.second_twist]
            ratio = (t + u) * pow(t - u, -1, p) % p
            tangents[1] = self.rng.randrange(1, p)
            tangents[2] = ratio * pow(tangents[1], -1, p) % p
        return draw_joint_values(self.linkage, p, self.rng, tangents.get)

    def motion_at(self, values: Sequence[Value], joints: JointValues, p: int) -> SpatialMotion:
        """Prepare the motion at a pose."""
        return SpatialMotion(self.linkage, place_parts(self.linkage, values, joints, p), p)

    def _motion(self, point: Sequence[int], p: int) -> SpatialMotion:
        values = self.free.pairs(point, p)
        for _ in range(MAX_DRAWS):
            motion = self.motion_at(values, self.draw_joints(point, p), p)
            if len(motion.columns) == self.linkage.freedoms:
                return motion
        raise UnclosedError

    def _reduced(self, point: Sequence[int], p: int) -> list[ModularRow]:
        """Reduce the conditions of a motion."""
        order, rays = self.extent
        motion, rows = self._motion(point, p), list[ModularRow]()
        for _ in range(rays if len(motion.columns) > 1 else 1):
            ray = [self.rng.randrange(1, p) for _ in motion.columns]
            rows += motion.rows_along(ray, order, self.linkage.body_parts, self.force)
        return echelon_modulo(rows, range(self.width), p)[0]

    def rows(self, point: Sequence[int], p: int) -> list[ModularRow]:
        """Compute independent conditions at values of the free dimensions."""
        self.check_time()
        rows = self._reduced(point, p)
        if len(rows) != self.target:
            raise UnclosedError
        return rows

    def agree(
        self, conditions: Callable[[int], list[ModularRow]], point: Sequence[int], p: int
    ) -> bool:
        """Check conditions at finite poses: masses that fulfil them have no momentum there.

        An open chain is put into poses drawn at random. A loop is displaced by multiples of p
        and closed by Newton's method modulo a power of p, so that the conditions are checked to
        as many orders of the displacement.

        Args:
            conditions: computes rows modulo a number, each with 1 where it is solved.
            point: values of the free dimensions.
            p: a prime.
        """
        order, rays = self.extent
        modulus = p ** (order + SPARE_DIGITS) if self.linkage.closed else p
        rows = conditions(modulus)
        if len(rows) != self.target:
            return False
        values = self.free.pairs(point, modulus)
        poses = rays + 1 if self.linkage.closed else self.target + 1
        joints = self.draw_joints(point, modulus)
        for _ in range(poses):
            if self.linkage.closed:
                pose = displaced_pose(self.linkage, values, joints, p, modulus, self.rng)
            else:
                joints = self.draw_joints(point, modulus)
                pose = place_parts(self.linkage, values, joints, modulus)
            if pose is None:
                return False
            motion = SpatialMotion(self.linkage, pose, modulus)
            for column in range(len(motion.columns)):
                ray = [int(w == column) for w in range(len(motion.columns))]
                momenta = motion.rows_along(ray, 0, self.linkage.body_parts, self.force)
                if not _annihilated(rows, self.solved, momenta, modulus):
                    return False
        return True


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


def _annihilated(
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
        residual = list(momentum)
        for row, column in zip(rows, solved, strict=True):
            if factor := momentum[column]:
                residual = [(x - factor * y) % q for x, y in zip(residual, row, strict=True)]
        if any(residual):
            return False
    return True
