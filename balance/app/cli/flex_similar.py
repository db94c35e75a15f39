"""The command ``balance flex similar``: a counter-arm, alone or below a translator."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Verbs, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.flex_arguments import (
    arm_of,
    moment_numbers,
    spin_numbers,
    translator_numbers,
)
from balance.app.cli.number_arguments import positive_number
from balance.app.cli.outputs import add_picture_option, kind_of
from balance.app.cli.progress_bar import progress_bar

if TYPE_CHECKING:
    from balance.motion.flexible.similarity import Arm
    from balance.motion.flexible.simulate import FlexibleMotion
    from balance.motion.flexible.translators import TranslatorMotion


ITEMS = "length:…,EI:…,rhoA:…,tip:…,radius:…,inertia:…,hub:…,EA:…,GA:…,rhoI:…"


def add_similar(kinds: Verbs) -> None:
    """Add ``flex similar``."""
    parser = kinds.add_parser("similar", help="the counter-arm that bends like a given arm")
    parser.add_argument(
        "--arm", type=arm_of, required=True, metavar="length:…,EI:…",
        help=f"the arm to balance, in SI units: {ITEMS}; tip, radius and inertia are of the "
        "body at its tip",
    )  # fmt: skip
    other = parser.add_mutually_exclusive_group(required=True)
    other.add_argument(
        "--scale", type=positive_number, metavar="F", help="length over that of the arm"
    )
    other.add_argument(
        "--against", dest="other_arm", type=arm_of, metavar="length:…,EI:…",
        help="a counter-arm to compare",
    )  # fmt: skip
    parser.add_argument(
        "--spin", type=spin_numbers, metavar="SPEED,RISE[,DURATION]",
        help="simulate both on one hub that reaches SPEED (rad/s) in RISE seconds",
    )  # fmt: skip
    parser.add_argument(
        "--translator", type=translator_numbers, metavar="pitch:…,mass:…,length:…,breadth:…",
        help="simulate a block that two such arms move, on hubs at a pitch, and a similar "
        "block on the counter-arms; hubmass: mass of a hub. SI units",
    )  # fmt: skip
    parser.add_argument(
        "--moment", type=moment_numbers, metavar="VALUE,RISE[,DURATION]",
        help="moment on the translator that reaches VALUE (N m) in RISE seconds",
    )  # fmt: skip
    parser.add_argument(
        "--both-hubs", action="store_true",
        help="the moment drives both hubs, by half on each; otherwise the lower one",
    )  # fmt: skip
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

    def files() -> Files:
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
        files=files,
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
        Block(given["mass"], given["length"], given["breadth"]), given["pitch"],
        given.get("hubmass", 0.0), value, rise, arguments.both_hubs,
    )  # fmt: skip
    with progress_bar("instants") as advance:
        return simulate_translator(
            translator, (first, second), more[0] if more else 10.0 * rise, progress=advance
        )
