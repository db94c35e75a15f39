"""Taylor expansion of closed motions: joint positions as polynomials in the inputs.

    q(u) = Σ_α c_α u^α          ∂^α q(0) = α! c_α

The multi-indices α and their order are those of `kinematics.closure.taylor.monomials`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.assembly.assemble import moving_chain
from kinematics.closure.joint_positions import solve_joint_positions
from kinematics.closure.newton import solve_positions
from kinematics.closure.series import expand
from kinematics.closure.taylor.expansion_kernels import polynomials
from kinematics.closure.taylor.layout import packed_layout
from kinematics.closure.taylor.monomials import Monomials, monomial_powers, monomial_table
from kinematics.errors import MobilityError, PoseError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import move_chain
from kinematics.model.linkage import Linkage, names_of
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.tolerances import CLOSURE_CONDITION
from kinematics.wording import count_noun, first_names, repr_lines

# Order of the series from which the radius of convergence is estimated: a singularity with
# little effect on 24 terms is missed.
RADIUS_ORDER = 24
# Directions for every input in the search for the radius.
DIRECTIONS_PER_INPUT = 6
# Terms of high order below this part of the first are round-off; as large as that, they would
# let the series converge up to 2.6.
TERM_ROUND_OFF = 1e-10
# Order up to which the terms of a linear motion are looked at: round-off grows with the order.
LINEAR_ORDER = 6
# Spread of the directions around the worst one found so far, of length 1, round by round.
DIRECTION_SPREADS = (1.0, 0.3, 0.1)
# Safety factor on the smallest radius found: directions in between may have a smaller one.
RADIUS_SAFETY = 0.9
# Seed of the random directions: a linkage has the same radius every time.
DIRECTION_SEED = 7


@dataclass(frozen=True, eq=False)
class TaylorMotion:
    """The closed motion of a linkage as a Taylor polynomial about its reference pose.

    Points u are displacements of the inputs from the reference pose, or coordinates y of a
    restricted motion, ``u = motion.basis @ y``; shape (..., w), SI units.

    Attributes:
        linkage: the linkage.
        motion: the motion that was expanded.
        joints: names of all joints of the linkage.
        exponents: multi-indices α (M, w), by degree.
        coefficients: ``c_α`` of every joint position (M, n), SI units.
        condition: condition number of the closure equations, in units of the chain.
        chain: the moving joints as arrays; its columns are the inputs in units of ``scales``.
        scales: unit of each input in which the radius is measured (w,): radians and
            characteristic lengths.
    """

    linkage: Linkage
    motion: Motion
    joints: tuple[str, ...]
    exponents: IntArray
    coefficients: Array
    condition: float
    chain: Chain
    scales: Array

    def __repr__(self) -> str:
        """Three lines with order, inputs and radius of convergence."""
        return repr_lines(
            f"TaylorMotion of {self.linkage.name}: order {self.order}, "
            f"{count_noun(len(self.joints), 'joint')}, "
            f"{count_noun(len(self.exponents), 'term')}",
            f"inputs {first_names(self.motion.inputs)}",
            f"radius of convergence {self.radius:.3g}, condition {self.condition:.3g}",
        )

    @property
    def order(self) -> int:
        """Highest degree."""
        return int(self.exponents.sum(axis=1).max())

    def evaluate(self, u: ArrayLike) -> Array:
        """Compute the positions of all joints at points u (..., w), rad and m.

        Returns:
            Shape (..., n), rad and m; not finite far beyond the radius, where they overflow.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            q: Array = monomial_powers(self.exponents, self._points(u)) @ self.coefficients
        return q

    def derivatives(self, alpha: ArrayLike, u: ArrayLike | None = None) -> Array:
        """Compute the mixed partial derivative ``∂^α q`` of all joint positions.

        Args:
            alpha: multi-index (w,), such as ``(2, 1)``.
            u: points (..., w); the reference pose by default, where it is ``α! c_α``.

        Returns:
            Shape (..., n), SI units; all derivatives beyond the order are 0.

        Raises:
            ValueError: ``alpha`` is not a multi-index.
        """
        alpha = np.asarray(alpha)
        if alpha.shape != self.scales.shape or not (alpha == np.abs(alpha).astype(int)).all():
            raise ValueError(f"a multi-index is {self.scales.size} whole numbers, not {alpha}")
        above = (self.exponents >= alpha).all(axis=1)
        exponents = self.exponents[above] - alpha
        factorial = np.cumprod([1.0, *range(1, self.order + 1)])
        ratio = (factorial[self.exponents[above]] / factorial[exponents]).prod(axis=1)
        coefficients = ratio[:, None] * self.coefficients[above]
        at = np.zeros(alpha.size) if u is None else self._points(u)
        derivatives: Array = monomial_powers(exponents, at) @ coefficients
        return derivatives

    @cached_property
    def radius(self) -> float:
        """Estimated radius of convergence: `distance` within which the series converges.

        Terms decrease like ``ρ^-k k^(-3/2)`` if the nearest singularity is a square root, as
        is usual. ρ is estimated from the growth of the terms of high order along many
        directions, and the least value counts. The radius is infinite if the motion is
        linear. A singularity with little effect on 24 terms is missed, such as that of a
        four-bar which is almost a kite.
        """
        width, rng = self.scales.size, np.random.default_rng(DIRECTION_SEED)
        normals = rng.standard_normal((DIRECTIONS_PER_INPUT * width, width))
        least, worst = np.inf, np.zeros(width)
        for spread in DIRECTION_SPREADS[: 1 if width == 1 else None]:
            directions = worst + spread * normals
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            radii = [_series_radius(self._term_sizes(d)) for d in directions]
            if min(radii) < least:
                least, worst = min(radii), directions[np.argmin(radii)]
        return RADIUS_SAFETY * least

    def distance(self, u: ArrayLike) -> Array:
        """Compute the distance of points u (..., w) from the reference pose.

        Returns:
            Shape (...), in radians and characteristic lengths, as `radius`.
        """
        distances: Array = np.linalg.norm(self._points(u) / self.scales, axis=-1)
        return distances

    def error(self, u: ArrayLike) -> Array:
        """Estimate the largest joint error of `evaluate` at points u (..., w).

        It is the largest entry of the first Newton step that closes the loops there, plus a
        bound on rounding.

        Returns:
            Shape (...), in radians and characteristic lengths; NaN beyond the radius of
            convergence, where the step is no estimate.
        """
        points = self._points(u)
        errors = np.full(points.shape[:-1], np.nan)
        inside = self.distance(points) <= self.radius
        q = self._in_chain(self.evaluate(points[inside]))
        steps = np.reshape([solve_positions(self.chain, x, 1)[0] - x for x in q], q.shape)
        rounding = np.finfo(float).eps * self.condition
        sizes = rounding * np.maximum(1.0, np.abs(q).max(axis=-1, initial=0.0))
        errors[inside] = sizes + np.abs(steps).max(axis=-1, initial=0.0)
        return errors

    def polish(self, u: ArrayLike) -> Array:
        """Compute the positions of all joints that close the loops at one point u (w,).

        Continuation along the straight line from the reference pose, with Newton's method in
        every step. The branch and the success do not depend on the order of the expansion.

        Returns:
            Shape (n,), rad and m.

        Raises:
            PoseError: ``u`` is not one point.
            UnreachedError: the loops cannot be closed all along that line.
        """
        point = self._points(u)
        if point.ndim != 1:
            raise PoseError(
                f"{self.linkage.source}: loops are closed at one point at a time, not at an "
                f"array of shape {point.shape}"
            )
        inputs, values = self.motion.inputs, self.motion.basis @ point
        goal = zip(inputs, values, strict=True)
        q = solve_joint_positions(self.chain, point / self.scales, self.linkage.source, goal)
        pose = self.positions(q)
        pose[self.linkage.positions_of(inputs)] = values  # without the rounding of the steps
        return pose

    def positions(self, q: ArrayLike) -> Array:
        """Convert positions of the chain's joints to those of all joints (n,), SI units."""
        positions = np.zeros(len(self.joints))
        positions[self.chain.joints] = np.asarray(q) * self.chain.units
        return positions

    def _points(self, u: ArrayLike) -> Array:
        """Convert points to an array (..., w), and check it."""
        points = np.asarray(u, dtype=np.float64)
        if points.shape[-1:] != self.scales.shape or not np.isfinite(points).all():
            raise PoseError(
                f"{self.linkage.source}: points of the motion are {self.scales.size} finite "
                f"numbers each, not an array of shape {points.shape}"
            )
        return points

    def _in_chain(self, q: Array) -> Array:
        """Convert joint positions to the units of the chain (..., moving joints)."""
        return q[..., self.chain.joints] / self.chain.units

    def _term_sizes(self, direction: Array) -> Array:
        """Largest joint term of each order along a direction (w,), from order 1 on."""
        rates = expand(self.chain, direction[None], RADIUS_ORDER - 1).C[0] @ direction
        return np.abs(rates).max(axis=1) / np.arange(1, RADIUS_ORDER + 1)


