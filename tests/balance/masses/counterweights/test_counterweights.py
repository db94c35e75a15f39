"""Counterweights: textbook formulas, second routes, certificates, growth of regions, files."""

import json
import random
from pathlib import Path

import numpy as np
import pytest

import balance
from balance.app.answers.html.added_matter import outlines
from balance.app.answers.html.counterweights import counterweights_page
from balance.app.cli.main import main
from balance.masses.counterweights.decide_points import balance_residual
from balance.masses.counterweights.exclusion import check_exclusion
from balance.masses.counterweights.lumps import Lumps, fewer_lumps
from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.regions import ball_region, hull_region
from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.support.clarabel_adapter import triangles
from kinematics.errors import BodyError, UsageError
from tests.independent.counterweight_requests import random_region, random_request
from tests.independent.second_counterweights import by_points, certificate_fault, samples
from tests.support.command_runs import asked
from tests.support.four_rrr import BODIES, CROSSED, GENERAL, PAIR
from tests.support.points import point_counterweights


def arm(path, length, bodies):
    """An arm of slender rods in the plane, with masses and distances of their centres."""
    parts, parent = ['<link name="base"/>'], "base"
    for k, (mass, centre, own) in enumerate(bodies, 1):
        inertia = mass * own**2 / 12.0
        at = "0 0 0" if k == 1 else f"{length!r} 0 0"
        parts.append(
            f'<link name="l{k}"><inertial><origin xyz="{centre!r} 0 0"/>'
            f'<mass value="{mass!r}"/><inertia ixx="0" ixy="0" ixz="0" iyy="{inertia!r}" '
            f'iyz="0" izz="{inertia!r}"/></inertial></link>'
            f'<joint name="j{k}" type="continuous"><parent link="{parent}"/>'
            f'<child link="l{k}"/><origin xyz="{at}"/><axis xyz="0 0 1"/></joint>'
        )
        parent = f"l{k}"
    path.write_text(f'<?xml version="1.0"?>\n<robot name="arm">{"".join(parts)}</robot>\n')
    return str(path)


@pytest.fixture
def rod_arm(tmp_path):
    return arm(tmp_path / "arm.urdf", 1.0, [(2.0, 0.5, 1.0), (1.0, 0.4, 0.8)])


@pytest.mark.parametrize("seed", range(6))
def test_the_textbook_formula_of_two_counterweights(seed, tmp_path):
    """m2' ρ2 = m2 d2 and m1' ρ1 = m1 d1 + (m2 + m2') l1, at the far edge of each region."""
    rng = np.random.default_rng(seed)
    length, (m1, m2), (r1, r2) = (
        rng.uniform(0.3, 2),
        rng.uniform(0.2, 5, 2),
        rng.uniform(0.1, 1, 2),
    )
    d1, d2 = 0.5 * length, rng.uniform(0.1, 1.0)
    bodies = [(m1, d1, length), (m2, d2, 2 * d2)]
    bodies = [tuple(map(float, body)) for body in bodies]
    path = arm(tmp_path / "a.urdf", float(length), bodies)
    space = balance.design_space(path, balance="force")
    regions = {"l1": ball_region([0, 0, 0], r1), "l2": ball_region([0, 0, 0], r2)}
    found = point_counterweights(space, ["l1", "l2"], regions)
    second = m2 * d2 / r2
    first = (m1 * d1 + (m2 + second) * length) / r1
    assert found.verdict == "feasible"
    for weight, mass, radius in zip(found.weights, (first, second), (r1, r2), strict=True):
        assert abs(weight.mass - mass) <= 1e-8 * mass
        (lump,) = weight.lumps
        np.testing.assert_allclose(lump.position, [-radius, 0, 0], atol=1e-8 * radius)
    assert found.gap <= 1e-8


def test_the_default_region_is_half_the_link_about_its_joint(rod_arm):
    space = balance.design_space(rod_arm, balance="force")
    found = point_counterweights(space, ["l1", "l2"])
    assert found.chosen == ("l1", "l2")
    assert [region.text for region in found.regions.values()] == [
        "ball(0,0,0,0.5)",
        "ball(0,0,0,0.2)",
    ]


