"""The size and the direction of a dyad for the least matter.

Known geometries of dyads keep their relations between angles at every size and direction, in
which the least matter is not convex. Directions are tried all around at the largest size, and
the best ones are followed to the least between their neighbours (Brent's method). If a smaller
dyad takes less there, its size is sought in the same way, and its direction again. Of a size at
a bound, one beyond it is tried.

Source:
    R. P. Brent, Algorithms for Minimization without Derivatives, 1973.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import degrees, isfinite, pi, radians
from typing import NamedTuple

from balance.masses.remedies.dyads.known_dyads import DyadSeed
from balance.masses.remedies.size_search import NO_MATTER, lightest_between
from balance.support.tolerances import MASSES_EQUAL
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

# Least and largest size of a dyad, over that of the loop or of the hinges that it is built on.
LEAST, LARGEST = 0.25, 1.0
# Smaller size that is tried at the best direction.
SMALLER = 0.9
# How far beyond a bound a size is tried, to say whether it would take less.
BEYOND = 1.1
NOT_SOUGHT = "not sought"
# What is said of a size that was sought for point masses, where matter has a density.
AS_POINTS = " as point masses"
# Directions that are tried at the largest size, and those of them that are followed.
DIRECTIONS, FOLLOWED = 8, 2
# Where the search for a direction ends, degrees; its result is of whole degrees.
FINE = 0.25


class SizedDyad(NamedTuple):
    """A dyad of a size and a direction.

    Attributes:
        seed: the dyad.
        turn: its direction, against that of the geometry to begin with, radians.
        mass: matter that it takes, kg.
        beyond: what sizes beyond the bound take, if its size is one.
    """

    seed: DyadSeed
    turn: float
    mass: float
    beyond: str


def size_words(seed: DyadSeed, beyond: str = NOT_SOUGHT) -> str:
    """Say what a dyad is, and its size, with a bound where it lies at one.

    Args:
        beyond: what is known of sizes beyond the bound.
    """
    if seed.size is None:
        return seed.words
    bound = f" (a bound: {beyond})" * (not LEAST < seed.size < LARGEST)
    size = "as large" if seed.size == 1.0 else f"{number_text(seed.size, '.3g')} times as large"
    return f"{seed.words}, {size}{bound}"


def turn_words(turn: float) -> str:
    """Say by how many degrees a dyad is turned, above -180 and up to 180."""
    return f"turned by {180 - (180 - round(degrees(turn))) % 360}°"


def best_size(
    seed: DyadSeed, mass_of: Callable[[DyadSeed], float], first: float = 0.0
) -> SizedDyad | None:
    """Search for the size and the direction of a dyad that take the least matter.

    Args:
        seed: a known geometry.
        mass_of: computes the least matter with a dyad, kg; infinite if none balances.
        first: direction to begin with, radians.

    Returns:
        The best one; None if no matter balances the linkage with any that was tried.
    """
    search = _Search(seed, mass_of)
    step = 2.0 * pi / DIRECTIONS
    turns = [first + k * step for k in range(DIRECTIONS)]
    masses = [search.mass(LARGEST, turn) for turn in turns]
    if not any(map(isfinite, masses)):
        return None
    for k in rank_least_first(masses, relative=MASSES_EQUAL)[:FOLLOWED]:
        turn = search.best_turn(LARGEST, turns[k], step)
        if search.mass(SMALLER * LARGEST, turn) < search.mass(LARGEST, turn):
            size = lightest_between(partial(search.mass, turn=turn), LEAST, LARGEST)
            search.best_turn(size, turn, step)
    return search.best


class _Search:
    """Masses of one geometry, each computed once, and the least of them."""

    def __init__(self, seed: DyadSeed, mass_of: Callable[[DyadSeed], float]) -> None:
        """Start without masses."""
        self._seed, self._mass_of = seed, mass_of
        self._masses: dict[tuple[float, float], float] = {}
        self._ends: list[tuple[float, float]] = []

    def _resized(self, size: float, turn: float) -> DyadSeed:
        assert self._seed.size is not None, "a known geometry has a size"
        return self._seed.resized(size / self._seed.size, turn)

    def mass(self, size: float, turn: float) -> float:
        """Compute the mass at a size and a direction; infinite if no matter balances."""
        if (size, turn) not in self._masses:
            self._masses[size, turn] = self._mass_of(self._resized(size, turn))
        return self._masses[size, turn]

    def _finite(self, size: float, turn: float) -> float:
        mass = self.mass(size, turn)
        if isfinite(mass):
            return mass
        return NO_MATTER * max(filter(isfinite, self._masses.values()), default=1.0)

    def best_turn(self, size: float, turn: float, step: float) -> float:
        """Follow the mass to its least within a step of a direction, in whole degrees."""
        from scipy.optimize import minimize_scalar

        ends = turn - step, turn + step
        solved = minimize_scalar(
            lambda at: self._finite(size, at),
            bounds=ends,
            method="bounded",
            options={"xatol": radians(FINE)},
        )
        rounded = radians(round(degrees(float(solved.x))))
        better = self.mass(size, rounded) <= self.mass(size, turn)
        self._ends.append((size, rounded if better else turn))
        return self._ends[-1][1]

    @property
    def best(self) -> SizedDyad:
        """The least mass of where the search for a direction ended."""
        masses = [self.mass(*end) for end in self._ends]
        k = rank_least_first(masses, relative=MASSES_EQUAL)[0]
        size, turn = self._ends[k]
        return SizedDyad(self._resized(size, turn), turn, masses[k], self._beyond(size, turn))

    def _beyond(self, size: float, turn: float) -> str:
        """Say what sizes beyond the bound take; empty if the size is not at one."""
        if LEAST < size < LARGEST:
            return ""
        which, factor = ("larger", BEYOND) if size >= LARGEST else ("smaller", 1.0 / BEYOND)
        mass = self.mass(size, turn)
        less = mass - self.mass(factor * size, turn) > MASSES_EQUAL * mass
        return f"{which} ones take {'less mass' if less else 'no less'}"
