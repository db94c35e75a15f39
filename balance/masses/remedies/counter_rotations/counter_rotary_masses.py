"""Counter-rotary counter-masses: counterweights that turn against their links."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.counterweights import counterweights
from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    FewestRotors,
    RotorSet,
    fewest_rotors,
)
from balance.masses.remedies.counter_rotations.lightest_places import lightest_places
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
from kinematics.numerics.linalg.ties import round_decimals
from kinematics.wording import count_noun, number_text

Array = NDArray[np.float64]

# Decimals of places, in characteristic lengths of the linkage.
DECIMALS = 7


def apply_counter_rotary_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by the fewest counterweights that turn against their links.

    The counterweight of the link after a joint turns about an axis parallel to that of the
    joint: -N times for one turn of the joint, seen from the link before the joint, N being
    ``request.gear``. On its own link it therefore turns -(N + 1) times; with N = 1 it turns
    against the link at the link's own rate. Its matter is within a ball of the radius of
    rotors. Each lies where the least mass is added; see
    `balance.masses.remedies.counter_rotations.lightest_places`.

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
    for rotor_set in fewest.sets[:MOST_SETS]:
        yield judge(request, _variant(request, fewest, rotor_set))


def _variant(request: RemedyRequest, fewest: FewestRotors, rotor_set: RotorSet) -> Variant:
    """Build turning counterweights where they are lightest, or where forces want them."""
    writer, linkage = RotorWriter(request), request.linkage
    bodies = {body.link: body for body in linkage.bodies}
    lightest = lightest_places(request, rotor_set.joints)
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
    matter = counterweights(force, request.links, request.regions, relax=False)
    return {weight.link: weight.com for weight in matter.weights}
