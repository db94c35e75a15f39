"""Linear momentum of planar linkages of links in a chain of letters, in rational numbers.

A link is a name and letters of joints: its origin, the joint on its x-axis, and further ones.
Letters in lower case are on the ground. Directions are rational points of the circle, so that
lengths and places are rational too; what is on the ground falls where it falls.
"""

from __future__ import annotations

from fractions import Fraction

from sympy import QQ
from sympy.polys.matrices import DomainMatrix

from tests.support.gaussian_rationals import Gaussian, unit


class ExactPose:
    """A random geometry at a random pose.

    Attributes:
        length: of each link, between its first two joints.
        direction: of the x-axis of each link.
        points: further joints in the frame of their link, by the link and the letter.
        places: of all joints.
    """

    def __init__(self, links, rng, same=(), straight=()):
        """Place the links in their order.

        Args:
            links: letters of each link, by its name.
            rng: random numbers of Python.
            same: pairs of links that are equal and parallel.
            straight: links that have the directions of the ground, and do not turn.
        """
        self.links, self.straight = links, straight
        self.length, self.direction, self.points, self.places = {}, {}, {}, {}
        like = dict(same)
        for name, letters in links.items():
            t = Fraction(rng.randrange(1, 30), rng.randrange(30, 60))
            self.direction[name] = Gaussian.of(1) if name in straight else unit(t)
            self.length[name] = Fraction(rng.randrange(1, 40), rng.randrange(7, 19))
            if name in like:
                self.direction[name] = self.direction[like[name]]
                self.length[name] = self.length[like[name]]
            self._place(name, letters, rng)

    def _place(self, name, letters, rng):
        step = self.direction[name] * self.length[name]
        origin, *others = letters
        if origin not in self.places:
            known = others and others[0] in self.places
            drawn = Gaussian(Fraction(rng.randrange(-9, 9), 7), Fraction(rng.randrange(9), 5))
            self.places[origin] = self.places[others[0]] - step if known else drawn
        for k, letter in enumerate(others):
            if k == 0:
                end = self.places[origin] + step
                assert self.places.setdefault(letter, end) == end
                continue
            x, y = rng.randrange(-20, 20), rng.randrange(1, 20)
            drawn = Gaussian(Fraction(x, 7), Fraction(y, 11))
            place = self.places[origin] + self.direction[name] * drawn
            z = (self.places.setdefault(letter, place) - self.places[origin]) / self.direction[
                name
            ]
            self.points[name, letter] = z

    def velocities(self, slides=()):
        """Rates of all links for a basis of the motions: velocities of origins, and turns.

        Args:
            slides: links that translate along the x-axis of the ground.
        """
        names = list(self.links)
        rows = []

        def point(name, letter, sign):
            """Add the velocity of a joint of a link to two rows."""
            arm = self.places[letter] - self.places[self.links[name][0]]
            at = 3 * names.index(name)
            for row, (k, turn) in zip(rows[-2:], ((0, -arm.y), (1, arm.x)), strict=True):
                row[at + k] += sign
                row[at + 2] += sign * turn

        def empty(count):
            rows.extend([Fraction(0)] * (3 * len(names)) for _ in range(count))

        holders = {}
        for name, letters in self.links.items():
            for letter in letters:
                holders.setdefault(letter, []).append(name)
        for letter, (first, *rest) in holders.items():
            if letter.islower():
                empty(2)
                point(first, letter, 1)
            for other in rest:
                empty(2)
                point(first, letter, 1)
                point(other, letter, -1)
        for name in (*slides, *self.straight):
            for k in (1, 2) if name in slides else (2,):
                empty(1)
                rows[-1][3 * names.index(name) + k] = Fraction(1)
        matrix = DomainMatrix(
            [[QQ(x.numerator, x.denominator) for x in r] for r in rows],
            (len(rows), 3 * len(names)),
            QQ,
        )
        basis = matrix.nullspace().to_Matrix().tolist()
        for motion in basis:
            x = [Fraction(int(each.p), int(each.q)) for each in motion]
            yield {
                name: (Gaussian(x[3 * k], x[3 * k + 1]), x[3 * k + 2])
                for k, name in enumerate(names)
            }

    def momenta(self, masses, moments, slides=()):
        """Linear momentum of each motion of a basis: ``Σ m Ȯ + s i Ω E``."""
        out = []
        for rates in self.velocities(slides):
            total = Gaussian.of(0)
            for name, (speed, turn) in rates.items():
                total = total + speed * masses[name]
                total = total + moments[name] * self.direction[name] * (1j * Gaussian.of(turn))
            out.append(total)
        return out
