"""The page of a design: its data, without a browser."""

from __future__ import annotations

import json

import numpy as np
import pytest

from balance.app.answers.html.design import block, design_page
from balance.bodies import mass_properties
from balance.masses.designs.best_design import design
from balance.space.certification.certify_space import certify
from tests.support.design_pages import FOUR_BAR, case
from tests.support.designs import design_of_any_density
from tests.support.hostile_names import HOSTILE
from tests.support.laws import sums
from tests.support.page_elements import Elements, without_breaks

PARALLEL = "three_rsr"
CASES = ((FOUR_BAR, None), (PARALLEL, "u2=u3"))


# Second moments about the centre over m a², for each of the semi-axes.
MOMENTS = {
    "block": (1 / 3, 1 / 3, 1 / 3),
    "plate": (1 / 4, 1 / 4, 1 / 3),
    "ellipsoid": (1 / 5,) * 3,
}


def parameters_of(solid):
    """Parameters (10,) of a homogeneous solid, from seven equal masses.

    One at its centre and two on each axis, at ``√(7 c/2) a`` from the centre, have the second
    moments ``2 (m/7) (7 c/2) a² = c m a²``.
    """
    centre = np.array(solid["centre"])
    axes = np.sqrt(3.5 * np.array(MOMENTS[solid["shape"]]))[:, None] * np.array(solid["axes"])
    points = np.concatenate([centre[None], centre + axes, centre - axes])
    return sums(np.full(7, solid["mass"] / 7), points)


def assert_solids(found, shapes):
    """Each solid has the mass, centre and inertia of its body, and axes at right angles."""
    assert [shape["name"] for shape in shapes] == list(found.space.bodies)
    given = [body.inertia for body in found.space.linkage.bodies]
    for shape, before, after in zip(shapes, given, found.z, strict=True):
        for z, solid in ((before, shape["given"]), (after, shape["designed"])):
            np.testing.assert_allclose(
                parameters_of(solid), z, rtol=0.0, atol=1e-11 * np.abs(z).max()
            )
            axes = np.array(solid["axes"])
            np.testing.assert_allclose(
                axes @ axes.T, np.diag(np.sum(axes**2, axis=1)), atol=1e-12 * axes.max() ** 2
            )


@pytest.mark.parametrize("model, motion", CASES)
def test_solids_have_the_inertia_of_their_bodies(model, motion):
    """Those of the file are blocks; those of a material are what its density limits."""
    found, text = case(model, motion)
    shapes = Elements(text).data("masses")
    limited = "plate" if found.space.planar else "ellipsoid"
    for state, kind in (("given", "block"), ("designed", limited)):
        assert {shape[state]["shape"] for shape in shapes} == {kind}
    assert_solids(found, shapes)
    free = design_of_any_density(found.space)
    shapes = Elements(design_page(free)).data("masses")
    assert {shape["designed"]["shape"] for shape in shapes} == {"block"}
    assert_solids(free, shapes)


def test_plates_are_drawn_in_their_sizes():
    """Of steel, 20 mm thick: volume times density is the mass, or more than it."""
    found = design(
        FOUR_BAR, "mass", bounds={"coupler": (0.5, 5.0)}, density=7850.0, thickness=0.02
    )
    elements = Elements(design_page(found))
    shapes = elements.data("masses")
    for shape in shapes:
        plate = shape["designed"]
        wide, long, half = np.linalg.norm(plate["axes"], axis=1)
        assert plate["shape"] == "plate" and half == pytest.approx(0.01, rel=1e-6)
        assert 2.0 * np.pi * wide * long * half * 7850.0 > (1.0 - 1e-6) * plate["mass"]
        assert abs(plate["axes"][2][2]) == pytest.approx(half, rel=1e-9)
        assert f"{2e3 * wide:.3g} × {2e3 * long:.3g} × 20" in elements.text
    assert_solids(found, shapes)
    given = sum(body.inertia[0] for body in found.space.linkage.bodies)
    text = without_breaks(elements.text)
    assert f"{found.value:.4g} kg in all, {given:.4g} kg in the file" in text


def test_a_uniform_bar_ends_where_its_block_ends():
    length, mass = 0.8, 1.5
    moment = mass * length**2 / 3.0  # about the end of a thin bar along x
    z = np.array([mass, mass * length / 2, 0.0, 0.0, 0.0, moment, moment, 0.0, 0.0, 0.0])
    bar = block(z)
    ends = np.sort([bar["centre"][0] + s * np.abs(bar["axes"]).max() for s in (-1.0, 1.0)])
    assert ends == pytest.approx([0.0, length], abs=1e-12)


def test_bodies_that_cannot_be_have_no_block():
    z = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 0.0, 0.0, 0.0])
    flat = block(z)
    assert np.allclose(sorted(np.linalg.norm(flat["axes"], axis=1)), [0.0, 3**0.5, 3**0.5])
    assert block(z * [1, 1, 1, 1, 1, 1, 1.01, 1, 1, 1]) is None
    assert block(np.zeros(10)) is None
    assert block(-z) is None


@pytest.mark.parametrize("model, motion", CASES)
def test_page_holds_the_outcome_and_little_else(model, motion):
    found, text = case(model, motion)
    elements = Elements(text)
    assert elements.data("report") == json.loads(json.dumps(found.to_dict()))
    assert len(text) < 400_000 and "{{" not in text
    limits = "within 1.5 lengths of the link from the middle of its joints"
    assert limits in " ".join(elements.text.split())
    urls = [v for _, name, v in elements.attributes if name in ("src", "href")]
    assert urls == ["data:,"]
    for body, z in zip(found.bodies, found.z, strict=True):
        assert f"{mass_properties(z).mass:.4g}" in elements.text
        assert body.name in elements.text


def test_the_page_of_a_python_design_is_as_certain_as_that_of_the_command():
    found, text = case(*CASES[0])
    assert found.space.level == "estimated"
    assert f"dimensions, {certify(found.space).level}" in text and "estimated" not in text


def test_names_from_files_are_text():
    found, _ = case(*CASES[0])
    linkage = found.space.linkage
    before = linkage.name, found.space.bodies, found.density
    density = {HOSTILE if name == before[1][0] else name: x for name, x in before[2].items()}
    try:
        object.__setattr__(linkage, "name", HOSTILE)
        object.__setattr__(found.space, "bodies", (HOSTILE, *before[1][1:]))
        object.__setattr__(found, "density", density)
        text = design_page(found)
    finally:
        object.__setattr__(linkage, "name", before[0])
        object.__setattr__(found.space, "bodies", before[1])
        object.__setattr__(found, "density", before[2])
    elements = Elements(text)
    assert elements.tags["script"] == Elements(case(*CASES[0])[1]).tags["script"]
    assert elements.tags["b"] == 1 and HOSTILE in elements.text
    assert elements.data("masses")[0]["name"] == HOSTILE
