"""Masses that no body has are not written in silence, and coordinates are real numbers."""

from __future__ import annotations

from fractions import Fraction
from xml.etree import ElementTree

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.masses.designs.feasibility import feasible
from kinematics.errors import BodyError, LinkageError
from tests.support.laws import coordinates

MODELS = ["four_bar_kite", "four_bar_antiparallelogram", "slider_crank", "bennett", "sarrus"]


def tensor(element):
    """The matrix (3, 3) of an element, by name."""
    found = ElementTree.fromstring(element).find("inertia")
    entry = {frozenset(name[1:]): float(value) for name, value in found.items()}
    return np.array([[entry[frozenset(a + b)] for b in "xyz"] for a in "xyz"])


def real(body):
    """Whether there is such a body: second moments about the centre of mass, by themselves."""
    inertia = tensor(body.element)
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    size = np.abs(inertia).max()
    return body.mass >= 0.0 and np.linalg.eigvalsh(second)[0] >= -1e-9 * size


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("model", MODELS)
def test_no_element_of_a_body_that_cannot_be(model, seed):
    """The error names the body and the inequality; the element is there for who asks."""
    space = design_space(kinematics.load(model))
    seen = set()
    for body in space.bodies_of(coordinates(space, seed)):
        if body.element is None:
            assert body.urdf is None and body.violated == ()
            continue
        seen.add(real(body))
        assert real(body) == (body.violated == ())
        if real(body):
            assert body.urdf == body.element
            continue
        with pytest.raises(BodyError) as caught:
            body.urdf  # noqa: B018
        text = str(caught.value)
        where = f"{space.source}: link '{body.name}': "
        assert text.startswith(f"{where}no body has these masses: ")
        assert body.violated[0] in text and caught.value.body == body.name
        assert "negative" in text or " < " in text
    assert seen


def test_a_negative_moment_is_told_in_numbers():
    """The example of the issue: ``izz="-0.915"`` was written without a word."""
    space = design_space(kinematics.load("four_bar_antiparallelogram"))
    told = []
    for seed in range(20):
        for body in space.bodies_of(coordinates(space, seed)):
            if body.mass > 0.0 and body.moment < 0.0:
                assert any(f"{body.moment:.6g} is negative" in line for line in body.violated)
                assert 'izz="-' in body.element
                told.append(body)
    assert told


@pytest.mark.parametrize("scale", [1e-90, 1.0, 1e90])
@pytest.mark.parametrize("model", ["four_bar_kite", "slider_crank", "scissor_three_stage"])
def test_designs_are_real(model, scale):
    space = design_space(kinematics.load(model))
    for body in space.bodies_of(scale * feasible(space).y):
        assert body.violated == () and body.urdf == body.element


def test_round_off_is_no_violation():
    """Bodies that carry nothing, and those that others' round-off reaches."""
    space = design_space(kinematics.load("three_rsr"))
    for body in space.bodies_of(np.zeros(space.nullity)):
        assert body.violated == () and 'mass value="0.0"' in body.urdf
    count = len(space.bodies)
    for k in range(space.nullity):
        for body in space.bodies_of(np.eye(space.nullity)[k]):
            if np.abs(body.z).max() < 1e-14:
                assert body.violated == ()
                count -= 1
    assert count < len(space.bodies)


SPACE = "four_bar_kite"


@pytest.mark.parametrize(
    "y",
    [
        np.ones(5) + 0j,
        [1j, 0, 0, 0, 0],
        ["1", "2", "3", "4", "5"],
        [None] * 5,
        [{}] * 5,
        np.array(["2020-01-01"] * 5, dtype="datetime64[D]"),
        [10**400, 0, 0, 0, 0],
        [np.inf, 0, 0, 0, 0],
        [np.nan, 0, 0, 0, 0],
    ],
)
def test_coordinates_are_real_numbers(y):
    with pytest.raises(ValueError, match="give 5 finite numbers"):
        design_space(kinematics.load(SPACE)).bodies_of(y)


@pytest.mark.parametrize("size", [1e200, -1e121, 1e308, 1e-200, -1e-121, 5e-324])
def test_coordinates_beyond_what_can_be_squared(size):
    """1e200 gave bodies of no mass, as its square is infinite."""
    space = design_space(kinematics.load(SPACE))
    with pytest.raises(ValueError, match="give numbers whose largest is from 1e-120 to 1e.120"):
        space.bodies_of([size, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("factor", [1e-119, 1e-30, 3.0, 1e30, 1e119])
def test_bodies_are_as_their_coordinates(factor):
    space = design_space(kinematics.load(SPACE))
    y = feasible(space).y
    y = y / np.abs(y).max()
    for one, other in zip(space.bodies_of(y), space.bodies_of(factor * y), strict=True):
        assert other.mass == pytest.approx(factor * one.mass, rel=1e-12)
        assert other.com == pytest.approx(one.com, rel=1e-9)
        assert other.moment == pytest.approx(factor * one.moment, rel=1e-9)


def test_whole_numbers_and_fractions_are_real():
    space = design_space(kinematics.load(SPACE))
    plain = space.bodies_of([1.0, 0.0, 0.5, 0.0, 2.0])
    for y in ([Fraction(1), 0, Fraction(1, 2), 0, 2], np.float32([1, 0, 0.5, 0, 2])):
        again = space.bodies_of(y)
        assert [a.mass for a in again] == [b.mass for b in plain]
    assert issubclass(BodyError, LinkageError)
