"""Stephenson III linkages with similar ternary links: two assemblies, neither buildable."""

import numpy as np
import pytest

import balance
from balance.studies.discovery.buildable_walk import margins
from balance.studies.discovery.families import relations_of
from balance.studies.discovery.polish import decide_special
from balance.studies.discovery.quantities import quantities_of
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.topologies import topology
from tests.support.covering import number_of_cases
from tests.support.planted import lanes_of, planted_corners

pytestmark = pytest.mark.lanes

GRAPH = topology("stephenson3")
BOTH = [("similar ternaries", 8), ("parallel ternaries", 10)]


@pytest.mark.slow
@pytest.mark.parametrize(("family", "nullity"), BOTH)
def test_no_member_can_be_built(family, nullity):
    """Random members: their margins by the cones of walks."""
    for first in range(0, number_of_cases(50, 1000), 50):
        structure, geometry = lanes_of(GRAPH, planted_corners(family, 50, 100 + first))
        ends = decide_special(structure, geometry, 7)
        own = ends.take(np.flatnonzero(ends.nullity == nullity))
        assert len(own.nullity) >= 48
        assert not any(margins(structure, own))


@pytest.mark.parametrize(("family", "nullity"), BOTH)
def test_the_engine_agrees_with_the_poses(family, nullity):
    """Nullity from series at one pose, and a certificate that nothing can be built."""
    structure, geometry = lanes_of(GRAPH, planted_corners(family, 2, 5))
    for lane in range(2):
        space = balance.design_space(to_linkage(GRAPH, structure, geometry, lane))
        assert (space.nullity, space.serial_nullity) == (nullity, 7)
        assert balance.masses.feasible(space).verdict == "infeasible"


@pytest.mark.parametrize(("family", "nullity"), BOTH)
def test_four_relations_describe_both(family, nullity):
    """Two equal angles make the ternary links similar; the dyad follows the cranks."""
    structure, geometry = lanes_of(GRAPH, planted_corners(family, 4, 6))
    quantities = quantities_of(GRAPH)
    for _, chosen in relations_of(GRAPH, structure, geometry):
        texts = [relation.text(quantities) for relation in chosen]
        assert len(texts) == 4
        assert texts[:2] == [
            "angle DAG = angle CBE (mod 180°)",
            "angle ADG = angle BCE (mod 180°)",
        ]
        assert all("EF" in text or "FG" in text for text in texts[2:])
