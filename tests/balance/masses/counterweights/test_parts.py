"""Parts of counterweights: what their files hold, and the URDF file that shows them."""

import csv
import io
import re

import numpy as np
import pytest

import balance
from balance.app.cli import part_options
from balance.app.cli.main import main
from balance.masses.counterweights.counterweight import Counterweight, filled_counterweight
from balance.masses.counterweights.parts.part_files import (
    part_files,
    part_notices,
    parts_of,
)
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.shaped.across_plane import shape_place
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from tests.independent.shapes_with_webs import shape_and_web

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("manifold3d")
ezdxf = pytest.importorskip("ezdxf")

STEEL = 7850.0
ROOM = {
    "crank": "cylinder(0,-0.1,0.03,0,0,1,0.12,0.04)",
    "rocker": "box(-0.05:0.2,-0.4:-0.1,0.01:0.05)",
}
ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def table_of(files):
    """Rows of the table by link, with numbers as numbers."""
    rows = csv.DictReader(io.StringIO(files["parts.csv"].decode()))
    words = ("link", "shape", "mesh", "outline", "solid")
    return {
        row["link"]: {k: v if k in words else float(v or "nan") for k, v in row.items()}
        for row in rows
    }


def test_a_filled_region_is_cut_by_no_plane():
    """Its form is constant but for round-off, whose plane would be 1e15 m away."""
    form = np.diag([0.0, 0.0, 0.0, 1.0])
    form[0, 3] = form[3, 0] = 1e-16
    region, none = read_region("ball(0,0,0,0.01)"), np.zeros(3)
    mass = STEEL * region.volume
    full = Counterweight("l1", mass, none, np.eye(3), (), region, form, STEEL)
    assert full.cut is None
    assert full.what == "100 % of ball(0,0,0,0.01)"


def check_meshes(files, weights, rays=1e-6):
    """Meshes that trimesh reads have the volume, centre and inertia of the table and answer.

    The answer's inertia may be off by ``rays``, the error of integrals over rays.
    """
    table = table_of(files)
    assert set(table) == {weight.link for weight in weights}
    for weight in weights:
        row = table[weight.link]
        mesh = trimesh.load(io.BytesIO(files[row["mesh"]]), file_type="stl")
        mesh.apply_scale(1e-3)
        assert mesh.is_watertight and mesh.is_winding_consistent
        extents = [row[f"along_{axis}_mm"] for axis in "xyz"]
        np.testing.assert_allclose(1e3 * mesh.extents, extents, rtol=1e-6)
        assert row["mass_g"] == pytest.approx(1e3 * row["mass_kg"], rel=1e-7)
        mass = mesh.volume * row["density_kg_m3"]
        size = np.sqrt(np.trace(weight.inertia) / weight.mass)
        centre = np.array([row[f"{axis}_m"] for axis in "xyz"])
        np.testing.assert_allclose(
            [row[f"{axis}_mm"] for axis in "xyz"], 1e3 * centre, rtol=1e-7
        )
        inertia = mesh.moment_inertia * row["density_kg_m3"]
        for wanted in (row["mass_kg"], weight.mass):
            assert mass == pytest.approx(wanted, rel=1e-6)
        for wanted, share in ((centre, 1e-6), (weight.com, rays)):
            np.testing.assert_allclose(mesh.center_mass + weight.com, wanted, atol=share * size)
        for name, at in ENTRIES.items():
            size = np.trace(weight.inertia)
            assert abs(inertia[at] - row[f"i{name}_kg_m2"]) <= 1e-6 * size
            assert abs(inertia[at] - weight.inertia[at]) <= rays * size


def curves_of(data):
    """Corners (n, 3) with bulges of the curves of a drawing whose units are millimetres."""
    drawing = ezdxf.read(io.StringIO(data.decode()))
    assert (drawing.header["$INSUNITS"], drawing.header["$MEASUREMENT"]) == (4, 1)
    assert not drawing.audit().has_issues
    curves = list(drawing.modelspace())
    assert all(curve.closed for curve in curves)
    return [np.array(list(curve.get_points("xyb"))) for curve in curves]


