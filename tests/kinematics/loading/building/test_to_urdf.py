"""Linkages written as URDF and read again, by the reader of files and by Pinocchio."""

import doctest
import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import kinematics
from balance import certify, design_space
from balance.momentum import momentum_regressor
from kinematics import ScrewJoint, from_pinocchio, from_screws
from kinematics.errors import LinkageError
from kinematics.loading import model_gallery as models
from kinematics.loading.building import dh_rows, screw_joints
from kinematics.loading.building import from_pinocchio as pinocchio_module
from kinematics.model import linkage as linkage_module
from kinematics.model.document.write_numbers import roll_pitch_yaw
from tests.support.covering import spread
from tests.support.laws import MODELS

# Links and joints of gallery files that Pinocchio reads: joints of one degree of freedom.
TREES = ("four_bar_general", "three_rrr", "sarrus", "slider_crank", "bennett", "hprs")


@pytest.fixture
def again(tmp_path):
    """Write a linkage to a file and read it."""

    def read(linkage, **options):
        path = tmp_path / "again.urdf"
        path.write_text(linkage.to_urdf(), encoding="utf-8")
        return kinematics.load(path, **options)

    return read


def same(found, linkage, screws=1e-14):
    """Screws, bodies, loops, relations and inputs are those of the other linkage."""
    assert (found.name, found.mobility, found.inputs, found.planar) == (
        linkage.name,
        linkage.mobility,
        linkage.inputs,
        linkage.planar,
    )
    assert [j.name for j in found.joints] == [j.name for j in linkage.joints]
    assert [(j.kind, j.parent, j.in_loop, j.numbered) for j in found.joints] == [
        (j.kind, j.parent, j.in_loop, j.numbered) for j in linkage.joints
    ]
    size = max(1.0, *(np.abs(joint.screw).max() for joint in linkage.joints))
    for ours, theirs in zip(found.joints, linkage.joints, strict=True):
        assert np.abs(ours.screw - theirs.screw).max() <= screws * size
    assert [(b.name, b.link) for b in found.bodies] == [
        (b.name, b.link) for b in linkage.bodies
    ]
    for ours, theirs in zip(found.bodies, linkage.bodies, strict=True):
        close = np.abs(ours.inertia - theirs.inertia).max()
        assert close <= 1e-13 * np.abs(theirs.inertia).max()
        assert np.abs(ours.frame - theirs.frame).max() <= 1e-13 * size
    assert [(x.name, x.end, x.successor) for x in found.loops] == [
        (x.name, x.end, x.successor) for x in linkage.loops
    ]
    assert [tuple(vars(m).values()) for m in found.mimics] == [
        tuple(vars(m).values()) for m in linkage.mimics
    ]
    assert set(found.places) >= set(linkage.places)
    for link, place in linkage.places.items():
        assert np.abs(found.places[link].pose - place.pose).max() <= 1e-13 * size


@pytest.mark.table(2)
@pytest.mark.parametrize("name", spread(MODELS, 3, 0))
def test_the_gallery_comes_back(name, again):
    linkage = kinematics.load(name)
    found = again(linkage)
    same(found, linkage)
    ours, theirs = certify(design_space(found)), certify(design_space(linkage))
    assert [o.rank for o in ours.orders] == [o.rank for o in theirs.orders]
    assert (ours.nullity, ours.serial.shape) == (theirs.nullity, theirs.serial.shape)
    assert ours.certainty.level == theirs.certainty.level


@pytest.mark.table(4)
@pytest.mark.parametrize("name", spread(MODELS, 3, 1))
def test_another_pose_is_written(name, again):
    """Momenta at a finite distance from it agree; screws of spherical joints may turn."""
    file = kinematics.load(name)
    u = file.inputs[0]
    linkage = kinematics.load(name, at={u: 0.1})
    found = again(linkage)
    numbered = {joint.whole for joint in linkage.joints if joint.numbered}
    if not numbered:
        same(found, linkage, 1e-13)
    X, Y = (momentum_regressor(each, {u: 0.05}) for each in (found, linkage))
    z = np.concatenate([body.inertia for body in linkage.bodies])
    assert X.shape == Y.shape and z.size
    assert np.abs(X - Y).max() <= 1e-10 * np.abs(Y).max()


