"""Small linkages at the end of a long arm, in decimals."""

from decimal import Decimal
from fractions import Fraction

import numpy as np

from tests.independent.checker import echelon

# Hinges of a four-bar: two on the arm, at its ends, and the two of the coupler between them.
FOUR_BARS = {
    "general": ((0, 0), (0.3, 0.7), (2.0, 1.5), (2.2, 0)),
    "parallelogram": ((0, 0), (0.3, 0.7), (2.3, 0.7), (2, 0)),
    "kite": ((0.25, 0.5), (0, 0), (0.25, -0.5), (1.5, 0)),
}
NAMES = (*FOUR_BARS, "slider_crank", "rssr")
BASE = (0.1, 0.2, 0)


def _less(p, q):
    return [Decimal(str(a)) - Decimal(str(b)) for a, b in zip(p, q, strict=True)]


def _words(numbers):
    return " ".join(format(Decimal(x), "f") for x in numbers)


def _joints(name):
    """Kind and axis of each joint, and its place at the size 1; the last closes the loop."""
    if name in FOUR_BARS:
        o1, o2, o3, o4 = ((*p, 0) for p in FOUR_BARS[name])
        return [("continuous", "0 0 1", p) for p in (o1, o2, o4, o3)]
    if name == "slider_crank":
        places = (0, 0, 0), (0.3, 0.7, 0), (1.5, 0.2, 0), (1.5, 0.2, 0)
        kinds = "continuous", "continuous", "prismatic", "continuous"
        axes = "0 0 1", "0 0 1", "1 0 0", "0 0 1"
    else:
        places = (0, 0, 0), (0.3, 0.7, 0.1), (2.2, 0.2, 0.3), (1.9, 1.1, 0.9)
        kinds = "continuous", "spherical", "continuous", "spherical"
        axes = "0 0 1", "1 0 0", "0.6 0 0.8", "1 0 0"
    return list(zip(kinds, axes, places, strict=True))


def small_loop(name, size, arm=1, lift=0, turn=""):
    """URDF of an arm that carries a linkage of some size; ``lift`` and ``turn`` open its loop.

    Args:
        name: one of NAMES.
        size: text of a decimal number, in metres.
        arm: length of the arm in metres, a whole number.
        lift: of the far frame of the loop out of the plane, in parts of the size.
        turn: ``rpy`` of the first joint of the small linkage.
    """
    s = Decimal(size)

    def scaled(vector):
        return _words(s * x for x in vector)

    def link(number, centre, unit):
        moment = format(unit * unit * Decimal("0.3"), "f")
        place = _words(unit * c for c in centre)
        return (
            f'<link name="L{number}"><inertial><origin xyz="{place}"/>'
            f'<mass value="1.3"/><inertia ixx="{moment}" iyy="{moment}" izz="{moment}" '
            'ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(number, kind, parent, xyz, axis, rpy=""):
        angles = f' rpy="{rpy}"' if rpy else ""
        return (
            f'<joint name="j{number}" type="{kind}"><origin xyz="{xyz}"{angles}/>'
            f'<parent link="{parent}"/><child link="L{number}"/><axis xyz="{axis}"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )

    crank, elbow, pivot, last = _joints(name)
    foot = _less((arm, 0, 0), (0, 0, 0))

    def on_arm(place):
        return _words(a + s * Decimal(str(x)) for a, x in zip(foot, place, strict=True))

    ends = _less(last[2], elbow[2]), _less(last[2], pivot[2])
    ends[1][2] += Decimal(str(lift))
    roles = ("predecessor", "L3"), ("successor", "L4")
    frames = "".join(
        f'<{role} link="{side}"><origin xyz="{scaled(end)}"/></{role}>'
        for (role, side), end in zip(roles, ends, strict=True)
    )
    centres = [
        tuple(map(Decimal, c.split()))
        for c in ("-0.2 0.2 0.1", "-0.1 0 0.2", "0.1 0.2 0.3", "-0.3 0.2 -0.1")
    ]
    parts = [link(k + 1, c, s if k else Decimal(arm)) for k, c in enumerate(centres)]
    parts += [
        '<link name="base"/>',
        joint(1, "continuous", "base", _words(map(str, BASE)), "0 0 1"),
        joint(2, crank[0], "L1", on_arm(crank[2]), crank[1], turn),
        joint(3, elbow[0], "L2", scaled(_less(elbow[2], crank[2])), elbow[1]),
        joint(4, pivot[0], "L1", on_arm(pivot[2]), pivot[1]),
        f'<loop name="k" type="{last[0]}">{frames}<axis xyz="{last[1]}"/></loop>',
    ]
    return f'<robot name="small">{"".join(parts)}</robot>'


def freedom(name, size, arm=1):
    """Mobility by the rank of the loop equations in fractions: the arm, and what they leave."""
    s, columns = Fraction(size), []
    for kind, axis, place in _joints(name):
        p = [arm * (i == 0) + BASE_EXACT[i] + s * Fraction(str(x)) for i, x in enumerate(place)]
        axes = np.eye(3, dtype=int).tolist() if kind == "spherical" else [axis.split()]
        for n in axes:
            n = [Fraction(x) for x in n]
            moment = [p[i - 2] * n[i - 1] - p[i - 1] * n[i - 2] for i in range(3)]
            columns.append([0, 0, 0, *n] if kind == "prismatic" else n + moment)
    rows = np.array([[Fraction(x) for x in column] for column in columns], object)
    return 1 + len(columns) - len(echelon(rows))


BASE_EXACT = [Fraction(str(x)) for x in BASE]
