"""The last hinge of the four-bar in `dialect_text`, in the words of each tool."""

from tests.support.dialect_text import ON_B, ON_C, OPEN

BALL = (
    '<drake:ball_constraint xmlns:drake="d"><drake:ball_constraint_body_A name="b"/>'
    f'<drake:ball_constraint_p_AP value="{ON_B}"/><drake:ball_constraint_body_B name="c"/>'
    f'<drake:ball_constraint_p_BQ value="{ON_C}"/></drake:ball_constraint>'
)

POSE = f"<pose>{ON_C} 0 3.141592653589793 0</pose>"


def gazebo(kind="revolute", pose=POSE, axis="<axis><xyz>0 0 1</xyz></axis>", ends="bc"):
    """A joint of SDF in <gazebo>."""
    parent, child = ends
    return (
        f'<gazebo><joint name="l" type="{kind}"><parent>{parent}</parent>'
        f"<child>{child}</child>{pose}{axis}</joint></gazebo>"
    )


AXES = ("0 0 1", "0 0 1")


def constraint(kind="revolute", axes=AXES, rpy=("0 0 0", "0 3.141592653589793 0")):
    """The element that was proposed to urdfdom."""
    lines = [
        f'<{role}_axis xyz="{axis}"/>'
        for role, axis in zip(("parent", "child"), axes, strict=True)
        if axis
    ]
    return (
        f'<constraint name="l" type="{kind}"><parent link="b"/>'
        f'<parent_origin xyz="{ON_B}" rpy="{rpy[0]}"/><child link="c"/>'
        f'<child_origin xyz="{ON_C}" rpy="{rpy[1]}"/>{"".join(lines)}</constraint>'
    )


def loop_joint(kind="revolute", axis='<axis xyz="0 0 1"/>', turn="0 3.141592653589793 0"):
    """The element of old versions of Drake and of Isaac Sim."""
    words = f' type="{kind}"' if kind else ""
    return (
        f'<loop_joint name="l"{words}><link1 link="b" xyz="{ON_B}" rpy="0 0 0"/>'
        f'<link2 link="c" xyz="{ON_C}" rpy="{turn}"/>{axis}</loop_joint>'
    )


def mujoco(*items):
    """Equalities of MuJoCo."""
    return f"<mujoco><compiler meshdir='m'/><equality>{''.join(items)}</equality></mujoco>"


def connect(ends="bc", anchor=ON_B, more=""):
    """The equality of MuJoCo that closes a loop in a point."""
    first, second = ends
    return mujoco(f'<connect body1="{first}" body2="{second}" anchor="{anchor}" {more}/>')


def related(polycoef, joints='joint1="j3" joint2="j1"'):
    """The equality of MuJoCo that relates two joints."""
    words = f' polycoef="{polycoef}"' if polycoef else ""
    return mujoco(f"<joint {joints}{words}/>")


def frame(name, parent, xyz, kind="fixed"):
    """A frame of onshape-to-robot or PlaCo, which is a link on a fixed joint."""
    return (
        f'<link name="{name}"/><joint name="{name}_frame" type="{kind}">'
        f'<parent link="{parent}"/><child link="{name}"/><origin xyz="{xyz}"/></joint>'
    )


PAIR = frame("closing_hinge_1", "b", ON_B) + frame("closing_hinge_2", "c", ON_C)


def plugin(parent="d", model="r", child="c", name="gz::sim::systems::DetachableJoint"):
    """The plugin of Gazebo that welds two links."""
    return (
        f'<gazebo><plugin filename="gz-sim-detachable-joint-system" name="{name}">'
        f"<parent_link>{parent}</parent_link><child_model>{model}</child_model>"
        f"<child_link>{child}</child_link></plugin></gazebo>"
    )


def coupling(ends="ac", ratio='<ratio value="-2"/>'):
    """The element of URDF+ that relates two joints."""
    first, second = ends
    return (
        f'<coupling name="k"><predecessor link="{first}"/><successor link="{second}"/>'
        f"{ratio}</coupling>"
    )


def mimicked(name, source, ratio):
    """The open linkage with a <mimic> in a joint."""
    start = OPEN.index(f'name="{name}"')
    end = OPEN.index("</joint>", start)
    return f'{OPEN[:end]}<mimic joint="{source}" multiplier="{ratio}"/>{OPEN[end:]}'
