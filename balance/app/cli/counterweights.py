"""The command ``balance counterweights``: its options, and its answer."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser
from balance.app.cli.density_options import (
    add_density_options,
    check_density_options,
    densities_of,
)
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.matter_options import (
    add_matter_options,
    add_merge_option,
    add_move_option,
    check_matter_options,
    require_links,
)
from balance.app.cli.model_options import add_model_options
from balance.app.cli.model_readings import certified_space
from balance.app.cli.motion_source import (
    MASSES_WHILE,
    add_motion_source,
    motions_of,
    notices_of,
    random_motions_remark,
)
from balance.app.cli.next_command import plates_command, reduce_command, relaxed_command
from balance.app.cli.number_arguments import finite_number, whole_number
from balance.app.cli.outputs import (
    add_out_option,
    add_page_option,
    describe_written,
    join_remarks,
)
from balance.app.cli.part_options import (
    add_parts_option,
    add_solids_option,
    added_matter_files,
    check_parts_options,
    make_parts,
    notices_of_parts,
)
from balance.app.cli.payload_option import add_payload_option
from balance.app.cli.progress import spinner
from balance.app.cli.requirement_options import (
    add_requirement_options,
    check_requirement_options,
)
from balance.app.cli.shape_option import add_shape_option, check_shape_option

if TYPE_CHECKING:
    from balance.masses.counterweights.counterweights_result import Counterweights
    from balance.masses.counterweights.movable_weights import MovableWeights
    from balance.masses.payload import Payload
    from balance.motion.verification.trajectory import Trajectory
    from balance.space.spaces.design_space import DesignSpace


OBJECTIVES = ("mass", "inertia", "rotor")


def add_counterweights(parser: Parser) -> None:
    """Add the options of the command ``counterweights``."""
    parser.description = (
        "The least matter that balances a linkage when it is added to links, or why there is "
        "none. Exits with 0 if there is, 1 if not, 4 if undecided."
    )
    add_model_options(parser, motion_alone=True)
    add_requirement_options(parser, explain=False)
    parser.set_defaults(run=_run)
    parser.group("motion").add_argument(
        "--max-order",
        type=whole_number(0, 50, "an order"),
        metavar="K",
        help="only the conditions of orders 0 to K count",
    )
    add_motion_source(parser.group("motion"), "none")
    add_matter_options(parser, "links that may get matter, or all", required=True)
    parser.group("matter").add_argument(
        "--minimise",
        choices=OBJECTIVES,
        default="mass",
        metavar="WHAT",
        help="mass (default), inertia, or rotor (of the inputs)",
    )
    parser.group("matter").add_argument(
        "--price-of-mass",
        type=finite_number,
        metavar="X",
        help="X length² for inertia, rotor (0.01)",
    )
    add_move_option(parser)
    add_payload_option(parser)
    add_density_options(parser, "matter", "plates on a planar linkage", points=True)
    add_shape_option(parser, "disc, block, sector (thickness), cylinder (radius)")
    add_out_option(parser)
    add_merge_option(parser)
    add_parts_option(parser)
    add_solids_option(parser)
    add_page_option(parser, "with the loads before and after")
    parser.add_examples(
        "balance counterweights robot.urdf --links crank --speed 300rpm --html page.html",
        "balance counterweights robot.urdf --balance force --links crank \\\n"
        "    --region 'crank=box(-90mm:-20mm,-30mm:30mm,0:12mm)' --parts made",
        "balance counterweights robot.urdf --balance force --links crank,rocker \\\n"
        "    --shape disc=20mm --out balanced.urdf",
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Compute the counterweights of the options.

    Raises:
        LinkageError: the file, the linkage, a link or a region cannot be used.
    """
    check_requirement_options(arguments, ("max_order",))
    check_matter_options(arguments)
    require_links(arguments)
    _check_objective(arguments)
    check_parts_options(arguments)
    if arguments.payload is not None and arguments.merge:
        arguments.refuse("--merge does not go with --payload, which no file holds")
    from balance.app.answers.text.counterweights import counterweights_body
    from balance.app.answers.text.payload import payload_section
    from balance.masses.counterweights.added_program import IDLE_MASS_PRICE
    from balance.masses.counterweights.counterweights import counterweights
    from balance.masses.counterweights.link_regions import distant_regions, names_of_links

    given = arguments.price_of_mass
    with spinner("finding the least matter that balances"):
        space = certified_space(arguments)
        motions = motions_of(arguments, space.linkage, MASSES_WHILE)
        matter = counterweights(
            space,
            arguments.links,
            dict(arguments.region),
            arguments.minimise,
            density=densities_of(arguments, names_of_links(space.linkage, arguments.links)),
            thickness=arguments.thickness,
            price_of_mass=IDLE_MASS_PRICE if given is None else given,
            shape=arguments.shape,
            move=dict(arguments.move),
        )
        matter = _with_loads(arguments, matter, motions)
        load = _load_data(arguments, space)
    parts = make_parts(arguments, matter)
    reduce = reduce_command(arguments, matter.given_mass)
    notices = (
        *space.warnings,
        *distant_regions(space, dict(arguments.region)),
        *notices_of(space.linkage, motions),
        *notices_of_parts(arguments, parts),
    )
    return Answer(
        verdict_code(matter.verdict),
        lambda: matter.to_dict() | ({} if load is None else {"payload": load.to_dict()}),
        lambda: [
            *counterweights_body(
                matter,
                reduce,
                relaxed_command(arguments, matter),
                plates_command(arguments, matter),
            ),
            *payload_section(load),
        ],
        notices,
        join_remarks(
            random_motions_remark(arguments, matter.space.linkage, matter.along.before.motions)
            if matter.along
            else "",
            describe_written(arguments, matter.z is not None),
        ),
        lambda: added_matter_files(arguments, matter, matter, parts),
    )


def _load_data(
    arguments: argparse.Namespace, space: DesignSpace
) -> Payload | MovableWeights | None:
    """Find what weights that move must do for a range of loads; else the load, if any."""
    payload: Payload | None = arguments.payload
    if payload is None or not payload.varies:
        return payload
    from balance.masses.counterweights.movable_weights import movable_weights
    from balance.masses.payload import carrying

    bare = carrying(space.linkage, payload, -payload.mean)
    return movable_weights(space, bare, payload, arguments.links, dict(arguments.region))


def _with_loads(
    arguments: argparse.Namespace, matter: Counterweights, motions: list[Trajectory] | None
) -> Counterweights:
    """Compute the loads along the motions of the options, which a page shows in any case."""
    if matter.z is None or not (motions or arguments.html is not None):
        return matter
    from balance.masses.counterweights.counterweights import with_loads

    return with_loads(matter, motions)


def _check_objective(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if the objective and other options contradict each other."""
    price, objective = arguments.price_of_mass, arguments.minimise
    if price is not None and objective == "mass":
        arguments.refuse("--price-of-mass needs --minimise inertia or rotor")
    if price is not None and price < 0.0:
        arguments.refuse(f"--price-of-mass {price:g}: a price is not negative")
    check_density_options(arguments)
    check_shape_option(
        arguments,
        "--shape has its thickness, for the least mass: leave out the rest"
        if objective != "mass" or arguments.thickness is not None
        else "",
    )
