"""Formulas as data: conditions, each solved for a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from balance.space.formulas.parameters import Parameter
from balance.space.formulas.planar_parts import PlanarParts
from balance.space.formulas.polynomials import Quotient
from balance.space.formulas.relations import FreeDimensions


class Term(NamedTuple):
    """A parameter and its coefficient."""

    parameter: Parameter
    coefficient: Quotient


class Condition(NamedTuple):
    """A condition: the solved parameter plus its terms is zero."""

    solved: Parameter
    terms: tuple[Term, ...]


@dataclass(frozen=True, eq=False)
class Formulas:
    source: str
    name: str
    balance: str
    parts: PlanarParts
    relations: tuple[str, ...]
    free: FreeDimensions
    parameters: tuple[Parameter, ...]
    conditions: tuple[Condition, ...]
    unknown: int
    rank: int
    residual: float
    geometries: int
