"""The command ``balance synthesize``: its options, and its answer."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser, add_json_option
from balance.app.cli.density_options import add_density_option
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.number_arguments import finite_number, positive_quantity
from balance.app.cli.outputs import (
    add_page_option,
    add_picture_option,
    add_table_option,
    kind_of,
    result_files,
)
from balance.app.cli.progress import progress_bar

if TYPE_CHECKING:
    from balance.studies.synthesis.mechanism import Synthesis


Positions = list[tuple[float, float, float]]


def add_synthesize(parser: Parser) -> None:
    """Add the options of the command ``synthesize``."""
    parser.description = (
        "Finds mechanisms that are balanced by design and whose tool passes through positions "
        "in the plane, or whose rocker follows a function, and confirms each as "
        "'balance report' and 'verify' do. Exits with 0 if one is confirmed and has no "
        "defects, 1 if there is none, 4 if none could be confirmed."
    )
    _add_task_options(parser)
    _add_method_options(parser)
    add_density_option(
        parser,
        "matter of links or rotors",
        steel=True,
        thickness="of plates (default 1/20 or 1/8 of the base; rotors: no plates)",
    )
    parser.add_argument(
        "--out", metavar="FILE.urdf", help="write the best mechanism as a URDF file"
    )
    add_table_option(parser, "write the motion of several inputs")
    parser.add_argument(
        "--slot",
        type=_slot_path,
        metavar="FILE.csv|.svg|.dxf",
        help="write the slot in the base for a pin, in the nonlinear case",
    )
    add_picture_option(parser)
    add_page_option(parser, "with the mechanism and the map")
    add_json_option(parser, _run)
    parser.group("output").add_argument(
        "--overwrite",
        action="store_true",
        help="let a written file replace one that is read",
    )


def _add_task_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of positions and of functions."""
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument(
        "--positions",
        type=_positions,
        default=(),
        metavar='"x,y,deg; …"',
        help="two or three of the tool, or more for others than pantographs: metres, and "
        "degrees by which it turns",
    )
    task.add_argument(
        "--function",
        metavar="FILE.csv",
        help="or angles 'crank [deg],rocker [deg]' of any four-bar",
    )
    parser.add_argument(
        "--start",
        type=_start,
        metavar="DEG,DEG",
        help="both from the base at the first of three points",
    )
    parser.add_argument(
        "--base-length",
        type=positive_quantity("length"),
        metavar="LENGTH",
        help="of the four-bar of a function (default 1 m)",
    )
    parser.add_argument(
        "--timed",
        action="store_true",
        help="the degrees are those of the crank of a four-bar",
    )


def _add_method_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the kind of mechanism and its pivots."""
    parser.add_argument(
        "--kind",
        choices=(
            "pantograph",
            "four-bar",
            "slider-crank",
            "geared-four-bar",
            "six-bar",
            "stack",
        ),
        default="pantograph",
        help="pantograph (default); kite or antiparallelogram; crank and coupler of one "
        "length; any four-bar with rotors, or with a dyad; three decoupled freedoms",
    )
    case = parser.add_mutually_exclusive_group()
    case.add_argument(
        "--ratio",
        type=finite_number,
        metavar="K",
        help="turn of the first link over that of the tool, constant and negative (default -1)",
    )
    case.add_argument(
        "--nonlinear",
        action="store_true",
        help="let the ratio vary, and search the pivots",
    )
    pivot = parser.add_mutually_exclusive_group()
    pivot.add_argument(
        "--fixed",
        type=_point,
        metavar="X,Y",
        help="pivot on the base, for two positions",
    )
    pivot.add_argument(
        "--moving",
        type=_point,
        metavar="X,Y",
        help="or the one on the tool, at the first position",
    )
    parser.add_argument(
        "--within",
        type=positive_quantity("length", "angle"),
        default=0.0,
        metavar="LENGTH|ANGLE",
        help="how far four or more may be missed (default: not)",
    )
    parser.add_argument(
        "--masses",
        metavar="FILE.json",
        help="of the pantograph (default: in proportion to it)",
    )
    parser.add_argument(
        "--window",
        type=_numbers,
        metavar="X0,X1[,Y0,Y1]",
        help="where the free or the moving pivot is searched",
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Synthesise the mechanisms of the options.

    Raises:
        LinkageError: nothing can be synthesised, or a file cannot be read or written.
    """
    with progress_bar("steps of the search") as advance:
        synthesis = _synthesize(arguments, advance)
    if arguments.table is not None and not (arguments.nonlinear or arguments.kind == "stack"):
        arguments.refuse(
            "--table: only with --nonlinear or --kind stack: other mechanisms have one input"
        )
    if arguments.slot is not None and not arguments.nonlinear:
        arguments.refuse("--slot: only with --nonlinear: a belt couples the links otherwise")
    from balance.app.answers.text.synthesis import synthesis_body

    return Answer(
        verdict_code(synthesis.verdict),
        synthesis.to_dict,
        lambda: synthesis_body(synthesis),
        files=lambda: _prepare_mechanism_files(arguments, synthesis),
    )


