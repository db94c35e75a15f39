"""What must hold for a geometry of a sweep, beyond loops that close."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.studies.sweeps.closing import ClosedGeometries, Closer
from balance.studies.sweeps.expressions import Expression, ExpressionError, read_expression
from balance.studies.sweeps.loop_shapes import FourBar, loop_cycle
from balance.studies.sweeps.reach import Reach
from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError
from kinematics.model.linkage import Linkage, names_of

Array = NDArray[np.float64]

KNOWN = ("assembles", "conditions", "grashof", "reach", "transmission")
ASSEMBLIES = ("anywhere", "here")
REASONS = {
    "here": "its loops close only with the inputs elsewhere",
    "grashof": "not Grashof: no link turns fully",
    "crank": "its input does not turn fully",
}


def read_constraints(table: Mapping[str, Any], source: str) -> Mapping[str, Any]:
    """Check the table of the constraints.

    Args:
        table: as the study has it.
        source: name of the study in messages.

    Returns:
        The table.

    Raises:
        FileError: a constraint is unknown, or its value has no meaning.
    """
    for name, value in table.items():
        if name not in KNOWN:
            remedy = f"choose from {closest_names(name, KNOWN)}"
            raise _fault(source, name, "no such constraint", remedy)
        wrong, remedy = {
            "assembles": (value not in ASSEMBLIES, 'write "anywhere" or "here"'),
            "conditions": (not _are_texts(value), 'write ["q2.origin.x < q4.origin.x"]'),
            "grashof": (value not in (True, "crank"), 'write true or "crank"'),
            "reach": (not _is_reach(value), "give link, point and targets in metres"),
            "transmission": (not _is_transmission(value), "give degrees, or {joint, least}"),
        }[name]
        if wrong:
            problem = f"'{clean(str(value))}' has no meaning"
            raise _fault(source, name, problem, remedy)
    return dict(table)


class StudyConstraints:
    """The constraints of a study, for its model.

    Attributes:
        conditions: expressions that must be true.
    """

    def __init__(self, table: Mapping[str, Any], linkage: Linkage, source: str) -> None:
        """Check constraints against a model.

        Args:
            table: that of `read_constraints`.
            source: name of the study in messages.

        Raises:
            FileError: a constraint does not fit the model.
        """
        self._table, self._linkage, self._source = table, linkage, source
        self.conditions = tuple(
            self._expression("conditions", text, True) for text in table.get("conditions", ())
        )
        self._four_bar = FourBar.of(linkage)
        wants = [name for name in ("grashof", "transmission") if name in table]
        if isinstance(table.get("transmission"), Mapping):
            wants.remove("transmission")
            self._corner = self._find_corner(table["transmission"]["joint"])
        if wants and self._four_bar is None:
            remedy = (
                "leave it out" if wants[0] == "grashof" else 'give {joint = "q3", least = 30}'
            )
            problem = "the model is no planar four-bar driven at one of its joints"
            raise _fault(source, wants[0], problem, remedy)
        self._point: tuple[Expression, ...] = ()
        if "reach" in table:
            given = table["reach"]["point"]
            self._point = tuple(self._expression("reach", str(x), False) for x in given)
            link = table["reach"]["link"]
            if linkage.places.get(link) is None or linkage.places[link].link < 0:
                choices = closest_names(link, [body.name for body in linkage.bodies])
                raise _fault(
                    source, "reach", f"no moving link '{clean(link)}'", f"take {choices}"
                )

    def check(
        self, closer: Closer, values: Mapping[str, Array], closed: ClosedGeometries,
        reasons: NDArray[Any],
    ) -> None:  # fmt: skip
        """Note the reason of each geometry that breaks a constraint, where there is none yet.

        Args:
            values: of all parameters (rows,).
            reasons: why a geometry has no answer (rows,); changed in place.
        """
        table, points = self._table, joint_points(self._linkage, closed)
        for condition in self.conditions:
            _note(
                reasons,
                ~np.broadcast_to(condition(values), reasons.size),
                f"not {condition.text}",
            )
        if table.get("assembles") == "here":
            _note(reasons, closed.closed == 2, REASONS["here"])
        if self._four_bar is not None and "grashof" in table:
            lengths = self._four_bar.lengths(points)
            _note(reasons, ~FourBar.is_grashof(lengths), REASONS["grashof"])
            if table["grashof"] == "crank":
                _note(reasons, ~FourBar.turns_fully(lengths), REASONS["crank"])
        if "transmission" in table:
            least, angle = self._transmission(points)
            text = f"transmission angle below {least:g} degrees"
            _note(reasons, ~(angle >= least), text)
        if "reach" in table:
            reach = Reach(self._linkage, closer, table["reach"]["link"])
            parts = [np.broadcast_to(x(values), reasons.size) for x in self._point]
            given = np.stack(parts, axis=-1).astype(np.float64)
            rows = np.flatnonzero(reasons == "")
            for target in table["reach"]["targets"]:
                missed = ~reach.reaches(closed, rows, given, target)
                words = ", ".join(f"{x:g}" for x in target)
                reasons[rows[missed]] = f"does not reach ({words})"
                rows = rows[~missed]

    @property
    def expressions(self) -> tuple[Expression, ...]:
        """All expressions of parameters in the constraints."""
        return *self.conditions, *self._point

    def _expression(self, name: str, text: str, comparison: bool) -> Expression:
        """Read an expression of a constraint."""
        try:
            return read_expression(text, comparison)
        except ExpressionError as error:
            remedy = 'write "q2.origin.x < q4.origin.x"' if comparison else 'write "q2.length"'
            raise _fault(self._source, name, str(error), remedy) from None

    def _find_corner(self, name: str) -> tuple[int, int, int]:
        """Find a joint in its loop, and its two neighbours there."""
        for number in range(len(self._linkage.loops)):
            cycle = loop_cycle(self._linkage, number)
            names = names_of([self._linkage.joints[j] for j in cycle])
            if name in names:
                k = names.index(name)
                return cycle[k - 1], cycle[k], cycle[(k + 1) % len(cycle)]
        choices = closest_names(name, names_of(self._linkage.joints))
        problem = f"no joint '{clean(name)}' is in a loop"
        raise _fault(self._source, "transmission", problem, f"choose from {choices}")

    def _transmission(self, points: Array) -> tuple[float, Array]:
        """Compute what is asked, and the transmission angle of each geometry, degrees."""
        wanted = self._table["transmission"]
        if not isinstance(wanted, Mapping):
            assert self._four_bar is not None
            lengths = self._four_bar.lengths(points)
            return float(wanted), FourBar.least_transmission(lengths)
        before, here, after = (points[:, j] for j in self._corner)
        first, second = before - here, after - here
        across = np.linalg.norm(np.cross(first, second), axis=1)
        along = np.abs(np.sum(first * second, axis=1))
        return float(wanted["least"]), np.degrees(np.arctan2(across, along))


def joint_points(linkage: Linkage, closed: ClosedGeometries) -> Array:
    """Compute points of all joints at closed poses (rows, n, 3), metres."""
    before = closed.H[:, [joint.parent for joint in linkage.joints]]
    turned = before[..., :3, :3] @ closed.placed.points[..., None]
    return np.asarray(turned[..., 0] + before[..., :3, 3])


def _note(reasons: NDArray[Any], broken: NDArray[Any], text: str) -> None:
    """Write a reason where a constraint is broken and no other reason stands."""
    reasons[np.asarray(broken, dtype=bool) & (reasons == "")] = text


def _are_texts(value: object) -> bool:
    return isinstance(value, list | tuple) and all(isinstance(item, str) for item in value)


def _is_number(value: object) -> bool:
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    )


def _is_triple(value: object, texts: bool = False) -> bool:
    return isinstance(value, list | tuple) and len(value) == 3 and all(
        _is_number(x) or (texts and isinstance(x, str)) for x in value
    )  # fmt: skip


def _is_transmission(value: object) -> bool:
    if isinstance(value, Mapping):
        return set(value) == {"joint", "least"} and isinstance(value["joint"], str) and (
            _is_number(value["least"])
        )  # fmt: skip
    return _is_number(value)


def _is_reach(value: object) -> bool:
    if not isinstance(value, Mapping) or set(value) != {"link", "point", "targets"}:
        return False
    targets = value["targets"]
    several = isinstance(targets, list | tuple) and bool(targets)
    several = several and all(map(_is_triple, targets))
    return isinstance(value["link"], str) and _is_triple(value["point"], True) and several


def _fault(source: str, name: str, problem: str, remedy: str) -> FileError:
    return FileError(source, f"[constraints] {clean(name)}", problem, remedy)
