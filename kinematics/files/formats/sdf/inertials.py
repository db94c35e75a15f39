"""Convert the ``<inertial>`` of SDF links, whose missing parts have default values."""

from __future__ import annotations

from kinematics.files.formats.sdf.fields import is_true, pose_steps
from kinematics.files.formats.sdf.steps import Steps, matrix_of, origins, simplify
from kinematics.files.urdf.validate_fields import check_only
from kinematics.model.document.element import Element

_MOMENTS = ("ixx", "iyy", "izz")
_PRODUCTS = ("ixy", "ixz", "iyz")


def has_inertial(link: Element) -> bool:
    """Return whether a link says its mass and inertia itself.

    Args:
        link: the ``<link>``.

    Raises:
        Refusal: it has two ``<inertial>``, or a malformed flag.
    """
    inertial = check_only(link, "inertial")
    return inertial is not None and not is_true(link, inertial, "auto")


def uses_defaults(link: Element) -> bool:
    """Return whether an ``<inertial>`` leaves out its mass or a moment of inertia.

    Args:
        link: a link that has one.
    """
    inertial = link.first("inertial")
    inertia = inertial.first("inertia") if inertial is not None else None
    if inertial is None or inertial.first("mass") is None or inertia is None:
        return True
    return any(inertia.first(name) is None for name in _MOMENTS)


def convert_inertial(link: Element, frame: Steps) -> Element:
    """Convert an ``<inertial>``, with 1 kg and 1 kg m² for what is missing, as SDF has it.

    Args:
        link: the link that has it.
        frame: pose of the frame of the link in that of its URDF link.

    Returns:
        The ``<inertial>`` of the URDF link.

    Raises:
        Refusal: a pose is malformed, or a part is there twice.
    """
    inertial = check_only(link, "inertial") or link
    pose = check_only(link, "pose", inertial)
    origin = _origin(simplify([*frame, *pose_steps(link, pose)]), inertial.line)
    mass = check_only(link, "mass", inertial)
    inertia = check_only(link, "inertia", inertial)
    defaults = {**dict.fromkeys(_MOMENTS, "1"), **dict.fromkeys(_PRODUCTS, "0")}
    entries = {}
    for name, default in defaults.items():
        item = check_only(link, name, inertia) if inertia is not None else None
        entries[name] = item.text if item is not None else default
    parts = (
        *origin,
        Element("mass", {"value": mass.text if mass else "1"}, (), (mass or inertial).line),
        Element("inertia", entries, (), (inertia or inertial).line),
    )
    return Element("inertial", {}, parts, inertial.line)


def _origin(steps: Steps, line: int) -> list[Element]:
    """Write a pose as one ``<origin>``; in floating point if its decimals do not fit."""
    exact = origins(steps, line)
    if len(exact) < 2:
        return exact
    from numpy import array

    from kinematics.model.document.write_numbers import number_words, roll_pitch_yaw

    R, p = matrix_of(steps)
    angles = number_words(roll_pitch_yaw(array(R)))
    return [Element("origin", {"xyz": number_words(p), "rpy": angles}, (), line)]
