"""The integers of the table depend neither on units, place and names, nor on other orders."""

import random
from decimal import Decimal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from tests.support.covering import spread
from tests.support.figures import FIGURES, Figure
from tests.support.laws import altered, known, placed, renamed, resized, space, space_of

FOUR_RRR = next(figure for figure in FIGURES if figure.model == "four_rrr")
SCALES = (1e-6, 1e6)
ROTATIONS = Rotation.random(6, random_state=np.random.default_rng(51)).as_matrix()


def check(found, figure: Figure):
    """All integers of the row."""
    last = figure.ranks[-1:] * (len(found.orders) - len(figure.ranks))
    assert [order.rank for order in found.orders] == [*figure.ranks, *last]
    assert (found.kmax, found.settled) == (figure.kmax, True)
    assert (found.rank, found.nullity) == (figure.ranks[-1], figure.nullity)
    parallel = found.nullity - found.serial_nullity
    assert (found.serial_nullity, parallel) == (figure.serial, figure.parallel)
    assert found.rank + found.nullity == figure.parameters


def pose(R=None, offset=0.0, length=1.0):
    """A displacement by a rotation, and by an offset in a fixed oblique direction."""
    H = np.eye(4)
    H[:3, :3] = np.eye(3) if R is None else R
    H[:3, 3] = offset * length * np.array([2.0, -3.0, 6.0]) / 7.0
    return H


def length_of(figure: Figure) -> float:
    return known(figure).length


@pytest.mark.table
@pytest.mark.parametrize("factor", SCALES)
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_size_does_not_matter(figure, factor, tmp_path):
    check(space(figure, altered(figure.model, tmp_path, resized(factor))), figure)


@pytest.mark.table
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_place_does_not_matter(figure, tmp_path):
    """A thousand lengths away."""
    H = pose(None, 1000.0, length_of(figure))
    check(space(figure, altered(figure.model, tmp_path, placed(H))), figure)


@pytest.mark.table(2)
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 2), ids=str)
def test_the_direction_does_not_matter(figure, tmp_path):
    for R in ROTATIONS:
        check(space(figure, altered(figure.model, tmp_path, placed(pose(R)))), figure)


def shuffled(seed):
    """The change that writes links, joints and loops in another order, among each other."""

    def change(robot):
        items = list(robot)
        random.Random(seed).shuffle(items)
        robot[:] = items

    return change


@pytest.mark.table
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_names_and_their_order_do_not_matter(figure, tmp_path):
    path = altered(figure.model, tmp_path, renamed, shuffled(0))
    found = space(figure, path)
    check(found, figure)
    plain = [body.name for body in kinematics.load(figure.model).bodies]
    assert sorted(f"x_{name}_9" for name in plain) == sorted(found.bodies)


@pytest.mark.table
@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 1), ids=str)
def test_nothing_of_it_matters_together(figure, factor, tmp_path):
    H = pose(ROTATIONS[3], 1000.0, factor * length_of(figure))
    changes = (resized(factor), placed(H), renamed, shuffled(2))
    check(space(figure, altered(figure.model, tmp_path, *changes)), figure)


@pytest.mark.table
@pytest.mark.parametrize("figure", spread(FIGURES, 2, 0), ids=str)
def test_the_rank_never_falls_with_the_order(figure):
    """Each highest order is decided by itself: nothing is carried over from lower ones."""
    linkage = kinematics.load(figure.model)
    for last in range(11):
        found = space_of(figure, linkage, last)
        ranks = [figure.ranks[min(k, figure.kmax)] for k in range(last + 1)]
        assert [order.rank for order in found.orders] == ranks
        assert found.rank == ranks[-1] and found.nullity == figure.parameters - ranks[-1]
        assert found.basis.shape[1] == found.nullity
        assert found.settled == (last >= figure.kmax)
        assert found.settled != ("not_settled" in [notice.code for notice in found.notices])


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_the_force_conditions_of_the_four_rrr_stay_twelve(factor, tmp_path):
    """For each highest order from 1 to 10, at any size, far away and turned."""
    H = pose(ROTATIONS[5], 1000.0, factor * length_of(FOUR_RRR))
    path = altered("four_rrr", tmp_path, resized(factor), placed(H))
    linkage = kinematics.load(path)
    for last in range(1, 11):
        found = design_space(linkage, balance="force", max_order=last)
        assert [order.rank for order in found.orders] == [6, *[12] * last]
        assert (found.rank, found.nullity, found.settled) == (12, 15, True)


def rescaled(exponent):
    """The change that multiplies lengths by a power of ten, to the last digit."""

    def change(robot):
        for origin in robot.iter("origin"):
            numbers = map(Decimal, origin.get("xyz").split())
            origin.set("xyz", " ".join(str(x.scaleb(exponent)) for x in numbers))
        for pitch in robot.iter("screw_thread_pitch"):
            pitch.set("value", str(Decimal(pitch.get("value")).scaleb(exponent)))

    return change


@pytest.mark.table(2)
@pytest.mark.parametrize("exponent", [-6, 6])
@pytest.mark.parametrize("figure", FIGURES[::3], ids=str)
def test_what_is_proved_does_not_depend_on_the_size(figure, exponent, tmp_path):
    found = space(figure, altered(figure.model, tmp_path, rescaled(exponent)))
    check(found, figure)
    certainty, plain = certify(found).certainty, known(figure).certainty
    assert certainty.level == plain.level
    assert (certainty.rank, certainty.nullity) == (plain.rank, plain.nullity)
