"""Conditions of the planar 4-RRR as they are printed, against the formulas, in symbols.

Source: the paper on shaking-force balance of the planar 4-RRR parallel manipulator, 13th World
Congress in Mechanism and Machine Science (IFToMM), Guanajuato, 2011, A12-523, Eqs. 2 to 4, 17,
19 and 21. A link ij of leg i has mass m, length l, and its centre of mass at p along it and q
across; the platform has half sides c and d, and p5, q5 from its centre.
"""

from __future__ import annotations

import pytest

import balance
import kinematics

pytestmark = pytest.mark.slow

sympy = pytest.importorskip("sympy")

i = sympy.I
LINKS = [(leg, k) for leg in (1, 2, 3, 4) for k in (1, 2)]
WORDS = {1: "lower", 2: "upper"}
STRAIGHT = "c1=-a1-b1"


def real(name):
    return sympy.Symbol(name, real=True)


M, L, P, Q = ({ij: real(f"{x}{ij[0]}{ij[1]}") for ij in LINKS} for x in "mlpq")
C, D, M5, P5, Q5 = map(real, ("c", "d", "m5", "p5", "q5"))
MU = [real(f"mu{leg}") for leg in (1, 2, 3, 4)]
U = C / D + D / C


def platform_masses():
    """Masses at the joints of the platform that are like it, Eqs. 2 to 4; mu4 is free."""
    m1, m2, m3, m4 = MU
    equations = [
        m1 + m2 + m3 + m4 - M5,
        m1 - m2 - m3 + m4 - M5 * P5 / C,
        -m1 - m2 + m3 + m4 - M5 * Q5 / D,
    ]
    return sympy.solve(equations, MU[:3], dict=True)[0]


def carried(ij):
    """What a link of leg 2 or 4 carries of legs 1 and 3 and of the platform."""
    (m1, m2, m3, m4), length = MU, L[ij]
    a, b = M[1, 2] / L[1, 2], M[3, 2] / L[3, 2]
    p1, q1, p3, q3 = P[1, 2], Q[1, 2], P[3, 2], Q[3, 2]
    side, sign, m = (D / C, 1, m2) if ij[0] == 2 else (C / D, -1, m4)
    along = a * (-sign * length / U * q1 + side * length / U * p1)
    along += b * (length * p3 + sign * length / U * q3 - side * length / U * p3)
    along += side * length / U * (m1 - m3) + (m + m3) * length
    across = a * (sign * length / U * p1 + side * length / U * q1)
    across += b * (length * q3 - sign * length / U * p3 - side * length / U * q3)
    across += sign * length / U * (m1 - m3)
    return along + i * across


def moment(ij):
    return M[ij] * (P[ij] + i * Q[ij])


def equation_17():
    """The left sides, complex, by the link whose moment stands first."""
    rows = {}
    for leg in (1, 3):
        l1, l2 = L[leg, 1], L[leg, 2]
        along = M[leg, 1] * P[leg, 1] + M[leg, 2] * l1 * (1 - P[leg, 2] / l2)
        across = M[leg, 1] * Q[leg, 1] - M[leg, 2] * l1 / l2 * Q[leg, 2]
        rows[leg, 1] = along + i * across
    for leg in (2, 4):
        rows[leg, 1] = moment((leg, 1)) + M[leg, 2] * L[leg, 1] + carried((leg, 1))
        rows[leg, 2] = moment((leg, 2)) + carried((leg, 2))
    return rows


# Rows of Eq. 17 whose sums are the rows of Eqs. 19 and 21, and the links that are equal.
CROSSED = (
    [((1, 1), (4, 2)), ((2, 1),), ((3, 1), (2, 2)), ((4, 1),)],
    {(4, 2): (1, 1), (4, 1): (1, 2), (3, 2): (2, 1), (3, 1): (2, 2)},
)
BESIDE = (
    [((1, 1), (4, 1)), ((3, 1), (2, 1)), ((2, 2),), ((4, 2),)],
    {(leg, k): (1, k) for leg in (2, 3, 4) for k in (1, 2)},  # all legs of the file are alike
)


def in_symbols_of_the_paper(formulas):
    """The left sides of formulas, renamed."""
    names = {}
    for ij in LINKS:
        link = f"{WORDS[ij[1]]}{ij[0]}"
        names[sympy.Symbol(f"s_{link}")] = moment(ij)
        names[real(f"m_{link}")], names[real(f"l_{link}")] = M[ij], L[ij]
    # From the first joint of the platform, with the x-axis to the second one.
    names[sympy.Symbol("s_platform")] = -M5 * (P5 + i * Q5 - C + i * D)
    names[real("m_platform")], names[real("l_platform")] = M5, 2 * C
    names[sympy.Symbol("z_platform_K")] = 2 * C - 2 * i * D
    names[sympy.Symbol("z_platform_L")] = -2 * i * D
    return [each.subs(names, simultaneous=True) for each in formulas.sympy()]


def test_twelve_conditions_are_those_of_equation_17():
    printed = equation_17()
    solve = [f"s_{WORDS[k]}{leg}" for leg, k in printed]
    formulas = balance.formulas("four_rrr", "force", solve=solve)
    assert formulas.confirmed and [each.solved.name for each in formulas.conditions] == solve
    masses = platform_masses()
    ours = in_symbols_of_the_paper(formulas)
    for left, right in zip(ours, printed.values(), strict=True):
        assert sympy.simplify(left - right.subs(masses)) == 0
    turned = ours[2].subs({C: D, D: C}, simultaneous=True)
    assert sympy.simplify(turned - printed[2, 1].subs(masses)) != 0


@pytest.mark.parametrize(
    ("name", "sums", "equal"),
    [("four_rrr_parallel", *CROSSED), ("four_rrr_side_by_side", *BESIDE)],
    ids=["Eq. 19", "Eq. 21"],
)
def test_six_conditions_follow_from_the_eight_in_print(name, sums, equal):
    """The prints are sufficient; two of their eight conditions are not necessary.

    That six are enough is checked without this paper, in `test_gallery`.
    """
    linkage = kinematics.load(name, inputs=["a1", "b1", "c1"])
    formulas = balance.formulas(linkage, "force", STRAIGHT)
    rows, masses = equation_17(), platform_masses()
    lengths = {L[a]: L[b] for a, b in equal.items()}
    printed = [sum(rows[ij] for ij in each).subs(masses).subs(lengths) for each in sums]
    first = [each[0] for each in sums]
    # Solved for the first moment of each row, which no other row has.
    solutions = {}
    for ij, row in zip(first, printed, strict=True):
        rest = (row - moment(ij)).expand()
        assert not rest.has(P[ij]) and not sum(x.has(P[ij]) for x in printed) > 1
        solutions[ij] = -rest
    assert formulas.rank == 6 < 2 * len(printed)
    for left in in_symbols_of_the_paper(formulas):
        left = left.subs(lengths).expand()
        for ij, rest in solutions.items():
            left = left.subs(Q[ij], 0).expand()
            left = (left.subs(P[ij], 0) + left.coeff(P[ij]) / M[ij] * rest).expand()
        assert sympy.simplify(left) == 0
