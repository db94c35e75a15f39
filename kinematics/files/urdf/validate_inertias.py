"""Find masses and inertias that no body can have.

They lead to remarks, not to errors, since design spaces do not depend on them. A body of
positive mass has principal moments ``0 ≤ I₁ ≤ I₂ ≤ I₃`` about its centre of mass with
``I₃ ≤ I₁ + I₂``.
"""

from __future__ import annotations

from collections.abc import Iterator

from kinematics.error_text import clean
from kinematics.model.document.element import Element
from kinematics.numerics.tolerances import INERTIA_INEQUALITY_EXCESS

UNPHYSICAL = "unphysical"
"""The code of the remark."""

# Number of links that a remark names.
MAX_NAMED = 4

_ENTRIES = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))


def find_unphysical(tree: Element, source: str) -> tuple[tuple[str, str], ...]:
    """Compose the remark on bodies with impossible masses or inertias, if there are any.

    Args:
        tree: checked tree of the file.
        source: path of the file, for the message.

    Returns:
        Code and message, or nothing.
    """
    faults = [
        f"{link.label}: {', '.join(broken)}"
        for link in tree.every("link")
        if (broken := list(_broken_inequalities(link)))
    ]
    if not faults:
        return ()
    more = f"; and {len(faults) - MAX_NAMED} more links" if len(faults) > MAX_NAMED else ""
    text = (
        f"{clean(source, 1000)}: {'; '.join(faults[:MAX_NAMED])}{more}; correct it where the "
        "file was exported: the design space does not depend on it, but whether the linkage is "
        "balanced as given does"
    )
    return ((UNPHYSICAL, text),)


def tensor(inertia: Element) -> list[list[float]]:
    """Read the rows of the tensor (3, 3) of an ``<inertia>``, kg m²."""
    return [[inertia.vector(name, "0")[0] for name in row] for row in _ENTRIES]


def _broken_inequalities(link: Element) -> Iterator[str]:
    """Inequalities that the numbers of a link break."""
    inertial = link.first("inertial")
    mass = inertial.first("mass") if inertial else None
    inertia = inertial.first("inertia") if inertial else None
    if mass is not None:
        (m,) = mass.vector("value", "0")
        if m < 0.0:
            yield f"mass {m:.6g} kg breaks m ≥ 0"
    if inertia is not None:
        import numpy as np

        first, second, third = np.linalg.eigvalsh(tensor(inertia))
        slack = INERTIA_INEQUALITY_EXCESS * max(abs(first), abs(third))
        if first < -slack:
            yield f"principal moment {first:.6g} kg m² of its inertia breaks I₁ ≥ 0"
        elif third > first + second + slack:
            sizes = f"{first:.6g}, {second:.6g} and {third:.6g} kg m²"
            yield f"principal moments {sizes} of its inertia break I₃ ≤ I₁ + I₂"
