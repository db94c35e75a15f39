"""Random linkages beside integers that share no code with the product, and those themselves.

``tests/independent/random_linkages.py`` runs as many linkages as it is told; here stand a few
of every family, and the figures that are known of famous linkages.
"""

from __future__ import annotations

import ast
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.independent.families import FAMILIES, linkage
from tests.independent.judging import Answer, compare, judge
from tests.independent.plain_linkage import AXES, Joint, Linkage, urdf, vector
from tests.independent.planar_families import chained, ring
from tests.independent.random_linkages import cases
from tests.independent.spatial_families import _bennett
from tests.independent.true_ranks import truth
from tests.support.covering import ALL_CASES

Z = AXES[2]
PARALLELOGRAM = [vector(*p, 0) for p in ((0, 0), ("0.3", "0.7"), ("2.3", "0.7"), (2, 0))]
GENERAL = [vector(*p, 0) for p in ((0, 0), ("0.3", "0.1"), ("0.7", "0.9"), (0, "1.1"))]
KITE = [vector(*p, 0) for p in ((0, 0), (1, 2), (3, 0), (1, -2))]
CROSSED = [vector(*p, 0) for p in ((-2, 0), (1, 3), (2, 0), (-1, 3))]


def spoked(legs, kinds, places, axes, **options):
    """A platform, which is the last link of the first leg, on legs of three joints."""
    joints: list[Joint] = []
    for leg in range(legs):
        after = joints[2].after if leg else -1
        chained(joints, 0, after, kinds, places[leg], axes[leg])
    return Linkage(tuple(joints), **options)


def three_rsr(**options):
    """Legs around the normal (1, 1, 1), a third of a turn apart."""
    places, axes = [], []
    for k in range(3):
        out = [-1, -1, -1]
        out[k] = 2
        across = vector(*((0, 1, -1)[i - k] for i in range(3)))
        places.append(
            [
                vector(*(3 * x for x in out)),
                tuple(Fraction(18 * x + 5, 5) for x in out),
                vector(*(3 * x + 2 for x in out)),
            ]
        )
        axes.append([across, Z, across])
    legs = spoked(3, "RSR", places, axes, **options)
    # In a symmetric motion the elbow of the first leg turns about one axis only.
    elbow = legs.joints[1]._replace(axis=axes[0][0], second=vector(2, -1, -1))
    return replace(legs, joints=(legs.joints[0], elbow, *legs.joints[2:]))


def four_rrr():
    """A plate on four legs in the plane."""
    rng = np.random.default_rng(3)
    places = [[vector(*p, 0) for p in rng.integers(-9, 10, (3, 2))] for _ in range(4)]
    return spoked(4, "RRR", places, [[Z] * 3] * 4, force=True)


def sarrus():
    """Two chains of three parallel axes at right angles to each other."""
    points = [
        vector(*p)
        for p in (
            (1, 0, 0),
            ("1.3", 0, "0.4"),
            (1, 0, "0.8"),
            (0, 1, "0.8"),
            (0, "1.3", "0.4"),
            (0, 1, 0),
        )
    ]
    return Linkage(ring(points, "R" * 6, [AXES[1]] * 3 + [AXES[0]] * 3))


def slider_crank():
    """Crank and connecting rod of one length, in line with the slide."""
    points = [vector(0, 0, 0), vector(1, 2, 0), vector(2, 0, 0), vector(2, 0, 0)]
    return Linkage(ring(points, "RRRP", [Z, Z, Z, AXES[0]]))