def _series_radius(terms: Array) -> float:
    """Estimate the radius of convergence of a series from the sizes of its terms.

    It is the smaller of two estimates: from the root of late terms, and from the growth of
    late maxima over earlier ones, since terms oscillate if complex singularities are nearest.
    Terms of round-off count as if they were as large as it may be: the estimate is then low. A
    series without terms of low order but the first is that of a linear motion.

    Args:
        terms: sizes from order 1 on (orders,).
    """
    count = len(terms)
    order = np.arange(1, count + 1)
    floor = TERM_ROUND_OFF * terms[0]
    if not terms[1:LINEAR_ORDER].max() > floor:
        return np.inf
    levels = np.log(np.maximum(terms, floor)) + 1.5 * np.log(order)
    half, quarter = count // 2, count // 4
    root = np.max((levels[half:] - levels[0]) / (order[half:] - 1))
    slope = (levels[-quarter:].max() - levels[quarter:half].max()) / half
    return float(np.exp(-max(root, slope)))


def scaled_chain(chain: Chain, linkage: Linkage, motion: Motion) -> tuple[Chain, Array]:
    """Change the columns of a chain to the coordinates of a motion, scaled to unit size.

    Args:
        chain: the moving joints as arrays.
        motion: relations between its inputs.

    Returns:
        The chain, and the scale of each coordinate (w,): the SI value of one unit.
    """
    if chain is linkage.chain:  # its columns are the inputs, one unit each
        scales = chain.units[chain.once(_independent_joints)]
        scales.setflags(write=False)
        return chain, scales
    at = {joint: j for j, joint in enumerate(chain.joints.tolist())}
    inputs = linkage.positions_of(motion.inputs).tolist()
    moving = [c for c, joint in enumerate(inputs) if joint in at]
    independent = np.array([at[inputs[c]] for c in moving], dtype=np.int64)
    basis = motion.basis[moving] / chain.units[independent, None]
    scales = 1.0 / np.linalg.norm(basis, axis=0)
    return move_chain(chain, independent, basis * scales), freeze(scales)


