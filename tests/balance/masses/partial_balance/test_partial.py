"""The least shaking for a budget: laws of the optimum, and a general solver's answer."""

from __future__ import annotations

import re

import numpy as np
import pytest

import balance
import kinematics
from balance import design_space
from balance.app.answers.text.partial_balance import front_facts
from balance.masses.partial_balance.shaking_program import quadratic_factor
from balance.motion import shaking
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.trajectory import random_motions
from kinematics.errors import BodyError, PoseError, UsageError
from tests.support.covering import number_of_cases
from tests.support.laws import unit_vector
from tests.support.points import point_partial
from tests.support.shapes import antiparallelogram, general, kite, quadrilateral

WIDE = {"crank": "ball(0,0,0,1)", "coupler": "ball(0,0,0,1)"}
ADD = ["crank", "coupler"]


def motions(linkage, count=2, samples=40):
    return list(random_motions(linkage, count, samples))


# --- a second route ------------------------------------------------------------------------


def shape_of(rng, centre):
    """A region in the plane's axes, as text, and its description for the general solver."""
    size = rng.uniform(0.1, 0.5, 3)
    x, y, z = centre + rng.uniform(-0.2, 0.2, 3)
    if rng.random() < 0.5:
        return f"ball({x},{y},{z},{size[0]})", ("ball", np.array([x, y, z]), size[0])
    low, high = np.array([x, y, z]) - size, np.array([x, y, z]) + size
    text = ",".join(f"{a}:{b}" for a, b in zip(low, high, strict=True))
    return f"box({text})", ("box", low, high)


def matter_of(cp, shape):
    """Pseudo-inertia (4, 4) of matter in a region as an expression, and its constraints."""
    from scipy.spatial import Delaunay

    if shape[0] == "ball":
        P = cp.Variable((4, 4), symmetric=True)
        c, r = shape[1:]
        G = -np.eye(4)
        G[:3, 3] = G[3, :3] = c
        G[3, 3] = r**2 - c @ c
        return P, [P >> 0, cp.trace(G @ P) >= 0]
    corners = np.array(np.meshgrid(*zip(*shape[1:], strict=True))).reshape(3, -1).T
    total, limits = 0, []
    for four in Delaunay(corners).simplices:
        V = np.vstack([corners[four].T, np.ones(4)])
        Y = cp.Variable((4, 4), symmetric=True)
        total, limits = total + V @ Y @ V.T, [*limits, Y >> 0, Y >= 0]
    return total, limits


def parameters(P):
    """Ten parameters of a pseudo-inertia expression."""
    x, y, z = P[0, 0], P[1, 1], P[2, 2]
    return [
        P[3, 3],
        P[0, 3],
        P[1, 3],
        P[2, 3],
        y + z,
        x + z,
        x + y,
        -P[0, 1],
        -P[0, 2],
        -P[1, 2],
    ]


def rows_of(linkage, ways, z, length):
    """Weighted shaking along motions (rows,) by `shaking`, moments about the middle."""
    middle = linkage.spatial_chain.frame.origin
    found = []
    for way in ways:
        wrench = shaking(linkage, way.u, way.ud, way.udd, z)
        moment = wrench[:, :3] - np.cross(middle, wrench[:, 3:])
        step = np.diff(way.time)
        weight = 0.5 * (np.append(step, 0) + np.append(0, step)) / step.sum()
        own = np.hstack([moment / length, wrench[:, 3:]])
        found.append((np.sqrt(weight / len(ways))[:, None] * own).reshape(-1))
    return np.concatenate(found)


