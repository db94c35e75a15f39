"""Counterweights that turn about their own centres and so balance moments (CRCM).

A turning counterweight on the link after joint j is a point mass m at p with a thin ring about
an axis along that of the joint, of the axial inertia ``J ≤ m ρ²``. It turns -(N + 1) times
against its link for one turn of the joint, so that it counts as matter of the link,

    D = m [p; 1][p; 1]ᵀ        and        J (n nᵀ + 1) / 2,

and has the momentum ``-(N + 1) J n q̇_j`` besides. With ``D ⪰ 0`` instead of rank one, all is
linear or conic: the least mass over all D, J and the matter on the other links is a lower
bound, and ``p`` the centre of D. A nearer counterweight is heavier, and of less inertia about
the joint, which its own turning has to cancel. In a serial chain this is one equation for each
link, from the tip to the base: with the first moment a and the inertia I of all that a link
carries, ``I + a² / m = N m ρ²``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import (
    MomentCone,
    lump_cone,
    moment_cone,
    parameters_per_moment,
)
from balance.masses.counterweights.added_program import objective_of
from balance.masses.counterweights.counterweights import counterweights
from balance.masses.counterweights.link_regions import default_region, regions_of, wide_region
from balance.masses.counterweights.regions import Region
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.remedies.applied import AppliedRemedy, refused, total_inertia
from balance.masses.remedies.counter_rotations.counter_rotors import (
    RotorConditions,
    disc_columns,
    rotor_conditions,
)
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    FewestRotors,
    RotorSet,
    fewest_rotors,
)
from balance.masses.remedies.counter_rotations.rotor_elements import RotorWriter
from balance.masses.remedies.counter_rotations.separate_rotors import (
    MOST_SETS,
    answer_without_rotors,
    rotor_details,
    rotor_variant,
    unusable,
)
from balance.masses.remedies.judge_variant import judge_variant, space_with
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.trade_off import TradeOff, best_points, prices_of
from balance.masses.remedies.variant import Variant
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import CONDITION_WITHOUT_MATTER, ROTOR_WITHOUT_MOMENTUM
from kinematics.closure.series import expand
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import round_decimals
from kinematics.wording import count_noun, number_text

# Decimals of places, in characteristic lengths of the linkage.
DECIMALS = 7

# Part of the radius that places leave free: at the very least mass all matter is at the rim,
# and no program for the masses would have an inner point.
SPARE_RADIUS = 1e-4


def apply_counter_rotary_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by the fewest counterweights that turn against their links.

    The counterweight of the link after a joint turns about an axis parallel to that of the
    joint: -N times for one turn of the joint, seen from the link before the joint, N being
    ``request.gear``. On its own link it therefore turns -(N + 1) times; with N = 1 it turns
    against the link at the link's own rate. Its matter is within a ball of the radius of
    rotors. Each lies where the least mass is added; see
    `balance.masses.remedies.counter_rotations.counter_rotary_masses`.

    Yields:
        A result for each of up to three smallest sets of joints, least momenta first.

    Source:
        J. L. Herder, C. M. Gosselin, A counter-rotary counterweight (CRCW) for light-weight
        dynamic balancing, ASME DETC, 2004.
    """
    if why := unusable(request):
        yield refused("counter_rotary_masses", why)
        return
    fewest = fewest_rotors(request.space, progress=request.progress)
    if fewest.verdict != "feasible" or not fewest.count:
        yield answer_without_rotors("counter_rotary_masses", fewest)
        return
    plain = request.changed(trade_off=0)
    for rotor_set in fewest.sets[:MOST_SETS]:
        lightest = lightest_places(request, rotor_set.joints)
        applied = judge_variant(plain, _variant(request, fewest, rotor_set, lightest))
        if request.trade_off and lightest is not None and applied.verdict == "feasible":
            points = _trade_off(request, fewest, rotor_set, applied, lightest)
            applied = replace(applied, trade_off=points)
        yield applied


def _trade_off(
    request: RemedyRequest,
    fewest: FewestRotors,
    rotor_set: RotorSet,
    applied: AppliedRemedy,
    lightest: LightestPlaces,
) -> tuple[TradeOff, ...]:
    """Find the places of the least inertia and price of mass, and what they take when built."""
    assert applied.added_mass is not None and applied.input_inertia is not None
    inertia = total_inertia(request, applied.input_inertia)
    gap = max(0.0, 1.0 - lightest.mass / applied.added_mass)
    points = [TradeOff(applied.added_mass, inertia, request.gear, None, gap)]
    area, spatial = request.space.length**2, request.space.planar
    for price in prices_of(request.trade_off):
        best = lightest_places(request, rotor_set.joints, price)
        if best is None:
            continue
        variant = _variant(request, fewest, rotor_set, best)
        space = space_with(request, variant)
        space = recompute_spatial(space) if spatial else space
        regions = {**request.regions, **variant.regions}
        built = counterweights(
            space,
            variant.free,
            regions,
            "rotor",
            price_of_mass=price,
            density=request.density,
            relax=False,
        )
        if built.verdict != "feasible" or built.value is None or built.priced is None:
            continue
        gap = max(0.0, 1.0 - best.mass / built.priced)
        points.append(TradeOff(built.added_mass, built.value, request.gear, price * area, gap))
    return best_points(points)


