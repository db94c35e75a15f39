"""The result of a command on one linkage, or on two that are compared (``--against``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:
    from kinematics.model.linkage import Notice

__all__ = ["TwoResults"]


class _Result(Protocol):
    """The result on one linkage."""

    @property
    def notices(self) -> Sequence[Notice]: ...

    def to_dict(self) -> dict[str, object]: ...


R = TypeVar("R", bound=_Result)


@dataclass(frozen=True)
class TwoResults(Generic[R]):
    """The result on a linkage, and on a second one.

    Attributes:
        first: the result on the linkage.
        second: that on a second linkage; None without one.
    """

    first: R
    second: R | None

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of both linkages."""
        return (*self.first.notices, *(self.second.notices if self.second else ()))

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        against = self.second.to_dict() if self.second else None
        return self.first.to_dict() | {"against": against}
