"""Options of ``balance design`` for the least shaking on a budget, and the answer to them."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.cli.arguments import picture_path
from balance.cli.exit_codes import DONE, NEGATIVE, UNDECIDED
from balance.cli.model_options import load_model
from balance.cli.number_arguments import add_about, finite_number, whole_number
from balance.cli.outcome import Outcome
from balance.cli.progress_bar import progress_bar

if TYPE_CHECKING:
    from balance.partial_balance.elastic_frame import ElasticFrame
    from balance.partial_balance.results import ParetoFront

__all__ = ["add_partial_options", "check_partial_options", "run_partial"]

CODES = {"optimal": DONE, "infeasible": NEGATIVE, "undecided": UNDECIDED}


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
    parser.add_argument(
        "--plot", type=picture_path, metavar="FILE.png|.svg",
        help="with --partial: a picture of what is left against the added mass",
    )  # fmt: skip


def check_partial_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options of partial balance contradict others."""
    own = {
        "--budget": arguments.budget is not None, "--trajectory": arguments.trajectory,
        "--weight-moment": arguments.weight_moment is not None,
        "--pareto": arguments.pareto is not None, "--max-bearing": arguments.max_bearing,
        "--max-torque": arguments.max_torque, "--frame": arguments.frame is not None,
        "--about": arguments.about is not None, "--plot": arguments.plot is not None,
    }  # fmt: skip
    if not arguments.partial:
        for name, given in own.items():
            if given:
                arguments.refuse(f"{name} needs --partial")
        return
    if not arguments.add:
        arguments.refuse("--partial needs --add: the links that may get matter")
    if arguments.budget is None and arguments.pareto is None:
        arguments.refuse("--partial needs a --budget in kg, or --pareto")
    if arguments.budget is not None and arguments.budget < 0.0:
        arguments.refuse(f"--budget {arguments.budget:g}: a mass is not negative")
    for name, given in {"--minimise": arguments.minimise, "--html": arguments.html}.items():
        if given:
            arguments.refuse(f"{name} does not go with --partial")
    if arguments.about is not None and arguments.frame is not None:
        arguments.refuse("--about: not with --frame, which turns about the middle")
    for flag, caps in (
        ("--max-bearing", arguments.max_bearing), ("--max-torque", arguments.max_torque)
    ):  # fmt: skip
        names = [name for name, _ in caps]
        if len(set(names)) < len(names):
            arguments.refuse(f"{flag}: one joint has two caps")


def run_partial(arguments: argparse.Namespace) -> Outcome:
    """Compute the designs of the options and write their files.

    Raises:
        LinkageError: the file, the linkage, a motion, a link or a region cannot be used.
    """
    front = _front(arguments)
    remark = _write_files(arguments, front)
    from balance.added_masses.link_regions import distant_regions
    from balance.report.text.partial import partial_text

    best = front.designs[-1]
    return Outcome(
        CODES[best.verdict], front.to_dict, lambda: partial_text(front),
        notices=(*front.notices, *distant_regions(best.space, dict(arguments.region))),
        remark=remark,
    )  # fmt: skip


def _front(arguments: argparse.Namespace) -> ParetoFront:
    """Compute the designs of the options."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.partial_balance.budgets import pareto, single
    from balance.spaces.compute_space import design_space
    from balance.verification.given_motions import from_csv
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


def _write_files(arguments: argparse.Namespace, front: ParetoFront) -> str:
    """Write the files of the options; return a remark.

    Raises:
        LinkageError: a file cannot be written, or a library is missing.
    """
    from balance.atomic_files import write_all_atomic

    best, contents = front.designs[-1], []
    paths = [path for path in (arguments.out, arguments.plot) if path is not None]
    if best.z is None:
        return f"not written, for there is no design: {', '.join(paths)}" if paths else ""
    if arguments.out is not None:
        from balance.added_masses.write_counterweights import with_counterweights

        contents.append((arguments.out, with_counterweights(best, merge=arguments.merge)))
    if arguments.plot is not None:
        from balance.report.html.partial import front_picture

        contents.append((arguments.plot, front_picture(front, arguments.plot[-3:].lower())))
    write_all_atomic(contents)
    return f"written: {', '.join(path for path, _ in contents)}" if contents else ""


def _cap(text: str) -> tuple[str, float]:
    """Parse ``JOINT=VALUE``."""
    name, _, value = text.rpartition("=")
    if not name:
        raise argparse.ArgumentTypeError(f"'{text}' is not JOINT=VALUE, such as u1=20")
    return name, finite_number(value)


def _frame(text: str) -> ElasticFrame:
    """Parse four numbers of an elastic frame."""
    from balance.partial_balance.elastic_frame import ElasticFrame
    from kinematics.errors import UsageError

    words = text.split(",")
    if len(words) != 4:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not mass,inertia,stiffness,damping, such as 50,4,2e5,100"
        )
    found = ElasticFrame(*map(finite_number, words))
    try:
        found.check()
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return found
