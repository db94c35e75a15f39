"""The command ``balance remedies``: its options, its answer, and the files that it writes."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from balance.cli.arguments import Parser, page_path
from balance.cli.counterweights import add_matter_options, check_regions
from balance.cli.exit_codes import DONE, NEGATIVE, UNDECIDED
from balance.cli.model_options import add_model_options, load_model
from balance.cli.number_arguments import positive_number
from balance.cli.outcome import Outcome
from balance.cli.progress_bar import progress_bar
from balance.remedies.catalogue import CATALOGUE

if TYPE_CHECKING:
    from balance.remedies.compare import RemedyComparison
    from balance.remedies.request import RemedyRequest

__all__ = ["add_remedies"]


def add_remedies(parser: Parser) -> None:
    """Add the options of the command ``remedies``."""
    parser.description = (
        "Applies the remedies of the literature to a linkage: counter-rotations, "
        "transmissions, duplicates, added dyads, driven wheels, constraints. Exits with 0 if "
        "one balances it, 1 if none does, 4 if that is undecided."
    )
    parser.epilog = "remedies: " + "; ".join(
        f"{one.name} ({one.title})" for one in CATALOGUE.values()
    )
    add_model_options(parser)
    parser.set_defaults(run=_run)
    parser.add_argument(
        "--only", type=_remedies, default=[], metavar="R1,R2", help="only these remedies"
    )
    add_matter_options(
        parser, "links to which matter may be added (default: all that carry parameters)"
    )
    parser.add_argument(
        "--gear", type=positive_number, default=1.0, metavar="N",
        help="turns of a counter-rotor for one turn of its joint (default 1)",
    )  # fmt: skip
    parser.add_argument(
        "--rotor-radius", type=positive_number, metavar="METRES",
        help="radius of rotors and wheels (default: a quarter of the characteristic length)",
    )  # fmt: skip
    parser.add_argument(
        "--budget", type=positive_number, metavar="KG",
        help="most mass that partial balance may add (default: the mass of the moving links)",
    )  # fmt: skip
    parser.add_argument(
        "--out", metavar="DIR",
        help="folder for the file of the linkage with each remedy that helps, and its tables",
    )  # fmt: skip
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page with added mass against input inertia; it needs no network",
    )  # fmt: skip


def _run(arguments: argparse.Namespace) -> Outcome:
    """Apply the remedies of the options and write their files.

    Raises:
        LinkageError: the file, the linkage, a link or a region cannot be used.
    """
    check_regions(arguments)
    if arguments.out is not None:
        _check_folder(arguments.out)
    with progress_bar("steps of the search") as advance:
        request = _request(arguments, advance)
        from balance.remedies.compare import compare_request

        found = compare_request(request, arguments.only)
    _write_files(arguments, found)
    from balance.report.text.remedies import remedies_text

    code = {"feasible": DONE, "infeasible": NEGATIVE}.get(found.verdict, UNDECIDED)
    notices = found.request.space.warnings
    return Outcome(code, found.to_dict, lambda: remedies_text(found), notices=notices)


def _request(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> RemedyRequest:
    """Build the request of the options."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.remedies.request import RemedyRequest

    return RemedyRequest(
        linkage, tuple(arguments.motion or ()), arguments.balance, tuple(arguments.add),
        dict(arguments.region), arguments.gear, arguments.rotor_radius, arguments.budget,
        spatial=arguments.spatial, angles=arguments.angles, progress=advance,
    )  # fmt: skip


def _check_folder(folder: str) -> None:
    """Refuse a folder for output that cannot be made, before any work.

    Raises:
        UsageError: it is a file, or the folder around it does not exist.
    """
    from kinematics.error_text import clean
    from kinematics.errors import UsageError

    if os.path.exists(folder) and not os.path.isdir(folder):
        raise UsageError(f"{clean(folder, 1000)}: --out is a file: give a folder")
    around = os.path.dirname(os.path.abspath(folder))
    if not os.path.isdir(around):
        raise UsageError(f"{clean(around, 1000)}: no such folder: make it before --out")


def _write_files(arguments: argparse.Namespace, found: RemedyComparison) -> None:
    """Write the files of the options, all of them or none.

    Raises:
        LinkageError: a file cannot be written, would replace one that is read, or a library is
            missing.
    """
    from balance.atomic_files import check_outputs, write_all_atomic
    from balance.remedies.files import remedy_files

    contents = []
    if arguments.html is not None:
        from balance.report.html.remedies import remedies_page

        contents.append((arguments.html, remedies_page(found).encode()))
    if arguments.out is not None:
        files = remedy_files(found.results)
        contents += [(os.path.join(arguments.out, name), data) for name, data in files.items()]
        outputs = {f"--out ({name})": os.path.join(arguments.out, name) for name in files}
        check_outputs(outputs, [found.request.linkage.source], arguments.force)
    made = arguments.out is not None and not os.path.isdir(arguments.out)
    if made:
        _make_folder(arguments.out)
    try:
        write_all_atomic(contents)
    except BaseException:
        if made:
            os.rmdir(arguments.out)
        raise


def _make_folder(folder: str) -> None:
    """Make a folder.

    Raises:
        FileError: it cannot be made.
    """
    from kinematics.error_text import clean
    from kinematics.errors import FileError

    try:
        os.mkdir(folder)
    except OSError as error:
        raise FileError(
            clean(folder, 1000), "", f"cannot be made ({error.strerror})",
            "give a folder inside one that can be written to",
        ) from None  # fmt: skip


def _remedies(text: str) -> list[str]:
    """Parse names of remedies of ``a,b``."""
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in CATALOGUE:
            raise argparse.ArgumentTypeError(
                f"no remedy '{name}': choose from {', '.join(CATALOGUE)}"
            )
    return names
