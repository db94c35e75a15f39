"""Linkages at poses where modes of motion meet, as URDF files."""

from __future__ import annotations

from itertools import pairwise, product
from operator import le
from typing import NamedTuple

import numpy as np

from tests.support.urdf_text import along, joint, link, loop, saved

Z = (0.0, 0.0, 1.0)
MASS = dict(mass=1.3, inertia=np.diag([0.1, 0.2, 0.3]), origin=along([0.2, 0.1, 0.0]))
SLIDE = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


class FlatLinkage(NamedTuple):
    """A planar linkage of bars, all of whose pins are on one line.

    Attributes:
        pins: name, the links that it joins, and its place on the line. A link that has no place
            yet is carried by its first pin; other pins close loops. ``g`` is the ground.
    """

    pins: tuple[tuple[str, str, str, float], ...]

    def write(self, folder, name, masses=MASS):
        """Write it as a URDF file."""
        start, elements = {"g": 0.0}, [link("g")]
        for pin, one, other, x in self.pins:
            if other not in start:
                start[other] = x
                elements.append(link(other, **masses))
                place = along([x - start[one], 0, 0])
                elements.append(joint(pin, "continuous", one, other, place, Z))
            else:
                frames = tuple(along([x - start[each], 0, 0]) for each in (one, other))
                elements.append(loop(pin, "revolute", (one, other), frames, Z))
        return saved(folder, *elements, name=name)

    def places(self, angles):
        """Complex positions of every pin on both of its links, for angles of tree joints."""
        turn, foot, start = {"g": 0.0}, {"g": 0j}, {"g": 0.0}
        found = {}
        for pin, one, other, x in self.pins:
            place = foot[one] + (x - start[one]) * np.exp(1j * turn[one])
            if other not in start:
                start[other], foot[other] = x, place
                turn[other] = turn[one] + angles.get(pin, 0.0)
            found[pin] = place, foot[other] + (x - start[other]) * np.exp(1j * turn[other])
        return found


def four_bar(a, b, c, d):
    """A four-bar with its pins A, B, C, D on a line, A and D on the ground."""
    return FlatLinkage(
        (
            ("a", "g", "crank", a),
            ("b", "crank", "coupler", b),
            ("d", "g", "rocker", d),
            ("c", "coupler", "rocker", c),
        )
    )


FLAT = {
    "parallelogram": four_bar(0, 0.5, 1.5, 1),
    # Ground and crank of one length, coupler and rocker of another.
    "kite": four_bar(0, 1, 2.5, 1),
    "kite on its side": four_bar(0, 1.5, 0, 1),
    "rhombus": four_bar(0, 1, 2, 1),
    "rhombus folded": four_bar(0, 1, 0, 1),
    # Longest and shortest bar are as long as the other two: 2 + 5 = 4 + 3.
    "change point": four_bar(0, 2, 7, 4),
    # B and D have one distance from A, from C, and from E.
    "two kites": FlatLinkage(
        (
            ("a", "g", "ab", 0),
            ("b1", "ab", "bc", 1),
            ("d1", "g", "dc", 1),
            ("c", "bc", "dc", 2.5),
            ("b2", "ab", "be", 1),
            ("d2", "g", "de", 1),
            ("e", "be", "de", 3),
        )
    ),
    "five-bar": FlatLinkage(
        (
            ("a", "g", "l1", 0),
            ("b", "l1", "l2", 1),
            ("e", "g", "l4", 4),
            ("d", "l4", "l3", 2.7),
            ("c", "l2", "l3", 3.1),
        )
    ),
}


def parallel_cells(count):
    """Cranks of one length, side by side: each cell is a parallelogram or crosses."""
    pins = [("a0", "g", "bar0", 0.0)]
    for i in range(count):
        pins += [
            (f"a{i + 1}", "g", f"bar{i + 1}", i + 1.0),
            (f"b{i}", f"bar{i}", f"rod{i}", i + 0.5),
            (f"c{i}", f"rod{i}", f"bar{i + 1}", i + 1.5),
        ]
    return FlatLinkage(tuple(pins))


def wunderlich(a, b, c):
    """Twelve bars, the edges of a cube in the plane: opposite bars of a face are of one length.

    W. Wunderlich, "Ein merkwürdiges Zwölfstabgetriebe", Österr. Ingenieurarchiv 8, 1954. The
    corner (i, j, k) is at a i + b j + c k; its pins are named after it, ``p0100``, ``p0101``.
    """
    corners = list(product((0, 1), repeat=3))
    edges = [
        (v, w) for v in corners for w in corners if sum(w) == sum(v) + 1 and all(map(le, v, w))
    ]
    names = {edge: "e" + "".join(map(str, edge[0] + edge[1])) for edge in edges}
    names[corners[0], (1, 0, 0)] = "g"
    pins, joined = [], ["g"]
    for v in sorted(corners, key=lambda v: (v[1] + v[2], v)):
        # The bar that is carried already comes first at each corner.
        bars = sorted((n for e, n in names.items() if v in e), key=lambda n: n not in joined)
        for k, bar in enumerate(bars[1:]):
            pin = f"p{v[0]}{v[1]}{v[2]}{k}"
            pins.append((pin, bars[0], bar, float(a * v[0] + b * v[1] + c * v[2])))
            joined.append(bar)
    return FlatLinkage(tuple(pins))


