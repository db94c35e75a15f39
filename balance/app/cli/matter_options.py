"""Options for the links that get matter, and where: of counterweights, reduce and remedies."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from balance.app.cli.arguments import Parser
from balance.app.cli.model_options import load_model, parse_names
from kinematics.errors import UsageError


def add_matter_options(parser: Parser, purpose: str, required: bool = False) -> None:
    """Add the options for links and regions that get matter.

    Args:
        parser: the parser of a command.
        purpose: help of ``--links``.
        required: whether the command needs links, which `require_links` then asks for.
    """
    group = parser.group("matter")
    links = group.add_argument(
        "--links",
        action=_AddNames,
        type=_link_names,
        default=[],
        metavar="L1,L2",
        help=f"{purpose}; repeatable",
    )
    # Not argparse's own word, which could not say which links there are.
    links.asked_for = required  # type: ignore[attr-defined]
    add_region_option(group)


def add_region_option(group: argparse._ActionsContainer) -> None:
    """Add the option for the region of a link."""
    group.add_argument(
        "--region",
        action="append",
        type=_link_region,
        default=[],
        metavar="L=SHAPE",
        help="80mm about joint, ball(x,y,z,r) … (half L's length)",
    )


def add_move_option(parser: Parser) -> None:
    """Add the option for links whose given matter may be moved."""
    parser.group("matter").add_argument(
        "--move",
        action=_AddShares,
        type=_link_shares,
        default=[],
        metavar="L1[=SHARE]",
        help="links whose own mass may be placed anew there",
    )


def require_links(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if it has no links, and name those that there are."""
    if not arguments.links:
        names = [body.name for body in load_model(arguments, arguments.angles).bodies]
        arguments.refuse(
            f"give --links: all, or those that may get matter, of {', '.join(names)}"
        )


def add_merge_option(parser: Parser) -> None:
    """Add the option for what the file of ``--out`` does with the matter."""
    parser.group("output").add_argument(
        "--merge",
        action="store_true",
        help="with --out: add to the links' own masses",
    )


def check_matter_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if a link has two regions, or nothing is to be merged."""
    check_regions(arguments)
    if getattr(arguments, "merge", False) and not arguments.out:
        arguments.refuse("--merge needs --out")
    if getattr(arguments, "move", None) and arguments.payload is not None:
        arguments.refuse("--move does not go with --payload, which is no mass of a link")


def check_regions(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if a link has two regions."""
    names = [name for name, _ in arguments.region]
    for name in names:
        if names.count(name) > 1:
            arguments.refuse(f"link '{name}' has two regions: give one")


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


class _AddShares(argparse.Action):
    """Collect shares of links over repeated options, each link once."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the links of one option."""
        pairs = [*getattr(namespace, self.dest), *values]
        if len(dict(pairs)) < len(pairs):
            raise argparse.ArgumentError(self, "a link is named twice: name each once")
        setattr(namespace, self.dest, pairs)


def _link_shares(text: str) -> list[tuple[str, float]]:
    """Parse links with shares of their mass, of ``a,b=30%,c=0.3``; all of it without one."""
    pairs = []
    for word in text.split(","):
        name, equals, share = word.strip().partition("=")
        try:
            value = 0.01 * float(share[:-1]) if share.endswith("%") else float(share or 1.0)
        except ValueError:
            value = 0.0
        if not name or (equals and not share) or not 0.0 < value <= 1.0:
            raise argparse.ArgumentTypeError(
                f"'{text}' is not a list of links, with a share of their mass above 0 and up "
                "to 100 %: write crank, or crank=30%"
            )
        pairs.append((name, value))
    return pairs


def _link_names(text: str) -> list[str]:
    """Parse names of ``a,b``, each once."""
    names = parse_names(text)
    if len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names: write a,b")
    return names


def _link_region(text: str) -> tuple[str, str]:
    """Parse link and shape of ``L=SHAPE``."""
    from balance.masses.counterweights.region_text import depends_on_link, is_mesh, read_region

    name, _, shape = text.rpartition("=")
    if not name:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not L=SHAPE, such as crank=80mm or crank=ball(0,0,0,0.1)"
        )
    try:
        # A file that cannot be read is no wrong option: the command reads it.
        if not depends_on_link(shape) and not is_mesh(shape):
            read_region(shape)
    except UsageError as error:
        raise argparse.ArgumentTypeError(f"link '{name}': {error}") from None
    return name, shape
