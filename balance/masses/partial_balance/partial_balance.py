"""Results of partial balance: the matter to add, what it buys, and the proof of the optimum."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from os import PathLike
from typing import Literal, NamedTuple

from balance.masses.counterweights.counterweight import (
    Counterweight,
    added_mass_table,
    moved_text,
    net_mass,
    sliver_sentence,
)
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.write_counterweights import counterweights_file
from balance.masses.designs.pseudo_inertia_cone import bodies_with
from balance.masses.partial_balance.elastic_frame import ElasticFrame
from balance.masses.partial_balance.shaking_objectives import (
    PartialObjective,
    objective_in_words,
)
from balance.masses.partial_balance.shaking_problem import ShakingFigures
from balance.motion.motion_tolerances import (
    CONDITIONING_NOTICE,
    SHAKING_RELATIVE,
    SINGULAR_MOTION_DETERMINED,
)
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.spaces.design_space import DesignSpace
from balance.support.change_text import change_text, mass_added_text, percent_text
from balance.support.mass_table import MassTable
from balance.support.result_files import WithPage, WithPicture
from balance.support.tolerances import SHAKING_GAP_PROVED
from kinematics.model.linkage import Notice
from kinematics.model.motion import while_text
from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, number_text, repr_lines

REDUCE_SCHEMA = "balance.reduce/1"

PartialVerdict = Literal["optimal", "infeasible", "undecided"]


class WiderRegions(NamedTuple):
    """What the same budget leaves in larger regions; in place of shapes with webs, any shape.

    Attributes:
        regions: the balls that are larger, by name of the link.
        share: objective over that of the file.
        mass: mass of the added matter, kg.
    """

    regions: Mapping[str, Region]
    share: float
    mass: float

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        radii = {link: region.size for link, region in self.regions.items()}
        return {"radii": radii, "share": self.share, "mass": self.mass}


@dataclass(frozen=True, eq=False)
class PartialBalance(WithPage, WithPicture):
    """Result of `partial`: the matter to add for the least shaking.

    Attributes:
        space: a design space of the linkage.
        budget: most mass that may be added, kg.
        verdict: ``"optimal"``: no matter in the regions shakes less, to 1e-6 of the shaking in
            the file; ``"infeasible"``: none keeps the caps, and that is proved;
            ``"undecided"``.
        words: the verdict in one line.
        given: what the linkage of the file does.
        motions: the motions that count.
        point: point of the inertial frame that moments are about (3,), metres.
        weight_moment: newton metres that count as one newton; infinite if moments do not
            count.
        frame: the elastic frame, if there is one.
        minimise: the objective; see `partial`.
        regions: where matter may be added, by name of the link.
        shaking: what the linkage with the added matter does; None without a design.
        bound: no matter within the budget has a smaller objective; proved without the solver.
            With a shape, no such shapes have, beside the webs of these.
        weights: the counterweight of each link that gets matter.
        z: parameters (bodies, 10) about the inertial origin, SI units; None without a design.
        moved: mass taken from links whose matter may be moved, kg, by name; at least as much is
            among ``weights``.
        shape: shape of the counterweights, such as ``disc=0.02``; None if they have any.
        least_objective: the least objective of matter of any shape; None without a shape.
        least_anywhere: no matter on the links has a smaller objective, wherever it is and
            however much; None if the largest load is minimised.
        try_wider: computes ``wider`` of the design; None for none.
    """

    page_maker = "partial_balance:partial_balance_page"
    picture_maker = "partial_balance:partial_balance_picture"

    space: DesignSpace
    budget: float
    verdict: PartialVerdict
    words: str
    given: ShakingFigures
    motions: tuple[Trajectory, ...]
    point: Array
    weight_moment: float
    frame: ElasticFrame | None
    minimise: PartialObjective
    regions: Mapping[str, Region]
    shaking: ShakingFigures | None = None
    bound: float = 0.0
    weights: tuple[Counterweight, ...] = ()
    z: Array | None = None
    moved: Mapping[str, float] = field(default_factory=dict)
    shape: str | None = None
    least_objective: float | None = None
    least_anywhere: float | None = None
    try_wider: Callable[[PartialBalance], tuple[WiderRegions, ...]] | None = None

    @cached_property
    def wider(self) -> tuple[WiderRegions, ...]:
        """What the budget leaves in larger regions, where those by default have no room for it.

        Each is solved when this is first asked for.
        """
        return self.try_wider(self) if self.try_wider else ()

    @property
    def front(self) -> ParetoFront:
        """The front of this design alone."""
        return ParetoFront((self,), self.weight_moment, self.frame, self.point, self.minimise)

    @property
    def share(self) -> float:
        """Objective over that of the file; 1 without a design."""
        if self.shaking is None or self.given.objective == 0.0:
            return 1.0
        return self.shaking.objective / self.given.objective

    @property
    def mass(self) -> float:
        """Mass of the added matter, less what is taken from links, kg."""
        return float(net_mass(self.weights, self.moved))

    @property
    def sentence(self) -> str:
        """The answer in one sentence: what is left to shake, and the added mass.

        Loads are peaks where these are minimised, else root mean squares, with the percent of
        the others where it differs. What is minimised comes first, if it is not the shaking.
        """
        if self.shaking is None:
            return f"{self.words[0].upper()}{self.words[1:]}."
        prefix, figure = ("peak_", "peak") if self.minimise == "peak" else ("", "rms")
        loads = [
            f"{name} {self._change(part, unit)}"
            for name, part, unit in (
                ("shaking force", f"{prefix}force", f"N {figure}"),
                ("moment", f"{prefix}moment", f"N m {figure}"),
                ("vibration", "vibration", "m rms"),
            )
            if getattr(self.given, part) is not None
        ]
        if self.minimise in ("torque", "bearing") and self.frame is None:
            slides = {*self.given.torque} <= self.space.linkage.sliding
            unit = "N" if self.minimise == "bearing" or slides else "N m"
            loads.insert(0, f"{self.front.objective} {self._change('objective', unit)}")
        moved = moved_text(self.moved)
        text = f"{', '.join(loads)}{while_text(self.space.motion)}"
        text = f"{', '.join([text, *[moved] * bool(moved)])}, {mass_added_text(self.mass)}."
        return f"{text[0].upper()}{text[1:]}{sliver_sentence(self.weights)}"

    def _change(self, part: str, unit: str) -> str:
        """Write a figure before and after, with the percent of its peak or root mean square."""
        sizes, more = self._before_and_after(part), ""
        if part not in ("vibration", "objective"):
            peak = part.startswith("peak_")
            other = part.removeprefix("peak_") if peak else f"peak_{part}"
            percents = [
                percent_text(after / before) if before else ""
                for before, after in (sizes, self._before_and_after(other))
            ]
            if percents[1] not in ("", percents[0]):
                more = f", {'rms' if peak else 'peak'} {percents[1]}"
        return change_text(*sizes, unit, more=more)

    def _before_and_after(self, part: str) -> tuple[float, float]:
        """Return a figure before and after; what the solver does not determine is 0."""
        assert self.shaking is not None
        before, after = getattr(self.given, part), getattr(self.shaking, part)
        least = SHAKING_GAP_PROVED * before
        if part not in ("vibration", "objective"):
            least = max(least, self.round_off_of(part))
        return before if before > least else 0.0, after if after > least else 0.0

    def round_off_of(self, part: str) -> float:
        """Compute the ``force``, N, or ``moment``, N m, up to which round-off decides it.

        It is large at a singularity.
        """
        near = min(motion.conditioning for motion in self.motions) < CONDITIONING_NOTICE
        share = SINGULAR_MOTION_DETERMINED if near else SHAKING_RELATIVE
        arm = 1.0 if part.endswith("force") else self.space.linkage.spatial_chain.frame.length
        return arm * share * max(self.given.bearing.values(), default=0.0)

    @property
    def bodies(self) -> tuple[BodyInertia, ...]:
        """Inertial parameters of the bodies with the added matter; empty without a design."""
        return () if self.z is None else bodies_with(self.space, self.z)

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the matter of each link."""
        parts = (f"{weight.link} +{number_text(weight.mass)} kg" for weight in self.weights)
        return repr_lines(f"PartialBalance of {self.space.linkage.name}", self.words, *parts)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        parts = ((weight.link, f"+{number_text(weight.mass)} kg") for weight in self.weights)
        title = f"PartialBalance of {self.space.linkage.name}"
        return html_facts(title, ("verdict", self.words), *parts)

    def to_urdf(self, path: str | PathLike[str] | None = None, *, merge: bool = False) -> bytes:
        """Return the file of the linkage with the matter, and no other change.

        Args:
            path: file to write it to; None for none.
            merge: whether it goes into the masses of its links; else it is in links of its own.

        Raises:
            UsageError: there is no design.
            FileError: the linkage has no file, or the new one cannot be written.
        """
        return counterweights_file(self, path, merge)

    def to_table(self) -> MassTable:
        """Return mass, g, centre of mass, mm, and inertia, kg mm², of each counterweight.

        Returns:
            Rows ``link, mass, x, y, z, ixx, iyy, izz, ixy, ixz, iyz`` in the link frames, which
            are printed as a table; none without a design.

        Example:
            >>> import balance
            >>> least = balance.partial("robot.urdf", ["crank"], 0.2)
            >>> [row.link for row in least.to_table()]
            ['crank']
        """
        return added_mass_table(self.weights, self.space.length, self.words)

    def to_dict(self) -> dict[str, object]:
        """Return a design as plain data for JSON."""
        return {
            "budget": self.budget,
            "verdict": self.verdict,
            "words": self.words,
            "mass": self.mass,
            "moved": dict(self.moved),
            "bound": self.bound,
            "shape": self.shape,
            "least_objective": self.least_objective,
            "least_anywhere": self.least_anywhere,
            "wider": [wider.to_dict() for wider in self.wider],
            "found": self.shaking._asdict() if self.shaking else None,
            "weights": [weight.to_dict() for weight in self.weights],
            "sentence": self.sentence,
        }


