"""Searches for geometries with more masses that meet several requirements.

The second route is that of `tests/independent/reference.py`, in the frame of the ground and
with the joints named as inputs: regressors at finite poses of the linkage of a geometry.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from scipy.linalg import qr

from balance.app.cli.main import main
from balance.studies.discovery.export import export_member
from balance.studies.discovery.families import group_members
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.lane_regions import lane_condition_rates, lane_condition_rows
from balance.studies.discovery.search_results import examine
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.discovery.walk import conditions_at
from tests.independent.reference import decide, load
from tests.support.json_answers import json_answer
from tests.support.required_rows import parameters, region_of, rows_of
from tests.support.search_ends import special_ends

pytestmark = pytest.mark.lanes
FIVE_BAR, SLIDER_CRANK = "0-1 0-4 1-2 2-3 3-4", "0-1 P0-3 1-2 2-3"
GRAVITY = (0.3, -1.0, 0.0)
# Displacements of the inputs of the second route: random geometries have dead points near by.
REACH = 0.2
CASES = [
    ("four-bar", "force; dynamic at A=0.2"),
    ("four-bar", "force x"),
    ("four-bar", "moment about 0.5,0.2,0"),
    ("four-bar", "gravity"),
    ("four-bar", "dynamic at A=0; dynamic at A=0.3"),
    ("four-bar", "dynamic at A=0.1; force; moment about com"),
    (SLIDER_CRANK, "force y; moment"),
    (FIVE_BAR, "dynamic along B=-1*A"),
    (FIVE_BAR, "force; dynamic along B=-1*A"),
    (FIVE_BAR, "force; dynamic at A=0.1,B=-0.1"),
    (FIVE_BAR, "dynamic along B=A**2; gravity"),
    (FIVE_BAR, "moment about 1,0,0 along B=A; force x"),
    ("watt2", "gravity"),
    ("watt2", "force; dynamic at A=0.1"),
    ("stephenson3", "force y; dynamic at A=0.1"),
    ("spherical-four-bar", "dynamic at A=0.1; dynamic at A=-0.1"),
]
# Topology, requirements, number of walks, and what the relations of the families are.
KITES = [{"AD = AB", "BC = CD"}, {"AD = CD", "AB = BC"}]
PARALLELOGRAM = {"AD = BC", "AB = CD"}
SEARCHES = [
    (SLIDER_CRANK, "force x", 50, [{"offset of D from A = 0", "AC = CD"}]),
    ("four-bar", "gravity", 50, [PARALLELOGRAM]),
    ("four-bar", "moment", 100, [PARALLELOGRAM, *KITES]),
    ("four-bar", "force; dynamic at A=0.2", 50, [PARALLELOGRAM]),
    ("four-bar", "dynamic at A=0; dynamic at A=0.3; dynamic at A=-0.3", 50, None),
    (FIVE_BAR, "force; dynamic along B=-1*A", 50, None),
]


def fastest_in_tree(linkage):
    """Names of joints of the tree that drive a linkage, the best conditioned ones."""
    chain = linkage.chain
    tree = [k for k, j in enumerate(chain.joints) if not linkage.joints[j].in_loop]
    order = qr(chain.columns[tree].T, pivoting=True)[2]
    return [linkage.joints[chain.joints[tree[k]]].name for k in order[: linkage.mobility]]


def nullity_at_finite_poses(job, geometry, lane, path):
    """Dimension of the null space of regressors, in the parameters that count.

    None where an input meets a dead point on the way.
    """
    linkage = to_linkage(job.topology, job.structure, geometry, lane)
    names = list(linkage.inputs)
    path.write_text(linkage.to_urdf())
    if any(joint.in_loop and joint.name in names for joint in linkage.joints):
        # The reader of the tests has no coordinates of joints that close loops.
        names = fastest_in_tree(linkage)
    mechanism = load(path, names)
    spatial = not linkage.planar
    columns = parameters(mechanism, spatial, job.structure.force)
    g, texts = np.array(job.gravity), job.require.replace(" about com", "").split("; ")
    try:
        blocks = [
            rows_of(mechanism, *region_of(text, names), spatial, g, seed, REACH)
            for seed, text in enumerate(texts)
        ]
    except ValueError as error:
        assert "cannot follow the branch" in str(error)
        return None
    decision = decide(np.concatenate(blocks)[:, columns])
    assert decision.dropped < 1e-3 * decision.kept
    return len(columns) - decision.rank


def search(name, text, count):
    """The job, and the families that its walks end on."""
    job = DiscoveryJob(name, count, require=text, gravity=GRAVITY)
    ends = special_ends(job.rows_of(range(count)))
    return job, group_members(job.topology, job.structure, job.generic, ends)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        case if k % 5 == 0 else pytest.param(*case, marks=pytest.mark.slow)
        for k, case in enumerate(CASES)
    ],
)
def test_most_geometries_have_the_nullity_at_finite_poses(name, text, tmp_path):
    job = DiscoveryJob(name, 12, require=text, gravity=GRAVITY)
    geometry, path = job.start(range(12)), tmp_path / "member.urdf"
    usable = np.flatnonzero(conditions_at(job.structure, geometry).usable).tolist()
    ways = (nullity_at_finite_poses(job, geometry, lane, path) for lane in usable)
    nullities = list(islice((x for x in ways if x is not None), 2))
    assert nullities == 2 * [job.generic - job.structure.uncounted]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "text", "count", "families"), SEARCHES)
def test_special_geometries_have_theirs_at_finite_poses(name, text, count, families, tmp_path):
    job, found = search(name, text, count)
    decided = 0
    for family in found:
        for member in family.members[:2]:
            nullity = nullity_at_finite_poses(job, member.geometry, 0, tmp_path / "member.urdf")
            assert nullity in (None, family.nullity - job.structure.uncounted)
            decided += nullity is not None
        assert family.nullity > job.generic
    assert decided
    if families is not None:
        assert sorted(map(sorted, families)) == sorted(
            sorted(family.relations) for family in found
        )


@pytest.mark.slow
def test_members_of_a_family_have_its_space():
    """Decided by the intersection of spaces, and the masses of an exported one by it, too."""
    job, (family,) = search("slider-crank", "force x", 50)
    examined = examine(job, family, members=20, tried=3)
    assert (examined.confirmation.members, examined.confirmation.agreed) == (20, 20)
    member = export_member(job, family)
    assert member.design.verdict == "feasible" and member.balanced
    assert member.space.texts == ("force x",)
    assert member.space.nullity == family.nullity - job.structure.uncounted


def test_a_relation_of_two_inputs_is_a_pair_of_gears():
    """``B = -A`` has the rows of the five-bar with gears, to the last bit."""
    gears = DiscoveryJob("geared-five-bar", 3)
    asked = DiscoveryJob(FIVE_BAR, 3, require="dynamic along B=-1*A")
    sets = [conditions_at(job.structure, job.start(range(3))) for job in (gears, asked)]
    assert np.abs(sets[0].values - sets[1].values).max() < 1e-12 * sets[0].values.max()
    assert gears.generic == asked.generic and not asked.structure.regions


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("four-bar", "moment about 0.5,0.2,0 at A=0.2; force x at A=-0.1"),
        ("slider-crank", "force x at A=0.2; moment at A=0.1"),
        (FIVE_BAR, "force x along B=A**2; gravity at A=0.1,B=0.1"),
    ],
)
def test_derivatives_of_conditions(name, text):
    """By central differences, of fixed masses, with frames that move with the ground."""
    job = DiscoveryJob(name, 6, require=text, gravity=GRAVITY)
    structure, step = job.structure, 1e-6
    geometry = job.start(range(6))
    geometry = geometry.take(conditions_at(structure, geometry, 0.3, 2).usable)
    lanes, count = len(geometry.points), len(structure.shifts)
    assert lanes
    z = np.random.default_rng(2).standard_normal((lanes, 2, structure.unknowns))

    def left(geometry):
        here = conditions_at(structure, geometry, 0.3, 2)
        rows = lane_condition_rows(structure, geometry, here.poses, here.regions)
        return np.einsum("lrx,lsx->lsr", rows, z)

    slopes = [
        (left(structure.move(geometry, x)) - left(structure.move(geometry, -x))) / (2 * step)
        for x in (np.tile(row, (lanes, 1)) for row in step * np.eye(count))
    ]
    here = conditions_at(structure, geometry, 0.3, 2)
    rates = lane_condition_rates(structure, geometry, here.poses, here.regions, z)
    assert np.abs(np.stack(slopes, axis=-1) - rates).max() < 1e-7 * np.abs(rates).max()


def test_a_file_of_a_search_keeps_requirements_and_gravity():
    job = DiscoveryJob("four-bar", 5, require="gravity", gravity=GRAVITY)
    again = DiscoveryJob.from_description(job.description)
    assert again == job and again.digest == job.digest
    other = DiscoveryJob("four-bar", 5, require="gravity", gravity=(0.0, -1.0, 0.0))
    assert other.digest != job.digest


@pytest.mark.slow
def test_the_command_searches_for_requirements(capsys, tmp_path):
    path, member = str(tmp_path / "search.db"), str(tmp_path / "member.urdf")
    words = ("discover", "run", "--topology", "slider-crank", "--starts", "50")
    code, answer = json_answer(
        capsys, *words, "--workers", "0", "--require", "force x", "--out", path
    )
    assert code == 0 and answer["require"] == "force x" and answer["nullity"] == 6
    assert [entry["nullity"] for entry in answer["families"]] == [7]
    assert main(["discover", "show", path, "--members", "4", "--tried", "1"]) == 0
    assert "force x; nullity counts masses" in capsys.readouterr().out
    assert main(["discover", "export", path, "--family", "1", "--out", member]) == 0
    assert main(["report", member, "--require", "force x"]) == 0
    assert "7 of 9 dimensions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("topology", "text", "told"),
    [
        ("four-bar", "decoupled", "walks follow momenta"),
        ("four-bar", "dynamic up to order 2", "not their derivatives"),
        ("four-bar", "dynamic at E=0.1", "is no joint of the topology: one of A, B, C, D"),
        ("four-bar", "dynamic at A=0.1; force at B=0.1", "names 2 joints"),
        (FIVE_BAR, "dynamic at A=0.1", "names 1 joints"),
        ("slider-crank", "dynamic at D=0.1", "joint D does not turn"),
        ("slider-crank", "moment about 1,0,0", "two turning joints"),
        ("four-bar", "force z", "asks for nothing"),
        ("four-bar", "moment x", "asks for nothing"),
        ("four-bar", "gravity", "gravity is along the normal"),
        ("r-u-s-r", "force x", "only geometries in a plane"),
        ("0-1 1-2 2-3 3-4 1-4", "force x", "the ground has no two"),
        (FIVE_BAR, "dynamic along B=A**2, A=B**2", "given by others"),
        ("four-bar", "dynamic along way.csv", "kept without its files"),
        ("four-bar", "dynamic at A=30", "more than a turn"),
        (FIVE_BAR, "dynamic along B=9+A**2", "more than a turn"),
        (FIVE_BAR, "dynamic along B=A+", "cannot read"),
    ],
)
def test_what_means_nothing_for_all_geometries_is_refused(capsys, topology, text, told):
    words = ["discover", "run", "--topology", topology, "--require", text]
    assert main([*words, "--starts", "1", "--workers", "0"]) == 2
    line, *more = capsys.readouterr().err.strip().splitlines()
    assert told in line and len(more) <= 1
