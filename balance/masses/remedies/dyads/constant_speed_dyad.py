"""Remedy: a dyad with which a linkage is balanced while its crank turns at constant speed.

At a constant rate φ̇ of the crank a constant moment of momentum shakes nothing, so that

    Σ p_b = 0    and    Σ h_b = J φ̇    with any constant J

are enough: the conditions of balance with the inertia of the crank about its axis left out. At
another motion the moment ``-J φ̈`` is left, and no force. In a loop of four hinges whose links
have the inertias B_b about their hinges, when the masses of its coupler are put there,

    Σ h_b = B_1 φ̇_1 + B_2 φ̇_2 + B_3 φ̇_3        (the coupler's centre of mass in line).

A dyad on the ground and the crank that repeats the loop, reflected, makes ``φ̇_2 + φ̇_4 = φ̇_1``
and ``φ̇_3 + φ̇_5 = φ̇_1`` for the rates of its links, see
`balance.masses.remedies.dyads.known_dyads`: with ``B_4 = B_2`` and ``B_5 = B_3`` the moment is
that of J = B_1 + B_2 + B_3. A crank-slider of equal lengths on the ground and the rocker makes
``φ̇_4 = -φ̇_3``: with ``B_2 = 0`` and ``B_4 = B_3`` it is that of J = B_1. The masses are sought
for all these geometries by the conditions of the linkage with the dyad, which ask for no centre
of mass in line.

Source:
    S. Briot, V. Arakelian, Mechanism and Machine Theory 57, 2012: in-line four-bars with
    constant input speed and an added RRR or RRP group.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, pi
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import (
    AppliedRemedy,
    describe_residual,
    refused,
    with_cost,
)
from balance.masses.remedies.dyads.dyad_geometry import Dyad, dyad_document
from balance.masses.remedies.dyads.dyad_sizes import (
    AS_POINTS,
    NOT_SOUGHT,
    best_size,
    size_words,
    turn_words,
)
from balance.masses.remedies.dyads.known_dyads import GEOMETRIES, DyadSeed
from balance.masses.remedies.dyads.with_dyad import (
    DYAD_LINKS,
    dyad_space,
    known_seeds,
    why_no_dyad,
)
from balance.masses.remedies.least_matter import least_matter_or_none, rim_text
from balance.masses.remedies.momentum_along import momentum_along
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.shafts.crank_turn import CrankTurn, revolve, turn_of_crank
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.verify_motions import measure_shaking
from balance.space.conditions.rank import Conditions
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import MASSES_EQUAL, ROTOR_WITHOUT_MOMENTUM
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.spatial.inertia import stack_parameters
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

KEY = "constant_speed_dyad"
# Conditioning of the loops along a turn, over that at the reference pose, below which a dyad
# passes a dead point: between the samples of a turn it falls to about 0.03 there.
DEAD_POINT = 0.1
# The lightest ones that are tried in the opposite direction too, and whose size and direction
# are sought if the remedy is named.
SOUGHT = 2


def apply_constant_speed_dyad(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage whose crank turns at constant speed by an added dyad.

    Yields:
        The lightest dyad of each kind (RRR and RRP), of known geometries in two directions;
        for a kind without any, one undecided result. If ``request.only`` names the remedy, more
        than 12 geometries are tried, and size and direction of the lightest are sought. One
        result without a dyad, if matter on the links is enough, and then dyads that take less
        of it. All are partial: a moment is
        left where the speed changes, which ``details`` has as an inertia.
    """
    if why := why_no_dyad(request):
        yield refused(KEY, why)
        return
    turn = turn_of_crank(request)
    if isinstance(turn, str):
        yield refused(KEY, turn)
        return
    if max(measure_shaking(request.linkage, [turn.trajectory])) <= SHAKING_RELATIVE:
        yield refused(KEY, "it shakes nothing at constant speed")
        return
    alone = _without_dyad(request, turn)
    if alone is not None:
        yield alone
    for slides in (False, True):
        seeds = [seed for seed in known_seeds(request) if seed.dyad.slides == slides]
        applied = _lightest(request, turn, seeds, slides)
        if alone is None or (applied.added_mass or inf) < (alone.added_mass or inf):
            yield applied


