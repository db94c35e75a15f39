"""Starts from a linkage of a file: its topology, its geometry, and walks from there."""

import numpy as np
import pytest

import balance
import kinematics
from balance.studies.discovery.from_linkage import from_linkage
from balance.studies.discovery.job import DiscoveryJob, geometry_of_text, text_of_geometry
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import topology
from balance.studies.discovery.walk import conditions_at
from kinematics.errors import UsageError

pytestmark = pytest.mark.lanes

# Gallery models by topology; the last two have no name.
NAMED = {
    "four_bar_kite": "four-bar",
    "slider_crank": "slider-crank",
    "six_bar_watt": "watt1",
    "six_bar_stephenson": "stephenson3",
    "four_bar_spherical": "spherical-four-bar",
    "four_bar_added_antiparallelogram": "watt2",
    "four_bar_added_slider_crank": "0-1 1-2 0-3 1-4 P0-5 2-3 4-5",
    "eight_bar": "0-1 1-2 0-3 2-4 0-5 4-6 3-7 2-3 4-5 6-7",
}


@pytest.mark.parametrize("model", [*NAMED, "rusr"])
def test_topology_and_geometry_are_those_of_the_file(model):
    """The nullity at poses of the walk is that of the engine for the file."""
    graph, geometry = from_linkage(kinematics.load(model))
    assert graph.name == NAMED.get(model, graph.name)
    structure = graph.structure()
    found = conditions_at(structure, geometry)
    nullity = int(np.sum(found.values[0] < 1e-10 * found.values[0, 0]))
    space = balance.design_space(kinematics.load(model, bodies="all"))
    assert found.usable.all() and nullity == space.nullity


@pytest.mark.parametrize("name", ["watt2", "stephenson1", "slider-crank", "spherical-four-bar"])
def test_a_linkage_from_a_geometry_gives_it_back(name):
    """Up to the order of joints: the same products of positions, and of axes."""
    job = DiscoveryJob(name, 1, 5)
    own = job.start(range(1))
    linkage = to_linkage(job.topology, job.structure, own)
    graph, again = from_linkage(linkage)
    assert graph.name == name
    if not job.structure.sliding.any():
        between = [np.sort((g.points[0] @ g.points[0].T).ravel()) for g in (own, again)]
        assert np.allclose(*between, atol=1e-9)
    angles = [np.sort(np.abs(g.axes[0] @ g.axes[0].T).ravel()) for g in (own, again)]
    assert np.allclose(*angles)


@pytest.mark.slow
def test_a_special_model_is_its_own_first_find():
    graph, geometry = from_linkage(kinematics.load("four_bar_kite"))
    job = DiscoveryJob(graph.name, 20, 1, origin=text_of_geometry(geometry))
    assert DiscoveryJob.from_description(job.description) == job
    rows = job.compute(0)
    assert rows["outcome"][0] == "special" and rows["nullity"][0] == 5
    found = geometry_of_text(rows["geometry"][0])
    assert np.abs(found.points - geometry.points).max() < 0.9
    assert rows["outcome"].count("special") >= 4


@pytest.mark.parametrize(
    "model", ["hprs", "bennett", "delta", "double_pendulum_counter_rotary"]
)
def test_what_no_walk_can_start_from_is_refused(model):
    with pytest.raises(UsageError, match="follow|neither|connected|more than"):
        from_linkage(kinematics.load(model))


@pytest.mark.parametrize(
    "text",
    [
        "0-1 1-2 x2-3",
        "0-1 1-1",
        "0-1 1-2 S2-3 0-3",
        "0-1 2-3",
        "0-1 0-1",
        "0-1 1-2 0-2",
        "0-1 1-99",
        "sphere: 0-1 P1-2 2-3 0-3",
        "0-1",
        "0-1 1-2",
        "space: S0-1 1-2",
        f"0-1 1-2 2-{'9' * 5000}",
    ],
)
def test_lists_that_are_no_topologies_are_refused(text):
    with pytest.raises(UsageError):
        topology(text).structure()


@pytest.mark.slow
def test_an_eight_bar_from_a_list_of_edges():
    name = "0-1 1-2 2-3 0-3 2-4 4-5 0-5 1-6 6-7 3-7"
    job = DiscoveryJob(name, 2, 1)
    assert job.structure.width == 1 and job.generic == 10
    assert len(job.compute(0)["outcome"]) == 2
