"""Ranges about the values of a model in which a study without an answer has answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.ranges import SAMPLED, Range, read_range
from balance.studies.sweeps.study_data import StudyData
from kinematics.wording import number_text

# Half widths of ranges over the value in the middle.
SHARES = (0.1, 0.03, 0.01)
# Most parameters whose ends are combined.
MOST_VARIED = 3


def answered_ranges(job: SweepJob) -> dict[str, str]:
    """Find ranges about the values of the model whose ends have all answers of a study.

    Only ranges that the model is outside of are moved, or all of them where that is not enough.
    All combinations of the ends are computed, and of those of the ranges that stay.

    Args:
        job: the job of a study; of grids and lists, three at most.

    Returns:
        The ranges that are moved, by path, as a study writes them, with as many values as
        before; empty if these ends have no answers, or the model has none itself.
    """
    study = StudyData.from_text(job.description)
    given, values = study.parameters, job.values_in_model()
    if len(given) > MOST_VARIED or any(each.kind in SAMPLED for each in given.values()):
        return {}
    kept = {name: _ends(each) for name, each in given.items()}
    if not _have_answers(study, kept | {name: [value] for name, value in values.items()}):
        return {}
    outside = [x for x in values if not min(kept[x]) <= values[x] <= max(kept[x])]
    choices = [outside] * (0 < len(outside) < len(values)) + [[*values]]
    for names, share in ((names, share) for names in choices for share in SHARES):
        texts = {x: _range_text(values[x], share, given[x]) for x in names}
        moved = {x: _ends(read_range(text)) for x, text in texts.items()}
        if _have_answers(study, kept | moved):
            return texts
    return {}


def _ends(each: Range) -> list[float]:
    """List the ends of a grid, or those of a list."""
    numbers = each.numbers[:2] if each.kind == "grid" else each.numbers
    return sorted({min(numbers), max(numbers)})


def _range_text(value: float, share: float, given: Range) -> str:
    """Write a range about a value; about 0, of a width that the given one decides."""
    if given.count == 1:
        return number_text(value, ".6g")
    half = share * (abs(value) or max(map(abs, _ends(given))))
    first, last = (number_text(x, ".3g") for x in (value - half, value + half))
    return f"{first}:{last}:{given.count}"


def _have_answers(study: StudyData, values: Mapping[str, list[float]]) -> bool:
    """Whether all combinations of values have all answers of a study."""
    ranges = {name: Range("list", tuple(values[name])) for name in study.parameters}
    job = SweepJob.of_study(replace(study, parameters=ranges, chunk_rows=1))
    return not any(job.compute(row)["reason"][0] for row in range(job.rows))
