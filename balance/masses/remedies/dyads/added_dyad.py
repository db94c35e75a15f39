"""A dyad added between two links of a planar linkage, with which it can be balanced.

Known geometries are tried first: a loop of four hinges repeated, reflected, and loops that are
balanced by themselves. Then walks from random geometries search for others, see
`balance.masses.remedies.dyads.dyad_search`. Whether masses can be built is decided for each
geometry by `balance.masses.feasible`; those that have some are judged as every remedy.

In a loop of four hinges J, K, M, L with K on link x and L on link y, which are hinged to each
other at J, write the plane as complex numbers. These dyads on x and y have a relation between
angles for every size and direction c of the dyad:

    reflected     f(s) = J + c conj(s - J):  hinges f(L) on x, f(K) on y, f(M) between.
                  The loop is repeated, reflected, with the parts of x and y exchanged.
    parallelogram the same with f(K) + f(L) - f(M) between.
    kite          f(s) = J + c (s - J):  hinges f(K), f(L), and f(J) reflected in their line.
    antiparallelogram  the same, reflected in the perpendicular bisector of f(K) f(L).
    crank-slider  hinge f(K), and a slide on a line through J that is fixed in y; the hinge
                  between is as far from f(K) as J is.

The first two make two relations in every loop of four hinges: against x, y turns by the sum of
the angles of LM and of the link of the dyad that repeats it, and by the sum of those of KM and
of its own. For the diagonals, D = L - K and D' of the repeated loop, have, seen from x,
``D' ~ e_y D̄`` with the direction e_y of y, and two triangles with sides in one ratio are
alike. The last three make a balanced loop of their own, and need no loop in the linkage.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import TypeVar

import numpy as np

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.dyads.dyad_geometry import (
    Dyad,
    DyadSide,
    convert_numbers,
    dyad_document,
    segments_of,
)
from balance.masses.remedies.dyads.dyad_search import AngleRelations, DyadWalk, walk
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import size_text

T = TypeVar("T")
# What a dyad is called to whose geometry a walk led.
GENERAL = "a general dyad"
# Most dyads of each kind.
MEMBERS = 2
# Walks from random geometries for each kind, if no known geometry helps.
WALKS = 12
# Known geometries of each kind that are tried, unless the remedy is named.
GEOMETRIES = 12
# Size of a dyad over that of the loop that it repeats.
SIZE = 0.5
HALF = ", half as large (a bound: larger ones take less mass)"
# Shortest link of a dyad, in characteristic lengths.
SHORTEST = 0.05


def apply_added_dyad(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by a dyad between two of its links.

    Yields:
        Dyads that balance the linkage, at most 2 of each kind (RRR, hinged to both links, and
        RRP, sliding along one); for a kind without any, one undecided result, for a search
        proves nothing. More than 12 known geometries are tried, and walks to others are made,
        if ``request.only`` names the remedy.
    """
    if why := _why_not(request):
        yield refused("added_dyad", why)
        return
    named = "added_dyad" in request.only
    walks, most = (WALKS, None) if named else (0, GEOMETRIES)
    seeds = list(dyad_seeds(request.linkage))
    kinds = [
        [seed for seed in seeds if seed.dyad.slides == slides][:most]
        for slides in (False, True)
    ]
    progress = _Progress(request, sum(map(len, kinds)) + 2 * walks)
    for slides, kind_seeds in zip((False, True), kinds, strict=True):
        members = 0
        # Walks are for linkages that no known geometry helps, and for who asks for them.
        ends = [_ends(request, slides, progress)] if walks else []
        for geometries in (progress.of(kind_seeds), *ends):
            if members:
                break
            for applied in _judge_buildable(request, geometries):
                members += applied.verdict == "feasible"
                yield applied
        if not members:
            yield _none(slides, len(kind_seeds), progress.best if walks else None)