def _variant(
    request: RemedyRequest,
    fewest: FewestRotors,
    rotor_set: RotorSet,
    lightest: LightestPlaces | None,
) -> Variant:
    """Build turning counterweights where they are best, or where forces want them."""
    writer, linkage = RotorWriter(request), request.linkage
    bodies = {body.link: body for body in linkage.bodies}
    places = _force_places(request) if lightest is None else lightest.centres
    decimals = DECIMALS - int(np.floor(np.log10(request.space.length)))
    links, rotors, levers = [], [], {}
    for name, j in zip(
        rotor_set.joints, linkage.positions_of(rotor_set.joints).tolist(), strict=True
    ):
        body = bodies[j]
        axis = np.linalg.solve(body.frame, [*linkage.joints[j].point, 1.0])[:3]
        place = round_decimals(places.get(body.name, axis), decimals)
        n = body.frame[:3, :3].T @ linkage.joints[j].screw[:3]
        levers[body.name] = float(np.linalg.norm(np.cross(n, place - axis)))
        rotors.append(writer.on_child(name, place, -request.gear - 1.0))
        links.append(body.name)
    number = count_noun(len(rotors), "turning counterweight")
    sizes = ", ".join(f"{number_text(lever, '.3g')} m" for lever in levers.values())
    words = (
        f"{number} on {', '.join(links)}, against {', '.join(rotor_set.joints)}, {sizes} from "
        "the axes of these joints"
    )
    details = {**rotor_details(fewest, rotor_set), "levers": levers}
    if lightest is not None:
        details |= {"minimised": "added mass", "least_mass": lightest.mass}
    return rotor_variant(request, "counter_rotary_masses", words, rotors, details)


def _force_places(request: RemedyRequest) -> Mapping[str, Array]:
    """Find where force balance puts the counterweight of each link, in its frame (3,)."""
    force = design_space(request.linkage, request.motion or None, "force")
    matter = counterweights(
        force, request.links, request.regions, density=request.density, relax=False
    )
    return {weight.link: weight.com for weight in matter.weights}


class LightestPlaces(NamedTuple):
    """Where turning counterweights are lightest.

    Attributes:
        centres: centre by name of the link (3,), metres, in its frame.
        mass: least mass of all added matter, kg: no places need less. These places need it for
            rotors that are smaller by a part of 1e-4. With a price, the least sum of the
            inertia that the inputs feel at the reference pose and of the price, kg m².
    """

    centres: Mapping[str, Array]
    mass: float


def lightest_places(
    request: RemedyRequest, joints: Sequence[str], price: float | None = None
) -> LightestPlaces | None:
    """Find where turning counterweights against some joints are lightest.

    A rotor of the inertia J about the axis n of its joint turns -(N + 1) times against its
    link: for a unit rate of an input with the rotation ω of the link, the input feels

        J (n·ω - (N + 1) q̇_j)²    in a plane, and J (|ω|² - (n·ω)²) / 2 besides in space.

    Args:
        request: the request, for its gear, its radius, and the regions of its links.
        joints: joints with a turning counterweight on the link after them.
        price: minimise the inertia that the inputs feel, and this price of mass, in squares of
            the characteristic length; the mass alone by default.

    Returns:
        The places; None if there is no such matter, also in wider regions.
    """
    space = request.spatial_space
    conditions = rotor_conditions(space, joints)
    if len(conditions.joints) < len(joints):
        return None
    regions = regions_of(space, request.links, request.regions)
    bodies = _bodies_after(space, joints)
    within = {b: regions[b] if b in regions else default_region(space, b) for b in bodies}
    wide = {
        b: region if space.bodies[b] in request.regions else wide_region(space, b)
        for b, region in (regions | within).items()
    }
    for chosen in within | regions, wide:
        parts = {b: chosen[b] for b in regions}, [chosen[b] for b in bodies]
        least = _solve(request, conditions, *parts, request.rotor_radius, price)
        inner = (1.0 - SPARE_RADIUS) * request.rotor_radius
        places = least and _solve(request, conditions, *parts, inner, price)
        if least is not None and places is not None:
            return places._replace(mass=least.mass)
    return None


def _bodies_after(space: DesignSpace, joints: Sequence[str]) -> list[int]:
    """List the positions of the bodies that some joints carry."""
    links = [body.link for body in space.linkage.bodies]
    return [links.index(j) for j in space.linkage.positions_of(joints).tolist()]


