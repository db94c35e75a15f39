"""Files of remedies: the linkage with each one that helps, and tables."""

from __future__ import annotations

from collections.abc import Iterable

from balance.remedies.applied import AppliedRemedy

__all__ = ["remedy_files"]


def remedy_files(results: Iterable[AppliedRemedy]) -> dict[str, bytes]:
    """Name the files of results, such as ``remedy_2.urdf`` and ``remedy_2_table.csv``.

    Args:
        results: results of remedies; those that do not help have no files.

    Returns:
        The contents by name.
    """
    found: dict[str, bytes] = {}
    counts: dict[str, int] = {}
    for one in results:
        if not one.helps:
            continue
        counts[one.remedy] = count = counts.get(one.remedy, 0) + 1
        stem = one.remedy if count == 1 else f"{one.remedy}_{count}"
        if one.urdf is not None:
            found[f"{stem}.urdf"] = one.urdf
        found |= {f"{stem}_{name}": data for name, data in one.files.items()}
    return found
