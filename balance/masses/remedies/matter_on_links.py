"""The plainest remedies: matter on the links that are there, to balance or within a budget."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.partial_balance.budgets import partial
from balance.masses.remedies.applied import AppliedRemedy, describe_residual, refused, with_cost
from balance.masses.remedies.balancers.on_base import (
    ForceBalanced,
    NoBalancer,
    balance_force,
)
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.least_matter import places_text, rim_text
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import Variant
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.shaking_wrench import move_wrenches, shaking_along
from balance.motion.verification.trajectory import Trajectory, drive
from balance.motion.verification.verify_motions import measure_shaking
from kinematics.closure.joint_positions import input_chain
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.linkage import Linkage
from kinematics.wording import number_text


def apply_own_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by matter on its own links alone.

    Yields:
        One result.
    """
    words = f"matter on {', '.join(request.links)}"
    yield judge_variant(request, Variant("own_masses", words, request.base, request.links))


def apply_force_masses(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance the force by counterweights on the links, and measure the moment that is left.

    The residual is the root mean square of the shaking moment about the middle of the linkage
    over that of the file, along the same random motions; it may be above 1.

    Yields:
        One result: ``"partial"``, for the moment stays.
    """
    if request.balance == "force":
        yield refused("force_masses", "the force alone is asked for: see own_masses")
        return
    words = f"matter on {', '.join(request.links)} against the force alone"
    try:
        balanced = balance_force(request)
    except NoBalancer as no:
        reason = no.reason.removeprefix("a wheel takes no force, and ")
        yield NoBalancer(no.verdict, reason, no.proof).applied("force_masses", words)
        return
    blank = AppliedRemedy("force_masses", words, "undecided", "")
    yield with_moment_left(request, blank, balanced)


def with_moment_left(
    request: RemedyRequest, blank: AppliedRemedy, balanced: ForceBalanced
) -> AppliedRemedy:
    """Measure the moment that a linkage without shaking force leaves, and add up the cost.

    Args:
        blank: the result so far.
        balanced: the linkage with the remedy.

    Returns:
        The result: partial if its file has no force, else undecided.

    Raises:
        PoseError: it cannot follow the random motions of the linkage.
    """
    given, made = request.linkage, balanced.linkage
    moved = motions = request.motions_of_loads
    if len(made.joints) > len(given.joints):
        # Further motions may come near singular poses of what is added.
        motions = request.motions
        moved = tuple(drive(made, each.time, each.u, each.ud, each.udd) for each in motions)
    before, after = _root_mean_squares(given, motions), _root_mean_squares(made, moved)
    shaking = measure_shaking(made, moved)
    if not shaking.force <= SHAKING_RELATIVE:
        reason = describe_residual(shaking.force)
        return replace(blank, reason=reason)
    balances = shaking.moment <= SHAKING_RELATIVE
    residual = 0.0 if balances or before[1] == 0.0 else after[1] / before[1]
    moment = (
        ", and no moment"
        if balances
        else f"; the moment is {number_text(residual, '.3g')} times that of the file "
        f"({number_text(after[1], '.3g')} N m, root mean square along random motions of 1 s)"
    )
    details = {
        "motions": f"{len(motions)} random motions of 1 s",
        "force_before": before[0],
        "force_after": after[0],
        "moment_before": before[1],
        "moment_after": after[1],
    }
    reason = f"no force is left{moment}{balanced.places}{balanced.rim}"
    done = replace(
        blank,
        verdict="partial",
        reason=reason,
        residual=residual,
        urdf=balanced.document.data,
        details={**blank.details, **details},
    )
    return with_cost(request, done, balanced.added, made, request.motion)


def _root_mean_squares(linkage: Linkage, motions: Sequence[Trajectory]) -> tuple[float, float]:
    """Compute the root mean squares of force and moment, over time, about the middle."""
    middle, squares = input_chain(linkage).frame.origin, np.zeros(6)
    for motion in motions:
        wrenches = move_wrenches(shaking_along(linkage, motion), middle)
        mean = np.trapezoid(np.square(wrenches), motion.time, axis=0) / np.ptp(motion.time)
        squares += mean / len(motions)
    return float(np.sqrt(squares[3:].sum())), float(np.sqrt(squares[:3].sum()))


def apply_partial(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Add the matter within a budget that lets a linkage shake least; see `balance.partial`.

    The residual is the root mean square of the shaking over that of the file; details have
    those of force and moment.

    Yields:
        One result.
    """
    budget = request.given_mass if request.budget is None else request.budget
    words = f"at most {budget:.4g} kg on {', '.join(request.links)}"
    design = partial(
        request.space_of_base,
        request.links,
        budget,
        regions=request.regions,
        density=request.density,
        thickness=request.thickness,
    )
    blank = AppliedRemedy("partial", words, "undecided", design.words)
    if design.shaking is None or design.verdict != "optimal":
        yield blank
        return
    residual = (
        design.shaking.objective / design.given.objective if design.given.objective else 0.0
    )
    urdf = with_counterweights(design) if design.weights else request.base.data
    document = Document(request.base.name, urdf)
    made = load(document, None, request.linkage.inputs, angles=request.angles)
    reason = design.words + places_text(design.weights)
    reason += rim_text(design.weights, request.links, "leave less")
    if design.weights:
        reason += (
            f"; they fit {len(design.motions)} random motions, so that alike links may get "
            "different ones; balance reduce --csv FILE fits one of yours"
        )
    details = {
        f"{part}_{when}": getattr(figures, part)
        for part in ("force", "moment")
        if getattr(design.given, part) > design.round_off_of(part)
        for when, figures in (("before", design.given), ("after", design.shaking))
    }
    done = replace(
        blank, verdict="partial", reason=reason, residual=residual, urdf=urdf, details=details
    )
    yield with_cost(request, done, design.mass, made, request.motion)
