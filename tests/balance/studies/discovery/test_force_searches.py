"""Searches for geometries whose forces balance with more masses than those of most others."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.motion.verification.verify_motions import verify
from balance.studies.discovery.confirm import confirm
from balance.studies.discovery.export import export_member
from balance.studies.discovery.families import group_members
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.lane_motion import (
    follow_curves,
    lane_momentum_rows,
    momentum_rates,
)
from balance.studies.discovery.search_results import examine
from balance.studies.discovery.to_linkage import to_linkage
from kinematics.model.document.element import Document
from tests.support.json_answers import json_answer
from tests.support.search_ends import special_ends

pytestmark = pytest.mark.lanes
PARALLELOGRAM = {"AD = BC", "AB = CD"}


def test_rows_are_the_linear_momenta():
    """Of all rows of the momentum, in the plane and in space, and so are their derivatives."""
    for name, first in (("four-bar", 1), ("r-u-s-r", 3)):
        whole, forces = DiscoveryJob(name, 2), DiscoveryJob(name, 2, require="force")
        geometry = whole.start(range(2))
        poses = follow_curves(whole.structure, geometry, 0.3, 2)
        dim, columns = whole.structure.algebra.dim, whole.structure.unknowns
        expected = lane_momentum_rows(whole.structure, poses).reshape(2, -1, dim, columns)
        rows = lane_momentum_rows(forces.structure, poses)
        assert np.array_equal(rows, expected[:, :, first:].reshape(2, -1, columns))
        z = np.random.default_rng(3).standard_normal((2, 1, columns))
        changes = momentum_rates(whole.structure, geometry, poses, z)
        changes = changes.reshape(2, 1, -1, dim, changes.shape[-1])[:, :, :, first:]
        rates = momentum_rates(forces.structure, geometry, poses, z)
        assert np.array_equal(rates, changes.reshape(rates.shape))


@pytest.mark.parametrize(
    "name",
    ["four-bar", *(pytest.param(x, marks=pytest.mark.slow) for x in ("watt2", "r-u-s-r"))],
)
def test_most_geometries_have_the_nullity_of_their_design_space(name):
    """By the design space of a linkage, which counts masses and first moments alone."""
    job = DiscoveryJob(name, 3, require="force")
    geometry = job.start(range(3))
    linkage = to_linkage(job.topology, job.structure, geometry, 1)
    space = balance.design_space(linkage, balance="force")
    assert space.nullity == job.generic - job.structure.uncounted


@pytest.fixture(scope="module")
def found():
    """The families of fifty four-bars."""
    job = DiscoveryJob("four-bar", 50, require="force")
    rows = job.compute(0)
    ends = special_ends(rows)
    return job, group_members(job.topology, job.structure, job.generic, ends)


@pytest.mark.slow
def test_the_parallelogram_alone_is_special_for_forces(found):
    """``Σ mc`` has terms along crank, coupler and rocker, which the loop joins by one relation:
    in the parallelogram alone two of them are alike, and one is still.
    """
    job, families = found
    (family,) = families
    assert set(family.relations) == PARALLELOGRAM
    assert (family.nullity - job.structure.uncounted, family.parallel) == (7, 2)
    assert family.codimension == 2
    answer = confirm(job.structure, family, 20)
    assert (answer.members, answer.agreed) == (20, 20)
    for lane in range(3):
        linkage = to_linkage(job.topology, job.structure, answer.geometry, lane)
        assert balance.design_space(linkage, balance="force").nullity == 7
    for kite in ("four_bar_kite", "four_bar_antiparallelogram", "four_bar_general"):
        assert balance.design_space(kite, balance="force").nullity == 5


@pytest.mark.slow
def test_a_member_with_masses_leaves_no_force(found):
    job, (family,) = found
    examined = examine(job, family, members=5, tried=2)
    assert examined.verdicts == {"feasible": 2}
    member = export_member(job, family)
    assert member.balanced and member.space.balance == "force"
    written = kinematics.load(Document("the member", member.urdf))
    again = verify(written, balance="force", trajectories=3, seed=9)
    assert again.balanced


def test_a_file_of_a_search_keeps_what_is_required():
    job = DiscoveryJob("four-bar", 5, require="force")
    again = DiscoveryJob.from_description(job.description)
    assert again == job and again.digest == job.digest
    plain = DiscoveryJob("four-bar", 5)
    assert "require" not in plain.description and plain.digest != job.digest
    assert DiscoveryJob.from_description(plain.description).require == "dynamic"


@pytest.mark.slow
def test_the_command_says_what_is_required(capsys, tmp_path):
    path = str(tmp_path / "search.db")
    words = ("discover", "run", "--topology", "four-bar", "--starts", "50", "--workers", "0")
    code, answer = json_answer(capsys, *words, "--require", "force", "--out", path)
    assert code == 0 and answer["require"] == "force" and answer["nullity"] == 5
    assert [entry["nullity"] for entry in answer["families"]] == [7]
    assert main(["discover", "show", path, "--members", "4", "--tried", "1"]) == 0
    assert "force balance; nullity counts masses" in capsys.readouterr().out


def test_what_is_no_requirement_is_refused(capsys):
    assert main(["discover", "run", "--topology", "four-bar", "--require", "balance"]) == 2
    assert "cannot be read" in capsys.readouterr().err
