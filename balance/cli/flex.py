"""The command ``balance flex``: modes, supports, similar arms, simulation of flexible links."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from balance.cli.arguments import Parser, Verbs, page_path, picture_path
from balance.cli.exit_codes import DONE
from balance.cli.flex_arguments import (
    arm_of,
    beam_of,
    drive_of,
    drive_profile,
    spin_numbers,
    support_position,
)
from balance.cli.model_options import add_model_options, load_model
from balance.cli.number_arguments import finite_number, positive_number, whole_number
from balance.cli.outcome import Outcome
from balance.cli.progress_bar import progress_bar

if TYPE_CHECKING:
    from balance.flexible.flex_links import FlexLink
    from balance.flexible.similarity import Arm

__all__ = ["add_flex"]


def add_flex(verbs: Verbs) -> None:
    """Add the command ``flex`` to the parser."""
    parser = verbs.add_parser(
        "flex",
        help="links that bend: modes, supports, similar counter-arms, simulation",
        description="Dynamic balance of mechanisms with links that bend, in the plane.",
    )
    parser.set_defaults(run=_run)
    kinds = parser.add_subparsers(metavar="what", required=True, parser_class=Parser)
    _add_modes(kinds)
    _add_supports(kinds)
    _add_similar(kinds)
    _add_simulate(kinds)


def _run(arguments: argparse.Namespace) -> Outcome:
    """Run one of the commands below ``flex``."""
    outcome: Outcome = arguments.compute(arguments)
    return outcome


def _add_output(parser: argparse.ArgumentParser) -> None:
    """Add the options of commands that read no model."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--plot", type=picture_path, metavar="FILE", help="write a picture")
    parser.set_defaults(force=False)


def _add_modes(kinds: Verbs) -> None:
    """Add ``flex modes``."""
    parser = kinds.add_parser("modes", help="modes of a beam, free or on supports")
    parser.add_argument(
        "--count", type=whole_number(1, 500), default=12, metavar="N",
        help="number of modes (default 12)",
    )  # fmt: skip
    parser.add_argument(
        "--beam", type=beam_of, metavar="length:…,EI:…,rhoA:…",
        help="a beam in SI units (default: a free beam without dimensions)",
    )  # fmt: skip
    parser.add_argument(
        "--pin", type=support_position, action="append", default=[], metavar="S[+S…]",
        help="a pin at S metres along the beam, or a whippletree at several points with "
        "weights (0.1*0.5+0.3*0.5); repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--clamp", type=finite_number, action="append", default=[], metavar="S",
        help="a clamp at S metres along the beam; repeatable",
    )  # fmt: skip
    _add_output(parser)
    parser.set_defaults(compute=_modes, refuse=parser.error)


def _modes(arguments: argparse.Namespace) -> Outcome:
    """Compute the modes of the options."""
    from balance.flexible import flex_data
    from balance.report.text import flexible as text

    if arguments.beam is None:
        if arguments.pin or arguments.clamp:
            arguments.refuse("--pin and --clamp need --beam")
        from balance.flexible.free_modes import free_modes

        free = free_modes(arguments.count)
        if arguments.plot:
            from balance.report.html.flexible import free_modes_picture

            _write(arguments.plot, free_modes_picture(free, arguments.plot[-3:].lower()))
        return Outcome(
            DONE, lambda: flex_data.modes_data(free), lambda: text.free_modes_text(free)
        )
    from balance.flexible.supported_modes import Clamp, Support, supported_modes

    supports = [Support(*points) for points in arguments.pin]
    clamps = [Clamp(s) for s in arguments.clamp]
    found = supported_modes(arguments.beam, [*supports, *clamps], arguments.count)
    if arguments.plot:
        from balance.report.html.flexible import supported_modes_picture

        _write(arguments.plot, supported_modes_picture(found, arguments.plot[-3:].lower()))
    return Outcome(
        DONE,
        lambda: flex_data.supported_modes_data(found),
        lambda: text.supported_modes_text(found),
    )


