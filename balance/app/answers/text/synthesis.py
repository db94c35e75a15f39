"""Text of a synthesis for ``balance synthesize``.

`Synthesis.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import math

from balance.app.answers.answer import AnswerBody, AnswerPart, Facts
from balance.motion.motion_tolerances import SYNTHESIS_MOMENTUM, SYNTHESIS_SHAKING
from balance.studies.synthesis.mechanism import Synthesis, SynthesizedMechanism
from kinematics.wording import number_text, size_text

HEAD = (
    "mechanism",
    "pivots (m)",
    "turns (deg)",
    "misses",
    "momentum",
    "shaking",
    "design space",
    "defects",
)
NONE = "-"
# Angle error from which it is written, radians.
ANGLE_SHOWN = 1e-9


def synthesis_facts(synthesis: Synthesis) -> list[tuple[str, str]]:
    """List the facts on a synthesis as pairs of label and value."""
    kind = (
        synthesis.kind
        if synthesis.kind != "pantograph"
        else f"{synthesis.kind}, {synthesis.case}"
    )
    pairs = [_describe_task(synthesis), ("mechanism", kind)]
    if synthesis.ratio is not None:
        pairs.append(("ratio", f"k = {number_text(synthesis.ratio, '.6g')}"))
    pairs += [("verdict", synthesis.words), *(("remark", words) for words in synthesis.remarks)]
    for mechanism in synthesis.mechanisms[:1]:
        pairs += _best(mechanism)
    return pairs


def _describe_task(synthesis: Synthesis) -> tuple[str, str]:
    """Write the positions, or the function, with their label."""
    if synthesis.function:
        turns = (tuple(map(_angle_text, each)) for each in synthesis.function)
        return "function", "; ".join(
            f"crank {crank}, rocker {rocker}" for crank, rocker in turns
        )
    at = "with the crank at" if synthesis.timed else "at"
    places = (
        f"({number_text(each.x, '.6g')}, {number_text(each.y, '.6g')}) "
        f"{at} {_angle_text(each.angle)}"
        for each in synthesis.positions
    )
    return "positions", "; ".join(places)


def _angle_text(angle: float) -> str:
    """Write an angle of radians."""
    return f"{number_text(math.degrees(angle), '.6g')}°"


def _best(mechanism: SynthesizedMechanism) -> list[tuple[str, str]]:
    """List the facts on the best mechanism."""
    pairs = []
    if mechanism.coupling is not None:
        kind = "slot" if mechanism.table else "belt"
        pairs.append((kind, mechanism.coupling.words))
    if mechanism.first_position:
        inputs = mechanism.first_position.items()
        at = ", ".join(f"{name}={number_text(x, '.9g')} rad" for name, x in inputs)
        pairs.append(("file pose", f"away from position 1, which is nearly flat, at {at}"))
    coupling = mechanism.confirmation.coupling
    if coupling is not None:
        size = size_text(coupling, floor=SYNTHESIS_MOMENTUM)
        pairs.append(("decoupled", f"inertia between inputs {size} of their own"))
    numbers = mechanism.numbers
    if "transmission_angle" in numbers:
        angle = number_text(math.degrees(numbers["transmission_angle"]), ".3g")
        pairs.append(("transmission", f"{angle}° or more"))
    pairs += _function_and_errors(mechanism)
    if "added_mass" in numbers:
        pairs.append(("added", f"{number_text(numbers['added_mass'], '.4g')} kg"))
    if "pressure_angle" in numbers:
        angle = number_text(math.degrees(numbers["pressure_angle"]), ".3g")
        pairs.append(("slider", f"pressure angle {angle}° or less"))
    if "thickness" in numbers:
        masses = ", ".join(
            f"{name.removesuffix('_mass')} {number_text(mass)} kg"
            for name, mass in numbers.items()
            if name.endswith("_mass")
        )
        pairs.append(
            ("plates", f"{number_text(1e3 * numbers['thickness'])} mm thick: {masses}")
        )
    if "J1" in numbers:
        lengths = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("l1", "l2", "l3")
        )
        centres = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("s1", "s2", "s3", "s4")
        )
        inertias = ", ".join(
            f"{name} {number_text(numbers[name], '.6g')}" for name in ("J1", "J2", "C")
        )
        pairs += [
            ("lengths", f"{lengths} m"),
            ("centres", f"{centres} m"),
            ("inertias", f"{inertias} kg m²"),
        ]
    return pairs


def _function_and_errors(mechanism: SynthesizedMechanism) -> list[tuple[str, str]]:
    """List the links of a function, and the errors of what is only approached."""
    pairs, numbers = [], mechanism.numbers
    if "rocker_start" in numbers:
        links = (
            f"{name} {number_text(numbers[name], '.6g')}"
            for name in ("crank", "coupler", "rocker", "base")
        )
        starts = (
            f"{name} at {_angle_text(numbers[f'{name}_start'])}" for name in ("crank", "rocker")
        )
        pairs += [("lengths", f"{', '.join(links)} m"), ("start", ", ".join(starts))]
    if "rms_distance" in numbers:
        largest, mean = (
            f"{size_text(1e3 * size, '.4g')} mm"
            for size in (mechanism.position_error, numbers["rms_distance"])
        )
        pairs.append(("distances", f"{largest} at most, {mean} root mean square"))
    if "rms_angle" in numbers:
        worst, typical = (
            f"{size_text(math.degrees(size), '.4g')}°"
            for size in (mechanism.angle_error, numbers["rms_angle"])
        )
        pairs.append(("errors", f"{worst} at most, {typical} root mean square"))
    return pairs


def mechanism_rows(synthesis: Synthesis) -> list[tuple[str, ...]]:
    """Build the table of mechanisms, its head first."""
    return [HEAD, *map(_row, synthesis.mechanisms)]


def _row(mechanism: SynthesizedMechanism) -> tuple[str, ...]:
    """Build the row of a mechanism."""
    pivots = "  ".join(
        f"{name} ({number_text(z.real, '.5g')}, {number_text(z.imag, '.5g')})"
        for name, z in mechanism.pivots.items()
    )
    inputs = mechanism.input_turns or {"": mechanism.link_turns}
    turns = "; ".join(
        f"{name} {', '.join(number_text(math.degrees(turn), '.5g') for turn in values[1:])}"
        for name, values in inputs.items()
    ).strip()
    sizes = (
        NONE if value is None else size_text(value, floor=floor)
        for value, floor in (
            (mechanism.confirmation.momentum, SYNTHESIS_MOMENTUM),
            (mechanism.confirmation.shaking, SYNTHESIS_SHAKING),
        )
    )
    defects = "; ".join(f"{each.kind}: {each.words}" for each in mechanism.defects) or "none"
    space = mechanism.confirmation.space or mechanism.confirmation.reason
    return (
        mechanism.kind,
        pivots,
        turns,
        _miss_text(mechanism),
        *sizes,
        space,
        defects,
    )


def _miss_text(mechanism: SynthesizedMechanism) -> str:
    """Write how far the tool is from its positions."""
    place = f"{size_text(mechanism.position_error)} m"
    if mechanism.angle_error <= ANGLE_SHOWN:
        return place
    return f"{place} and {number_text(math.degrees(mechanism.angle_error), '.3g')}°"


def synthesis_body(synthesis: Synthesis) -> AnswerBody:
    """Build what is printed on a synthesis."""
    head, *rows = mechanism_rows(synthesis)
    body: list[AnswerPart] = [Facts(synthesis_facts(synthesis))]
    for row in rows:
        body += ["", Facts(list(zip(head, row, strict=True)))]
    return body
