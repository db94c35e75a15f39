"""The design space has the size of the table, balances, and does not depend on the frame."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.inertial_parameters.conversions import from_chain, pseudo_inertia
from balance.space.spaces import compute_space
from kinematics import Motion, ScrewJoint, from_screws
from kinematics.errors import MotionError
from kinematics.model.spatial.inertia import displace_parameters
from kinematics.numerics.compiled.background import WORTH
from kinematics.numerics.linalg.pivoted_qr import RANK_RELATIVE
from tests.independent import reference
from tests.support.covering import spread
from tests.support.figures import BALANCED, DESIGNS, FIGURES
from tests.support.laws import (
    MODELS,
    PLANAR,
    altered,
    coordinates,
    displacement,
    known,
    outside,
    placed,
    relative,
    renamed,
    resized,
    space,
    sums,
)


def ranks(found):
    return [order.rank for order in found.orders]


def padded(figure, count):
    """The ranks of the table, the last one repeated up to a number of orders."""
    return [figure.ranks[min(k, figure.kmax)] for k in range(count)]


def check(found, figure):
    assert ranks(found) == padded(figure, len(found.orders))
    assert found.kmax == figure.kmax and found.settled
    assert found.rank == figure.ranks[-1] and found.nullity == figure.nullity
    assert found.basis.shape == (figure.parameters, figure.nullity)


def fresh_regressor(name, motion, balance, spatial, seed, reach=0.25):
    """Regressor at a random pose, by the independent route, in SI units."""
    mechanism = reference.load(name)
    basis = reference.motion_basis(mechanism, motion)
    inputs = basis @ np.random.default_rng(seed).uniform(-reach, reach, basis.shape[1])
    q = reference.follow(mechanism, np.zeros(len(mechanism.joints)), inputs)
    rates = reference.velocities(mechanism, q, basis)
    X = reference.regressor(mechanism, q, rates, balance, spatial)
    # The route has the bodies in the order of the file, the product in that of the links.
    order = [mechanism.bodies.index(body.name) for body in kinematics.load(name).bodies]
    return X.reshape(len(X), len(order), -1)[:, order].reshape(X.shape)


def unbalanced(X, basis):
    """Largest momentum, relative to what the bodies add to it one by one."""
    return (np.abs(X @ basis) / (np.abs(X) @ np.abs(basis)).max()).max(initial=0.0)


def carried(H, bodies):
    """Matrix that takes the parameters of all bodies along with an affine map H."""
    one = displace_parameters(np.eye(10), H).T
    return np.kron(np.eye(bodies), one)


def same_space(one, other):
    assert one.shape == other.shape
    assert max(outside(one, other), outside(other, one)) < 1e-9


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_table_comes_out(figure):
    found = known(figure)
    check(found, figure)
    assert found.kept == found.singular_values[-1] > 1e-9
    assert found.dropped < RANK_RELATIVE and found.singular_values[0] == 1.0
    assert (np.diff(found.singular_values) <= 0.0).all()
    assert [order.order for order in found.orders] == list(range(len(found.orders)))
    assert all(order.rank + order.nullity == figure.parameters for order in found.orders)
    per_body = figure.parameters // len(found.bodies)
    assert len(found.labels) == per_body
    assert set(found.bodies) == set(reference.load(figure.model).bodies)


@pytest.mark.table(1)
@pytest.mark.parametrize("figure", spread(FIGURES, 2, 0), ids=str)
def test_every_column_is_balanced_at_fresh_poses(figure):
    """1e-11: at a quarter of a radian, poses close to 1e-13 and vectors cancel."""
    found = known(figure)
    if found.planar:
        assert np.array_equal(found.axes, np.eye(3))
    for seed in range(90, 94):
        X = fresh_regressor(figure.model, figure.motion, figure.balance, figure.spatial, seed)
        assert unbalanced(X, found.basis) < 1e-11
        blind = found.basis + 1e-6 * np.abs(found.basis).max() * np.ones(found.basis.shape)
        assert unbalanced(X, blind) > 1e-8


MOTIONS = [
    ("three_rsr", ("u1=u3",), "dynamic", True),
    ("three_rsr", ("u1=u2", "u2=u3"), "dynamic", True),
    ("three_rsr", (), "force", True),
    ("three_rsr", ("u1=u2",), "force", True),
    ("four_rrr", (), "dynamic", False),
    ("four_rrr", (), "dynamic", True),
    ("four_rrr", ("a1=a2",), "dynamic", False),
    ("five_bar", ("u1=u2",), "dynamic", False),
    ("five_bar", (), "dynamic", True),
    ("hprs", ("revolute=wrist_x",), "dynamic", True),
    ("hprs", ("helical=revolute", "wrist_y=wrist_z"), "dynamic", True),
    ("hprs", (), "force", True),
    ("bennett", (), "force", True),
    ("slider_crank", (), "dynamic", True),
    ("slider_crank", (), "force", False),
    ("four_bar_kite", (), "dynamic", True),
    ("four_bar_parallelogram", (), "dynamic", True),
    ("four_bar_antiparallelogram", (), "force", True),
]


@pytest.mark.table(3)
@pytest.mark.parametrize(("name", "motion", "balance", "spatial"), MOTIONS)
def test_other_questions_have_the_rank_of_finite_poses(name, motion, balance, spatial):
    decision = reference.rank_over_poses(reference.load(name), motion, balance, spatial)
    found = design_space(kinematics.load(name), motion, balance, spatial=spatial)
    assert found.settled and found.rank == decision.rank
    X = fresh_regressor(name, motion, balance, spatial, 95)
    assert unbalanced(X, found.basis) < 1e-11


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 0), ids=str)
def test_the_frame_of_the_file_does_not_matter(figure, tmp_path):
    """The whole linkage is put elsewhere, in a random direction, on a new root link."""
    H = displacement(np.random.default_rng(96), reach=3.0)
    path = altered(figure.model, tmp_path, placed(H))
    found = space(figure, path)
    check(found, figure)
    assert found.axes @ found.axes.T == pytest.approx(np.eye(3), abs=1e-14)
    one = known(replace(figure, spatial=True))
    if one.balance == "dynamic":
        other = space(replace(figure, spatial=True), path)
        same_space(carried(H, len(one.bodies)) @ one.basis, other.basis)


@pytest.mark.table(3)
@pytest.mark.parametrize("factor", [1e-3, 1e3])
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 1), ids=str)
def test_the_unit_of_length_does_not_matter(figure, factor, tmp_path):
    found = space(figure, altered(figure.model, tmp_path, resized(factor)))
    check(found, figure)
    degrees = {"m": 0, "mcx": 1, "mcy": 1, "mcz": 1}
    units = np.tile([factor ** degrees.get(x, 2) for x in found.labels], len(found.bodies))
    same_space(found.basis / units[:, None], known(figure).basis)


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_names_of_links_do_not_matter(name, tmp_path):
    one = design_space(kinematics.load(name))
    other = design_space(kinematics.load(altered(name, tmp_path, renamed)))
    assert other.bodies == tuple(f"x_{body}_9" for body in one.bodies)
    assert other.inputs == one.inputs and other.orders == one.orders
    assert np.array_equal(other.basis, one.basis)


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("four_bar_general", ["q4"]),
        ("four_bar_kite", ["q3"]),
        ("slider_crank", ["q2"]),
        ("five_bar", ["q2", "q4"]),
        ("bennett", ["q3"]),
        ("four_rrr", ["a1", "b1", "c1"]),
        ("three_rsr", ["platform1", "u2", "platform3"]),
    ],
)
def test_the_choice_of_inputs_does_not_matter(name, inputs):
    one, other = (design_space(kinematics.load(name, inputs=i)) for i in (None, inputs))
    assert other.inputs == tuple(inputs)
    assert (other.rank, other.kmax) == (one.rank, one.kmax)
    same_space(one.basis, other.basis)


@pytest.mark.table(6)
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_columns_are_orthonormal_in_units_of_the_mechanism(figure):
    found = known(figure)
    linkage = found.linkage
    frame = (linkage.spatial_chain if figure.spatial else linkage.chain).frame
    G = from_chain(frame, found.planar, found.balance == "force")
    columns = np.linalg.solve(np.kron(np.eye(len(found.bodies)), G), found.basis)
    assert columns.T @ columns == pytest.approx(np.eye(found.nullity), abs=1e-12)


@pytest.mark.table(20)
@pytest.mark.parametrize("name", PLANAR)
def test_planar_spaces_lie_in_the_spatial_ones(name):
    """Bodies in the plane, balanced there, are balanced in space: ``mcz = Exz = Eyz = 0``."""
    linkage = kinematics.load(name)
    flat, solid = design_space(linkage), design_space(linkage, spatial=True)
    bodies = len(linkage.bodies)
    lifted = np.zeros((bodies, 10, flat.nullity))
    lifted[:, [0, 1, 2, 6]] = flat.basis.reshape(bodies, 4, -1)
    assert outside(lifted.reshape(-1, flat.nullity), solid.basis) < 1e-11
    for found in (flat, solid):
        size = found.basis.shape[0] // bodies
        kept = 3 if found.planar else 4
        force = design_space(linkage, balance="force", spatial=not found.planar)
        part = found.basis.reshape(bodies, size, -1)[:, :kept].reshape(bodies * kept, -1)
        part = part[:, np.linalg.norm(part, axis=0) > 1e-6]
        assert outside(part, force.basis) < 1e-9


@pytest.mark.parametrize("motion", [("u2=u3",), ("u1=u2",), ("u1=u3",)])
def test_the_three_rsr_is_balanced_as_given_on_its_planes(motion, tmp_path):
    H = displacement(np.random.default_rng(97), reach=3.0)
    for path in ("three_rsr", altered("three_rsr", tmp_path, placed(H))):
        linkage = kinematics.load(path)
        balanced, residual = design_space(linkage, motion).as_given
        assert balanced and residual < 1e-12
        assert design_space(linkage, motion, "force").as_given.balanced
        free = design_space(linkage).as_given
        assert not free.balanced and 1e-4 < free.residual <= 1.0
        assert design_space(linkage, [f"{motion[0]}"] * 2).as_given.balanced


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_members_of_the_space_are_balanced_as_given(name):
    linkage = kinematics.load(name)
    assert design_space(linkage).as_given.balanced == (name in {*DESIGNS, *BALANCED})
    found = design_space(linkage, spatial=True)
    rng = np.random.default_rng(98)
    member = (found.basis @ coordinates(found)).reshape(-1, 10)
    for z, balanced in ((member, True), (member + 1e-6 * rng.standard_normal(10), False)):
        bodies = tuple(replace(b, inertia=x) for b, x in zip(linkage.bodies, z, strict=True))
        given = design_space(replace(linkage, bodies=bodies), spatial=True).as_given
        assert given.balanced == balanced
        assert given.residual < 1e-13 if balanced else given.residual > 1e-9


@pytest.mark.table
@pytest.mark.parametrize(
    ("name", "motion"),
    [(name, ()) for name in MODELS]
    + [("three_rsr", ("u2=u3",)), ("three_rsr", ("u1=u2", "u1=u3")), ("five_bar", ("u1=u2",))],
)
def test_idle_joints_are_those_without_rates(name, motion):
    """Rates at two random poses of the independent route; only joints of the tree have them."""
    mechanism = reference.load(name)
    basis = reference.motion_basis(mechanism, motion)
    moved = np.zeros(len(mechanism.joints))
    for y in np.random.default_rng(99).uniform(-0.2, 0.2, (2, basis.shape[1])):
        q = reference.follow(mechanism, np.zeros(len(moved)), basis @ y)
        moved += np.abs(reference.velocities(mechanism, q, basis)).sum(axis=1)
    still = {name for name, x in zip(mechanism.joints, moved, strict=True) if x < 1e-12}
    found = design_space(kinematics.load(name), motion)
    assert set(found.idle) & set(mechanism.joints) == still


def test_results_cannot_be_changed():
    found = design_space(kinematics.load("five_bar"), ["u1=-u2"])
    with pytest.raises(FrozenInstanceError):
        found.rank = 3
    arrays = (found.basis, found.axes, found.singular_values, found.motion.basis)
    for array in arrays:
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    linkage = found.linkage
    arrays = [value for value in vars(linkage.chain).values() if isinstance(value, np.ndarray)]
    arrays += [body.inertia for body in linkage.bodies]
    arrays += [joint.screw for joint in linkage.joints]
    assert not any(array.flags.writeable for array in arrays)


def test_singular_values_wait_until_they_are_asked_for(monkeypatch):
    linkage, svd, asked = kinematics.load("three_rsr"), np.linalg.svd, []
    monkeypatch.setattr("numpy.linalg.svd", lambda *a, **k: asked.append(1) or svd(*a, **k))
    found = design_space(linkage, max_order=2)
    assert found.rank == 43 and asked == []
    assert found.dropped < found.kept == found.singular_values[-1] and len(asked) == 1


def test_results_do_not_depend_on_what_was_asked_before():
    linkage = kinematics.load("three_rsr")
    first = design_space(linkage, ["u2=u3"])
    design_space(linkage, max_order=5)
    design_space(linkage, balance="force")
    again = design_space(kinematics.load("three_rsr"), ["u2=u3"])
    assert first.orders == again.orders and np.array_equal(first.basis, again.basis)


def test_motions_may_be_objects():
    linkage = kinematics.load("three_rsr")
    motion = Motion.parse(["u2=u3"], linkage.inputs)
    one, other = design_space(linkage, motion), design_space(linkage, ["u2=u3"])
    assert one.orders == other.orders and np.array_equal(one.basis, other.basis)
    free = design_space(linkage, Motion.free(linkage.inputs))
    same_space(free.basis, design_space(linkage).basis)
    scaled = design_space(linkage, ["7*u2=7*u3"])
    same_space(scaled.basis, one.basis)


def test_what_cannot_be_asked_is_refused():
    linkage = kinematics.load("five_bar")
    with pytest.raises(MotionError, match="'q2' is not an input"):
        design_space(linkage, ["u1=q2"])
    with pytest.raises(MotionError, match="leaves no input to move"):
        design_space(linkage, ["u1=0", "u2=0"])
    with pytest.raises(ValueError, match="'static'"):
        design_space(linkage, balance="static")


def test_bodies_that_balance_exist_where_the_table_says_so():
    """A counterweight on each side balances a parallelogram: an example by hand.

    The forces of a rocker, a coupler at rest in angle, and a second rocker are those of
    the masses reduced to the pivots; equal and opposite ones on the far side balance them.
    """
    linkage = kinematics.load("four_bar_parallelogram")
    pivots = {joint.name: joint.point for joint in linkage.joints}
    first, second = pivots["q2"] - pivots["u1"], pivots["q3"] - pivots["q4"]
    coupler = sums([1.0, 1.0], np.array([pivots["q2"], pivots["q3"]]))
    rockers = [
        sums([2.0], np.array([pivots[name] - 0.5 * arm]))
        for name, arm in (("u1", first), ("q4", second))
    ]
    z = {"crank": rockers[0], "coupler": coupler, "rocker": rockers[1]}
    assert all(np.linalg.eigvalsh(pseudo_inertia(x))[0] > -1e-12 for x in z.values())
    bodies = tuple(replace(body, inertia=z[body.name]) for body in linkage.bodies)
    balanced = replace(linkage, bodies=bodies)
    assert design_space(balanced, balance="force").as_given.balanced
    assert not design_space(balanced).as_given.balanced
    assert relative(first, second) < 1e-12


@pytest.mark.parametrize(("links", "long"), [(3, False), (25, True)])
def test_long_runs_of_kernels_are_foreseen(links, long, monkeypatch):
    """One call eliminates all parameters: a humanoid's must not run uncompiled to its end."""
    foreseen = []

    def stop(*_):
        raise InterruptedError

    monkeypatch.setattr(compute_space.kernel_clock, "foresee", foreseen.append)
    monkeypatch.setattr(compute_space, "first_orders", stop)
    joints = [
        ScrewJoint(f"j{k}", f"l{k}", f"l{k + 1}", (k % 2, 1 - k % 2, 0), (k, 0, 0.1 * k * k))
        for k in range(links)
    ]
    with pytest.raises(InterruptedError):
        design_space(from_screws(joints))
    assert (foreseen[0] > WORTH) == long
