"""The command ``balance remedies``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from shlex import join
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser
from balance.app.cli.density_options import add_density_option
from balance.app.cli.exit_codes import DONE, verdict_code
from balance.app.cli.implausible_request import note_implausible_masses
from balance.app.cli.matter_options import add_matter_options, check_matter_options
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.next_command import reduce_command, without_options
from balance.app.cli.number_arguments import (
    add_workers,
    positive_number,
    positive_quantity,
    whole_number,
)
from balance.app.cli.outputs import (
    add_page_option,
    add_picture_option,
    check_folder,
    describe_written,
    join_remarks,
    result_files,
)
from balance.app.cli.progress import print_on_terminal, progress_bar
from balance.masses.counterweights.link_regions import ALL, regions_by_name
from balance.masses.remedies.catalogue import CATALOGUE, remedy_named
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.masses.remedies.applied import AppliedRemedy
    from balance.masses.remedies.compare import RemedyComparison
    from balance.masses.remedies.request import RemedyRequest


# What to write in place of an option of another command.
ELSEWHERE = {
    "--speed": "balance shafts hold at any constant speed, and most remedies in any motion; "
    "balance verify FILE --speed gives the loads of a file of --out",
}


def add_remedies(parser: Parser) -> None:
    """Add the options of the command ``remedies``."""
    parser.description = (
        "Applies the remedies of the literature to a linkage: counter-rotations, "
        "transmissions, duplicates, added dyads, driven wheels, constraints. Exits with 0 if "
        "one balances it, or all of --only shake less; 1 if none does, 4 if undecided."
    )
    parser.epilog = f"remedies: {', '.join(CATALOGUE)}"
    parser.elsewhere |= ELSEWHERE
    add_model_options(parser)
    parser.set_defaults(run=_run)
    add_matter_options(parser, "links that may get matter (default: all)")
    group = parser.group("matter")
    group.add_argument(
        "--only", type=_remedies, default=[], metavar="R1,R2", help="only these remedies"
    )
    group.add_argument(
        "--gear",
        type=positive_number,
        default=1.0,
        metavar="N",
        help="turns of a counter-rotor a turn (default 1)",
    )
    group.add_argument(
        "--rotor-radius",
        type=positive_quantity("length"),
        metavar="METRES",
        help="of rotors and wheels (default: chosen by size)",
    )
    group.add_argument(
        "--budget",
        type=positive_quantity("mass"),
        metavar="KG",
        help="of partial balance (default: mass of the links)",
    )
    group.add_argument(
        "--trade-off",
        type=whole_number(2, 50),
        default=0,
        metavar="N",
        help="also N points of mass against input inertia",
    )
    add_workers(group, keeps_results=False)
    add_density_option(parser, "matter")
    parser.group("output").add_argument(
        "--out",
        metavar="DIR",
        help="folder for the files of the remedies that help",
    )
    add_picture_option(parser, "draw added mass against input inertia")
    add_page_option(parser, "with added mass against input inertia")


def _run(arguments: argparse.Namespace) -> Answer:
    """Apply the remedies of the options.

    Raises:
        LinkageError: the file, the linkage, a link or a region cannot be used.
    """
    check_matter_options(arguments)
    if arguments.out is not None:
        check_folder(arguments.out)
    with progress_bar("steps of the search") as advance:
        request = _request(arguments, advance)
        from balance.masses.remedies.compare import compare_request, remedy_files

        comparison = compare_request(request, arguments.only, _print_result, arguments.workers)
    from balance.app.answers.text.remedies import remedies_body

    bodies = request.linkage.body_names
    links = [] if arguments.links else list(bodies) if ALL in bodies else [ALL]
    comparison = replace(
        comparison,
        following=_following(arguments, comparison),
        reduce=reduce_command(arguments, request.given_mass, links),
    )
    helps = any(applied.helps for applied in comparison.results)
    undrawn = [] if helps else ["out", "plot"]
    unwritten = ", ".join(filter(None, (getattr(arguments, name) for name in undrawn)))
    return Answer(
        DONE if comparison.verdict == "partial" else verdict_code(comparison.verdict),
        comparison.to_dict,
        lambda: remedies_body(comparison),
        (
            *comparison.request.space.warnings,
            *note_implausible_masses(request.linkage, [("--budget ", arguments.budget or 0.0)]),
        ),
        join_remarks(
            describe_written(
                arguments,
                True,
                without=undrawn,
                inside={"out": [*remedy_files(comparison.results)]},
            ),
            f"not written, for no remedy helps: {unwritten}" if unwritten else "",
            _describe_tables(arguments.out, comparison),
        ),
        lambda: _prepare_remedy_files(arguments, comparison),
    )


def _following(arguments: argparse.Namespace, comparison: RemedyComparison) -> str:
    """Write the command that makes the file of the first choice; empty if it is made."""
    from balance.app.answers.text.remedies import first_choice

    first = first_choice(comparison)
    if first is None or arguments.out is not None:
        return ""
    kept = without_options(arguments.words, {"--only": 1, "--html": 1, "--plot": 1})
    return join(["balance", "remedies", *kept, "--only", first.remedy, "--out", "built"])


def _describe_tables(folder: str | None, comparison: RemedyComparison) -> str:
    """Say how to verify files whose added inputs follow a table of motion."""
    from balance.masses.remedies.compare import name_files

    if folder is None:
        return ""
    commands = [
        join(
            [
                "balance",
                "verify",
                f"{folder}/{stem}.urdf",
                "--csv",
                f"{folder}/{stem}_motion.csv",
            ]
        )
        for stem, applied in name_files(comparison.results)
        if "motion.csv" in applied.files
    ]
    return f"balanced as their tables of motion move: {'; '.join(commands)}" if commands else ""


def _print_result(applied: AppliedRemedy) -> None:
    """Print a result on the terminal while others are computed; the bar is drawn below."""
    added = "" if applied.added_mass is None else f", {applied.added_text}"
    print_on_terminal(f"{applied.short}: {applied.verdict}{added}")


def _prepare_remedy_files(arguments: argparse.Namespace, comparison: RemedyComparison) -> Files:
    """Prepare the makers of page and picture, and of the files of the remedies that help."""
    from balance.masses.remedies.compare import remedy_files

    files = dict(result_files(arguments, comparison))
    files["out"] = partial(remedy_files, comparison.results)
    if not any(applied.helps for applied in comparison.results):
        del files["plot"], files["out"]
    return files


def _request(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> RemedyRequest:
    """Build the request of the options."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.masses.remedies.request import RemedyRequest

    return RemedyRequest(
        linkage,
        tuple(arguments.motion or ()),
        arguments.balance,
        tuple(arguments.links),
        regions_by_name(linkage, arguments.links or (ALL,), dict(arguments.region)),
        arguments.gear,
        arguments.rotor_radius,
        arguments.budget,
        spatial=arguments.spatial,
        angles=arguments.angles,
        progress=advance,
        trade_off=arguments.trade_off,
        density=arguments.density,
    )


def _remedies(text: str) -> list[str]:
    """Parse names of remedies of ``a,b``."""
    try:
        return [remedy_named(name) for name in text.split(",")]
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
