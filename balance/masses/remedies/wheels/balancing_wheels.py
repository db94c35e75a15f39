"""One wheel on the base that takes the angular momentum: passive, or with a motor of its own.

Counterweights balance the force first; the moment is then the same about every point. A
wheel about the normal of a planar linkage, of inertia J, takes it at the speed ``-h / J``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.wheels.geared_wheel import build_geared_wheel
from balance.masses.remedies.wheels.motor_wheels import build_motor_wheels
from balance.masses.remedies.wheels.wheels_on_base import NoWheel
from kinematics.errors import LinkageError


def apply_passive_wheel(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage of one freedom by a wheel that its crank drives.

    The wheel's ratio to the crank varies: ``i(u) = -h(u) / J`` with the angular momentum h for
    a unit rate of the crank; see
    `balance.masses.remedies.wheels.geared_wheel.build_geared_wheel`.

    Yields:
        One result.
    """
    yield _attempt("passive_wheel", request, build_geared_wheel)


def apply_active_wheel(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by a wheel with a motor of its own, or by three if it is spatial.

    Speed ``-h / J``, torque ``-ḣ`` and power ``h ḣ / J``; see
    `balance.masses.remedies.wheels.motor_wheels.build_motor_wheels`.

    Yields:
        One result.
    """
    yield _attempt("active_wheel", request, build_motor_wheels)


def _attempt(
    remedy: str, request: RemedyRequest, build: Callable[[RemedyRequest], AppliedRemedy]
) -> AppliedRemedy:
    """Build wheels, or say why there are none."""
    if request.balance == "force":
        return refused(remedy, "a wheel takes a moment, and only the force is to be balanced")
    try:
        return build(request)
    except NoWheel as no:
        return replace(refused(remedy, no.reason), verdict=no.verdict, proof=no.proof)
    except LinkageError as error:
        return refused(remedy, str(error))
