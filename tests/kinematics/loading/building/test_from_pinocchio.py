"""Linkages built from models of Pinocchio, beside its algorithms and the reader of files."""

import numpy as np
import pinocchio as pin
import pytest

import kinematics
from balance import design_space
from balance.momentum import momentum_regressor
from kinematics import from_pinocchio
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import FileError, LinkageError
from kinematics.loading import model_gallery as models

# Robots with mimic joints, sliding joints, joints without bounds, and floating bases.
ROBOTS = {
    "ur5": {},
    "panda": {},
    "talos_left_arm": {},
    "kinova": {},
    "baxter": {},
    "pr2": {},
    "tiago_no_hand": {},
    "double_pendulum_continuous": {},
    "solo12": {},
    "icub_reduced": {},
}
SIMPLE = {
    "rx": pin.JointModelRX,
    "rz": pin.JointModelRZ,
    "px": pin.JointModelPX,
    "hz": lambda: pin.JointModelHZ(0.3),
    "rubx": pin.JointModelRUBX,
    "r": lambda: pin.JointModelRevoluteUnaligned(np.array([0.0, 0.6, 0.8])),
    "p": lambda: pin.JointModelPrismaticUnaligned(np.array([0.6, 0.0, -0.8])),
    "h": lambda: pin.JointModelHelicalUnaligned(np.array([0.0, 0.6, 0.8]), -0.2),
    "t": pin.JointModelTranslation,
    "u": lambda: pin.JointModelUniversal(np.eye(3)[0], np.eye(3)[2]),
    "leaning": lambda: pin.JointModelUniversal(np.eye(3)[0], np.array([0.6, 0.8, 0.0])),
}


def path_of(name):
    path = models.robots().get(name)
    if path is None:
        pytest.skip("needs example-robot-data")
    return path


def placed(rng):
    return pin.SE3(pin.exp3(rng.standard_normal(3)), rng.standard_normal(3))


def model_of(*joints, seed=0):
    """A serial model of joints at random places, with random inertias."""
    rng, model = np.random.default_rng(seed), pin.Model()
    for k, joint in enumerate(joints):
        at = model.addJoint(k, joint, placed(rng), f"j{k}")
        model.appendBodyToJoint(at, pin.Inertia.Random(), placed(rng))
    return model


def moving(model):
    """Names and joints that have coordinates of their own; the first is the universe."""
    pairs = list(zip(model.names, model.joints, strict=True))[1:]
    return [(name, joint) for name, joint in pairs if joint.nv]


def configuration(model, linkage, q):
    """Pinocchio's configuration for positions q of our joints, by their names."""
    at = dict(zip([joint.name for joint in linkage.joints], q, strict=True))
    found = pin.neutral(model)
    for name, joint in moving(model):
        own = [
            at[key] for key in (name, *(f"{name}.{k}" for k in range(joint.nv))) if key in at
        ]
        if joint.nq == 2 and joint.nv == 1:
            found[joint.idx_q : joint.idx_q + 2] = np.cos(own[0]), np.sin(own[0])
        else:
            found[joint.idx_q : joint.idx_q + joint.nq] = own
    return found


def momentum_of_pinocchio(model, q, v):
    """Its momentum as ``[ξ; p]`` about the inertial origin, from its centroidal one."""
    data = model.createData()
    h = pin.computeCentroidalMomentum(model, data, q, v)
    return np.concatenate([h.angular + np.cross(data.com[0], h.linear), h.linear])


def check_momentum(model, linkage, seed=0):
    """At random poses and speeds."""
    rng = np.random.default_rng(seed)
    z = np.concatenate([body.inertia for body in linkage.bodies])
    for _ in range(3):
        u, speed = rng.uniform(-1.0, 1.0, (2, linkage.mobility))
        q = np.zeros(len(linkage.joints))
        q[linkage.positions_of(linkage.inputs)] = u
        for mimic in linkage.mimics:
            q[mimic.joint] = mimic.ratio * q[mimic.source]
        X = momentum_regressor(
            linkage, dict(zip(linkage.inputs, u.tolist(), strict=True)), spatial=True
        )
        v = np.zeros(model.nv)
        known = dict(zip(linkage.inputs, speed, strict=True))
        for name, joint in moving(model):
            for k in range(joint.nv):
                key = name if joint.nv == 1 else f"{name}.{k}"
                v[joint.idx_v + k] = known[key if key in known else f"{name}.{k}"]
        expected = momentum_of_pinocchio(model, configuration(model, linkage, q), v)
        found = np.einsum("w,wij,j->i", speed, X, z)
        assert np.abs(found - expected).max() <= 1e-11 * max(1.0, np.abs(expected).max())


