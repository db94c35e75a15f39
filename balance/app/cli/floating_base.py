"""Options of ``balance verify`` for a base that floats or stands on springs, and the answer."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE, UNDECIDED
from balance.app.cli.model_readings import solve_model
from balance.app.cli.motion_source import motions_of
from balance.app.cli.number_arguments import number_between, point, values_by_name
from balance.app.cli.outputs import result_files
from balance.app.cli.progress import progress_bar
from balance.app.cli.several_models import data_against
from balance.app.cli.short_notices import notices_by_file

if TYPE_CHECKING:
    from balance.motion.floating_base.base import FloatingBase
    from balance.motion.floating_base.floating_base_motion import FloatingBaseMotion
    from kinematics.model.linkage import Linkage, Notice


NUMBER = r"[+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
# Largest numbers that describe a base, and their inverses: squares do not overflow.
MAX_NUMBER = 1e12
_size = partial(number_between, 1.0 / MAX_NUMBER, MAX_NUMBER)
# Options that need a base.
OWN = (
    "base_mass",
    "base_inertia",
    "base_com",
    "stiffness",
    "initial",
    "torque",
    "duration",
)


def add_base_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of a base to the command ``verify``."""
    group.add_argument(
        "--base",
        choices=("fixed", "free", "spring"),
        default="fixed",
        metavar="free|spring",
        help="simulate a base that floats, or on springs",
    )
    group.add_argument(
        "--base-mass", type=_size("mass"), metavar="KG", help="mass of that base"
    )
    group.add_argument(
        "--base-inertia",
        type=inertia,
        metavar="I|IX,IY,IZ",
        help="its moment of inertia, or three, or with IXY,IXZ,IYZ, kg m²",
    )
    group.add_argument(
        "--base-com",
        type=point,
        metavar="X,Y,Z",
        help="its centre of mass, metres (default 0,0,0)",
    )
    group.add_argument(
        "--stiffness",
        type=_stiffness,
        action="append",
        metavar="1e4Nm/rad",
        help="of its springs: 1e4Nm/rad, 2e5N/m; repeatable",
    )
    group.add_argument(
        "--initial",
        type=_velocities,
        metavar="wz=10,…",
        help="velocities at the start, rad/s and m/s",
    )
    group.add_argument(
        "--torque",
        type=_torques,
        metavar="J1=VALUE,…",
        help="constant torques on inputs that move freely",
    )
    group.add_argument(
        "--duration",
        type=_size("time"),
        metavar="S",
        help="duration, seconds (default: of the table, or 10)",
    )


