"""All exceptions that this project raises on purpose.

Each message is one line that states the problem, its place and the remedy.
The facts behind the message are attributes, so that programs need not parse text.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

# Modes that a message describes.
MAX_LISTED_MODES = 8


class LinkageError(ValueError):
    """Base class: a linkage, or a request for it, that cannot be used."""


class UsageError(LinkageError):
    """A request that is wrong for every linkage."""


class PackageError(UsageError):
    """A missing package that a request needs.

    Attributes:
        package: its name.
        command: the command that installs it.
    """

    def __init__(self, purpose: str, package: str, command: str, more: str = "") -> None:
        """Compose the message; ``more`` names another way to install it."""
        self.package, self.command = package, command
        super().__init__(
            f"{purpose} needs {package}, which is not installed; install it with "
            f"'{command}'{more}"
        )


def _did_you_mean(name: str, valid: Sequence[str]) -> str:
    """Ask for a known name that is like another; nothing if the name is known."""
    if name in valid:
        return ""
    from kinematics.error_text import did_you_mean

    return did_you_mean(name, valid)


class BodyError(LinkageError):
    """A body that does not exist, or that a request cannot use.

    Attributes:
        body: name of the link at fault.
        problem: the fault.
        valid: names of the bodies, if the name is the problem.
    """

    def __init__(
        self, linkage: str, body: str, problem: str, valid: Sequence[str] = ()
    ) -> None:
        """Compose the message and list the bodies."""
        self.linkage, self.body, self.problem, self.valid = linkage, body, problem, tuple(valid)
        names = f"; the bodies are {', '.join(self.valid)}" if valid else ""
        meant = _did_you_mean(body, self.valid) if valid else ""
        super().__init__(f"{linkage}: link '{body}': {problem}{meant}{names}")


class ExactError(LinkageError):
    """A linkage, or a motion, that exact arithmetic cannot treat."""


class InexactClosureError(ExactError):
    """Loops that close only to the rounding of the numbers in the file.

    Attributes:
        orders: how many orders of the motion close exactly.
        mobility: degrees of freedom at first order, of the numbers as they are written.
    """

    def __init__(self, linkage: str, orders: int, mobility: int) -> None:
        """Compose the message."""
        self.orders, self.mobility = orders, mobility
        super().__init__(
            f"{linkage}: its geometry is not exactly representable: in the decimals of the "
            f"file the loops close at {orders} orders, and not at the next; write it with "
            "decimals that close exactly, or do without exact arithmetic"
        )


class InexactPlaneError(ExactError):
    """A linkage that is planar only to the rounding of its axes.

    Attributes:
        deviation: largest angle between them, radians.
    """

    def __init__(self, linkage: str, deviation: float) -> None:
        """Compose the message."""
        self.deviation = deviation
        super().__init__(
            f"{linkage}: planar only up to rounding: its axes are not exactly parallel; write "
            "them with rational directions, or count all parameters (spatial)"
        )


class FileError(LinkageError):
    """A file that cannot be read as a linkage.

    Attributes:
        file: path or name of the file.
        element: the element at fault, such as ``joint 'j1'``, or an empty string.
        problem: the fault.
        remedy: how to correct it.
    """

    def __init__(self, file: str, element: str, problem: str, remedy: str) -> None:
        """Compose ``file: element: problem; remedy``."""
        self.file, self.element, self.problem, self.remedy = file, element, problem, remedy
        where = f"{file}: {element}: " if element else f"{file}: "
        super().__init__(f"{where}{problem}; {remedy}")


class OpenLoopError(LinkageError):
    """A loop that does not close at the pose of the file.

    Attributes:
        loop: name of the loop that is furthest open.
        distance: gap in metres.
        angle: misalignment in radians.
        starts: number of poses from which closing it was tried.
    """

    def __init__(
        self,
        linkage: str,
        loop: str,
        distance: float,
        angle: float,
        starts: int,
        remedy: str = "",
    ) -> None:
        """Compose the message from the size of the gap."""
        self.linkage, self.loop, self.starts = linkage, loop, starts
        self.distance, self.angle = distance, angle
        super().__init__(
            f"{linkage}: loop '{loop}': does not close: its frames are {distance:.3g} m and "
            f"{angle:.3g} rad apart, and no pose near any of {starts} starts closes it; "
            f"{remedy or 'correct the origins of the loop, or the joints along it'}"
        )


class MobilityError(LinkageError):
    """A linkage that cannot move, or cannot be moved away from its pose.

    Attributes:
        order: at which the loops stop closing, if the linkage moves only infinitesimally.
        joints: names of the joints at fault, as far as they are known.
    """

    def __init__(self, text: str, order: int = 0, joints: Sequence[str] = ()) -> None:
        """Keep the facts beside the message."""
        self.order, self.joints = order, tuple(joints)
        super().__init__(text)


class MeetingModesError(MobilityError):
    """A pose at which modes of motion meet, so that it does not determine which one is meant.

    Attributes:
        modes: all of them, `kinematics.model.mode_of_motion.ModeOfMotion`.
        doubt: why there may be more; empty if nothing speaks for it.
    """

    def __init__(
        self, linkage: str, modes: Sequence[Any], joints: Sequence[str], doubt: str = ""
    ) -> None:
        """Compose the message and list the modes."""
        self.modes = tuple(modes)
        self.doubt = doubt
        listed = [
            f"mode {mode.number}: mobility {mode.mobility}, at {mode.place}"
            for mode in self.modes[:MAX_LISTED_MODES]
        ]
        more = len(self.modes) - len(listed)
        text = "; ".join([*listed, *([f"and {more} more"] if more else [])])
        here = sum(mode.here for mode in self.modes)
        in_all = f", of {len(self.modes)} in all" if here < len(self.modes) else ""
        super().__init__(
            f"{linkage}: singular at its pose: {here} modes of motion meet there{in_all}, and "
            f"the pose does not determine which one is meant: {text}; "
            + (f"there may be more: {doubt}; " if doubt else "")
            + "choose one by its number, such as --mode 1",
            joints=joints,
        )


class CoordinateError(LinkageError):
    """Joints that cannot serve as independent coordinates.

    Attributes:
        names: the joints at fault.
        valid: joints that can serve.
    """

    def __init__(
        self, linkage: str, names: Sequence[str], problem: str, valid: Sequence[str]
    ) -> None:
        """Compose the message and list the joints that can serve."""
        self.linkage, self.names, self.valid = linkage, tuple(names), tuple(valid)
        label = "inputs" if len(self.names) > 1 else "input"
        meant = "".join(_did_you_mean(name, self.valid) for name in self.names[:1])
        super().__init__(
            f"{linkage}: {label} {', '.join(self.names)}: {problem}{meant}; "
            f"choose from {', '.join(self.valid)}"
        )


class MotionError(LinkageError):
    """A motion relation that cannot be used.

    Attributes:
        relation: the text of the relation.
        problem: the fault.
        valid: names of the inputs that a relation may use.
    """

    def __init__(
        self, relation: str, problem: str, valid: Sequence[str], linkage: str = ""
    ) -> None:
        """Compose the message and list the inputs."""
        self.relation, self.problem, self.valid = relation, problem, tuple(valid)
        where = f"{linkage}: " if linkage else ""
        super().__init__(
            f"{where}motion '{relation}': {problem}; the inputs are {', '.join(self.valid)}"
        )


class PoseError(LinkageError):
    """A pose that the linkage cannot take."""


class _RemediedError(LinkageError):
    """A fault with its remedy.

    Attributes:
        problem: the fault.
        remedy: how to correct it.
    """

    def __init__(self, problem: str, remedy: str) -> None:
        """Compose ``problem; remedy``."""
        self.problem, self.remedy = problem, remedy
        super().__init__(f"{problem}; {remedy}")


class SynthesisError(_RemediedError):
    """Points, positions, pivots or masses from which no mechanism can be made."""


class UnreachedError(PoseError):
    """A pose that is not reached along the straight line from the reference pose.

    Attributes:
        share: part of the line that was followed, from 0 to 1.
        positions: of the joints at its end (n,), in the units of their chain.
    """

    def __init__(
        self, linkage: str, goal: str, share: float, positions: Sequence[float], steps: int = 0
    ) -> None:
        """Compose the message; ``steps`` is their number, if they were used up."""
        self.share, self.positions = share, tuple(positions)
        part = f"{share:.0%}"
        if part in ("0%", "100%"):
            part = f"{min(share, 0.9999):.2%}"
        text = f"the loops cannot be closed beyond {part} of the way to {goal}"
        if steps:
            text = f"{steps} steps lead {part} of the way to {goal}"
        super().__init__(
            f"{linkage}: {text}; give a nearer pose, take other inputs, or start from another "
            "reference pose"
        )


class WorkerError(_RemediedError):
    """Processes or machines that cannot compute what they were given."""
