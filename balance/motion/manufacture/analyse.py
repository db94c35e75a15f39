"""Shaking of a linkage whose masses, centres of mass and joints are within tolerances.

Of ``F + C v`` with ``|v_k| ≤ 1`` the largest component along a unit vector n is
``n·F + Σ_k |n·C_k|``. The largest norm is the maximum of this over n, to be maximised. Let
n be the direction of the maximum, and n' one within the angle θ of it: along n', the same v has
at least ``cos θ`` times the norm. So over a grid of directions that covers the sphere up to θ,

    max over the grid  ≤  largest norm  ≤  max over the grid / cos θ,

and the v of the best direction reaches the norm ``|F + C v|``, which is the lower bound here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import atan, cos, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.manufacture.deviations import (
    DeviatingLoads,
    Deviation,
    Tolerances,
    deviated_masses,
    deviating_loads,
    deviations_of,
    exact_peaks,
)
from balance.motion.verification.given_motions import Motions
from balance.motion.verification.trajectory import random_motions
from balance.motion.verification.verify_motions import given_or_turned
from balance.support.options import point_of
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest, rank_least_first
from kinematics.numerics.tolerances import TIE_RELATIVE
from kinematics.wording import number_text, repr_lines

# Drawn linkages, and how many at once.
DRAWS = 20_000
BLOCK = 2_000
# Quantiles that are told, percent.
QUANTILES = (50, 95, 99)
# Cells along an edge of the cube whose grid is projected to the sphere.
CELLS = 40
# Steps from the best direction of the grid to that of a vertex.
MAX_STEPS = 20


class ShakingSpread(NamedTuple):
    """Peak of the shaking force or moment of linkages within tolerances, N or N m.

    Attributes:
        nominal: without deviations.
        reached: the largest peak that was found, with a deviation of its own.
        bound: what no linkage within the tolerances exceeds.
        median: of linkages drawn at random, each deviation evenly within its bound.
        high: 95th percentile of these.
        higher: 99th percentile.
        largest: of all that were drawn.
    """

    nominal: float
    reached: float
    bound: float
    median: float
    high: float
    higher: float
    largest: float


class DeviationShare(NamedTuple):
    """What one deviation adds in the worst case.

    Attributes:
        deviation: which one.
        force: what it adds to the largest peak force, N.
        moment: what it adds to the largest peak moment, N m.
    """

    deviation: Deviation
    force: float
    moment: float


@dataclass(frozen=True, eq=False)
class ShakingTolerance:
    """Result of `shaking_tolerance`.

    Attributes:
        linkage: the linkage.
        tolerances: the bounds of the deviations.
        force: spread of the peak force.
        moment: spread of the peak moment about the point.
        shares: what each deviation adds in the worst case, the most first, by force.
        point: point of moments (3,), metres.
        draws: number of linkages that were drawn.
        seed: seed of these.
    """

    linkage: Linkage
    tolerances: Tolerances
    force: ShakingSpread
    moment: ShakingSpread
    shares: tuple[DeviationShare, ...]
    point: Array
    draws: int
    seed: int

    @property
    def proved(self) -> bool:
        """Whether the bounds hold for all linkages within the tolerances.

        Lengths count to first order alone.
        """
        return self.tolerances.length == 0.0

    @property
    def words(self) -> str:
        """The worst case in words."""
        kind = "" if self.proved else " to first order in lengths"
        force, moment = (
            f"{number_text(spread.reached)} to {number_text(spread.bound)} {unit}"
            for spread, unit in ((self.force, "N"), (self.moment, "N m"))
        )
        return f"worst case{kind}: peak force {force}, peak moment {moment}"

    def __repr__(self) -> str:
        """Up to six lines: the worst case, and what adds most."""
        most = (
            f"{share.deviation.words}: {number_text(share.force)} N, "
            f"{number_text(share.moment)} N m"
            for share in self.shares
        )
        return repr_lines(f"ShakingTolerance of {self.linkage.name}", self.words, *most)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/verify.schema.json``."""
        return {
            **self.tolerances._asdict(),
            "force": self.force._asdict(),
            "moment": self.moment._asdict(),
            "proved": self.proved,
            "draws": self.draws,
            "seed": self.seed,
            "shares": [
                {
                    "kind": share.deviation.kind,
                    "name": share.deviation.name,
                    "force": share.force,
                    "moment": share.moment,
                }
                for share in self.shares
            ],
        }


