"""Linkages at special poses: dead joints, fewer conditions at low orders, late plateaus.

The true integers are those of an oracle that shares no code with the product.
"""

from fractions import Fraction

import numpy as np
import pytest

import balance
import kinematics
from balance.space.exact.chain import exact_chain
from balance.space.exact.idle_joints import joints_shown_at_rest
from kinematics.files.urdf.rational_screws import exact_geometry
from tests.independent.certainty_cases import certainty_case
from tests.independent.hard_families import add_yoke, loops_last
from tests.independent.plain_linkage import AXES, Joint, Linkage, Mimic, urdf, vector
from tests.independent.planar_families import ring
from tests.independent.true_ranks import truth
from tests.independent.turned_files import turned_text

Z = AXES[2]


def revolute(before, after, x, y, loop=False):
    """A joint about z."""
    return Joint("R", before, after, vector(x, y, 0), Z, loop=loop)


# Joints 0 and 1 are coaxial, so that link 3 is at rest; so are joints 3 and 6. That joint 4 is
# at rest is seen only around the loop that passes link 3 by its pivot on the ground.
RESTING = Linkage(
    (
        revolute(0, 1, 1, 1),
        revolute(1, 2, 1, 1),
        revolute(2, 3, 0, -1),
        revolute(0, 4, 0, -1),
        revolute(4, 5, -1, -1),
        revolute(3, 0, 0, 1, True),
        revolute(5, 3, 0, -1, True),
    )
)
# Order 2 adds one condition, although the rank is 18.
ALIGNED = Linkage(
    (
        revolute(0, 1, 3, -1),
        revolute(1, 2, 3, 1),
        Joint("P", 2, 3, vector(3, 0, 0), AXES[0]),
        revolute(3, 4, -1, -1),
        Joint("P", 4, 5, vector(0, 3, 0), vector(1, -2, 0)),
        revolute(2, 6, -3, -1),
        revolute(6, 7, -1, 0),
        revolute(3, 0, -1, -3, True),
        revolute(5, 2, -3, 2, True),
        revolute(7, 3, 1, 1, True),
    )
)


def certified(text, tmp_path, **options):
    """The certified space of a file."""
    path = tmp_path / "linkage.urdf"
    path.write_text(text)
    return balance.certify(balance.design_space(path, **options))


def test_joints_rest_around_the_shortest_loop(tmp_path):
    """Links that resting joints connect are one link, around which loops are shorter."""
    space = certified(urdf(RESTING), tmp_path)
    true = truth(RESTING)
    assert space.idle == true.idle == ("j2", "j4", "j5")
    assert (space.rank, space.level, space.doubts) == (true.rank, "verified", ())
    chain = exact_chain(space.linkage, exact_geometry(space.linkage), None, False, False)
    names = [joint.name for joint in space.linkage.joints]
    idle = {names.index(name) for name in true.idle}
    assert joints_shown_at_rest(chain, idle) == idle
    # A joint that moves is not shown to rest.
    assert not joints_shown_at_rest(chain, [names.index("j0")])


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(21245, id="two coaxial pairs of joints cancel around a loop"),
        pytest.param(21236, id="a link spins between coaxial joints that two loops share"),
        pytest.param(22277, id="slides alone connect the links of a pivot"),
        pytest.param(21113, id="loops close by fewer constraints than they have"),
    ],
)
def test_joints_rest_where_the_linkage_moves_as_freely_without_them(seed, tmp_path):
    """A linkage with its resting joints locked keeps all its degrees of freedom."""
    case = certainty_case("grid", seed)
    space, true = certified(case.text, tmp_path), truth(case.readings[0], seed)
    assert (set(space.idle), space.rank, space.doubts) == (set(true.idle), true.rank, ())
    chain = exact_chain(space.linkage, exact_geometry(space.linkage), None, False, True)
    idle = {j for j, joint in enumerate(space.linkage.joints) if joint.name in true.idle}
    assert joints_shown_at_rest(chain, idle) == idle
    moving = set(range(len(chain.parent))) - idle
    for joint in moving:
        assert joint not in joints_shown_at_rest(chain, {*idle, joint})
        assert joint not in joints_shown_at_rest(chain, {joint})


@pytest.mark.parametrize("digits", [pytest.param(9, marks=pytest.mark.slow), 12, 16, 17])
def test_orders_of_a_special_pose_in_turned_frames(digits, tmp_path):
    """The ranks by order are those of the decimals, and the notice says so."""
    true = truth(ALIGNED)
    assert true.ranks[:4] == (3, 6, 7, 10) and true.rank == 18
    exactly = certified(urdf(ALIGNED), tmp_path)
    assert tuple(order.rank for order in exactly.orders) == true.ranks
    assert "corrected" not in {notice.code for notice in exactly.notices}
    text = turned_text(ALIGNED, np.random.default_rng(3), digits, True, "turned")
    space = certified(text, tmp_path)
    assert (space.rank, space.serial_nullity) == (true.rank, true.serial)
    # Doubles are read as roots in the frame of two axes, which gives the pose that is meant.
    codes = {notice.code for notice in space.notices}
    assert codes & {"corrected", "read_as_roots"}


