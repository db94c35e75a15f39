"""What joints let pass: the table of inertia transfers, for geometry drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

from balance import design_space
from balance.space.inertial_parameters.conversions import from_chain
from kinematics.closure.assembly.assemble import assemble
from tests.independent.opened import Graph, serials
from tests.support.covering import number_of_cases
from tests.support.drafts import axis_edge, linked
from tests.support.laws import outside, unit_vector

SEEDS = range(number_of_cases(20, 60))
# Dimension of the transfers across a joint whose axis is parallel to every axis of rotation
# below it, and across one where it is not. (J. J. de Jong, PhD thesis, University of Twente,
# Table 5.1; there a planar joint has the row of a prismatic one, but its rotation takes the
# pairs of rods that do not turn about the normal.)
TABLE = {
    "revolute": (5, 3),
    "helical": (4, 1),
    "prismatic": (7, 6),
    "universal": (1, 1),
    "spherical": (1, 1),
    "cylindrical": (4, 1),
    "two-prismatic": (6, 6),
    "planar": (3, 1),
}
SIMPLE = ("revolute", "helical", "prismatic")


def parts_of(kind, n, rng):
    """Kinds and axes of the joints of one degree that make up a joint with axis n."""
    others = [unit_vector(rng), unit_vector(rng)]
    across = np.linalg.svd(n[None])[2][1:]
    return {
        "universal": [("revolute", n), ("revolute", others[0])],
        "spherical": [("revolute", n), *(("revolute", o) for o in others)],
        "cylindrical": [("prismatic", n), ("revolute", n)][:: rng.choice([1, -1])],
        "two-prismatic": [("prismatic", n), ("prismatic", others[0])],
        "planar": [*(("prismatic", a) for a in across), ("revolute", n)],
    }.get(kind, [(kind, n)])


def edges_of(name, kind, n, sides, rng):
    """The joint as a chain through parts of its own."""
    pieces, point = parts_of(kind, n, rng), rng.standard_normal(3)
    inner = [1000 * (sides[1] + 1) + k for k in range(len(pieces) - 1)]
    stops = [sides[0], *inner, sides[1]]
    pitch = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 1.0) if kind == "helical" else 0.0
    for k, (one, axis) in enumerate(pieces):
        label = name if len(pieces) == 1 else f"{name}.{k}"
        yield axis_edge(one, axis, point, (stops[k], stops[k + 1]), label, pitch)


def aligned(n, below):
    """Whether n is parallel to the axes of rotation of all joints below."""
    turning = [e.screw[:3] for e in below if e.kind != "prismatic"]
    return all(np.linalg.norm(np.cross(n, t)) < 1e-12 for t in turning)


def below_parallel(rng, n):
    """Joints with axes along n, prismatic ones along any; sometimes none."""
    kinds = rng.choice(SIMPLE, rng.integers(0, 3))
    signs = rng.choice([-1.0, 1.0], len(kinds))
    axes = [
        unit_vector(rng) if k == "prismatic" else s * n
        for k, s in zip(kinds, signs, strict=True)
    ]
    return list(zip(kinds.tolist(), axes, strict=True))


def below_skew(rng, n):
    """Joints of which at least one turns about an axis that is not along n."""
    first = (str(rng.choice(["revolute", "helical", "spherical"])), unit_vector(rng))
    return [first, *below_parallel(rng, n)]


def chain_of(kinds, rng):
    """A serial linkage with a body after each joint, and the edges of each joint."""
    joints = [
        list(edges_of(f"s{k}", kind, n, (k, k + 1), rng)) for k, (kind, n) in enumerate(kinds)
    ]
    return assemble(linked(sum(joints, []), range(1, len(joints) + 1), rng)), joints


def blocks(space, transfer):
    """The transfer in coordinates of the chain: (bodies, parameters, dimension)."""
    chain = space.chain
    G = from_chain(chain.frame, space.planar, space.balance == "force")
    return np.linalg.solve(G, transfer.basis.reshape(len(space.bodies), len(G), -1))


@pytest.mark.table
@pytest.mark.parametrize("case", ["parallel", "skew"])
@pytest.mark.parametrize("kind", TABLE)
def test_the_table_of_transfers(kind, case):
    for seed in SEEDS:
        rng = np.random.default_rng([seed, sum(kind.encode()), len(case)])
        n = unit_vector(rng)
        below = below_parallel(rng, n) if case == "parallel" else below_skew(rng, n)
        kinds = [*below, (kind, n), *below_parallel(rng, n)[:1]]
        linkage, joints = chain_of(kinds, rng)
        space = design_space(linkage, spatial=True)
        place = len(below)
        assert aligned(n, sum(joints[:place], [])) == (case == "parallel")
        for k, ((name, axis), edges, transfer) in enumerate(
            zip(kinds, joints, space.transfers, strict=True)
        ):
            skew = not aligned(axis, sum(joints[:k], []))
            assert transfer.dimension == TABLE[name][skew], (seed, k, name)
            assert transfer.joints == tuple(edge.name for edge in edges)
            assert transfer.bodies == tuple(f"b{i}" for i in (k - 1, k) if i >= 0)
        if seed % 4 == 0:
            check_exchanges(space)


def check_exchanges(space):
    """Transfers take from one body what they give to the next, and are the whole space."""
    for k, transfer in enumerate(space.transfers):
        z = blocks(space, transfer)
        if k:
            assert np.abs(z[k - 1] + z[k]).max() <= 1e-12 * np.abs(z).max()
            z[k - 1] = 0.0
        z[k] = 0.0
        assert not z.any()
    found = np.hstack([blocks(space, t).reshape(len(space.basis), -1) for t in space.transfers])
    (expected,) = serials(space.chain)
    assert found.shape == expected.shape
    assert max(outside(found, expected), outside(expected, found)) < 1e-10
    assert space.parallel.shape[1] == 0


PLANAR_TABLE = [
    ("revolute", False, 1),
    ("revolute", True, 1),
    ("prismatic", False, 2),
    ("prismatic", True, 1),
]


@pytest.mark.parametrize(("kind", "turns", "dimension"), PLANAR_TABLE)
def test_the_table_of_planar_linkages(kind, turns, dimension):
    """A prismatic joint passes a displacement only if nothing below it turns."""
    for seed in SEEDS:
        rng = np.random.default_rng([seed, dimension, turns])
        normal = unit_vector(rng)

        def drawn(one, rng=rng, normal=normal):
            v = np.cross(normal, unit_vector(rng))
            return one, normal if one == "revolute" else v / np.linalg.norm(v)

        choices = ["revolute", "prismatic"] if turns else ["prismatic"]
        below = [drawn(str(one)) for one in rng.choice(choices, rng.integers(0, 3))]
        below += [drawn("revolute")] if turns else []
        linkage, _ = chain_of([*below, drawn(kind), drawn("revolute")], rng)
        space = design_space(linkage)
        assert space.planar
        assert space.transfers[len(below)].dimension == dimension, seed
        if seed % 4 == 0:
            check_exchanges(space)


def contained(space, k, z):
    """How far parameters z (10, d) of body k are from what its joint lets pass."""
    return outside(z, space.transfers[k].basis.reshape(len(space.bodies), 10, -1)[k])


def rod(b):
    """Pure-inertia rod: the tensor ``-[b]²`` without mass."""
    E = b @ b * np.eye(3) - np.outer(b, b)
    return np.r_[np.zeros(4), np.diag(E), E[0, 1], E[0, 2], E[1, 2]]


def test_a_skew_revolute_joint_passes_masses_on_its_axis_and_a_rod_along_it():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        n = unit_vector(rng)
        linkage, joints = chain_of([("revolute", unit_vector(rng)), ("revolute", n)], rng)
        space = design_space(linkage)
        point = joints[1][0].point
        masses = np.array([mass_at(point + x * n) for x in (-1.0, 0.0, 2.0)]).T
        assert contained(space, 1, masses) < 1e-10
        # Masses on a line, as far apart as these, span mass, displacement and rod.
        assert contained(space, 1, rod(n)[:, None]) < 1e-10
        assert contained(space, 1, rod(unit_vector(rng))[:, None]) > 1e-3
        assert contained(space, 1, mass_at(point + unit_vector(rng))[:, None]) > 1e-3


def mass_at(r):
    """Parameters of a unit point mass, written out."""
    return rod(r) + np.r_[1.0, r, np.zeros(6)]


def test_masses_pass_where_axes_meet():
    for kind in ("spherical", "universal"):
        rng = np.random.default_rng(7)
        linkage, joints = chain_of(
            [("revolute", unit_vector(rng)), (kind, unit_vector(rng))], rng
        )
        space = design_space(linkage)
        assert contained(space, 1, mass_at(joints[1][0].point)[:, None]) < 1e-10


def test_force_balance_only_exchanges_masses_and_first_moments():
    """Revolute: mass and displacement; helical: displacement or less; prismatic: along it."""
    for seed in range(50):
        rng = np.random.default_rng(seed)
        kinds = [(str(k), unit_vector(rng)) for k in rng.choice(SIMPLE, 4)]
        space = design_space(chain_of(kinds, rng)[0], balance="force")
        (expected,) = serials(space.chain, force=True)
        found = np.hstack([blocks(space, t).reshape(16, -1) for t in space.transfers])
        assert found.shape == expected.shape
        assert max(outside(found, expected), outside(expected, found)) < 1e-10


def test_the_reference_route_sees_a_wrong_transfer():
    """A point mass off the axis by 1e-6 of the length is not in the space."""
    rng = np.random.default_rng(1)
    kinds = [("revolute", unit_vector(rng)), ("revolute", unit_vector(rng))]
    space = design_space(chain_of(kinds, rng)[0])
    graph = Graph.of(space.chain)
    assert graph.loops == 0
    (expected,) = serials(space.chain)
    z = blocks(space, space.transfers[1]).reshape(20, -1)
    assert outside(z, expected) < 1e-12
    z[1] += 1e-6
    assert outside(z, expected) > 1e-9
