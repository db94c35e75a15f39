"""The command ``balance verify``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from os.path import isfile
from typing import TYPE_CHECKING, Any

from balance.app.answers.answer import Answer, Files, side_by_side
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE, UNDECIDED
from balance.app.cli.floating_base import (
    add_base_options,
    check_base_options,
    run_floating_base,
)
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.model_readings import ReadFile, load_readings, solve_model, solve_readings
from balance.app.cli.motion_source import (
    add_other_motion,
    motions_of,
    notices_of,
    random_motions_remark,
)
from balance.app.cli.number_arguments import add_about, gravity, whole_number
from balance.app.cli.outputs import (
    add_meshes_option,
    add_page_option,
    add_picture_option,
    add_table_option,
    result_files,
)
from balance.app.cli.progress import progress_bar
from balance.app.cli.several_models import (
    add_other_models,
    compared,
    data_against,
    named_notices,
)
from balance.app.cli.short_notices import notices_by_file
from balance.support.units import UnitNumber, read_quantity
from kinematics.errors import LinkageError, UsageError

if TYPE_CHECKING:
    from balance.motion.verification.holding_torques import HoldingTorques
    from balance.motion.verification.verification import Verification
    from kinematics.model.linkage import Linkage, Notice


# What tolerances are given of, and the largest length, metres.
TOLERATED = ("mass", "length", "com")
MOST_LENGTH = 1e6
# Default number of random motions.
TRAJECTORIES = 10


def add_verify(parser: Parser) -> None:
    """Add the options of the command ``verify``."""
    parser.description = (
        "Whether a linkage with the masses of its file shakes its base, by Pinocchio and by "
        "our own series. Exits with 0 if it is balanced, 1 if not, 4 if the two disagree."
    )
    add_model_options(parser)
    add_other_models(parser)
    parser.set_defaults(run=_run)
    _add_motion_options(parser.group("motion"))
    add_base_options(parser.group("base"))
    check = parser.group("check")
    check.add_argument(
        "--tolerance",
        type=_tolerance,
        metavar="T",
        help="part of the bodies' inertia forces that counts as balanced (default 1e-9); or "
        "what is made how well, mass=2%%,length=0.1mm,com=1mm: worst case and spread",
    )
    check.add_argument(
        "--against",
        metavar="MODEL",
        help="the linkage before, on the same motions, moments about its middle",
    )
    add_about(check, "the middle")
    check.add_argument(
        "--gravity", type=gravity, metavar="X,Y,Z", help="show what inputs hold at rest (m/s²)"
    )
    add_picture_option(parser)
    add_page_option(parser, "on which the linkage moves")
    add_meshes_option(parser)
    add_table_option(parser.group("output"), "write motion and shaking over time")
    parser.add_examples(
        "balance verify robot.urdf --speed 300rpm",
        "balance verify balanced.urdf --against robot.urdf",
        "balance verify robot.urdf --trajectories 3 --table shaking.csv --html page.html",
    )


def _add_motion_options(group: argparse._ArgumentGroup) -> None:
    """Add the options for the motion of the inputs."""
    group.add_argument(
        "--trajectories",
        type=whole_number(1, 10_000),
        metavar="N",
        help=f"number of random motions (default {TRAJECTORIES})",
    )
    group.add_argument(
        "--seed", type=_seed, metavar="S", help="seed of the random motions (default 0)"
    )
    source = group.add_mutually_exclusive_group()
    add_other_motion(source)


def _run(arguments: argparse.Namespace) -> Answer:
    """Verify the linkages of the options; the first decides, or of several models the worst."""
    _refuse_exclusive_options(arguments)
    if arguments.base != "fixed":
        return run_floating_base(arguments)
    with progress_bar("motions") as advance:
        results = _verify(arguments, advance)
    from balance.app.answers.text.verification import (
        holding_body,
        verification_body,
        verification_facts,
    )

    def prepare_files() -> Files:
        return _prepare_verification_files(arguments, results)

    held = _holding(arguments, results)
    if isinstance(arguments.tolerance, dict):
        return _with_tolerances(arguments, results[0], prepare_files)
    if not arguments.others:
        return Answer(
            _code(results[0]),
            lambda: _data(results) | ({"holding": held[0].to_dict()} if held else {}),
            lambda: [*verification_body(results), *holding_body(held)],
            _notices(results),
            random_motions_remark(arguments, results[0].linkage, results[0].motions),
            prepare_files,
        )
    return Answer(
        max(map(_code, results)),
        lambda: compared("verify", [_data([result]) for result in results]),
        lambda: side_by_side(list(map(verification_facts, results))),
        named_notices((result.linkage, result.notices) for result in results),
        files=prepare_files,
    )


def _with_tolerances(
    arguments: argparse.Namespace, result: Verification, prepare_files: Callable[[], Files]
) -> Answer:
    """Add to a verification what shakes if the linkage is made within tolerances."""
    from balance.app.answers.text.manufacture import tolerance_body
    from balance.app.answers.text.verification import verification_body
    from balance.motion.manufacture.analyse import shaking_tolerance

    spread = shaking_tolerance(
        result.linkage,
        motions=result.motions,
        about=result.point,
        seed=arguments.seed or 0,
        **arguments.tolerance,
    )
    return Answer(
        _code(result),
        lambda: _data([result]) | {"tolerances": spread.to_dict()},
        lambda: [*verification_body([result]), "", *tolerance_body(spread)],
        result.notices,
        random_motions_remark(arguments, result.linkage, result.motions),
        prepare_files,
    )


def _holding(
    arguments: argparse.Namespace, results: Sequence[Verification]
) -> list[HoldingTorques]:
    """Compute what the inputs hold against gravity along the motions, if that is asked for."""
    if arguments.gravity is None:
        return []
    from balance.motion.verification.holding_torques import holding_along

    return [holding_along(result, arguments.gravity) for result in results]


def _data(results: Sequence[Verification]) -> dict[str, object]:
    """Collect the data of a verification, and of that of a second linkage."""
    from balance.app.answers.text.verification import comparison_sentence

    return data_against(*results) | {"sentence": comparison_sentence(results)}


def _code(verification: Verification) -> int:
    """Return the exit code of a verification."""
    if not verification.decided:
        return UNDECIDED
    return DONE if verification.balanced else NEGATIVE


def _verify(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> list[Verification]:
    """Verify all linkages of the options.

    Args:
        advance: called with the number of motions done and the number of all motions.

    Raises:
        LinkageError: a linkage, a motion, a file or a library cannot be used.
    """
    options = _options(arguments) | {"progress": advance}

    def verify_first(linkage: Linkage) -> Verification:
        # Load the kernels only after the file is accepted.
        from balance.motion.verification.verify_motions import verify

        motions = None
        if arguments.csv or arguments.tool_path:
            motions = motions_of(arguments, linkage)
        verification = verify(linkage, motions=motions, **options)
        told = notices_of(linkage, motions)
        return replace(verification, notices=(*verification.notices, *told))

    def verify_other(linkage: Linkage) -> Verification:
        from balance.motion.verification.verify_motions import verify_second

        return verify_second(first, linkage, **options)

    others = [arguments.against] if arguments.against else arguments.others
    for model in others:
        # Refuse a file that is not there before the first linkage is verified.
        if isinstance(model, str) and not isfile(model):
            load_model(arguments, arguments.angles, model)
    readings = [load_readings(arguments, model) for model in others]
    if arguments.against is not None and arguments.about is None:
        options |= _choose_point(readings[0][0])
    first = solve_model(arguments, verify_first)
    return [first, *(solve_readings(files, verify_other) for files in readings)]


def _choose_point(before: ReadFile) -> dict[str, object]:
    """Choose the point of the moments: the middle of the linkage before, if it can be read."""
    if isinstance(before.linkage, LinkageError):
        # The verification of this file raises the error, with the other reading of angles.
        return {}
    from balance.motion.verification.comparison import middle_of

    return {"about": middle_of(before.linkage)}


def _notices(results: Sequence[Verification]) -> list[Notice]:
    """List the notices on a linkage, or on two, with the file of each."""
    if len(results) == 1:
        return list(results[0].notices)
    linkages = [each.linkage for each in results]
    return notices_by_file(linkages, [each.notices for each in results])


def _refuse_exclusive_options(arguments: argparse.Namespace) -> None:
    """End the command if its options exclude each other."""
    check_base_options(arguments)
    if arguments.speed is not None:
        random = "{}: not with --speed, whose one motion is not random"
        refuse_given(arguments, ("trajectories", "seed"), random)
    if arguments.others and arguments.against is not None:
        arguments.refuse("--against: not with several models; name it among them")
    if arguments.about is not None and arguments.base != "fixed":
        arguments.refuse("--about: not with --base, which tells no moments")
    if arguments.gravity is not None:
        if arguments.others or arguments.base != "fixed":
            arguments.refuse("--gravity: what is held is shown of a linkage on a fixed base")
        if isinstance(arguments.tolerance, dict):
            arguments.refuse("--gravity: not with --tolerance mass=…; ask for each")
        if not any(arguments.gravity):
            arguments.refuse("--gravity 0,0,0: nothing is held; give a direction")
    if isinstance(arguments.tolerance, dict):
        if arguments.others or arguments.against is not None:
            arguments.refuse("--tolerance mass=…: not with a second linkage; ask for each")
        if arguments.base != "fixed":
            arguments.refuse("--tolerance mass=…: not with --base, which moves")
    if arguments.others and arguments.base != "fixed":
        arguments.refuse("--base: not with several models; --against compares two")
    if arguments.table is not None and (arguments.against is not None or arguments.others):
        arguments.refuse("--table: not with a second linkage; write a table for each")


def _options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of `verify` from the options."""
    crank, speed = arguments.speed or (None, None)
    options = {
        "motion": arguments.motion,
        "balance": arguments.balance,
        "trajectories": arguments.trajectories or TRAJECTORIES,
        "seed": arguments.seed or 0,
        "speed": speed,
        "crank": crank,
        "about": arguments.about,
    }
    if isinstance(arguments.tolerance, float):
        options["tolerance"] = arguments.tolerance
    return options


