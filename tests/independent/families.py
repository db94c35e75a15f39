"""Random linkages: what a family and a seed stand for."""

from __future__ import annotations

import zlib
from dataclasses import replace
from fractions import Fraction

import numpy as np

from tests.independent import planar_families as planar
from tests.independent import spatial_families as spatial
from tests.independent.plain_linkage import Linkage, edges
from tests.independent.true_ranks import independent

FAMILIES = {
    "grid": planar.grid,
    "single": planar.single,
    "small_loop": planar.small_loop,
    "mimic": planar.mimic,
    "embedded": spatial.embedded,
    "overconstrained": spatial.overconstrained,
    "tilted_loop": spatial.tilted_loop,
    "tilted_arm": spatial.tilted_arm,
    "general": spatial.general,
}
# Planar by nature: ten parameters per body are asked for now and then, not always.
PLANAR = ("grid", "single", "small_loop", "mimic")
# With a link or two without mass at times.
BARE = ("grid",)
# Read with rounded axes put right half of the time.
NOMINAL = ("grid", "single", "small_loop", "mimic", "general", "overconstrained")


def linkage(family: str, seed: int) -> Linkage:
    """The linkage that a family and a seed stand for, and what is asked about it."""
    rng = np.random.default_rng([seed, zlib.crc32(family.encode())])
    joints, mimics = FAMILIES[family](rng)
    found = Linkage(
        joints,
        mimics,
        force=bool(rng.random() < 0.2),
        spatial=family not in PLANAR or bool(rng.random() < 0.1),
        as_written=family not in NOMINAL or bool(rng.random() < 0.5),
    )
    restrict = rng.random() < 0.35
    names = [edge.name for edge in edges(found) if "." not in edge.name]
    last = tuple(str(x) for x in rng.permutation(names))
    free, closed = independent(found, last)
    if family in BARE and rng.random() < 0.15:
        some = rng.choice(found.links, 1 + int(rng.random() < 0.3), replace=False)
        found = replace(found, bare=tuple(int(x) + 1 for x in some))
    if not restrict or not closed or any("." in name for name in free) or len(free) < 2:
        return found
    return _restricted(rng, found, free)


def _restricted(rng, found: Linkage, free: tuple[str, ...]) -> Linkage:
    """The linkage with named inputs, and relations that leave at least one of them free."""
    screws = {edge.name: edge.screw for edge in edges(found)}
    squares = {
        name: sum(x * x for x in s[:3]) or sum(x * x for x in s[3:])
        for name, s in screws.items()
    }
    rows = []
    for _ in range(int(rng.integers(0, len(free)))):
        row = [Fraction(0)] * len(free)
        a, b = rng.choice(len(free), 2, replace=False)
        row[a] = Fraction(1)
        if squares[free[a]] == squares[free[b]] == 1 and rng.random() < 0.8:
            row[b] = Fraction(int(rng.choice([-2, -1, 1, 2]))) / int(rng.integers(1, 3))
        rows.append(tuple(row))
    return replace(found, inputs=free, relations=tuple(dict.fromkeys(rows)))
