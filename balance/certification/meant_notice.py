"""The notice on a special geometry that the digits of a file mean, or just miss."""

from __future__ import annotations

from dataclasses import replace

from balance.certification.certified_space import CertifiedSpace
from balance.exact.chain import exact_chain
from balance.exact.modular_ranks import ranks_of
from balance.spaces.design_space import DesignSpace
from balance.tolerances import DISTANCE_ROUND_OFF, MENDED_RELATIVE, MENDED_ROUND_OFF
from kinematics.errors import ExactError
from kinematics.linalg.rational import Vector
from kinematics.meant.digits import rounding_of_file
from kinematics.model.chain import extent
from kinematics.model.linkage import Notice
from kinematics.urdf.rational_screws import Geometry, exact_geometry, geometry_of
from kinematics.wording import count_noun, size_text

__all__ = ["add_meant_notice", "add_mending_doubt", "decimals_have_rank"]


def add_meant_notice(space: CertifiedSpace) -> CertifiedSpace:
    """State both answers where a special geometry lies inside the digits of a file, or near.

    Args:
        space: the certified space.

    Returns:
        The space, with a notice ``special_as_meant`` or ``near_special`` if the linkage as
        written, or the special one, has another rank.
    """
    meant = space.linkage.meant
    if meant is None or not meant.digits or not (meant.relations or meant.near):
        return space
    notices = []
    away = f"{meant.distance:.0e} of the size away"
    if meant.distance <= DISTANCE_ROUND_OFF:
        away = f"below {DISTANCE_ROUND_OFF:.0e} of the size away"
    if meant.relations and not space.doubts:
        other = _rank_as_written(space)
        if other != space.rank:
            written = "loops that do not close" if other is None else _conditions(other)
            text = (
                f"as written ({meant.digits} digits): {written}; the nearest special geometry "
                f"({', '.join(meant.relations)}) is {away}, below the digits of the file: "
                f"{space.rank} are meant (--as-written for the other)"
            )
            notices.append(Notice("special_as_meant", text))
    if meant.near is not None and not space.doubts:
        other = _rank_of(space, meant.near)
        if other is not None and other != space.rank:
            text = (
                f"as written ({meant.digits} digits): {_conditions(space.rank)}; a special "
                f"geometry ({', '.join(meant.near_relations)}) with {_conditions(other)} is "
                f"{away}, {meant.nearness:.1f} times what the digits of the file leave open: "
                "the answer is that of the linkage as written; if the other is meant, write "
                "its numbers with more digits"
            )
            notices.append(Notice("near_special", text))
    return replace(space, notices=(*space.notices, *notices)) if notices else space


def _conditions(rank: int) -> str:
    return count_noun(rank, "condition")


def add_mending_doubt(space: CertifiedSpace) -> CertifiedSpace:
    """Doubt a mobility for which axes were moved by more than the digits leave open.

    Args:
        space: the certified space.

    Returns:
        The space, with the level ``estimated`` and a doubt if they were.
    """
    linkage = space.linkage
    if not linkage.mended or linkage.tree is None:
        return space
    known = rounding_of_file(linkage.tree, max(extent(linkage).length, 1e-300))
    if linkage.mended <= max(MENDED_RELATIVE * known, MENDED_ROUND_OFF):
        return space
    doubt = (
        f"mobility: as written the loops do not move; axes and welds were moved by "
        f"{linkage.mended:.0e} (radians, parts of the size of the linkage), the digits of the "
        f"file leave {size_text(known, '.0e')} open"
    )
    certainty = space.certainty._replace(
        level="estimated", reason=doubt, doubts=(*space.doubts, doubt), proof=None, orders=()
    )
    return replace(space, certainty=certainty)


def decimals_have_rank(space: DesignSpace, rank: int) -> bool:
    """Whether loops close exactly in the decimals of the file, with a rank that is expected.

    Then the numbers are design values, and no condition comes from their rounding.

    Args:
        space: a design space.
        rank: the rank.
    """
    try:
        geometry = exact_geometry(space.linkage)
        return not geometry.notices and _rank(space, geometry) == rank
    except ExactError:
        return False


def _rank_as_written(space: CertifiedSpace) -> int | None:
    """Compute the rank of the decimals, or of the loops closed without relations."""
    assert space.linkage.meant is not None
    try:
        return _rank(space, exact_geometry(space.linkage))
    except ExactError:
        return _rank_of(space, space.linkage.meant.plain)


def _rank_of(space: CertifiedSpace, screws: tuple[Vector, ...]) -> int | None:
    """Compute the rank with other screws of the joints; None if the loops do not close."""
    try:
        return _rank(space, geometry_of(space.linkage, screws))
    except ExactError:
        return None


def _rank(space: DesignSpace, geometry: Geometry) -> int:
    """Compute the rank of a geometry; raise an `ExactError` if its loops do not close."""
    linkage = space.linkage
    chain = exact_chain(
        linkage, geometry, space.motion, space.balance == "force", not space.planar
    )
    return ranks_of(linkage.source, chain, (), space.highest_order).rank
