"""Bodies that loops without joints weld together."""

from __future__ import annotations

from dataclasses import replace

from kinematics.model.arrays import freeze
from kinematics.model.linkage import Notice, UnassembledLinkage


def merge_welded_bodies(draft: UnassembledLinkage) -> UnassembledLinkage:
    """Merge every two bodies that a loop without a joint welds together.

    A body that is welded to the ground is dropped. The loops must be closed. A notice names
    the bodies.
    """
    bodies, notices = list(draft.bodies), list(draft.notices)
    for loop in draft.loops:
        if draft.joints[loop.end].in_loop:
            continue
        pair = [body for body in bodies if body.link in (loop.end, loop.successor)]
        if not pair or (len(pair) == 1 and loop.successor >= 0):
            continue
        bodies = [body for body in bodies if body not in pair]
        joined = "the ground"
        if loop.successor >= 0:
            first, second = pair
            total = freeze(first.inertia + second.inertia)
            bodies.append(replace(first, inertia=total))
            bodies.sort(key=lambda body: body.link)
            joined, pair = first.name, [second]
        text = f"loop '{loop.name}' makes '{pair[0].name}' one body with {joined}"
        notices.append(Notice("welded", text))
    return replace(draft, bodies=tuple(bodies), notices=tuple(notices))
