"""Options that commands on a model share, and the linkage from them."""

from __future__ import annotations

import argparse
import logging
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from balance.app.cli.arguments import NAMED_ALONE, Parser
from balance.app.cli.number_arguments import values_by_name, whole_number

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage


# Radians from which an angle without a unit is more than a turn.
MORE_THAN_A_TURN = 6.4
# Degrees beyond which nobody means an angle.
MOST_DEGREES = 3600.0


def add_model_options(
    parser: Parser,
    unused: Collection[str] = (),
    explain: bool = False,
    motion_alone: bool = False,
    named: tuple[str, str] = ("MODEL", "robot file, - for stdin, or name of a model"),
) -> None:
    """Add the options of a model, of its motion, and of output.

    Args:
        parser: the parser of a command.
        unused: of ``--motion``, ``--balance`` and ``--spatial``, those that mean nothing to the
            command: it does not get them, and their values are the defaults.
        explain: whether its help explains how a file is read.
        motion_alone: whether its help has the names of inputs, poses and relations alone.
        named: what stands for the model in the help, and what it may be.
    """
    parser.group("model").add_argument("model", metavar=named[0], help=named[1])
    _add_reading_options(parser.group("model" if explain else NAMED_ALONE))
    _add_pose_options(parser.group(NAMED_ALONE if motion_alone else "motion"))
    _add_restrictions(parser, unused, motion_alone)
    output = parser.group("output")
    output.add_argument("--json", action="store_true", help="print one JSON object")
    output.add_argument(
        "--overwrite",
        action="store_true",
        help="let a written file replace one that is read",
    )
    # Options that exclude each other are usage errors.
    parser.set_defaults(refuse=parser.error)


def _add_reading_options(group: argparse._ArgumentGroup) -> None:
    """Add the options on how the links, joints and numbers of a file are read."""
    group.add_argument(
        "--loops", metavar="FILE", help="YAML file of the loops (default: beside the model)"
    )
    group.add_argument(
        "--fix-base", action="store_true", help="fix a base that floats to the ground"
    )
    group.add_argument("--ground", metavar="LINK", help="which loose link is the ground")
    group.add_argument(
        "--bodies",
        choices=("given", "all"),
        default="given",
        metavar="given|all",
        help="all: links without mass carry parameters too",
    )
    group.add_argument(
        "--massless",
        type=parse_names,
        default=[],
        metavar="L1,L2",
        help="links that carry no parameters",
    )
    reading = group.add_mutually_exclusive_group()
    reading.add_argument(
        "--nominal",
        dest="angles",
        action="store_const",
        const="nominal",
        default="nominal",
        help="read 1.5708 as π/2 (the default)",
    )
    reading.add_argument(
        "--as-written",
        dest="angles",
        action="store_const",
        const="as_written",
        help="read all angles and axes by their digits",
    )


def _add_pose_options(group: argparse._ArgumentGroup) -> None:
    """Add the options for coordinates, reference pose and motion."""
    group.add_argument(
        "--inputs", type=parse_names, metavar="J1,J2", help="joints that are the inputs"
    )
    group.add_argument(
        "--at",
        type=parse_coordinates,
        metavar="J1=VALUE,…",
        help="another reference pose: u1=0.3, or u1=30deg",
    )
    group.add_argument(
        "--mode",
        type=whole_number(1, 99, "a mode"),
        metavar="N",
        help="mode of motion, where several meet",
    )


def _add_restrictions(parser: Parser, unused: Collection[str], motion_alone: bool) -> None:
    """Add the options for the motions that count, and what of them."""
    parser.set_defaults(motion=None, balance="dynamic", spatial=False)
    options: dict[str, dict[str, Any]] = {
        "--motion": {
            "action": "append",
            "metavar": "RELATION",
            "help": "relation of inputs: j4=-2*j7, j3=0; repeatable",
        },
        "--balance": {
            "choices": ("dynamic", "force"),
            "metavar": "dynamic|force",
            "help": "force: without moments (default dynamic)",
        },
        "--spatial": {
            "action": "store_true",
            "help": "ten parameters a body, in the plane too",
        },
    }
    for name, option in options.items():
        if name not in unused:
            alone = motion_alone and name == "--motion"
            parser.group(NAMED_ALONE if alone else "motion").add_argument(name, **option)


