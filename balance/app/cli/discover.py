"""The command ``balance discover``: search for special geometries, show and export them."""

from __future__ import annotations

import argparse
import logging
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser, Verbs, add_json_option
from balance.app.cli.exit_codes import DONE, NEGATIVE, UNDECIDED, verdict_code
from balance.app.cli.number_arguments import (
    add_workers,
    point,
    positive_number,
    whole_number,
)
from balance.app.cli.outputs import add_page_option
from balance.app.cli.progress import progress_bar
from balance.support.options import GRAVITY
from kinematics.errors import WorkerError

if TYPE_CHECKING:
    from balance.studies.discovery.job import DiscoveryJob
    from balance.studies.runs.results_file import ResultsFile

logger = logging.getLogger(__name__)

MAX_START = 10_000_000
# Starts that `walk` tries for one that ends at a special geometry.
STARTS_TRIED = 300
STARTS, MAX_STARTS = 300, 10_000_000
MAX_SEED = 2**31
MEMBERS, TRIED, MAX_MEMBERS = 100, 20, 10_000
KEPT = "keeps the walks so far; --resume goes on from there"


def add_discover(parser: Parser) -> None:
    """Add the commands below ``discover``."""
    parser.description = (
        "Walks from random geometries of a topology to special ones, whose design "
        "space is larger, and groups these to families by the relations that they fulfil."
    )
    kinds = parser.add_subparsers(title="jobs", metavar="what", prog=parser.prog, required=True)
    _add_run(kinds)
    _add_show(kinds)
    _add_export(kinds)
    add_walk(kinds)


def _add_topology_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say whose topology the walks have."""
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--model",
        metavar="MODEL",
        help="take the topology of this model, begin with its geometry, and go on from "
        "random changes of it; a path, or a name from 'balance models'",
    )
    where.add_argument(
        "--topology",
        metavar="NAME",
        help="four-bar, slider-crank, geared-five-bar, watt1, watt2, stephenson1, stephenson2, "
        "stephenson3, spherical-four-bar, r-u-s-r, 3-rsr, or the pairs of links that joints "
        'connect, as "0-1 1-2 2-3 P0-3", where 0 is the ground and P a sliding joint',
    )


def _add_run(kinds: Verbs) -> None:
    """Add ``discover run``."""
    parser = kinds.add_parser(
        "run",
        help="walk from random starts",
        description="Walks from random starts. Results that were written stay, however the run "
        "ends. Exits with 0 if a family was found, 1 if none was.",
    )
    _add_topology_options(parser)
    parser.add_argument(
        "--buildable",
        action="store_true",
        help="walk to geometries that balance with masses that can be built",
    )
    _add_require(parser)
    parser.add_argument(
        "--starts",
        type=whole_number(1, MAX_STARTS),
        default=STARTS,
        metavar="N",
        help=f"number of walks (default {STARTS})",
    )
    parser.add_argument(
        "--seed",
        type=whole_number(0, MAX_SEED),
        default=1,
        metavar="N",
        help="seed of the starts (default 1)",
    )
    parser.add_argument(
        "--seconds",
        type=positive_number,
        metavar="S",
        help="stop after this time; --resume goes on from there",
    )
    parser.add_argument(
        "--out",
        metavar="FILE.db",
        help="file of the results (default: NAME.db)",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on with a file that this search has begun; begin it, if there is none",
    )
    add_workers(parser, keeps_results=True)
    add_json_option(parser, _compute)


def _add_require(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what is balanced."""
    parser.add_argument(
        "--require",
        action="append",
        type=_requirements,
        default=[],
        metavar="TEXT",
        help="what is balanced, with letters of joints as inputs: 'force; dynamic at A=0.3', "
        "'dynamic along B=-A', 'force x' (default: dynamic, everywhere); repeatable",
    )
    parser.add_argument(
        "--gravity",
        type=point,
        default=GRAVITY,
        metavar="X,Y,Z",
        help="for --require gravity: its direction, with x along the ground from its first "
        "joint to the next",
    )


