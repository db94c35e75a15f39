"""Motions that excite the parameters on which balance depends, for identification.

Each input follows a Fourier series that starts and ends at rest at the reference pose,

    u(t) = Σ_k a_k sin(k ω t) + b_k (cos(k ω t) - 1),    Σ_k k a_k = 0,    Σ_k k² b_k = 0,

scaled until it reaches a limit (J. Swevers, C. Ganseman, D. B. Tükel, J. de Schutter, H. Van
Brussel, IEEE Transactions on Robotics and Automation 13(5), 1997). The shape minimises the
volume of the ellipsoid of errors, ``log det`` of the covariance of the combinations on which
balance depends, for a sensor of the six components of the base wrench whose errors of moments
are those of forces times the characteristic length (D-optimality). Random shapes are tried
first, and the best of them is improved by Powell's method; no better one is excluded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from os import PathLike
from typing import NamedTuple

import numpy as np

from balance.masses.identification.combinations import relevant_combinations
from balance.masses.identification.least_squares import complement, excited_directions
from balance.masses.identification.load_rows import load_rows
from balance.masses.identification.measurements import require_bodies
from balance.motion.motion_tolerances import CONDITIONING_LEAST
from balance.motion.quiet.limits import InputLimits, Limit, input_limits
from balance.motion.verification.given_motions import table_of_motion
from balance.motion.verification.input_paths import SinePath, input_path_data, sample_input_path
from balance.motion.verification.joint_limits import joint_limits
from balance.motion.verification.trajectory import (
    AMPLITUDE_FACTOR,
    FIRST_AMPLITUDE,
    LEAST_AMPLITUDE,
    Trajectory,
    drive,
    random_motions,
)
from balance.space.conditions.rank import singular_value_decomposition
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import GRAVITY, Balance
from balance.support.result_files import WithPage, WithPicture, write_file
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text, repr_lines

PLAN_SCHEMA = "balance.identify_plan/1"
# Random shapes that are tried, and motions that are tried in all.
STARTS = 12
TRIES = 250
# Samples of a motion per harmonic while shapes are compared, and the fewest.
SAMPLES_PER_HARMONIC = 8
FEWEST_SAMPLES = 40
# Samples of the result.
SAMPLES = 401
# Value of a shape that does not excite all combinations.
UNEXCITED = 1e6
# Part of a limit that a motion uses: between samples it may go beyond.
WITHIN_LIMITS = 0.999


class Excitation(NamedTuple):
    """How well a motion excites the combinations on which balance depends.

    Attributes:
        condition: ratio of the largest and the smallest standard error of unit combinations.
        error: geometric mean of the standard errors for one sample a second of a sensor whose
            forces have errors of 1 N, and moments of as many N m as `DesignSpace.length` has
            metres: masses in kg.
    """

    condition: float
    error: float


@dataclass(frozen=True, eq=False)
class ExcitingMotion(WithPage, WithPicture):
    """Result of `exciting_motion`.

    Attributes:
        space: the design space of the linkage.
        path: the inputs as functions of time.
        duration: seconds.
        harmonics: number of harmonics.
        limits: limits of the inputs.
        excitation: how well it excites the combinations on which balance depends.
        random: the same of the random shapes that were tried, the median.
        tries: number of motions tried.
        seed: seed of the search.
        trajectory: the motion of all joints.
    """

    page_maker = "identification:plan_page"
    picture_maker = "identification:plan_picture"

    space: DesignSpace
    path: SinePath
    duration: float
    harmonics: int
    limits: InputLimits
    excitation: Excitation
    random: Excitation
    tries: int
    seed: int
    trajectory: Trajectory

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the linkage."""
        return self.space.linkage.notices

    @property
    def words(self) -> str:
        """What was found, in words."""
        gain = number_text(self.random.error / self.excitation.error, ".3g")
        return (
            f"best of {self.tries} motions with seed {self.seed}: standard errors {gain} times "
            f"smaller than of a random one; condition {number_text(self.excitation.condition)} "
            f"instead of {number_text(self.random.condition)}"
        )

    def __repr__(self) -> str:
        """Two lines: the duration, and what was found."""
        name = self.space.linkage.name
        return repr_lines(
            f"ExcitingMotion of {name}, {number_text(self.duration)} s", self.words
        )

    def samples(self, count: int) -> tuple[Array, ...]:
        """Compute time, inputs, velocities and accelerations at even times.

        Args:
            count: number of samples.
        """
        return sample_input_path(self.path, self.duration, count)

    def table(self, path: str | PathLike[str] | None = None) -> bytes:
        """Write the motion as a table that ``balance verify --csv`` reads.

        Args:
            path: file to write it to; None for none.

        Raises:
            FileError: the file cannot be written.
        """
        return write_file(path, table_of_motion(self.space.linkage, self.samples))

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/identify.schema.json``."""
        motion = self.samples(101)
        inputs = self.space.linkage.inputs
        peaks = (np.abs(values).max(axis=0).tolist() for values in motion[1:])
        return {
            "schema": PLAN_SCHEMA,
            "model": self.space.linkage.name,
            "at": self.space.linkage.at,
            "balance": self.space.balance,
            "words": self.words,
            "duration": self.duration,
            "harmonics": self.harmonics,
            "seed": self.seed,
            "tries": self.tries,
            "relevant": self.space.rank,
            "planned": self.excitation._asdict(),
            "random": self.random._asdict(),
            "peaks": {
                name: {"position": a, "velocity": b, "acceleration": c}
                for name, a, b, c in zip(inputs, *peaks, strict=True)
            },
            "motion": input_path_data(*motion),
            "warnings": [notice.to_dict() for notice in self.notices],
        }


def exciting_motion(
    linkage: LinkageLike,
    duration: float = 5.0,
    *,
    harmonics: int = 4,
    velocity: Limit = None,
    acceleration: Limit = None,
    file_limits: bool = True,
    seed: int = 0,
    tries: int = TRIES,
    balance: Balance = "dynamic",
    spatial: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> ExcitingMotion:
    """Plan a motion that excites the parameters on which balance depends.

    It starts and ends at rest at the reference pose. Limits of speed and acceleration scale
    with the duration: without any, a shorter motion is always the better one.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        duration: seconds.
        harmonics: number of harmonics of each input, at least 2.
        velocity: largest speed of every input, or by name, rad/s and m/s.
        acceleration: largest acceleration, rad/s² and m/s².
        file_limits: whether limits of positions and speeds in the file count.
        seed: seed of the search.
        tries: number of motions that are tried.
        balance: ``"dynamic"``, or ``"force"`` for combinations on which forces alone depend.
        spatial: count ten parameters per body, even if the linkage is planar.
        progress: called with the number of motions tried and of all.

    Returns:
        The best motion that was found.

    Raises:
        UsageError: an option is out of range.
        PoseError: no motion was found near the reference pose.
        FileError: no link that moves has an inertia.

    Source: J. Swevers et al., IEEE Transactions on Robotics and Automation 13(5), 1997.

    Example:
        >>> import balance
        >>> plan = balance.masses.exciting_motion("robot.urdf", 2.0, tries=15)
        >>> plan.excitation.error <= plan.random.error
        True
    """
    linkage = as_linkage(linkage)
    require_bodies(linkage)
    if not (np.isfinite(duration) and duration > 0.0):
        raise UsageError(f"duration: {duration:g} s is not above 0")
    if harmonics < 2:
        raise UsageError("harmonics: a motion from rest to rest needs two or more")
    if tries < 1:
        raise UsageError("tries: at least one motion has to be tried")
    limits = input_limits(linkage, velocity, acceleration, file=file_limits)
    space = design_space(linkage, None, balance, spatial=spatial)
    search = _Search(space, duration, harmonics, limits, file_limits)
    rng = np.random.default_rng(seed)
    starts = [rng.normal(size=search.width) for _ in range(min(STARTS, tries))]
    values = []
    for shape in starts:
        values.append(search.value(shape))
        if progress is not None:
            progress(search.tries, tries)
    if min(values) >= UNEXCITED:
        raise PoseError(
            f"{linkage.source}: no motion near the reference pose excites what balance depends "
            "on; write the file at a pose further from a singularity"
        )
    middle = starts[int(np.argsort(values)[len(values) // 2])]
    random = search.excitation(search.follow(middle)[1])
    best = starts[first_least(values)]
    if tries > len(starts):
        best = search.improve(best, tries, progress)
    path, trajectory = search.follow(best, SAMPLES)
    return ExcitingMotion(
        space,
        path,
        duration,
        harmonics,
        limits,
        search.excitation(trajectory),
        random,
        search.tries,
        seed,
        trajectory,
    )


class _Search:
    """Shapes of motions, and how well they excite the parameters.

    Attributes:
        width: number of coordinates of a shape.
        tries: number of shapes that were tried.
    """

    def __init__(
        self,
        space: DesignSpace,
        duration: float,
        harmonics: int,
        limits: InputLimits,
        file_limits: bool,
    ) -> None:
        """Find out which directions of the parameters motions can excite."""
        self._space, self._linkage = space, space.linkage
        self._duration, self._harmonics, self._limits = duration, harmonics, limits
        k = np.arange(1.0, harmonics + 1.0)
        # Harmonics k get amplitudes of the size 1/k.
        self._sines, self._cosines = (
            complement((row / np.linalg.norm(row))[:, None]) / k[:, None]
            for row in (np.ones(harmonics), k)
        )
        self._inputs = space.linkage.mobility
        self.width = 2 * (harmonics - 1) * self._inputs
        self._count = max(FEWEST_SAMPLES, SAMPLES_PER_HARMONIC * harmonics)
        self._joints = joint_limits(space.linkage) if file_limits else None
        self.tries = 0
        (way,) = random_motions(self._linkage, 1, self._count)
        self._V = excited_directions(self._rows(way))
        self._relevant = relevant_combinations(space, self._V).directions.T @ self._V

    def _rows(self, trajectory: Trajectory) -> Array:
        """Compute rows of the wrench of a sensor, moments in characteristic lengths."""
        frame = input_chain(self._linkage).frame
        wrench = load_rows(self._linkage, trajectory, np.array(GRAVITY), frame.origin).wrench
        weight = np.repeat([1.0, 1.0 / frame.length], 3)[:, None]
        root = np.sqrt(trajectory.duration / len(wrench))
        return np.asarray(root * (weight * wrench).reshape(-1, wrench.shape[2]))

    def path(self, shape: Array, scale: float) -> SinePath:
        """Build the motion of the inputs."""
        half = shape.reshape(2, self._harmonics - 1, self._inputs)
        a, b = self._sines @ half[0], self._cosines @ half[1]
        # a sin x + b (cos x - 1) = A (sin(x + φ) - sin φ)
        return SinePath(
            np.hypot(a, b), np.arctan2(b, a), self._duration, np.eye(self._inputs), scale
        )

    def _scale(self, shape: Array) -> float:
        """Compute the largest scale within the limits of the inputs."""
        time = np.linspace(0.0, self._duration, SAMPLES)
        motions, limits = self.path(shape, 1.0).at(time), self._limits
        units = input_chain(self._linkage).units[
            self._linkage.positions_of(self._linkage.inputs)
        ]
        ratios = [FIRST_AMPLITUDE * units / np.abs(motions[0]).max(axis=0)]
        for kind, values in enumerate(motions):
            for limit, most in (
                (limits.upper[kind], values.max(axis=0)),
                (-limits.lower[kind], -values.min(axis=0)),
            ):
                ratios.append(np.where(most > 0.0, limit / np.maximum(most, 1e-300), np.inf))
        return WITHIN_LIMITS * float(np.min(ratios))

    def follow(self, shape: Array, count: int = 0) -> tuple[SinePath, Trajectory]:
        """Follow the motion of a shape, smaller until its loops close.

        Raises:
            PoseError: it cannot be followed.
        """
        scale = self._scale(shape)
        least = LEAST_AMPLITUDE * scale
        time = np.linspace(0.0, self._duration, count or self._count)
        while scale > least:
            path = self.path(shape, scale)
            try:
                trajectory = drive(self._linkage, time, *path.at(time))
            except PoseError:
                trajectory = None
            if trajectory is not None and self._keeps(trajectory):
                return path, replace(trajectory, path=path)
            scale *= AMPLITUDE_FACTOR
        raise PoseError(f"{self._linkage.source}: no motion was found near the reference pose")

    def _keeps(self, trajectory: Trajectory) -> bool:
        """Whether a motion keeps away from singular poses and from the limits of joints."""
        if trajectory.conditioning < CONDITIONING_LEAST:
            return False
        if self._joints is None:
            return True
        low, high = self._joints
        return bool(np.all((trajectory.q >= low) & (trajectory.q <= high)))

    def excitation(self, trajectory: Trajectory) -> Excitation:
        """Measure how well a motion excites the parameters."""
        spread = self._spread(trajectory)
        if spread is None:
            return Excitation(np.inf, np.inf)
        mean = float(np.exp(np.log(spread).mean())) if spread.size else 0.0
        return Excitation(float(spread[0] / spread[-1]) if spread.size else 1.0, mean)

    def _spread(self, trajectory: Trajectory) -> Array | None:
        """Compute half-axes of the ellipsoid of errors; None if it is not bounded."""
        R = np.asarray(np.linalg.qr(self._rows(trajectory) @ self._V, mode="r"))
        sizes = np.abs(R.diagonal())
        if sizes.size and sizes.min() <= np.finfo(np.float64).eps * sizes.max():
            return None
        half = np.linalg.solve(R.T, self._relevant.T)
        return singular_value_decomposition(half)[1]

    def value(self, shape: Array) -> float:
        """Compute what is minimised: the mean logarithm of the half-axes."""
        self.tries += 1
        try:
            spread = self._spread(self.follow(shape)[1])
        except PoseError:
            spread = None
        if spread is None or not spread.min(initial=1.0) > 0.0:
            return UNEXCITED
        return float(np.log(spread).mean()) if spread.size else 0.0

    def improve(
        self, start: Array, tries: int, progress: Callable[[int, int], None] | None
    ) -> Array:
        """Improve a shape by Powell's method, in a number of tries."""
        from scipy.optimize import minimize

        best, least = start, np.inf

        def value(shape: Array) -> float:
            nonlocal best, least
            if self.tries >= tries:
                return UNEXCITED
            now = self.value(shape)
            if progress is not None:
                progress(self.tries, tries)
            if now < least:
                best, least = shape.copy(), now
            return now

        minimize(value, start, method="Powell", options={"maxfev": tries - self.tries})
        return best
