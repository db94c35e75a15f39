"""A member of a family as a linkage with balanced masses, confirmed by independent routes.

Some joints of a member (as many coordinates as its relations bind) are chosen as dependent.
The coordinates of all others are rounded to a grid, Newton's method returns the dependent ones
to the relations, and if these come out as fractions that fulfil all relations exactly, the
member is rational. Multiplied by the common denominator, its coordinates are whole numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import lcm
from typing import NamedTuple

import numpy as np

from balance.masses.designs.best_design import Design, design
from balance.masses.designs.feasibility import feasible
from balance.masses.designs.write_urdf import replace_inertials
from balance.motion.verification.verify_motions import verify
from balance.space.certification.certify_space import certify
from balance.space.spaces.design_space import DesignSpace
from balance.studies.discovery.confirm import random_members
from balance.studies.discovery.families import Family, relations_of
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.quantities import (
    InvariantQuantity,
    measure_quantities,
    quantities_of,
    site_geometry,
)
from balance.studies.discovery.relations import GeometryRelation, gradients, residuals
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.to_linkage import to_linkage
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

Point = tuple[Fraction, Fraction]

# Members found by walks and random ones that are tried for masses, and rational ones next to
# those that can be built.
OWN, DRAWN, ROUNDED = 10, 150, 40
TRAJECTORIES = 5
# Cells of the grid in the size of the linkage, coarse ones first.
GRIDS = (4, 8, 16, 32)
LARGEST_DENOMINATOR = 20_000
NEWTON_STEPS, CLOSE = 12, 1e-14
# Largest change of a dependent coordinate, in the size of the linkage.
FAR = 0.7


@dataclass(frozen=True, eq=False)
class ExportedMember:
    """A member with masses.

    Attributes:
        urdf: its file.
        rational: whether its coordinates are rational, so that exact arithmetic applies.
        space: its design space, certified if it is rational.
        design: masses that balance it, or the reason why there are none.
        balanced: whether the file as written is balanced; None if it carries no masses.
    """

    urdf: bytes
    rational: bool
    space: DesignSpace
    design: Design
    balanced: bool | None


def export_member(job: DiscoveryJob, family: Family) -> ExportedMember:
    """Find a member that can be built, rational if possible, and give it balanced masses.

    Raises:
        LinkageError: no member can be read as a linkage.
    """
    drawn = random_members(job.structure, family, DRAWN, np.random.default_rng([1, 2]))
    ranks = rank_least_first([-member.margin for member in family.members], 1.0)
    geometries = [family.members[k].geometry for k in ranks[:OWN]]
    members = LaneGeometry(*(np.concatenate(a) for a in zip(*geometries, drawn, strict=True)))
    best = None
    for geometry, rational in _candidates(job, family, members):
        linkage, verdict = _judge(job, family, geometry)
        if linkage is None:
            continue
        if verdict == "feasible":
            best = linkage, rational
            break
        best = best or (linkage, rational)
    if best is None:
        raise LinkageError("no member of this family could be read as a linkage")
    return _with_masses(job, *best)


def _judge(
    job: DiscoveryJob, family: Family, geometry: LaneGeometry
) -> tuple[Linkage | None, str]:
    """Read a geometry as a linkage, and decide whether it can be built."""
    try:
        built = to_linkage(job.topology, job.structure, geometry)
        linkage = _read(built.to_urdf().encode())
        space = job.space(linkage)
        if space.nullity + job.structure.uncounted != family.nullity:
            return None, ""
        return linkage, str(feasible(space).verdict)
    except LinkageError:
        return None, ""


def _candidates(
    job: DiscoveryJob, family: Family, members: LaneGeometry
) -> Iterator[tuple[LaneGeometry, bool]]:
    """Yield rational members next to those that can be built, these, and any others."""
    good: list[LaneGeometry] = []
    other: list[LaneGeometry] = []
    for lane in range(len(members.points)):
        geometry = members.take(slice(lane, lane + 1))
        linkage, verdict = _judge(job, family, geometry)
        if linkage is not None:
            (good if verdict == "feasible" else other).append(geometry)
        if len(good) == 6:
            break
    chosen = good or other[:4]
    for geometry in chosen:
        held, independent = relations_of(job.topology, job.structure, geometry)[0]
        relations = [*independent, *(r for r in held if r not in independent)]
        if job.structure.frame:
            continue  # turned into its frame, a rational member would not stay rational
        rationals = _rational_members(job.structure, family, geometry, [relations])
        for _, member in zip(range(ROUNDED), rationals, strict=False):
            points = member.geometry.points / member.scale
            yield member.geometry._replace(points=points), True
    yield from ((geometry, False) for geometry in chosen)


def _read(urdf: bytes) -> Linkage:
    return load(Document("the member", urdf))


def _with_masses(job: DiscoveryJob, linkage: Linkage, rational: bool) -> ExportedMember:
    """Design masses for a member, write them, and verify what was written."""
    space = job.space(linkage)
    if rational:
        space = certify(space)
    mass_design = design(space)
    if mass_design.z is None:
        return ExportedMember(linkage.to_urdf().encode(), rational, space, mass_design, None)
    inertials = {body.name: body.urdf for body in mass_design.bodies if body.urdf}
    urdf = replace_inertials(linkage, inertials)
    return ExportedMember(urdf, rational, space, mass_design, _is_balanced(job, _read(urdf)))


def _is_balanced(job: DiscoveryJob, written: Linkage) -> bool:
    """Decide whether the masses of a file do as required: along motions, or by its space."""
    if job.everywhere is not None:
        return bool(verify(written, balance=job.everywhere, trajectories=TRAJECTORIES).balanced)
    return job.space(written).as_given.balanced is True


class _RationalMember(NamedTuple):
    """A member whose coordinates are whole numbers.

    Attributes:
        geometry: the member, in one lane, of the size of whole numbers.
        scale: a power of ten by which it is divided to have a size near 1.
    """

    geometry: LaneGeometry
    scale: float


def _rational_members(
    structure: TopologyArrays,
    family: Family,
    members: LaneGeometry,
    relations: list[list[GeometryRelation]],
) -> Iterator[_RationalMember]:
    """Round members of a planar family to rational ones.

    Args:
        relations: for each, independent relations, followed by all others that hold.
    """
    slides = int(structure.sliding.sum())
    if family.topology.space != "plane" or slides > 1:
        return
    quantities = quantities_of(family.topology)
    for lane in range(len(members.points)):
        points = _level(structure, members, lane)
        turning = [j for j, kind in enumerate(_kinds(family)) if kind == "R"]
        for grid in GRIDS:
            for dependent in _dependent(turning, family.codimension):
                member = _round(
                    structure, family, quantities, points, relations[lane], grid, dependent
                )
                if member is not None:
                    yield member


def _kinds(family: Family) -> list[str]:
    """Return the kinds of the joints of the graph."""
    return [kind for kind, _, _ in family.topology.edges]


def _level(structure: TopologyArrays, members: LaneGeometry, lane: int) -> Array:
    """Return the points of a member (sites, 3), turned so that it slides along x."""
    sites = site_geometry(structure, members)
    points = sites.points[lane]
    if not structure.sliding.any():
        return points
    slide = structure.origin[structure.sliding][0]
    x, y, _ = sites.axes[lane, slide]
    return np.asarray(points @ np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]]))


def _dependent(joints: list[int], codimension: int) -> Iterator[list[int]]:
    """Yield choices of dependent coordinates: whole joints first, then one coordinate more."""
    for some in combinations(joints, codimension // 2):
        both = [2 * j + k for j in some for k in range(2)]
        if codimension % 2 == 0:
            yield both
        else:
            for other in (2 * j + k for j in joints for k in range(2)):
                if other not in both:
                    yield [*both, other]


def _round(
    structure: TopologyArrays,
    family: Family,
    quantities: tuple[InvariantQuantity, ...],
    points: Array,
    relations: list[GeometryRelation],
    grid: int,
    dependent: list[int],
) -> _RationalMember | None:
    """Round one member; None if its dependent coordinates are no fractions."""
    rounded = np.round(points[:, :2] * grid)
    start = rounded.ravel().copy()
    start[dependent] = (points[:, :2] * grid).ravel()[dependent]
    independent = relations[: family.codimension]
    solved = _newton(structure, quantities, start / grid, independent, dependent)
    if solved is None or np.abs(solved * grid - start).max() > FAR * grid:
        return None
    fractions = [Fraction(x) for x in rounded.ravel().tolist()]
    for k in dependent:
        value = float(solved[k] * grid)
        fractions[k] = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
        if abs(float(fractions[k]) - value) > 1e-11 * grid:
            return None
    exact = list(zip(fractions[::2], fractions[1::2], strict=True))
    if not all(_holds_exactly(relation, quantities, exact) for relation in relations):
        return None
    common = lcm(*(x.denominator for x in fractions))
    whole = np.array([float(x * common) for x in fractions]).reshape(-1, 2)
    if np.abs(whole).max() >= 1e12:
        return None
    scale = 10.0 ** np.round(np.log10(np.abs(whole).max()))
    return _RationalMember(_planar(structure, whole), float(scale))


def _planar(structure: TopologyArrays, points: Array) -> LaneGeometry:
    """Build the geometry of points (joints, 2) of a linkage that slides along x."""
    spatial = np.zeros((1, len(points), 3))
    spatial[0, :, :2] = points
    axes = np.where(structure.sliding[:, None], np.eye(3)[0], np.eye(3)[2])
    return LaneGeometry(spatial[:, structure.origin], axes[None])


def _newton(
    structure: TopologyArrays,
    quantities: tuple[InvariantQuantity, ...],
    start: Array,
    relations: list[GeometryRelation],
    dependent: list[int],
) -> Array | None:
    """Solve the relations for the dependent coordinates; None if that fails."""
    x = start.copy()
    moved = _columns(structure, dependent)
    for _ in range(NEWTON_STEPS):
        geometry = _planar(structure, x.reshape(-1, 2))
        values = measure_quantities(quantities, site_geometry(structure, geometry))
        wrong = np.array([residuals(r.kind, [r], values)[0, 0] for r in relations])
        if not np.isfinite(wrong).all():
            return None
        if np.abs(wrong).max() <= CLOSE:
            return x
        slopes = gradients(structure, quantities, geometry, relations)[0][:, moved]
        if np.linalg.matrix_rank(slopes, 1e-6) < len(dependent):
            return None
        step = np.linalg.lstsq(slopes, -wrong, rcond=None)[0]
        if np.abs(step).max() > 1.0:
            return None
        x[dependent] += step
    return x if np.abs(wrong).max() <= 10 * CLOSE else None


def _columns(structure: TopologyArrays, dependent: list[int]) -> list[int]:
    """Return the change that moves each coordinate (joint and x or y)."""
    columns = []
    for coordinate in dependent:
        joint = structure.origin.tolist().index(coordinate // 2)
        moves = (structure.moved[:, joint] != 0.0) & (
            structure.shifts[:, coordinate % 2] != 0.0
        )
        columns.append(int(np.flatnonzero(moves)[0]))
    return columns


def _holds_exactly(
    relation: GeometryRelation, quantities: tuple[InvariantQuantity, ...], points: list[Point]
) -> bool:
    """Decide whether rational points fulfil a relation exactly, by polynomials.

    Args:
        relation: the relation; a sum of lengths is never decided.
        points: the points of the joints.
    """
    sides = [
        [quantities[k].joints for k in side]
        for side in (relation.left_side, relation.right_side)
    ]
    left, right = sides
    match relation.kind:
        case "zero":
            return points[left[0][0]][1] == points[left[0][1]][1]
        case "straight":
            return _angle(left[0], points)[1] == 0
        case "right":
            return _angle(left[0], points)[0] == 0
        case "same angle" | "opposite angle":
            (a, b), (c, d) = _angle(left[0], points), _angle(right[0], points)
            return b * c == a * d if relation.kind == "same angle" else b * c == -a * d
        case "same function" | "opposite function":
            return _same_function(relation, quantities, left[0], right[0], points)
        case "equal" | "squares":
            return sum(_square(p, points) for p in left) == sum(
                _square(p, points) for p in right
            )
        case "product":
            products = [Fraction(1), Fraction(1)]
            for k, side in enumerate(sides):
                for pair in side:
                    products[k] *= _square(pair, points)
            return products[0] == products[1]
    return False


def _square(pair: tuple[int, ...], points: list[Point]) -> Fraction:
    """Compute the square of a distance."""
    (a, b), (c, d) = points[pair[0]], points[pair[1]]
    return (a - c) ** 2 + (b - d) ** 2


def _angle(joints: tuple[int, ...], points: list[Point]) -> tuple[Fraction, Fraction]:
    """Compute multiples of cosine and sine of a signed angle."""
    (x, y), (a, b), (c, d) = (points[j] for j in joints)
    a, b, c, d = a - x, b - y, c - x, d - y
    return a * c + b * d, a * d - b * c


def _same_function(
    relation: GeometryRelation,
    quantities: tuple[InvariantQuantity, ...],
    first_loop: tuple[int, ...],
    second_loop: tuple[int, ...],
    points: list[Point],
) -> bool:
    """Compare slopes or constants of two loops by their squares, and the signs."""
    sides = [
        [_square((loop[k], loop[(k + 1) % 4]), points) for k in range(4)]
        for loop in (first_loop, second_loop)
    ]
    (ab, bc, cd, da), (ef, fg, gh, he) = sides
    if quantities[relation.left_side[0]].kind == "slope":
        return ab * da * fg * gh == ef * he * bc * cd
    first, second = bc + cd - ab - da, fg + gh - ef - he
    sign = 1 if relation.kind == "same function" else -1
    same = (first > 0) == (sign * second > 0) and (first == 0) == (second == 0)
    return same and first**2 * fg * gh == second**2 * bc * cd