def compare(seed, move=False):
    """The optimum of a random linkage, regions and budget, and that of a general solver.

    With ``move``, shares of the given masses may be taken, if as much is placed there again.
    """
    cp = pytest.importorskip("cvxpy")
    rng = np.random.default_rng(seed)
    corners = (kite, antiparallelogram, general)[seed % 3](rng)
    linkage = quadrilateral(corners, int(rng.integers(4)), rng)
    space = design_space(linkage, max_order=0)
    ways, budget, length = (
        motions(linkage, 2, 15),
        rng.uniform(0.05, 2.0),
        rng.uniform(0.2, 2.0),
    )
    chosen = list(rng.choice(3, int(rng.integers(1, 4)), replace=False))
    add = [space.bodies[b] for b in chosen]
    shapes = [shape_of(rng, np.zeros(3)) for _ in add]
    regions = {name: text for name, (text, _) in zip(add, shapes, strict=True)}
    shares = {name: rng.uniform(0.1, 1.0) for name in add if move}
    budget = 0.0 if move and seed % 2 else budget
    found = point_partial(
        space, add, budget, regions=regions, motions=ways, weight_moment=length, move=shares
    )
    given = np.array([body.inertia for body in linkage.bodies])
    fixed = rows_of(linkage, ways, given, length)
    total, mass, limits = fixed, 0, []
    for b, (_, shape) in zip(chosen, shapes, strict=True):
        P, own = matter_of(cp, shape)
        H = space.frames[b]
        columns = np.column_stack(
            [
                rows_of(linkage, ways, given + np.eye(3)[b][:, None] * unit, length) - fixed
                for unit in np.eye(10)
            ]
        )
        total = total + columns @ cp.hstack(parameters(H @ P @ H.T))
        mass, limits = mass + P[3, 3], [*limits, *own]
        if space.bodies[b] in shares:
            theta = cp.Variable(nonneg=True)
            total = total - columns @ given[b] * theta
            mass = mass - given[b, 0] * theta
            limits += [theta <= shares[space.bodies[b]], P[3, 3] >= given[b, 0] * theta]
    problem = cp.Problem(cp.Minimize(cp.norm(total)), [*limits, mass <= budget])
    least = problem.solve(solver=cp.CLARABEL)
    return found, least, np.linalg.norm(fixed)


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", range(number_of_cases(4, 10)))
def test_a_general_solver_finds_the_same_optimum(seed):
    """On random linkages of each shape; on ten with ``ALL_CASES=1``."""
    found, least, given = compare(seed)
    assert found.given.objective == pytest.approx(given, rel=1e-10)
    assert found.shaking.objective == pytest.approx(least, abs=1e-6 * given)
    assert found.verdict == "optimal" and found.bound <= found.shaking.objective * (1.0 + 1e-12)


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", range(number_of_cases(2, 8)))
def test_a_general_solver_finds_the_same_optimum_of_moved_matter(seed):
    found, least, given = compare(seed, move=True)
    assert found.shaking.objective == pytest.approx(least, abs=1e-6 * given)
    assert found.verdict == "optimal" and found.bound <= found.shaking.objective * (1.0 + 1e-12)
    assert any(found.moved.values()) and found.mass <= found.budget * (1 + 1e-9)


# --- laws ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_without_a_budget_nothing_changes():
    found = point_partial("slider_crank", ADD, 0.0)
    assert (found.mass, found.weights, found.share) == (0.0, (), 1.0)
    given = np.array([body.inertia for body in found.space.linkage.bodies])
    assert np.array_equal(found.z, given) and found.shaking == found.given
    ways = motions(found.space.linkage, 10, 200)
    runs = balance.verify(found.space.linkage, motions=ways).runs
    force = np.sqrt(np.mean([run.rms("force") ** 2 for run in runs]))
    moment = np.sqrt(np.mean([run.rms("moment") ** 2 for run in runs]))
    assert (found.given.force, found.given.moment) == pytest.approx((force, moment), rel=1e-12)
    peaks = max(run.peak("force") for run in runs), max(run.peak("moment") for run in runs)
    assert (found.given.peak_force, found.given.peak_moment) == pytest.approx(peaks, rel=1e-12)
    bearing = max(run.bearing.max() for run in runs)
    assert max(found.given.bearing.values()) == pytest.approx(bearing, rel=1e-12)


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "shape",
    [
        "ball(0,0,0,0.7)",
        "box(-1:1,-0.2:0.5,0:0.1)",
        "ellipsoid(0,0,0,1,0.4,0.2)",
        "cylinder(0,0,0,0,0,1,0.7,0.1)",
    ],
)
def test_more_budget_leaves_less(shape):
    space = design_space("slider_crank", max_order=0)
    ways, last = motions(space.linkage), np.inf
    for budget in (0.0, 1e-3, 0.1, 1.0, 10.0):
        found = point_partial(
            space, ADD, budget, regions=dict.fromkeys(ADD, shape), motions=ways
        )
        # Lumps of a cylinder are fitted to seven digits.
        assert found.verdict == "optimal" and found.mass <= budget * (1 + 1e-6)
        assert found.shaking.objective < last
        gap = found.shaking.objective - found.bound
        assert -1e-9 <= gap / found.given.objective <= 1e-6
        last = found.shaking.objective
        for weight in found.weights:
            assert all(weight.region.contains(lump.position) for lump in weight.lumps)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "add", "kind"),
    [
        ("slider_crank", ["crank", "coupler", "slider"], "dynamic"),
        ("four_bar_antiparallelogram", ["crank", "coupler", "rocker"], "dynamic"),
        ("four_bar_general", ["crank", "rocker"], "force"),
    ],
)
def test_nothing_is_left_where_an_exact_design_exists(model, add, kind):
    space = design_space(model, balance=kind)
    regions = dict.fromkeys(add, "ball(0,0,0,1.5)")
    found = point_partial(space, add, 1000.0, regions=regions)
    assert found.shaking.objective <= 1e-9 * found.given.objective
    assert found.mass < 100.0
    again = balance.verify(space.linkage, found.z, balance=kind, seed=5)
    assert again.balanced


