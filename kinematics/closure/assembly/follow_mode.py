"""A linkage on one of the modes of motion that leave its pose."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from kinematics.closure.assembly.singular_pose import ModeStart, ModeStarts, check_mobility
from kinematics.errors import CoordinateError, LinkageError, MeetingModesError, MobilityError
from kinematics.model.full_turns import wrap_turns
from kinematics.model.linkage import Linkage, Notice, UnassembledLinkage
from kinematics.model.mode_of_motion import ModeOfMotion
from kinematics.numerics.tolerances import NAMED_POSITION, UNMOVED_DISTANCE

# Makes the linkage at the pose of a draft, with named joints as coordinates.
Assemble = Callable[[UnassembledLinkage, Sequence[str]], Linkage]


def follow_mode(
    draft: UnassembledLinkage,
    modes: ModeStarts,
    inputs: Sequence[str] | None,
    mode: int | None,
    assemble: Assemble,
) -> Linkage:
    """Assemble a linkage on one of the modes that leave its pose.

    Args:
        draft: the linkage at that pose.
        modes: all of them, at least two.
        inputs: names of joints to use as coordinates; None for those of the file, or others
            where these cannot drive the linkage on the mode.
        mode: number of the mode, from 1.
        assemble: makes the linkage at the pose of a draft, with named joints as coordinates.

    Raises:
        MeetingModesError: no mode is asked for.
        MobilityError: there is none of that number, or the linkage cannot move on it.
        CoordinateError: an input cannot drive the linkage on it.
    """
    starts = modes.starts
    if mode is None:
        listed = [_describe(start, inputs, assemble, k) for k, start in enumerate(starts, 1)]
        raise MeetingModesError(
            draft.source, listed, _moving_joints(draft, starts), modes.doubt
        )
    if not 1 <= mode <= len(starts):
        raise unknown_mode_error(draft.source, len(starts))
    linkage = _assemble_on_mode(starts[mode - 1], inputs, assemble)
    text = f"the reference pose is on mode {mode} of {len(starts)}, away from where they meet"
    return replace(linkage, notices=(*linkage.notices, Notice("mode_of_motion", text)))


def unknown_mode_error(source: str, count: int) -> MobilityError:
    """Make the error for the number of a mode that does not exist.

    Args:
        source: name of the linkage.
        count: number of its modes.
    """
    there = "one mode of motion leaves" if count == 1 else f"{count} modes of motion leave"
    remedy = "leave out the number of a mode" if count == 1 else f"choose one from 1 to {count}"
    return MobilityError(f"{source}: {there} its pose; {remedy}")


def _assemble_on_mode(
    start: ModeStart, inputs: Sequence[str] | None, assemble: Assemble
) -> Linkage:
    """Assemble a linkage at a pose on a mode.

    Inputs that the file marks, and that do not drive the linkage on this mode, are replaced.
    """
    wanted = tuple(inputs) if inputs is not None else start.draft.named_inputs
    notices = []
    try:
        linkage = assemble(start.draft, wanted)
    except CoordinateError as error:
        if inputs is not None:
            raise
        linkage = assemble(start.draft, ())
        text = (
            f"{', '.join(error.names)} of the file cannot drive this mode: the inputs are "
            f"{', '.join(linkage.inputs)}"
        )
        notices = [Notice("inputs_of_mode", text)]
    check_mobility(linkage, start)
    assert linkage.displaced is not None
    positions = linkage.displaced[linkage.positions_of(linkage.inputs)]
    positions = np.where(np.abs(positions) > UNMOVED_DISTANCE, positions, 0.0)
    pose = dict(zip(linkage.inputs, positions.tolist(), strict=True))
    return replace(linkage, at=pose, notices=(*linkage.notices, *notices), other_poses=())


def _describe(
    start: ModeStart, inputs: Sequence[str] | None, assemble: Assemble, number: int
) -> ModeOfMotion:
    """Describe a mode by the pose on it."""
    q = start.draft.displaced
    assert q is not None
    within, _ = wrap_turns(start.draft.joints, q)
    positions = {
        joint.name: float(x)
        for joint, x in zip(start.draft.joints, within, strict=True)
        if not joint.in_loop and abs(x) > UNMOVED_DISTANCE
    }
    linkage: Linkage | LinkageError
    try:
        linkage = _assemble_on_mode(start, inputs, assemble)
    except LinkageError as error:
        linkage = error
    return ModeOfMotion(number, start.mobility, start.here, positions, linkage)


def _moving_joints(draft: UnassembledLinkage, starts: Sequence[ModeStart]) -> list[str]:
    """List the joints that move on one of the modes."""
    here = 0.0 if draft.displaced is None else draft.displaced
    q = np.array([start.draft.displaced for start in starts])
    moving = np.flatnonzero(np.any(np.abs(q - here) > NAMED_POSITION, axis=0))
    return [draft.joints[j].name for j in moving]
