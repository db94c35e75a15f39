"""Options that several functions share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


Balance: TypeAlias = Literal["dynamic", "force"]
"""``"dynamic"`` for all six components of the momentum, ``"force"`` for the linear ones."""


GRAVITY = (0.0, 0.0, -9.81)
"""Acceleration of gravity in the inertial frame by default, m/s²."""


def point_of(about: ArrayLike) -> NDArray[np.float64]:
    """Read a point of the inertial frame (3,), metres.

    Raises:
        ValueError: it is no point.
    """
    import numpy as np

    point = np.asarray(about, dtype=np.float64)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"a point has three finite coordinates, not {about!r}")
    return point
