"""Reactionless paths: laws of the curve, and its table in the command that verifies."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from balance.masses.remedies.constraints.slider_path import apply_slider_path
from balance.masses.remedies.request import RemedyRequest
from tests.independent import reference


def files_of(name):
    """The remedy of a linkage, and the rows of its table."""
    linkage = kinematics.load(name)
    (found,) = apply_slider_path(RemedyRequest(linkage))
    head, *rows = found.files["path.csv"].decode().splitlines()
    assert head.split(",")[1 : 1 + linkage.mobility] == list(linkage.inputs)
    return linkage, found, np.array([[float(x) for x in row.split(",")] for row in rows])


@pytest.mark.table(1)
@pytest.mark.parametrize(("name", "choices"), [("principal_vector_linkage", 2), ("fuga_i", 1)])
def test_the_momentum_vanishes_along_the_path(name, choices):
    """By the independent route, with the velocities of the table."""
    linkage, found, table = files_of(name)
    assert found.details["choices"] == choices
    u, ud, _ = np.split(table[:, 1:], 3, axis=1)
    mechanism = reference.load(name, linkage.inputs)
    q = np.zeros(len(mechanism.joints))
    for k in np.linspace(20, len(u) - 21, 7).astype(int):
        q = reference.follow(mechanism, q, u[k])
        rates = reference.velocities(mechanism, q, ud[k][:, None])
        X = reference.regressor(mechanism, q, rates)
        parts = X.reshape(6, *mechanism.inertias.shape) * mechanism.inertias
        assert np.abs(parts.sum(axis=(1, 2))).max() < 1e-11 * np.abs(parts).sum()
        assert np.linalg.norm(ud[k]) > 1e-3


@pytest.mark.slow
def test_the_path_of_constant_inertias_is_a_straight_line():
    """1.2 u1 + 0.4 u2 + 0.1 u3 = 0 along it, the inertias of the file."""
    linkage, found, table = files_of("zero_reaction_arm")
    weights = dict(u1=1.2, u2=0.4, u3=0.1)
    row = np.array([weights[name] for name in linkage.inputs])
    assert np.abs(table[:, 1:4] @ row).max() < 1e-13
    assert np.linalg.norm(table[-1, 1:4] - table[0, 1:4]) == pytest.approx(
        found.details["length"]
    )


@pytest.mark.slow
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


@pytest.mark.slow
def test_forces_are_balanced_first():
    """The 3-RRR gets counterweights, and then one of two reactionless directions."""
    (found,) = apply_slider_path(RemedyRequest(kinematics.load("three_rrr")))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert found.added_mass > 1.0 and found.details["choices"] == 2


def test_linkages_without_a_path_are_refused():
    (one,) = apply_slider_path(RemedyRequest(kinematics.load("four_bar_general")))
    assert one.verdict == "refused" and "one freedom" in one.reason
