"""What is read of MJCF files and what is refused in one line: constraints, bodies, names."""

import numpy as np
import pytest

import kinematics
from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_robot
from tests.support.mjcf_text import CONNECT, GEOM, four_bar, of, world

pytest.importorskip("mujoco")


def tree_of(text, **options):
    return read_robot(of(text), **options).tree


def remarks_of(text):
    return [message for _, message in read_robot(of(text)).remarks]


def refused(text, *fragments, **options):
    with pytest.raises(FileError) as caught:
        read_robot(of(text), **options)
    message = str(caught.value)
    assert message.isprintable() and len(message) < 1000
    for fragment in fragments:
        assert fragment in message, message


@pytest.mark.parametrize(
    ("tail", "kind"),
    [
        (CONNECT, "spherical"),
        ('<equality><connect site1="s" site2="t"/></equality>', "spherical"),
        (
            '<equality><connect body1="coupler" body2="rocker" anchor="2 0 0"/><connect '
            'body1="coupler" body2="rocker" anchor="2 0 1"/></equality>',
            "revolute",
        ),
        (
            '<equality><weld body1="rocker" body2="coupler" torquescale="0" anchor="2 0 0"/>'
            "</equality>",
            "spherical",
        ),
    ],
)
def test_every_way_to_close_a_four_bar(tail, kind):
    linkage = kinematics.load(of(four_bar(tail=tail)), inputs=["j1"])
    (loop,) = tree_of(four_bar(tail=tail)).every("loop")
    assert loop.attributes["type"] == kind
    assert linkage.mobility == 1 and len(linkage.loops) == 1


def test_a_weld_fixes_and_says_where():
    weld = '<weld body1="coupler" body2="rocker" relpose="2 0 0 .7071 0 0 .7071"/>'
    tail = f"<equality>{weld}</equality>"
    (loop,) = tree_of(four_bar(tail=tail)).every("loop")
    assert loop.attributes["type"] == "fixed"
    origin = loop.first("predecessor").first("origin")
    assert origin.attributes == {"xyz": "2 0 0", "rpy": "0 0 1.5707963267948966"}


def test_joints_are_coupled():
    tail = '<equality><joint joint1="j3" joint2="j1" polycoef="0.25 -2 0 0 0"/></equality>'
    tree = tree_of(four_bar(tail=tail))
    (mimic,) = (joint.first("mimic") for joint in tree.every("joint") if joint.first("mimic"))
    assert mimic.attributes == {"joint": "j1", "multiplier": "-2", "offset": "0.25"}


def test_a_joint_follows_one_other_only():
    tail = (
        '<equality><joint joint1="j1" joint2="j2" polycoef="0 2 0 0 0"/>'
        '<joint joint1="j1" joint2="j3" polycoef="1 4 0 0 0"/></equality>'
    )
    linkage = kinematics.load(of(four_bar(tail=tail)))
    assert linkage.mobility == 1 and len(linkage.mimics) == 2
    ratios = {
        (linkage.joints[m.joint].name, linkage.joints[m.source].name): m.ratio
        for m in linkage.mimics
    }
    speed = {"j1": 4.0, "j2": 2.0, "j3": 1.0}
    for (joint, source), ratio in ratios.items():
        assert speed[joint] == ratio * speed[source]


def test_a_held_joint_is_fixed():
    tail = '<equality><joint joint1="j3"/></equality>'
    joints = {joint.name: joint for joint in tree_of(four_bar(tail=tail)).every("joint")}
    assert joints["j3"].attributes["type"] == "fixed"


@pytest.mark.parametrize(
    ("tail", "fragments"),
    [
        (
            '<equality><joint name="e" joint1="j3" joint2="j1" polycoef="0 1 0.5"/></equality>',
            ["joint 'e'", "not linear"],
        ),
        ('<equality><joint joint1="j3" polycoef="0.5 0 0 0 0"/></equality>', ["'j3'", "0.5"]),
        (
            '<equality><joint joint1="j3" joint2="j1"/><joint joint1="j1" joint2="j3"/>'
            "</equality>",
            ["couple already"],
        ),
        (
            '<tendon><fixed name="f"><joint joint="j1" coef="1"/></fixed></tendon><equality>'
            '<tendon name="e" tendon1="f"/></equality>',
            ["tendon 'e'", "not read"],
        ),
        ('<equality><flex flex="f"/></equality>', ["<flex>", "not read"]),
        (
            '<equality><connect body1="coupler" body2="nothing" anchor="0 0 0"/></equality>',
            ["unknown element", "connect", "(line 9)"],
        ),
        ('<equality><conect body1="coupler" body2="rocker"/></equality>', ["conect"]),
        ('<equality><connect body1="coupler" body2="coupler" anchor="0 0 0"/></equality>', []),
        (
            '<equality><weld body1="coupler" body2="rocker" relpose="nan 0 0 1 0 0 0"/>'
            "</equality>",
            ["not finite"],
        ),
    ],
)
def test_what_cannot_be_a_loop_is_refused(tail, fragments):
    refused(four_bar(tail=tail), *fragments)


@pytest.mark.parametrize(
    ("head", "tail", "fragment"),
    [
        ("", CONNECT.replace("name=", 'active="false" name='), "connect 'k': not active"),
        ('<option><flag equality="disable"/></option>', CONNECT, "connect 'k': not active"),
        ("", '<tendon><fixed name="f"><joint joint="j1" coef="1"/></fixed></tendon>', "'f'"),
        ("", '<deformable><flex name="c"/></deformable>', "deformable"),
    ],
)
def test_what_is_left_out_is_said(head, tail, fragment):
    (remark,) = remarks_of(four_bar(head, tail))
    assert fragment in remark and "\n" not in remark


