"""Results in the terms of a designer, and as the published JSON."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError
from importlib.resources import files
from xml.etree import ElementTree

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import balance
import kinematics
from balance.app.answers.data import schema
from kinematics.model.plane import plane_axes
from kinematics.model.spatial.inertia import inertia_tensor
from tests.support.figures import BALANCED, FIGURES
from tests.support.laws import (
    altered,
    coordinates,
    displacement,
    known,
    outside,
    placed,
    relative,
    space,
)

SPATIAL = [figure for figure in FIGURES if figure.spatial]
# Linkages of which a single link has mass in balanced distributions.
ONE_MASS = {"pantograph_reaction_wheel"}
FLAT = [f for f in FIGURES if not f.spatial and str(f) not in ONE_MASS]
DYNAMIC = [f for f in FIGURES if f.balance == "dynamic" and str(f) not in ONE_MASS]
VALIDATOR = Draft202012Validator(schema())


def weighable(found):
    """Coordinates that give no first moment to the bodies that cannot have mass."""
    y, per_body = coordinates(found), len(found.labels)
    for i, body in enumerate(found.bodies_of(y)):
        if body.mass == 0.0:
            rows = found.basis[i * per_body + 1 : i * per_body + 4]
            y = y - np.linalg.pinv(rows, rcond=1e-9) @ rows @ y
    return y


def parts(found, vector):
    """Parameters of every body."""
    return vector.reshape(len(found.bodies), -1)


@pytest.mark.parametrize("figure", SPATIAL, ids=str)
def test_spatial_bodies_have_the_parameters_they_came_from(figure, tmp_path):
    """From the centre of mass back to the origin, in both frames."""
    path = altered(figure.model, tmp_path, placed(displacement(np.random.default_rng(7))))
    found = space(figure, path)
    y = coordinates(found)
    bodies = found.bodies_of(y)
    assert tuple(body.name for body in bodies) == found.bodies
    z, in_links = found.basis @ y, found.basis_in_link_frames() @ y
    for body, expected, local in zip(
        bodies, parts(found, z), parts(found, in_links), strict=True
    ):
        assert np.array_equal(body.z, expected) and body.moment is None
        assert (body.com is None) == (body.mass == 0.0) == (body.link_com is None)
        if body.inertia is None:
            assert body.mass == 0.0 and body.element is None and body.link_inertia is None
            continue
        com, link_com = (np.zeros(3) if c is None else c for c in (body.com, body.link_com))
        again = balance.bodies.parameters(body.mass, com, body.inertia)
        assert relative(again, expected) < 1e-12
        again = balance.bodies.parameters(body.mass, link_com, body.link_inertia)
        assert relative(again, local) < 1e-12


@pytest.mark.table
@pytest.mark.parametrize("figure", FLAT, ids=str)
def test_planar_bodies_have_the_parameters_they_came_from(figure, tmp_path):
    """In a plane that is inclined to every axis of the file."""
    path = altered(figure.model, tmp_path, placed(displacement(np.random.default_rng(8))))
    found = space(figure, path)
    assert found.planar and np.abs(found.axes[2]).min() > 1e-3
    y = coordinates(found)
    z, local = parts(found, found.basis @ y), parts(found, found.basis_in_link_frames() @ y)
    for i, body in enumerate(found.bodies_of(y)):
        frame = found.linkage.bodies[i].frame
        R, origin, n = frame[:3, :3], frame[:3, 3], found.axes[2]
        assert body.inertia is None and body.link_inertia is None
        assert (body.moment is None) == (figure.balance == "force")
        assert n @ body.com == pytest.approx(n @ origin)
        assert relative(R @ body.link_com + origin, body.com) < 1e-12
        E = R.T @ n
        for own, centre in (
            (z[i], found.axes[:2] @ body.com),
            (local[i], plane_axes(E)[:2] @ body.link_com),
        ):
            again = np.array([body.mass, *(body.mass * centre)])
            if body.moment is not None:
                again = np.append(again, body.moment + body.mass * (centre @ centre))
            assert relative(again, own) < 1e-11


@pytest.mark.table
@pytest.mark.parametrize("figure", DYNAMIC, ids=str)
def test_a_file_with_the_new_inertials_is_balanced(figure, tmp_path):
    """Through the reader: the values are those of the element, in the frame of its link."""
    turned = placed(displacement(np.random.default_rng(6)))
    found = space(figure, altered(figure.model, tmp_path, turned))
    bodies = found.bodies_of(weighable(found))

    def reweighed(robot):
        for body in bodies:
            link = next(k for k in robot.findall("link") if k.get("name") == body.name)
            link.remove(link.find("inertial"))
            link.append(ElementTree.fromstring(body.element))

    assert found.as_given.balanced == (str(figure) in BALANCED)
    again = space(figure, altered(figure.model, tmp_path, turned, reweighed))
    assert again.as_given.balanced and again.as_given.residual < 1e-13
    if figure.spatial:
        for body, read in zip(bodies, again.linkage.bodies, strict=True):
            assert relative(read.inertia, body.z) < 1e-12


@pytest.mark.parametrize("name", ["bennett", "three_rsr", "hprs"])
def test_the_basis_in_link_frames_does_not_see_where_the_robot_stands(name, tmp_path):
    """1e-10: the geometry passes through roll, pitch and yaw."""
    figure = next(f for f in SPATIAL if f.model == name)
    H = displacement(np.random.default_rng(4))
    here, there = known(figure), space(figure, altered(name, tmp_path, placed(H)))
    assert outside(there.basis, here.basis) > 1e-2
    assert outside(there.basis_in_link_frames(), here.basis_in_link_frames()) < 1e-10


def test_in_the_plane_of_the_file_link_axes_are_x_and_y():
    found = balance.design_space(kinematics.load("four_bar_kite"))
    y = coordinates(found)
    local = parts(found, found.basis_in_link_frames() @ y)
    for row, body in zip(local, found.bodies_of(y), strict=True):
        assert relative(row[1:3] / row[0], body.link_com[:2]) < 1e-12


@pytest.mark.parametrize("figure", [FIGURES[0], FIGURES[1], FIGURES[7]], ids=str)
def test_a_body_without_mass_has_no_centre(figure):
    found = known(figure)
    y = np.linalg.svd(found.basis[:1])[2][1:].sum(axis=0)
    first, *others = found.bodies_of(y)
    assert first.mass == 0.0 and abs(first.z[0]) < 1e-15
    missing = (first.com, first.inertia, first.moment, first.link_com, first.link_inertia)
    assert missing == (None,) * 5 and first.urdf is None
    assert any(body.com is not None for body in others)
    assert all(body.mass == 0.0 for body in found.bodies_of(np.zeros(found.nullity)))


def test_a_body_of_rods_alone_has_inertia_without_mass():
    """The body on a helical joint can carry a first moment along the axis, but no mass."""
    found = known(next(figure for figure in FIGURES if figure.model == "hprs"))
    first, *others = found.bodies_of(coordinates(found))
    assert (first.mass, first.com, first.inertia, first.urdf) == (0.0, None, None, None)
    assert all(body.mass != 0.0 for body in others)
    first = found.bodies_of(weighable(found))[0]
    assert (first.mass, first.com, first.link_com) == (0.0, None, None)
    assert relative(first.inertia, inertia_tensor(first.z)) < 1e-15
    assert '<mass value="0.0"/>' in first.element
    assert 'xyz="0.0 0.0 0.0"' in first.element


def test_results_cannot_be_changed():
    found = known(FIGURES[1])
    body = found.bodies_of(coordinates(found))[0]
    with pytest.raises(FrozenInstanceError):
        body.mass = 1.0
    arrays = [body.z, body.com, body.inertia, body.link_com, body.link_inertia]
    arrays += [found.basis_in_link_frames(), found.frames]
    assert not any(array.flags.writeable for array in arrays)


@pytest.mark.parametrize("y", [np.zeros(3), np.zeros((4, 1)), [1.0, 2.0, np.nan, 0.0], 1.0])
def test_coordinates_that_do_not_fit(y):
    with pytest.raises(ValueError, match="give 4 finite numbers"):
        known(FIGURES[0]).bodies_of(y)


def test_the_schema_is_a_schema():
    Draft202012Validator.check_schema(schema())
    found = schema()
    path = files("balance").joinpath("app", "schemas", "report.schema.json")
    assert json.loads(path.read_text(encoding="utf-8")) == found
    assert set(found["required"]) == set(found["properties"])
    assert found["additionalProperties"] is False


@pytest.mark.table
@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_every_report_follows_the_schema(figure):
    """What the command prints is this: see the tests of the command."""
    VALIDATOR.validate(json.loads(json.dumps(known(figure).to_dict())))


@pytest.mark.parametrize("figure", FIGURES, ids=str)
def test_the_report_holds_the_basis_and_the_singular_values(figure):
    """To the last digit; what it spans leaves no momentum at a finite pose."""
    found = known(figure)
    report = json.loads(json.dumps(found.to_dict()))
    basis, values = np.array(report["basis"]), np.array(report["singular_values"])
    assert np.array_equal(basis.reshape(found.basis.shape), found.basis)
    assert basis.shape == (report["parameters"], report["nullity"])
    assert len(values) == report["rank"] and np.all(np.diff(values) <= 0.0)
    assert values[0] == 1.0 and values[-1] == report["margin"]["kept"]
    X = balance.momentum.momentum_regressor(
        found.linkage, np.zeros(found.linkage.mobility), spatial=not found.planar
    )
    if found.balance == "dynamic" and not found.motion:
        assert np.abs(X @ basis).max() <= 1e-12 * np.abs(X).max() * np.abs(basis).max()


WRONG = {
    "missing": lambda r: r.pop("kmax"),
    "added": lambda r: r.update(colour="red"),
    "version": lambda r: r.update(schema="balance.report/2"),
    "type": lambda r: r.update(rank="8"),
    "fraction": lambda r: r.update(rank=8.5),
    "negative": lambda r: r.update(nullity=-1),
    "word": lambda r: r.update(algebra="flat"),
    "null": lambda r: r.update(mobility=None),
    "twice": lambda r: r.update(bodies=["a", "a"]),
    "order": lambda r: r["orders"][0].pop("rank"),
    "order added": lambda r: r["orders"][0].update(time=1.0),
    "margin": lambda r: r["margin"].update(kept=-0.1),
    "given": lambda r: r["as_given"].update(balanced=0),
    "warning": lambda r: r.update(warnings=["careful"]),
    "certainty": lambda r: r.update(certainty="guessed"),
    "basis": lambda r: r["basis"][0].append("1"),
    "singular values": lambda r: r["singular_values"].append(-0.1),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_report_breaks_the_schema(case):
    report = known(FIGURES[0]).to_dict()
    VALIDATOR.validate(report)
    WRONG[case](report)
    assert not VALIDATOR.is_valid(report)
