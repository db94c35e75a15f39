"""The least shaking with matter of limited density, against least squares over cells."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import balance
from balance.masses.counterweights.region_text import read_region
from balance.masses.partial_balance.shaking_problem import ShakingOptions, build_problem
from balance.motion.verification.trajectory import random_motions
from balance.support.clarabel_adapter import triangles
from kinematics.loading.model_gallery import as_linkage, find
from tests.independent.filled_cells import cells

STEEL = 7850.0
BOXES = {"crank": "box(-0.2:0,-0.2:0,-0.01:0.01)", "rocker": "box(0:0.2,-0.4:-0.1,-0.01:0.01)"}


def question(balanced, count=1):
    linkage = as_linkage("four_bar_general")
    space = balance.design_space(linkage, balance=balanced, max_order=0)
    return space, list(random_motions(linkage, count, 60))


def cells_of(regions, density, count):
    """Moments of cells inside regions, kg, and their masses, by link."""
    parts = []
    for region in regions:
        middles, size, inside = cells(region, count)
        own = np.zeros((4, 4))
        back = np.linalg.inv(region.place)
        own[:3, :3] = np.diag(size**2 / 12.0)
        p = np.column_stack([middles[inside], np.ones(inside.sum())])
        moments = p[:, :, None] * p[:, None, :] + own
        parts.append(density * np.prod(size) * (back @ moments @ back.T))
    return parts


@pytest.mark.parametrize("balanced", ["force", pytest.param("dynamic", marks=pytest.mark.slow)])
def test_the_bound_is_below_bounded_least_squares_and_the_answer_near_it(balanced):
    space, motions = question(balanced)
    found = balance.partial(
        space, ["crank", "rocker"], 1000.0, regions=BOXES, motions=motions, density=STEEL
    )
    assert found.verdict == "optimal"
    problem = build_problem(space, list(BOXES), ShakingOptions(BOXES, motions))
    R = problem.program.factor
    parts = cells_of([read_region(text) for text in BOXES.values()], STEEL, 600)
    blocks = [
        R[:, 10 * k : 10 * k + 10] @ triangles(moments).T for k, moments in enumerate(parts)
    ]
    best = lsq_linear(np.hstack(blocks), -R[:, -1], (0.0, 1.0), tol=1e-10)
    least = np.sqrt(2.0 * best.cost)
    assert found.bound <= least * (1.0 + 1e-6)
    assert least <= 1.05 * found.shaking.objective + 1e-6 * found.given.objective
    for weight in found.weights:
        assert 0.0 < weight.share <= 1.0 + 1e-9 and weight.density == STEEL


def test_the_least_force_of_a_budget_meets_its_bound_to_round_off():
    """Parts that planes cut off have exact integrals, of both the shaking and the bound."""
    space, motions = question("force")
    least = balance.partial(space, ["crank", "rocker"], 0.5, motions=motions, density=STEEL)
    assert least.mass == pytest.approx(0.5, rel=1e-12)
    assert abs(least.shaking.objective - least.bound) <= 1e-12 * least.given.objective


@pytest.mark.slow
def test_no_random_filling_shakes_less_than_the_bound():
    space, motions = question("force")
    found = balance.partial(
        space, ["crank", "rocker"], 0.5, regions=BOXES, motions=motions, density=STEEL
    )
    assert found.verdict == "optimal" and found.mass <= 0.5 * (1.0 + 1e-9)
    problem = build_problem(space, list(BOXES), ShakingOptions(BOXES, motions))
    parts = cells_of([read_region(text) for text in BOXES.values()], STEEL, 200)
    rng, least = np.random.default_rng(0), np.inf
    for _ in range(2000):
        s, mass = [], 0.0
        for moments in parts:
            side = rng.normal(size=4) * [1.0, 1.0, 0.2, 0.7]
            order = moments[:, :, 3] @ side
            shares = (order > np.quantile(order, rng.uniform(0.3, 1.0))) * 1.0
            total = np.tensordot(shares, moments, 1)
            s.append(triangles(total))
            mass += total[3, 3]
        scale = min(1.0, 0.5 / mass)
        least = min(least, problem.program.value(scale * np.concatenate(s)))
    assert found.bound <= least and found.shaking.objective <= least * (1.0 + 1e-6)


@pytest.mark.slow
def test_less_density_leaves_more_shaking():
    space, motions = question("force")
    left = [
        balance.partial(
            space, ["crank", "rocker"], 2.0, regions=BOXES, motions=motions, density=density
        ).shaking.objective
        for density in (1000.0, STEEL, 1e7, None)
    ]
    assert left[0] > 1.05 * left[1] > 1.05 * 1.05 * left[2]
    assert left[2] >= left[3] - 1e-6 * left[0]


@pytest.mark.slow
def test_caps_hold_with_a_density():
    space, motions = question("force")
    free = balance.partial(
        space, ["crank", "rocker"], 5.0, regions=BOXES, motions=motions, density=STEEL
    )
    most = 0.5 * (free.shaking.torque["u1"] + free.given.torque["u1"])
    capped = balance.partial(
        space,
        ["crank", "rocker"],
        5.0,
        regions=BOXES,
        motions=motions,
        density=STEEL,
        max_torque={"u1": most},
    )
    assert free.shaking.torque["u1"] > most
    assert capped.verdict == "optimal"
    assert capped.shaking.torque["u1"] <= most * (1.0 + 1e-6)
    assert capped.shaking.objective > free.shaking.objective
    none = balance.partial(
        space,
        ["crank"],
        5.0,
        regions={"crank": BOXES["crank"]},
        motions=motions,
        density=STEEL,
        max_torque={"u1": 0.1 * free.given.torque["u1"]},
    )
    assert none.verdict in ("infeasible", "undecided") and none.shaking is None


@pytest.mark.slow
def test_boxes_that_are_too_small_are_filled():
    """Two boxes of 120 cm³ on a five-bar: 0.942 kg of steel each, where points take 3 kg."""
    linkage = as_linkage("five_bar")
    space = balance.design_space(linkage, balance="force", max_order=0)
    motions = list(random_motions(linkage, 1, 60))
    boxes = {
        "left_lower": "box(0.06:0.12,-0.35:-0.25,-0.01:0.01)",
        "right_lower": "box(-0.22:-0.12,-0.26:-0.2,-0.01:0.01)",
    }
    steel, points = (
        balance.partial(space, list(boxes), 3.0, regions=boxes, motions=motions, **limits)
        for limits in ({"density": STEEL}, {"density": None})
    )
    problem = build_problem(space, list(boxes), ShakingOptions(boxes, motions))
    whole = []
    for text in boxes.values():
        region = read_region(text)
        # In unit coordinates: a cube of side 2, whose second moments are m / 3.
        whole.append(triangles(STEEL * region.volume * np.diag([1 / 3, 1 / 3, 1 / 3, 1.0])))
    filled = problem.program.value(np.concatenate(whole))
    assert abs(steel.mass - 2 * 0.942) <= 1e-5 and steel.verdict == "optimal"
    assert abs(steel.shaking.objective - filled) <= 1e-5 * filled
    assert points.mass > 2.9 and points.share < 0.6 * steel.share


def arms_at(u1, u2):
    """Rotations (samples, 2, 2) and origins of the four links of `five_bar`, from its circles.

    Its joints are at (0, 0), (-0.2, 0.6), (0.5, 1.1), (1.2, 0.5) and (0.9, 0.1) when u = 0.
    """
    places = np.array([[0, 0], [-0.2, 0.6], [0.5, 1.1], [1.2, 0.5], [0.9, 0.1]])

    def turned(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)

    left, right = turned(u1), turned(u2)
    a = np.broadcast_to(places[0], (len(u1), 2))
    b = a + left @ (places[1] - places[0])
    e = np.broadcast_to(places[4], (len(u2), 2))
    d = e + right @ (places[3] - places[4])
    r, s = (np.linalg.norm(places[2] - places[k]) for k in (1, 3))
    way = d - b
    size = np.linalg.norm(way, axis=1)
    along = (r * r - s * s + size**2) / (2.0 * size)
    off = np.sqrt(r * r - along**2)
    e1 = way / size[:, None]
    tool = b + along[:, None] * e1 + off[:, None] * np.column_stack([-e1[:, 1], e1[:, 0]])

    def angle(at, given):
        x, y = (at.T, np.broadcast_to(given, at.shape).T)
        return np.arctan2(x[1], x[0]) - np.arctan2(y[1], y[0])

    upper = [angle(tool - b, places[2] - places[1]), angle(tool - d, places[2] - places[3])]
    frames = {
        "left_lower": (left, a),
        "left_upper": (turned(upper[0]), b),
        "right_lower": (right, e),
        "right_upper": (turned(upper[1]), d),
    }
    np.testing.assert_allclose(tool[1], places[2], atol=1e-9)
    return frames


def force_of(frames, link, points, step):
    """Force per kilogram at points (n, 2) of a link: (times, 2, n), from three finite poses."""
    turn, at = frames[link]
    x = turn @ points.T + at[:, :, None]
    return -(x[2::3] - 2.0 * x[1::3] + x[0::3]) / step**2


@pytest.mark.slow
def test_a_five_bar_shakes_as_finite_poses_and_least_squares_over_cells_say():
    """Two boxes of 120 cm³: full of steel they leave half, 3 kg of points a fifth.

    Poses are intersections of circles, accelerations second differences of places, and the
    least is that of bounded least squares over cells, at the same times.
    """
    linkage = as_linkage("five_bar")
    space = balance.design_space(linkage, balance="force", max_order=0)
    (motion,) = random_motions(linkage, 1, 60)
    boxes = {
        "left_lower": "box(-0.16:0.16,-0.01:0.01,-0.009375:0.009375,0,0,-0.9625)",
        "right_lower": "box(-0.16:0.16,-0.01:0.01,-0.009375:0.009375,0,0,0.7576)",
    }
    centres = {"left_lower": [0.24, -0.345, 0.0], "right_lower": [-0.306, -0.29, 0.0]}
    regions = {}
    for name, text in boxes.items():
        region = read_region(text)
        place = region.place.copy()
        place[:3, 3] = centres[name]
        regions[name] = replace(region, place=place)
        assert region.volume == pytest.approx(120e-6)
    steel, points = (
        balance.partial(space, list(boxes), 3.0, regions=regions, motions=[motion], **limits)
        for limits in ({"density": STEEL}, {"density": None})
    )
    step = 1e-4
    times = (motion.time[:, None] + step * np.array([-1, 0, 1])).reshape(-1)
    u, _, _ = motion.path.at(times)
    frames = arms_at(u[:, 0], u[:, 1])
    given = sum(
        body.inertia[0] * force_of(frames, body.name, to_link(space, body), step)[:, :, 0]
        for body in linkage.bodies
    )
    # The mean over time is that of the trapezoidal rule.
    share = np.ones((len(given), 1))
    share[[0, -1]] = 0.5
    given = np.sqrt(share / share.sum()) * given
    size = np.linalg.norm(given)
    columns = []
    for name, region in regions.items():
        u = np.stack(
            np.meshgrid(*[(np.arange(n) + 0.5) * 2 / n - 1 for n in (60, 4)], [0.0]), -1
        )
        at = region.to_link(u.reshape(-1, 3))[:, :2]
        per_kilogram = (
            force_of(frames, name, at, step) * np.sqrt(share / share.sum())[..., None]
        )
        per_kilogram = per_kilogram.reshape(-1, len(at))
        columns.append(per_kilogram * STEEL * region.volume / len(at))
    A, b = np.hstack(columns), given.reshape(-1)
    least = lsq_linear(A, -b, (0.0, 1.0), tol=1e-12)
    left = np.sqrt(2.0 * least.cost) / size
    assert steel.verdict == points.verdict == "optimal"
    assert steel.share == pytest.approx(left, rel=1e-6)
    assert points.share < 0.7 * steel.share and points.mass > 1.2 * steel.mass


def to_link(space, body):
    """The centre of mass (1, 2) of a body in its link frame."""
    F = space.frames[space.bodies.index(body.name)]
    return (F[:3, :3].T @ (body.inertia[1:4] / body.inertia[0] - F[:3, 3]))[None, :2]


@pytest.mark.table(1)
@pytest.mark.parametrize("budget", [1e-3, 0.1])
def test_a_budget_is_kept_in_a_region_that_holds_tonnes(budget):
    """11 t fit into each ball: shares of that are far below the accuracy of a solver."""
    space = balance.design_space("slider_crank", max_order=0)
    links = ["crank", "coupler"]
    regions = dict.fromkeys(links, "ball(0,0,0,0.7)")
    ways = list(random_motions(space.linkage, 1, 30))
    found = balance.partial(space, links, budget, regions=regions, motions=ways)
    assert found.verdict == "optimal" and found.mass <= budget * (1.0 + 1e-9)
    # Integrals over rays have errors of this size.
    assert found.bound <= found.shaking.objective * (1.0 + 1e-7)
    assert found.shaking.objective < found.given.objective


@pytest.mark.slow
def test_a_front_in_steel_begins_with_nothing_added():
    space = balance.design_space("four_bar_general", balance="force", max_order=0)
    links, ways = ["crank", "rocker"], list(random_motions(space.linkage, 1, 60))
    front = balance.pareto(space, links, 3, motions=ways)
    masses = [design.mass for design in front.designs]
    assert masses[0] == 0.0 and masses[1] == pytest.approx(0.5 * masses[2], rel=1e-6)
    least = balance.counterweights(
        balance.design_space("four_bar_general", balance="force"), ["crank", "rocker"]
    )
    assert masses[2] == pytest.approx(least.added_mass, rel=1e-4)
    assert front.designs[2].share <= 1e-6


@pytest.mark.parametrize("minimise", ["rms", pytest.param("peak", marks=pytest.mark.slow)])
@pytest.mark.parametrize("density", [STEEL, None])
def test_of_matter_that_leaves_nothing_the_least_is_added(density, minimise):
    """As much as the least counterweights, which another program finds."""
    links = ["crank", "rocker"]
    space = balance.design_space("four_bar_general", balance="force")
    motions = question("force")[1]
    least = balance.counterweights(space, links, density=density)
    found = balance.partial(
        space,
        links,
        2.0 * least.added_mass,
        motions=motions,
        density=density,
        minimise=minimise,
    )
    assert found.verdict == "optimal" and found.share < 1e-9
    assert found.mass == pytest.approx(least.added_mass, rel=1e-7)


def test_matter_of_a_planar_linkage_is_its_own_mirror_image():
    """Integrals over its sections are those of the bound, of other rays, to round-off."""
    space, motions = question("dynamic")
    found = balance.partial(space, ["crank", "rocker"], 3.0, motions=motions, density=STEEL)
    assert abs(found.shaking.objective - found.bound) <= 1e-10 * found.given.objective
    for weight in found.weights:
        assert weight.com[2] == 0.0 and not weight.inertia[2, :2].any()


@pytest.mark.slow
def test_matter_is_no_mirror_image_where_the_linkage_is_none(tmp_path):
    """The coupler is 250 mm off the plane: least squares over cells put matter off it, too."""
    text = find("four_bar_general").read_text(encoding="utf-8")
    above = text.replace('<origin xyz="0.38 0.22 0"', '<origin xyz="0.38 0.22 0.25"')
    assert above != text
    path = tmp_path / "above.urdf"
    path.write_text(above, encoding="utf-8")
    space = balance.design_space(path, max_order=0)
    (motion,) = random_motions(space.linkage, 1, 60)
    regions = {"crank": "box(-0.2:0,-0.2:0,-0.1:0.1)"}
    found = balance.partial(
        space, ["crank"], 1000.0, regions=regions, motions=[motion], density=STEEL
    )
    problem = build_problem(space, ["crank"], ShakingOptions(regions, [motion]))
    (moments,) = cells_of([read_region(regions["crank"])], STEEL, 3000)
    mirror, R = np.diag([1.0, 1.0, -1.0, 1.0]), problem.program.factor
    values, places = [], []
    for parts in (moments, 0.5 * (moments + mirror @ moments @ mirror)):
        A, b = R[:, :-1] @ triangles(parts).T, -R[:, -1]
        cells = lsq_linear(A, b, (0.0, 1.0), tol=1e-10)
        values.append(np.sqrt(2.0 * cells.cost))
        # The box is 0.1 m high on each side of the plane.
        places.append(0.1 * cells.x @ parts[:, 2, 3] / (cells.x @ parts[:, 3, 3]))
    (weight,) = found.weights
    assert found.verdict == "optimal" and found.bound <= values[0] <= 0.995 * values[1]
    assert found.shaking.objective == pytest.approx(values[0], rel=6e-3)
    assert places[0] > 0.02 and weight.com[2] == pytest.approx(places[0], rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("density", [STEEL, None])
def test_twin_rods_share_matter_where_the_force_alone_counts(density):
    """They translate alike; the moment depends on their places, and one of them saves more."""
    space = balance.design_space("delta", balance="force", max_order=0)
    problem = build_problem(space, ["rod1a", "rod1b"], ShakingOptions(density=density))
    first, second = problem.solve(0.3).s.reshape(2, 10)
    assert first == pytest.approx(second, abs=1e-6) and first[-1] > 0.1
    space = balance.design_space("delta", max_order=0)
    problem = build_problem(space, ["rod1a", "rod1b"], ShakingOptions(density=density))
    best = problem.solve(0.3)
    first, second = best.s.reshape(2, 10)
    for shared in ((second, first), ((first + second) / 2,) * 2):
        value = problem.program.value(np.concatenate(shared))
        assert value > best.value + 100.0 * (best.value - best.bound)
