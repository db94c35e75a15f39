"""Matter of limited density: closed forms, cells and linear programs, certificates, plates."""

import json
import random

import numpy as np
import pytest

import balance
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.regions import hull_region
from balance.masses.counterweights.volume.cut_regions import (
    Stock,
    cut_moments,
    fill,
    support_function,
)
from balance.masses.counterweights.volume.filling_check import check_filling
from kinematics.errors import BodyError, UsageError
from tests.independent.counterweight_requests import random_request
from tests.independent.filled_cells import cells, least_masses
from tests.independent.second_counterweights import samples
from tests.support.points import point_counterweights

STEEL = 7850.0
UNIT = {
    "ball": read_region("ball(0,0,0,1)"),
    "cylinder": read_region("cylinder(0,0,0,0,0,1,1,2)"),
    "box": read_region("box(-1:1,-1:1,-1:1)"),
    "hull": hull_region(np.random.default_rng(5).normal(size=(40, 3))),
}


def one_link(path, mass_moment, extra=""):
    """One link that turns about z, with 1 kg at x; its frame is the inertial one."""
    path.write_text(
        '<robot name="one"><link name="base"/><link name="l1"><inertial>'
        f'<origin xyz="{mass_moment!r} 0 0"/><mass value="1"/>'
        '<inertia ixx="0" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
        f'{extra}</link><joint name="j1" type="continuous"><parent link="base"/>'
        '<child link="l1"/><axis xyz="0 0 1"/></joint></robot>'
    )
    return balance.design_space(str(path), balance="force")


def direction(rng):
    n = rng.normal(size=3)
    return n / np.linalg.norm(n)


@pytest.mark.parametrize("height", [-0.7, 0.0, 0.4, 0.95])
def test_a_cap_of_a_ball_has_the_volume_and_centre_of_the_textbook(height):
    n, depth = direction(np.random.default_rng(2)), 1.0 - height
    P = cut_moments(UNIT["ball"], n, -height)
    volume = np.pi * depth**2 * (3.0 - depth) / 3.0
    centre = 0.75 * (2.0 - depth) ** 2 / (3.0 - depth)
    np.testing.assert_allclose(P[3, 3], volume, rtol=1e-13)
    np.testing.assert_allclose(P[:3, 3], volume * centre * n, atol=1e-13)


def test_a_hoof_of_a_cylinder_has_the_volume_and_centre_of_the_textbook():
    """The wedge over half a disc of radius 1 up to the height h: 2/3 h, (3π/16, 3πh/32)."""
    h = 2.0  # from z = -1 over the diameter to z = 1 at the rim x = 1
    P = cut_moments(UNIT["cylinder"], np.array([h, 0.0, -1.0]), -1.0)
    volume = 2.0 / 3.0 * h
    np.testing.assert_allclose(P[3, 3], volume, rtol=1e-13)
    centre = [3.0 * np.pi / 16.0, 0.0, -1.0 + 3.0 * np.pi * h / 32.0]
    np.testing.assert_allclose(P[:3, 3] / volume, centre, atol=1e-13)


@pytest.mark.parametrize("distance", [-0.6, 0.0, 0.3])
def test_a_segment_of_a_cylinder_has_the_area_and_centre_of_the_textbook(distance):
    P = cut_moments(UNIT["cylinder"], np.array([0.6, 0.8, 0.0]), -distance)
    area = np.arccos(distance) - distance * np.sqrt(1.0 - distance**2)
    moment = 2.0 / 3.0 * (1.0 - distance**2) ** 1.5
    np.testing.assert_allclose(P[3, 3], 2.0 * area, rtol=1e-13)
    np.testing.assert_allclose(P[:3, 3], [1.2 * moment, 1.6 * moment, 0.0], atol=1e-13)


