"""Overconstrained loops that close only to the decimals of their file."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

import kinematics
from balance import design_space
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import LinkageError, MobilityError, OpenLoopError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.model.arrays import freeze
from kinematics.model.document.element import Document
from kinematics.model.spatial.screws import Ad
from tests.independent.certainty_cases import certainty_case
from tests.support.laws import altered
from tests.support.urdf_text import about, along, joint, link, loop, saved

# Models whose loops close only because their axes fulfil relations.
OVERCONSTRAINED = (
    "bennett",
    "goldberg_five_bar",
    "four_bar_general",
    "four_bar_spherical",
    "sarrus",
    "four_rrr",
    "four_bar_chain",
    "four_bar_parallelogram",
)


def spherical(folder, size, digits=12, seed=1):
    """A 3-RRR spherical manipulator; every origin and axis is off by up to ``size``."""
    rng = np.random.default_rng(seed)

    def near(x):
        return np.round(x + size * rng.uniform(-1, 1, 3), digits)

    def axis(azimuth, height):
        flat = np.cos(height)
        return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(height)])

    body = dict(mass=1.0, inertia=0.1 * np.eye(3))
    parts = [link("base"), link("top", **body, origin=along([0, 0, 0.3]))]
    first = 0.5 * axis(0.5, 0.9)
    for i in range(3):
        azimuth = 2 * np.pi * i / 3
        u, w, v = (axis(azimuth + a, h) for a, h in ((0, -0.6), (0.9, 0.1), (0.5, 0.9)))
        parts += [link(f"{part}{i}", **body, origin=along([0.1, 0.2, 0.05])) for part in "pd"]
        parts += [
            joint(f"a{i}", "continuous", "base", f"p{i}", along(near(0.5 * u)), near(u)),
            joint(f"b{i}", "continuous", f"p{i}", f"d{i}", along(near(0.5 * (w - u))), near(w)),
        ]
        end = along(near(0.5 * (v - w)))
        if i == 0:
            parts.append(joint("c0", "continuous", "d0", "top", end, near(v)))
        else:
            frames = end, along(near(0.5 * v - first))
            parts.append(loop(f"c{i}", "revolute", (f"d{i}", "top"), frames, near(v)))
    return saved(folder, *parts)


def remark(linkage):
    (text,) = [n.message for n in linkage.notices if n.code == "closes_to_rounding"]
    return text


def numbers(text):
    """Opening, angle and shift that a remark tells."""
    found = re.search(r"open by (\S+) .* by up to (\S+) rad and (\S+) m", text)
    return [float(x) for x in found.groups()]


def ranks(linkage):
    return [order.rank for order in design_space(linkage).orders]


def test_a_spherical_manipulator_with_rounded_axes(tmp_path):
    exact = kinematics.load(spherical(tmp_path, 0.0, digits=17))
    linkage = kinematics.load(spherical(tmp_path, 1e-6))
    assert linkage.mobility == exact.mobility == 3
    assert not exact.notices and linkage.inputs == exact.inputs
    assert ranks(linkage) == ranks(exact)
    assert design_space(linkage).nullity == design_space(exact).nullity
    opening, angle, shift = numbers(remark(linkage))
    assert 1e-7 < opening < 1e-5 and 0 < angle < 5e-6 and 1e-7 < shift < 5e-6
    assert "3 degrees of freedom" in remark(linkage) and "1e-04" in remark(linkage)
    # All axes meet in one point: by least squares on the lines themselves.
    ns = np.array([each.screw[:3] for each in linkage.joints])
    ms = np.array([each.screw[3:] for each in linkage.joints])
    blocks = np.concatenate([np.cross(n, np.eye(3)).T for n in ns])
    centre = np.linalg.lstsq(blocks, -ms.ravel(), rcond=None)[0]
    apart = [np.linalg.norm(m + np.cross(n, centre)) for n, m in zip(ns, ms, strict=True)]
    assert max(apart) < 1e-12 and np.linalg.norm(centre) < 5e-6


@pytest.mark.slow
def test_loops_with_moved_axes_close_at_finite_poses(tmp_path):
    """By products of rotations and least squares, from positions that are drawn."""
    linkage = kinematics.load(spherical(tmp_path, 1e-6))
    given = read_unassembled(spherical(tmp_path, 1e-6))
    starts = 0.3 * np.random.default_rng(2).standard_normal((4, 9))
    assert max(least_opening(linkage, q) for q in starts) < 1e-13
    assert least_opening(given, starts[0]) > 1e-8


def least_opening(linkage, start):
    """How far the loops stay open at the pose near a start that closes them best."""
    tight = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15) | {"max_nfev": 100}
    return np.abs(least_squares(lambda q: opened(linkage, q), start, **tight).fun).max()


def opened(linkage, q):
    """How far the loops are open at joint positions (n,), all joints being revolute."""
    H = []
    for each, angle in zip(linkage.joints, q, strict=True):
        n, m = each.screw[:3], each.screw[3:]
        before = H[each.parent] if each.parent >= 0 else np.eye(4)
        H.append(before @ about(n, angle, np.cross(n, m)))
    gaps = [H[each.end] @ np.linalg.inv(each.gap) - H[each.successor] for each in linkage.loops]
    return np.concatenate([gap[:3].ravel() for gap in gaps])


def test_axes_that_are_further_off_are_refused_with_the_gap(tmp_path):
    with pytest.raises(LinkageError, match="does not close") as caught:
        kinematics.load(spherical(tmp_path, 1e-3))
    text = str(caught.value)
    opening, angle, shift = numbers(text)
    assert 1e-4 < opening < 1e-2 and max(angle, shift) > 1e-4
    assert "3 degrees of freedom" in text and "1e-04 is no rounding" in text
    # What is more than that limit is told, and in parts of which size.
    change = float(re.search(r"that is (\S+) of the size of \S+ m", text)[1])
    assert change >= max(opening, angle) * 0.99 and change > 1e-4


def perturbed(draft, size, seed=1):
    """The draft with every axis turned and shifted by up to ``size``; loops stay closed."""
    rng, joints = np.random.default_rng(seed), []
    for each in draft.joints:
        H = about(rng.standard_normal(3), size * rng.uniform(-1, 1), each.point)
        H[:3, 3] += size * rng.uniform(-1, 1, 3)
        joints.append(replace(each, screw=freeze(Ad(H) @ each.screw)))
    return replace(draft, joints=tuple(joints))


@pytest.mark.table
@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-5])
@pytest.mark.parametrize("name", OVERCONSTRAINED)
def test_overconstrained_models_survive_rounding(name, size):
    """Parallel axes stay parallel, and the ranks are those of the linkage that is meant."""
    draft = read_unassembled(kinematics.gallery()[name])
    linkage, given = assemble(perturbed(draft, size)), assemble(draft)
    assert (linkage.mobility, linkage.planar) == (given.mobility, given.planar)
    assert ranks(linkage) == ranks(given)
    _, angle, shift = numbers(remark(linkage))
    assert max(angle, shift) < 5 * size and not given.notices


@pytest.mark.parametrize("name", ["bennett", "four_bar_spherical"])
def test_axes_taken_as_written_are_not_moved(name):
    draft = perturbed(read_unassembled(kinematics.gallery()[name]), 1e-6)
    with pytest.raises(MobilityError, match="rigid"):
        assemble(draft, exactly=True)


def test_axes_far_off_leave_a_rigid_linkage_and_say_how_far():
    draft = perturbed(read_unassembled(kinematics.gallery()["bennett"]), 1e-3)
    with pytest.raises(MobilityError, match="loops do not close: as written .* no rounding"):
        assemble(draft)


def test_a_loop_out_of_plane_by_rounding(tmp_path):
    """A planar loop with a micrometre between its planes: closed, or refused as written."""

    def lifted(robot):
        origin = robot.find("loop/successor/origin")
        x, y, _ = origin.get("xyz").split()
        origin.set("xyz", f"{x} {y} 0.000001")

    path = altered("four_bar_general", tmp_path, lifted)
    linkage = kinematics.load(path)
    assert linkage.planar and linkage.mobility == 1
    assert numbers(remark(linkage))[0] == pytest.approx(1e-6, rel=2.0)
    assert ranks(linkage) == ranks(kinematics.load("four_bar_general"))
    with pytest.raises(OpenLoopError) as caught:
        assemble(read_unassembled(path), exactly=True)
    assert caught.value.distance == pytest.approx(1e-6, rel=1e-6)


def test_pieces_of_rounded_loops_stay_where_the_file_has_them():
    """A parallelogram and a four-bar on one crank, with frames that turn, in 12 digits.

    With its axes as written, the parallelogram closes only where its modes of motion meet, and
    from there as an antiparallelogram.
    """
    case = certainty_case("coupled", 22212)
    linkage = assemble(read_unassembled(Document("coupled", case.text.encode())))
    assert np.abs(linkage.displaced if linkage.displaced is not None else 0.0).max() <= 1e-10
    assert {notice.code for notice in linkage.notices} >= {"closes_to_rounding"}
