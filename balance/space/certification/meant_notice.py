"""The notice on a special geometry that the digits of a file mean, or just miss."""

from __future__ import annotations

from dataclasses import replace

from balance.space.certification.certified_space import CertifiedSpace, with_readings
from balance.space.certification.exact_ranks import rank_of_geometry
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.readings import Reading, deciding_digits
from balance.support.tolerances import MENDED_RELATIVE, MENDED_ROUND_OFF
from kinematics.errors import ExactError, InexactClosureError, InexactPlaneError
from kinematics.files.urdf.rational_screws import exact_geometry, geometry_of
from kinematics.loading.meant.digits import rounding_of_file
from kinematics.model.chain import extent
from kinematics.model.linkage import Notice
from kinematics.numerics.linalg.rational import Vector
from kinematics.wording import count_noun, size_text


def add_meant_notice(space: CertifiedSpace) -> CertifiedSpace:
    """State both answers where a special geometry lies inside the digits of a file, or near.

    Returns:
        The space, with a notice ``special_as_meant`` or ``near_special`` if the linkage as
        written, or the special one, has another rank.
    """
    meant = space.linkage.meant
    if meant is None or not meant.digits or not (meant.relations or meant.near):
        return space
    notices, readings = [], []
    deciding = deciding_digits(meant.digits, meant.nearness)
    if meant.relations and not space.doubts:
        other, instead = _rank_as_written(space)
        if other != space.rank:
            reading = Reading(
                "as_meant",
                meant.relations,
                meant.digits,
                None if meant.near else deciding,
                other,
                space.rank,
                meant.distance,
                meant.nearness,
                instead,
            )
            decided = f"; {reading.deciding_text}" if reading.deciding_text else ""
            text = (
                f"as written ({meant.digits} digits): {reading.written_text}; the nearest "
                f"special geometry ({', '.join(meant.relations)}) is {reading.away}, below the "
                f"digits of the file: {space.rank} are meant (--as-written for the other)"
                f"{decided}"
            )
            notices.append(Notice("special_as_meant", text))
            readings.append(reading)
    if meant.near is not None and not (space.doubts and space.linkage.loops):
        other, _ = _rank_of(space, meant.near)
        if other is not None and other != space.rank:
            reading = Reading(
                "as_written",
                meant.near_relations,
                meant.digits,
                deciding,
                space.rank,
                other,
                meant.distance,
                meant.nearness,
            )
            few = meant.nearness < 100.0
            times = f"{meant.nearness:.1f} times" if few else "more than a hundred times"
            written = reading.deciding_text or "write its numbers with more digits"
            relations = ", ".join(meant.near_relations)
            conditions = count_noun(other, "condition")
            text = (
                f"as written ({meant.digits} digits): {reading.written_text}; a special "
                f"geometry ({relations}) with {conditions} is {reading.away}, {times} what the "
                "digits of the file leave open, off on purpose or by rounding: the answer is "
                f"that of the linkage as written; {written}"
            )
            notices.append(Notice("near_special", text))
            readings.append(reading)
    return with_readings(space, notices, readings)


def add_mending_doubt(space: CertifiedSpace) -> CertifiedSpace:
    """Doubt a mobility that rests on axes near others with which the loops move otherwise.

    Returns:
        The space, with the level ``estimated`` and a doubt if axes were moved by more than the
        digits leave open, or if moving them a little would free joints at rest.
    """
    linkage = space.linkage
    for notice in linkage.notices:
        if notice.code == "nearly_movable":
            doubt = f"mobility: {notice.message}"
            space = replace(space, certainty=space.certainty.with_doubt(doubt))
    if not linkage.mended or linkage.tree is None:
        return space
    rounding = rounding_of_file(linkage.tree, max(extent(linkage).length, 1e-300))
    if linkage.mended <= max(MENDED_RELATIVE * rounding, MENDED_ROUND_OFF):
        return space
    doubt = (
        f"mobility: as written the loops do not move; axes and welds were moved by "
        f"{linkage.mended:.0e} (radians, parts of the size of the linkage), the digits of the "
        f"file leave {size_text(rounding, '.0e')} open"
    )
    return replace(space, certainty=space.certainty.with_doubt(doubt))


def decimals_have_rank(space: DesignSpace, rank: int) -> bool:
    """Whether loops close exactly in the decimals of the file, with a rank that is expected.

    Then the numbers are design values, and no condition comes from their rounding.
    """
    try:
        geometry = exact_geometry(space.linkage)
        return not geometry.notices and rank_of_geometry(space, geometry) == rank
    except ExactError:
        return False


def _rank_as_written(space: CertifiedSpace) -> tuple[int | None, str]:
    """Compute the rank of the decimals, or of the loops closed with the relations of these.

    Returns:
        The rank, or None and what the linkage has as written in place of it.
    """
    assert space.linkage.meant is not None
    try:
        return rank_of_geometry(space, exact_geometry(space.linkage)), ""
    except ExactError:
        return _rank_of(space, space.linkage.meant.plain)


def _rank_of(space: CertifiedSpace, screws: tuple[Vector, ...]) -> tuple[int | None, str]:
    """Compute the rank with other screws of the joints; see `_rank_as_written`."""
    try:
        return rank_of_geometry(space, geometry_of(space.linkage, screws)), ""
    except InexactPlaneError:
        return None, "axes that leave the plane"
    except InexactClosureError:
        return None, "loops that do not close"
    except ExactError:
        return None, "conditions that exact arithmetic does not count"
