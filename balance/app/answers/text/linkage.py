"""Facts on the linkage that an answer is about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from kinematics.model.linkage import Linkage
from kinematics.wording import first_names, number_text


def linkage_facts(
    linkage: Linkage,
    words: str,
    relations: Sequence[str] = (),
    more: Sequence[tuple[str, str]] = (),
) -> list[tuple[str, str]]:
    """List a linkage, its pose if that is not the one of its file, and relations of its inputs.

    Args:
        words: what stands beside its name.
        relations: of the displacements of its inputs.
        more: facts before the pose.
    """
    pose = [("pose", linkage.pose)] if linkage.at else []
    motion = [("motion", ", ".join(relations))] if relations else []
    return [("linkage", f"{linkage.name}, {words}"), *more, *pose, *motion]


def amplitude_text(linkage: Linkage, amplitude: Mapping[str, float]) -> str:
    """Write how far inputs move, by name, in radians or metres."""
    sliding = linkage.sliding
    return first_names(
        [
            f"{name} {number_text(size, '.3g')} {'m' if name in sliding else 'rad'}"
            for name, size in amplitude.items()
        ]
    )
