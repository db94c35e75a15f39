"""Build serial linkages from Denavit-Hartenberg parameters, standard or modified."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinematics.error_text import clean
from kinematics.files.urdf.nominal_angles import nearest_twelfth
from kinematics.files.urdf.rounded_angles import (
    ANGLE_READINGS,
    Rounded,
    note_rounded_angles,
)
from kinematics.files.urdf.validate_fields import MAX_ANGLE, MAX_NUMBER
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.loading.building.assemble_elements import assemble_elements, faults_of
from kinematics.loading.building.check_arguments import (
    BodyLike,
    bodies_by_link,
    checked_name,
    find_by_name,
    links_and_joints,
)
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import exp, prismatic, revolute
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import ANGLE_ROUND_OFF, RIGHT_ANGLE_ENTRY

CONVENTIONS = ("standard", "modified")
"""The conventions of Denavit-Hartenberg parameters."""
# Kinds of joints, and names of the columns.
KINDS = ("revolute", "prismatic")
COLUMNS = ("theta", "d", "a", "alpha")
_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
_CENTRE = (0.0, 0.0, 0.0)


def from_dh(
    rows: ArrayLike,
    convention: str = "standard",
    kinds: str | Sequence[str] = "revolute",
    bodies: Mapping[str, BodyLike] | None = None,
    *,
    names: Sequence[str] | None = None,
    angles: str = "nominal",
    name: str = "arm",
) -> Linkage:
    """Build a serial linkage from Denavit-Hartenberg parameters.

    Row i displaces frame i-1 to frame i by

        standard: ``T_i = Rz(θ_i) Tz(d_i) Tx(a_i) Rx(α_i)``, joint i along z of frame i-1;
        modified: ``T_i = Rx(α_i) Tx(a_i) Rz(θ_i) Tz(d_i)``, joint i along z of frame i.

    Craig numbers α and a of row i (modified) as α_(i-1), a_(i-1). Joint coordinates add to θ
    (revolute) or d (prismatic); the rows are the reference pose. Frame 0 is the inertial frame
    and that of ``base``. The frame of ``link<i>``, after joint i, is frame i if modified, and
    frame i-1 at the reference pose if standard; there a link ``tool`` has frame n.

    Args:
        rows: columns θ, d, a, α (n, 4), rad and m; one order for both conventions.
        convention: ``"standard"`` or ``"modified"``.
        kinds: ``"revolute"`` or ``"prismatic"``, of all joints, or of each (n).
        bodies: mass (kg), centre of mass (3,) in frame i (m), and inertia tensor about it
            (3, 3), along the axes of frame i (kg m²), by the name of the link; others carry
            no parameters. By default every link carries parameters, of mass 0.
        names: names of the joints (n); by default ``q1``, ``q2`` ….
        angles: ``"nominal"`` replaces an angle that looks rounded, such as 1.5708, by the
            multiple of π/12 nearby, with a notice; ``"as_written"`` keeps it.
        name: name of the linkage, in messages and in its file.

    Returns:
        The linkage; its inputs are all its joints.

    Raises:
        FileError: the rows do not form a linkage; the message has reason and remedy.

    Source:
        J. Denavit and R. S. Hartenberg, 1955; J. J. Craig, "Introduction to Robotics".

    Example:
        >>> import math, kinematics
        >>> arm = kinematics.from_dh([[0, 0.4, 0, math.pi / 2], [0, 0, 0.5, 0]])
        >>> [round(float(x), 6) for x in arm.places["tool"].pose[:3, 3]]
        [0.5, 0.0, 0.4]
    """
    source = f"{clean(str(name))} (built from Denavit-Hartenberg rows)"
    with faults_of(source):
        _check_option("convention", convention, CONVENTIONS)
        _check_option("angles", angles, ANGLE_READINGS)
        numbers = _check_rows(rows)
        titles = _joint_names(names, len(numbers))
        numbers, rounded = _replace_rounded(numbers, titles, angles)
        robot = _robot(name, numbers, convention, _joint_kinds(kinds, titles), titles, bodies)
    remarks = [note_rounded_angles(source, rounded, angles)] if rounded else []
    return assemble_elements(robot, source, titles, links_and_joints(bodies), remarks)


def _transformations(row: ArrayLike, convention: str) -> tuple[Array, Array]:
    """Compute the factors (4, 4) of ``T_i`` before and after the motion of joint i.

    Standard: ``1`` and ``Rz(θ) Tz(d) Tx(a) Rx(α)``; modified: the whole product and ``1``,
    since motions along z commute with ``Rz(θ) Tz(d)``.

    Args:
        row: θ, d, a, α (4,), in radians and metres.
        convention: ``"standard"`` or ``"modified"``.

    Returns:
        Both factors, lengths in metres.
    """
    theta, d, a, alpha = np.asarray(row, dtype=np.float64).tolist()
    along_z = _about(_Z, theta) @ exp(prismatic(_Z), d)
    along_x = _about(_X, alpha) @ exp(prismatic(_X), a)
    if convention == "standard":
        return np.eye(4), along_z @ along_x
    return along_x @ along_z, np.eye(4)


def _about(axis: ArrayLike, angle: float) -> Array:
    """Rotation (4, 4) about an axis through the origin, exact for right angles."""
    H = exp(revolute(axis, _CENTRE), angle)
    near = np.round(H)
    return np.where(np.abs(H - near) <= RIGHT_ANGLE_ENTRY, near, H)


def _check_option(option: str, value: str, choices: Sequence[str]) -> None:
    """Reject an unknown value of an option."""
    if value not in choices:
        problem = f"unknown {option} '{clean(str(value))}'"
        raise Refusal("", problem, f"choose from {', '.join(choices)}")


def _check_rows(rows: ArrayLike) -> Array:
    """Convert the rows to an array (n, 4), and check it."""
    try:
        numbers = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        problem, remedy = "the rows are not numbers of one length", "give θ, d, a, α of each"
        raise Refusal("", problem, remedy) from None
    if numbers.ndim != 2 or numbers.shape[1] != 4 or not len(numbers):
        shape = " by ".join(map(str, numbers.shape)) or "a single number"
        problem = f"the rows are {shape}, not n by 4"
        raise Refusal("", problem, "give θ, d, a, α of each joint")
    for i, row in enumerate(numbers):
        for column, value in zip(COLUMNS, row.tolist(), strict=True):
            most = MAX_ANGLE if column in ("theta", "alpha") else MAX_NUMBER
            if not abs(value) <= most:
                problem = f"{column} = {value!r} is not a finite number of at most {most:g}"
                raise Refusal(f"row {i + 1}", problem, "give radians and metres")
    return numbers


def _joint_names(names: Sequence[str] | None, count: int) -> list[str]:
    """List the names of the joints."""
    if names is None:
        return [f"q{i + 1}" for i in range(count)]
    if isinstance(names, str) or len(names) != count:
        problem = f"{clean(repr(names), 60)} does not name {count} joints"
        raise Refusal("names", problem, "give one name for each row")
    return [checked_name(f"row {i + 1}", "name", each) for i, each in enumerate(names)]


def _joint_kinds(kinds: str | Sequence[str], titles: Sequence[str]) -> list[str]:
    """Kinds of the joints."""
    joint_kinds = [kinds] * len(titles) if isinstance(kinds, str) else list(kinds)
    if len(joint_kinds) != len(titles):
        problem = f"{len(joint_kinds)} kinds for {len(titles)} rows"
        raise Refusal("kinds", problem, "give one for each row, or one for all")
    for title, kind in zip(titles, joint_kinds, strict=True):
        if kind not in KINDS:
            problem = f"unknown kind '{clean(str(kind))}'"
            raise Refusal(
                find_by_name("joint", title), problem, f"choose from {', '.join(KINDS)}"
            )
    return joint_kinds


def _replace_rounded(
    rows: Array, titles: Sequence[str], angles: str
) -> tuple[Array, list[Rounded]]:
    """Replace angles that look rounded, if wanted, and list them."""
    replaced, rounded = rows.copy(), []
    for i, title in enumerate(titles):
        for k in (COLUMNS.index("theta"), COLUMNS.index("alpha")):
            word = repr(float(rows[i, k]))
            multiple = nearest_twelfth(word)
            angle = multiple * math.pi / 12
            if multiple and abs(rows[i, k] - angle) > ANGLE_ROUND_OFF:
                replaced[i, k] = angle
                rounded.append(Rounded(find_by_name("joint", title), COLUMNS[k], word))
    return (replaced if angles == "nominal" else rows), rounded


def _robot(
    name: str,
    rows: Array,
    convention: str,
    kinds: Sequence[str],
    titles: Sequence[str],
    bodies: Mapping[str, BodyLike] | None,
) -> Element:
    """Make the elements of the linkage."""
    checked_name("<robot>", "name", name)
    links = ["base", *(f"link{i + 1}" for i in range(len(rows)))]
    masses = bodies_by_link(bodies, dict.fromkeys(links, _CENTRE))
    parts, joints, after = [make_elements.link("base")], [], np.eye(4)
    for parent, child, row, kind, title in zip(
        links, links[1:], rows, kinds, titles, strict=False
    ):
        before, beyond = _transformations(row, convention)
        joints.append(
            make_elements.joint(
                title,
                "continuous" if kind == "revolute" else kind,
                parent,
                child,
                make_elements.origin(after @ before),
                ("0 0 1", ""),
                independent=True,
            )
        )
        after = beyond
        parts.append(make_elements.link(child, _inertial(masses.get(child), beyond)))
    if convention == "standard":
        parts.append(make_elements.link("tool"))
        last = make_elements.origin(after)
        joints.append(make_elements.joint("tool_fixed", "fixed", links[-1], "tool", last))
    return make_elements.robot(name, [*parts, *joints])


def _inertial(body: tuple[float, Array, Array] | None, frame: Array) -> Element | None:
    """Make the ``<inertial>`` of a body from its frame (4, 4) in its link."""
    if body is None:
        return None
    mass, com, inertia = body
    at = frame.copy()
    at[:3, 3] += frame[:3, :3] @ com
    return make_elements.inertial(mass, inertia, make_elements.origin(at))
