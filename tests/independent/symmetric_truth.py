"""What is true of platforms with threefold symmetry: their roots exist modulo a prime."""

from __future__ import annotations

from fractions import Fraction

from tests.independent.plain_linkage import Joint, Linkage
from tests.independent.prime_field import PRIMES
from tests.independent.true_ranks import Truth, truth
from tests.support.symmetric_platforms import platform_legs

LETTERS = {"revolute": "R", "universal": "U", "spherical": "S", "prismatic": "P"}
# The prime of odd seeds is 3 modulo 4, and 3 is a square there.
P = PRIMES[1]
ROOT = pow(3, (P + 1) // 4, P)


def _turned(third: int, a: tuple) -> tuple[Fraction, ...]:
    """Turn a vector by thirds of a turn about z: remainders, as whole numbers."""
    half = pow(2, -1, P)
    c, s = (1, 0) if not third else (-half, half * ROOT * (1 if third == 1 else -1))
    x, y, z = (t.numerator * pow(t.denominator, -1, P) for t in map(Fraction, a))
    return tuple(Fraction(t % P) for t in (c * x - s * y, s * x + c * y, z))


def platform_truth(kind: str) -> Truth:
    """What is true of a platform of `tests.support.symmetric_platforms`."""
    assert ROOT * ROOT % P == 3
    tree, loops, links, platform = [], [], 0, 0
    for angle, leg in platform_legs(kind):
        before = 0
        for joint in leg:
            closes = not joint.after and platform > 0
            if not closes:
                links += 1
            after = platform if closes else links
            platform = platform or (0 if joint.after else after)
            vectors = [_turned(angle // 120, a) for a in (joint.point, joint.axis)]
            if joint.second:
                vectors.append(_turned(angle // 120, joint.second))
            made = Joint(LETTERS[joint.kind], before, after, *vectors, loop=closes)
            (loops if closes else tree).append(made)
            before = after
    return truth(Linkage((*tree, *loops)), 1)