@pytest.mark.table(4)
@pytest.mark.parametrize("name", ROBOTS)
def test_robots_are_those_of_their_files(name):
    path = path_of(name)
    file = kinematics.load(path, angles="as_written")
    model = pin.buildModelFromUrdf(str(path), mimic=True)
    built = from_pinocchio(model)
    ours = {joint.name: joint for joint in built.joints}
    assert set(ours) == {joint.name for joint in file.joints}
    for joint in file.joints:
        assert ours[joint.name].kind == joint.kind
        assert np.abs(ours[joint.name].screw - joint.screw).max() <= 1e-12
    bodies = {body.name: body for body in built.bodies}
    assert set(bodies) == {body.name for body in file.bodies}
    for body in file.bodies:
        error = np.abs(bodies[body.name].inertia - body.inertia).max()
        assert error <= 1e-12 * np.abs(body.inertia).max()
    assert len(built.mimics) == len(file.mimics)
    for link, place in file.places.items():
        assert np.abs(built.places[link].pose - place.pose).max() <= 1e-12
    check_momentum(model, built)


@pytest.mark.parametrize("name", SIMPLE)
def test_momentum_is_that_of_pinocchio(name):
    model = model_of(pin.JointModelRY(), SIMPLE[name](), pin.JointModelPY())
    check_momentum(model, from_pinocchio(model), seed=3)


def test_composite_joints_are_chains():
    composite = pin.JointModelComposite(pin.JointModelRX(), pin.SE3.Random())
    composite.addJoint(pin.JointModelPY(), pin.SE3.Random())
    composite.addJoint(pin.JointModelHZ(0.1), pin.SE3.Random())
    model = model_of(composite, pin.JointModelRZ())
    linkage = from_pinocchio(model)
    assert [joint.name for joint in linkage.joints] == ["j0.0", "j0.1", "j0.2", "j1"]
    assert [body.name for body in linkage.bodies] == ["j0", "j1"]
    check_momentum(model, linkage)


@pytest.mark.parametrize(
    "joint",
    [
        pin.JointModelSpherical,
        pin.JointModelSphericalZYX,
        pin.JointModelPlanar,
    ],
)
def test_joints_of_three_freedoms_span_the_same_motions(joint):
    model = model_of(pin.JointModelRY(), joint(), pin.JointModelRX())
    linkage = from_pinocchio(model)
    data = model.createData()
    J = pin.computeJointJacobians(model, data, pin.neutral(model))
    J = np.vstack([J[3:], J[:3]]).T
    ours = np.array([each.screw for each in linkage.joints])
    assert [each.whole for each in linkage.joints] == ["j0", "j1", "j1", "j1", "j2"]
    assert np.abs(ours[[0, 4]] - J[[0, 4]]).max() <= 1e-12
    span = np.linalg.pinv(ours[1:4]) @ ours[1:4]
    assert np.abs(J[1:4] - J[1:4] @ span).max() <= 1e-12
    assert np.linalg.matrix_rank(ours[1:4]) == 3
    bodies = {body.name: body.inertia for body in linkage.bodies}
    pin.forwardKinematics(model, data, pin.neutral(model))
    for i in range(1, 4):
        H = np.asarray(data.oMi[i].actInv(pin.SE3.Identity()).inverse().homogeneous)
        com = H[:3, :3] @ model.inertias[i].lever + H[:3, 3]
        assert np.abs(bodies[f"j{i - 1}"][1:4] / model.inertias[i].mass - com).max() <= 1e-12