@pytest.mark.parametrize("kind", UNIT)
def test_both_sides_of_a_plane_make_up_the_region(kind):
    """And the first moments of one side are those of cells, to the size of the cells."""
    rng, region = np.random.default_rng(3), UNIT[kind]
    n, c = direction(rng), 0.2
    one, other = cut_moments(region, n, c), cut_moments(region, -n, -c)
    whole = cut_moments(region, np.zeros(3), 1.0)
    np.testing.assert_allclose(one + other, whole, atol=1e-13)
    np.testing.assert_allclose(whole[3, 3], region.volume / np.linalg.det(region.place[:3, :3]))
    points, size, _ = cells(region, 60_000)
    u = region.to_unit(points)
    u = u[(region.excess(u) <= 0.0) & (u @ n + c > 0.0)]
    weight = np.prod(size) / np.linalg.det(region.place[:3, :3])
    p = np.column_stack([u, np.ones(len(u))])
    np.testing.assert_allclose(weight * p.T @ p, one, atol=2e-2 * whole[3, 3])


@pytest.mark.parametrize("kind", UNIT)
def test_a_small_ball_inside_is_integrated_within_the_estimate(kind):
    """A ball of radius 0.2 off the centre: 4π r³/3, and 4π r⁵/15 about its middle."""
    r, at = 0.2, np.array([0.1, -0.1, 0.05])
    Q = -np.eye(4)
    Q[:3, 3] = Q[3, :3] = at
    Q[3, 3] = r * r - at @ at
    stock = Stock(UNIT[kind], 1.0).with_rays_inside(Q)
    P = fill(stock, Q) / stock.per_volume
    volume = 4.0 / 3.0 * np.pi * r**3
    np.testing.assert_allclose(P[3, 3], volume, rtol=1e-5)
    np.testing.assert_allclose(P[:3, 3], volume * at, atol=1e-5 * volume)
    second = volume * (np.outer(at, at) + 0.2 * r * r * np.eye(3))
    np.testing.assert_allclose(P[:3, :3], second, atol=1e-5 * volume)
    value, error = support_function(stock, Q)
    exact = stock.per_volume * volume * 0.4 * r * r  # the mean of r² - x² is 0.4 r²
    assert abs(value - exact) <= error + 1e-9 * exact
    assert error <= 1e-4 * exact


@pytest.mark.slow
def test_no_matter_of_the_density_has_more_than_the_support_function():
    """Random densities between 0 and the limit on cells of the region stay below it."""
    rng = np.random.default_rng(8)
    for region in UNIT.values():
        points, size, inside = cells(region, 3000)
        u = np.column_stack([region.to_unit(points[inside]), np.ones(inside.sum())])
        weight = np.prod(size)
        stock = Stock(region, 1.0)
        for _ in range(5):
            Q = rng.normal(size=(4, 4))
            Q = Q + Q.T
            value, error = support_function(stock.with_rays_inside(Q), Q)
            unit = size / np.linalg.norm(region.place[:3, :3], axis=0)
            # A cell's second moment about its middle adds up to so much.
            own = np.abs(Q[:3, :3]).sum() * np.square(unit).sum() / 12.0 * weight * len(u)
            values = np.einsum("ni,ij,nj->n", u, Q, u) * weight
            greedy = values[values > 0.0].sum()
            assert greedy <= value + error + own
            for share in rng.uniform(size=(3, len(u))):
                assert share @ values <= value + error + own


def dense_request(seed, path):
    """A random request that points balance, and a density that counts; None if they do not."""
    space, add, regions = random_request(seed, path)
    points = point_counterweights(space, add, regions, relax=False)
    if not points.weights:
        return None
    mean = max(weight.mean_density for weight in points.weights)
    return space, add, regions, mean * random.Random(seed).uniform(1.0, 8.0), points


def check_against_cells(seed, path, count):
    """The least mass is between the bounds of cells; what does not fit fits no cells."""
    request = dense_request(seed, path)
    if request is None:
        return None
    space, add, regions, density, points = request
    found = balance.counterweights(space, add, regions, density=density, relax=False)
    lower, upper = least_masses(space, found.regions, density, count)
    assert found.verdict in ("feasible", "infeasible")
    if found.verdict == "infeasible":
        assert upper == np.inf and found.check.accepted
    else:
        assert lower <= found.added_mass * (1.0 + 1e-8)
        assert found.added_mass <= upper * (1.0 + 1e-8)
        assert points.added_mass <= found.added_mass and found.gap <= 1e-9
    return found.verdict


