"""Judge a variant: find its least masses, write its file, verify it, and add up its cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from balance.masses.counterweights.write_counterweights import with_counterweights
from balance.masses.remedies.applied import (
    AppliedRemedy,
    describe_residual,
    total_inertia,
    with_cost,
)
from balance.masses.remedies.least_matter import least_matter
from balance.masses.remedies.request import MOTIONS, POSES, RemedyRequest, freedoms_of
from balance.masses.remedies.trade_off import TradeOff, trade_off_of
from balance.masses.remedies.variant import Variant
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.verification.trajectory import random_motions
from balance.motion.verification.verify_motions import measure_shaking
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.model.motion import motion_of


def judge_variant(
    request: RemedyRequest, variant: Variant, space: DesignSpace | None = None
) -> AppliedRemedy:
    """Find the least matter that balances a variant, and verify the linkage with it.

    Args:
        variant: the linkage with the remedy built in.
        space: the design space of the variant, if it is known.

    Returns:
        The result; ``"feasible"`` only if Pinocchio confirms the written file.
    """
    blank = AppliedRemedy(
        variant.remedy,
        variant.words,
        "undecided",
        "",
        new_links=variant.new_links,
        new_joints=variant.new_joints,
        details=variant.details,
    )
    motion = (*request.motion, *variant.motion)
    inputs = _inputs(request, variant)
    regions = {**request.regions, **variant.regions}
    if variant.urdf is request.own_file and not variant.motion:
        # Nothing is built in but matter: the spaces of the request are known, and certified.
        flat = request.space.planar and request.balance == "dynamic"
        whole = request.spatial_space if flat and not request.thickness else None
        least = least_matter(
            request.space,
            variant.free,
            regions,
            request.density,
            request.thickness,
            whole,
            request.prove,
        )
    else:
        try:
            space = space or space_with(request, variant)
        except LinkageError as error:
            return replace(blank, verdict="refused", reason=str(error))
        least = least_matter(
            space,
            variant.free,
            regions,
            request.density,
            request.thickness,
            prove=request.prove,
        )
    verdict = least.matter.verdict
    if verdict != "feasible":
        return replace(blank, verdict=verdict, reason=least.reason, proof=least.proof)
    urdf = with_counterweights(least.matter, merge=frozenset(variant.new_links))
    done = verify_file(request, blank, urdf, motion, inputs)
    if done.verdict == "feasible":
        where = least.places_text + least.rim_text(_bounded(request, variant))
        done = replace(done, reason=done.reason + where)
    if not request.trade_off or done.added_mass is None or done.input_inertia is None:
        return done
    inertia, gap = total_inertia(request, done.input_inertia), least.matter.gap or 0.0
    first = TradeOff(done.added_mass, inertia, request.gear, None, gap)
    points = trade_off_of(request, least, variant.free, first)
    return replace(done, trade_off=points)


def space_with(request: RemedyRequest, variant: Variant) -> DesignSpace:
    """Compute the design space of a variant, all of whose links may carry matter.

    Raises:
        LinkageError: it does not assemble.
    """
    linkage = load(
        variant.urdf,
        None,
        _inputs(request, variant),
        bodies="all",
        massless=(*request.massless, *variant.massless),
        angles=request.angles,
    )
    motion = (*request.motion, *variant.motion)
    return design_space(linkage, motion or None, request.balance)


def _bounded(request: RemedyRequest, variant: Variant) -> list[str]:
    """List the links with default regions, or those of the user, whose rims are bounds.

    The regions of other new links are sizes of the remedy, which its words state.
    """
    return [
        name for name in variant.free if name in request.links or name not in variant.regions
    ]


def _inputs(request: RemedyRequest, variant: Variant) -> tuple[str, ...]:
    return request.linkage.inputs if variant.inputs is None else variant.inputs


def verify_file(
    request: RemedyRequest,
    blank: AppliedRemedy,
    urdf: bytes,
    motion: Sequence[str],
    inputs: Sequence[str],
) -> AppliedRemedy:
    """Verify the file of a linkage with a remedy, and add up its cost.

    Args:
        blank: the result so far.
        urdf: the file, with all masses.
        motion: relations between its inputs.

    Returns:
        The result: feasible if the file is balanced along random motions, else undecided.
    """
    document = Document(request.base.name, urdf)
    linkage = load(document, None, inputs, angles=request.angles)
    motions = random_motions(linkage, MOTIONS, POSES, motion=motion_of(linkage, motion or None))
    shaking = measure_shaking(linkage, motions)
    residual = max(shaking) if request.balance == "dynamic" else shaking.force
    if not residual <= SHAKING_RELATIVE:
        reason = describe_residual(residual)
        return replace(blank, reason=reason, residual=residual)
    added = sum(float(body.inertia[0]) for body in linkage.bodies) - request.given_mass
    done = replace(
        blank,
        verdict="feasible",
        residual=residual,
        urdf=urdf,
        lost_freedoms=request.freedoms - freedoms_of(linkage, motion),
    )
    return with_cost(request, done, added, linkage, motion)