def shaking_tolerance(
    linkage: LinkageLike,
    mass: float = 0.0,
    length: float = 0.0,
    com: float = 0.0,
    *,
    motions: Motions | None = None,
    speed: float | str | None = None,
    crank: str | None = None,
    about: ArrayLike | None = None,
    z: ArrayLike | None = None,
    trajectories: int = 10,
    draws: int = DRAWS,
    seed: int = 0,
) -> ShakingTolerance:
    """Find what shakes at most if a linkage is made within tolerances, and how it spreads.

    Each link has a mass and a centre of mass of its own, and each joint an axis of its own,
    within the bounds. The peak over the motions is between one that a linkage within the
    tolerances reaches and one that none exceeds; for masses and centres of mass this is proved
    but for round-off. Lengths count to first order.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        mass: bound on the mass of each link, relative to it.
        length: bound on the place of the axis of each joint that turns, along two directions
            at right angles to it, metres.
        com: bound on the centre of mass of each link, along each axis of its frame, metres.
        motions: one or several, as for `balance.verify`; by default its random ones.
        speed: speed of a crank, rad/s, or ``"300rpm"``: the motion is one revolution.
        crank: name of that crank, as for `balance.verify`.
        about: point for moments in the inertial frame, metres; the middle of the mechanism by
            default.
        z: parameters as in `balance.verify`; those of the file by default.
        trajectories: number of random motions.
        draws: number of linkages that are drawn at random.
        seed: seed of motions and draws.

    Returns:
        Peaks of force and moment, and what each deviation adds in the worst case.

    Raises:
        UsageError: a bound is out of range.
        LinkageError: loops do not close with other lengths.
        PoseError: nothing moves, or the crank cannot turn fully.
        ValueError: there are motions and a speed.

    Source: the support function of a zonotope; for tolerances of balance: V. H. Arakelian,
        M. R. Smith, Journal of Mechanical Design 127, 2005.

    Example:
        >>> import balance
        >>> spread = balance.motion.shaking_tolerance("robot.urdf", mass=0.02, draws=100)
        >>> spread.force.nominal < spread.force.reached <= spread.force.bound
        True
    """
    linkage = as_linkage(linkage)
    tolerances = Tolerances(mass, length, com)
    deviations = deviations_of(linkage, tolerances)
    followed, _ = given_or_turned(linkage, motions, speed, crank)
    if followed is None:
        followed = list(random_motions(linkage, trajectories, seed=seed))
    middle = linkage.spatial_chain.frame.origin
    point = middle if about is None else point_of(about)
    parameters = None if z is None else np.asarray(z, dtype=np.float64)
    loads = [
        deviating_loads(linkage, trajectory, tolerances, deviations, point, parameters)
        for trajectory in followed
    ]
    spreads, added = [], []
    peaks = _drawn_peaks(loads, draws, seed)

    def reach(vertex: Array) -> tuple[float, float]:
        pairs = zip(followed, loads, strict=True)
        masses = deviated_masses(linkage, tolerances, loads[0], deviations, vertex, parameters)
        sizes = [
            exact_peaks(linkage, trajectory, masses, item, deviations, vertex, point)
            for trajectory, item in pairs
        ]
        moment, force = np.max(sizes, axis=0).tolist()
        return moment, force

    for k, part in enumerate((slice(3, 6), slice(0, 3))):
        row = 1 - k
        spread, shares = _spread(loads, part, row, peaks[row], len(deviations), reach)
        spreads.append(spread)
        added.append(shares)
    return ShakingTolerance(
        linkage,
        tolerances,
        spreads[0],
        spreads[1],
        _rank_shares(deviations, added[0], added[1]),
        point,
        draws,
        seed,
    )


def _rank_shares(
    deviations: Sequence[Deviation], force: Array, moment: Array
) -> tuple[DeviationShare, ...]:
    """List what deviations add, those first that add most of the force."""
    shares = map(DeviationShare, deviations, force.tolist(), moment.tolist())
    rows = tuple(shares)
    order = rank_least_first([-row.force for row in rows], max(float(force.max()), 1e-300))
    return tuple(rows[i] for i in order)