def _judge_buildable(
    request: RemedyRequest, geometries: Iterable[DyadSeed]
) -> Iterator[AppliedRemedy]:
    """Judge geometries that have buildable masses, until enough of them are feasible."""
    members = 0
    for seed in geometries:
        space = buildable_space(request, seed)
        if space is not None:
            applied = _judge(request, seed, space)
            yield applied
            members += applied.verdict == "feasible"
            if members == MEMBERS:
                return


class _Progress:
    """Steps that are reported, and the best residual of walks."""

    def __init__(self, request: RemedyRequest, total: int) -> None:
        """Start at no step."""
        self._report, self._total, self._done = request.progress, total, 0
        self.best = np.inf

    def of(self, items: Iterable[T]) -> Iterator[T]:
        """Yield items, each of which is a step."""
        for item in items:
            yield item
            self._done += 1
            if self._report is not None:
                self._report(self._done, self._total)


def _why_not(request: RemedyRequest) -> str:
    """Say why no dyad is searched for; empty if one is."""
    if not request.linkage.planar or request.spatial:
        return "dyads are searched for in planar linkages, with the parameters of a plane"
    if request.balance == "force":
        return "a dyad adds no freedom to balance forces: see counter-masses"
    return "" if hinges_of(request.linkage) else "the linkage has no hinge that moves"


def _ends(request: RemedyRequest, slides: bool, progress: _Progress) -> Iterator[DyadSeed]:
    """Yield the geometries with related angles at which walks end."""
    progress.best = np.inf
    for ended, dyad in progress.of(walks_from_random(request, slides, WALKS)):
        progress.best = min(progress.best, ended.residual)
        if ended.related:
            yield DyadSeed(dyad, ended.numbers, GENERAL)


def walks_from_random(
    request: RemedyRequest, slides: bool, count: int
) -> Iterator[tuple[DyadWalk, Dyad]]:
    """Walk from random geometries of dyads between all pairs of links in turn.

    Args:
        slides: whether the dyads slide along their second link.

    Yields:
        Where each walk ended, and its dyad. Walks that begin at a singular geometry are left
        out.
    """
    linkage = request.linkage
    sides = list(sides_of(linkage).values())
    pairs = list(permutations(sides, 2) if slides else combinations(sides, 2))
    points = np.array([[hinge.point.real, hinge.point.imag] for hinge in hinges_of(linkage)])
    spread = 1.0 + points.std(axis=0)
    rng = np.random.default_rng(0)
    for k in range(count):
        dyad = Dyad(pairs[k % len(pairs)], slides)
        at = points.mean(axis=0) + spread * rng.standard_normal((3, 2))
        numbers = at.ravel()[: dyad.size]
        try:
            yield _walk(request, dyad, numbers), dyad
        except (LinkageError, np.linalg.LinAlgError):
            continue


def buildable_space(request: RemedyRequest, seed: DyadSeed) -> DesignSpace | None:
    """Compute the design space with a dyad, if buildable masses in it balance the linkage.

    Args:
        seed: the dyad and its geometry.

    Returns:
        The space; None if no buildable masses balance the linkage with the dyad.
    """
    try:
        linkage = _with_dyad(request, seed.dyad, seed.numbers)
        if not _is_like(linkage, request.linkage):
            return None
        space = design_space(linkage, request.motion or None)
    except LinkageError:
        return None
    return space if feasible(space).verdict == "feasible" else None


def _with_dyad(request: RemedyRequest, dyad: Dyad, numbers: Array) -> Linkage:
    """Load a linkage with a dyad, all of whose links carry parameters."""
    document, _, _ = dyad_document(request.base, dyad, numbers, request.linkage.chain.frame)
    return load(
        document,
        None,
        request.linkage.inputs,
        bodies="all",
        massless=request.massless,
        angles=request.angles,
    )


