"""Matter that is moved: closed forms of a crank, cvxpy, cells, and files read by Pinocchio."""

import json
import random

import numpy as np
import pytest

import balance
from balance.app.cli.main import main
from balance.masses.counterweights.exclusion import check_exclusion
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.filling_check import check_filling
from kinematics.errors import BodyError, UsageError
from tests.independent.counterweight_requests import random_request
from tests.independent.filled_cells import least_masses
from tests.independent.second_counterweights import by_cvxpy
from tests.support.covering import number_of_cases
from tests.support.points import point_counterweights, point_partial

CRANK = """<robot name="crank">
  <link name="base"/>
  <link name="crank">
    <inertial><origin xyz="0.1 0 0"/><mass value="0.8"/>
      <inertia ixx="1e-4" iyy="3e-3" izz="3e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="tip">
    <inertial><mass value="0.2"/>
      <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="turn" type="continuous">
    <parent link="base"/><child link="crank"/><axis xyz="0 0 1"/></joint>
  <joint name="end" type="fixed">
    <origin xyz="0.2 0 0"/><parent link="crank"/><child link="tip"/></joint>
</robot>"""
# Mass, and distance of its centre from the joint, of the crank with its tip.
MASS, ARM = 1.0, 0.12
# How far behind the joint its region reaches, and its section, m and m².
REACH, SECTION = 0.08, 0.03 * 0.05
REGION = {"crank": "box(-0.08:0,-0.015:0.015,-0.025:0.025)"}


@pytest.fixture
def crank(tmp_path):
    path = tmp_path / "crank.urdf"
    path.write_text(CRANK)
    return str(path)


def moved(path, share, density=None):
    return balance.counterweights(
        path, ["crank"], REGION, density=density, move={"crank": share}, balance="force"
    )


def test_enough_of_a_crank_is_moved_to_the_end_of_its_region(crank):
    """(1 - θ) m c = θ m a, of which θ follows; nothing is added."""
    answer = moved(crank, 1.0)
    taken = MASS * ARM / (ARM + REACH)
    assert answer.moved["crank"] == pytest.approx(taken, rel=1e-8)
    (weight,) = answer.weights
    assert weight.mass == pytest.approx(taken, rel=1e-8)
    assert weight.com[0] == pytest.approx(-REACH, rel=1e-8)
    assert answer.added_mass == 0.0 and answer.gap <= 1e-8
    assert answer.priced == pytest.approx(0.01 * taken, rel=1e-7)


def test_matter_is_added_where_too_little_may_be_moved(crank):
    """With at most θ = 0.3: (1 - θ) m c / a is placed, and so much less θ m is added."""
    answer = moved(crank, 0.3)
    placed = 0.7 * MASS * ARM / REACH
    assert answer.moved["crank"] == pytest.approx(0.3 * MASS, rel=1e-12)
    assert answer.added_mass == pytest.approx(placed - 0.3 * MASS, rel=1e-8)


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_a_density_fills_the_end_of_the_region(crank, share):
    """A slab of thickness t: ρ A t (a - t / 2) = (1 - θ) m c, and ρ A t = θ m if θ is free."""
    density = 20_000.0
    line = density * SECTION
    if share < 1.0:
        half = [-0.5 * line, line * REACH, -(1.0 - share) * MASS * ARM]
    else:  # θ = ρ A t / m
        half = [-0.5 * line, line * (REACH + ARM), -MASS * ARM]
    slab = float(min(np.roots(half)))
    answer = moved(crank, share, density)
    (weight,) = answer.weights
    assert weight.mass == pytest.approx(line * slab, rel=1e-8)
    taken = share * MASS if share < 1.0 else line * slab
    assert answer.moved["crank"] == pytest.approx(taken, rel=1e-8)
    assert weight.com[0] == pytest.approx(-REACH + 0.5 * slab, rel=1e-8)
    assert answer.gap <= 1e-8


def test_a_certificate_knows_what_may_be_moved(crank):
    """In a region on the wrong side nothing helps but to move all of the crank to the joint."""
    region = {"crank": "box(0.01:0.09,-0.015:0.015,-0.025:0.025)"}
    answer = balance.counterweights(
        crank, ["crank"], region, density=None, move={"crank": 0.9}, balance="force"
    )
    assert answer.verdict == "infeasible"
    regions = {0: answer.regions["crank"]}
    for share, accepted in ((0.0, True), (0.9, True), (1.0, True)):
        check = check_exclusion(answer.space, regions, answer.certificate, {0: share})
        assert check.accepted == accepted
    # Of a region that reaches the joint, all of the mass may be moved there, but no less.
    region = {"crank": "box(0:0.08,-0.015:0.015,-0.025:0.025)"}
    for share, verdict in ((0.9, "infeasible"), (1.0, "feasible")):
        answer = balance.counterweights(
            crank, ["crank"], region, density=None, move={"crank": share}, balance="force"
        )
        assert answer.verdict == verdict
    small = moved(crank, 0.3, 8000.0)
    assert small.verdict == "infeasible" and moved(crank, 0.8, 8000.0).verdict == "feasible"
    stocks = {0: Stock(small.regions["crank"], 8000.0)}
    for share, accepted in ((0.3, True), (0.8, False)):
        check = check_filling(small.space, stocks, small.certificate, {0: share})
        assert check.accepted == accepted