def outline_moments(data):
    """Area and first moments of outlines of lines and arcs, mm, about the origin."""
    area, moment = 0.0, np.zeros(2)
    for points in curves_of(data):
        for (x, y, bulge), (u, v, _) in zip(points, np.roll(points, -1, axis=0), strict=True):
            p, q, cross = np.array([x, y]), np.array([u, v]), x * v - u * y
            area += 0.5 * cross
            moment += cross * (p + q) / 6.0
            if bulge:
                angle, chord = 4.0 * np.arctan(bulge), np.hypot(*(q - p))
                r = 0.5 * chord / np.sin(0.5 * angle)
                out = np.array([v - y, x - u]) / chord
                segment = 0.5 * r * r * (angle - np.sin(angle))
                middle = 0.5 * (p + q) - r * np.cos(0.5 * angle) * out
                area += segment
                moment += segment * middle + chord**3 / 12.0 * np.sign(bulge) * out
    return area, moment


def filled(regions, model="four_bar_general", balanced="force", **wishes):
    """Counterweights in steel."""
    space = balance.design_space(model, balance=balanced)
    return balance.counterweights(
        space,
        list(regions),
        {k: v for k, v in regions.items() if v},
        density=STEEL,
        relax=False,
        **wishes,
    )


def test_a_segment_and_a_slice_are_plates_with_their_mass_and_centre():
    answer = filled(ROOM)
    files = part_files(parts_of(answer.weights))
    assert list(files) == [
        *("crank.stl", "crank.dxf", "rocker.stl", "rocker.dxf", "parts.csv", "README.txt")
    ]
    check_meshes(files, answer.weights)
    for weight in answer.weights:
        row = table_of(files)[weight.link]
        assert (row["shape"], row["thickness_mm"]) == ("plate", pytest.approx(40.0))
        area, moment = outline_moments(files[row["outline"]])
        per_area = STEEL * row["thickness_mm"] * 1e-9
        assert area * per_area == pytest.approx(weight.mass, rel=2e-6)
        # The outline has the frame of the mesh, whose origin is the centre of mass.
        np.testing.assert_allclose(moment / area, 0.0, atol=2e-4)
        corners = np.concatenate(curves_of(files[row["outline"]]))
        mesh = trimesh.load(io.BytesIO(files[row["mesh"]]), file_type="stl")
        assert (corners[:, :2] >= mesh.bounds[0, :2] - 1e-3).all()
        assert (corners[:, :2] <= mesh.bounds[1, :2] + 1e-3).all()


def test_a_whole_disc_is_one_circle():
    region = read_region("cylinder(0.1,0.2,0.3,0,0,1,0.05,0.02)")
    whole = np.diag([0.0, 0.0, 0.0, 1.0])
    stock = Stock(region, STEEL)
    weight = filled_counterweight("l1", stock, whole, fill(stock, whole))
    files = part_files(parts_of([weight]))
    check_meshes(files, [weight])
    (curve,) = curves_of(files["l1.dxf"])
    assert curve[:, 2].tolist() == [1.0, 1.0]
    area, moment = outline_moments(files["l1.dxf"])
    assert area == pytest.approx(np.pi * 50.0**2, rel=1e-12)
    np.testing.assert_allclose(moment / area, 0.0, atol=1e-9)
    row = table_of(files)["l1"]
    assert (row["shape"], row["radius_mm"], row["thickness_mm"]) == ("disc", 50.0, 20.0)
    assert [row[f"axis_{axis}_mm"] for axis in "xyz"] == [100.0, 200.0, 300.0]
    assert not {"hole_radius_mm", "angle_deg", "arm_mm", "solid"} & set(row)


