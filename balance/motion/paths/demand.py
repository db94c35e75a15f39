"""What a path must keep at rest: all or a part of the momentum, on a fixed or free base."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Literal

from balance.motion.floating_base.base import FloatingBase
from balance.motion.pose.null_space import Components
from kinematics.errors import UsageError
from kinematics.wording import vector_text

Kept = Literal["all", "moment", "force", "attitude", "turned"]


@dataclass(frozen=True)
class Demand:
    """The part of the momentum that vanishes along a path, ``A(q) u̇ = 0``.

    With the momentum matrix ``M_B = [ξ; p]`` per unit rate of each input:

    - ``"all"``: ``[ξ; p]``; a base that is fixed feels nothing, one that floats stays at rest;
    - ``"moment"``: ξ about the inertial origin, or ``ξ - r × p`` about a point r;
    - ``"force"``: p;
    - ``"attitude"``: the base floats and translates with ``v = -p / m``, which leaves no linear
      momentum, but does not turn: ``ξ - c × p`` with mass m and centre of mass c of linkage and
      base together;
    - ``"turned"``: nothing of it: the base floats, and turns so that no momentum is left; paths
      to a pose turn it by a given rotation.

    Attributes:
        kept: one of these.
        base: the base that floats, of which mass and centre of mass count; None if it is
            fixed.
        about: point (3,) of the moment alone, fixed in the inertial frame, metres; None for the
            inertial origin.
        tolerance: part of the momenta of the bodies that may be left along a path; 0 for
            round-off.
    """

    kept: Kept = "all"
    base: FloatingBase | None = None
    about: tuple[float, float, float] | None = None
    tolerance: float = 0.0

    @property
    def components(self) -> Components | None:
        """What counts of the momentum matrix about the inertial origin, on a fixed base.

        None if the base floats, or if the moment is about another point.
        """
        if self.base is not None or self.about is not None:
            return None
        if self.kept in ("moment", "force"):
            return "moment" if self.kept == "moment" else "force"
        return "both"

    def check(self) -> None:
        """Check that the parts fit together.

        Raises:
            UsageError: they do not.
        """
        if self.kept in ("attitude", "turned") and self.base is None:
            raise UsageError("the attitude is that of a base that floats: give its mass too")
        if self.kept == "turned" and self.base is not None:
            self.base.check()
        if self.kept in ("moment", "force") and self.base is not None:
            raise UsageError(
                f"a base that floats has no {self.kept}-only paths: keep all of it at rest, or "
                "its attitude alone"
            )
        if self.about is not None and (
            self.kept != "moment" or not all(map(isfinite, self.about))
        ):
            raise UsageError("a point of three finite coordinates goes with the moment alone")
        if not 0.0 <= self.tolerance < 1.0:
            raise UsageError("a tolerance is a part of the momenta, from 0 up to 1")
        if self.base is not None and not (
            0.0 <= self.base.mass < float("inf") and all(map(isfinite, self.base.com))
        ):
            raise UsageError("a base needs a mass of at least 0 kg and a centre of mass")

    @property
    def words(self) -> str:
        """What is at rest, in words."""
        if self.tolerance:
            return f"{self._words}, within {self.tolerance:.3g} of the bodies' own momenta"
        return self._words

    @property
    def _words(self) -> str:
        """What is at rest, without the tolerance."""
        if self.base is not None:
            words = {"attitude": "it does not turn", "turned": "it turns as is asked for"}
            return "the base floats; " + words.get(self.kept, "all of it stays at rest")
        return {
            "all": "no shaking force, no shaking moment",
            "moment": f"no shaking moment about {self._point}",
            "force": "no shaking force",
        }[self.kept]

    @property
    def _point(self) -> str:
        """Name the point of the moment."""
        if self.about is None:
            return "the inertial origin"
        return f"{vector_text(self.about)} m"
