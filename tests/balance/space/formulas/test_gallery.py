"""Formulas of the gallery: no momentum at finite poses, in rational numbers.

Geometries and poses are drawn together; masses fulfil the printed formulas exactly. Velocities
solve the joints in rational numbers, without the package.
"""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

import balance
import kinematics
from balance.studies.discovery.topologies import topology
from kinematics import ScrewJoint, from_screws
from tests.support.exact_momentum import ExactPose
from tests.support.formula_rows import file_values, matrix, violation
from tests.support.gaussian_rationals import Gaussian

POSES = 3
STRAIGHT = "c1=-a1-b1"


def turning(tree, loops):
    """A linkage of revolute joints: two links and a place for each."""

    def joints(rows):
        words = [row.split() for row in rows]
        return [
            ScrewJoint(f"{a}_{b}", a, b, point=(float(x), float(y), 0.0))
            for a, b, x, y in words
        ]

    return from_screws([*joints(tree)], [*joints(loops)])


def offset_slider_crank():
    """A slider that runs beside the pivot of the crank."""
    end = (1.0, 0.1, 0.0)
    joints = [
        ScrewJoint("u1", "base", "crank"),
        ScrewJoint("q2", "crank", "coupler", point=(0.3, 0.4, 0.0)),
        ScrewJoint("p", "base", "slider", axis=(1.0, 0.0, 0.0), point=end, kind="prismatic"),
    ]
    return from_screws(joints, [ScrewJoint("q3", "coupler", "slider", point=end)])


SIX_BARS = {
    "watt2": (
        [
            "base crank 0 0",
            "crank coupler 0.2 0.5",
            "base lever 1.1 -0.1",
            "lever rod 1.5 0.6",
            "base rocker 2.3 0.2",
        ],
        ["coupler lever 0.9 0.8", "rod rocker 2.2 1.1"],
    ),
    "stephenson1": (
        [
            "base left 0 0",
            "base right 1.1 -0.1",
            "left coupler 0.2 0.5",
            "left rod -0.5 0.7",
            "rod link 0.3 1.5",
        ],
        ["coupler right 0.9 0.8", "link right 1.4 0.9"],
    ),
    "stephenson2": (
        [
            "base crank 0 0",
            "base right 1.1 -0.1",
            "crank left 0.2 0.5",
            "left lower 0.6 0.4",
            "left upper 0.3 1.3",
        ],
        ["lower right 1.3 0.5", "upper right 1.2 1.4"],
    ),
}
THREE_RRR = {
    "lower1": "a1 B1",
    "upper1": "B1 C1",
    "platform": "C1 C2 C3",
    "upper2": "B2 C2",
    "lower2": "a2 B2",
    "upper3": "B3 C3",
    "lower3": "a3 B3",
}
FOUR_RRR = THREE_RRR | {"platform": "C1 C2 C3 C4", "upper4": "B4 C4", "lower4": "a4 B4"}
# Letters of joints of each link, in an order in which they can be placed.
LINKS = {
    "watt1": {
        "coupler": "B E C",
        "crank": "a B",
        "link4": "E G",
        "link5": "F G",
        "rocker": "d F C",
    },
    "watt2": {
        "crank": "a B",
        "coupler": "B C",
        "lever": "d E C",
        "rod": "E F",
        "rocker": "g F",
    },
    "stephenson1": {
        "left": "a B C",
        "coupler": "B E",
        "rod": "C G",
        "link": "G F",
        "right": "d E F",
    },
    "stephenson2": {
        "left": "B G H",
        "crank": "a B",
        "lower": "G E",
        "upper": "H F",
        "right": "d E F",
    },
    "stephenson3": {
        "crank": "a B",
        "coupler": "B E C",
        "rocker": "d C",
        "link4": "E F",
        "rocker2": "g F",
    },
    "three_rrr": THREE_RRR,
    "four_rrr": FOUR_RRR,
    "offset slider": {"crank": "a B", "coupler": "B C", "slider": "C"},
}
GALLERY = {"watt1": "six_bar_watt", "stephenson3": "six_bar_stephenson"}


def linkage_of(name):
    """The linkage of a name, from the gallery or made here."""
    if name == "offset slider":
        return offset_slider_crank()
    return (
        turning(*SIX_BARS[name])
        if name in SIX_BARS
        else kinematics.load(GALLERY.get(name, name))
    )


def values_at(pose, formulas):
    """Dimensions of a pose by the names of the formulas, which have none of the ground."""
    values = {name: Fraction(1) for name in formulas.free.argument_names()}
    values |= {f"l_{name}": length for name, length in pose.length.items()}
    several = {}
    for name, letter in pose.points:
        several.setdefault(name, []).append(letter)
    for (name, letter), z in pose.points.items():
        if len(several[name]) == 1:
            values[f"z_{name}"] = z
        else:  # letters of the formulas: joints in the order of the file
            values[f"z_{name}_{'KL'[several[name].index(letter)]}"] = z
    return values


