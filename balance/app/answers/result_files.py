"""Pages and pictures of results, for their methods ``to_html`` and ``plot``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.motion.verification.result import Verification
    from balance.studies.runs.results_file import ResultsFile
    from balance.studies.sweeps.sweep_table import SweepTable


def make_result_file(result: Any, kind: str, **options: Any) -> bytes:
    """Make a page or a picture of a result.

    Args:
        kind: ``"html"``, ``"png"`` or ``"svg"``.
        options: of the picture: the columns of a sweep.

    Raises:
        UsageError: the result has none: there is no design.
    """
    shown = result.designs[-1] if hasattr(result, "designs") else result
    if getattr(shown, "z", shown) is None:
        raise UsageError(f"{shown.space.linkage.name}: nothing to show: {shown.words}")
    if kind == "html":
        return _page(result).encode()
    return _picture(result, kind, **options)


def _page(result: Any) -> str:
    """Make the page of a result."""
    match type(result).__name__:
        case "DesignSpace" | "CertifiedSpace" | "RequiredSpace":
            from balance.app.answers.data import Report
            from balance.app.answers.html.report import report_page

            return report_page(Report(result))
        case "Design":
            from balance.app.answers.html.design import design_page

            return design_page(result)
        case "Counterweights":
            from balance.app.answers.html.counterweights import counterweights_page

            return counterweights_page(result)
        case "ParetoFront":
            from balance.app.answers.html.counterweights import partial_page

            return partial_page(result)
        case "PartialBalance":
            from balance.app.answers.html.counterweights import partial_page

            return partial_page(result.front)
        case "Verification":
            from balance.app.answers.html.verification_page import verification_page

            return verification_page([result])
        case "RemedyComparison":
            from balance.app.answers.html.remedies import remedies_page

            return remedies_page(result)
        case "ReactionlessPaths":
            from balance.app.answers.html.paths import paths_page

            return paths_page(result)
        case "Synthesis":
            from balance.app.answers.html.synthesis import synthesis_page

            return synthesis_page(result)
        case "FloatingBaseMotion":
            from balance.app.answers.html.floating_base import floating_base_page

            return floating_base_page([result])
        case "FlexibleSimulation":
            from balance.app.answers.html.flexible import flexible_page

            return flexible_page(result.flexible, result.motion)
        case "SweepTable":
            from balance.app.answers.html.sweep import sweep_page

            with _rows_of(result) as rows:
                return sweep_page(rows)
        case name:
            raise TypeError(f"{name} has no page")


def _rows_of(table: SweepTable) -> ResultsFile:
    """Give the rows of a sweep to what shows those of a file."""
    from balance.studies.runs.results_file import ResultsFile

    return ResultsFile.in_memory(table.source, table.job, table.columns)


def _picture(result: Any, kind: str, **options: Any) -> bytes:
    """Draw a result: of new masses, the loads before and after."""
    match type(result).__name__:
        case "Identification":
            from balance.app.answers.html.identification import identification_picture

            return identification_picture(result, kind)
        case "ParetoFront":
            from balance.app.answers.html.partial import front_picture

            return front_picture(result, kind)
        case "RemedyComparison":
            from balance.app.answers.html.remedies import remedies_picture

            return remedies_picture(result, kind)
        case "ReactionlessPaths":
            from balance.app.answers.html.paths import paths_picture

            return paths_picture(result, kind)
        case "QuietMotion":
            from balance.app.answers.html.quiet import quiet_picture

            return quiet_picture(result, kind)
        case "SpringBalance":
            from balance.app.answers.html.springs import springs_picture

            return springs_picture(result, kind)
        case "Synthesis":
            from balance.app.answers.html.synthesis import synthesis_picture

            return synthesis_picture(result, kind)
        case "FloatingBaseMotion":
            from balance.app.answers.html.floating_base import floating_base_picture

            return floating_base_picture([result], kind)
        case "FlexibleSimulation":
            from balance.app.answers.html.flexible_pictures import shaking_picture

            return shaking_picture(result.motion, result.flexible.point, kind)
        case "SweepTable":
            from balance.app.answers.html.sweep_plot import default_columns, sweep_picture

            with _rows_of(result) as rows:
                return sweep_picture(rows, options["columns"] or default_columns(rows), kind)
    from balance.app.answers.html.verification import verification_picture

    return verification_picture(_verifications(result), kind)


def _verifications(result: Any) -> tuple[Verification, ...]:
    """List the verifications to draw side by side."""
    from balance.motion.verification.before_after import compare_masses

    match type(result).__name__:
        case "Verification":
            return (result,)
        case "Counterweights" if result.along is not None:
            return tuple(result.along.pair)
        case "PartialBalance":
            from balance.masses.partial.loads_along import loads_of

            return loads_of(result).pair
    space = result.space
    return compare_masses(
        space.linkage, result.z, motion=space.motion, balance=space.balance
    ).pair
