"""The command ``balance new``: its options, and its answer."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.model_options import parse_names
from balance.support.atomic_files import is_stream
from kinematics.errors import UsageError


def add_new(parser: Parser) -> None:
    """Add the options of the command ``new``."""
    parser.description = (
        "Writes the URDF file of a planar linkage from the points and links of a sketch, with "
        "loops, inputs, masses of bars and their shapes. Lengths are in metres or have a unit; "
        "angles have one, deg or rad."
    )
    parser.add_argument("out", metavar="FILE.urdf", help="file to write")
    parser.add_argument(
        "--points",
        required=True,
        metavar='"A=…; B=…"',
        help="A=0,400mm (x,y); C=A+250mm@120deg; P=C+80mm@E (from C towards E); "
        "E=C:350mm,D:350mm (distances; left of C to D); F=C:350mm,A@0deg (on a line)",
    )
    parser.add_argument(
        "--links",
        required=True,
        metavar='"L=A,C; …"',
        help="the points of each link; joints are where links share one. base=A,B: points of "
        "the base (default: those that one link alone has)",
    )
    parser.add_argument(
        "--sliders",
        default="",
        metavar='"L=C@ANGLE; …"',
        help="blocks at a point that slide on the base; or C@D, along the line CD",
    )
    parser.add_argument(
        "--inputs",
        type=parse_names,
        metavar="J1,J2",
        help="joints that are driven (default: on the base first)",
    )
    _add_matter_options(parser)
    add_json_option(parser, _run)
    parser.group("output").add_argument(
        "--overwrite", action="store_true", help="let the file replace another one"
    )
    parser.elsewhere = {"--base": "write base=A,B in --links"}
    parser.add_examples(
        'balance new legs.urdf --points "A=0,0; B=400mm,0; C=A+250mm@120deg; '
        "D=B+250mm@60deg; \\",
        '  E=C:350mm,D:350mm" --links "l1=A,C; l2=C,E; r1=B,D; r2=D,E" --section 30mmx10mm',
        'balance new engine.urdf --points "O=0,0; A=O+50mm@60deg; C=A:180mm,O@0deg" \\',
        '  --links "crank=O,A; rod=A,C" --sliders "piston=C@0deg" --section d20mm --mass '
        "piston=0.5",
    )


def _add_matter_options(parser: Parser) -> None:
    """Add the options for sections, densities and masses."""
    matter = parser.group("matter")
    matter.add_argument(
        "--section",
        action="append",
        default=[],
        metavar="[L=]WxT|dD",
        help="of bars: 30mmx10mm, d20mm; crank=d25mm (default: links have no mass)",
    )
    matter.add_argument(
        "--density",
        action="append",
        default=[],
        metavar="[L=]KG/M3",
        help="7850, 7.85g/cm3, aluminium; rod=titanium (default steel)",
    )
    matter.add_argument(
        "--mass",
        action="append",
        default=[],
        metavar="L=KG",
        help="piston=0.5,rod=200g, in place of the mass of the bars",
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Build the linkage of the sketch.

    Raises:
        UsageError: the sketch is written wrongly, or the file exists.
        LinkageError: the linkage cannot be built.
    """
    path = arguments.out
    _check_path(path, arguments.overwrite)
    from balance.app.answers.text.sketched_linkage import sketch_body
    from balance.studies.sketches.from_sketch import linkage_from_sketch

    sketch = linkage_from_sketch(
        arguments.points,
        arguments.links,
        arguments.sliders,
        section=",".join(arguments.section),
        density=",".join(arguments.density) or "steel",
        mass=",".join(arguments.mass),
        inputs=arguments.inputs,
        name=Path(path).stem,
    )
    return Answer(
        DONE,
        sketch.to_dict,
        lambda: sketch_body(sketch, path),
        notices=sketch.notices,
        files=lambda: {"out": sketch.to_urdf},
    )


def _check_path(path: str, overwrite: bool) -> None:
    """Refuse a path that does not end in .urdf, or an existing file without --overwrite.

    Raises:
        UsageError: it is one of these, and no stream.
    """
    if is_stream(path):
        return
    from kinematics.error_text import clean

    if not path.lower().endswith(".urdf"):
        raise UsageError(f"{clean(path, 1000)}: the name of the file ends in .urdf")
    if os.path.exists(path) and not overwrite:
        raise UsageError(f"{clean(path, 1000)} exists: give another name, or --overwrite")
