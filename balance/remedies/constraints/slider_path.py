"""Remedy: a slider along a reactionless path of the inputs, one freedom in place of several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from balance.motion_tolerances import SHAKING_RELATIVE
from balance.remedies.applied import AppliedRemedy, inertia_ratio, refused
from balance.remedies.constraints.reactionless_path import ReactionlessPath, reactionless_path
from balance.remedies.judge import judge
from balance.remedies.request import RemedyRequest, input_inertia
from balance.remedies.variant import Variant
from balance.verification.to_pinocchio import verify
from balance.verification.trajectory import drive
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.model_gallery import load
from kinematics.urdf_elements.element import Document

__all__ = ["apply_slider_path"]

KEY = "slider_path"


def apply_slider_path(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage along a reactionless path, to which a slider or a cam holds it.

    With the masses of the file if they leave a reactionless direction; else with counterweights
    that balance the force, so that only the moment asks for a path.

    Args:
        request: the request.

    Yields:
        One result, with the path as a table for ``balance verify --csv``.
    """
    if request.freedoms < 2:
        yield refused(KEY, "the linkage has one freedom: its path is given")
        return
    words = "a slider along a reactionless path"
    found = _path(request, request.linkage)
    if found is not None:
        yield _verified(request, request.linkage, request.base.data, found, words)
        return
    if request.balance == "force":
        yield refused(KEY, "every direction of the inputs moves the centre of mass", words)
        return
    words = "counterweights against the force, and a slider along a reactionless path"
    force = replace(request, balance="force")
    balanced = judge(force, Variant(KEY, words, request.base, request.links))
    if balanced.urdf is None:
        reason = f"every direction has momentum, and the force stays: {balanced.reason}"
        yield replace(balanced, reason=reason)
        return
    document = Document(request.base.name, balanced.urdf)
    linkage = load(document, None, request.linkage.inputs, angles=request.angles)
    found = _path(request, linkage)
    if found is None:
        reason = "every direction of the inputs has angular momentum at the reference pose"
        yield refused(KEY, reason, words)
        return
    yield _verified(request, linkage, balanced.urdf, found, words)


def _path(request: RemedyRequest, linkage: Linkage) -> ReactionlessPath | None:
    """Integrate the path of a linkage under the relations of a request."""
    motion = Motion.parse(request.motion, linkage.inputs)
    return reactionless_path(linkage, motion, request.balance == "force")


def _verified(
    request: RemedyRequest, linkage: Linkage, urdf: bytes, path: ReactionlessPath, words: str
) -> AppliedRemedy:
    """Verify a linkage along its path, at a speed of 1 rad/s, and add up its cost."""
    along = drive(linkage, path.length, path.u, path.rates, path.bends)
    checked = verify(linkage, balance=request.balance, along=[along])
    residual = checked.force_residual
    if request.balance == "dynamic":
        residual = max(residual, checked.moment_residual)
    added = sum(float(body.inertia[0]) for body in linkage.bodies) - request.given_mass
    felt = input_inertia(linkage)
    reason = (
        f"balanced along a path of {path.length[-1]:.3g} rad of the inputs, one of "
        f"{path.choices} reactionless directions; a slider or cam must hold it"
    )
    good = residual <= SHAKING_RELATIVE
    return AppliedRemedy(
        KEY, words, "feasible" if good else "undecided",
        reason if good else f"its path shakes by {residual:.1e} of the bodies' own inertia",
        added_mass=added, mass_ratio=added / request.given_mass, input_inertia=felt,
        inertia_ratio=inertia_ratio(request, felt), lost_freedoms=request.freedoms - 1,
        residual=residual, urdf=urdf,
        files={"path.csv": _table(linkage.inputs, path)},
        details={"length": float(path.length[-1]), "choices": path.choices},
    )  # fmt: skip


def _table(inputs: Sequence[str], path: ReactionlessPath) -> bytes:
    """Write a path as a table for ``balance verify --csv``; length stands for time."""
    rows = np.column_stack([path.length, path.u]).tolist()
    lines = [",".join(["time", *inputs]), *(",".join(map(repr, row)) for row in rows)]
    return ("\n".join(lines) + "\n").encode()
