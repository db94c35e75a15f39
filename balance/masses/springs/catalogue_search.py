"""Every choice of springs of a catalogue: those that balance, or leave the least torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.springs.attached_springs import AttachedSpring
from balance.masses.springs.both_ends import balance_springs, least_springs
from balance.masses.springs.spring_catalogue import Choice, used_in
from balance.masses.springs.spring_cone import SpringCone
from balance.masses.springs.spring_problem import SpringProblem
from balance.masses.springs.spring_text import SpringRange
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import rank_least_first

# Torque over that of gravity by which a bound may exceed the least for a choice to be tried.
BESIDE = 1e-6
# Pivot over the largest above which points are the only ones that leave their torque.
UNIQUE = 1e-9


class SpringSet(NamedTuple):
    """Springs that are attached together.

    Attributes:
        used: their indices.
        x: their unknowns.
        entries: for all springs, those of a catalogue; empty without one.
    """

    used: tuple[int, ...]
    x: Array
    entries: Choice = ()


class _CatalogueSprings(NamedTuple):
    """The springs of a choice from a catalogue.

    Attributes:
        used: their indices.
        springs: the springs, of the free lengths of the choice.
        ranges: their stiffnesses.
        rows: conditions, or torques, on their unknowns.
        spread: from these unknowns to those for any free length.
    """

    used: tuple[int, ...]
    springs: list[AttachedSpring]
    ranges: list[SpringRange]
    rows: Array
    spread: Array


def _catalogue_springs(
    problem: SpringProblem, rows: Array, cone: SpringCone, choice: Choice
) -> _CatalogueSprings:
    """Take the springs of a choice, and the columns of their unknowns."""
    used = used_in(choice)
    entries = [entry for entry in choice if entry is not None]
    pairs = [
        problem.springs[k].with_length(entry.free_length / problem.length)
        for k, entry in zip(used, entries, strict=True)
    ]
    columns = cone.columns_of(used)
    T = np.eye(len(columns))
    if any(problem.springs[k].any_length for k in used):
        from scipy.linalg import block_diag

        T = block_diag(*(matrix for _, matrix in pairs))
    few = np.column_stack([rows[:, columns] @ T, rows[:, -1]])
    ranges = [(entry.stiffness, entry.stiffness) for entry in entries]
    return _CatalogueSprings(used, [spring for spring, _ in pairs], ranges, few, T)


def balanced_of_catalogue(
    problem: SpringProblem, rows: Array, choices: Sequence[Choice]
) -> tuple[list[SpringSet], bool]:
    """Find the choices from a catalogue with the fewest springs that balance.

    None is tried that leaves torque, or that balances with points out of their ranges alone.

    Args:
        rows: the conditions of balance.

    Returns:
        The choices; and whether fewer springs, or all, are excluded.
    """
    balanced: list[SpringSet] = []
    sure, cone = True, problem.cone
    limit = BESIDE * float(np.linalg.norm(problem.torque_triangle[:, -1]))
    bounds, inside = _lower_bounds(problem, choices)
    for choice, possible in zip(choices, inside & (bounds <= limit), strict=True):
        used = used_in(choice)
        if balanced and len(used) > len(balanced[0].used):
            break
        if used and possible:
            part = _catalogue_springs(problem, rows, cone, choice)
            x, known = balance_springs(part.rows, part.springs, part.ranges, problem.unit)
            balanced += [] if x is None else [SpringSet(used, part.spread @ x, choice)]
            sure = sure and known
    return balanced, sure


def least_of_catalogue(problem: SpringProblem, choices: Sequence[Choice]) -> SpringSet:
    """Find the choice from a catalogue that leaves the least torque.

    Choices are tried in the order of their bounds, as long as these are below the least found.
    """
    rows, cone = problem.torque_triangle, problem.cone
    bounds, _ = _lower_bounds(problem, choices)
    size = float(np.linalg.norm(rows[:, -1]))
    tried: dict[int, tuple[SpringSet, float]] = {}
    least = np.inf
    for n in np.argsort(bounds, kind="stable").tolist():
        if bounds[n] > least + BESIDE * size:
            break
        part, x = _catalogue_springs(problem, rows, cone, choices[n]), np.empty(0)
        if part.used:
            x = least_springs(part.rows, part.springs, part.ranges, problem.unit)
        torque = float(np.linalg.norm(part.rows @ np.append(x, 1.0)))
        tried[n] = SpringSet(part.used, part.spread @ x, choices[n]), torque
        least = min(least, torque)
    numbers = sorted(tried)
    ranked = rank_least_first([tried[n][1] for n in numbers], size)
    return tried[numbers[ranked[0]]][0]


def _lower_bounds(problem: SpringProblem, choices: Sequence[Choice]) -> tuple[Array, Flags]:
    """Bound the torques that choices leave from below: by points without limits.

    Returns:
        The bounds (choices,), and whether the points that reach them may be in their ranges.
    """
    rows = problem.torque_triangle
    by_used: dict[tuple[int, ...], list[int]] = {}
    for n, choice in enumerate(choices):
        by_used.setdefault(used_in(choice), []).append(n)
    bounds, inside = np.empty(len(choices)), np.ones(len(choices), bool)
    for used, numbers in by_used.items():
        given, limits, free = _given_unknowns(problem, used, [choices[n] for n in numbers])
        torques = rows @ given
        Q, R = np.linalg.qr(rows[:, free])
        moved = Q.T @ torques
        bounds[numbers] = np.linalg.norm(torques - Q @ moved, axis=0)
        sizes = np.abs(np.diag(R))
        unique = sizes.size == len(free) and sizes.min(initial=1.0) > UNIQUE * sizes.max(
            initial=0.0
        )
        if unique and not any(problem.springs[k].paired for k in used):
            points = np.abs(np.linalg.solve(R, moved))
            inside[numbers] = (points <= (1.0 + BESIDE) * limits).all(axis=0)
    return bounds, inside


def _given_unknowns(
    problem: SpringProblem, used: Sequence[int], choices: Sequence[Choice]
) -> tuple[Array, Array, list[int]]:
    """Read the unknowns that choices of the same springs give.

    Returns:
        These, and 1 for gravity (unknowns + 1, choices); the limits of the others (free,
        choices), and their numbers.
    """
    given = np.zeros((problem.torque_triangle.shape[1], len(choices)))
    given[-1] = 1.0
    limits, free = [np.empty((0, len(choices)))], list[int]()
    for k in used:
        spring, start = problem.springs[k], problem.cone.starts[k]
        entries = [entry for choice in choices if (entry := choice[k]) is not None]
        given[start] = [entry.stiffness / problem.unit for entry in entries]
        if spring.any_length:
            lengths = [entry.free_length / problem.length for entry in entries]
            given[start + 1] = [spring.with_length(length)[1][1, 0] for length in lengths]
            given[start + 1] *= given[start]
            continue
        numbers = range(start + 1, start + spring.columns)
        free += numbers
        limits.append(np.tile(given[start], (len(numbers), 1)))
    return given, np.concatenate(limits), free
