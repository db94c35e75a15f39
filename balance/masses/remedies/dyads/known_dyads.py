"""Known geometries of dyads between two links of a planar linkage.

In a loop of four hinges J, K, M, L with K on link x and L on link y, which are hinged to each
other at J, write the plane as complex numbers. These dyads on x and y have a relation between
angles for every size and direction c of the dyad:

    reflected     f(s) = J + c conj(s - J):  hinges f(L) on x, f(K) on y, f(M) between.
                  The loop is repeated, reflected, with the parts of x and y exchanged.
    parallelogram the same with f(K) + f(L) - f(M) between.
    kite          f(s) = J + c (s - J):  hinges f(K), f(L), and f(J) reflected in their line.
    antiparallelogram  the same, reflected in the perpendicular bisector of f(K) f(L).
    crank-slider  hinge f(K), and a slide on a line through J that is fixed in y; the hinge
                  between is as far from f(K) as J is.

The first two make two relations in every loop of four hinges: against x, y turns by the sum of
the angles of LM and of the link of the dyad that repeats it, and by the sum of those of KM and
of its own. For the diagonals, D = L - K and D' of the repeated loop, have, seen from x,
``D' ~ e_y D̄`` with the direction e_y of y, and two triangles with sides in one ratio are
alike. The last three make a balanced loop of their own, and need no loop in the linkage.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from balance.masses.remedies.dyads.dyad_geometry import Dyad, DyadSide, segments_of
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array

# Shortest link of a dyad, in characteristic lengths.
SHORTEST = 0.05
# Known geometries of each kind that a remedy tries, unless it is named.
GEOMETRIES = 12


@dataclass(frozen=True)
class _Hinge:
    """A hinge of a planar linkage.

    Attributes:
        links: the two rigid bodies; -1 is the ground.
        point: in the plane of the chain, chain units, as a complex number.
    """

    links: tuple[int, int]
    point: complex

    def other(self, link: int) -> int:
        """Return the rigid body on the other side."""
        return self.links[1] if self.links[0] == link else self.links[0]


@dataclass(frozen=True, eq=False)
class DyadSeed:
    """A geometry of a dyad to begin with.

    Attributes:
        dyad: the dyad.
        numbers: its numbers; see `balance.masses.remedies.dyads.dyad_geometry`.
        words: what it is.
        size: its size over that of the loop that it repeats, or of the triangle of hinges that
            it is built on; None for geometries that a search led to.
        centre: the hinge about which it may be larger, smaller and turned.
    """

    dyad: Dyad
    numbers: Array
    words: str
    size: float | None = None
    centre: complex = 0.0

    def __repr__(self) -> str:
        """One line: what it is, and the links."""
        return f"DyadSeed: {self.words}, {self.dyad!r}"

    def resized(self, factor: float, turn: float = 0.0) -> DyadSeed:
        """Return the dyad larger by a factor and turned by an angle about its centre."""
        count = 4 if self.dyad.slides else 6
        arms = self.numbers[:count].reshape(-1, 2) @ [1.0, 1.0j] - self.centre
        points = self.centre + factor * np.exp(1j * turn) * arms
        numbers = np.concatenate([_numbers(*points), self.numbers[count:] + turn])
        size = None if self.size is None else factor * self.size
        return replace(self, numbers=numbers, size=size)


def hinges_of(linkage: Linkage) -> list[_Hinge]:
    """List the hinges of a planar linkage."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    frame = linkage.chain.frame
    hinges = []
    for j, joint in enumerate(linkage.joints):
        if joint.kind != "revolute" or joint.name in linkage.idle:
            continue
        x, y = (frame.R[:2] @ (joint.point - frame.origin)) / frame.length
        links = welded.get(joint.parent, joint.parent), welded.get(j, j)
        hinges.append(_Hinge(links, complex(x, y)))
    return hinges


def sides_of(linkage: Linkage) -> dict[int, DyadSide]:
    """Name a link of each rigid body to which a dyad can be attached.

    Returns:
        By number of the rigid body; -1 is the ground. Links of bodies come first.
    """
    bodies = {body.name for body in linkage.bodies}
    order = sorted(linkage.places, key=lambda name: name not in bodies)
    sides: dict[int, DyadSide] = {}
    for name in order:
        place = linkage.places[name]
        sides.setdefault(place.link, DyadSide(name, place.link, place.pose))
    return sides


def dyad_seeds(linkage: Linkage) -> Iterator[DyadSeed]:
    """Yield known geometries of dyads, those that repeat a loop first."""
    hinges, sides = hinges_of(linkage), sides_of(linkage)
    for make in (_repeats, _loops_of_their_own):
        for seed in make(hinges, sides):
            if segments_of(seed.dyad, seed.numbers).min() >= SHORTEST:
                yield seed


def _repeats(hinges: list[_Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
    """Yield dyads that repeat a loop of four hinges, reflected; those on the ground first."""
    corners = [corner for corner in permutations(hinges, 4) if _is_loop(*corner)]
    corners.sort(key=lambda corner: GROUND not in corner[0].links)
    for centre, first, middle, last in corners:
        x, y = first.links[_common(centre, first)], last.links[_common(centre, last)]
        if x > y or x not in sides or y not in sides:
            continue
        J = centre.point
        K, L, M = (J + (hinge.point - J).conjugate() for hinge in (first, last, middle))
        dyad = Dyad((sides[x], sides[y]), False)
        for between, words in ((M, "the loop repeated"), (K + L - M, "its parallelogram")):
            numbers = _numbers(L, between, K)
            yield DyadSeed(dyad, numbers, f"{words}, reflected", 1.0, J)


def _is_loop(centre: _Hinge, first: _Hinge, middle: _Hinge, last: _Hinge) -> bool:
    """Whether four hinges make a loop of four rigid bodies, in this order."""
    pairs = ((centre, first), (first, middle), (middle, last), (last, centre))
    shared = [set(hinge.links) & set(other.links) for hinge, other in pairs]
    return all(len(links) == 1 for links in shared) and len(set().union(*shared)) == 4


def _common(centre: _Hinge, other: _Hinge) -> int:
    """Return which link of a hinge is also one of the centre: 0 or 1."""
    return int(other.links[1] in centre.links)


def _loops_of_their_own(hinges: list[_Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
    """Yield kites, antiparallelograms, and crank-sliders of equal lengths."""
    for centre, first, last in permutations(hinges, 3):
        x = first.links[_common(centre, first)]
        y = last.links[_common(centre, last)]
        if {x, y} != set(centre.links) or x == y or x not in sides or y not in sides:
            continue
        J, K, L = centre.point, first.point, last.point
        if abs(K - L) == 0.0 or abs(K - J) == 0.0 or abs(L - J) == 0.0:
            continue
        along = (L - K) / abs(L - K)
        both = Dyad((sides[x], sides[y]), False)
        kite = K + along * ((J - K) / along).conjugate()
        if x < y:
            yield DyadSeed(both, _numbers(K, kite, L), "a kite", 1.0, J)
            crossed = _numbers(K, K + L - kite, L)
            yield DyadSeed(both, crossed, "an antiparallelogram", 1.0, J)
        line = (L - J) / abs(L - J)
        far = J + 2.0 * line * ((K - J) * line.conjugate()).real
        slide = np.array([K.real, K.imag, far.real, far.imag, np.angle(line)])
        slider = Dyad((sides[x], sides[y]), True)
        yield DyadSeed(slider, slide, "a crank-slider of equal lengths", 1.0, J)


def _numbers(*points: complex) -> Array:
    """Write points as numbers of a dyad."""
    return np.array([[point.real, point.imag] for point in points]).ravel()
