"""The serial and the parallel space, against every way of opening the loops."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.inertial_parameters.conversions import from_chain
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import MobilityError
from kinematics.model.linkage import Mimic
from tests.independent import reference
from tests.independent.opened import Graph, openings, serials, union
from tests.support.covering import number_of_cases, spread
from tests.support.drafts import axis_edge, linked, planar_edge, spatial_edge
from tests.support.figures import FIGURES
from tests.support.laws import known, outside

# Ways of opening the loops that are tried: all, unless there are more than so many.
MANY = 20


def in_chain(space, basis):
    """Columns of a space (parameters, d) in the coordinates of its chain."""
    G = from_chain(space.chain.frame, space.planar, space.balance == "force")
    blocks = np.linalg.solve(G, basis.reshape(len(space.bodies), len(G), -1))
    return blocks.reshape(basis.shape)


def ways_of(graph):
    """All ways of opening, or an even choice of them where there are very many."""
    ways = list(openings(graph))
    return ways[:: 1 + len(ways) // MANY]


def gap(one, other):
    """How far two spaces of one dimension are apart."""
    assert one.shape == other.shape
    return max(outside(one, other), outside(other, one)) if one.shape[1] else 0.0


def check(space, ways=None):
    """Serial space as by the definition; parallel space the rest; both orthonormal."""
    chain, force = space.chain, space.balance == "force"
    ways = ways or ways_of(Graph.of(chain))
    assert ways
    ser, par, all_ = (in_chain(space, b) for b in (space.serial, space.parallel, space.basis))
    expected = union(*serials(chain, force, ways))
    assert gap(ser, expected) < 1e-10
    both = np.hstack([ser, par])
    assert np.abs(both.T @ both - np.eye(space.nullity)).max(initial=0.0) < 1e-12
    assert gap(both, all_) < 1e-10
    transfers = [in_chain(space, t.basis) for t in space.transfers]
    assert gap(union(*transfers), ser) < 1e-10


@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_partition_has_the_sizes_of_the_table(figure):
    found = known(figure)
    assert (found.serial.shape[1], found.parallel.shape[1]) == (figure.serial, figure.parallel)
    assert found.serial.shape[0] == found.parallel.shape[0] == figure.parameters


@pytest.mark.table
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 0), ids=str)
def test_the_serial_space_is_the_sum_over_all_ways_of_opening(figure):
    """Delta and Stewart platform, with thousands of ways, are opened in some of them.

    None of these can add to the sum, as every column of the product is in it.
    """
    check(known(figure))


WAYS = [
    ("four_bar_general", (), 3, {4}),
    ("three_rrr", (), 25, {9}),
    ("three_rsr", (), 25, {27}),
    ("three_rsr", ("u2=u3",), 25, {29, 31, 33}),
    ("four_rrr", (), 105, {12}),
    ("sarrus", (), 5, {26, 28, 29}),
]


@pytest.mark.table(3)
@pytest.mark.parametrize(("model", "motion", "count", "sizes"), WAYS)
def test_most_linkages_have_one_serial_space_for_all_ways_of_opening(
    model, motion, count, sizes
):
    """Not Sarrus, nor the 3-RSR on a symmetry plane: V below a joint depends on the way."""
    found = design_space(kinematics.load(model), motion or None)
    chain = found.chain
    assert len(set(openings(Graph.of(chain)))) == count
    every = serials(chain)
    assert len(every) == count and {one.shape[1] for one in every} == sizes
    ser = in_chain(found, found.serial)
    assert ser.shape[1] == max(sizes)
    assert all(outside(one, ser) < 1e-10 for one in every)


def test_the_ways_of_splitting_are_counted_right():
    """A four-bar linkage has one for each body; a pair of half-edges counts once."""
    graph = Graph.of(kinematics.load("four_bar_general").chain)
    assert graph.loops == 1 and len(graph.bodies) == 4
    split = [{graph.sides[j][s] for j, s in way} for way in openings(graph)]
    assert sorted(map(sorted, split)) == [[0], [1], [2]]


def test_to_drop_a_joint_instead_of_splitting_a_body_gives_too_little():
    """Four-bar linkage: three pins pass a mass; with a copy beyond the fourth, it does too."""
    chain = kinematics.load("four_bar_general").chain
    graph = Graph.of(chain)
    cut = next(iter(openings(graph)))[0][0]
    rest = np.delete(np.arange(4), cut)
    z = np.array([masses_at_pin(chain, graph, j) for j in rest]).T
    (full, *_) = serials(chain)
    assert full.shape[1] == 4 and z.shape[1] == 3 and np.linalg.matrix_rank(z) == 3
    assert outside(z, full) < 1e-12 < 1e-3 < outside(full, z)


def masses_at_pin(chain, graph, j):
    """A unit mass at a joint, taken from the one body and given to the other."""
    w, vx, vy = chain.screws[j]
    x, y = -vy / w, vx / w
    z = np.zeros((chain.links.size, 4))
    for part, sign in zip(graph.sides[j], (1.0, -1.0), strict=True):
        for body in graph.bodies[part]:
            z[body] = sign * np.array([1.0, x, y, x * x + y * y])
    return z.ravel()


def test_hprs_splits_joint_by_joint():
    found = known(next(f for f in FIGURES if f.model == "hprs"))
    assert [t.dimension for t in found.transfers] == [4, 6, 5, 1]


def test_three_rsr_splits_leg_by_leg():
    """Revolute on the base 5, spherical 1, revolute on the platform 3."""
    free, restricted = (known(f) for f in FIGURES if f.model == "three_rsr")
    assert sorted(t.dimension for t in free.transfers) == [1] * 3 + [3] * 3 + [5] * 3
    assert (restricted.serial.shape[1], restricted.parallel.shape[1]) == (33, 2)


POSES = [
    ("four_bar_general", (), False),
    ("four_bar_general", (), True),
    ("four_bar_antiparallelogram", (), False),
    ("slider_crank", (), False),
    ("hprs", (), True),
    ("three_rsr", (), True),
    ("three_rsr", ("u2=u3",), True),
    ("sarrus", (), True),
]


@pytest.mark.table(2)
@pytest.mark.parametrize(("model", "motion", "spatial"), POSES)
def test_the_serial_space_is_balanced_at_fifty_finite_poses(model, motion, spatial):
    """Poses and momentum by a route of their own; relative to the parts of the bodies."""
    linkage = kinematics.load(model)
    found = design_space(linkage, motion or None, spatial=spatial)
    mechanism = reference.load(model)
    basis = reference.motion_basis(mechanism, motion)
    order = [mechanism.bodies.index(name) for name in found.bodies]
    rng = np.random.default_rng(4)
    start = np.zeros(len(mechanism.joints))
    for _ in range(50):
        goal = basis @ rng.uniform(-0.3, 0.3, basis.shape[1])
        q = reference.follow(mechanism, start, goal)
        rates = reference.velocities(mechanism, q, basis)
        X = reference.regressor(mechanism, q, rates, "dynamic", spatial)
        X = X.reshape(len(X), len(order), -1)[:, order].reshape(X.shape)
        left = np.abs(X @ found.serial).max()
        assert left <= 1e-12 * (np.abs(X) @ np.abs(found.serial)).max()


MOTIONS = [
    ("three_rsr", ("u1=u3",), "dynamic", False),
    ("three_rsr", ("u1=u2", "u2=u3"), "dynamic", False),
    ("three_rsr", (), "force", False),
    ("three_rsr", ("u2=u3",), "force", False),
    ("four_rrr", (), "dynamic", False),
    ("five_bar", (), "dynamic", True),
    ("hprs", ("helical=0",), "dynamic", False),
    ("hprs", ("revolute=wrist_x",), "dynamic", False),
    ("hprs", (), "force", False),
    ("slider_crank", (), "force", False),
    ("slider_crank", (), "dynamic", True),
    ("four_bar_parallelogram", (), "dynamic", True),
    ("sarrus", (), "force", False),
    ("bennett", (), "force", False),
    ("rusr", (), "force", False),
]


@pytest.mark.table
@pytest.mark.parametrize(("model", "motion", "balance", "spatial"), MOTIONS)
def test_restricted_motions_and_other_questions(model, motion, balance, spatial):
    check(design_space(kinematics.load(model), motion or None, balance, spatial=spatial))


R, Z = "revolute", np.array([0.0, 0.0, 1.0])


def pins(points, sides):
    """Revolute joints of a planar linkage."""
    return [
        axis_edge(R, Z, np.r_[p, 0.0], s, f"p{k}")
        for k, (p, s) in enumerate(zip(points, sides, strict=True))
    ]


FOUR_BAR = [(0.0, 0.0), (0.1, 1.0), (2.1, 1.4), (1.8, 0.0)]


def test_bodies_of_one_rigid_part_exchange_everything():
    """Two bodies on the coupler of a four-bar linkage: 4 pins and 4 parameters, or 10."""
    draft = linked(
        pins(FOUR_BAR, [(0, 1), (1, 2), (2, 3), (3, 0)]), [1, 2, 2, 3], np.random.default_rng(0)
    )
    found = design_space(assemble(draft))
    assert found.serial.shape[1] == 8 and found.parallel.shape[1] == 0
    check(found)
    found = design_space(assemble(draft), spatial=True)
    assert found.serial.shape[1] == 27
    check(found)


def test_a_joint_that_never_moves_makes_one_part_of_two():
    """Links of a loop through a prismatic joint that is idle count as welded."""
    sides = [(0, 1), (1, 2), (2, 4), (4, 3), (3, 0)]
    joints = pins([*FOUR_BAR[:3], FOUR_BAR[2], FOUR_BAR[3]], sides)
    slide = axis_edge("prismatic", Z, np.zeros(3), (2, 4), "slide")
    joints[2] = slide
    joints[3] = axis_edge(R, Z, np.r_[FOUR_BAR[2], 0.0], (4, 3), "p2")
    draft = linked(joints, [1, 2, 4, 3], np.random.default_rng(0))
    found = design_space(assemble(draft))
    assert found.idle == ("slide",)
    assert found.serial.shape[1] == 8
    check(found)


def test_links_without_parameters_pass_on_what_they_can():
    """A four-bar linkage whose coupler is massless keeps the masses at its base pins.

    What passes through the coupler must pass both its pins, and no mass lies on both.
    """
    sides = [(0, 1), (1, 2), (2, 3), (3, 0)]
    draft = linked(pins(FOUR_BAR, sides), [1, 3], np.random.default_rng(0))
    found = design_space(assemble(draft))
    assert found.serial.shape[1] == 2
    check(found)


def test_mimic_joints_are_free_in_the_opened_linkage():
    """The serial space does not know of the gear; what the gear adds is parallel."""
    rng = np.random.default_rng(3)
    joints = [axis_edge(R, Z, rng.standard_normal(3), (k, k + 1), f"p{k}") for k in range(3)]
    bodies = [1, 2, 3]
    geared = linked(joints, bodies, rng, mimics=(Mimic(2, 0, -1.0), Mimic(1, 0, 1.0)))
    found, free = (
        design_space(assemble(draft)) for draft in (geared, linked(joints, bodies, rng))
    )
    assert found.nullity > free.nullity == 3
    assert gap(in_chain(found, found.serial), in_chain(free, free.basis)) < 1e-10
    check(found)


def test_a_long_leg_counts_up_to_its_end():
    """A Sarrus linkage with legs of 7 and 3 joints: every joint passes 5 from its own leg.

    The last bodies of the long leg are fewer joints away from the ground by the short leg,
    whose axes are not parallel to theirs.
    """
    rng = np.random.default_rng(5)
    x, y = np.eye(3)[:2]
    stops = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0]
    joints = [
        axis_edge(
            R, x if k < 7 else y, rng.standard_normal(3), (stops[k], stops[k + 1]), f"p{k}"
        )
        for k in range(10)
    ]
    found = design_space(assemble(linked(joints, range(1, 10), rng)))
    assert [t.dimension for t in found.transfers] == [5] * 10
    check(found)


def ring(parts):
    """Sides of the joints of a loop through some parts."""
    return list(zip(parts, [*parts[1:], parts[0]], strict=True))


def drawn(seed, spatial):
    """A random linkage with one loop or two, a branch, and links without parameters."""
    rng = np.random.default_rng([seed, spatial])
    least = 7 if spatial else 4
    double = bool(rng.integers(0, 2)) and not (spatial and seed % 3)
    if double:
        long = 2 * least - 1 + int(rng.integers(0, 2))
        cut = sorted(rng.choice(np.arange(2, long - 1), 2, replace=False).tolist())
        outer = list(range(cut[1]))
        inner = [outer[cut[0] // 2], *range(100, 100 + long - cut[1]), outer[-1]]
        sides = ring(outer) + list(zip(inner[:-1], inner[1:], strict=True))
    else:
        sides = ring(list(range(least + int(rng.integers(0, 2)))))
    last = max(sides)[0]
    sides += [(last, 500), (500, 501)] if rng.integers(0, 2) else []
    parts = sorted({p for side in sides for p in side} - {0})
    massive = [p for p in parts if rng.uniform() < 0.7] or parts[:1]
    massive += massive[:1] if rng.uniform() < 0.3 else []
    rng.shuffle(sides)
    make = spatial_edge if spatial else planar_edge
    joints = [make(rng, tuple(map(int, s)), f"j{k}") for k, s in enumerate(sides)]
    return linked(joints, massive, rng), double


@pytest.mark.table(1)
@pytest.mark.parametrize("spatial", [False, True], ids=["planar", "spatial"])
def test_random_linkages(spatial):
    """Loops without a body to split, and linkages that are rigid by chance, do not count.

    Of 16 linkages; of 40 with ``ALL_CASES=1``.
    """
    done = {False: 0, True: 0}
    for seed in range(number_of_cases(16, 40)):
        draft, double = drawn(seed, spatial)
        try:
            linkage = assemble(draft)
            found = design_space(linkage)
        except MobilityError:
            continue
        ways = list(islice(openings(Graph.of(found.chain)), 400))
        if ways:
            check(found, ways[:: 1 + len(ways) // 16])
            done[double] += 1
    assert min(done.values()) >= number_of_cases(3, 8), done