def test_a_region_of_all_is_that_of_each_link_without_one(rod_arm):
    regions = {"all": "80mm", "l2": "0.3"}
    answer = balance.counterweights(rod_arm, ["l1", "l2"], regions, balance="force")
    named = {"l1": "80mm", "l2": "0.3"}
    given = balance.counterweights(rod_arm, ["l1", "l2"], named, balance="force")
    assert {name: x.size for name, x in answer.regions.items()} == {"l1": 0.08, "l2": 0.3}
    assert answer.added_mass == given.added_mass and not answer.chosen
    one = balance.counterweights(rod_arm, ["l2"], {"all": "0.3"}, balance="force")
    assert [*one.regions] == ["l2"] and one.regions["l2"].size == 0.3


def test_a_radius_is_a_ball_about_the_joint_that_carries_the_link(rod_arm):
    """Each lump is on the sphere about its joint: there it has most leverage."""
    space = balance.design_space(rod_arm, balance="force")
    regions = {"l1": "80mm", "l2": "0.3"}
    answer = point_counterweights(space, list(regions), regions, relax=False)
    for weight, radius in zip(answer.weights, (0.08, 0.3), strict=True):
        joint = next(x for x in space.linkage.bodies if x.name == weight.link).link
        away = weight.lumps[0].position + space.frames[joint, :3, 3]
        away = away - space.linkage.joints[joint].point
        assert abs(np.linalg.norm(away) - radius) < 1e-8
    for text in ("0mm", "-80mm"):
        with pytest.raises(UsageError, match="link 'l1': .* a radius is a length above 0"):
            point_counterweights(space, ["l1"], {"l1": text})


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize("seed", range(4))
def test_boxes_hulls_and_many_points(seed, tmp_path):
    """Points inside give no less; their dual proves no more; the hull of a box is the box."""
    rng = np.random.default_rng(seed)
    space, add, _ = random_request(seed, tmp_path / "a.urdf")
    add = list(space.bodies)
    boxes = {}
    for name in add:
        c, h = rng.uniform(-0.3, 0.3, 3), rng.uniform(0.2, 0.6, 3)
        pairs = ",".join(
            f"{a!r}:{b!r}" for a, b in zip((c - h).tolist(), (c + h).tolist(), strict=True)
        )
        boxes[name] = f"box({pairs})"
    found = point_counterweights(space, add, boxes, relax=False)
    least, proved = by_points(space, found.regions, rng)
    if found.verdict != "feasible":
        assert least is None
        return
    assert least is not None
    assert proved * (1 - 1e-6) <= found.added_mass <= least * (1 + 1e-6)
    hulls = {n: hull_region(r.to_link(r.vertices)) for n, r in found.regions.items()}
    again = point_counterweights(space, add, hulls, relax=False)
    assert abs(again.added_mass - found.added_mass) <= 1e-6 * found.added_mass


@pytest.mark.parametrize(
    "shape", ["ball(0,0,0,2)", "box(-2:2,-2:2,-2:2)", "ellipsoid(0,0,0,2,2,1)"]
)
def test_dynamic_balance_in_every_shape(shape):
    """Lumps are inside to 1e-9, make up the mass, and leave no momentum."""
    space = balance.design_space("four_bar_antiparallelogram")
    add = ["crank", "coupler", "rocker"]
    found = point_counterweights(space, add, dict.fromkeys(add, shape))
    assert found.verdict == "feasible" and found.residual <= 1e-12 and found.gap <= 1e-8
    for weight in found.weights:
        assert weight.region.contains(weight.com[None]).all()
        points = np.array([lump.position for lump in weight.lumps]).reshape(-1, 3)
        assert weight.region.contains(points, 1e-9).all()
    h = balance.momentum.momentum_regressor(
        found.space.linkage, {found.space.inputs[0]: 0.3}, spatial=True
    )
    z = found.z.reshape(-1)
    assert np.abs(h @ z).max() <= 1e-12 * np.abs(h).max() * np.abs(z).max()


@pytest.mark.parametrize("seed", range(4))
def test_of_lumps_that_replace_each_other_the_first_is_kept(seed):
    """Whatever the accuracy of a solver leaves in their masses and places, and in prices."""
    rng = np.random.default_rng(seed)
    rows = np.tile(rng.uniform(-1.0, 1.0, (2, 3, 10)), (2, 1, 1))[[0, 2, 1, 3]]
    places = rng.uniform(-1.0, 1.0, (2, 1, 3)).repeat(2, axis=0)
    places += 1e-9 * rng.uniform(-1.0, 1.0, places.shape)
    masses = rng.uniform(0.5, 2.0, 4)
    costs = np.ones((4, 1)) * triangles(np.diag([0.0, 0.0, 0.0, 1.0]))
    costs = costs * (1.0 + 1e-15 * rng.uniform(-1.0, 1.0, (4, 1)))
    lumps = [Lumps(masses[[k]], places[k]) for k in range(4)]
    few = fewer_lumps(rows, costs, lumps)
    assert [cluster.masses.size for cluster in few] == [1, 0, 1, 0]
    for kept, pair in ((few[0], masses[:2]), (few[2], masses[2:])):
        assert abs(kept.masses[0] - pair.sum()) <= 1e-7


