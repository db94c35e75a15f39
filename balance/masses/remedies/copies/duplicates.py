"""Duplicates: copies of a linkage, driven in step with it, that cancel its momentum."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.copies.copy_elements import Copied, copy_linkage
from balance.masses.remedies.copies.symmetric_copies import (
    Copy,
    four_group,
    half_turn_in_plane,
    place_of,
    single_copies,
)
from balance.masses.remedies.judge import judge, verify_file
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from kinematics.errors import LinkageError
from kinematics.files.formats.robot_files import read_files
from kinematics.files.urdf.read_options import ReadOptions

_COUNTS = {1: "one copy", 3: "three copies"}


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


def _copy(request: RemedyRequest, copies: Sequence[Copy], driven: Sequence[str]) -> Copied:
    """Write the linkage with its copies."""
    file = read_files(request.base, None, ReadOptions(angles=request.angles))
    return copy_linkage(request.base, file.tree, copies, driven)


def _copied(
    request: RemedyRequest, copies: Sequence[Copy], driven: Sequence[str]
) -> AppliedRemedy:
    """Write copies with the masses of the file, and verify them."""
    made = _copy(request, copies, driven)
    words = f"{_COUNTS[len(copies)]}: {'; '.join(copy.words for copy in copies)}"
    blank = AppliedRemedy(
        "duplicates", words, "undecided", "", new_links=made.links, new_joints=made.joints,
        details=_details(copies, driven),
    )  # fmt: skip
    urdf = made.document.data
    return verify_file(request, blank, urdf, request.motion, request.linkage.inputs)


def _with_counterweights(
    request: RemedyRequest, copy: Copy, driven: Sequence[str]
) -> AppliedRemedy:
    """Judge one copy, with matter on its links and on those of the linkage."""
    made = _copy(request, [copy], driven)
    names = made.names[0]
    return judge(request, Variant(
        "duplicates", f"one copy, {copy.words}, and counterweights on both", made.document,
        free=(*request.links, *(names[link] for link in request.links)),
        regions={names[link]: region for link, region in request.regions.items()},
        massless=tuple(names[link] for link in request.massless),
        new_links=made.links, new_joints=made.joints, details=_details([copy], driven),
    ))  # fmt: skip


def _details(copies: Sequence[Copy], driven: Sequence[str]) -> dict[str, object]:
    """Describe copies as plain data."""
    return {
        "copies": [
            {
                "words": copy.words, "mirrored": copy.mirrored, "point": copy.point.tolist(),
                "rotation": copy.rotation.tolist(),
            }
            for copy in copies
        ],
        "driven": list(driven),
    }  # fmt: skip
