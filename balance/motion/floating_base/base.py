"""The body that carries a linkage and floats, or stands on springs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.conversions import parameters, to_chain, violations
from kinematics.errors import UsageError
from kinematics.model.arrays import Chain
from kinematics.model.spatial.inertia import spatial_inertias
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array


@dataclass(frozen=True)
class FloatingBase:
    """The body that carries a linkage and floats, or stands on springs without damping.

    Attributes:
        mass: kg.
        inertia: moments of inertia ``Ixx, Iyy, Izz`` about the axes through its centre of mass,
            parallel to the inertial axes (3,), kg m²; or with the elements ``Ixy, Ixz, Iyz`` of
            its tensor too (6,); or one number for all three. Simulations need it; paths without
            reaction do not depend on it.
        com: its centre of mass (3,), metres, in the inertial frame at the start.
        turning_stiffness: stiffness of a rotational spring to the ground, N m/rad; its moment
            is proportional to the rotation vector.
        stiffness: stiffness of a translational spring to the ground that acts on the centre
            of mass alike in all directions, N/m.

    Example:
        >>> import balance
        >>> balance.motion.FloatingBase(mass=10, inertia=1, turning_stiffness=1e4).on_springs
        True
    """

    mass: float
    inertia: float | tuple[float, ...] | None = None
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turning_stiffness: float = 0.0
    stiffness: float = 0.0

    @property
    def on_springs(self) -> bool:
        """Whether there is a spring."""
        return self.turning_stiffness > 0.0 or self.stiffness > 0.0

    @property
    def moments(self) -> tuple[float, float, float]:
        """The three moments of inertia, kg m².

        Raises:
            UsageError: there are none.
        """
        x, y, z, *_ = self._elements
        return x, y, z

    @property
    def products(self) -> tuple[float, float, float]:
        """The elements ``Ixy, Ixz, Iyz`` of its inertia tensor, kg m².

        Raises:
            UsageError: there is no inertia.
        """
        *_, xy, xz, yz = self._elements
        return xy, xz, yz

    @property
    def _elements(self) -> tuple[float, ...]:
        """Six elements of the inertia tensor, the moments first."""
        given = self.inertia
        if given is None:
            raise UsageError("a base that turns needs moments of inertia")
        if not isinstance(given, tuple):
            given = (given, given, given)
        if len(given) not in (3, 6):
            raise UsageError("the inertia of a base is one number, three, or six")
        return (*given, 0.0, 0.0, 0.0)[:6]

    @property
    def tensor(self) -> Array:
        """Inertia tensor about its centre of mass, in inertial axes (3, 3), kg m²."""
        (x, y, z), (xy, xz, yz) = self.moments, self.products
        return np.array([[x, xy, xz], [xy, y, yz], [xz, yz, z]])

    @property
    def parameters(self) -> Array:
        """Inertial parameters about the inertial origin (10,)."""
        return parameters(self.mass, self.com, self.tensor)

    def check(self) -> None:
        """Refuse a base that cannot be.

        Raises:
            UsageError: a number is not finite, mass or a moment is not positive or missing, no
                body has these moments, or a stiffness is negative.
        """
        numbers = [self.mass, *self._elements, *self.com]
        numbers += [self.turning_stiffness, self.stiffness]
        if not (np.isfinite(numbers).all() and self.mass > 0.0 and min(self.moments) > 0.0):
            raise UsageError(
                "a base needs a mass and moments of inertia above 0, and a centre of mass"
            )
        if min(self.turning_stiffness, self.stiffness) < 0.0:
            raise UsageError("a spring needs a stiffness from 0 up")
        wrong = violations(parameters(self.mass, (0.0, 0.0, 0.0), self.tensor))
        if wrong:
            raise UsageError(f"no base has these moments of inertia: {wrong[0]}")


class BaseInChain(NamedTuple):
    """A base in the frame and units of a chain.

    Attributes:
        M: its spatial inertia (6, 6).
        com: its centre of mass (3,).
        turning_stiffness: of the rotational spring.
        stiffness: of the translational spring.
        freedoms: twists that the base can have, as columns (6, 6); or (6, 3) in a plane: the
            rotation about its normal and the translations along its axes.
    """

    M: Array
    com: Array
    turning_stiffness: float
    stiffness: float
    freedoms: Array

    @classmethod
    def of(cls, base: FloatingBase, chain: Chain, axes: Array | None) -> BaseInChain:
        """Convert a base.

        Args:
            base: in SI units.
            axes: axes of the plane in which the base moves, as rows, the normal last (3, 3);
                None in space.
        """
        frame = chain.frame
        z = to_chain(base.parameters[None], frame, False, False)
        freedoms = np.eye(6)
        if axes is not None:
            freedoms = np.zeros((6, 3))
            freedoms[:3, 0], freedoms[3:, 1], freedoms[3:, 2] = axes[2], axes[0], axes[1]
        return cls(
            spatial_inertias(z)[0],
            (np.array(base.com) - frame.origin) / frame.length,
            base.turning_stiffness / frame.length**2,
            base.stiffness,
            freedoms,
        )

    @property
    def planar(self) -> bool:
        """Whether the base moves in a plane."""
        return self.freedoms.shape[1] == 3

    @property
    def stiffness_matrix(self) -> Array:
        """Stiffness against small displacements of the base (6, 6)."""
        moved = np.hstack([-skew(self.com), np.eye(3)])
        turned = np.diag([self.turning_stiffness] * 3 + [0.0] * 3)
        return np.asarray(turned + self.stiffness * moved.T @ moved)
