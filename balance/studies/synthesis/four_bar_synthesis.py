"""Synthesis of four-bars: kites and antiparallelograms, and any others with geared rotors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from balance.motion.motion_tolerances import SYNTHESIS_MET
from balance.studies.synthesis.confirm import confirm_balance
from balance.studies.synthesis.four_bar_masses import balanced_four_bar
from balance.studies.synthesis.four_bars import FOUR_BARS, FourBarDesign, four_bars_through
from balance.studies.synthesis.geared_four_bar import balanced_by_rotors
from balance.studies.synthesis.general_four_bars import GeneralFourBar, general_four_bars
from balance.studies.synthesis.many_positions import four_bars_near
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from balance.studies.synthesis.positions import size_of
from balance.studies.synthesis.request import SynthesisRequest
from kinematics.numerics.linalg.ties import rank_least_first

# Most four-bars whose masses are tried. Of plates, those of each ratio of base and crank at
# these parts of their order by size: large ones take less dense matter for the same tool.
TRIES, PARTS = 8, (0.0, 0.1, 0.3, 0.6)
# Thickness of plates, over the length of the base; the first that does is taken.
THICKNESS = (1.0 / 20.0, 1.0 / 8.0)
# Most general four-bars that are balanced, of which the lightest is the best, by the number of
# positions: each costs half a second.
GEARED = {2: 1, 3: 1, 4: 3, 5: 3}


def special_four_bars(request: SynthesisRequest) -> Synthesis:
    """Search balanced four-bars, and masses for the best of each kind."""
    mechanisms, count, unbuilt = [], 0, False
    within = max(request.within, SYNTHESIS_MET * size_of(request.positions))
    for done, kind in enumerate(FOUR_BARS, 1):
        if len(request.positions) > 3:
            designs = four_bars_near(request.positions, kind)
        else:
            designs = four_bars_through(
                request.positions, kind, fixed=request.fixed, moving=request.moving
            )
        meeting = [design for design in designs if design.miss <= within]
        count += len(meeting)
        if meeting and request.density is not None:
            tried = _of_plates(meeting, request.density, request.thickness, within)
        else:
            tried = (_four_bar(four_bar, within) for four_bar in (meeting or designs)[:TRIES])
        first = next((mechanism for mechanism in tried if mechanism is not None), None)
        if first is not None:
            mechanisms.append(first)
        unbuilt |= first is None and any(not each.defects for each in meeting)
        if request.progress is not None:
            request.progress(done, len(FOUR_BARS))
    ranked = sorted(
        mechanisms,
        key=lambda four_bar: (not four_bar.good, not four_bar.meets, len(four_bar.defects)),
    )
    if unbuilt and not any(mechanism.good for mechanism in ranked):
        # Those of the other kind have defects; these have none, and may have masses.
        ranked = []
    return Synthesis(
        request.positions,
        request.kind,
        None,
        tuple(ranked),
        count,
        within=request.within,
        density=request.density,
        thickness=request.thickness,
    )


def _of_plates(
    designs: Sequence[FourBarDesign], density: float, thickness: float | None, within: float
) -> Iterator[SynthesizedMechanism | None]:
    """Try four-bars of all ratios and sizes as plates, thin and small ones first."""
    fewest = min(len(each.defects) for each in designs)
    groups: dict[float, list[int]] = {}
    for k, each in enumerate(designs):
        if len(each.defects) == fewest:
            groups.setdefault(each.ratio, []).append(k)
    picked = {group[int(part * len(group))] for group in groups.values() for part in PARTS}
    chosen = [designs[k] for k in sorted(picked)]
    for part in THICKNESS if thickness is None else (0.0,):
        for each in chosen:
            base = abs(each.scale) * each.ratio
            yield _four_bar(each, within, density, thickness or part * base)


def _four_bar(
    four_bar: FourBarDesign,
    within: float,
    density: float | None = None,
    thickness: float | None = None,
) -> SynthesizedMechanism | None:
    """Write and confirm a four-bar; None if the core finds no masses."""
    urdf, best = balanced_four_bar(four_bar, density, thickness)
    if urdf is None:
        return None
    numbers = {f"{body.name}_mass": float(body.mass) for body in best.bodies}
    if thickness is not None:
        numbers["thickness"] = thickness
    return _four_bar_mechanism(four_bar, urdf, numbers, within)


def _four_bar_mechanism(
    four_bar: FourBarDesign | GeneralFourBar,
    urdf: bytes,
    numbers: dict[str, float],
    within: float,
) -> SynthesizedMechanism:
    """Confirm a four-bar that was written."""
    alpha = four_bar.crank_angles
    turns = np.linspace(min(alpha), max(alpha), 200)
    numbers |= {"crank": abs(four_bar.scale), "base": abs(four_bar.scale) * four_bar.ratio}
    first = four_bar.positions[0].angle
    return SynthesizedMechanism(
        four_bar.kind,
        four_bar.pivots(),
        tuple(angle - alpha[0] for angle in alpha),
        tuple(each.angle - first for each in four_bar.positions),
        four_bar.error,
        four_bar.angle_error,
        four_bar.miss <= within,
        four_bar.tool_points(turns),
        tuple(map(four_bar.outline, range(len(alpha)))),
        four_bar.defects,
        urdf,
        None,
        None,
        confirm_balance(urdf, certified=False),
        numbers,
    )


def geared_four_bars(request: SynthesisRequest) -> Synthesis:
    """Search general four-bars without defects, and balance the best by rotors."""
    size = size_of(request.positions)
    designs = general_four_bars(request.positions, fixed=request.fixed, moving=request.moving)
    most = GEARED[len(request.positions)]
    mechanisms: list[SynthesizedMechanism] = []
    for done, four_bar in enumerate(designs[:TRIES], 1):
        applied = balanced_by_rotors(four_bar, request.density, request.thickness)
        if applied is not None:
            assert applied.urdf is not None and applied.added_mass is not None
            numbers = {
                "added_mass": applied.added_mass,
                "transmission_angle": four_bar.transmission,
            }
            within = SYNTHESIS_MET * size
            mechanisms.append(_four_bar_mechanism(four_bar, applied.urdf, numbers, within))
        if request.progress is not None:
            request.progress(min(done, most), most)
        if len(mechanisms) == most:
            break
    ranks = rank_least_first([mechanism.numbers["added_mass"] for mechanism in mechanisms])
    ranked = sorted((mechanisms[k] for k in ranks), key=lambda mechanism: not mechanism.good)
    remark = "links: bars of steel; tool: 1 kg; a rotor turns three times as far as its joint"
    return Synthesis(
        request.positions,
        request.kind,
        None,
        tuple(ranked),
        len(designs),
        (remark,),
        density=request.density,
        thickness=request.thickness,
    )
