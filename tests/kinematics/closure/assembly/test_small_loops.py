"""A small linkage on a long arm has the mobility and the ranks of a large one."""

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from balance.space.certification.exact_ranks import exact_ranks
from balance.space.exact.chain import exact_chain
from kinematics.errors import LinkageError, MobilityError
from kinematics.files.urdf.rational_screws import exact_geometry
from tests.independent import exactly
from tests.support.small_loops import NAMES, freedom, small_loop

SIZES = [f"1e-{k}" for k in range(9)]
# Ranks by order of each, whatever its size.
RANKS = {
    "general": [6, 10, 11],
    "parallelogram": [6, 7, 8],
    "kite": [6, 10],
    "slider_crank": [6, 10, 11],
    "rssr": [16, 24, 25],
}


@pytest.fixture
def loaded(tmp_path):
    def load(*arguments, **more):
        path = tmp_path / "small.urdf"
        path.write_text(small_loop(*arguments, **more), encoding="utf-8")
        return kinematics.load(path)

    return load


@pytest.mark.table(18)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", SIZES)
def test_mobility_does_not_depend_on_the_arm(name, size, loaded):
    linkage = loaded(name, size)
    assert linkage.mobility == freedom(name, size)
    assert linkage.planar == (name != "rssr")
    assert not linkage.notices and not linkage.idle


@pytest.mark.table(1)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arm", [1, 100_000])
def test_ranks_do_not_depend_on_the_arm(name, arm, loaded):
    """By exact arithmetic; in floating point as long as that calls itself sure."""
    for size in ("1", "1e-3", "1e-5", "1e-8") if arm == 1 else ("1",):
        linkage = loaded(name, size, arm)
        exact = exact_ranks(linkage)
        assert list(exact.ranks[: exact.kmax + 1]) == RANKS[name]
        space = certify(design_space(linkage))
        assert [order.rank for order in space.orders] == RANKS[name]
        assert space.certainty.level != "estimated"


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("name", [name for name in NAMES if name != "rssr"])
def test_the_ranks_by_series_in_fractions(name, loaded):
    linkage, order, p = loaded(name, "1e-6"), 2, 2**31 - 1
    chain = exact_chain(linkage, exact_geometry(linkage))
    found = [exactly.Series(chain, [1 + k, 3 - 2 * k], order).rows() for k in range(4)]
    kept = [10 * body + k for body in range(len(chain.links)) for k in (0, 1, 2, 6)]
    ranks = []
    for k in range(order + 1):
        rows = np.concatenate(
            [each[: k + 1, :, 2:5, kept].reshape(-1, len(kept)) for each in found]
        )
        ranks.append(rank([[exactly.modulo(x, p) for x in row] for row in rows], p))
    assert ranks == (RANKS[name] + RANKS[name][-1:])[:3]


def rank(rows, p):
    """Rank of whole numbers modulo a prime."""
    count = 0
    while rows and rows[0]:
        pivot = next((row for row in rows if row[0]), None)
        if pivot is not None:
            rows.remove(pivot)
            factor = pow(pivot[0], -1, p)
            rows = [
                [(x - row[0] * factor * y) % p for x, y in zip(row, pivot, strict=True)]
                for row in rows
            ]
            count += 1
        rows = [row[1:] for row in rows]
    return count


@pytest.mark.parametrize("name", NAMES)
def test_what_is_too_small_beside_its_distance_is_refused(name, loaded):
    with pytest.raises(MobilityError, match="too small for double precision"):
        loaded(name, "1e-9")


@pytest.mark.parametrize("name", ["general", "rssr"])
@pytest.mark.parametrize("size", ["1", "1e-4", "1e-7"])
def test_an_open_loop_is_closed_to_its_own_size(name, size, loaded):
    """Distances of joints along the coupler, in parts of the size, are those of the file."""
    opened, given = loaded(name, size, turn="0 0 0.01"), loaded(name, size)
    assert [notice.code for notice in opened.notices] == ["assembled"]
    assert opened.mobility == given.mobility
    for one, other in (("L2", "L3"), ("L3", "k"), ("L4", "k")):
        lengths = [apart(each, one, other) for each in (opened, given)]
        assert lengths[0] / float(size) == pytest.approx(lengths[1] / float(size), abs=1e-8)


def apart(linkage, one, other):
    """Distance of the joints after which two links come, or that close the loop."""
    at = {joint.whole.replace("j", "L"): joint.point for joint in linkage.joints}
    return np.linalg.norm(at[one] - at[other])


@pytest.mark.parametrize("size", ["1", "1e-3"])
def test_rounding_is_relative_to_the_loop(size, loaded):
    """Between its planes a loop may be off by a millionth of its size, not by a hundredth."""
    linkage = loaded("general", size, lift=1e-6)
    assert [notice.code for notice in linkage.notices] == ["closes_to_rounding"]
    assert linkage.planar and linkage.mobility == 2
    with pytest.raises(LinkageError, match="does not close"):
        loaded("general", size, lift=1e-2)
