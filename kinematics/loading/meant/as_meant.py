"""Read a linkage as it is meant: with the special geometry that lies inside its digits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.assembly.assemble import assemble_mode
from kinematics.errors import LinkageError
from kinematics.loading.meant.digits import EXACT, FileDigits, file_digits
from kinematics.loading.meant.exact_screws import exact_screws, find_figures
from kinematics.loading.meant.four_joint_loops import LinkRelation
from kinematics.loading.meant.link_widths import LinkWidths, link_widths
from kinematics.loading.meant.open_chains import Limits, snap_open_chain
from kinematics.model.arrays import freeze
from kinematics.model.chain import extent
from kinematics.model.linkage import Joint, Linkage, MeantGeometry, Notice
from kinematics.numerics.linalg.rational import Vector
from kinematics.numerics.tolerances import EXACT_SCREW_DIFFERENCE, MEANT_DIFFERENCE
from kinematics.wording import size_text

Array = NDArray[np.float64]

# Nearness, in half widths of the intervals, up to which a special geometry outside of them is
# named: it may be meant, or missed on purpose.
NEAR = 30.0
# The same for axes of open chains, in radians and parts of the size: six digits, with which
# exporters write absolute poses, from which relative ones get more digits.
NEAR_OPEN = 1e-5


def as_meant(linkage: Linkage, *, exactly: bool = False, again: bool = True) -> Linkage:
    """Move the axes of a linkage to the special geometry inside the digits of its file.

    Args:
        exactly: whether its numbers count as written: axes are made exactly parallel, or
            exactly meet, where they are up to round-off, and no more.
        again: whether to start again if the linkage assembles at another pose.

    Returns:
        The linkage, with ``meant`` where its loops are planar or spherical and its numbers are
        rounded; its axes are moved where a special geometry lies inside all intervals.
    """
    if linkage.tree is None:
        return linkage
    digits = file_digits(linkage.tree)
    if digits is None:
        # Numbers are exact, and so are the links; only another pose is rounded.
        if linkage.displaced is None:
            return linkage
        digits = EXACT
    widths = link_widths(linkage, digits)
    if not linkage.loops and not exactly:
        return _open_chain_as_meant(linkage, digits, widths, again)
    figures = find_figures(linkage, widths, NEAR)
    if not figures:
        return linkage
    plain, _ = exact_screws(linkage, widths, figures, -1.0)
    if exactly:
        written = MeantGeometry(plain, plain, None, (), (), digits.significant, 0.0, 0.0, True)
        return replace(linkage, meant=written) if _is_near(linkage, plain) else linkage
    screws, wider = plain, plain
    inside: list[LinkRelation] = []
    all_relations: list[LinkRelation] = []
    if any(figure.relations for figure in figures):
        screws, inside = exact_screws(linkage, widths, figures, 1.0)
        wider, all_relations = exact_screws(linkage, widths, figures, NEAR)
    near = [relation for relation in all_relations if relation not in inside]
    shown = near or inside
    meant = MeantGeometry(
        screws=screws,
        plain=plain,
        near=wider if near else None,
        relations=tuple(_words(linkage, relation) for relation in inside),
        near_relations=tuple(_words(linkage, relation) for relation in near),
        digits=min(digits.significant, 17),
        distance=max((relation.error for relation in shown), default=0.0),
        nearness=max((relation.nearness for relation in shown), default=0.0),
        in_decimals=all(relation.error == 0.0 for relation in inside),
        apart=len(linkage.joints) - len({j for x in inside for j in _joints_of(x)}),
    )
    return _with_screws(linkage, meant, again)


def _open_chain_as_meant(
    linkage: Linkage, digits: FileDigits, widths: LinkWidths, again: bool
) -> Linkage:
    """Move the axes of an open chain to the special geometry inside the digits."""
    size = max(extent(linkage).length, 1e-300)
    angle, place = widths.angle, widths.place
    inner = Limits(angle, place, angle, place, size)
    far = inner._replace(
        angle=max(NEAR * angle, NEAR_OPEN), place=max(NEAR * place, NEAR_OPEN * size)
    )
    screws, inside = snap_open_chain(linkage, inner)
    wider, all_relations = snap_open_chain(linkage, far)
    texts = {relation.text for relation in inside}
    near = [relation for relation in all_relations if relation.text not in texts]
    if not inside and not near:
        return linkage
    plain, _ = snap_open_chain(linkage, inner._replace(angle=0.0, place=0.0))
    shown = near or inside
    meant = MeantGeometry(
        screws=screws,
        plain=plain,
        near=wider if near else None,
        relations=tuple(x.text for x in inside),
        near_relations=tuple(x.text for x in near),
        digits=min(digits.significant, 17),
        distance=max(x.error for x in shown),
        nearness=max(x.nearness for x in shown),
        in_decimals=max((x.error for x in inside), default=0.0) <= MEANT_DIFFERENCE,
    )
    return _with_screws(linkage, meant, again)


def with_screws(linkage: Linkage, screws: tuple[Vector, ...]) -> Linkage:
    """Assemble a linkage again with other screws of its joints.

    Args:
        screws: screws (n, 6) of any length, near its own.

    Raises:
        LinkageError: it does not assemble with them.
    """
    joints = tuple(
        _move_joint(joint, _unit_screw(screw))
        for joint, screw in zip(linkage.joints, screws, strict=True)
    )
    draft = replace(linkage, joints=joints)
    again, _ = assemble_mode(
        draft, linkage.inputs, None, exactly=True, stay=linkage.at is not None
    )
    notices = tuple(
        notice for notice in dict.fromkeys(again.notices)
        if notice.code != "nearly_planar" or not again.planar
    )  # fmt: skip
    return replace(again, notices=notices)


def _with_screws(linkage: Linkage, meant: MeantGeometry, again: bool) -> Linkage:
    """Attach the meant geometry to a linkage, and move its axes where they differ from it."""
    if _is_near(linkage, meant.screws):
        return replace(linkage, meant=meant)
    if not linkage.loops:
        linkage = replace(linkage, notices=(*linkage.notices, _axes_notice(linkage, meant)))
    try:
        there = with_screws(linkage, meant.screws)
    except LinkageError:
        return linkage
    if _is_near(there, meant.screws, EXACT_SCREW_DIFFERENCE):
        return replace(there, meant=meant)
    # It left a singular pose: the geometry is that at the pose to which it went.
    return as_meant(there, again=False) if again else linkage


def _axes_notice(linkage: Linkage, meant: MeantGeometry) -> Notice:
    """State that axes of an open chain were moved to be parallel, perpendicular, or meet."""
    written = np.array([joint.screw for joint in linkage.joints])
    tilt = float(
        np.abs(np.array([_unit_screw(x) for x in meant.screws]) - written)[:, :3].max()
    )
    text = (
        f"axes that are parallel, perpendicular, or meet inside the {meant.digits} digits of "
        f"the file, and are tilted by {size_text(tilt, '.0e')} rad as written, are read so "
        "(--as-written for the other)"
    )
    return Notice("special_as_meant", text)


def _is_near(
    linkage: Linkage, screws: tuple[Vector, ...], limit: float = MEANT_DIFFERENCE
) -> bool:
    """Return whether screws are those of a linkage, up to a relative limit."""
    as_written = np.array([joint.screw for joint in linkage.joints])
    apart = float(np.abs(np.array([_unit_screw(screw) for screw in screws]) - as_written).max())
    return apart <= limit * max(1.0, float(np.abs(as_written).max()))


def _unit_screw(screw: Vector) -> Array:
    """Convert a rational screw to one of unit length."""
    n = screw[:3] if any(screw[:3]) else screw[3:]
    length = float(sum(x * x for x in n)) ** 0.5
    return np.array([float(x) for x in screw]) / length


def _move_joint(joint: Joint, screw: Array) -> Joint:
    """Give a joint another screw, and the nearest point of it."""
    point = joint.point
    if joint.kind != "prismatic":
        n = screw[:3]
        point = np.cross(n, screw[3:]) + (n @ point) * n
    return replace(joint, screw=freeze(screw), point=freeze(point))


def _words(linkage: Linkage, relation: LinkRelation) -> str:
    """Name a relation and its joints."""
    names = (linkage.joints[j].name for j in _joints_of(relation))
    return f"{relation.name} {' '.join(names)}"


def _joints_of(relation: LinkRelation) -> tuple[int, ...]:
    """Joints that a relation names."""
    return relation.pins if relation.slide < 0 else (*relation.pins, relation.slide)
