"""Both verdicts where masses are limited to balls: their words, their proofs, their checks."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import design_space
from balance.app.cli.main import main
from balance.checks import check_certificate, check_design
from balance.masses.designs.constraints import constraints_of
from balance.masses.designs.mass_regions import ball_of, reach_of
from kinematics.closure.assembly.assemble import assemble
from tests.independent import reference
from tests.support import balls
from tests.support.designs import design_of_any_density
from tests.support.drafts import axis_edge, linked
from tests.support.laws import altered, placed, resized, sums
from tests.support.shapes import conditions, functional, matrix, outside

# A heavy coupler that is kept, and little mass to balance it.
BEYOND = "feasible anywhere (--anywhere, in Python within=None): "
CLASH = ("four_bar_general", ["coupler"], {"crank": (0.0, 0.1)})


def space_of(model, motion=None, **more):
    return design_space(kinematics.load(model), motion, **more)


def clashing(within=1.5):
    """No design within the balls, and one without them."""
    model, keep, bounds = CLASH
    return design_of_any_density(
        space_of(model, balance="force"), keep=keep, bounds=bounds, within=within
    )


def test_the_linkage_of_the_issue(tmp_path):
    """Force balance of a four-bar of 0.3 m: 10 g had a radius of gyration of 3 m, and with the
    coupler kept a centre of mass far away: 17.6 m by a floor of 0.01, 46 m by today's 0.001.
    """
    size = 0.3 / space_of("four_bar_general").length
    space = space_of(altered("four_bar_general", tmp_path, resized(size)), balance="force")
    for keep, within, gyration, away in (
        ((), None, 3.2, 0.2),
        ((), 1.5, 0.7, 0.3),
        (("coupler",), None, 26.0, 46.0),
        (("coupler",), 1.5, 0.14, 0.38),
    ):
        bodies = design_of_any_density(space, "mass", keep=keep, within=within).bodies
        k = [np.sqrt(np.linalg.eigvalsh(body.inertia)[-1] / body.mass) for body in bodies]
        assert max(k) == pytest.approx(gyration, rel=0.05)
        furthest = max(np.linalg.norm(body.link_com) for body in bodies)
        assert furthest == pytest.approx(away, rel=0.2)


def test_both_verdicts_are_told():
    found = clashing()
    assert found.verdict == "infeasible" and found.z is None and found.bodies == ()
    assert found.words.startswith("infeasible within 1.5 link lengths: with what is kept")
    beyond = found.anywhere
    assert beyond.verdict == "feasible" and beyond.within is None and beyond.anywhere is None
    assert check_design(found.space, beyond.z, beyond.constraints).accepted
    # The one that is furthest beyond its ball.
    ratios = {}
    for name, ball in found.balls.items():
        z = beyond.z[found.space.bodies.index(name)]
        away = np.linalg.norm((z[1:4] / z[0] - ball.centre)[:2])
        ratios[name] = away / ball.radius, away
    name = max(ratios, key=ratios.get)
    assert ratios[name][0] > 1.0
    away = f"centre of mass of {name} {ratios[name][1]:.2g} m away"
    assert found.words.endswith(f"; {BEYOND}{away}")
    assert found.balls.keys() == {"crank", "rocker"}, "what is kept has no ball"


def test_a_body_whose_mass_is_spread_too_far_is_told():
    """Its centre of mass is within the ball, its radius of gyration is not."""
    space = space_of("four_bar_antiparallelogram")
    found = design_of_any_density(space, within=0.5)
    told = found.words.rpartition("; ")[2]
    assert found.verdict == "infeasible" and told.startswith(BEYOND)
    asked = constraints_of(space, [], {}, 0.5)
    P = {name: matrix(z) for name, z in zip(space.bodies, found.anywhere.z, strict=True)}
    centres = [
        np.linalg.norm((P[name][:3, 3] / P[name][3, 3] - ball.centre)[:2]) / ball.radius
        for name, ball in found.balls.items()
    ]
    assert ("root mean square" in told) == (max(centres) <= 1.0) and asked.within == 0.5


def test_the_command_tells_both(capsys):
    words = ["design", CLASH[0], "--balance", "force", "--keep", "coupler"]
    words += ["--bounds", "crank=:0.1"]
    assert main([*words, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "infeasible" and found["within"] == 1.5
    assert found["anywhere"]["verdict"] == "feasible" and found["anywhere"]["bodies"]
    assert set(found["balls"]) == {"crank", "rocker"} and found["anywhere"]["balls"] == {}
    assert main(words) == 1
    text = capsys.readouterr().out
    assert "infeasible within 1.5 link lengths" in text and BEYOND in text
    assert text.startswith(f"Next: balance {' '.join(words)} --anywhere\n")
    assert "within 1.5 lengths of the link from the middle of its joints" in text
    assert main([*words, "--anywhere", "--json"]) == 0
    free = json.loads(capsys.readouterr().out)
    assert free["within"] is None and free["balls"] == {} and free["anywhere"] is None
    assert free["bodies"] == found["anywhere"]["bodies"]
    assert main([*words, "--anywhere"]) == 0
    assert "none: masses may be anywhere" in capsys.readouterr().out


def test_what_nothing_balances_is_told_once():
    """The proof without balls is the stronger one."""
    found = design_of_any_density(space_of("four_bar_general"))
    assert found.anywhere is None and not found.multipliers.any() and found.within == 1.5
    assert "within" not in found.words
    assert check_certificate(found.space, found.certificate).accepted


def test_a_wider_ball_holds_the_designs_of_a_narrower():
    space, radii = space_of("four_bar_kite"), (0.4, 1.0, 1.4, 1.5, 2.0, 4.0, 1e3, None)
    margins = [design_of_any_density(space, within=radius).margin for radius in radii]
    assert margins[:3] == [0.0] * 3 and 0.0 < margins[3] < 0.9 * margins[4]
    assert all(b >= 0.99999 * a for a, b in zip(margins, margins[1:], strict=False))
    # The solver knows a margin to about 1e-9 of the traces: here to 6e-6 of it.
    assert margins[-1] == pytest.approx(margins[-2], rel=1e-5)


# --- kept links, checks ---------------------------------------------------------------------


def test_a_link_that_is_kept_may_have_its_mass_anywhere():
    """The crank of the file, as heavy and as far away: it is none of the question's."""
    linkage = kinematics.load("four_bar_antiparallelogram_balanced")
    coupler = linkage.bodies[1]
    space = design_space(linkage)
    far = design_of_any_density(space, keep=["coupler"], within=0.9)
    wide = coupler.inertia.copy()
    wide[4:7] += [500.0, 500.0, 1000.0]
    spread = replace(
        linkage, bodies=(linkage.bodies[0], replace(coupler, inertia=wide), linkage.bodies[2])
    )
    kept = constraints_of(design_space(spread), ["coupler"], {}, 0.9)
    assert set(kept.balls) == {0, 2} and far.verdict == "feasible"
    assert np.array_equal(far.z[1], coupler.inertia)
    ball = ball_of(space, coupler, 0.9)
    assert reach_of(ball, balls.moments(np.ones(1), ball.centre[None] + 2.0)) > 1.0


