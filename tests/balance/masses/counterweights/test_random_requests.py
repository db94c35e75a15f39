"""Counterweights: random requests against cvxpy, and the files of the feasible ones."""

import pytest

from tests.independent.counterweight_files import check_exports
from tests.independent.second_counterweights import compare


@pytest.mark.table(3)
@pytest.mark.parametrize("seed", range(10))
def test_random_requests_agree_with_cvxpy(seed, tmp_path):
    """A sample of ``python -m tests.independent.second_counterweights``."""
    assert compare(seed, tmp_path) == ""


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", [0, 1, 3, 7, 8, 9])
def test_random_requests_of_dynamic_balance_agree_with_cvxpy(seed, tmp_path):
    """A sample of the same with ``--balance dynamic``."""
    assert compare(seed, tmp_path, "dynamic") == ""


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("balanced", ["force", "dynamic"])
def test_files_of_feasible_random_requests_are_balanced(balanced, tmp_path):
    """A sample of ``python -m tests.independent.counterweight_files``."""
    assert check_exports(range(4), tmp_path, balanced) == 0