@pytest.mark.table(3)
@pytest.mark.parametrize("name", spread(sorted(models.robots()), 4, 0))
def test_robots_come_back(name, again):
    linkage = None
    for fixed in (False, True):
        try:
            linkage = kinematics.load(name, fix_base=fixed, angles="as_written")
            break
        except LinkageError:
            continue
    if linkage is None:
        pytest.skip("not a linkage")
    same(again(linkage, angles="as_written"), linkage, 1e-13)


def mass_matrix(model, linkage):
    """Pinocchio's at a random pose, the rows and columns of joints in our order."""
    rng = np.random.default_rng(2)
    at = {name: joint.idx_v for name, joint in zip(model.names, model.joints, strict=True)}
    v, columns = np.zeros(model.nv), []
    for joint in linkage.joints:
        if not joint.in_loop:
            columns.append(at[joint.name])
            v[columns[-1]] = rng.uniform(-1.0, 1.0)
    q = pin.integrate(model, pin.neutral(model), v)
    M = pin.crba(model, model.createData(), q)
    M = np.triu(M) + np.triu(M, 1).T
    return M[np.ix_(columns, columns)]


def check_mass_matrix(path, linkage):
    ours = mass_matrix(pin.buildModelFromXML(linkage.to_urdf()), linkage)
    theirs = mass_matrix(pin.buildModelFromUrdf(str(path)), linkage)
    assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(theirs).max()


@pytest.mark.parametrize("name", TREES)
def test_pinocchio_reads_the_tree(name):
    linkage = kinematics.load(name)
    if any(joint.numbered and not joint.in_loop for joint in linkage.joints):
        pytest.skip("Pinocchio reads joints of one degree of freedom only")
    check_mass_matrix(kinematics.gallery()[name], linkage)


@pytest.mark.parametrize("name", ["ur5", "panda", "pr2", "talos_full_v2", "kinova"])
def test_pinocchio_reads_robots(name):
    path = models.robots().get(name)
    if path is None:
        pytest.skip("needs example-robot-data")
    check_mass_matrix(path, kinematics.load(path, angles="as_written"))
    check_mass_matrix(path, from_pinocchio(pin.buildModelFromUrdf(str(path))))


KINDS = ("revolute", "prismatic", "universal", "cylindrical", "spherical", "planar")


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_joint_and_of_loop(kind, again):
    rng = np.random.default_rng(KINDS.index(kind))
    body = (1.0, (0.1, 0.2, 0.3), np.eye(3))
    joints, across = [], np.array([0.0, 0.8, -0.6])
    for k in range(7):
        point, axis = rng.standard_normal((2, 3))
        joints.append(ScrewJoint(f"j{k}", f"l{k - 1}", f"l{k}", axis, point))
    axis = np.array([2.0, 0.6, 0.8])
    second = across if kind == "universal" else None
    joints[3] = ScrewJoint("j3", "l2", "l3", axis, (0.3, 0.2, -0.1), kind, axis2=second)
    joints[5] = joints[5]._replace(kind="helical", pitch=-0.02)
    loop = ScrewJoint("c", "l6", "l-1", axis, (0.1, 0.7, 0.2), kind, axis2=second)
    bodies = {joint.child: body for joint in joints}
    linkage = from_screws(joints, [loop], bodies, name='a & <b> "c"')
    found = again(linkage)
    if len(found.places) == len(linkage.places):
        same(found, linkage, 1e-13)
    assert (found.name, found.inputs) == (linkage.name, linkage.inputs)
    u = dict.fromkeys(linkage.inputs, 0.002)
    X, Y = (momentum_regressor(each, u) for each in (found, linkage))
    assert np.abs(X - Y).max() <= 1e-10 * np.abs(Y).max()


