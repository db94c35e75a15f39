"""A path without reaction to a given pose, or one that turns a base that floats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.floating_base.base import FloatingBase
from balance.motion.motion_tolerances import PATH_MOMENTUM, PATH_REACHED
from balance.motion.paths.branches import tangent_directions
from balance.motion.paths.connect import Connection, ConnectionEquations, connect
from balance.motion.paths.demand import Demand, Kept
from balance.motion.paths.follow import PathEvent
from balance.motion.paths.path import ReactionlessPath, sample_path
from balance.motion.paths.path_network import path_through_meetings
from balance.motion.paths.path_search import generic_dimension, record_pose, start_pose
from balance.motion.paths.reactionless_paths import PathTarget, ReactionlessPaths
from balance.motion.paths.rest_equations import RestEquations
from balance.motion.quiet.problem import follow_poses, read_pose
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.verification.joint_limits import joint_limits
from kinematics.errors import PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Why there is no path where no rates are without reaction.
FULL_RANK = "the momentum matrix has full column rank: no rates leave the base at rest"
# Samples of a path for each unit of its length, fewest and most.
PER_LENGTH, FEWEST, MOST = 120, 401, 6401
# Gauss points between two samples, by which arc lengths are computed.
GAUSS_POINTS = 5
# First paths that are tried: the straight line, and loops.
STARTS = 16
# Poses on the straight line to the pose.
LINE_POSES = 81
# How often the samples are doubled, and the momentum at which they are close enough.
REFINEMENTS, SAMPLED_WELL = 4, 1e-10


def path_to_pose(
    linkage: LinkageLike,
    end: ArrayLike | Mapping[str, float],
    start: ArrayLike | Mapping[str, float] | None = None,
    *,
    kept: Kept = "all",
    base: FloatingBase | None = None,
    turn: ArrayLike | None = None,
    about: tuple[float, float, float] | None = None,
) -> ReactionlessPaths:
    """Find a path to a given pose along which a linkage leaves its base at rest.

    ``A(q) u̇ = 0`` is solved for the whole path at once (`balance.motion.paths.connect`), from
    the straight line and from loops of random size; the path is then shortened. Where the null
    space has dimension 1, paths through meetings are tried too: segments, with rest between
    them. With ``turn`` the base floats and turns: no momentum is left, and the base has that
    rotation at the end, as a falling cat.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        end: displacements of the inputs from the reference pose at the end, by name or in
            order, rad and m; those that are not named stay.
        start: those at the start; those that are not named are 0.
        kept: what vanishes; see `find_paths`. ``"turned"`` if a turn is given.
        base: the base that floats; None if it is fixed.
        turn: rotation vector of the base at the end (3,), rad, in its axes at the start; or the
            angle about the normal of a planar linkage.
        about: point of the moment, if that alone vanishes, metres.

    Returns:
        The path; or why none was found. Its attribute ``target`` says what was asked for.

    Raises:
        UsageError: the options contradict each other.
        PoseError: a pose cannot be reached, or both are one.
        LinkageError: no moving link has a mass.

    Source:
        E. Papadopoulos, S. Dubowsky, ICRA 1991; A. W. Divelbiss, J. T. Wen, IEEE CDC 1993.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "a", point=(0.5, 0, 0)),
        ...      kinematics.ScrewJoint("u2", "a", "b", point=(1, 0, 0)),
        ...      kinematics.ScrewJoint("u3", "b", "c", point=(1.5, 0, 0))],
        ...     bodies={name: (1, (x, 0, 0), 0.1 * np.eye(3))
        ...             for name, x in (("a", 0.8), ("b", 1.3), ("c", 1.8))},
        ... )
        >>> satellite = balance.motion.FloatingBase(mass=5)
        >>> paths = balance.path_to_pose(arm, [0.2, 0.3, -0.4], kept="attitude", base=satellite)
        >>> bool(paths.paths), paths.paths[0].residual < 1e-9
        (True, True)
    """
    linkage = as_linkage(linkage)
    rotation = _rotation(linkage, turn)
    if rotation is not None:
        kept = "turned"
    elif kept == "turned":
        raise UsageError("give the turn of the base")
    demand = Demand(kept, base, about)
    rest_equations = RestEquations(linkage, demand)
    first = read_pose(linkage, {} if start is None else start, np.zeros(linkage.mobility))
    last = read_pose(linkage, end, first)
    if np.array_equal(first, last) and rotation is None:
        raise PoseError(f"{linkage.source}: the two poses are one: nothing moves")
    here = start_pose(rest_equations, first)
    equations = ConnectionEquations.of(linkage, demand)
    generic, poses = generic_dimension(rest_equations, here)
    turns = np.zeros(0) if rotation is None else rotation
    x = np.append(first, np.zeros(len(turns))) / equations.units
    way = np.append(last, turns) / equations.units - x
    paths: tuple[ReactionlessPath, ...] = ()
    reason = FULL_RANK if generic == 0 else _centre_apart(equations, first, last)
    if not reason:
        alone = generic == 1 and rotation is None
        paths = path_through_meetings(rest_equations, here, last) if alone else ()
        if not paths:
            paths, reason = _connected(
                rest_equations, equations, x, way, 1 if alone else STARTS
            )
    target = PathTarget(
        freeze(last),
        None if rotation is None else freeze(rotation @ equations.axes),
        "" if paths else reason,
    )
    tangents = tangent_directions(rest_equations, here, generic)
    return ReactionlessPaths(
        linkage,
        demand,
        None,
        generic,
        poses,
        (record_pose(rest_equations, here, tangents, 0.0),),
        (),
        paths,
        linkage.notices,
        target,
    )


def _connected(
    rest: RestEquations, equations: ConnectionEquations, x: Array, way: Array, starts: int
) -> tuple[tuple[ReactionlessPath, ...], str]:
    """Find one smooth path, or say why there is none.

    Args:
        x: coordinates at the start (coordinates,), in units.
        way: to the end.
        starts: number of first paths.
    """
    linkage, count = rest.linkage, equations.inputs
    limits, first = joint_limits(linkage), x[:count] * equations.units[:count]

    def follow(u: Array) -> SampledPoses:
        path = np.concatenate([first[None], u])
        return SampledPoses(*(part[1:] for part in follow_poses(equations.model, path)))

    def accept(solution: Connection) -> bool:
        return _beyond(solution, limits) is None

    connection = connect(equations, x, way, follow, accept, starts)
    reason = _why_not(linkage, connection, limits)
    if reason or connection is None:
        return (), reason
    path = _sampled(rest, equations, connection)
    if path.residual > PATH_MOMENTUM:
        return (), "the samples of the path leave a momentum"
    return (path,), ""


def _rotation(linkage: Linkage, turn: ArrayLike | None) -> Array | None:
    """Read the turn of a base: about the normal of a plane (1,), or in space (3,).

    Raises:
        UsageError: it is none, a turn or more, or leaves the plane.
    """
    if turn is None:
        return None
    values = np.atleast_1d(np.asarray(turn, dtype=np.float64))
    if values.shape not in ((1,), (3,)) or not np.isfinite(values).all():
        raise UsageError(
            "the turn of a base is an angle, or a rotation vector of three numbers"
        )
    if values.size == 1 and not linkage.planar:
        raise UsageError("the turn of a base in space is a rotation vector of three numbers")
    if linkage.planar and values.size == 3:
        normal = linkage.chain.frame.R[2]
        if np.abs(values - normal * (normal @ values)).max() > 1e-9:
            raise UsageError("the base of a planar linkage turns about the normal of its plane")
        values = values @ normal[:, None]
    if not linkage.planar and np.linalg.norm(values) >= 2.0 * np.pi:
        raise UsageError("a base in space turns by less than a full turn: give a part of it")
    return values


def _centre_apart(equations: ConnectionEquations, first: Array, last: Array) -> str:
    """Say how far the centres of mass of two poses are apart, if no force may act; or nothing.

    Without force a centre of mass at rest stays.
    """
    if equations.demand.kept not in ("all", "force"):
        return ""
    share = np.linspace(0.0, 1.0, LINE_POSES)[:, None]
    poses = follow_poses(equations.model, first + share * (last - first))
    a, b = equations.model.com(poses)[[0, -1]]
    distance = float(np.linalg.norm(b - a))
    linkage = equations.model.linkage
    if distance <= PATH_REACHED * linkage.spatial_chain.frame.length:
        return ""
    return (
        f"the centre of mass is {number_text(distance, '.3g')} m away at the pose to reach, "
        "and stays where it is without a force"
    )


def _beyond(connection: Connection, limits: Array) -> int | None:
    """Find a joint that a path takes beyond its limits; None if it keeps all."""
    q = connection.poses.q
    beyond = ((q < limits[0] - 1e-9) | (q > limits[1] + 1e-9)).any(axis=0)
    return int(np.argmax(beyond)) if beyond.any() else None


def _why_not(linkage: Linkage, connection: Connection | None, limits: Array) -> str:
    """Say why no path was found; empty if one was."""
    if connection is None:
        return "the loops cannot be closed along any first path to the pose"
    if not connection.meets:
        return (
            "no path without reaction to the pose was found from any first path; a search "
            "does not prove that there is none"
        )
    joint = _beyond(connection, limits)
    if joint is None:
        return ""
    return f"all paths that were found lead {linkage.joints[joint].name} beyond its limits"


def _sampled(
    rest: RestEquations,
    equations: ConnectionEquations,
    connection: Connection,
) -> ReactionlessPath:
    """Sample a path over its arc length, closer until the momentum at the samples is small."""
    count = int(np.clip(PER_LENGTH * np.sqrt(connection.path.size), FEWEST, MOST)) | 1
    best: ReactionlessPath | None = None
    for _ in range(REFINEMENTS):
        path = _path_of_samples(rest, equations, connection, count)
        # Closer samples have more round-off.
        worse = best is not None and path.residual > 0.5 * best.residual
        if best is None or path.residual < best.residual:
            best = path
        if worse or best.residual <= SAMPLED_WELL or count > MOST:
            break
        count = 2 * count - 1
    assert best is not None
    return best


def _path_of_samples(
    rest: RestEquations, equations: ConnectionEquations, connection: Connection, count: int
) -> ReactionlessPath:
    """Sample a path, closer at its ends, with the arc lengths in all joints there.

    Splines are least exact at their ends.
    """
    tau = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, count)))
    points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    half = 0.5 * np.diff(tau)
    inner = (tau[:-1, None] + half[:, None] * (1.0 + points)).ravel()
    x, rates = connection.path.at(inner)
    speeds = _speeds(rest, equations, connection, x, rates, inner)
    steps = half * (speeds.reshape(-1, GAUSS_POINTS) @ weights)
    s = np.append(0.0, np.cumsum(steps))
    x, rates = connection.path.at(tau)
    poses = _poses(equations, connection, x, tau)
    q = np.array([rest.close(pose) for pose in poses.q / rest.chain.units])
    ends = (PathEvent("start", 0.0, "start"), PathEvent("target", float(s[-1]), "the target"))
    path = sample_path(rest, 0, s, q, ends)
    if not len(equations.axes):
        return path
    turns = x[:, equations.inputs :]
    momentum = _turning_momentum(equations, poses, x, s)
    return replace(path, momentum=freeze(momentum), attitude=freeze(turns @ equations.axes))


def _poses(
    equations: ConnectionEquations, connection: Connection, x: Array, tau: Array
) -> SampledPoses:
    """Compute closed poses of a path from those at its Gauss points."""
    nearest = np.abs(tau[:, None] - connection.tau).argmin(axis=1)
    known = SampledPoses(*(part[nearest] for part in connection.poses))
    count = equations.inputs
    poses = equations.model.near(known, x[:, :count] * equations.units[:count])
    if poses is None:
        raise PoseError(f"{equations.model.linkage.source}: the loops cannot be closed")
    return poses


def _speeds(
    rest: RestEquations,
    equations: ConnectionEquations,
    connection: Connection,
    x: Array,
    rates: Array,
    tau: Array,
) -> Array:
    """Compute ``ds/dτ``: the size of the rates of all joints, in units of the chain."""
    poses, count = _poses(equations, connection, x, tau), equations.inputs
    joints = np.einsum("pnw,pw->pn", poses.C, rates[:, :count] * equations.units[:count])
    return np.asarray(np.linalg.norm(joints / rest.chain.units, axis=1))


def _turning_momentum(
    equations: ConnectionEquations, poses: SampledPoses, x: Array, s: Array
) -> Array:
    """Compute the momentum that splines through joints and attitude leave (N,), relative."""
    from scipy.interpolate import make_interp_spline

    slopes = make_interp_spline(s, x, k=5)(s, 1)
    rows = equations.at(poses, x * equations.units).rows
    momenta = np.linalg.norm(np.einsum("prm,pm->pr", rows, slopes), axis=1)
    scale = np.linalg.norm(rows, axis=1) @ np.ones(x.shape[1]) * np.linalg.norm(slopes, axis=1)
    return np.asarray(momenta / np.where(scale > 0.0, scale, 1.0))
