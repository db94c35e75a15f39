"""Identified masses: loads by other routes, standard errors, what is open, the prior."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.identification.least_squares import (
    ChannelRows,
    excited_directions,
    solve,
)
from balance.masses.identification.likeliest_masses import (
    likeliest_masses,
    widened_pseudo_inertias,
)
from balance.masses.identification.load_rows import load_rows
from balance.motion.verification.trajectory import drive, random_motions
from balance.space.inertial_parameters.conversions import from_chain
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import BodyError, UsageError
from tests.independent import identification_run, reference
from tests.independent.identification_run import other_masses
from tests.independent.measured_loads import Arm, load_regressor
from tests.support.motions import bodies

GRAVITY = np.array([0.3, -0.8, -9.7])
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


def si_rows(linkage, way, about=(0.0, 0.0, 0.0)):
    """Rows of loads per parameter in SI units about the inertial origin."""
    rows = load_rows(linkage, way, GRAVITY, np.array(about))
    back = np.linalg.inv(
        np.kron(np.eye(rows.bodies), from_chain(input_chain(linkage).frame, False, False))
    )
    return rows.wrench @ back, rows.drives @ back


@cache
def measured(name):
    """A linkage, a motion of 80 samples, and its loads with masses unlike those of the file."""
    linkage = kinematics.load(name)
    (way,) = random_motions(linkage, 1, 80, seed=3)
    truth = other_masses(linkage, np.random.default_rng(5)).reshape(-1)
    wrench, drives = si_rows(linkage, way)
    return linkage, way, truth, wrench @ truth, drives @ truth


def columns(way, wrench, drives=None, names=WRENCH, inputs=()):
    """A table of loads; the wrench is that of the base on the linkage."""
    table = {"time": way.time, **{name: wrench[:, WRENCH.index(name)] for name in names}}
    return table | {name: drives[:, k] for k, name in enumerate(inputs)}


def without_sensors(rows, loads):
    """Channels of one recording, of sensors without parameters and with exact numbers."""
    count = len(loads)
    return [
        ChannelRows(
            rows[:, c], loads[:, c], np.empty((count, 0)), np.zeros(count, int), np.zeros(count)
        )
        for c in range(loads.shape[1])
    ]


@pytest.mark.parametrize(
    "name", ["five_bar", pytest.param("three_rsr", marks=pytest.mark.slow)]
)
def test_wrenches_of_point_masses_at_finite_poses(name):
    """Differences of momentum in time, and weights, of a route that shares no code."""
    linkage = kinematics.load(name)
    (way,) = random_motions(linkage, 1, 40, seed=2)
    mechanism = reference.load(kinematics.gallery()[name], linkage.inputs)
    order = [linkage.inputs.index(mechanism.joints[i]) for i in mechanism.inputs]
    there = [mechanism.bodies.index(body.name) for body in linkage.bodies]

    def path(now):
        u, ud, _ = way.path.at(np.array([now]))
        return u[0, order], ud[0, order]

    time = way.time[[5, 6, 7, 8]]
    expected = load_regressor(mechanism, path, time, GRAVITY).reshape(len(time), 6, -1, 10)
    found, _ = si_rows(linkage, drive(linkage, time, *way.path.at(time)))
    found = found.reshape(expected.shape)
    error = np.abs(found - expected[:, :, there]).max()
    assert error < 1e-7 * np.abs(expected).max()


def test_wrenches_and_torques_of_pinocchio():
    linkage = kinematics.load("hprs")
    (way,) = random_motions(linkage, 1, 12, seed=4)
    truth = bodies(linkage, 8)
    wrench, torques = Arm(linkage, GRAVITY).loads(truth, way.q, way.qd, way.qdd)
    rows, drives = si_rows(linkage, way)
    assert np.abs(rows @ truth.reshape(-1) - wrench).max() < 1e-11 * np.abs(wrench).max()
    torques = torques[:, linkage.positions_of(linkage.inputs)]
    assert np.abs(drives @ truth.reshape(-1) - torques).max() < 1e-11 * np.abs(torques).max()


def test_torques_in_closed_loops_do_the_work_of_the_energy():
    """``Σ τ u̇`` is the rate of the energy of point masses, of another route."""
    linkage = kinematics.load("five_bar")
    (way,) = random_motions(linkage, 1, 60, seed=6)
    truth = bodies(linkage, 9)
    power = np.einsum("kw,kw->k", si_rows(linkage, way)[1] @ truth.reshape(-1), way.ud)
    mechanism = reference.load(kinematics.gallery()["five_bar"], linkage.inputs)
    there = [mechanism.bodies.index(body.name) for body in linkage.bodies]
    z = np.zeros((len(there), 10))
    z[there] = truth
    step = 1e-4
    for k in (7, 25, 44):
        energies = []
        for now in (way.time[k] - step, way.time[k] + step):
            u, ud, _ = (x[0] for x in way.path.at(np.array([now])))
            q = reference.follow(mechanism, np.zeros(len(mechanism.joints)), u)
            rates = reference.velocities(mechanism, q, np.eye(2))
            momenta = reference.regressor(mechanism, q, rates @ ud[:, None])
            moved = reference.displacements(mechanism, q)[1]
            twists = np.einsum(
                "bj,j,jac->bac",
                reference.carriers(mechanism, list(mechanism.links)),
                (rates @ ud),
                moved,
            )
            six = np.column_stack(
                [twists[:, 2, 1], twists[:, 0, 2], twists[:, 1, 0], twists[:, :3, 3]]
            )
            momentum = np.einsum("ibp,bp->bi", momenta.reshape(6, -1, 10), z)
            place = reference.carried_parameters(mechanism, q)[:, 1:4]
            height = np.einsum("bip,bp,i->", place, z, -GRAVITY)
            energies.append(0.5 * np.sum(six * momentum) + height)
        rate = (energies[1] - energies[0]) / (2.0 * step)
        assert abs(rate - power[k]) < 1e-6 * np.abs(power).max()


@pytest.mark.parametrize(
    ("name", "channels", "inputs"),
    [("four_bar_general", ("fx", "fy", "mz"), ()), ("hprs", WRENCH, ())],
)
def test_exact_loads_give_the_true_combinations(name, channels, inputs):
    linkage, way, truth, wrench, drives = measured(name)
    found = balance.identify(
        linkage,
        way,
        columns(way, wrench, drives, channels, inputs),
        gravity=GRAVITY,
        on_linkage=True,
    )
    assert found.complete and found.verdict == "identified"
    assert len(found.combinations) == balance.design_space(linkage).rank
    for item in found.combinations:
        true = identification_run.true_value(item, truth, found)
        assert abs(item.value - true) < 1e-7 * np.abs(truth).max()
        assert (
            abs(
                item.file
                - identification_run.true_value(
                    item, np.array([body.inertia for body in linkage.bodies]).reshape(-1), found
                )
            )
            < 1e-11 * np.abs(truth).max()
        )


def test_a_sensor_elsewhere_with_the_other_sign_tells_the_same():
    linkage, way, _, wrench, _ = measured("four_bar_general")
    point = np.array([0.4, -0.2, 0.1])
    moved = np.column_stack([wrench[:, :3], wrench[:, 3:] - np.cross(point, wrench[:, :3])])
    first = balance.identify(
        linkage, way, columns(way, wrench), gravity=GRAVITY, on_linkage=True
    )
    other = balance.identify(linkage, way, columns(way, -moved), gravity=GRAVITY, about=point)
    for a, b in zip(first.combinations, other.combinations, strict=True):
        assert abs(a.value - b.value) < 1e-7


def test_offsets_and_friction_are_told_apart_from_masses():
    linkage, way, truth, wrench, drives = measured("five_bar")
    moving = drives + 0.7 * way.ud + 0.3 * np.sign(way.ud)
    loads = columns(way, wrench + np.arange(6.0), moving, ("fx", "mz"), linkage.inputs)
    found = balance.identify(
        linkage, way, loads, gravity=GRAVITY, on_linkage=True, offset=True, friction=True
    )
    assert found.complete
    for name in linkage.inputs:
        assert abs(found.sensors[f"viscous {name}"] - 0.7) < 1e-6
        assert abs(found.sensors[f"dry {name}"] - 0.3) < 1e-6
    for item in found.combinations:
        true = identification_run.true_value(item, truth, found)
        assert abs(item.value - true) < 1e-6
    blind = balance.identify(linkage, way, loads, gravity=GRAVITY, on_linkage=True)
    assert blind.furthest > 0.0 and max(c.residual for c in blind.recordings[0].channels) > 0.1


def test_what_is_not_excited_is_named():
    """Only one input of two moves: the other link is a mass that is carried."""
    linkage, _, truth, _, _ = measured("hprs")
    time = np.linspace(0.0, 1.0, 60)
    u = np.zeros((60, linkage.mobility))
    u[:, 0] = 0.3 * np.sin(4.0 * time) ** 2
    ud, udd = np.gradient(u, time, axis=0), np.zeros_like(u)
    ud[:, 0] = 1.2 * np.sin(8.0 * time)
    udd[:, 0] = 9.6 * np.cos(8.0 * time)
    way = drive(linkage, time, u, ud, udd)
    wrench = si_rows(linkage, way)[0] @ truth
    found = balance.identify(
        linkage, way, columns(way, wrench), gravity=GRAVITY, on_linkage=True
    )
    assert not found.complete and 0 < found.determined < len(found.combinations)
    assert len(found.combinations) == balance.design_space(linkage).rank
    rows = np.array([item.combination.row for item in found.combinations])
    assert np.linalg.matrix_rank(rows / np.linalg.norm(rows, axis=1)[:, None]) == len(rows)
    for item in found.combinations:
        if item.combination.determined:
            true = identification_run.true_value(item, truth, found)
            assert abs(item.value - true) < 1e-6 * np.abs(truth).max()
        else:
            assert item.value is None and "not determined" in repr(item)


def test_standard_errors_are_those_of_repeated_measurements():
    """Of the pseudo-inverse by hand: with known weights there is one formula."""
    rng = np.random.default_rng(2)
    Y = rng.normal(size=(300, 2, 4)) @ np.diag([1.0, 2.0, 0.5, 0.0])
    x, noise = np.array([1.0, -2.0, 3.0, 7.0]), np.array([0.1, 1.0])
    values = []
    for _ in range(200):
        loads = Y @ x + noise * rng.normal(size=(300, 2))
        fit = solve(without_sensors(Y, loads))
        values.append(fit.directions @ fit.estimate)
    spread = np.std(values, axis=0)[:3]
    W = (Y / noise[:, None]).reshape(-1, 4)[:, :3]
    expected = np.sqrt(np.diag(np.linalg.inv(W.T @ W)))
    assert np.all(np.abs(spread / expected - 1.0) < 0.2)
    told = fit.spread(fit.directions[:3])
    assert np.all(np.abs(told / expected - 1.0) < 0.15)
    assert np.all(np.abs(np.array(fit.noise).T / noise - 1.0) < 0.1)
    assert excited_directions(Y.reshape(-1, 4)).shape == (4, 3)


@pytest.mark.slow
def test_likeliest_masses_are_those_of_a_conic_solver():
    """The same convex program, written for cvxpy, with logarithms of determinants."""
    cvxpy = pytest.importorskip("cvxpy")
    linkage, way, _, wrench, _ = measured("four_bar_general")
    rng = np.random.default_rng(1)
    noisy = wrench + 0.02 * np.abs(wrench).max() * rng.normal(size=wrench.shape)
    chain = input_chain(linkage)
    rows = load_rows(linkage, way, GRAVITY, np.zeros(3)).wrench
    fit = solve(without_sensors(rows, noisy))
    back = np.linalg.inv(from_chain(chain.frame, False, False))
    x0 = np.array([body.inertia for body in linkage.bodies]) @ back.T
    P0, _ = widened_pseudo_inertias(x0)
    found = likeliest_masses(fit, P0, 0.3)
    matrices = [cvxpy.Variable((4, 4), symmetric=True) for _ in P0]
    parameters = []
    for P in matrices:
        t = P[0, 0] + P[1, 1] + P[2, 2]
        parameters += [
            P[3, 3],
            P[0, 3],
            P[1, 3],
            P[2, 3],
            t - P[0, 0],
            t - P[1, 1],
            t - P[2, 2],
            -P[0, 1],
            -P[0, 2],
            -P[1, 2],
        ]
    misfit = fit.factor @ (fit.directions.T @ cvxpy.hstack(parameters) - fit.estimate)
    apart = sum(
        cvxpy.trace(np.linalg.inv(P) @ Q) - cvxpy.log_det(Q)
        for P, Q in zip(P0, matrices, strict=True)
    )
    program = cvxpy.Problem(cvxpy.Minimize(0.5 * cvxpy.sum_squares(misfit) + apart / 0.09))
    program.solve(solver="CLARABEL")
    expected = np.array([float(np.squeeze(item.value)) for item in parameters])
    error = np.abs(found.x - expected) / np.maximum(np.abs(expected), 0.01)
    assert error.max() < 1e-3


def test_likeliest_masses_can_be_built_where_loads_alone_say_otherwise():
    """A single noisy channel: the combinations are off, and the masses are those of bodies."""
    linkage, way, truth, wrench, _ = measured("four_bar_general")
    rng = np.random.default_rng(0)
    noisy = wrench + 3.0 * np.abs(wrench).max() * rng.normal(size=wrench.shape)
    found = balance.identify(
        linkage, way, columns(way, noisy), gravity=GRAVITY, on_linkage=True
    )
    assert all(not balance.bodies.violations(z) for z in found.z)
    weak = balance.identify(
        linkage, way, columns(way, wrench), gravity=GRAVITY, on_linkage=True, prior=1e-6
    )
    file = np.array([body.inertia for body in linkage.bodies])
    assert np.abs(found.z - file).max() > 1e-3
    for item in weak.combinations:
        true = identification_run.true_value(item, truth, weak)
        assert abs(item.value - true) < 1e-6


def test_loads_that_no_masses_near_the_file_explain_are_told():
    """The wrong gravity and sign on a few exact samples: masses would be far off."""
    linkage, way, _, wrench, _ = measured("hprs")
    found = balance.identify(linkage, way, {"time": way.time[:12], "fx": wrench[:12, 0]})
    assert "far_from_file" in {notice.code for notice in found.notices}
    assert all(not balance.bodies.violations(z) for z in found.z)


def test_the_file_with_likeliest_masses_is_read_again(tmp_path):
    linkage, way, _, wrench, _ = measured("four_bar_general")
    found = balance.identify(
        linkage, way, columns(way, wrench), gravity=GRAVITY, on_linkage=True
    )
    found.to_urdf(tmp_path / "real.urdf")
    again = kinematics.load(tmp_path / "real.urdf")
    read = np.array([body.inertia for body in again.bodies])
    assert np.abs(read - found.z).max() < 1e-9 * np.abs(found.z).max()
    shaking = balance.motion.shaking(again, way.u, way.ud, way.udd)
    force = np.sqrt(np.square(shaking[:, 3:]).sum(axis=1).mean())
    assert abs(force - found.after.force) < 1e-6 * force
    assert found.plot().startswith(b"\x89PNG")


def test_loads_at_other_times_than_the_motion():
    linkage, way, truth, wrench, _ = measured("four_bar_general")
    time = np.linspace(0.1, 0.9, 50)
    there = drive(linkage, time, *way.path.at(time))
    loads = columns(there, si_rows(linkage, there)[0] @ truth)
    found = balance.identify(linkage, way, loads, gravity=GRAVITY, on_linkage=True)
    for item in found.combinations:
        true = identification_run.true_value(item, truth, found)
        assert abs(item.value - true) < 1e-6
    early = loads | {"time": time - 0.2}
    with pytest.raises(UsageError, match=r"from -0\.1 to 0\.7 s, and the motion"):
        balance.identify(linkage, way, early, gravity=GRAVITY)


def test_what_cannot_be_used_is_told():
    linkage, way, _, wrench, _ = measured("four_bar_general")
    loads = columns(way, wrench)
    for change, options, told in (
        ({"fx": [1.0, 2.0]}, {}, "one number for each time"),
        ({"ghost": way.time}, {}, "time and some of fx"),
        ({"fx": np.full(80, np.nan)}, {}, "must be finite"),
        (dict.fromkeys(WRENCH, np.zeros(80)), {}, "all numbers are 0"),
        ({"time": way.time[::-1]}, {}, "times that increase"),
        ({}, {"prior": 0.0}, "prior: 0 is not above 0"),
        ({}, {"friction": True}, "friction: no torque of a drive"),
        ({}, {"rotors": True}, "rotors: no torque of a drive"),
        ({}, {"cutoff": 0.0}, "cutoff: 0 is not above 0"),
        ({}, {"cutoff": 9.0}, "9 Hz needs 90 samples a second, and the motion have 79"),
        ({}, {"cutoff": 2.0}, "2 Hz needs a measurement of 3.25 s"),
    ):
        with pytest.raises(UsageError, match=told):
            balance.identify(linkage, way, loads | change, **options)
    linkage, way, _, wrench, _ = measured("hprs")
    short = {"time": way.time[::7], "mz": wrench[::7, 5]}
    with pytest.raises(UsageError, match="too few for so many unknowns"):
        balance.identify(linkage, way, short)


def test_a_link_without_mass_has_no_likeliest_one():
    linkage = kinematics.load("hprs", bodies="all")
    _, way, _, wrench, _ = measured("hprs")
    with pytest.raises(BodyError, match="'wrist1'.* has no mass in the file"):
        balance.identify(linkage, way, columns(way, wrench))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hprs", "five_bar"])
def test_noise_is_covered_by_the_standard_errors(name):
    """A sample of ``python -m tests.independent.identification_run --runs 200``."""
    moving = identification_run.machine(name, 20, 201)
    found = identification_run.coverage(name, 12, [(moving, identification_run.NOISE)])
    assert found.within >= 0.95
    assert 0.7 < found.squares < 1.4


def excited_by_torques(linkage, gravity):
    """Number of combinations that torques along random motions determine."""
    rows = [
        load_rows(linkage, way, np.array(gravity), np.zeros(3)).drives
        for way in random_motions(linkage, 3, 40, seed=1)
    ]
    stacked = np.concatenate(rows).reshape(-1, rows[0].shape[2])
    return excited_directions(stacked / np.abs(stacked).max()).shape[1]


def test_two_links_in_a_plane():
    """M. Gautier, W. Khalil, 1990: six base parameters with gravity in the plane, else four."""
    arm = kinematics.from_dh([[0.3, 0, 0.5, 0], [0.4, 0, 0.4, 0]])
    assert excited_by_torques(arm, (0.0, -9.81, 0.0)) == 6
    assert excited_by_torques(arm, (0.0, 0.0, -9.81)) == 4


def test_the_puma_has_36_base_parameters():
    """H. Mayeda, K. Yoshida, K. Osuka, 1990; the lengths are those of B. Armstrong, 1986."""
    right = np.pi / 2.0
    rows = [
        [0.0, 0.0, 0.0, 0.0],
        [0.3, 0.2435, 0.0, -right],
        [0.4, -0.0934, 0.4318, 0.0],
        [0.2, 0.4331, -0.0203, right],
        [0.5, 0.0, 0.0, -right],
        [0.1, 0.0, 0.0, right],
    ]
    puma = kinematics.from_dh(rows, "modified")
    assert excited_by_torques(puma, (0.0, 0.0, -9.81)) == 36
