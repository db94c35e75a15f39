"""Simple shapes of counterweights, of a thickness or a radius that may be one of several.

Discs, square blocks and sectors of discs have a thickness, cylinders a radius.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import pi, sqrt
from typing import Literal, NamedTuple, get_args

import numpy as np

from balance.masses.counterweights.regions import Region, box_region, cylinder_region
from balance.space.spaces.design_space import DesignSpace
from balance.support.materials import Density
from balance.support.units import read_quantity
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

Kind = Literal["disc", "block", "cylinder", "sector"]


class WeightShape(NamedTuple):
    """A shape whose axis is normal to the plane of the linkage, and that grows with its mass.

    A mass m of density ρ reaches so far from its axis, and from its middle along it: a disc of
    thickness t ``√(m/(π ρ t))`` and t/2, a square block ``½ √(m/(ρ t))`` along each of two
    axes and t/2, a cylinder of radius r that radius and ``m/(2 π ρ r²)``. A sector of a disc of
    radius R, about the joint of its link, grows in its angle ``2 m/(ρ t R²)``.

    Attributes:
        kind: its kind.
        size: thickness of a disc, block or sector, radius of a cylinder, m.
        radius: that of a sector, m; None for the largest circle about the joint in the region.
    """

    kind: Kind
    size: float
    radius: float | None = None

    @property
    def plural(self) -> str:
        """Several of the shape, in words."""
        what = "radius" if self.kind == "cylinder" else "thickness"
        radius = "" if self.radius is None else f" and radius {self.radius:g} m"
        return f"{self.kind}s of {what} {self.size:g} m{radius}"

    @property
    def flat(self) -> bool:
        """Whether its thickness is given."""
        return self.kind != "cylinder"

    @property
    def growth(self) -> float:
        """Metres that a cubic metre reaches, of other shapes than sectors.

        It is times the root of the volume for flat shapes, and times the volume for others.
        """
        if self.kind == "disc":
            return 1.0 / sqrt(pi * self.size)
        if self.kind == "block":
            return 0.5 / sqrt(self.size)
        return 0.5 / (pi * self.size**2)

    def place(self, mass: float, density: float, centre: Array, axes: Array) -> Region:
        """Make the region that a mass fills.

        Args:
            mass: kg.
            density: kg/m³.
            centre: its centre of mass (3,) in the link frame, m.
            axes: orthonormal rows (3, 3) of the link frame, the last one its axis.
        """
        reach = self.growth * (sqrt(mass / density) if self.flat else mass / density)
        if self.kind == "block":
            place = np.eye(4)
            place[:3, :3], place[:3, 3] = axes.T * [reach, reach, 0.5 * self.size], centre
            text = f"a block {number_text(2.0 * reach)} m square, {self.size:g} m thick"
            return replace(box_region([-1.0] * 3, [1.0] * 3), place=freeze(place), text=text)
        radius, length = (reach, self.size) if self.flat else (self.size, 2.0 * reach)
        ends = f"{number_text(length)} m {'thick' if self.flat else 'long'}"
        text = f"a {self.kind} of radius {number_text(radius)} m, {ends}"
        return replace(cylinder_region(centre, axes[2], radius, length), text=text)


def shape_text(choices: Sequence[WeightShape]) -> str:
    """Return the text of a shape in its sizes, mm, as `read_weight_shapes` reads it."""
    sizes = "/".join(f"{1e3 * shape.size:g}mm" for shape in choices)
    radius = choices[0].radius
    return f"{choices[0].kind}={sizes}{'' if radius is None else f',{1e3 * radius:g}mm'}"


def shapes_in_words(choices: Sequence[WeightShape]) -> str:
    """Several counterweights of a shape in its sizes, in words."""
    if len(choices) == 1:
        return choices[0].plural
    return f"{choices[0].kind}s ({shape_text(choices)})"


def read_weight_shapes(text: str) -> tuple[WeightShape, ...]:
    """Read a shape from its text, such as ``disc=0.02`` or ``sector=5mm/8mm/10mm,90mm``.

    Args:
        text: kind, sizes of which each link gets one, and for a sector, its radius.

    Returns:
        The shape in each of its sizes, in the order of the text.

    Raises:
        UsageError: there is no such shape, or its size is none.
    """
    kind, _, rest = text.strip().partition("=")
    sizes, comma, radius = rest.partition(",")
    first, *further = re.split(r"[\s,;/+&]+(?=[a-z]+=)", text.strip())
    if further:
        raise _several_shapes(text, first, further)
    if kind in get_args(Kind) and sizes and (kind == "sector" or not comma):
        try:
            lengths = [read_quantity(size, "length") for size in sizes.split("/")]
            reach = read_quantity(radius, "length") if comma else None
        except UsageError as error:
            raise UsageError(f"shape '{text}': {error}") from None
        given = [*lengths, *([] if reach is None else [reach])]
        if all(0.0 < length < np.inf for length in given):
            return tuple(
                WeightShape(kind, length, reach)  # type: ignore[arg-type]
                for length in dict.fromkeys(lengths)
            )
    raise UsageError(
        f"shape '{text}' has no known form: write disc=0.02, block=0.02 or sector=0.02, of "
        "that thickness in metres (sector=0.02,0.1 of a radius too), or cylinder=0.03, of that "
        "radius; disc=5mm/8mm/10mm for a choice of sizes"
    )


def _several_shapes(text: str, first: str, further: Sequence[str]) -> UsageError:
    """Make the refusal of a text of several shapes, which advises one of them.

    It is the first of them, or one in all their sizes if they are of one kind.

    Args:
        text: the whole text.
        first: the first shape.
        further: the others.

    Raises:
        UsageError: the first shape is none itself.
    """
    read_weight_shapes(first)
    kind, _, sizes = first.partition("=")
    more = [shape.removeprefix(f"{kind}=") for shape in further]
    alike = all(size and not set("=,") & set(size) for size in (sizes, *more))
    advice = "/".join([first, *more]) if alike else first
    return UsageError(f"shape '{text}' has {1 + len(more)} shapes: give one, such as {advice}")


def wanted_shapes(
    shape: str | None,
    space: DesignSpace,
    density: Density,
    move: Mapping[str, float] | None,
    clash: str = "",
) -> tuple[WeightShape, ...]:
    """Read a shape in its sizes, and check that what else is asked for goes with it.

    Args:
        shape: its text; None for matter of any shape.
        space: a design space of the linkage.
        density: density of the matter; None for point masses.
        move: shares of given masses that may be moved, by link.
        clash: what else contradicts a shape, in words; empty if nothing does.

    Raises:
        UsageError: the shape has no known form, or something does not go with it.
    """
    if shape is None:
        return ()
    choices = read_weight_shapes(shape)
    if move:
        raise UsageError("shapes are found for added matter: leave out what is to be moved")
    if density is None:
        raise UsageError(
            f"shape {shape} has a volume, and point masses have none: give a density"
        )
    if clash:
        raise UsageError(clash)
    if not space.linkage.planar:
        raise UsageError(
            f"shapes lie across the plane of a planar linkage, and '{space.linkage.name}' has "
            "none: leave out the shape, and give regions, such as "
            "cylinder(x,y,z,ax,ay,az,r,length), a part of which matter then fills"
        )
    if not space.planar or space.balance != "force":
        raise UsageError(
            "shapes are found for forces in the plane: ask for force balance (--balance force"
            f"{'' if space.planar else ', without --spatial'}), or leave out the shape"
        )
    return choices
