"""The command ``balance discover walk``: one walk, step by step."""

from __future__ import annotations

import argparse
from functools import partial

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Verbs, add_json_option
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.number_arguments import whole_number
from balance.app.cli.outputs import add_page_option

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
    add_page_option(parser, "on which the linkage deforms while its singular value falls")
    add_json_option(parser, _walk)


def _walk(arguments: argparse.Namespace) -> Answer:
    """Repeat a walk.

    Raises:
        LinkageError: there is no such topology, no start, or the page cannot be written.
    """
    from balance.app.answers.text.watched_walk import walk_body, walk_data
    from balance.studies.discovery.job import DiscoveryJob
    from balance.studies.discovery.topologies import topology
    from balance.studies.discovery.watch import first_special_start, watch_walk
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
    walk = watch_walk(job, start)
    data = walk_data(walk)

    def files() -> Files:
        from balance.app.answers.html.walk import walk_page

        return {"html": partial(walk_page, walk)}

    code = DONE if walk.outcome == "special" else NEGATIVE
    return Answer(code, lambda: data, lambda: walk_body(data), files=files)