def _independent_joints(chain: Chain) -> IntArray:
    """The joint of each column (w,), where each moves one of the independent joints."""
    joints: IntArray = np.argmax(chain.columns != 0.0, axis=0)
    return joints


def taylor_motion(
    linkage: Linkage,
    order: int,
    motion: str | Sequence[str] | Motion | None = None,
    *,
    equations: Sequence[int] | None = None,
) -> TaylorMotion:
    """Compute the Taylor expansion of the closed motion about the reference pose.

    ``q(u) = Σ_α c_α u^α`` with the joint positions q, displacements u of the inputs, and
    coefficients c up to a degree. The recursion: docs/theory/closure.md.

    Args:
        linkage: an assembled linkage; see `kinematics.tool` for its inverse kinematics.
        order: highest degree, at least 1.
        motion: restriction of the inputs, as relations or as a `Motion`.
        equations: numbers of the loop closure equations to solve: six for each loop,
            ``[ω; v]``, or three in a plane, then one for each mimic joint. By default all
            are solved by least squares, which is better conditioned than any selection.

    Returns:
        The polynomials, in radians and metres.

    Raises:
        MotionError: the motion is not one of this linkage's inputs.
        MobilityError: the linkage cannot follow the motion, or the equations do not determine
            it.
        LinkageError: there are too many coefficients.
        ValueError: the order is less than 1.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, 2019, Eq. 4.30 (derivatives of the
        closed motion); the recursion is in `kinematics.closure.taylor.expansion_kernels`.

    Example:
        >>> import kinematics
        >>> motion = kinematics.taylor_motion(kinematics.load("robot.urdf"), order=3)
        >>> motion.joints
        ('u1', 'q2', 'q4', 'q3')
        >>> motion.evaluate([0.1]).round(4).tolist()
        [0.1, -0.1192, 0.0329, 0.0521]
    """
    if order < 1:
        raise ValueError(f"the order is at least 1, not {order}")
    given = motion_of(linkage, motion)
    motion = given or Motion.free(linkage.inputs)
    chain, scales = scaled_chain(moving_chain(linkage, given), linkage, motion)
    table = monomial_table(chain.width, order)
    chosen = None if equations is None else tuple(map(int, equations))
    layout = packed_layout(chain, order, chosen)
    chain_coefficients, condition = polynomials(chain.screws, layout)
    if not condition < CLOSURE_CONDITION:
        raise MobilityError(
            f"{linkage.source}: the closure equations hardly determine the other joints "
            f"(condition number {condition:.1g}); choose other inputs or equations"
        )
    coefficients = _to_si(chain_coefficients, chain, scales, table, len(linkage.joints))
    return TaylorMotion(
        linkage,
        motion,
        names_of(linkage.joints),
        table.exponents,
        coefficients,
        max(condition, 1.0),
        chain,
        scales,
    )


def _to_si(
    chain_coefficients: Array, chain: Chain, scales: Array, table: Monomials, joints: int
) -> Array:
    """Convert coefficients of the moving joints to those of all joints in SI units."""
    units = chain.units
    if any(scale != 1.0 for scale in scales.tolist()):
        units = monomial_powers(table.exponents, 1.0 / scales)[:, None] * units
    coefficients = chain_coefficients * units
    if chain.joints.size < joints:
        moving, coefficients = coefficients, np.zeros((len(coefficients), joints))
        coefficients[:, chain.joints] = moving
    coefficients.setflags(write=False)
    return coefficients
