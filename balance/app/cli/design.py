"""The command ``balance design``: its options, and its answer."""

from __future__ import annotations

import argparse
import math
from os.path import isfile
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser
from balance.app.cli.density_options import add_density_options, densities_of
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.implausible_request import note_implausible_masses
from balance.app.cli.model_options import add_model_options, model_words
from balance.app.cli.model_readings import certified_space
from balance.app.cli.next_command import reduce_command
from balance.app.cli.number_arguments import whole_number
from balance.app.cli.outputs import (
    add_out_option,
    add_page_option,
    describe_written,
    result_files,
)
from balance.app.cli.payload_option import add_payload_option
from balance.app.cli.progress import spinner
from balance.app.cli.requirement_options import (
    add_requirement_options,
    check_requirement_options,
)
from balance.support.units import read_quantity
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.masses.designs.best_design import Design
    from balance.space.spaces.design_space import DesignSpace


OBJECTIVES = ("mass", "inertia", "rotor", "change")


def add_design(parser: Parser) -> None:
    """Add the options of the command ``design``."""
    parser.description = (
        "Masses of the links' own that balance a linkage and that bodies can have, or a "
        "certificate that there are none. Exits with 0 if there are, 1 if not, 4 if undecided."
    )
    add_model_options(parser)
    add_requirement_options(parser)
    parser.set_defaults(run=_run)
    parser.group("motion").add_argument(
        "--max-order",
        type=whole_number(0, 50, "an order"),
        metavar="K",
        help="only orders 0 to K; 0: at the reference pose alone",
    )
    _add_mass_options(parser)
    add_out_option(parser)
    add_page_option(parser, "with the masses before and after")
    parser.add_examples(
        "balance design robot.urdf",
        "balance design robot.urdf --minimise mass --bounds coupler=0.1:1",
        "balance design robot.urdf --density 7850 --thickness 0.01 --out built.urdf",
    )


def _add_mass_options(parser: Parser) -> None:
    """Add the options for the masses that links may have."""
    group = parser.group("matter")
    group.add_argument(
        "--minimise",
        choices=OBJECTIVES,
        metavar="WHAT",
        help="mass, inertia, rotor (of the inputs), change",
    )
    group.add_argument(
        "--keep",
        action="append",
        default=[],
        metavar="L",
        help="link that stays as in the file; repeatable",
    )
    group.add_argument(
        "--bounds",
        action="append",
        type=_bounds,
        default=[],
        metavar="L=LO:HI",
        help="least and largest mass of a link, kg; repeatable",
    )
    add_payload_option(parser, ranges=False)
    add_density_options(parser, "matter", "planar links")
    group.add_argument(
        "--anywhere", action="store_true", help="masses may lie far from their links"
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Compute the design of the options."""
    check_requirement_options(arguments, ("max_order",))
    with spinner("finding the mass distributions that balance"):
        space = certified_space(arguments)
        design = _design(arguments, space)
    from balance.app.answers.text.design import design_body
    from balance.masses.payload import PAYLOAD_BODY

    bodies = [body for body in space.linkage.bodies if body.name != PAYLOAD_BODY]
    mass = sum(float(body.inertia[0]) for body in bodies)
    reduce = reduce_command(arguments, mass, [body.name for body in bodies])
    # For one pose, the conditions there are all there are.
    notices = tuple(
        notice
        for notice in space.warnings
        if arguments.max_order != 0 or notice.code != "not_settled"
    )
    heavy = note_implausible_masses(
        space.linkage, [(f"--bounds {name}=", least) for name, least, _ in arguments.bounds]
    )
    remark = describe_written(arguments, design.z is not None)
    if arguments.out and design.z is not None and arguments.payload is None:
        remark += f"; to {_checked_claim(arguments)}: {_verify_command(arguments, design)}"
    return Answer(
        verdict_code(design.verdict),
        design.to_dict,
        lambda: design_body(design, reduce, _anywhere_command(arguments, design)),
        notices + heavy,
        remark,
        lambda: (
            {}
            if design.z is None
            else {"out": design.to_urdf, **result_files(arguments, design)}
        ),
    )


def _design(arguments: argparse.Namespace, space: DesignSpace) -> Design:
    """Compute the design of the options.

    Raises:
        LinkageError: kept or bounded links are unknown, or all links are kept.
    """
    from balance.masses.designs.best_design import design
    from balance.masses.designs.mass_regions import BALL_RADIUS

    limits: dict[str, tuple[float, float]] = {}
    for name, low, high in arguments.bounds:
        least, most = limits.get(name, (low, high))
        limits[name] = max(least, low), min(most, high)
    within = None if arguments.anywhere else BALL_RADIUS
    keep = [
        name
        for word in arguments.keep
        for name in ([word] if word in space.bodies else word.split(","))
    ]
    if arguments.payload is not None:
        from balance.masses.payload import PAYLOAD_BODY

        keep.append(PAYLOAD_BODY)
    free = [name for name in space.bodies if name not in keep]
    return design(
        space,
        arguments.minimise,
        keep=keep,
        bounds=limits,
        within=within,
        one_pose=arguments.max_order == 0,
        density=densities_of(arguments, free),
        thickness=arguments.thickness,
    )


def _anywhere_command(arguments: argparse.Namespace, design: Design) -> str:
    """Write the same request for masses far from their links; empty if that has no design."""
    import shlex

    if design.anywhere is None or design.anywhere.verdict != "feasible":
        return ""
    return shlex.join(["balance", "design", *arguments.words, "--anywhere"])


def _checked_claim(arguments: argparse.Namespace) -> str:
    """Say what the command that follows shows: in one pose alone, ``as given`` is balanced."""
    if arguments.max_order == 0 or arguments.require:
        return "see 'as given balanced' for what was written"
    return "verify what was written"


def _verify_command(arguments: argparse.Namespace, design: Design) -> str:
    """Build the command that verifies the file of a design, with the same options.

    `balance verify` moves the linkage, and so finds that it is balanced in one pose alone:
    there, the residual of `balance report` at order 0 is the check.
    """
    import shlex

    one_pose = arguments.max_order == 0
    reported = one_pose or bool(arguments.require)
    words = ["balance", "report" if reported else "verify", arguments.out]
    words += ["--max-order", "0"] * one_pose
    # Other formats, and files from which links were left out, are written with their ground.
    loops = arguments.loops or _loop_file(design, arguments.out)
    return shlex.join([*words, *model_words(arguments, loops)])


def _loop_file(design: Design, out: str) -> str | None:
    """Return the loop file of the model, if ``out`` has no loop file of that name."""
    from kinematics.files.urdf.loop_file import loop_file_of

    linkage = design.space.linkage
    streamed = not isfile(linkage.source)
    if streamed or any(notice.code == "loops_ignored" for notice in linkage.notices):
        return None
    file = loop_file_of(linkage.source)
    return None if file == loop_file_of(out) else file


def _bounds(text: str) -> tuple[str, float, float]:
    """Parse name and limits of ``L=LO:HI``."""
    name, _, limits = text.rpartition("=")
    low, colon, high = limits.partition(":")
    try:
        least = read_quantity(low or "0", "mass")
        most = read_quantity(high or "inf", "mass")
        reason = ""
    except UsageError as error:
        least, reason = math.nan, f"; {error}" if name and colon else ""
    if not (name and colon and math.isfinite(least) and not math.isnan(most)):
        form = "L=LO:HI, such as crank=0.5:2"
        raise argparse.ArgumentTypeError(f"'{text}' is not {form}{reason}")
    return name, least, most
