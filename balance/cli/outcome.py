"""The outcome of a command: what is printed, and the exit code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from kinematics.model.linkage import Notice

__all__ = ["Outcome"]


class Outcome(NamedTuple):
    """The outcome of a command.

    Attributes:
        code: the exit code.
        data: computes the object that ``--json`` prints.
        text: computes the text that is printed otherwise.
        styled: computes the text for a terminal, with its line ends; None if that is the same.
        notices: remarks, printed on standard error before the answer.
        remark: one more line there; empty if there is none.
    """

    code: int
    data: Callable[[], object]
    text: Callable[[], str]
    styled: Callable[[], str] | None = None
    notices: Sequence[Notice] = ()
    remark: str = ""