def _is_like(linkage: Linkage, given: Linkage) -> bool:
    """Whether a linkage with a dyad is planar and has the mobility of the one without."""
    return linkage.planar and linkage.mobility == given.mobility


def _walk(request: RemedyRequest, dyad: Dyad, numbers: Array) -> DyadWalk:
    """Walk in the frame of the linkage with the dyad; numbers are in that of the linkage."""
    linkage = _with_dyad(request, dyad, numbers)
    names = {joint.name for joint in request.linkage.joints}
    new = [k for k, j in enumerate(linkage.chain.joints) if linkage.joints[j].name not in names]
    if not _is_like(linkage, request.linkage) or len(new) != 3:
        raise LinkageError(f"{linkage.source}: singular with this dyad")
    given, frame = request.linkage.chain.frame, linkage.chain.frame
    turning = np.arange(len(linkage.bodies) - dyad.slides)
    relations = AngleRelations(linkage.chain, dyad, np.array(new), turning)
    ended = walk(relations, convert_numbers(dyad, numbers, given, frame))
    return replace(ended, numbers=convert_numbers(dyad, ended.numbers, frame, given))


def _judge(request: RemedyRequest, seed: DyadSeed, space: DesignSpace) -> AppliedRemedy:
    """Find the least matter that balances a linkage with a dyad, and verify it."""
    dyad, frame = seed.dyad, request.linkage.chain.frame
    document, links, joints = dyad_document(request.base, dyad, seed.numbers, frame)
    first, second = dyad.sides
    words = f"{dyad.kind} between {first.name} and {second.name}: {seed.words}{seed.bound}"
    return judge_variant(
        request,
        Variant(
            "added_dyad",
            words,
            document,
            (*request.links, *links),
            new_links=links,
            new_joints=joints,
            details={"kind": dyad.kind, "geometry": seed.words},
        ),
        space,
    )


def _none(slides: bool, tried: int, best: float | None) -> AppliedRemedy:
    """Return the result of a search that found no dyad of a kind; None is for no walks."""
    kind = "RRP" if slides else "RRR"
    reason = (
        f"no member found: {tried} known geometries have no buildable masses; --only added_dyad"
        f" tries all that are known, and makes {WALKS} walks to others"
    )
    if best is not None:
        reason = (
            f"no member found: {tried} known geometries, and {WALKS} walks to related angles "
            f"(best residual {size_text(best)}), have no buildable masses; others may"
        )
    return AppliedRemedy("added_dyad", f"{kind} between any two links", "undecided", reason)


@dataclass(frozen=True)
class _Hinge:
    """A hinge of a planar linkage.

    Attributes:
        links: the two rigid bodies; -1 is the ground.
        point: in the plane of the chain, chain units, as a complex number.
    """

    links: tuple[int, int]
    point: complex

    def other(self, link: int) -> int:
        """Return the rigid body on the other side."""
        return self.links[1] if self.links[0] == link else self.links[0]


@dataclass(frozen=True, eq=False)
class DyadSeed:
    """A geometry of a dyad to begin with.

    Attributes:
        dyad: the dyad.
        numbers: its numbers; see `balance.masses.remedies.dyads.dyad_geometry`.
        words: what it is.
        bound: the size that is set, in words; empty where the linkage sets it.
    """

    dyad: Dyad
    numbers: Array
    words: str
    bound: str = ""

    def __repr__(self) -> str:
        """One line: what it is, and the links."""
        return f"DyadSeed: {self.words}, {self.dyad!r}"