def _add_supports(kinds: Verbs) -> None:
    """Add ``flex supports``."""
    parser = kinds.add_parser(
        "supports",
        help="points and weights on which a free beam shakes its mount in no low mode",
    )
    parser.add_argument("count", type=whole_number(1, 40), help="number of points, 1 to 40")
    _add_output(parser)
    parser.set_defaults(compute=_supports, refuse=parser.error)


def _supports(arguments: argparse.Namespace) -> Outcome:
    """Compute the supports of the options."""
    from balance.flexible.flex_data import supports_data
    from balance.flexible.support_points import support_points
    from balance.report.text.flexible import supports_text

    found = support_points(arguments.count)
    if arguments.plot:
        from balance.report.html.flexible import supports_picture

        _write(arguments.plot, supports_picture(found, arguments.plot[-3:].lower()))
    return Outcome(DONE, lambda: supports_data(found), lambda: supports_text(found))


def _add_similar(kinds: Verbs) -> None:
    """Add ``flex similar``."""
    parser = kinds.add_parser("similar", help="the counter-arm that bends like a given arm")
    items = "length:…,EI:…,rhoA:…,tip:…,radius:…,inertia:…,hub:…,EA:…,GA:…,rhoI:…"
    parser.add_argument(
        "--arm", type=arm_of, required=True, metavar="length:…,EI:…",
        help=f"the arm to balance, in SI units: {items}; tip, radius and inertia are of the "
        "body at its tip",
    )  # fmt: skip
    other = parser.add_mutually_exclusive_group(required=True)
    other.add_argument(
        "--scale", type=positive_number, metavar="F", help="length over that of the arm"
    )
    other.add_argument(
        "--against",
        dest="other_arm",
        type=arm_of,
        metavar="length:…,EI:…",
        help="a counter-arm to compare",
    )
    parser.add_argument(
        "--spin", type=spin_numbers, metavar="SPEED,RISE[,DURATION]",
        help="simulate both on one hub that reaches SPEED (rad/s) in RISE seconds",
    )  # fmt: skip
    _add_output(parser)
    parser.set_defaults(compute=_similar, refuse=parser.error)


def _similar(arguments: argparse.Namespace) -> Outcome:
    """Compute the counter-arm of the options, and simulate the pair if asked for."""
    from balance.flexible.flex_data import similarity_data
    from balance.flexible.similarity import compare_arms, similar_arm
    from balance.report.text.flexible import similarity_text

    if arguments.plot and arguments.spin is None:
        arguments.refuse("--plot shows the simulation: add --spin")
    first = arguments.arm
    second = arguments.other_arm or similar_arm(first, arguments.scale)
    found, motion = compare_arms(first, second), None
    if arguments.spin is not None:
        motion = _spin(arguments, first, second)
    return Outcome(
        DONE,
        lambda: similarity_data(first, second, found, motion),
        lambda: similarity_text(second, found, motion),
    )


def _spin(arguments: argparse.Namespace, first: Arm, second: Arm) -> Any:
    """Simulate two arms on one hub, and draw the shaking."""
    import numpy as np

    from balance.flexible.arm_mechanisms import arm_mechanism
    from balance.flexible.build_beam import BeamOptions
    from balance.flexible.drives import spin_up
    from balance.flexible.simulate import simulate

    speed, rise, *more = arguments.spin
    options = BeamOptions(elements=6, modes=3, axial_modes=0)
    mechanism = arm_mechanism([first, second], spin_up(speed, rise), options)
    with progress_bar("instants") as advance:
        motion = simulate(mechanism, more[0] if more else 5.0 * rise, progress=advance)
    if arguments.plot:
        from balance.report.html.flexible import shaking_picture

        picture = shaking_picture(motion, np.zeros(2), arguments.plot[-3:].lower())
        _write(arguments.plot, picture)
    return motion