@pytest.mark.parametrize("seed", range(6))
def test_a_region_too_small_names_the_growth_that_helps(seed, tmp_path):
    rng = np.random.default_rng(100 + seed)
    second = (float(rng.uniform(0.5, 2)), float(rng.uniform(0.2, 0.5)), 0.8)
    bodies = [(float(rng.uniform(1, 3)), 0.5, 1.0), second]
    path = arm(tmp_path / "a.urdf", 1.0, bodies)
    space = balance.design_space(path, balance="force")
    x, r = float(rng.uniform(0.3, 0.6)), float(rng.uniform(0.05, 0.25))
    small = {"l2": ball_region([x, 0.0, 0.0], r)}
    found = point_counterweights(space, ["l1", "l2"], small)
    assert found.verdict == "infeasible" and "'l2'" in found.words
    assert certificate_fault(found, rng) == ""
    (growth,) = (one for one in found.relaxations if one.links == ("l2",))
    for factor, verdict in ((growth.factor, "feasible"), (0.99 * growth.factor, "infeasible")):
        grown = {"l2": small["l2"].grown(factor)}
        assert point_counterweights(space, ["l1", "l2"], grown, relax=False).verdict == verdict
    assert abs(growth.factor - x / r) <= 2e-3 * x / r


def test_one_more_link_may_help(rod_arm):
    space = balance.design_space(rod_arm, balance="force")
    found = point_counterweights(space, ["l2"])
    assert found.verdict == "infeasible"
    assert [(one.links, one.factor) for one in found.relaxations] == [(("l1",), None)]


def test_all_links_may_help_where_no_single_one_does(tmp_path):
    """Each link of an arm needs a weight of its own: the answer is that for all links."""
    bodies = [(2.0, 0.5, 1.0), (1.0, 0.4, 0.8), (0.5, 0.3, 0.6)]
    space = balance.design_space(arm(tmp_path / "arm.urdf", 1.0, bodies), balance="force")
    found = point_counterweights(space, ["l3"])
    (every,) = found.relaxations
    assert (every.links, every.factor) == (("all",), None)
    assert "adding matter to all links would do" in found.words
    whole = point_counterweights(space, ["all"])
    assert every.mass == pytest.approx(whole.added_mass, rel=1e-6)


def test_a_wrong_certificate_is_rejected(rod_arm):
    space = balance.design_space(rod_arm, balance="force")
    found = point_counterweights(space, ["l2"])
    regions = {1: found.regions["l2"]}
    assert check_exclusion(space, regions, found.certificate).accepted
    rng = np.random.default_rng(0)
    for wrong in (
        -found.certificate,
        found.certificate + 1e-6 * rng.normal(size=6),
        0.0 * found.certificate,
        np.full(6, np.nan),
    ):
        assert not check_exclusion(space, regions, wrong).accepted
    everywhere = {0: ball_region([0, 0, 0], 1.0), 1: found.regions["l2"]}
    assert not check_exclusion(space, everywhere, found.certificate).accepted


@pytest.mark.parametrize("seed", range(8))
def test_the_least_value_of_a_quadratic_polynomial(seed):
    """No sample of the region is below it, and it is the value of a point inside."""
    rng = np.random.default_rng(seed)
    region = read_region(random_region(random.Random(seed)))
    u = region.to_unit(samples(region, rng, 20_000))
    p = np.column_stack([u, np.ones(len(u))])
    for k in range(12):
        M = rng.normal(size=(4, 4))
        M = M @ M.T if k % 3 == 0 else M + M.T
        if k % 3 == 2:
            M[2] = M[:, 2] = 0.0
        M *= (1.0, 1e-170, 1e170)[k % 4 % 3]
        value, at = minimise_in_region(region, M)
        q = np.append(at, 1.0)
        assert abs(q @ M @ q - value) <= 1e-12 * np.abs(M).max()
        assert region.excess(at) <= 1e-12
        assert np.einsum("ni,ij,nj->n", p, M, p).min() >= value - 1e-12 * np.abs(M).max()


