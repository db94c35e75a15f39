"""A pantograph on a pair of links: force balance by one counterweight behind the base joint.

A pair of links is hinged to the base at O and to each other at A. The first is made longer
beyond O, to ``A' = O - k (A - O)``. From there a counter-arm keeps parallel to the second link,
by a bar that is parallel to the first: the hinges A, A', Q', Q make a parallelogram. With the
direction ``e`` of the second link, a mass m at ``A' - c e`` has the momentum

    -m (k d(A - O)/dt + c de/dt)

so that one mass takes what both links leave, where a counterweight on the second link would be
a load for the first. It moves against the common centre of mass of the pair, k times as far.

Source:
    V. H. Arakelian, M. R. Smith, Journal of Mechanical Design 127(2), 2005: pantographs whose
    counterweight moves against the common centre of mass.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.regions import ball_region
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.balancers.on_base import ForceBalanced
from balance.masses.remedies.dyads.dyad_geometry import Dyad, DyadSide, dyad_document
from balance.masses.remedies.dyads.known_dyads import hinges_of, sides_of
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.least_matter import rim_of
from balance.masses.remedies.matter_on_links import with_moment_left
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import GROUND, Linkage
from kinematics.wording import number_text

KEY = "pantograph"
# Size k of the pantograph over the pair: regions of counterweights are as large by default.
SIZE = 0.5
# Most pairs that are tried, those of the longest second links.
PAIRS = 2


class _Pair(NamedTuple):
    """Two links, hinged to the base and to each other.

    Attributes:
        sides: the links.
        base: O, complex, chain units.
        elbow: A.
        length: of the second link from A to its furthest hinge or centre of mass.
    """

    sides: tuple[DyadSide, DyadSide]
    base: complex
    elbow: complex
    length: float


def apply_pantograph(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance the force of a planar linkage by a pantograph on a pair of its links.

    The counter-arm is half as long as the second link, and the first is made longer by half:
    a larger pantograph needs less mass. Its bars have no mass besides the counterweights.

    Yields:
        The pantograph with the least mass: balanced if the force alone is asked for, else
        partial, with the moment that is left.
    """
    pairs = _pairs(request.linkage) if request.linkage.planar else []
    if not pairs:
        yield refused(KEY, "no pair of links is hinged to the base and to each other")
        return
    # Of what is known of the request, only lengths, links and inertias are read.
    asked = request.changed(balance="force")
    tried = [_judged(asked, pair) for pair in pairs]
    balanced = [applied for applied in tried if applied.added_mass is not None]
    best = min(balanced, key=lambda applied: applied.added_mass or 0.0, default=tried[0])
    if best.urdf is None or request.balance == "force":
        yield best
        return
    document = Document(request.base.name, best.urdf)
    linkage = load(document, None, request.linkage.inputs, angles=request.angles)
    blank = replace(best, verdict="undecided", reason="", urdf=None)
    try:
        made = ForceBalanced(document, linkage, best.added_mass or 0.0, rim_of(best.reason))
        yield with_moment_left(request, blank, made)
    except LinkageError as error:
        yield refused(KEY, str(error), best.words)


def _pairs(linkage: Linkage) -> list[_Pair]:
    """List pairs of links, the longest second links first."""
    hinges, sides = hinges_of(linkage), sides_of(linkage)
    frame, pairs = linkage.chain.frame, []
    centres = {
        body.link: frame.R[:2] @ (body.inertia[1:4] / body.inertia[0] - frame.origin)
        for body in linkage.bodies
        if body.inertia[0] > 0.0
    }
    for foot in hinges:
        if GROUND not in foot.links:
            continue
        upper = foot.other(GROUND)
        for elbow in hinges:
            if elbow is foot or upper not in elbow.links or GROUND in elbow.links:
                continue
            lower = elbow.other(upper)
            ends = [hinge.point for hinge in hinges if lower in hinge.links]
            if lower in centres:
                ends.append(complex(*centres[lower].tolist()) / frame.length)
            length = max(abs(end - elbow.point) for end in ends)
            if min(length, abs(elbow.point - foot.point)) > 0.0:
                pair = sides[upper], sides[lower]
                pairs.append(_Pair(pair, foot.point, elbow.point, length))
    return sorted(pairs, key=lambda pair: -round(pair.length, 9))[:PAIRS]


def _judged(request: RemedyRequest, pair: _Pair) -> AppliedRemedy:
    """Find the least matter with a pantograph on a pair, against the force, and verify it.

    The parallelogram is a rectangle at the reference pose, as far from flat as can be.
    """
    arm = pair.elbow - pair.base
    hinge = pair.base - SIZE * arm
    across = 1j * arm / abs(arm) * SIZE * pair.length
    points = hinge, hinge + across, pair.elbow + across
    numbers = np.array([[point.real, point.imag] for point in points]).ravel()
    dyad, frame = Dyad(pair.sides, False), request.linkage.chain.frame
    document, links, joints = dyad_document(request.base, dyad, numbers, frame, KEY)
    first, second = (side.name for side in pair.sides)
    reach, lever = (x * frame.length for x in (SIZE * pair.length, SIZE * abs(arm)))
    words = (
        f"a counter-arm of {number_text(reach, '.3g')} m that keeps parallel to {second}, "
        f"{number_text(lever, '.3g')} m behind the base joint of {first} (bounds: a longer one "
        "takes less mass)"
    )
    variant = Variant(
        KEY,
        words,
        document,
        (*request.links, *links),
        regions={links[0]: ball_region(np.zeros(3), reach)},
        new_links=links,
        new_joints=joints,
        details={"pair": [first, second], "size": SIZE},
    )
    return judge_variant(request, variant)
