"""Relations between the quantities of a special geometry.

All relations of a few simple forms are tried, short ones first: a length is zero or equals
another, three joints are in line or at a right angle, angles are equal or opposite, products of
lengths agree (triangles are similar), sums of squares or of lengths agree. Those that are not
implied by shorter ones, by the rank of their gradients, are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, combinations_with_replacement
from typing import NamedTuple

import numpy as np

from balance.studies.discovery.quantities import (
    InvariantQuantity,
    measure_quantities,
    site_geometry,
)
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from kinematics.numerics.array_types import Array

# Residual up to which a relation holds at a polished geometry.
HOLDS = 1e-8
# Part of a gradient, over its length, that must be new.
NEW = 1e-5
STEP = 1e-5

KINDS = (
    "zero",
    "straight",
    "right",
    "equal",
    "supplement",
    "same angle",
    "opposite angle",
    "same function",
    "opposite function",
    "product",
    "squares",
    "sum",
)


class GeometryRelation(NamedTuple):
    """An equation between quantities.

    Attributes:
        kind: one of `KINDS`.
        left_side: numbers of the quantities on the left.
        right_side: numbers of the quantities on the right.
    """

    kind: str
    left_side: tuple[int, ...]
    right_side: tuple[int, ...] = ()

    def text(self, quantities: tuple[InvariantQuantity, ...]) -> str:
        """Write the relation with the names of the quantities."""
        left = [quantities[k].text for k in self.left_side]
        right = [quantities[k].text for k in self.right_side]
        match self.kind:
            case "zero":
                return f"{left[0]} = 0"
            case "straight":
                a, b, c = (chr(65 + j) for j in quantities[self.left_side[0]].joints)
                return f"{b}, {a}, {c} in line"
            case "right":
                return f"{left[0]} = 90°"
            case "supplement":
                return f"{left[0]} + {right[0]} = 180°"
            case "opposite function":
                return f"{left[0]} = -{right[0]}"
            case "same angle":
                return f"{left[0]} = {right[0]} (mod 180°)"
            case "opposite angle":
                return f"{left[0]} = -{right[0]} (mod 180°)"
            case "product":
                return f"{_product(left)} = {_product(right)}"
            case "squares":
                return " = ".join(" + ".join(f"{x}²" for x in side) for side in (left, right))
        return f"{' + '.join(left)} = {' + '.join(right)}"

    def words(self, quantities: tuple[InvariantQuantity, ...]) -> str:
        """Say the relation in words, with the names of the quantities."""
        left = [quantities[k].text for k in self.left_side]
        right = [quantities[k].text for k in self.right_side]
        quantity = quantities[self.left_side[0]]
        a, b, c = (*(chr(65 + j) for j in quantity.joints), "")[:3]
        match self.kind:
            case "zero":
                return f"{b} slides in line with {a}"
            case "straight":
                return f"{b}, {a} and {c} are in line"
            case "right":
                return f"{'the arc ' * (quantity.kind == 'arc')}{left[0]} is a right angle"
            case "supplement":
                return f"the arcs {left[0]} and {right[0]} add up to a straight angle"
            case "same angle":
                return f"{left[0]} and {right[0]} are equal"
            case "opposite angle":
                return f"{left[0]} and {right[0]} are equal, one mirrored"
            case "same function" | "opposite function":
                opposite = "opposite of the " * (self.kind == "opposite function")
                corner, other = (
                    f"corner {letters[2]} over corner {letters[0]} in the loop {letters}"
                    for letters in _loops(quantities, (*self.left_side, *self.right_side))
                )
                return f"{corner} has the {opposite}{quantity.kind} of {other}"
            case "product":
                return _ratio_words(left, right)
            case "squares":
                return (
                    f"the squares over {_and(left)} and those over {_and(right)} add up alike"
                )
            case "sum":
                return f"{_and(left)} together are as long as {_and(right)} together"
        return f"{_and([*left, *right])} are equally long"


def _loops(quantities: tuple[InvariantQuantity, ...], chosen: tuple[int, ...]) -> Iterator[str]:
    """Yield the letters of the joints around loops."""
    for k in chosen:
        yield "".join(chr(65 + j) for j in quantities[k].joints)


def _and(names: list[str]) -> str:
    """Join names."""
    return f"twice {names[0]}" if len(set(names)) < len(names) else " and ".join(names)


def _ratio_words(first: list[str], second: list[str]) -> str:
    """Say that two products are equal."""
    if first[0] == first[1]:
        return f"{first[0]} is the geometric mean of {second[0]} and {second[1]}"
    if second[0] == second[1]:
        return f"{second[0]} is the geometric mean of {first[0]} and {first[1]}"
    return f"{first[0]} is to {second[0]} as {second[1]} is to {first[1]}"


def _product(names: list[str]) -> str:
    """Write a product of names; a square if they are the same."""
    return f"{names[0]}²" if len(set(names)) == 1 < len(names) else "·".join(names)


def list_relations(
    quantities: tuple[InvariantQuantity, ...],
) -> dict[str, list[GeometryRelation]]:
    """List all relations of each kind, short ones first."""
    by_kind: dict[str, list[GeometryRelation]] = {kind: [] for kind in KINDS}
    for relation in _all(quantities):
        by_kind[relation.kind].append(relation)
    return by_kind


def _all(quantities: tuple[InvariantQuantity, ...]) -> Iterator[GeometryRelation]:
    """Yield all relations."""
    by_kind = {
        kind: [k for k, entry in enumerate(quantities) if entry.kind == kind]
        for kind in ("length", "arc", "angle", "offset", "slope", "constant")
    }
    lengths, arcs, angles = by_kind["length"], by_kind["arc"], by_kind["angle"]
    for k in by_kind["offset"]:
        yield GeometryRelation("zero", (k,))
    for k in angles:
        yield GeometryRelation("straight", (k,))
    for k in angles + arcs:
        yield GeometryRelation("right", (k,))
    for a, b in combinations(arcs, 2):
        yield GeometryRelation("equal", (a,), (b,))
        yield GeometryRelation("supplement", (a,), (b,))
    for a, b in combinations(lengths, 2):
        yield GeometryRelation("equal", (a,), (b,))
    for a, b in combinations(angles, 2):
        yield GeometryRelation("same angle", (a,), (b,))
        yield GeometryRelation("opposite angle", (a,), (b,))
    yield from _same_functions(quantities, by_kind["slope"], by_kind["constant"])
    pairs = list(combinations_with_replacement(lengths, 2))
    for left, right in combinations(pairs, 2):
        if not set(left) & set(right) and len({*left, *right}) > 2:
            yield GeometryRelation("product", left, right)
            yield GeometryRelation("squares", left, right)
            yield GeometryRelation("sum", left, right)


def _same_functions(
    quantities: tuple[InvariantQuantity, ...], slopes: list[int], constants: list[int]
) -> Iterator[GeometryRelation]:
    """Yield equal slopes and equal or opposite constants of two loops."""
    for functions in (slopes, constants):
        for a, b in combinations(functions, 2):
            if set(quantities[a].joints) != set(quantities[b].joints):
                yield GeometryRelation("same function", (a,), (b,))
                if functions is constants:
                    yield GeometryRelation("opposite function", (a,), (b,))


def residuals(kind: str, relations: list[GeometryRelation], values: Array) -> Array:
    """Compute by how much relations of one kind fail (lanes, relations).

    Args:
        values: quantities of the linkages (lanes, quantities).
    """
    left = values[
        :, np.array([r.left_side for r in relations], int).reshape(len(relations), -1)
    ]
    right = values[
        :, np.array([r.right_side for r in relations], int).reshape(len(relations), -1)
    ]
    match kind:
        case "zero":
            return left[..., 0]
        case "straight":
            return np.sin(left[..., 0])
        case "right":
            return np.cos(left[..., 0])
        case "opposite function":
            return left[..., 0] + right[..., 0]
        case "supplement":
            return left[..., 0] + right[..., 0] - np.pi
        case "same angle":
            return np.sin(left[..., 0] - right[..., 0])
        case "opposite angle":
            return np.sin(left[..., 0] + right[..., 0])
        case "product":
            tiny = 1e-300
            return np.log(left + tiny).sum(axis=-1) - np.log(right + tiny).sum(axis=-1)
        case "squares":
            return (left**2).sum(axis=-1) - (right**2).sum(axis=-1)
    return np.asarray(left.sum(axis=-1) - right.sum(axis=-1))


def held_relations(
    listed: dict[str, list[GeometryRelation]], values: Array
) -> list[GeometryRelation]:
    """Return the relations that one geometry fulfils, short ones first.

    Args:
        listed: from `list_relations`.
        values: its quantities (quantities,).
    """
    held: list[GeometryRelation] = []
    for kind, relations in listed.items():
        if relations:
            wrong = np.abs(residuals(kind, relations, values[None])[0])
            held += [relations[k] for k in np.flatnonzero(wrong <= HOLDS)]
    return _without_trivial(held)


def _without_trivial(held: list[GeometryRelation]) -> list[GeometryRelation]:
    """Leave out relations that read the same on both sides if equal lengths share a name."""
    name: dict[int, int] = {}
    for relation in held:
        if relation.kind == "equal":
            a, b = (name.get(k, k) for k in (relation.left_side[0], relation.right_side[0]))
            for k in [*name, relation.left_side[0], relation.right_side[0]]:
                if name.get(k, k) == b:
                    name[k] = a

    def renamed(side: tuple[int, ...]) -> list[int]:
        return sorted(name.get(k, k) for k in side)

    many = ("product", "squares", "sum")
    return [
        r for r in held if r.kind not in many or renamed(r.left_side) != renamed(r.right_side)
    ]


def gradients(
    structure: TopologyArrays,
    quantities: tuple[InvariantQuantity, ...],
    geometry: LaneGeometry,
    relations: list[GeometryRelation],
) -> Array:
    """Differentiate relations with respect to all changes (lanes, relations, changes)."""
    lanes, count = len(geometry.points), len(structure.shifts)
    steps = np.repeat(np.concatenate([np.eye(count), -np.eye(count)])[None], lanes, 0) * STEP
    many = LaneGeometry(*(np.repeat(a, 2 * count, axis=0) for a in geometry))
    moved = structure.move(many, steps.reshape(-1, count))
    values = measure_quantities(quantities, site_geometry(structure, moved))
    errors = np.stack([residuals(r.kind, [r], values)[:, 0] for r in relations], axis=1)
    both = errors.reshape(lanes, 2, count, len(relations))
    return np.moveaxis((both[:, 0] - both[:, 1]) / (2 * STEP), 1, 2)


def independent(slopes: Array) -> list[int]:
    """Choose relations that shorter ones do not imply.

    Args:
        slopes: gradients of the relations of one geometry (relations, changes).

    Returns:
        Their numbers.
    """
    chosen: list[int] = []
    basis = np.zeros((0, slopes.shape[1]))
    for k, row in enumerate(slopes):
        size = np.sqrt(row @ row)
        if size == 0.0:
            continue
        row = row / size
        row = row - basis.T @ (basis @ row)
        remainder = np.sqrt(row @ row)
        if remainder > NEW:
            basis = np.concatenate([basis, row[None] / remainder])
            chosen.append(k)
    return chosen
