"""Options of ``balance design`` for the least shaking on a budget, and the answer to them."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import refuse_given
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.model_options import load_model
from balance.app.cli.number_arguments import add_about, finite_number, whole_number
from balance.app.cli.outputs import add_picture_option, describe_written, kind_of
from balance.app.cli.progress_bar import progress_bar

if TYPE_CHECKING:
    from balance.masses.partial.elastic_frame import ElasticFrame
    from balance.masses.partial.results import ParetoFront


# Options that need ``--partial``.
OWN = (
    "budget", "trajectory", "weight_moment", "pareto", "max_bearing", "max_torque", "frame",
    "about", "plot",
)  # fmt: skip


def add_partial_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of partial balance to the command ``design``."""
    parser.add_argument(
        "--partial", action="store_true",
        help="with --add: the least shaking along motions for a --budget, not full balance",
    )  # fmt: skip
    parser.add_argument(
        "--budget", type=finite_number, metavar="KG", help="with --partial: most mass to add"
    )
    parser.add_argument(
        "--trajectory", action="append", default=[], metavar="FILE.csv",
        help="motion that counts: columns time and the inputs, SI units; repeatable; by "
        "default the random motions of verify",
    )  # fmt: skip
    parser.add_argument(
        "--weight-moment", type=finite_number, metavar="METRES",
        help="a moment of so many N m counts as a force of 1 N (default: the characteristic "
        "length)",
    )  # fmt: skip
    parser.add_argument(
        "--pareto", type=whole_number(2, 1000), metavar="N",
        help="N designs between nothing added and the least shaking, at most the --budget",
    )  # fmt: skip
    parser.add_argument(
        "--max-bearing", action="append", type=_cap, default=[], metavar="JOINT=N",
        help="largest force in a joint, newtons; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--max-torque", action="append", type=_cap, default=[], metavar="JOINT=NM",
        help="largest drive torque of an input, N m (sliding: N), gravity apart; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--frame", type=_frame, metavar="MASS,INERTIA,STIFFNESS,DAMPING",
        help="least vibration of an elastic frame with these kg, kg m², N/m and N s/m instead "
        "of the least shaking",
    )  # fmt: skip
    add_about(parser, "with --partial: the middle of the mechanism")
    add_picture_option(
        parser, "with --partial: a picture of what is left against the added mass"
    )


def check_partial_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options of partial balance contradict others."""
    if not arguments.partial:
        refuse_given(arguments, OWN, "{} needs --partial")
        return
    if not arguments.add:
        arguments.refuse("--partial needs --add: the links that may get matter")
    if arguments.budget is None and arguments.pareto is None:
        arguments.refuse("--partial needs a --budget in kg, or --pareto")
    if arguments.budget is not None and arguments.budget < 0.0:
        arguments.refuse(f"--budget {arguments.budget:g}: a mass is not negative")
    refuse_given(arguments, ("minimise", "html"), "{} does not go with --partial")
    if arguments.about is not None and arguments.frame is not None:
        arguments.refuse("--about: not with --frame, which turns about the middle")
    for flag, caps in (
        ("--max-bearing", arguments.max_bearing), ("--max-torque", arguments.max_torque)
    ):  # fmt: skip
        names = [name for name, _ in caps]
        if len(set(names)) < len(names):
            arguments.refuse(f"{flag}: one joint has two caps")


def run_partial(arguments: argparse.Namespace) -> Answer:
    """Compute the designs of the options.

    Raises:
        LinkageError: the file, the linkage, a motion, a link or a region cannot be used.
    """
    front = _front(arguments)
    from balance.app.answers.text.partial import partial_body
    from balance.masses.counterweights.link_regions import distant_regions

    best = front.designs[-1]
    return Answer(
        verdict_code(best.verdict), front.to_dict, lambda: partial_body(front),
        (*front.notices, *distant_regions(best.space, dict(arguments.region))),
        describe_written(arguments, best.z is not None), lambda: _files(arguments, front),
    )  # fmt: skip


def _front(arguments: argparse.Namespace) -> ParetoFront:
    """Compute the designs of the options."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.masses.partial.budgets import pareto, single
    from balance.motion.verification.given_motions import from_csv
    from balance.space.spaces.compute_space import design_space
    from kinematics.model.motion import motion_of

    space = design_space(linkage, arguments.motion, arguments.balance, 0)
    along = None
    if arguments.trajectory:
        limits = motion_of(linkage, arguments.motion)
        along = [from_csv(linkage, path, limits) for path in arguments.trajectory]
    with progress_bar("motions and designs") as advance:
        options = {
            "regions": dict(arguments.region), "trajectories": along,
            "weight_moment": arguments.weight_moment, "frame": arguments.frame,
            "max_bearing": dict(arguments.max_bearing),
            "max_torque": dict(arguments.max_torque), "progress": advance,
            "about": arguments.about,
        }  # fmt: skip
        if arguments.pareto is None:
            return single(space, arguments.add, arguments.budget, **options)
        return pareto(space, arguments.add, arguments.pareto, arguments.budget, **options)


def _files(arguments: argparse.Namespace, front: ParetoFront) -> Files:
    """Find what makes the files of designs, if there are any."""
    from balance.app.answers.html.partial import front_picture
    from balance.masses.counterweights.write_counterweights import with_counterweights

    best = front.designs[-1]
    if best.z is None:
        return {}
    return {
        "out": partial(with_counterweights, best, merge=arguments.merge),
        "plot": partial(front_picture, front, kind_of(arguments.plot)),
    }


def _cap(text: str) -> tuple[str, float]:
    """Parse ``JOINT=VALUE``."""
    name, _, value = text.rpartition("=")
    if not name:
        raise argparse.ArgumentTypeError(f"'{text}' is not JOINT=VALUE, such as u1=20")
    return name, finite_number(value)


def _frame(text: str) -> ElasticFrame:
    """Parse four numbers of an elastic frame."""
    from balance.masses.partial.elastic_frame import ElasticFrame
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
