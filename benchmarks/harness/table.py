"""Targets of the benchmarks: result of a run, limit and aim of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Verdict(NamedTuple):
    """The result of a claim.

    Attributes:
        value: ratio of two times, or a tracked value.
        limit: its largest admissible value.
    """

    value: float
    limit: float

    @property
    def holds(self) -> bool:
        """Whether the claim holds."""
        return self.value <= self.limit


class Line(NamedTuple):
    """One target.

    Attributes:
        job: the job.
        against: the peer.
        claims: ``module:case: methods`` of its claims, all with one limit.
        aim: value that each of them should reach in the end.
    """

    job: str
    against: str
    claims: tuple[str, ...]
    aim: float


def _of(module: str, cases: tuple[str, ...], methods: str) -> tuple[str, ...]:
    return tuple(f"{module}:{case}: {methods}" for case in cases)


TAYLOR, SPACES, COST = (
    "taylor_five_bar_and_6r",
    "design_space_against_sampling",
    "cost_grows_linearly",
)
FOUR = ("four_bar_general", "five_bar", "three_rsr", "four_rrr")
KERNELS = (
    "four_bar_general 4 64",
    "five_bar 4 32",
    "bennett 4 32",
    "three_rsr 2 12",
    "stewart_6ups 2 8",
)
MANY = ("four_bar_general any", "four_bar_kite kites")
MANY_POSES = "time_all_poses/time_heyoka_at_each"
HEYOKA, DESIGN_SPACES = "time_ours/time_heyoka", "design spaces of 4R, 5R, 3-RSR, 4-RRR"

LINES = (
    Line("five-bar IK, order 10, all coefficients", "heyoka, batched jets",
         _of(TAYLOR, ("five_bar 10",), HEYOKA), 1.0),
    Line("the same, orders 5 and 7", "heyoka",
         _of(TAYLOR, ("five_bar 5", "five_bar 7"), HEYOKA), 1.0),
    Line("6R along a line, order 10", "heyoka, geometry at run time",
         _of(TAYLOR, ("six_r 10",), HEYOKA), 1.0),
    Line("five-bar IK, order 10, 1000 poses in one call", "heyoka, batched jets",
         _of(TAYLOR, ("five_bar 10",), MANY_POSES), 0.8),
    Line("6R along a line, order 10, 1000 poses", "heyoka, geometry at run time",
         _of(TAYLOR, ("six_r 10",), MANY_POSES), 0.8),
    Line("five-bar, order 10", "daceypy",
         _of(TAYLOR, ("five_bar 10",), "time_ours/time_daceypy"), 1 / 90),
    Line("five-bar, order 10", "Kronecker tensors, NumPy",
         _of(TAYLOR, ("five_bar 10",), "time_ours/time_kronecker"), 1 / 20000),
    Line("five-bar, order 7, first call in a process", "heyoka without disk cache",
         _of(TAYLOR, ("five_bar 7",), "track_ours/track_heyoka"), 1 / 3),
    Line("error of a coefficient, order 10, five-bar", "mpmath",
         _of(TAYLOR, ("five_bar 10",), "track_error"), 5e-15),
    Line("error of a coefficient, order 10, 6R", "mpmath",
         _of(TAYLOR, ("six_r 10",), "track_error"), 5e-15),
    Line(DESIGN_SPACES, "sampling with Pinocchio", _of(SPACES, FOUR, "time_ours/time_sampling"),
         1 / 50),
    Line(f"{DESIGN_SPACES}: wrong ranks", "exact arithmetic",
         _of(SPACES, FOUR, "track_wrong_ranks"), 0.0),
    Line("momentum kernel", "the same arithmetic in C",
         _of("close_to_the_limit", KERNELS, "time_ours/time_in_c"), 1.2),
    Line("exponent in bodies, 50 to 800: serial chain", "itself",
         _of(COST, ("serial",), "track_exponent_in_bodies"), 1.05),
    Line("exponent in bodies, 50 to 800: coupled four-bars", "itself",
         _of(COST, ("four-bars",), "track_exponent_in_bodies"), 1.15),
    Line("exponent in order, both", "itself",
         _of(COST, ("serial", "four-bars"), "track_exponent_in_order"), 2.1),
    Line("many four-bar design spaces, one core", "kernel alone in C",
         _of("many_geometries", MANY, "time_one_core/time_kernels_in_c"), 2.5),
    Line("the same, two cores", "one core",
         _of("many_geometries", MANY, "time_two_cores/time_one_core"), 1 / 1.9),
)  # fmt: skip


def modules() -> list[str]:
    """The benchmarks with the claims of the targets."""
    return sorted({claim.split(":")[0] for line in LINES for claim in line.claims})


def answered(found: Mapping[str, Verdict]) -> list[tuple[str, dict[str, str]]]:
    """Make a row for each target whose claims were all tested.

    Args:
        found: verdicts by ``module:case: methods``.
    """
    rows = []
    for line in LINES:
        verdicts = [found[claim] for claim in line.claims if claim in found]
        if len(verdicts) < len(line.claims):
            continue
        limit, held = verdicts[0].limit, all(verdict.holds for verdict in verdicts)
        aimed = ", and the aim" if all(v.value <= line.aim for v in verdicts) else ""
        row = {
            "against": line.against,
            "ours": ", ".join(_number(verdict.value, limit) for verdict in verdicts),
            "must": _number(limit, limit),
            "aim": _number(line.aim, limit),
            "verdict": f"holds{aimed}" if held else "DOES NOT HOLD",
        }
        rows.append((line.job, row))
    return rows


def _number(value: float, limit: float) -> str:
    """Format a value like its limit: as a number, in powers of ten, or as a fraction."""
    if value <= 0.0 or limit >= 1.0:
        return f"{value:.3g}"
    if limit < 1e-7:
        return f"{value:.1e}"
    return f"1/{1.0 / value:.1f}" if value > 0.1 else f"1/{1.0 / value:.0f}"
