"""Apply every remedy to a linkage, and compare what each costs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pkgutil import resolve_name

from balance.masses.counterweights.link_regions import ALL, regions_by_name
from balance.masses.counterweights.regions import Region
from balance.masses.designs.feasibility import Feasibility, feasible
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.catalogue import CATALOGUE, remedy_named
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.trade_off import GEAR_SHARES, best_points
from balance.support.materials import density_in_si
from balance.support.options import Balance
from balance.support.result_files import WithPage, WithPicture
from balance.support.tolerances import MASSES_EQUAL
from kinematics.errors import LinkageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.numerics.compiled.background import collect_garbage_seldom, kernel_clock
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import count_noun, first_names, html_facts, number_text, repr_lines

REMEDIES_SCHEMA = "balance.remedies/1"
# Seconds that a remedy of a four-bar takes in uncompiled kernels, about.
UNCOMPILED = 0.25
# Added mass, over that of the linkage, above which one would not build a remedy.
MOST_BUILT = 10.0
# Remedies that build the whole linkage again, and those after which its frame turns.
COPIES, TURNING = ("duplicates",), ("free_joint",)
# Remedies that take no shaking, but the torque of an input.
TORQUE_ALONE = ("harmonic_springs",)
# Remedies that add matter to links, which are point masses without a density.
ON_LINKS = ("force_masses", "partial")

Apply = Callable[[RemedyRequest], Iterator[AppliedRemedy]]

# Remedies with counter-rotations at the gear of the request.
_GEARED = (
    "separate_rotors",
    "counter_rotary_masses",
    "planetary_transmission",
    "parallelogram_transmission",
)


def _apply(name: str, request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Apply one remedy, with the points of its trade-off at all gears that are tried."""
    apply: Apply = resolve_name(f"{__package__}.{CATALOGUE[name].module}:apply_{name}")
    if not request.trade_off or name not in _GEARED:
        yield from apply(request)
        return
    results = list(apply(request))
    others = [
        applied
        for share in GEAR_SHARES
        for applied in apply(request.changed(gear=share * request.gear))
    ]
    for applied in results:
        same = [each.trade_off for each in others if each.new_joints == applied.new_joints]
        points = best_points(chain(applied.trade_off, *same)) if applied.trade_off else ()
        yield replace(applied, trade_off=points)


def _mass_words(applied: AppliedRemedy) -> str:
    """Name a result, with the mass that it adds."""
    return f"{applied.short} {number_text(applied.added_mass_with_gears, '.4g')} kg"


