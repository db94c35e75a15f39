"""Assembly: close loops, decide the mobility, choose coordinates, find idle joints.

Mobility is decided at first order at the reference pose, by the rank of the loop matrix of
each component whose joints depend on one another, and then tested: along a generic
direction the series must close at every order computed, and a finite pose must exist there.
The same finite pose shows which joints are idle, because an analytic joint motion that
vanishes at a generic pose vanishes everywhere. Where the loop equations of a component are
clearly independent, and all its joints clearly move, that follows from the implicit function
theorem, and is not tested.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from kinematics.closure.assembly.close_loops import close_loops
from kinematics.closure.assembly.closed_component import open_loop_error
from kinematics.closure.assembly.generic_pose import generic_direction, is_near_singular
from kinematics.closure.assembly.repair_axes import (
    has_near_zero_singular_values,
    repair_axes,
    repair_component,
)
from kinematics.closure.mobility.components import (
    Component,
    component_freedoms,
    split_components,
)
from kinematics.closure.mobility.independent_coordinates import choose_coordinates
from kinematics.closure.mobility.regular_as_written import regular_loop_ranks
from kinematics.closure.newton import Pose
from kinematics.errors import CoordinateError, MobilityError, MotionError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import arrange_loops, move_chain
from kinematics.model.linkage import Linkage, Notice, UnassembledLinkage
from kinematics.model.motion import Motion
from kinematics.model.plane import plane_normal, reduce_to_plane
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.tolerances import (
    AXIS_ROUNDING,
    CLEAR_MOTION_RELATIVE,
    IDLE_JOINT_RELATIVE,
    NEAR_SINGULAR_CONDITIONING,
)
from kinematics.wording import count_noun


def assemble(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None = None,
    *,
    exactly: bool = False,
    mode: int | None = None,
) -> Linkage:
    """Close the loops of a linkage and choose its independent coordinates.

    Args:
        draft: the linkage as its file describes it.
        inputs: names of joints to use as coordinates, instead of those that the file marks
            or, where neither does, of well-conditioned ones. Fewer than the mobility are
            completed with passive joints; a notice names these.
        exactly: whether axes count as written, even where overconstrained loops close with
            them only to rounding; otherwise they are moved until the loops close.
        mode: number of a mode of motion, from 1, where several meet at the pose of the
            linkage. The reference pose is one on that mode.

    Returns:
        The linkage at its reference pose, with loops closed.

    Raises:
        OpenLoopError: a loop does not close, or numbers overflow on the way, so that a
            decomposition of a matrix does not converge.
        MobilityError: nothing can move, or it moves only infinitesimally, or several modes of
            motion meet at its pose; `MeetingModesError` lists them.
        CoordinateError: an input is unknown or depends on the others.
    """
    return assemble_mode(draft, inputs, mode, exactly=exactly)[0]


def assemble_mode(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None,
    mode: int | None,
    *,
    exactly: bool = False,
    optional: bool = False,
    stay: bool = False,
) -> tuple[Linkage, bool]:
    """Close the loops of a linkage, and follow a mode if several meet at its pose.

    Args:
        draft: as for `assemble`; so are the others.
        inputs: names of joints to use as coordinates.
        mode: number of the mode.
        exactly: whether axes count as written.
        optional: whether any number is taken where a single mode leaves the pose.
        stay: whether a regular pose near a singular one is kept, because it was asked for.

    Returns:
        The linkage, and whether a single mode leaves its pose.

    Raises:
        LinkageError: as for `assemble`.
    """
    try:
        linkage, single = _assemble(draft, inputs, exactly, mode, stay and mode is None)
    except np.linalg.LinAlgError:
        raise open_loop_error(draft, "", 1) from None
    if single and mode not in (None, 1) and not optional:
        from kinematics.closure.assembly.follow_mode import unknown_mode_error

        raise unknown_mode_error(linkage.source, 1)
    return linkage, single


def _assemble(
    draft: UnassembledLinkage,
    inputs: Sequence[str] | None,
    exactly: bool,
    mode: int | None,
    stay: bool,
) -> tuple[Linkage, bool]:
    """Close the loops of a linkage and choose its coordinates; see `assemble_mode`."""
    draft = _merge_welded_bodies(close_loops(draft, None if exactly else repair_component))
    wanted = tuple(inputs) if inputs is not None else draft.named_inputs
    repaired: UnassembledLinkage | str = ""
    try:
        linkage, rounded, near = _assemble_at_pose(draft, wanted)
    except (CoordinateError, MobilityError) as error:
        problem: CoordinateError | MobilityError | None = error
        repaired = repair_axes(draft) if not exactly else ""
    else:
        if not rounded and (stay or not near):
            return (linkage if exactly else _with_notice_on_rest(linkage)), True
        problem = None
        repaired = repair_axes(draft) if rounded and not exactly else ""
    if not isinstance(repaired, str):
        return _assemble_at_pose(repaired, wanted)[0], True
    # Linkages at regular poses need neither of these modules.
    from kinematics.closure.assembly.follow_mode import follow_mode
    from kinematics.closure.assembly.singular_pose import check_mobility, leave_singular_pose

    modes = leave_singular_pose(draft)
    if len(modes.starts) > 1:
        return follow_mode(draft, modes, inputs, mode, _linkage_at_pose), False
    if modes.starts:
        (start,) = modes.starts
        return check_mobility(_assemble_at_pose(start.draft, wanted)[0], start), True
    if problem is None:
        return (linkage if exactly else _with_notice_on_rest(linkage)), True
    if repaired:
        raise MobilityError(f"{draft.source}: its loops do not close: {repaired}") from None
    raise problem


def _with_notice_on_rest(linkage: Linkage) -> Linkage:
    """Add notices on joints at rest that would move if axes were moved a little."""
    if not linkage.idle or not linkage.loops:
        return linkage
    from kinematics.closure.assembly.nearly_movable import note_nearly_movable

    notices = note_nearly_movable(linkage)
    return replace(linkage, notices=(*linkage.notices, *notices)) if notices else linkage


def _linkage_at_pose(draft: UnassembledLinkage, wanted: Sequence[str]) -> Linkage:
    """Make the linkage at the pose of a draft."""
    return _assemble_at_pose(draft, wanted)[0]


def _assemble_at_pose(
    draft: UnassembledLinkage, wanted: Sequence[str]
) -> tuple[Linkage, bool, bool]:
    """Make the linkage at the pose of a draft.

    Returns:
        The linkage, whether its axes look rounded, and whether a singular pose is near.
    """
    chain = arrange_loops(draft)
    parts = split_components(draft, whole=chain)
    free, spectra = component_freedoms(parts, len(draft.joints))
    ranks: list[int | None] = [None] * len(parts)
    normal = plane_normal(chain)
    planar = normal is not None
    if not planar:
        ranks = regular_loop_ranks(draft, parts, spectra)
        free, spectra = component_freedoms(parts, len(draft.joints), ranks)
    mobility = free.shape[1]
    if mobility == 0:
        raise MobilityError(
            f"{draft.source}: the linkage is rigid: its loops leave no joint free to move; "
            "check the axes of the joints along them"
        )
    independent, notices = choose_coordinates(draft, free, wanted)
    chain = move_chain(chain, independent, np.eye(mobility))
    clear = [
        _is_clear(part.chain, values, free[part.joints], 3 if planar else 6)
        for part, values in zip(parts, spectra, strict=True)
    ]
    idle, poses = _find_idle_joints(draft, chain, parts, clear)
    near = any(
        pose is not None and is_near_singular(part.with_columns(chain), values, pose)
        for part, values, pose, rank in zip(parts, spectra, poses, ranks, strict=True)
        if rank is None
    )
    spatial, flat = reduce_to_plane(chain, idle, normal)
    notices += _note_nearly_planar(flat)
    notices += _note_small_singular_values(mobility, spectra, ranks)
    linkage = Linkage(
        **{
            f.name: getattr(draft, f.name)
            for f in fields(UnassembledLinkage)
            if f.name != "notices"
        },
        notices=(*draft.notices, *notices),
        mobility=mobility,
        inputs=tuple(draft.joints[j].name for j in independent),
        idle=tuple(draft.joints[j].name for j in np.flatnonzero(idle)),
        frames=freeze(np.reshape([body.frame for body in draft.bodies], (-1, 4, 4))),
        chain=flat,
        spatial_chain=spatial,
    )
    rounded = any(
        has_near_zero_singular_values(values, flat.planar)
        for values, rank in zip(spectra, ranks, strict=True)
        if rank is None
    )
    return linkage, rounded, near


def moving_chain(
    linkage: Linkage,
    motion: Motion | None = None,
    spatial: bool = False,
    *,
    idle: Flags | None = None,
) -> Chain:
    """Make the arrays of a linkage under a motion, without the joints that it leaves idle.

    Args:
        motion: subspace of the inputs, the whole space by default.
        spatial: whether to keep all components of a planar linkage.
        idle: which joints are idle (n,), if that is known; otherwise those that do not move
            up to a finite pose.

    Returns:
        The chain, in its own frame and units.

    Raises:
        MotionError: the motion is not one of this linkage's inputs.
        MobilityError: the linkage cannot follow it.
    """
    if motion is None and idle is None:
        return linkage.spatial_chain if spatial else linkage.chain
    motion = Motion.free(linkage.inputs) if motion is None else motion
    if problem := _motion_problem(linkage, motion):
        text = ", ".join(motion.relations)
        raise MotionError(text, problem, linkage.inputs, linkage.source)
    # Where no joint is idle, the arrays of the linkage have all of them.
    whole = linkage.spatial_chain.joints.size == len(linkage.joints)
    full = linkage.spatial_chain if whole else arrange_loops(linkage)
    independent = linkage.positions_of(motion.inputs)
    scaled = np.linalg.qr(motion.basis / full.units[independent, None])[0]
    moved = move_chain(full, independent, scaled)
    if idle is None:
        parts = split_components(linkage, whole=full)
        idle, _ = _find_idle_joints(linkage, moved, parts, [False] * len(parts))
    reduced, flat = reduce_to_plane(moved, idle)
    return reduced if spatial else flat


def _motion_problem(linkage: Linkage, motion: Motion) -> str:
    """Explain why a motion does not fit the linkage; empty if it does."""
    if sorted(motion.inputs) != sorted(linkage.inputs):
        return f"made for the inputs {', '.join(motion.inputs)}"
    basis = np.asarray(motion.basis, dtype=np.float64)
    if basis.ndim != 2 or len(basis) != len(motion.inputs) or not np.isfinite(basis).all():
        return f"its basis must be {len(motion.inputs)} rows of finite numbers"
    if basis.shape[1] == 0 or np.linalg.matrix_rank(basis) < basis.shape[1]:
        return "the columns of its basis must be independent"
    return ""


def _note_nearly_planar(chain: Chain) -> list[Notice]:
    """Make a notice if the linkage would be planar without the rounding of its axes."""
    if chain.planar or plane_normal(chain, AXIS_ROUNDING) is None:
        return []
    text = (
        f"the axes are parallel to within {AXIS_ROUNDING:.0e} rad, but not exactly, so the "
        "linkage is taken as spatial; write angles such as π/2 with 16 digits if it is meant "
        "to be planar"
    )
    return [Notice("nearly_planar", text)]


def _note_small_singular_values(
    mobility: int, spectra: Sequence[Array], ranks: Sequence[int | None]
) -> list[Notice]:
    """Make a notice if loops that are regular as written were not, had axes been rounded.

    Args:
        mobility: degrees of freedom as written.
        spectra: singular values of the loop matrix of each component (n,).
        ranks: its rank, if it is regular as written and has small singular values.
    """
    small = sum(
        rank - int(np.sum(values > AXIS_ROUNDING * values.max()))
        for values, rank in zip(spectra, ranks, strict=True)
        if rank is not None
    )
    if not small:
        return []
    here, fewer = count_noun(mobility, "degree"), count_noun(small, "constraint")
    text = (
        f"as written the loops close and leave {here} of freedom, which is the answer; if axes "
        f"were rounded by up to {AXIS_ROUNDING:.0e}, so that {fewer} fewer are left, there are "
        f"{mobility + small}: write axes that are meant to be parallel, or to meet, with the "
        "same digits"
    )
    return [Notice("nearly_special", text)]


def _is_clear(chain: Chain, values: Array, free: Array, dim: int) -> bool:
    """Return whether loops are clearly independent at a pose, and all joints clearly move.

    Args:
        chain: arrays of a component.
        values: singular values of its loop matrix (n,), descending.
        free: joint rates that close its loops (n, freedom).
        dim: equations of a loop, 3 in the plane.
    """
    rank = dim * len(chain.ends) + len(chain.mimics)
    if not 0 < rank < values.size or values[rank - 1] < NEAR_SINGULAR_CONDITIONING * values[0]:
        return False
    rates = np.sqrt(np.sum(free * free, axis=1))
    return bool(rates.min() > CLEAR_MOTION_RELATIVE * rates.max())


def _find_idle_joints(
    draft: UnassembledLinkage, chain: Chain, parts: Sequence[Component], clear: Sequence[bool]
) -> tuple[Flags, list[Pose | None]]:
    """Find the joints that do not move up to a generic pose, and so in no motion.

    Args:
        chain: its arrays, with a motion.
        parts: its components; see `kinematics.closure.mobility.components`.
        clear: whether each is known to move with all its joints.

    Returns:
        Whether each joint is idle (n,), and a generic pose of each part, None if no joint of
        it moves or that is known.

    Raises:
        MobilityError: closure fails at a higher order or at a finite pose.
    """
    still: Flags = np.all(chain.columns == 0.0, axis=1)
    poses: list[Pose | None] = []
    for part, known in zip(parts, clear, strict=True):
        if known:
            still[part.joints] = False
            poses.append(None)
            continue
        local = part.with_columns(chain)
        pose = _find_generic_pose(draft, part, local) if local.width else None
        poses.append(pose)
        if pose is not None:
            still[part.joints] = np.abs(pose.q) <= IDLE_JOINT_RELATIVE * np.abs(pose.q).max()
    return still, poses


def _find_generic_pose(draft: UnassembledLinkage, part: Component, chain: Chain) -> Pose:
    """Find a finite pose of a component in a generic direction of the chain's columns.

    Raises:
        MobilityError: closure fails at a higher order or at a finite pose.
    """
    order, pose = generic_direction(chain)
    if pose is None:
        moving = part.joints[np.any(chain.columns != 0.0, axis=1)]
        raise MobilityError(
            f"{draft.source}: its loops do not close at order {order} of a motion of "
            f"{', '.join(draft.joints[j].name for j in moving)}; choose another motion",
            order=order,
        )
    return pose


def _merge_welded_bodies(draft: UnassembledLinkage) -> UnassembledLinkage:
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
