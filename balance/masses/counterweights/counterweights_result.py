"""The answer to a request for counterweights, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

from balance.masses.counterweights.added_program import AddedObjective
from balance.masses.counterweights.counterweight import (
    Counterweight,
    added_mass_table,
    change_words,
    moved_text,
    net_mass,
    sliver_sentence,
)
from balance.masses.counterweights.exclusion import (
    Exclusion,
    links_in_certificate,
    quoted_names,
)
from balance.masses.counterweights.link_regions import ALL
from balance.masses.counterweights.moved_matter import PRICE_OF_MOVING
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.filling_check import FillingCheck
from balance.masses.counterweights.write_counterweights import counterweights_file
from balance.masses.designs.feasibility import Verdict
from balance.space.inertial_parameters.conversions import LABELS, PLANAR_LABELS
from balance.space.spaces.design_space import DesignSpace, balanced_text
from balance.support.change_text import MASS_FORM, mass_added_text
from balance.support.mass_table import MassTable
from balance.support.result_files import WithPage, WithPicture
from kinematics.model.motion import while_text
from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, number_text, repr_lines

if TYPE_CHECKING:
    from balance.motion.verification.before_after import BeforeAfter


# Added mass, over the given mass, above which a change of the request is no help.
MOST_ADDED = 100.0
# Density of osmium, kg/m³: no metal is denser.
DENSEST = 22_590.0
COUNTERWEIGHTS_SCHEMA = "balance.counterweights/1"
# Format of an added mass where moments of inertia are least: the optimum is known to 1e-4, and
# flat. And of masses of advice, which are known to 1e-5.
ROUGH_FORM = ".3g"


@dataclass(frozen=True)
class Relaxation:
    """One change of an infeasible request that makes it feasible.

    Attributes:
        links: the links, those that are alike together; ``("all",)`` if no fewer help, and
            empty if all matter must be denser.
        factor: factor by which their regions must grow about their centres, or the density;
            None if matter must be added to these links too, in their default regions. Of a
            request for a shape, growth of the largest region, or of the shape.
        mass: mass that is then added, kg.
        regions: regions of these links that hold a shape, as text, or that of ``all``; empty
            for other changes.
        shape: text of another shape; None for other changes.
    """

    links: tuple[str, ...]
    factor: float | None
    mass: float
    regions: Mapping[str, str] = field(default_factory=dict)
    shape: str | None = None

    @property
    def for_shape(self) -> bool:
        """Whether it is a change of a request for a shape."""
        return bool(self.regions or self.shape)

    @property
    def words(self) -> str:
        """The change in words."""
        mass = f"would do ({number_text(self.mass, ROUGH_FORM)} kg in all)"
        which = quoted_names(self.links)
        if self.for_shape:
            larger = [f"{name}={text}" for name, text in self.regions.items()]
            place = f"the region{'s' * (len(larger) > 1)} {' and '.join(larger)}"
            return f"{' in '.join(filter(None, [self.shape, place * bool(larger)]))} {mass}"
        if self.factor is None:
            which = "all links" if self.links == (ALL,) else f"{which} too"
            return f"adding matter to {which} {mass}"
        factor = number_text(self.factor)
        if not self.links:
            return f"matter {factor} times as dense {mass}"
        what = "a region" if len(self.links) == 1 else "regions"
        return f"{what} of {which} {factor} times as large {mass}"


def _chain_dict(space: DesignSpace) -> dict[str, object]:
    """Return what a stranger needs to read a certificate, as plain data for JSON.

    The functional has a part for each of the bodies, in their order, whose entries belong to
    the parameters (`balance.space.inertial_parameters.conversions`), about ``origin``, along
    the rows of ``axes``, with ``length`` metres as the unit of length.
    """
    frame, count = space.chain.frame, len(space.scaled_basis) // len(space.bodies)
    names = PLANAR_LABELS if space.planar else LABELS
    return {
        "bodies": list(space.bodies),
        "parameters": list(names[:count]),
        "origin": frame.origin.tolist(),
        "axes": frame.R.tolist(),
        "length": frame.length,
    }


@dataclass(frozen=True, eq=False)
class Counterweights(WithPage, WithPicture):
    """Result of `counterweights`: added matter, or a certificate that none balances.

    Attributes:
        space: the design space; spatial for dynamic balance of a planar linkage.
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        minimise: the objective.
        regions: where matter may be added, by name of the link.
        given_mass: mass of the bodies in the file, kg.
        words: the verdict in one line.
        price: price of mass besides the objective, m²: what was minimised is the value, and
            so much for each kilogram that is added.
        value: its value in SI units (see `counterweights`); None without counterweights.
        gap: largest part of the value by which it may exceed the global minimum, proved by
            the dual; None likewise.
        chosen: links whose region is the default.
        weights: the counterweight of each link to which matter is added.
        z: parameters (bodies, 10) of given and added masses about the inertial origin, SI
            units; None without counterweights.
        residual: size of the conditions' residual over the sum of the bodies' parts; None
            likewise.
        certificate: functional (parameters,) that proves infeasibility; see
            `balance.masses.counterweights.exclusion`, and for a shape
            `balance.masses.counterweights.shaped.exclude_shapes`.
        check: result of its check without the solver.
        relaxations: changes of one link, or of links that are alike, that would help, the
            smallest first; empty if feasible.
        density: density that matter nowhere exceeds, kg/m³, by link; None for point masses.
        thickness: that of plates about the plane of the linkage, m; None for other matter.
        proof: functional (parameters,) that proves the gap of matter of limited density; see
            `balance.masses.counterweights.volume.filling_check`. None otherwise.
        shape: shape of the counterweights, such as ``disc=20mm``; None if they have any. The
            value then is the least mass of such shapes, beside the webs of these, and its gap
            that to their dual.
        least_mass: the least mass of any shape in the regions, kg; None without a shape.
        along: loads along motions, before and after; None if they were not computed.
        movable: largest share of the given mass of links that may be moved, by name.
        moved: mass taken from each of these links, kg; at least as much is among ``weights``.
    """

    page_maker = "counterweights:counterweights_page"
    picture_maker = "counterweights:counterweights_picture"

    space: DesignSpace
    verdict: Verdict
    minimise: AddedObjective
    regions: Mapping[str, Region]
    given_mass: float
    words: str
    price: float
    value: float | None = None
    gap: float | None = None
    chosen: tuple[str, ...] = ()
    weights: tuple[Counterweight, ...] = ()
    z: Array | None = None
    residual: float | None = None
    certificate: Array | None = None
    check: Exclusion | FillingCheck | None = None
    relaxations: tuple[Relaxation, ...] = ()
    density: Mapping[str, float] | None = None
    thickness: float | None = None
    proof: Array | None = None
    shape: str | None = None
    least_mass: float | None = None
    along: BeforeAfter | None = None
    movable: Mapping[str, float] = field(default_factory=dict)
    moved: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the counterweights."""
        title = f"Counterweights for {self.space.linkage.name}"
        return repr_lines(title, self.words, *(weight.words for weight in self.weights))

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        facts = ((weight.link, weight.words) for weight in self.weights)
        title = f"Counterweights for {self.space.linkage.name}"
        return html_facts(title, ("verdict", self.words), *facts)

    def undecided(self, words: str, **changes: Any) -> Counterweights:
        """Return the same request without counterweights.

        Args:
            words: why, after "undecided".
            changes: of other fields.
        """
        blank = dict(value=None, gap=None, weights=(), z=None, residual=None, proof=None)
        return replace(
            self, verdict="undecided", words=f"undecided: {words}", **(blank | changes)
        )

    @property
    def added_mass(self) -> float:
        """Mass of all counterweights, less what is taken from links, kg."""
        return net_mass(self.weights, self.moved)

    @property
    def change(self) -> str:
        """What is moved and added, in words."""
        return change_words(self.weights, self.moved, self.given_mass, self.mass_form)

    @property
    def roughly_known(self) -> bool:
        """Whether the optimum is known to `FILLING_GAP` alone: inertia of filled parts."""
        filled = any(weight.form is not None for weight in self.weights)
        return filled and self.minimise == "inertia"

    @property
    def mass_form(self) -> str:
        """Format of the added mass, by the digits that are known."""
        return ROUGH_FORM if self.roughly_known else MASS_FORM

    @property
    def price_of_moving(self) -> float:
        """Price of a kilogram that is moved, in units of the value for each kilogram."""
        return PRICE_OF_MOVING * (1.0 if self.minimise == "mass" else self.price)

    @property
    def priced(self) -> float | None:
        """What was minimised: the value, and the prices of added and moved mass, SI units."""
        if self.value is None:
            return None
        moving = self.price_of_moving * sum(self.moved.values())
        return self.value + self.price * self.added_mass + moving

    @property
    def may_have_shape(self) -> bool:
        """Whether it is matter of any shape of a request that may ask for a shape of plate."""
        space = self.space
        in_plane = space.planar and space.balance == "force" and not space.requirements
        plain = self.minimise == "mass" and self.thickness is None and not self.movable
        return in_plane and plain and self.shape is None and bool(self.weights and self.density)

    @property
    def worth_naming(self) -> tuple[Relaxation, ...]:
        """Changes of the request that need no more than a hundred times the given mass.

        Of matter that is denser than any metal only if nothing else helps.
        """
        most, density = (
            MOST_ADDED * self.given_mass,
            max((self.density or {}).values(), default=0.0),
        )
        light = tuple(change for change in self.relaxations if change.mass <= most)
        made = tuple(
            change
            for change in light
            if change.links or density * (change.factor or 1.0) <= DENSEST
        )
        return made or light

    @property
    def depends_on_regions(self) -> bool:
        """Whether what proves that nothing balances holds in these regions alone.

        Else no matter on these links balances the linkage, wherever it is.
        """
        proof = self.certificate
        return proof is not None and bool(links_in_certificate(self.space, self.regions, proof))

    @property
    def sentence(self) -> str:
        """The answer in one sentence: what is left to shake, and the added mass."""
        links, when = ", ".join(self.regions), while_text(self.space.motion)
        what, balance = f"matter added to {links}", "balances"
        if self.shape:
            what, balance = f"{self.shape.partition('=')[0]}s on {links}", "balance"
        if self.verdict == "infeasible":
            where = " in these regions" if self.depends_on_regions else ""
            return f"No {what}{where} {balance} the linkage{when}."
        if self.verdict == "undecided":
            return f"It is undecided whether {what} {balance} the linkage{when}."
        moved = moved_text(self.moved)
        added = f"{moved}, {mass_added_text(self.added_mass, self.mass_form)}".removeprefix(
            ", "
        )
        if self.along is not None:
            return f"{self.along.words}{when}, {added}.{sliver_sentence(self.weights)}"
        text = balanced_text(self.space)
        return f"{text[0].upper()}{text[1:]}{when}, {added}.{sliver_sentence(self.weights)}"

    def to_urdf(self, path: str | PathLike[str] | None = None, *, merge: bool = False) -> bytes:
        """Return the file of the linkage with the counterweights, and no other change.

        Args:
            path: file to write it to; None for none.
            merge: whether they go into the masses of their links; else they are links.

        Raises:
            UsageError: nothing balances the linkage.
            FileError: the linkage has no file, or the new one cannot be written.
        """
        return counterweights_file(self, path, merge)

    def to_table(self) -> MassTable:
        """Return mass, g, centre of mass, mm, and inertia, kg mm², of each counterweight.

        Returns:
            Rows ``link, mass, x, y, z, ixx, iyy, izz, ixy, ixz, iyz`` in the link frames, which
            are printed as a table; none if there is no answer.

        Example:
            >>> import balance
            >>> links = ["crank", "rocker"]
            >>> given = balance.counterweights("robot.urdf", links, balance="force")
            >>> [row.link for row in given.to_table()]
            ['crank', 'rocker']
        """
        return added_mass_table(self.weights, self.space.length, self.words)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/counterweights.schema.json``."""
        space = self.space
        return {
            "schema": COUNTERWEIGHTS_SCHEMA,
            "model": space.linkage.name,
            "at": space.linkage.at,
            "algebra": "planar" if space.planar else "spatial",
            "balance": space.balance,
            "verdict": self.verdict,
            "minimise": self.minimise,
            "value": self.value,
            "price_of_mass": self.price,
            "priced": self.priced,
            "gap": self.gap,
            "density": None if self.density is None else dict(self.density),
            "thickness": self.thickness,
            "shape": self.shape,
            "least_mass": self.least_mass,
            "chain": _chain_dict(space),
            "regions": {
                name: {
                    "text": region.text,
                    "kind": region.kind,
                    "default": name in self.chosen,
                    "place": region.place.tolist(),
                }
                for name, region in self.regions.items()
            },
            "movable": dict(self.movable),
            "moved": dict(self.moved),
            "given_mass": self.given_mass,
            "added_mass": self.added_mass,
            "counterweights": [weight.to_dict() for weight in self.weights],
            "residual": self.residual,
            "certificate": None if self.certificate is None else self.certificate.tolist(),
            "proof": None if self.proof is None else self.proof.tolist(),
            "check": self.check._asdict() if self.check else None,
            "relaxations": [asdict(relaxation) for relaxation in self.relaxations],
            "words": self.words,
            "along": self.along.to_dict() if self.along else None,
            "sentence": self.sentence,
        }