@pytest.mark.parametrize("reach", [0.0064, 0.3])
def test_nothing_is_added_to_what_is_balanced(reach):
    """Its shaking is round-off, of which no share is worth a budget; a cap still counts."""
    linkage = kinematics.load("four_bar_kite_balanced")
    ways = [rest_to_rest(linkage, [[0.0], [reach]], 0.08, 20)]
    front = balance.pareto(linkage, ["crank"], 3, motions=ways)
    for one in front.designs:
        assert (one.verdict, one.mass, one.budget >= 0.0) == ("optimal", 0.0, True)
        assert "balanced" in one.words and one.shaking == one.given
    least = front.designs[0].given.torque["u1"]
    capped = point_partial(linkage, ["crank"], 1.0, motions=ways, max_torque={"u1": least / 2})
    assert capped.verdict == "infeasible"


@pytest.mark.slow
def test_a_region_that_is_full_is_told():
    """Twice the budget does no better, a larger region does."""
    given = ("four_bar_general", ["crank"])
    small, large = ({"crank": f"ball(0,0,0,{radius})"} for radius in (0.02, 0.06))
    answers = [
        balance.partial(*given, budget, regions=regions, speed="300rpm")
        for budget, regions in ((5.0, small), (10.0, small), (5.0, large), (0.01, small))
    ]
    told = ["room" in dict(front_facts(answer.front)) for answer in answers]
    assert told[:2] == [True, True] and not told[3]
    first, second, wider, _ = (answer.shaking.objective for answer in answers)
    assert second == pytest.approx(first, rel=1e-4) and wider < 0.99 * first


def test_a_budget_that_saves_next_to_nothing_is_told():
    """Both sides of 0.1 % of the shaking in the file."""
    space = design_space("four_bar_general", balance="dynamic")
    links = [body.name for body in space.linkage.bodies][:2]
    told = []
    for budget in (1e-5, 1e-4, 1e-3, 0.5):
        answer = point_partial(space, links, budget, motions=motions(space.linkage))
        left = answer.shaking.objective / answer.given.objective
        told.append("hardly worth its mass" in answer.words)
        assert told[-1] == (left > 1 - 1e-3 and bool(answer.weights))
    assert any(told) and not told[-1]


@pytest.mark.slow
def test_the_lightest_of_the_best_designs_is_found():
    """With less mass than it has, something is left."""
    space, add = design_space("slider_crank", max_order=0), ["crank", "coupler", "slider"]
    options = {"regions": dict.fromkeys(add, "ball(0,0,0,1.5)")}
    found = point_partial(space, add, 1000.0, **options)
    assert point_partial(space, add, 0.999 * found.mass, **options).share > 1e-5


