"""Chapter 6 of J. J. de Jong, PhD thesis, University of Twente: [J]."""

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.bodies import mass_properties, parameters
from balance.checks import check_design
from balance.masses import buildable_masses, pure_inertia
from balance.momentum import momentum_lines, momentum_regressor
from balance.space import decoupling
from kinematics.errors import BodyError, UsageError
from tests.support.laws import outside
from tests.support.planar_masses import in_plane, momentum, with_masses

CHAPTER_6 = "two_rrr_bisector"
# Pure inertias of [J] table 6.2, in the order arm1, arm3, arm2, arm4, platform, bars, bisector.
TABLE_6_2 = [1.0, 1.01, 1.0, 1.01, -2.025, 0.01, 0.01, 0.01]
# (m, c, g) from tables 6.2 and 6.3 in full; c along the link, g about the centre of mass.
EXACT = {
    "arm1": (1.34, -0.434701, 0.166161),
    "arm2": (0.30, -0.891667, 0.495854),
    "arm3": (0.69, -0.710145, 0.172029),
    "arm4": (0.23, -1.130435, 0.456087),
    "platform": (0.52, 2.0, 0.055),
    "bar6": (0.007, -0.321429, 0.00758929),
    "bar7": (0.013, -0.173077, 0.0112981),
    "bisector": (0.010, 0.0, 0.010),
}
# [J] table 6.4 as printed.
TABLE_6_4 = {
    "arm1": (1.3, -0.43, 0.17),
    "arm2": (0.30, -0.89, 0.50),
    "arm3": (0.69, -0.71, 0.17),
    "arm4": (0.23, -1.1, 0.46),
    "platform": (0.52, 2.0, 0.055),
    "bar6": (0.007, -0.32, 0.0076),
    "bar7": (0.013, -0.17, 0.011),
    "bisector": (0.010, 0.0, 0.010),
}
# The origin from which c is measured, and a point of the link in the direction of c.
AXES = {
    "arm1": ((0, 0), (0.6, 0.8)),
    "arm2": ((0.6, 0.8), (0.32, 1.76)),
    "arm3": ((4, 0), (3.064, 0.352)),
    "arm4": ((3.064, 0.352), (4.064, 0.352)),
    "platform": ((0.32, 1.76), (4.064, 0.352)),
    "bar6": ((0.15, 0.2), (-0.06, 0.92)),
    "bar7": ((-0.06, 0.92), (0.39, 1.52)),
    "bisector": ((0.6, 0.8), (3.064, 0.352)),
}


def masses(table):
    """Parameters (bodies, 10) of links with centres along their lines."""
    found = []
    for body in kinematics.load(CHAPTER_6).bodies:
        (m, c, g), (start, end) = table[body.name], np.array(AXES[body.name], float)
        if body.name == "bar7":
            start = end
        along = (end - np.array(AXES[body.name][0])) / np.linalg.norm(
            end - np.array(AXES[body.name][0])
        )
        com = np.array([*(start + c * along), 0.0])
        found.append(parameters(m, com, np.diag([0.6 * g, 0.6 * g, g])))
    return np.array(found)


def test_the_masses_of_the_file_are_those_of_chapter_6():
    """(m, c, g) from tables 6.2 and 6.3: the file has them to the six digits given."""
    linkage = kinematics.load(CHAPTER_6)
    for body, z in zip(linkage.bodies, masses(EXACT), strict=True):
        mine, its = mass_properties(body.inertia), mass_properties(z)
        assert mine.mass == pytest.approx(its.mass, abs=1e-12)
        assert mine.com == pytest.approx(its.com, abs=1e-6)
        assert mine.inertia[2, 2] == pytest.approx(its.inertia[2, 2], abs=1e-6)


