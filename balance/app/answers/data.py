"""The report on a design space as plain data, the output of ``balance report --json``."""

from __future__ import annotations

import json
from importlib.resources import files
from math import inf
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from balance.masses.pure_inertias.pure_inertia import PureInertia
    from balance.space.decoupled.decoupling import Decoupling
    from balance.space.exact.modular_ranks import ExactRanks
    from balance.space.interpretation.explain import Explanation
    from balance.space.spaces.design_space import DesignSpace


def schema() -> dict[str, object]:
    """Return the JSON schema (draft 2020-12) of `report_data`."""
    path = files("balance").joinpath("app", "schemas", "report.schema.json")
    return dict(json.loads(path.read_text(encoding="utf-8")))


class Report(NamedTuple):
    """A design space and what was computed about it.

    Attributes:
        space: the design space.
        explanation: result of `balance.explain`; None without it.
        exact: result of `balance.checks.exact_ranks`; None without it.
        change: result of `balance.space.distance_to_rank_drop`; infinite without it.
        decoupling: result of `balance.space.decoupling`; None without it.
        pure_inertia: result of `balance.masses.pure_inertia`; None without it.
        following: the command that comes next; empty if there is none.
        alternative: the command that says what to build in, where other masses may not be
            enough; empty elsewhere.
    """

    space: DesignSpace
    explanation: Explanation | None = None
    exact: ExactRanks | None = None
    change: float = inf
    decoupling: Decoupling | None = None
    pure_inertia: PureInertia | None = None
    following: str = ""
    alternative: str = ""


def report_data(report: Report) -> dict[str, object]:
    """Collect a report as plain data for JSON.

    The keys ``next``, ``alternative``, ``transfers``, ``freedoms``, ``exact``, ``decoupled``,
    ``pure_inertia`` and ``margin.change`` are ``None`` without their results; so is
    ``margin.change`` where the distance is infinite.
    """
    data = report.space.to_dict()
    if report.explanation is not None:
        data |= report.explanation.to_dict()
    if report.exact is not None:
        data["exact"] = report.exact.to_dict()
    if report.decoupling is not None:
        data["decoupled"] = report.decoupling.to_dict()
    if report.pure_inertia is not None:
        data["pure_inertia"] = report.pure_inertia.to_dict()
    if report.following:
        data["next"] = report.following
    if report.alternative:
        data["alternative"] = report.alternative
    if report.change < inf:
        margin = data["margin"]
        assert isinstance(margin, dict)
        margin["change"] = report.change
    return data