@dataclass(frozen=True, eq=False)
class RemedyComparison(WithPage, WithPicture):
    """Remedies that were applied to one linkage, and what each costs.

    Attributes:
        request: the request.
        own_masses: whether masses of the links of the linkage can balance it.
        results: results in the order of the catalogue.
        following: the command that comes next, with what was asked; empty without one.
        reduce: the command for the least shaking, with what was asked; empty without one.
    """

    page_maker = "remedies:remedies_page"
    picture_maker = "remedies:remedies_picture"

    request: RemedyRequest
    own_masses: Feasibility
    results: tuple[AppliedRemedy, ...]
    following: str = ""
    reduce: str = ""

    def __repr__(self) -> str:
        """Up to four lines: the linkage, and which remedies help."""
        verdicts = ("feasible", "partial", "infeasible")
        named = {
            v: [applied.remedy for applied in self.results if applied.verdict == v]
            for v in verdicts
        }
        return repr_lines(
            f"RemedyComparison of {self.request.linkage.name}",
            *(f"{v}: {first_names(list(dict.fromkeys(n)))}" for v, n in named.items() if n),
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        facts = (
            (applied.remedy, f"{applied.verdict}: {applied.reason}") for applied in self.results
        )
        return html_facts(f"Remedies for {self.request.linkage.name}", *facts)

    @property
    def balanced(self) -> tuple[AppliedRemedy, ...]:
        """Results that balance the linkage, the least added mass, with gears, first."""
        remedies = [applied for applied in self.results if applied.verdict == "feasible"]
        remedies.sort(key=lambda applied: applied.lost_freedoms)
        masses = [applied.added_mass_with_gears for applied in remedies]
        ranks = rank_least_first(masses, self.request.given_mass, MASSES_EQUAL)
        return tuple(remedies[k] for k in ranks)

    @property
    def by_preference(self) -> tuple[AppliedRemedy, ...]:
        """All results, those first that one would build first.

        What balances comes first, without loss of freedoms before with it, a frame that turns
        after other parts, and the least mass, with gears, first; then partial balance, what
        adds more than the mass of the linkage after what adds no more, copies
        of the whole linkage that balance it, springs for a torque, all again
        with more than `MOST_BUILT` times the given mass, what is undecided, what no masses do,
        and what does not apply, in the order of the catalogue.
        """
        balanced = sorted(
            (each for each in self.balanced if each.remedy not in COPIES),
            key=lambda applied: (applied.lost_freedoms, applied.remedy in TURNING),
        )
        copies = [each for each in self.balanced if each.remedy in COPIES]
        partial, *rest = (
            [applied for applied in self.results if applied.verdict == verdict]
            for verdict in ("partial", "undecided", "infeasible", "refused")
        )
        torque = [each for each in partial if each.remedy in TORQUE_ALONE]
        partial = [each for each in partial if each not in torque]
        partial.sort(key=self.outweighs)
        helping = (*balanced, *partial, *copies, *torque)
        heavy = [each for each in helping if self.too_heavy(each)]
        light = [each for each in helping if each not in heavy]
        return (*light, *heavy, *chain.from_iterable(rest))

    @property
    def why_first(self) -> str:
        """Why the first of `by_preference` comes first, in words; empty if none balances it."""
        first = self.by_preference[0] if self.balanced else None
        if first is None or first.verdict != "feasible":
            return ""
        others = [each for each in self.balanced if each.remedy != first.remedy]
        lost = first.lost_freedoms
        freedoms = f"takes {count_noun(lost, 'freedom')}" if lost else "keeps all freedoms"
        mass = first.added_text
        if not others:
            return f"nothing else that was tried balances it; it {freedoms}, and adds {mass}"
        last = {*COPIES, *TURNING}
        if first.remedy in last:
            last = set()
        later = [each for each in others if each.lost_freedoms > lost or each.remedy in last]
        alike = [each for each in others if each not in later]
        words = [f"it balances the linkage, {freedoms}, and adds {mass}"]
        if alike:
            words[0] += f", the least (next: {_mass_words(alike[0])})"
        lighter = [
            each for each in later if each.added_mass_with_gears < first.added_mass_with_gears
        ]
        if lighter:
            names = ", ".join(dict.fromkeys(map(_mass_words, lighter)))
            but = "with fewer freedoms, copies of it all or a frame that turns"
            words.append(f"lighter, but {but}: {names}")
        return "; ".join(words)

    def outweighs(self, applied: AppliedRemedy) -> bool:
        """Whether a remedy adds, with gears, more than the mass of the linkage."""
        given = self.request.given_mass
        return applied.added_mass_with_gears > given * (1.0 + MASSES_EQUAL)

    def too_heavy(self, applied: AppliedRemedy) -> bool:
        """Whether a remedy adds, with gears, over `MOST_BUILT` times the given mass."""
        return applied.added_mass_with_gears > MOST_BUILT * self.request.given_mass

    @property
    def only_copies(self) -> bool:
        """Whether copies of the whole linkage balance it, and nothing else that was tried."""
        return bool(self.balanced) and all(
            applied.remedy in COPIES for applied in self.balanced
        )

    @property
    def verdict(self) -> str:
        """``"feasible"`` if a remedy balances the linkage; ``"undecided"`` if one may.

        ``"partial"``: no remedy was tried but some that leave less to shake, and all do.
        """
        if self.balanced:
            return "feasible"
        if all(
            applied.verdict == "partial" and applied.remedy not in TORQUE_ALONE
            for applied in self.results
        ):
            return "partial"
        open_ones = any(applied.verdict == "undecided" for applied in self.results)
        return "undecided" if open_ones else "infeasible"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/remedies.schema.json``."""
        request = self.request
        return {
            "schema": REMEDIES_SCHEMA,
            "model": request.linkage.name,
            "at": request.linkage.at,
            "motion": list(request.motion),
            "balance": request.balance,
            "mobility": request.freedoms,
            "given_mass": request.given_mass,
            "input_inertia": dict(request.input_inertia),
            "own_masses": {"verdict": self.own_masses.verdict, "words": self.own_masses.words},
            "verdict": self.verdict,
            "why_first": self.why_first,
            "gear": request.gear,
            "rotor_radius": request.rotor_radius,
            "density": request.density,
            "links": list(request.links),
            "remedies": [applied.to_dict() for applied in self.results],
        }


def remedy_files(results: Iterable[AppliedRemedy]) -> dict[str, bytes]:
    """Name the files of results, such as ``remedy_2.urdf`` and ``remedy_2_table.csv``.

    Args:
        results: results of remedies; those that do not help have no files.

    Returns:
        The contents by name.
    """
    contents: dict[str, bytes] = {}
    for stem, applied in name_files(results):
        if applied.urdf is not None:
            contents[f"{stem}.urdf"] = applied.urdf
        contents |= {f"{stem}_{name}": data for name, data in applied.files.items()}
    return contents


def name_files(results: Iterable[AppliedRemedy]) -> Iterator[tuple[str, AppliedRemedy]]:
    """Yield how the names of files of each result that helps begin, and the result."""
    counts: dict[str, int] = {}
    for applied in results:
        if applied.helps:
            counts[applied.remedy] = count = counts.get(applied.remedy, 0) + 1
            yield applied.remedy if count == 1 else f"{applied.remedy}_{count}", applied


def compare_remedies(
    linkage: LinkageLike,
    only: Sequence[str] = (),
    *,
    motion: Sequence[str] = (),
    balance: Balance = "dynamic",
    links: Sequence[str] = (),
    regions: Mapping[str, Region | str] | None = None,
    gear: float = 1.0,
    radius: float | None = None,
    budget: float | None = None,
    trade_off: int = 0,
    density: float | str | None = None,
    progress: Callable[[int, int], None] | None = None,
    report: Callable[[AppliedRemedy], None] | None = None,
    workers: int = 1,
) -> RemedyComparison:
    """Apply the remedies of the literature to a linkage, and compare what each costs.

    Each remedy changes the linkage into one with new parts, whose masses are then found by
    `counterweights`: the masses of the file stay, and the least matter is added. The written
    file is verified by `verify` before it counts.

    Args:
        linkage: an assembled linkage, or an argument of `kinematics.load`.
        only: names of remedies, from `balance.masses.remedies.catalogue`, or their words in
            tables, such as ``"mirrored copies"``; by default all.
        motion: relations between the inputs.
        balance: ``"dynamic"``, or ``"force"``.
        links: links of the linkage to which matter may be added; by default all bodies.
        regions: where, by name of the link, see `counterweights`; by default a ball about the
            joint that carries the link, of half its length, and if that is too small, one about
            the middle of its joints of 1.5 lengths.
        gear: turns of a counter-rotor for one turn of its joint.
        radius: radius of rotors and wheels, metres; by default a quarter of the characteristic
            length, or of the length of a link at the end of a chain if that is longer.
        budget: most mass that partial balance may add, kg; by default the mass of the linkage.
        trade_off: points of added mass against input inertia for each remedy that balances by
            the least matter: `AppliedRemedy.trade_off`; 0 for none.
        density: density that added matter nowhere exceeds, kg/m³ or a material, new links
            included; by default it is point masses, the limit of infinite density.
        progress: called with the number of steps done and of all steps.
        report: called with each result, as soon as it is there and those before it are.
        workers: processes that apply remedies; each takes a second or two to start.

    Returns:
        The results, one or more for each remedy; the same ones with any number of processes.

    Raises:
        BodyError: a link is unknown.
        LinkageError: no moving link has a mass.
        MotionError: a relation is wrong.
        UsageError: a remedy is unknown, or a number is out of range.
        WorkerError: a process has ended before its work did.

    Source:
        V. van der Wijk, J. L. Herder, B. Demeulenaere, Journal of Mechanisms and Robotics
        1(4), 2009; G. Becht, MSc thesis, TU Delft, 2020, chapter 2.

    Example:
        >>> import balance
        >>> comparison = balance.compare_remedies("robot.urdf", ["own_masses"])
        >>> comparison.results[0].verdict
        'infeasible'
    """
    linkage = as_linkage(linkage)
    request = RemedyRequest(
        linkage,
        tuple(motion),
        balance,
        tuple(links),
        regions_by_name(linkage, tuple(links) or (ALL,), regions or {}),
        gear,
        radius,
        budget,
        progress=progress,
        trade_off=trade_off,
        density=density_in_si(density),
    )
    return compare_request(request, only, report, workers)


def compare_request(
    request: RemedyRequest,
    only: Sequence[str] = (),
    report: Callable[[AppliedRemedy], None] | None = None,
    workers: int = 1,
) -> RemedyComparison:
    """Apply remedies to what a request describes; see `compare_remedies`.

    Args:
        only: names of remedies; by default all.
        report: called with each result, as soon as it is there and those before it are.
        workers: processes that apply remedies.
    """
    only = tuple(map(remedy_named, only))
    request = replace(request, only=only)
    request.check()
    names = [name for name in CATALOGUE if name in (only or CATALOGUE)]
    kernel_clock.foresee(UNCOMPILED * len(names))
    results = []
    with collect_garbage_seldom():
        for applied in _apply_all(request, names, min(workers, len(names))):
            results.append(applied)
            if report is not None:
                report(applied)
    return RemedyComparison(request, feasible(request.space), tuple(results))


def _apply_all(
    request: RemedyRequest, names: Sequence[str], workers: int
) -> Iterator[AppliedRemedy]:
    """Apply remedies in this process, or in others.

    One that another process refuses is applied again here, where its error is raised.
    """
    if workers < 2:
        yield from chain.from_iterable(_apply(name, request) for name in names)
        return
    from balance.support.processes import map_in_processes

    # A linkage that was not used yet can be pickled: it has no kernels.
    fresh = replace(request, linkage=replace(request.linkage), progress=None)
    begin = partial(_keep_request, fresh)
    parts = map_in_processes(_apply_kept, names, workers, begin)
    for k, (name, results) in enumerate(zip(names, parts, strict=True), 1):
        yield from _apply(name, request) if results is None else results
        if request.progress is not None:
            request.progress(k, len(names))


# The request whose remedies a process applies: what it knows of the linkage is kept.
_kept: list[RemedyRequest] = []


def _keep_request(request: RemedyRequest) -> None:
    _kept[:] = [request]


def _apply_kept(name: str) -> list[AppliedRemedy] | None:
    """Apply one remedy in a process of its own; None if it raises an error."""
    try:
        return list(_apply(name, _kept[0]))
    except LinkageError:
        return None
