"""Names of linkages that tell several of them apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath

from kinematics.model.linkage import Linkage


def linkage_title(linkage: Linkage) -> str:
    """Return the name of a linkage, with its file if that has another name."""
    file = PurePath(linkage.source)
    if not file.suffix or file.stem == linkage.name:
        return linkage.name
    return f"{linkage.name} ({file.name})"


def linkage_names(linkages: Sequence[Linkage]) -> list[str]:
    """Return the title of a linkage, and what tells several apart: file, or name and file."""
    if len(linkages) == 1:
        return [linkage_title(linkages[0])]
    files = [PurePath(linkage.source).parts for linkage in linkages]
    longest = max(map(len, files))
    # Use as many folders as distinguish the files.
    tails = ([PurePath(*file[-k:]).as_posix() for file in files] for k in range(1, longest + 1))
    apart = next((tail for tail in tails if len({*tail}) == len(tail)), None)
    if apart and len({linkage.name for linkage in linkages}) == 1:
        return apart
    labels = apart or [file[-1] for file in files]
    return [f"{linkage.name} ({file})" for linkage, file in zip(linkages, labels, strict=True)]
