"""What must hold for a geometry of a sweep, beyond loops that close.

A spherical joint at the point welds the link to the ground there, as a further loop. Its gap is
closed in steps along the straight line to the target, with all joints moving by steps of least
norm: the linkage reaches the target if it can follow that line on its branch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.sweeps.closing import (
    ClosedGeometries,
    Closer,
    continue_rows,
    newton_limits,
)
from balance.studies.sweeps.closing_kernels import close_each, closing_workspace
from balance.studies.sweeps.ranges import are_texts, is_finite_number
from balance.studies.sweeps.study_units import in_si
from balance.support.expressions import Expression, ExpressionError, read_expression
from balance.support.tolerances import SCREW_ROUNDED
from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError, UsageError
from kinematics.model.arrays import freeze
from kinematics.model.chain import arrange_loops, loop_signs, path
from kinematics.model.linkage import Linkage, names_of
from kinematics.numerics.array_types import Array, Flags, IntArray

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
        The table, with numbers instead of texts that have a unit: metres, and for transmission
        angles degrees.

    Raises:
        FileError: a constraint is unknown, or its value has no meaning.
    """
    for name in table:
        if name not in KNOWN:
            remedy = f"choose from {closest_names(name, KNOWN)}"
            raise _fault(source, name, "no such constraint", remedy)
    try:
        table = {name: _without_units(name, value) for name, value in table.items()}
    except UsageError as error:
        raise _fault(source, "units", str(error), "correct the unit") from None
    for name, value in table.items():
        wrong, remedy = {
            "assembles": (value not in ASSEMBLIES, 'write "anywhere" or "here"'),
            "conditions": (not are_texts(value), 'write ["q2.origin.x < q4.origin.x"]'),
            "grashof": (value not in (True, "crank"), 'write true or "crank"'),
            "reach": (not _is_reach(value), "give link, point and targets in metres"),
            "transmission": (
                not _is_transmission(value),
                'give "30deg", or {joint = "q3", least = "30deg"}; a number is in degrees',
            ),
        }[name]
        if wrong:
            problem = f"'{clean(str(value))}' has no meaning"
            raise _fault(source, name, problem, remedy)
    return dict(table)


def _without_units(name: str, value: Any) -> Any:
    """Convert texts with units to numbers: transmission angles in degrees, targets in metres.

    Raises:
        UsageError: a unit is none of an angle, or of a length.
    """
    if name == "transmission":
        if isinstance(value, Mapping):
            return {key: _degrees(x) if key == "least" else x for key, x in value.items()}
        return _degrees(value)
    if name == "reach" and isinstance(value, Mapping):
        return {
            key: in_si(each, "length") if key == "targets" else each
            for key, each in value.items()
        }
    return value


def _degrees(value: Any) -> Any:
    """Convert a text with a unit of angle to degrees; other values stay as they are."""
    number = in_si(value, "angle")
    return number if number == value else float(f"{degrees(number):.14g}")


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
        self._four_bar = _FourBar.of(linkage)
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
        self,
        closer: Closer,
        values: Mapping[str, Array],
        closed: ClosedGeometries,
        reasons: NDArray[Any],
    ) -> None:
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
            _note(reasons, ~_FourBar.is_grashof(lengths), REASONS["grashof"])
            if table["grashof"] == "crank":
                _note(reasons, ~_FourBar.turns_fully(lengths), REASONS["crank"])
        if "transmission" in table:
            least, angle = self._transmission(points)
            text = f"transmission angle below {least:g} degrees"
            _note(reasons, ~(angle >= least), text)
        if "reach" in table:
            reach = _Reach(self._linkage, closer, table["reach"]["link"])
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
            cycle = _loop_cycle(self._linkage, number)
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
            return float(wanted), _FourBar.least_transmission(lengths)
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


def _is_triple(value: object, texts: bool = False) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == 3
        and all(is_finite_number(x) or (texts and isinstance(x, str)) for x in value)
    )