KNOWN = {
    "general": (Linkage(ring(GENERAL)), 1, (3, 6, 7, 8), 4, 0),
    "general, in space": (Linkage(ring(GENERAL), spatial=True), 1, (5, 10, 11, 12), 17, 1),
    "kite": (Linkage(ring(KITE)), 1, (3, 6, 7), 4, 1),
    "antiparallelogram": (Linkage(ring(CROSSED)), 1, (3, 6, 7), 4, 1),
    "parallelogram": (Linkage(ring(PARALLELOGRAM)), 1, (3, 4, 5), 4, 3),
    "five bars": (Linkage(ring([*GENERAL, vector(-1, "0.3", 0)])), 2, (6, 11), 5, 0),
    "five bars, force": (
        Linkage(ring([*GENERAL, vector(-1, "0.3", 0)]), force=True),
        2,
        (4, 6),
        5,
        1,
    ),
    "slider-crank": (slider_crank(), 1, (3, 6), 5, 1),
    "Bennett": (Linkage(_bennett(np.random.default_rng(0))), 1, (6, 10, 13), 16, 1),
    "3-RSR": (three_rsr(), 3, (15, 39, 43), 27, 0),
    "3-RSR, u2 = u3": (
        three_rsr(inputs=("j0", "j3", "j6"), relations=(vector(0, 1, -1),)),
        3,
        (11, 28, 33, 34, 35),
        33,
        2,
    ),
    "4-RRR, force": (four_rrr(), 3, (6, 12), None, None),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed"),
    [
        (name, seed)
        for k, name in enumerate(KNOWN)
        for seed in (0, 1)
        if ALL_CASES or seed == k % 2
    ],
)
def test_known_figures(name, seed):
    """By one of two primes in turn, or by both."""
    case, mobility, ranks, serial, parallel = KNOWN[name]
    true = truth(case, seed)
    assert (true.mobility, true.regular, true.ranks) == (mobility, True, ranks)
    if serial is None:
        assert true.parameters - true.rank == 15
    else:
        assert (true.serial, true.parallel) == (serial, parallel)


@pytest.mark.parametrize("power", range(1, 17))
def test_what_is_nearly_a_parallelogram_is_general(power):
    """Whatever the offset: 3 6 7 8 of 12."""
    points = [PARALLELOGRAM[0], PARALLELOGRAM[1], *PARALLELOGRAM[2:]]
    points[2] = (points[2][0] + Fraction(1, 10**power), *points[2][1:])
    true = truth(Linkage(ring(points)))
    assert (true.ranks, true.serial, true.certain) == ((3, 6, 7, 8), 4, True)


def test_ways_of_opening_add_up():
    """No single way of opening Sarrus's linkage gives all of its serial space."""
    true = truth(sarrus())
    assert (true.mobility, true.serial, true.enumerated) == (1, 29, True)


def test_open_arms_have_no_parallel_part():
    """Whatever their axes: nothing couples them."""
    for seed in range(20):
        true = truth(linkage("tilted_arm", seed), seed)
        assert true.certain and true.parallel == 0


def test_structures_and_bifurcations_are_irregular():
    """A triangle does not move; a square and a flat four-bar are at their limits."""
    triangle = [vector(0, 0, 0), vector(1, 0, 0), vector(0, 1, 0)]
    assert truth(Linkage(ring(triangle))).mobility == 0
    flat = [vector(x, 0, 0) for x in (0, 1, 3, 4)]
    assert not truth(Linkage(ring([flat[k] for k in (0, 1, 3, 2)]))).regular


def test_small_loops_are_no_different():
    """The size of a loop on an arm changes no integer."""

    def arm(scale):
        inner = [tuple(x * scale for x in p) for p in GENERAL]
        joints: list[Joint] = []
        chained(joints, 0, -1, "R", [vector(-1, 0, 0)], [Z])
        chained(joints, 1, 1, "RRRR", inner, [Z] * 4)
        return Linkage(tuple(joints))

    large = truth(arm(1))
    assert (large.mobility, large.ranks) == (2, (6, 10, 11))
    assert truth(arm(Fraction(1, 10**6))) == large


def test_the_oracle_shares_no_code_with_the_product():
    """Only the command line of the product is called, and only by what compares.

    The files named first are no oracles of ranks: they compare poses and counterweights with
    those of the product, masses with those of a recording, or count how often a remedy helps.
    """
    comparing = {
        "added_dyads.py",
        "identification_run.py",
        "nearest_closed.py",
        "counterweight_files.py",
        "least_matter_run.py",
        "synthesis_run.py",
        "recorded_pendulum.py",
        "counterweight_requests.py",
        "second_counterweights.py",
        "test_robot_folder.py",
    }
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.name in comparing:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            modules = []
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                modules = [node.module]
            for module in modules:
                ours = module.partition(".")[0] in ("balance", "kinematics", "urdf_models")
                runs = path.name in ("judging.py", "meant_run.py")
                assert not ours or (runs and module == "balance.app.cli.main")


