"""The conditions on springs that balance gravity, from closed poses of a workspace."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice

import numpy as np

from balance.masses.springs.attached_springs import AttachedSpring
from balance.masses.springs.gradient_rows import gradient_rows
from balance.masses.springs.spring_cone import SpringCone, make_cone
from balance.motion.verification.holding_torques import Weights, weights_of
from balance.motion.verification.joint_limits import joint_limits
from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Conditions
from balance.support.tolerances import SPRING_TORQUE_LEFT
from kinematics.closure.continuation import continue_in_directions
from kinematics.closure.joint_positions import check_inputs, input_chain, joint_positions
from kinematics.closure.newton import Pose, expand_at, forward_kinematics
from kinematics.errors import LinkageError, PoseError, UnreachedError, UsageError
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Seeds of the rays that give conditions, and of those that check them.
CONDITION_RAYS, FRESH_RAYS = 108, 109
# Poses of the first batch of conditions, most batches, and poses of the check.
FIRST_BATCH, BATCHES, FRESH_POSES = 12, 5, 24

# Poses of a workspace: with one input, and with several.
POSES_OF_ONE, POSES_OF_SEVERAL = 61, 96
# Range of an input each way where neither the file nor a caller gives one, rad and
# characteristic lengths.
DEFAULT_RANGE = 1.0
# Poses at which links are compared, and angular velocities that are alike for unit rates.
TURN_POSES, TURNS_ALIKE = 6, 1e-9
# Generic rays along which a linkage is followed for conditions.
RAYS = 2


class SpringProblem:
    """Springs of a linkage: conditions of balance, and torques over a workspace.

    Attributes:
        linkage: the linkage.
        springs: the springs.
        weights: the masses that gravity acts on.
        force: weight of all masses, N.
        length: characteristic length, metres.
        unit: stiffness that counts as 1, N/m: weight over characteristic length.
    """

    def __init__(
        self,
        linkage: Linkage,
        springs: Sequence[AttachedSpring],
        gravity: Array,
        ranges: Mapping[str, tuple[float, float]],
    ) -> None:
        """Keep what is asked for.

        Raises:
            LinkageError: there is no gravity, no mass, or no work of gravity.
            PoseError: a range names no input, or no pose is reached.
            UsageError: a range is empty.
        """
        self.linkage, self.springs = linkage, tuple(springs)
        self._chain = input_chain(linkage)
        self.length = self._chain.frame.length
        self.weights: Weights = weights_of(linkage, self._chain.frame, gravity)
        mass = float(self.weights.moments[:, 0].sum())
        self.force = mass * float(np.linalg.norm(gravity))
        if not self.force > 0.0:
            raise LinkageError(
                f"{linkage.source}: no gravity acts: give the moving links masses, and "
                "--gravity a direction"
            )
        self.unit = self.force / self.length
        self.ranges = _input_ranges(linkage, ranges)
        if not self._gravity_works():
            raise LinkageError(
                f"{linkage.source}: gravity does no work in any motion: there is nothing to "
                "balance; another direction is given by --gravity"
            )

    def _gravity_works(self) -> bool:
        """Whether gravity does work at poses of generic motions."""
        work = max(np.abs(rows[:, -1]).max(initial=0.0) for rows in self._first_batch)
        return bool(work > SPRING_TORQUE_LEFT)

    def rows_at(self, chain: Chain, pose: Pose) -> Array:
        """Differentiate the energies at a pose, in units of weight times length.

        Returns:
            Shape (w, unknowns + 1); unknowns are stiffnesses in `unit`, and these times the
            free coordinates in halves of their boxes.
        """
        rows = gradient_rows(chain, pose, self.springs, self.weights)
        rows[:, -1] /= self.force * self.length
        return rows

    @cached_property
    def _rows(self) -> Iterator[Array]:
        """Rows at poses of generic motions, one pose after the other."""
        return (self.rows_at(*pose) for pose in _generic_poses(self.linkage, CONDITION_RAYS))

    @cached_property
    def _first_batch(self) -> list[Array]:
        """Rows at the first poses.

        Raises:
            LinkageError: there is no pose.
        """
        return self._checked(list(islice(self._rows, FIRST_BATCH)))

    def _checked(self, rows: list[Array]) -> list[Array]:
        """Return rows at poses, if there are any."""
        if not rows:
            raise LinkageError(
                f"{self.linkage.source}: no closed pose was found near the reference pose; "
                "write the file at a pose further from a singularity"
            )
        return rows

    @cached_property
    def conditions(self) -> tuple[Conditions, bool]:
        """All conditions on the unknowns and gravity, and whether further poses add none."""
        batch = self._first_batch
        unknowns = batch[0].shape[1]
        conditions = Conditions.given(np.empty((0, unknowns)), relative_tolerance(self._chain))
        settled = False
        for k in range(1, BATCHES + 1):
            before = conditions.rank
            blocks = [rows / (np.linalg.norm(rows) or 1.0) for rows in batch]
            conditions = conditions.append(np.concatenate(blocks))
            settled = conditions.rank == before or conditions.complete
            batch = [] if settled else list(islice(self._rows, FIRST_BATCH * 2**k))
            if not batch:
                break
        return conditions, settled

    @cached_property
    def turns(self) -> list[int]:
        """Number of the angle of each link: links that turn alike have one, 0 is none."""
        poses = list(islice(_generic_poses(self.linkage, FRESH_RAYS), TURN_POSES))
        rates = np.array([expand_at(chain, pose).T[0, 0][..., :3] for chain, pose in poses])
        kinds = [np.zeros_like(rates[:, 0])]
        numbers = []
        for link in range(len(self.linkage.joints)):
            alike = (np.abs(rates[:, link] - kind).max() < TURNS_ALIKE for kind in kinds)
            number = next((k for k, same in enumerate(alike) if same), len(kinds))
            kinds += [rates[:, link]] if number == len(kinds) else []
            numbers.append(number)
        return numbers

    @cached_property
    def workspace(self) -> tuple[list[Pose], Array]:
        """Poses of the workspace, and the inputs there (poses, inputs)."""
        return _workspace_poses(self.linkage, self.ranges)

    @cached_property
    def torque_rows(self) -> Array:
        """Rows at the poses of the workspace (poses, inputs, unknowns + 1)."""
        return np.stack([self.rows_at(self._chain, pose) for pose in self.workspace[0]])

    @cached_property
    def torque_triangle(self) -> Array:
        """A triangle R (n, unknowns + 1) with ``|R [x; 1]|`` as the torques of all poses."""
        rows = self.torque_rows
        return np.asarray(np.linalg.qr(rows.reshape(-1, rows.shape[-1]), mode="r"))

    @cached_property
    def cone(self) -> SpringCone:
        """The limits of the springs as they are asked for."""
        given = [spring.asked.stiffness for spring in self.springs]
        return make_cone(self.springs, self.unit, given)

    def torques(self, x: Array | None) -> Array:
        """Compute what the inputs hold over the workspace (poses, inputs), N m and N.

        Args:
            x: unknowns; None for gravity alone.
        """
        rows = self.torque_rows
        values = rows[..., -1] if x is None else rows @ np.append(x, 1.0)
        at = self.linkage.positions_of(self.linkage.inputs)
        return np.asarray(values * self.force * self.length / self._chain.units[at])

    def fresh_torque(self, x: Array) -> tuple[float, int]:
        """Measure the largest torque left at poses that decided nothing, over that of gravity.

        Returns:
            The largest torque over the largest of gravity, and the number of poses.
        """
        poses = islice(_generic_poses(self.linkage, FRESH_RAYS), FRESH_POSES)
        rows = self._checked([self.rows_at(*pose) for pose in poses])
        largest = max(np.abs(row @ np.append(x, 1.0)).max() for row in rows)
        return float(largest / max(np.abs(row[:, -1]).max() for row in rows)), len(rows)


def _input_ranges(linkage: Linkage, ranges: Mapping[str, tuple[float, float]]) -> Array:
    """Read the ranges of the inputs (2, inputs), radians and metres.

    Those that are not given are the limits in the file, and without limits 1 rad or one
    characteristic length each way.

    Args:
        ranges: by name of input.

    Raises:
        PoseError: a name is not that of an input.
        UsageError: a range is empty.
    """
    check_inputs(linkage, ranges)
    at, chain = linkage.positions_of(linkage.inputs), input_chain(linkage)
    whole = DEFAULT_RANGE * chain.units[at]
    limits = joint_limits(linkage)[:, at]
    low, high = (
        np.where(np.isfinite(x), x, sign * whole)
        for sign, x in zip((-1.0, 1.0), limits, strict=True)
    )
    for k, name in enumerate(linkage.inputs):
        if name in ranges:
            low[k], high[k] = ranges[name]
        if not low[k] < high[k]:
            raise UsageError(f"range {low[k]:g}:{high[k]:g} of {name} is empty: give low:high")
    return np.array([low, high])


def _workspace_poses(linkage: Linkage, ranges: Array) -> tuple[list[Pose], Array]:
    """Sample the poses within ranges of the inputs.

    One input takes equal steps; several take points of a fixed random sequence. Points at
    which the loops cannot be closed are left out.

    Args:
        linkage: the linkage.
        ranges: shape (2, inputs), radians and metres.

    Returns:
        The poses, in the frame of `input_chain`, and their inputs (poses, inputs).

    Raises:
        PoseError: no pose of the ranges is reached.
    """
    chain, (low, high) = input_chain(linkage), ranges
    if low.size == 1:
        shares = np.linspace(0.0, 1.0, POSES_OF_ONE)[:, None]
    else:
        shares = np.random.default_rng(107).random((POSES_OF_SEVERAL, low.size))
    poses, reached = [], []
    for point in low + shares * (high - low):
        try:
            q = joint_positions(linkage, point)
        except UnreachedError:
            continue
        poses.append(forward_kinematics(chain, q / chain.units))
        reached.append(point)
    if not poses:
        raise PoseError(
            f"{linkage.source}: no pose of the ranges is reached: give smaller ones"
        )
    return poses, np.array(reached)


def _generic_poses(linkage: Linkage, seed: int) -> Iterator[tuple[Chain, Pose]]:
    """Follow the linkage along generic rays, both ways.

    Args:
        linkage: the linkage.
        seed: of the rays.

    Raises:
        LinkageError: it has no motion.
    """
    chain = input_chain(linkage)
    if chain.width == 0:
        raise LinkageError(f"{linkage.source}: does not move: springs have nothing to balance")
    rays = np.random.default_rng(seed).standard_normal((RAYS, chain.width))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    return continue_in_directions(chain, rays)
