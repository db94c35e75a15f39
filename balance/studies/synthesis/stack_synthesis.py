"""Synthesis of stacks: three freedoms, balanced and decoupled, through positions."""

from __future__ import annotations

from itertools import islice

import numpy as np

from balance.motion.motion_tolerances import SYNTHESIS_MET
from balance.motion.verification.given_motions import rest_to_rest
from balance.studies.synthesis.confirm import confirm_balance
from balance.studies.synthesis.constrained_motion import MotionTable
from balance.studies.synthesis.four_bar_stack import (
    StackMasses,
    plate_thicknesses,
    stack_masses,
    stack_space,
)
from balance.studies.synthesis.four_bar_synthesis import make_synthesis
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from balance.studies.synthesis.positions import size_of
from balance.studies.synthesis.request import SynthesisRequest
from balance.studies.synthesis.stack_designs import StackDesign, stack_designs
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.wording import number_text

# Most stacks whose masses are tried.
TRIES = 8
# Samples of the motion in each step from position to position.
STEP_SAMPLES = 120


def decoupled_stack(request: SynthesisRequest) -> Synthesis:
    """Search a stack of antiparallelograms that passes, and masses that balance it.

    Balanced in all freedoms, it is decoupled: the confirmation checks both.
    """
    count, mechanisms, words = 0, list[SynthesizedMechanism](), tuple[str, ...]()
    for design in islice(stack_designs(request.positions), TRIES):
        count += 1
        if request.progress is not None:
            request.progress(count, TRIES)
        masses, thickness = _masses(request, design)
        if masses is not None:
            mechanisms.append(_confirmed(request, design, masses, thickness))
            ratio = number_text(design.modules[0].ratio)
            words = (f"each base is {ratio} cranks long; each drive feels its own crank alone",)
            break
    if request.progress is not None:
        request.progress(TRIES, TRIES)
    return make_synthesis(request, mechanisms, count, words)


def _masses(
    request: SynthesisRequest, design: StackDesign
) -> tuple[StackMasses | None, float | None]:
    """Find masses of a stack, and the thickness of its plates."""
    space = stack_space(design.urdf)
    lowest = design.modules[0]
    base = lowest.crank * lowest.ratio
    for plate in plate_thicknesses(base, request.density, request.thickness):
        masses = stack_masses(space, request.density, plate)
        if masses is not None:
            return masses, plate
    return None, None


def _confirmed(
    request: SynthesisRequest, design: StackDesign, masses: StackMasses, thickness: float | None
) -> SynthesizedMechanism:
    """Confirm a stack that was written: balanced and decoupled."""
    numbers = {f"{name}_mass": mass for name, mass in masses.masses.items()}
    for k, module in enumerate(design.modules, 1):
        numbers |= {f"crank_{k}": module.crank, f"base_{k}": module.crank * module.ratio}
    if thickness is not None:
        numbers["thickness"] = thickness
    size, first = size_of(request.positions), request.positions[0].angle
    turns = design.turns
    table = _motion(masses.urdf, turns)
    within = SYNTHESIS_MET * size
    return SynthesizedMechanism(
        "stack",
        design.pivots,
        tuple(turns[:, 0].tolist()),
        tuple(each.angle - first for each in request.positions),
        design.error,
        design.angle_error,
        max(design.error, size * design.angle_error) <= within,
        design.way(),
        tuple(map(design.outline, range(len(turns)))),
        (),
        masses.urdf,
        None,
        table,
        confirm_balance(masses.urdf, certified=False, decoupled=True),
        numbers | {"transmission_angle": design.transmission},
        input_turns=dict(zip(table.inputs, map(tuple, turns.T.tolist()), strict=True)),
    )


def _motion(urdf: bytes, turns: np.ndarray) -> MotionTable:
    """Compute a motion that rests at each position, all cranks on straight lines."""
    linkage = load(Document("the synthesised mechanism", urdf))
    samples = STEP_SAMPLES * (len(turns) - 1) + 1
    moved = rest_to_rest(linkage, turns, samples=samples)
    return MotionTable(moved.time, moved.u, moved.ud, moved.udd, linkage.inputs)