def test_the_hole_of_a_ring_is_in_the_table_and_in_the_drawing():
    """Moments of a ring are those of two discs."""
    region = read_region("cylinder(0.1,0.2,0.3,0,0,1,0.05,0.02)")
    stock = Stock(region, STEEL)
    inner = 0.6
    ring = np.diag([1.0, 1.0, 0.0, -(inner**2)])
    weight = filled_counterweight("l1", stock, ring, fill(stock, ring))
    files = part_files(parts_of([weight]))
    row = table_of(files)["l1"]
    assert row["hole_radius_mm"] == pytest.approx(30.0, rel=1e-6)
    area, _ = outline_moments(files["l1.dxf"])
    assert area == pytest.approx(np.pi * (50.0**2 - 30.0**2), rel=1e-6)
    izz = 0.5 * STEEL * np.pi * 0.02 * (0.05**4 - 0.03**4)
    assert row["izz_kg_m2"] == pytest.approx(izz, rel=1e-5)


@pytest.mark.parametrize("axis", ["1,0,0", "0,1,0", "0,3,4"])
def test_axes_of_a_drawing_are_those_that_are_named(axis):
    """The mesh, seen along the axes that `README.txt` names, covers the outline."""
    region = read_region(f"cylinder(0.1,0.2,0.3,{axis},0.05,0.02)")
    half = np.zeros((4, 4))
    half[0, 3] = half[3, 0] = 0.3
    half[1, 3] = half[3, 1] = 0.4
    half[3, 3] = 0.2
    stock = Stock(region, STEEL)
    weight = filled_counterweight("l1", stock, half, fill(stock, half))
    files = part_files(parts_of([weight]))
    (line,) = re.findall(
        r"l1\.dxf: x is \((.*)\) and y is \((.*)\) of l1", files["README.txt"].decode()
    )
    axes = np.array([[float(x) for x in text.split(",")] for text in line])
    mesh = trimesh.load(io.BytesIO(files["l1.stl"]), file_type="stl")
    seen = mesh.vertices @ axes.T
    area, moment = outline_moments(files["l1.dxf"])
    np.testing.assert_allclose(moment / area, 0.0, atol=1e-4)
    # Second moments of the outline are of this part alone, and differ if an axis is turned.
    corners = curves_of(files["l1.dxf"])[0][:, :2]
    distance = np.linalg.norm(corners[:, None] - seen, axis=-1).min(axis=1)
    assert distance.max() < 1e-2
    assert np.linalg.norm(corners[:, None] * [1, -1] - seen, axis=-1).min(axis=1).max() > 1.0


@pytest.mark.parametrize("shape", ["disc=0.02", "sector=0.02", "cylinder=0.05"])
def test_the_table_has_the_dimensions_to_make_a_shape(shape):
    """Mass and centre of textbooks from the dimensions, webs from the joints of the file."""
    answer = filled({"crank": "", "rocker": ""}, shape=shape)
    files = part_files(parts_of(answer.weights))
    table = list(csv.reader(io.StringIO(files["parts.csv"].decode())))
    assert all(cell for row in table for cell in row)
    joints = {"crank": [[0, 0], [100, 300]], "rocker": [[0, 0], [-200, 700]]}
    for link, row in table_of(files).items():
        radius, thickness = row["radius_mm"], row["thickness_mm"]
        axis = np.array([row["axis_x_mm"], row["axis_y_mm"]])
        centre = np.array([row["x_mm"], row["y_mm"]])
        # A cylinder that is no longer than its diameter is a disc.
        assert row["shape"] == "sector" if shape.startswith("sector") else "disc"
        angle = np.radians(row.get("angle_deg", 360.0))
        area, far = 0.5 * angle * radius**2, centre
        assert row["arm_mm"] == 0.0
        if shape.startswith("sector"):
            np.testing.assert_allclose(axis, 0.0, atol=1e-9)
            middle = np.radians(row["direction_deg"])
            away = 4.0 * radius * np.sin(0.5 * angle) / (3.0 * angle)
            far = away * np.array([np.cos(middle), np.sin(middle)])
        else:
            ends = np.array(joints[link])
            joint = ends[np.linalg.norm(ends - axis, axis=1).argmin()]
            np.testing.assert_allclose([row["web_x_mm"], row["web_y_mm"]], joint, atol=1e-6)
            length = float(np.linalg.norm(axis - joint))
            assert row["web_length_mm"] == pytest.approx(length, rel=1e-6)
            assert row["web_width_mm"] == pytest.approx(radius, rel=1e-6)
            area, moment = shape_and_web("disc", radius, length)
            far = joint + moment / area * (axis - joint) / length
        np.testing.assert_allclose(centre, far, atol=1e-5 * radius)
        assert row["mass_g"] == pytest.approx(1e-6 * STEEL * area * thickness, rel=2e-6)
        weight = next(x for x in answer.weights if x.link == link)
        place, other = shape_place(answer.space, weight), np.array(joints[link][1])
        assert 1e3 * place.distance == pytest.approx(np.hypot(*centre), rel=1e-6)
        along = [np.cos(np.radians(place.direction)), np.sin(np.radians(place.direction))]
        np.testing.assert_allclose(along, centre / np.hypot(*centre), atol=1e-6)
        (away,) = place.away.values()
        cosine = centre @ other / np.hypot(*centre) / np.hypot(*other)
        assert np.cos(np.radians(away)) == pytest.approx(cosine, abs=1e-6)
        drawn = f"{link}.dxf: x is (1, 0, 0) and y is (0, 1, 0) of {link}"
        assert drawn in files["README.txt"].decode()


