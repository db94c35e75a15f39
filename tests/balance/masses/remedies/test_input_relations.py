"""Relations between inputs: the list of candidates, the search, and the words."""

from __future__ import annotations

from itertools import product
from math import gcd

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.constraints import input_relations
from balance.masses.remedies.constraints.input_relations import (
    RelationSearch,
    apply_input_relation,
    free_inputs,
    inertia_needs,
    search_relations,
    turning_ratios,
)
from balance.masses.remedies.constraints.relation_candidates import _primitive, candidates
from balance.masses.remedies.request import RemedyRequest
from kinematics import Motion
from kinematics.model.document.element import Document
from tests.support.limited_process import run_limited
from tests.support.remedy_requests import SLENDER, request_of, rod


@pytest.mark.parametrize(("inputs", "dimension"), [(2, 1), (3, 1), (3, 2)])
def test_all_subspaces_of_small_numbers_are_tried_once(inputs, dimension):
    """As many as primitive vectors up to sign, whether they are columns or rows."""
    every = {
        v
        for v in product(range(-3, 4), repeat=inputs)
        if gcd(*v) == 1 and next(x for x in v if x) > 0
    }
    found = candidates(inputs, dimension)
    vectors = [one.columns[0] if dimension == 1 else one.rows[0] for one in found]
    assert len(vectors) == len(set(vectors)) == len(every) and set(vectors) == every
    sizes = [max(map(abs, v)) for v in vectors]
    assert sizes == sorted(sizes)


@pytest.mark.parametrize(
    ("inputs", "dimension"), [(2, 1), (3, 1), (3, 2), (4, 1), (4, 2), (4, 3)]
)
def test_words_of_a_subspace_are_the_subspace(inputs, dimension):
    """The relations, read as ``--motion``, leave the same displacements."""
    names = [f"u{k + 1}" for k in range(inputs)]
    for one in candidates(inputs, dimension)[::7]:
        basis = Motion.parse(one.words(names), names).basis
        assert basis.shape == one.basis.shape == (inputs, dimension)
        assert np.linalg.matrix_rank(np.hstack([basis, one.basis])) == dimension
        assert one.holds(np.array(one.columns)).all()
        assert not one.holds(np.array(one.rows)).any()


def test_free_inputs_under_relations():
    arm = kinematics.load("zero_reaction_arm")
    names, basis = free_inputs(RemedyRequest(arm, ("u3=-12*u1-4*u2",)))
    assert len(names) == 2 and basis.shape == (3, 2)
    for column, name in zip(basis.T, names, strict=True):
        u = dict(zip(arm.inputs, column, strict=True))
        assert u[name] == 1.0
        assert u["u3"] == pytest.approx(-12 * u["u1"] - 4 * u["u2"])


@pytest.fixture(scope="module")
def principal():
    return RemedyRequest(kinematics.load("principal_vector_linkage"))


@pytest.fixture(scope="module")
def found(principal):
    return search_relations(principal)


def test_the_relation_of_the_principal_vector_linkage_is_found(found):
    """w1 = -w3, w2 = 0, and equal moments of inertia: as the source says."""
    first = found.balanced[0]
    assert first.space.as_given.balanced
    assert turning_ratios(first.space) == {"element1": 1.0, "element2": 0.0, "element3": -1.0}
    (need,) = inertia_needs(first.space)
    assert str(need) == "J(element1) = J(element3)"
    assert not any(one.space.as_given.balanced for one in found.balanced[1:])


def test_no_relation_that_leaves_two_freedoms_balances_it(principal, found):
    """The pruned search says the same as all planes, one by one."""
    assert {one.candidate.basis.shape[1] for one in found.balanced} == {1}
    linkage = principal.linkage
    for plane in candidates(3, 2)[::6]:
        space = balance.design_space(linkage, Motion(linkage.inputs, (), plane.basis))
        assert balance.masses.feasible(space).verdict == "infeasible"


def test_needs_have_the_factors_of_the_angular_velocities(found):
    """``Σ w_b J_b = constant`` where all bodies turn in fixed ratios."""
    for one in found.balanced:
        ratios = turning_ratios(one.space)
        (need,) = inertia_needs(one.space)
        assert need.factors.keys() == {name for name, x in ratios.items() if x}
        shares = [x / ratios[name] for name, x in need.factors.items()]
        assert shares == pytest.approx([shares[0]] * len(shares), rel=1e-9)


def test_the_constant_of_a_need_is_what_the_masses_ask(found):
    """With the moments of inertia changed to fulfil it, the masses of the file balance."""
    one = next(one for one in found.balanced[1:] if inertia_needs(one.space)[0].constant)
    (need,) = inertia_needs(one.space)
    z = np.array([body.inertia for body in one.space.linkage.bodies])
    own = z[:, 6] - (z[:, 1] ** 2 + z[:, 2] ** 2) / z[:, 0]
    left = sum(need.factors.get(n, 0.0) * j for n, j in zip(one.space.bodies, own, strict=True))
    name = next(iter(need.factors))
    z[one.space.bodies.index(name), 6] += (need.constant - left) / need.factors[name]
    direction = one.candidate.basis[:, 0]
    for size in (0.0, 0.2):
        X = balance.momentum.momentum_regressor(
            one.space.linkage, size * direction, spatial=True
        )
        assert np.abs(direction @ (X @ z.ravel())).max() < 1e-13


