"""Remedy: balance shafts against the first and second harmonic, at constant speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from balance.masses.designs.density import STEEL
from balance.masses.remedies.applied import AppliedRemedy, refused, with_cost
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.shafts.crank_turn import revolve, turn_of_crank
from balance.masses.remedies.shafts.harmonic_shafts import (
    Harmonics,
    Shaft,
    harmonics_of,
    shafts_against,
)
from balance.masses.remedies.variant import append_elements, free_name, names_taken
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.trajectory import Trajectory
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.loading.model_gallery import load
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import round_decimals
from kinematics.wording import count_noun, number_text, size_text

KEY = "balance_shafts"
# Harmonics that shafts are built against, and those that are listed.
BUILT, LISTED = (1, 2), 4
# Furthest place of a shaft from the axis of the crank, in characteristic lengths.
FURTHEST = 2.0
# Digits of places, of the characteristic length: fewer would leave a moment.
PLACE_DIGITS = 12


def apply_balance_shafts(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Cancel harmonics of the shaking at constant speed by shafts geared to the crank.

    For each harmonic two shafts turn against each other at its multiple of the speed of the
    crank, whose unbalances take its force, and whose places take its moment, see
    `balance.masses.remedies.shafts.harmonic_shafts`. They hold for a crank at constant speed,
    and for no other motion. The unbalance of each is a ball of steel at the radius of rotors.

    Yields:
        A result with shafts against the first harmonic, and one against the first two; one if
        the linkage has one of them. The residual is the root mean square of the force over a
        turn, over that of the file.

    Source:
        F. W. Lanchester, 1911; E. N. Stevensen, Journal of Engineering for Industry 95(2),
        1973, for forces and moments of any linkage.
    """
    turn = _turn_of(request)
    if isinstance(turn, str):
        yield refused(KEY, turn)
        return
    forces = turn.harmonics.forces
    size = float(np.abs(turn.force).max())
    there = [k for k in BUILT if forces[k - 1] > SHAKING_RELATIVE * max(size, turn.inertia)]
    if not there:
        yield refused(KEY, "no force of the first two harmonics is left at constant speed")
    for count in range(1, len(there) + 1):
        yield _built(request, turn, there[:count])


class _Turn(NamedTuple):
    """One turn of the crank at its unit rate.

    Attributes:
        crank: its name.
        near: its axis in the plane, complex, and along the normal, metres.
        force: of the base on the linkage (N,), complex, N.
        inertia: sum of the bodies' masses times accelerations of the size of 1 m/s², N.
        harmonics: of the shaking of the file, up to `LISTED`.
    """

    crank: str
    near: tuple[complex, float]
    force: Array
    inertia: float
    harmonics: Harmonics


def _turn_of(request: RemedyRequest) -> _Turn | str:
    """Turn the crank once, or say why that is no remedy."""
    linkage = request.linkage
    if not linkage.planar:
        return "a spatial linkage: shafts are placed against forces in a plane"
    turn = turn_of_crank(request)
    if isinstance(turn, str):
        return turn
    crank = turn.joint
    force, moment, u = _shaking(linkage, crank.name, turn.trajectory)
    R = linkage.chain.frame.R
    x, y, z = (R @ crank.point).tolist()
    harmonics = harmonics_of(u, force, moment, np.arange(1, LISTED + 1))
    weight = request.given_mass * request.space.length
    return _Turn(crank.name, (complex(x, y), z), force, weight, harmonics)


def _shaking(linkage: Linkage, crank: str, turn: Trajectory) -> tuple[Array, Array, Array]:
    """Compute force (complex), moment and crank angle over one turn at the unit rate (N,).

    The wrench is that of Pinocchio, which knows nothing of harmonics.
    """
    wrench = PinocchioModel(linkage, mass_parameters(linkage)).reactions(turn)[:-1]
    R = linkage.chain.frame.R
    force = wrench[:, 3:] @ (R[0] + 1j * R[1])
    return force, wrench[:, :3] @ R[2], turn.u[:-1, linkage.inputs.index(crank)]