@pytest.mark.table(3)
@pytest.mark.parametrize("seed", [20, 43, 49, 17, 69, 77])
def test_the_least_mass_of_forces_is_that_of_linear_programs_over_cells(seed, tmp_path):
    assert check_against_cells(seed, tmp_path / "a.urdf", 3000)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 55])
def test_more_least_masses_of_forces_are_those_of_linear_programs(first, tmp_path):
    """Of 55 requests those that point masses fulfil, over 8,000 cells a region."""
    seeds = range(first, first + 55)
    verdicts = [check_against_cells(seed, tmp_path / "a.urdf", 8000) for seed in seeds]
    assert verdicts.count("feasible") >= 3 and verdicts.count("infeasible") >= 3


def held_by_cells(data, regions, density, count=40_000):
    """What the certificate of a report has on matter in regions, from the report alone.

    Cells that touch a region count whole, and each by its largest corner: never too little.
    """
    chain = data["chain"]
    w = np.array(data["certificate"]).reshape(len(chain["bodies"]), -1)
    R, origin, length = np.array(chain["axes"]), np.array(chain["origin"]), chain["length"]
    total = 0.0
    for name, region in regions.items():
        points, size, _ = cells(region, count)
        corners = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T * size
        x = ((points[:, None] + corners) - origin) @ R.T / length
        terms = {"m": np.ones(x.shape[:2]), "mcx": x[..., 0], "mcy": x[..., 1]}
        part = w[chain["bodies"].index(name)]
        values = sum(c * terms[p] for c, p in zip(part, chain["parameters"], strict=True))
        total += density * np.prod(size) * np.maximum(values.max(axis=1), 0.0).sum()
    return total


def test_a_stranger_checks_the_certificate_from_the_report_alone(tmp_path):
    """The link frame is the inertial one: what a kilogram at x has follows from the report."""
    space = one_link(tmp_path / "one.urdf", 0.5)
    region = read_region("box(-0.2:-0.1,-0.05:0.05,-0.02:0.02)")
    found = balance.counterweights(space, ["l1"], {"l1": region}, density=STEEL, relax=False)
    assert found.verdict == "infeasible" and found.check.accepted
    data = json.loads(json.dumps(found.to_dict()))
    chain = data["chain"]
    x = np.array(chain["axes"]) @ (np.array([0.5, 0.0, 0.0]) - chain["origin"])
    given = np.array([1.0, *(x / chain["length"])[:2]])
    w = np.array(data["certificate"])
    assert held_by_cells(data, {"l1": region}, STEEL) < -w @ given
    # All the steel there moments at most 3.14 kg × 0.15 m against 0.5 kg m.
    assert abs(found.check.most / found.check.margin - 3.14 * 0.15 / 0.5) <= 1e-9


def test_a_wrong_certificate_of_filling_is_rejected(tmp_path):
    space = one_link(tmp_path / "one.urdf", 0.5)
    regions = {"l1": read_region("box(-0.2:-0.1,-0.05:0.05,-0.02:0.02)")}
    found = balance.counterweights(space, ["l1"], regions, density=STEEL, relax=False)
    stocks = {0: Stock(regions["l1"], STEEL)}
    assert check_filling(space, stocks, found.certificate).accepted
    assert not check_filling(space, stocks, -found.certificate).accepted
    assert not check_filling(space, {0: Stock(regions["l1"], 1.1 * STEEL)}, found.certificate)[
        0
    ]
    assert not check_filling(space, stocks, np.zeros(found.certificate.size)).accepted


