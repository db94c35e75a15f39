"""Webs that join shapes to their joints: geometry of unions, what is told, and when none is."""

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import balance
from balance.app.cli.main import main
from balance.masses.counterweights.region_text import read_region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, nearest_joint
from balance.masses.counterweights.shaped.webs import web_of, web_volume
from balance.masses.counterweights.shaped.weight_shape import read_weight_shapes

STEEL = 7850.0
NEEDED = 0.05  # kg m, what the link below needs on its other side


@pytest.mark.parametrize("text", ["disc=0.02", "block=0.02"])
def test_the_arm_of_a_shape_is_its_distance_from_the_nearest_joint(text, turned_arm):
    """Against the least distance of many points of the shape, in a frame that is turned."""
    space = balance.design_space(turned_arm, balance="force")
    (shape,) = read_weight_shapes(text)
    axes, _ = axes_and_height(space, 0)
    for centre in ([0.3, 0.1, 0.0], [0.2, -0.01, 0.05], [0.02, 0.03, 0.0]):
        region = shape.place(2.0, STEEL, np.array(centre), axes)
        grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 801)] * 2), axis=-1).reshape(-1, 2)
        inside = grid[region.excess(np.insert(grid, 2, 0.0, axis=1)) <= 0.0]
        points = region.to_link(np.insert(inside, 2, 0.0, axis=1))
        least = np.linalg.norm(points[:, :2], axis=1).min()
        assert nearest_joint(space, 0, region)[0] == pytest.approx(
            least, abs=2.0 * region.size / 800
        )


def test_webs_and_arms_of_discs_are_told_with_what_to_do(caplog, capsys):
    words = ["counterweights", "four_bar_general", "--balance", "force"]
    words += ["--links", "crank,rocker"]

    def run(*more):
        assert main([*words, *more]) == 0
        return " ".join(capsys.readouterr().out.split())

    text = run("--shape", "disc=20mm")
    assert "kg of discs with webs added" in text and "beside these webs" in text
    radius, wide = re.search(
        r"crank fills 100 % of a disc of radius (\S+) .*? web (\S+)", text
    ).groups()
    assert radius == wide and f"web {1e3 * float(radius):g} mm wide on 'crank'" in text
    assert "arm " not in text
    # This region does not hold the joint, nor a web from it.
    text = run("--shape", "disc=20mm", "--region", "crank=box(-0.2:0.1,-0.3:-0.02,-0.02:0.02)")
    assert "an arm that holds it is not counted: add its mass to the link" in text
    assert "arm from the nearest joint to the part" in text and "mm wide on 'rocker'" in text
    text = run("--shape", "sector=20mm")
    assert "arm " not in text and "web" not in text
    assert "layers which layer parts are in, and whether they collide" in text
    assert "layers" not in run()


SKEWED = [[0.3, 0.1, 0.0], [0.2, -0.01, 0.05], [0.055, 0.065, 0.0], [0.06, 0.02, 0.0]]


@pytest.mark.parametrize("centre", SKEWED)
@pytest.mark.parametrize("text", ["disc=0.02", "block=0.02", "cylinder=0.03"])
def test_a_web_is_counted_where_it_is_outside_its_shape(text, centre, turned_arm):
    """Against many points of the web, in a frame that is turned; no shape reaches the joint."""
    space = balance.design_space(turned_arm, balance="force")
    (shape,) = read_weight_shapes(text)
    axes, _ = axes_and_height(space, 0)
    part = shape.place(1.0, STEEL, np.array(centre), axes)
    web = web_of(space, 0, part, read_region("ball(0,0,0,1)"))
    assert web is not None
    steps = (np.arange(1200) + 0.5) / 600 - 1.0
    grid = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    points = web.to_link(np.insert(grid, 2, 0.0, axis=1))
    outside = points[~part.contains(points, 0.0)]
    area = web.volume / len(grid)
    p = np.column_stack([outside - web.centre, np.ones(len(outside))])
    shift = np.eye(4)
    shift[:3, 3] = web.centre
    thick = np.outer(axes[2], axes[2]) * np.sum(web.place[:3, 2] ** 2) / 3.0
    wanted = area * p.T @ p
    wanted[:3, :3] += thick * area * len(outside)
    back = np.linalg.inv(shift)
    told = back @ web_volume(web, part) @ back.T
    np.testing.assert_allclose(told[3, 3], wanted[3, 3], rtol=1e-3)
    np.testing.assert_allclose(told[:3, 3], wanted[:3, 3], atol=1e-3 * web.size * wanted[3, 3])
    np.testing.assert_allclose(
        told[:3, :3], wanted[:3, :3], atol=1e-3 * web.size**2 * wanted[3, 3]
    )


@pytest.mark.parametrize("centre", SKEWED)
@pytest.mark.parametrize("text", ["disc=0.02", "block=0.02", "cylinder=0.03"])
def test_shape_and_web_have_the_volume_of_the_union_of_two_solids(text, centre, turned_arm):
    manifold3d = pytest.importorskip("manifold3d")
    space = balance.design_space(turned_arm, balance="force")
    (shape,) = read_weight_shapes(text)
    part = shape.place(1.0, STEEL, np.array(centre), axes_and_height(space, 0)[0])
    web = web_of(space, 0, part, read_region("ball(0,0,0,1)"))
    bar = manifold3d.Manifold.cube((2.0, 2.0, 2.0), True).transform(1e3 * web.place[:3])
    if text.startswith("block"):
        solid = manifold3d.Manifold.cube((2.0, 2.0, 2.0), True)
    else:
        solid = manifold3d.Manifold.cylinder(2.0, 1.0, 1.0, 4096, True)
    union = 1e-9 * (solid.transform(1e3 * part.place[:3]) + bar).volume()
    together = part.volume + web_volume(web, part)[3, 3]
    assert together == pytest.approx(union, rel=3e-6)


def with_disc(arm, region, shape):
    """A steel disc on the first link of an arm."""
    options = dict(density=STEEL, shape=shape, balance="force")
    return balance.counterweights(arm, ["l1"], {"l1": region}, **options)


def test_webs_that_do_not_settle_are_not_counted(turned_arm, monkeypatch):
    """The answer is then the shape alone, with its arm."""
    monkeypatch.setattr("balance.masses.counterweights.shaped.webs.MOST_STEPS", 1)
    answer = with_disc(turned_arm, "ball(0,0,0,0.2)", "disc=0.02")
    (weight,) = answer.weights
    reach = np.sqrt(0.2**2 - 0.01**2)
    per = np.pi * 0.02 * STEEL
    a = brentq(lambda a: per * a * a * (reach - a) - NEEDED, 1e-9, 0.1, xtol=1e-15)
    assert weight.web is None and weight.mass == pytest.approx(per * a * a, rel=1e-6)
    assert weight.arm == pytest.approx(reach - 2.0 * a, rel=1e-6)


def test_a_disc_that_holds_its_joint_has_no_web(turned_arm):
    answer = with_disc(turned_arm, "ball(0,0,0,0.1)", "disc=0.014")
    (weight,) = answer.weights
    assert weight.web is None and weight.arm == 0.0
    assert STEEL * weight.region.volume == pytest.approx(weight.mass, rel=1e-12)
    assert "web" not in answer.words
