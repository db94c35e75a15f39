"""A linkage at another reference pose than that of its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kinematics.closure.assembly.assemble import assemble_mode
from kinematics.closure.assembly.close_loops import close_loops
from kinematics.closure.assembly.repair_axes import repair_component
from kinematics.closure.assembly.rereference import rereference
from kinematics.closure.joint_positions import joint_positions
from kinematics.error_text import closest_names
from kinematics.errors import CoordinateError, MobilityError, OpenLoopError, PoseError
from kinematics.model.chain import arrange_loops
from kinematics.model.full_turns import position_text, wrap_turns
from kinematics.model.linkage import Linkage, Notice, UnassembledLinkage, names_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import GIVEN_POSE_RESIDUAL


def assemble_at(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None,
    at: Mapping[str, float],
    *,
    exactly: bool = False,
    mode: int | None = None,
) -> Linkage:
    """Assemble a linkage at another pose, which becomes its reference pose.

    Positions of inputs fix the pose. If only inputs are named, the other joints follow along
    the straight line of input displacements from the reference pose, without a change of
    branch. Positions of further joints are starting values, from which the loops are closed
    anew at the nearest pose: they choose the branch. A pose that closes the loops stays as it
    is given. So does a regular one near a singular pose; only where the loops have another
    mobility to first order is the reference pose one further on, as a notice says.

    Args:
        draft: the linkage as its file describes it.
        inputs: as for `kinematics.closure.assembly.assemble.assemble`.
        at: positions of joints, counted from the pose of the file, in radians and metres.
            Inputs that are not named stay where they are if the file closes its loops, or if
            only inputs are named.
        exactly: as for `kinematics.closure.assembly.assemble.assemble`.
        mode: number of a mode of motion, where several meet at the pose of the file, or else
            at the pose asked for; positions count from the pose of the file.

    Returns:
        The linkage at that pose; whatever it holds refers to it. A notice names joints that
        are elsewhere than their starting values.

    Raises:
        CoordinateError: a joint does not exist, or an input cannot drive the linkage there; or
            one is no input, on a mode at the pose of the file.
        PoseError: the loops cannot be closed at that pose, or not all the way to it.
        MobilityError: modes of motion meet there, and none is asked for.
        OpenLoopError: the loops do not close.
    """
    names = names_of(draft.joints)
    for name in at:
        if name not in names:
            problem = f"no such joint; the closest are {closest_names(name, names)}"
            raise CoordinateError(draft.source, [name], problem, names)
    try:
        linkage, single = assemble_mode(draft, inputs, mode, exactly=exactly, optional=True)
    except (OpenLoopError, MobilityError) as error:
        named = draft.named_inputs if inputs is None else tuple(inputs)
        mode_refused = mode is not None and isinstance(error, MobilityError)
        if mode_refused or all(name in named for name in at):
            raise
        return _close_near(draft, _Request(at, exactly, inputs, mode), named)
    chosen = None if inputs is None else linkage.inputs
    request = _Request(at, exactly, chosen, mode if single else None)
    if all(name in linkage.inputs for name in at):
        return _follow(linkage, request)
    if not single:
        others = [name for name in at if name not in linkage.inputs]
        problem = "on a mode that is chosen by its number, positions of inputs set the pose"
        raise CoordinateError(draft.source, others, problem, linkage.inputs)
    marked = replace(draft, named_inputs=linkage.inputs)
    return _close_near(marked, request, linkage.inputs)


class _Request(NamedTuple):
    """A pose that is asked for; attributes as the arguments of `assemble_at`."""

    at: Mapping[str, float]
    exactly: bool
    inputs: Sequence[str] | None
    mode: int | None


def _follow(linkage: Linkage, request: _Request) -> Linkage:
    """Move a linkage along the straight line to given positions of inputs."""
    at = request.at
    inputs, before = linkage.inputs, linkage.displaced
    here = dict.fromkeys(inputs, 0.0)
    if before is not None:
        here = dict(zip(inputs, before[linkage.positions_of(inputs)].tolist(), strict=True))
    q = joint_positions(linkage, {name: value - here[name] for name, value in at.items()})
    chain = arrange_loops(linkage)
    moved = rereference(replace(linkage, named_inputs=inputs), chain, q / chain.units)
    there, single = assemble_mode(
        moved, request.inputs, request.mode, exactly=request.exactly, stay=True
    )
    # Both assemblies may have made the same notices.
    there = replace(there, notices=tuple(dict.fromkeys(there.notices)), other_poses=())
    if not single:
        return there
    return replace(there, at=_input_positions(there, {**here, **at}))


def _close_near(
    draft: UnassembledLinkage,
    request: _Request,
    coordinates: Sequence[str],
) -> Linkage:
    """Close the loops of a linkage near given positions of some joints, and assemble it.

    Args:
        draft: the linkage as its file describes it.
        coordinates: joints whose given positions are kept.
    """
    at = request.at
    place = {joint.name: j for j, joint in enumerate(draft.joints)}
    chain, start = arrange_loops(draft), np.zeros(len(draft.joints))
    start[[place[name] for name in at]] = list(at.values())
    closed = all(np.array_equal(loop.gap, np.eye(4)) for loop in draft.loops)
    held = {place[x] for x in coordinates if x in at or closed}
    preferred = {place[name] for name in at} - held
    for mimic in draft.mimics:  # sources come before the joints that follow them, or after
        start[mimic.joint] = mimic.ratio * start[mimic.source]
        held |= {mimic.joint} if mimic.source in held else set()
    begun = rereference(draft, chain, start / chain.units, closed=False)
    try:
        there = close_loops(
            begun,
            None if request.exactly else repair_component,
            frozenset(held),
            frozenset(preferred),
        )
    except OpenLoopError as error:
        fixed = ", ".join(f"{x}={at.get(x, 0.0):.4g}" for x in coordinates if place[x] in held)
        raise PoseError(
            f"{draft.source}: the loops do not close at {fixed or 'any pose nearby'}; give "
            "other positions"
        ) from error
    linkage, single = assemble_mode(
        there, request.inputs, request.mode, exactly=request.exactly, stay=True
    )
    q = np.zeros(len(start)) if linkage.displaced is None else linkage.displaced
    pose = _input_positions(linkage, at)
    notices = [n for n in linkage.notices if n.code != "assembled"]
    if not single:
        return replace(linkage, notices=tuple(notices), other_poses=())
    notices += _moved_notices(linkage, q, {k: v for k, v in at.items() if place[k] not in held})
    return replace(linkage, at=pose, notices=tuple(notices), other_poses=())


def _input_positions(linkage: Linkage, asked: Mapping[str, float]) -> dict[str, float]:
    """Positions of the inputs at the reference pose: those asked for, if they are taken."""
    q = np.zeros(len(linkage.joints)) if linkage.displaced is None else linkage.displaced
    positions = dict(zip(names_of(linkage.joints), q.tolist(), strict=True))
    return {
        name: float(asked[name])
        if abs(asked.get(name, np.inf) - positions[name]) <= GIVEN_POSE_RESIDUAL
        else positions[name]
        for name in linkage.inputs
    }


def _moved_notices(linkage: Linkage, q: Array, at: Mapping[str, float]) -> list[Notice]:
    """Make a notice of joints that are elsewhere than their starting values."""
    texts = []
    for joint, position in zip(linkage.joints, q.tolist(), strict=True):
        by, _ = wrap_turns([joint], [position - at.get(joint.name, position)])
        if abs(by[0]) > GIVEN_POSE_RESIDUAL:
            text = f"'{joint.name}' is at {position_text(joint, round(position, 9), 6)}"
            texts.append(f"{text}, {position_text(joint, by[0])} from its starting value")
    if not texts:
        return []
    how = "positions of joints that are no inputs are starting values only: "
    return [Notice("starting_values", how + ", ".join(texts))]