def space_at_constant_speed(space: DesignSpace, crank: int) -> DesignSpace:
    """Compute the masses that shake nothing while a crank turns at constant speed.

    Its inertia about its axis n does not count: the conditions ``C z = 0`` become
    ``(1 - v vᵀ / v·v) C z = 0`` with ``v = C e``, where e is the inertia ``n nᵀ`` of the crank.

    Args:
        space: a design space of dynamic balance.
        crank: index of its joint, which turns on the base.

    Returns:
        The space, of one more dimension; the same space if the crank carries no parameters.
        Its orders, transfers and certificates are those of ``space``.
    """
    links = [body.link for body in space.linkage.bodies]
    if crank not in links:
        return space
    n = space.linkage.joints[crank].screw[:3]
    e = np.zeros((len(links), 10))
    e[links.index(crank)] = stack_parameters(0.0, np.zeros(3), np.outer(n, n))
    conditions = space.decision.conditions
    v = conditions.rows @ to_chain(e, space.chain.frame, space.planar, False).reshape(-1)
    size = float(np.linalg.norm(v))
    if size <= ROTOR_WITHOUT_MOMENTUM:
        return space
    rows = conditions.rows - np.outer(v, v @ conditions.rows) / size**2
    kept = Conditions.given(conditions.known, conditions.tolerance).append(rows)
    return replace(space, decision=kept.decide())


class _Built(NamedTuple):
    """What is built in, and the least matter with it.

    Attributes:
        words: what is built in where.
        matter: the matter.
        links: links that are added.
        joints: joints and loops that are added.
        details: plain data about it.
    """

    words: str
    matter: Counterweights
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    details: Mapping[str, object] = {}


def _without_dyad(request: RemedyRequest, turn: CrankTurn) -> AppliedRemedy | None:
    """Balance a linkage by matter on its links, if that is enough at constant speed."""
    if not _is_steady(request.space, turn):
        return None
    matter = _least_matter(request, turn, request.space_of_base, request.links)
    if matter is None:
        return None
    words = f"no dyad: matter on {', '.join(request.links)} is enough"
    return _judge(request, turn, _Built(words, matter))


class _Choice(NamedTuple):
    """A dyad in a direction, radians, and the matter that it takes, kg.

    Attributes:
        beyond: what is known of sizes beyond the bound, if its size is one.
    """

    seed: DyadSeed
    turned: float
    mass: float
    beyond: str = NOT_SOUGHT


def _lightest(
    request: RemedyRequest, turn: CrankTurn, seeds: Sequence[DyadSeed], slides: bool
) -> AppliedRemedy:
    """Judge the lightest dyad of some known geometries of one kind.

    Geometries are compared with point masses, which take a hundredth of the time.
    """
    named = KEY in request.only
    tried = seeds if named else seeds[:GEOMETRIES]
    choices = _lightest_first(_tried(request, turn, tried))
    if named:
        choices = _lightest_first(_sought(request, turn, choices))
    kind = "RRP" if slides else "RRR"
    matter = _matter_with(request, turn, choices[0].seed) if choices else None
    if matter is None:
        reason = (
            "with the dyad that takes the least point masses no matter of this density in the "
            "regions balances it"
            if choices
            else f"{len(tried)} known geometries have no buildable masses at constant speed"
        )
        more = "" if named else f"; --only {KEY} tries all that are known"
        reason = f"no member found: {reason}{more}"
        return AppliedRemedy(KEY, f"{kind} between any two links", "undecided", reason)
    seed, turned, _, beyond = choices[0]
    beyond += AS_POINTS * (named and request.density is not None)
    frame = request.linkage.chain.frame
    _, links, joints = dyad_document(request.base, seed.dyad, seed.numbers, frame)
    first, second = seed.dyad.sides
    how = "" if named else f", the better of two directions (--only {KEY} seeks the best)"
    words = (
        f"{kind} between {first.name} and {second.name}: {size_words(seed, beyond)}, "
        f"{turn_words(turned)}{how}"
    )
    details = {"kind": kind, "geometry": seed.words, "size": seed.size, "turned": turned}
    return _judge(request, turn, _Built(words, matter, links, joints, details))


def _tried(
    request: RemedyRequest, turn: CrankTurn, seeds: Iterable[DyadSeed]
) -> Iterator[_Choice]:
    """Yield the lightest geometries with which the crank turns fully, in two directions."""
    ahead, spaces = [], {}
    for seed in seeds:
        space = dyad_space(request, seed)
        if space is None or not _is_steady(space, turn):
            continue
        matter = _matter_with(request, turn, seed, points=True)
        if matter is not None:
            ahead.append(_Choice(seed, 0.0, matter.added_mass))
            spaces[seed] = space
    lightest = _lightest_first(ahead, lambda seed: _turns_well(request, spaces[seed], turn))
    yield from lightest
    for choice in lightest:
        resized = choice.seed.resized(1.0, pi)
        matter = _matter_with(request, turn, resized, points=True)
        if matter is not None:
            yield _Choice(resized, pi, matter.added_mass)


