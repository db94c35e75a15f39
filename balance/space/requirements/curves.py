"""Curved regions: poses of the inputs, and the directions in which they move there.

``input = expression`` of the others is a surface; its tangents come from the expression at a
complex step (W. Squire, G. Trapp, SIAM Review 40, 1998), without cancellation. A file of input
displacements is a path: a cubic spline through its rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import count
from typing import NamedTuple

import numpy as np

from balance.space.conditions.order_kernels import generic_directions
from balance.space.requirements.requirement import Requirement
from balance.support.csv_columns import read_columns, refuse_row
from balance.support.expressions import Expression, ExpressionError, read_expression
from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

# Step of the derivative: its square is far below round-off.
COMPLEX_STEP = 1e-100
# Functions that have no derivative at a complex step.
NOT_ANALYTIC = ("abs(", "atan2(", "hypot(", "max(", "min(")
# Largest displacement of the free inputs of a surface, radians and metres.
REACH = 0.7
# Most rows of a path that count.
MAX_SAMPLES = 48


class Place(NamedTuple):
    """A pose of a region, and how it may move there.

    Attributes:
        u: displacements of the inputs (w,), SI units.
        tangents: their rates for each freedom of the region (w, freedoms).
    """

    u: Array
    tangents: Array


def read_surface(requirement: Requirement, inputs: tuple[str, ...]) -> dict[str, Expression]:
    """Read the relations of a requirement as expressions of some inputs, one for each other.

    Raises:
        UsageError: a relation is none, or joins inputs that are given by others.
    """
    surface: dict[str, Expression] = {}
    for relation in requirement.relations:
        name, _, body = (part.strip() for part in relation.partition("="))
        try:
            expression = read_expression(body)
        except ExpressionError as error:
            raise _refusal(requirement, f"'{relation}': {error}") from None
        unknown = [word for word in (name, *expression.names) if word not in inputs]
        if unknown:
            names = ", ".join(inputs)
            raise _refusal(
                requirement,
                f"'{unknown[0][:40]}' is not an input{did_you_mean(unknown[0], inputs)}; "
                f"the inputs are {names}",
            )
        if any(function in body.replace(" ", "") for function in NOT_ANALYTIC):
            raise _refusal(requirement, f"'{relation}': use functions that are smooth")
        if name in surface:
            raise _refusal(requirement, f"input '{name}' is given twice")
        surface[name] = expression
    given = [name for item in surface.values() for name in item.names if name in surface]
    if given:
        raise _refusal(requirement, f"'{given[0]}' is given by others: write it with these")
    if len(surface) == len(inputs):
        raise _refusal(requirement, "no input is left to move")
    return surface


def places_on_surface(
    surface: Mapping[str, Expression], inputs: tuple[str, ...]
) -> Iterator[Place]:
    """Yield poses on a surface, in generic directions and at growing distances.

    Args:
        surface: an expression for each input that others give.
        inputs: names of all inputs.
    """
    free = [name for name in inputs if name not in surface]
    distances = REACH * (0.5 + 0.5 * np.cos(2.4 * np.arange(64.0)))
    for k in count():
        ray = generic_directions(k, k + 1, len(free))[0]
        y = float(distances[k % 64]) * ray * (1.0 if k % 2 else -1.0)
        yield _place(surface, inputs, free, y)


def _place(
    surface: Mapping[str, Expression], inputs: tuple[str, ...], free: list[str], y: Array
) -> Place:
    """Compute the pose and the tangents at displacements y of the free inputs."""
    u, tangents = np.zeros(len(inputs)), np.zeros((len(inputs), len(free)))
    steps = y + 1j * COMPLEX_STEP * np.eye(len(free))
    values = {name: steps[:, k] for k, name in enumerate(free)}
    for w, name in enumerate(inputs):
        if name in values:
            column = values[name]
        else:
            column = np.broadcast_to(surface[name](values), len(free)).astype(complex)
        u[w], tangents[w] = column[0].real, column.imag / COMPLEX_STEP
    return Place(u, tangents)


def places_on_path(requirement: Requirement, inputs: tuple[str, ...]) -> list[Place]:
    """Read a path, and give the poses of its rows and amid them, with its directions there.

    Raises:
        FileError: the file is no table of the inputs, or its rows are all the same.
    """
    from scipy.interpolate import CubicSpline

    rows = read_columns(requirement.path, inputs, 2)
    steps = np.linalg.norm(np.diff(rows, axis=0), axis=1)
    rows = np.concatenate([rows[:1], rows[1:][steps > 0.0]])
    if len(rows) < 2:
        raise refuse_row(requirement.path, "", "all samples are the same pose")
    s = np.concatenate([[0.0], np.cumsum(steps[steps > 0.0])])
    spline = CubicSpline(s, rows)
    at = np.sort(np.concatenate([s, 0.5 * (s[1:] + s[:-1])]))
    if at.size > MAX_SAMPLES:
        at = at[np.linspace(0, at.size - 1, MAX_SAMPLES).astype(int)]
    return [Place(spline(x), spline(x, 1)[:, None]) for x in at]


def _refusal(requirement: Requirement, problem: str) -> UsageError:
    """Build the exception for a requirement that cannot be used."""
    return UsageError(f"requirement '{requirement.text}': {problem}")
