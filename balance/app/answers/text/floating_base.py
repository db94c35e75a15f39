"""Text of a simulation on a base that floats, for ``balance verify --base``.

`FloatingBaseMotion.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, Facts
from balance.motion.floating_base.floating_base_motion import FloatingBaseMotion, drift_text
from balance.motion.motion_tolerances import INTEGRAL_DETERMINED
from kinematics.numerics.array_types import Array
from kinematics.wording import first_names, number_text, size_text, vector_text


def floating_base_facts(motion: FloatingBaseMotion) -> list[tuple[str, str]]:
    """List the facts on a simulation as pairs of label and value."""
    of = motion.samples
    space = "planar" if motion.planar else "spatial"
    steps, fastest = motion.time.size - 1, float(of.speed.max())
    return [
        ("linkage", f"{motion.model}, on a {space} base"),
        ("file", motion.linkage.source),
        *([("pose", motion.linkage.pose)] if motion.linkage.at else []),
        *_base_facts(motion),
        ("inputs", _inputs_text(motion)),
        *([("at the start", _values_text(motion.initial))] if motion.initial else []),
        ("duration", f"{motion.duration:.4g} s, {steps} steps"),
        ("base turns", f"{motion.rotation_text}, at most {_speed(of.turning, fastest)} rad/s"),
        (
            "base moves",
            f"{motion.displacement_text}, at most "
            f"{_speed(of.velocity, fastest * motion.length)} m/s",
        ),
        (
            "at the end",
            f"{_vector(of.turning[-1], fastest)} rad/s, "
            f"{_vector(of.velocity[-1], fastest * motion.length)} m/s",
        ),
        (
            "drift",
            f"energy {drift_text(motion.energy_drift)}, momentum "
            f"{drift_text(motion.momentum_drift)}, of their peaks",
        ),
        *(("note", remark) for remark in motion.remarks),
        (
            "verdict",
            f"{motion.verdict} (residual {drift_text(motion.residual)}, tolerance "
            f"{motion.tolerance:.1e})",
        ),
    ]


def _base_facts(motion: FloatingBaseMotion) -> list[tuple[str, str]]:
    """List the facts on the base and its springs."""
    base = motion.base
    elements: tuple[float, ...] = (*base.moments, *base.products)
    if not any(base.products):
        elements = base.moments if len(set(base.moments)) > 1 else base.moments[:1]
    moments = ", ".join(map(number_text, elements))
    facts = [
        (
            "base",
            f"{number_text(base.mass)} kg, {moments} kg m² about {vector_text(base.com)} m",
        )
    ]
    if not base.on_springs:
        return facts
    springs = [(base.turning_stiffness, "N m/rad"), (base.stiffness, "N/m")]
    words = [f"{number_text(stiffness)} {unit}" for stiffness, unit in springs if stiffness]
    tones = ", ".join(number_text(frequency) for frequency in motion.frequencies)
    return [
        *facts,
        ("springs", ", ".join(words)),
        ("frequencies", f"{tones} Hz, inputs held at the start"),
    ]


def _inputs_text(motion: FloatingBaseMotion) -> str:
    """Describe how the inputs move."""
    names = first_names(motion.linkage.inputs)
    if motion.torques is None:
        return f"{names}, prescribed"
    given = _values_text({name: torque for name, torque in motion.torques.items() if torque})
    return f"{names}, free, " + (f"torques {given}" if given else "without torques")


def _values_text(values: Mapping[str, float]) -> str:
    """Write values by name."""
    return ", ".join(f"{name} = {number_text(value, '.6g')}" for name, value in values.items())


def _speed(vectors: Array, fastest: float) -> str:
    """Write the largest size of vectors (N, 3), beside that of the bodies on the base."""
    largest = float(np.linalg.norm(vectors, axis=1).max())
    return size_text(largest, ".3g", fastest, INTEGRAL_DETERMINED)


def _vector(vector: Array, fastest: float) -> str:
    """Write a vector (3,), beside the largest size of that of the bodies on the base."""
    texts = (number_text(x, ".6g", fastest, INTEGRAL_DETERMINED) for x in vector.tolist())
    return f"({', '.join(texts)})"


def floating_base_body(results: Sequence[FloatingBaseMotion]) -> AnswerBody:
    """Build what is printed on simulations, one below the other."""
    body: list[AnswerPart] = []
    for each in results:
        body += ["", Facts(floating_base_facts(each), least=15)]
    return body[1:]