def _is_transmission(value: object) -> bool:
    if isinstance(value, Mapping):
        return (
            set(value) == {"joint", "least"}
            and isinstance(value["joint"], str)
            and (is_finite_number(value["least"]))
        )
    return is_finite_number(value)


def _is_reach(value: object) -> bool:
    if not isinstance(value, Mapping) or set(value) != {"link", "point", "targets"}:
        return False
    targets = value["targets"]
    several = isinstance(targets, list | tuple) and bool(targets)
    several = several and all(map(_is_triple, targets))
    return isinstance(value["link"], str) and _is_triple(value["point"], True) and several


def _fault(source: str, name: str, problem: str, remedy: str) -> FileError:
    return FileError(source, f"[constraints] {clean(name)}", problem, remedy)


def _loop_cycle(linkage: Linkage, number: int) -> list[int]:
    """List the joints round a loop, in order."""
    parent, loop = [joint.parent for joint in linkage.joints], linkage.loops[number]
    out, back = path(parent, loop.end), path(parent, loop.successor)
    shared = set(out) & set(back)
    return [j for j in reversed(out) if j not in shared] + [j for j in back if j not in shared]


class _FourBar(NamedTuple):
    """The loop of a planar four-bar linkage, driven at one joint.

    Attributes:
        cycle: its joints, from the driven one on: the first link follows that joint.
        normal: of its plane (3,).
    """

    cycle: tuple[int, ...]
    normal: Array

    @classmethod
    def of(cls, linkage: Linkage) -> _FourBar | None:
        """Find the four-bar of a linkage; None if it is none, or is not driven at a joint."""
        cycle = _loop_cycle(linkage, 0) if len(linkage.loops) == 1 else []
        joints = [linkage.joints[j] for j in cycle]
        if len(cycle) != 4 or not all(joint.kind == "revolute" for joint in joints):
            return None
        n = joints[0].screw[:3]
        if any(np.abs(np.cross(n, j.screw[:3])).max() > SCREW_ROUNDED for j in joints):
            return None
        driven = [k for k, name in enumerate(names_of(joints)) if name in linkage.inputs]
        if len(driven) != 1:
            return None
        return cls((*cycle[driven[0] :], *cycle[: driven[0]]), n)

    def lengths(self, points: Array) -> Array:
        """Compute the lengths of the links (rows, 4), in the plane, from points of the joints.

        Args:
            points: of all joints (rows, n, 3), metres.
        """
        corners = points[:, list(self.cycle)]
        spans = np.roll(corners, -1, axis=1) - corners
        spans -= (spans @ self.normal)[..., None] * self.normal
        return np.sqrt(np.sum(spans**2, axis=-1))

    @staticmethod
    def is_grashof(lengths: Array) -> Flags:
        """Whether some link can turn fully: shortest and longest are at most the other two."""
        ends = lengths.min(axis=1) + lengths.max(axis=1)
        return np.asarray(2.0 * ends <= lengths.sum(axis=1))

    @staticmethod
    def turns_fully(lengths: Array) -> Flags:
        """Whether the driven joint turns fully: the shortest link is at it, by Grashof."""
        at_joint = np.minimum(lengths[:, 0], lengths[:, 3]) <= lengths.min(axis=1)
        return _FourBar.is_grashof(lengths) & at_joint

    @staticmethod
    def least_transmission(lengths: Array) -> Array:
        """Compute the least transmission angle (rows,) over a full turn, degrees.

        Opposite to the driven joint, between links b and c: ``cos μ = (b² + c² - D²) / 2bc``
        with the diagonal D between ``|a - d|`` and ``a + d``. It is 0 where the driven joint
        cannot turn fully: the linkage then reaches a dead centre.
        """
        a, b, c, d = lengths.T
        with np.errstate(all="ignore"):
            cosines = [(b * b + c * c - D * D) / (2.0 * b * c) for D in (np.abs(a - d), a + d)]
            largest = np.clip(np.max(np.abs(cosines), axis=0), 0.0, 1.0)
        angle = np.degrees(np.arccos(largest))
        return np.where(_FourBar.turns_fully(lengths), angle, 0.0)


