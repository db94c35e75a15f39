"""Readable bases: they span what they should, and say it in the words of a designer."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.momentum import momentum_regressor
from balance.space.inertial_parameters.multipole import rod
from balance.space.interpretation.explain import explain
from balance.space.interpretation.freedoms import (
    SparseSearch,
    parallel_freedoms,
    summarise,
    transfer_freedoms,
)
from balance.space.interpretation.terms import candidate_terms, describe_terms, term_vectors
from tests.support.covering import spread
from tests.support.figures import FIGURES, Figure
from tests.support.laws import (
    altered,
    known,
    outside,
    placed,
    relative,
    renamed,
    resized,
    space,
    unit_vector,
)
from tests.support.urdf_text import UNIT_INERTIA, about, joint, link, pose_of, saved

CLOSED = tuple(figure for figure in FIGURES if figure.parallel != 0)
AXIS = "a point mass on the axis, a displacement along the axis, a rod along the axis"
PAIRS = "two ± pairs of rods across the axis"
U2_U3 = next(figure for figure in FIGURES if figure.motion == ("u2=u3",))


@cache
def freed(figure: Figure):
    """The design space of a row of the table, and its parallel freedoms."""
    found = known(figure)
    return found, parallel_freedoms(found)


def of(model, balance="dynamic", spatial=False):
    """The words of the parallel freedoms of a model."""
    found = design_space(kinematics.load(model), None, balance, spatial=spatial)
    return [freedom.words for freedom in parallel_freedoms(found)]


def columns(freedoms):
    """Vectors of freedoms as unit columns."""
    vectors = np.array([freedom.vector for freedom in freedoms]).T
    return vectors / np.linalg.norm(vectors, axis=0)


def same_span(one, other):
    """Whether two sets of columns, as many each, span one space."""
    assert one.shape == other.shape
    one, other = (c / np.linalg.norm(c, axis=0) for c in (one, other))
    return max(outside(one, other), outside(other, one)) < 1e-10


@pytest.mark.table
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 2), ids=str)
def test_serial_and_parallel_freedoms_span_the_space(figure):
    found, freedoms = freed(figure)
    assert len(freedoms) == found.nullity - found.serial_nullity
    if freedoms:
        assert outside(columns(freedoms), found.basis) < 1e-10
    size = np.abs(found.basis).max(axis=1)[:, None]
    size[size == 0.0] = 1.0
    both = np.column_stack([found.serial / size, *(f.vector[:, None] / size for f in freedoms)])
    sizes = np.linalg.svd(both / np.linalg.norm(both, axis=0), compute_uv=False)
    assert sizes.size == found.nullity and sizes[-1] > 1e-6


@pytest.mark.table(3)
@pytest.mark.parametrize("figure", spread(FIGURES, 2, 0), ids=str)
def test_transfer_freedoms_span_the_transfers(figure):
    found, _ = freed(figure)
    for transfer in found.transfers:
        freedoms = transfer_freedoms(found, transfer)
        assert len(freedoms) == transfer.dimension
        if freedoms:
            assert same_span(columns(freedoms), transfer.basis)
            bodies = {p.body for freedom in freedoms for p in freedom.primitives}
            assert bodies == set(transfer.bodies)


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", CLOSED, ids=str)
def test_a_freedom_is_the_sum_of_its_primitives(figure):
    found, freedoms = freed(figure)
    transferred = [f for t in found.transfers for f in transfer_freedoms(found, t)]
    for freedom in (*freedoms, *transferred):
        z = np.zeros((len(found.bodies), 10))
        for primitive in freedom.primitives:
            z[found.bodies.index(primitive.body)] += primitive.parameters()
            if primitive.direction is not None:
                assert abs(np.linalg.norm(primitive.direction) - 1.0) < 1e-14
        if found.planar:
            n = found.axes[2]
            E = np.array(
                [[[b[4], b[7], b[8]], [b[7], b[5], b[9]], [b[8], b[9], b[6]]] for b in z]
            )
            moments = np.einsum("bij,i,j->b", E, n, n)
            z = np.column_stack([z[:, 0], z[:, 1:4] @ found.axes[:2].T, moments])
        assert relative(freedom.vector, z[:, : len(found.labels)].ravel()) < 1e-13
        assert not freedom.vector.flags.writeable
        assert max(abs(p.value) for p in freedom.primitives) == 1.0
        assert freedom.primitives[0].value > 0.0
        data = json.loads(json.dumps(freedom.to_dict()))
        assert data["words"] == freedom.words
        assert len(data["primitives"]) == len(freedom.primitives)


def test_planar_linkages_in_one_line():
    assert of("four_bar_antiparallelogram") == [
        "rod +1 on the crank, -1 on the coupler, +1 on the rocker"
    ]
    assert of("slider_crank") == ["rod +1 on the crank, +1 on the coupler"]
    assert of("four_bar_general") == []


@pytest.mark.parametrize("model", ["four_bar_kite", "four_bar_antiparallelogram"])
def test_rods_have_the_signs_of_the_angular_velocities(model):
    """Rods that balance satisfy Σ E ω = 0 in every pose; the loop gives the velocities."""
    found = design_space(kinematics.load(model))
    (freedom,) = parallel_freedoms(found)
    by_name = {j.name: j.point for j in found.linkage.joints}
    a, b, c, d = (by_name[name] for name in ("u1", "q2", "q3", "q4"))
    # Velocity of q3 by way of either side: ω1 (b - a) + ω2 (c - b) = ω3 (c - d).
    sides = np.column_stack([c - b, -(c - d)])[:2]
    w2, w3 = np.linalg.solve(sides, -(b - a)[:2])
    values = {p.body: p.value for p in freedom.primitives}
    assert {p.kind for p in freedom.primitives} == {"rod"}
    assert sorted(np.abs(list(values.values()))) == [1.0, 1.0, 1.0]
    assert abs(values["crank"] + values["coupler"] * w2 + values["rocker"] * w3) < 1e-12


def test_names_come_from_the_file(tmp_path):
    path = altered("four_bar_antiparallelogram", tmp_path, renamed)
    words = "rod +1 on the x_crank_9, -1 on the x_coupler_9, +1 on the x_rocker_9"
    assert of(path) == [words]


@pytest.mark.parametrize("model", ["four_bar_antiparallelogram", "bennett"])
def test_words_do_not_depend_on_the_frame(model, tmp_path):
    path = altered(model, tmp_path, placed(pose_of([3.0, -2.0, 1.0], [0.3, -0.8, 1.1])))
    assert sorted(of(path)) == sorted(of(model))


def test_force_balance_of_a_loop_is_its_closure():
    """Displacements across the links, as long as the links."""
    found = design_space(kinematics.load("five_bar"), None, "force")
    (freedom,) = parallel_freedoms(found)
    points = {j.name: j.point for j in found.linkage.joints}
    links = (("u1", "q2"), ("q2", "q3"), ("u2", "q4"), ("q4", "q3"))
    lengths = np.array([np.linalg.norm(points[a] - points[b]) for a, b in links])
    values = np.array([p.value for p in freedom.primitives])
    assert relative(np.abs(values), lengths / lengths.max()) < 1e-12
    assert list(np.sign(values)) == [1, 1, -1, -1]
    assert freedom.words.startswith("displacement across u1-q2 +")


def test_rods_of_the_3rsr_are_those_of_the_thesis():
    """J. J. de Jong, equations 5.74 to 5.77: a7 lies in the plane, perpendicular to n1."""
    found, freedoms = freed(U2_U3)
    at = {j.name: j for j in found.linkage.joints}
    r = {
        name: at[name].point
        for name in ("u1", "u2", "u3", "platform1", "platform2", "platform3", "elbow1_y")
    }
    r |= {"elbow2": at["elbow2.0"].point, "elbow3": at["elbow3.0"].point}

    def unit(a, b):
        return (r[b] - r[a]) / np.linalg.norm(r[b] - r[a])

    def n(name):
        return at[name].screw[:3]

    def upper(elbow, platform):
        a = unit(elbow, platform)
        return 0.5 * (rod(a) + rod(np.cross(n(platform), a)))

    middle = (r["platform1"] + r["platform2"] + r["platform3"]) / 3.0
    a7 = r["platform1"] - middle
    a7 /= np.linalg.norm(a7)
    assert abs(a7 @ n("u1")) < 1e-15
    phi = 2.0 * np.pi / 3.0
    first = {
        "lower1": rod(unit("u1", "elbow1_y")),
        "upper1": upper("elbow1_y", "platform1"),
        "platform": -rod(a7),
    }
    second = {
        "lower2": rod(unit("u2", "elbow2")),
        "upper2": upper("elbow2", "platform2"),
        "lower3": rod(unit("u3", "elbow3")),
        "upper3": upper("elbow3", "platform3"),
        "platform": (-0.5 * np.cos(2.0 * phi) - 1.5) * rod(a7),
    }
    zero = np.zeros(10)
    z = [np.concatenate([v.get(body, zero) for body in found.bodies]) for v in (first, second)]
    z = np.array(z).T
    assert outside(z, found.basis) < 1e-10
    # Neither is a transfer; and what is printed is the same, but for transfers.
    assert outside(z[:, :1], found.serial) > 0.1 and outside(z[:, 1:], found.serial) > 0.1
    assert outside(z, np.column_stack([found.serial, columns(freedoms)])) < 1e-10
    assert freedoms[0].words == (
        "rod along u1-elbow1_y +1 on the lower1; "
        "rod along elbow1_y-platform1 +1 on the upper1; "
        "rod along platform1-middle -1 on the platform"
    )
    values = [Fraction(abs(p.value)).limit_denominator(9) for p in freedoms[1].primitives]
    assert sorted(values) == [Fraction(2, 5)] * 4 + [Fraction(4, 5)] * 2 + [Fraction(1)]
    assert {p.kind for p in freedoms[1].primitives} == {"rod"}


@pytest.mark.table(1)
@pytest.mark.parametrize("figure", CLOSED, ids=str)
def test_the_vocabulary_says_everything(figure):
    """Of every body that moves, and each name means one thing."""
    found, _ = freed(figure)
    terms = candidate_terms(found)
    for body in found.bodies:
        own = [term for term in terms if term.primitives[0].body == body]
        D = term_vectors(found, [p for term in own for p in term.primitives], True)
        assert np.linalg.matrix_rank(D, 1e-9) == len(found.labels)
        assert len({term.name for term in own}) == len(own)


def test_what_cannot_be_said_in_few_terms_is_still_exact(monkeypatch):
    monkeypatch.setattr(SparseSearch, "sparse", lambda self, w: None)
    figure = next(f for f in FIGURES if f.model == "scissor_three_stage")
    found = space(figure)
    freedoms = parallel_freedoms(found)
    assert len(freedoms) == figure.parallel
    assert outside(columns(freedoms), found.basis) < 1e-10
    both = np.column_stack([found.serial, columns(freedoms)])
    assert same_span(both, found.basis)


def test_numbers_are_fractions_only_if_they_are():
    term = candidate_terms(design_space(kinematics.load("four_bar_kite")))[0]
    name = f"{term.name} {{}} on the crank"
    for value, text in (
        (1.0, "+1"),
        (-0.5, "-1/2"),
        (5 / 12, "+5/12"),
        (1 / 3, "+1/3"),
        (1 / 13, "+0.0769231"),
        (0.5 + 1e-8, "+0.5"),
        (-np.pi, "-3.14159"),
        (1e-9 / 3, "+3.33333e-10"),
    ):
        assert describe_terms([term.times(value)]) == name.format(text)


def two_links(tmp_path, first, kind, n, second, more=""):
    """A chain: a joint at the ground, then the joint in question, at random places."""
    rng = np.random.default_rng(5)
    parts = [
        link("base"),
        link("a", **UNIT_INERTIA),
        link("b", **UNIT_INERTIA),
        joint("j1", first, "base", "a", pose_of(rng.normal(size=3), np.zeros(3)), n),
        joint("j2", kind, "a", "b", pose_of(rng.normal(size=3), np.zeros(3)), second, more),
    ]
    found = design_space(kinematics.load(saved(tmp_path, *parts)), spatial=True)
    return [(t, transfer_freedoms(found, t)) for t in found.transfers]


OBLIQUE = (1.0, 2.0, -0.7)
PITCH = '<screw_thread_pitch value="0.3"/>'


@pytest.mark.parametrize(
    ("kind", "more", "parallel", "skew"),
    [
        ("continuous", "", f"{AXIS}, {PAIRS}", AXIS),
        (
            "continuous",
            PITCH,
            f"a displacement along the axis, a rod along the axis, {PAIRS}",
            "a rod along the axis",
        ),
        ("prismatic", "", "a displacement along the axis, six rods", "six rods"),
        (
            "cylindrical",
            "",
            f"a displacement along the axis, a rod along the axis, {PAIRS}",
            "a rod along the axis",
        ),
        ("universal", "", "a point mass at the centre", "a point mass at the centre"),
        ("spherical", "", "a point mass at the centre", "a point mass at the centre"),
        ("planar", "", f"a rod along the axis, {PAIRS}", "a rod along the axis"),
    ],
)
def test_transfers_of_every_joint_in_words(kind, more, parallel, skew, tmp_path):
    limits = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    for below, words in ((OBLIQUE, parallel), (unit_vector(np.random.default_rng(1)), skew)):
        base, (transfer, freedoms) = two_links(
            tmp_path, "continuous", kind, below, OBLIQUE, limits + more
        )
        assert summarise(base[1]) == f"{AXIS}, {PAIRS}"
        assert [p.body for f in base[1] for p in f.primitives] == ["a"] * 7
        assert summarise(freedoms) == words
        for freedom in freedoms:
            half = len(freedom.primitives) // 2
            gives, takes = freedom.primitives[:half], freedom.primitives[half:]
            assert [p.body for p in gives] == ["a"] * half
            assert [p.body for p in takes] == ["b"] * half
            assert [p.value for p in gives] == [-p.value for p in takes]


def test_the_primitives_of_a_revolute_joint(tmp_path):
    """The point mass on the axis, displacement and rod along it, pairs across it."""
    (_, base), _ = two_links(tmp_path, "continuous", "spherical", OBLIQUE, OBLIQUE)
    n = np.array(OBLIQUE) / np.linalg.norm(OBLIQUE)
    mass, moved, along, *pairs = base
    here = mass.primitives[0].point
    assert (
        abs(
            about(n, 0.7, np.random.default_rng(5).normal(size=3)) @ [*here, 1.0] - [*here, 1.0]
        ).max()
        < 1e-12
    )
    assert np.linalg.norm(np.cross(moved.primitives[0].direction, n)) < 1e-12
    assert np.linalg.norm(np.cross(along.primitives[0].direction, n)) < 1e-12
    for pair in pairs:
        one, other = pair.primitives
        assert one.value == -other.value == 1.0
        assert max(abs(one.direction @ n), abs(other.direction @ n)) < 1e-12
        assert abs(one.direction @ other.direction) < 1e-12


def test_bodies_that_are_rigidly_joined_exchange_everything():
    """With one arm at rest, its bodies are part of the ground and may have any inertia."""
    found = design_space(kinematics.load("hprs"), ["helical=0", "prismatic=0"])
    rigid = [t for t in found.transfers if not t.joints]
    assert rigid
    for transfer in rigid:
        freedoms = transfer_freedoms(found, transfer)
        assert same_span(columns(freedoms), transfer.basis)
        count = "two" if transfer.dimension == 20 else "a"
        assert summarise(freedoms).startswith(f"{count} point mass")


def test_nothing_is_moved_across_joints_that_pass_nothing():
    found = freed(FIGURES[0])[0]
    empty = found.transfers[0]._replace(basis=np.zeros((12, 0)))
    assert transfer_freedoms(found, empty) == ()
    assert summarise(()) == ""


@pytest.mark.parametrize("factor, away", [(1.0, 1e3), (1e-6, 0.0), (1e6, 1e3), (1e-3, 1e2)])
def test_words_and_transfers_hold_at_any_size_and_place(tmp_path, factor, away):
    model = "four_bar_antiparallelogram"
    H = np.eye(4)
    H[:3, 3] = away * factor * np.array([0.6, 0.8, 0.0])
    found = design_space(kinematics.load(altered(model, tmp_path, resized(factor), placed(H))))
    usual = explain(design_space(kinematics.load(model)))
    meaning = explain(found)
    assert [t.words for t in meaning.transfers] == [t.words for t in usual.transfers]
    assert [f.words for f in meaning.freedoms] == [f.words for f in usual.freedoms]
    if away * factor > 1e6:  # the pose itself is not known to more digits out there
        return
    X = momentum_regressor(found.linkage, {"u1": 0.4})
    moved = np.concatenate([transfer.basis for transfer in found.transfers], axis=1)
    size = np.abs(X) @ np.abs(moved)
    assert np.all(np.abs(X @ moved) <= 1e-12 * (1.0 + away) * size.max(axis=-1, keepdims=True))
