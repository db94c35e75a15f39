"""The command ``balance discover walk``: one walk, step by step."""

from __future__ import annotations

import argparse

from balance.cli.arguments import Verbs, page_path
from balance.cli.exit_codes import DONE, NEGATIVE
from balance.cli.number_arguments import whole_number
from balance.cli.outcome import Outcome

__all__ = ["add_walk"]

MAX_START, MAX_SEED = 10_000_000, 2**31
# Starts that are tried for one that ends at a special geometry.
TRIED = 300


def add_walk(kinds: Verbs) -> None:
    """Add ``discover walk`` to the parser of ``discover``."""
    parser = kinds.add_parser(
        "walk",
        help="watch one walk",
        description="Repeats one walk of a search and tells its steps. Exits with 0 if it ends "
        "at a special geometry, 1 if not.",
    )
    parser.add_argument(
        "--topology", required=True, metavar="NAME",
        help="the topology, as for 'balance discover run'",
    )  # fmt: skip
    parser.add_argument(
        "--buildable", action="store_true",
        help="a walk of a search for geometries that balance with masses that can be built",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=whole_number(0, MAX_SEED), default=1, metavar="N",
        help="seed of the search (default 1)",
    )  # fmt: skip
    parser.add_argument(
        "--start", type=whole_number(0, MAX_START), metavar="N",
        help="number of the start, from 0 (default: the first that ends at a special geometry, "
        f"of {TRIED})",
    )  # fmt: skip
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page on which the linkage deforms while its singular value falls; it "
        "needs no network",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_walk, refuse=parser.error, force=False)


def _walk(arguments: argparse.Namespace) -> Outcome:
    """Repeat a walk.

    Raises:
        LinkageError: there is no such topology, no start, or the page cannot be written.
    """
    from balance.atomic_files import write_all_atomic
    from balance.discovery.job import DiscoveryJob
    from balance.discovery.topologies import topology
    from balance.discovery.watch import first_special_start, watch_walk
    from balance.report.text.watched_walk import walk_data, walk_text
    from kinematics.errors import UsageError

    graph, start = topology(arguments.topology), arguments.start
    count = TRIED if start is None else start + 1
    job = DiscoveryJob(graph.name, count, arguments.seed, arguments.buildable)
    if start is None:
        start = first_special_start(job)
    if start < 0:
        raise UsageError(
            f"none of {TRIED} walks ends at a special geometry; name one with --start, or try "
            "another --seed"
        )
    found = watch_walk(job, start)
    if arguments.html is not None:
        from balance.report.html.walk import walk_page

        write_all_atomic([(arguments.html, walk_page(found).encode())])
    data = walk_data(found)
    code = DONE if found.outcome == "special" else NEGATIVE
    return Outcome(code, lambda: data, lambda: walk_text(data))
