"""Linkages from sketches against Pinocchio, trigonometry, and files that were made by hand."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

import balance
from balance.studies import linkage_from_sketch
from kinematics.errors import LinkageError, SynthesisError, UsageError

FIVE_BAR = (
    "A=0,0; B=400mm,0; C=A+250mm@120deg; D=B+250mm@60deg; E=C:350mm,D:350mm",
    "left_lower=A,C; left_upper=C,E; right_lower=B,D; right_upper=D,E",
)
FOUR_BAR = (
    "o1=0,0; o2=0.1,0.3; o3=0.9,0.7; o4=1.1,0",
    "crank=o1,o2; coupler=o2,o3; rocker=o4,o3",
)
SLIDER = ("O=0,0; A=O+50mm@60deg; C=A:180mm,O@0deg", "crank=O,A; rod=A,C", "piston=C@0deg")
# A Watt six-bar: a four-bar with a ternary coupler that carries a dyad.
SIX_BAR = (
    "A=0,0; B=0.1,0.25; C=0.55,0.4; D=0.6,0; P=B:0.3,C:0.35; Q=P+0.4@10deg; F=Q+0.5@-80deg",
    "base=A,D,F; crank=A,B; coupler=B,C,P; rocker=D,C; connector=P,Q; output=F,Q",
)
# A parallelogram whose links lie on one line.
FLAT = "A=0,0; B=1,0; C=3,0; D=2,0"
SKETCHES = {"five-bar": FIVE_BAR, "four-bar": FOUR_BAR, "slider": SLIDER, "six-bar": SIX_BAR}


class PinocchioFile:
    """The tree of a file in Pinocchio at its pose, and the ends of its loops."""

    def __init__(self, urdf: bytes) -> None:
        root = ElementTree.fromstring(urdf)
        loops = root.findall("loop")
        for loop in loops:
            root.remove(loop)
        self.model = pin.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))
        self.data = self.model.createData()
        pin.framesForwardKinematics(self.model, self.data, pin.neutral(self.model))
        self.ends = {
            loop.get("name"): [self._place(loop.find(side)) for side in SIDES] for loop in loops
        }

    def _place(self, side: ElementTree.Element) -> np.ndarray:
        offset = [float(word) for word in side.find("origin").get("xyz").split()]
        return self.link(side.get("link")).act(np.array(offset))

    def link(self, name: str) -> pin.SE3:
        return self.data.oMf[self.model.getFrameId(name)]

    def inertia(self, name: str) -> pin.Inertia:
        """That of a link with a joint of its own, in the inertial frame."""
        (joint,) = (j for j, parent in enumerate(self.model.joints) if self._carries(j, name))
        return self.data.oMi[joint].act(self.model.inertias[joint])

    def _carries(self, joint: int, link: str) -> bool:
        frame = self.model.frames[self.model.getFrameId(link)]
        return frame.parentJoint == joint


SIDES = ("predecessor", "successor")


def placed(z: complex) -> np.ndarray:
    return np.array([z.real, z.imag, 0.0])


@pytest.mark.parametrize("words", SKETCHES.values(), ids=SKETCHES)
def test_joints_are_where_the_sketch_has_them(words):
    """By Pinocchio, from the file; each loop closes there, and in our own assembly."""
    sketch = linkage_from_sketch(*words)
    file = PinocchioFile(sketch.urdf)
    size = max(map(abs, sketch.points.values()))
    for joint in sketch.joints:
        point = placed(sketch.points[joint.point])
        if joint.closes_loop:
            for end in file.ends[joint.name]:
                assert np.abs(end - point).max() < 1e-14 * size
        else:
            assert np.abs(file.link(joint.child).translation - point).max() < 1e-14 * size
    for loop in sketch.linkage.loops:
        assert np.abs(loop.gap - np.eye(4)).max() < 1e-12


def test_points_are_those_of_trigonometry():
    points = linkage_from_sketch(*FIVE_BAR).points
    height = 0.25 * math.sqrt(3.0) / 2.0
    tip = height + math.sqrt(0.35**2 - 0.325**2)
    for name, x, y in (("C", -0.125, height), ("D", 0.525, height), ("E", 0.2, tip)):
        assert abs(points[name] - complex(x, y)) < 1e-15
    low = "A=0,0; B=400mm,0; C=A+250mm@120deg; D=B+250mm@60deg; E=D:350mm,C:350mm"
    other = linkage_from_sketch(low, FIVE_BAR[1]).points
    assert abs(other["E"] - complex(0.2, 2.0 * height - tip)) < 1e-15
    stroke = linkage_from_sketch(*SLIDER).points["C"]
    angle = math.radians(60.0)
    slant = math.sqrt(0.18**2 - (0.05 * math.sin(angle)) ** 2)
    assert abs(stroke - (0.05 * math.cos(angle) + slant)) < 1e-15
    on = linkage_from_sketch("A=0,0; B=3,4; P=A+-5@B", "base=A; arm=A,B,P").points["P"]
    assert abs(on - (-3 - 4j)) < 1e-14


def closed_form(start, end, sizes, density, circular=False):
    """A box or a cylinder between two points, by Pinocchio, in the inertial frame."""
    length, (w, t) = abs(end - start), sizes
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, cmath.phase(end - start))
    at = pin.SE3(turn, placed(0.5 * (start + end)))
    if not circular:
        return at.act(pin.Inertia.FromBox(density * length * w * t, length, w, t))
    along = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.5 * math.pi, 0.0), np.zeros(3))
    mass = density * length * math.pi * w * w / 4.0
    return at.act(along.act(pin.Inertia.FromCylinder(mass, 0.5 * w, length)))


def assert_same(inertia, expected):
    """To the ten digits of the file."""
    size = np.abs(expected.matrix()).max()
    assert np.abs(inertia.matrix() - expected.matrix()).max() < 1e-9 * size


def test_inertias_are_those_of_boxes_and_cylinders():
    sketch = linkage_from_sketch(
        *SIX_BAR,
        section="30mmx10mm, rocker=d20mm",
        density="aluminium, crank=7.85g/cm3",
        mass="connector=250g",
    )
    file, at = PinocchioFile(sketch.urdf), sketch.points
    bar = 0.03, 0.01
    assert_same(file.inertia("crank"), closed_form(at["A"], at["B"], bar, 7850.0))
    rod = closed_form(at["D"], at["C"], (0.02, 0.02), 2700.0, circular=True)
    assert_same(file.inertia("rocker"), rod)
    plain = closed_form(at["P"], at["Q"], bar, 2700.0)
    scale = 0.25 / plain.mass
    assert_same(
        file.inertia("connector"),
        pin.Inertia(0.25, plain.lever, scale * plain.inertia),
    )
    corners = [at[name] for name in "BCPB"]
    first, *others = (closed_form(a, b, bar, 2700.0) for a, b in pairwise(corners))
    assert_same(file.inertia("coupler"), sum(others, start=first))
    masses = {link.name: link.mass for link in sketch.links}
    assert masses["coupler"] == pytest.approx(sum((first, *others), pin.Inertia.Zero()).mass)
    lone = linkage_from_sketch("A=0,0; B=0,2", "base=A; arm=A,B", mass={"arm": 3.0})
    assert_same(PinocchioFile(lone.urdf).inertia("arm"), thin_rod(3.0, 2.0))


def thin_rod(mass, length):
    """Along y from the origin."""
    across = mass * length**2 / 12.0
    return pin.Inertia(mass, np.array([0.0, length / 2.0, 0.0]), np.diag([across, 0.0, across]))


def test_a_slider_is_a_block():
    sketch = linkage_from_sketch(*SLIDER, section="20mmx10mm", mass="piston=0.5")
    piston = PinocchioFile(sketch.urdf).inertia("piston")
    block = pin.Inertia.FromBox(0.5, 0.04, 0.02, 0.01)
    assert_same(piston, pin.SE3(np.eye(3), placed(sketch.points["C"])).act(block))
    kinds = {joint.name: joint.kind for joint in sketch.joints}
    assert [name for name in kinds if kinds[name] == "prismatic"] == ["piston_slide"]
    bare = linkage_from_sketch(*SLIDER, mass="piston=0.5, crank=0.1, rod=0.2")
    assert_same(
        PinocchioFile(bare.urdf).inertia("piston"),
        pin.Inertia(0.5, placed(sketch.points["C"]), np.zeros((3, 3))),
    )


def test_shapes_are_those_of_the_bars():
    """Each ``<visual>`` lies on its bar: both ends of its axis are the points."""
    sketch = linkage_from_sketch(*SIX_BAR, section="30mmx10mm, rocker=d20mm")
    file = PinocchioFile(sketch.urdf)
    root = ElementTree.fromstring(sketch.urdf)
    ends = []
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            origin, shape = visual.find("origin"), visual.find("geometry")[0]
            xyz, rpy = (
                np.array([float(x) for x in origin.get(key).split()]) for key in ("xyz", "rpy")
            )
            at = file.link(link.get("name")) * pin.SE3(pin.rpy.rpyToMatrix(*rpy), xyz)
            cylinder = shape.tag == "cylinder"
            assert cylinder == (link.get("name") == "rocker")
            size = float(shape.get("length") if cylinder else shape.get("size").split()[0])
            axis = np.array([0.0, 0.0, 0.5 * size] if cylinder else [0.5 * size, 0.0, 0.0])
            ends.append({(*np.round(at.act(sign * axis)[:2], 8),) for sign in (-1.0, 1.0)})
    at = {name: (round(z.real, 8), round(z.imag, 8)) for name, z in sketch.points.items()}
    for pair in ("AB", "BC", "CP", "PB", "DC", "PQ", "FQ"):
        assert {at[name] for name in pair} in ends
    assert len(ends) == 7


@pytest.mark.parametrize(
    ("words", "mobility", "inputs"),
    [
        (FIVE_BAR, 2, ("A", "B")),
        (FOUR_BAR, 1, ("o1",)),
        (SLIDER, 1, ("O",)),
        (SIX_BAR, 1, ("A",)),
        (("A=0,0; B=1,0; C=1,1", "base=A; upper=A,B; lower=B,C"), 2, ("A", "B")),
    ],
)
def test_mobility_is_that_of_grueblers_formula(words, mobility, inputs):
    sketch = linkage_from_sketch(*words)
    links, joints = len(sketch.links) + 1, len(sketch.joints)
    assert sketch.linkage.mobility == mobility == 3 * (links - 1) - 2 * joints
    assert sketch.linkage.inputs == inputs and sketch.linkage.planar


def test_three_links_at_one_point_have_two_joints():
    """Named after their links; the inputs that are named hold."""
    sketch = linkage_from_sketch(
        "A=0,0; G=0.1,0.4; B=1,0; C=0.5,0.8; E=1.4,0.9; F=2,0",
        "base=A,B,F; left=A,G; rod=G,C; right=B,C; top=C,E; far=F,E",
        inputs=["B"],
    )
    names = {joint.name for joint in sketch.joints if joint.point == "C"}
    assert names == {"C_rod", "C_top"}
    assert {joint.parent for joint in sketch.joints if joint.point == "C"} == {"right"}
    assert sketch.linkage.mobility == 1 == 3 * 5 - 2 * len(sketch.joints)
    assert sketch.linkage.inputs == ("B",)


def test_a_tool_point_has_a_frame_and_lengthens_its_bar():
    sketch = linkage_from_sketch(
        "A=0,0; B=0,0.25; C=0.2,0.4; D=0.6,0; T=C+50mm@B; P=B+-0.1@C",
        "base=A,D; crank=A,B; coupler=B,C,P; rocker=D,C",
        section="20mmx5mm",
    )
    file, at = PinocchioFile(sketch.urdf), sketch.points
    assert np.abs(file.link("P").translation - placed(at["P"])).max() < 1e-15
    assert_same(file.inertia("coupler"), closed_form(at["P"], at["C"], (0.02, 0.005), 7850.0))
    lengths = {link.name: link.length for link in sketch.links}
    assert lengths["coupler"] == pytest.approx(0.35)


def test_frames_of_tool_points_have_names_of_their_own():
    """Beside a pin T_fixed, and links with the name of the point, and of its frame."""
    points = "A=0,0; T_fixed=1,0; B=1,1; T=2,1"
    sketch = linkage_from_sketch(points, "base=A; T=A,T_fixed; T_tool=T_fixed,B; c=B,T")
    root = ElementTree.fromstring(sketch.urdf)
    for tag, name in (("link", "T_tool_"), ("joint", "T_fixed_")):
        names = [item.get("name") for item in root.findall(tag)]
        assert name in names and len(set(names)) == len(names)
    tool = PinocchioFile(sketch.urdf).link("T_tool_").translation
    assert np.abs(tool - placed(sketch.points["T"])).max() < 1e-15


def test_an_angle_of_zero_needs_no_unit():
    bare, degrees, radians = (
        linkage_from_sketch(f"A=0,0; B=A+1@{angle}", "base=A; arm=A,B").points["B"]
        for angle in ("0", "0deg", "0rad")
    )
    assert bare == degrees == radians == 1.0
    turned = linkage_from_sketch("A=0,0; B=A+1@2rad", "base=A; arm=A,B").points["B"]
    assert abs(turned - cmath.rect(1.0, 2.0)) < 1e-15


def test_ranks_are_the_known_ones():
    """A kite has 7 conditions of 12, a general four-bar 8, see the files of the gallery."""
    kite = linkage_from_sketch(
        "A=0,0; B=0.2,0.15; C=0.4,0; D=0.2,-0.4", "crank=A,B; coupler=B,C; rocker=D,C"
    )
    assert balance.design_space(kite.linkage).rank == 7
    twins = linkage_from_sketch(
        "A=0,0; B=0.1,0.3; C=0.9,0.3; D=0.8,0", "crank=A,B; coupler=B,C; rocker=D,C"
    )
    gallery = balance.design_space("four_bar_general")
    general = balance.design_space(linkage_from_sketch(*FOUR_BAR).linkage)
    assert (general.rank, general.bodies) == (gallery.rank, gallery.bodies)
    # Of a parallelogram: the force has two conditions, the moment a constant and two harmonics.
    assert balance.design_space(twins.linkage).rank == 5


@pytest.mark.slow
def test_a_linkage_shakes_as_the_file_made_by_hand():
    """The same geometry with the same masses, on the same motions."""
    model = balance.load("four_bar_general")
    masses = [body.inertia for body in model.bodies]
    sketch = linkage_from_sketch(*FOUR_BAR)
    assert [body.name for body in sketch.linkage.bodies] == [b.name for b in model.bodies]
    first, second = (
        balance.verify(linkage, masses, trajectories=2, seed=4)
        for linkage in (model, sketch.linkage)
    )
    for part in ("force", "moment"):
        pair = [max(run.peak(part) for run in check.runs) for check in (first, second)]
        assert pair[0] > 1.0 and pair[1] == pytest.approx(pair[0], rel=1e-10)


@pytest.mark.parametrize(
    ("words", "kind", "problem"),
    [
        (("A=0,0; B=1", "a=A,B"), UsageError, "point 'B': '1' is not x,y or"),
        (("A=0,0; A=1,0", "a=A,B"), UsageError, "'A' is given twice"),
        (("A=0,0; B=K+1@0", "a=A,B"), UsageError, "point 'B': no point 'K'"),
        (("A=B+1@0; B=A+1@0", "a=A,B"), UsageError, "A needs B needs A|B needs A needs B"),
        (("A=0,0; B=A+1@60", "a=A,B"), UsageError, "'60' has no unit: write 60deg or 60rad"),
        (("A=0,0; B=A+1@-5", "a=A,B"), UsageError, "'-5' has no unit: write -5deg or -5rad"),
        ((*SLIDER[:2], "piston=C@1.5"), UsageError, "'1.5' has no unit"),
        (("A=0,0; B=A+1@inf", "a=A,B"), UsageError, "no point 'inf'"),
        (("A=0,0; B=A+1@-inf", "a=A,B"), UsageError, "'-inf' is no angle"),
        (("", "a=A,B"), UsageError, 'points: there are none: write "A=0,0'),
        (({}, "a=A,B"), UsageError, "points: there are none: write"),
        (([(0, 0), (1, 0)], "a=A,B"), UsageError, "points: write .*; this is of type list"),
        (("A=0,0; B=1,0", ["A,B"]), UsageError, "links: write .*; this is of type list"),
        (({"": "0,0"}, "a=A,B"), UsageError, "points: '0,0' has no name"),
        (("A=0,0; B=1kg,0", "a=A,B"), UsageError, "'kg' is a unit of mass"),
        (("A=0,0; B=nan,0", "a=A,B"), UsageError, "is no length"),
        (("A=0,0; B=1,0; C=A:0.3,B:0.2", "a=A,B"), SynthesisError, "add up to 500 mm.*500 mm"),
        (
            ("A=0,0; B=1,0; C=A:0.3,B:0.1", "a=A,B"),
            SynthesisError,
            "1000 mm apart.* lengthen them by 600 mm in all",
        ),
        (
            ("A=0,0; B=0,0; C=A:1,B:1", "a=A,C; b=C,B"),
            SynthesisError,
            "points A and B are at one place: two distances from it give no point",
        ),
        (
            ("A=0,0; B=1,0; C=A:3,B:1", "a=A,B"),
            SynthesisError,
            "differ by 2000 mm.*1000 mm less",
        ),
        (
            ("A=0,0; B=0,1; C=B:0.5,A@0", "a=A,B"),
            SynthesisError,
            "passes B at 1000 mm; add 500",
        ),
        (("A=0,0; B=A:1,A:2", "a=A,B"), UsageError, "both distances are from A"),
        (("A=0,0; B=A:-1,A:1", "a=A,B"), UsageError, "a distance is a positive length"),
        (("A=0,0; 1B=1,0", "a=A,B"), UsageError, "'1B' is no name"),
        (("A=0,0; B=1,0", "a=A"), UsageError, "link 'a' has one point"),
        (("A=0,0; B=1,0", "a=A,B,A"), UsageError, "a point is named twice"),
        (("A=0,0; B=1,0", "a=A,b"), UsageError, r"no point 'b' \(did you mean 'B'"),
        (("A=0,0; B=1,0", "A,B"), UsageError, "'A,B' has no name: write"),
        (("A=0,0; B=0,0", "base=A; a=A,B"), SynthesisError, "points A and B are at one place"),
        (("A=0,0; B=1,0; C=1,1", "a=A,B; b=B,C; c=C,A"), SynthesisError, "base=A,B among"),
        (
            ("A=0,0; B=1,0; C=1,1; D=2,1", "base=A; a=A,B; b=C,D"),
            SynthesisError,
            "'b' hangs on",
        ),
        (("A=0,0; B=1,0; C=1,1", "base=C; a=A,B"), UsageError, "'C' of the base is on no link"),
        (("A=0,0; B=1,0; C=2,1", "a=A,B; b=B,C"), LinkageError, "base has A, C, the points of"),
        ((FLAT, "a=A,B; b=B,C; c=D,C"), SynthesisError, "2 modes of motion meet in the pose"),
        (("A=0,0; B=1,0", "base=A"), UsageError, "none that moves"),
        ((*SLIDER[:2], "rod=C@0"), UsageError, "slider 'rod' is a link too"),
        ((*SLIDER[:2], "block=C"), UsageError, "write POINT@ANGLE"),
        ((*SLIDER[:2], "block=C@K"), UsageError, "no point 'K'"),
        ((SLIDER[0], "base=O; a=O,A", "block=O@0"), UsageError, "point O is on the base, too"),
    ],
)
def test_what_is_wrong_is_told(words, kind, problem):
    with pytest.raises(kind, match=problem) as caught:
        linkage_from_sketch(*words)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"section": "30mm"}, "'30mm' is not WIDTHxTHICKNESS"),
        ({"section": "0x1"}, "sizes are positive"),
        ({"section": "d"}, "section 'd'"),
        ({"section": "crnak=d1cm"}, r"no link 'crnak' \(did you mean 'crank'"),
        ({"section": "1x1,2x2"}, "section: a value for all links is given twice"),
        ({"section": "rod=d1cm,rod=d2cm"}, "section: 'rod' is given twice"),
        ({"section": "30x10mm"}, "'30x10mm': one size has no unit: give both one, as in 30mmx"),
        ({"section": "crank=30mmx10"}, "'30mmx10': one size has no unit"),
        ({"section": {"crank": 3}}, "section: '3' is no text"),
        ({"density": None}, "density: write .*; this is of type NoneType"),
        ({"density": "wood"}, "is no material"),
        ({"density": -1.0}, "density '-1.0' is not between 0 and 1e12 kg/m³"),
        ({"mass": "0.5"}, "mass: '0.5' has no name: write \"piston=0.5"),
        ({"mass": 0.5}, 'mass: write "piston=0.5.*; this is of type float'),
        ({"mass": "rod=0"}, "mass '0' is not between 0 and 1e12 kg"),
        ({"mass": "crank=1e13"}, "mass '1e13' is not between 0 and 1e12 kg"),
        ({"mass": {"piston": "1m"}}, "'m' is a unit of length"),
    ],
)
def test_matter_that_is_wrong_is_told(options, problem):
    with pytest.raises(UsageError, match=problem):
        linkage_from_sketch(*SLIDER, **options)


def test_points_and_links_may_be_python_objects():
    sketch = linkage_from_sketch(
        {"A": (0, 0), "B": "0,300mm", "C": (0.4, 0.5), "D": (0.6, 0.0)},
        {"base": ["A", "D"], "crank": "A,B", "coupler": ("B", "C"), "rocker": "C,D"},
        section={"crank": "d1cm"},
        density=2700,
        mass={"rocker": "200g"},
        name="mine",
    )
    assert [link.mass is None for link in sketch.links] == [False, True, False]
    assert [notice.code for notice in sketch.notices] == ["massless"]
    assert balance.load(sketch.urdf.decode()).name == "mine"


def test_links_without_a_density_are_of_steel():
    sketch = linkage_from_sketch(*SLIDER, section="10mmx10mm", density="rod=titanium")
    masses = {link.name: link.mass for link in sketch.links}
    assert masses["crank"] == pytest.approx(7850.0 * 0.05 * 1e-4, rel=1e-9)
    assert masses["rod"] == pytest.approx(4430.0 * 0.18 * 1e-4, rel=1e-9)


def test_a_slider_may_stand_alone():
    """It has its freedom; a link may have the name of a point."""
    sketch = linkage_from_sketch("A=0,0; B=1,0; C=2,1", "base=A; A=A,B", "block=C@B")
    assert sketch.linkage.mobility == 2 and sketch.linkage.inputs == ("A", "block_slide")
