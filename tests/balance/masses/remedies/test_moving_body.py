"""Moving bodies: centres of mass by finite poses, momentum by Pinocchio, the best place."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import balance
import kinematics
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.balancers.moving_body import apply_cam_mass, apply_moving_mass
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import drive
from kinematics.loading.model_gallery import as_linkage
from kinematics.model.document.element import Document
from tests.support.remedy_files import momentum_by_pinocchio, placed, table
from tests.support.remedy_requests import PENDULUM, request_of, rod


def load_moved(request, applied: AppliedRemedy):
    """The linkage with the body, and its motion as the file beside it says."""
    joints = applied.details["body"]["joints"]
    inputs = [*request.linkage.inputs, *joints]
    whole = kinematics.load(Document("whole.urdf", applied.urdf), inputs=inputs)
    columns = table(applied.files["motion.csv"])
    parts = [
        np.stack([columns[f"{rate}{name}"] for name in inputs], axis=1)[::50]
        for rate in ("", "velocity ", "acceleration ")
    ]
    return whole, drive(whole, columns["time"][::50], *parts)


def centres(linkage, motion, links):
    """Centre of mass (N, 3) of some links, by finite poses."""
    bodies = [body for body in linkage.bodies if body.name in links]
    moments = np.zeros((len(motion.time), 4))
    for k, q in enumerate(motion.q):
        poses = placed(linkage, q, 0.0 * q)[0]
        for body in bodies:
            moments[k] += poses[body.link] @ np.append(body.inertia[1:4], body.inertia[0])
    return moments[:, :3] / moments[:, 3:]


def test_a_rod_and_the_body_turn_about_one_point():
    """The body circles against the rod: mass times shift is the same, reversed."""
    request = request_of(PENDULUM[0], radius=0.2, budget=0.5)
    (applied,) = apply_moving_mass(request)
    assert applied.verdict == "feasible" and applied.added_mass == pytest.approx(0.5)
    assert applied.inertia_ratio == pytest.approx(1.0)
    whole, motion = load_moved(request, applied)
    own, moved = (centres(whole, motion, names) for names in (["a"], ["balancing_body"]))
    np.testing.assert_allclose(moved - moved[0], -2.0 * (own - own[0]), atol=1e-9)
    momenta = momentum_by_pinocchio(whole, motion)
    path = [x[:, :1] for x in (motion.u, motion.ud, motion.udd)]
    alone = momentum_by_pinocchio(request.linkage, drive(request.linkage, motion.time, *path))
    assert np.abs(momenta).max() < 1e-9 * np.abs(alone).max()


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "slider_crank", "five_bar", "four_rrr"])
@pytest.mark.parametrize("aim", ["dynamic", "force"])
def test_no_momentum_is_left_along_the_motion_of_the_file(model, aim):
    request = RemedyRequest(as_linkage(model), balance=aim)
    (applied,) = apply_moving_mass(request)
    assert applied.verdict == "feasible" and len(applied.new_links) == 2 + (aim == "dynamic")
    assert applied.added_mass == pytest.approx(request.given_mass)
    whole, motion = load_moved(request, applied)
    inputs = len(request.linkage.inputs)
    still = [x.copy() for x in (motion.u, motion.ud, motion.udd)]
    for x in still:
        x[:, inputs:] = 0.0
    own, total = (
        momentum_by_pinocchio(whole, each)
        for each in (drive(whole, motion.time, *still), motion)
    )
    rows = slice(0, 6) if aim == "dynamic" else slice(3, 6)
    assert np.abs(total[:, rows]).max() < 1e-9 * np.abs(own).max()
    names = [body.name for body in request.linkage.bodies]
    shift = centres(whole, motion, names)
    moved = centres(whole, motion, ["balancing_body"])
    np.testing.assert_allclose(moved - moved[0], -(shift - shift[0]), atol=1e-9)


@pytest.mark.slow
def test_the_body_is_where_it_turns_least():
    """Its angular momentum along the random motions, from places around."""
    from balance.masses.remedies.balancers import moving_body

    request = RemedyRequest(as_linkage("four_bar_general"))
    ready = moving_body._prepare(request)

    def turn(place):
        body = ready.body._replace(place=place)
        return sum(float(np.square(body.courses(run)[2][1]).mean()) for run in ready.runs)

    best = turn(ready.body.place)
    around = [0.02 * (x * ready.body.axes[0] + y * ready.body.axes[1])
              for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y]  # fmt: skip
    assert all(turn(ready.body.place + shift) > best for shift in around)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "slider_crank"])
def test_cams_balance_at_any_speed(model):
    """Lifts between the samples of the table, for a crank that swings to and fro."""
    request = RemedyRequest(as_linkage(model))
    (applied,) = apply_cam_mass(request)
    assert applied.verdict == "feasible" and applied.details["full_turn"]
    slides = applied.details["cycle"][:2]
    np.testing.assert_allclose(slides, 0.0, atol=1e-9)
    joints = applied.details["body"]["joints"]
    crank = applied.details["crank"]
    whole = kinematics.load(Document("whole.urdf", applied.urdf), inputs=[crank, *joints])
    cams = table(applied.files["cams.csv"])
    lifts = [make_interp_spline(cams["u"], cams[f"{name} lift"], k=5) for name in joints]
    t = np.linspace(0.0, 1.0, 200)
    angle, speed, change = 3.0 + 2.0 * np.sin(3 * t), 6.0 * np.cos(3 * t), -18.0 * np.sin(3 * t)
    columns = (
        [angle, *(lift(angle) for lift in lifts)],
        [speed, *(lift(angle, 1) * speed for lift in lifts)],
        [change, *(lift(angle, 1) * change + lift(angle, 2) * speed**2 for lift in lifts)],
    )
    motion = drive(whole, t, *(np.stack(part, axis=1) for part in columns))
    checked = balance.verify(whole, motions=[motion])
    assert max(checked.force_residual, checked.moment_residual) <= 1e-7
    # The crank feels the kinetic energy of the body: twice that at its unit rate.
    start = [
        make_interp_spline(cams["u"], cams[f"{name} lift"], k=5)(0.0, 1) for name in joints
    ]
    mass, inertia = applied.details["body"]["mass"], applied.details["body"]["inertia"]
    felt = mass * (start[0] ** 2 + start[1] ** 2) + inertia * start[2] ** 2
    added = applied.input_inertia[crank] - request.input_inertia[crank]
    assert added == pytest.approx(felt, rel=1e-6)


def test_refusals_say_what_is_in_the_way():
    spatial = request_of(
        rod("a", "base", "0 0 0", 1.0, "0.5 0 0", (0.0, 0.1, 0.1)),
        rod("b", "a", "1 0 0", 1.0, "0 0.5 0", (0.1, 0.0, 0.1), axis="1 0 0"),
    )
    for apply in (apply_moving_mass, apply_cam_mass):
        (applied,) = apply(spatial)
        assert applied.verdict == "refused" and "spatial" in applied.reason
    (applied,) = apply_cam_mass(request_of(*PENDULUM))
    assert applied.verdict == "refused" and "2 degrees of freedom" in applied.reason
    (applied,) = apply_moving_mass(request_of(PENDULUM[0], budget=0.0))
    assert applied.verdict == "refused" and "0 kg" in applied.reason