@pytest.mark.table(1)
@pytest.mark.parametrize("merge", [False, True])
@pytest.mark.parametrize("model", ["arm", "four_rrr_pair"])
def test_files_with_counterweights_are_balanced(model, merge, rod_arm, tmp_path, capsys):
    model = rod_arm if model == "arm" else model
    links = balance.design_space(model, balance="force").bodies
    out, more = str(tmp_path / "out.urdf"), ["--merge"] * merge
    words = ["--balance", "force"]
    assert (
        main(["counterweights", model, "--links", ",".join(links), "--out", out, *words, *more])
        == 0
    )
    space = balance.design_space(out, balance="force")
    assert space.as_given.balanced and space.bodies == links
    assert main(["verify", out, "--trajectories", "1", *words]) == 0
    capsys.readouterr()


def test_links_of_their_own_and_merged_masses_have_one_momentum(tmp_path):
    space = balance.design_space("four_bar_antiparallelogram")
    add = ["crank", "coupler", "rocker"]
    found = point_counterweights(space, add)
    bodies = []
    for merge in (False, True):
        path = tmp_path / f"{merge}.urdf"
        path.write_bytes(with_counterweights(found, merge=merge))
        bodies.append([b.inertia for b in balance.design_space(str(path)).linkage.bodies])
    size = np.abs(found.z).max()
    assert np.abs(np.array(bodies[0]) - bodies[1]).max() <= 1e-12 * size
    assert np.abs(np.array(bodies[0]) - found.z).max() <= 1e-12 * size


def test_no_other_byte_of_the_file_changes(rod_arm):
    data = Path(rod_arm).read_bytes()
    found = point_counterweights(balance.design_space(rod_arm, balance="force"), ["l1", "l2"])
    new = with_counterweights(found)
    head, tail = data.rsplit(b"</robot>", 1)
    assert new.startswith(head.rstrip(b"\n")) and new.endswith(b"</robot>" + tail)


