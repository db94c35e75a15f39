"""The command ``balance flex``: modes, supports, similar arms, simulation of flexible links."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Facts, Files
from balance.app.cli.arguments import Parser, Verbs, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.flex_arguments import (
    arm_of,
    beam_of,
    drive_of,
    moment_numbers,
    spin_numbers,
    support_position,
    tip_of,
    translator_numbers,
)
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.number_arguments import (
    add_about,
    finite_number,
    positive_number,
    whole_number,
)
from balance.app.cli.outputs import (
    add_page_option,
    add_picture_option,
    add_table_option,
    kind_of,
    result_files,
)
from balance.app.cli.progress import progress_bar

if TYPE_CHECKING:
    from balance.motion.flexible.free_beam_modes import FreeMode
    from balance.motion.flexible.similarity import Arm
    from balance.motion.flexible.simulate import FlexibleMotion
    from balance.motion.flexible.translators import TranslatorMotion

ITEMS = "length:…,EI:…,rhoA:…,tip:…,radius:…,inertia:…,hub:…,EA:…,GA:…,rhoI:…"


def add_flex(parser: Parser) -> None:
    """Add the commands below ``flex``."""
    parser.description = "Dynamic balance of mechanisms with links that bend, in the plane."
    kinds = parser.add_subparsers(title="jobs", metavar="what", prog=parser.prog, required=True)
    _add_modes(kinds)
    _add_supports(kinds)
    _add_similar(kinds)
    _add_simulate(kinds)


def _add_modes(kinds: Verbs) -> None:
    """Add ``flex modes``."""
    parser = kinds.add_parser("modes", help="modes of a beam, free or on supports")
    parser.add_argument(
        "--count",
        type=whole_number(1, 500),
        default=12,
        metavar="N",
        help="number of modes (default 12)",
    )
    parser.add_argument(
        "--beam",
        type=beam_of,
        metavar="length:…,EI:…,rhoA:…",
        help="a beam in SI units (default: a free beam without dimensions)",
    )
    parser.add_argument(
        "--pin",
        type=support_position,
        action="append",
        default=[],
        metavar="S[+S…]",
        help="a pin at S metres along the beam, or a whippletree at several points with "
        "weights (0.1*0.5+0.3*0.5); repeatable",
    )
    parser.add_argument(
        "--clamp",
        type=finite_number,
        action="append",
        default=[],
        metavar="S",
        help="a clamp at S metres along the beam; repeatable",
    )
    parser.add_argument(
        "--tip",
        type=tip_of,
        metavar="MASS[,INERTIA[,OFFSET]]",
        help="a rigid body fixed to the far end of the beam: kg, kg m² about its centre of "
        "mass, and metres from the end to that centre",
    )
    add_json_option(parser, _modes)
    add_picture_option(parser, kinds="")


def _modes(arguments: argparse.Namespace) -> Answer:
    """Compute the modes of the options."""
    if arguments.beam is None:
        if arguments.pin or arguments.clamp or arguments.tip:
            arguments.refuse("--pin, --clamp and --tip need --beam")
        from balance.motion.flexible.free_beam_modes import free_modes

        return _free_modes(free_modes(arguments.count), kind_of(arguments.plot))
    from balance.app.answers.text.flexible import supported_modes_table
    from balance.motion.flexible.supported_beam_modes import Clamp, Support, supported_modes

    supports = [Support(*points) for points in arguments.pin]
    clamps = [Clamp(s) for s in arguments.clamp]
    modes = supported_modes(
        arguments.beam, [*supports, *clamps], arguments.count, end_body=arguments.tip
    )

    return Answer(
        DONE,
        modes.to_dict,
        lambda: [supported_modes_table(modes)],
        files=lambda: result_files(arguments, modes),
    )


def _free_modes(modes: Sequence[FreeMode], kind: str) -> Answer:
    """Answer with the modes of a free beam."""
    from balance.app.answers.text.flexible import free_modes_table
    from balance.motion.flexible.flex_data import modes_data

    def prepare_files() -> Files:
        from balance.app.answers.html.flexible_pictures import free_modes_picture

        return {"plot": partial(free_modes_picture, modes, kind)}

    return Answer(
        DONE, lambda: modes_data(modes), lambda: [free_modes_table(modes)], files=prepare_files
    )


def _add_supports(kinds: Verbs) -> None:
    """Add ``flex supports``."""
    parser = kinds.add_parser(
        "supports",
        help="points and weights on which a free beam shakes its mount in no low mode",
    )
    parser.add_argument("count", type=whole_number(1, 40), help="number of points, 1 to 40")
    add_json_option(parser, _supports)
    add_picture_option(parser, kinds="")


def _supports(arguments: argparse.Namespace) -> Answer:
    """Compute the supports of the options."""
    from balance.app.answers.text.flexible import supports_body
    from balance.motion.flexible.support_points import support_points

    supports = support_points(arguments.count)
    return Answer(
        DONE,
        supports.to_dict,
        lambda: supports_body(supports),
        files=lambda: result_files(arguments, supports),
    )


def _add_simulate(kinds: Verbs) -> None:
    """Add ``flex simulate``."""
    parser = kinds.add_parser("simulate", help="a planar linkage of which named links bend")
    add_model_options(parser, unused=("--motion", "--balance", "--spatial"))
    parser.add_argument(
        "--flex",
        action="append",
        required=True,
        metavar="LINK=…",
        help="a link that bends: LINK=EI:…,rhoA:… in SI units, or LINK=rect(WIDTH,THICKNESS),"
        "steel; further items: EA:, GA:, rhoI:, length:, supports:, timoshenko; repeatable",
    )
    parser.add_argument(
        "--drive",
        type=drive_of,
        action="append",
        default=[],
        metavar="JOINT=spin:SPEED,RISE",
        help="an input: spin:SPEED,RISE, speed:SPEED, or moment:VALUE,RISE, in SI units "
        "(default: the first input spins up to 1 rad/s in 1 s); other inputs stay; repeatable",
    )
    for name, kind, default, metavar, text in (
        ("--duration", positive_number, 5.0, "SECONDS", "duration (default 5)"),
        ("--elements", whole_number(1, 400), None, "N",
         "elements of a beam (default 16, or twice the modes)"),
        ("--modes", whole_number(1, 400), None, "N",
         "modes of a beam that are kept (default 6, or 2 N + 2 on N > 2 supports)"),
        ("--samples", whole_number(2, 100_000), 501, "N",
         "instants of the answer (default 501)"),
        ("--damping", positive_number, 0.0, "BETA",
         "damping BETA × stiffness, in seconds (default none)"),
    ):  # fmt: skip
        parser.add_argument(name, type=kind, default=default, metavar=metavar, help=text)
    parser.add_argument(
        "--linear", action="store_true", help="leave out centrifugal and axial stiffening"
    )
    parser.add_argument(
        "--from-rest",
        action="store_true",
        help="start with all bodies at rest under an input at speed, which hits them",
    )
    add_about(parser.group("motion"), "the centre of mass at the start")
    add_picture_option(parser, "write a picture of the shaking", "")
    add_table_option(
        parser, "write time, shaking force and moment, energy, and the bending of each link"
    )
    add_page_option(parser, "in which the links bend")
    parser.set_defaults(run=_simulate)


def _simulate(arguments: argparse.Namespace) -> Answer:
    """Simulate the linkage of the options."""
    from balance.app.answers.text.flexible import flexible_motion_facts
    from balance.motion.flexible.flex_data import motion_table
    from balance.motion.flexible.flex_links import parse_flex_link
    from balance.motion.flexible.linkage_motion import simulate_flexible

    flex = [parse_flex_link(text) for text in arguments.flex]  # before the file is read
    linkage = load_model(arguments, arguments.angles)
    with progress_bar("instants") as advance:
        run = simulate_flexible(
            linkage,
            flex,
            dict(arguments.drive),
            arguments.duration,
            samples=arguments.samples,
            elements=arguments.elements,
            modes=arguments.modes,
            damping=arguments.damping,
            geometric=not arguments.linear,
            from_rest=arguments.from_rest,
            about=arguments.about,
            progress=advance,
        )
    return Answer(
        DONE,
        run.to_dict,
        lambda: [Facts(flexible_motion_facts(run.flexible, run.motion))],
        run.notices,
        files=lambda: {
            **result_files(arguments, run),
            "table": partial(motion_table, run.flexible, run.motion),
        },
    )


def _add_similar(kinds: Verbs) -> None:
    """Add ``flex similar``."""
    parser = kinds.add_parser("similar", help="the counter-arm that bends like a given arm")
    parser.add_argument(
        "--arm",
        type=arm_of,
        required=True,
        metavar="length:…,EI:…",
        help=f"the arm to balance, in SI units: {ITEMS}; tip, radius and inertia are of the "
        "body at its tip",
    )
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
        "--spin",
        type=spin_numbers,
        metavar="SPEED,RISE[,DURATION]",
        help="simulate both on one hub that reaches SPEED (rad/s) in RISE seconds",
    )
    parser.add_argument(
        "--translator",
        type=translator_numbers,
        metavar="pitch:…,mass:…,length:…,breadth:…",
        help="simulate a block that two such arms move, on hubs at a pitch, and a similar "
        "block on the counter-arms; hubmass: mass of a hub. SI units",
    )
    parser.add_argument(
        "--moment",
        type=moment_numbers,
        metavar="VALUE,RISE[,DURATION]",
        help="moment on the translator that reaches VALUE (N m) in RISE seconds",
    )
    parser.add_argument(
        "--both-hubs",
        action="store_true",
        help="the moment drives both hubs, by half on each; otherwise the lower one",
    )
    add_json_option(parser, _similar)
    add_picture_option(parser, kinds="")


def _similar(arguments: argparse.Namespace) -> Answer:
    """Compute the counter-arm of the options, and simulate what was asked for."""
    from balance.app.answers.text.flexible import similarity_body
    from balance.motion.flexible.flex_data import similarity_data
    from balance.motion.flexible.similarity import compare_arms, similar_arm

    _check(arguments)
    first = arguments.arm
    second = arguments.other_arm or similar_arm(first, arguments.scale)
    similarity = compare_arms(first, second)
    motion = _spin(arguments, first, second) if arguments.spin else None
    translator = _translate(arguments, first, second) if arguments.translator else None

    def prepare_files() -> Files:
        from balance.app.answers.html.flexible_pictures import one_panel_picture

        kind = kind_of(arguments.plot)
        if translator:
            pitch = translator.translator.pitch
            return {"plot": partial(one_panel_picture, translator.pair, pitch, kind)}
        return {"plot": partial(one_panel_picture, motion, kind=kind)} if motion else {}

    return Answer(
        DONE,
        lambda: similarity_data(first, second, similarity, motion, translator),
        lambda: similarity_body(second, similarity, motion, translator),
        files=prepare_files,
    )


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that do not fit."""
    if arguments.spin and arguments.translator:
        arguments.refuse("--spin turns arms, --moment a --translator: give one of them")
    if (arguments.translator is None) != (arguments.moment is None):
        arguments.refuse("--translator and --moment go together")
    if arguments.both_hubs and arguments.translator is None:
        arguments.refuse("--both-hubs needs --translator")
    if arguments.plot and not (arguments.spin or arguments.translator):
        arguments.refuse("--plot shows the simulation: add --spin, or --translator")