def _prepare_verification_files(
    arguments: argparse.Namespace, results: Sequence[Verification]
) -> Files:
    """Prepare the makers of the files of verifications."""
    from balance.app.answers.html.verification import verification_table

    return {
        **result_files(arguments, *results, meshes=not arguments.no_meshes),
        "table": partial(verification_table, results[0]),
    }


def _seed(text: str) -> int:
    """Parse a seed."""
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 0 up")
    return int(text)


def _tolerance(text: str) -> float | dict[str, float]:
    """Parse a tolerance of the verdict, or of ``mass=2%,length=0.1mm,com=1mm``."""
    if "=" in text:
        return _tolerances(text)
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0 up to 1")
    return value


def _tolerances(text: str) -> dict[str, float]:
    """Parse ``mass=2%,length=0.1mm,com=1mm``."""
    values: dict[str, float] = {}
    for word in text.split(","):
        name, _, number = (part.strip() for part in word.partition("="))
        percent = name == "mass" and number.endswith("%")
        try:
            value = read_quantity(number.removesuffix("%") if percent else number, "length")
        except UsageError:
            value = -1.0
        value = value / 100.0 if percent else value
        most = 1.0 if name == "mass" else MOST_LENGTH
        wrong = name not in TOLERATED or name in values or not 0.0 <= value < most
        if wrong or (name == "mass" and isinstance(value, UnitNumber)):
            raise argparse.ArgumentTypeError(
                f"'{word}' is not one of mass=2%, length=0.1mm, com=1mm, each once"
            )
        values[name] = float(value)
    if not any(values.values()):
        raise argparse.ArgumentTypeError(f"'{text}' has no tolerance above 0")
    return values
