"""Matter for forces: what a plane cuts off, by exact integrals."""

import pytest

import balance
from balance.support.clarabel_adapter import solve_conic


def test_matter_for_forces_is_cut_off_by_planes(monkeypatch):
    """Conditions on forces have no second moments: no sums over rays, slow and off."""
    calls = []
    monkeypatch.setattr(
        "balance.masses.counterweights.volume.cut_regions.integrate_positive_part",
        lambda *_: calls.append(1),
    )
    links = ["crank", "rocker"]
    proved, quick = (
        balance.counterweights("four_bar_general", links, balance="force", prove=prove)
        for prove in (True, False)
    )
    assert proved.verdict == "feasible" and not calls
    assert quick.added_mass == pytest.approx(proved.added_mass, rel=1e-9)
    assert 0.0 <= quick.gap < 1e-9


@pytest.mark.parametrize(("density", "verdict"), [(7850.0, "feasible"), (150.0, "infeasible")])
def test_matter_for_forces_needs_one_conic_program(density, verdict, monkeypatch):
    """That of point masses, from whose multipliers Newton's method ends at parts or a bound."""
    programs = []

    def counted(*arguments, **options):
        programs.append(1)
        return solve_conic(*arguments, **options)

    for module in ("added_program", "volume.fill_program"):
        name = f"balance.masses.counterweights.{module}.solve_conic"
        monkeypatch.setattr(name, counted)
    links = ["crank", "rocker"]
    answer = balance.counterweights(
        "four_bar_general", links, density=density, balance="force", relax=False
    )
    assert answer.verdict == verdict and len(programs) == 1
    if verdict == "infeasible":
        assert answer.check.accepted