def _spin(arguments: argparse.Namespace, first: Arm, second: Arm) -> FlexibleMotion:
    """Simulate two arms on one hub."""
    from balance.motion.flexible.arm_mechanisms import arm_mechanism
    from balance.motion.flexible.build_beam import BeamOptions
    from balance.motion.flexible.drives import spin_up
    from balance.motion.flexible.simulate import simulate

    speed, rise, *more = arguments.spin
    options = BeamOptions(elements=6, modes=3, axial_modes=0)
    mechanism = arm_mechanism([first, second], spin_up(speed, rise), options)
    with progress_bar("instants") as advance:
        return simulate(mechanism, more[0] if more else 5.0 * rise, progress=advance)


def _translate(arguments: argparse.Namespace, first: Arm, second: Arm) -> TranslatorMotion:
    """Simulate the translator of the options."""
    from balance.motion.flexible.arm_mechanisms import Block
    from balance.motion.flexible.translators import Translator, simulate_translator

    given = arguments.translator
    value, rise, *more = arguments.moment
    translator = Translator(
        Block(given["mass"], given["length"], given["breadth"]),
        given["pitch"],
        given.get("hubmass", 0.0),
        value,
        rise,
        arguments.both_hubs,
    )
    with progress_bar("instants") as advance:
        return simulate_translator(
            translator, (first, second), more[0] if more else 10.0 * rise, progress=advance
        )