def _requirements(text: str) -> str:
    """Parse requirements."""
    from balance.studies.discovery.search_requirements import canonical_requirements
    from kinematics.errors import UsageError

    try:
        return canonical_requirements(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _required(arguments: argparse.Namespace) -> tuple[str, tuple[float, float, float]]:
    """Join the requirements of the options; and gravity, where one is about it."""
    from balance.studies.discovery.search_requirements import canonical_requirements

    text = canonical_requirements(arguments.require or "dynamic")
    if "gravity" in text:
        return text, arguments.gravity
    if arguments.gravity != GRAVITY:
        arguments.refuse("--gravity needs --require gravity")
    return text, GRAVITY


def _compute(arguments: argparse.Namespace) -> Answer:
    """Run the search of the options.

    Raises:
        LinkageError: there is no such topology, the file cannot be used, or workers fail.
    """
    from balance.app.answers.text.discovery import search_body, search_data
    from balance.studies.discovery.search_results import read_search
    from balance.studies.runs.results_file import ResultsFile
    from kinematics.wording import count_noun

    job, name = _job(arguments)
    job.generic  # noqa: B018 - computed before there is a file: a topology may close nowhere
    path = arguments.out or f"{name}.db"
    open_file = ResultsFile.resume if arguments.resume else ResultsFile.create
    with open_file(path, job) as file:
        begin = monotonic()
        try:
            ended = _walk_all(arguments, job, file)
        except KeyboardInterrupt:
            logger.warning("%s %s", path, KEPT)
            raise
        except WorkerError as error:
            error.add_note(f"{path} {KEPT}")
            raise
        search = read_search(file)
        if ended == "time":
            logger.warning(
                "time is up after %d of %d walks, with %s; --resume goes on from there",
                file.computed()[0],
                file.rows,
                count_noun(len(search.families), "family"),
            )
        data = search_data(file, search, monotonic() - begin)
    code = DONE if data["families"] else NEGATIVE
    return Answer(code, lambda: data, lambda: search_body(data, job.topology))


def _job(arguments: argparse.Namespace) -> tuple[DiscoveryJob, str]:
    """Describe the search of the options, and name its file.

    Raises:
        LinkageError: there is no such topology, or the model is no linkage to start from.
    """
    from balance.studies.discovery.from_linkage import from_linkage
    from balance.studies.discovery.job import DiscoveryJob, text_of_geometry
    from balance.studies.discovery.topologies import topology
    from kinematics.loading.model_gallery import load

    origin = ""
    if arguments.model is None:
        graph = topology(arguments.topology)
        name = graph.name.replace(":", "").replace(" ", "_")
    else:
        linkage = load(arguments.model)
        graph, geometry = from_linkage(linkage)
        name, origin = linkage.name, text_of_geometry(geometry)
    some = arguments.starts, arguments.seed, arguments.buildable
    return DiscoveryJob(graph.name, *some, origin, *_required(arguments)), name


def _walk_all(arguments: argparse.Namespace, job: DiscoveryJob, file: ResultsFile) -> str:
    """Compute the chunks that the file lacks, as long as the time lasts; why that ended."""
    from balance.studies.discovery.search_results import FamilyTally
    from balance.studies.runs.chunk_runs import run_chunks
    from kinematics.wording import count_noun

    deadline = None if arguments.seconds is None else monotonic() + arguments.seconds
    tally = FamilyTally(file)
    with progress_bar("walks", True) as advance:
        return run_chunks(
            job,
            file,
            workers=arguments.workers,
            deadline=deadline,
            progress=lambda done, total: advance(
                done, total, f"{count_noun(tally.count(), 'family')} so far"
            ),
        ).ended


def _add_show(kinds: Verbs) -> None:
    """Add ``discover show``."""
    parser = kinds.add_parser(
        "show",
        help="show the families found, also while a search runs",
        description="Shows the families in a file: their relations, how many of random members "
        "have the design space, and for how many of these masses can be built.",
    )
    parser.add_argument("results", metavar="FILE.db", help="file of the results")
    parser.add_argument(
        "--members",
        type=whole_number(1, MAX_MEMBERS),
        default=MEMBERS,
        metavar="N",
        help=f"random members of each family to decide (default {MEMBERS})",
    )
    parser.add_argument(
        "--tried",
        type=whole_number(0, MAX_MEMBERS),
        default=TRIED,
        metavar="N",
        help=f"random members of each family to look for masses for (default {TRIED})",
    )
    add_page_option(parser, "with a table of the families and a moving member of each")
    add_json_option(parser, _show)


def _show(arguments: argparse.Namespace) -> Answer:
    """Examine the families of a file.

    Raises:
        LinkageError: the file cannot be read, is not that of a search, or the page cannot be
            written.
    """
    from balance.app.answers.text.discovery import families_data, search_body, search_data
    from balance.studies.discovery.search_results import examine, read_search
    from balance.studies.runs.results_file import ResultsFile

    with ResultsFile.open(arguments.results) as file:
        search = read_search(file)
        data = search_data(file, search, None, "show")
    with progress_bar("families") as advance:
        examined = []
        for family in search.families:
            examined.append(
                examine(search.job, family, members=arguments.members, tried=arguments.tried)
            )
            advance(len(examined), len(search.families))
    families_data(data, examined)

    def prepare_files() -> Files:
        from balance.app.answers.html.families import families_page

        return {"html": partial(families_page, search.job, data, examined)}

    return Answer(
        DONE if search.families else NEGATIVE,
        lambda: data,
        lambda: search_body(data, search.job.topology),
        files=prepare_files,
    )


def _add_export(kinds: Verbs) -> None:
    """Add ``discover export``."""
    parser = kinds.add_parser(
        "export",
        help="write a member of a family as a URDF file",
        description="Writes a member of a family with masses that balance it, if there are "
        "any: a member with rational coordinates if one is found, so that 'balance report "
        "--exact' decides exactly. Exits with 0 if the file is balanced, 1 if no masses "
        "balance the member, 4 if that is undecided.",
    )
    parser.add_argument("results", metavar="FILE.db", help="file of the results")
    parser.add_argument(
        "--family",
        type=whole_number(1, MAX_MEMBERS),
        required=True,
        metavar="N",
        help="number of the family, as shown by 'balance discover show'",
    )
    parser.add_argument("--out", required=True, metavar="FILE.urdf", help="the file to write")
    add_json_option(parser, _export)


def _export(arguments: argparse.Namespace) -> Answer:
    """Export a member of a family.

    Raises:
        LinkageError: a file cannot be read or written, or no member can be read as a linkage.
        UsageError: there is no such family.
    """
    from balance.app.answers.text.discovery import member_body, member_data
    from balance.studies.discovery.export import export_member
    from balance.studies.discovery.search_results import read_search
    from balance.studies.runs.results_file import ResultsFile
    from kinematics.errors import UsageError

    with ResultsFile.open(arguments.results) as file:
        search = read_search(file)
    if arguments.family > len(search.families):
        raise UsageError(
            f"{arguments.results}: no family {arguments.family}, of {len(search.families)}"
        )
    member = export_member(search.job, search.families[arguments.family - 1])
    data = member_data(arguments.family, arguments.out, member)
    code = verdict_code(member.design.verdict)
    if member.balanced is False:
        code = UNDECIDED
    return Answer(
        code,
        lambda: data,
        lambda: member_body(data),
        files=lambda: {"out": lambda: member.urdf},
    )


def add_walk(kinds: Verbs) -> None:
    """Add ``discover walk`` to the parser of ``discover``."""
    parser = kinds.add_parser(
        "walk",
        help="watch one walk",
        description="Repeats one walk of a search and tells its steps. Exits with 0 if it ends "
        "at a special geometry, 1 if not.",
    )
    parser.add_argument(
        "--topology",
        required=True,
        metavar="NAME",
        help="the topology, as for 'balance discover run'",
    )
    parser.add_argument(
        "--buildable",
        action="store_true",
        help="a walk of a search for geometries that balance with masses that can be built",
    )
    _add_require(parser)
    parser.add_argument(
        "--seed",
        type=whole_number(0, MAX_SEED),
        default=1,
        metavar="N",
        help="seed of the search (default 1)",
    )
    parser.add_argument(
        "--start",
        type=whole_number(0, MAX_START),
        metavar="N",
        help="number of the start, from 0 (default: the first that ends at a special geometry, "
        f"of {STARTS_TRIED})",
    )
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
    count = STARTS_TRIED if start is None else start + 1
    some = count, arguments.seed, arguments.buildable
    job = DiscoveryJob(graph.name, *some, "", *_required(arguments))
    if start is None:
        start = first_special_start(job)
    if start < 0:
        raise UsageError(
            f"none of {STARTS_TRIED} walks ends at a special geometry; name one with --start, "
            "or try another --seed"
        )
    walk = watch_walk(job, start)
    data = walk_data(walk)

    def prepare_files() -> Files:
        from balance.app.answers.html.walk import walk_page

        return {"html": partial(walk_page, walk)}

    code = DONE if walk.outcome == "special" else NEGATIVE
    return Answer(code, lambda: data, lambda: walk_body(data), files=prepare_files)
