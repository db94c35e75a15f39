"""Transmissions: counter-rotors on the ground against the rotations of links.

The rotation of a link of a planar linkage is brought to the ground along the links that carry
it, by wheels or by parallelograms, and a rotor on the ground turns against it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.counter_rotations.counter_rotors import link_rotor_conditions
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    FewestRotors,
    RotorSet,
    fewest_of,
)
from balance.masses.remedies.counter_rotations.separate_rotors import (
    answer_without_rotors,
    rotor_details,
    unusable,
)
from balance.masses.remedies.counter_rotations.transmission_elements import (
    Transmission,
    TransmissionWriter,
    chain_to_ground,
    mass_per_length,
)
from balance.masses.remedies.judge import judge
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant, append_elements
from kinematics.wording import count_noun


def apply_planetary_transmission(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by rotors on the ground, driven by wheels along its links.

    A wheel coaxial with each joint on the way from a link to the ground turns with that link,
    by belts or gears along the links between; the rotor turns -N times for one turn of the
    link, N being ``request.gear``. Wheels have masses of their own; see
    `balance.masses.remedies.counter_rotations.transmission_elements`.

    Yields:
        A result for the smallest set of links with the least momenta and, if no link of it
        needs a transmission, one for the best set of which one does.
    """
    yield from _apply(request, "planetary_transmission", TransmissionWriter.wheels, "wheels")


def apply_parallelogram_transmission(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage by rotors on the ground, driven by parallelograms.

    An idler coaxial with each joint on the way from a link to the ground keeps parallel to
    that link by a bar along each link between, which closes a loop; the rotor turns -N times
    for one turn of the idler on the ground, N being ``request.gear``. Idlers and bars have
    masses of their own; see `balance.masses.remedies.counter_rotations.transmission_elements`.

    Yields:
        As `apply_planetary_transmission`.
    """
    write = TransmissionWriter.parallelograms
    yield from _apply(request, "parallelogram_transmission", write, "parallelograms")


def _apply(
    request: RemedyRequest, remedy: str,
    write: Callable[[TransmissionWriter, Transmission, tuple[str, ...]], None], by: str,
) -> Iterator[AppliedRemedy]:  # fmt: skip
    """Judge the linkage with rotors on the ground against one or two sets of links."""
    if why := unusable(request):
        yield refused(remedy, why)
        return
    if not request.space.planar:
        yield refused(remedy, "axes that are not parallel: it transmits rotations in a plane")
        return
    chains = {body: chain_to_ground(request, body) for body in request.space.bodies}
    links = [body for body, chain in chains.items() if chain]
    fewest = fewest_of(link_rotor_conditions(request.space, links), request.progress)
    if fewest.verdict != "feasible" or not fewest.count:
        yield answer_without_rotors(remedy, fewest)
        return
    sets = [fewest.sets[0]]
    if all(len(chains[name]) == 1 for name in sets[0].joints):
        longer = (x for x in fewest.sets if any(len(chains[name]) > 1 for name in x.joints))
        sets += [rotor_set for rotor_set in (next(longer, None),) if rotor_set is not None]
    for rotor_set in sets:
        out, writer = Transmission(), TransmissionWriter(request)
        for name in rotor_set.joints:
            write(writer, out, chains[name])
        variant = _variant(request, remedy, out, fewest, rotor_set)
        far = [name for name in rotor_set.joints if len(chains[name]) > 1]
        driven = f", driven by {by} from {', '.join(far)}" if far else ", without transmission"
        number = count_noun(len(rotor_set.joints), "rotor")
        words = f"{number} on the ground against {', '.join(rotor_set.joints)}{driven}"
        yield judge(request, variant(words))


def _variant(
    request: RemedyRequest,
    remedy: str,
    out: Transmission,
    fewest: FewestRotors,
    rotor_set: RotorSet,
) -> Callable[[str], Variant]:
    """Return a function that makes the variant from its words."""
    details = {**rotor_details(fewest, rotor_set), "mass_per_length": mass_per_length(request)}
    return lambda words: Variant(
        remedy, words, append_elements(request.base, out.elements),
        (*request.links, *out.free), regions=out.free, massless=tuple(out.massless),
        new_links=tuple(out.links), new_joints=tuple(out.joints), details=details,
    )  # fmt: skip
