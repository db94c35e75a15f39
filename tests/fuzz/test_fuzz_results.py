"""Damaged files of results, changed studies and random topologies: no request crashes.

More of them: ``python -m tests.fuzz.fuzz_results --cases 50000``, or ``ALL_CASES=1``.
"""

import pytest

from tests.fuzz.fuzz_results import run, words_of
from tests.support.covering import number_of_cases

pytestmark = pytest.mark.lanes

CASES = number_of_cases(40, 3000)


@pytest.mark.slow
def test_no_damaged_file_and_no_study_crashes():
    ends = list(run(range(CASES)))
    assert not [wrong for _, _, wrong in ends if wrong]
    verbs = {end.partition(":")[0] for _, end, _ in ends}
    assert {"sweep show", "sweep run", "discover show", "discover walk"} <= verbs
    assert {end[-1] for _, end, _ in ends} >= {"0", "2", "3"}


def test_a_seed_is_one_case(tmp_path):
    assert words_of(7, tmp_path) == words_of(7, tmp_path) != words_of(8, tmp_path)
