"""Discs, blocks and cylinders as counterweights: closed forms, another solver, refusals."""

import json
import re

import numpy as np
import pytest
from scipy.optimize import brentq, linprog, minimize

import balance
import kinematics
from balance.app.cli.main import main
from balance.masses.counterweights.decide_points import balance_residual
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.shaped.sectors import fan_of
from balance.masses.counterweights.shaped.weight_shape import read_weight_shapes
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.space.inertial_parameters.conversions import to_chain
from kinematics.errors import UsageError
from tests.independent.second_counterweights import (
    conditions,
    given_parameters,
    point_parameters,
    to_inertial,
)
from tests.independent.shapes_with_webs import shape_and_web

STEEL = 7850.0
# Joints of links of the model four_bar_general, m.
JOINTS = {
    "crank": [[0.0, 0.0], [0.1, 0.3]],
    "coupler": [[0.0, 0.0], [0.8, 0.4]],
    "rocker": [[0.0, 0.0], [-0.2, 0.7]],
}
NEEDED = 0.05  # kg m, what the link of the fixture arm needs on its other side


def least_root(f, high):
    """The least positive root of an increasing, then decreasing function."""
    return brentq(f, 1e-9, high, xtol=1e-15)


def textbook(shape, region):
    """Mass of the lightest shape with its web at the far side of a region, by one equation."""
    kind, size = shape.split("=")
    t = r = float(size)
    if kind == "cylinder":
        # (c + r)² + (l/2)² = R² in the ball, m c = what is needed.
        def with_web(half):
            away = np.sqrt(max(0.1**2 - half**2, 0.0)) - r
            return 2.0 * half * STEEL * np.array(shape_and_web(kind, r, away))

        return with_web(least_root(lambda half: with_web(half)[1] - NEEDED, 0.06))[0]
    reach = {"ball(0,0,0,0.1)": np.sqrt(0.1**2 - 0.25 * t * t)}.get(region, 0.1)

    def mass_and_moment(a):
        return STEEL * t * np.array(shape_and_web(kind, a, reach - a))

    a = least_root(lambda a: mass_and_moment(a)[1] - NEEDED, 2.0 * reach / 3.0)
    return mass_and_moment(a)[0]


@pytest.mark.table(3)
@pytest.mark.parametrize(
    ("shape", "region"),
    [
        ("disc=0.02", "ball(0,0,0,0.1)"),
        ("disc=0.02", "box(-0.1:0.1,-0.1:0.1,-0.02:0.02)"),
        ("disc=0.02", "cylinder(0,0,0.05,0,0,2,0.1,0.02)"),
        ("block=0.02", "box(-0.1:0.1,-0.1:0.1,0:0.02)"),
        ("cylinder=0.02", "ball(0,0,0,0.1)"),
    ],
)
def test_one_link_needs_the_shape_of_the_textbook(shape, region, arm):
    space = balance.design_space(arm, balance="force")
    answer = balance.counterweights(
        space, ["l1"], {"l1": region}, density=STEEL, shape=shape, relax=False
    )
    assert answer.verdict == "feasible", answer.words
    (weight,) = answer.weights
    assert weight.mass == pytest.approx(textbook(shape, region), rel=1e-7)
    np.testing.assert_allclose(weight.mass * weight.com[:2], [-NEEDED, 0.0], atol=1e-12)
    assert answer.gap < 1e-6
    free = balance.counterweights(space, ["l1"], {"l1": region}, density=STEEL, relax=False)
    assert answer.least_mass == free.added_mass < weight.mass
    kind, size = shape.split("=")
    volume = weight.region.volume
    side = weight.region.place[:3, :3]
    if kind == "block":
        assert np.prod(2.0 * np.linalg.norm(side, axis=0)) == pytest.approx(volume, rel=1e-12)
    else:
        radius, half = np.linalg.norm(side[:, 0]), np.linalg.norm(side[:, 2])
        assert 2.0 * np.pi * radius**2 * half == pytest.approx(volume, rel=1e-12)
        assert (radius if kind == "cylinder" else 2.0 * half) == pytest.approx(float(size))