@pytest.mark.slow
def test_what_does_not_fit_names_the_density_and_the_region_that_do(tmp_path):
    space = one_link(tmp_path / "one.urdf", 0.5)
    region = read_region("box(-0.2:-0.1,-0.05:0.05,-0.02:0.02)")
    found = balance.counterweights(space, ["l1"], {"l1": region}, density=STEEL)
    denser, larger = found.relaxations
    factor = 0.5 / (3.14 * 0.15)
    assert denser.links == () and abs(denser.factor - factor) <= 1e-3 * factor
    assert "times as dense would do" in found.words
    # About its middle the region grows as k³, and then holds as much moment.
    assert larger.links == ("l1",) and abs(larger.factor - factor ** (1 / 3)) <= 2e-3
    for part, verdict in ((1.01, "feasible"), (0.99, "infeasible")):
        more = balance.counterweights(
            space, ["l1"], {"l1": region}, density=part * denser.factor * STEEL, relax=False
        )
        wider = balance.counterweights(
            space,
            ["l1"],
            {"l1": region.grown(part * larger.factor)},
            density=STEEL,
            relax=False,
        )
        assert (more.verdict, wider.verdict) == (verdict, verdict)


def test_a_box_is_filled_from_its_far_face(tmp_path):
    """2 ρ A x dx from the far face: the cut d solves ρ A (0.3² - d²)/2 = 0.2 kg m."""
    space = one_link(tmp_path / "one.urdf", 0.2)
    regions = {"l1": "box(-0.3:-0.1,-0.05:0.05,-0.02:0.02)"}
    found = balance.counterweights(space, ["l1"], regions, density=STEEL)
    cut = np.sqrt(0.3**2 - 2.0 * 0.2 / (STEEL * 0.004))
    (weight,) = found.weights
    normal, distance = weight.cut
    np.testing.assert_allclose(normal, [-1.0, 0.0, 0.0], atol=1e-9)
    assert abs(distance - cut) <= 1e-9
    assert abs(weight.mass - STEEL * 0.004 * (0.3 - cut)) <= 1e-9
    assert abs(weight.mass * weight.com[0] + 0.2) <= 1e-12
    inertia = weight.mass * (0.1**2 + (0.3 - cut) ** 2) / 12.0
    assert abs(weight.inertia[2, 2] - inertia) <= 1e-9
    assert "% of box" in weight.what and found.gap <= 1e-12


@pytest.mark.parametrize("moment", [0.05, 0.3])
def test_a_plate_on_a_disc_is_the_segment_of_the_textbook(moment, tmp_path):
    """ρ t 2/3 (R² - d²)^{3/2} balances, wherever the middle of the ball is along z."""
    space, R, t = one_link(tmp_path / "one.urdf", moment), 0.2, 0.01
    regions = {"l1": "cylinder(0,0,0.05,0,0,1,0.2,0.3)"}
    found = balance.counterweights(
        space, ["l1"], regions, density=STEEL, thickness=t, relax=False
    )
    power = (1.5 * moment / (STEEL * t)) ** (2.0 / 3.0)
    assert (found.verdict == "feasible") == (power < R * R)
    if found.weights:
        d = np.sqrt(R * R - power)
        (weight,) = found.weights
        mass = STEEL * t * (R * R * np.arccos(d / R) - d * np.sqrt(R * R - d * d))
        assert abs(weight.mass - mass) <= 1e-9 * mass
        assert abs(weight.com[2]) <= 1e-12 and weight.region.kind == "cylinder"


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        ("ball(0,0,0.03,0.05)", 0.02 * np.pi * (0.05**2 - 0.03**2)),
        ("box(0:0.1,0:0.2,-0.5:0.5)", 0.02 * 0.02),
        ("cylinder(0,0,0.01,1,0,0,0.05,0.3)", 0.02 * 0.3 * 2 * np.sqrt(0.05**2 - 0.01**2)),
        ("ellipsoid(0,0,0,0.1,0.2,0.3)", 0.02 * np.pi * 0.02),
    ],
)
def test_a_plate_has_the_section_of_its_region(shape, volume, tmp_path):
    space = one_link(tmp_path / "one.urdf", 0.0)
    from balance.masses.counterweights.volume.plates import density_limits, stocks_of

    regions = {0: read_region(shape)}
    stock = stocks_of(space, regions, density_limits(space, regions, 1.0, 0.02))[0]
    assert abs(stock.whole - volume) <= 1e-12