BAD = {
    "unknown link": (["--links", "ghost"], 3),
    "the ground": (["--links", "base"], 3),
    "region on the ground": (["--links", "l1", "--region", "base=ball(0,0,0,1)"], 3),
    "region of another": (["--links", "l1", "--region", "l2=ball(0,0,0,1)"], 2),
    "twice": (["--links", "l1,l1"], 2),
    "twice apart": (["--links", "l1", "--links", "l1"], 2),
    "no name": (["--links", ","], 2),
    "empty ball": (["--links", "l1", "--region", "l1=ball(0,0,0,0)"], 2),
    "inside out": (["--links", "l1", "--region", "l1=box(1:0,0:1,0:1)"], 2),
    "flat": (["--links", "l1", "--region", "l1=box(0:0,0:1,0:1)"], 2),
    "not a number": (["--links", "l1", "--region", "l1=ball(nan,0,0,1)"], 2),
    "no axis": (["--links", "l1", "--region", "l1=cylinder(0,0,0,0,0,0,1,1)"], 2),
    "no shape": (["--links", "l1", "--region", "l1=cube(1)"], 2),
    "no collision": (["--links", "l1", "--region", "l1=collision"], 3),
    "kept": (["--links", "l1", "--keep", "l2"], 2),
    "no links": (["--region", "l1=ball(0,0,0,1)"], 2),
    "change": (["--links", "l1", "--minimise", "change"], 2),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_requests_write_nothing(name, rod_arm, tmp_path, capsys, caplog):
    words, code = BAD[name]
    out = tmp_path / "no.urdf"
    assert main(["counterweights", rod_arm, *words, "--json", "--out", str(out)]) == code
    told = capsys.readouterr()
    assert told.out == "" and not out.exists()
    assert len(told.err.splitlines()) == (2 if code == 2 else 1)


def test_bad_requests_of_the_function(rod_arm):
    space = balance.design_space(rod_arm, balance="force")
    with pytest.raises(UsageError, match="at least one"):
        point_counterweights(space, [])
    with pytest.raises(BodyError, match="ghost"):
        point_counterweights(space, ["ghost"])
    with pytest.raises(ValueError, match="minimise"):
        point_counterweights(space, ["l1"], minimise="change")


def test_collision_elements_give_a_hull(tmp_path):
    path = tmp_path / "arm.urdf"
    text = Path(arm(path, 1.0, [(2.0, 0.5, 1.0), (1.0, 0.4, 0.8)])).read_text()
    shape = (
        '<collision><origin xyz="0.1 0 0" rpy="0 0 0.3"/><geometry><box size="2 0.2 0.1"/>'
        "</geometry></collision><collision><geometry>"
        '<cylinder radius="0.1" length="0.4"/></geometry></collision></link><joint name="j1"'
    )
    path.write_text(text.replace('</link><joint name="j1"', shape))
    space = balance.design_space(str(path), balance="force")
    found = point_counterweights(space, ["l1", "l2"], {"l1": "collision"})
    region = found.regions["l1"]
    assert region.kind == "hull" and found.verdict == "feasible"
    assert region.contains([[0, 0, 0.2], [0.1, 0, 0]]).all()
    assert not region.contains([[0, 0, 0.21], [2.0, 0, 0]]).any()


@pytest.mark.parametrize(
    ("geometry", "relation", "verdict"),
    [
        (PAIR, "c1=-a1-b1", "feasible"),
        (CROSSED, "c1=-a1-b1", "feasible"),
        (GENERAL, "c1=-a1-b1", "infeasible"),
        (CROSSED, None, "infeasible"),
    ],
)
def test_matter_on_the_base_links_of_a_four_rrr(geometry, relation, verdict, tmp_path):
    """Fig. 6b of the paper of 2011: enough for parallel legs and no rotation."""
    path = tmp_path / "rrr.urdf"
    path.write_text(geometry.text())
    space = balance.design_space(str(path), [relation] if relation else None, balance="force")
    found = point_counterweights(space, BODIES[:4], relax=False)
    assert found.verdict == verdict
    if verdict == "infeasible":
        assert certificate_fault(found, np.random.default_rng(0)) == ""


def test_leg_by_leg_equations_of_a_four_rrr(tmp_path):
    """Eqs. 10 and 11, with the platform's mass at C1, balance; the optimum is no heavier."""
    path = tmp_path / "rrr.urdf"
    path.write_text(GENERAL.text())
    space = balance.design_space(str(path), balance="force")
    radius, total = 0.2, 0.0
    z = np.array([body.inertia for body in space.linkage.bodies])
    A, B, C = GENERAL.points
    for i, (l1, l2) in enumerate(GENERAL.lengths):
        mu = float(i == 0)
        upper = mu * l2 / radius
        lower = (1.0 + upper + mu) * l1 / radius
        for name, mass, joint, end, length in (
            (f"upper{i + 1}", upper, B[i], C[i], l2),
            (f"lower{i + 1}", lower, A[i], B[i], l1),
        ):
            at = np.append(joint - radius * (end - joint) / length, 0.0)
            z[space.bodies.index(name)] += balance.bodies.parameters(mass, at, np.zeros((3, 3)))
            total += mass
    assert balance_residual(space, z) <= 1e-12
    balls = {name: f"ball(0,0,0,{radius})" for name in BODIES[:8]}
    found = point_counterweights(space, BODIES[:8], balls)
    assert found.verdict == "feasible" and found.added_mass <= total * (1 + 1e-9)


def test_the_page_draws_regions_and_lumps(rod_arm):
    space = balance.design_space(rod_arm, balance="force")
    regions = {"l1": "box(-1:0,-0.1:0.1,-0.1:0.1)", "l2": "cylinder(-0.1,0,0,1,0,0,0.1,0.4)"}
    found = point_counterweights(space, ["l1", "l2"], regions)
    page = counterweights_page(found)
    assert 'id="additions"' in page and "balls of steel" in page and "Tungsten" in page
    for name, region in found.regions.items():
        points = np.concatenate(outlines(region))
        assert np.abs(region.excess(region.to_unit(points))).max() <= 1e-12, name


def test_links_may_be_named_one_by_one(capsys):
    """What the second ``--links`` names is added to what the first does."""
    printed = []
    for words in (["--links", "crank,rocker"], ["--links", "crank", "--links", "rocker"]):
        assert (
            main(["counterweights", "four_bar_general", "--balance", "force", *words, "--json"])
            == 0
        )
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]


def test_what_holds_without_conditions_needs_no_matter():
    """Gravity along the normal of the plane does no work, whatever the masses are."""
    words = ["counterweights", "four_bar_antiparallelogram", "--links", "crank", "--json"]
    done = asked([*words, "--require", "gravity"])
    answer = json.loads(done.out)
    assert done.code == 0 and answer["verdict"] == "feasible" and answer["value"] == 0.0
