"""Spatial platforms on three or four legs of parallelepipeds, with three or six freedoms.

A leg is a parallelepiped whose three edges a_k turn about constant axes n_k: three
parallelograms in series, each on a carrier that only translates. Edge k is two equal links,
side by side about the middle of the carrier; what they carry has its middle at their tips. The
tip of the leg is

    r = b + a_1 + a_2 + a_3,    ȧ_k = θ̇_k n_k × a_k

and goes everywhere near. With the mass M_k that edge k carries, the mass m_k of its two links
and both counterweights c_k, at -γ a_k, the forces are balanced if

    γ c_k = M_k + ½ m_k.

Then all that hangs on an edge has its centre of mass on its axis, no product of two rates is
left in the moment of momentum, and it is ``Σ_k J_k θ̇_k n_k`` with constant

    J_k = M_k |a_k|² + 2 (moments of inertia of a link and of its counterweight about n_k).

A rotor on the carrier below, geared to the edge by the ratio -g, of the moment of inertia
J_k / g cancels it. So a leg carries a point mass at its tip without reactions, and n points of
a platform that is equivalent to point masses there, too:

    Σ m_i = m,    Σ m_i r_i = m c,    Σ m_i (|r_i - c|² 1 - (r_i - c)(r_i - c)ᵀ) = I.

With three points, the last holds for thin plates in their plane; four are equivalent to any
platform, `equivalent_points`. Where the platform does not turn, it is not needed.

Sources: the platform as point masses on legs that are balanced one by one, with mechanisms of
parallelepipeds and counter-rotations: Y. Wu, C. M. Gosselin, Design of reactionless 3-DOF and
6-DOF parallel manipulators using parallelepiped mechanisms, IEEE Trans. Robotics 21(5), 2005,
and On the dynamic balancing of multi-DOF parallel mechanisms with multiple legs, ASME J. Mech.
Des. 129(2), 2007, after their titles and abstracts. The arrangement of the legs, the formulas
above and the sizes are ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.designs.density import STEEL
from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, number_text, repr_lines

Vector = tuple[float, float, float]

LEGS, FREEDOMS = (3, 4), (3, 6)
EDGES = 3
# Corners of a cube, one in each pair of opposite ones: Σ v vᵀ = 4.
TETRAHEDRON = ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))
# Numbers from which squares and sums overflow.
LARGEST = 1e100
# Second moment across a thin plate over the largest, at most.
ROUNDING = 1e-12
# Decimals of lengths and directions.
DECIMALS = 12
# Bounds of edges, radii of rotors, and distances of hinges from the first, m.
SHORTEST, LONGEST = 1e-4, 1e4
# Volume of a leg over that of a cuboid of its edges, second over first radius of gyration of
# the hinges, and smallest over largest speed of the inputs, at least.
FLAT = 0.05


class ParallelepipedPlatform(NamedTuple):
    """Sizes of a platform on three or four legs of parallelepipeds; SI units.

    Attributes:
        freedoms: 6, or 3 for a platform that only translates.
        hinges: where the platform is hinged to the legs, at the pose of the file, m.
        legs: of each leg the three edges as vectors, from the base to the hinge, m. An edge
            turns about the axis that is perpendicular to it and to the next one (the third:
            and to the first).
        shares: mass of the platform at each hinge, kg.
        carrier_mass: of each body that only translates, kg.
        width: of a square bar, as a part of the length of its edge.
        counter: γ, how far the counterweights are behind the axis, as a part of the edge.
        ratio: g, speed of a rotor over that of its edge.
        rotor_radius: of the rotors, solid discs, as a part of the length of the edge.
    """

    freedoms: int = 6
    hinges: tuple[Vector, ...] = ((0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2))
    legs: tuple[tuple[Vector, ...], ...] = (
        ((0.0, 0.0, 0.25), (0.2, 0.0, 0.0), (0.0, 0.15, 0.0)),
        ((0.25, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.15)),
        ((0.0, 0.25, 0.0), (0.0, 0.0, 0.2), (0.15, 0.0, 0.0)),
    )
    shares: tuple[float, ...] = (0.3, 0.3, 0.4)
    carrier_mass: float = 0.05
    width: float = 0.04
    counter: float = 1.0
    ratio: float = 10.0
    rotor_radius: float = 0.5

    def __repr__(self) -> str:
        """Two lines: the platform and its legs."""
        mass = number_text(sum(self.shares))
        hinges = count_noun(len(self.hinges), "hinge")
        freedoms = count_noun(self.freedoms, "freedom")
        return repr_lines(
            f"ParallelepipedPlatform: {mass} kg on {hinges}, {freedoms}",
            f"{count_noun(len(self.legs), 'leg')} of {EDGES} edges",
        )


DEFAULT = ParallelepipedPlatform()
"""A platform of 1 kg on three legs that are alike along x, y and z."""


class _Edge(NamedTuple):
    """An edge: its vector, axis and masses.

    Attributes:
        along: a_k, m.
        axis: n_k.
        aside: from the middle to the axis of the second link, m.
        bar, counterweight: mass of each, kg.
        ball: radius of the counterweight, m.
        rotor: mass of the rotor, kg.
        radius: of the rotor, m.
    """

    along: Array
    axis: Array
    aside: Array
    bar: float
    counterweight: float
    ball: float
    rotor: float
    radius: float


def parallelepiped_platform_urdf(
    platform: ParallelepipedPlatform = DEFAULT, name: str = "parallelepiped_platform"
) -> bytes:
    """Write a platform on legs of parallelepipeds as a URDF file, balanced.

    The inputs are the first edges ``edge_joint_L_1`` of the legs L, and with six freedoms as
    many second ones ``edge_joint_L_2`` as it takes; the platform is then on ball joints, and on
    three legs a thin plate. With three freedoms it is fixed to the legs, and its tensor is of
    no matter. Bars and counterweights are of steel, the latter as balls; rotors are discs
    whose mass follows from their radius.

    Args:
        platform: its sizes.
        name: of the robot.

    Returns:
        The file.

    Raises:
        UsageError: there are not three or four legs of three edges, a leg is flat, the hinges
            are in line, the inputs do not move the platform in all its freedoms, or a size is
            not positive, or out of bounds.

    Source:
        After Y. Wu, C. M. Gosselin, IEEE Trans. Robotics 21(5), 2005; the formulas are ours.

    Example:
        >>> from pathlib import Path
        >>> import kinematics, balance.studies
        >>> urdf = balance.studies.parallelepiped_platform_urdf()
        >>> _ = Path("spatial.urdf").write_bytes(urdf)
        >>> kinematics.load("spatial.urdf").mobility
        6
    """
    _check(platform)
    parts: list[Element] = [make_elements.link("base")]
    tips = [_add_leg(parts, platform, number) for number in range(1, len(platform.legs) + 1)]
    parts += _platform_elements(platform, tips)
    return element_text(make_elements.robot(name, parts)).encode()


def equivalent_points(
    mass: float, centre: Sequence[float], tensor: ArrayLike
) -> tuple[tuple[tuple[float, float, float], ...], tuple[float, ...]]:
    """Find four equal point masses that are equivalent to a rigid body.

    With the second moments ``S = ½ tr(I) 1 - I`` they are at ``c + √(S/m) v_i``, where v_i are
    the corners (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1), so that ``Σ v vᵀ = 4``.

    Args:
        mass: m, kg.
        centre: c, m.
        tensor: I about the centre of mass (3, 3), kg m².

    Returns:
        Hinges and shares of a `ParallelepipedPlatform`: where the masses are, m, and each, kg.

    Raises:
        UsageError: no body has this mass and tensor.

    Source:
        Y. Wu, C. M. Gosselin, ASME J. Mech. Des. 129(2), 2007, for four points; the formula is
        ours.

    Example:
        >>> import numpy as np, balance.studies
        >>> hinges, shares = balance.studies.equivalent_points(4.0, (0, 0, 0), 8 * np.eye(3))
        >>> hinges[1], shares
        ((1.0, -1.0, -1.0), (1.0, 1.0, 1.0, 1.0))
    """
    moments, c = np.array(tensor, dtype=float), np.array(centre, dtype=float)
    if moments.shape != (3, 3) or c.shape != (3,):
        raise UsageError("equivalent points: give a centre (3,) and a tensor (3, 3)")
    if not (np.abs([*moments.flat, *c, mass]) < LARGEST).all():
        raise UsageError("equivalent points: give finite numbers")
    if not np.abs(moments - moments.T).max() <= ROUNDING * np.abs(moments).max():
        raise UsageError("equivalent points: the tensor is not symmetric")
    second = 0.5 * np.trace(moments) * np.eye(3) - 0.5 * (moments + moments.T)
    squares, axes = np.linalg.eigh(second)
    # A thin plate has none across it, up to rounding.
    if not (mass > 0.0 and squares[0] >= -ROUNDING * squares[2]):
        raise UsageError("equivalent points: no body has this mass and this tensor")
    root = (axes * np.sqrt(squares.clip(0.0) / mass)) @ axes.T
    points = c + np.array(TETRAHEDRON) @ root
    return tuple((x, y, z) for x, y, z in points.tolist()), (0.25 * mass,) * len(points)


def _count_driven(platform: ParallelepipedPlatform) -> tuple[int, int, int]:
    """Count the legs whose first, second and third edge is driven; they are the first ones."""
    first = min(platform.freedoms, len(platform.legs))
    return first, platform.freedoms - first, 0


def _compute_directions(edges: Array) -> tuple[Array, Array]:
    """Compute the axes of the edges of a leg, and the directions in which their tips go.

    Args:
        edges: their vectors (3, 3), one a row.

    Returns:
        Unit vectors (3, 3) each, one a row.
    """
    axes = np.cross(edges, np.roll(edges, -1, axis=0))
    axes = axes / np.linalg.norm(axes, axis=1)[:, None]
    ways = np.cross(axes, edges)
    return axes, ways / np.linalg.norm(ways, axis=1)[:, None]


def _leg_edges(
    platform: ParallelepipedPlatform, vectors: tuple[Vector, ...], share: float
) -> list[_Edge]:
    """Find the masses of a leg, from its tip to the base."""
    along = np.array(vectors).round(DECIMALS)
    axes, ways = _compute_directions(along)
    axes = axes.round(DECIMALS)
    carried, edges = share, list[_Edge]()
    for k in reversed(range(EDGES)):
        carried += platform.carrier_mass
        length = float(np.linalg.norm(along[k]))
        side, radius = platform.width * length, platform.rotor_radius * length
        bar = STEEL * side**2 * length
        counterweight = (0.5 * carried + 0.5 * bar) / platform.counter
        ball = float((0.75 * counterweight / (np.pi * STEEL)) ** (1.0 / 3.0))
        behind = platform.counter * length
        moment = bar * (length**2 / 3.0 + side**2 / 12.0)
        moment += counterweight * (behind**2 + 0.4 * ball**2)
        J = carried * length**2 + 2.0 * moment
        rotor = 2.0 * J / (platform.ratio * radius**2)
        # The links stand apart by half the edge.
        aside = (0.25 * length * ways[k]).round(DECIMALS)
        edges.append(_Edge(along[k], axes[k], aside, bar, counterweight, ball, rotor, radius))
        carried += 2.0 * (bar + counterweight) + rotor
    return edges[::-1]


def _add_leg(
    parts: list[Element], platform: ParallelepipedPlatform, number: int
) -> tuple[str, Array]:
    """Add the links and joints of a leg; its last carrier, and the tip in its frame, m."""
    edges = _leg_edges(platform, platform.legs[number - 1], platform.shares[number - 1])
    reach = np.sum([edge.along for edge in edges], axis=0)
    below = "base", (np.array(platform.hinges[number - 1]) - reach).round(DECIMALS)
    for k, edge in enumerate(edges, 1):
        label = f"{number}_{k}"
        driven = number <= _count_driven(platform)[k - 1]
        parts += _edge_elements(platform, edge, label, below, driven)
        below = f"carrier_{label}", edge.aside
    return below


def _edge_elements(
    platform: ParallelepipedPlatform,
    edge: _Edge,
    label: str,
    below: tuple[str, Array],
    independent: bool,
) -> list[Element]:
    """Make both links of an edge, what they carry, and the rotor.

    Args:
        label: what ends the names of its links and joints.
        below: the carrier below, and its middle in its frame, m.
        independent: whether the edge is an input.
    """
    parent, middle = below
    link, twin, carrier, rotor = (
        f"{word}_{label}" for word in ("edge", "twin", "carrier", "rotor")
    )
    axis = number_words(edge.axis)
    bar = _link_inertial(platform, edge)
    ball = make_elements.inertial(
        platform.carrier_mass, _ball_tensor(platform.carrier_mass), _origin(edge.aside)
    )
    # A disc about its axis; the other moments are half of it.
    disc = 0.25 * edge.rotor * edge.radius**2 * (np.eye(3) + np.outer(edge.axis, edge.axis))
    return [
        make_elements.link(link, bar),
        make_elements.link(twin, bar),
        make_elements.link(carrier, ball),
        make_elements.link(
            rotor, make_elements.inertial(edge.rotor, disc, _origin(np.zeros(3)))
        ),
        make_elements.hinge(
            f"edge_joint_{label}",
            parent,
            link,
            _origin(middle - edge.aside),
            axis,
            independent=independent,
        ),
        make_elements.hinge(
            f"twin_joint_{label}", parent, twin, _origin(middle + edge.aside), axis
        ),
        make_elements.hinge(f"carrier_joint_{label}", link, carrier, _origin(edge.along), axis),
        make_elements.hinge(
            f"rotor_joint_{label}",
            parent,
            rotor,
            _origin(middle),
            axis,
            mimic=(f"edge_joint_{label}", -platform.ratio, 0.0),
        ),
        make_elements.loop(
            f"tip_joint_{label}",
            "revolute",
            [(twin, _origin(edge.along)), (carrier, _origin(2.0 * edge.aside))],
            (axis, ""),
        ),
    ]


def _platform_elements(
    platform: ParallelepipedPlatform, tips: list[tuple[str, Array]]
) -> list[Element]:
    """Make the platform, its frame at the first hinge, and its hinges.

    Args:
        tips: last carrier of each leg, and its tip in its frame, m.
    """
    hinges = np.array(platform.hinges)
    at = (hinges - hinges[0]).round(DECIMALS)
    masses = np.array(platform.shares)
    centre = masses @ at / masses.sum()
    tensor = sum(
        (_point_tensor(mass, r - centre) for mass, r in zip(masses, at, strict=True)),
        start=np.zeros((3, 3)),
    )
    inertial = make_elements.inertial(float(masses.sum()), tensor, _origin(centre))
    parts = [make_elements.link("platform", inertial)]
    (carrier, tip), *others = tips
    if platform.freedoms == 3:
        parts.append(make_elements.joint("hinge_1", "fixed", carrier, "platform", _origin(tip)))
    else:
        # A ball joint, of hinges with links without mass between them.
        chain = [carrier, "ball_x", "ball_y", "platform"]
        parts += map(make_elements.link, chain[1:3])
        for k, letter in enumerate("xyz"):
            place = _origin(tip if k == 0 else np.zeros(3))
            axis = number_words(np.eye(3)[k])
            parts.append(
                make_elements.hinge(f"hinge_1_{letter}", chain[k], chain[k + 1], place, axis)
            )
    for number, (link, end) in enumerate(others, 2):
        sides = [(link, _origin(end)), ("platform", _origin(at[number - 1]))]
        kind = "fixed" if platform.freedoms == 3 else "spherical"
        parts.append(make_elements.loop(f"hinge_{number}", kind, sides))
    return parts


def _link_inertial(platform: ParallelepipedPlatform, edge: _Edge) -> Element:
    """Make the ``<inertial>`` of a link: a square bar, and a ball behind the axis."""
    along = edge.along
    unit, side = along / np.linalg.norm(along), platform.width * np.linalg.norm(along)
    behind = -platform.counter * along
    mass = edge.bar + edge.counterweight
    centre = (0.5 * edge.bar * along + edge.counterweight * behind) / mass
    # The bar is as long as the edge, and as wide in all directions across it.
    tensor = edge.bar * (side**2 * np.eye(3) + along @ along * np.eye(3)) / 12.0
    tensor += edge.bar * (side**2 - along @ along) * np.outer(unit, unit) / 12.0
    tensor += 0.4 * edge.counterweight * edge.ball**2 * np.eye(3)
    tensor += _point_tensor(edge.bar, 0.5 * along - centre)
    tensor += _point_tensor(edge.counterweight, behind - centre)
    return make_elements.inertial(mass, tensor, _origin(centre))


def _ball_tensor(mass: float) -> Array:
    """Compute the tensor of a ball of steel about its centre, kg m²."""
    radius = (0.75 * mass / (np.pi * STEEL)) ** (1.0 / 3.0)
    return np.asarray(0.4 * mass * radius**2 * np.eye(3))


def _point_tensor(mass: float, at: Array) -> Array:
    """Compute the tensor of a point mass about the origin, kg m²."""
    return np.asarray(mass * (at @ at * np.eye(3) - np.outer(at, at)))


def _origin(at: Array) -> Element:
    """Make the ``<origin>`` of a point."""
    return Element("origin", {"xyz": number_words([round(float(x), 15) for x in at])})


def _check(platform: ParallelepipedPlatform) -> None:
    """Refuse sizes of no platform, or of one that does not follow its inputs."""
    where = "platform on parallelepipeds"
    if platform.freedoms not in FREEDOMS:
        raise UsageError(f"{where}: freedoms = {platform.freedoms}: give 3 or 6")
    counts = {len(platform.hinges), len(platform.legs), len(platform.shares)}
    if len(counts) != 1 or not counts <= {*LEGS} or {*map(len, platform.legs)} != {EDGES}:
        raise UsageError(f"{where}: give three or four hinges, shares and legs of three edges")
    if {*map(len, (*platform.hinges, *sum(platform.legs, ())))} != {3}:
        raise UsageError(f"{where}: hinges and edges have three coordinates")
    for field, value in _name_sizes(platform).items():
        if not 0.0 < value < float("inf"):
            raise UsageError(f"{where}: {field} = {value:g} must be positive")
    _check_lengths(platform, where)
    for number, leg in enumerate(platform.legs, 1):
        if _is_flat(np.array(leg)):
            raise UsageError(f"{where}: leg {number} is flat, or not finite")
    hinges = np.array(platform.hinges)
    radii = np.zeros(2)
    if np.isfinite(hinges).all():
        radii = np.linalg.svd(hinges - hinges.mean(axis=0), compute_uv=False)
    if not radii[1] > FLAT * radii[0]:
        raise UsageError(f"{where}: the hinges are in line, or not finite")
    speeds = np.linalg.svd(_input_speeds(platform), compute_uv=False)
    if not speeds[-1] > FLAT * speeds[0]:
        raise UsageError(
            f"{where}: its inputs do not move it in all freedoms: turn the edges of a leg in "
            "another order, or move the hinges"
        )


def _check_lengths(platform: ParallelepipedPlatform, where: str) -> None:
    """Refuse lengths of which the decimals of a file leave too little, or that overflow."""
    edges = [math.hypot(*edge) for leg in platform.legs for edge in leg]
    hinges = [math.dist(each, platform.hinges[0]) for each in platform.hinges[1:]]
    rotors = [platform.rotor_radius * length for length in edges]
    for name, sizes in ("hinges", hinges), ("edges", edges), ("rotors", rotors):
        if any(0.0 < size < SHORTEST or LONGEST < size < math.inf for size in sizes):
            raise UsageError(f"{where}: sizes of {name}: {SHORTEST:g} to {LONGEST:g} m")


def _is_flat(edges: Array) -> bool:
    """Check that edges (3, 3), or the directions in which they go, are nearly in a plane."""
    lengths = np.linalg.norm(edges, axis=1)
    if not abs(np.linalg.det(edges)) > FLAT * lengths.prod() < np.inf:
        return True
    return bool(abs(np.linalg.det(_compute_directions(edges)[1])) <= FLAT)


def _name_sizes(platform: ParallelepipedPlatform) -> dict[str, float]:
    """Name what must be positive."""
    fields = ("carrier_mass", "width", "counter", "ratio", "rotor_radius")
    sizes = {field: float(getattr(platform, field)) for field in fields}
    return sizes | {f"shares[{k}]": mass for k, mass in enumerate(platform.shares)}


def _input_speeds(platform: ParallelepipedPlatform) -> Array:
    """Compute the speeds of the driven edges for a twist of the platform, over sizes.

    A leg follows the velocity v of its hinge by the shares ``θ̇_k |a_k|`` along its directions.

    Returns:
        Rows: driven edges; columns: velocity of the middle of the hinges, and with six freedoms
        the turn times the distance of the hinges from it.
    """
    hinges = np.array(platform.hinges)
    arms = hinges - hinges.mean(axis=0)
    size = np.linalg.norm(arms, axis=1).max()
    driven, rows = _count_driven(platform), []
    for number, (arm, leg) in enumerate(zip(arms / size, platform.legs, strict=True)):
        _, ways = _compute_directions(np.array(leg))
        # The turn ω moves the hinge by ω × arm.
        x, y, z = arm
        turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        velocity = np.column_stack([np.eye(3), turn])[:, : platform.freedoms]
        speeds = np.linalg.solve(ways.T, velocity)
        rows += [speeds[k] for k in range(EDGES) if number < driven[k]]
    return np.vstack(rows)