def test_many_poses_of_a_small_yoke_do_not_outvote_exact_arithmetic(tmp_path):
    """Radius 1 mm, two yokes and an arm that follows: conditions of 1e-9 at finite poses."""
    joints, mimics = [Joint("R", 0, 1, vector(-1, "0.6", "1.5"), Z)], []
    pin = vector("0.001", 0, 0)
    first = add_yoke(joints, mimics, 0, Fraction(2), vector(0, 3, 0), pin, False)
    second = add_yoke(joints, mimics, first, Fraction(1), vector(0, 6, 0), pin, False)
    joints.append(Joint("R", 0, 8, vector("-0.1", "-0.8", "-0.9"), Z))
    mimics.append(mimics[0]._replace(joint=len(joints) - 1, source=second))
    linkage = Linkage(*loops_last(joints, mimics), bare=(2, 3, 6, 7))
    true = truth(linkage)
    space = certified(urdf(linkage), tmp_path)
    assert tuple(order.rank for order in space.orders) == true.ranks == (3, 6, 8, 11)
    assert (space.level, space.settled, space.doubts) == ("verified", True, ())
    assert "not_settled" not in {notice.code for notice in space.notices}


@pytest.mark.parametrize("digits", [12, 17])
def test_a_slide_in_the_plane_of_a_loop_is_meant_to_be_in_it(digits, tmp_path):
    """The slide belongs to no loop: its direction is known to the digits of the file only."""
    pins = (
        revolute(0, 1, "-0.66", "-4.3"),
        revolute(1, 2, "-1.59", "-0.19"),
        revolute(2, 3, "4.03", "-1.52"),
    )
    slide = Joint("P", 2, 4, vector("-1.3", "1.7", "1.8"), vector(1, 1, 0))
    closing = revolute(3, 0, "-1.51", "-3.04", True)
    linkage = Linkage((*pins, slide, closing), (Mimic(3, 0, Fraction(1)),), spatial=True)
    text = turned_text(linkage, np.random.default_rng(5), digits, True, "turned")
    space, true = certified(text, tmp_path, spatial=True), truth(linkage)
    assert tuple(order.rank for order in space.orders) == true.ranks == (5, 10, 13, 14, 15)
    assert (space.level, space.doubts) == ("verified", ())


def test_exact_decimals_of_six_digits_leave_no_doubt(tmp_path):
    """A Bennett linkage that closes exactly, and a slide that follows it slowly."""
    axes = [
        AXES[2],
        vector("-0.21", "-0.72", -1),
        vector("-0.147", "-1.204", "-0.012"),
        vector(0, 4, 3),
    ]
    points = [
        vector(0, 0, 0),
        vector("0.87336", "-0.25473", 0),
        vector("-0.322", "-0.11025", "0.147"),
        vector("-1.213", 0, 0),
    ]
    loop = ring(points, "RRRR", axes)
    arms = [
        Joint("R", 1, 4, vector("-0.3", 0, "-0.6"), vector(0, 1, 2)),
        Joint("P", 0, 5, vector("1.5", "-0.1", "-0.8"), vector("0.3", "0.4", 1)),
    ]
    follows = Mimic(5, 1, Fraction(-3))
    linkage = Linkage(*loops_last([*loop, *arms], [follows]), spatial=True)
    true = truth(linkage)
    space = certified(urdf(linkage), tmp_path, spatial=True)
    assert (space.rank, space.serial_nullity) == (true.rank, true.serial)
    assert (space.level, space.doubts) == ("verified", ())


@pytest.mark.slow
def test_coincidences_that_doubles_break_are_in_doubt(tmp_path):
    """The centre of a ball joint lies on the axis of the crank, about which all links turn."""
    joints = (
        Joint("R", 0, 1, vector(2, 0, -2), vector(-1, 1, 1)),
        Joint("R", 1, 2, vector(-1, 1, 1), vector(2, 0, 1)),
        Joint("S", 2, 3, vector(2, 0, -2), AXES[0], AXES[1]),
        Joint("R", 3, 4, vector(1, -1, -2), vector(0, 0, -2)),
        Joint("R", 4, 0, vector(-1, 2, 2), vector(2, -1, 0), loop=True),
    )
    linkage = Linkage(joints, spatial=True)
    true = truth(linkage)
    exactly = certified(urdf(linkage), tmp_path, spatial=True)
    assert (exactly.rank, exactly.doubts) == (true.rank, ()) == (5, ())
    text = turned_text(linkage, np.random.default_rng(0), 17, True, "plain")
    space = certified(text, tmp_path, spatial=True)
    assert space.rank == true.rank or space.doubts