@pytest.mark.parametrize("family", FAMILIES)
def test_files_say_exactly_what_is_meant(family):
    """The decimals of a file add up to the points of the data; loops close in them."""
    assert urdf(linkage(family, 3)) != urdf(linkage(family, 4))
    for seed in range(10):
        case = linkage(family, seed)
        tree, places = ElementTree.fromstring(urdf(case)), {"L0": vector(0, 0, 0)}

        def at(link, element, places=places):
            words = element.find("origin").get("xyz").split()
            return tuple(a + Fraction(b) for a, b in zip(places[link], words, strict=True))

        for number, joint in enumerate(case.joints):
            found = tree.find(f"*[@name='j{number}']")
            if joint.loop:
                ends = [found.find(role) for role in ("predecessor", "successor")]
                assert [at(end.get("link"), end) for end in ends] == [joint.point] * 2
            else:
                place = at(found.find("parent").get("link"), found)
                places[found.find("child").get("link")] = place
                assert place == joint.point


# A few seeds of each family.
SAMPLE = {
    "grid": (1, 3, 4, 5, 9),
    "single": (0, 1, 2, 3, 4),
    "small_loop": (0, 1, 2, 3, 30062),
    "mimic": (0, 1, 2, 3, 4),
    "embedded": (0, 3, 4, 5, 6),
    "overconstrained": (0, 1, 2, 3, 4),
    "tilted_loop": (1, 3, 4, 8, 9),
    "tilted_arm": (0, 1, 2, 3, 5),
    "general": (0, 1, 2, 3, 5),
}


@pytest.mark.table
@pytest.mark.parametrize(
    ("family", "seed"), [(family, seed) for family in SAMPLE for seed in SAMPLE[family]]
)
def test_the_product_agrees(family, seed, tmp_path):
    verdict = judge(family, seed, tmp_path)
    assert not verdict.failed, verdict


def test_every_difference_is_seen():
    """An answer that is off by one anywhere is wrong."""
    true = truth(Linkage(ring(KITE)))
    orders = [
        {"order": k, "rank": rank, "nullity": 12 - rank} for k, rank in enumerate(true.ranks)
    ]
    report = {
        "algebra": "planar",
        "mobility": 1,
        "parameters": 12,
        "rank": 7,
        "nullity": 5,
        "serial": 4,
        "parallel": 1,
        "kmax": 2,
        "orders": orders,
        "certainty": "verified",
        "evidence": {"reason": "", "doubts": []},
        "warnings": [],
        "idle": [],
    }
    assert compare(true, Answer(0, report, ""))[0] == "right"
    numbers = "mobility", "parameters", "rank", "nullity", "serial", "parallel", "kmax"
    wrong = [{**report, name: report[name] + 1} for name in numbers]
    wrong += [{**report, "algebra": "spatial"}, {**report, "idle": ["j0"]}]
    wrong += [{**report, "evidence": {"reason": "", "doubts": ["rank"]}}]
    wrong += [{**report, "warnings": [{"code": "closes_to_rounding", "message": ""}]}]
    for k in range(3):
        for name in ("rank", "nullity"):
            off = [dict(order) for order in orders]
            off[k][name] -= 1
            wrong.append({**report, "orders": off})
    for tampered in wrong:
        assert compare(true, Answer(0, tampered, ""))[0] == "wrong", tampered
    rigid = true._replace(regular=False)
    assert compare(rigid, Answer(0, report, ""))[0] == "wrong"
    assert compare(true, Answer(1, None, ""))[0] == "crash"


def test_cases_are_told_apart():
    """All families in turn; one family by its seeds."""
    assert len(set(cases(900, 5))) == 900
    assert cases(2, 7, "grid") == [("grid", 7), ("grid", 8)]