def _synthesize(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> Synthesis:
    """Call `synthesize` with the options."""
    from balance.studies.synthesis.function_four_bars import read_function
    from balance.studies.synthesis.mass_file import read_masses
    from balance.studies.synthesis.request import GENERAL
    from balance.studies.synthesis.synthesize import synthesize

    if arguments.function is not None and arguments.kind not in GENERAL:
        arguments.refuse(f"--function: give --kind {' or --kind '.join(GENERAL)}")
    masses = None if arguments.masses is None else read_masses(arguments.masses)
    function = () if arguments.function is None else read_function(arguments.function)
    wanted = "angle" if function else "length"
    if getattr(arguments.within, "quantity", "") not in ("", wanted):
        arguments.refuse(f"--within: give a unit of {wanted}")
    return synthesize(
        arguments.positions,
        arguments.ratio,
        nonlinear=arguments.nonlinear,
        kind=arguments.kind,
        fixed=arguments.fixed,
        moving=arguments.moving,
        masses=masses,
        window=arguments.window,
        within=arguments.within,
        density=arguments.density,
        thickness=arguments.thickness,
        timed=arguments.timed,
        function=function,
        start=arguments.start,
        base=arguments.base_length,
        progress=advance,
    )


def _prepare_mechanism_files(arguments: argparse.Namespace, synthesis: Synthesis) -> Files:
    """Prepare the makers of the files of a synthesis; no mechanism, no file of it."""
    from balance.studies.synthesis.constrained_motion import motion_csv
    from balance.studies.synthesis.couplings import SlotCoupling, slot_file

    files = dict(result_files(arguments, synthesis))
    if not synthesis.mechanisms:
        return files
    best = synthesis.mechanisms[0]
    files["out"] = lambda: best.urdf
    if best.table is not None:
        files["table"] = partial(motion_csv, best.table)
    if isinstance(best.coupling, SlotCoupling):
        files["slot"] = partial(slot_file, best.coupling, kind_of(arguments.slot))
    return files


def _slot_path(text: str) -> str:
    """Check that a word names a table or a drawing."""
    if not text.lower().endswith((".csv", ".svg", ".dxf")):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .csv, .svg nor .dxf")
    return text


def _positions(text: str) -> Positions:
    """Parse positions of ``x,y,deg; x,y,deg``."""
    positions = []
    for word in text.split(";"):
        numbers = _split(word)
        if len(numbers) != 3:
            raise argparse.ArgumentTypeError(
                f"'{word.strip()}' is not x,y,deg: write \"0.3,0.1,10; 0.1,0.4,-40\""
            )
        x, y, degrees = numbers
        positions.append((x, y, math.radians(degrees)))
    return positions


def _start(text: str) -> tuple[float, ...]:
    """Parse two angles of degrees."""
    numbers = _split(text)
    if len(numbers) != 2:
        raise argparse.ArgumentTypeError(f"'{text}' is not two angles: write 30,60")
    return tuple(map(math.radians, numbers))


def _point(text: str) -> complex:
    """Parse a point of ``x,y``."""
    numbers = _split(text)
    if len(numbers) != 2:
        raise argparse.ArgumentTypeError(f"'{text}' is not a point x,y")
    return complex(*numbers)


def _numbers(text: str) -> tuple[float, ...]:
    """Parse two or four numbers."""
    numbers = _split(text)
    if len(numbers) not in (2, 4):
        raise argparse.ArgumentTypeError(f"'{text}' is not X0,X1 or X0,X1,Y0,Y1")
    return tuple(numbers)


def _split(text: str) -> list[float]:
    """Split numbers at commas; an empty list if one is none or not finite."""
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []
