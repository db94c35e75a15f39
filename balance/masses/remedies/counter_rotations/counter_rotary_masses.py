"""Counter-rotary counter-masses: counterweights that turn against their links."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.counterweights import counterweights
from balance.masses.remedies.applied import AppliedRemedy, refused
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
from balance.masses.remedies.judge import judge
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.space.spaces.compute_space import design_space
from kinematics.wording import count_noun

Array = NDArray[np.float64]

# Parts of the lever that force balance gives a counterweight, at which it may turn. A nearer
# one is heavier, and its inertia about the joint is smaller.
LEVERS = (1.0, 0.5, 0.25, 0.125)


def apply_counter_rotary_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by the fewest counterweights that turn against their links.

    The counterweight of the link after a joint lies where force balance alone puts it, and
    turns there about an axis parallel to that of the joint: -N times for one turn of the
    joint, seen from the link before the joint, N being ``request.gear``. On its own link it
    therefore turns -(N + 1) times; with N = 1 it turns against the link at the link's own
    rate. Its matter is within a ball of the radius of rotors about that place. Where this
    radius is too small for the lever, a half, a quarter or an eighth of the lever is lighter.

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
    places = _counterweight_places(request)
    for rotor_set in fewest.sets[:MOST_SETS]:
        yield _built(request, fewest, rotor_set, places)


def _counterweight_places(request: RemedyRequest) -> dict[str, Array]:
    """Find where force balance puts the counterweight of each link, in its frame (3,)."""
    force = design_space(request.linkage, request.motion or None, "force")
    matter = counterweights(force, request.links, request.regions, relax=False)
    return {weight.link: weight.com for weight in matter.weights}


def _built(
    request: RemedyRequest, fewest: FewestRotors, rotor_set: RotorSet, places: dict[str, Array]
) -> AppliedRemedy:
    """Judge turning counterweights on one set of joints, with the lever of the least mass."""
    best = judge(request, _variant(request, fewest, rotor_set, places, LEVERS[0]))
    for lever in LEVERS[1:]:
        result = judge(request, _variant(request, fewest, rotor_set, places, lever))
        if result.added_mass is None:
            continue
        if best.added_mass is not None and result.added_mass >= best.added_mass:
            break
        best = result
    return best


def _variant(
    request: RemedyRequest, fewest: FewestRotors, rotor_set: RotorSet, places: dict[str, Array],
    lever: float,
) -> Variant:  # fmt: skip
    """Build turning counterweights at a part of the lever that force balance gives them."""
    writer, linkage = RotorWriter(request), request.linkage
    bodies = {body.link: b for b, body in enumerate(linkage.bodies)}
    links, rotors = [], []
    for name, j in zip(
        rotor_set.joints, linkage.positions_of(rotor_set.joints).tolist(), strict=True
    ):
        body = linkage.bodies[bodies[j]]
        axis = np.linalg.solve(body.frame, [*linkage.joints[j].point, 1.0])[:3]
        place = axis + lever * (places.get(body.name, axis) - axis)
        rotors.append(writer.on_child(name, place, -request.gear - 1.0))
        links.append(body.name)
    number = count_noun(len(rotors), "turning counterweight")
    words = f"{number} on {', '.join(links)}, against {', '.join(rotor_set.joints)}"
    if lever < 1.0:
        words = f"{words}, at {lever:g} of the lever of force balance"
    details = {**rotor_details(fewest, rotor_set), "lever": lever}
    return rotor_variant(request, "counter_rotary_masses", words, rotors, details)
