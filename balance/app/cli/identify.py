"""The command ``balance identify``: its options, and its answer."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.number_arguments import add_about, gravity, number_between, whole_number
from balance.app.cli.outputs import (
    add_page_option,
    add_picture_option,
    describe_written,
    result_files,
)
from balance.app.cli.progress import progress_bar, spinner
from balance.app.cli.quiet import add_limit, limits_by_name
from balance.support.options import GRAVITY

if TYPE_CHECKING:
    from balance.masses.identification.exciting_motion import ExcitingMotion
    from balance.masses.identification.identification import Identification

# Options that only a measurement has, and those that only a plan has.
MEASURED = ("measured", "wrench", "gravity", "about", "prior", "cutoff")
NUMBERS = ("duration", "harmonics", "seed", "tries")
PLANNED = (*NUMBERS, "max_velocity", "max_acceleration")


def add_identify(parser: Parser) -> None:
    """Add the options of the command ``identify``."""
    parser.description = (
        "Masses from measured motions and loads, as far as balance depends on them; --plan: a "
        "motion to measure. Exits with 1 if some are not determined."
    )
    add_model_options(parser, unused=("--motion",))
    parser.set_defaults(run=_run)
    _add_measured_options(parser.group("motion"))
    _add_planned_options(parser.group("motion"))
    parser.group("output").add_argument(
        "--out", metavar="FILE", help="write the linkage with these masses, or the plan"
    )
    add_picture_option(parser)
    add_page_option(parser, "with loads and masses, or the plan")
    parser.add_examples(
        "balance identify robot.urdf --plan --duration 5 --out motion.csv",
        "balance identify robot.urdf --motion m.csv --wrench l.csv --out real.urdf",
    )


def _add_measured_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of what was measured."""
    group.add_argument(
        "--motion",
        dest="measured",
        action="append",
        metavar="FILE.csv",
        help="motion: time and the inputs; repeatable",
    )
    group.add_argument(
        "--wrench",
        action="append",
        metavar="FILE.csv",
        help="loads along it: time, some of fx,fy,fz,mx,my,mz and of the inputs",
    )
    group.add_argument(
        "--gravity",
        type=gravity,
        metavar="X,Y,Z",
        help="acceleration of gravity (0,0,-9.81)",
    )
    add_about(group, "the origin")
    group.add_argument(
        "--on-linkage", action="store_true", help="the wrench acts on the linkage, not the base"
    )
    group.add_argument(
        "--offset", action="store_true", help="each load has an unknown constant"
    )
    group.add_argument(
        "--friction", action="store_true", help="drives have viscous and dry friction"
    )
    group.add_argument("--rotors", action="store_true", help="drives have rotors, too")
    group.add_argument(
        "--cutoff",
        type=number_between(1e-6, 1e6),
        metavar="HZ",
        help="filter motion and loads below it (noisy positions)",
    )
    group.add_argument(
        "--prior",
        type=number_between(1e-6, 1e6),
        metavar="P",
        help="relative error of the masses of the file (0.3)",
    )


def _add_planned_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of a motion to be measured."""
    group.add_argument("--plan", action="store_true", help="plan a motion that excites masses")
    group.add_argument(
        "--duration", type=number_between(1e-6, 1e6, "time"), metavar="S", help="seconds (5)"
    )
    group.add_argument(
        "--harmonics", type=whole_number(2, 50), metavar="N", help="harmonics of it (4)"
    )
    add_limit(group, "velocity", "largest speed, rad/s or m/s; repeatable")
    add_limit(group, "acceleration", "the same, rad/s² or m/s²")
    group.add_argument(
        "--tries", type=whole_number(1, 1_000_000), metavar="N", help="motions tried (250)"
    )
    group.add_argument(
        "--seed", type=whole_number(0, 10**17), metavar="N", help="seed of the search (0)"
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Identify the masses of the options, or plan a motion.

    Raises:
        LinkageError: the file, the linkage, or a table cannot be used.
        SystemExit: options exclude each other.
    """
    _refuse_exclusive_options(arguments)
    if arguments.plan:
        plan = _plan(arguments)
        from balance.app.answers.text.identification import plan_body

        return Answer(
            DONE,
            plan.to_dict,
            lambda: plan_body(plan),
            plan.notices,
            describe_written(arguments, True),
            lambda: {"out": plan.table, **result_files(arguments, plan)},
        )
    with spinner("identifying masses"):
        answer = _identify(arguments)
    from balance.app.answers.text.identification import identification_body

    return Answer(
        DONE if answer.complete else NEGATIVE,
        answer.to_dict,
        lambda: identification_body(answer),
        answer.notices,
        describe_written(arguments, True),
        lambda: {"out": answer.to_urdf, **result_files(arguments, answer)},
    )


def _refuse_exclusive_options(arguments: argparse.Namespace) -> None:
    """End the command if its options exclude each other."""
    if arguments.plan:
        refuse_given(arguments, MEASURED, "{}: not with --plan, before anything is measured")
        for name in ("on_linkage", "offset", "friction", "rotors"):
            if getattr(arguments, name):
                option = f"--{name.replace('_', '-')}"
                arguments.refuse(f"{option}: not with --plan, before anything is measured")
        return
    refuse_given(arguments, PLANNED, "{}: only with --plan")
    if arguments.measured is None or arguments.wrench is None:
        arguments.refuse("give --motion and --wrench, or --plan for a motion to measure")
    motions, loads = len(arguments.measured), len(arguments.wrench)
    if motions != loads:
        arguments.refuse(
            f"give one --wrench for each --motion, in the same order, not {loads} for {motions}"
        )


def _identify(arguments: argparse.Namespace) -> Identification:
    """Identify the masses."""
    linkage = load_model(arguments, arguments.angles)
    # Load the libraries only after the file is accepted.
    from balance.masses.identification.identify import PRIOR, identify

    return identify(
        linkage,
        arguments.measured,
        arguments.wrench,
        about=arguments.about,
        gravity=GRAVITY if arguments.gravity is None else arguments.gravity,
        on_linkage=arguments.on_linkage,
        offset=arguments.offset,
        friction=arguments.friction,
        rotors=arguments.rotors,
        cutoff=arguments.cutoff,
        prior=PRIOR if arguments.prior is None else arguments.prior,
        balance=arguments.balance,
        spatial=arguments.spatial,
    )


def _plan(arguments: argparse.Namespace) -> ExcitingMotion:
    """Plan a motion to measure."""
    linkage = load_model(arguments, arguments.angles)
    from balance.masses.identification.exciting_motion import exciting_motion

    chosen = {name: getattr(arguments, name) for name in NUMBERS}
    options: dict[str, Any] = {name: x for name, x in chosen.items() if x is not None}
    with progress_bar("motions") as advance:
        return exciting_motion(
            linkage,
            velocity=limits_by_name(linkage, arguments.max_velocity or ()),
            acceleration=limits_by_name(linkage, arguments.max_acceleration or ()),
            balance=arguments.balance,
            spatial=arguments.spatial,
            progress=advance,
            **options,
        )
