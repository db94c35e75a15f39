"""Robots written for tests of their motion: links with plain inertias, joints at points."""

from __future__ import annotations

import numpy as np

from tests.support.laws import words

INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
# Points and axes of the joints of an arm that takes its last link anywhere.
SIX = (
    [
        (0, 0, 0),
        (0.03, 0, 0.35),
        (0.03, 0.05, 0.75),
        (0.35, 0.1, 0.8),
        (0.45, 0.02, 0.85),
        (0.5, 0.02, 0.7),
    ],
    [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0.2), (0, 1, 0), (0.3, 0, 1)],
)


def joint(name, parent, child, offset, axis):
    """A revolute joint at an offset from the one that carries its parent."""
    return (
        f'<link name="{child}">{INERTIAL}</link><joint name="{name}" type="continuous">'
        f'<origin xyz="{words(offset)}"/><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{words(axis)}"/></joint>'
    )


def arm(folder, points, axes):
    """A serial robot with joints j1, j2 … at points, and links l1, l2 …; its path."""
    offsets = np.diff(np.vstack([np.zeros(3), points]), axis=0)
    parts = [
        joint(f"j{i}", f"l{i - 1}", f"l{i}", offset, axis)
        for i, (offset, axis) in enumerate(zip(offsets, axes, strict=True), 1)
    ]
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm"><link name="l0"/>{"".join(parts)}</robot>', "utf-8")
    return path


def bennett(folder, lengths, twists):
    """A Bennett linkage collapsed onto the x axis, driven by q1; its path.

    Sides and twists (radians) are ``l1, l2`` and ``α1, α2``: from the first joint along x by
    l1, back by l2, back by l1, and along x by l2.
    """
    along = np.array([1.0, -1.0, -1.0]) * [lengths[0], lengths[1], lengths[0]]
    x = np.concatenate([[0.0], np.cumsum(along)])
    turn = np.cumsum([0.0, twists[0], -twists[1], -twists[0]])
    P = np.column_stack([x, np.zeros(4), np.zeros(4)])
    n = np.column_stack([np.zeros(4), -np.sin(turn), np.cos(turn)])
    parts = [
        joint("q1", "base", "crank", P[0], n[0]),
        joint("q2", "crank", "coupler", P[1] - P[0], n[1]),
        joint("q4", "base", "rocker", P[3], n[3]),
    ]
    loop = (
        '<loop name="q3" type="revolute">'
        f'<predecessor link="coupler"><origin xyz="{words(P[2] - P[1])}"/></predecessor>'
        f'<successor link="rocker"><origin xyz="{words(P[2] - P[3])}"/></successor>'
        f'<axis xyz="{words(n[2])}"/></loop>'
    )
    text = f'<robot name="bennett"><link name="base"/>{"".join(parts)}{loop}</robot>'
    path = folder / "bennett.urdf"
    path.write_text(text, "utf-8")
    return path
