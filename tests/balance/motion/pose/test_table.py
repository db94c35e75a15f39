"""Table 3.1: for each case, closed form = conditions of order 0 = momentum by differences.

[J] J. J. de Jong, PhD thesis, University of Twente, chapter 3. Thirty random pairs of
bodies for each of the nine cases, a hundred with ``ALL_CASES=1``, ten in one linkage; see
`pairs`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from balance import design, design_space
from balance.bodies import parameters, violations
from balance.pose import balance_pose, balancing_family
from kinematics.errors import UsageError
from tests.support.covering import number_of_cases
from tests.support.laws import outside, relative
from tests.support.pairs import IMPOSSIBLE, PITCHES, POSSIBLE, linkage_of, momentum, pair

LINKAGES, PAIRS = number_of_cases(3, 10), 10
CASES = POSSIBLE + IMPOSSIBLE
# Free parameters of the proximal body: inertia transfers of the thesis, table 5.1, parallel.
FREE = {"zero": 5, "finite": 4, "infinite": 7}


@cache
def drawn(case, number):
    """Ten pairs, their linkage, and the space of order 0."""
    rng = np.random.default_rng([number, PITCHES.index(case[0]), PITCHES.index(case[1])])
    pairs = tuple(pair(rng, *case) for _ in range(PAIRS))
    linkage = linkage_of(pairs)
    return pairs, linkage, design_space(linkage, max_order=0)


def parts(space):
    """Rows of the basis that belong to bodies a and b, each (pairs, 10, nullity)."""
    rows = space.basis.reshape(len(space.bodies), 10, -1)
    assert len(rows) == 2 * PAIRS and not space.planar
    return [rows[[space.bodies.index(f"{x}{k}") for k in range(PAIRS)]] for x in "ab"]


def families(pairs):
    return [balancing_family(one.a, one.wanted) for one in pairs]


def test_all_nine_cases_are_drawn():
    assert len(set(CASES)) == 9
    for case in CASES:
        for found in families(drawn(case, 0)[0]):
            assert (found.twist_pitch, found.momentum_pitch) == case


@pytest.mark.table(1)
@pytest.mark.parametrize("case", POSSIBLE)
def test_closed_form_is_the_null_space_of_order_0(case):
    """As affine sets of parameters of bodies a, with bodies b as they are: both ways."""
    rng = np.random.default_rng(5)
    for number in range(LINKAGES):
        pairs, _, space = drawn(case, number)
        a, b = parts(space)
        size = b.shape[2]
        found = families(pairs)
        wanted = np.array([one.z for one in pairs]).ravel()
        fixed = b.reshape(-1, size)
        y = np.linalg.lstsq(fixed, wanted, rcond=None)[0]
        assert relative(fixed @ y, wanted) < 1e-10
        # The free directions of the conditions, and those of the closed forms.
        left = size - np.linalg.matrix_rank(fixed, 1e-8)
        assert left == PAIRS * FREE[case[0]] == sum(one.basis.shape[1] for one in found)
        # Two members of each family, with body b of the pair and nothing else: in the space?
        targets = np.zeros((2 * PAIRS, 2, PAIRS, 10))
        for k, one in enumerate(found):
            other = one.z + one.basis @ rng.standard_normal(one.basis.shape[1])
            targets[2 * k : 2 * k + 2, 0, k] = one.z, other
            targets[2 * k : 2 * k + 2, 1, k] = pairs[k].z
        basis = np.concatenate([a, b]).reshape(-1, size)
        assert outside(targets.reshape(2 * PAIRS, -1).T, basis) < 1e-10


@pytest.mark.parametrize("case", POSSIBLE)
def test_momentum_by_differences_vanishes(case):
    """Of bodies that can exist, solved by `balance_pose`."""
    for number in range(LINKAGES):
        pairs, linkage, _ = drawn(case, number)
        least = [one.least_mass for one in families(pairs)]
        free = case[0] == "zero"
        masses = {f"a{k}": 2.0 * m or 1.0 for k, m in enumerate(least)} if free else None
        found = balance_pose(linkage, masses)
        names = [body.name for body in linkage.bodies]
        assert found.words.startswith("balanced") and found.residual < 1e-12
        for k, one in enumerate(pairs):
            z = found.z[names.index(f"a{k}")]
            assert not violations(z)
            # Relative to the terms, which cancel where the body is far from the axis.
            size = max(np.abs(one.wanted).max(), np.abs(z).max() * np.abs(one.a).max())
            assert np.abs(momentum(one.a, z) - one.wanted).max() < 1e-10 * size


@pytest.mark.parametrize("case", POSSIBLE)
def test_the_convex_problem_finds_members_of_the_families(case):
    for number in range(LINKAGES):
        pairs, _, space = drawn(case, number)
        kept = [f"b{k}" for k in range(PAIRS)]
        best = design(space, keep=kept, within=None, one_pose=True, density=None)
        assert best.verdict == "feasible" and best.residuals.accepted
        for k, one in enumerate(families(pairs)):
            z = best.z[space.bodies.index(f"a{k}")]
            scale = np.abs(z).max()
            off = (z - one.z) / scale
            assert one.possible
            y = np.linalg.lstsq(one.basis, off, rcond=None)[0]
            assert np.abs(one.basis @ y - off).max() < 1e-10
            if one.mass is None:
                assert z[0] > one.least_mass
            else:
                assert relative(z[0], one.mass) < 1e-10


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_impossible_cases_have_no_solution_or_no_mass(case):
    for number in range(LINKAGES):
        pairs, _, space = drawn(case, number)
        a, b = parts(space)
        size = b.shape[2]
        fixed = b.reshape(-1, size)
        _, values, right = np.linalg.svd(fixed)
        free = right[np.count_nonzero(values > 1e-8) :].T
        wanted = np.zeros((PAIRS, PAIRS, 10))  # body b of one pair at a time
        wanted[range(PAIRS), range(PAIRS)] = [one.z for one in pairs]
        columns = wanted.reshape(PAIRS, -1).T
        y = np.linalg.lstsq(fixed, columns, rcond=None)[0]
        misses, sizes = np.abs(fixed @ y - columns).max(axis=0), np.abs(columns).max(axis=0)
        for k, one in enumerate(families(pairs)):
            assert not one.possible and one.reason
            with pytest.raises(UsageError, match="no body has this momentum"):
                one.body(1.0)
            mass = abs(a[k, 0] @ y[:, k]) + np.abs(a[k, 0] @ free).max(initial=0.0)
            assert (misses[k] > 1e-6 * sizes[k]) == bool(one.unmet)
            assert one.unmet or max(misses[k], mass) < 1e-10 * sizes[k]


@pytest.mark.table
@pytest.mark.parametrize("case", CASES)
def test_the_verdict_is_that_of_the_convex_problem(case):
    """Six linkages of one random pair for each case, that can be balanced and not."""
    rng = np.random.default_rng(11)
    seen = set()
    for k in range(6):
        one = pair(rng, *case)
        one = replace(one, ratio=one.ratio * (-1) ** k)  # no body exists for the other sense
        space = design_space(linkage_of([one]), max_order=0)
        best = design(space, keep=["b0"], within=None, one_pose=True, density=None)
        found = balancing_family(one.a, one.wanted)
        seen.add(found.possible)
        assert best.verdict == ("feasible" if found.possible else "infeasible")
        assert best.residuals.accepted
    assert seen == ({False} if case in IMPOSSIBLE else {False, True})


def test_a_pose_without_the_relation_of_the_table_is_refused():
    """ω ⊥ p for a body that turns; a body that slides needs p along its axis."""
    turn, slide = [0, 0, 1, 0, 0, 0], [0, 0, 0, 0, 0, 1]
    assert balancing_family(turn, [0, 0, 1, 0, 0, 1]).unmet == ("ω ⊥ p",)
    assert balancing_family(slide, [0, 0, 0, 1, 0, 1]).unmet == ("v ∥ p",)
    assert balancing_family(slide, [0, 0, 1, 0, 0, 1]).unmet == ("v ⊥ ξ",)
    assert balancing_family(slide, [1, 0, 0, 0, 0, 1]).possible


def test_the_minus_sign_printed_in_equation_3_36_is_wrong():
    """[J] Eq. 3.36 puts the centre of mass on the other side of the origin."""
    rng = np.random.default_rng(2)
    one = pair(rng, "finite", "finite")
    found = balancing_family(one.a, one.wanted)
    w, v, p = one.a[:3], one.a[3:], one.wanted[3:]
    right = np.cross(w, found.mass * v - p) / (found.mass * w @ w)
    c = found.body()[1:4] / found.mass
    assert relative(c - (c @ w) * w, right) < 1e-10
    wrong = parameters(found.mass, (c @ w) * w - right, np.eye(3))
    assert relative(momentum(one.a, wrong)[3:], p) > 0.1