def folded_sarrus(folder):
    """Sarrus' linkage with bars of one length, folded: the platform is on the ground.

    The first leg has axes along z and lies along x, the second has axes along x and lies
    along z.
    """
    X, here = (1.0, 0.0, 0.0), along([0, 0, 0.5])
    names = ("r_low", "r_high", "s_low", "s_high", "platform")
    return saved(
        folder,
        link("g"),
        *(link(name, **MASS) for name in names),
        joint("r1", "continuous", "g", "r_low", along([0, 0, 0]), Z),
        joint("r2", "continuous", "r_low", "r_high", along([1, 0, 0]), Z),
        joint("r3", "continuous", "r_high", "platform", along([-1, 0, 0]), Z),
        joint("s1", "continuous", "g", "s_low", here, X),
        joint("s2", "continuous", "s_low", "s_high", along([0, 0, 1.5]), X),
        loop("s3", "revolute", ("s_high", "platform"), (along([0, 0, -1.5]), here), X),
        name="folded_sarrus",
    )


def limit_pose(folder):
    """A slider-crank of equal bars, whose crank is the rocker of a four-bar at its limit.

    The crank of the four-bar drives, and at its limit the rocker stands still.
    """
    names = ("rocker", "coupler", "slider", "crank", "rod")
    return saved(
        folder,
        link("g"),
        *(link(name, **MASS) for name in names),
        joint("a", "continuous", "g", "rocker", along([0, 0, 0]), Z),
        joint("b", "continuous", "rocker", "coupler", along([0, 1, 0]), Z),
        joint("s", "prismatic", "g", "slider", along([0, 0, 0]), [1, 0, 0], more=SLIDE),
        loop("c", "revolute", ("coupler", "slider"), (along([0, -1, 0]), along([0, 0, 0])), Z),
        joint("o", "continuous", "g", "crank", along([-3, 2, 0]), Z),
        joint("e", "continuous", "crank", "rod", along([1, 0, 0]), Z),
        loop("f", "revolute", ("rod", "rocker"), (along([2, 0, 0]), along([0, 2, 0])), Z),
        name="limit_pose",
    )


def slider_crank(folder):
    """Crank and coupler of one length, folded on each other across the slide."""
    return saved(
        folder,
        link("g"),
        *(link(name, **MASS) for name in ("crank", "coupler", "slider")),
        joint("a", "continuous", "g", "crank", along([0, 0, 0]), Z),
        joint("b", "continuous", "crank", "coupler", along([0, 1, 0]), Z),
        joint("s", "prismatic", "g", "slider", along([0, 0, 0]), [1, 0, 0], more=SLIDE),
        loop("c", "revolute", ("coupler", "slider"), (along([0, -1, 0]), along([0, 0, 0])), Z),
        name="slider_crank",
    )


def spherical(folder, angles, name):
    """A spherical four-bar: axes of A, B, C and D in one plane, through one point."""
    a, b, c, d = ([float(np.cos(x)), float(np.sin(x)), 0.0] for x in angles)
    here = along([0, 0, 0])
    return saved(
        folder,
        link("g"),
        *(link(each, **MASS) for each in ("crank", "coupler", "rocker")),
        joint("a", "continuous", "g", "crank", here, a),
        joint("b", "continuous", "crank", "coupler", here, b),
        joint("d", "continuous", "g", "rocker", here, d),
        loop("c", "revolute", ("coupler", "rocker"), (here, here), c),
        name=name,
    )


def three_upu(folder, height=2.0):
    """A 3-UPU with equal base and platform, one above the other, outer axes tangential."""
    elements, first = [link("base"), link("platform", **MASS)], None
    for k in range(3):
        t = 2 * np.pi * k / 3
        foot, outer = np.array([np.cos(t), np.sin(t), 0]), np.array([-np.sin(t), np.cos(t), 0])
        inner, up = np.array([np.cos(t), np.sin(t), 0]), np.array([0, 0, height])
        names = [f"{part}{k}" for part in ("cross", "cylinder", "rod", "top")]
        elements += [link(names[0]), link(names[1], **MASS), link(names[2], **MASS)]
        elements += [link(names[3])]
        kinds = ("a", "b", "s", "c")
        for kind, (one, other), place, axis in zip(
            kinds,
            pairwise(["base", *names]),
            (foot, 0 * up, 0 * up, up),
            (outer, inner, up / height, inner),
            strict=True,
        ):
            name, type_of, more = f"{kind}{k}", "continuous", ""
            if kind == "s":
                type_of, more = "prismatic", SLIDE
            elements.append(joint(name, type_of, one, other, along(place), axis, more=more))
        if first is None:
            first = foot
            elements.append(
                joint("d0", "continuous", "top0", "platform", along([0, 0, 0]), outer)
            )
        else:
            frames = along([0, 0, 0]), along(foot - first)
            elements.append(loop(f"d{k}", "revolute", (names[3], "platform"), frames, outer))
    return saved(folder, *elements, name="three_upu")