def _built(request: RemedyRequest, turn: _Turn, orders: Sequence[int]) -> AppliedRemedy:
    """Write the shafts against some orders, and measure what is left."""
    at = np.array(orders) - 1
    harmonics = Harmonics(*(np.asarray(part)[at] for part in turn.harmonics))
    furthest = FURTHEST * request.space.length
    shafts = shafts_against(harmonics, turn.near[0], furthest)
    document, links, joints = _document(request, turn, shafts)
    blank = AppliedRemedy(
        KEY, "", "undecided", "", new_links=tuple(links), new_joints=tuple(joints)
    )
    linkage = load(document, None, request.linkage.inputs, angles=request.angles)
    whole = revolve(request, linkage, turn.crank)
    force, moment, u = _shaking(linkage, turn.crank, whole)
    after = harmonics_of(u, force, moment, np.arange(1, LISTED + 1))
    residual = float(np.linalg.norm(force) / np.linalg.norm(turn.force))
    if residual <= SHAKING_RELATIVE:  # round-off
        residual = 0.0
    harmonic_share = float((after.forces[at] / turn.harmonics.forces[at]).max())
    moments = after.moments[at] <= SHAKING_RELATIVE * (
        turn.harmonics.moments[at] + turn.harmonics.forces[at] * request.space.length
    )
    number = "first harmonic" if list(orders) == [1] else "first two harmonics"
    number = "second harmonic" if list(orders) == [2] else number
    words = (
        f"{count_noun(len(shafts), 'shaft')} geared to {turn.crank}, against the {number} of "
        "the shaking at constant speed"
    )
    details = _details(request, turn, shafts, links, after) | {
        "orders": list(orders),
        "moment_taken": bool(moments.all()),
    }
    if not harmonic_share <= SHAKING_RELATIVE:
        reason = f"{size_text(harmonic_share)} of these harmonics is left in its file"
        return replace(blank, words=words, reason=reason, details=details)
    asked = request.balance == "dynamic"
    taken = "force and moment" if asked and moments.all() else "force"
    reason = (
        f"at constant speed they take the {taken} of the {number}, and leave "
        f"{number_text(residual, '.3g')} of the force in the file (root mean square); their "
        "places are within two characteristic lengths of the crank"
    )
    if asked and not moments.all():
        reason += ", where they cannot take the moment"
    done = replace(
        blank,
        verdict="partial",
        words=words,
        reason=reason,
        residual=residual,
        urdf=document.data,
        details=details,
    )
    added = sum(float(body.inertia[0]) for body in linkage.bodies) - request.given_mass
    costed = with_cost(request, done, added, linkage, request.motion)
    assert costed.built is not None, "its cost was added up"
    # At constant speed, for which they are, gears of shafts carry no torque.
    return replace(costed, built=costed.built._replace(gear_mass=0.0))


def _details(
    request: RemedyRequest,
    turn: _Turn,
    shafts: Sequence[Shaft],
    links: Sequence[str],
    after: Harmonics,
) -> dict[str, Any]:
    """List the shafts, and the harmonics with and without them."""
    least = SHAKING_RELATIVE * float(turn.harmonics.forces.max())
    return {
        "crank": turn.crank,
        "shafts": [
            {
                "link": link,
                "ratio": shaft.ratio,
                "unbalance": abs(shaft.unbalance),
                "place": _place(request, turn, shaft.place).tolist(),
            }
            for link, shaft in zip(links, shafts, strict=True)
        ],
        "harmonics": {
            "orders": list(range(1, LISTED + 1)),
            "unit": "N s^2 and N m s^2: times the square of the speed in rad/s",
            "force_before": _sizes(turn.harmonics.forces, least),
            "force_after": _sizes(after.forces, least),
            "moment_before": _sizes(turn.harmonics.moments, least * request.space.length),
            "moment_after": _sizes(after.moments, least * request.space.length),
        },
    }


def _sizes(sizes: Array, least: float) -> list[float]:
    """List sizes of harmonics; 0 for those that round-off decides."""
    determined: list[float] = np.where(sizes > least, sizes, 0.0).tolist()
    return determined


def _place(request: RemedyRequest, turn: _Turn, p: complex) -> Array:
    """Convert a place in the plane to the inertial frame (3,)."""
    R = request.linkage.chain.frame.R
    decimals = PLACE_DIGITS - int(np.floor(np.log10(request.space.length)))
    place = np.array([p.real, p.imag, turn.near[1]]) @ R
    return np.asarray(round_decimals(place, decimals))


def _document(
    request: RemedyRequest, turn: _Turn, shafts: Sequence[Shaft]
) -> tuple[Document, list[str], list[str]]:
    """Write shafts into the file: it, and their links and joints."""
    linkage = request.linkage
    taken = names_taken(request.base)
    root = next(name for name, place in linkage.places.items() if place.link == GROUND)
    R, radius = linkage.chain.frame.R, request.rotor_radius
    elements: list[Element] = []
    links, joints = [], []
    for shaft in shafts:
        links.append(free_name("balance_shaft", taken))
        taken.add(links[-1])
        joints.append(free_name(f"{links[-1]}_joint", taken))
        taken.add(joints[-1])
        mass = abs(shaft.unbalance) / radius
        arm = radius * shaft.unbalance / abs(shaft.unbalance)
        middle, pose = np.eye(4), np.eye(4)
        middle[:3, 3] = arm.real * R[0] + arm.imag * R[1]
        pose[:3, 3] = _place(request, turn, shaft.place)
        ball = (0.75 * mass / (np.pi * STEEL)) ** (1.0 / 3.0)
        inertia = 0.4 * mass * ball**2 * np.eye(3)
        elements += [
            make_elements.link(
                links[-1],
                make_elements.inertial(mass, inertia, make_elements.origin(middle)),
            ),
            make_elements.joint(
                joints[-1],
                "continuous",
                root,
                links[-1],
                make_elements.origin(pose),
                (number_words(R[2]), ""),
                mimic=(turn.crank, float(shaft.ratio), 0.0),
            ),
        ]
    return append_elements(request.base, elements), links, joints
