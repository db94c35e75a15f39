"""Mutants of other formats are read, refused in one line or told of: never silently open.

More of them: ``python -m tests.fuzz.fuzz_formats dialects --cases 20000``, or ``ALL_CASES=1``.
"""

import pytest

from tests.fuzz.dialect_mutants import dialect_mutant
from tests.fuzz.fuzz_formats import run
from tests.fuzz.mjcf_mutants import mjcf_mutant
from tests.fuzz.sdf_mutants import sdf_mutant
from tests.support.covering import number_of_cases

# Number of cases, and the least share of each way to end.
CASES = {
    "dialects": (number_of_cases(300, 1500), {"translated": 0.1, "refused": 0.2, "told": 0.02}),
    "mjcf": (number_of_cases(100, 300), {"read": 0.1, "refused": 0.1}),
    "sdf": (number_of_cases(100, 300), {"read": 0.1, "refused": 0.1}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_no_loop_is_lost(name):
    if name == "mjcf":
        pytest.importorskip("mujoco")
    cases, shares = CASES[name]
    counts, wrong = run(name, range(cases))
    assert not wrong, "\n".join(wrong[:20])
    assert all(counts[way] > share * cases for way, share in shares.items()), counts


@pytest.mark.table(1)
@pytest.mark.parametrize("mutant", [dialect_mutant, mjcf_mutant, sdf_mutant])
def test_a_seed_is_one_case(mutant):
    assert mutant(7) == mutant(7) != mutant(8)
