"""What the product made of a file, against the second reading of the same bytes."""

from __future__ import annotations

import math

import numpy as np

from kinematics.model.linkage import GROUND, Linkage, UnassembledLinkage
from tests.independent.second_reading import Joint, Reading, Weld

# Round-off of products of rotations and of sums, relative to the extents.
SMALL = 1e-9
# Loops that are open by round-off are closed without a word: joints move by 1e-9 at most.
UNTOLD = 1e-8


def compare(draft: UnassembledLinkage, said: Reading, tolerance: float = SMALL) -> None:
    """Assert that a draft is what the second reading says.

    Args:
        draft: before its loops are closed.
        said: the second reading.
        tolerance: of lengths relative to the extent, and of directions.
    """
    at = {joint.name: i for i, joint in enumerate(draft.joints)}
    assert len(at) == len(draft.joints)
    expected = [n for j in said.joints for n in j.names]
    closing = [n for w in said.welds.values() for n in w.joint.names]
    tree = len(expected)
    assert {j.name for j in draft.joints[:tree]} == set(expected)
    assert [j.name for j in draft.joints[tree:]] == closing
    for i, joint in enumerate(draft.joints):
        assert GROUND <= joint.parent < i and joint.in_loop == (i >= tree)
    for joint in said.joints:
        _same_joint(draft, at, joint, said, tolerance)
    for weld, loop in zip(said.welds.values(), draft.loops, strict=True):
        _same_weld(draft, at, weld, loop, said, tolerance)
    assert [loop.name for loop in draft.loops] == list(said.welds)
    found = {draft.joints[m.joint].name: m for m in draft.mimics}
    assert set(found) == set(said.mimics)
    for name, (source, ratio, _) in said.mimics.items():
        assert draft.joints[found[name].source].name == source
        assert found[name].ratio == ratio
    assert list(draft.named_inputs) == said.inputs
    _same_bodies(draft, said, tolerance)


def _index(at: dict[str, int], name: str) -> int:
    return at[name] if name else GROUND


def _screws(
    draft: UnassembledLinkage, at: dict[str, int], names: tuple[str, ...]
) -> np.ndarray:
    return np.array([draft.joints[at[name]].screw for name in names]).reshape(-1, 6)


def _same_joint(
    draft: UnassembledLinkage, at: dict, joint: Joint, said: Reading, tolerance: float
) -> None:
    """Names, kinds, order and screws of the freedoms of one joint."""
    before = _index(at, joint.parent)
    for name, kind in zip(joint.names, joint.kind, strict=True):
        item = draft.joints[at[name]]
        word = "prismatic" if kind == "P" else "helical" if joint.pitch else "revolute"
        assert (item.kind, item.parent) == (word, before), name
        before = at[name]
    if joint.names:
        screws, size = _screws(draft, at, joint.names), said.extent + 1.0 + abs(joint.pitch)
        _same_screws(screws, joint, tolerance, size)


def _same_screws(screws: np.ndarray, joint: Joint, tolerance: float, size: float) -> None:
    """Axes as the file gives them where it does, and what the others must be."""
    p, n = joint.point, joint.n
    for kind, screw in zip(joint.kind, screws, strict=True):
        a = screw[3:] if kind == "P" else screw[:3]
        assert abs(math.hypot(*a) - 1.0) <= tolerance
        moment = np.cross(p, a) + joint.pitch * a if kind == "R" else a
        assert np.abs(screw[3:] - moment).max() <= tolerance * size
        assert kind == "R" or not screw[:3].any()
    axes = [s[3:] if k == "P" else s[:3] for k, s in zip(joint.kind, screws, strict=True)]
    first = axes[2] if joint.kind == "PPR" else axes[0]
    assert np.abs(first - n).max() <= tolerance
    if joint.kind == "RP":
        assert np.abs(axes[1] - n).max() <= tolerance
    elif len(axes) > 1:  # three turns, and before them three slides if the joint floats
        for part in (np.array(axes[:3]), np.array(axes[3:]).reshape(-1, 3)):
            off = np.abs(part @ part.T - np.eye(len(part))).max(initial=0.0)
            assert off <= max(tolerance, 1e-9)
    if joint.u is not None:
        across = joint.u - (joint.u @ n) * n
        assert np.abs(axes[1] - across / math.hypot(*across)).max() <= tolerance


