"""Text of a simulation on a base that floats, for ``balance verify --base``.

`FloatingBaseMotion.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from balance.floating_base.result import FloatingBaseMotion
from kinematics.wording import first_names, vector_text

__all__ = ["floating_base_facts", "floating_base_text"]

Array = NDArray[np.float64]


def floating_base_facts(found: FloatingBaseMotion) -> list[tuple[str, str]]:
    """List the facts on a simulation as pairs of label and value."""
    of = found.samples
    space = "planar" if found.planar else "spatial"
    steps = found.time.size - 1
    return [
        ("linkage", f"{found.model}, on a {space} base"),
        ("file", found.linkage.source),
        *([("pose", found.linkage.pose)] if found.linkage.at else []),
        *_base_facts(found),
        ("inputs", _inputs_text(found)),
        *([("at the start", _values_text(found.initial))] if found.initial else []),
        ("duration", f"{found.duration:.4g} s, {steps} steps"),
        ("base turns", f"{found.rotation:.3g} rad, at most {_speed(of.turning)} rad/s"),
        ("base moves", f"{found.displacement:.3g} m, at most {_speed(of.velocity)} m/s"),
        ("at the end", f"{_vector(of.turning[-1])} rad/s, {_vector(of.velocity[-1])} m/s"),
        ("drift", f"energy {found.energy_drift:.1e}, momentum {found.momentum_drift:.1e}, "
                  "of their peaks"),
        *(("note", remark) for remark in found.remarks),
        ("verdict", f"{found.verdict} (residual {found.residual:.1e}, tolerance "
                    f"{found.tolerance:.1e})"),
    ]  # fmt: skip


def _base_facts(found: FloatingBaseMotion) -> list[tuple[str, str]]:
    """List the facts on the base and its springs."""
    base = found.base
    moments = ", ".join(f"{moment:.4g}" for moment in dict.fromkeys(base.moments))
    facts = [("base", f"{base.mass:.4g} kg, {moments} kg m² about {vector_text(base.com)} m")]
    if not base.on_springs:
        return facts
    springs = [(base.turning_stiffness, "N m/rad"), (base.stiffness, "N/m")]
    words = [f"{stiffness:.4g} {unit}" for stiffness, unit in springs if stiffness]
    tones = ", ".join(f"{frequency:.4g}" for frequency in found.frequencies)
    return [
        *facts, ("springs", ", ".join(words)),
        ("frequencies", f"{tones} Hz, inputs held at the start"),
    ]  # fmt: skip


def _inputs_text(found: FloatingBaseMotion) -> str:
    """Describe how the inputs move."""
    names = first_names(found.linkage.inputs)
    if found.torques is None:
        return f"{names}, prescribed"
    given = _values_text({name: torque for name, torque in found.torques.items() if torque})
    return f"{names}, free, " + (f"torques {given}" if given else "without torques")


def _values_text(values: Mapping[str, float]) -> str:
    """Write values by name."""
    return ", ".join(f"{name} = {value:.6g}" for name, value in values.items())


def _speed(vectors: Array) -> str:
    """Write the largest size of vectors (N, 3)."""
    return f"{np.linalg.norm(vectors, axis=1).max():.3g}"


def _vector(vector: Array) -> str:
    """Write a vector (3,)."""
    return f"({', '.join(f'{x + 0.0:.6g}' for x in vector)})"


def floating_base_text(
    first: FloatingBaseMotion, second: FloatingBaseMotion | None = None
) -> str:
    """Write simulations as plain text.

    Args:
        first: a simulation.
        second: that of a second linkage, which follows; None without it.
    """
    return "\n\n".join(
        "\n".join(f"{label:<15} {value}" for label, value in floating_base_facts(one))
        for one in (first, second)
        if one is not None
    )