class _Reach:
    """A link of a model whose points are to reach targets."""

    def __init__(self, linkage: Linkage, closer: Closer, link: str) -> None:
        """Extend the chain of the model by a spherical joint.

        Args:
            link: name of the link.
        """
        self._closer, self._place, self._name = closer, linkage.places[link], link
        chain = arrange_loops(linkage)
        n, at = chain.parent.size, self._place.link
        parent = np.append(chain.parent, [at, n, n + 1])
        ends = np.vstack([chain.ends, [n + 2, -1]])
        mimics = np.hstack([chain.mimics, np.zeros((len(chain.mimics), 3))])
        signs = loop_signs(parent, ends)
        moving = np.any(signs != 0.0, axis=0) | np.any(mimics != 0.0, axis=0)
        self._topology = (
            freeze(parent, np.int64),
            freeze(ends, np.int64),
            freeze(signs),
            freeze(mimics),
            freeze(signs.T @ signs),
            freeze(np.flatnonzero(moving), np.int64),
        )
        self._axes = np.roll(linkage.chain.frame.R, 1, axis=0)  # the normal of a plane first
        self._workspace = closing_workspace(n + 3, len(ends), len(mimics))

    def reaches(
        self,
        closed: ClosedGeometries,
        rows: IntArray,
        points: Array,
        target: Sequence[float],
    ) -> Flags:
        """Decide which geometries bring their points of the link to a target.

        Args:
            points: in the frame of the link (rows, 3), metres; one of each geometry.
            target: in the inertial frame (3,), metres.

        Returns:
            Whether each of these rows does (rows,).
        """
        frame = self._closer.chain.frame
        screws, gaps = self._closer.to_chain(closed.placed)
        links = closed.placed.links[self._name]
        frames = np.broadcast_to(links, (len(screws), 4, 4))[rows] @ self._place.pose
        here = (frames[:, :3, :3] @ points[rows][..., None])[..., 0] + frames[:, :3, 3]
        here = (here - frame.origin) / frame.length
        goal = (np.array(target, dtype=np.float64) - frame.origin) / frame.length
        axes = np.broadcast_to(self._axes, (rows.size, 3, 3))
        moments = np.cross(here[:, None], axes)
        added = np.concatenate([axes, moments], axis=-1)
        q = np.concatenate(
            [closed.q[rows] / self._closer.chain.units, np.zeros((rows.size, 3))], 1
        )
        start = self._starts(closed, rows, here)
        welds = np.tile(np.eye(4), (rows.size, 1, 1, 1))
        given = np.concatenate([screws[rows], added], axis=1), gaps[rows]
        return self._follow(given, here, start, goal, welds, q)

    def _starts(self, closed: ClosedGeometries, rows: IntArray, here: Array) -> Array:
        """Compute where the point is at the closed poses (rows, 3), in units of the chain."""
        frame = self._closer.chain.frame
        H = closed.H[rows, self._place.link]
        si = frame.length * here + frame.origin
        there = (H[:, :3, :3] @ si[..., None])[..., 0] + H[:, :3, 3]
        return np.asarray((there - frame.origin) / frame.length)

    def _follow(
        self,
        given: tuple[Array, Array],
        here: Array,
        start: Array,
        goal: Array,
        welds: Array,
        q: Array,
    ) -> Flags:
        """Follow the straight line from the start of each row to the goal."""
        share, limits = np.zeros(len(q)), newton_limits(free=True)

        def solve(rows: IntArray, ahead: Array) -> tuple[Array, Flags]:
            line = start[rows] + ahead[:, None] * (goal - start[rows])
            welds[rows, 0, :3, 3] = line - here[rows]
            solutions, good = q[rows], np.zeros(rows.size, dtype=np.bool_)
            gaps = np.concatenate([given[1][rows], welds[rows]], axis=1)
            close_each(
                self._topology, (given[0][rows], gaps), limits, solutions, good, self._workspace
            )
            return solutions, good

        continue_rows(solve, np.arange(len(q)), q, share)
        return share == 1.0
