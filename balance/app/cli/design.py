"""The command ``balance design``: its options, and its answer."""

from __future__ import annotations

import argparse
import math
from functools import partial
from os.path import isfile
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser
from balance.app.cli.counterweights import (
    add_counterweight_options,
    check_counterweight_options,
    run_counterweights,
)
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.model_options import add_model_options
from balance.app.cli.model_readings import certified_space
from balance.app.cli.number_arguments import positive_number, whole_number
from balance.app.cli.outputs import add_page_option, describe_written
from balance.app.cli.partial import add_partial_options, check_partial_options, run_partial
from balance.app.cli.requirement_options import (
    add_requirement_options,
    check_requirement_options,
)
from balance.app.cli.spinner import spinner

if TYPE_CHECKING:
    from balance.masses.designs.best_design import Design
    from balance.space.spaces.design_space import DesignSpace


OBJECTIVES = ("mass", "inertia", "rotor", "change")


def add_design(parser: Parser) -> None:
    """Add the options of the command ``design``."""
    parser.description = (
        "Masses, centres of mass and inertias that balance a linkage and that "
        "bodies can have, or a certificate that there are none. Exits with 0 if there is a "
        "design, 1 if there is none, 4 if that is undecided."
    )
    add_model_options(parser)
    add_requirement_options(parser)
    parser.set_defaults(run=_run)
    parser.add_argument(
        "--max-order", type=whole_number(0, 50, "an order"), metavar="K",
        help="0: balance at the reference pose alone, see --at; more: only the conditions of "
        "orders 0 to K count, which leaves designs undecided",
    )  # fmt: skip
    parser.add_argument(
        "--minimise", "--minimize", choices=OBJECTIVES,
        help="the best design in this respect: total mass, largest inertia, inertia that the "
        "inputs feel at the reference pose, or change of the masses in the file",
    )  # fmt: skip
    parser.add_argument(
        "--keep", action="append", default=[], metavar="L",
        help="link whose mass and inertia stay as the file gives them; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--bounds", action="append", type=_bounds, default=[], metavar="L=LO:HI",
        help="least and largest mass of a link in kg, either may be left out; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--density", action="append", type=_density, default=[], metavar="[L=]KG/M3",
        help="largest density of a link, or of all that no other --density names, in kg/m³ "
        "(steel: 7850); repeatable. Without --minimise, the design changes the masses least",
    )  # fmt: skip
    parser.add_argument(
        "--thickness", type=positive_number, metavar="METRES",
        help="thickness of the links of a planar linkage, which --density needs there",
    )  # fmt: skip
    parser.add_argument(
        "--anywhere", action="store_true",
        help="let masses be anywhere, not just within 1.5 lengths of each link from the middle "
        "of its joints",
    )  # fmt: skip
    add_counterweight_options(parser)
    add_partial_options(parser)
    parser.add_argument(
        "--out", metavar="FILE.urdf",
        help="write the file of the linkage with the masses of the design",
    )  # fmt: skip
    add_page_option(parser, "with the linkage and its masses, before and after")


def _run(arguments: argparse.Namespace) -> Answer:
    """Compute the design of the options."""
    check_requirement_options(arguments, ("max_order", "partial", "pareto"))
    check_counterweight_options(arguments)
    check_partial_options(arguments)
    if arguments.partial:
        return run_partial(arguments)
    if arguments.add:
        return run_counterweights(arguments)
    with spinner("finding the mass distributions that balance"):
        space = certified_space(arguments)
        design = _design(arguments, space)
    from balance.app.answers.text.design import design_body

    # For one pose, the conditions there are all there are.
    notices = tuple(
        notice for notice in space.warnings
        if arguments.max_order != 0 or notice.code != "not_settled"
    )  # fmt: skip
    remark = describe_written(arguments, design.z is not None)
    if arguments.out and design.z is not None:
        remark += f"; to {_checked_claim(arguments)}: {_verify_command(arguments, design)}"
    return Answer(
        verdict_code(design.verdict),
        design.to_dict,
        lambda: design_body(design),
        notices,
        remark,
        lambda: _files(design),
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
    return design(
        space, arguments.minimise, keep=arguments.keep, bounds=limits, within=within,
        one_pose=arguments.max_order == 0, density=_densities(arguments, space.bodies),
        thickness=arguments.thickness,
    )  # fmt: skip


def _densities(
    arguments: argparse.Namespace, bodies: tuple[str, ...]
) -> float | dict[str, float] | None:
    """Collect densities by link; of two for the same links the lower one holds."""
    named: dict[str, float] = {}
    for name, value in arguments.density:
        named[name] = min(named.get(name, value), value)
    rest = named.pop("", None)
    if rest is None:
        return named or None
    if not named:
        return rest
    others = (name for name in bodies if name not in arguments.keep)
    return {name: rest for name in others} | named


def _files(design: Design) -> Files:
    """Find what makes the files of a design, if there is one."""
    from balance.app.answers.html.design import design_page
    from balance.masses.designs.write_urdf import replace_inertials

    if design.z is None:
        return {}
    elements = {body.name: body.urdf for body in design.bodies
                if body.name not in design.keep and body.urdf}  # fmt: skip
    return {
        "out": partial(replace_inertials, design.space.linkage, elements),
        "html": partial(design_page, design),
    }


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
    loops = arguments.loops or _loop_file(design, arguments.out)
    # Other formats, and files from which links were left out, are written with their ground.
    lists = (("--inputs", arguments.inputs), ("--massless", arguments.massless))
    pairs = [("--loops", loops), *((flag, ",".join(names or ())) for flag, names in lists)]
    pairs += [("--motion", relation) for relation in arguments.motion or ()]
    pairs += [("--require", text) for text in arguments.require]
    words += [word for flag, value in pairs if value for word in (flag, value)]
    if arguments.at:
        words += ["--at", ",".join(f"{name}={value!r}" for name, value in arguments.at.items())]
    words += ["--mode", str(arguments.mode)] if arguments.mode else []
    words += ["--fix-base"] * arguments.fix_base
    words += ["--as-written"] * (arguments.angles == "as_written")
    if arguments.gravity:
        words.append(f"--gravity={','.join(map(repr, arguments.gravity))}")
    words += ["--balance", "force"] * (arguments.balance == "force")
    return shlex.join(words)


def _loop_file(design: Design, out: str) -> str | None:
    """Return the loop file of the model, if ``out`` has no loop file of that name."""
    from kinematics.files.urdf.loop_file import loop_file_of

    linkage = design.space.linkage
    streamed = not isfile(linkage.source)
    if streamed or any(notice.code == "loops_ignored" for notice in linkage.notices):
        return None
    file = loop_file_of(linkage.source)
    return None if file == loop_file_of(out) else file


def _density(text: str) -> tuple[str, float]:
    """Parse name and density of ``L=KG/M3``; the name of all others is empty."""
    name, equals, value = text.rpartition("=")
    if equals and not name:
        raise argparse.ArgumentTypeError(f"'{text}' names no link; write crank=2700, or 2700")
    return name, positive_number(value)


def _bounds(text: str) -> tuple[str, float, float]:
    """Parse name and limits of ``L=LO:HI``."""
    name, _, limits = text.rpartition("=")
    low, colon, high = limits.partition(":")
    try:
        least, most = float(low or 0.0), float(high or math.inf)
    except ValueError:
        least = math.nan
    if not (name and colon and math.isfinite(least) and not math.isnan(most)):
        raise argparse.ArgumentTypeError(f"'{text}' is not L=LO:HI, such as crank=0.5:2")
    return name, least, most
