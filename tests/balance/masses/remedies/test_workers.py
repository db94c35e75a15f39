"""Remedies in several processes: the same answers in the same order, and what goes wrong."""

from __future__ import annotations

import os
from functools import partial

import numpy as np
import pytest

from balance.masses.remedies import compare
from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.request import RemedyRequest
from balance.support import processes
from balance.support.processes import map_in_processes
from kinematics.errors import PoseError, WorkerError
from kinematics.loading.model_gallery import as_linkage, load
from kinematics.model.document.element import Document

NAMES = (
    "own_masses",
    "duplicates",
    "constant_speed_dyad",
    "balance_shafts",
    "harmonic_springs",
)


def assert_same(first, second):
    """Plain data with the same words, and numbers to the last digits of a few."""
    assert type(first) is type(second), (first, second)
    if isinstance(first, dict):
        assert list(first) == list(second)
        # Certificates are not unique: other kernels, or threads, lead to others.
        first, second = ({**each, "proof": None} for each in (first, second))
        first, second = list(first.values()), list(second.values())
    if isinstance(first, list):
        assert len(first) == len(second)
        for one_value, other in zip(first, second, strict=True):
            assert_same(one_value, other)
    elif isinstance(first, float):
        np.testing.assert_allclose(first, second, rtol=1e-6, atol=1e-9)
    else:
        assert first == second


def bodies_of(applied):
    return load(Document("remedy.urdf", applied.urdf)).bodies


@pytest.mark.slow
def test_two_processes_give_what_one_gives():
    """Results, their order and that of their reports, files, and steps up to the last."""
    answers = []
    for workers in (1, 2):
        steps, told = [], []
        request = RemedyRequest(
            as_linkage("four_bar_general"), progress=lambda *step, kept=steps: kept.append(step)
        )
        comparison = compare_request(request, NAMES, told.append, workers)
        assert tuple(told) == comparison.results
        assert not steps or steps[-1] == (len(NAMES), len(NAMES))
        answers.append(comparison)
    alone, shared = answers
    assert_same(alone.to_dict(), shared.to_dict())
    masses = [
        [body.inertia for each in answer.results if each.urdf for body in bodies_of(each)]
        for answer in answers
    ]
    np.testing.assert_allclose(*masses, rtol=1e-6, atol=1e-9)


def test_what_a_process_refuses_is_raised_here(monkeypatch):
    """With the error itself, which need not be one that can be pickled."""
    request = RemedyRequest(as_linkage("five_bar"))

    def refuse(name, request):
        raise PoseError(f"{name} of {request.linkage.name}")

    monkeypatch.setattr(compare, "_apply", refuse)
    monkeypatch.setattr(
        processes,
        "map_in_processes",
        lambda work, names, _, begin: (begin(), map(work, names))[1],
    )
    with pytest.raises(PoseError, match="slider_path of five_bar"):
        compare.compare_request(request, ("balance_shafts", "slider_path"), workers=2)


@pytest.mark.slow
def test_a_process_that_dies_is_an_error_in_words():
    with pytest.raises(WorkerError, match="ended before its work did"):
        list(map_in_processes(os._exit, [3, 3], 2))


@pytest.mark.slow
def test_processes_keep_the_order_and_have_the_settings_of_this_one(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    assert list(map_in_processes(partial(pow, 3), range(5), 2)) == [1, 3, 9, 27, 81]
    for workers in (1, 2):
        assert list(map_in_processes(os.getenv, ["OPENBLAS_NUM_THREADS"], workers)) == ["3"]