@pytest.mark.parametrize("merge", [False, True])
@pytest.mark.parametrize("share", [1.0, 0.3])
def test_the_file_keeps_what_is_not_moved(crank, share, merge, tmp_path):
    answer = moved(crank, share)
    path = tmp_path / "out.urdf"
    answer.to_urdf(path, merge=merge)
    body = balance.load(str(path)).bodies[0].inertia
    np.testing.assert_allclose(body[1:4], 0.0, atol=1e-12)
    np.testing.assert_allclose(body, answer.z[0], rtol=0.0, atol=1e-12)
    assert body[0] == pytest.approx(MASS + answer.added_mass, rel=1e-8)


def test_pinocchio_confirms_the_shaking_of_a_file_with_moved_matter(tmp_path):
    pytest.importorskip("pinocchio")
    links, path = ["crank", "rocker"], tmp_path / "out.urdf"
    linkage = "four_bar_general"
    design = point_partial(linkage, links, 0.0, move={"crank": 1.0, "rocker": 0.5})
    design.to_urdf(path)
    runs = balance.verify(str(path), motions=list(design.motions)).runs
    force = np.sqrt(np.mean([run.rms("force") ** 2 for run in runs]))
    assert design.shaking.force == pytest.approx(force, rel=1e-8)
    assert design.share < 0.65 and design.mass == 0.0
    assert sum(design.moved.values()) == pytest.approx(0.75, rel=1e-6)


def shares_of(space, add, seed):
    rng = random.Random(seed)
    masses = {body.name: body.inertia[0] for body in space.linkage.bodies}
    return {name: rng.choice((1.0, 0.7, 0.3)) for name in add if masses[name] > 0.0}


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", [2, 3, 17, 20, 37, *range(100, number_of_cases(100, 120))])
def test_random_requests_agree_with_cvxpy(seed, tmp_path):
    pytest.importorskip("cvxpy")
    space, add, texts = random_request(seed, tmp_path / "a.urdf")
    move = shares_of(space, add, seed)
    answer = point_counterweights(space, add, texts, move=move, relax=False)
    verdict, priced, _ = by_cvxpy(answer.space, answer.regions, move)
    assert answer.verdict == verdict
    assert priced is None or answer.priced == pytest.approx(priced, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [17, 20, 37])
def test_cells_bound_the_least_mass_from_both_sides(seed, tmp_path):
    space, add, texts = random_request(seed, tmp_path / "a.urdf")
    move = shares_of(space, add, seed)
    points = point_counterweights(space, add, texts, move=move, relax=False)
    density = 8.0 * max(weight.mean_density for weight in points.weights)
    answer = balance.counterweights(space, add, texts, density=density, move=move, relax=False)
    low, high = least_masses(space, answer.regions, density, 6000, move)
    assert answer.weights and answer.gap <= 1e-8
    assert low <= answer.priced * (1.0 + 1e-8) and answer.priced <= high * (1.0 + 1e-8)


def test_the_command_says_what_was_moved(crank, capsys):
    words = ["counterweights", crank, "--balance", "force", "--links", "crank", "--points"]
    words += ["--region", f"crank={REGION['crank']}", "--move", "crank"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "0.6 kg moved on 'crank', nothing added." in text
    assert "mass + 0.01 × moved mass" in text
    assert main([*words, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["movable"] == {"crank": 1.0}
    assert data["moved"]["crank"] == pytest.approx(0.6, rel=1e-8)
    assert data["added_mass"] == 0.0


@pytest.mark.parametrize(
    ("move", "error", "text"),
    [
        ({"crank": 0.0}, UsageError, "a share of 0 of its mass"),
        ({"crank": 1.5}, UsageError, "a share of 1.5 of its mass"),
        ({"ghost": 1.0}, BodyError, "gets no matter: name it among the links"),
    ],
)
def test_bad_shares(crank, move, error, text):
    with pytest.raises(error, match=text):
        balance.counterweights(crank, ["crank"], move=move, balance="force")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--move", "crank=0"], "write crank, or crank=30%"),
        (["--move", "crank", "--move", "crank"], "named twice"),
        (["--move", "crank", "--payload", "crank=1"], "does not go with --payload"),
        (["--move", "crank", "--shape", "disc=0.02"], "leave out --move"),
    ],
)
def test_words_that_contradict_each_other(crank, words, text, capsys):
    command = ["counterweights", crank, "--balance", "force", "--links", "crank"]
    assert main([*command, *words]) == 2
    assert text in capsys.readouterr().err
