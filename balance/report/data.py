"""The report on a design space as plain data, the output of ``balance report --json``."""

from __future__ import annotations

import json
from importlib.resources import files
from math import inf
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from balance.exact.modular_ranks import Exact
    from balance.interpretation.explain import Explanation
    from balance.spaces.design_space import DesignSpace

__all__ = ["report_data", "schema"]


def schema() -> dict[str, object]:
    """Return the JSON schema (draft 2020-12) of `report_data`."""
    path = files("balance").joinpath("schemas", "report.schema.json")
    return dict(json.loads(path.read_text(encoding="utf-8")))


def report_data(
    space: DesignSpace,
    explanation: Explanation | None = None,
    exact: Exact | None = None,
    change: float = inf,
) -> dict[str, object]:
    """Collect a design space and results about it as plain data for JSON.

    Args:
        space: the design space.
        explanation: result of `balance.explain`, for the keys ``transfers`` and ``freedoms``.
        exact: result of `balance.exact_ranks`, for the key ``exact``.
        change: result of `balance.distance_to_rank_drop`, for ``margin.change``; an infinite
            distance is written as ``None``.
    """
    data = space.to_dict()
    if explanation is not None:
        data |= explanation.to_dict()
    if exact is not None:
        data["exact"] = exact.to_dict()
    margin = {"kept": space.kept, "dropped": space.dropped}
    data["margin"] = margin | {"change": change if change < inf else None}
    return data
