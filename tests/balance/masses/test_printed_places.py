"""Printed and tabled masses stand where the written file has them, in the named frame."""

import re
from ast import literal_eval
from xml.etree import ElementTree

import numpy as np
import pytest

import balance
from balance.app.answers.text.counterweights import FRAMES
from balance.app.answers.text.partial_balance import front_body, front_rows
from balance.app.answers.text.remedies import remedies_facts
from balance.support.mass_table import mass_table
from kinematics.errors import UsageError

MODEL = "four_bar_general"


def added_links(data):
    """Mass, g, and centre, mm, of what a file adds to links, in the frames of these links."""
    robot = ElementTree.fromstring(data)
    masses = {
        x.get("name"): float(x.find("inertial/mass").get("value"))
        for x in robot.iter("link")
        if x.find("inertial") is not None
    }
    places = {}
    for joint in robot.iter("joint"):
        child = joint.find("child").get("link")
        if joint.get("type") == "fixed" and child.endswith("_counterweight"):
            origin = np.array(joint.find("origin").get("xyz").split(), float)
            places[joint.find("parent").get("link")] = 1e3 * masses[child], 1e3 * origin
    return places


def test_the_table_of_counterweights_is_that_of_the_file():
    made = balance.counterweights(MODEL, ["crank", "rocker"], balance="force")
    written = added_links(made.to_urdf())
    table = made.to_table()
    assert [row.link for row in table] == ["crank", "rocker"] == list(written)
    for row in table:
        mass, place = written[row.link]
        assert row.mass == pytest.approx(mass, rel=1e-12)
        np.testing.assert_allclose(row[2:5], place, atol=1e-9)


def areas_of(link):
    """Functions that tell which points (n, 2), m, are in the cylinders and boxes of a link.

    Their axes are across the plane.
    """
    for visual in link.iter("visual"):
        (shape,) = visual.find("geometry")
        origin = visual.find("origin")
        (x, y, _), angles = (
            np.array((origin.get(name) or "0 0 0").split(), float) for name in ("xyz", "rpy")
        )
        assert not angles[:2].any()
        c, s = np.cos(angles[2]), np.sin(angles[2])

        def inside(points, shape=shape, middle=(x, y), turn=((c, -s), (s, c))):
            u = (points - middle) @ np.array(turn)
            if shape.tag == "cylinder":
                return np.linalg.norm(u, axis=1) <= float(shape.get("radius"))
            return (np.abs(u) <= 0.5 * np.array(shape.get("size").split(), float)[:2]).all(1)

        yield inside


@pytest.mark.parametrize(
    "shape, regions, kinds",
    [
        ("disc=0.02", {}, ["cylinder", "box"]),
        ("block=0.02", {"all": "250mm"}, ["box", "box"]),
        ("disc=0.02", {"crank": "box(-0.3:-0.02,-0.3:-0.02,-0.1:0.1)"}, ["cylinder"]),
    ],
)
def test_a_shape_without_parts_is_drawn_with_its_web(shape, regions, kinds):
    """What is drawn has the mass and the centre of the weight, by a count of squares."""
    made = balance.counterweights(
        MODEL, ["crank", "rocker"], regions, balance="force", shape=shape
    )
    robot = ElementTree.fromstring(made.to_urdf())
    (link,) = (x for x in robot.iter("link") if x.get("name") == "crank_counterweight")
    drawn = [x.tag for geometry in link.iter("geometry") for x in geometry]
    assert drawn == kinds and link.find("collision") is None
    line = np.linspace(-0.3, 0.3, 1501)
    points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    inside = np.any([area(points) for area in areas_of(link)], axis=0)
    mass = 7850.0 * 0.02 * (line[1] - line[0]) ** 2 * inside.sum()
    assert mass == pytest.approx(float(link.find("inertial/mass").get("value")), rel=5e-3)
    np.testing.assert_allclose(points[inside].mean(axis=0), 0.0, atol=2e-4)


@pytest.mark.parametrize("density", ["steel", 2700.0, None])
def test_weights_without_parts_are_drawn_as_balls_of_their_volume(density):
    """Point masses as steel; the balls collide with nothing."""
    made = balance.counterweights(MODEL, ["crank", "rocker"], balance="force", density=density)
    robot = ElementTree.fromstring(made.to_urdf())
    added = [x for x in robot.iter("link") if "_counterweight" in x.get("name")]
    assert len(added) >= 2
    for link in added:
        radius = float(link.find("visual/geometry/sphere").get("radius"))
        mass = float(link.find("inertial/mass").get("value"))
        kilograms = 2700.0 if density == 2700.0 else 7850.0
        assert 4.0 / 3.0 * np.pi * radius**3 * kilograms == pytest.approx(mass, rel=2e-3)
        assert link.find("collision") is None


def test_the_table_of_a_design_is_that_of_the_file():
    best = balance.design("four_bar_antiparallelogram", "mass", bounds={"coupler": (0.5, 2)})
    robot = ElementTree.fromstring(best.to_urdf())
    given = {x.get("name"): x.find("inertial") for x in robot.iter("link")}
    for row in best.to_table():
        inertial = given[row.link]
        assert row.mass == pytest.approx(1e3 * float(inertial.find("mass").get("value")))
        centre = np.array(inertial.find("origin").get("xyz").split(), float)
        np.testing.assert_allclose(row[2:5], 1e3 * centre, atol=1e-9)
        written = inertial.find("inertia")
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        tensor = np.array([float(written.get(name)) for name in names])
        np.testing.assert_allclose(row.moments, 1e6 * tensor, atol=1e-3)


def test_the_table_of_a_design_of_plates_has_their_sizes():
    """Of full sizes a, b, t: at most ``ρ π a b t / 4`` heavy, ``m (a² + b²) / 16`` about t."""
    best = balance.design(
        "four_bar_antiparallelogram",
        "mass",
        bounds={"coupler": (0.5, 5)},
        density="steel",
        thickness="20mm",
    )
    table = best.to_table()
    lines = repr(table).splitlines()
    assert lines[0].endswith("  solid of its inertia (mm), density (kg/m³)")
    for row, line in zip(table, lines[1:-1], strict=True):
        shape, sizes = line[-len(table.solids[row.link]) :].split(" plate ")
        sizes, _, density = sizes.partition(", ")
        width, height, thickness = map(float, sizes.split(" × "))
        assert shape == "elliptic" and thickness == 20.0
        volume = 1e-6 * np.pi / 4.0 * width * height * thickness  # of g and kg/m³
        assert row.mass == pytest.approx(float(density) * volume, rel=0.02)
        assert float(density) < 7.86e3
        body = next(body for body in best.bodies if body.name == row.link)
        about = 1e9 * float(body.link_inertia[2, 2])
        assert about == pytest.approx(row.mass * (width**2 + height**2) / 16.0, rel=0.01)
        assert table.solids[row.link] in table._repr_html_()


def test_a_table_is_printed_in_columns():
    inertia = np.diag([0.002, 0.003, 0.005]) + 1e-9  # products are the solver's, and no column
    rows = [
        ("crank", 0.5, np.array([0.1, -0.02, 1e-14]), inertia),
        ("bare", 0.0, None, None),
        ("point", 0.1, np.zeros(3), np.zeros((3, 3))),
    ]
    table = mass_table(rows, 1.0)
    assert repr(table).splitlines() == [
        "link   mass (g)  x (mm)  y (mm)  z (mm)  Ixx (kg mm²)  Iyy (kg mm²)  Izz (kg mm²)",
        "crank       500     100     -20       0          2000          3000          5000",
        "point       100       0       0       0             0             0             0",
        "Centres of mass, and moments about them, are in the link frames of the file.",
    ]
    assert "500 g at (100, -20, 0) mm" in table._repr_html_()
    assert table[0].mass == 500.0 and len(table) == 2


