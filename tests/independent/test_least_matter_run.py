"""A sample of the comparisons of `tests.independent.least_matter_run`."""

import pytest

from tests.independent.least_matter_run import against_cells, searched

QUESTIONS = [(0, "mass", False), (7, "rotor", False), (17, "mass", True), (20, "inertia", True)]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "minimise", "filled"), QUESTIONS)
def test_no_random_design_is_below_the_proved_bound(seed, minimise, filled, tmp_path):
    bound, value, least = searched(seed, tmp_path / "a.urdf", minimise, filled, designs=2000)
    assert bound <= value * (1.0 + 1e-9) and bound <= least * (1.0 + 1e-8)
    assert value <= least * (1.0 + 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [17, 20])
def test_cells_bound_the_least_mass_from_both_sides(seed, tmp_path):
    _, lower, mass, upper = against_cells(seed, tmp_path / "a.urdf", 6000)
    assert lower <= mass * (1.0 + 1e-8) and mass <= upper * (1.0 + 1e-8)