def test_inputs_that_are_part_of_a_joint_split_it(again):
    """An RSSR linkage whose coupler is turned about the first axis of its ball."""
    body = (1.0, (0.1, 0.2, 0.3), np.diag([1.0, 2.0, 3.0]))
    joints = [
        ScrewJoint("u1", "base", "crank"),
        ScrewJoint("s", "crank", "coupler", (1, 0, 0), (0.3, 0.1, 0.2), "spherical"),
        ScrewJoint("r", "base", "rocker", (0.2, 1, 0.1), (1, 0, 0)),
    ]
    loop = ScrewJoint("c", "coupler", "rocker", (0, 0, 1), (0.9, 0.2, 0.6), "spherical")
    bodies = {joint.child: body for joint in joints}
    for inputs in (["u1", "s.0"], ["u1", "c.0"]):
        linkage = from_screws(joints, [loop], bodies, inputs)
        found = again(linkage)
        assert found.inputs == linkage.inputs
        assert [body.name for body in found.bodies] == [body.name for body in linkage.bodies]
        u = {"u1": 0.2, inputs[1]: -0.1}
        X, Y = (momentum_regressor(each, u) for each in (found, linkage))
        assert np.abs(X - Y).max() <= 1e-10 * np.abs(Y).max()


def test_coordinates_of_a_tool_are_written(again):
    linkage = kinematics.load("five_bar")
    tool = kinematics.tool(linkage, linkage.bodies[-1].name, "x,rz")
    found = again(tool)
    assert found.inputs == tool.inputs and found.mobility == tool.mobility
    u = dict.fromkeys(tool.inputs, 0.02)
    X, Y = (momentum_regressor(each, u) for each in (found, tool))
    assert np.abs(X - Y).max() <= 1e-10 * np.abs(Y).max()


def test_bodies_without_mass_come_back(again):
    """By themselves if no body has mass, else if they are asked for."""
    linkage = from_screws([ScrewJoint("j", "base", "arm", point=(0.5, 0, 0))])
    assert [notice.code for notice in again(linkage).notices] == ["no_masses"]
    same(again(linkage), linkage)
    same(again(linkage, bodies="all"), linkage)


def test_text_is_the_same_when_it_is_written_again(again):
    for name in ("four_bar_general", "three_rrr", "five_bar"):
        linkage = kinematics.load(name)
        first, second = (
            re.sub("<inertia .*/>", "", each.to_urdf()) for each in (linkage, again(linkage))
        )
        assert first == second


@pytest.mark.parametrize("lean", [0.0, 1e-17, 1e-12, 1e-8, 1e-4, 0.3])
def test_angles_give_back_the_rotation_at_any_pitch(lean):
    rng = np.random.default_rng(8)
    for sign in (1.0, -1.0):
        roll, yaw = rng.uniform(-3.0, 3.0, 2)
        R = _turn(2, yaw) @ _turn(1, sign * (np.pi / 2 - lean)) @ _turn(0, roll)
        r, p, y = roll_pitch_yaw(R)
        assert np.abs(_turn(2, y) @ _turn(1, p) @ _turn(0, r) - R).max() <= 1e-15 * 3


def _turn(axis, angle):
    """Rotation about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = np.cos(angle)
    R[i, j], R[j, i] = -np.sin(angle), np.sin(angle)
    return R


def test_a_linkage_in_memory_works_like_one_from_a_file(tmp_path):
    """Its text is its document: masses are written into it, and exact ranks come from it."""
    from balance.masses.designs.write_urdf import replace_inertials

    linkage = from_screws([ScrewJoint("j", "base", "arm", point=(0.5, 0, 0))])
    data = replace_inertials(linkage, {"arm": '<inertial>\n  <mass value="1"/>\n</inertial>'})
    assert b'<mass value="1"/>' in data
    assert not Path(linkage.source).exists()


@pytest.mark.parametrize("module", [dh_rows, pinocchio_module, screw_joints, linkage_module])
def test_examples_run(module):
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0