def test_a_design_outside_its_ball_is_rejected():
    space = space_of("four_bar_kite")
    anywhere, within = (
        design_of_any_density(space, within=None),
        design_of_any_density(space, within=1.5),
    )
    asked = constraints_of(space, [], {}, 1.5)
    assert check_design(space, within.z, asked).accepted
    check = check_design(space, anywhere.z, asked)
    assert check.reach > 1.01 and not check.accepted
    assert check_design(space, anywhere.z).accepted
    narrower = constraints_of(space, [], {}, 1.5 * within.residuals.reach * (1.0 - 1e-6))
    assert not check_design(space, within.z, narrower).accepted


@pytest.mark.table(3)
@pytest.mark.parametrize(
    ("model", "within"),
    [
        ("four_bar_kite", 0.6),
        ("four_bar_kite", 1.0),
        ("slider_crank", 0.8),
        ("scissor_three_stage", 0.5),
        ("four_bar_antiparallelogram", 0.5),
        ("three_rsr", 0.3),
    ],
)
def test_certificates_exclude_what_is_in_the_balls(model, within):
    """By finite poses and point masses: the functional vanishes on balanced distributions, and
    is positive on any masses in the balls.
    """
    space = space_of(model, "u2=u3" if model == "three_rsr" else None)
    found = design_of_any_density(space, within=within)
    assert found.verdict == "infeasible" and found.anywhere.verdict == "feasible"
    Z, spare = np.array(found.certificate), found.multipliers
    assert (spare >= 0.0).all() and spare.any()
    value, still = functional(space, Z), balls.still(space)
    mechanism = reference.load(model)
    for b, name in enumerate(space.bodies):
        places = balls.places(mechanism, name) @ still
        centre, radius = balls.ball(places, within, space.length)
        form = balls.inside(centre, radius, still)
        value[10 * b : 10 * b + 10] += spare[b] * form / space.length**2
    assert outside(value, conditions(space)) < 1e-7
    rng, total = np.random.default_rng(1), 0.0
    for b, name in enumerate(space.bodies):
        masses, points = balls.cloud(rng, found.balls[name], 300)
        along = rng.standard_normal((300, 1)) * (np.eye(3) - still)[2] * space.planar
        for m, x in zip(masses, points + along, strict=True):
            one = value[10 * b : 10 * b + 10] @ sums(np.array([m]), x[None])
            assert one > -1e-12 * np.abs(value).max()
            total += one
    assert total > 0.0
    asked = found.constraints
    assert check_certificate(space, Z, asked, spare).accepted
    wider = constraints_of(space, [], {}, 1.001 * within)
    wrong = [
        (Z, asked, None),
        (Z, asked, -spare),
        (Z, asked, 1.0001 * spare),
        (Z, asked, 0.0 * spare),
        (Z, asked, np.nan * spare),
        (-Z, asked, spare),
        (Z, None, spare),
        (Z, wider, spare),
    ]
    assert not any(check_certificate(space, A, a, s).accepted for A, a, s in wrong)
    with pytest.raises(ValueError, match="multipliers of shape"):
        check_certificate(space, Z, asked, spare[:-1])


