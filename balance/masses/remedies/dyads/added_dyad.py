"""A dyad added between two links of a planar linkage, with which it can be balanced.

Known geometries are tried first: a loop of four hinges repeated, reflected, and loops that are
balanced by themselves. Then walks from random geometries search for others, see
`balance.masses.remedies.dyads.dyad_search`. Whether masses can be built is decided for each
geometry by `balance.masses.feasible`; those that have some are judged as every remedy.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import combinations, permutations
from math import inf
from typing import NamedTuple, TypeVar

import numpy as np

from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.dyads.dyad_geometry import Dyad, convert_numbers, dyad_document
from balance.masses.remedies.dyads.dyad_search import AngleRelations, DyadWalk, walk
from balance.masses.remedies.dyads.dyad_sizes import (
    AS_POINTS,
    best_size,
    size_words,
    turn_words,
)
from balance.masses.remedies.dyads.known_dyads import (
    GEOMETRIES,
    DyadSeed,
    hinges_of,
    sides_of,
)
from balance.masses.remedies.dyads.with_dyad import (
    DYAD_LINKS,
    dyad_space,
    is_like,
    known_seeds,
    load_with_dyad,
    why_no_dyad,
)
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.least_matter import least_matter_or_none
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array
from kinematics.wording import size_text

T = TypeVar("T")
KEY = "added_dyad"
# What a dyad is called to whose geometry a walk led.
GENERAL = "a general dyad"
# Most dyads of each kind.
MEMBERS = 2
# Walks from random geometries for each kind, if no known geometry helps.
WALKS = 12


def apply_added_dyad(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by a dyad between two of its links.

    Yields:
        Dyads that balance the linkage, at most 2 of each kind (RRR, hinged to both links, and
        RRP, sliding along one); for a kind without any, one undecided result, for a search
        proves nothing. If ``request.only`` names the remedy, more than 12 known geometries are
        tried, their sizes and directions are sought, and walks to others are made.
    """
    if why := why_no_dyad(request):
        yield refused(KEY, why)
        return
    named = KEY in request.only
    walks, most = (WALKS, None) if named else (0, GEOMETRIES)
    seeds = known_seeds(request)
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
            applied = _judge(request, *_best(request, seed, space))
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
    space = dyad_space(request, seed)
    return space if space is not None and feasible(space).verdict == "feasible" else None


def _walk(request: RemedyRequest, dyad: Dyad, numbers: Array) -> DyadWalk:
    """Walk in the frame of the linkage with the dyad; numbers are in that of the linkage."""
    linkage = load_with_dyad(request, dyad, numbers)
    names = {joint.name for joint in request.linkage.joints}
    new = [k for k, j in enumerate(linkage.chain.joints) if linkage.joints[j].name not in names]
    if not is_like(linkage, request.linkage) or len(new) != 3:
        raise LinkageError(f"{linkage.source}: singular with this dyad")
    given, frame = request.linkage.chain.frame, linkage.chain.frame
    turning = np.arange(len(linkage.bodies) - dyad.slides)
    relations = AngleRelations(linkage.chain, dyad, np.array(new), turning)
    ended = walk(relations, convert_numbers(dyad, numbers, given, frame))
    return replace(ended, numbers=convert_numbers(dyad, ended.numbers, frame, given))


class _Choice(NamedTuple):
    """A dyad, the design space with it, and its size and direction in words."""

    seed: DyadSeed
    space: DesignSpace
    words: str


def _best(request: RemedyRequest, seed: DyadSeed, space: DesignSpace) -> _Choice:
    """Seek the size and the direction of a dyad, if the remedy is named and they are free.

    They are those for point masses, which take a hundredth of the time.
    """

    def mass_of(seed: DyadSeed) -> float:
        space = dyad_space(request, seed)
        if space is None:
            return inf
        links = (*request.links, *space.bodies[-DYAD_LINKS:])
        matter = least_matter_or_none(recompute_spatial(space), links, request.regions)
        return inf if matter is None else matter.added_mass

    if KEY in request.only and seed.size is not None and (sized := best_size(seed, mass_of)):
        sized_space = dyad_space(request, sized.seed)
        assert sized_space is not None, "it has a mass"
        words = size_words(sized.seed, sized.beyond + AS_POINTS * (request.density is not None))
        return _Choice(sized.seed, sized_space, f"{words}, {turn_words(sized.turn)}")
    return _Choice(seed, space, size_words(seed))


def _judge(
    request: RemedyRequest, seed: DyadSeed, space: DesignSpace, size: str
) -> AppliedRemedy:
    """Find the least matter that balances a linkage with a dyad, and verify it.

    Args:
        size: its size and direction in words.
    """
    dyad, frame = seed.dyad, request.linkage.chain.frame
    document, links, joints = dyad_document(request.base, dyad, seed.numbers, frame)
    first, second = dyad.sides
    words = f"{dyad.kind} between {first.name} and {second.name}: {size}"
    return judge_variant(
        request,
        Variant(
            KEY,
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
    return AppliedRemedy(KEY, f"{kind} between any two links", "undecided", reason)
