"""Remedy: a slider along a reactionless path of the inputs, one freedom in place of several."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from balance.masses.remedies.applied import AppliedRemedy, describe_residual, refused, with_cost
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.least_matter import rim_of
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.paths.demand import Kept
from balance.motion.paths.path import path_table, timed_path
from balance.motion.paths.path_search import find_paths
from balance.motion.paths.reactionless_paths import ReactionlessPaths
from balance.motion.verification.verify_motions import verify
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.wording import number_text

KEY = "slider_path"
# Arc length of the path to either side of the reference pose, in all joints.
LENGTH = 0.5


def apply_slider_path(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage along a reactionless path, to which a slider or a cam holds it.

    With the masses of the file if they leave a reactionless direction; else with counterweights
    that balance the force, so that only the moment asks for a path.

    Yields:
        One result, with the path as a table for ``balance verify --csv``.
    """
    if request.freedoms < 2:
        yield refused(KEY, "the linkage has one freedom: its path is given")
        return
    words = "a slider along a reactionless path"
    solution = _path(request, request.linkage)
    if solution is not None:
        yield _verified(request, request.linkage, request.base.data, solution, words)
        return
    if request.balance == "force":
        yield refused(KEY, "every direction of the inputs moves the centre of mass", words)
        return
    words = "counterweights against the force, and a slider along a reactionless path"
    force = replace(request, balance="force")
    balanced = judge_variant(force, Variant(KEY, words, request.base, request.links))
    if balanced.urdf is None:
        reason = f"every direction has momentum, and the force stays: {balanced.reason}"
        yield replace(balanced, reason=reason)
        return
    document = Document(request.base.name, balanced.urdf)
    linkage = load(document, None, request.linkage.inputs, angles=request.angles)
    solution = _path(request, linkage)
    if solution is None:
        reason = "every direction of the inputs has angular momentum at the reference pose"
        yield refused(KEY, reason, words)
        return
    rim = rim_of(balanced.reason)
    yield _verified(request, linkage, balanced.urdf, solution, words, rim)


def _path(request: RemedyRequest, linkage: Linkage) -> ReactionlessPaths | None:
    """Find the paths of a linkage under the relations of a request; None if there is none."""
    kept: Kept = "force" if request.balance == "force" else "all"
    solution = find_paths(linkage, kept=kept, motion=request.motion, length=LENGTH)
    return solution if solution.paths else None


def _verified(
    request: RemedyRequest,
    linkage: Linkage,
    urdf: bytes,
    solution: ReactionlessPaths,
    words: str,
    rim: str = "",
) -> AppliedRemedy:
    """Verify a linkage along the first of its paths, in 1 s, and add up its cost.

    Args:
        rim: which counterweights are at the rim of their regions, in words.
    """
    path = solution.paths[0]
    checked = verify(linkage, balance=request.balance, motions=[timed_path(linkage, path)])
    length = float(np.linalg.norm(np.diff(path.u, axis=0), axis=1).sum())
    residual = checked.force_residual
    if request.balance == "dynamic":
        residual = max(residual, checked.moment_residual)
    added = sum(float(body.inertia[0]) for body in linkage.bodies) - request.given_mass
    reason = (
        f"balanced along a path of {number_text(length, '.3g')} rad of the inputs, one of "
        f"{solution.dimension} reactionless directions; a slider or cam must hold it{rim}"
    )
    good = residual <= SHAKING_RELATIVE
    if not good:
        reason = describe_residual(residual, "path")
    done = AppliedRemedy(
        KEY,
        words,
        "feasible" if good else "undecided",
        reason,
        lost_freedoms=request.freedoms - 1,
        residual=residual,
        urdf=urdf,
        files={"path.csv": path_table(linkage, path)},
        details={"length": length, "choices": solution.dimension},
    )
    return with_cost(request, done, added, linkage, request.motion)