def _add_simulate(kinds: Verbs) -> None:
    """Add ``flex simulate``."""
    parser = kinds.add_parser("simulate", help="a planar linkage of which named links bend")
    add_model_options(parser)
    parser.add_argument(
        "--flex", action="append", required=True, metavar="LINK=…",
        help="a link that bends: LINK=EI:…,rhoA:… in SI units, or LINK=rect(WIDTH,THICKNESS),"
        "steel; further items: EA:, GA:, rhoI:, length:, supports:, timoshenko; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--drive", type=drive_of, action="append", default=[], metavar="JOINT=spin:SPEED,RISE",
        help="an input: spin:SPEED,RISE, speed:SPEED, or moment:VALUE,RISE, in SI units "
        "(default: the first input spins up to 1 rad/s in 1 s); other inputs stay; repeatable",
    )  # fmt: skip
    for name, kind, metavar, text in (
        ("--duration", positive_number, "SECONDS", "duration (default 5)"),
        ("--elements", whole_number(1, 400), "N", "elements of a beam (default 16)"),
        ("--modes", whole_number(1, 400), "N", "modes of a beam that are kept (default 6)"),
        ("--samples", whole_number(2, 100_000), "N", "instants of the answer (default 501)"),
        (
            "--damping",
            positive_number,
            "BETA",
            "damping BETA × stiffness, in seconds (default none)",
        ),
    ):
        parser.add_argument(name, type=kind, metavar=metavar, help=text)
    parser.add_argument(
        "--linear", action="store_true", help="leave out centrifugal and axial stiffening"
    )
    parser.add_argument(
        "--plot", type=picture_path, metavar="FILE", help="write a picture of the shaking"
    )
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page in which the links bend; it needs no network",
    )  # fmt: skip
    parser.set_defaults(compute=_simulate)


def _simulate(arguments: argparse.Namespace) -> Outcome:
    """Simulate the linkage of the options and write its files."""
    from balance.flexible.build_beam import BeamOptions
    from balance.flexible.flex_data import motion_data
    from balance.flexible.flex_links import parse_flex_link
    from balance.flexible.from_linkage import flexible_linkage
    from balance.flexible.simulate import simulate
    from balance.report.text.flexible import flexible_motion_text

    if arguments.motion or arguments.spatial or arguments.balance != "dynamic":
        arguments.refuse("--motion, --spatial and --balance are not for flex simulate")
    flex: list[FlexLink] = [parse_flex_link(text) for text in arguments.flex]
    linkage = load_model(arguments, arguments.angles)
    options = BeamOptions(
        elements=arguments.elements or 16, modes=arguments.modes or 6,
        geometric=not arguments.linear, damping=arguments.damping or 0.0,
    )  # fmt: skip
    drives = dict(arguments.drive) or {
        name: drive_profile("spin", (1.0, 1.0)) for name in linkage.inputs[:1]
    }
    found = flexible_linkage(linkage, flex, drives, options)
    with progress_bar("instants") as advance:
        motion = simulate(found.mechanism, arguments.duration or 5.0,
                          arguments.samples or 501, progress=advance)  # fmt: skip
    if arguments.plot:
        from balance.report.html.flexible import shaking_picture

        picture = shaking_picture(motion, found.centre, arguments.plot[-3:].lower())
        _write(arguments.plot, picture)
    if arguments.html:
        from balance.report.html.flexible import flexible_page

        _write(arguments.html, flexible_page(found, motion).encode())
    return Outcome(
        DONE, lambda: motion_data(found, motion), lambda: flexible_motion_text(found, motion),
        notices=linkage.notices,
    )  # fmt: skip


def _write(path: str, content: bytes) -> None:
    """Write a file whole or not at all."""
    from balance.atomic_files import write_all_atomic

    write_all_atomic([(path, content)])
