"""Linkages built from joint screws, beside formulas and files."""

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from kinematics import ScrewJoint, from_screws
from kinematics.errors import CoordinateError, FileError, LinkageError, MobilityError
from kinematics.files.urdf.rational_screws import exact_geometry
from tests.support.laws import MODELS, unit_vector

CRANK = ScrewJoint("u1", "base", "crank")
COUPLER = ScrewJoint("q2", "crank", "coupler", point=(0.1, 0.3, 0.0))
ROCKER = ScrewJoint("q4", "base", "rocker", point=(1.1, 0.0, 0.0))
CLOSED = ScrewJoint("q3", "coupler", "rocker", point=(0.9, 0.7, 0.0))
TREE = [CRANK, COUPLER, ROCKER]


def line(axis, point, pitch=0.0):
    """Screw of a line, from its definition: the velocity of the point at the origin."""
    n = np.asarray(axis) / np.linalg.norm(axis)
    return np.concatenate([n, np.cross(point, n) + pitch * n])


def cloud(rng, count=6):
    """Point masses (count,) and their places (count, 3)."""
    return rng.uniform(0.1, 1.0, count), rng.standard_normal((count, 3))


def of_cloud(masses, places):
    """Mass, centre of mass, and inertia about it, by sums over points."""
    com = masses @ places / masses.sum()
    arms = places - com
    return (
        masses.sum(),
        com,
        sum(
            m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arms, strict=True)
        ),
    )


def parameters_of_cloud(masses, places):
    """The ten parameters about the origin, by sums over points."""
    E = sum(
        m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, places, strict=True)
    )
    return np.array(
        [masses.sum(), *(masses @ places), E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]]
    )


def arm(rng):
    """One joint after the other, with any axis and point, and what their screws are."""
    kinds = [
        "revolute",
        "prismatic",
        "helical",
        "universal",
        "cylindrical",
        "spherical",
        "planar",
        "revolute",
    ]
    joints, expected = [], []
    for k, kind in enumerate(kinds):
        n, r, pitch = 3.0 * unit_vector(rng), rng.standard_normal(3), 0.0
        u, axis2 = np.cross(n, unit_vector(rng)), None
        slide = np.concatenate([np.zeros(3), n / np.linalg.norm(n)])
        if kind == "helical":
            pitch = 0.3
        if kind == "universal":
            axis2 = u
        joints.append(ScrewJoint(f"j{k}", f"l{k - 1}", f"l{k}", n, r, kind, pitch, axis2))
        expected.append(
            {
                "prismatic": [slide],
                "cylindrical": [line(n, r), slide],
                "universal": [line(n, r), line(u, r)],
            }.get(kind, [line(n, r, pitch)])
        )
    return joints, expected


def test_screws_are_those_of_their_axes():
    joints, expected = arm(np.random.default_rng(4))
    linkage = from_screws(joints)
    for joint, screws in zip(joints, expected, strict=True):
        own = [each.screw for each in linkage.joints if each.whole == joint.name]
        if joint.kind in ("spherical", "planar"):
            turning = [s for s in own if s[:3].any()]
            assert len(own) == 3
            for s in turning:
                assert np.abs(s[3:] - np.cross(joint.point, s[:3])).max() <= 1e-14
        else:
            assert np.abs(np.array(own) - screws).max() <= 1e-14
    planar = [j.screw for j in linkage.joints if j.whole == "j6"]
    n = np.asarray(joints[6].axis) / 3.0
    assert np.abs(planar[2][:3] - n).max() <= 1e-14
    assert max(abs(n @ s[3:]) for s in planar[:2]) <= 1e-14


def test_frames_are_at_the_points_and_parallel_to_the_inertial_frame():
    joints, _ = arm(np.random.default_rng(5))
    places = from_screws(joints).places
    for joint in joints:
        pose = places[joint.child].pose
        assert np.array_equal(pose[:3, :3], np.eye(3))
        assert np.abs(pose[:3, 3] - joint.point).max() <= 1e-14
    assert np.array_equal(places["l-1"].pose, np.eye(4))


def test_a_raw_screw_says_the_same_as_its_axis():
    rng = np.random.default_rng(6)
    joints, _ = arm(rng)
    by_axis = from_screws(joints[:3])
    raw = []
    for joint, own in zip(joints, by_axis.joints, strict=False):
        size = rng.uniform(0.5, 3.0)
        raw.append(ScrewJoint(joint.name, joint.parent, joint.child, screw=size * own.screw))
    by_screw = from_screws(raw)
    for first, second in zip(by_axis.joints, by_screw.joints, strict=True):
        assert first.kind == second.kind
        assert np.abs(first.screw - second.screw).max() <= 1e-14