WRONG = {
    "inertia": {"minimise": "inertia", "price_of_mass": -1.0},
    "no density": {"thickness": 0.01, "density": None},
    "negative": {"density": -1.0},
    "price": {"price_of_mass": -1.0},
    "missed": {"density": STEEL, "thickness": 0.01, "regions": {"l1": "ball(0,0,1,0.1)"}},
    "oblique": {
        "density": STEEL,
        "thickness": 0.01,
        "regions": {"l1": "cylinder(0,0,0,1,0,1,1,1)"},
    },
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_densities_are_refused(case, tmp_path):
    space = one_link(tmp_path / "one.urdf", 0.1)
    with pytest.raises(UsageError):
        balance.counterweights(space, ["l1"], **WRONG[case])
    with pytest.raises(BodyError):
        balance.counterweights(space, ["l1"], density={"other": 1.0, "l1": 1.0})


@pytest.mark.table(1)
@pytest.mark.parametrize("price", [0.05, 1.0])
def test_the_largest_inertia_in_steel_is_that_of_linear_programs(price, tmp_path):
    """Of one link Izz is the largest: first moments of cells that fill the box exactly."""
    from scipy.optimize import linprog

    space = one_link(tmp_path / "one.urdf", 0.2)
    region = read_region("box(-0.3:-0.05,-0.05:0.05,-0.02:0.02)")
    found = balance.counterweights(
        space, ["l1"], {"l1": region}, "inertia", price_of_mass=price, relax=False
    )
    points, size, inside = cells(region, 60_000)
    assert inside.all()
    arms = points[:, :2] ** 2 + size[:2] ** 2 / 12.0
    cap = STEEL * np.prod(size)
    best = linprog(
        arms.sum(axis=1) + found.price,
        A_eq=points[:, :2].T,
        b_eq=[-0.2, 0.0],
        bounds=(0.0, cap),
    )
    least = best.fun + 0.01 + 0.2**2  # with that of the link itself
    assert found.priced * (1.0 - found.gap) <= least
    assert abs(found.priced - least) <= 1e-3 * least and found.gap <= 1e-5


def test_the_price_of_mass_is_stated_and_chosen():
    """Without a price doubled masses at half the levers are better; the bound says so."""
    space = balance.design_space("four_bar_general", balance="force")
    priced = point_counterweights(space, ["crank", "rocker"], minimise="rotor")
    free = point_counterweights(
        space, ["crank", "rocker"], minimise="rotor", price_of_mass=1e-4
    )
    assert free.value < 0.9 * priced.value and free.added_mass > priced.added_mass
    assert priced.priced <= free.value + priced.price * free.added_mass
    assert abs(priced.price - 0.01 * space.length**2) <= 1e-15
    assert free.priced <= priced.value + free.price * priced.added_mass


@pytest.mark.slow
@pytest.mark.parametrize("minimise", ["mass", "inertia", "rotor"])
def test_a_random_search_finds_nothing_below_the_bound(minimise):
    """Mixtures of balanced point masses anywhere in the regions, 20,000 of them."""
    from scipy.optimize import linprog

    from tests.independent.second_counterweights import (
        conditions,
        given_parameters,
        point_parameters,
        to_inertial,
    )

    space = balance.design_space("four_bar_general", balance="force")
    found = balance.counterweights(space, ["crank", "rocker"], minimise=minimise)
    best, bound = found.priced, found.priced * (1.0 - found.gap)
    rng, rows = np.random.default_rng(1), conditions(space)
    target = -rows @ given_parameters(space).reshape(-1)
    per_link = rows.reshape(len(rows), len(space.bodies), -1)
    points = {name: samples(region, rng, 300) for name, region in found.regions.items()}
    for name, x in points.items():
        points[name] = np.concatenate([x, 0.5 * x])
    columns = [
        per_link[:, space.bodies.index(n)] @ point_parameters(space, to_inertial(space, n, x)).T
        for n, x in points.items()
    ]
    A = np.hstack(columns)
    corners = [
        linprog(rng.uniform(0.1, 1.0, A.shape[1]), A_eq=A, b_eq=target).x for _ in range(30)
    ]
    from balance.masses.counterweights.added_program import added_objective, build_added_program

    regions = {space.bodies.index(n): r for n, r in found.regions.items()}
    program = build_added_program(space, regions, minimise)
    at = np.cumsum([0, *(len(x) for x in points.values())])
    moments = []
    for masses in corners:
        parts = []
        for k, (name, region) in enumerate(found.regions.items()):
            u = region.to_unit(points[name])
            p = np.column_stack([u, np.ones(len(u))])
            parts.append((masses[at[k] : at[k + 1]] * p.T) @ p / program.unit)
        moments.append(parts)
    moments = np.array(moments)
    least = np.inf
    for share in rng.dirichlet(np.full(len(corners), 0.2), size=20_000):
        value, _ = added_objective(program, list(np.tensordot(share, moments, 1)))
        mass = program.unit * np.tensordot(share, moments, 1)[:, 3, 3].sum()
        least = min(least, value + found.price * mass)
    assert least >= bound * (1.0 - 1e-9) and best >= bound


@pytest.mark.slow
def test_the_newcomer_gets_parts_that_fit():
    """Counterweights on crank and rocker, forces: inside their regions, in steel."""
    space = balance.design_space("four_bar_general", balance="force")
    found = balance.counterweights(space, ["crank", "rocker"], density=STEEL)
    assert found.verdict == "feasible" and found.residual <= 1e-12
    for weight in found.weights:
        points, size, _ = cells(weight.region, 300_000)
        p = np.column_stack([points, np.ones(len(points))])
        full = weight.region.contains(points) & (
            np.einsum("ni,ij,nj->n", p, weight.form, p) > 0.0
        )
        mass = STEEL * np.prod(size) * full.sum()
        assert abs(mass - weight.mass) <= 0.1 * weight.mass


@pytest.mark.slow
def test_dynamic_balance_needs_no_more_than_linear_programs_over_cells(tmp_path):
    """Twenty problems: cells inside the regions need more than the least, and little more."""
    from scipy.optimize import linprog

    from tests.independent.second_counterweights import (
        conditions,
        given_parameters,
        point_parameters,
        to_inertial,
    )

    corners, verdicts = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T, []
    for seed in range(1, 400, 2):
        space, add, regions = random_request(seed, tmp_path / "a.urdf", "dynamic")
        points = point_counterweights(space, add, regions, relax=False)
        if not points.weights:
            continue
        mean = max(weight.mean_density for weight in points.weights)
        density = mean * random.Random(seed).uniform(3.0, 60.0)
        found = balance.counterweights(space, add, regions, density=density, relax=False)
        space = found.space
        rows, given = conditions(space), given_parameters(space)
        per_link = rows.reshape(len(rows), len(space.bodies), -1)
        columns, capacity = [], []
        for name, region in found.regions.items():
            middles, size, inside = cells(region, 8000)
            middles = middles[inside]
            # Eight points have the second moments of a cell.
            parts = [
                point_parameters(
                    space, to_inertial(space, name, middles + corner * size / np.sqrt(12.0))
                )
                for corner in corners
            ]
            columns.append(per_link[:, space.bodies.index(name)] @ np.mean(parts, axis=0).T)
            capacity.append(np.full(len(middles), density * np.prod(size)))
        A, cap = np.hstack(columns), np.concatenate(capacity)
        best = linprog(
            np.ones(len(cap)),
            A_eq=A,
            b_eq=-rows @ given.reshape(-1),
            bounds=np.column_stack([0.0 * cap, cap]),
        )
        verdicts.append(found.verdict)
        if found.verdict == "feasible":
            assert best.status == 2 or found.added_mass <= best.fun * (1.0 + 1e-4)
            assert best.status == 2 or best.fun <= 1.5 * found.added_mass
        else:
            assert best.status == 2
        if len(verdicts) == 20:
            break
    assert verdicts.count("feasible") >= 5 and verdicts.count("infeasible") >= 3
    assert len(verdicts) == 20 and verdicts.count("undecided") <= 2
