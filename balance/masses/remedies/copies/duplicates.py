"""Duplicates: copies of a linkage, driven in step with it, that cancel its momentum.

A turned copy is rigidly turned: its elements are those of the file, on a fixed joint to the
root. A mirrored copy is turned too, and inverted in the origin of its root frame: positions
``x → -x`` in every frame, so that rotations of frames, axes of turns (axial vectors) and
inertia tensors stay, and slides and pitches of screws (polar) change their sign. No number of
the file changes but by its sign. Meshes are not mirrored: mirrored links have no pictures.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.copies.symmetric_copies import (
    Copy,
    four_group,
    half_turn_in_plane,
    place_of,
    single_copies,
)
from balance.masses.remedies.judge_variant import judge_variant, verify_file
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant, append_elements, free_name
from kinematics.errors import LinkageError
from kinematics.files.formats.robot_files import read_files
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element

_COUNTS = {1: "one copy", 3: "three copies"}
_PICTURES = ("visual", "collision")
_SIDES = ("parent", "child", "predecessor", "successor")


def apply_duplicates(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by the fewest copies of it that are driven in step.

    One copy is tried where the momenta of the linkage allow it, else there are three, turned by
    π about perpendicular axes, which balance any linkage; see
    `balance.masses.remedies.copies.symmetric_copies`. The copies have the masses of the file.
    Their inputs mimic those of the linkage; their other joints follow by their loops and
    relations.

    For dynamic balance of a planar linkage that needs three copies, one copy turned by π about
    an axis in its plane cancels the moment, and counterweights on both cancel the force: this
    is the second result.

    Yields:
        One result, or two.
    """
    if request.space.as_given.balanced:
        yield refused("duplicates", "the linkage is balanced as it is: it needs no copy")
        return
    try:
        driven = _driven_joints(request)
        place = place_of(request.linkage)
        force = request.balance == "force"
        single = list(single_copies(request.linkage, request.motion, force, place))
    except LinkageError as error:
        yield refused("duplicates", str(error))
        return
    applied = None
    for copies in [*((copy,) for copy in single), four_group(place)]:
        applied = _copied(request, copies, driven)
        if applied.verdict != "undecided":
            break
    assert applied is not None
    yield applied
    if len(applied.details["copies"]) == 3 and request.linkage.planar:  # type: ignore[arg-type]
        yield _with_counterweights(request, half_turn_in_plane(place), driven)


def _driven_joints(request: RemedyRequest) -> tuple[str, ...]:
    """Find the joints of the tree, with one degree of freedom, that drive the linkage.

    An input that mimics another joint stands for the joint at the end of its relations.

    Raises:
        LinkageError: an input is no such joint.
    """
    linkage = request.linkage
    named = {joint.name: j for j, joint in enumerate(linkage.joints)}
    source = {mimic.joint: mimic.source for mimic in linkage.mimics}
    driven = []
    for name in linkage.inputs:
        j = named[name]
        while j in source:
            j = source[j]
        joint = linkage.joints[j]
        if joint.in_loop or joint.numbered:
            what = "closes a loop" if joint.in_loop else "has several degrees of freedom"
            raise LinkageError(
                f"{linkage.source}: input {name}: its joint {what}, and no relation of single "
                "joints drives that of a copy in step; name other inputs"
            )
        driven.append(joint.name)
    return tuple(driven)


def _copy(request: RemedyRequest, copies: Sequence[Copy], driven: Sequence[str]) -> _Copied:
    """Write the linkage with its copies."""
    file = read_files(request.base, None, ReadOptions(angles=request.angles))
    return _copy_linkage(request.base, file.tree, copies, driven)


def _copied(
    request: RemedyRequest, copies: Sequence[Copy], driven: Sequence[str]
) -> AppliedRemedy:
    """Write copies with the masses of the file, and verify them."""
    made = _copy(request, copies, driven)
    words = f"{_COUNTS[len(copies)]}: {'; '.join(copy.words for copy in copies)}"
    blank = AppliedRemedy(
        "duplicates",
        words,
        "undecided",
        "",
        new_links=made.links,
        new_joints=made.joints,
        details=_details(copies, driven),
    )
    urdf = made.document.data
    return verify_file(request, blank, urdf, request.motion, request.linkage.inputs)


