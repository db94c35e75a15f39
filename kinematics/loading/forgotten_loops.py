"""Ends of two chains at one place in a file without loops: a loop that was forgotten."""

from __future__ import annotations

from collections import defaultdict
from itertools import combinations

import numpy as np

from kinematics.error_text import clean
from kinematics.model.linkage import GROUND, Notice, UnassembledLinkage
from kinematics.numerics.tolerances import ENDS_MEET

# Fewest joints of the longer chain, from the link that carries both on: the fingers of a
# gripper have one each, and often one origin.
FEWEST = 2


def forgotten_loop(draft: UnassembledLinkage) -> list[Notice]:
    """Note two ends of chains with frames at one place, if the file has no loop.

    A mechanism with loops, exported without them, is a tree whose chains end where the loops
    would close.
    """
    if draft.loops:
        return []
    parents = [joint.parent for joint in draft.joints]
    ends = sorted(set(range(len(parents))) - set(parents))
    frames: dict[int, list[tuple[str, np.ndarray]]] = defaultdict(list)
    for name, place in draft.places.items():
        frames[place.link].append((name, place.pose[:3, 3]))
    origins = np.array([place.pose[:3, 3] for place in draft.places.values()])
    size = float(np.linalg.norm(np.ptp(origins, axis=0))) if len(origins) else 0.0
    for first, second in combinations(ends, 2):
        if max(_lengths(parents, first, second)) < FEWEST:
            continue
        for name, point in frames[first]:
            for other, there in frames[second]:
                if np.linalg.norm(point - there) <= ENDS_MEET * size:
                    return [_notice(name, other)]
    return []


def _lengths(parents: list[int], first: int, second: int) -> tuple[int, int]:
    """Count the joints from each of two links down to the link that carries both."""
    down = [_way_down(parents, link) for link in (first, second)]
    shared = set(down[0]) & set(down[1])
    return len(down[0]) - len(shared), len(down[1]) - len(shared)


def _way_down(parents: list[int], link: int) -> list[int]:
    """List the links from one down to the last above the ground."""
    way = []
    while link != GROUND:
        way.append(link)
        link = parents[link]
    return way


def _notice(name: str, other: str) -> Notice:
    text = (
        f"no loop: did you forget one? The links '{clean(name)}' and '{clean(other)}', at the "
        "ends of two chains, are at one place; if they are joined there, add a <loop> to the "
        "file, or a YAML file beside it (docs/files.md)"
    )
    return Notice("no_loop", text)