def _spread(
    loads: Sequence[DeviatingLoads],
    part: slice,
    row: int,
    peaks: Array,
    count: int,
    reach: Callable[[Array], tuple[float, float]],
) -> tuple[ShakingSpread, Array]:
    """Compute the spread of a part of the wrench, and what each deviation adds (count,).

    Args:
        reach: computes the peaks of moment and force, N m and N, with deviations (columns,).
    """
    F = np.concatenate([item.nominal[:, part] for item in loads])
    C = np.concatenate([item.columns[:, part] for item in loads])
    worst = worst_case(F, C, np.concatenate([item.neglected[:, row] for item in loads]))
    along = (worst.direction @ C[worst.sample]) * worst.vertex
    shares = np.zeros(count)
    np.add.at(shares, list(loads[0].owners), along)
    median, high, higher = np.percentile(peaks, QUANTILES).tolist()
    nominal = float(np.linalg.norm(F, axis=1).max())
    reached = max(reach(worst.vertex)[row], nominal)
    spread = ShakingSpread(
        nominal,
        reached,
        max(worst.most, reached),
        median,
        high,
        higher,
        float(peaks.max()),
    )
    return spread, shares


def _drawn_peaks(loads: Sequence[DeviatingLoads], draws: int, seed: int) -> Array:
    """Compute the peak moment and force (2, draws) of linkages drawn within the tolerances."""
    rng = np.random.default_rng([seed, 1])
    F = np.concatenate([item.nominal for item in loads])
    C = np.concatenate([item.columns for item in loads])
    peaks = np.empty((2, draws))
    flat = C.reshape(-1, C.shape[2])
    for start in range(0, draws, BLOCK):
        v = rng.uniform(-1.0, 1.0, (C.shape[2], min(BLOCK, draws - start)))
        wrenches = F[:, :, None] + (flat @ v).reshape(*C.shape[:2], -1)
        squares = np.square(wrenches).reshape(len(F), 2, 3, -1).sum(axis=2)
        peaks[:, start : start + v.shape[1]] = np.sqrt(squares.max(axis=0))
    return peaks


class _WorstCase(NamedTuple):
    """The largest norm over all samples and the whole box.

    Attributes:
        least: a norm that is reached.
        most: a bound that none exceeds.
        sample: where.
        direction: unit vector there (3,).
        vertex: v of the norm that is reached (k,), each 1 or -1.
    """

    least: float
    most: float
    sample: int
    direction: Array
    vertex: Array


@cache
def directions() -> tuple[Array, float]:
    """Return unit vectors (count, 3) that cover the sphere, and the cosine of the angle θ.

    A point of the cube of edge 2 is within the half-diagonal ``√2 / CELLS`` of a corner of its
    cell. Both are on a plane at the distance 1 from the centre, so that the angle between them
    is at most that of two points to both sides of its foot, ``2 atan(1 / (√2 CELLS))``.
    """
    ticks = np.linspace(-1.0, 1.0, CELLS + 1)
    a, b = (x.ravel() for x in np.meshgrid(ticks, ticks))
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((a.size, 3))
            face[:, axis] = side
            face[:, axis - 2], face[:, axis - 1] = a, b
            faces.append(face)
    points = np.unique(np.concatenate(faces), axis=0)
    units = points / np.linalg.norm(points, axis=1)[:, None]
    return freeze(units), cos(2.0 * atan(sqrt(0.5) / CELLS))


def worst_case(F: Array, C: Array, extra: Array) -> _WorstCase:
    """Find the largest ``|F + C v| + extra`` over samples and ``|v_k| ≤ 1``.

    Args:
        F: constant vectors (N, 3).
        C: columns (N, 3, k).
        extra: sizes that are added to the bound (N,).
    """
    units, cosine = directions()
    best = 0.0, 0, 0
    most = 0.0
    for k in range(len(F)):
        support = units @ F[k] + np.abs(units @ C[k]).sum(axis=1)
        at = first_largest(support)
        most = max(most, float(support.max()) / cosine + float(extra[k]))
        if support[at] > (1.0 + TIE_RELATIVE) * best[0]:
            best = float(support[at]), k, at
    _, sample, at = best
    vertex, reached = _ascend(F[sample], C[sample], units[at])
    size = float(np.linalg.norm(reached))
    direction = reached / size if size > 0.0 else units[at]
    return _WorstCase(size, max(most, size), sample, freeze(direction), freeze(vertex))


def _ascend(F: Array, C: Array, n: Array) -> tuple[Array, Array]:
    """Go from a direction to its vertex and back, until the norm of the load grows no more."""
    vertex = np.where(C.T @ n >= 0.0, 1.0, -1.0)
    for _ in range(MAX_STEPS):
        reached = F + C @ vertex
        after = np.where(C.T @ reached >= 0.0, 1.0, -1.0)
        if np.linalg.norm(F + C @ after) <= np.linalg.norm(reached):
            break
        vertex = after
    return vertex, F + C @ vertex
