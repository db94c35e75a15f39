"""Paths without reaction from given poses, and the poses in which several of them meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.floating_base.base import FloatingBase
from balance.motion.motion_tolerances import PATH_CONDITIONING
from balance.motion.paths.branches import (
    Tangents,
    fan_of_directions,
    null_basis,
    tangent_directions,
)
from balance.motion.paths.demand import Demand, Kept
from balance.motion.paths.follow import Arc, PathEvent, follow_arc
from balance.motion.paths.local_curve import LocalArc, solve_local_curve
from balance.motion.paths.meeting_poses import meeting_pose
from balance.motion.paths.path import ReactionlessPath, sample_path
from balance.motion.paths.reactionless_paths import ReactionlessPaths, StartPose
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from balance.motion.verification.joint_limits import joint_limits
from kinematics.closure.joint_positions import joint_positions, values_by_input
from kinematics.errors import PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import number_text

# Length of a path to either side of its start, radians and characteristic lengths.
LENGTH = 1.0
# Arc length between samples if no step is given: of closer ones, round-off grows in the spline
# through them. Fewest and most samples.
STEP = 0.005
FEWEST, MOST = 33, 100_000
# Poses around a start that decide the dimension of the null space in general, and the steps
# that lead to each.
LOOKED_AT = 8
WALK = 4
SEED = 11
# Distance up to which a meeting of paths near a start is a start of its own.
NEAR = 0.01
# The same up to which they are one.
SAME_MEETING = 1e-6
# How often the samples of a path are doubled until the momentum at them is round-off: up to
# this part of the momenta of the bodies.
REFINEMENTS = 5
SAMPLED_WELL = 2e-11


def find_paths(
    linkage: LinkageLike,
    starts: Sequence[ArrayLike | Mapping[str, float]] = (),
    *,
    kept: Kept = "all",
    base: FloatingBase | None = None,
    about: tuple[float, float, float] | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    length: float = LENGTH,
    step: float | None = None,
    line: int = 0,
    tolerance: float = 0.0,
    fan: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> ReactionlessPaths:
    """Find paths along which a linkage leaves its base at rest.

    ``A(q) u̇ = 0`` with the momentum matrix, or a part of it, is integrated from each pose to
    both sides. In a pose in which several paths meet, all of their directions follow from the
    tangent cone; where the null space has a dimension k above 1 in general, k paths are
    followed, each led by one input.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        starts: poses, as displacements of the inputs from the reference pose (mobility,) or by
            name, rad and m; by default the reference pose.
        kept: what vanishes: ``"all"``, ``"moment"`` or ``"force"``; with a base that floats
            ``"all"`` or ``"attitude"``; see `balance.motion.paths.demand.Demand`.
        base: the base that floats; None if it is fixed.
        about: point of the moment, if that alone vanishes, metres, in the inertial frame; None
            for its origin.
        motion: relations of the inputs that the paths fulfil.
        length: arc length to either side of the start, in all joints, radians and
            characteristic lengths.
        step: arc length between samples; 0.005 by default.
        line: number of further starts between each two of the given ones, on the straight line
            of the inputs.
        tolerance: part of the momenta of the bodies that may be left: with one, the rates with
            the least momentum are followed as long as it is below that part, for masses that
            have no paths without any.
        fan: number of paths that are followed from each start where the null space has a
            dimension k above 1 in general, in directions all around; 0 for k.
        progress: called with the number of starts done and of all.

    Returns:
        The paths, the poses in which several meet, or the reason why there is none.

    Raises:
        UsageError: the options contradict each other.
        PoseError: a start cannot be reached, or is a singular pose of the linkage.
        MotionError: a relation is wrong.
        LinkageError: no moving link has a mass.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eq. 3.51; D. N. Nenchev, Mechanical
        Sciences 4, 2013.

    Example:
        >>> import balance
        >>> bool(balance.find_paths("robot.urdf").paths)
        False
    """
    linkage = as_linkage(linkage)
    if fan < 0:
        raise UsageError("the number of paths of a fan is not negative")
    if not 0.0 < length < np.inf or (step is not None and not 0.0 < step < np.inf):
        raise UsageError("the length of a path and its step are positive numbers")
    relations = motion_of(linkage, motion)
    demand = Demand(kept, base, about, tolerance)
    equations = RestEquations(linkage, demand, relations)
    here = [start_pose(equations, u) for u in _poses(linkage, starts, line)]
    search = _Search(equations, here, length, step, fan)
    for k in range(len(here)):
        search.run(k)
        if progress is not None:
            progress(k + 1, len(here))
    return ReactionlessPaths(
        linkage,
        equations.demand,
        relations,
        search.generic,
        search.poses,
        tuple(search.starts),
        tuple(search.meetings),
        tuple(search.paths),
        linkage.notices,
    )


def _poses(
    linkage: Linkage, starts: Sequence[ArrayLike | Mapping[str, float]], line: int
) -> list[Array]:
    """List the displacements of the inputs at all starts."""
    poses = []
    for u in starts or [{}]:
        if isinstance(u, Mapping):
            u = values_by_input(linkage, u)
        poses.append(np.asarray(u, dtype=np.float64))
    if line and len(poses) < 2:
        raise UsageError("a line of starts needs two poses: give its ends")
    if line:
        shares = np.linspace(0.0, 1.0, line + 2)[:-1, None]
        lines = [a + shares * (b - a) for a, b in zip(poses[:-1], poses[1:], strict=True)]
        poses = [*np.concatenate(lines), poses[-1]]
    return poses


def start_pose(equations: RestEquations, u: Array) -> RowsAtPose:
    """Close the loops at a start.

    Raises:
        PoseError: it cannot be reached, or is singular.
    """
    linkage = equations.linkage
    q = joint_positions(linkage, u) / equations.chain.units
    here = equations.at(equations.close(q))
    if here.conditioning < PATH_CONDITIONING:
        where = ", ".join(
            f"{name}={number_text(value)}"
            for name, value in zip(linkage.inputs, u, strict=True)
        )
        raise PoseError(
            f"{linkage.source}: the pose {where} is a singular one of the linkage; start "
            "elsewhere, or take other inputs"
        )
    return here


class _Search:
    """The search from several poses of one linkage."""

    def __init__(
        self,
        equations: RestEquations,
        here: Sequence[RowsAtPose],
        length: float,
        step: float | None,
        fan: int = 0,
    ) -> None:
        """Decide the dimension of the null space in general."""
        self.equations, self.here, self.length, self.fan = equations, here, length, fan
        count = 1 + 2.0 * length / (step or STEP)
        if count > MOST:
            raise UsageError(f"more than {MOST} samples: give a longer step")
        self.samples = max(FEWEST, int(round(count)))
        self.limits = joint_limits(equations.linkage) / equations.chain.units
        self.starts: list[StartPose] = []
        self.meetings: list[StartPose] = []
        self.paths: list[ReactionlessPath] = []
        self.generic, self.poses = generic_dimension(equations, *here)
        if self.generic:
            # There are paths that leave nothing.
            equations.demand = replace(equations.demand, tolerance=0.0)

    def run(self, number: int) -> None:
        """Find the paths of one start, and of a meeting of paths close to it."""
        here = self.here[number]
        met = None
        if self.generic and self.equations.width > 1:
            met = meeting_pose(self.equations, here, self.generic, 2.0 * self.length)
        if met is not None:
            tangents = tangent_directions(self.equations, met[0], self.generic)
            self._note_meeting(record_pose(self.equations, met[0], tangents, met[1]))
        if met is not None and met[1] <= NEAR:
            self.follow(*met)
        else:
            self.follow(here, 0.0)

    def _note_meeting(self, pose: StartPose) -> None:
        """Keep a meeting, unless it is known."""
        matches = [np.abs(pose.q - other.q).max() < 1e-6 for other in self.meetings]
        if not any(matches):
            self.meetings.append(pose)

    def follow(self, here: RowsAtPose, distance: float) -> None:
        """Follow all paths through a pose."""
        tangents = self._tangents(here)
        number = len(self.starts)
        kept = []
        for v in tangents.directions:
            path = self._path(number, here, v, tangents.kind == "regular")
            kept.append(path is not None and path.reactionless)
            if path is not None and path.reactionless:
                self.paths.append(path)
        directions = tangents.directions[np.array(kept, dtype=bool)]
        kind = "isolated" if len(kept) and not any(kept) else tangents.kind
        tangents = tangents._replace(kind=kind, directions=directions)
        self.starts.append(record_pose(self.equations, here, tangents, distance))

    def _tangents(self, here: RowsAtPose) -> Tangents:
        """Find the directions of paths through a pose; with a tolerance, the quietest one."""
        tolerance = self.equations.demand.tolerance
        if tolerance:
            quietest = np.linalg.svd(here.rows, full_matrices=True)[2][-1:]
            quietest = quietest * np.sign(quietest[0, first_largest(np.abs(quietest[0]))])
            if self.equations.share(here, quietest[0]) > tolerance:
                return Tangents("isolated", quietest[:0], 0)
            return Tangents("regular", quietest, 1)
        tangents = tangent_directions(self.equations, here, self.generic)
        if self.fan and tangents.kind == "regular" and tangents.family > 1:
            return tangents._replace(directions=fan_of_directions(here, self.fan))
        return tangents

    def _path(
        self, number: int, here: RowsAtPose, v: Array, regular: bool
    ) -> ReactionlessPath | None:
        """Follow one path to both sides; None if none leaves along the direction."""
        if regular:
            middle, dimension = None, max(self.generic, 1)
            ends = [(here.q, sign * v, 0.0) for sign in (1.0, -1.0)]
        else:
            curve = solve_local_curve(self.equations, here, v)
            if curve is None:
                return None
            middle = LocalArc(self.equations, curve)
            ends, dimension = middle.ends()
        arcs = [
            follow_arc(self.equations, q, t, self.length, dimension, self.limits, s)
            for q, t, s in ends
        ]
        return self._sample(number, middle, arcs)

    def _sample(
        self, number: int, middle: LocalArc | None, arcs: Sequence[Arc]
    ) -> ReactionlessPath | None:
        """Sample a path evenly in its arc length, closer where it bends sharply."""
        ahead, behind = (arc.length for arc in arcs)
        if ahead + behind <= 0.0:
            return None
        events = [event._replace(s=-event.s) for event in reversed(arcs[1].events)]
        if middle is not None:
            events.append(PathEvent("meeting", 0.0, "several paths meet"))
        events += arcs[0].events
        count = max(FEWEST, int(np.ceil(self.samples * (ahead + behind) / 2 / self.length)))
        count |= 1  # so that one of them is in the middle
        best: ReactionlessPath | None = None
        for _ in range(REFINEMENTS):
            s = np.linspace(-behind, ahead, count)
            q = self._positions(s, middle, arcs)
            path = sample_path(self.equations, number, s, q, tuple(events))
            if best is not None and path.residual > 0.25 * best.residual:
                break
            best = path
            if path.residual <= SAMPLED_WELL:
                break
            count = 2 * count - 1
        return best

    def _positions(self, s: Array, middle: LocalArc | None, arcs: Sequence[Arc]) -> Array:
        """Compute closed joint positions (N, n) at arc lengths."""
        first, last = (0.0, 0.0) if middle is None else middle.extent
        inside = (s > first) & (s < last)
        q = np.empty((s.size, self.equations.chain.parent.size))
        if middle is not None and inside.any():
            q[inside] = middle.positions(s[inside])
        for k in np.flatnonzero(~inside):
            q[k] = self.equations.close(arcs[int(s[k] < 0.0)].positions(abs(float(s[k]))))
        return q


def paths_through(
    equations: RestEquations, here: RowsAtPose, length: float
) -> tuple[list[ReactionlessPath], list[RowsAtPose]]:
    """Follow all paths through a pose, and find the meetings of paths on them.

    Args:
        length: arc length to either side.
    """
    search = _Search(equations, [here], length, None)
    met = meeting_pose(equations, here, search.generic, SAME_MEETING)
    search.follow(*(met or (here, 0.0)))
    meetings = []
    for path in search.paths:
        for event in path.events:
            if event.kind != "meeting" or abs(event.s) <= SAME_MEETING:
                continue
            k = int(np.abs(path.s - event.s).argmin())
            near = equations.at(equations.close(path.q[k] / equations.chain.units))
            meeting = meeting_pose(equations, near, search.generic, NEAR)
            if meeting is not None:
                meetings.append(meeting[0])
    return search.paths, meetings


def record_pose(
    equations: RestEquations, here: RowsAtPose, tangents: Tangents, distance: float
) -> StartPose:
    """Make the data of a pose."""
    N, _, values = null_basis(here)
    q = here.q * equations.chain.units
    inputs = equations.linkage.positions_of(equations.linkage.inputs)
    directions = tangents.directions @ equations.basis.T * equations.units
    kind = tangents.kind if N.shape[1] or len(tangents.directions) else "none"
    return StartPose(
        q[inputs], q, values, N.shape[1], kind, directions, tangents.family, distance
    )


def generic_dimension(equations: RestEquations, *here: RowsAtPose) -> tuple[int, int]:
    """Compute the dimension of the null space in general, and by how many poses.

    Args:
        here: the equations at poses; others are around the first one.
    """
    looked = [*here, *_poses_around(equations, here[0])]
    return min(null_basis(pose)[0].shape[1] for pose in looked), len(looked)


def _poses_around(equations: RestEquations, start: RowsAtPose) -> list[RowsAtPose]:
    """Walk to poses around a start, in random directions."""
    rng = np.random.default_rng(SEED)
    poses = []
    for _ in range(LOOKED_AT):
        here = start
        direction = rng.standard_normal(equations.width)
        direction *= rng.uniform(0.02, 0.08) / np.linalg.norm(direction)
        for _ in range(WALK):
            try:
                here = equations.at(equations.move(here, direction))
            except PoseError:
                break
        poses.append(here)
    return poses
