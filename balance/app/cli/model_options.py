"""Options that commands on a model share, and the linkage from them."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from balance.app.cli.number_arguments import whole_number

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that every command on a model shares."""
    parser.add_argument(
        "model",
        help="path of a URDF, SDF or xacro file, - for standard input, a name from 'balance "
        "models', or a robot of example-robot-data if that is installed",
    )
    parser.add_argument(
        "--loops", metavar="FILE",
        help="YAML file that describes the loops; by default the one next to the URDF file",
    )  # fmt: skip
    _add_reading_options(parser)
    _add_pose_options(parser)
    parser.add_argument(
        "--motion", action="append", metavar="RELATION",
        help="linear relation of input displacements: j4=j7, j4=-2*j7, j3=0; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--balance", choices=("dynamic", "force"), default="dynamic",
        help="force: linear momentum only",
    )  # fmt: skip
    parser.add_argument(
        "--spatial", action="store_true", help="ten parameters per body, even if it is planar"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--force", action="store_true",
        help="let a file that is written replace one that is read, such as the model",
    )  # fmt: skip
    # Options that exclude each other are usage errors.
    parser.set_defaults(refuse=parser.error)


def _add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Add the options on how the links, joints and numbers of a file are read."""
    parser.add_argument(
        "--fix-base", action="store_true",
        help="fix a base that floats to the ground, and no other body that floats",
    )  # fmt: skip
    parser.add_argument(
        "--ground", metavar="LINK",
        help="link that is the ground, of those that no joint carries, or of an SDF model that "
        "is not fixed to the world; loose links are left out then",
    )  # fmt: skip
    parser.add_argument(
        "--bodies", choices=("given", "all"), default="given",
        help="all: links without mass in the file carry parameters too",
    )  # fmt: skip
    parser.add_argument(
        "--massless", type=_names, default=[], metavar="L1,L2",
        help="links that carry no parameters, whatever the file says",
    )  # fmt: skip
    reading = parser.add_mutually_exclusive_group()
    reading.add_argument(
        "--nominal", dest="angles", action="store_const", const="nominal", default="nominal",
        help="read angles that look rounded, such as 1.5708, as the multiples of π/12 they "
        "round (the default)",
    )  # fmt: skip
    reading.add_argument(
        "--as-written", dest="angles", action="store_const", const="as_written",
        help="take all angles and axes by their digits, in loops that do not quite close too",
    )  # fmt: skip


def _add_pose_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for coordinates and reference pose."""
    parser.add_argument(
        "--inputs", type=_names, metavar="J1,J2",
        help="joints to use as independent coordinates",
    )  # fmt: skip
    parser.add_argument(
        "--at", type=parse_coordinates, metavar="J1=VALUE,…",
        help="another reference pose than that of the file: positions of joints counted from "
        "the pose of the file, in radians and metres (u1=0.3,u2=-0.1); the others follow, and "
        "displacements count from there. Positions of joints that are no inputs are starting "
        "values: they choose the branch on which the loops close",
    )  # fmt: skip
    parser.add_argument(
        "--mode", type=whole_number(1, 99, "a mode"), metavar="N",
        help="mode of motion to follow where several meet, at the pose of the file or at that "
        "of --at; 'balance report' lists them. The reference pose is on that mode",
    )  # fmt: skip


def load_model(arguments: argparse.Namespace, angles: str, other: str = "") -> Linkage:
    """Load the linkage of the options.

    Args:
        angles: reading of rounded angles, ``"nominal"`` or ``"as_written"``.
        other: path or name of another model to load with the same options.

    Returns:
        The assembled linkage.

    Raises:
        LinkageError: the file or the linkage cannot be used.
    """
    from kinematics.loading.model_gallery import load

    return load(
        other or arguments.model, None if other else arguments.loops, arguments.inputs,
        fix_base=arguments.fix_base, bodies=arguments.bodies, massless=arguments.massless,
        angles=angles, at=arguments.at, mode=arguments.mode, ground=arguments.ground,
    )  # fmt: skip


def _names(text: str) -> list[str]:
    """Parse names of ``a,b``."""
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names: write a,b")
    return names


def parse_coordinates(text: str) -> dict[str, float]:
    """Parse values by name of ``u1=0.3,u2=-0.1``.

    Raises:
        ArgumentTypeError: the text is nothing like it, or names one twice.
    """
    words = [word.rpartition("=") for word in text.split(",")]
    names = [name.strip() for name, *_ in words]
    try:
        values = [float(value) for *_, value in words]
    except ValueError:
        values = [math.nan]
    if not all(names) or len(set(names)) < len(names) or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"'{text}' is not u1=0.3,u2=-0.1 with each joint once")
    return dict(zip(names, values, strict=True))
