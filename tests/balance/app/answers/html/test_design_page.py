"""The page of a design: its data, without a browser."""

from __future__ import annotations

import json

import numpy as np
import pytest

from balance.app.answers.html.design import design_page, ellipsoid
from balance.bodies import mass_properties
from tests.support.design_pages import FOUR_BAR, case
from tests.support.hostile_names import HOSTILE
from tests.support.laws import sums
from tests.support.page_elements import Elements

PARALLEL = "three_rsr"
CASES = ((FOUR_BAR, None), (PARALLEL, "u2=u3"))


def parameters_of(solid):
    """Parameters (10,) of a homogeneous solid ellipsoid, from its seven equal masses.

    One at its centre and two on each axis, at ``√(7/10)`` of its length from the centre, have
    its second moments: ``2 (m/7) (7/10) a² = m a² / 5``.
    """
    centre, axes = np.array(solid["centre"]), np.sqrt(0.7) * np.array(solid["axes"])
    points = np.concatenate([centre[None], centre + axes, centre - axes])
    return sums(np.full(7, solid["mass"] / 7), points)


@pytest.mark.parametrize("model, motion", CASES)
def test_ellipsoids_have_the_inertia_of_their_bodies(model, motion):
    found, text = case(model, motion)
    shapes = Elements(text).data("masses")
    assert [shape["name"] for shape in shapes] == list(found.space.bodies)
    given = [body.inertia for body in found.space.linkage.bodies]
    for shape, before, after in zip(shapes, given, found.z, strict=True):
        for z, solid in ((before, shape["given"]), (after, shape["designed"])):
            np.testing.assert_allclose(
                parameters_of(solid), z, rtol=0.0, atol=1e-12 * np.abs(z).max()
            )
            axes = np.array(solid["axes"])
            np.testing.assert_allclose(
                axes @ axes.T, np.diag(np.sum(axes**2, axis=1)), atol=1e-12 * axes.max() ** 2
            )


def test_bodies_that_cannot_be_have_no_ellipsoid():
    z = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 0.0, 0.0, 0.0])
    flat = ellipsoid(z)
    assert np.allclose(sorted(np.linalg.norm(flat["axes"], axis=1)), [0.0, 5**0.5, 5**0.5])
    assert ellipsoid(z * [1, 1, 1, 1, 1, 1, 1.01, 1, 1, 1]) is None
    assert ellipsoid(np.zeros(10)) is None
    assert ellipsoid(-z) is None


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
