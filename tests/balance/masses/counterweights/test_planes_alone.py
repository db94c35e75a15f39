"""Matter for forces: what a plane cuts off, by exact integrals."""

import pytest

import balance


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
