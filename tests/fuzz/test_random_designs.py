"""Verdicts on random designs, and what bounds and kept links add to a certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.checks import check_certificate
from balance.masses.designs.best_design import design
from balance.masses.designs.certificate import _split_known_terms
from balance.masses.designs.certificate_search import conflict_certificate
from balance.masses.designs.constraints import build_program, constraints_of
from balance.masses.designs.pseudo_inertia_cone import matrices_of
from tests.fuzz.random_designs import Question, asked, check, matrix, question, run
from tests.independent.second_solvers import SETTLED
from tests.support.laws import bounded_cloud
from tests.support.shapes import quadrilateral
from tests.support.urdf_text import along, joint

INERTIAL = (
    '<inertial><origin xyz="{}"/><mass value="{}"/>'
    '<inertia ixx="0.21" iyy="0.29" izz="0.25" ixy="0" ixz="0" iyz="0"/></inertial>'
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seeds", "uneven"), [(range(40_000, 40_030), False), (range(50_000, 50_010), True)]
)
def test_random_designs(seeds, uneven):
    """A sample of ``python -m tests.fuzz.random_designs --cases 1500``."""
    ends = set()
    for seed, one, end, wrong in run(seeds, uneven):
        assert not wrong, f"seed {seed}: {one}: {wrong}"
        ends.add(end)
    assert {"feasible", "infeasible"} <= ends


@pytest.mark.parametrize("seed", [7149, 90135, 90170])
def test_bounds_far_from_other_masses_are_heeded(seed, tmp_path):
    """They were missed by 1e-7 of them, where other masses are a million times as large."""
    one = question(seed, tmp_path, True)._replace(within=None)
    found = asked(one)
    assert found.verdict == "feasible" and check(one, found) == "feasible"
    of_steel = design(found.space, keep=one.keep, bounds=one.bounds, within=None)
    assert of_steel.verdict != "feasible" or of_steel.densest[1] < 7850.001


@pytest.mark.slow
def test_the_check_of_designs_can_fail():
    """Designs and certificates that are changed, and what others decide, are noticed."""
    good = Question("four_bar_kite_balanced", "dynamic", (), {"crank": (0.5, 2.0)})
    bad = Question("four_bar_general", "dynamic", (), {})
    found, none = asked(good), asked(bad)
    assert check(good, found) == "feasible" and check(bad, none) == "infeasible"
    more = found.z.copy()
    more[0, 1] += 1e-6 * more[0, 0]
    certificate = np.array(none.certificate)
    certificate[1, 0, 0] *= 1.0 + 1e-5
    narrow = good._replace(bounds={"crank": (5.0, 6.0)})
    for one, wrong in (
        (good, replace(found, z=more)),
        (narrow, found),
        (bad, replace(none, certificate=tuple(certificate))),
        (bad, replace(none, certificate=tuple(-np.array(none.certificate)))),
        (good, replace(found, verdict="undecided", z=None)),
        (bad, replace(none, verdict="undecided", certificate=None)),
    ):
        caught = False
        try:
            check(one, wrong)
        except AssertionError:
            caught = True
        assert caught, wrong.words + str(one)
    assert SETTLED == 1e-9


def sliding_loop(folder):
    """A planar linkage with a body on a slide whose force nothing can balance."""
    bodies = [
        ("L1", "-0.066 -0.188 -0.165", 1.072),
        ("L2", "0.159 -0.025 -0.076", 0.652),
        ("L3", "0.299 0.180 0", 0.643),
        ("L4", "0.224 -0.259 0", 1.602),
    ]
    links = "".join(
        f'<link name="{name}">{INERTIAL.format(com, mass)}</link>' for name, com, mass in bodies
    )
    joints = "".join(
        joint(name, kind, parent, child, along(at), axis)
        for name, kind, parent, child, at, axis in (
            ("j1", "continuous", "base", "L1", (1.8, 2.4, 0), (0, 0, 1)),
            ("j2", "continuous", "L1", "L2", (0.7, -2.4, 0), (0, 0, 1)),
            ("j4", "continuous", "base", "L3", (0.26, 1.68, 0), (0, 0, 1)),
            ("j5", "prismatic", "L2", "L4", (-4.97, -0.04, 0), (1, 0, 0)),
        )
    )
    loop = (
        '<loop name="loop1" type="revolute"><predecessor link="L2"><origin xyz="-2.5 0 0"/>'
        '</predecessor><successor link="L3"><origin xyz="-0.26 -1.68 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>'
    )
    path = folder / "sliding.urdf"
    text = f'<robot name="m"><link name="base"/>{links}{joints}{loop}</robot>'
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    "bounds",
    [
        {},
        {"L3": (0.1, 2.0), "L4": (0.0, 1.0)},
        {"L4": (0.0, np.inf)},
        {"L4": (0.2, 1.0)},
        {"L4": (0.3, 0.3)},
        {"L4": (0.0, 1e-9)},
    ],
)
@pytest.mark.parametrize("keep", [(), ("L1",)])
def test_a_bound_that_says_nothing_takes_nothing(keep, bounds, tmp_path):
    """The slide's body has no mass in any balanced distribution, whatever its bounds."""
    space = design_space(kinematics.load(sliding_loop(tmp_path)), balance="force")
    found = design(space, keep=keep, bounds=bounds)
    assert found.verdict == "infeasible" and "the masses of L4 are zero" in found.words
    assert found.residuals.separation < 1e-13
    assert type(found.residuals.accepted) is bool


