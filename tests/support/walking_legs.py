"""Walking machines: legs of six bars on one crank, their loops open and all bars upright.

Dimensions are the eleven "holy numbers" of T. Jansen, in metres. Each leg has three loops that
balls close, and its own plane. The legs share no joint but the crank.
"""

import math

from tests.support.urdf_text import INERTIAL

# Bars of a leg: parent, the way to its joint in the frame of the parent, along x and z.
BARS = {
    "j": ("crank", None),
    "k": ("j", (0.0, 0.0)),
    "c": ("k", (0.0, 0.619)),
    "g": ("k", (0.0, 0.619)),
    "b": ("j", (0.0, 0.5)),
    "f": ("b", (0.0, 0.558)),
}
# Points of two bars that coincide, along x and z of their frames; the last of the crossbar.
BALLS = (
    ("f", (0.0, 0.394), "g", (0.3624, -0.0582)),
    ("b", (-0.2978, 0.2892), "c", (0.0, 0.393)),
    ("", (-0.38, -0.078), "c", (0.0, 0.393)),
)


def walking_legs(count: int, dialect: str = "loop") -> str:
    """A file with this many legs, every second one to the other side.

    Args:
        count: number of legs.
        dialect: ``"loop"``, or ``"drake"`` for its ball constraints.
    """
    parts = ['<link name="bar"/>', f'<link name="crank">{INERTIAL}</link>']
    parts.append(_joint("crank", "bar", "crank", "0 0 0"))
    for leg in range(count):
        parts += _leg(leg, 2 * math.pi * (leg // 2) / max(1, count // 2), dialect)
    return f'<robot name="legs" xmlns:drake="http://drake.mit.edu">{"".join(parts)}</robot>'


def _leg(leg: int, angle: float, dialect: str) -> list[str]:
    """Links, joints and loops of a leg whose crank pin is at an angle."""
    y, turn, parts = 0.1 * leg, math.pi * (leg % 2), []
    for bar, (parent, way) in BARS.items():
        parts.append(f'<link name="{bar}{leg}">{INERTIAL}</link>')
        if way is None:
            pin = f"{0.15 * math.sin(angle):.15g} {y} {0.15 * math.cos(angle):.15g}"
            lean = -angle if turn else angle
            origin = f'{pin}" rpy="0 {lean:.16g} {turn:.16g}'
            parts.append(_joint(f"{bar}{leg}", "crank", f"{bar}{leg}", origin))
        else:
            origin = f"{way[0]} 0 {way[1]}"
            parts.append(_joint(f"{bar}{leg}", f"{parent}{leg}", f"{bar}{leg}", origin))
    for number, (one, first, other, second) in enumerate(BALLS):
        side = -1 if turn and not one else 1
        points = (
            f"{side * first[0]} {y if not one else 0} {first[1]}",
            f"{second[0]} 0 {second[1]}",
        )
        ends = (f"{one}{leg}" if one else "bar", f"{other}{leg}")
        parts.append(_ball(f"ball{leg}_{number}", ends, points, dialect))
    return parts


def _joint(name: str, parent: str, child: str, origin: str) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{origin}"/><axis xyz="0 1 0"/></joint>'
    )


def _ball(name: str, ends: tuple[str, str], points: tuple[str, str], dialect: str) -> str:
    """The ball at a point of two links."""
    if dialect == "drake":
        tag = "drake:ball_constraint"
        inside = "".join(
            f'<{tag}_body_{x} name="{end}"/><{tag}_p_{x}{p} value="{point}"/>'
            for x, p, end, point in zip("AB", "PQ", ends, points, strict=True)
        )
        return f"<{tag}>{inside}</{tag}>"
    sides = "".join(
        f'<{role} link="{end}"><origin xyz="{point}"/></{role}>'
        for role, end, point in zip(("predecessor", "successor"), ends, points, strict=True)
    )
    return f'<loop name="{name}" type="spherical">{sides}</loop>'