@pytest.mark.slow
def test_no_other_matter_in_the_regions_does_better():
    """Random point masses of the whole budget, along the line from the optimum to them."""
    space, rng = design_space("slider_crank", max_order=0), np.random.default_rng(0)
    ways = motions(space.linkage, 2, 15)
    best = point_partial(space, ADD, 0.8, regions=WIDE, motions=ways, weight_moment=0.5)
    given = np.array([body.inertia for body in space.linkage.bodies])
    for _ in range(30):
        b = int(rng.integers(2))
        at = space.frames[b, :3, :3] @ unit_vector(rng) + space.frames[b, :3, 3]
        other = given.copy()
        other[b] += point_mass(0.8, at)
        for share in (0.01, 0.3):
            z = (1 - share) * best.z + share * other
            value = np.linalg.norm(rows_of(space.linkage, ways, z, 0.5))
            assert value >= best.shaking.objective * (1 - 1e-9)


def point_mass(m, r):
    """Ten parameters of a point mass."""
    x, y, z = r
    second = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
    return m * np.array([1.0, x, y, z, *second])


def test_the_factor_keeps_what_squares_would_lose():
    """A residual of 1e-12 of the columns; the Gram matrix has only 1e-8."""
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((400, 5))
    rest = 1e-12 * rng.standard_normal(400)
    rows = np.column_stack([columns, columns @ np.ones(5) + rest])
    x = np.append(-np.ones(5), 1.0)
    R = quadratic_factor([rows[:150], rows[150:]])
    assert np.linalg.norm(R @ x) == pytest.approx(np.linalg.norm(rows @ x), rel=0.05)
    assert R.shape == (6, 6)


# --- caps ----------------------------------------------------------------------------------


def test_caps_are_kept_at_every_sample():
    space = design_space("slider_crank", max_order=0)
    ways = motions(space.linkage, 3, 60)
    options = {"regions": WIDE, "motions": ways}
    free = point_partial(space, ADD, 1.0, **options)
    limit = 0.5 * (free.given.torque["u1"] + free.shaking.torque["u1"])
    capped = point_partial(space, ADD, 1.0, max_torque={"u1": limit}, **options)
    assert capped.verdict == "optimal"
    assert capped.shaking.torque["u1"] == pytest.approx(limit, rel=1e-7)
    assert free.shaking.objective < capped.shaking.objective < free.given.objective
    runs = balance.verify(space.linkage, capped.z, motions=ways).runs
    bearing = max(run.bearing[:, 1].max() for run in runs)
    name = space.linkage.joints[1].name
    tight = point_partial(space, ADD, 1.0, max_bearing={name: 0.99 * bearing}, **options)
    assert tight.shaking.bearing[name] <= 0.99 * bearing * (1 + 1e-7)


@pytest.mark.slow
def test_caps_that_cannot_be_kept_say_how_large_ones_can():
    """The named factor is enough, and one smaller by a hundredth is not."""
    space = design_space("slider_crank", max_order=0)
    options = {"regions": WIDE, "motions": motions(space.linkage, 1, 40)}
    caps = {"u1": 1.0}
    found = point_partial(space, ADD, 1.0, max_torque=caps, **options)
    assert found.verdict == "infeasible"
    factor = float(re.search(r"caps ([\d.]+) times as large can be kept", found.words)[1])
    for part, verdict in ((1.001, "optimal"), (0.99, "infeasible")):
        limit = {"u1": part * factor * caps["u1"]}
        again = point_partial(space, ADD, 1.0, max_torque=limit, **options)
        assert again.verdict == verdict