def _with_counterweights(
    request: RemedyRequest, copy: Copy, driven: Sequence[str]
) -> AppliedRemedy:
    """Judge one copy, with matter on its links and on those of the linkage."""
    made = _copy(request, [copy], driven)
    names = made.names[0]
    return judge_variant(
        request,
        Variant(
            "duplicates",
            f"one copy, {copy.words}, and counterweights on both",
            made.document,
            free=(*request.links, *(names[link] for link in request.links)),
            regions={names[link]: region for link, region in request.regions.items()},
            massless=tuple(names[link] for link in request.massless),
            new_links=made.links,
            new_joints=made.joints,
            details=_details([copy], driven),
        ),
    )


def _details(copies: Sequence[Copy], driven: Sequence[str]) -> dict[str, object]:
    """Describe copies as plain data."""
    return {
        "copies": [
            {
                "words": copy.words,
                "mirrored": copy.mirrored,
                "point": copy.point.tolist(),
                "rotation": copy.rotation.tolist(),
            }
            for copy in copies
        ],
        "driven": list(driven),
    }


class _Copied(NamedTuple):
    """A linkage with copies of it.

    Attributes:
        document: its URDF file.
        names: the copied links, joints and loops of each copy, by their names in the linkage.
        links: all new links.
        joints: all new joints and loops.
    """

    document: Document
    names: tuple[Mapping[str, str], ...]
    links: tuple[str, ...]
    joints: tuple[str, ...]


def _copy_linkage(
    document: Document, robot: Element, copies: Sequence[Copy], driven: Iterable[str]
) -> _Copied:
    """Append copies of a linkage to its file, driven in step with it.

    Args:
        robot: its checked elements, loops in other words translated.
        copies: where the copies are.
        driven: joints that turn or slide the linkage: those of the copies mimic them.

    Returns:
        The new file.
    """
    items = [item for item in robot.children if item.tag in ("link", "joint", "loop")]
    taken = {item.name for item in items}
    sides = (child for joint in robot.every("joint") for child in joint.every("child"))
    carried = {child.attributes["link"] for child in sides}
    (root,) = (link.name for link in robot.every("link") if link.name not in carried)
    elements: list[Element] = []
    renamings: list[dict[str, str]] = []
    for number, copy in enumerate(copies, 1):
        suffix = "_copy" if len(copies) == 1 else f"_copy{number}"
        names = {}
        for item in items:
            names[item.name] = free_name(f"{item.name}{suffix}", taken)
            taken.add(names[item.name])
        mount = free_name(f"{names[root]}_mount", taken)
        taken.add(mount)
        at = make_elements.origin(copy.pose)
        elements += [
            make_elements.link(names[root]),
            make_elements.joint(mount, "fixed", root, names[root], at),
        ]
        writer = _Writer(names, frozenset(driven), copy.mirrored)
        elements += [writer.element(item) for item in items if item.name != root]
        renamings.append(names)
    return _Copied(
        append_elements(document, elements),
        tuple(renamings),
        tuple(item.name for item in elements if item.tag == "link"),
        tuple(item.name for item in elements if item.tag != "link"),
    )


class _Writer(NamedTuple):
    """The writer of one copy: names of its parts, driven joints, whether it is mirrored."""

    names: Mapping[str, str]
    driven: frozenset[str]
    mirrored: bool

    def element(self, item: Element) -> Element:
        """Copy a link, joint or loop."""
        attributes = {**item.attributes, "name": self.names[item.name]}
        attributes.pop("independent", None)
        slides = item.attributes.get("type") == "prismatic"
        children = [
            self.part(child, slides)
            for child in item.children
            if not (self.mirrored and child.tag in _PICTURES)
        ]
        if item.name in self.driven and item.tag == "joint":
            children = [child for child in children if child.tag != "mimic"]
            children.append(Element("mimic", {"joint": item.name, "multiplier": "1"}))
        return replace(item, attributes=attributes, children=tuple(children))

    def part(self, part: Element, slides: bool) -> Element:
        """Copy what is inside of a link, joint or loop, ``slides`` if it is prismatic."""
        attributes = dict(part.attributes)
        if part.tag in _SIDES:
            attributes["link"] = self.names[attributes["link"]]
        elif part.tag == "mimic":
            attributes["joint"] = self.names[attributes["joint"]]
        if self.mirrored:
            if part.tag == "origin" or (part.tag == "axis" and slides):
                attributes["xyz"] = _opposite(attributes.get("xyz", "0 0 0"))
            elif part.tag == "screw_thread_pitch":
                attributes["value"] = _opposite(attributes["value"])
        children = tuple(self.part(child, slides) for child in part.children)
        return replace(part, attributes=attributes, children=children)


def _opposite(text: str) -> str:
    """Change the signs of numbers in a text; all their decimals stay."""
    words = text.split()
    return " ".join(w[1:] if w[0] == "-" else f"-{w.removeprefix('+')}" for w in words)