def test_momentum_with_exact_values_and_with_the_rounded_table():
    """[J] table 6.4 is rounded: some hundredths are left, where 1e-11 is with exact values."""
    linkage = kinematics.load(CHAPTER_6)
    given = in_plane([body.inertia for body in linkage.bodies])
    assert np.abs(momentum(linkage, given, count=20)[0]).max() <= 1e-11
    printed = np.abs(momentum(linkage, in_plane(masses(TABLE_6_4)), count=20)[0]).max()
    assert 0.02 < printed < 0.1


def test_the_engine_finds_the_pure_inertias_of_table_6_2():
    found = pure_inertia(design_space(CHAPTER_6))
    assert found.complete and found.balanced
    assert found.inertias == pytest.approx(TABLE_6_2, abs=1e-12)
    gains = {item.joints: item.gains for item in found.moved}
    # Table 6.3, where a10 must read -1.93: the arm gives it to the base.
    assert gains["u1",] == pytest.approx({"arm1": -1.93})
    assert gains["u3",] == pytest.approx({"arm3": -1.18})
    assert gains["q12",] == pytest.approx({"arm1": 0.57, "arm2": -0.57})
    assert gains["q34",] == pytest.approx({"arm3": 0.49, "arm4": -0.49})
    assert gains["q67",] == pytest.approx({"bar6": 0.003, "bar7": -0.003})
    g = dict(zip(found.space.bodies, found.inertias, strict=True))
    assert g["platform"] + g["bisector"] / 2 == pytest.approx(-2.02, abs=1e-12)
    assert -g["arm2"] - g["bar6"] - g["arm4"] == pytest.approx(-2.02, abs=1e-12)


# arm1, arm3, arm2, arm4, platform, bar6, bar7, bisector
EQUATION_6_14 = np.array(
    [
        [1, 0, -1, 0, 0, -1, 1, 0],  # g1 + g7 = g2 + g6
        [0, 1, 0, -1, 0, 0, 0, 0],  # g3 = g4
        [0, 0, 1, 1, 1, 1, 0, 0.5],  # g5 + g8 / 2 = -g2 - g6 - g4
    ]
)


def test_the_relations_of_chapter_6_are_found():
    """[J] Eq. 6.14 with g6 in its third relation: these and no others, from the geometry."""
    space = design_space(CHAPTER_6)
    found = pure_inertia(space)
    assert np.linalg.matrix_rank(found.conditions) == 3
    assert outside(EQUATION_6_14.T, found.conditions.T) < 1e-12
    assert outside(found.conditions.T, EQUATION_6_14.T) < 1e-12
    printed = EQUATION_6_14[2] - np.eye(8)[5]
    assert outside(printed[:, None], found.conditions.T) > 0.1
    assert found.condition_words[1] == "g(arm3) = g(arm4)"
    assert found.condition_words[2] == (
        "g(arm2) + g(arm4) + g(platform) + g(bar6) + 0.5 g(bisector) = 0"
    )
    assert found.relation_words[-1] == "ω(bisector) = 0.5 ω(arm1) + 0.5 ω(arm2)"
    # The same in the parallel freedoms: every balanced distribution of inertias alone.
    alone = np.zeros((len(space.basis), len(found.relations)))
    alone[3::4] = found.relations.T
    assert outside(alone, space.basis) < 1e-12
    assert outside(alone, space.serial) > 0.1
    assert np.abs(EQUATION_6_14 @ found.relations.T).max() < 1e-12


def test_the_relations_are_those_of_angular_velocities():
    """Σ r ω = 0 at a finite pose; ω of the bodies from a twist of unit inertia."""
    space = design_space(CHAPTER_6)
    X = momentum_regressor(space.linkage, {"u1": 0.12, "u3": -0.09})
    omega = X[:, 0, 3::4]
    assert np.abs(pure_inertia(space).relations @ omega.T).max() < 1e-12
    assert np.linalg.matrix_rank(omega) == 2


def test_the_engine_says_balanced_and_decoupled():
    space = design_space(CHAPTER_6)
    assert space.as_given.balanced
    assert decoupling(space).exact