@pytest.mark.parametrize("shape", ["disc=0.02", "block=0.03"])
def test_a_web_is_in_every_file_of_its_part(shape, tmp_path):
    """The outline has the area of shape and web, and lines to the joint at both sides of it."""
    room = {"crank": "ball(0,0,0,0.2)", "rocker": "ball(0,0,0,0.4)"}
    answer = filled(room, shape=shape)
    parts = parts_of(answer.weights)
    assert not part_notices(parts)
    files = part_files(parts)
    check_meshes(files, answer.weights)
    for weight in answer.weights:
        web = weight.web
        assert weight.what.endswith(web.text) and weight.to_dict()["web"]["width"] > 0.0
        (curve,) = curves_of(files[f"{weight.link}.dxf"])
        area, _ = outline_moments(files[f"{weight.link}.dxf"])
        thickness = 2.0 * np.linalg.norm(web.place[:3, 2])
        assert STEEL * 1e-6 * area * thickness == pytest.approx(weight.mass, rel=2e-6)
        for side in (-1.0, 1.0):
            corner = 1e3 * (web.to_link([-1.0, side, 0.0]) - weight.com)[:2]
            assert np.linalg.norm(curve[:, :2] - corner, axis=1).min() < 1e-2
        if shape.startswith("disc"):
            # One arc, and three sides of the web.
            assert len(curve) == 4 and np.count_nonzero(curve[:, 2]) == 1
    answer.to_urdf(tmp_path / "made.urdf")
    assert balance.verify(tmp_path / "made.urdf", balance="force", speed="60rpm").balanced


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "balanced", "regions", "wishes"),
    [
        ("four_bar_general", "force", {"crank": "", "rocker": ""}, {}),
        ("four_bar_general", "force", {"crank": "", "rocker": ""}, {"thickness": 0.02}),
        (
            "four_bar_general",
            "force",
            {
                "crank": "cylinder(0,-0.1,0,1,2,3,0.15,0.2)",
                "rocker": "ellipsoid(0.1,-0.3,0,0.2,0.1,0.1,0.3,0.2,0.1)",
            },
            {},
        ),
        (
            "four_bar_antiparallelogram",
            "dynamic",
            dict.fromkeys(("crank", "coupler", "rocker"), ""),
            {},
        ),
        (
            "four_bar_general",
            "force",
            {
                "crank": "cylinder(0,-0.1,0,0,0,1,0.09,0.04)",
                "rocker": "box(0:0.1,-0.35:-0.1,-0.05:0.05)",
            },
            {"thickness": 0.03, "minimise": "rotor"},
        ),
    ],
)
def test_parts_in_every_shape(model, balanced, regions, wishes):
    """Parts cut by planes and quadrics, and plates cut along circles."""
    answer = filled(regions, model, balanced, **wishes)
    assert answer.verdict == "feasible", answer.words
    parts = parts_of(answer.weights)
    assert "rough_part" not in [notice.code for notice in part_notices(parts)]
    files = part_files(parts)
    check_meshes(files, answer.weights)
    for weight in answer.weights:
        outside = weight.region.excess(
            weight.region.to_unit(
                next(p for p in parts if p.weight is weight).solid.points + weight.com
            )
        )
        assert outside.max() <= 2e-3
        if "thickness" in wishes:
            area, _ = outline_moments(files[f"{weight.link}.dxf"])
            mass = STEEL * 1e-6 * area * wishes["thickness"]
            assert mass == pytest.approx(weight.mass, rel=2e-6)