def moved(x, y):
    return pin.SE3(np.eye(3), np.array([x, y, 0.0]))


def four_bar(kind):
    """The tree of a planar four-bar linkage, and the constraint that closes it."""
    model, inertia = pin.Model(), pin.Inertia(1.0, np.zeros(3), np.eye(3))

    def add(name, parent, x, y):
        at = model.addJoint(parent, pin.JointModelRZ(), moved(x, y), name)
        model.appendBodyToJoint(at, inertia, pin.SE3.Identity())
        return at

    coupler = add("q2", add("u1", 0, 0.0, 0.0), 0.1, 0.3)
    rocker, end = add("q4", 0, 1.1, 0.0), moved(-0.2, 0.7)
    if kind == pin.ContactType.CONTACT_6D:
        rocker, end = model.addJoint(rocker, pin.JointModelRZ(), end, "q3"), moved(0.0, 0.0)
    closed = pin.RigidConstraintModel(kind, model, coupler, moved(0.8, 0.4), rocker, end)
    return model, closed


@pytest.mark.parametrize("kind", ["CONTACT_3D", "CONTACT_6D"])
def test_constraints_are_loops(kind):
    """With the ranks of the same linkage in a file, and closed in Pinocchio at another pose."""
    model, closed = four_bar(getattr(pin.ContactType, kind))
    linkage = from_pinocchio(model, [closed], ["u1"])
    known = design_space(kinematics.load("four_bar_general"))
    space = design_space(linkage)
    assert (linkage.mobility, linkage.planar) == (1, True)
    assert [o.rank for o in space.orders] == [o.rank for o in known.orders]
    q = joint_positions(linkage, {"u1": 0.3})
    data, at = model.createData(), configuration(model, linkage, q)
    pin.forwardKinematics(model, data, at)
    first = data.oMi[closed.joint1_id] * closed.joint1_placement
    second = data.oMi[closed.joint2_id] * closed.joint2_placement
    apart = np.abs(first.homogeneous - second.homogeneous)
    assert np.abs(at[:2]).min() > 0.01 and apart[:3, 3].max() <= 1e-11
    assert kind == "CONTACT_3D" or apart.max() <= 1e-11


def test_frames_of_bodies_are_links():
    model = model_of(pin.JointModelRX(), pin.JointModelRY())
    away = pin.SE3.Random()
    model.addBodyFrame("arm", 1, pin.SE3.Identity(), 0)
    model.addBodyFrame("hand", 2, away, 0)
    linkage = from_pinocchio(model)
    assert [body.name for body in linkage.bodies] == ["arm", "j1"]
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    pose = data.oMf[model.getFrameId("hand")].homogeneous
    assert np.abs(linkage.places["hand"].pose - pose).max() <= 1e-14
    assert linkage.places["hand"].link == 1


def test_a_free_flyer_is_refused_or_fixed():
    model = model_of(pin.JointModelFreeFlyer(), pin.JointModelRX())
    with pytest.raises(FileError, match="joint 'j0': a floating joint of the base"):
        from_pinocchio(model)
    assert from_pinocchio(model, fix_base=True).mobility == 1


def test_what_cannot_be_taken_is_named():
    with pytest.raises(FileError, match="joint 'j1': a JointModelEllipsoid, for which"):
        from_pinocchio(model_of(pin.JointModelRX(), pin.JointModelEllipsoid(1.0, 2.0, 3.0)))
    with pytest.raises(TypeError, match="expected a pinocchio.Model, not str"):
        from_pinocchio("ur5")
    with pytest.raises(FileError, match="no joint moves"):
        from_pinocchio(pin.Model())
    model, closed = four_bar(pin.ContactType.CONTACT_3D)
    with pytest.raises(FileError, match="constraint 1: a str of no known type; give a Rigid"):
        from_pinocchio(model, ["closed"])
    closed.desired_contact_placement = pin.SE3.Random()
    with pytest.raises(FileError, match="constraint 1: its desired_contact_placement"):
        from_pinocchio(model, [closed])
    with pytest.raises(LinkageError, match="input z: no such joint"):
        from_pinocchio(model, inputs=["z"])
