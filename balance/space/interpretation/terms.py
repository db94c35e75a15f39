"""Terms: named inertial elements at named points and in named directions of a linkage.

Point masses at the centres of joints, displacements from there, and rods along links, along
the axes of joints, and across both, as a designer would draw them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.conversions import to_chain
from balance.space.inertial_parameters.multipole import UNITS, Primitive
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    FRACTION_IN_TEXT,
    FRACTION_ROUND_OFF,
    GEOMETRY_EQUAL,
    TERMS_RANK,
)
from kinematics.model.arrays import Frame
from kinematics.model.linkage import Joint
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg import vectors
from kinematics.wording import number_text

# Cost of a term in the search for few terms: along a direction, across it, between two.
PLAIN, CROSSING, OBLIQUE = 1.0, 1.02, 1.05
# How the names of directions begin that are normal to others.
NORMAL = "the normal to "


class Term(NamedTuple):
    """Primitives on one body that belong together, with a name.

    Attributes:
        name: such as ``"point mass at j2"``, ``"rod along j1-j2"``; ``"rod"`` in a plane.
        primitives: one; or two rods of opposite values.
        cost: in the search for few terms.
        value: factor of the primitives.
    """

    name: str
    primitives: tuple[Primitive, ...]
    cost: float = PLAIN
    value: float = 1.0

    def times(self, value: float) -> Term:
        """Multiply all primitives of the term by a value."""
        primitives = (p._replace(value=value * p.value) for p in self.primitives)
        return Term(self.name, tuple(primitives), self.cost, value * self.value)

    def on(self, body: str) -> Term:
        """Move the term to another body."""
        return self._replace(primitives=tuple(p._replace(body=body) for p in self.primitives))


def term_vectors(space: DesignSpace, primitives: Iterable[Primitive], scaled: bool) -> Array:
    """Compute the parameters of primitives in the rows of ``basis``; (parameters, primitives).

    Args:
        space: the design space whose parameters count.
        primitives: on bodies of the space.
        scaled: in the units of the chain, where the columns of ``basis`` are orthonormal,
            instead of SI units.
    """
    some = list(primitives)
    # Positions are relative to the middle of the mechanism, so that nothing large cancels.
    scaled_primitives = [_scale_primitive(p, space.chain.frame) if scaled else p for p in some]
    z = np.array([primitive.parameters() for primitive in scaled_primitives]).reshape(-1, 10)
    z = to_chain(z, Frame(space.axes), space.planar, space.balance == "force")
    out = np.zeros((len(some), len(space.bodies), z.shape[1]))
    at = {name: b for b, name in enumerate(space.bodies)}
    out[np.arange(len(some)), [at[primitive.body] for primitive in some]] = z
    return out.reshape(len(some), -1).T


def _scale_primitive(primitive: Primitive, frame: Frame) -> Primitive:
    """Scale a primitive to the unit of length and the origin of the chain."""
    power = {"mass": 0, "displacement": 1, "rod": 2}[primitive.kind]
    point = primitive.point
    return primitive._replace(
        value=primitive.value / frame.length**power,
        point=None if point is None else (point - frame.origin) / frame.length,
    )


def candidate_terms(space: DesignSpace) -> list[Term]:
    """List every term on the bodies that move, body by body; they span all parameters."""
    terms: list[Term] = []
    for b, name in enumerate(space.bodies):
        if space.chain.links[b] >= 0:
            terms += _terms_of_body(space, name, _named_points(space, b))
    return terms


def _terms_of_body(space: DesignSpace, body: str, places: Sequence[_NamedPoint]) -> list[Term]:
    """List masses and displacements at joints, and rods, that span all parameters of a body."""
    named = [_named_directions(space, k, places) for k in range(len(places))]
    terms = _terms_at(space, body, places, named)
    parts = [p for term in terms for p in term.primitives]
    if np.linalg.matrix_rank(term_vectors(space, parts, True), TERMS_RANK) < len(space.labels):
        axes = [_NamedDirection(a, name) for a, name in zip(space.axes, "xyz", strict=True)]
        axes = axes[:2] if space.planar else axes
        origin = _NamedPoint("the origin", np.zeros(3), space.axes[0], "x")
        names = {term.name for term in terms}
        more = _terms_at(space, body, places[:1] or [origin], [axes])
        terms += [term for term in more if term.name not in names]
    return terms


def _terms_at(
    space: DesignSpace,
    body: str,
    places: Sequence[_NamedPoint],
    named: Sequence[Sequence[_NamedDirection]],
) -> list[Term]:
    """List all terms at places, each in the directions of its own."""
    terms = [
        Term(f"point mass at {site.name}", (Primitive("mass", body, 1.0, site.point),))
        for site in places
    ]
    if space.balance == "force":
        # The place of a displacement does not matter to the linear momentum.
        some = _distinct_directions([d for group in named for d in group])
        return terms + _displacements(body, places[0].point, "displacement", some)
    for site, group in zip(places, named, strict=True):
        terms += _displacements(body, site.point, f"displacement at {site.name}", group)
    return terms + _rods(body, named, space.planar)


def _displacements(
    body: str, point: Array, name: str, some: Sequence[_NamedDirection]
) -> list[Term]:
    """List displacements from a point in some directions."""
    return [
        Term(
            f"{name} {d.adverb}",
            (Primitive("displacement", body, 1.0, point, d.along),),
            CROSSING if d.normal else PLAIN,
        )
        for d in some
    ]


def _rods(body: str, named: Sequence[Sequence[_NamedDirection]], planar: bool) -> list[Term]:
    """List rods in all directions, and ± pairs between perpendicular ones at a joint.

    In a plane all rods are the same.
    """
    some = sorted(
        _distinct_directions([d for group in named for d in group]), key=lambda d: d.normal
    )
    if planar:
        return [Term("rod", (Primitive("rod", body, 1.0, None, d.along),)) for d in some[:1]]
    terms = [
        Term(
            f"rod {d.adverb}",
            (Primitive("rod", body, 1.0, None, d.along),),
            CROSSING if d.normal else PLAIN,
        )
        for d in some
    ]
    products = np.empty((0, 3, 3))
    for direction, other in (pair for group in named for pair in combinations(group, 2)):
        product = np.outer(direction.along, other.along) + np.outer(
            other.along, direction.along
        )
        off = np.minimum(*(abs(products + s * product).max(axis=(1, 2)) for s in (1.0, -1.0)))
        if (
            abs(direction.along @ other.along) < GEOMETRY_EQUAL
            and off.min(initial=1.0) > GEOMETRY_EQUAL
        ):
            products = np.concatenate([products, product[None]])
            terms.append(_pair(body, direction, other))
    return terms


def _pair(body: str, direction: _NamedDirection, other: _NamedDirection) -> Term:
    """Make rods halfway between perpendicular a and b: + along a + b, - along a - b."""
    sides = ((1.0, direction.along + other.along), (-1.0, direction.along - other.along))
    rods = (Primitive("rod", body, sign, None, v / 2.0**0.5) for sign, v in sides)
    second = other.name.replace(direction.name, "it")
    return Term(f"± pair of rods between {direction.name} and {second}", tuple(rods), OBLIQUE)


def describe_terms(terms: Sequence[Term]) -> str:
    """Describe terms with their values, those of one name together.

    Values carry their units where kinds are mixed; otherwise only ratios matter.
    """
    mixed = len({term.primitives[0].kind for term in terms}) > 1
    groups: dict[str, list[str]] = {}
    for term in terms:
        first = term.primitives[0]
        unit = f" {UNITS[first.kind]}" if mixed else ""
        text = f"{_number(term.value)}{unit} on the {first.body}"
        groups.setdefault(term.name, []).append(text)
    return "; ".join(f"{name} {', '.join(values)}" for name, values in groups.items())


def round_to_fraction(value: float) -> float:
    """Round a number to a fraction with a denominator up to 12, if one is near enough."""
    fraction = float(Fraction(value).limit_denominator(12))
    return fraction if abs(fraction - value) <= FRACTION_ROUND_OFF else value


def _number(value: float) -> str:
    """Write a signed number, as a simple fraction if it is one."""
    fraction = Fraction(value).limit_denominator(12)
    if fraction and abs(float(fraction) - value) <= FRACTION_IN_TEXT:
        return f"{'-' if value < 0 else '+'}{abs(fraction)}"
    return number_text(value, "+.6g")


class _NamedDirection(NamedTuple):
    """A direction with a name.

    Attributes:
        along: unit vector (3,).
        name: such as ``"u1-q2"``, which points from u1 to q2, ``"the axis of u1"`` or
            ``"the normal to u1-q2"``.
    """

    along: Array
    name: str

    @property
    def normal(self) -> bool:
        """Whether it is normal to other directions."""
        return self.name.startswith(NORMAL)

    @property
    def adverb(self) -> str:
        """The name as it follows a noun: ``"along u1-q2"``, ``"across u1-q2"``."""
        return f"across {self.name[len(NORMAL) :]}" if self.normal else f"along {self.name}"


class _NamedPoint(NamedTuple):
    """A joint of a body, as a point with an axis.

    Attributes:
        name: of the joint in the file.
        point: its centre (3,), metres.
        axis: unit vector along it (3,).
        label: name of the axis.
    """

    name: str
    point: Array
    axis: Array
    label: str


def _named_points(space: DesignSpace, body: int) -> list[_NamedPoint]:
    """List the moving joints at a body, one for every centre; those of loops come last.

    Args:
        body: number of the body.
    """
    chain, joints = space.chain, space.linkage.joints
    part = space.chain_transfers.rigid_part
    here = [
        joints[k]
        for j, k in enumerate(chain.joints)
        if part[chain.links[body]] in (part[j], part[chain.parent[j]])
    ]
    apart = GEOMETRY_EQUAL * space.length
    first = vectors.distinct_vectors(
        [joint.point for joint in here],
        lambda some, point: np.linalg.norm(some - point, axis=1) <= apart,
    )
    return [_named_point(here[k]) for k in first]


def _named_point(joint: Joint) -> _NamedPoint:
    """Name a joint; one of several degrees goes by its own name."""
    axis = joint.direction
    return _NamedPoint(joint.whole, joint.point, axis / np.linalg.norm(axis), joint.name)


def _named_directions(
    space: DesignSpace, place: int, places: Sequence[_NamedPoint]
) -> list[_NamedDirection]:
    """List directions at a joint of a body: along its links and axes, and across them.

    Across is the vector product of the axis, or of the normal of the plane, with another.

    Args:
        space: whose axes count if it is planar.
        place: number of the joint.
        places: the joints of the body.
    """
    site = places[place]
    axis = _NamedDirection(site.axis, f"the axis of {site.label}")
    links = _link_directions(place, places)
    if space.planar:
        n = space.axes[2]
        plain = _distinct_directions(
            [*links, *([axis] if abs(site.axis @ n) < GEOMETRY_EQUAL else [])]
        )
        crossed, end = plain, ""
    else:
        n = site.axis
        crossed = [*links, *(_NamedDirection(s.axis, f"the axis of {s.label}") for s in places)]
        plain = _distinct_directions([*links, axis])
        parallel = all(np.linalg.norm(np.cross(s.axis, n)) < GEOMETRY_EQUAL for s in places)
        end = "" if parallel else f" and {axis.name}"
    normals = [_NamedDirection(np.cross(n, d.along), f"{NORMAL}{d.name}{end}") for d in crossed]
    return _distinct_directions([*plain, *normals])


def _link_directions(place: int, places: Sequence[_NamedPoint]) -> list[_NamedDirection]:
    """List directions from joint to joint, and to the middle of more than two."""
    site, directions = places[place], []
    for k, other in enumerate(places):
        if k != place:
            first, second = (site, other) if place < k else (other, site)
            along = second.point - first.point
            directions.append(_NamedDirection(along, f"{first.name}-{second.name}"))
    if len(places) > 2:
        middle = np.mean([other.point for other in places], axis=0)
        directions.append(_NamedDirection(middle - site.point, f"{site.name}-middle"))
    return _distinct_directions(directions)


def _distinct_directions(directions: Sequence[_NamedDirection]) -> list[_NamedDirection]:
    """Normalise directions, and remove zeros and repetitions up to sign."""
    unit = [
        direction._replace(along=direction.along / size)
        for direction in directions
        if (size := float(np.linalg.norm(direction.along))) > GEOMETRY_EQUAL
    ]
    first = vectors.distinct_vectors([direction.along for direction in unit], _opposite_or_same)
    return [unit[k] for k in first]


def _opposite_or_same(some: Array, vector: Array) -> Flags:
    """Mark the unit vectors (k, 3) that equal another one (3,), up to sign."""
    apart = np.minimum(abs(some - vector).max(axis=1), abs(some + vector).max(axis=1))
    return np.asarray(apart <= GEOMETRY_EQUAL)
