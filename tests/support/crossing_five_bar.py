"""The five-bar of J. J. de Jong's thesis, chapter 3 (Fuga I), from its table and closed forms.

Base pivots at (0, ∓0.2) m, upper arms 190 mm, lower arms 180 mm, both elbows on the side +x
(an M). Table 3.2: arms of 0.66 and 0.21 kg, lower arms of 1.66 g m² about their centres of
mass. The centres and moments of inertia of the upper arms follow from Eqs. 3.59 and 3.60, which
are written here by themselves: planar momenta of the lower arms, nothing of the package.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics import ScrewJoint, from_screws
from kinematics.model.linkage import Linkage

HALF_BASE, UPPER, LOWER = 0.2, 0.19, 0.18
UPPER_MASS, LOWER_MASS, LOWER_INERTIA = 0.66, 0.21, 1.66e-3


class FiveBar(NamedTuple):
    """A design, and its upper arms as the thesis describes them, left and right.

    Attributes:
        linkage: the linkage at the balanced pose.
        com: distance of each upper arm's centre of mass from its pivot, metres (2,).
        angle: from each arm to that centre, degrees (2,).
        inertia: moments of inertia about them, kg m² (2,).
    """

    linkage: Linkage
    com: np.ndarray
    angle: np.ndarray
    inertia: np.ndarray


def crossing_five_bar(x: float, distance: float, degrees: float) -> FiveBar:
    """Design the robot balanced with its end point at (x, 0), lower arms as given.

    Force balance asks for ``γ4 = π + γ2`` (Eq. 3.61), angles counted in one sense.

    Args:
        x: of the end point, metres; negative beyond the base line, seen from the elbows.
        distance: of the lower arms' centres of mass from their elbows, metres.
        degrees: γ2, from the left lower arm to its centre.
    """
    end, pivots = complex(x, 0.0), [complex(0.0, -HALF_BASE), complex(0.0, HALF_BASE)]
    elbows = [_elbow(pivots[0], end), _elbow(pivots[0], end).conjugate()]
    part = distance / LOWER * np.exp(1j * np.radians(degrees))
    lower = [o + sign * part * (end - o) for o, sign in zip(elbows, (1, -1), strict=True)]
    arms, inertias = zip(
        *(
            _upper_arm(pivots[k], elbows[k], elbows[1 - k], end, lower[k], lower[1 - k])
            for k in (0, 1)
        ),
        strict=True,
    )
    bodies = {}
    for k, side in enumerate(("left", "right")):
        for name, mass, c, g in (
            ("upper", UPPER_MASS, pivots[k] + arms[k], inertias[k]),
            ("lower", LOWER_MASS, lower[k], LOWER_INERTIA),
        ):
            bodies[f"{side}_{name}"] = (
                mass,
                (c.real, c.imag, 0.0),
                np.diag([0.4 * g, 0.7 * g, g]),
            )
    turn = [np.angle(arms[k] / (elbows[k] - pivots[k])) for k in (0, 1)]
    return FiveBar(
        _linkage([*pivots, *elbows, end], bodies),
        np.abs(arms),
        np.abs(np.degrees(turn)),
        np.array(inertias),
    )


def _upper_arm(
    pivot: complex, elbow: complex, other: complex, end: complex, near: complex, far: complex
) -> tuple[complex, float]:
    """Pivot to centre of mass, and moment of inertia, of the arm that balances its own input.

    Args:
        pivot: of the arm, which turns at a unit rate.
        elbow: at its end.
        other: the other elbow, at rest.
        end: where the lower arms meet.
        near: centre of mass of the lower arm at this elbow.
        far: that of the other one.
    """
    rate = 1j * (elbow - pivot)
    a, b = 1j * (end - elbow), -1j * (end - other)
    turns = np.linalg.solve([[a.real, b.real], [a.imag, b.imag]], [-rate.real, -rate.imag])
    moving = [
        (turns[0], near, rate + 1j * turns[0] * (near - elbow)),
        (turns[1], far, 1j * turns[1] * (far - other)),
    ]
    p = LOWER_MASS * sum(v for _, _, v in moving)
    moment = sum(
        LOWER_INERTIA * w + LOWER_MASS * (c.conjugate() * v).imag for w, c, v in moving
    )
    arm = 1j * p / UPPER_MASS  # Eq. 3.59: c1 = o1 + n × p / m1
    centre, speed = pivot + arm, 1j * arm
    return arm, float(-moment - UPPER_MASS * (centre.conjugate() * speed).imag)


def _linkage(points: list[complex], bodies: dict) -> Linkage:
    """The linkage with pivots, elbows and end point."""
    places = [(z.real, z.imag, 0.0) for z in points]
    joints = [
        ScrewJoint("u1", "base", "left_upper", point=places[0]),
        ScrewJoint("q2", "left_upper", "left_lower", point=places[2]),
        ScrewJoint("u3", "base", "right_upper", point=places[1]),
        ScrewJoint("q4", "right_upper", "right_lower", point=places[3]),
    ]
    loop = ScrewJoint("q5", "left_lower", "right_lower", point=places[4])
    return from_screws(joints, [loop], bodies, inputs=["u1", "u3"], name="crossing_five_bar")


def _elbow(pivot: complex, end: complex) -> complex:
    """The elbow on the side +x."""
    span = end - pivot
    d = abs(span)
    along = (UPPER**2 - LOWER**2 + d * d) / (2.0 * d)
    height = np.sqrt(UPPER**2 - along**2)
    points = [pivot + span / d * complex(along, sign * height) for sign in (1, -1)]
    return max(points, key=lambda z: z.real)


def end_points(linkage, q) -> np.ndarray:
    """End point (N, 2) at positions of all joints (N, n), by planar trigonometry."""
    names = [joint.name for joint in linkage.joints]
    points = {joint.name: complex(*joint.point[:2]) for joint in linkage.joints}
    u1, q2 = q[:, names.index("u1")], q[:, names.index("q2")]
    elbow = points["u1"] + np.exp(1j * u1) * (points["q2"] - points["u1"])
    last = next(joint for joint in linkage.joints if joint.in_loop)
    end = elbow + np.exp(1j * (u1 + q2)) * (complex(*last.point[:2]) - points["q2"])
    return np.column_stack([end.real, end.imag])
