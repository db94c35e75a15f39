"""Regions from meshes: a box and a cut ball as files have the counterweights of the shapes."""

import numpy as np
import pytest
import trimesh

import balance
from balance.app.cli.main import main
from balance.masses.counterweights.region_text import read_region
from kinematics.errors import FileError, UsageError

BOX = "box(-0.09:-0.02,-0.03:0.03,0:0.012)"


def box_file(path, unit=1.0):
    low, high = np.array([-0.09, -0.03, 0.0]), np.array([-0.02, 0.03, 0.012])
    mesh = trimesh.creation.box(extents=(high - low) / unit)
    mesh.apply_translation(0.5 * (low + high) / unit)
    mesh.export(path)
    return path


@pytest.mark.parametrize(("kind", "unit"), [("stl", 1e-3), ("obj", 1.0)])
def test_a_box_from_a_file_is_the_box(kind, unit, tmp_path):
    path = box_file(tmp_path / f"free.{kind}", unit)
    region, box = read_region(f"mesh({path},{unit})"), read_region(BOX)
    assert region.volume == pytest.approx(box.volume, rel=1e-6)
    low, high = (f(region.to_link(region.vertices), axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose(low, [-0.09, -0.03, 0.0], atol=1e-8)
    np.testing.assert_allclose(high, [-0.02, 0.03, 0.012], atol=1e-8)


def test_matter_in_a_mesh_is_that_in_the_shape(tmp_path):
    path = box_file(tmp_path / "free.stl", 1e-3)
    answers = [
        balance.partial("four_bar_general", ["crank"], 0.1, regions={"crank": text})
        for text in (f"mesh({path},1mm)", BOX)
    ]
    masses, objectives = zip(*((a.mass, a.shaking.objective) for a in answers), strict=True)
    assert masses[0] == pytest.approx(masses[1], rel=1e-6)
    assert objectives[0] == pytest.approx(objectives[1], rel=1e-6)


def test_meshes_that_are_no_region(tmp_path):
    ring = trimesh.creation.annulus(0.02, 0.05, 0.01)
    ring.export(tmp_path / "ring.stl")
    holes = trimesh.creation.box()
    holes.update_faces(np.arange(len(holes.faces)) > 1)
    holes.export(tmp_path / "open.stl")
    (tmp_path / "bad.stl").write_text("no mesh")
    for name, text in (
        ("ring.stl", "not convex: its hull holds 19 % more"),
        ("open.stl", "is not closed"),
        ("bad.stl", "trimesh cannot read it|no mesh"),
        ("none.stl", "cannot be read"),
        ("part.step", "no format of one mesh"),
    ):
        with pytest.raises(FileError, match=text):
            read_region(f"mesh({tmp_path / name})")
    with pytest.raises(UsageError):
        read_region("mesh(ring.stl,0mm)")


def test_the_command_refuses_a_missing_mesh_with_one_line(capsys):
    words = ["counterweights", "four_bar_general", "--links", "crank"]
    assert main([*words, "--region", "crank=mesh(none.stl)"]) == 3
    assert capsys.readouterr().err.strip().splitlines()[0].count("none.stl") == 1