def _solve(
    request: RemedyRequest,
    conditions: RotorConditions,
    regions: Mapping[int, Region],
    rotor_regions: Sequence[Region],
    radius: float,
    price: float | None,
) -> LightestPlaces | None:
    """Solve the program, first the matter of the links, then that of the rotors."""
    space, count = conditions.space, len(rotor_regions)
    bodies = _bodies_after(space, conditions.joints)
    shapes = [*regions.values(), *rotor_regions]
    cones = [_cone_in(region) for region in shapes]
    by_body = conditions.bodies.reshape(len(conditions.bodies), len(space.bodies), -1)
    matter = [
        by_body[:, b] @ parameters_per_moment(space, {b: region})[0]
        for b, region in [*regions.items(), *zip(bodies, rotor_regions, strict=True)]
    ]
    rings = disc_columns(conditions) + (request.gear + 1.0) * conditions.rotors
    columns = np.hstack(
        [M @ triangles(cone.matrices).T for M, cone in zip(matter, cones, strict=True)]
        + [rings]
    )
    masses = np.concatenate([cone.matrices[:, 3, 3] for cone in cones] + [np.zeros(count)])
    unit = float(np.abs(conditions.given).max()) or 1.0
    balanced, target = _independent(columns, -conditions.bodies @ conditions.given / unit)
    if balanced is None:
        return None
    at = np.cumsum([0, *(len(cone.matrices) for cone in cones)])
    rows, parts = [balanced], [ConstraintBlock("zero", len(balanced))]
    for k, cone in enumerate(cones):
        block = np.zeros((len(cone.rows), len(masses)))
        block[:, at[k] : at[k + 1]] = cone.rows
        rows.append(block)
        parts += cone.parts
    # 0 ≤ J ≤ m ρ²
    limits = np.zeros((2 * count, len(masses)))
    rim = (radius / space.chain.frame.length) ** 2
    for k in range(count):
        places = slice(at[len(regions) + k], at[len(regions) + k + 1])
        limits[k, places] = rim * masses[places]
        limits[[k, count + k], at[-1] + k] = -1.0, 1.0
    stacked = np.vstack([*rows, limits])
    parts.append(ConstraintBlock("nonnegative", 2 * count))
    offset = np.zeros(len(stacked))
    offset[: len(target)] = -target
    cost, scale, constant = masses, unit, 0.0
    if price is not None:
        chosen = [*regions.items(), *zip(bodies, rotor_regions, strict=True)]
        felt, scale, constant = _felt(request, conditions, chosen, cones, unit)
        cost = felt + price * masses
    solution = solve_conic(cost, stacked, offset, parts)
    if solution.infeasible or not np.isfinite(solution.x).all():
        return None
    centres = {}
    for k, (b, region) in enumerate(zip(bodies, rotor_regions, strict=True), len(regions)):
        moments = np.einsum("n,nij->ij", solution.x[at[k] : at[k + 1]], cones[k].matrices)
        if not moments[3, 3] > ROTOR_WITHOUT_MOMENTUM:
            return None
        centres[space.bodies[b]] = (region.place @ moments[:, 3] / moments[3, 3])[:3]
    return LightestPlaces(centres, scale * float(cost @ solution.x) + constant)


def _felt(
    request: RemedyRequest,
    conditions: RotorConditions,
    regions: Sequence[tuple[int, Region]],
    cones: Sequence[MomentCone],
    unit: float,
) -> tuple[Array, float, float]:
    """Compute the inertia that the inputs feel, as a linear function of the variables.

    Returns:
        The function, kg m² per unit of it, and the part of the given masses.
    """
    space, chain = conditions.space, conditions.space.chain
    file, costs = given_parameters(space), []
    for (b, region), cone in zip(regions, cones, strict=True):
        cost, _, scale, constant = objective_of(space, {b: region}, "rotor", 0.0, file, unit)
        costs.append(triangles(cone.matrices) @ cost[0])
    motion = expand(chain, np.zeros((1, chain.width)), 0)
    rings, joints = [], chain.joints.tolist()
    positions = space.linkage.positions_of(conditions.joints).tolist()
    for j, b in zip(positions, _bodies_after(space, conditions.joints), strict=True):
        at = joints.index(j)
        rotations, n = motion.T[0, 0][chain.links[b]][:, :3], chain.screws[at, :3]
        along = rotations @ n
        turns = along - (request.gear + 1.0) * motion.C[0, 0][at]
        across = 0.5 * (np.square(rotations).sum(axis=1) - along**2)
        rings.append(float(np.sum(turns**2 + across)))
    return np.concatenate([*costs, rings]), scale, constant


def _independent(columns: Array, target: Array) -> tuple[Array | None, Array]:
    """Reduce equations ``columns x = target`` to orthonormal rows; None without a solution."""
    U, values, V = np.linalg.svd(columns, full_matrices=False)
    rank = int(np.sum(values > CONDITION_WITHOUT_MATTER * values.max(initial=0.0)))
    reduced = target @ U[:, :rank]
    missed = float(np.linalg.norm(target - U[:, :rank] @ reduced))
    if missed > CONDITION_WITHOUT_MATTER * float(np.linalg.norm(target)):
        return None, target
    return V[:rank], reduced / values[:rank]


def _cone_in(region: Region) -> MomentCone:
    """Describe matter in a region; in a cylinder by point masses at its first points."""
    from balance.masses.counterweights.cylinder_points import first_points

    return lump_cone(first_points()) if region.kind == "cylinder" else moment_cone(region)