@pytest.mark.slow
@pytest.mark.parametrize("minimise", ["peak", "torque", "bearing"])
def test_the_largest_load_is_least(minimise):
    """The figure is that of the masses along the motion; random matter has no smaller one."""
    space = design_space("slider_crank", max_order=0)
    options = {"regions": WIDE, "motions": motions(space.linkage, 1, 40)}
    found = point_partial(space, ADD, 1.0, minimise=minimise, **options)
    figures = found.shaking
    sizes = {"torque": figures.torque, "bearing": figures.bearing}
    if minimise != "peak":
        assert figures.objective == pytest.approx(max(sizes[minimise].values()), rel=1e-12)
    assert found.verdict == "optimal" and found.bound <= figures.objective * (1.0 + 1e-9)
    rng = np.random.default_rng(4)
    for link in ADD:
        x = rng.uniform(-0.1, 0.1, 3)
        region = {link: f"ball({x[0]},{x[1]},{x[2]},0.001)"}
        if point_partial(space, [link], 1.0, motions=options["motions"], regions=region).mass:
            narrow = point_partial(
                space,
                [link],
                1.0,
                minimise=minimise,
                motions=options["motions"],
                regions=region,
            )
            assert found.bound <= narrow.shaking.objective * (1.0 + 1e-9)


@pytest.mark.slow
def test_caps_that_nothing_keeps_are_proved_impossible():
    """Added mass in the crank alone cannot take force from the pin of the coupler."""
    found = point_partial("slider_crank", ["crank"], 1.0, max_bearing={"q2": 1.0})
    assert (found.verdict, found.shaking, found.z, found.mass) == ("infeasible", None, None, 0)
    assert "q2" in found.words
    nothing = point_partial("slider_crank", ["crank"], 0.0, max_torque={"u1": 1.0})
    assert nothing.verdict == "infeasible" and "u1" in nothing.words


# --- requests that are wrong ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"budget": -1.0}, UsageError, "budget of -1"),
        ({"budget": np.nan}, UsageError, "budget of nan"),
        ({"add": ["nothing"]}, BodyError, "nothing"),
        ({"add": ["base"]}, BodyError, "ground"),
        ({"add": []}, UsageError, "at least one"),
        ({"weight_moment": 0.0}, UsageError, "weigh"),
        ({"max_torque": {"q2": 3.0}}, UsageError, "no input 'q2'"),
        ({"max_bearing": {"x": 3.0}}, UsageError, "no joint 'x'"),
        ({"max_bearing": {"q2": 0.0}}, UsageError, "cap of 0"),
        ({"motions": []}, PoseError, "nothing moves"),
        ({"regions": {"crank": "ball(0,0,0,-1)"}}, UsageError, "crank"),
    ],
)
def test_requests_that_are_wrong(changes, error, text):
    asked = {"add": ["crank"], "budget": 1.0} | changes
    with pytest.raises(error, match=text) as caught:
        point_partial("slider_crank", asked.pop("add"), asked.pop("budget"), **asked)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_the_sentence_has_the_loads_that_were_minimised():
    """Peaks where peaks are least, and the torque first where it is."""
    options = {"speed": "300rpm", "density": None}
    peak = balance.partial("slider_crank", ["crank"], 0.5, minimise="peak", **options)
    assert " N peak (" in peak.sentence and " N m peak" in peak.sentence
    assert "N rms" not in peak.sentence and "N m rms" not in peak.sentence
    for load in (peak.shaking.peak_force, peak.shaking.peak_moment):
        assert f"→ {float(f'{load:.3g}'):g} N" in peak.sentence
    torque = balance.partial("slider_crank", ["crank"], 0.5, minimise="torque", **options)
    assert torque.sentence.startswith("Largest torque ")


def test_the_motion_is_told():
    """The turn of a crank by its speed, others by their length and how far inputs move."""
    linkage = kinematics.load("slider_crank")
    turn, _ = revolve_crank(linkage, "-3000rpm", steps=40)
    others = motions(linkage, 2, 15)
    parts = [others[0].u[:, 0], others[1].u[:, 0]]
    most = max(float(np.abs(part).max()) for part in parts)
    why = "rad, so that loops close (--csv FILE goes further)"
    for chosen, told in (
        (turn, ("motion", "one revolution of u1 at -3000 rpm")),
        (others[:1], ("motion", f"of 1 s, amplitude u1 {np.abs(parts[0]).max():.3g} {why}")),
        (others, ("motions", f"2 of 1 s each, amplitude u1 {most:.3g} {why}")),
    ):
        found = balance.partial(linkage, ["crank"], 0.1, motions=chosen, balance="force")
        assert told in front_facts(found.front)
