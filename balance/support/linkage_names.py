"""Names of linkages that tell several of them apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath

from kinematics.model.linkage import Linkage


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
