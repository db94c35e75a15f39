"""Small random linkages as URDF files: open arms and single loops, plane and space.

All frames are parallel, so that `reference_model` reads them, and offsets are decimals, so that
loops close exactly.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

Z = (0.0, 0.0, 1.0)


def small_linkage(rng: random.Random, path: Path, uneven: bool = False) -> Path:
    """Write a linkage of one to four bodies to a file: arms, four-bars, five-bars, sliders.

    ``uneven`` makes some bodies up to a thousand times lighter or heavier.
    """
    kind = rng.choice(("arm", "four_bar", "four_bar", "five_bar", "slider", "special"))
    parts = _arm(rng) if kind == "arm" else _loop(rng, kind)
    if uneven:
        parts = [_resized(part, 10.0 ** rng.choice((-3, -1, 0, 0, 1, 3))) for part in parts]
    text = f'<robot name="{kind}"><link name="base"/>{"".join(parts)}</robot>'
    path.write_text(text, "utf-8")
    return path


def _arm(rng: random.Random) -> list[str]:
    """A serial arm of one to three joints, planar or spatial."""
    flat, parts = rng.random() < 0.5, []
    for k in range(1, rng.choice((2, 3, 4))):
        axis = Z if flat else tuple(rng.choice((-1, 0, 1, 2)) for _ in range(3))
        kind = rng.choice(("continuous", "continuous", "prismatic"))
        if flat and kind == "prismatic":
            axis = (1.0, rng.choice((0.0, 0.5)), 0.0)
        where = (_length(rng), _length(rng), 0.0 if flat else _length(rng))
        parts.append(
            _body(
                rng, k, "base" if k == 1 else f"L{k - 1}", kind, where, axis if any(axis) else Z
            )
        )
    return parts


def _loop(rng: random.Random, kind: str) -> list[str]:
    """A planar loop of four or five joints, cut at the second last body of one side."""
    points = {"four_bar": 4, "special": 4, "slider": 4, "five_bar": 5}[kind]
    corners = [(_length(rng), _length(rng)) for _ in range(points)]
    if kind == "special":  # parallelogram or kite
        a, b = _length(rng), _length(rng)
        corners = [(0.0, 0.0), (a, b), (a + 1.5, b), (1.5, 0.0)]
        if rng.random() < 0.5:
            corners = [(0.0, 0.0), (0.5, 0.25), (2.0, 0.0), (0.5, -0.25)]
            cut = rng.randrange(4)
            corners = corners[cut:] + corners[:cut]
    parts, count = [], points - 1
    for k in range(1, count):
        (x, y), (u, v) = corners[k - 1], corners[k - 2] if k > 1 else (0.0, 0.0)
        slides = kind == "slider" and k == 2
        parts.append(
            _body(
                rng,
                k,
                "base" if k == 1 else f"L{k - 1}",
                "prismatic" if slides else "continuous",
                (round(x - u, 4), round(y - v, 4), 0.0),
                (1.0, 0.0, 0.0) if slides else Z,
            )
        )
    x, y = corners[-1]
    parts.append(_body(rng, count, "base", "continuous", (x, y, 0.0), Z))
    # The last joint joins the ends of both sides.
    (a, b), (u, v) = corners[-2], corners[-3]
    first = f"{round(a - u, 4)} {round(b - v, 4)} 0"
    second = f"{round(a - x, 4)} {round(b - y, 4)} 0"
    parts.append(
        f'<loop name="loop1" type="revolute"><predecessor link="L{count - 1}">'
        f'<origin xyz="{first}"/></predecessor><successor link="L{count}">'
        f'<origin xyz="{second}"/></successor><axis xyz="0 0 1"/></loop>'
    )
    return parts


def _resized(text: str, factor: float) -> str:
    """A body with its mass and moments multiplied."""
    pattern = re.compile(r'(mass value|i[xyz][xyz])="([^"]*)"')
    return pattern.sub(lambda found: f'{found[1]}="{factor * float(found[2])!r}"', text)


def _length(rng: random.Random) -> float:
    return round(rng.uniform(-2.0, 2.0), rng.choice((0, 1, 2, 4)))


def _body(rng, k, parent, kind, where, axis) -> str:
    """A link with its joint; its inertia is that of a body."""
    moments = [rng.uniform(0.1, 0.3) for _ in range(3)]
    moments[2] = min(moments[2], 0.95 * (moments[0] + moments[1]))
    xx, yy, zz = (round(value, 4) for value in (*moments[:2], moments[2]))
    com = " ".join(f"{rng.uniform(-0.3, 0.3):.3f}" for _ in range(3))
    limit = '<limit lower="-9" upper="9" effort="1" velocity="1"/>' * (kind == "prismatic")
    return (
        f'<link name="L{k}"><inertial><origin xyz="{com}"/>'
        f'<mass value="{rng.uniform(0.2, 2.0):.3f}"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="j{k}" type="{kind}"><origin xyz="{_text(where)}"/><parent '
        f'link="{parent}"/><child link="L{k}"/><axis xyz="{_text(axis)}"/>{limit}</joint>'
    )


def _text(numbers) -> str:
    return " ".join(f"{x:g}" for x in numbers)
