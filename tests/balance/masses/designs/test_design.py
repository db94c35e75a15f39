"""Designs: objectives, bodies that are kept, bounds, and what cannot be asked."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import Design, design_space
from balance.checks import check_design
from balance.masses.designs.feasibility import feasible
from balance.motion.verification.verify_motions import verify
from balance.space.inertial_parameters.conversions import violations
from kinematics.errors import BodyError, LinkageError
from tests.independent import reference
from tests.support import balls
from tests.support.covering import number_of_cases
from tests.support.designs import design_of_any_density
from tests.support.shapes import (
    antiparallelogram,
    conditions,
    functional,
    general,
    kite,
    matrix,
    outside,
    quadrilateral,
)

OBJECTIVES = ("mass", "inertia", "rotor", "change")
FEASIBLE = [
    ("four_bar_kite", None),
    ("four_bar_antiparallelogram", None),
    ("slider_crank", None),
    ("scissor_three_stage", None),
    ("three_rsr", "u2=u3"),
]


def space_of(model, motion=None, **more):
    return design_space(kinematics.load(model), motion, **more)


def given(space):
    return np.array([body.inertia for body in space.linkage.bodies])


@pytest.mark.table
@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize(("model", "motion"), FEASIBLE)
def test_designs_are_balanced_and_can_be_built(model, motion, objective):
    space = space_of(model, motion)
    found = design_of_any_density(space, objective)
    assert found.verdict == "feasible" and check_design(space, found.z).accepted
    rows = conditions(space)
    left = np.abs(rows @ found.z.reshape(-1)).max()
    assert left < 1e-12 * np.abs(rows).max() * np.abs(found.z).sum()
    assert not any(violations(z, 0.0) for z in found.z)
    assert min(np.linalg.eigvalsh(matrix(z))[0] for z in found.z) > 0.0
    assert found.margin > 0.0 and not found.z.flags.writeable


@pytest.mark.parametrize(("model", "motion"), FEASIBLE)
def test_the_best_is_better_than_the_others(model, motion):
    """Value of each objective, measured anew: no other design or mixture of two is below.

    Of the designs whose value is the least but for 1e-5 of it, the nearest one counts.
    """
    space = space_of(model, motion)
    found = {name: design_of_any_density(space, name) for name in OBJECTIVES[:3]}
    measured = {name: value_of(name, space) for name in found}
    for name, best in found.items():
        assert measured[name](best.z) == pytest.approx(best.value, rel=1e-6)
        for other in found.values():
            for share in (0.1, 1.0):
                mixed = (1.0 - share) * best.z + share * other.z
                assert measured[name](mixed) >= best.value * (1.0 - 1.1e-5)


def value_of(name, space):
    """An objective as a function of parameters (bodies, 10), from its definition."""
    if name == "mass":
        return lambda z: z[:, 0].sum()
    if name == "inertia":
        return lambda z: max(map(largest_moment, z, space.frames))
    swept = twists(space)
    pairs = [(b, T) for b, body in enumerate(swept) for T in body]
    return lambda z: sum(np.trace(T @ matrix(z[b]) @ T.T) for b, T in pairs)


def largest_moment(z, frame):
    """Largest principal moment about the origin of a link frame."""
    shift = np.eye(4)
    shift[:3, 3] = -frame[:3, 3]
    S = (shift @ matrix(z) @ shift.T)[:3, :3]
    return np.linalg.eigvalsh(np.trace(S) * np.eye(3) - S)[-1]


def test_an_input_that_slides_counts_in_lengths():
    """The kinetic energy is one: the inertias are as the squares of the rates."""
    values = []
    for chosen in ("u1", "q4"):
        space = design_space(kinematics.load("slider_crank", inputs=[chosen]))
        values.append(design_of_any_density(space, "rotor").value)
    mechanism = reference.load("slider_crank")
    names = [joint.name for joint in space.linkage.joints]
    rate = reference.velocities(mechanism, np.zeros(len(mechanism.joints)), np.eye(1))
    ratio = rate[names.index("q4"), 0] / rate[names.index("u1"), 0]
    assert values[0] == pytest.approx(values[1] * ratio**2 / space.length**2, rel=1e-6)


def twists(space):
    """Twists (4, 4) of each body for each coordinate of the motion, by the second route."""
    mechanism = reference.load(space.linkage.name)
    relations = space.motion.relations if space.motion else ()
    basis = reference.motion_basis(mechanism, relations)
    sliding = [space.linkage.joints[j].kind == "prismatic" for j in mechanism.inputs]
    basis = basis * np.where(sliding, space.length, 1.0)[:, None]
    q = np.zeros(len(mechanism.joints))
    rates = reference.velocities(mechanism, q, basis)
    moved = reference.displacements(mechanism, q)[1]
    link = dict(zip(mechanism.bodies, mechanism.links, strict=True))
    ways = [path_to(mechanism, link[name]) for name in space.bodies]
    return [[np.tensordot(rate[way], moved[way], 1) for rate in rates.T] for way in ways]


def path_to(mechanism, link):
    """Joints between the ground and a link."""
    path = []
    while link >= 0:
        path.append(link)
        link = mechanism.parents[link]
    return path


def questions():
    """Random quadrilaterals on each of their sides, and which objective to compare."""
    for seed in range(number_of_cases(3, 9)):
        rng = np.random.default_rng(seed)
        for shape in (kite, antiparallelogram, general):
            corners = shape(rng)
            for base in range(4):
                space = design_space(quadrilateral(corners, base, rng))
                yield space, corners, base, ("mass", "inertia", "change")[(seed + base) % 3]


def balls_of(space, corners, base, within):
    """The disc of each side, by its two corners and the centre of mass of its body."""
    found = []
    for k, body in enumerate(space.linkage.bodies, 1):
        ends = np.column_stack([np.roll(corners, -(k + base), axis=0)[:2], [0.0, 0.0]])
        carrier = space.linkage.joints[body.link].point
        ends = sorted(ends, key=lambda end: np.linalg.norm(end - carrier))  # noqa: B023
        centre = body.inertia[1:4] / body.inertia[0] * [1.0, 1.0, 0.0]
        found.append(balls.ball(np.array([*ends, centre]), within, space.length))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("within", [None, 1.5, 0.8])
def test_cvxpy_agrees(within):
    """On random problems, from conditions of finite poses: each verdict, each optimum.

    On 36 of them; on 108 with ``ALL_CASES=1``.
    """
    from tests.independent.modelled import Model  # CVXPY takes seconds to load

    asked = solved = 0
    # Where a ball is full, margins of both solvers have a digit less.
    digits = 1e-5 if within else 1e-6
    for space, corners, base, objective in questions():
        limits = balls_of(space, corners, base, within) if within else ()
        found, model = design_of_any_density(space, within=within), Model(space, balls=limits)
        assert found.verdict == model.verdict()
        asked += 1
        # Where the margin is 1e-6, neither solver has six digits.
        if found.verdict == "feasible" and found.margin > 1e-4:
            margin = model.margin()
            assert found.margin == pytest.approx(margin, rel=digits)
            best = design_of_any_density(space, objective, within=within).value
            # The nearest design whose value exceeds the least one by 1e-5 of it.
            excess = 1e-5 * (objective != "change")
            least = model.best(objective, margin) * (1.0 + excess)
            assert best == pytest.approx(least, rel=digits)
            solved += 1
    assert asked == 12 * number_of_cases(3, 9)
    assert solved > (0 if within == 0.8 else number_of_cases(9, 30))


# --- the designs of the thesis -------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "motion"),
    [
        ("three_rsr", "u2=u3"),
        ("four_bar_kite_balanced", None),
        ("four_bar_antiparallelogram_balanced", None),
    ],
)
def test_the_designs_of_the_thesis_are_points_of_the_space(model, motion):
    """[J] table 5.4, and Eq. 6.8 as corrected; the least change from them is none."""
    space = space_of(model, motion)
    assert check_design(space, given(space)).accepted
    # The upper links of the thesis' 3-RSR have a radius of gyration of two lengths.
    found = design_of_any_density(space, "change", within=None if model == "three_rsr" else 1.5)
    assert found.value == pytest.approx(0.0, abs=1e-7)
    assert np.abs(found.z - given(space)).max() < 1e-6 * np.abs(given(space)).max()
    other = given(space) * (1.0 + 1e-6 * np.random.default_rng(0).standard_normal((1, 10)))
    assert not check_design(space, other).accepted


def test_the_minus_of_the_kite_is_a_misprint():
    """[J] Eq. 6.8 with its last line as printed is no point of the space."""
    space = space_of("four_bar_kite_balanced")
    z, o3, o4 = given(space), np.array([0.72, 0.96]), np.array([1.0, 0.0])
    length, m3 = np.linalg.norm(o4 - o3), z[2, 0]
    c3 = (z[2, 1:3] / m3 - o3) @ (o4 - o3) / length
    z[2, 6] -= 2.0 * m3 * c3 * (length - c3)
    assert not check_design(space, z).accepted


@pytest.mark.parametrize("asked", [{}, {"minimise": "mass"}, {"bounds": {"crank": (0.1, 9)}}])
def test_conditions_that_are_not_complete_allow_no_design(asked):
    """What is balanced to first order may shake: the general four-bar has no design."""
    space = space_of("four_bar_general", max_order=1)
    assert not space.settled
    assert feasible(space).verdict == feasible(space).words.split(":")[0] == "undecided"
    found = design_of_any_density(space, **asked)
    assert (found.verdict, found.z, found.value, found.bodies) == ("undecided", None, None, ())
    assert "not all conditions are known" in found.words and "max_order" in found.words
    assert found.residuals is None and json.loads(json.dumps(found.to_dict()))["bodies"] == []


def test_a_proof_needs_no_more_conditions():
    """More conditions leave fewer designs: none stays none."""
    space = space_of("four_bar_spherical", max_order=2)
    found = feasible(space)
    assert not space.settled and found.verdict == "infeasible"
    complete = conditions(space_of("four_bar_spherical"), reach=0.05)
    assert outside(functional(space, found.certificate), complete) < 1e-7


# --- kept bodies, bounds -------------------------------------------------------------------


@pytest.mark.parametrize("objective", [None, *OBJECTIVES])
def test_kept_bodies_and_bounds_are_heeded(objective):
    space = space_of("four_bar_kite_balanced")
    bounds = {"coupler": (0.15, 0.1965), "rocker": (0.0, 20.0)}
    found = design_of_any_density(space, objective, keep=["crank"], bounds=bounds)
    assert found.verdict == "feasible" and found.residuals.accepted
    assert np.array_equal(found.z[0], given(space)[0])
    for name, (low, high) in bounds.items():
        mass = found.z[space.bodies.index(name), 0]
        assert low * (1 - 1e-9) <= mass <= high * (1 + 1e-9)


def test_an_exact_mass():
    space = space_of("four_bar_kite_balanced")
    found = design_of_any_density(space, "change", bounds={"coupler": (0.18, 0.18)})
    assert found.verdict == "feasible"
    assert found.z[1, 0] == pytest.approx(0.18, rel=1e-12)


def test_kept_bodies_off_the_plane_ask_for_all_parameters():
    """A kept body with a product of inertia, or all kept at a height of their own."""
    linkage = kinematics.load("four_bar_kite_balanced")
    space = design_space(linkage)
    flat = design_of_any_density(space, keep=["crank"])
    assert flat.space.planar
    crank, *rest = linkage.bodies
    tilted = crank.inertia.copy()
    tilted[9] += 0.01
    changed = replace(linkage, bodies=(replace(crank, inertia=tilted), *rest))
    found = design_of_any_density(design_space(changed), keep=["crank"])
    assert not found.space.planar and found.verdict in ("feasible", "infeasible")
    if found.verdict == "feasible":
        shaken = verify(changed, found.z, trajectories=1, samples=20)
        assert shaken.verdict == "balanced"
    lifted = crank.inertia.copy()
    m, x, y, h = lifted[0], lifted[1], lifted[2], 0.3
    lifted[[3, 4, 5, 8, 9]] += [m * h, m * h * h, m * h * h, -x * h, -y * h]
    raised = replace(linkage, bodies=(replace(crank, inertia=lifted), *rest))
    found = design_of_any_density(design_space(raised), keep=["crank"])
    assert found.space.planar and found.verdict == "feasible"
    assert np.allclose(found.z[:, 3], h * found.z[:, 0], rtol=1e-12)
    assert verify(raised, found.z, trajectories=1, samples=20).verdict == "balanced"


# --- the result ----------------------------------------------------------------------------


def test_bodies_are_those_of_the_parameters():
    found = design_of_any_density(space_of("three_rsr", "u2=u3"), "mass")
    assert len(found.bodies) == len(found.z) == 7
    for body, z in zip(found.bodies, found.z, strict=True):
        assert body.mass == z[0] and np.allclose(body.com, z[1:4] / z[0], rtol=1e-12)
        assert np.array_equal(body.z, z) and body.urdf.startswith("<inertial>")


def test_the_design_as_data():
    infinite = {"crank": (0.1, float("inf"))}
    found = design_of_any_density(space_of("four_bar_kite"), "mass", bounds=infinite)
    data = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert data["bounds"] == {"crank": [0.1, None]} and data["verdict"] == "feasible"
    assert data["value"] == found.value == pytest.approx(found.z[:, 0].sum(), rel=1e-7)
    assert [body["name"] for body in data["bodies"]] == ["crank", "coupler", "rocker"]
    none = design_of_any_density(space_of("four_bar_general")).to_dict()
    assert none["bodies"] == [] and len(none["certificate"]) == 3 and none["value"] is None
    json.dumps(none, allow_nan=False)


def test_without_an_objective_the_margin_is_largest():
    space = space_of("four_bar_antiparallelogram")
    found = design_of_any_density(space)
    assert isinstance(found, Design) and found.value is None
    assert all(found.margin >= design_of_any_density(space, name).margin for name in OBJECTIVES)


REFUSED = [
    (dict(keep=["no_such"]), "link 'no_such': there is no such link; the bodies are"),
    (dict(bounds={"base": (0, 1)}), "link 'base': carries no inertial parameters"),
    (
        dict(keep=["crank", "coupler", "rocker"]),
        "every link is kept (crank, coupler, rocker): nothing is left to design; keep fewer",
    ),
    (dict(bounds={"crank": (2.0, 1.0)}), "link 'crank': its mass cannot be from 2 to 1 kg"),
    (dict(bounds={"crank": (-1.0, 1.0)}), "cannot be from -1 to 1 kg"),
    (dict(bounds={"crank": (0.0, 0.0)}), "cannot be from 0 to 0 kg"),
    (dict(bounds={"crank": (float("nan"), 1.0)}), "cannot be from nan to 1 kg"),
    (dict(keep=["crank"], bounds={"crank": (1.0, 2.0)}), "is kept and bounded"),
]


@pytest.mark.parametrize(("asked", "text"), REFUSED)
def test_what_cannot_be_asked_is_refused_in_one_line(asked, text):
    space = space_of("four_bar_kite")
    with pytest.raises(LinkageError) as caught:
        design_of_any_density(space, "mass", **asked)
    message = str(caught.value)
    assert text in message and "\n" not in message and message.startswith(space.source)


def test_a_rod_has_no_distance_from_itself():
    """A body of no width is singular; kept, it is none of the question's."""
    linkage = kinematics.load("four_bar_kite_balanced")
    crank, *rest = linkage.bodies
    m, cx, cy = crank.inertia[0], *crank.inertia[1:3] / crank.inertia[0]
    point = np.zeros(10)
    point[[0, 1, 2]] = m, m * cx, m * cy
    point[4:8] = m * cy**2, m * cx**2, m * (cx**2 + cy**2), -m * cx * cy
    space = design_space(replace(linkage, bodies=(replace(crank, inertia=point), *rest)))
    with pytest.raises(BodyError, match="link 'crank': has a singular mass distribution"):
        design_of_any_density(space, "change")
    assert design_of_any_density(space, "mass").verdict == "feasible"


def test_an_unknown_objective():
    with pytest.raises(ValueError, match="mass, inertia, rotor, change"):
        design_of_any_density(space_of("four_bar_kite"), "cost")