def test_inertias_are_those_of_the_points_they_are_made_of():
    rng = np.random.default_rng(7)
    joints, _ = arm(rng)
    clouds = {joint.child: cloud(rng) for joint in joints}
    linkage = from_screws(joints, bodies={link: of_cloud(*c) for link, c in clouds.items()})
    assert [body.name for body in linkage.bodies] == [joint.child for joint in joints]
    for body in linkage.bodies:
        expected = parameters_of_cloud(*clouds[body.name])
        assert np.abs(body.inertia - expected).max() <= 1e-13 * np.abs(expected).max()


def test_only_named_bodies_carry_parameters():
    body = (1.0, (0.2, 0.1, 0.0), 0.1 * np.eye(3))
    linkage = from_screws(TREE, [CLOSED], {"rocker": body})
    assert [each.name for each in linkage.bodies] == ["rocker"]
    assert [each.name for each in from_screws(TREE, [CLOSED]).bodies] == [
        "crank",
        "coupler",
        "rocker",
    ]


@pytest.mark.table(16)
@pytest.mark.parametrize("name", MODELS)
def test_ranks_are_those_of_the_same_linkage_in_a_file(name):
    """Each freedom of the file as a joint of its own, where it has one joint each."""
    known = kinematics.load(name)
    links = {place.link: link for link, place in reversed(known.places.items())}
    if any(joint.numbered for joint in known.joints):
        pytest.skip("has joints of several degrees of freedom")
    follows = {m.joint: (known.joints[m.source].name, m.ratio) for m in known.mimics}
    tree = [
        ScrewJoint(
            j.name,
            links[j.parent],
            links[i],
            point=j.point,
            screw=j.screw,
            mimic=follows.get(i),
        )
        for i, j in enumerate(known.joints)
        if not j.in_loop
    ]
    loops = []
    for loop in known.loops:
        j = known.joints[loop.end]
        ends = links[j.parent], links[loop.successor]
        axis = j.screw[3:] if j.kind == "prismatic" else j.screw[:3]
        loops.append(ScrewJoint(j.name, *ends, axis, j.point, j.kind))
    bodies = {body.name: (1.0, (0, 0, 0), np.eye(3)) for body in known.bodies}
    built = from_screws(tree, loops, bodies, known.inputs)
    assert (built.mobility, built.inputs, built.planar) == (
        known.mobility,
        known.inputs,
        known.planar,
    )
    ours, theirs = design_space(built), design_space(known)
    assert [o.rank for o in ours.orders] == [o.rank for o in theirs.orders]
    assert ours.nullity == theirs.nullity
    assert ours.serial.shape == theirs.serial.shape


def test_decimals_that_close_prove_the_ranks():
    """0.9 - 0.1 and 0.7 - 0.3 are rounded in binary; in decimals the loop closes."""
    linkage = from_screws(TREE, [CLOSED], inputs=["u1"])
    assert not exact_geometry(linkage).notices
    space = certify(design_space(linkage))
    assert [order.rank for order in space.orders] == [3, 6, 7, 8]
    assert space.certainty.level == "proved" and not space.notices


def test_a_mimic_is_a_relation_of_displacements():
    joints = [CRANK, ScrewJoint("q2", "crank", "coupler", point=(1, 0, 0), mimic=("u1", -2.5))]
    linkage = from_screws(joints)
    assert (linkage.mobility, linkage.inputs) == (1, ("u1",))
    (mimic,) = linkage.mimics
    assert (mimic.joint, mimic.source, mimic.ratio) == (1, 0, -2.5)


def test_a_weld_makes_two_bodies_one():
    end = ScrewJoint("q5", "rocker", "end", point=(0.9, 0.7, 0.0))
    weld = ScrewJoint("w", "coupler", "end", kind="fixed")
    bodies = {link: (1.0, (0.5, 0.5, 0.0), np.eye(3)) for link in ("coupler", "end")}
    welded = from_screws([*TREE, end], [weld], bodies)
    assert welded.mobility == 1
    assert [(body.name, body.inertia[0]) for body in welded.bodies] == [("coupler", 2.0)]


