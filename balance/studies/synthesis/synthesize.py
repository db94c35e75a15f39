"""Synthesis of balanced mechanisms whose tool passes through positions.

The masses are given, and the pivots are searched for which the motion without momentum passes
through the positions: along a line for two positions (`pivot_line`), in the plane for three.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.designs.density import STEEL
from balance.motion.motion_tolerances import SYNTHESIS_LINK_FLAT
from balance.studies.synthesis.angle_error import chain_angles
from balance.studies.synthesis.balanced_pantograph import (
    ELBOW,
    SHOULDER,
    BalancedPantograph,
    pantograph_urdf,
)
from balance.studies.synthesis.confirm import confirm_along, confirm_balance
from balance.studies.synthesis.constrained_motion import (
    constrained_motion,
    list_defects,
)
from balance.studies.synthesis.construction import construct_chain
from balance.studies.synthesis.couplings import Coupling, belt_coupling, slot_coupling
from balance.studies.synthesis.error_map import angle_error_map, offsets_without_error
from balance.studies.synthesis.four_bar_synthesis import (
    dyad_six_bars,
    geared_four_bars,
    slider_cranks,
    special_four_bars,
)
from balance.studies.synthesis.function_four_bars import FunctionPoint
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from balance.studies.synthesis.pantograph import (
    PantographMasses,
    decouple,
    default_masses,
    match_ratio,
)
from balance.studies.synthesis.pivot_line import PivotLine, fixed_pivot_line, moving_pivot_line
from balance.studies.synthesis.positions import (
    Position,
    check_positions,
    displacements,
    size_of,
)
from balance.studies.synthesis.request import SynthesisRequest
from balance.studies.synthesis.rr_chain import (
    RRChain,
    chain_from_fixed_pivot,
    chain_from_moving_pivot,
    chain_from_three_positions,
    check_ratio,
)
from balance.studies.synthesis.stack_synthesis import decoupled_stack
from balance.studies.synthesis.three_positions import CrossingMap, crossing_map, default_window
from balance.support.units import length_in_si
from kinematics.errors import UsageError
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

# Those whose coupler is the tool, and what searches them.
COUPLERS = {
    "four-bar": special_four_bars,
    "slider-crank": slider_cranks,
    "geared-four-bar": geared_four_bars,
    "six-bar": dyad_six_bars,
    "stack": decoupled_stack,
}
KINDS = ("pantograph", *COUPLERS)
"""Kinds of mechanisms."""
RATIO = -1.0
"""Ratio of the turns if none is given."""
# Most mechanisms in a result.
MOST = 4
# Rows and columns of a map; its half width, in sizes of the positions; its highest ratio R.
GRID, REACH, HIGHEST = 60, 3.0, 2.0
# Mass m6 of default masses in the nonlinear case, kg: it couples the links.
COUPLING_MASS = 1.0
# Least angle between the links at which link 2 keeps pointing to the tool.
CLEAR = math.radians(15.0)


def synthesize(
    positions: Iterable[Sequence[float]] = (),
    ratio: float | None = None,
    *,
    nonlinear: bool = False,
    kind: str = "pantograph",
    fixed: complex | None = None,
    moving: complex | None = None,
    masses: PantographMasses | None = None,
    window: Sequence[float] | None = None,
    within: float = 0.0,
    density: float | None = STEEL,
    thickness: float | str | None = None,
    timed: bool = False,
    function: Iterable[Sequence[float]] = (),
    start: Sequence[float] | None = None,
    base: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Synthesis:
    """Find balanced mechanisms whose tool passes through positions.

    Pantographs with links that turn in the ratio ``k = β/φ`` of the first link and the tool
    (the linear case); pantographs with given masses, whose ratio varies (nonlinear); or kites
    and antiparallelograms whose coupler is the tool, which pass through up to four positions,
    and near more, in the sense of least squares; slider-cranks with crank and coupler of one
    length, through three, and near more; any four-bars, through up to five, with
    counterweights and geared rotors; any four-bars that a dyad makes six-bars which can be
    balanced; or three antiparallelograms, each on the coupler of the one before, with three
    freedoms that are balanced and decoupled, through up to twenty. Instead of positions, the
    rocker of any four-bar can follow a function of the crank. Every mechanism is written as
    URDF and confirmed by the design space and by Pinocchio.

    Args:
        positions: of the tool: x and y in metres, the angle in radians; inertial frame.
        ratio: k, negative; -1 by default.
        nonlinear: whether the ratio varies with the pose.
        kind: ``"pantograph"``, ``"four-bar"``, ``"slider-crank"``, ``"geared-four-bar"``,
            ``"six-bar"`` or ``"stack"``.
        fixed: the pivot on the base, for two positions; complex, metres.
        moving: or the one on the tool, at the first position.
        masses: of the pantograph. In the linear case s3 and a moment of inertia are changed.
        window: in the nonlinear case, the range of x of the free pivot for two positions, or of
            x and y of the moving pivot for three; metres.
        within: distance up to which a four-bar or slider-crank may miss four or more positions,
            metres; its angle counts as an arc of the size of the positions. By default it meets
            them. Of six and more points of a function: the error of the rocker, radians.
        density: density that the links, or the counterweights and rotors of any four-bar,
            nowhere exceed, kg/m³; that of steel by default. None for points, denser than any
            material.
        thickness: of the plates that this matter is, metres or ``"20mm"``. By default links are
            plates of a twentieth of the base, or of crank and coupler in line, or an eighth if
            those are too thin, and counterweights and rotors are no plates.
        timed: whether the angles of three to twenty positions are those of the crank of any
            four-bar, which rise or fall; the tool turns as it may (path generation with
            prescribed timing). Only differences of the angles count. Up to five are met, more
            are approached, in the sense of least squares next to many starts.
        function: three to twenty pairs of angles of the crank, which rise or fall, and of the
            rocker of any four-bar, radians (function generation); as for timed positions, only
            differences count, and more than five are approached.
        start: angles of both from the base at the first of three points of a function, radians;
            by default those of the best four-bar.
        base: length of the base of a function, metres; 1 by default. It is on the x-axis.
        progress: called with the number of steps done and of all steps.

    Returns:
        The mechanisms, best first, with their defects.

    Raises:
        SynthesisError: nothing can pass through the positions so.
        UsageError: the request contradicts itself.

    Source:
        G. Becht, MSc thesis, TU Delft, 2020, chapter 3; four-bars: J. M. McCarthy, G. S. Soh,
        Geometric Design of Linkages, 2nd ed., 2011, chapter 5; timed: G. N. Sandor, A. G.
        Erdman, Advanced Mechanism Design, vol. 2, 1984, chapter 3; functions: F. Freudenstein,
        Trans. ASME 77, 1955, pp. 853-861.

    Example:
        >>> import balance
        >>> places = [(0.3, 0.1, 0.2), (0.1, 0.4, -0.7)]
        >>> synthesis = balance.synthesize(places, -0.5, moving=0.2 - 0.1j)
        >>> synthesis.verdict
        'feasible'

        A point on its way while the crank turns by 0.5 and by 1.1 rad:

        >>> places = [(0.3, 0.1, 0.0), (0.2, 0.3, 0.5), (0.0, 0.4, 1.1)]
        >>> path = balance.synthesize(places, kind="geared-four-bar", timed=True)
        >>> [round(turn, 9) for turn in path.mechanisms[0].link_turns]
        [0.0, 0.5, 1.1]

        A rocker that turns as the square of the crank:

        >>> square = [(0.2, 0.04), (0.6, 0.36), (1.0, 1.0)]
        >>> rocker = balance.synthesize(kind="geared-four-bar", function=square)
        >>> [round(turn, 9) for turn in rocker.mechanisms[0].tool_turns]
        [0.0, 0.32, 0.96]
    """
    if kind not in KINDS:
        raise UsageError(f"no kind '{kind}': choose from {', '.join(KINDS)}")
    if (nonlinear or kind != "pantograph") and ratio is not None:
        raise UsageError("a ratio is for the linear case of a pantograph")
    points = tuple(FunctionPoint(*map(float, each)) for each in function)
    given = tuple(positions)
    poses = check_positions(given) if given or not points else ()
    linear = kind == "pantograph" and not nonlinear
    request = SynthesisRequest(
        poses,
        kind,
        check_ratio(RATIO if ratio is None else ratio) if linear else None,
        fixed,
        moving,
        masses,
        None if window is None else tuple(map(float, window)),
        progress,
        float(within),
        density,
        length_in_si(thickness),
        timed,
        points,
        None if start is None else (float(start[0]), float(start[1])),
        base,
    )
    request.check()
    if kind != "pantograph":
        return COUPLERS[kind](request)
    return _linear(request) if linear else _nonlinear(request)


def _linear(request: SynthesisRequest) -> Synthesis:
    """Synthesise the pantograph of a ratio."""
    ratio = request.ratio
    assert ratio is not None
    if request.fixed is not None:
        chain = chain_from_fixed_pivot(request.positions, ratio, request.fixed)
    elif request.moving is not None:
        chain = chain_from_moving_pivot(request.positions, ratio, request.moving)
    else:
        chain = chain_from_three_positions(request.positions, ratio)
    pantograph = balance_chain(chain, ratio, request.masses)
    chosen = "fixed" if request.fixed is not None else "moving"
    drawn = construct_chain(chain, chosen) if len(request.positions) == 2 else None
    mechanism = _pantograph(pantograph, ratio)
    return Synthesis(
        request.positions,
        request.kind,
        ratio,
        (mechanism,),
        1,
        _changes(request, pantograph),
        construction=drawn,
    )


def _changes(request: SynthesisRequest, pantograph: BalancedPantograph) -> tuple[str, ...]:
    """Describe what the linear case changed of given masses."""
    if request.masses is None:
        return ("masses in proportion to the chain: links of 1 kg, a payload of 0.1 kg",)
    given, masses = asdict(request.masses), asdict(pantograph.masses)
    return tuple(
        f"{name} changed from {number_text(given[name], '.6g')} to "
        f"{number_text(masses[name], '.6g')}, so that C = 0, k = -J2/J1"
        for name in masses
        if masses[name] != given[name]
    )


def _nonlinear(request: SynthesisRequest) -> Synthesis:
    """Search the pantographs of given masses."""
    size = size_of(request.positions)
    masses = request.masses or replace(default_masses(size, size), m6=COUPLING_MASS)
    masses.check()
    if len(request.positions) == 3:
        window = request.window or default_window(request.positions)
        x0, x1, y0, y1 = window
        designs, crossings = through_three_positions(
            request.positions, masses, (x0, x1, y0, y1), request.progress
        )
        words = "moving pivots from ({0:.4g}, {2:.4g}) to ({1:.4g}, {3:.4g}) m were searched"
        return _choose(request, designs, crossings, words.format(*window))
    line, (low, high) = _line(request, size)
    designs = _through_two_positions(request.positions, line, masses, low, high)
    ratio = masses.inertia_1 / masses.inertia_2 if masses.inertia_2 else 0.0
    error_map = angle_error_map(
        request.positions,
        line,
        masses,
        np.linspace(low, high, GRID),
        np.linspace(0.0, HIGHEST * ratio or 1.0, GRID),
        progress=request.progress,
    )
    words = (
        f"{line.free} pivots up to {number_text(max(-low, high))} m from the chord "
        "were searched"
    )
    return _choose(request, designs, error_map, words)


def _line(request: SynthesisRequest, size: float) -> tuple[PivotLine, tuple[float, float]]:
    """Find the line of the free pivot, and the range of offsets on it."""
    if request.moving is not None:
        line = fixed_pivot_line(request.positions, request.moving)
    else:
        assert request.fixed is not None
        line = moving_pivot_line(request.positions, request.fixed)
    if request.window is None:
        return line, (-REACH * size, REACH * size)
    low, high = sorted(line.offsets_of_x(request.window).tolist())
    return line, (low, high)


def _choose(
    request: SynthesisRequest,
    designs: Sequence[BalancedPantograph],
    pivot_map: object,
    words: str,
) -> Synthesis:
    """Confirm the best designs: without defects, and with short first links."""
    ranks = rank_least_first([pantograph.chain.length for pantograph in designs])
    ranked = sorted(
        (designs[k] for k in ranks), key=lambda pantograph: len(list_defects(pantograph))
    )
    mechanisms = tuple(_pantograph(pantograph, None) for pantograph in ranked[:MOST])
    remarks = [words]
    if request.masses is None:
        remarks.append("masses in proportion to the positions: links of 1 kg, 1 kg at m6")
    return Synthesis(
        request.positions,
        request.kind,
        None,
        mechanisms,
        len(designs),
        tuple(remarks),
        map=pivot_map,  # type: ignore[arg-type]
    )


def _pantograph(pantograph: BalancedPantograph, ratio: float | None) -> SynthesizedMechanism:
    """Write and confirm a pantograph, of a constant ratio or of one that varies."""
    chain, urdf = pantograph.chain, pantograph_urdf(pantograph, ratio)
    motion = constrained_motion(pantograph)
    coupling: Coupling
    if ratio is None:
        confirmation, coupling = confirm_along(urdf, motion), slot_coupling(pantograph)
    else:
        confirmation, coupling = confirm_balance(urdf), belt_coupling(ratio)
    first, second = motion.u.T
    first, second = first + pantograph.pose[0], first + second + pantograph.pose[1]
    J1, J2, C = map(float, pantograph.inertias)
    numbers = {
        name: value for name, value in asdict(pantograph.masses).items() if value is not None
    }
    s2 = pantograph.s2
    numbers |= {
        "l1": chain.length,
        "s1": pantograph.s1,
        "s2": s2.real,
        "s2_beside": s2.imag,
        "payload": pantograph.payload.real,
        "payload_beside": pantograph.payload.imag,
        "J1": J1,
        "J2": J2,
        "C": C,
    }
    return SynthesizedMechanism(
        "pantograph",
        {"fixed": chain.fixed, "moving": chain.moving},
        chain.link_turns,
        chain.tool_turns,
        chain.error,
        0.0,
        True,
        chain.tool_points(first, second),
        tuple(map(pantograph.outline, range(len(chain.positions)))),
        list_defects(pantograph),
        urdf,
        coupling,
        motion if ratio is None else None,
        confirmation,
        numbers,
        _first_position(pantograph, ratio),
    )


def _first_position(pantograph: BalancedPantograph, ratio: float | None) -> dict[str, float]:
    """Return the inputs at position 1, counted from the pose of the file, if they are not 0."""
    link, tool = pantograph.pose
    if not (link or tool):
        return {}
    elbow = {ELBOW: link - tool} if ratio is None else {}
    return {SHOULDER: -link, **elbow}


def balance_chain(
    chain: RRChain, ratio: float, masses: PantographMasses | None = None
) -> BalancedPantograph:
    """Find masses with which the links of a chain turn in a ratio without momentum.

    The centre of link 3 is moved until C vanishes, and a moment of inertia is raised until
    ``-J2/J1`` is the ratio. Link 2 points from the moving pivot to the tool; if the
    parallelogram would be nearly flat on the way, and the payload does not forbid it, in the
    direction in which it stays furthest from that.

    Args:
        masses: to begin with; in proportion to the chain by default.

    Returns:
        The pantograph.

    Raises:
        SynthesisError: the ratio is positive.
        UsageError: a mass is none.
    """
    given = masses or default_masses(chain.length, abs(chain.reach))
    given.check()
    start = BalancedPantograph(chain, decouple(given, chain.length))
    if given.s5 is None:
        start = replace(start, link_angle=_link_angle(start.deltas))
    matched = match_ratio(start.masses, chain.length, start.payload, ratio)
    return replace(start, masses=matched)


def _link_angle(deltas: tuple[float, ...]) -> float:
    """Choose the angle from the line to the tool to link 2."""
    low, high = min(deltas), max(deltas)
    if math.floor((low - CLEAR) / math.pi) == math.floor((high + CLEAR) / math.pi):
        return 0.0
    # δ falls by as much as link 2 is turned. Its middle goes to a right angle, or, if it passes
    # a change point anyway, its value at the first position, which is the pose of the file.
    clear = high - low < math.pi - 2.0 * SYNTHESIS_LINK_FLAT
    middle = 0.5 * (low + high) if clear else deltas[0]
    return math.remainder(middle - 0.5 * math.pi, math.pi)


def _through_two_positions(
    positions: Sequence[Position],
    line: PivotLine,
    masses: PantographMasses,
    low: float,
    high: float,
) -> tuple[BalancedPantograph, ...]:
    """Find the pantographs through two positions with a pivot on a line.

    Args:
        positions: two positions of the tool.
        line: of the pivot that is not chosen.
        low: least offset of the pivot, metres.
    """
    offsets = offsets_without_error(positions, line, masses, low, high)
    return _pantographs(positions, *line.pivots(offsets), masses)


def through_three_positions(
    positions: Sequence[Position],
    masses: PantographMasses,
    window: tuple[float, float, float, float],
    progress: Callable[[int, int], None] | None = None,
) -> tuple[tuple[BalancedPantograph, ...], CrossingMap]:
    """Find the pantographs through three positions.

    Args:
        positions: three positions of the tool.
        window: of the moving pivots, see `crossing_map`.
        progress: as of `crossing_map`.

    Returns:
        The pantographs, and the map with which they were found.
    """
    crossings = crossing_map(positions, masses, window, progress=progress)
    return _pantographs(positions, crossings.fixed, crossings.moving, masses), crossings


def _pantographs(
    positions: Sequence[Position], fixed: ArrayLike, moving: ArrayLike, masses: PantographMasses
) -> tuple[BalancedPantograph, ...]:
    """Build the pantographs on pivots."""
    steps, G, W = displacements(positions), np.asarray(fixed), np.asarray(moving)
    angles = chain_angles(positions[0], steps, G, W, masses)
    turns = np.cumsum(angles.link_turns, axis=0)
    pantographs = []
    for k in range(len(G)):
        beta = (0.0, *turns[:, k].tolist())
        chain = RRChain(tuple(positions), complex(G[k]), complex(W[k]), beta)
        pantographs.append(BalancedPantograph(chain, masses))
    return tuple(pantographs)
