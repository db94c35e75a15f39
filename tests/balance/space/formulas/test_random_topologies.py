"""Formulas of random planar linkages against their design spaces."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from kinematics import ScrewJoint, from_screws
from kinematics.errors import LinkageError
from tests.support.formula_rows import file_values, matrix, violation


def _point(rng):
    return (*np.round(rng.uniform(-2, 2, 2), 3).tolist(), 0.0)


class Builder:
    """A linkage to which cranks and dyads are added at random."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.links, self.joints, self.loops = ["base"], [], []

    def new_link(self):
        self.links.append(f"link{len(self.links)}")
        return self.links[-1]

    def name(self):
        return f"j{len(self.joints) + len(self.loops)}"

    def crank(self):
        """A link on a revolute joint."""
        parent = self.links[self.rng.integers(len(self.links))]
        joint = ScrewJoint(self.name(), parent, self.new_link(), point=_point(self.rng))
        self.joints.append(joint)

    def dyad(self):
        """Two links between two others, now and then with a slider at its end."""
        a, b = self.rng.choice(len(self.links), 2, replace=False).tolist()
        a, b = self.links[a], self.links[b]
        first, second = self.new_link(), self.new_link()
        elbow, end = _point(self.rng), _point(self.rng)
        self.joints.append(ScrewJoint(self.name(), a, first, point=_point(self.rng)))
        if self.rng.random() < 0.25:
            axis = np.array(_point(self.rng))
            slide = ScrewJoint(self.name(), b, second, axis=axis, point=end, kind="prismatic")
            self.joints.append(slide)
            self.loops.append(ScrewJoint(self.name(), first, second, point=elbow))
        else:
            self.joints.append(ScrewJoint(self.name(), first, second, point=elbow))
            self.loops.append(ScrewJoint(self.name(), second, b, point=end))

    def linkage(self):
        self.crank()
        while len(self.links) < self.rng.integers(4, 8):
            self.crank() if self.rng.random() < 0.2 else self.dyad()
        return from_screws(self.joints, self.loops)


def checked(seed, kind):
    """Derive the formulas of a random linkage, and compare; None for one that is refused."""
    try:
        linkage = Builder(seed).linkage()
    except LinkageError:
        return None
    space = balance.design_space(linkage, balance=kind)
    try:
        formulas = balance.formulas(linkage, kind)
    except LinkageError as error:
        assert "two directions" in str(error), error
        return None
    values = file_values(formulas.to_dict())
    assert formulas.confirmed
    # The basis has an error of round-off over the smallest singular value.
    assert violation(formulas, space, values) < 1e-12 / min(1.0, 1e3 * space.kept)
    rows = matrix(formulas, values)
    assert np.linalg.matrix_rank(rows) == len(rows)
    assert len(rows) * (2 if kind == "force" else 1) == space.rank
    return formulas


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_linkages_force(seed):
    checked(seed, "force")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 106))
def test_random_linkages_dynamic(seed):
    checked(seed, "dynamic")


def test_one_random_linkage_and_a_wrong_dimension():
    """The comparison notices a dimension that is off by a thousandth."""
    linkage = Builder(1).linkage()
    space = balance.design_space(linkage, balance="force")
    formulas = balance.formulas(linkage, "force")
    values = file_values(formulas.to_dict())
    assert violation(formulas, space, values) < 1e-12
    names = [name for name in values if name in formulas.text()]
    wrong = values | {names[0]: 1.001 * values[names[0]]}
    assert violation(formulas, space, wrong) > 1e-6
