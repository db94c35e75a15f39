"""Parallel robots with three- and sixfold symmetry, in the numbers that programs write.

Legs are one leg that is turned by multiples of 120 degrees. A file has either vectors with all
digits of √3/2, or frames that are turned by 2π/3, so that the numbers of all legs are alike.
Oracles that compute without rounding have the same legs as rational numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

from mpmath import cos, mpf, pi, sin, sqrt, workdps

X, Y = (tuple(Fraction(int(i == j)) for j in range(3)) for i in range(2))
STYLES = ("vectors", "frames")
INERTIAL = (
    '<inertial><origin xyz="0.0{number} 0.02 -0.03"/><mass value="1.{number}"/>'
    '<inertia ixx="0.5" iyy="0.6" izz="0.7" ixy="0.01" ixz="0.02" iyz="0.03"/></inertial>'
)


NUMBERS = re.compile(r'(?<!<inertial><origin )xyz="([^"]*)"')


class LegJoint(NamedTuple):
    """A joint of a leg, in the frame of the leg; ``after`` is "" for the platform."""

    name: str
    kind: str
    after: str
    point: tuple
    axis: tuple = Y
    second: tuple | None = None


def _points(size: str, *words: str) -> list[tuple]:
    """Points in rational numbers, from decimals."""
    return [tuple(Fraction(x) * Fraction(size) for x in word.split()) for word in words]


def _ruu(size: str) -> list[LegJoint]:
    """Arm about a tangent; forearm between universal joints with equal axes: translations."""
    first, second, third = _points(size, "1 0 0", "1.2 0 -0.5", "0.3 0 -1.7")
    across = (Fraction(4, 5), Fraction(0), Fraction(-3, 5))
    return [
        LegJoint("arm", "revolute", "arm", first),
        LegJoint("elbow", "universal", "rod", second, Y, across),
        LegJoint("wrist", "universal", "", third, across, Y),
    ]


def _rsr(size: str) -> list[LegJoint]:
    """Two links that turn about tangents, and a ball between them."""
    first, second, third = _points(size, "3 0 0", "3.6 0 0.8", "3 0 1.6")
    return [
        LegJoint("low", "revolute", "low", first),
        LegJoint("ball", "spherical", "up", second, X, Y),
        LegJoint("top", "revolute", "", third),
    ]


def _ups(size: str, side: int) -> list[LegJoint]:
    """A leg of a hexagonal platform: universal, prismatic, spherical."""
    foot, tip = _points(size, f"1 {side * 0.2} 0", f"0.5 {side * 0.4} 1.2")
    along = tuple((b - a) / Fraction(size) for a, b in zip(foot, tip, strict=True))
    return [
        LegJoint("foot", "universal", "low", foot, X, Y),
        LegJoint("slide", "prismatic", "up", foot, along),
        LegJoint("tip", "spherical", "", tip, X, Y),
    ]


def platform_legs(kind: str, size: str = "1") -> list[tuple[int, list[LegJoint]]]:
    """Angle, in degrees, and joints of each leg before it is turned about z.

    Args:
        kind: ``"3_ruu"``, ``"3_rsr"`` or ``"6_ups"``.
        size: of its lengths, a decimal.
    """
    if kind == "6_ups":
        return [(120 * k, _ups(size, side)) for k in range(3) for side in (1, -1)]
    leg = {"3_ruu": _ruu, "3_rsr": _rsr}[kind](size)
    return [(120 * k, leg) for k in range(3)]


def _turn(angle: mpf, a: tuple) -> tuple:
    x, y, z = (mpf(t.numerator) / t.denominator if isinstance(t, Fraction) else t for t in a)
    c, s = cos(angle * pi / 180), sin(angle * pi / 180)
    return c * x - s * y, s * x + c * y, z


def _words(a: tuple) -> str:
    return " ".join(repr(float(x) + 0.0 if abs(x) > 1e-30 else 0.0) for x in a)


def _unit(a: tuple) -> tuple:
    length = sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def platform_text(
    kind: str,
    size: str = "1",
    style: str = "vectors",
    start: float = 0.0,
    base: str = "",
    turn: tuple | None = None,
) -> str:
    """Write a platform as URDF.

    Args:
        kind: as for `platform_legs`.
        size: likewise.
        style: ``"vectors"`` turns the numbers, ``"frames"`` the frames.
        start: angle of the first leg, degrees.
        base: roll, pitch and yaw of the base; empty for none.
        turn: rows of a rotation of all vectors, for the style ``"vectors"``.
    """
    stand = f' rpy="{base}"' if base else ""
    lines = [
        f'<robot name="{kind}"><link name="world"/><link name="base"/>',
        '<joint name="stand" type="fixed"><parent link="world"/><child link="base"/>'
        f'<origin xyz="0 0 0"{stand}/></joint>',
    ]
    with workdps(40):
        text = "\n".join([*lines, *_leg_lines(kind, size, style, mpf(str(start)))])
        return text if turn is None else NUMBERS.sub(lambda found: _turned(turn, found), text)


def _turned(turn: tuple, found: re.Match) -> str:
    """Turn the vector of an attribute ``at``, as of all but centres of mass."""
    a = [mpf(word) for word in found.group(1).split()]
    b = tuple(sum(x * y for x, y in zip(row, a, strict=True)) for row in turn)
    return f'{found.group(0)[: -len(found.group(1)) - 1]}{_words(b)}"'


def _leg_lines(kind: str, size: str, style: str, start: mpf) -> Iterator[str]:
    """Write links and joints of all legs; the last joints of all but the first close loops."""
    frames = style == "frames"
    first = None
    for number, (angle, joints) in enumerate(platform_legs(kind, size), 1):
        turn = start + angle
        turned = mpf(0) if frames else turn
        carrier, here = "base", (Fraction(0),) * 3
        for joint in joints:
            after = f"{joint.after}{number}" if joint.after else "platform"
            step = tuple(b - a for a, b in zip(here, joint.point, strict=True))
            at_base = frames and carrier == "base"
            origin = _origin(_turn(turn if at_base else turned, step), turn if at_base else 0)
            axes = f'<axis xyz="{_words(_unit(_turn(turned, joint.axis)))}"/>'
            if joint.kind == "universal":
                axes += f'<axis2 xyz="{_words(_unit(_turn(turned, joint.second)))}"/>'
            name = f'name="{joint.name}{number}" type="{joint.kind}"'
            if joint.after or first is None:
                yield (
                    f'<link name="{after}">{INERTIAL.format(number=number)}</link>'
                    f'<joint {name}>{origin}<parent link="{carrier}"/><child link="{after}"/>'
                    f"{axes}</joint>"
                )
            else:
                place = zip(first, _turn(turn, joint.point), strict=True)
                there = _turn(-start if frames else mpf(0), tuple(b - a for a, b in place))
                back = _origin(there, mpf(angle) if frames else 0)
                yield (
                    f'<loop {name}><predecessor link="{carrier}">{origin}</predecessor>'
                    f'<successor link="platform">{back}</successor>{axes}</loop>'
                )
            if not joint.after and first is None:
                first = _turn(turn, joint.point)
            carrier, here = after, joint.point
    yield "</robot>\n"


def _origin(xyz: tuple, angle: mpf) -> str:
    """Write an origin that is turned about z, degrees."""
    rpy = f' rpy="0 0 {float(angle * pi / 180)!r}"' if angle else ""
    return f'<origin xyz="{_words(xyz)}"{rpy}/>'
