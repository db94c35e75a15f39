"""Facts on the linkage that an answer is about."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath

from kinematics.model.linkage import Linkage


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


def linkage_names(linkages: Sequence[Linkage]) -> list[str]:
    """Return the name of each linkage, with its file if there are several."""
    if len(linkages) == 1:
        return [linkages[0].name]
    files = [PurePath(linkage.source).parts for linkage in linkages]
    longest = max(map(len, files))
    # Use as many folders as distinguish the files.
    tails = ([PurePath(*file[-k:]).as_posix() for file in files] for k in range(1, longest + 1))
    apart = next((tail for tail in tails if len({*tail}) == len(tail)), None)
    labels = apart or [file[-1] for file in files]
    return [f"{linkage.name} ({file})" for linkage, file in zip(linkages, labels, strict=True)]