def test_bounds_do_not_undo_a_proof():
    """What nothing balances is not balanced by less; the certificate need not use bounds."""
    for model in ("four_bar_general", "bennett", "rusr", "six_bar_watt"):
        space = design_space(kinematics.load(model))
        certificate = design(space).certificate
        name = space.bodies[-1]
        for low, high in ((0.0, np.inf), (0.0, 1e-9), (1e-6, 1e6), (3.0, 3.0)):
            asked_for = constraints_of(space, [], {name: (low, high)})
            assert check_certificate(space, certificate, asked_for).accepted


@pytest.mark.table
@pytest.mark.parametrize("seed", range(40))
def test_what_is_known_is_a_lower_bound(seed):
    """``Σ <Z, P> ≥ Σ <own, P> + known T0`` for all masses that heed what is asked."""
    rng = np.random.default_rng(seed)
    space = design_space(kinematics.load("four_bar_kite_balanced"))
    names = list(rng.permutation(space.bodies))
    size = 10.0 ** rng.uniform(-9, 2)
    bounds = {}
    for name in names[: 1 + seed % 2]:
        low, more = size * rng.random(2) * [seed % 3 > 0, 1.0]
        bounds[name] = (float(low), float(low + more + 1e-3 * size))
    wanted = constraints_of(space, names[2:] * (seed % 4 > 1), bounds)
    root = rng.standard_normal((3, 3, 3))
    Z = root @ root.transpose(0, 2, 1)
    Z[:, 2, 2] += rng.uniform(-6.0, 1.0, 3)
    own, known = _split_known_terms(space, Z, wanted)
    file = np.array([body.inertia for body in space.linkage.bodies])
    least = sum(low for low, _ in wanted.bounds.values())
    least += sum(np.trace(matrices_of(space, file)[b]) for b in wanted.keep)
    if least == 0.0:
        assert known <= 0.0 and not (known and np.isfinite(known))
        known = 0.0 if known == 0.0 else -np.inf
    for _ in range(30):
        z = np.array([bounded_cloud(rng, 0.1, 5.0) for _ in space.bodies])
        for b, (low, high) in wanted.bounds.items():
            z[b] *= rng.choice([low or 0.5 * high, high]) / z[b, 0]
        z[list(wanted.keep)] = file[list(wanted.keep)]
        P = matrices_of(space, z)
        left, right = np.sum(Z * P), np.sum(own * P) + (known * least if least else 0.0)
        assert right <= left + 1e-10 * np.abs(Z * P).sum() or known == -np.inf


@pytest.mark.parametrize("entry", ["dynamic", "force"])
def test_a_link_without_mass_may_be_kept(entry, tmp_path):
    """Its matrix is zero, and has no centre: no division by nothing."""
    text = kinematics.gallery()["five_bar"].read_text(encoding="utf-8")
    path = tmp_path / "light.urdf"
    start = text.index("<inertial")
    path.write_text(text[:start] + text[text.index("</inertial>") + 11 :], encoding="utf-8")
    space = design_space(kinematics.load(path, bodies="all"), balance=entry)
    empty = [b.name for b in space.linkage.bodies if b.inertia[0] == 0.0]
    assert empty and design(space, keep=empty).verdict in ("feasible", "infeasible")


def test_questions_follow_from_their_seed(tmp_path):
    assert question(7, tmp_path) == question(7, tmp_path) != question(8, tmp_path)
    assert np.array_equal(matrix(np.eye(10)[0]), np.diag([0.0, 0.0, 0.0, 1.0]))


def test_kept_links_that_say_the_same_twice():
    """Force balance of a parallelogram: rows of two kept cranks depend on one another."""
    rng = np.random.default_rng(11)
    for _ in range(12):
        a, b = rng.uniform(-2.0, -1.0), rng.uniform(-1.0, -0.4)
        corners = np.array([[0.0, 0.0], [a, b], [a + 1.5, b], [1.5, 0.0]])
        space = design_space(quadrilateral(corners, 3, rng), balance="force")
        found = design(space, keep=[space.bodies[0], space.bodies[2]])
        assert space.rank == 2 and found.verdict == "infeasible"
        assert found.residuals.separation < 1e-12
        # Whatever the round-off in these rows, multipliers of their difference stay bounded.
        question = build_program(space, constraints_of(space, found.keep, {}))
        noise = 1e-14 * rng.standard_normal(question.fixed.shape)
        moved = conflict_certificate(question._replace(fixed=question.fixed + noise)).matrices
        assert np.abs(moved - conflict_certificate(question).matrices).max() < 1e-9
