"""Files of remedies: the linkage with each one that helps, and tables."""

from __future__ import annotations

from collections.abc import Iterable

from balance.masses.remedies.applied import AppliedRemedy


def remedy_files(results: Iterable[AppliedRemedy]) -> dict[str, bytes]:
    """Name the files of results, such as ``remedy_2.urdf`` and ``remedy_2_table.csv``.

    Args:
        results: results of remedies; those that do not help have no files.

    Returns:
        The contents by name.
    """
    contents: dict[str, bytes] = {}
    counts: dict[str, int] = {}
    for applied in results:
        if not applied.helps:
            continue
        counts[applied.remedy] = count = counts.get(applied.remedy, 0) + 1
        stem = applied.remedy if count == 1 else f"{applied.remedy}_{count}"
        if applied.urdf is not None:
            contents[f"{stem}.urdf"] = applied.urdf
        contents |= {f"{stem}_{name}": data for name, data in applied.files.items()}
    return contents
