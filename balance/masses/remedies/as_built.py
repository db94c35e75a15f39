"""What a remedy asks of the machine as it is built: its bearings, its gears, and its room.

At the reference pose each input moves alone, once at a unit rate (1 rad/s, or a characteristic
length per second) and once with a unit acceleration from rest. The load of bearings is the
largest force of a joint over all of them, each scaled to the peaks of rate and acceleration
along random motions of 1 s of the linkage in the file, so that linkages with and without a
remedy are compared at one motion of the inputs.

A joint that follows another is driven by a pair of gears, of the ratio m ≥ 1. The torque T of
the pinion asks for face widths F and diameters d of

    Σ F d² = (2 T / K) (1 + 1/m + m + m²)

with the K factor of surface durability; both wheels are solid discs of steel. Belts weigh less.

Source:
    R. J. Willis, Lightest-weight gears, Product Engineering, 21 January 1963; D. W. Dudley,
    Handbook of Practical Gear Design, 1984, for K.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from balance.masses.designs.density import STEEL
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.shaking_wrench import inertia_loads, mass_parameters
from balance.motion.verification.trajectory import order_inputs
from kinematics.closure.joint_positions import input_chain
from kinematics.model.linkage import Linkage
from kinematics.model.motion import motion_of
from kinematics.numerics.array_types import Array

if TYPE_CHECKING:
    from balance.masses.remedies.request import RemedyRequest

# K factor of gears of through-hardened steel, N/m².
K_FACTOR = 1e6
# Masses below it, of that of the linkage, take no room.
ROOMLESS = 1e-9


class InputSteps(NamedTuple):
    """Rates and accelerations of the inputs at the reference pose, one row a sample, SI units.

    Attributes:
        ud: rates (2 w, inputs): w rows that move, then w at rest.
        udd: accelerations (2 w, inputs).
    """

    ud: Array
    udd: Array


class AsBuilt(NamedTuple):
    """What a linkage with a remedy asks of its bearings, its gears, and its room.

    Attributes:
        bearing_load: largest force of a joint at the peaks of the inputs' motion, N.
        width: longest edge of a box about joints, centres of mass and spheres of gyration at
            the reference pose, along the axes of the linkage, m.
        gear_mass: of the gears that drive the joints that it adds, kg; not in its file.
        bearing_ratio: the load over that of the file; None where the file has none.
        width_ratio: the width over that of the file; None where the file has none.
    """

    bearing_load: float
    width: float
    gear_mass: float = 0.0
    bearing_ratio: float | None = None
    width_ratio: float | None = None


def input_steps(
    request: RemedyRequest, linkage: Linkage, relations: Sequence[str] = ()
) -> InputSteps:
    """Move each input of a linkage alone, or as relations between inputs let it.

    Args:
        request: for the peaks of its motions, and its characteristic length.
        relations: between the inputs.
    """
    lengths = _input_units(request, linkage)
    limits = motion_of(linkage, tuple(relations) or None)
    basis = np.eye(len(lengths)) if limits is None else order_inputs(limits, linkage)
    steps = basis.T / lengths
    steps = steps / np.abs(steps).max(axis=1, keepdims=True, initial=1e-300) * lengths
    rate, acceleration = _peaks(request)
    still = np.zeros_like(steps)
    return InputSteps(
        np.concatenate([rate * steps, still]), np.concatenate([still, acceleration * steps])
    )


def as_built(
    request: RemedyRequest, linkage: Linkage, steps: InputSteps, new_joints: Sequence[str]
) -> AsBuilt:
    """Compute what a linkage with a remedy asks of the machine, beside its file.

    Args:
        linkage: the linkage with the remedy.
        steps: of its inputs.
        new_joints: joints that the remedy adds.
    """
    file = built_in_file(request)
    load, gears = _loads(linkage, steps, new_joints)
    width = _width(request, linkage)
    return AsBuilt(
        load,
        width,
        gears,
        load / file.bearing_load if file.bearing_load > 0.0 else None,
        width / file.width if file.width > 0.0 else None,
    )


@lru_cache(maxsize=4)
def built_in_file(request: RemedyRequest) -> AsBuilt:
    """Compute the same of the linkage in the file, once for all remedies."""
    linkage = request.linkage
    load, _ = _loads(linkage, input_steps(request, linkage, request.motion), ())
    return AsBuilt(load, _width(request, linkage), 0.0, 1.0, 1.0)


def gear_mass(torque: float, ratio: float) -> float:
    """Compute the mass of a pair of gears that drives a rotor, kg.

    Args:
        torque: of the rotor, N m.
        ratio: turns of the rotor for one turn of what drives it; its sign does not count.
    """
    turns = abs(ratio)
    pinion, m = (torque, turns) if turns >= 1.0 else (torque * turns, 1.0 / turns)
    return 0.25 * np.pi * STEEL * 2.0 * pinion / K_FACTOR * (1.0 + 1.0 / m + m + m**2)


def _input_units(request: RemedyRequest, linkage: Linkage) -> list[float]:
    """List the SI units per unit of each input: 1 rad, or the characteristic length."""
    length, sliding = request.space.length, linkage.sliding
    return [length if name in sliding else 1.0 for name in linkage.inputs]


@lru_cache(maxsize=4)
def _peaks(request: RemedyRequest) -> tuple[float, float]:
    """Compute the peaks of rate and acceleration of the inputs along random motions."""
    units = _input_units(request, request.linkage)
    rates = max(float(np.abs(each.ud / units).max()) for each in request.motions)
    changes = max(float(np.abs(each.udd / units).max()) for each in request.motions)
    return rates, changes


def _loads(
    linkage: Linkage, steps: InputSteps, new_joints: Sequence[str]
) -> tuple[float, float]:
    """Compute the largest force of a joint, N, and the mass of the gears of new joints, kg."""
    chain = input_chain(linkage)
    units = chain.units[linkage.positions_of(linkage.inputs)]
    at = np.zeros((len(steps.ud), len(linkage.joints)))
    loads = inertia_loads(
        chain, mass_parameters(linkage), at, steps.ud / units, steps.udd / units
    )
    reactions = joint_reactions(chain, loads)
    forces = np.linalg.norm(reactions.joints[..., 3:], axis=2)
    gears = 0.0
    for mimic in linkage.mimics:
        if linkage.joints[mimic.joint].name not in new_joints or not mimic.ratio:
            continue
        efforts = np.einsum(
            "ti,ti->t", loads.screws[:, mimic.joint], reactions.joints[:, mimic.joint]
        )
        moving, resting = np.split(np.abs(efforts), 2)
        scale = chain.frame.length**2 / chain.units[mimic.joint]
        torque = float(scale * (moving.sum() + resting.sum()))
        if linkage.joints[mimic.joint].kind == "revolute":
            gears += gear_mass(torque, mimic.ratio)
    return chain.frame.length * float(forces.max(initial=0.0)), gears


def _width(request: RemedyRequest, linkage: Linkage) -> float:
    """Compute the longest edge of the box about a linkage at its reference pose, metres."""
    given = {body.name: body.inertia for body in request.linkage.bodies}
    points = [joint.point for joint in linkage.joints]
    low, high = list(points), list(points)
    for body in linkage.bodies:
        parts = [body.inertia]
        if body.name in given:
            parts = [given[body.name], body.inertia - given[body.name]]
        for z in parts:
            if z[0] > ROOMLESS * request.given_mass:
                centre = z[1:4] / z[0]
                square = 0.5 * float(z[4:7].sum()) / z[0] - centre @ centre
                radius = np.sqrt(max(square, 0.0))
                low.append(centre - radius)
                high.append(centre + radius)
    return float((np.max(high, axis=0) - np.min(low, axis=0)).max())
