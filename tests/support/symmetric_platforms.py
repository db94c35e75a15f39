"""Parallel robots with three- and sixfold symmetry, in the numbers that programs write.

Legs are one leg that is turned by multiples of 120 degrees. A file has either vectors with all
digits of √3/2, or frames that are turned by 2π/3, so that the numbers of all legs are alike.
"""

from __future__ import annotations

from typing import NamedTuple

from mpmath import cos, mp, mpf, pi, sin, sqrt

__all__ = ["STYLES", "platform_text"]

mp.dps = 40

STYLES = ("vectors", "frames")
INERTIAL = (
    '<inertial><origin xyz="{com}"/><mass value="{mass}"/><inertia ixx="0.5" iyy="0.6" '
    'izz="0.7" ixy="0.01" ixz="0.02" iyz="0.03"/></inertial>'
)


class _Joint(NamedTuple):
    """A joint of a leg, in the frame of the leg; ``after`` is "" for the platform."""

    name: str
    kind: str
    after: str
    point: tuple
    axis: tuple = (0, 1, 0)
    second: tuple | None = None
    body: bool = True


def _ruu(size: float) -> list[_Joint]:
    """Arm about a tangent; forearm between universal joints with equal axes: translations."""
    s = mpf(str(size))
    p1, p2, p3 = ((mpf(x) * s, 0, mpf(z) * s) for x, z in (("1", "0"), ("1.2", "-0.5"),
                                                           ("0.3", "-1.7")))  # fmt: skip
    across = (12, 0, -9)
    return [
        _Joint("arm", "revolute", "arm", p1),
        _Joint("elbow", "universal", "rod", p2, (0, 1, 0), across),
        _Joint("wrist", "universal", "", p3, across, (0, 1, 0)),
    ]


def _rsr(size: float) -> list[_Joint]:
    """Two links that turn about tangents, and a ball between them."""
    s = mpf(str(size))
    places = ("3", "0"), ("3.6", "0.8"), ("3", "1.6")
    points = [(mpf(x) * s, 0, mpf(z) * s) for x, z in places]
    return [
        _Joint("low", "revolute", "low", points[0]),
        _Joint("ball", "spherical", "up", points[1]),
        _Joint("top", "revolute", "", points[2]),
    ]


def _ups(size: float, side: int) -> list[_Joint]:
    """A leg of a hexagonal platform: universal, prismatic, spherical."""
    s = mpf(str(size))
    foot = (mpf("1") * s, side * mpf("0.2") * s, 0)
    tip = (mpf("0.5") * s, side * mpf("0.4") * s, mpf("1.2") * s)
    along = tuple(b - a for a, b in zip(foot, tip, strict=True))
    return [
        _Joint("foot", "universal", "low", foot, (1, 0, 0), (0, 1, 0)),
        _Joint("slide", "prismatic", "up", foot, along),
        _Joint("tip", "spherical", "", tip, (0, 0, 1)),
    ]


def _legs(kind: str, size: float) -> list[tuple[mpf, list[_Joint]]]:
    """Angle, in degrees, and joints of each leg."""
    if kind == "6_ups":
        return [(mpf(120 * k), _ups(size, side)) for k in range(3) for side in (1, -1)]
    leg = {"3_ruu": _ruu, "3_rsr": _rsr}[kind](size)
    return [(mpf(120 * k), leg) for k in range(3)]


def _turn(angle: mpf, a: tuple) -> tuple:
    c, s = cos(angle * pi / 180), sin(angle * pi / 180)
    return c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]


def _words(a: tuple) -> str:
    return " ".join(repr(float(x) + 0.0) for x in a)


def _unit(a: tuple) -> tuple:
    length = sqrt(sum(mpf(x) ** 2 for x in a))
    return tuple(x / length for x in a)


def platform_text(
    kind: str, size: float = 1.0, style: str = "vectors", start: float = 0.0,
    base: str = "", platform: str = "",
) -> str:  # fmt: skip
    """Write a platform as URDF.

    Args:
        kind: ``"3_ruu"``, ``"3_rsr"`` or ``"6_ups"``.
        size: of its lengths.
        style: ``"vectors"`` turns the numbers, ``"frames"`` the frames.
        start: angle of the first leg, degrees.
        base: roll, pitch and yaw of the base; empty for none.
        platform: numbers of ``xyz`` of the frame of the platform, else the wrist of leg 1.
    """
    lines = [f'<robot name="{kind}">', '<link name="world"/>', '<link name="base"/>']
    lines.append(
        '<joint name="stand" type="fixed"><parent link="world"/><child link="base"/>'
        f'<origin xyz="0 0 0"{f" rpy={chr(34)}{base}{chr(34)}" if base else ""}/></joint>'
    )
    first: tuple | None = None
    for k, (angle, joints) in enumerate(_legs(kind, size), 1):
        angle += mpf(str(start))
        carried, here = "base", (mpf(0),) * 3
        for number, joint in enumerate(joints):
            last = number == len(joints) - 1
            after = f"{joint.after}{k}" if joint.after else "platform"
            where = tuple(b - a for a, b in zip(here, joint.point, strict=True))
            rpy = ""
            if style == "vectors":
                where = _turn(angle, where)
            elif number == 0:
                where = _turn(angle, where)
                rpy = f' rpy="0 0 {float(angle * pi / 180)!r}"' if angle else ""
            turned = angle if style == "vectors" else 0
            axis = _turn(turned, _unit(joint.axis))
            second = (
                f'<axis2 xyz="{_words(_turn(turned, _unit(joint.second)))}"/>'
                if joint.second else ""
            )  # fmt: skip
            origin = f'<origin xyz="{_words(where)}"{rpy}/>'
            words = f'<axis xyz="{_words(axis)}"/>{second}'
            if not last or first is None:
                lines.append(
                    f'<joint name="{joint.name}{k}" type="{joint.kind}">{origin}'
                    f'<parent link="{carried}"/><child link="{after}"/>{words}</joint>'
                )
            else:
                there = _turn(angle, joint.point)
                there = tuple(b - a for a, b in zip(first[0], there, strict=True))
                back = f' rpy="0 0 {float(angle * pi / 180)!r}"' if angle else ""
                if style == "frames":
                    there = _turn(-first[1], there)
                    turn = float((angle - first[1]) * pi / 180)
                    back = f' rpy="0 0 {turn!r}"'
                else:
                    back = ""
                lines.append(
                    f'<loop name="{joint.name}{k}" type="{joint.kind}">'
                    f'<predecessor link="{carried}">{origin}</predecessor>'
                    f'<successor link="{after}"><origin xyz="{_words(there)}"{back}/>'
                    f"</successor>{words}</loop>"
                )
            if last and first is None:
                first = _turn(angle, joint.point), angle
            if not last or k == 1:
                text = INERTIAL.format(com=f"0.0{k} 0.02 -0.0{number + 1}", mass=f"1.{k}")
                lines.append(f'<link name="{after}">{text}</link>')
            carried, here = after, joint.point
    return "\n".join([*lines, "</robot>\n"])
