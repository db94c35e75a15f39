"""The parameters that conditions are solved for: those asked for, or those of the shortest."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations, islice

from balance.space.formulas.geometry_samples import ConditionSamples
from balance.space.formulas.interpolation import Interpolation
from balance.space.formulas.parameters import (
    SPATIAL_MOMENTS,
    SPATIAL_SECOND_MOMENTS,
    Parameter,
)
from kinematics.errors import ExactError
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS

MAX_SOLVED_CHOICES = 300
"""Most choices of solved parameters that are compared."""
# Orders of kinds in which columns are tried.
MOMENTS_FIRST = (*SPATIAL_MOMENTS, *SPATIAL_SECOND_MOMENTS)
SECOND_MOMENTS_FIRST = (*SPATIAL_SECOND_MOMENTS, *SPATIAL_MOMENTS)
AXES_LAST = ("sx", "sy", "Jzz", "Jxy", "Jxz", "Jyz", "Jxx", "sz", "Jyy")
# Weight of a degree in a denominator.
DIVISION = 4
# Degree of an entry whose degree lines do not show.
UNKNOWN_DEGREE = 100


def choose_solved(
    samples: ConditionSamples,
    parameters: Sequence[Parameter],
    names: Sequence[str],
    planar: bool,
) -> list[int]:
    """Choose the columns to solve for.

    Args:
        samples: conditions.
        parameters: of the columns.
        names: of those that are asked for.
        planar: whether choices are compared by their terms alone, not by degrees too.

    Raises:
        ExactError: a name is none, or the conditions cannot be solved for all of them.
    """
    by_name = {parameter.name: i for i, parameter in enumerate(parameters)}
    for name in names:
        if name not in by_name:
            raise ExactError(f"no parameter '{name}': there are {', '.join(by_name)}")
    asked = [by_name[name] for name in names]
    others = [i for i in range(len(parameters)) if i not in asked]
    first = samples.pivots_for([*asked, *others])
    if missing := [parameters[i].name for i in asked if i not in first]:
        raise ExactError(f"the conditions cannot be solved for {', '.join(missing)} as well")
    if asked:
        return first
    if not planar:
        return _of_least_degrees(samples, parameters)
    moments = [i for i, parameter in enumerate(parameters) if not parameter.is_mass]
    if len(first) > len(moments):
        return first
    choices = [tuple(first), *islice(combinations(moments, len(first)), MAX_SOLVED_CHOICES)]
    counted = ((samples.count_terms(choice), choice) for choice in choices)
    fewest = min((count, choice) for count, choice in counted if count is not None)
    return list(fewest[1])


def _of_least_degrees(samples: ConditionSamples, parameters: Sequence[Parameter]) -> list[int]:
    """Compare several orders of columns: the sum of all degrees and of the terms counts."""
    best: tuple[int, list[int]] | None = None
    tried = set()
    for order in _orders(parameters):
        solved = sorted(samples.pivots_for(order))
        if tuple(solved) in tried:
            continue
        tried.add(tuple(solved))
        samples.solve_for(solved)
        interpolation = interpolation_of(samples)
        degrees = interpolation.degrees(range(len(samples.entries)))
        size = 0
        for e, each in degrees.items():
            if each is None:
                size += UNKNOWN_DEGREE
            else:
                size += 1 + sum(n for n, _ in each.single)
                size += DIVISION * interpolation.divides_by(e, each)
        if best is None or size < best[0]:
            best = size, solved
    assert best is not None
    return best[1]


def _orders(parameters: Sequence[Parameter]) -> Iterator[list[int]]:
    """List orders of columns: by bodies, by kinds, masses last; bodies from either end.

    The last orders leave sz and Jyy open: of a chain with revolute joints, what is along an
    axis is free, and so is one of the moments across it.
    """
    columns = range(len(parameters))

    def key(rank: Sequence[str], by_body: bool, sign: int, i: int) -> tuple[float, ...]:
        kind, body = parameters[i].kind, sign * parameters[i].body
        place = float(rank.index(kind)) if kind in rank else len(rank) + 0.0
        group = (kind == "m") + 0.0
        if by_body:
            return group, place > 2.0, body, place
        return group, place, body

    for rank in (MOMENTS_FIRST, SECOND_MOMENTS_FIRST, AXES_LAST):
        for by_body in (False, True):
            for sign in (1, -1):
                yield sorted(columns, key=partial(key, rank, by_body, sign))


def interpolation_of(samples: ConditionSamples, most_unknowns: int = 0) -> Interpolation:
    """Prepare the interpolation of the entries of conditions; points are always the same."""
    rng, p = random.Random(7), PRIMES_OF_61_BITS[0]
    free = samples.free
    return Interpolation(
        samples.values, free.angles, lambda: free.draw(p, rng), p, most_unknowns
    )
