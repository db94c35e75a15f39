"""Choice of the joints that serve as independent coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinematics.errors import CoordinateError
from kinematics.model.linkage import GROUND, Joint, Notice, UnassembledLinkage, names_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.vectors import project_out
from kinematics.numerics.tolerances import REMAINING_FREEDOM, STANDSTILL_RELATIVE, TIE_RELATIVE


def choose_coordinates(
    draft: UnassembledLinkage, velocities: Array, wanted: Sequence[str]
) -> tuple[IntArray, list[Notice]]:
    """Choose independent joints: the wanted ones, completed by well-conditioned ones.

    Args:
        velocities: joint rates that close the loops: orthonormal columns (n, mobility).
        wanted: names of joints, or of joints of several coordinates.

    Returns:
        Positions of the joints among all, and notices for the user.

    Raises:
        CoordinateError: a name is unknown, or its joint depends on those before it.
    """
    mobility = velocities.shape[1]
    all_names = names_of(draft.joints)
    projected = velocities.copy()
    chosen: list[int] = []
    for name in _expand_names(wanted, draft.joints):
        if name not in all_names or all_names.index(name) in chosen:
            problem = "named twice" if name in all_names else "no such joint"
            raise CoordinateError(draft.source, [name], problem, all_names)
        j = all_names.index(name)
        if problem := _input_problem(j, velocities, projected, [all_names[i] for i in chosen]):
            can = [all_names[i] for i in _candidate_inputs(draft, projected) or chosen]
            raise CoordinateError(draft.source, [name], problem, can)
        projected = _project_joint_out(projected, j)
        chosen.append(j)
    named = len(chosen)
    while len(chosen) < mobility:
        j = _candidate_inputs(draft, projected)[0]
        projected = _project_joint_out(projected, j)
        chosen.append(j)
    notices = []
    if named and named < mobility:
        added = ", ".join(all_names[j] for j in chosen[named:])
        text = f"{named} inputs named, mobility {mobility}: completed with passive {added}"
        if not draft.loops:
            text += "; without loops: was one forgotten?"
        notices.append(Notice("inputs_completed", text))
    if not named:
        chosen.sort()
    return np.array(chosen, dtype=np.int64), notices


def _input_problem(joint: int, velocities: Array, rest: Array, taken: Sequence[str]) -> str:
    """Explain why a joint cannot be the next input; empty if it can."""
    rate, rest_rate = (float(np.linalg.norm(v[joint])) for v in (velocities, rest))
    fastest = float(np.linalg.norm(velocities, axis=1).max())
    if rate <= STANDSTILL_RELATIVE * fastest:
        return (
            "stands still, to first order, at the reference pose: a dead centre, if it moves "
            "at all, where it cannot drive the linkage"
        )
    if rest_rate > max(REMAINING_FREEDOM, STANDSTILL_RELATIVE * rate):
        return ""
    if len(taken) == velocities.shape[1]:
        return f"depends on the other inputs: {', '.join(taken)} take up mobility {len(taken)}"
    return f"depends on the other inputs ({', '.join(taken)}) at the reference pose"


def _expand_names(wanted: Sequence[str], joints: Sequence[Joint]) -> list[str]:
    """List names of coordinates; a joint of several coordinates gives all of them."""
    names: list[str] = []
    for name in wanted:
        names += [joint.name for joint in joints if joint.whole == name] or [name]
    return names


def _candidate_inputs(draft: UnassembledLinkage, rest: Array) -> list[int]:
    """List the joints that can be the next coordinate, the preferred one first.

    Any joint whose remaining freedom is at least a third of the largest is well enough
    conditioned; joints with actuators come before others, joints on the ground before those
    between moving links, joints of the tree before those of loops, earlier ones before later.
    """
    sizes = np.linalg.norm(rest, axis=1)
    least = (1.0 - TIE_RELATIVE) * sizes.max(initial=0.0) / 3.0
    good = np.flatnonzero(sizes >= max(least, REMAINING_FREEDOM))
    driven, grounded = _actuated(draft), _on_ground(draft)
    joints = draft.joints
    return sorted(
        good.tolist(),
        key=lambda j: (joints[j].whole not in driven, j not in grounded, joints[j].in_loop, j),
    )


def _on_ground(draft: UnassembledLinkage) -> set[int]:
    """Find the joints of one coordinate between the ground and a link that moves."""
    parents = {j for j, joint in enumerate(draft.joints) if joint.parent == GROUND}
    ends = {loop.end for loop in draft.loops if loop.successor == GROUND}
    return {j for j in parents | ends if not draft.joints[j].numbered} - {GROUND}


def _actuated(draft: UnassembledLinkage) -> set[str]:
    """Find the names of the joints for which the file has a ``<transmission>``."""
    if draft.tree is None:
        return set()
    return {
        joint.name for item in draft.tree.every("transmission") for joint in item.every("joint")
    }


def _project_joint_out(rest: Array, joint: int) -> Array:
    """Project the direction that moves ``joint`` out of the velocities."""
    return project_out(rest.T, rest[joint] / np.linalg.norm(rest[joint])).T