@pytest.mark.table(1)
@pytest.mark.parametrize("merge", [True, False])
def test_one_command_writes_parts_and_a_balanced_file_that_shows_them(
    merge, tmp_path, capsys, caplog, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    words = ["--balance", "force", "--links", "crank,rocker", "--density", "7850"]
    words += [f"--region={link}={text}" for link, text in ROOM.items()]
    words += ["--parts", "made", "--out", "heavier.urdf", *["--merge"] * merge]
    assert main(["counterweights", "four_bar_general", *words]) == 0
    assert "written: heavier.urdf, made" in caplog.text
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == [
        "README.txt",
        "crank.dxf",
        "crank.stl",
        "parts.csv",
        "rocker.dxf",
        "rocker.stl",
    ]
    text = (tmp_path / "heavier.urdf").read_text()
    assert text.count('filename="made/crank.stl" scale="0.001 0.001 0.001"') == 2
    space = balance.design_space("heavier.urdf", balance="force")
    assert space.as_given.balanced
    wanted = filled(ROOM).z
    masses = np.array([body.inertia for body in space.linkage.bodies])
    assert np.abs(masses - wanted).max() <= 1e-12 * np.abs(wanted).max()
    assert main(["verify", "heavier.urdf", "--trajectories", "1", "--balance", "force"]) == 0
    capsys.readouterr()


REFUSED = {
    "points": (["--parts", "made", "--points"], "point masses have no volume"),
    "in use": (["--parts", "full", "--density", "7850"], "give another folder, or --overwrite"),
    "a file": (["--parts", "full/old", "--density", "7850"], "is a file: give a folder"),
    "nowhere": (["--parts", "no/made", "--density", "7850"], "make it before --parts"),
}


@pytest.mark.table(2)
@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("verb", ["counterweights", "reduce"])
def test_folders_that_cannot_be_used_are_refused_before_any_work(
    verb, name, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "old").touch()
    words, told = REFUSED[name]
    more = ["--budget", "1"] * (verb == "reduce")
    assert main([verb, "four_bar_general", "--links", "crank", *words, *more]) == 2
    assert told in capsys.readouterr().err
    assert [path.name for path in tmp_path.rglob("*")] == ["full", "old"]


def test_a_missing_library_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(part_options, "find_spec", lambda name: None)
    words = ["--links", "crank", "--density", "7850", "--parts", str(tmp_path / "made")]
    assert main(["counterweights", "four_bar_general", *words]) == 2
    assert "screwbalance[parts]" in capsys.readouterr().err


def test_outline_and_table_of_a_plate_that_a_circle_cuts_agree():
    """Area times thickness is the volume in the table, though a circle cuts the box."""
    regions = {
        "crank": "box(-0.19:0.03,-0.35:0.1,-0.02:0.02,0,0,-0.2)",
        "rocker": "box(-0.13:0.11,-0.26:-0.11,-0.02:0.02)",
    }
    answer = filled(regions, minimise="rotor", price_of_mass=0.02)
    parts = parts_of(answer.weights)
    files = part_files(parts)
    for part in parts:
        row = table_of(files)[part.weight.link]
        assert part.solid.plate.circles  # a circle, not a line
        area, moment = outline_moments(files[part.outline])
        assert 1e-9 * area * row["thickness_mm"] == pytest.approx(row["volume_m3"], rel=2e-6)
        np.testing.assert_allclose(moment / area, 0.0, atol=1e-4)


def test_parts_without_an_outline_are_named(caplog, capsys, tmp_path):
    words = ["four_bar_general", "--balance", "force", "--links", "crank,rocker"]
    words += ["--region", f"rocker={ROOM['rocker']}", "--parts", str(tmp_path / "made")]
    assert main(["counterweights", *words]) == 0
    assert "no DXF of 'crank': it is not of one thickness" in caplog.text
    assert sorted(path.suffix for path in (tmp_path / "made").iterdir()) == sorted(
        [".csv", ".dxf", ".stl", ".stl", ".txt"]
    )
    capsys.readouterr()


def test_solids_need_a_folder_and_their_library(tmp_path, capsys, monkeypatch):
    words = ["counterweights", "four_bar_general", "--links", "crank", "--solids"]
    assert main(words) == 2
    assert "--solids needs --parts" in capsys.readouterr().err
    there = part_options.find_spec
    monkeypatch.setattr(
        part_options, "find_spec", lambda name: None if name == "build123d" else there(name)
    )
    assert main([*words, "--parts", str(tmp_path / "made")]) == 2
    assert "screwbalance[cad]" in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("regions", "wishes"),
    [
        ({"crank": "", "rocker": ""}, {"shape": "sector=0.02"}),
        ({"crank": "", "rocker": ""}, {"shape": "disc=0.02"}),
        ({"crank": "", "rocker": ""}, {}),
        (ROOM, {}),
        (
            {
                "crank": "cylinder(0,-0.1,0,1,2,3,0.15,0.2)",
                "rocker": "ellipsoid(0.1,-0.3,0,0.2,0.1,0.1,0.3,0.2,0.1)",
            },
            {},
        ),
        (
            {
                "crank": "box(-0.1:0.1,-0.3:0,-0.03:0.03,0.3,0.2,0.5)",
                "rocker": "box(-0.2:0.3,-0.5:0,-0.1:0.1)",
            },
            {"minimise": "rotor", "thickness": 0.03},
        ),
    ],
)
def test_exact_solids_have_the_mass_centre_and_inertia_of_the_answer(regions, wishes, tmp_path):
    """STEP read back by Open CASCADE, whose integrals are adaptive."""
    build123d = pytest.importorskip("build123d")
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    answer = filled(regions, **wishes)
    parts = parts_of(answer.weights)
    files = part_files(parts, solids=True)
    for part in parts:
        weight = part.weight
        assert table_of(files)[weight.link]["solid"] == part.step
        (tmp_path / part.step).write_bytes(files[part.step])
        solid = build123d.import_step(tmp_path / part.step)
        assert solid.is_valid
        found = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid.wrapped, found, 1e-10)
        assert STEEL * 1e-9 * found.Mass() == pytest.approx(weight.mass, rel=1e-6)
        centre, tensor = found.CentreOfMass(), found.MatrixOfInertia()
        size = 1e3 * np.sqrt(np.trace(weight.inertia) / weight.mass)
        at = [centre.X(), centre.Y(), centre.Z()]
        np.testing.assert_allclose(at, 0.0, atol=1e-6 * size)
        inertia = np.array([[tensor.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)])
        np.testing.assert_allclose(
            STEEL * 1e-15 * inertia, weight.inertia, atol=1e-6 * np.trace(weight.inertia)
        )


@pytest.mark.slow
def test_matter_that_shakes_least_has_parts_too(tmp_path, capsys):
    words = ["--links", "crank,rocker", "--density", "7850", "--budget", "1", "--balance"]
    out = tmp_path / "made"
    assert main(["reduce", "four_bar_general", *words, "force", "--parts", str(out)]) == 0
    rows = table_of({"parts.csv": (out / "parts.csv").read_bytes()})
    assert sum(row["mass_kg"] for row in rows.values()) == pytest.approx(1.0, rel=1e-4)
    for row in rows.values():
        mesh = trimesh.load(out / row["mesh"])
        assert mesh.volume * 1e-9 == pytest.approx(row["volume_m3"], rel=1e-6)
    capsys.readouterr()