@pytest.mark.slow
def test_the_remedy_is_written_as_mimic_joints(principal):
    first = next(apply_input_relation(principal))
    assert first.verdict == "feasible" and first.lost_freedoms == 2
    assert first.added_mass == 0.0 and first.residual <= 1e-9
    assert first.details["built_as"] == "mimic" and not first.details["motion"]
    assert "J(element1) = J(element3)" in first.reason
    again = kinematics.load(Document("again.urdf", first.urdf))
    assert again.mobility == 1 and balance.verify(again, trajectories=2).balanced


@pytest.mark.slow
def test_a_relation_of_three_inputs_needs_a_gear(tmp_path):
    """The arm balances with two freedoms left, for every relation of terms of one sign."""
    arm = kinematics.load("zero_reaction_arm")
    first = next(apply_input_relation(RemedyRequest(arm)))
    assert first.verdict == "feasible" and first.lost_freedoms == 1
    assert first.details["built_as"] == "gear or slider"
    (relation,) = first.details["motion"]
    linkage = kinematics.load(Document("again.urdf", first.urdf), inputs=arm.inputs)
    assert balance.verify(linkage, motion=relation, trajectories=2).balanced
    assert not balance.verify(linkage, trajectories=1).balanced


def test_where_no_relation_helps_it_is_said():
    (found,) = apply_input_relation(RemedyRequest(kinematics.load("five_bar")))
    assert found.verdict == "infeasible" and "16 relations" in found.reason
    (one,) = apply_input_relation(RemedyRequest(kinematics.load("four_bar_general")))
    assert one.verdict == "refused" and "one freedom" in one.reason
    (none,) = apply_input_relation(RemedyRequest(kinematics.load("double_pendulum_duplicates")))
    assert none.verdict == "refused" and "no relation is needed" in none.reason


@pytest.mark.parametrize("inputs", [2, 3, 4])
def test_directions_are_in_the_order_of_their_sizes(inputs):
    """All of them are listed and sorted here; the search makes one after another."""
    for largest in (1, 2, 3):
        every = [
            v
            for v in product(range(largest, -largest - 1, -1), repeat=inputs)
            if max(map(abs, v)) == largest and gcd(*v) == 1 and next(x for x in v if x) > 0
        ]
        assert list(_primitive(inputs, largest)) == sorted(
            every, key=lambda v: sum(map(abs, v))
        )


@pytest.mark.slow
def test_candidates_of_many_inputs_take_little_memory():
    """22 inputs have 3**22 directions of -1, 0 and 1."""
    code = (
        "from balance.masses.remedies.constraints.relation_candidates import candidates\n"
        "print([len(candidates(22, dimension)) for dimension in (1, 11, 20, 21)])"
    )
    assert run_limited(code).stdout.strip() == "[400, 400, 400, 400]"


def test_relations_of_many_inputs_are_tried_if_the_user_insists(monkeypatch):
    rods = [rod("l1", "base", "0 0 0", 1.0, "0.5 0 0", SLENDER)]
    rods += [rod(f"l{k}", f"l{k - 1}", "1 0 0", 1.0, "0.5 0 0", SLENDER) for k in range(2, 8)]
    request, asked = request_of(*rods), []

    def search(request):
        asked.append(request)
        return RelationSearch((), 0, 1)

    monkeypatch.setattr(input_relations, "search_relations", search)
    (result,) = input_relations.apply_input_relation(request)
    assert result.verdict == "refused" and "2400 relations of 7 inputs" in result.reason
    assert "--only input_relation" in result.reason and not asked
    (result,) = compare_request(request, ["input_relation"]).results
    assert result.verdict == "infeasible" and len(asked) == 1


def test_what_is_undecided_of_relations_is_said(monkeypatch):
    """Not how many, which round-off may change, but what the user may do."""
    request = RemedyRequest(kinematics.load("principal_vector_linkage"))
    texts = set()
    for count in (1, 2):
        search = RelationSearch((), count, 290)
        monkeypatch.setattr(input_relations, "search_relations", lambda _, s=search: s)
        (result,) = apply_input_relation(request)
        texts.add((result.verdict, result.reason))
    ((verdict, reason),) = texts
    assert verdict == "undecided" and reason.startswith("under some of 290 relations")
    assert "balance design --motion" in reason


def test_inputs_that_rest_follow_one_that_moves():
    """Two inputs at rest both follow the third with ratio 0: no circle of mimics."""
    from balance.masses.remedies.constraints.input_relations import (
        InputRelation,
        _driven,
        _with_mimics,
    )

    arm = RemedyRequest(kinematics.load("zero_reaction_arm"))
    line = next(one for one in candidates(3, 1) if one.columns[0] == (0, 0, 1))
    relation = InputRelation(line, arm.linkage.inputs, arm.space, "feasible")
    driven = _driven(arm, relation)
    assert driven == {"u1": ("u3", 0.0), "u2": ("u3", 0.0)}
    again = kinematics.load(_with_mimics(arm.base, driven))
    assert again.mobility == 1 and again.inputs == ("u3",)
