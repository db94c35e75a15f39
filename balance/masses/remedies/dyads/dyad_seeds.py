"""Geometries of dyads that are known to make loops whose angles are related.

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
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from balance.masses.remedies.dyads.dyad_geometry import Dyad, DyadSide, segments_of
from kinematics.model.linkage import GROUND, Linkage

Array = NDArray[np.float64]

# Size of a dyad over that of the loop that it repeats.
SIZE = 0.5
# Shortest link of a dyad, in characteristic lengths.
SHORTEST = 0.05


@dataclass(frozen=True)
class Hinge:
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
    """

    dyad: Dyad
    numbers: Array
    words: str

    def __repr__(self) -> str:
        """One line: what it is, and the links."""
        return f"DyadSeed: {self.words}, {self.dyad!r}"


def hinges_of(linkage: Linkage) -> list[Hinge]:
    """List the hinges of a planar linkage."""
    welded = {loop.end: loop.successor for loop in linkage.loops}
    frame = linkage.chain.frame
    hinges = []
    for j, joint in enumerate(linkage.joints):
        if joint.kind != "revolute" or joint.name in linkage.idle:
            continue
        x, y = (frame.R[:2] @ (joint.point - frame.origin)) / frame.length
        links = welded.get(joint.parent, joint.parent), welded.get(j, j)
        hinges.append(Hinge(links, complex(x, y)))
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


def _repeats(hinges: list[Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
    """Yield dyads that repeat a loop of four hinges, reflected; those on the ground first."""
    corners = [corner for corner in permutations(hinges, 4) if _is_loop(*corner)]
    corners.sort(key=lambda corner: GROUND not in corner[0].links)
    for centre, first, middle, last in corners:
        x, y = first.links[_common(centre, first)], last.links[_common(centre, last)]
        if x > y or x not in sides or y not in sides:
            continue
        J = centre.point
        K, L, M = (J + SIZE * (hinge.point - J).conjugate() for hinge in (first, last, middle))
        dyad = Dyad((sides[x], sides[y]), False)
        yield DyadSeed(dyad, _numbers(L, M, K), "the loop repeated, reflected")
        yield DyadSeed(dyad, _numbers(L, K + L - M, K), "its parallelogram, reflected")


def _is_loop(centre: Hinge, first: Hinge, middle: Hinge, last: Hinge) -> bool:
    """Whether four hinges make a loop of four rigid bodies, in this order."""
    pairs = ((centre, first), (first, middle), (middle, last), (last, centre))
    shared = [set(hinge.links) & set(other.links) for hinge, other in pairs]
    return all(len(links) == 1 for links in shared) and len(set().union(*shared)) == 4


def _common(centre: Hinge, other: Hinge) -> int:
    """Return which link of a hinge is also one of the centre: 0 or 1."""
    return int(other.links[1] in centre.links)


def _loops_of_their_own(hinges: list[Hinge], sides: dict[int, DyadSide]) -> Iterator[DyadSeed]:
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
            yield DyadSeed(both, _numbers(K, kite, L), "a kite")
            yield DyadSeed(both, _numbers(K, K + L - kite, L), "an antiparallelogram")
        line = (L - J) / abs(L - J)
        far = J + 2.0 * line * ((K - J) * line.conjugate()).real
        slide = np.array([K.real, K.imag, far.real, far.imag, np.angle(line)])
        slider = Dyad((sides[x], sides[y]), True)
        yield DyadSeed(slider, slide, "a crank-slider of equal lengths")


def _numbers(*points: complex) -> Array:
    """Write points as numbers of a dyad."""
    return np.array([[point.real, point.imag] for point in points]).ravel()