def hinges_of(linkage: Linkage) -> list[_Hinge]:
    """List the hinges of a planar linkage."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    frame = linkage.chain.frame
    hinges = []
    for j, joint in enumerate(linkage.joints):
        if joint.kind != "revolute" or joint.name in linkage.idle:
            continue
        x, y = (frame.R[:2] @ (joint.point - frame.origin)) / frame.length
        links = welded.get(joint.parent, joint.parent), welded.get(j, j)
        hinges.append(_Hinge(links, complex(x, y)))
    return hinges


def sides_of(linkage: Linkage) -> dict[int, DyadSide]:
    """Name a link of each rigid body to which a dyad can be attached.

    Returns:
        By number of the rigid body; -1 is the ground. Links of bodies come first.
    """
    bodies = {body.name for body in linkage.bodies}
    order = sorted(linkage.places, key=lambda name: name not in bodies)
    sides: dict[int, DyadSide] = {}
    for name in order:
        place = linkage.places[name]
        sides.setdefault(place.link, DyadSide(name, place.link, place.pose))
    return sides


def dyad_seeds(linkage: Linkage) -> Iterator[DyadSeed]:
    """Yield known geometries of dyads, those that repeat a loop first."""
    hinges, sides = hinges_of(linkage), sides_of(linkage)
    for make in (_repeats, _loops_of_their_own):
        for seed in make(hinges, sides):
            if segments_of(seed.dyad, seed.numbers).min() >= SHORTEST:
                yield seed


def _repeats(hinges: list[_Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
    """Yield dyads that repeat a loop of four hinges, reflected; those on the ground first."""
    corners = [corner for corner in permutations(hinges, 4) if _is_loop(*corner)]
    corners.sort(key=lambda corner: GROUND not in corner[0].links)
    for centre, first, middle, last in corners:
        x, y = first.links[_common(centre, first)], last.links[_common(centre, last)]
        if x > y or x not in sides or y not in sides:
            continue
        J = centre.point
        K, L, M = (J + SIZE * (hinge.point - J).conjugate() for hinge in (first, last, middle))
        dyad = Dyad((sides[x], sides[y]), False)
        yield DyadSeed(dyad, _numbers(L, M, K), "the loop repeated, reflected", HALF)
        yield DyadSeed(dyad, _numbers(L, K + L - M, K), "its parallelogram, reflected", HALF)


def _is_loop(centre: _Hinge, first: _Hinge, middle: _Hinge, last: _Hinge) -> bool:
    """Whether four hinges make a loop of four rigid bodies, in this order."""
    pairs = ((centre, first), (first, middle), (middle, last), (last, centre))
    shared = [set(hinge.links) & set(other.links) for hinge, other in pairs]
    return all(len(links) == 1 for links in shared) and len(set().union(*shared)) == 4


def _common(centre: _Hinge, other: _Hinge) -> int:
    """Return which link of a hinge is also one of the centre: 0 or 1."""
    return int(other.links[1] in centre.links)


def _loops_of_their_own(hinges: list[_Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
    """Yield kites, antiparallelograms, and crank-sliders of equal lengths."""
    for centre, first, last in permutations(hinges, 3):
        x = first.links[_common(centre, first)]
        y = last.links[_common(centre, last)]
        if {x, y} != set(centre.links) or x == y or x not in sides or y not in sides:
            continue
        J, K, L = centre.point, first.point, last.point
        if abs(K - L) == 0.0 or abs(K - J) == 0.0 or abs(L - J) == 0.0:
            continue
        along = (L - K) / abs(L - K)
        both = Dyad((sides[x], sides[y]), False)
        kite = K + along * ((J - K) / along).conjugate()
        if x < y:
            yield DyadSeed(both, _numbers(K, kite, L), "a kite")
            yield DyadSeed(both, _numbers(K, K + L - kite, L), "an antiparallelogram")
        line = (L - J) / abs(L - J)
        far = J + 2.0 * line * ((K - J) * line.conjugate()).real
        slide = np.array([K.real, K.imag, far.real, far.imag, np.angle(line)])
        slider = Dyad((sides[x], sides[y]), True)
        yield DyadSeed(slider, slide, "a crank-slider of equal lengths")


def _numbers(*points: complex) -> Array:
    """Write points as numbers of a dyad."""
    return np.array([[point.real, point.imag] for point in points]).ravel()
