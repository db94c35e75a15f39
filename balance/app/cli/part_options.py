"""The options for the parts of counterweights: of counterweights and reduce."""

from __future__ import annotations

import argparse
import os
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from balance.app.answers.answer import Files
from balance.app.cli.arguments import Parser
from balance.app.cli.density_options import points_words, without_density
from balance.app.cli.outputs import check_folder, result_files
from kinematics.errors import PackageError, UsageError

if TYPE_CHECKING:
    from balance.masses.counterweights.counterweights_result import Counterweights
    from balance.masses.counterweights.parts.part_files import CounterweightPart
    from balance.masses.counterweights.write_counterweights import WithCounterweights
    from balance.masses.partial_balance.partial_balance import ParetoFront, PartialBalance
    from kinematics.model.linkage import Notice


def add_parts_option(parser: Parser) -> None:
    """Add the option ``--parts``."""
    parser.group("output").add_argument(
        "--parts", metavar="DIR", help="folder for parts: STL, DXF of plates, a table"
    )


def add_solids_option(parser: Parser) -> None:
    """Add the option ``--solids``."""
    parser.group("output").add_argument(
        "--solids", action="store_true", help="with --parts: STEP files too"
    )


def check_parts_options(arguments: argparse.Namespace) -> None:
    """Refuse parts without a volume, and a folder that is in use or cannot be made.

    Raises:
        UsageError: the folder cannot be made, or has files and may not be written to.
        PackageError: a library is missing.
    """
    folder = arguments.parts
    if folder is None:
        if _wants_solids(arguments):
            arguments.refuse("--solids needs --parts")
        return
    if without_density(arguments):
        arguments.refuse(
            f"--parts: point masses have no volume; leave out {points_words(arguments)}"
        )
    check_folder(folder, "--parts")
    if os.path.isdir(folder) and os.listdir(folder) and not arguments.overwrite:
        from kinematics.error_text import clean

        raise UsageError(
            f"{clean(folder, 1000)}: --parts has files already: give another folder, or "
            "--overwrite"
        )
    for library in ("manifold3d", "ezdxf"):
        if find_spec(library) is None:
            command = "python -m pip install 'screwbalance[parts]'"
            raise PackageError("--parts", library, command)
    if _wants_solids(arguments):
        from balance.masses.counterweights.parts.step_solids import INSTALL, LIBRARY

        if find_spec(LIBRARY) is None:
            raise PackageError("--solids", LIBRARY, INSTALL)


def make_parts(
    arguments: argparse.Namespace, answer: WithCounterweights
) -> tuple[CounterweightPart, ...]:
    """Make the parts of an answer, if the options want them."""
    if arguments.parts is None:
        return ()
    from balance.masses.counterweights.parts.part_files import parts_of

    return parts_of(answer.weights)


def notices_of_parts(
    arguments: argparse.Namespace, parts: tuple[CounterweightPart, ...]
) -> tuple[Notice, ...]:
    """Tell what is wrong with parts; see `part_notices` of the parts."""
    if not parts:
        return ()
    from balance.masses.counterweights.parts.part_files import part_notices

    return part_notices(parts, _wants_solids(arguments))


def added_matter_files(
    arguments: argparse.Namespace,
    answer: Counterweights | PartialBalance,
    shown: Counterweights | ParetoFront,
    parts: tuple[CounterweightPart, ...],
) -> Files:
    """Find what makes the files of counterweights and of their parts, if there are any.

    Args:
        answer: what is written.
        shown: what the page and the picture show.
    """
    from balance.masses.counterweights.parts.part_files import part_files
    from balance.masses.counterweights.write_counterweights import with_counterweights

    if answer.z is None:
        return {}
    meshes = {part.weight.link: _path_from_output(arguments, part.mesh) for part in parts}
    return {
        **result_files(arguments, shown),
        "out": partial(with_counterweights, answer, merge=arguments.merge, meshes=meshes),
        "parts": partial(part_files, parts, solids=_wants_solids(arguments)),
    }


def _wants_solids(arguments: argparse.Namespace) -> bool:
    """Whether a command has the option, and it is given."""
    return bool(getattr(arguments, "solids", False))


def _path_from_output(arguments: argparse.Namespace, name: str) -> str:
    """Return the path of a part's file from the folder of the file that names it."""
    around = os.path.dirname(os.path.abspath(arguments.out or ""))
    path = os.path.join(os.path.abspath(arguments.parts), name)
    return Path(os.path.relpath(path, around)).as_posix()
