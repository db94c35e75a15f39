"""Build planar linkages from points and from the links that carry them.

Where k links share a point they have k - 1 revolute joints. A tree of joints grows from the
base, the nearest links first; the joints that are left close the loops. The frame of a link is
at the joint that carries it, with axes parallel to the inertial frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from balance.studies.sketches.joint_tree import place_frames, plan_joints
from balance.studies.sketches.link_matter import ByLink, LinkMatter, LinkSolid, read_matter
from balance.studies.sketches.points import DECIMALS, PointLike
from balance.studies.sketches.sketch import NamesLike, Sketch, read_sketch
from balance.studies.sketches.sketched_linkage import (
    BASE,
    SketchedJoint,
    SketchedLink,
    SketchedLinkage,
)
from kinematics.errors import MeetingModesError, MobilityError, SynthesisError
from kinematics.loading.building.assemble_elements import assemble_elements
from kinematics.loading.building.check_arguments import exact_differences
from kinematics.loading.model_gallery import load
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element, unused_name
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.wording import round_to_ten_digits


def linkage_from_sketch(
    points: str | Mapping[str, PointLike],
    links: str | Mapping[str, NamesLike],
    sliders: str | Mapping[str, str] = "",
    *,
    section: str | Mapping[str, str] = "",
    density: ByLink = "steel",
    mass: str | Mapping[str, float | str] = "",
    inputs: Sequence[str] | None = None,
    name: str = "linkage",
) -> SketchedLinkage:
    """Build a planar linkage from the points and links of a sketch.

    Points are coordinates ``x,y``, steps ``A+250mm@120deg`` or ``A+80mm@C`` (towards C), or
    have two distances, ``E=C:350mm,D:350mm``: on the left seen from C to D; or a distance and a
    line, ``C=A:180mm,O@0deg``: the farther one along it. Lengths are in metres or have a
    unit; angles other than 0 have one, deg or rad.

    A link has bars between its points: one between two points or along a line, else one along
    each side of the polygon in the order of the points. Bars end at the points, and matter that
    two bars of a link share counts twice. The link ``base`` does not move. Without it, the base
    has the points that one link alone has; give it where such a point is a tool point. A tool
    point gets a frame of its name. A slider is a block at its point, twice as long as wide.

    Args:
        points: ``"A=0,0; B=400mm,0; C=A+250mm@120deg"``, or points by name.
        links: ``"base=A,B; crank=A,C; …"``, or names of points by name of the link.
        sliders: ``"piston=C@0deg"``: bodies that slide on the base, each with its point and its
            direction, an angle from the x axis or a second point of the line.
        section: of bars, ``"30mmx10mm"`` in the plane and along z, or ``"d20mm"`` for rods;
            one for all links, with others by name after it, ``"30mmx10mm, crank=d20mm"``, or a
            mapping; without one, links have no ``<inertial>`` and no shape.
        density: kg/m³, a material, or one of them by link, and steel for the others.
        mass: ``"piston=0.5, crank=200g"``, kg, in place of that of section and density: the
            inertia is scaled; without a section, a link with a mass is a thin rod, a slider a
            point mass.
        inputs: names of joints; by default as many as the mobility, on the base first.
        name: of the robot.

    Returns:
        The linkage, its parts and its file; SI units, joints about z.

    Raises:
        UsageError: an argument is written wrongly, or names what is not there.
        SynthesisError: circles do not meet, points of a bar are at one place, there is no base,
            a link hangs on nothing, or modes of motion meet in the pose of the sketch.
        LinkageError: the linkage cannot move, or not with these inputs.

    Source:
        Inertias of solids: J. L. Meriam, L. G. Kraige, Engineering Mechanics: Dynamics,
        table D/4.

    Example:
        >>> from balance.studies import linkage_from_sketch
        >>> sketch = linkage_from_sketch(
        ...     "O=0,0; A=O+50mm@60deg; C=A:180mm,O@0deg",
        ...     "crank=O,A; rod=A,C",
        ...     "piston=C@0deg",
        ...     section="20mmx10mm",
        ... )
        >>> sketch.linkage.inputs, [joint.name for joint in sketch.joints]
        (('O',), ['O', 'A', 'piston_slide', 'C'])
        >>> sketch.to_urdf().count(b"<visual>")
        3
    """
    sketch = read_sketch(points, links, sliders)
    matter = read_matter(sketch.links, section, density, mass)
    joints = plan_joints(sketch)
    frames = place_frames(sketch, joints)
    solids = _build_solids(sketch, frames, matter)
    source = f"{name} (from a sketch)"
    try:
        robot = _make_robot(name, sketch, joints, frames, solids)
        with_inputs = assemble_elements(robot, source, inputs)
    except MeetingModesError as error:
        problem = f"{len(error.modes)} modes of motion meet in the pose of the sketch"
        raise SynthesisError(problem, "sketch it in another pose") from None
    except MobilityError as error:
        if sketch.base_by_rule:
            error.add_note(
                f"the base has {', '.join(sketch.base)}, the points of one link alone: where "
                "one of them is a tool point, write base=… among the links"
            )
        raise
    joints = [joint._replace(is_input=joint.name in with_inputs.inputs) for joint in joints]
    urdf = element_text(_make_robot(name, sketch, joints, frames, solids)).encode()
    linkage = load(Document(source, urdf))
    return SketchedLinkage(
        linkage=linkage,
        points=sketch.places,
        base=sketch.base,
        base_by_rule=sketch.base_by_rule,
        links=tuple(
            SketchedLink(
                link, names, _span(sketch, names), matter[link].words, solids[link].mass
            )
            for link, names in sketch.links.items()
        ),
        joints=tuple(joints),
        urdf=urdf,
        notices=tuple(dict.fromkeys((*linkage.notices, *with_inputs.notices))),
    )


def _build_solids(
    sketch: Sketch, frames: Mapping[str, complex], matter: Mapping[str, LinkMatter]
) -> dict[str, LinkSolid]:
    """Make the matter of the links, in their frames."""
    return {
        link: matter[link].build(
            [sketch.places[point] - frames[link] for point in names], sketch.sliders.get(link)
        )
        for link, names in sketch.links.items()
    }


def _make_robot(
    name: str,
    sketch: Sketch,
    joints: Sequence[SketchedJoint],
    frames: Mapping[str, complex],
    solids: Mapping[str, LinkSolid],
) -> Element:
    """Make the elements of the file."""
    parts = [make_elements.link(BASE)]
    parts += [Element("link", {"name": link}, each.elements) for link, each in solids.items()]
    parts += [_joint_element(joint, sketch, frames) for joint in joints]
    return make_elements.robot(name, [*parts, *_tool_frames(sketch, joints, frames)])


def _joint_element(
    joint: SketchedJoint, sketch: Sketch, frames: Mapping[str, complex]
) -> Element:
    """Make the ``<joint>`` or ``<loop>`` of a joint."""
    parent, child = (
        _origin(sketch.places[joint.point], frames[link])
        for link in (joint.parent, joint.child)
    )
    turns = "0 0 1", ""
    if joint.closes_loop:
        sides = [(joint.parent, parent), (joint.child, child)]
        return make_elements.loop(
            joint.name, joint.kind, sides, turns, independent=joint.is_input
        )
    axes, kind = turns, "continuous"
    if joint.kind == "prismatic":
        way = sketch.sliders[joint.child]
        line = [round(way.real, DECIMALS), round(way.imag, DECIMALS), 0.0]
        axes, kind = (number_words(line), ""), joint.kind
    return make_elements.joint(
        joint.name, kind, joint.parent, joint.child, parent, axes, independent=joint.is_input
    )


def _tool_frames(
    sketch: Sketch, joints: Sequence[SketchedJoint], frames: Mapping[str, complex]
) -> Iterator[Element]:
    """Yield a link at each tool point, and the joint that fixes it there."""
    links, names = set(frames), {joint.name for joint in joints}
    for link, point in sketch.tool_points:
        tool = unused_name(f"{point}_tool" if point in links else point, links)
        at = _origin(sketch.places[point], frames[link])
        yield make_elements.link(tool)
        yield make_elements.joint(unused_name(f"{point}_fixed", names), "fixed", link, tool, at)


def _origin(point: complex, frame: complex) -> Element:
    """Make the ``<origin>`` of a point, seen from the origin of a frame."""
    ends, starts = ([z.real, z.imag, 0.0] for z in (point, frame))
    return Element("origin", {"xyz": exact_differences(ends, starts)})


def _span(sketch: Sketch, names: Sequence[str]) -> float:
    """Compute the largest distance between two points; metres."""
    places = [sketch.places[name] for name in names]
    return round_to_ten_digits(max(abs(z - w) for z in places for w in places))
