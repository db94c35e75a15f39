"""Slider-cranks with crank and coupler of one length, whose coupler carries the tool.

The slider moves on a line through the pivot G of the crank, so that the coupler turns as far as
the crank, against it. With ``w = e^(iφ)`` of the turn φ of the tool from the first position its
point is at

    z = G + P w̄ + Q w

with the crank P and the arm Q from its tip to the tool, both at the first position. This is
linear in G, P and Q: two positions and a pivot determine them, three do without, and for more
least squares find the nearest, with the angles as they are given. Each point of the coupler as
far from the crank tip as G moves on a line through G (the circles of Cardan), so that the line
of the slider may have any direction; the pressure angle is least if the crank turns as far to
both sides of it.

Source: elliptic motion, O. Bottema, B. Roth, Theoretical Kinematics, 1979; that it can be
balanced, J. J. de Jong, PhD thesis, University of Twente, section 2.4.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from balance.studies.synthesis.constrained_motion import Defect
from balance.studies.synthesis.four_bar_masses import plane_origin
from balance.studies.synthesis.four_bars import Complex, CouplerMotion, order_defects
from balance.studies.synthesis.positions import Position, size_of
from kinematics.errors import SynthesisError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.numerics.array_types import Array

KIND = "slider-crank"
# Largest pressure angle; at 90° crank and coupler fold onto each other, and may stay so.
STEEPEST = math.radians(80.0)
# Decimals of the direction of the line in the file.
DECIMALS = 15


@dataclass(frozen=True)
class SliderCrank(CouplerMotion):
    """A slider-crank with crank and coupler of one length through positions.

    Attributes:
        positions: of the tool.
        crank_angles: of the crank at each position, from the line of the slider, radians.
        crank_base: G, metres, inertial frame.
        crank: P, from G to the tip of the crank at the first position, metres.
        arm: Q, from that tip to the tool.
    """

    positions: tuple[Position, ...]
    crank_angles: tuple[float, ...]
    crank_base: complex
    crank: complex
    arm: complex

    kind = KIND

    @property
    def first(self) -> Position:
        """Pose of the tool at the first angle of the crank."""
        point = self.crank_base + self.crank + self.arm
        return Position(point.real, point.imag, self.positions[0].angle)

    @property
    def line(self) -> complex:
        """Direction of the line of the slider, of length 1."""
        return self.crank / abs(self.crank) * cmath.exp(-1j * self.crank_angles[0])

    @property
    def pressure_angle(self) -> float:
        """Largest angle between coupler and line on the way, radians."""
        return max(map(abs, self.crank_angles))

    @property
    def numbers(self) -> dict[str, float]:
        """Length of crank and coupler, metres, and the pressure angle, radians."""
        return {"crank": abs(self.crank), "pressure_angle": self.pressure_angle}

    def pivots(self, index: int = 0) -> dict[str, complex]:
        """Compute the pivots at a position, metres, inertial frame."""
        alpha = self.crank_angles[index]
        along = 2.0 * abs(self.crank) * math.cos(alpha) * self.line
        return {
            "crank_base": self.crank_base,
            "crank_tip": self.crank_base
            + self.crank * cmath.exp(1j * (alpha - self.crank_angles[0])),
            "slider": self.crank_base + along,
        }

    def outline(self, index: int) -> tuple[complex, ...]:
        """Compute a line along the links: crank, coupler with the tool, and to the slider."""
        at, tool = self.pivots(index), complex(self.tool_points(self.crank_angles[index]))
        return at["crank_base"], at["crank_tip"], tool, at["slider"], at["crank_tip"]

    def tool_points(self, crank_angles: ArrayLike) -> Complex:
        """Compute the point of the tool for angles of the crank from the line."""
        w = self._coupler_turns(crank_angles)
        return np.asarray(self.crank_base + self.crank * w.conjugate() + self.arm * w)

    def tool_turns(self, crank_angles: ArrayLike) -> Complex:
        """Compute ``e^(iθ)`` of the angle of the tool for angles of the crank."""
        return self._coupler_turns(crank_angles) * cmath.exp(1j * self.positions[0].angle)

    def _coupler_turns(self, crank_angles: ArrayLike) -> Complex:
        """Compute w."""
        turned = np.asarray(crank_angles, dtype=np.float64) - self.crank_angles[0]
        return np.asarray(np.exp(-1j * turned))

    @property
    def defects(self) -> tuple[Defect, ...]:
        """Order defects, and that crank and coupler fold onto each other on the way."""
        folds = (
            Defect("branch", "crank and coupler fold onto each other: the tool turns too far"),
        )
        steep = self.pressure_angle > STEEPEST
        return (*(folds if steep else ()), *order_defects(self.crank_angles))


def slider_crank_through(
    positions: Sequence[Position],
    *,
    fixed: complex | None = None,
    moving: complex | None = None,
) -> SliderCrank:
    """Find the slider-crank through two or three positions, or the nearest to more.

    Args:
        positions: two or more positions of the tool.
        fixed: pivot of the crank on the base, for two positions; metres, inertial frame.
        moving: or the tip of the crank, at the first position.

    Returns:
        The slider-crank; with more positions ``Σ |z_i - point_i|²`` is least.

    Raises:
        SynthesisError: the positions have fewer angles than the equations take, or the tool
            turns about a pole, so that no crank has a length.
    """
    points = np.array([each.point for each in positions])
    turns = _least_turns([each.angle - positions[0].angle for each in positions])
    w = np.exp(1j * turns)
    # Columns of G, P and Q; a chosen pivot takes one of them away.
    rows = np.column_stack([np.ones_like(w), w.conjugate(), w])
    given = np.zeros_like(points)
    reduce = np.eye(3, dtype=np.complex128)
    if fixed is not None:
        given, reduce = rows[:, 0] * fixed, reduce[:, 1:]
    elif moving is not None:
        # G = moving - P, and Q = point - moving.
        arm = points[0] - moving
        given = moving + arm * w
        reduce = np.array([[-1.0], [1.0], [0.0]], dtype=np.complex128)
    system = rows @ reduce
    if np.linalg.svd(system, compute_uv=False)[-1] < SYNTHESIS_SINGULAR:
        raise SynthesisError(
            "the angles of the positions are too few, or the crank would turn half a turn",
            "give positions that differ in angle",
        )
    G, P, Q = reduce @ np.linalg.lstsq(system, points - given, rcond=None)[0]
    if fixed is not None:
        G = fixed
    elif moving is not None:
        G, Q = moving + G, points[0] - moving
    if abs(P) < SYNTHESIS_SINGULAR * size_of(positions):
        raise SynthesisError(
            "the tool turns about a pole, so that the crank has no length",
            "choose a pivot away from it" if len(positions) == 2 else "give other positions",
        )
    middle = 0.5 * (turns.min() + turns.max())
    return SliderCrank(
        tuple(positions), tuple((middle - turns).tolist()), complex(G), complex(P), complex(Q)
    )


def _least_turns(turns: Sequence[float]) -> Array:
    """Choose turns that differ by whole ones, so that all lie in the least range."""
    whole = 2.0 * np.pi
    wrapped = np.mod(turns, whole)
    order = np.sort(wrapped)
    gaps = np.diff(order, append=order[0] + whole)
    start = order[(gaps.argmax() + 1) % len(order)]
    shifted = np.mod(wrapped - start, whole)
    return np.asarray(shifted - shifted[0])


def slider_crank_urdf(design: SliderCrank) -> bytes:
    """Write a slider-crank as a URDF file at the first position.

    The frames of its links are at their joints, all parallel to the inertial frame.
    """
    at = design.pivots()
    base, tip, pin = at["crank_base"], at["crank_tip"], at["slider"]
    axis = number_words(
        [round(design.line.real, DECIMALS), round(design.line.imag, DECIMALS), 0.0]
    )
    yaw = number_words([0.0, 0.0, design.first.angle])
    turned = Element(
        "origin", {**plane_origin(design.first.point - tip).attributes, "rpy": yaw}
    )
    parts = [
        *map(make_elements.link, ("base", "crank", "coupler", "slider", "tool")),
        make_elements.hinge(
            "crank_joint", "base", "crank", plane_origin(base), independent=True
        ),
        make_elements.hinge("coupler_joint", "crank", "coupler", plane_origin(tip - base)),
        make_elements.joint(
            "slide", "prismatic", "base", "slider", plane_origin(pin), (axis, "")
        ),
        make_elements.joint("tool_fixed", "fixed", "coupler", "tool", turned),
        make_elements.loop(
            "slider_joint",
            "revolute",
            [("coupler", plane_origin(pin - tip)), ("slider", plane_origin(0j))],
            ("0 0 1", ""),
        ),
    ]
    return element_text(make_elements.robot(KIND, parts)).encode()