J = ScrewJoint
REFUSED = {
    "no joints": ([], {}, "no joints; give at least one"),
    "zero axis": ([J("a", "b", "c", (0, 0, 0))], {}, "joint 'a': axis is zero; give"),
    "nan": ([J("a", "b", "c", (0, 0, np.nan))], {}, "joint 'a': axis = .*not 3 finite"),
    "infinite": ([J("a", "b", "c", point=(0, 0, np.inf))], {}, "joint 'a': point = .*finite"),
    "shape": ([J("a", "b", "c", point=(0, 1))], {}, "joint 'a': point = .*not 3 finite"),
    "words": ([J("a", "b", "c", point="no")], {}, "joint 'a': point = 'no' is not 3"),
    "screw": ([J("a", "b", "c", screw=(0, 0, 1))], {}, "joint 'a': screw = .*not 6 finite"),
    "no screw": ([J("a", "b", "c", screw=np.zeros(6))], {}, "joint 'a': screw is zero"),
    "both": ([J("a", "b", "c", (0, 0, 1), screw=(0, 0, 1, 0, 0, 0))], {}, "screw alone"),
    "kind": ([J("a", "b", "c", kind="ball")], {}, "unknown kind 'ball'; choose from"),
    "pitch": ([J("a", "b", "c", pitch=0.1)], {}, "a pitch on a revolute joint; use kind="),
    "axis2": ([J("a", "b", "c", axis2=(1, 0, 0))], {}, "axis2 of a revolute joint"),
    "lean": ([J("a", "b", "c", (0, 0, 1), kind="universal", axis2=(1, 0, 1))], {},
             "not perpendicular"),
    "no name": ([J("", "b", "c")], {}, "name is '', not a name"),
    "number": ([J("a", 3, "c")], {}, "joint 'a': parent is 3, not a name"),
    "tuple": ([("a", "b", "c")], {}, "is not a ScrewJoint; write ScrewJoint"),
    "same name": ([J("a", "b", "c"), J("a", "c", "d")], {}, "name 'a' is taken by joint 'a'"),
    "two parents": ([J("a", "b", "c"), J("e", "b", "c")], {},
                    "joint 'e': link 'c' is already the child of joint 'a'; .* item of loops"),
    "cycle": ([J("a", "b", "c"), J("e", "c", "b")], {}, "form a cycle of joints; .*of loops"),
    "itself": ([J("a", "b", "c"), J("e", "c", "c")], {}, "joins link 'c' to itself|cycle"),
    "no parent": ([J("a", "b", "c"), J("e", "x", "d")], {},
                  "joint 'e': no joint carries its parent link 'x', and the base is 'b'"),
    "no body": ([J("a", "b", "c")], {"bodies": {"d": (1, (0, 0, 0), np.eye(3))}},
                "body 'd': there is no such link; .*'b', 'c'"),
    "no inertia": ([J("a", "b", "c")], {"bodies": {"c": (1, (0, 0, 0))}},
                   "body 'c': .*is not mass, centre of mass and inertia; give"),
    "skew": ([J("a", "b", "c")], {"bodies": {"c": (1, (0, 0, 0), np.arange(9).reshape(3, 3))}},
             "inertia is not symmetric"),
    "mimic": ([J("a", "b", "c"), J("e", "c", "d", mimic=("z", 1))], {},
              "joint 'e': mimics unknown joint 'z'"),
    "mimic word": ([J("a", "b", "c"), J("e", "c", "d", mimic=3)], {}, "a name and a ratio"),
    "loop": ([J("a", "b", "c")], {"loops": [J("l", "c", "z")]},
             "loop 'l': successor link 'z' does not exist; .*'b', 'c'"),
    "loop itself": ([J("a", "b", "c")], {"loops": [J("l", "c", "c")]}, "are one rigid body"),
    "loop pitch": ([J("a", "b", "c")], {"loops": [J("l", "c", "b", kind="helical", pitch=1)]},
                   "loop 'l': a pitch on a helical loop"),
    "only fixed": ([J("a", "b", "c", kind="fixed")], {}, "no joint moves"),
    "title": ([J("a", "b", "c")], {"name": ""}, "name is ''"),
}  # fmt: skip


@pytest.mark.parametrize("fault", REFUSED)
def test_what_cannot_be_a_linkage_is_refused_with_its_reason(fault):
    joints, more, message = REFUSED[fault]
    with pytest.raises(FileError, match=message) as error:
        from_screws(joints, **more)
    assert "\n" not in str(error.value) and error.value.remedy
    assert "(line" not in str(error.value) and "--" not in str(error.value)


def test_what_cannot_move_is_refused_like_a_file():
    with pytest.raises(CoordinateError, match="input z: no such joint"):
        from_screws(TREE, [CLOSED], inputs=["z"])
    rigid = [CLOSED, ScrewJoint("b", "coupler", "base", point=(0.5, 0.9, 0))]
    with pytest.raises(MobilityError, match="rigid"):
        from_screws(TREE, rigid)
    assert issubclass(FileError, LinkageError)