def test_conditions_below_round_off_are_counted_exactly(tmp_path):
    """Small yokes leave conditions that no finite pose shows, and no momentum either."""
    case = certainty_case("yokes", 23197)
    space, true = certified(case.text, tmp_path), truth(case.readings[0], 23197)
    assert (space.rank, space.serial_nullity) == (true.rank, true.serial)
    assert (space.level, space.settled, space.doubts) == ("verified", True, ())
    assert "not_settled" not in {notice.code for notice in space.notices}


def test_rates_below_the_digits_of_the_file_are_in_doubt(tmp_path):
    """Slides that are parallel to 12 digits let the joints between them turn that slowly."""
    case = certainty_case("oblique", 23161)
    space, true = certified(case.text, tmp_path, balance="force"), truth(case.readings[0])
    assert true.idle == ("j1", "j5")
    assert any("j1" in doubt and "digits" in doubt for doubt in space.doubts)


@pytest.mark.parametrize(("seed", "mobility"), [(23119, 0), (38091, 1)])
def test_decimals_that_open_a_loop_are_in_doubt_as_written(seed, mobility, tmp_path):
    """A slide leaves the plane of its loop in the 15th or 17th digit: it does not move."""
    case = certainty_case("embedded", seed)
    assert truth(case.readings[0]).mobility == mobility
    path = tmp_path / "linkage.urdf"
    path.write_text(case.text)
    for spatial in (False, True):
        linkage = kinematics.load(path, angles="as_written")
        space = balance.certify(balance.design_space(linkage, spatial=spatial))
        assert space.level == "estimated" and space.doubts


def test_a_dead_joint_that_rounded_frames_free_is_in_doubt(tmp_path):
    """The centre of a ball joint lies on the axis of the rocker, to eight digits."""
    case = certainty_case("turned", 25130)
    space, true = certified(case.text, tmp_path, spatial=True), truth(case.readings[0])
    assert true.idle == ("j0",) and space.rank != true.rank
    assert any("within the rounding of the file" in doubt for doubt in space.doubts)


def test_a_condition_that_rounding_adds_to_a_planar_linkage_is_in_doubt(tmp_path):
    """Coaxial joints leave parts of a planar linkage at rest, to twelve digits."""
    case = certainty_case("oblique", 29141)
    space, true = certified(case.text, tmp_path), truth(case.readings[0])
    assert space.rank == true.rank + 1
    assert any("within the rounding of the file" in doubt for doubt in space.doubts)


@pytest.mark.slow
def test_a_special_pose_that_doubles_break_is_in_doubt(tmp_path):
    """All joints are on nine points of a square lattice, which no four of them show."""
    case = certainty_case("oblique", 35348)
    space, true = certified(case.text, tmp_path), truth(case.readings[0])
    assert space.rank == true.rank + 1
    assert any("conditions of order 0" in doubt for doubt in space.doubts)


PARALLELOGRAM = """<mujoco model="parallelogram"><worldbody>
<body name="crank"><joint name="a" axis="0 0 1"/>
<inertial pos="0.3 0.4 0" mass="1" diaginertia="0.01 0.1 0.1"/>
<body name="coupler" pos="0.6 0.8 0"><joint name="b" axis="0 0 1"/>
<inertial pos="1 0 0" mass="1" diaginertia="0.01 0.1 0.1"/></body></body>
<body name="rocker" pos="2 0 0"><joint name="c" axis="0 0 1"/>
<inertial pos="0.3 0.4 0" mass="1" diaginertia="0.01 0.1 0.1"/></body></worldbody>
<equality><connect body1="coupler" body2="rocker" anchor="2 0 0"/></equality></mujoco>"""


@pytest.mark.parametrize("at", [{"a": 0.7}, {"a": 0.7, "b": -0.7}, {"a": -0.4}, {"a": 0.3}])
def test_a_parallelogram_is_one_at_every_pose(at, tmp_path):
    """Angles that differ by round-off are one number: crank and rocker stay parallel."""
    path = tmp_path / "parallelogram.xml"
    path.write_text(PARALLELOGRAM)
    linkage = kinematics.load(path, at=at)
    names = [joint.name for joint in linkage.joints]
    screws = dict(zip(names, exact_geometry(linkage).screws, strict=True))
    pivots = [screws[name][3:5] for name in ("a", "b", "c")]
    tip = next(s[3:5] for n, s in screws.items() if n not in "abc" and s[2] and not any(s[:2]))
    crank = [y - x for x, y in zip(pivots[0], pivots[1], strict=True)]
    assert crank == [y - x for x, y in zip(pivots[2], tip, strict=True)]
    space = balance.certify(balance.design_space(linkage))
    assert space.level == "verified" and space.rank == 5