def test_a_multiplier_of_a_link_that_is_kept_proves_nothing():
    found = clashing()
    assert check_certificate(
        found.space, found.certificate, found.constraints, found.multipliers
    ).accepted
    kept = found.space.bodies.index("coupler")
    assert found.multipliers[kept] == 0.0 and found.multipliers.any()
    spare = found.multipliers.copy()
    spare[kept] = 1e-9
    check = check_certificate(found.space, found.certificate, found.constraints, spare)
    assert not check.accepted


def test_a_multiplier_that_is_negative_proves_nothing():
    """Of a space that is a point, where any sum vanishes: only signs decide."""
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    joints = [
        axis_edge("prismatic", x, np.zeros(3), (0, 1), "slide"),
        axis_edge("revolute", z, np.array([0.3, 0.1, 0.0]), (1, 2), "hinge"),
    ]
    space = design_space(assemble(linked(joints, [2], np.random.default_rng(0))))
    asked, Z = constraints_of(space, [], {}, 1.5), np.eye(3)[None]
    assert space.nullity == 0
    for spare, accepted in ((0.0, True), (0.5, True), (-0.5, False), (-1e-300, False)):
        found = check_certificate(space, Z, asked, [spare])
        assert found.accepted == accepted, spare


@pytest.mark.parametrize("size", [1e-6, 1e6])
@pytest.mark.parametrize(("model", "within"), [("four_bar_kite", 1.5), ("four_bar_kite", 0.9)])
def test_size_and_place_do_not_matter(model, within, size, tmp_path):
    plain = design_of_any_density(space_of(model), within=within)
    H = np.eye(4)
    H[:3, :3] = Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix()
    H[:3, 3] = 1000.0 * size * plain.space.length * np.array([2.0, -3.0, 6.0]) / 7.0
    moved = design_of_any_density(
        space_of(altered(model, tmp_path, resized(size), placed(H))), within=within
    )
    assert moved.verdict == plain.verdict
    assert moved.margin == pytest.approx(plain.margin, rel=1e-4)
    for name, ball in plain.balls.items():
        there = H[:3, :3] @ (size * ball.centre) + H[:3, 3]
        n = moved.space.chain.frame.R[2]
        off = moved.balls[name].centre - there
        assert np.linalg.norm(off - (off @ n) * n) < 1e-9 * np.linalg.norm(H[:3, 3])
        assert moved.balls[name].radius == pytest.approx(size * ball.radius, rel=1e-9)


@pytest.mark.parametrize("within", [0.0, -1.0, np.inf, np.nan])
def test_a_radius_is_positive(within):
    with pytest.raises(ValueError, match="give lengths of a link"):
        design_of_any_density(space_of("four_bar_kite"), within=within)
