"""Synthesis of mechanisms whose coupler is the tool, and of their masses.

Kites, antiparallelograms and slider-cranks, and any four-bars with geared rotors or a dyad.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from balance.space.spaces.design_space import DesignSpace
from balance.studies.synthesis.circle_points import MOST_POSITIONS
from balance.studies.synthesis.confirm import confirm_balance
from balance.studies.synthesis.four_bar_masses import balanced_masses, bare_space, four_bar_urdf
from balance.studies.synthesis.four_bars import (
    FOUR_BARS,
    LARGEST,
    SMALLEST,
    CouplerMotion,
    FourBarDesign,
    four_bars_through,
)
from balance.studies.synthesis.function_four_bars import function_four_bars
from balance.studies.synthesis.geared_four_bar import balanced_by_rotors
from balance.studies.synthesis.general_four_bars import GeneralFourBar, general_four_bars
from balance.studies.synthesis.many_positions import four_bars_near
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from balance.studies.synthesis.near_four_bars import (
    REMARK,
    near_function_four_bars,
    near_timed_four_bars,
)
from balance.studies.synthesis.positions import size_of
from balance.studies.synthesis.request import SynthesisRequest
from balance.studies.synthesis.six_bars import six_bars
from balance.studies.synthesis.slider_cranks import (
    slider_crank_through,
    slider_crank_urdf,
)
from balance.studies.synthesis.timed_four_bars import timed_four_bars
from kinematics.numerics.linalg.ties import rank_least_first

# Most four-bars whose masses are tried. Of plates, those of each ratio of base and crank at
# these parts of their order by size: large ones take less dense matter for the same tool.
TRIES, PARTS = 8, (0.0, 0.1, 0.3, 0.6)
# Thickness of plates, over the length of the base; the first that does is taken.
THICKNESS = (1.0 / 20.0, 1.0 / 8.0)
# Most general four-bars that are balanced, of which the lightest is the best, by the number of
# positions: each costs half a second.
GEARED = {2: 1, 3: 1, 4: 3, 5: 3}
# Length of the base of a function, metres, if none is given.
BASE = 1.0
# Most six-bars whose masses are found, of which the lightest is the best.
SIX_BARS = 2


def special_four_bars(request: SynthesisRequest) -> Synthesis:
    """Search balanced four-bars, and masses for the best of each kind."""
    mechanisms, count, unbuilt = [], 0, False
    within = request.tolerance
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
            tried = (
                _with_masses(four_bar, _space_of(four_bar), within)
                for four_bar in (meeting or designs)[:TRIES]
            )
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
    return make_synthesis(request, ranked, count)


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
            plate = thickness or part * base
            yield _with_masses(each, _space_of(each), within, density, plate)


def slider_cranks(request: SynthesisRequest) -> Synthesis:
    """Find the slider-crank of the positions, and its masses."""
    size = size_of(request.positions)
    within = request.tolerance
    design = slider_crank_through(request.positions, fixed=request.fixed, moving=request.moving)
    length = abs(design.crank)
    in_reach = SMALLEST * size < length and design.spread < LARGEST * size
    meets = in_reach and design.miss <= within
    space = bare_space(design.kind, slider_crank_urdf(design))
    density, plates = request.density, [request.thickness]
    if not meets:
        density, plates = None, [None] * in_reach
    elif density is not None and request.thickness is None:
        plates = [2.0 * part * length for part in THICKNESS]
    tried = (_with_masses(design, space, within, density, plate) for plate in plates)
    mechanism = next((each for each in tried if each is not None), None)
    if request.progress is not None:
        request.progress(1, 1)
    return make_synthesis(request, [] if mechanism is None else [mechanism], int(meets))


def _space_of(four_bar: FourBarDesign) -> DesignSpace:
    """Compute the design space of a four-bar."""
    return bare_space(four_bar.kind, four_bar_urdf(four_bar))


def _with_masses(
    design: CouplerMotion,
    space: DesignSpace,
    within: float,
    density: float | None = None,
    thickness: float | None = None,
) -> SynthesizedMechanism | None:
    """Find masses in a design space and confirm the file; None if the core finds none."""
    file, best = balanced_masses(space, density, thickness)
    if file is None:
        return None
    numbers = {f"{body.name}_mass": float(body.mass) for body in best.bodies}
    if thickness is not None:
        numbers["thickness"] = thickness
    return _confirmed(design, file, numbers, within)


def _confirmed(
    design: CouplerMotion, urdf: bytes, numbers: dict[str, float], within: float
) -> SynthesizedMechanism:
    """Confirm a mechanism that was written."""
    alpha = design.crank_angles
    turns = np.linspace(min(alpha), max(alpha), 200)
    first = design.positions[0].angle
    return SynthesizedMechanism(
        design.kind,
        design.pivots(),
        tuple(angle - alpha[0] for angle in alpha),
        tuple(each.angle - first for each in design.positions),
        design.error,
        design.angle_error,
        design.meets(within),
        design.tool_points(turns),
        tuple(map(design.outline, range(len(alpha)))),
        design.defects,
        urdf,
        None,
        None,
        confirm_balance(urdf, certified=False),
        numbers | design.numbers,
        positions=design.positions,
    )


def geared_four_bars(request: SynthesisRequest) -> Synthesis:
    """Search general four-bars without defects, and balance the best by rotors."""
    designs = _general_designs(request)
    most = GEARED.get(request.count, 1)
    mechanisms: list[SynthesizedMechanism] = []
    for done, four_bar in enumerate(designs[:TRIES], 1):
        applied = balanced_by_rotors(four_bar, request.density, request.thickness)
        if applied is not None:
            assert applied.urdf is not None and applied.added_mass is not None
            numbers = {"added_mass": applied.added_mass}
            mechanisms.append(_confirmed(four_bar, applied.urdf, numbers, request.tolerance))
        if request.progress is not None:
            request.progress(min(done, most), most)
        if len(mechanisms) == most:
            break
    ranks = rank_least_first([mechanism.numbers["added_mass"] for mechanism in mechanisms])
    ranked = sorted((mechanisms[k] for k in ranks), key=lambda mechanism: not mechanism.good)
    tool = "" if request.function else " tool: 1 kg;"
    remark = f"links: bars of steel;{tool} a rotor turns three times as far as its joint"
    return make_synthesis(request, ranked, len(designs), (remark, *_search_remarks(request)))


def _search_remarks(request: SynthesisRequest) -> tuple[str, ...]:
    """Say how general four-bars were searched, if they need not be the nearest."""
    return (REMARK,) if request.count > MOST_POSITIONS else ()


def _general_designs(request: SynthesisRequest) -> tuple[GeneralFourBar, ...]:
    """Find general four-bars without defects."""
    exact = request.count <= MOST_POSITIONS
    if request.function:
        base = request.base or BASE
        if exact:
            return function_four_bars(request.function, start=request.start, base=base)
        return near_function_four_bars(request.function, base=base)
    if request.timed:
        return (timed_four_bars if exact else near_timed_four_bars)(request.positions)
    return general_four_bars(request.positions, fixed=request.fixed, moving=request.moving)


def dyad_six_bars(request: SynthesisRequest) -> Synthesis:
    """Search general four-bars without defects, and balance the best by an added dyad."""
    within = request.tolerance
    designs = _general_designs(request)
    mechanisms: list[tuple[SynthesizedMechanism, str]] = []
    pairs, most = six_bars(designs, request.progress), SIX_BARS
    if request.count > MOST_POSITIONS:
        # The nearest one, not the lightest of two.
        nearest = rank_least_first([design.root_mean_square for design, _ in pairs])
        pairs, most = tuple(pairs[k] for k in nearest), 1
    for design, space in pairs[:TRIES]:
        base = design.numbers["base"]
        plates: list[float | None] = [part * base for part in THICKNESS]
        if request.thickness is not None or request.density is None:
            plates = [request.thickness]
        tried = (
            _with_masses(design, space, within, request.density, plate) for plate in plates
        )
        mechanism = next((each for each in tried if each is not None), None)
        if mechanism is not None:
            mechanisms.append((mechanism, design.words))
        if len(mechanisms) == most:
            break
    ranks = rank_least_first([_mass_of(mechanism) for mechanism, _ in mechanisms])
    ranked = sorted((mechanisms[k] for k in ranks), key=lambda pair: not pair[0].good)
    remarks = (*(words for _, words in ranked[:1]), *_search_remarks(request))
    count = len(mechanisms) or len(designs)
    return make_synthesis(request, [mechanism for mechanism, _ in ranked], count, remarks)


def _mass_of(mechanism: SynthesizedMechanism) -> float:
    """Add up the masses of a mechanism, kg."""
    return sum(mass for name, mass in mechanism.numbers.items() if name.endswith("_mass"))


def make_synthesis(
    request: SynthesisRequest,
    mechanisms: Sequence[SynthesizedMechanism],
    count: int,
    remarks: tuple[str, ...] = (),
) -> Synthesis:
    """Make the result of a request from its mechanisms, the best first."""
    positions = request.positions
    if request.function and mechanisms:
        positions = mechanisms[0].positions
    return Synthesis(
        positions,
        request.kind,
        None,
        tuple(mechanisms),
        count,
        remarks,
        within=request.within,
        density=request.density,
        thickness=request.thickness,
        timed=request.timed,
        function=request.function,
    )
