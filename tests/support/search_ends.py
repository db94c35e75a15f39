"""Ends of the walks of a search, for tests that need no file of results."""

from __future__ import annotations

from balance.studies.discovery.job import geometry_of_text


def special_ends(rows):
    """List number, geometry, nullity, codimension and margin of walks to special geometries."""
    return [
        (
            k,
            geometry_of_text(rows["geometry"][k]),
            int(rows["nullity"][k]),
            int(rows["codimension"][k]),
            float(rows["margin"][k]),
        )
        for k, outcome in enumerate(rows["outcome"])
        if outcome == "special"
    ]
