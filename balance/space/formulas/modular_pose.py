"""Poses of a planar linkage modulo a prime, for any dimensions: every joint closes exactly.

A complex number is a pair of remainders, the number and its conjugate, which are independent
in the field; a direction E has the conjugate 1/E.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from balance.space.formulas.assembly_order import DyadStep, FreeStep, Step
from balance.space.formulas.planar_parts import PartJoint, PlanarParts
from kinematics.numerics.linalg.prime_field import root_modulo

Pair = tuple[int, int]

ZERO: Pair = (0, 0)


class ModularPose(NamedTuple):
    """A pose in the frame of the ground.

    Attributes:
        directions: of the x-axis of each part.
        origins: of its frame.
        slides: position of each prismatic joint, 0 of the others.
    """

    directions: tuple[Pair, ...]
    origins: tuple[Pair, ...]
    slides: tuple[int, ...]


class UnclosedError(Exception):
    """No pose was reached with the numbers drawn: a root does not exist."""


class ModularAssembly:
    """Assembly of a linkage with given dimensions modulo a prime."""

    def __init__(
        self, linkage: PlanarParts, values: Sequence[Pair], p: int, rng: random.Random
    ) -> None:
        """Start without parts.

        Args:
            linkage: the parts.
            values: of its dimensions.
            p: the prime.
            rng: draws positions and roots.
        """
        self.linkage, self.values, self.p, self.rng = linkage, values, p, rng
        self.E: dict[int, Pair] = {}
        self.O: dict[int, Pair] = {}

    def pose(self, first: int, steps: Sequence[Step]) -> ModularPose:
        """Place all parts.

        Raises:
            UnclosedError: a root does not exist, or a joint does not close.
        """
        self.E, self.O = {first: (1, 1)}, {first: ZERO}
        try:
            for step in steps:
                if isinstance(step, FreeStep):
                    self._place_freely(step)
                else:
                    self._place_dyad(step)
            slides = tuple(
                self._slide_position(joint) if joint.slides else self._check_centre(k)
                for k, joint in enumerate(self.linkage.joints)
            )
        except ValueError:  # a remainder without an inverse
            raise UnclosedError from None
        return self._from_the_ground(slides)

    def _from_the_ground(self, slides: tuple[int, ...]) -> ModularPose:
        """Express the pose in the frame of the ground."""
        p, parts = self.p, range(len(self.linkage.parts))
        e, c = self.E[0]
        o, q = self.O[0]
        directions = tuple((self.E[k][0] * c % p, self.E[k][1] * e % p) for k in parts)
        origins = tuple(((self.O[k][0] - o) * c % p, (self.O[k][1] - q) * e % p) for k in parts)
        return ModularPose(directions, origins, slides)

    def point(self, part: int, joint: int) -> Pair:
        """Return the place of a revolute joint in the frame of a part."""
        dimension = self.linkage.parts[part].points[joint]
        return ZERO if dimension is None else self.values[dimension]

    def _offset(self, joint: PartJoint) -> Pair:
        return ZERO if joint.offset is None else self.values[joint.offset]

    def _turned(self, part: int, z: Pair) -> Pair:
        e, c = self.E[part]
        return e * z[0] % self.p, c * z[1] % self.p

    def _plus(self, a: Pair, b: Pair, sign: int = 1) -> Pair:
        return (a[0] + sign * b[0]) % self.p, (a[1] + sign * b[1]) % self.p

    def _norm(self, a: Pair) -> int:
        return a[0] * a[1] % self.p

    def _centre(self, part: int, joint: int) -> Pair:
        return self._plus(self.O[part], self._turned(part, self.point(part, joint)))

    def _put_centre(self, part: int, joint: int, centre: Pair) -> None:
        """Place the origin of a part whose direction is known."""
        self.O[part] = self._plus(centre, self._turned(part, self.point(part, joint)), -1)

    def _put_direction(self, part: int, direction: Pair) -> None:
        if not direction[0] or direction[0] * direction[1] % self.p != 1:
            raise UnclosedError
        self.E[part] = direction

    def _scaled(self, z: Pair, factor: int) -> Pair:
        return z[0] * factor % self.p, z[1] * factor % self.p

    def _quotient(self, a: Pair, b: Pair) -> Pair:
        return a[0] * pow(b[0], -1, self.p) % self.p, a[1] * pow(b[1], -1, self.p) % self.p

    def _quadratic(self, a: int, b: int, c: int) -> int:
        """Draw a root of ``a x² + b x + c``."""
        p = self.p
        root = root_modulo(b * b - 4 * a * c, p)
        if root is None:
            raise UnclosedError
        return (self.rng.choice((root, -root)) - b) * pow(2 * a, -1, p) % p

    def _align(self, joint: PartJoint, base: int, part: int) -> Pair:
        """Turn a part along a prismatic joint to its base; return the direction of sliding."""
        signs = dict(zip(joint.parts, joint.signs, strict=True))
        self.E[part] = self._scaled(self.E[base], signs[base] * signs[part])
        return self._scaled(self.E[base], signs[base])

    def _origin_on_line(self, joint: PartJoint, base: int, part: int) -> tuple[Pair, Pair]:
        """Turn a part along a prismatic joint; return a point of its origin and a direction."""
        direction = self._align(joint, base, part)
        if joint.parts[0] == base:
            return self._plus(self.O[base], self._turned(base, self._offset(joint))), direction
        start = self._plus(self.O[base], self._turned(part, self._offset(joint)), -1)
        return start, self._scaled(direction, -1)

    def _place_freely(self, step: FreeStep) -> None:
        joint, drawn = self.linkage.joints[step.joint], self.rng.randrange(1, self.p)
        if joint.slides:
            start, direction = self._origin_on_line(joint, step.base, step.part)
            self.O[step.part] = self._plus(start, self._scaled(direction, drawn))
        else:
            still = step.part in self.linkage.unturned and 0 in self.E
            self.E[step.part] = self.E[0] if still else (drawn, pow(drawn, -1, self.p))
            self._put_centre(step.part, step.joint, self._centre(step.base, step.joint))

    def _place_dyad(self, step: DyadStep) -> None:
        joints = [self.linkage.joints[k] for k in step.joints]
        kinds = tuple(joint.slides for joint in joints)
        if kinds == (False, False, False):
            self._place_turning(step)
        elif kinds == (False, True, False):
            self._place_around_slide(step)
        elif kinds == (True, False, True):
            self._place_between_slides(step)
        else:
            if kinds[0]:
                step = DyadStep(
                    (step.joints[2], step.joints[1], step.joints[0]),
                    (step.bases[1], step.bases[0]),
                    (step.parts[1], step.parts[0]),
                )
            self._place_on_slide(step)

    def _place_turning(self, step: DyadStep) -> None:
        """Three revolute joints: ``P + u E₁ + v E₂ = Q``."""
        p, (first, middle, last), (left, right) = self.p, step.joints, step.parts
        P, Q = self._centre(step.bases[0], first), self._centre(step.bases[1], last)
        u = self._plus(self.point(left, middle), self.point(left, first), -1)
        v = self._plus(self.point(right, last), self.point(right, middle), -1)
        g = self._plus(Q, P, -1)
        middle_term = self._norm(g) + self._norm(v) - self._norm(u)
        e = self._quadratic(g[1] * v[0], -middle_term, g[0] * v[1])
        self._put_direction(right, (e, pow(e, -1, p)))
        across = self._plus(g, self._turned(right, v), -1)
        self._put_direction(left, self._quotient(across, u))
        self._put_centre(left, first, P)
        self._put_centre(right, last, Q)

    def _place_on_slide(self, step: DyadStep) -> None:
        """Two revolute joints and a prismatic one: ``|R + σ D - P|² = |u|²``."""
        (first, middle, last), (left, right) = step.joints, step.parts
        P = self._centre(step.bases[0], first)
        u = self._plus(self.point(left, middle), self.point(left, first), -1)
        start, D = self._origin_on_line(self.linkage.joints[last], step.bases[1], right)
        R = self._plus(start, self._turned(right, self.point(right, middle)))
        w = self._plus(R, P, -1)
        slide = self._quadratic(1, D[1] * w[0] + D[0] * w[1], self._norm(w) - self._norm(u))
        self.O[right] = self._plus(start, self._scaled(D, slide))
        across = self._plus(w, self._scaled(D, slide))
        self._put_direction(left, self._quotient(across, u))
        self._put_centre(left, first, P)

    def _place_around_slide(self, step: DyadStep) -> None:
        """A prismatic joint between two revolute ones: ``E₁ (τ + q) = Q - P``."""
        joint = self.linkage.joints[step.joints[1]]
        (first, _, last), bases, (left, right) = step.joints, step.bases, step.parts
        if joint.parts[0] != left:
            first, last, bases, (left, right) = last, first, bases[::-1], (right, left)
        P, Q = self._centre(bases[0], first), self._centre(bases[1], last)
        far = self._scaled(self.point(right, last), joint.signs[0] * joint.signs[1])
        q = self._plus(self._plus(self._offset(joint), far), self.point(left, first), -1)
        g = self._plus(Q, P, -1)
        slide = self._quadratic(1, q[0] + q[1], self._norm(q) - self._norm(g))
        self._put_direction(left, self._quotient(g, self._plus(q, (slide, slide))))
        self._align(joint, left, right)
        self._put_centre(left, first, P)
        self._put_centre(right, last, Q)

    def _place_between_slides(self, step: DyadStep) -> None:
        """A revolute joint between two prismatic ones: ``R + σ D = S + τ G``."""
        p, (first, middle, last), (left, right) = self.p, step.joints, step.parts
        start, D = self._origin_on_line(self.linkage.joints[first], step.bases[0], left)
        other, G = self._origin_on_line(self.linkage.joints[last], step.bases[1], right)
        R = self._plus(start, self._turned(left, self.point(left, middle)))
        S = self._plus(other, self._turned(right, self.point(right, middle)))
        w = self._plus(S, R, -1)
        scale = pow(D[0] * G[1] - D[1] * G[0], -1, p)
        sigma = (w[0] * G[1] - w[1] * G[0]) * scale
        tau = (w[0] * D[1] - w[1] * D[0]) * scale
        self.O[left] = self._plus(start, self._scaled(D, sigma))
        self.O[right] = self._plus(other, self._scaled(G, tau))

    def _check_centre(self, joint: int) -> int:
        """Check that the centres of a joint on its two parts are one; return 0."""
        first, second = self.linkage.joints[joint].parts
        if self._centre(first, joint) != self._centre(second, joint):
            raise UnclosedError
        return 0

    def _slide_position(self, joint: PartJoint) -> int:
        """Compute the position of a prismatic joint; check that its parts are on its line."""
        first, second = joint.parts
        before = self.E[second]
        start, D = self._origin_on_line(joint, first, second)
        along = self._quotient(self._plus(self.O[second], start, -1), D)
        if before != self.E[second] or along[0] != along[1]:
            raise UnclosedError
        return along[0]