def balanced_masses(formulas, values, rng):
    """Random masses that fulfil the formulas exactly, by name."""
    names = [each.name for each in formulas.parameters]
    drawn = {}
    for name in names:
        x, y = (Fraction(rng.randrange(-30, 30), 7) for _ in range(2))
        drawn[name] = Gaussian(x, y) if name.startswith("s_") else Fraction(rng.randrange(1, 9))
    rows = matrix(formulas, values).tolist()
    for condition, row in zip(formulas.conditions, rows, strict=True):
        total = Gaussian.of(0)
        for name, c in zip(names, row, strict=True):
            if name != condition.solved.name:
                total = total + Gaussian.of(c) * drawn[name]
        drawn[condition.solved.name] = -total
    return drawn


def check(formulas, links, same=(), straight=(), slides=()):
    """Masses that fulfil the formulas have no momentum; a change of any solved one has."""
    rng = random.Random(1)
    for _ in range(POSES):
        pose = ExactPose({k: v.split() for k, v in links.items()}, rng, same, straight)
        drawn = balanced_masses(formulas, values_at(pose, formulas), rng)

        def momenta(changed="", pose=pose, drawn=drawn):
            moments = {name: drawn[f"s_{name}"] for name in links}
            masses = {name: drawn[f"m_{name}"] for name in links}
            if changed:
                moments[changed] = moments[changed] + Fraction(1, 1000)
            return pose.momenta(masses, moments, slides)

        left = momenta()
        assert left and all(each == Gaussian.of(0) for each in left)
        for condition in formulas.conditions:
            broken = momenta(condition.solved.name.removeprefix("s_"))
            assert any(each != Gaussian.of(0) for each in broken)


def names_of_formulas(formulas):
    """Dimensions that the conditions have in them."""
    return {name for name in formulas.free.argument_names() if name in formulas.text()}


QUICK = ("offset slider", "watt2")


@pytest.mark.parametrize(
    "name",
    [each if each in QUICK else pytest.param(each, marks=pytest.mark.slow) for each in LINKS],
)
def test_formulas_hold_at_finite_poses_in_rational_numbers(name):
    linkage = linkage_of(name)
    formulas = balance.formulas(linkage, "force")
    assert formulas.confirmed and not any(
        "ground" in each for each in names_of_formulas(formulas)
    )
    assert 2 * len(formulas.conditions) == formulas.rank
    slides = ("slider",) if "slider" in name else ()
    check(formulas, LINKS[name], slides=slides)


@pytest.mark.parametrize("name", SIX_BARS)
def test_six_bars_have_the_topology_of_their_name(name):
    tree, loops = SIX_BARS[name]
    links = ["base"]
    for row in (*tree, *loops):
        links += [each for each in row.split()[:2] if each not in links]
    edges = " ".join(
        "-".join(str(links.index(x)) for x in r.split()[:2]) for r in (*tree, *loops)
    )
    assert any(topology(name).matches(topology(edges)))


CROSSED = [("upper4", "lower1"), ("lower4", "upper1")]
PAIRS = {
    "four_rrr": (10, []),
    "four_rrr_pair": (8, CROSSED),
    "four_rrr_parallel": (6, [*CROSSED, ("lower3", "upper2"), ("upper3", "lower2")]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_rrr_in_line", "four_rrr_symmetric"])
@pytest.mark.parametrize("kind", ["force", "dynamic"])
def test_legs_that_are_crossed_or_parallel(name, kind):
    """Equal legs have both motions; the formulas are those of the one in the file."""
    linkage = kinematics.load(name, inputs=["a1", "b1", "c1"])
    formulas = balance.formulas(linkage, kind, STRAIGHT)
    assert formulas.confirmed and formulas.rank == (6 if kind == "force" else 18)
    space = balance.design_space(linkage, STRAIGHT, balance=kind)
    assert violation(formulas, space, file_values(formulas.to_dict())) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_four_rrr_whose_platform_does_not_turn(name):
    """Ten real conditions, eight with one parallel pair of legs, six with two."""
    rank, same = PAIRS[name]
    linkage = kinematics.load(name, inputs=["a1", "b1", "c1"])
    formulas = balance.formulas(linkage, "force", STRAIGHT)
    assert formulas.confirmed and formulas.rank == rank == 2 * len(formulas.conditions)
    assert not any("platform" in each for each in names_of_formulas(formulas))
    check(formulas, FOUR_RRR, same, straight=("platform",))
    if same:  # the legs of a pair are equal and parallel: general legs have more conditions
        with pytest.raises(AssertionError):
            check(formulas, FOUR_RRR, straight=("platform",))
