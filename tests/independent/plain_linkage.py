"""A linkage as plain data in rational numbers, and its URDF text.

All joints are placed at the pose where every position is 0, in inertial coordinates, and all
frames of links are parallel there. So loops close exactly whatever the numbers are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from math import isqrt
from typing import NamedTuple

Vector = tuple[Fraction, ...]

# Turns and slides of a joint about or along its axes: the first, the second, their product.
STEPS = {
    "R": ("turn 0",),
    "P": ("slide 0",),
    "U": ("turn 0", "turn 1"),
    "S": ("turn 0", "turn 1", "turn 2"),
    "C": ("turn 0", "slide 0"),
}
TYPES = {
    "R": "continuous",
    "P": "prismatic",
    "U": "universal",
    "S": "spherical",
    "C": "cylindrical",
}


def vector(*entries: object) -> Vector:
    """Entries as rational numbers; texts are decimals."""
    return tuple(Fraction(str(x)) for x in entries)


AXES = (vector(1, 0, 0), vector(0, 1, 0), vector(0, 0, 1))


def cross(a: Vector, b: Vector) -> Vector:
    """``a × b``."""
    return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))


class Joint(NamedTuple):
    """A joint between two links; 0 is the ground.

    Attributes:
        kind: R, P, U, S or C; an S joint turns about x, y, z unless told otherwise.
        before, after: the links; a joint of the tree carries ``after``.
        point: on the joint.
        axis, second: directions of any length; ``second`` of U and S joints only, at right
            angles to the first.
        loop: whether it closes a loop.
    """

    kind: str
    before: int
    after: int
    point: Vector
    axis: Vector = AXES[2]
    second: Vector = AXES[0]
    loop: bool = False


class Mimic(NamedTuple):
    """The position of joint number ``joint`` is ``ratio`` times that of ``source``."""

    joint: int
    source: int
    ratio: Fraction


@dataclass(frozen=True)
class Linkage:
    """Joints, parents first, and what is asked about them.

    Attributes:
        joints: the links they carry are 1, 2, 3 ….
        bare: links without mass, which carry no parameters.
        mimics: relations of joints.
        inputs: names of the independent coordinates, or none.
        relations: rows of factors, one for each input, whose sums of displacements vanish.
        force: whether linear momentum alone counts.
        spatial: whether all ten parameters count, even in a plane.
        as_written: whether axes are taken by their digits.
    """

    joints: tuple[Joint, ...]
    mimics: tuple[Mimic, ...] = ()
    inputs: tuple[str, ...] = ()
    relations: tuple[tuple[Fraction, ...], ...] = ()
    force: bool = False
    spatial: bool = False
    as_written: bool = True
    bare: tuple[int, ...] = ()

    @property
    def links(self) -> int:
        """How many links move, or could."""
        return max(joint.after for joint in self.joints)

    @property
    def bodies(self) -> list[int]:
        """Links with mass."""
        return [link for link in range(1, self.links + 1) if link not in self.bare]

    @property
    def options(self) -> list[str]:
        """Words of the command line that ask for this."""
        words = ["--as-written"] * self.as_written + ["--spatial"] * self.spatial
        words += ["--balance", "force"] * self.force
        for row in self.relations:
            terms = [(f, name) for f, name in zip(row, self.inputs, strict=True) if f]
            (first, left), *rest = terms
            right = "".join(
                f"{'+' if -f / first > 0 else '-'}{_text(abs(f / first))}*{name}"
                for f, name in rest
            )
            words += ["--motion", f"{left}={right.removeprefix('+') or '0'}"]
        return words


class Edge(NamedTuple):
    """One degree of freedom: its name, the nodes it connects, and its screw.

    Nodes are the links, and behind them what lies between the axes of one joint. The last
    edge of a joint that closes a loop has no node of its own after it: ``closes``. ``square``
    is the square of the length of the direction, 1 if it is rational and divided out.
    """

    name: str
    before: int
    after: int
    screw: Vector
    closes: bool
    square: Fraction = Fraction(1)


def edges(linkage: Linkage) -> list[Edge]:
    """All degrees of freedom; axes of rational length count as unit vectors.

    A joint of several freedoms is a chain of them, as in the product: of an S joint whose
    motion is restricted to one axis, the others are idle only if it is one of the three.
    """
    found, extra = [], linkage.links + 1
    for number, joint in enumerate(linkage.joints):
        at, steps = joint.before, STEPS[joint.kind]
        for k, step in enumerate(steps):
            motion, which = step.split()
            n = _unit((joint.axis, joint.second, cross(joint.axis, joint.second))[int(which)])
            screw = n + cross(joint.point, n) if motion == "turn" else (Fraction(0),) * 3 + n
            last = k == len(steps) - 1
            to, extra = (joint.after, extra) if last else (extra, extra + 1)
            name = f"j{number}" if len(steps) == 1 else f"j{number}.{k}"
            square = sum(x * x for x in n)
            found.append(Edge(name, at, to, screw, joint.loop and last, square))
            at = to
    return found


def urdf(linkage: Linkage) -> str:
    """The text of a file; every number in it is exact."""
    places = {0: (Fraction(0),) * 3}
    parts = ['<robot name="generated">', '<link name="L0"/>']
    for k in range(1, linkage.links + 1):
        parts.append(_link(k) if k in linkage.bodies else f'<link name="L{k}"/>')
    mimics = {mimic.joint: mimic for mimic in linkage.mimics}
    named = {name.partition(".")[0] for name in linkage.inputs}
    for number, joint in enumerate(linkage.joints):
        name = f"j{number}"
        mark = ' independent="true"' if name in named else ""
        axis = f'<axis xyz="{_words(joint.axis)}"/>'
        if joint.kind == "S":
            assert (joint.axis, joint.second) == AXES[:2], "not written"
            axis = ""
        if joint.kind == "U":
            axis += f'<axis2 xyz="{_words(joint.second)}"/>'
        at = _origin(joint.point, places[joint.before])
        if joint.loop:
            kind = TYPES[joint.kind]
            there = _origin(joint.point, places[joint.after])
            parts.append(
                f'<loop name="{name}" type="{kind}"{mark}>'
                f'<predecessor link="L{joint.before}">{at}</predecessor>'
                f'<successor link="L{joint.after}">{there}</successor>{axis}</loop>'
            )
            continue
        places[joint.after] = joint.point
        follows = ""
        if number in mimics:
            _, source, ratio = mimics[number]
            follows = f'<mimic joint="j{source}" multiplier="{_text(ratio)}"/>'
        parts.append(
            f'<joint name="{name}" type="{TYPES[joint.kind]}"{mark}>{at}'
            f'<parent link="L{joint.before}"/><child link="L{joint.after}"/>{axis}{follows}'
            "</joint>"
        )
    return "\n".join([*parts, "</robot>\n"])


def _link(k: int) -> str:
    """A link with a mass distribution that bodies can have."""
    place = f"0.{17 * k % 29:02d} -0.{11 * k % 31:02d} 0.{7 * k % 19:02d}"
    return (
        f'<link name="L{k}"><inertial><origin xyz="{place}"/><mass value="1.{k:02d}"/>'
        '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _unit(n: Vector) -> Vector:
    """The unit vector along n if it is rational, otherwise n."""
    square = sum(x * x for x in n)
    length = Fraction(isqrt(square.numerator), isqrt(square.denominator)) or Fraction(1)
    return tuple(x / length for x in n) if length * length == square else n


def _origin(point: Vector, frame: Sequence[Fraction]) -> str:
    return f'<origin xyz="{_words([a - b for a, b in zip(point, frame, strict=True)])}"/>'


def _words(entries: Sequence[Fraction]) -> str:
    return " ".join(map(_text, entries))


def _text(x: Fraction) -> str:
    """A rational number as a decimal, exactly."""
    with localcontext(prec=80):
        found = Decimal(x.numerator) / Decimal(x.denominator)
    assert Fraction(found) == x, f"{x} is no decimal"
    return format(found, "f")