@pytest.mark.parametrize(
    ("name", "inertias"),
    [
        # [J] Eq. 6.10 for the kite; the antiparallelogram has ω1 + ω3 = ω2.
        ("four_bar_kite", [1, 1, -1]),
        ("four_bar_antiparallelogram", [1, -1, 1]),
    ],
)
def test_four_bars_from_pure_inertia_alone(name, inertias):
    """Eq. 6.8 of Ricard and Gosselin from Eq. 6.10: masses that can be built, and balanced."""
    space = design_space(name)
    found = pure_inertia(space)
    assert found.relations == pytest.approx(np.array([inertias]) * found.relations[0, 0])
    built = buildable_masses(space, 0.3 * np.array(inertias))
    assert built.verdict == "feasible"
    assert check_design(space, built.z).accepted
    again = pure_inertia(design_space(with_masses(space.linkage, built.z)))
    assert again.balanced
    assert again.inertias == pytest.approx(0.3 * np.array(inertias), abs=1e-9)
    wrong = buildable_masses(space, -0.3 * np.array(inertias))
    assert (wrong.verdict, wrong.z) == ("infeasible", None)
    if name != "four_bar_kite":
        return
    points = np.array([[0, 0], [0.6, 0.3], [0.72, 0.96], [1, 0]])
    m, c, g, l = [], [], [], []  # noqa: E741
    for z, start, end in zip(built.z, points, points[1:], strict=False):
        known, along = mass_properties(z), end - start
        l.append(np.linalg.norm(along))
        m.append(known.mass)
        c.append((known.com[:2] - start) @ along / l[-1])
        g.append(known.inertia[2, 2])
    gc1 = g[0] - m[0] * c[0] * (l[0] - c[0])
    assert gc1 == pytest.approx(0.3, abs=1e-9)
    assert m[1] * c[1] == pytest.approx(m[0] * c[0] + m[1] * l[0])
    assert g[1] == pytest.approx(gc1 + m[1] * c[1] * (l[0] - c[1]))
    assert m[2] * c[2] == pytest.approx(l[2] / l[0] * (c[1] * m[1] + l[0] * m[2]))
    assert g[2] == pytest.approx(-gc1 + m[2] * c[2] * (l[2] - c[2]))
    assert g[2] != pytest.approx(-gc1 - m[2] * c[2] * (l[2] - c[2]))


def test_chapter_6_back_to_masses_that_can_be_built():
    space = design_space(CHAPTER_6)
    built = buildable_masses(space, TABLE_6_2)
    assert built.verdict == "feasible"
    again = pure_inertia(design_space(with_masses(space.linkage, built.z)))
    assert again.inertias == pytest.approx(TABLE_6_2, abs=1e-9)


def test_pure_inertias_that_are_not_balanced_are_refused():
    space = design_space("four_bar_kite")
    with pytest.raises(UsageError, match="not balanced"):
        buildable_masses(space, [1, 1, 1])
    with pytest.raises(UsageError, match="3 finite"):
        buildable_masses(space, [1, 1])
    with pytest.raises(BodyError, match="crnk"):
        buildable_masses(space, {"crnk": 1})
    named = buildable_masses(space, {"rocker": -1, "crank": 1, "coupler": 1})
    assert named.verdict == "feasible"


def test_momenta_of_pure_inertias_are_couples():
    """[J] Eq. 6.4: each is g ω; they have no line and add up to zero."""
    space = design_space("four_bar_kite_balanced")
    found = pure_inertia(space)
    pure = with_masses(space.linkage, found.spatial_parameters)
    (lines,) = momentum_lines(pure, {"u1": 0.3})
    assert all(np.isinf(line.pitch) for line in lines)
    omega = momentum_regressor(space.linkage, {"u1": 0.3})[0, 0, 3::4]
    sizes = [line.magnitude * line.direction[2] for line in lines]
    assert sizes == pytest.approx(found.inertias * omega, abs=1e-12)
    assert sum(sizes) == pytest.approx(0.0, abs=1e-13)