def test_contacts_actuators_and_sensors_need_no_word():
    tail = (
        '<actuator><motor joint="j1"/></actuator><sensor><jointpos joint="j1"/></sensor>'
        '<contact><exclude body1="crank" body2="rocker"/></contact><keyframe><key/></keyframe>'
    )
    assert remarks_of(four_bar('<asset><texture file="no.png"/></asset>', tail)) == []


@pytest.mark.parametrize("joint", ["j1", "j2", "j3"])
def test_the_input_is_the_joint_with_an_actuator(joint):
    """A parallelogram turns as well by each of its joints; without actuators by the first."""
    drive = f'<actuator><position joint="{joint}"/><motor site="s"/></actuator>'
    assert kinematics.load(of(four_bar())).inputs == ("j1",)
    linkage = kinematics.load(of(four_bar("", CONNECT + drive)))
    assert linkage.inputs == (joint,) and not remarks_of(four_bar("", CONNECT + drive))
    assert kinematics.load(of(linkage.document.data.decode())).inputs == (joint,)


TENDON = (
    '<tendon><fixed name="t"><joint joint="{}" coef="{}"/><joint joint="{}" coef="{}"/></fixed>'
    '</tendon><equality><tendon tendon1="t" polycoef="0 1 0 0 0"/></equality>'
)


def test_a_fixed_tendon_of_two_joints_that_is_held_is_a_mimic():
    """As in MuJoCo, whose constraint has the same direction in joint rates."""
    text = four_bar("", TENDON.format("j2", 2, "j1", -3))
    linkage = kinematics.load(of(text))
    (mimic,) = linkage.mimics
    names = [linkage.joints[k].name for k in (mimic.joint, mimic.source)]
    assert (names, mimic.ratio) == (["j2", "j1"], 1.5) and not remarks_of(text)
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.1, 0.2, 0.3
    mujoco.mj_forward(model, data)
    row = data.efc_J.reshape(-1, model.nv)[0]
    assert row @ [1.0, 1.5, 0.0] == pytest.approx(0.0, abs=1e-15) and row.any()


@pytest.mark.parametrize(
    "change", [('tendon1="t"', 'tendon1="t" tendon2="t"'), ('"-3"', '"0"'), ('coef="2"', "")]
)
def test_other_tendons_that_are_held_are_refused(change):
    refused(
        four_bar("", TENDON.format("j2", 2, "j1", -3).replace(*change)), "tendon", "not read"
    )


def test_free_bodies_float_until_the_base_is_fixed():
    text = world(f'<body name="b"><freejoint/>{GEOM}<body><joint/>{GEOM}</body></body>')
    with pytest.raises(FileError, match="a floating joint of the base.*--fix-base"):
        kinematics.load(of(text))
    linkage = kinematics.load(of(text), fix_base=True)
    assert linkage.mobility == 1 and [body.name for body in linkage.bodies] == ["body2"]


def test_unnamed_and_doubled_names_are_unique():
    inside = (
        f'<body name="body2"><joint name="joint1"/>{GEOM}<body><joint/>{GEOM}</body></body>'
    )
    tree = tree_of(world(inside + f'<body name="joint1_link"><joint/><joint/>{GEOM}</body>'))
    for tag in ("link", "joint"):
        names = [item.name for item in tree.every(tag)]
        assert len(set(names)) == len(names)
    assert {"body2", "body2_", "joint1", "joint1_", "joint1_link"} <= {
        item.name for tag in ("link", "joint") for item in tree.every(tag)
    }


def test_mocap_bodies_are_fixed_and_said_to_be():
    text = world(
        f'<body name="hand" mocap="true" pos="1 0 0"/><body name="b"><joint/>{GEOM}</body>'
    ).replace("</mujoco>", '<equality><weld body1="hand" body2="b"/></equality></mujoco>')
    (remark,) = remarks_of(text)
    assert "'hand' is a mocap body" in remark


@pytest.mark.parametrize(
    "equality",
    ['<weld body1="hand" body2="stand"/>', '<connect body1="b" body2="c" anchor="0 0 0"/>'],
)
def test_equalities_inside_one_rigid_body_close_nothing(equality):
    """The arm keeps its freedom, and a remark names what is left out."""
    text = world(
        f'<body name="hand" mocap="true"/><body name="stand"><body name="b"><joint/>{GEOM}'
        f'<body name="c">{GEOM}</body></body></body>'
    ).replace("</mujoco>", f"<equality>{equality}</equality></mujoco>")
    linkage = kinematics.load(of(text))
    assert linkage.mobility == 1 and not linkage.loops
    (remark,) = remarks_of(text)
    assert "cannot move apart" in remark and "left out" in remark


def test_static_bodies_belong_to_the_ground_or_their_parent():
    text = world(
        f'<body name="t">{GEOM}<body name="b"><joint/>{GEOM}'
        f'<body name="c">{GEOM}</body></body></body>'
    )
    linkage = kinematics.load(of(text))
    (body,) = linkage.bodies
    assert body.name == "b"
    density = 1000.0 * 4 / 3 * np.pi * 1e-3
    assert abs(body.inertia[0] - 2 * density) <= 1e-12 * density


def test_joint_positions_count_from_the_reference():
    """``ref`` is where the joint stands in the pose of the file: nothing moves."""
    inside = (
        '<body name="b" pos="1 0 0"><joint name="j" ref="{}" axis="0 0 1"/>' + GEOM + "</body>"
    )
    poses = [kinematics.load(of(world(inside.format(ref)))).places["b"].pose for ref in (0, 30)]
    assert np.array_equal(*poses)