@pytest.mark.slow
@pytest.mark.parametrize("links", [("crank", "rocker"), ("crank", "coupler", "rocker")])
def test_no_discs_of_another_solver_are_lighter(links):
    """Sequential quadratic programs in masses and centres, from many places, end no lower.

    They change discs and webs together.
    """
    regions = {link: "box(-0.3:0.3,-0.4:0.1,-0.02:0.02)" for link in links}
    space = balance.design_space("four_bar_general", balance="force")
    answer = balance.counterweights(
        space, links, regions, density=STEEL, shape="disc=0.03", relax=False
    )
    assert answer.verdict == "feasible"
    frames = [space.frames[space.bodies.index(b)] for b in links]
    given = np.array([body.inertia for body in space.linkage.bodies])
    null = np.linalg.svd(space.scaled_basis.T)[2][space.scaled_basis.shape[1] :]

    def masses(x):
        z = given.copy()
        for (m, cx, cy), link, H in zip(x.reshape(-1, 3), links, frames, strict=True):
            at = H[:3, :3] @ [cx, cy, 0.0] + H[:3, 3]
            z[space.bodies.index(link), :4] += m * np.append(1.0, at)
            z[space.bodies.index(link), :4] += web_of_disc(m, cx, cy, link, H)
        return z

    def web_of_disc(m, cx, cy, link, H):
        """Mass and first moments of a web, from the nearest joint of the model."""
        r = np.sqrt(max(m, 1e-12) / (np.pi * STEEL * 0.03))
        ends = np.array(JOINTS[link])
        joint = ends[np.linalg.norm(ends - [cx, cy], axis=1).argmin()]
        away = np.array([cx, cy]) - joint
        far = float(np.linalg.norm(away))
        disc = STEEL * 0.03 * np.array([np.pi * r * r, np.pi * r * r * far])
        mass, moment = STEEL * 0.03 * np.array(shape_and_web("disc", r, far)) - disc
        at = (H[:3, :3] @ np.append(joint, 0.0) + H[:3, 3]) * mass
        return np.append(mass, at + H[:3, :3] @ np.append(moment * away / far, 0.0))

    def all_mass(x):
        return (masses(x) - given)[:, 0].sum()

    def errors(x):
        chain = to_chain(masses(x), space.chain.frame, space.planar, True).reshape(-1)
        return null @ chain

    low, high = np.array([-0.3, -0.4]), np.array([0.3, 0.1])

    def room(x):
        m, c = x.reshape(-1, 3)[:, :1], x.reshape(-1, 3)[:, 1:]
        r = np.sqrt(np.maximum(m, 1e-12) / (np.pi * STEEL * 0.03))
        return np.concatenate([c - low - r, high - c - r], axis=1).reshape(-1)

    rng, best = np.random.default_rng(3), np.inf
    for _ in range(20):
        start = np.array([[2.0, *rng.uniform(low, high)] for _ in links]).reshape(-1)
        tried = minimize(
            all_mass,
            start,
            method="SLSQP",
            bounds=[(1e-9, 20.0), (None, None), (None, None)] * len(links),
            constraints=[{"type": "eq", "fun": errors}, {"type": "ineq", "fun": room}],
            options={"maxiter": 500, "ftol": 1e-12},
        )
        if tried.success and balance_residual(space, masses(tried.x)) < 1e-8:
            best = min(best, tried.fun)
    assert best >= answer.added_mass * (1.0 - 1e-6)
    assert best == pytest.approx(answer.added_mass, rel=1e-4)


