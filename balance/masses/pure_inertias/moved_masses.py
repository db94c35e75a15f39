"""Point masses moved across the joints of a planar linkage, until bodies have none left."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import MASS_LEFT_RELATIVE
from kinematics.model.arrays import freeze
from kinematics.wording import number_text

Array = NDArray[np.float64]


class MovedMass(NamedTuple):
    """A point mass that bodies exchange across a revolute joint.

    Attributes:
        joints: names of the joint, or of several where links without parameters lie between.
        point: where it is, in the plane (2,), metres.
        gains: mass that each body gains, kg, by name; the rest comes from the ground.
    """

    joints: tuple[str, ...]
    point: Array
    gains: dict[str, float]

    @property
    def gains_text(self) -> str:
        """The masses in one line."""
        return ", ".join(
            f"{name} {number_text(mass, '+.6g')} kg" for name, mass in self.gains.items()
        )

    @property
    def words(self) -> str:
        """The joint and the masses in one line."""
        return f"{', '.join(self.joints)}: {self.gains_text}"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return {
            "joints": list(self.joints), "point": self.point.tolist(), "gains": self.gains,
            "words": self.words,
        }  # fmt: skip


class LeftMass(NamedTuple):
    """Mass that cannot be moved off a body.

    Attributes:
        body: name of the body.
        mass: kg.
        moment: mass times the place of its centre, in the plane (2,), kg m.
        reason: why it stays, in one line.
    """

    body: str
    mass: float
    moment: Array
    reason: str

    @property
    def words(self) -> str:
        """The mass and the reason in one line."""
        return f"{self.body}: {number_text(self.mass, '.6g')} kg stays: {self.reason}"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return self._asdict() | {"moment": self.moment.tolist(), "words": self.words}


def given_in_plane(space: DesignSpace) -> Array:
    """Return the parameters (bodies, 4) of the masses of the file, in units of the chain."""
    given = np.array([body.inertia for body in space.linkage.bodies]).reshape(-1, 10)
    return to_chain(given, space.chain.frame, True, False)


def empty_bodies(space: DesignSpace) -> tuple[Array, list[LeftMass]]:
    """Move the masses of the file off as many bodies as inertia transfers allow.

    Bodies give up their mass one after the other, the last of the tree first; a body keeps it
    if it cannot be emptied together with those before. Of all ways the one with the least
    transfers is taken.

    Args:
        space: a planar design space for dynamic balance.

    Returns:
        What is added to the parameters (bodies, 4), in the units of the chain; and the masses
        that stay.
    """
    z, T = given_in_plane(space), _transfer_columns(space)
    size = float(np.abs(z[:, :3]).max(initial=0.0))
    y: Array = np.zeros(T.shape[2])
    empty: list[int] = []
    for body in reversed(range(len(z))):
        wanted = [*empty, body]
        A, b = T[wanted, :3].reshape(3 * len(wanted), -1), -z[wanted, :3].ravel()
        solution = np.asarray(np.linalg.lstsq(A, b)[0], np.float64)
        if np.abs(A @ solution - b).max() <= MASS_LEFT_RELATIVE * size:
            y, empty = solution, wanted
    added = T @ y
    rest = [body for body in range(len(z)) if body not in empty]
    remaining_masses = [_left_mass(space, T, z, z + added, body) for body in rest]
    added[empty, :3] = -z[empty, :3]
    return added, remaining_masses


def masses_by_joint(space: DesignSpace, added: Array) -> tuple[MovedMass, ...]:
    """Write a sum of inertia transfers as point masses, joint by joint.

    Args:
        space: a planar design space.
        added: the sum (bodies, 4), in the units of the chain.

    Returns:
        The masses at revolute joints; what passes a prismatic joint has none.
    """
    masses = []
    T = _transfer_columns(space)
    y = np.linalg.lstsq(T.reshape(-1, T.shape[2]), added.ravel())[0]
    size, at = float(np.abs(added[:, 0]).max(initial=0.0)), 0
    for item in space.transfers:
        part = T[:, :, at : at + item.dimension] @ y[at : at + item.dimension]
        at += item.dimension
        heavy = np.flatnonzero(np.abs(part[:, 0]) > MASS_LEFT_RELATIVE * size)
        if item.joints and heavy.size:
            first = part[heavy[0]]
            gains = {space.bodies[b]: float(part[b, 0]) for b in heavy.tolist()}
            point = _in_metres(space, first[1:3] / first[0])
            masses.append(MovedMass(item.joints, freeze(point), gains))
    return tuple(masses)


def _transfer_columns(space: DesignSpace) -> Array:
    """Stack the inertia transfers of all joints (bodies, 4, count), in units of the chain."""
    count = len(space.bodies)
    columns = [item.scaled.reshape(count, 4, -1) for item in space.transfers]
    return np.concatenate([np.empty((count, 4, 0)), *columns], axis=2)


def _in_metres(space: DesignSpace, point: Array) -> Array:
    """Convert a point of the plane from units of the chain, about the inertial origin."""
    frame = space.chain.frame
    return np.asarray(frame.length * point + (frame.R @ frame.origin)[:2])


def _left_mass(space: DesignSpace, T: Array, given: Array, after: Array, body: int) -> LeftMass:
    """Describe the mass that stays on a body, and say why."""
    mass, length = float(after[body, 0]), space.chain.frame.length
    middle = (space.chain.frame.R @ space.chain.frame.origin)[:2]
    moment = length * after[body, 1:3] + mass * middle
    reason = _reason(space, T[body], given[body])
    return LeftMass(space.bodies[body], mass, freeze(moment), reason)


def _reason(space: DesignSpace, T: Array, z: Array) -> str:
    """Say why the mass of a body cannot be moved off it.

    Args:
        T: what transfers add to the body (4, count).
        z: its parameters (4,).
    """
    heavy = np.abs(T[0]) > MASS_LEFT_RELATIVE * np.abs(T).max(initial=1e-300)
    points = (T[1:3, heavy] / T[0, heavy]).T
    slides = "; a prismatic joint lets no point mass pass" if _at_slide(space, T) else ""
    if not len(points):
        return f"no revolute joint leads to a body that could take it{slides}"
    fitted = np.linalg.lstsq(T[:3], z[:3])[0]
    if np.abs(T[:3] @ fitted - z[:3]).max() <= MASS_LEFT_RELATIVE * np.abs(z[:3]).max():
        return "the bodies around it cannot pass it on to the ground" + slides
    if not z[0]:
        return f"its first moment has no mass{slides}"
    centre = z[1:3] / z[0]
    off, apart, slid = centre - points[0], points - points[0], T[1:3, ~heavy].T
    along = np.concatenate([apart, slid])
    foot = np.linalg.lstsq(along.T, off)[0] @ along
    distance = space.chain.frame.length * float(np.linalg.norm(off - foot))
    if np.abs(apart).max() > MASS_LEFT_RELATIVE:
        where = "beside the line through its revolute joints"
    else:
        where = "from its revolute joint"
    if np.abs(slid).max(initial=0.0) > MASS_LEFT_RELATIVE:
        where += ", across the slide"
    return f"its centre of mass is {number_text(distance)} m {where}{slides}"


def _at_slide(space: DesignSpace, T: Array) -> bool:
    """Whether a transfer without mass reaches the body: one across a prismatic joint."""
    light = np.abs(T[0]) <= MASS_LEFT_RELATIVE * np.abs(T).max(initial=1e-300)
    return bool(np.abs(T[:, light]).max(initial=0.0) > 0.0)
