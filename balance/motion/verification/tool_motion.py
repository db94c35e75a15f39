"""Motions of a linkage from a path of one of its links, the tool: inverse kinematics.

The tool coordinates x are the inputs of another linkage (`kinematics.tool`), in which the loops
give all joints. With the inputs ``u = f(x)`` and ``J = ∂f/∂x``, numbers of a table that are off
by Δx let the inputs be off, to first order in Δx, by

    Δu = J Δx        Δu̇ = J Δẋ + J̇ Δx        Δü = J Δẍ + 2 J̇ Δẋ + J̈ Δx
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import SAME_BRANCH
from balance.motion.verification.given_motions import from_csv, on_relations
from balance.motion.verification.load_errors import joint_rates
from balance.motion.verification.table_rounding import InputErrors
from balance.motion.verification.trajectory import Trajectory, drive
from balance.support.csv_columns import column_names, refuse_row
from kinematics.closure.assembly.tool_frame import DIRECTIONS, tool, tool_coordinates
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage, names_of
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array

REMEDY = "head the columns time and some of x, y, z, rx, ry, rz, such as time,x,y"


def from_tool_csv(
    linkage: LinkageLike,
    path: str | PathLike[str],
    link: str,
    point: ArrayLike | None = None,
    motion: Motion | None = None,
) -> Trajectory:
    """Read the path of a tool from a table, and compute the motion that moves it so.

    The table has a column ``time`` and some of ``x``, ``y``, ``z`` (shifts along the inertial
    axes) and ``rx``, ``ry``, ``rz`` (turns), displacements from the reference pose; what the
    columns do not name is held as far as that leaves those named free (`kinematics.tool`).
    Velocities and accelerations are those of a spline within the rounding of the numbers, as
    for `from_csv`.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        path: file of comma-separated values, SI units or those of the heads: ``x [mm]``.
        link: name of the link that is the tool.
        point: the point of the tool that moves (3,), metres, in the frame of the link; the
            origin of that frame by default.
        motion: relations that the inputs must fulfil.

    Returns:
        The motion of all joints.

    Raises:
        FileError: the file is no such table, or nothing moves in it.
        BodyError: there is no such link.
        CoordinateError: the tool cannot move that way.
        PoseError: the tool cannot follow the path.

    Source:
        A. Campos, R. Guenther, D. Martins, J. Braz. Soc. Mech. Sci. Eng. 27, 2005.

    Example:
        >>> import balance
        >>> rows = [f"{0.1 * k:.1f},{0.05 * (0.1 * k) ** 2:.6f}" for k in range(11)]
        >>> with open("tool.csv", "w") as file:
        ...     print("time,x", *rows, sep=chr(10), file=file)
        >>> balance.motion.from_tool_csv("robot.urdf", "tool.csv", "coupler")
        Trajectory: 11 samples of 4 joints over 1 s
    """
    linkage = as_linkage(linkage)
    coordinates = dict(zip(DIRECTIONS, tool_coordinates(link), strict=True))
    tooled = tool(linkage, link, _directions(path, coordinates), point, frame="link")
    moved = from_csv(tooled, path, short=coordinates)
    rows = [names_of(tooled.joints).index(joint.name) for joint in linkage.joints]
    driven = [rows[k] for k in linkage.positions_of(linkage.inputs)]
    errors = _errors_of_inputs(tooled, moved, driven)
    u = moved.q[:, driven]
    if motion is not None:
        u = on_relations(linkage, motion, path, u, errors.u)[0]
    trajectory = drive(linkage, moved.time, u, moved.qd[:, driven], moved.qdd[:, driven])
    units = input_chain(linkage).units
    if np.any(np.abs(trajectory.q - moved.q[:, rows]) > SAME_BRANCH * units):
        raise PoseError(
            f"{linkage.source}: along this path of {link} the inputs "
            f"({', '.join(linkage.inputs)}) do not decide the other joints: name others "
            "(--inputs)"
        )
    return replace(trajectory, errors=errors)


def _directions(path: str | PathLike[str], coordinates: Mapping[str, str]) -> list[str]:
    """Read the directions that a table has columns of, in the order of `DIRECTIONS`."""
    names = column_names(path)
    named = [x for x, name in coordinates.items() if x in names or name in names]
    if not named:
        raise refuse_row(path, "line 1", "names no direction of a tool", REMEDY)
    return named


def _errors_of_inputs(tooled: Linkage, moved: Trajectory, driven: list[int]) -> InputErrors:
    """Bound how far inputs can be off, since the path of the tool is rounded.

    Args:
        tooled: the linkage whose inputs are those of the tool.
        moved: its motion.
        driven: joints that are the inputs of the linkage itself.
    """
    chain, given = input_chain(tooled), moved.errors
    assert given is not None
    scale = chain.units[tooled.positions_of(tooled.inputs)]
    J = joint_rates(chain, moved.q / chain.units)[:, driven]
    J = J * chain.units[driven][:, None] / scale
    slope = np.gradient(J, moved.time, axis=0)
    bend = np.gradient(slope, moved.time, axis=0)

    def bound(*parts: tuple[Array, Array]) -> Array:
        return sum(
            (np.einsum("nij,nj->ni", np.abs(A), e) for A, e in parts), np.zeros_like(J[:, :, 0])
        )

    return InputErrors(
        given.decimals,
        bound((J, given.u)),
        bound((J, given.ud), (slope, given.u)),
        bound((J, given.udd), (2.0 * slope, given.ud), (bend, given.u)),
    )