def test_a_four_bar_with_two_discs_in_one_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["--balance", "force", "--links", "crank,rocker", "--density", "7850", "--json"]
    more = ["--shape", "disc=20mm", "--parts", "made", "--out", "discs.urdf"]
    assert main(["counterweights", "four_bar_general", *words, *more]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["shape"] == "disc=20mm" and 2.9 < told["least_mass"] < told["added_mass"]
    text = (tmp_path / "discs.urdf").read_text()
    assert text.count("<mesh filename=") == 4  # <visual> and <collision> of two discs
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == [
        "README.txt",
        "crank.dxf",
        "crank.stl",
        "parts.csv",
        "rocker.dxf",
        "rocker.stl",
    ]
    assert main(["verify", "discs.urdf", "--trajectories", "1", "--balance", "force"]) == 0
    capsys.readouterr()


REFUSED = {
    "two sizes": ({"shape": "disc=0.02,0.1"}, "write disc=0.02"),
    "outside": (
        {"shape": "sector=0.02", "regions": {"l1": "box(-0.2:-0.1,-1:1,-1:1)"}},
        "does not hold the axis of joint 'j1'",
    ),
    "large": ({"shape": "sector=0.02,0.3", "regions": {"l1": "ball(0,0,0,0.2)"}}, "no sector"),
    "edge": (
        {"shape": "sector=0.02", "regions": {"l1": "box(-0.2:0,-1:1,-1:1)"}},
        "holds no circle about joint 'j1': give the radius too",
    ),
    "many": (
        {
            "regions": {"l1": "ball(0,0,0,0.2)"},
            "shape": "disc=" + "/".join(str(0.001 + 1e-5 * k) for k in range(257)),
        },
        "257 sizes on 1 links are 257 choices",
    ),
    "no density": ({"density": None}, "point masses have none"),
    "dynamic": ({"balance": "dynamic"}, "ask for force balance"),
    "thickness": ({"thickness": 0.01}, "leave out the rest"),
    "objective": ({"minimise": "rotor"}, "leave out the rest"),
    "thin": ({"regions": {"l1": "box(-1:1,-1:1,0:0.01)"}}, "too thin for discs of thickness"),
    "oblique": ({"regions": {"l1": "ellipsoid(0,0,0,1,2,3)"}}, "is no ball, box, hull"),
    "no shape": ({"shape": "disc"}, "write disc=0.02"),
    "no size": ({"shape": "disc=0"}, "write disc=0.02"),
}


@pytest.mark.table(3)
@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_go_with_a_shape_is_told(name, arm):
    more, told = REFUSED[name]
    more = {"shape": "disc=0.02", "density": STEEL, "balance": "force", **more}
    space = balance.design_space(arm, balance=more.pop("balance"))
    with pytest.raises(UsageError, match=told):
        balance.counterweights(space, ["l1"], **more, relax=False)


def test_a_linkage_without_a_plane_has_no_shapes():
    with pytest.raises(UsageError, match="'delta' has none: leave out the shape, and give reg"):
        balance.counterweights("delta", "all", shape="cylinder=40mm", balance="force")


def test_units_of_shapes():
    assert read_weight_shapes("disc=20mm") == read_weight_shapes("disc=0.02")
    assert read_region("ball(0,0,0,20mm)").size == 0.02
    cylinders = (f"cylinder(0,0,0,0,0,1,{size})" for size in ("45mm,3cm", "0.045,0.03"))
    assert len({repr(read_region(text)) for text in cylinders}) == 1


@pytest.mark.parametrize("region", ["ball(0,0,0,0.12)", "box(-0.12:0.3,-0.12:0.2,0:0.02)"])
def test_a_sector_has_the_angle_of_the_textbook(region, arm):
    """2/3 ρ t R³ sin α balances; without a radius R is that of the largest circle."""
    t, R = 0.02, 0.12
    if region.startswith("ball"):
        R = np.sqrt(R * R - 0.25 * t * t)
    space = balance.design_space(arm, balance="force")
    answer = balance.counterweights(
        space, ["l1"], {"l1": region}, shape="sector=0.02", relax=False
    )
    alpha = np.arcsin(NEEDED / (2.0 / 3.0 * STEEL * t * R**3))
    (weight,) = answer.weights
    assert answer.verdict == "feasible" and answer.gap < 1e-9
    assert weight.mass == pytest.approx(STEEL * t * alpha * R * R, rel=1e-9)
    np.testing.assert_allclose(weight.mass * weight.com[:2], [-NEEDED, 0.0], atol=1e-12)
    assert weight.region.half_angle == pytest.approx(alpha, rel=1e-9)
    assert weight.region.volume == pytest.approx(weight.mass / STEEL, rel=1e-9)
    middle = weight.mass / STEEL / t * R * R / 4.0  # ∫ r² dA / 2 of a sector is α R⁴ / 4
    polar = weight.inertia[2, 2] + weight.mass * weight.com[:2] @ weight.com[:2]
    assert polar == pytest.approx(STEEL * t * 2.0 * middle, rel=1e-9)


def wedges(region, at, R, t, count):
    """Directions about an axis in which a region holds the whole wedge, by points of it."""
    turn = (np.arange(count) + 0.5) * 2.0 * np.pi / count
    e = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    ends = [at + r * e + [0, 0, z] for r in (0.0, 0.5 * R, R) for z in (-0.5 * t, 0.5 * t)]
    inside = np.all([region.contains(points) for points in ends], axis=0)
    return e[inside], STEEL * t * R * R * np.pi / count


@pytest.mark.slow
@pytest.mark.parametrize(
    "regions",
    [
        {"crank": "ball(0,0,0,0.3)", "rocker": "ball(0,0,0,0.3)"},
        {"crank": "box(-0.15:0.4,-0.3:0.3,-0.03:0.03)", "rocker": "ball(-0.03,0,0,0.25)"},
        {"crank": "ball(0.05,-0.1,0,0.3)", "rocker": "box(-0.3:0.3,-0.3:0.3,-1:1,0,0,0.4)"},
        dict.fromkeys(("crank", "coupler", "rocker"), "ball(0,0,0,0.3)"),
    ],
)
def test_no_wedges_of_a_linear_program_are_lighter_than_sectors(regions):
    """Thin wedges of the same disc, each with any share, balance with as much and no less."""
    t, R, count = 0.04, 0.22, 6000
    space = balance.design_space("four_bar_general", balance="force")
    answer = balance.counterweights(
        space, list(regions), regions, shape=f"sector={t},{R}", relax=False
    )
    assert answer.verdict == "feasible", answer.words
    rows = conditions(space)
    per_link = rows.reshape(len(rows), len(space.bodies), -1)
    columns, capacities = [], []
    for name, text in regions.items():
        e, most = wedges(read_region(text), np.zeros(3), R, t, count)
        # The centre of a sector as narrow as this is at 2/3 of the radius.
        points = to_inertial(space, name, 2.0 / 3.0 * R * e)
        part = per_link[:, space.bodies.index(name)]
        columns.append(part @ point_parameters(space, points).T)
        capacities.append(np.full(len(e), most))
    A, cap = np.hstack(columns), np.concatenate(capacities)
    target = -rows @ given_parameters(space).reshape(-1)
    least = linprog(
        np.ones(A.shape[1]), A_eq=A, b_eq=target, bounds=np.column_stack([0 * cap, cap])
    )
    assert least.status == 0
    assert least.fun == pytest.approx(answer.added_mass, rel=1e-5)


@pytest.mark.table(2)
@pytest.mark.parametrize("kind", ["disc", "sector"])
def test_of_several_sizes_the_lightest_is_chosen(kind, arm):
    """Of sizes alone, all of which balance, none is lighter, and one is as light."""
    space, region = balance.design_space(arm, balance="force"), {"l1": "ball(0,0,0,0.12)"}
    sizes = ("0.01", "0.03", "0.1", "0.22")
    masses = [
        balance.counterweights(
            space, ["l1"], region, shape=f"{kind}={size}", relax=False
        ).added_mass
        for size in sizes
    ]
    several = balance.counterweights(
        space, ["l1"], region, shape=f"{kind}={'/'.join(sizes)}", relax=False
    )
    lightest = min(mass for mass in masses if mass > 0.0)
    assert several.added_mass == pytest.approx(lightest, rel=1e-9)
    assert max(masses) > 1.05 * lightest
    in_mm = "/".join(f"{1e3 * float(size):g}mm" for size in sizes)
    assert several.shape == f"{kind}={in_mm}"


def test_a_slider_has_no_sectors():
    space = balance.design_space("slider_crank", balance="force")
    free = balance.counterweights(space, ["crank"], relax=False)
    stock = Stock(read_region("ball(0,0,0,3)"), STEEL)
    (shape,) = read_weight_shapes("sector=0.02")
    crank, slider = (space.bodies.index(name) for name in ("crank", "slider"))
    assert fan_of(free.space, crank, stock, shape).fan.allowed.width == 2.0 * np.pi
    with pytest.raises(UsageError, match="sectors are about a joint that turns, and 'q4'"):
        fan_of(free.space, slider, stock, shape)


@pytest.mark.parametrize("merge", [False, True])
@pytest.mark.parametrize("shape", ["disc=0.02", "sector=0.02", None])
def test_files_have_no_round_off(shape, merge, turned_arm, tmp_path):
    """The counterweight is on the x-axis of its link: what is across it is exactly 0."""
    space, made = balance.design_space(turned_arm, balance="force"), tmp_path / "made.urdf"
    regions, density = {"l1": "ball(0,0,0,0.1)"}, STEEL if shape else None
    answer = balance.counterweights(
        space, ["l1"], regions=regions, density=density, shape=shape
    )
    text = answer.to_urdf(made, merge=merge).decode()
    numbers = [float(x) for x in re.findall(r'(?<=[ "])-?[0-9][^ "]*(?=[ "])', text)]
    assert len(numbers) > 15 and not [x for x in numbers if 0.0 < abs(x) < 1e-9]
    linkage = kinematics.load(made)
    assert not {"origin_noise", "axis_noise"} & {notice.code for notice in linkage.notices}
    moment = sum(np.array(body.inertia[1:4]) for body in linkage.bodies)
    mass = sum(float(body.inertia[0]) for body in linkage.bodies)
    np.testing.assert_allclose(moment, mass * np.array([1.0, 0.3, 0.0]), atol=1e-6)
