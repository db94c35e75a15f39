"""Separate counter-rotations: rotors of their own, geared to a joint."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.counter_rotations.counter_rotors import has_fixed_axis
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    FewestRotors,
    RotorSet,
    fewest_rotors,
)
from balance.masses.remedies.counter_rotations.rotor_elements import RotorParts, RotorWriter
from balance.masses.remedies.counter_rotations.rotor_sets import check_rotor_certificate
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant, append_elements
from kinematics.model.linkage import GROUND
from kinematics.wording import count_noun

# Most sets of joints that are built: those with the least sum of momenta.
MOST_SETS = 3


def apply_separate_rotors(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by the fewest rotors of their own.

    A rotor turns -N times for one turn of its joint, N being ``request.gear``. It stands on the
    ground in line with the joint if the axis of that keeps its direction, and otherwise on the
    link before the joint. The best set is also built with every rotor on the link before its
    joint. Its matter is within a ball of the radius of rotors, where the least mass is a
    ring at the rim, ``J / N = m ρ²``; other matter may be added to the links of the request.

    Yields:
        A result for each of up to three smallest sets of joints, least momenta first.
    """
    if why := unusable(request):
        yield refused("separate_rotors", why)
        return
    fewest = fewest_rotors(request.space, request.gear, request.progress)
    if fewest.verdict != "feasible" or not fewest.count:
        yield answer_without_rotors("separate_rotors", fewest)
        return
    for k, rotor_set in enumerate(fewest.sets[:MOST_SETS]):
        grounded = [name for name in rotor_set.joints if _may_stand_on_ground(request, name)]
        yield _built(request, fewest, rotor_set, grounded)
        carried = [name for name in grounded if _is_carried(request, name)]
        if k == 0 and carried:
            on_ground = [name for name in grounded if name not in carried]
            yield _built(request, fewest, rotor_set, on_ground)


def unusable(request: RemedyRequest) -> str:
    """Say why counter-rotations are no remedy for a request; empty if they are."""
    if request.balance == "force":
        return "counter-rotations balance moments, and force balance asks for none"
    return ""


def answer_without_rotors(remedy: str, fewest: FewestRotors) -> AppliedRemedy:
    """Return the result where no set of counter-rotations is to be built.

    Args:
        remedy: name of the remedy.
        fewest: the fewest counter-rotations, none or not feasible.
    """
    if fewest.verdict == "feasible":
        return refused(remedy, "masses of the links balance it: no counter-rotation is needed")
    details, proof = rotor_details(fewest), None
    if fewest.verdict == "infeasible":
        certificate = fewest.certificates[0]
        check = check_rotor_certificate(fewest.conditions, certificate)
        proof = {"matrices": certificate.matrices.tolist(), "check": check._asdict()}
    return AppliedRemedy(
        remedy, "counter-rotations", fewest.verdict, fewest.words, proof, details=details
    )


def rotor_variant(
    request: RemedyRequest,
    remedy: str,
    words: str,
    rotors: Sequence[RotorParts],
    details: Mapping[str, object],
) -> Variant:
    """Make the variant of a linkage with some rotors.

    Args:
        remedy: name of the remedy.
        words: what is built in where.
        details: plain data about it.
    """
    elements = [element for rotor in rotors for element in rotor.elements]
    links = tuple(rotor.link for rotor in rotors)
    return Variant(
        remedy,
        words,
        append_elements(request.base, elements),
        (*request.links, *links),
        regions={rotor.link: rotor.region for rotor in rotors},
        new_links=links,
        new_joints=tuple(rotor.joint for rotor in rotors),
        details=details,
    )


def rotor_details(fewest: FewestRotors, rotor_set: RotorSet | None = None) -> dict[str, object]:
    """Return plain data about the fewest counter-rotations.

    Args:
        fewest: the fewest counter-rotations.
        rotor_set: one set of them, for its momenta.
    """
    details: dict[str, object] = {
        "candidates": list(fewest.candidates),
        "fewest": fewest.count,
        "sets": [list(each.joints) for each in fewest.sets],
    }
    if rotor_set is not None:
        details["momenta"] = dict(zip(rotor_set.joints, rotor_set.momenta, strict=True))
        details["momenta_ratio"] = rotor_set.ratio
    return details


def _may_stand_on_ground(request: RemedyRequest, name: str) -> bool:
    """Return whether the axis of a joint keeps its direction."""
    return has_fixed_axis(request.linkage, int(request.linkage.positions_of([name])[0]))


def _is_carried(request: RemedyRequest, name: str) -> bool:
    """Return whether the link before a joint moves."""
    linkage = request.linkage
    return linkage.joints[linkage.positions_of([name])[0]].parent != GROUND


def _built(
    request: RemedyRequest, fewest: FewestRotors, rotor_set: RotorSet, grounded: Sequence[str]
) -> AppliedRemedy:
    """Judge the linkage with rotors on one set of joints, some of them on the ground."""
    writer = RotorWriter(request)
    rotors = [
        writer.on_base(name, -request.gear)
        if name in grounded
        else writer.on_carrier(name, -request.gear)
        for name in rotor_set.joints
    ]
    moving = [name for name in rotor_set.joints if name not in grounded]
    where = [
        f"{', '.join(names)} ({place})"
        for names, place in ((grounded, "on the ground"), (moving, "on the link before"))
        if names
    ]
    words = f"{count_noun(len(rotors), 'rotor')} against {' and '.join(where)}"
    details = rotor_details(fewest, rotor_set)
    return judge_variant(
        request, rotor_variant(request, "separate_rotors", words, rotors, details)
    )
