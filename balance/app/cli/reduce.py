"""The command ``balance reduce``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.density_options import (
    add_density_options,
    check_density_options,
    densities_of,
)
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.implausible_request import note_implausible_masses
from balance.app.cli.matter_options import (
    add_matter_options,
    add_merge_option,
    add_move_option,
    check_matter_options,
    require_links,
)
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.motion_source import (
    MASSES_WHILE,
    add_motion_source,
    motions_of,
    random_motions_remark,
)
from balance.app.cli.number_arguments import (
    add_about,
    finite_number,
    finite_quantity,
    whole_number,
)
from balance.app.cli.outputs import (
    add_out_option,
    add_page_option,
    add_picture_option,
    describe_written,
    join_remarks,
)
from balance.app.cli.part_options import (
    add_parts_option,
    added_matter_files,
    check_parts_options,
    make_parts,
    notices_of_parts,
)
from balance.app.cli.payload_option import add_payload_option
from balance.app.cli.progress import progress_bar
from balance.app.cli.requirement_options import (
    add_requirement_options,
    check_requirement_options,
)
from balance.app.cli.shape_option import add_shape_option, check_shape_option

if TYPE_CHECKING:
    from balance.masses.partial_balance.elastic_frame import ElasticFrame
    from balance.masses.partial_balance.load_range import LoadsLeft
    from balance.masses.partial_balance.partial_balance import ParetoFront
    from balance.masses.partial_balance.shaking_objectives import PartialObjective
    from balance.masses.payload import Payload
    from kinematics.model.linkage import Linkage, Notice


# Largest budget, kilograms.
MOST_BUDGET = 1e9
# Options on the shaking along motions, and on what is made of it.
OF_MOTIONS = (
    *("csv", "tool_path", "speed", "about", "density", "thickness", "points", "shape"),
    *("minimise",),
    *("move", "pareto", "weight_moment", "max_bearing", "max_torque", "frame", "parts"),
    *("plot", "html"),
)
# What to write in place of options of `balance counterweights`.
ELSEWHERE = {
    "--max-order": "of balance counterweights alone; here the motions of --csv, --tool-path or "
    "--speed count",
    "--price-of-mass": "of balance counterweights alone; here --budget limits the mass",
}
# What may be least, the default first.
OBJECTIVES = ("rms", "peak", "torque", "bearing")


def add_reduce(parser: Parser) -> None:
    """Add the options of the command ``reduce``."""
    parser.description = (
        "The least shaking that matter buys; exit 1: none keeps the caps, 4: undecided."
    )
    add_model_options(parser, unused=("--spatial",), motion_alone=True)
    add_requirement_options(parser, explain=False)
    parser.set_defaults(run=_run)
    add_motion_source(parser.group("motion"), "random")
    add_about(parser.group("motion"), "the middle")
    add_matter_options(parser, "links that may get matter, or all", required=True)
    add_move_option(parser)
    add_payload_option(parser)
    add_density_options(parser, "matter", "plates on a planar linkage", points=True)
    add_shape_option(parser, "disc, block, sector, cylinder (--balance force)")
    _add_least_options(parser)
    parser.elsewhere |= ELSEWHERE
    add_out_option(parser)
    add_merge_option(parser)
    add_parts_option(parser)
    add_picture_option(parser, "what is left against the added mass")
    add_page_option(parser, "with the loads before and after")
    parser.add_examples(
        "balance reduce robot.urdf --links crank --speed 300rpm --budget 1.5",
        "balance reduce robot.urdf --links crank --budget 1 --require 'force; gravity'",
        "balance reduce robot.urdf --links crank --region crank=80mm --budget 0.6 \\\n"
        "    --balance force --shape sector=20mm --out quiet.urdf",
    )


def _add_least_options(parser: Parser) -> None:
    """Add the options for what is least, within which limits."""
    group = parser.group("matter")
    group.add_argument(
        "--budget",
        type=finite_quantity("mass"),
        metavar="KG",
        help="most mass to add; --pareto N: N designs to the best",
    )
    front = group.add_argument(
        "--pareto",
        type=whole_number(2, 1000),
        metavar="N",
        help="N designs from nothing to the least shaking",
    )
    front.told_beside = True  # type: ignore[attr-defined]
    group.add_argument(
        "--minimise",
        type=_objective,
        metavar="WHAT",
        help="rms (default), peak, torque, bearing, harmonics 1,2",
    )
    group.add_argument(
        "--weight-moment",
        type=finite_quantity("length"),
        metavar="METRES",
        help="so many N m count as 1 N (default: its length)",
    )
    group.add_argument(
        "--max-bearing",
        action="append",
        type=_cap("force"),
        default=[],
        metavar="JOINT=N",
        help="largest force; --max-torque JOINT=NM of a drive",
    )
    torque = group.add_argument(
        "--max-torque",
        action="append",
        type=_cap("torque", "force"),
        default=[],
        metavar="JOINT=NM",
        help="largest drive torque of an input; repeatable",
    )
    torque.told_beside = True  # type: ignore[attr-defined]
    group.add_argument(
        "--frame",
        type=_frame,
        metavar="M,I,K,D",
        help="least vibration of a frame: kg,kg m²,N/m,N s/m",
    )
    group.add_argument(
        "--weights",
        type=_weights,
        metavar="W1,W2",
        help="of the squares of --require, in their order (1)",
    )


def _check_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options contradict each other."""
    check_matter_options(arguments)
    require_links(arguments)
    check_density_options(arguments)
    check_parts_options(arguments)
    check_shape_option(arguments, _name_clash(arguments))
    if arguments.payload is not None and arguments.merge:
        arguments.refuse("--merge does not go with --payload, which no file holds")
    if arguments.budget is None and arguments.pareto is None:
        arguments.refuse(
            "give the most mass that may be added, such as --budget 1.5 (kg), or --pareto 10 "
            "for designs up to the least shaking"
        )
    if arguments.budget is not None and arguments.budget < 0.0:
        arguments.refuse(f"--budget {arguments.budget:g}: a mass is not negative")
    if (arguments.budget or 0.0) > MOST_BUDGET:
        arguments.refuse(f"--budget {arguments.budget:g}: give at most {MOST_BUDGET:g} kg")
    if arguments.about is not None and arguments.frame is not None:
        arguments.refuse("--about: not with --frame, which turns about the middle")
    for flag, caps in (
        ("--max-bearing", arguments.max_bearing),
        ("--max-torque", arguments.max_torque),
    ):
        names = [name for name, _ in caps]
        if len(set(names)) < len(names):
            arguments.refuse(f"{flag}: one joint has two caps")


