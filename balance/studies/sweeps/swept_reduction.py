"""The least shaking for a budget of matter as a quantity of a sweep, as of ``balance reduce``.

Options and defaults are those of `balance.partial`. The motion is that of
`balance.studies.sweeps.swept_motion`; the random ones without options of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from balance.masses.partial_balance.added_weights import check_budget
from balance.masses.partial_balance.budgets import partial
from balance.masses.partial_balance.partial_balance import PartialBalance
from balance.masses.partial_balance.shaking_problem import (
    SAMPLES,
    ShakingOptions,
    build_problem,
)
from balance.motion.verification.crank_revolution import STEPS
from balance.motion.verification.trajectory import Trajectory, random_motions
from balance.space.spaces.compute_space import design_space
from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.swept_motion import MOTION_OPTIONS, motion_of_options
from balance.studies.sweeps.weight_columns import BUDGET, weight_columns, weight_values
from balance.support.options import Balance
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage

Options = Mapping[str, Any]

REQUEST = ("links", "budget")
LIMITS = (
    *("density", "max_bearing", "max_torque", "minimise", "regions", "thickness"),
    "weight_moment",
)
REDUCE_OPTIONS = tuple(sorted((*REQUEST, *LIMITS, *MOTION_OPTIONS)))
"""Names of the options."""


def reduce_columns(linkage: Linkage, options: Options) -> tuple[Column, ...]:
    """Name verdict, added mass, what is left of the objective of the file, and the weights."""
    return (
        Column("reduce", "text"),
        Column("budget_used", "real", "kg"),
        Column("share_left", "real"),
        *weight_columns(linkage, options["links"], BUDGET),
    )


def reduce_values(
    linkage: Linkage, options: Options, answer: PartialBalance
) -> tuple[Any, ...]:
    """Return the values of `reduce_columns`; no numbers where no matter keeps the caps."""
    if answer.shaking is None:
        return (answer.verdict,)
    weights = weight_values(linkage, options["links"], answer.weights)
    return answer.verdict, answer.mass, answer.share, *weights


def reduction(linkage: Linkage, balance: Balance, options: Options) -> PartialBalance:
    """Compute the matter within the budget that lets a geometry shake least.

    Args:
        balance: of forces alone, or of moments, too.
        options: those of `REDUCE_OPTIONS`, with a density of None for point masses.

    Raises:
        LinkageError: see `balance.partial`.
    """
    limits = {name: options[name] for name in LIMITS if name in options}
    motions = _motions(linkage, options, explain=False)
    space = design_space(linkage, None, balance, max_order=0)
    return partial(space, options["links"], options["budget"], motions=motions, **limits)


def check_reduce(linkage: Linkage, options: Options) -> None:
    """Refuse links, regions, joints, a budget or a motion that the model does not have."""
    if not isinstance(options.get("links"), Sequence):
        raise UsageError('no links to add matter to; write links = ["crank", "rocker"]')
    if "budget" not in options:
        raise UsageError('no budget of matter; write budget = "0.5kg"')
    check_budget(options["budget"])
    motions = _motions(linkage, options, explain=True)
    if motions is None:
        motions = list(random_motions(linkage, 1, SAMPLES))
    limits = {name: options[name] for name in LIMITS if name in options}
    space = design_space(linkage, None, max_order=0)
    build_problem(space, options["links"], ShakingOptions(motions=motions, **limits))


def _motions(linkage: Linkage, options: Options, explain: bool) -> list[Trajectory] | None:
    """Compute the motion of the options; None for the random ones."""
    if not any(name in options for name in MOTION_OPTIONS):
        return None
    return [motion_of_options(linkage, options, STEPS, explain=explain)]