def model_words(arguments: argparse.Namespace, loops: str | None) -> list[str]:
    """List the words of a command that ask for the same motions of a model, without the model.

    Args:
        loops: file of the loops; None for the one beside the model.
    """
    lists = (("--inputs", arguments.inputs), ("--massless", arguments.massless))
    pairs = [("--loops", loops), *((flag, ",".join(names or ())) for flag, names in lists)]
    pairs += [("--motion", relation) for relation in arguments.motion or ()]
    pairs += [("--require", text) for text in getattr(arguments, "require", ())]
    words = [word for flag, value in pairs if value for word in (flag, value)]
    if arguments.at:
        words += ["--at", ",".join(f"{name}={value!r}" for name, value in arguments.at.items())]
    words += ["--mode", str(arguments.mode)] if arguments.mode else []
    words += ["--fix-base"] * arguments.fix_base
    words += ["--as-written"] * (arguments.angles == "as_written")
    if getattr(arguments, "gravity", None):
        words.append(f"--gravity={','.join(map(repr, arguments.gravity))}")
    return [*words, *["--balance", "force"] * (arguments.balance == "force")]


def load_model(arguments: argparse.Namespace, angles: str, other: str = "") -> Linkage:
    """Load the linkage of the options, and check the units of all coordinates among them.

    Args:
        angles: reading of rounded angles, ``"nominal"`` or ``"as_written"``.
        other: path or name of another model to load with the same options.

    Returns:
        The assembled linkage.

    Raises:
        LinkageError: the file or the linkage cannot be used.
    """
    from kinematics.loading.model_gallery import load

    linkage = load(
        other or arguments.model,
        None if other else arguments.loops,
        arguments.inputs,
        fix_base=arguments.fix_base,
        bodies=arguments.bodies,
        massless=arguments.massless,
        angles=angles,
        at=arguments.at,
        mode=arguments.mode,
        ground=arguments.ground,
    )
    for value in vars(arguments).values():
        for positions in value if isinstance(value, list) else [value]:
            if isinstance(positions, Coordinates):
                check_units(linkage, positions)
    if getattr(arguments, "payload", None) is None:
        return linkage
    from balance.masses.payload import carrying

    return carrying(linkage, arguments.payload, apart=arguments.payload_apart)


def check_units(linkage: Linkage, positions: Mapping[str, float]) -> None:
    """Refuse an angle of a joint that slides, and a length of one that turns.

    Warn of angles without a unit that may be degrees.

    Args:
        positions: positions of joints by name, those with a unit as `UnitNumber`.

    Raises:
        PoseError: a unit does not fit its joint.
    """
    from balance.support.units import UnitNumber
    from kinematics.errors import PoseError

    kinds = {joint.name: joint.kind for joint in linkage.joints}
    for name in kinds.keys() & positions.keys():
        value, slides = positions[name], kinds[name] == "prismatic"
        wanted = "length" if slides else "angle"
        if isinstance(value, UnitNumber) and value.quantity != wanted:
            article = "a length, such as 20mm" if slides else "an angle, such as 30deg"
            raise PoseError(
                f"{linkage.source}: joint '{name}' is {kinds[name]}: its position is {article}"
            )
        degrees = MORE_THAN_A_TURN < abs(value) <= MOST_DEGREES
        if degrees and not slides and not isinstance(value, UnitNumber):
            logging.warning(
                "degrees: %s=%g are radians, more than a turn: for degrees write %s=%gdeg",
                name,
                value,
                name,
                value,
            )


def parse_names(text: str) -> list[str]:
    """Parse names of ``a,b``."""
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names: write a,b")
    return names


class Coordinates(dict[str, float]):
    """Positions of joints by name, as an option gives them."""


def parse_coordinates(text: str) -> Coordinates:
    """Parse positions of joints by name, of ``u1=0.3,u2=-10deg``.

    Raises:
        ArgumentTypeError: the text is nothing like it, or names one twice.
    """
    return Coordinates(values_by_name(text, "u1=0.3,u2=-10deg", "angle", "length"))
