"""Random requests for counterweights: linkages, links and regions that follow from a seed."""

from __future__ import annotations

import random
import re
from pathlib import Path

import balance
from tests.support.small_linkages import small_linkage


def random_request(seed: int, path: Path, balanced: str = "force"):
    """A space, links to add matter to, and texts of regions; all of them follow from a seed.

    Few linkages can be balanced dynamically: half of those requests are kites with matter in
    a large region of every link, whose geometry admits it.
    """
    rng = random.Random(seed)
    if balanced == "dynamic" and seed % 2:
        space = balance.design_space(str(kite(rng, path)), balance=balanced)
        return space, list(space.bodies), {n: random_region(rng, 4.0) for n in space.bodies}
    space = balance.design_space(str(small_linkage(rng, path)), balance=balanced)
    names = list(space.bodies)
    add = rng.sample(names, rng.randint(1, len(names)))
    return space, add, {name: random_region(rng) for name in add if rng.random() < 0.8}


def kite(rng: random.Random, path: Path) -> Path:
    """Write a kite with random masses; its joints are 0.5 and 1.5 by 0.25 m apart."""
    for _ in range(1000):
        small_linkage(rng, path)
        text = path.read_text("utf-8")
        if 'name="special"' in text and re.search(r'[" ]-?0\.25 0"', text):
            return path
    raise AssertionError("one of thirty linkages is a kite")


def random_region(rng: random.Random, scale: float = 1.0) -> str:
    """A region near the origin of the link: a ball, a box, a cylinder or an ellipsoid."""
    x, y, z = (round(rng.uniform(-0.6, 0.6), 3) for _ in range(3))
    a, b, c = (round(scale * rng.uniform(0.1, 0.8), 3) for _ in range(3))
    u, v, w = (round(rng.uniform(-1.0, 1.0), 3) for _ in range(3))
    return rng.choice(
        (
            f"ball({x},{y},{z},{a})",
            f"box({x - a}:{x + a},{y - b}:{y + b},{z - c}:{z + c})",
            f"cylinder({x},{y},{z},{u},{v},{w},{a},{b})",
            f"ellipsoid({x},{y},{z},{a},{b},{c},{u},{v},{w})",
        )
    )