def _same_weld(
    draft: UnassembledLinkage,
    at: dict,
    weld: Weld,
    loop: object,
    said: Reading,
    tolerance: float,
) -> None:
    size = said.extent + 1.0
    names, here, there = weld.joint.names, weld.joint.parent, weld.successor
    D = loop.gap
    if names:
        before = _index(at, here)
        for name in names:
            assert draft.joints[at[name]].parent == before
            before = at[name]
        here = names[-1]
        joint = weld.joint
        if joint.kind == "PPR":
            joint = joint._replace(point=draft.joints[at[names[0]]].point)
            assert abs((joint.point - weld.joint.point) @ joint.n) <= 4 * tolerance * size + (
                weld.distance
            )
        _same_screws(_screws(draft, at, names), joint, tolerance, size)
    elif here == "":
        here, there, D = there, here, np.linalg.inv(D)
    assert (loop.end, loop.successor) == (_index(at, here), _index(at, there))
    p = weld.after[:3, 3]
    back = D[:3, :3].T @ (p - D[:3, 3])
    assert abs(math.hypot(*(back - p)) - weld.distance) <= 9 * tolerance * size
    if not math.isnan(weld.angle):
        twist = [D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]]
        angle = math.atan2(math.hypot(*twist) / 2, (np.trace(D[:3, :3]) - 1) / 2)
        assert abs(angle - weld.angle) <= max(9 * tolerance, 1e-7)


def _same_bodies(draft: UnassembledLinkage, said: Reading, tolerance: float) -> None:
    """Masses, first moments and inertias about the inertial origin, body by body."""
    heavy = {}
    for name, (m, mc, E) in said.inertias.items():
        z = np.array([m, *mc, E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]])
        if name and z.any():
            heavy[name] = z
    found = {draft.joints[body.link].name: body for body in draft.bodies}
    assert set(found) == set(heavy) and len(found) == len(draft.bodies)
    for name, z in heavy.items():
        size = 1.0 + said.extent
        scale = np.array([1.0, *[size] * 3, *[size**2] * 6]) * (1.0 + np.abs(z).max())
        assert (np.abs(found[name].inertia - z) <= 10 * tolerance * scale).all(), name
        body = found[name]
        assert np.abs(body.frame - said.places[body.name]).max() <= tolerance * size
        assert said.carrier[body.name] == name


def closed(said: Reading) -> bool:
    """Whether the loops close at the pose of the file, to round-off."""
    return all(
        weld.distance <= 1e-13 * said.extent and weld.angle <= 1e-13
        for weld in said.welds.values()
    )


def compare_closed(linkage: Linkage, draft: UnassembledLinkage, tolerance: float) -> None:
    """Assert that closing the loops moved the links of a draft, and changed nothing else."""
    assert [(j.name, j.kind, j.parent, j.in_loop) for j in linkage.joints] == [
        (j.name, j.kind, j.parent, j.in_loop) for j in draft.joints
    ]
    assert linkage.mimics == draft.mimics and linkage.source == draft.source
    assert [w[:3] for w in map(_ends, linkage.loops)] == [
        w[:3] for w in map(_ends, draft.loops)
    ]
    assert 1 <= linkage.mobility <= len(draft.joints) == len(linkage.joints)
    assert len(linkage.inputs) == linkage.mobility
    assert {*linkage.inputs, *linkage.idle} <= {j.name for j in draft.joints}
    codes = {notice.code for notice in linkage.notices}
    size = max(float(np.abs(j.screw).max()) for j in (*linkage.joints, *draft.joints))
    if not codes & {"assembled", "closes_to_rounding", "left_singular_pose"}:
        for ours, theirs in zip(linkage.joints, draft.joints, strict=True):
            assert np.abs(ours.screw - theirs.screw).max() <= UNTOLD * (1.0 + size)
    for ours, theirs in zip(_forms(linkage), _forms(draft), strict=True):
        assert abs(ours - theirs) <= tolerance * (1.0 + size)
    if "welded" not in codes:
        for ours, theirs in zip(linkage.bodies, draft.bodies, strict=True):
            assert (ours.name, ours.link) == (theirs.name, theirs.link)
            size = 1.0 + np.abs(theirs.inertia).max()
            assert abs(ours.inertia[0] - theirs.inertia[0]) <= SMALL * size


def _ends(loop: object) -> tuple[str, int, int]:
    return loop.name, loop.end, loop.successor


def _forms(draft: UnassembledLinkage) -> list[float]:
    """Invariants of neighbours: angles between the axes on a link, and their reciprocity."""
    forms = []
    for joint in draft.joints:
        if joint.parent != GROUND:
            before = draft.joints[joint.parent].screw
            forms.append(float(before[:3] @ joint.screw[:3]))
            forms.append(float(before[:3] @ joint.screw[3:] + before[3:] @ joint.screw[:3]))
    return forms