@dataclass(frozen=True, eq=False)
class ParetoFront(WithPage, WithPicture):
    """Result of `pareto`: designs from nothing added to the least shaking.

    Attributes:
        designs: the designs by budget, ascending; those whose caps cannot be kept have none.
        weight_moment: newton metres that count as one newton; infinite if moments do not
            count.
        frame: the elastic frame, if there is one.
        point: point of the inertial frame that moments are about (3,), metres.
        minimise: the objective; see `partial`.
    """

    page_maker = "partial_balance:front_page"
    picture_maker = "partial_balance:front_picture"

    designs: tuple[PartialBalance, ...]
    weight_moment: float
    frame: ElasticFrame | None
    point: Array
    minimise: PartialObjective = "rms"

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the linkage."""
        return self.designs[0].space.linkage.notices

    @property
    def objective(self) -> str:
        """What is minimised, in words, such as ``"shaking"``."""
        return objective_in_words(self.minimise) if self.frame is None else "vibration"

    def to_urdf(self, path: str | PathLike[str] | None = None, *, merge: bool = False) -> bytes:
        """Return the file with the matter of the largest budget; see `PartialBalance.to_urdf`.

        Args:
            path: file to write it to; None for none.
            merge: whether it goes into the masses of its links.

        Raises:
            UsageError: there is no design.
            FileError: the linkage has no file, or the new one cannot be written.
        """
        return self.designs[-1].to_urdf(path, merge=merge)

    def to_table(self) -> MassTable:
        """Return the matter of the largest budget; see `PartialBalance.to_table`."""
        return self.designs[-1].to_table()

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/reduce.schema.json``."""
        first = self.designs[0]
        return {
            "schema": REDUCE_SCHEMA,
            "model": first.space.linkage.name,
            "at": first.space.linkage.at,
            "balance": first.space.balance,
            "objective": self.objective,
            "weight_moment": self.weight_moment if isfinite(self.weight_moment) else None,
            "about": self.point.tolist(),
            "frame": self.frame._asdict() if self.frame else None,
            "given": first.given._asdict(),
            "designs": [design.to_dict() for design in self.designs],
        }

    def __repr__(self) -> str:
        """Up to six lines: mass and relative objective of the first designs."""
        parts = (
            f"+{number_text(design.mass)} kg: {number_text(design.share)} of the "
            f"{self.objective} in the file"
            for design in self.designs
            if design.shaking is not None
        )
        return repr_lines(self._title, *parts)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        rows = (
            (f"+{number_text(design.mass)} kg", design.sentence)
            for design in self.designs
            if design.shaking is not None
        )
        return html_facts(self._title, *rows)

    @property
    def _title(self) -> str:
        """What it is, in words."""
        name = self.designs[0].space.linkage.name
        return f"ParetoFront of {name}, {len(self.designs)} designs"
