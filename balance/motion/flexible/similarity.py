"""Similar counter-arms: an arm on a hub balanced by a scaled arm that bends alike.

With lengths scaled by f, masses by 1/f and bending stiffness by f², both arms follow the hub
with the same angles at the same time, and their forces on the hub cancel (J. P. Meijaard,
V. van der Wijk, Mechanism and Machine Theory 172, 104784, 2022, Sec. 2; numbers in brackets are
those of its equations).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from balance.motion.flexible.beam import Beam
from balance.motion.flexible.supported_beam_modes import Clamp, EndBody, supported_modes
from kinematics.errors import LinkageError
from kinematics.wording import repr_lines

# Elements of the beam of an arm.
ELEMENTS = 16

CONDITION_HOLDS = 1e-9
# Largest scale, and the inverse of the smallest: thicknesses and widths are powers of it.
LARGEST_SCALE = 1e6
"""Largest relative difference of two sides of a condition that holds."""


@dataclass(frozen=True)
class Arm:
    """A beam clamped on a hub, with a rigid body at its tip.

    Attributes:
        beam: the beam, from the edge of the hub to the tip body.
        tip_mass: mass of the tip body, in kg.
        tip_radius: distance of its centre of mass beyond the end of the beam, in metres.
        tip_inertia: about its centre of mass, in kg m².
        hub_radius: distance of the beam's root from the axis, in metres.

    Raises:
        LinkageError: a number is negative or not finite, or nothing has mass.
    """

    beam: Beam
    tip_mass: float
    tip_radius: float = 0.0
    tip_inertia: float = 0.0
    hub_radius: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("tip_mass", "tip_radius", "tip_inertia", "hub_radius"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise LinkageError(f"arm: {name} {getattr(self, name):g} is negative")
        if self.tip_mass + self.beam.mass == 0.0:
            raise LinkageError("arm: neither its beam nor its tip has mass")

    def __repr__(self) -> str:
        """Tip body, hub, and the beam on a line of its own."""
        return repr_lines(
            f"Arm: tip of {self.tip_mass:.6g} kg, hub radius {self.hub_radius:.6g} m",
            repr(self.beam),
        )

    @property
    def first_moment(self) -> float:
        """Mass times distance from the axis of the straight arm, in kg m."""
        beam, root = self.beam, self.hub_radius
        tip = self.tip_mass * (root + beam.length + self.tip_radius)
        return beam.mass * (root + 0.5 * beam.length) + tip


@dataclass(frozen=True)
class Section:
    """A rectangular section: thickness in the plane of bending and width, in metres."""

    thickness: float
    width: float


@dataclass(frozen=True)
class SimilarityCondition:
    """One condition of similarity.

    Attributes:
        name: number of the equation in the source, or words.
        words: what is equal.
        first: value of the first arm, SI units.
        second: value of the second arm.
        difference: second over first, minus 1; infinity if only one side vanishes.
        holds: whether the difference is below 1e-9.
    """

    name: str
    words: str
    first: float
    second: float
    difference: float
    holds: bool


@dataclass(frozen=True)
class Similarity:
    """How far two arms are similar.

    Attributes:
        scale: f, length of the second beam over that of the first.
        conditions: those of the source, and those of geometry.
        frequencies: first frequency of each arm on a fixed hub, in Hz.
        first_moment: difference of the first moments of the straight arms over the larger.
    """

    scale: float
    conditions: tuple[SimilarityCondition, ...]
    frequencies: tuple[float, float]
    first_moment: float

    def __repr__(self) -> str:
        """Scale, verdict and frequencies."""
        wrong = ", ".join(
            condition.name for condition in self.conditions if not condition.holds
        )
        first, second = self.frequencies
        return repr_lines(
            f"Similarity of arms, scale {self.scale:.6g}",
            "similar" if self.similar else f"not similar: {wrong}",
            f"first frequencies {first:.6g} and {second:.6g} Hz",
        )

    @property
    def similar(self) -> bool:
        """Whether all conditions hold, so that the pair does not shake the hub."""
        return all(condition.holds for condition in self.conditions)


def similar_arm(arm: Arm, scale: float) -> Arm:
    """Compute the similar counter-arm: lengths f, masses 1/f, EI f², ρA 1/f², EA as it is.

    Args:
        arm: the arm to balance.
        scale: f, positive.

    Raises:
        LinkageError: the scale is not positive, or beyond 1e6 or 1e-6.

    Example:
        >>> from balance.flexible import Arm, Beam, similar_arm
        >>> similar_arm(Arm(Beam(0.1, 0.0045, 0.024), 0.01), 0.5)
        Arm: tip of 0.02 kg, hub radius 0 m
          Beam: 0.05 m, EI 0.001125 N m², 0.096 kg/m
    """
    f, beam = _checked_scale(scale), arm.beam
    return Arm(
        Beam(
            f * beam.length,
            f**2 * beam.bending,
            beam.line_mass / f**2,
            beam.axial,
            beam.shear,
            beam.rotary,
        ),
        arm.tip_mass / f,
        f * arm.tip_radius,
        f * arm.tip_inertia,
        f * arm.hub_radius,
    )


def similar_section(section: Section, scale: float) -> tuple[Section, float]:
    """Compute the section of a similar beam of the same material, Euler-Bernoulli.

    Args:
        section: of the first beam, metres.
        scale: f, length of the similar beam over that of the first one.

    Returns:
        The section, with thickness scaled by f² and width by 1/f⁴, and the factor 1/f³ of the
        width of rigid parts.

    Raises:
        LinkageError: the scale is not positive, or beyond 1e6 or 1e-6.

    Example:
        >>> from balance.motion.flexible.similarity import Section, similar_section
        >>> similar_section(Section(0.001, 0.01), 0.5)
        (Section(thickness=0.00025, width=0.16), 8.0)
    """
    f = _checked_scale(scale)
    return Section(f**2 * section.thickness, section.width / f**4), 1.0 / f**3


def compare_arms(first: Arm, second: Arm) -> Similarity:
    """Compare two arms condition by condition.

    Args:
        first: the arm to balance.
        second: its counter-arm, on the other side of the same hub.

    Returns:
        The conditions with their differences, and the first frequencies.

    Example:
        >>> from balance.flexible import Arm, Beam, compare_arms, similar_arm
        >>> arm = Arm(Beam(0.1, 0.0045, 0.024), 0.01)
        >>> compare_arms(arm, similar_arm(arm, 0.5)).similar
        True
    """
    conditions = [
        _condition(name, words, first, second)
        for (name, words, first), (_, _, second) in zip(
            _sides(first), _sides(second), strict=True
        )
    ]
    moments = (first.first_moment, second.first_moment)
    frequencies = [_arm_frequency(arm) / (2.0 * np.pi) for arm in (first, second)]
    return Similarity(
        second.beam.length / first.beam.length,
        tuple(conditions),
        (frequencies[0], frequencies[1]),
        abs(moments[1] - moments[0]) / max(moments),
    )


def _arm_frequency(arm: Arm) -> float:
    """Compute the lowest circular frequency of an arm on a fixed hub, in rad/s."""
    body = EndBody(arm.tip_mass, arm.tip_radius, arm.tip_inertia)
    return float(supported_modes(arm.beam, [Clamp(0.0)], 1, ELEMENTS, body).frequencies[0])


def _checked_scale(scale: float) -> float:
    """Return a scale that is positive and of a size that can be built.

    Raises:
        LinkageError: it is not.
    """
    if not 0.0 < scale < math.inf:
        raise LinkageError(f"scale {scale:g} is not positive")
    if not 1.0 / LARGEST_SCALE <= scale <= LARGEST_SCALE:
        raise LinkageError(
            f"scale {scale:g} is none that is built; choose one from {1.0 / LARGEST_SCALE:g} "
            f"to {LARGEST_SCALE:g}"
        )
    return scale


def _sides(arm: Arm) -> list[tuple[str, str, float]]:
    """List the quantities of an arm that a similar arm shares."""
    beam = arm.beam
    l, mass = beam.length, arm.tip_mass or beam.mass  # noqa: E741
    return [
        ("1", "tip mass × length", arm.tip_mass * l),
        ("6", "EI / length²", beam.bending / l**2),
        ("8", "EA", beam.axial),
        ("17", "ρA × length²", beam.line_mass * l**2),
        ("18", "E / (ρ × length²)", _quotient(beam.axial, beam.line_mass * l**2)),
        ("shear", "κGA", beam.shear),
        ("rotary inertia", "ρI", beam.rotary),
        ("tip inertia", "tip inertia / (mass × length²)", arm.tip_inertia / (mass * l**2)),
        ("tip radius", "tip radius / length", arm.tip_radius / l),
        ("hub radius", "hub radius / length", arm.hub_radius / l),
    ]


def _quotient(a: float, b: float) -> float:
    """Divide; infinity by zero."""
    return a / b if b > 0.0 else math.inf


def _condition(name: str, words: str, first: float, second: float) -> SimilarityCondition:
    """Compare the two sides of a condition."""
    if first == second:
        return SimilarityCondition(name, words, first, second, 0.0, True)
    finite = math.isfinite(first) and math.isfinite(second) and first != 0.0
    difference = second / first - 1.0 if finite else math.inf
    return SimilarityCondition(
        name, words, first, second, difference, abs(difference) < CONDITION_HOLDS
    )