def _name_clash(arguments: argparse.Namespace) -> str:
    """Say which options, for loads that feel moments of inertia, do not go with a shape."""
    given = {
        "--max-bearing": arguments.max_bearing,
        "--max-torque": arguments.max_torque,
        "--frame": arguments.frame,
        "--minimise torque": arguments.minimise == "torque",
        "--minimise bearing": arguments.minimise == "bearing",
    }
    names = [name for name, value in given.items() if value]
    if arguments.thickness is not None:
        return "--shape has its thickness: leave out --thickness"
    if names:
        others = ", ".join(names)
        return f"--shape is for the shaking force alone: leave out {others}, or the shape"
    return ""


def _check_requirements(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if other options are about shaking along motions."""
    check_requirement_options(arguments, ())
    if not arguments.require:
        refuse_given(arguments, ("weights",), "{} needs --require")
        return
    refuse_given(arguments, OF_MOTIONS, "{} is about motions: it does not go with --require")
    if not arguments.budget:
        arguments.refuse("--require needs a --budget above 0 kg")


def _run_required(arguments: argparse.Namespace) -> Answer:
    """Compute the matter that leaves the least of the requirements unmet.

    Raises:
        LinkageError: the file, the linkage, a requirement, a link or a region cannot be used.
    """
    from balance.app.answers.text.payload import payload_section
    from balance.app.answers.text.violation import violation_body
    from balance.masses.counterweights.link_regions import distant_regions
    from balance.masses.counterweights.write_counterweights import with_counterweights
    from balance.masses.partial_balance.least_violation import least_violation
    from balance.masses.partial_balance.load_range import violation_left
    from balance.support.options import GRAVITY

    regions = dict(arguments.region)
    answer = least_violation(
        load_model(arguments, arguments.angles),
        arguments.links,
        arguments.budget,
        require=arguments.require,
        gravity=arguments.gravity or GRAVITY,
        regions=regions,
        weights=arguments.weights,
    )
    payload: Payload | None = arguments.payload
    load = violation_left(answer, payload) if payload and payload.varies else payload
    return Answer(
        verdict_code(answer.verdict),
        lambda: answer.to_dict() | ({} if load is None else {"payload": load.to_dict()}),
        lambda: [*violation_body(answer), *payload_section(load)],
        (
            *answer.space.warnings,
            *distant_regions(answer.space, regions),
            *_implausible_budget(arguments, answer.space.linkage),
        ),
        describe_written(arguments, True),
        lambda: {"out": partial(with_counterweights, answer, merge=arguments.merge)},
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Compute the designs of the options.

    Raises:
        LinkageError: the file, the linkage, a motion, a link or a region cannot be used.
    """
    _check_requirements(arguments)
    _check_options(arguments)
    if arguments.require:
        return _run_required(arguments)
    front, load = _front(arguments)
    from balance.app.answers.text.partial_balance import front_body
    from balance.app.answers.text.payload import payload_section
    from balance.masses.counterweights.link_regions import distant_regions

    best = front.designs[-1]
    parts = make_parts(arguments, best)
    far = distant_regions(best.space, dict(arguments.region))
    return Answer(
        verdict_code(best.verdict),
        lambda: front.to_dict() | ({} if load is None else {"payload": load.to_dict()}),
        lambda: [*front_body(front), *payload_section(load)],
        (
            *front.notices,
            *far,
            *notices_of_parts(arguments, parts),
            *_implausible_budget(arguments, best.space.linkage),
        ),
        join_remarks(
            random_motions_remark(arguments, best.space.linkage, best.motions),
            describe_written(arguments, best.z is not None),
        ),
        lambda: added_matter_files(arguments, front.designs[-1], front, parts),
    )


def _implausible_budget(arguments: argparse.Namespace, linkage: Linkage) -> tuple[Notice, ...]:
    """Note a budget that looks like grams."""
    return note_implausible_masses(linkage, [("--budget ", arguments.budget or 0.0)])


def _front(
    arguments: argparse.Namespace,
) -> tuple[ParetoFront, Payload | LoadsLeft | None]:
    """Compute the designs of the options, and what the last leaves for a range of loads."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.masses.counterweights.link_regions import names_of_links
    from balance.masses.partial_balance.budgets import pareto, single
    from balance.masses.partial_balance.load_range import shaking_left
    from balance.masses.partial_balance.shaking_problem import ShakingOptions
    from balance.space.spaces.compute_space import design_space

    space = design_space(linkage, arguments.motion, arguments.balance, 0)
    with progress_bar("motions and designs") as advance:
        options: dict[str, Any] = {
            "regions": dict(arguments.region),
            "motions": motions_of(arguments, linkage, MASSES_WHILE),
            "weight_moment": arguments.weight_moment,
            "frame": arguments.frame,
            "max_bearing": dict(arguments.max_bearing),
            "max_torque": dict(arguments.max_torque),
            "about": arguments.about,
            "thickness": arguments.thickness,
            "minimise": arguments.minimise or OBJECTIVES[0],
            "move": dict(arguments.move),
            "shape": arguments.shape,
            "density": densities_of(arguments, names_of_links(space.linkage, arguments.links)),
        }
        links, given = arguments.links, ShakingOptions(**options)
        if arguments.pareto is None:
            front = single(space, links, arguments.budget, given, advance)
        else:
            front = pareto(
                space, links, arguments.pareto, arguments.budget, progress=advance, **options
            )
        payload: Payload | None = arguments.payload
        if payload is None or not payload.varies:
            return front, payload
        return front, shaking_left(front, payload, tuple(links), given)


def _cap(*quantities: str) -> Callable[[str], tuple[str, float]]:
    """Build an argparse type of ``JOINT=VALUE``, in units of some quantities."""

    def read(text: str) -> tuple[str, float]:
        name, _, value = text.rpartition("=")
        if not name:
            raise argparse.ArgumentTypeError(f"'{text}' is not JOINT=VALUE, such as u1=20")
        return name, finite_quantity(*quantities)(value)

    return read


def _objective(text: str) -> PartialObjective:
    """Parse an objective: one of `OBJECTIVES`, or orders of harmonics."""
    words = text.split(",")
    if all(word.strip().isdecimal() for word in words):
        return tuple(int(word) for word in words)
    if text not in OBJECTIVES:
        raise argparse.ArgumentTypeError(
            f"'{text}' is none of {', '.join(OBJECTIVES)}, and no orders of harmonics, such as "
            "1,2"
        )
    return cast("PartialObjective", text)


def _weights(text: str) -> list[float]:
    """Parse weights of ``1,0.5``."""
    values = [finite_number(word) for word in text.split(",")]
    if not all(value > 0.0 for value in values):
        raise argparse.ArgumentTypeError(f"'{text}': a weight is above 0")
    return values


def _frame(text: str) -> ElasticFrame:
    """Parse four numbers of an elastic frame."""
    from balance.masses.partial_balance.elastic_frame import ElasticFrame
    from kinematics.errors import UsageError

    words = text.split(",")
    if len(words) != 4:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not mass,inertia,stiffness,damping, such as 50,4,2e5,100"
        )
    frame = ElasticFrame(*map(finite_number, words))
    try:
        frame.check()
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return frame