def check_base_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if options of a base contradict others."""
    if arguments.base == "fixed":
        refuse_given(arguments, OWN, "{}: only with --base free or --base spring")
        return
    both = f"--base {arguments.base}: give --base-mass and --base-inertia"
    refuse_given(arguments, ("base_mass", "base_inertia"), both, given=False)
    if (arguments.base == "spring") != bool(arguments.stiffness):
        arguments.refuse("--stiffness belongs to --base spring: give both or neither")
    kinds = [kind for kind, _ in arguments.stiffness or ()]
    if len(set(kinds)) < len(kinds):
        arguments.refuse("--stiffness: give one rotational and one translational at most")
    if arguments.balance == "force":
        arguments.refuse("--base: not with --balance force, for a base turns too")
    if (arguments.trajectories or 1) > 1:
        arguments.refuse("--trajectories: there is one motion with --base")
    if arguments.torque is not None:
        moved = "--torque: frees the inputs that {} moves"
        refuse_given(arguments, ("csv", "tool_path", "speed", "seed"), moved)


def run_floating_base(arguments: argparse.Namespace) -> Answer:
    """Simulate one or two linkages on a base.

    Raises:
        LinkageError: a linkage, a motion, the base, a file or a library cannot be used.
    """
    with progress_bar("hundredths") as advance:
        results = _simulate(arguments, advance)
    from balance.app.answers.text.floating_base import floating_base_body

    def prepare_files() -> Files:
        from balance.app.answers.html.floating_base import floating_base_table

        table = partial(floating_base_table, results[0])
        return {**result_files(arguments, *results), "table": table}

    code = DONE if results[0].undisturbed else NEGATIVE
    return Answer(
        code if results[0].agreed else UNDECIDED,
        lambda: data_against(*results),
        lambda: floating_base_body(results),
        _notices(results),
        files=prepare_files,
    )


def _notices(results: Sequence[FloatingBaseMotion]) -> list[Notice]:
    """List the notices on one linkage, or on two with the name of each."""
    if len(results) == 1:
        return list(results[0].notices)
    linkages = [each.linkage for each in results]
    return notices_by_file(linkages, [each.notices for each in results])


def _simulate(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> list[FloatingBaseMotion]:
    """Simulate the linkages of the options, one or two."""
    base = _base(arguments)
    base.check()

    def simulate_first(linkage: Linkage) -> FloatingBaseMotion:
        # Load the kernels only after the file is accepted.
        from balance.motion.floating_base.simulate import simulate_floating_base
        from balance.motion.verification.given_motions import rounding_notice

        motions = motions_of(arguments, linkage)
        if motions is None:
            return simulate_floating_base(
                linkage, base, **_options(arguments), progress=advance
            )
        simulation = simulate_floating_base(
            linkage, base, motions=motions[0], **_options(arguments), progress=advance
        )
        told = rounding_notice(motions[0])
        return replace(simulation, notices=(*simulation.notices, *told))

    def simulate_other(linkage: Linkage) -> FloatingBaseMotion:
        from balance.motion.floating_base.simulate import simulate_second

        return simulate_second(first, linkage, **_options(arguments), progress=advance)

    first = solve_model(arguments, simulate_first)
    others = [arguments.against] if arguments.against else []
    return [first, *(solve_model(arguments, simulate_other, model) for model in others)]


def _base(arguments: argparse.Namespace) -> FloatingBase:
    """Make the base of the options."""
    from balance.motion.floating_base.base import FloatingBase

    return FloatingBase(
        arguments.base_mass,
        arguments.base_inertia,
        arguments.base_com or (0.0, 0.0, 0.0),
        **dict(arguments.stiffness or ()),
    )


def _options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of `simulate_floating_base` from the options."""
    options = {
        "torques": arguments.torque,
        "initial": arguments.initial,
        "motion": arguments.motion,
        "duration": arguments.duration,
        "seed": arguments.seed or 0,
        "spatial": arguments.spatial,
    }
    if arguments.tolerance is not None:
        options["tolerance"] = arguments.tolerance
    return options


def _velocities(text: str) -> dict[str, float]:
    """Parse velocities by name."""
    return values_by_name(text, "wz=10,vx=0.1", "angular velocity", "velocity")


def _torques(text: str) -> dict[str, float]:
    """Parse torques and forces by name."""
    return values_by_name(text, "u1=0.5,u2=2", "torque", "force")


def inertia(text: str) -> float | tuple[float, ...]:
    """Parse a moment of inertia, or three, or the six elements of a tensor."""
    words = text.split(",")
    if len(words) not in (1, 3, 6):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a moment of inertia, nor three, nor six elements of a tensor"
        )
    product = number_between(-MAX_NUMBER, MAX_NUMBER, "inertia")
    values = tuple(map(_size("inertia"), words[:3])) + tuple(map(product, words[3:]))
    return values if len(words) > 1 else values[0]


def _stiffness(text: str) -> tuple[str, float]:
    """Parse ``1e4Nm/rad`` or ``2e5N/m``: name of the spring, and its stiffness."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(N\s?m/rad|N/m)?\s*", text)
    if match is None:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a stiffness: write 1e4Nm/rad or 2e5N/m"
        )
    name = "stiffness" if match[2] == "N/m" else "turning_stiffness"
    return name, _size()(match[1])
