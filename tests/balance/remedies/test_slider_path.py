"""Reactionless paths: laws of the curve, and its table in the command that verifies."""

from __future__ import annotations

import numpy as np
import pytest
import reference

import kinematics
from balance.cli.main import main
from balance.remedies.constraints.reactionless_path import reactionless_path
from balance.remedies.constraints.slider_path import apply_slider_path
from balance.remedies.request import RemedyRequest
from kinematics import Motion


def path_of(name, relations=()):
    linkage = kinematics.load(name)
    return linkage, reactionless_path(linkage, Motion.parse(relations, linkage.inputs))


@pytest.mark.parametrize(("name", "choices"), [("principal_vector_linkage", 2), ("fuga_i", 1)])
def test_the_momentum_vanishes_along_the_path(name, choices):
    """By the independent route, with the rates of the path; and ends are where rates lead."""
    linkage, path = path_of(name)
    assert path.choices == choices
    mechanism = reference.load(name, linkage.inputs)
    q = np.zeros(len(mechanism.joints))
    for k in np.linspace(0, len(path.length) - 1, 7).astype(int):
        q = reference.follow(mechanism, q, path.u[k])
        rates = reference.velocities(mechanism, q, path.rates[k][:, None])
        X = reference.regressor(mechanism, q, rates)
        parts = X.reshape(6, *mechanism.inertias.shape) * mechanism.inertias
        assert np.abs(parts.sum(axis=(1, 2))).max() < 1e-12 * np.abs(parts).sum()
        assert np.linalg.norm(path.rates[k]) == pytest.approx(1.0)
    assert np.abs(path.u).sum(axis=1).min() == 0.0
    h = path.length[1]
    # Fourth-order differences of u and of its rates.
    for x, slope in ((path.u, path.rates), (path.rates, path.bends)):
        near = (x[3:-1] - x[1:-3]) * 8.0 - (x[4:] - x[:-4])
        assert np.abs(near / (12.0 * h) - slope[2:-2]).max() < 1e-5


def test_the_path_of_constant_inertias_is_a_straight_line():
    """1.2 u1 + 0.4 u2 + 0.1 u3 = 0 along it, the inertias of the file."""
    linkage, path = path_of("zero_reaction_arm")
    weights = dict(u1=1.2, u2=0.4, u3=0.1)
    row = np.array([weights[name] for name in linkage.inputs])
    assert np.abs(path.u @ row).max() < 1e-13
    assert np.abs(path.bends).max() < 1e-9
    assert path.length[-1] == pytest.approx(1.0)


def test_the_table_passes_verify(tmp_path, capsys):
    """``balance verify --csv`` confirms the table of the zero-reaction arm."""
    linkage = kinematics.load("zero_reaction_arm")
    (found,) = apply_slider_path(RemedyRequest(linkage))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert found.lost_freedoms == 2 and abs(found.added_mass) < 1e-12
    table = tmp_path / "path.csv"
    table.write_bytes(found.files["path.csv"])
    assert main(["verify", "zero_reaction_arm", "--csv", str(table)]) == 0
    assert main(["verify", "zero_reaction_arm", "--trajectories", "1"]) == 1


def test_forces_are_balanced_first():
    """The 3-RRR gets counterweights, and then one of two reactionless directions."""
    (found,) = apply_slider_path(RemedyRequest(kinematics.load("three_rrr")))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert found.added_mass > 1.0 and found.details["choices"] == 2


def test_linkages_without_a_path_are_refused():
    (one,) = apply_slider_path(RemedyRequest(kinematics.load("four_bar_general")))
    assert one.verdict == "refused" and "one freedom" in one.reason
    linkage = kinematics.load("five_bar")
    assert reactionless_path(linkage, Motion.free(linkage.inputs)) is None
