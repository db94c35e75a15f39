"""This package on the Taylor jobs, with another geometry at every call.

The time is measured from the joint screws of a geometry to the coefficients of all joints.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle

import numpy as np

from benchmarks.peers import jobs
from kinematics.closure.assembly.assemble import assemble, moving_chain
from kinematics.closure.assembly.tool_frame import tool
from kinematics.closure.taylor.expansion_kernels import polynomials
from kinematics.closure.taylor.layout import packed_layout
from kinematics.closure.taylor.many_poses import taylor_motion_many
from kinematics.closure.taylor.monomials import monomial_powers, monomial_table
from kinematics.closure.taylor.taylor_motion import scaled_chain, taylor_motion
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Body, Joint, Linkage, Loop, UnassembledLinkage
from kinematics.model.motion import Motion, motion_of
from kinematics.model.spatial.screws import revolute

# Number of geometries, their standard deviation (metres), and the random seed.
COUNT, SIZE, SEED = 24, 0.01, 5
LINE = tuple(
    f"flange.{axis}={float(part / jobs.DIRECTION[0])!r}*flange.x"
    for axis, part in zip("yz", jobs.DIRECTION[1:], strict=True)
)
UNIT = freeze([1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    return _job(_five_bar, (), order, 4, jobs.ANGLES)


def six_r(order: int) -> tuple[Callable, Callable]:
    """The 6R arm along its line; its input is the distance along x."""
    return _job(_six_r, LINE, order, 6, jobs.POSE)


def linkage(job: str) -> Linkage:
    """Build the linkage of a job, with its tool's coordinates as inputs."""
    return (_five_bar if job == "five_bar" else _six_r)(np.random.default_rng(SEED), 0.0)


def many_poses(job: str, order: int, count: int) -> Callable:
    """Make the function that expands the motion at many poses around that of the job.

    Args:
        job: name of the job.
        order: highest degree.
        count: number of poses.
    """
    made, motion = linkage(job), LINE if job == "six_r" else None
    one, rng = taylor_motion(made, 5, motion), np.random.default_rng(SEED)
    points = SIZE * rng.standard_normal((COUNT, one.scales.size))
    poses = np.resize([one.polish(point) for point in points], (count, len(made.joints)))
    return lambda: taylor_motion_many(made, poses, order, motion)


def _job(
    build: Callable[[np.random.Generator, float], Linkage],
    relations: tuple[str, ...],
    order: int,
    joints: int,
    angles: np.ndarray,
) -> tuple[Callable, Callable]:
    rng = np.random.default_rng(SEED)
    first = build(rng, 0.0)
    given = motion_of(first, relations) if relations else None
    motion = given or Motion.free(first.inputs)
    chain, scales = scaled_chain(moving_chain(first, given), first, motion)
    table = monomial_table(chain.width, order)
    whole = packed_layout(chain, order)
    # The direction of the 6R arm's line is not of unit length along x.
    scales = scales / jobs.DIRECTION[0] if relations else scales
    units = monomial_powers(table.exponents, 1.0 / scales)[:, None]
    others = [moving_chain(build(rng, SIZE), given) for _ in range(COUNT)]
    screws = cycle([other.screws for other in others])

    def run() -> tuple[np.ndarray, float]:
        return polynomials(next(screws), whole)

    def read(_: object) -> np.ndarray:
        found = (polynomials(chain.screws, whole)[0] * units)[:, :joints].T
        found[:, 0] = angles
        return found

    return run, read


def _joint(name: str, parent: int, axis: np.ndarray, at: np.ndarray) -> Joint:
    axis, at = (np.asarray(x, dtype=np.float64) for x in (axis, at))
    return Joint(name, "revolute", parent, freeze(revolute(axis, at)), freeze(at))


def _unassembled(
    joints: list[Joint], bodies: dict[str, int], loops: tuple[Loop, ...]
) -> UnassembledLinkage:
    made = tuple(Body(name, link, UNIT, freeze(np.eye(4))) for name, link in bodies.items())
    return UnassembledLinkage("job", "job", tuple(joints), made, loops)


def _five_bar(rng: np.random.Generator, size: float) -> Linkage:
    z, tip = np.array([0.0, 0.0, 1.0]), np.array([*jobs.TIP, 0.0])
    joints = []
    for arm, base in enumerate(jobs.BASES):
        angle = jobs.ANGLES[2 * arm]
        pivot = np.array([base, 0.0, 0.0])
        elbow = pivot + jobs.LOWER * np.array([np.cos(angle), np.sin(angle), 0.0])
        moved = [p + size * np.append(rng.standard_normal(2), 0.0) for p in (pivot, elbow)]
        joints += [_joint(f"lower{arm}", -1, z, moved[0])]
        joints += [_joint(f"upper{arm}", len(joints) - 1, z, moved[1])]
    joints.append(_joint("tip", 1, z, tip))
    draft = _unassembled(joints, {"left": 1, "right": 3}, (Loop("loop", 4, 3),))
    return tool(assemble(draft, ["lower0", "lower1"]), "left", "x,y", tip)


def _six_r(rng: np.random.Generator, size: float) -> Linkage:
    joints: list[Joint] = []
    # Joints at the pose are rounded once: what is measured is the error of their motion.
    R, p = np.eye(3, dtype=np.longdouble), np.zeros(3, dtype=np.longdouble)
    points = jobs.POINTS + size * rng.standard_normal((6, 3))
    for i, (axis, at, angle) in enumerate(zip(jobs.AXES, points, jobs.POSE, strict=True)):
        joints.append(_joint(f"q{i}", i - 1, R @ axis, R @ at + p))
        K, angle = jobs.cross_matrix(axis), np.longdouble(angle)
        turn = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
        p = p + R @ (at - turn @ at)
        R = R @ turn
    names = [joint.name for joint in joints]
    flange = np.asarray(R @ jobs.FLANGE + p, dtype=np.float64)
    draft = _unassembled(joints, {"flange": 5}, ())
    return tool(assemble(draft, names), "flange", "x,y,z", flange)
