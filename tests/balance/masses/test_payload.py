"""Payloads: one load and ranges of loads, against Pinocchio, quadrature and formulas."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.masses import carrying, least_violation, movable_weights, read_payload
from balance.masses.partial_balance.least_violation import missed_by
from balance.masses.payload import point_parameters, with_parameters
from balance.masses.springs.spring import AttachedPoint, Spring
from kinematics.errors import BodyError, UsageError
from tests.support.potential_energies import GRAVITY, energies, poses_of
from tests.support.spring_energies import G, balancer, lamp, torques_with_springs


def energy_range(linkage, z):
    """Range of the potential energy by Pinocchio over poses, over that of the masses alone."""
    poses = poses_of(linkage)
    both = energies(linkage, poses, z[:, 0], z[:, 1:4])
    parts = [
        np.ptp(energies(linkage, poses, z[:, 0] * row, z[:, 1:4] * row[:, None]))
        for row in np.eye(len(z))
    ]
    return np.ptp(both) / max(parts)


@pytest.mark.parametrize("model", ["five_bar", pytest.param("delta", marks=pytest.mark.slow)])
def test_a_load_is_a_point_mass_by_pinocchio(model):
    """Its potential energy at finite poses is that of a small body at the point."""
    linkage = kinematics.load(model)
    link = linkage.bodies[-1].name
    payload = read_payload(f"{link}@0.1,-0.2,0=1.5")
    there = carrying(linkage, payload)
    poses = poses_of(linkage)[:10]
    z = [np.array([body.inertia for body in each.bodies]) for each in (linkage, there)]
    bare, loaded = (energies(linkage, poses, x[:, 0], x[:, 1:4]) for x in z)
    more = point_parameters(linkage, payload, 1.5)
    alone = np.zeros_like(z[0])
    alone[-1] = more
    point = energies(linkage, poses, alone[:, 0], alone[:, 1:4])
    assert np.abs(np.diff(loaded - bare - point)).max() < 1e-12 * np.ptp(loaded)
    pose = linkage.places[link].pose
    p = pose[:3, :3] @ [0.1, -0.2, 0] + pose[:3, 3]
    assert more[:4] == pytest.approx([1.5, *1.5 * p])
    assert more[4:7].sum() == pytest.approx(2 * 1.5 * p @ p)


def test_springs_for_a_load_and_a_range_of_loads():
    """k r a = (m l + M L) g: for the mean load if points stay, linear in M if they move."""
    asked = "base@0,0,0:1 arm@0.25,0,0"
    answer = balance.springs(balancer(), asked, payload="arm@0.5,0,0=1")
    (spring,) = answer.springs
    assert spring.stiffness * spring.ends[0].point[2] * 0.25 == pytest.approx(1.1 * G, rel=1e-9)
    answer = balance.springs(balancer(), asked, payload="arm@0.5,0,0=0:2")
    (spring,) = answer.springs
    assert spring.stiffness * spring.ends[0].point[2] * 0.25 == pytest.approx(1.1 * G, rel=1e-9)
    # 0.5 kg m of payload too much, or too little, beside 0.6 and 1.6.
    assert answer.loads.torque_shares == pytest.approx((0.5 / 0.6, 0.5 / 1.6), rel=1e-9)
    (moved,) = answer.loads.springs
    heights = moved.start[0, 2], moved.end[0, 2]
    assert moved.stiffness * 0.25 * np.array(heights) == pytest.approx([0.6 * G, 1.6 * G])


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_points_that_move_balance_every_load_by_pinocchio(share):
    linkage = lamp()
    asked = [
        "base@0,0,0:0.2 upper@0.4,0,0",
        "lower@0,0,0.4:0.6 upper@0.4,0,0",
        "base@0,0,0:0.2 lower@0,0,0.1",
    ]
    answer = balance.springs(linkage, asked, payload="upper@0.5,0,0=0:0.2")
    assert answer.verdict == "feasible"
    springs = []
    for moved, found in zip(answer.loads.springs, answer.springs, strict=True):
        points = (1 - share) * moved.start + share * moved.end
        ends = tuple(
            AttachedPoint(end.link, tuple(point))
            for end, point in zip(found.ends, points, strict=True)
        )
        springs.append(Spring("", ends, moved.stiffness, (0, 0), 0))
    loaded = carrying(linkage, "upper@0.5,0,0=1", 0.2 * share)
    given = SimpleNamespace(springs=springs, gravity=answer.gravity)
    left, gravity = torques_with_springs(loaded, given, 20)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_weights_that_move_balance_every_load_by_pinocchio(share):
    linkage, payload = kinematics.load("five_bar"), None
    tip = linkage.bodies[1].name
    payload = read_payload(f"{tip}@0.1,0,0=0.5:1.5")
    space = balance.require(linkage, "gravity", gravity=GRAVITY)
    answer = movable_weights(space, linkage, payload, list(space.bodies))
    assert answer.weights and not answer.fixed
    load = 0.5 + share
    z = np.array([body.inertia for body in carrying(linkage, payload, load).bodies])
    for weight in answer.weights:
        place = (1 - share) * weight.start + share * weight.end
        lump = read_payload(
            f"{weight.link}@{','.join(repr(float(x)) for x in place)}={weight.mass!r}"
        )
        z[space.bodies.index(weight.link)] += point_parameters(linkage, lump, weight.mass)
    assert energy_range(linkage, z) < 1e-10


def test_a_balanced_load_needs_no_weights_that_move():
    """A load on the axis of the first joint of a balanced arm."""
    linkage = lamp()
    space = balance.require(linkage, "gravity")
    answer = movable_weights(space, linkage, read_payload("lower@0,0,0=0:3"), ["lower"])
    assert answer.fixed and not answer.weights


@pytest.mark.parametrize("model", ["four_bar_general", "five_bar"])
def test_a_design_keeps_the_load_and_balances_with_it(model, tmp_path):
    linkage = kinematics.load(model)
    name = linkage.bodies[1].name
    payload = read_payload(f"{name}=0.7")
    loaded = carrying(linkage, payload, apart=True)
    space = balance.require(loaded, "gravity", gravity=GRAVITY)
    answer = balance.design(space, keep=["payload"])
    assert answer.verdict == "feasible"
    assert answer.z[-1] == pytest.approx(point_parameters(linkage, payload, 0.7))
    z = np.array(answer.z[:-1])
    # The links' own masses can be built, and balance with the load alone.
    assert all(np.linalg.eigvalsh(balance.bodies.pseudo_inertia(row)).min() > 0 for row in z)
    assert energy_range(linkage, z) > 1e-4
    z[1] += answer.z[-1]
    assert energy_range(linkage, z) < 1e-9
    written = kinematics.load(answer.to_urdf(tmp_path / "out.urdf"))
    assert written.bodies[1].inertia == pytest.approx(answer.z[1], rel=1e-6, abs=1e-9)


def test_the_mean_load_leaves_the_least_mean_square_over_the_range():
    linkage, payload = kinematics.load("four_bar_general"), read_payload("coupler=0:2")
    nodes, weights = np.polynomial.legendre.leggauss(3)

    def mean_square(load):
        space = balance.require(carrying(linkage, payload, load), "force")
        answer = least_violation(space, ["crank"], 1.5)
        given = np.array(answer.z)
        b, total = space.bodies.index("coupler"), 0.0
        for node, weight in zip(nodes, weights, strict=True):
            z = given.copy()
            z[b] += point_parameters(linkage, payload, 1.0 + node - load)
            # In the sizes of one of them, so that all are measured alike.
            total += weight * missed_by(measure, z) ** 2
        return total

    measure = least_violation(
        balance.require(carrying(linkage, payload), "force"), ["crank"], 1.5
    )
    at_mean = mean_square(1.0)
    assert all(mean_square(load) > at_mean * (1 + 1e-6) for load in (0.4, 0.8, 1.2, 2.0))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("tool", "has no known form"),
        ("=2", "has no known form"),
        ("arm@1,2=2", "has no known form"),
        ("arm=1:2:3", "has no known form"),
        ("arm=-1", "a load is not negative"),
        ("arm=0", "give a load above 0"),
        ("arm=2:1", "give a load above 0"),
        ("arm=2m", "is a unit of length"),
        ("arm=nan", "give a load above 0"),
        ("arm@1e9,0,0=1", "is beyond"),
    ],
)
def test_payloads_that_cannot_be_read(text, words):
    with pytest.raises(UsageError) as raised:
        read_payload(text)
    assert words in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hand=1", "there is no such link"),
        ("base=1", "is part of the ground"),
    ],
)
def test_links_that_carry_no_payload(text, words):
    with pytest.raises(BodyError, match=words):
        carrying(balancer(), text)


def test_a_link_without_mass_carries_a_payload_with_all_bodies():
    linkage = balancer()
    bare = replace(linkage, bodies=())
    with pytest.raises(BodyError, match="--bodies all"):
        carrying(bare, "arm=1")
    zero = with_parameters(linkage, {0: np.zeros(10)})
    assert carrying(zero, "arm@0.5,0,0=2").bodies[0].inertia[:2].tolist() == [2.0, 1.0]


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["design", "--payload", "coupler=0:1"], 2, "a design is for one load"),
        (
            ["counterweights", "--links", "crank", "--payload", "coupler=1", "--merge",
             "--out", "x.urdf"],
            2,
            "--merge does not go with --payload",
        ),
        (["reduce", "--links", "crank", "--budget", "1", "--payload", "hand=1"], 3,
         "no such link"),
        (["springs", "--between", "base,crank", "--payload", "base=1"], 3,
         "part of the ground"),
    ],
)  # fmt: skip
def test_payloads_that_commands_refuse(words, code, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([words[0], "four_bar_general", *words[1:]]) == code
    lines = capsys.readouterr().err.strip().splitlines()
    assert told in lines[0] and len(lines) == 1 + (code == 2)
