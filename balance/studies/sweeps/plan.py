"""A study that fits its model: values of all paths by row, and their closed geometries."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

import numpy as np

from balance.space.inertial_parameters.conversions import violations
from balance.studies.sweeps.closing import ClosedGeometries, Closer
from balance.studies.sweeps.constraints import StudyConstraints
from balance.studies.sweeps.geometry import bar_inertial, link_inertias
from balance.studies.sweeps.parameter_paths import MASSES, NumberPlace, PathError, read_sites
from balance.studies.sweeps.placing import Placer
from balance.studies.sweeps.quantities import check_quantities
from balance.studies.sweeps.ranges import Range, range_values
from balance.studies.sweeps.row_quantities import MASS_QUANTITIES
from balance.studies.sweeps.study_data import StudyData
from balance.support.expressions import Expression, ExpressionError, read_expression
from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError, LinkageError
from kinematics.model.spatial.inertia import parameters
from kinematics.numerics.array_types import Array, IntArray


class Plan:
    """A study with its model.

    Attributes:
        study: the study.
        linkage: its model.
        driven: names of all columns of parameters: those that vary, then those of relations.
        closer: closes the loops of its geometries.
        constraints: what must hold.
    """

    def __init__(self, study: StudyData) -> None:
        """Check a study against its model.

        Raises:
            FileError: a path, a relation or a range does not fit the model.
            LinkageError: the model cannot be read.
        """
        self.study, self.linkage = study, study.model.load()
        self._sites = read_sites(self.linkage)
        self._relations = self._ordered(self._read_relations())
        self.driven = (*study.parameters, *self._relations)
        self._nominal: dict[str, float] = {}
        self._places = places = self._find_places()
        heavy = sorted(
            (path for path, place in places.items() if place.kind in MASSES),
            key=lambda path: MASSES.index(places[path].kind),
        )
        self._heavy = {path: places[path] for path in heavy}
        moving = {path: place for path, place in places.items() if path not in self._heavy}
        self.closer = Closer(self.linkage, Placer(self.linkage, self._sites, moving))
        self._start = self._values_in_model()
        self.constraints = StudyConstraints(study.constraints, self.linkage, study.source)
        self._check_names()
        check_quantities(study.quantities, self.linkage, study.source)
        self._check_lengths(moving)
        self._check_moves(moving)

    @cached_property
    def _masses(self) -> dict[str, Array]:
        """Inertial parameters of the links of the model; see `link_inertias`."""
        return link_inertias(self.linkage)

    def masses(self, values: Mapping[str, Array], row: int) -> dict[str, Array]:
        """Compute the inertial parameters (10,) of the links of the file in a geometry.

        Args:
            values: of all columns of parameters (rows,).

        Returns:
            By name of the link, as `link_inertias`, at the reference pose of the model.

        Raises:
            LinkageError: a link has parameters that no body can have.
        """
        changed: dict[str, Array] = {}
        origins: dict[int, Array] = {}
        if any(place.kind == "mass_per_length" for place in self._heavy.values()):
            origins = self.closer.placer.origins_of(values, row)
        for path, place in self._heavy.items():
            link, value = self._sites.links[place.site], float(values[path][row])
            if place.kind == "mass_per_length":
                changed[link] = bar_inertial(value, *self._sites.ends(place, origins))
                continue
            numbers = changed.setdefault(link, self._sites.inertials[link].copy())
            numbers[self._sites.inertial_entry(place)] = value
        masses = dict(self._masses)
        for link, numbers in changed.items():
            pose, moments = self.linkage.places[link].pose, numbers[[4, 7, 8, 7, 5, 9, 8, 9, 6]]
            R, centre = pose[:3, :3], pose[:3, :3] @ numbers[1:4] + pose[:3, 3]
            z = parameters(numbers[0], centre, R @ moments.reshape(3, 3) @ R.T)
            if broken := violations(z):
                raise LinkageError(f"link '{link}' cannot exist: {broken[0]}")
            masses[link] = z
        return masses

    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Compute the values of all columns of parameters in rows ``start`` to ``stop``.

        Args:
            start: first row.
            stop: row after the last.
        """
        study = self.study
        values = range_values(study.parameters, study.samples, study.seed, start, stop)
        return self._with_relations(values, stop - start)

    def value_in_model(self, name: str) -> float | None:
        """Compute the value of a parameter in the model; None for a name that is no path."""
        place = self._places.get(name)
        return None if place is None else self._sites.value(place)

    def links_with_moved_joints(self) -> set[str]:
        """Names of the bodies on which the study moves the origin of a joint or loop."""
        moved = (
            self._sites.sites[place.site].link
            for place in self._places.values()
            if place.kind == "length" or (place.kind == "origin" and place.component < 3)
        )
        links = {self.linkage.places[name].link for name in moved}
        return {body.name for body in self.linkage.bodies if body.link in links}

    def close(self, values: Mapping[str, Array]) -> ClosedGeometries:
        """Close the geometries of some rows.

        On the way, parameters go along a straight line and relations hold, so that a family
        of geometries that close is not left. Where a relation does not hold in the model, the
        difference goes to zero on the way.

        Args:
            values: of all columns of parameters (rows,); see `values`.
        """
        free_values = {name: values[name] for name in self.study.parameters}
        rows = len(next(iter(free_values.values())))
        start = {
            name: np.full(len(value), self._start[name]) if name in self._start else value
            for name, value in free_values.items()
        }
        related = self._with_relations(start, rows)
        nominal = self.closer.placer.nominal
        paths = list(nominal)

        def between(rows: IntArray, share: Array) -> dict[str, Array]:
            there = {
                name: np.where(
                    share == 1.0,
                    value[rows],
                    start[name][rows] + share * (value[rows] - start[name][rows]),
                )
                for name, value in free_values.items()
            }
            all_values = self._with_relations(there, rows.size)
            for path in self._relations.keys() & nominal.keys():
                all_values[path] += (1.0 - share) * (nominal[path] - related[path][rows])
            return {path: all_values[path] for path in paths}

        return self.closer.close(rows, {path: values[path] for path in paths}, between)

    def _with_relations(self, values: dict[str, Array], rows: int) -> dict[str, Array]:
        """Add the values of all relations."""
        all_values = {
            name: np.full(rows, value) for name, value in self._nominal.items()
        } | values
        for path, expression in self._relations.items():
            all_values[path] = np.broadcast_to(expression(all_values), rows).astype(np.float64)
        return {name: all_values[name] for name in self.driven}

    def _read_relations(self) -> dict[str, Expression]:
        """Read the expressions of all relations."""
        expressions = {}
        for path, text in self.study.relations.items():
            if path in self.study.parameters:
                problem = "has a range in [parameters], too"
                raise self._fault("relations", path, problem, "leave out one of the two")
            try:
                expressions[path] = read_expression(text)
            except ExpressionError as error:
                remedy = 'write "2*q2.origin.x + 0.1"'
                raise self._fault("relations", path, str(error), remedy) from None
        return expressions

    def _ordered(self, relations: dict[str, Expression]) -> dict[str, Expression]:
        """Sort relations so that each follows those that it uses."""
        graph = {path: [n for n in x.names if n in relations] for path, x in relations.items()}
        try:
            order = list(TopologicalSorter(graph).static_order())
        except CycleError as error:
            circle = " → ".join(map(clean, reversed(error.args[1])))
            problem = f"relations go in a circle: {circle}"
            raise self._fault("relations", error.args[1][0], problem, "cut it") from None
        return {path: relations[path] for path in order}

    def _find_places(self) -> dict[str, NumberPlace]:
        """Find what all paths name, and the values in the model of those that only occur."""
        used = {name for x in self._relations.values() for name in x.names}
        places = {}
        for path in self.driven:
            table = "relations" if path in self._relations else "parameters"
            try:
                places[path] = self._sites.find(path)
            except PathError as error:
                if path.isidentifier() and path in used:
                    continue  # a number of its own, which relations use
                raise self._fault(table, path, str(error), "correct the path") from None
        for name in sorted(used - set(self.driven)):
            try:
                self._nominal[name] = self._sites.value(self._sites.find(name))
            except PathError:
                owner = next(p for p, x in self._relations.items() if name in x.names)
                problem = f"'{clean(name)}' is neither a path nor a parameter"
                remedy = f"use paths, or {closest_names(name, self.driven)}"
                raise self._fault("relations", owner, problem, remedy) from None
        return places

    def _values_in_model(self) -> dict[str, float]:
        """Compute the values of parameters in the model, as far as they have one.

        A name that is no path has the value of a path that a relation sets equal to it.
        """
        values = dict(self.closer.placer.nominal)
        for path, expression in self._relations.items():
            if expression.text.strip() in self.study.parameters and path in values:
                values.setdefault(expression.text.strip(), values[path])
        return values

    def _check_names(self) -> None:
        """Refuse conditions on parameters that do not vary."""
        for expression in self.constraints.expressions:
            for name in expression.names:
                if name not in self.driven:
                    problem = f"'{clean(name)}' does not vary"
                    remedy = f"use {closest_names(name, self.driven)}"
                    raise self._fault("constraints", expression.text, problem, remedy)

    def _check_lengths(self, places: Mapping[str, NumberPlace]) -> None:
        """Refuse lengths of 0 or less: a link has no direction there, or turns round."""
        for name, each in self.study.parameters.items():
            ends = _ends(each)[:1] if each.kind == "normal" else each.numbers[:2]
            least = min(each.numbers if each.kind == "list" else ends)
            if name in places and places[name].kind == "length" and least <= 0.0:
                problem = f"a length of {least:g} m is not positive"
                raise self._fault("parameters", name, problem, "give lengths above 0")

    def _check_moves(self, places: Mapping[str, NumberPlace]) -> None:
        """Refuse a parameter whose change leaves every geometry as it was.

        The two ends of its range are compared, all others being as in the model.
        """
        middle = {name: _ends(each)[0] for name, each in self.study.parameters.items()}
        for name, each in self.study.parameters.items():
            low, high = _ends(each)
            if low == high:
                continue
            values = {k: np.full(2, value) for k, value in middle.items()}
            values[name] = np.array([low, high])
            all_values = self._with_relations(values, 2)
            placed = self.closer.placer.place(2, {path: all_values[path] for path in places})
            parts = (placed.screws, placed.gaps, *placed.links.values())
            parts += tuple(all_values[path] for path in self._heavy if self._uses_masses)
            if all(np.array_equal(part[0], part[-1], equal_nan=True) for part in parts):
                problem = "moves nothing: no joint, link or loop of the model changes with it"
                remedy = "leave it out, or use it in a relation"
                if name in self._heavy:
                    problem = "changes masses, on which no quantity of the study depends"
                    remedy = "compute shaking or counterweights, or leave it out"
                raise self._fault("parameters", name, problem, remedy)

    @property
    def _uses_masses(self) -> bool:
        """Whether a quantity depends on the masses of the model."""
        return any(name in MASS_QUANTITIES for name in self.study.quantities)

    def _fault(self, table: str, path: str, problem: str, remedy: str) -> FileError:
        """Make the error of an entry of the study."""
        return FileError(self.study.source, f"[{table}] {clean(path)}", problem, remedy)


def _ends(each: Range) -> tuple[float, float]:
    """Two values of a range, different if it has two."""
    if each.kind == "list":
        first = each.numbers[0]
        return first, next((x for x in each.numbers if x != first), first)
    low, high = each.numbers[:2]
    return (low, low + high) if each.kind == "normal" else (low, high)