def _sought(
    request: RemedyRequest, turn: CrankTurn, choices: Iterable[_Choice]
) -> Iterator[_Choice]:
    """Yield geometries at their best size and direction."""

    def mass_of(seed: DyadSeed) -> float:
        matter = _matter_with(request, turn, seed, points=True)
        return inf if matter is None else matter.added_mass

    for choice in choices:
        if sized := best_size(choice.seed, mass_of):
            yield _Choice(sized.seed, choice.turned + sized.turn, sized.mass, sized.beyond)


def _lightest_first(
    choices: Iterable[_Choice], fits: Callable[[DyadSeed], bool] = lambda _: True
) -> list[_Choice]:
    """Find the lightest ones, of different geometries, that fit; at most `SOUGHT`.

    Args:
        fits: whether one counts; it is asked from the lightest on until there are enough.
    """
    listed = list(choices)
    best: dict[tuple[str, Dyad], _Choice] = {}
    for k in rank_least_first([choice.mass for choice in listed], relative=MASSES_EQUAL):
        key = (listed[k].seed.words, listed[k].seed.dyad)
        if len(best) < SOUGHT and key not in best and fits(listed[k].seed):
            best[key] = listed[k]
    return list(best.values())


def _turns_well(request: RemedyRequest, space: DesignSpace, turn: CrankTurn) -> bool:
    """Whether the crank turns fully with a dyad, far from dead points of the dyad."""
    try:
        return revolve(request, space.linkage, turn.joint.name).conditioning > DEAD_POINT
    except LinkageError:
        return False


def _matter_with(
    request: RemedyRequest, turn: CrankTurn, seed: DyadSeed, points: bool = False
) -> Counterweights | None:
    """Find the least matter with a dyad; None if none balances at constant speed.

    Args:
        points: whether it is point masses, whatever density is asked for.
    """
    space = dyad_space(request, seed)
    if space is None:
        return None
    links = (*request.links, *space.bodies[-DYAD_LINKS:])
    return _least_matter(request, turn, space, links, points)


def _is_steady(space: DesignSpace, turn: CrankTurn) -> bool:
    """Whether masses that can be built balance a linkage at constant speed."""
    crank = int(space.linkage.positions_of([turn.joint.name])[0])
    return feasible(space_at_constant_speed(space, crank)).verdict == "feasible"


def _least_matter(
    request: RemedyRequest,
    turn: CrankTurn,
    space: DesignSpace,
    links: Sequence[str],
    points: bool = False,
) -> Counterweights | None:
    """Find the least matter that balances at constant speed; None if the regions have none."""
    density, thickness = (None, None) if points else (request.density, request.thickness)
    whole = space if thickness else recompute_spatial(space)
    crank = int(space.linkage.positions_of([turn.joint.name])[0])
    steady = space_at_constant_speed(whole, crank)
    return least_matter_or_none(steady, links, request.regions, density, thickness)


def _judge(request: RemedyRequest, turn: CrankTurn, built: _Built) -> AppliedRemedy:
    """Write the file, verify it by Pinocchio at constant speed, and add up its cost."""
    crank = turn.joint.name
    blank = AppliedRemedy(
        KEY,
        f"{built.words}, while {crank} turns at constant speed",
        "undecided",
        "",
        new_links=built.links,
        new_joints=built.joints,
    )
    urdf = with_counterweights(built.matter, merge=frozenset(built.links))
    document = Document(request.base.name, urdf)
    linkage = load(document, None, request.linkage.inputs, angles=request.angles)
    try:
        whole = revolve(request, linkage, crank)
    except LinkageError as error:
        return replace(blank, reason=str(error))
    shaking = measure_shaking(linkage, [whole])
    if not max(shaking) <= SHAKING_RELATIVE:
        return replace(blank, reason=describe_residual(max(shaking)))
    normal = request.linkage.chain.frame.R[2]
    J = float(momentum_along(linkage, whole).total[:, :3].mean(axis=0) @ normal)
    J *= float(np.sign(turn.joint.screw[:3] @ normal))
    added = sum(float(body.inertia[0]) for body in linkage.bodies) - request.given_mass
    reason = (
        f"balanced at constant speed of {crank}: {number_text(added)} kg added to "
        f"{number_text(request.given_mass)} kg; where the speed changes, the moment of "
        f"{number_text(J, '.3g')} kg m² times the angular acceleration of {crank} is left, and "
        f"no force{rim_text(built.matter.weights, request.links)}"
    )
    done = replace(
        blank,
        verdict="partial",
        reason=reason,
        residual=0.0,
        urdf=urdf,
        details={**built.details, "crank": crank, "inertia_left": J},
    )
    return with_cost(request, done, added, linkage, request.motion)
