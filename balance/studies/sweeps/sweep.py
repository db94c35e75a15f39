"""Quantities of a linkage in many geometries, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from balance.studies.sweeps.study import Study
from balance.studies.sweeps.sweep_table import SweepTable
from balance.support.options import Balance
from kinematics.loading.model_gallery import LinkageLike, as_linkage


def sweep(
    linkage: LinkageLike,
    parameters: Mapping[str, object],
    *,
    quantities: Sequence[str] | Mapping[str, Mapping[str, Any]] = ("rank",),
    constraints: Mapping[str, Any] | None = None,
    relations: Mapping[str, str] | None = None,
    balance: Balance = "dynamic",
    spatial: bool = False,
    samples: int | None = None,
    seed: int = 0,
    workers: int = 1,
) -> SweepTable:
    """Compute quantities of a linkage in many geometries.

    Geometries are closed by continuation from the model's own pose. Those that do not close, or
    break a constraint, stay in the table with the reason.

    Args:
        linkage: the model, a linkage or what `kinematics.load` accepts.
        parameters: range of each number that varies, by its path: a grid
            ``"first:last:count"``, a list, ``{"uniform": [a, b]}``, ``{"normal": [m, s]}`` or
            ``{"sobol": [a, b]}``.
        quantities: names of what to compute, or options by name; see ``docs/sweeps.md``.
        constraints: what must hold, likewise.
        relations: further paths as expressions of the others.
        balance: as for `balance.design_space`.
        spatial: likewise.
        samples: number of samples of each point of the grid, if a parameter is sampled.
        seed: of the samples.
        workers: processes to use.

    Returns:
        One row for each geometry; see `SweepTable`.

    Raises:
        LinkageError: the model, or the study of it, cannot be used.

    Example:
        >>> import balance
        >>> table = balance.sweep("robot.urdf", {"coupler.length": "0.7:1.0:4"})
        >>> table["rank"]
        array([8, 8, 8, 8])
    """
    options = dict(quantities) if isinstance(quantities, Mapping) else {}
    sampling: dict[str, Any] = {"seed": seed} | ({} if samples is None else {"count": samples})
    tables = {
        "parameters": parameters,
        "relations": relations or {},
        "constraints": constraints or {},
        "sampling": sampling,
        "compute": {"quantities": list(quantities), "balance": balance, "spatial": spatial}
        | options,
    }
    return Study.from_tables(tables, as_linkage(linkage), "sweep").run(workers=workers)
