"""Options of ``balance design`` that add matter to links, and the answer to them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import refuse_given
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.model_readings import certified_space
from balance.app.cli.outputs import describe_written
from balance.app.cli.spinner import spinner
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.masses.counterweights.answer import Counterweights


def add_counterweight_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of counterweights to the command ``design``."""
    add_matter_options(
        parser, "keep all masses of the file, and only add matter to these links: the least "
        "that balances, or why there is none",
    )  # fmt: skip
    parser.add_argument(
        "--merge", action="store_true",
        help="with --add and --out: put counterweights into the masses of their links, not "
        "into links of their own",
    )  # fmt: skip


def add_matter_options(parser: argparse.ArgumentParser, purpose: str) -> None:
    """Add the options for links and regions that get matter.

    Args:
        parser: the parser of a command.
        purpose: help of ``--add``.
    """
    parser.add_argument(
        "--add", action=_AddNames, type=_link_names, default=[], metavar="L1,L2",
        help=f"{purpose}; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--region", action="append", type=_link_region, default=[], metavar="L=SHAPE",
        help="where matter may be added, metres in the link frame: ball(x,y,z,r), "
        "box(x0:x1,y0:y1,z0:z1), cylinder(x,y,z,ax,ay,az,r,length), "
        "ellipsoid(x,y,z,a,b,c[,roll,pitch,yaw]) or collision; by default a ball about the "
        "joint of the link, of half its length; repeatable",
    )  # fmt: skip


def check_counterweight_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options contradict each other."""
    if not arguments.add:
        refuse_given(arguments, ("region", "merge"), "{} needs --add")
        return
    for name in arguments.keep:
        if name in arguments.add:
            arguments.refuse(f"link '{name}' is both kept and added to: name it once")
    clash = "{} does not go with --add, which keeps the given masses"
    refuse_given(arguments, ("keep", "bounds", "anywhere", "density", "thickness"), clash)
    if arguments.minimise == "change":
        arguments.refuse(clash.format("--minimise change"))
    if arguments.merge and not arguments.out:
        arguments.refuse("--merge needs --out")
    check_regions(arguments)


def check_regions(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if a link has two regions."""
    names = [name for name, _ in arguments.region]
    for name in names:
        if names.count(name) > 1:
            arguments.refuse(f"link '{name}' has two regions: give one")


def run_counterweights(arguments: argparse.Namespace) -> Answer:
    """Compute the counterweights of the options.

    Raises:
        LinkageError: the file, the linkage, a link or a region cannot be used.
    """
    from balance.app.answers.text.counterweights import counterweights_body
    from balance.masses.counterweights.counterweights import counterweights
    from balance.masses.counterweights.link_regions import distant_regions

    with spinner("finding the least matter that balances"):
        space = certified_space(arguments)
        matter = counterweights(
            space, arguments.add, dict(arguments.region), arguments.minimise or "mass"
        )
    notices = (*space.warnings, *distant_regions(space, dict(arguments.region)))
    return Answer(
        verdict_code(matter.verdict),
        matter.to_dict,
        lambda: counterweights_body(matter),
        notices,
        describe_written(arguments, matter.z is not None),
        lambda: _files(matter, arguments.merge),
    )


def _files(counterweights: Counterweights, merge: bool) -> Files:
    """Find what makes the files of counterweights, if there are any."""
    from balance.app.answers.html.counterweights import counterweights_page
    from balance.masses.counterweights.write_counterweights import with_counterweights

    if counterweights.z is None:
        return {}
    return {
        "out": partial(with_counterweights, counterweights, merge=merge),
        "html": partial(counterweights_page, counterweights),
    }


class _AddNames(argparse.Action):
    """Collect names over repeated options, each once."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[str] | None,
        option_string: str | None = None,
    ) -> None:
        """Append the names of one option."""
        names = [*getattr(namespace, self.dest), *(values or ())]
        if len(set(names)) < len(names):
            raise argparse.ArgumentError(self, "a link is named twice: name each once")
        setattr(namespace, self.dest, names)


def _link_names(text: str) -> list[str]:
    """Parse names of ``a,b``, each once."""
    names = [name.strip() for name in text.split(",")]
    if not all(names) or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names: write a,b")
    return names


def _link_region(text: str) -> tuple[str, str]:
    """Parse link and shape of ``L=SHAPE``."""
    from balance.masses.counterweights.link_regions import COLLISION
    from balance.masses.counterweights.region_text import read_region

    name, _, shape = text.rpartition("=")
    if not name:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not L=SHAPE, such as crank=ball(0,0,0,0.1)"
        )
    try:
        if shape.strip() != COLLISION:
            read_region(shape)
    except UsageError as error:
        raise argparse.ArgumentTypeError(f"link '{name}': {error}") from None
    return name, shape
