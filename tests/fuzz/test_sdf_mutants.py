"""Mutants of SDF files are read, or refused in one line."""

from sdf_mutants import run, sdf_mutant

CASES = 300


def test_mutants_are_read_or_refused(tmp_path):
    counts = run(range(CASES), tmp_path)
    assert set(counts) == {"read", "refused"}, counts
    assert min(counts.values()) > 0.1 * CASES


def test_a_seed_is_one_case():
    assert sdf_mutant(7) == sdf_mutant(7) != sdf_mutant(8)
