"""From a draft to a linkage: loops closed, mobility known, coordinates chosen.

Mobility is decided at first order at the reference pose, by the rank of the loop matrix,
and then put to the test: along a generic direction the series must close at every order
computed, and a finite pose must exist there. The same finite pose tells which joints are
idle, because an analytic joint motion that vanishes at a generic pose vanishes everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from kinematics import closing, placement
from kinematics.chain import arrange, move, plane_normal, reduce
from kinematics.closure import expand, loop_matrix
from kinematics.errors import CoordinateError, MobilityError, MotionError
from kinematics.linkage import Chain, Draft, Linkage, Notice, frozen, names
from kinematics.motion import Motion

__all__ = ["assemble", "moving_chain"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# First-order closure: singular values of the loop matrix, and rows of its null space, below
# this part of the largest are zero. Geometry in files is given to about 1e-12.
DEPENDENT = 1e-8
# Axes that deviate by less from those of a planar linkage (radians) were probably rounded.
NEARLY = 1e-4
# Closure to round-off, at series orders and at finite poses.
CLOSED = 1e-9


def assemble(draft: Draft, inputs: Sequence[str] | None = None) -> Linkage:
    """Close the loops of a draft and choose its independent coordinates.

    Args:
        draft: the linkage as its file describes it.
        inputs: names of joints to use as coordinates, instead of those that the file marks
            or, where neither does, of well-conditioned ones. Fewer than the mobility are
            completed with passive joints; a notice says which.

    Raises:
        OpenLoopError: a loop does not close.
        MobilityError: nothing can move, or it moves only infinitesimally.
        CoordinateError: an input is unknown or depends on the others.
    """
    draft = closing.welded(closing.closed(draft))
    chain = arrange(draft)
    velocities = _velocities(draft, chain)
    wanted = tuple(inputs) if inputs is not None else draft.named_inputs
    independent, notices = _coordinates(draft, chain, velocities, wanted)
    chain = move(chain, independent, np.eye(len(independent)))
    spatial, flat, idle = _reduced(draft, chain)
    notices += _nearly_planar(flat)
    return Linkage(
        **{f.name: getattr(draft, f.name) for f in fields(Draft) if f.name != "notices"},
        notices=(*draft.notices, *notices),
        mobility=len(independent),
        inputs=tuple(draft.joints[j].name for j in independent),
        idle=tuple(draft.joints[j].name for j in idle),
        frames=frozen(np.reshape([body.frame for body in draft.bodies], (-1, 4, 4))),
        chain=flat,
        spatial_chain=spatial,
    )


def moving_chain(
    linkage: Linkage, motion: Motion | None = None, spatial: bool = False
) -> Chain:
    """The arrays of a linkage under a motion, without the joints that it leaves idle.

    Args:
        linkage: an assembled linkage.
        motion: subspace of the inputs, the whole space by default.
        spatial: whether to keep all components of a planar linkage.

    Raises:
        MotionError: the motion is not one of this linkage's inputs.
        MobilityError: the linkage cannot follow it.
    """
    if motion is None:
        return linkage.spatial_chain if spatial else linkage.chain
    if problem := _unfit(linkage, motion):
        text = ", ".join(motion.relations)
        raise MotionError(text, problem, linkage.inputs, linkage.source)
    full = arrange(linkage)
    independent = linkage.positions_of(motion.inputs)
    scaled = np.linalg.qr(motion.basis / full.units[independent, None])[0]
    reduced, flat, _ = _reduced(linkage, move(full, independent, scaled))
    return reduced if spatial else flat


def _unfit(linkage: Linkage, motion: Motion) -> str:
    """Why a motion does not fit the linkage; empty if it does."""
    if sorted(motion.inputs) != sorted(linkage.inputs):
        return f"made for the inputs {', '.join(motion.inputs)}"
    basis = np.asarray(motion.basis, dtype=np.float64)
    if basis.ndim != 2 or len(basis) != len(motion.inputs) or not np.isfinite(basis).all():
        return f"its basis must be {len(motion.inputs)} rows of finite numbers"
    if basis.shape[1] == 0 or np.linalg.matrix_rank(basis) < basis.shape[1]:
        return "the columns of its basis must be independent"
    return ""


def _stuck(draft: Draft, chain: Chain, order: int) -> MobilityError:
    """The error for a pose with more freedom at first order than the loops really leave.

    If poses nearby have less, the pose of the file is singular; otherwise, or if there are
    none, the linkage cannot move.
    """
    here = _freedom(loop_matrix(chain)).shape[1]
    for q in closing.neighbours(chain):
        there = _freedom(loop_matrix(chain, placement.forward(chain, q).screws)).shape[1]
        if 0 < there < here:
            positions = ", ".join(
                f"{joint.name}={value:.3g}"
                for joint, value in zip(draft.joints, q * chain.units, strict=True)
                if not joint.in_loop and abs(value) > 1e-3
            )
            return MobilityError(
                f"{draft.source}: singular at the pose of the file: {here} degrees of freedom "
                f"there, {there} at other poses; write the file at another pose, such as "
                f"{positions}"
            )
    return MobilityError(
        f"{draft.source}: the linkage moves only infinitesimally: its loops do not close at "
        f"order {order}; it is rigid: check the origins and axes along its loops"
    )


def _freedom(A: Array) -> Array:
    """Orthonormal joint rates that a loop matrix (rows, n) leaves free; (n, freedom)."""
    if not len(A):
        return np.eye(A.shape[1])
    _, values, Vt = np.linalg.svd(A)
    return Vt[int(np.sum(values > DEPENDENT * values.max(initial=0.0))) :].T


def _velocities(draft: Draft, chain: Chain) -> Array:
    """Joint rates that close the loops at first order: orthonormal columns (n, mobility)."""
    free = _freedom(loop_matrix(chain))
    if free.shape[1] == 0:
        raise MobilityError(
            f"{draft.source}: the linkage is rigid: its loops leave no joint free to move; "
            "check the axes of the joints along them"
        )
    return free


def _coordinates(
    draft: Draft, chain: Chain, velocities: Array, wanted: Sequence[str]
) -> tuple[IntArray, list[Notice]]:
    """Independent joints: the wanted ones, completed by well-conditioned ones."""
    mobility = velocities.shape[1]
    all_names = names(draft.joints)
    rest = velocities.copy()
    chosen: list[int] = []
    for name in _expanded(wanted, all_names):
        if name not in all_names or all_names.index(name) in chosen:
            problem = "named twice" if name in all_names else "no such joint"
            raise CoordinateError(draft.source, [name], problem, all_names)
        j = all_names.index(name)
        size = float(np.linalg.norm(rest[j]))
        if size <= DEPENDENT * max(1.0, float(np.linalg.norm(velocities[j]))):
            can = [all_names[i] for i in _candidates(draft, rest) or chosen]
            problem = "depends on the other inputs, or cannot move, at the reference pose"
            if len(chosen) == mobility:
                taken = ", ".join(all_names[i] for i in chosen)
                problem = f"depends on the other inputs: {taken} take up mobility {mobility}"
            raise CoordinateError(draft.source, [name], problem, can)
        rest = _without(rest, j)
        chosen.append(j)
    named = len(chosen)
    while len(chosen) < mobility:
        j = _candidates(draft, rest)[0]
        rest = _without(rest, j)
        chosen.append(j)
    notices = []
    if named and named < mobility:
        added = ", ".join(all_names[j] for j in chosen[named:])
        text = f"{named} inputs named, mobility {mobility}: completed with passive {added}"
        notices.append(Notice("inputs_completed", text))
    if not named:
        chosen.sort()
    return np.array(chosen, dtype=np.int64), notices


def _expanded(wanted: Sequence[str], all_names: Sequence[str]) -> list[str]:
    """Names of coordinates; the name of a joint of several stands for all of them."""
    found: list[str] = []
    for name in wanted:
        parts = [n for n in all_names if n.rpartition(".")[0] == name]
        found += parts if parts and name not in all_names else [name]
    return found


def _candidates(draft: Draft, rest: Array) -> list[int]:
    """Joints that would serve as the next coordinate, the preferred one first.

    Any joint whose remaining freedom is at least a third of the largest is well enough
    conditioned; joints of the tree come before those of loops, earlier ones before later.
    """
    sizes = np.linalg.norm(rest, axis=1)
    good = np.flatnonzero(sizes >= max(sizes.max(initial=0.0) / 3.0, DEPENDENT))
    return sorted(good.tolist(), key=lambda j: (draft.joints[j].in_loop, j))


def _without(rest: Array, joint: int) -> Array:
    """Velocities with the direction that moves ``joint`` projected out."""
    direction = rest[joint] / np.linalg.norm(rest[joint])
    return rest - np.outer(rest @ direction, direction)


def _nearly_planar(chain: Chain) -> list[Notice]:
    """A remark if the linkage would be planar, were its axes not rounded."""
    if chain.planar or plane_normal(chain, NEARLY) is None:
        return []
    text = (
        f"the axes are parallel to within {NEARLY:.0e} rad, but not exactly, so the linkage is "
        "taken as spatial; write angles such as π/2 with 16 digits if it is meant to be planar"
    )
    return [Notice("nearly_planar", text)]


def _reduced(draft: Draft, chain: Chain) -> tuple[Chain, Chain, IntArray]:
    """Spatial chain without idle joints, the same in its plane if it has one, idle joints.

    Raises:
        MobilityError: closure fails at a higher order or at a finite pose.
    """
    if not len(chain.ends) and not len(chain.mimics):
        idle = ~np.any(chain.columns != 0.0, axis=1)
    else:
        idle = _idle(draft, chain)
    return *reduce(chain, idle), np.flatnonzero(idle)


def _idle(draft: Draft, chain: Chain) -> NDArray[np.bool_]:
    """Joints that do not move along a generic direction of the chain's columns."""
    ray = np.random.default_rng(2).standard_normal(chain.width)
    ray /= np.linalg.norm(ray)
    series = expand(chain, ray[None], 4)
    sizes = np.abs(series.C[0]).max(axis=(1, 2))
    for order, (residual, size) in enumerate(zip(series.residual, sizes, strict=True)):
        if residual > CLOSED * max(1.0, size, sizes[0] ** (order + 1)):
            raise _stuck(draft, chain, order + 1)
    pose, step = placement.follow(chain, np.zeros(chain.parent.size), series, ray)
    if step == 0.0:
        raise _stuck(draft, chain, len(series.residual) + 1)
    return np.abs(pose.q) <= CLOSED * np.abs(pose.q).max()