def test_an_answer_without_masses_says_that_there_are_none_and_why():
    none = balance.design(MODEL)
    told = repr(none.to_table())
    assert told == f"no masses: {none.words}" and none.words.startswith("infeasible: ")
    assert "no masses" in none.to_table()._repr_html_()
    with pytest.raises(UsageError, match=r'balance the forces alone \(balance="force"\)'):
        none.to_urdf()
    assert balance.design(MODEL, balance="force").to_table()
    assert repr(balance.counterweights(MODEL, ["coupler"]).to_table()).startswith(
        "no masses: i"
    )


def test_a_design_that_is_lighter_than_air_says_so_and_how_to_make_it_heavier():
    """A plate of the central moments I_zz and mass m: C = diag(a², b²) m/4, ρ = m/(π a b t)."""
    model, light = "four_bar_antiparallelogram", {"coupler": (1e-5, 1e-4)}
    design = balance.design(model, bounds=light)
    coupler = next(body for body in design.bodies if body.name == "coupler")
    a, b = 2.0 * np.sqrt(np.linalg.eigvalsh(_central(coupler)) / coupler.mass)
    assert coupler.mass / (np.pi * a * b * design.thickness) < 1.2
    assert design.words.endswith("; lighter than air: coupler")
    assert (
        repr(design.to_table())
        .splitlines()[-1]
        .startswith("lighter than air as a solid: coupler")
    )
    (line,) = (x for x in repr(design).splitlines() if "bounds=" in x)
    bounds = literal_eval(line.strip().removeprefix("bounds=").partition("}")[0] + "}")
    heavier = balance.design(model, bounds={"coupler": (0.05, 0.5)})
    assert "lighter" not in heavier.words and "lighter" not in repr(heavier.to_table())
    assert bounds["coupler"][0] == pytest.approx(10.0 * coupler.mass, rel=0.05)


def _central(body):
    """Second moments (2, 2) in the plane about the centre of mass, from moments of inertia."""
    inertia = body.link_inertia
    return (0.5 * np.trace(inertia) * np.eye(3) - inertia)[:2, :2]


@pytest.mark.slow
def test_remedies_say_where_their_matter_is_in_link_frames():
    comparison = balance.compare_remedies("slider_crank", ["force_masses"])
    (remedy,) = comparison.by_preference
    written = added_links(remedy.urdf)
    _, _, places = remedy.reason.partition("centres in link frames of the file, mm: ")
    told = re.findall(r"(\w+) ([\d.]+) g at \(([^)]*)\)", places)
    assert {link for link, *_ in told} == set(written)
    for link, mass, place in told:
        grams, centre = written[link]
        assert float(mass) == pytest.approx(grams, rel=5e-3)
        size = np.abs(centre).max()
        np.testing.assert_allclose(np.array(place.split(","), float), centre, atol=1e-2 * size)
    told = dict(remedies_facts(comparison))["other masses"]
    assert "chosen anew (balance design)" in told and "keep the masses of the file" in told


@pytest.mark.slow
def test_fronts_say_how_much_room_their_matter_fills():
    """Of a ball of 4/3 π r³ matter of steel fills its mass over 7850 kg/m³."""
    front = balance.pareto(
        MODEL, ["crank"], 3, 0.6, balance="force", regions={"crank": "ball(0,0,0,0.15)"}
    )
    head, *rows = front_rows(front)
    column = head.index("room filled (%)")
    volume = 4.0 / 3.0 * np.pi * 0.15**3
    assert rows[0][column] == "–"
    for design, row in zip(front.designs[1:], rows[1:], strict=True):
        filled = 100.0 * design.mass / (7850.0 * volume)
        assert float(row[column]) == pytest.approx(filled, rel=5e-3)
    body = front_body(front)
    assert body[-1] == FRAMES and "link frames of the file" in FRAMES
    (room,) = [text for label, text in body[2].rows if label == "room"]
    assert "ball(0,0,0,0.15) of crank" in room and "--region" in room
