"""Verdicts name a few links, and count the others."""

from types import SimpleNamespace

import numpy as np
import pytest

from balance.app.answers.text.design import other_ways
from balance.masses.designs.constraints import Constraints
from balance.masses.designs.verdicts import describe_conflict


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (1, "of l0 are zero"),
        (3, "of l0, l1 and l2 add up"),
        (7, "l4, l5 and l6 add up"),
        (25, "of l0, l1, l2, l3, l4, l5 and 19 others add up to zero"),
    ],
)
def test_a_verdict_names_few_links(count, words):
    space = SimpleNamespace(bodies=tuple(f"l{k}" for k in range(count)), balance="dynamic")
    assert words in describe_conflict(space, np.ones((count, 3, 3)), Constraints())


@pytest.mark.parametrize(
    ("second", "words"),
    [(1e-14, "the masses of l0 and l1"), (0.5, "some second moments of l0")],
)
def test_weights_of_first_moments_alone_are_those_of_masses(second, words):
    """A positive matrix has entries of s beside 1 where its second moments have s²."""
    Z = np.array([[[second, 1e-7], [1e-7, 1.0]]] * 2)
    space = SimpleNamespace(bodies=("l0", "l1"), balance="force")
    assert words in describe_conflict(space, Z, Constraints())


def test_partial_balance_is_advised_with_the_budget_that_it_needs():
    facts = dict(other_ways("dynamic"))
    assert facts["reduce"] == "balance reduce MODEL --links LINKS --budget KG"
    assert "--balance force" in facts["other ways"]
    assert "--balance force" not in dict(other_ways("force"))["other ways"]
