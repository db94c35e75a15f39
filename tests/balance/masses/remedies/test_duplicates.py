"""Copies in step: closed formulas, the momentum of whole files by Pinocchio, refusals."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import balance
import kinematics
from balance.masses.remedies.copies.duplicates import apply_duplicates
from balance.masses.remedies.copies.symmetric_copies import (
    Copy,
    four_group,
    place_of,
    single_copies,
)
from balance.masses.remedies.request import RemedyRequest
from kinematics.model.document.element import Document
from tests.support.remedy_requests import BALANCED_FORCE, PENDULUM, SLENDER, request_of, rod


def step_momentum(urdf: bytes, rng) -> np.ndarray:
    """Linear momentum, and angular momentum about the centre of mass, by Pinocchio's reader.

    Joints of copies have the positions and the rates of those that they copy, by name.
    """
    model = pin.buildModelFromXML(urdf.decode())
    data, q, v = model.createData(), pin.neutral(model), np.zeros(model.nv)
    drawn = {}
    for name, joint in zip(model.names, model.joints, strict=True):
        if joint.nv == 1:
            own = name.partition("_copy")[0]
            angle, rate = drawn.setdefault(own, rng.uniform(-2.0, 2.0, 2))
            turn = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
            q[joint.idx_q : joint.idx_q + joint.nq] = turn
            v[joint.idx_v] = rate
    return np.array(pin.computeCentroidalMomentum(model, data, q, v))


def rest_is_zero(urdf: bytes, size: float, seed=0) -> bool:
    rng = np.random.default_rng(seed)
    return max(np.abs(step_momentum(urdf, rng)).max() for _ in range(5)) <= 1e-12 * size


@pytest.mark.slow
def test_two_slender_rods_need_three_copies():
    """3 × 2 kg are added; the inputs feel four times 1/3 + 1/12 + 1.5² and four times 1/3."""
    request = request_of(*PENDULUM)
    three, one = apply_duplicates(request)
    assert three.verdict == "feasible" and three.added_mass == pytest.approx(6.0, abs=1e-8)
    assert three.mass_ratio == pytest.approx(3.0, abs=1e-8)
    felt = {"j_a": 1 / 3 + 1 / 12 + 1.5**2, "j_b": 1 / 3}
    for name, value in felt.items():
        assert three.input_inertia[name] == pytest.approx(4.0 * value, abs=1e-8)
    assert three.inertia_ratio == pytest.approx(4.0, abs=1e-8)
    assert three.residual <= 1e-9 and three.lost_freedoms == 0
    assert len(three.new_links) == 3 * 3 and len(three.details["copies"]) == 3
    assert rest_is_zero(three.urdf, 10.0) and not rest_is_zero(request.base.data, 10.0)
    again = kinematics.load(Document("again.urdf", three.urdf))
    assert again.mobility == 2 and again.planar
    assert balance.design_space(again).as_given.balanced
    # One copy takes the moment. The force of each arm is that of the textbook, with matter at
    # 0.25 m behind the second joint and 0.5 m behind the first; and the copy has 2 kg itself.
    second = 1.0 * 0.5 / 0.25
    first = (1.0 * 0.5 + (1.0 + second) * 1.0) / 0.5
    assert one.verdict == "feasible" and one.residual <= 1e-9
    assert one.added_mass == pytest.approx(2.0 * (first + second) + 2.0, rel=1e-6)


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize("seed", range(3))
def test_three_copies_balance_any_spatial_arm_and_two_do_not(seed):
    rng = np.random.default_rng(seed)
    parts, parent = [], "base"
    for k in range(3):
        place, com, axis = (" ".join(map(repr, rng.normal(size=3).tolist())) for _ in range(3))
        kind = "prismatic" if k == seed else "continuous"
        parts.append(rod(f"l{k}", parent, place, 1.0 + k, com, (0.2, 0.3, 0.4), kind, axis))
        parent = f"l{k}"
    (found,) = apply_duplicates(request_of(*parts))
    assert found.verdict == "feasible" and len(found.details["copies"]) == 3
    assert found.mass_ratio == pytest.approx(3.0, rel=1e-9) and found.residual <= 1e-9
    assert rest_is_zero(found.urdf, 100.0)
    for number in (1, 2, 3):
        light = found.urdf.decode()
        for k in range(3):
            old = f'<link name="l{k}_copy{number}">'
            start = light.index(old)
            mass = light.index("<mass", start)
            light = light[:mass] + light[mass:].replace(
                f'value="{1.0 + k!r}"', 'value="0.1"', 1
            )
        assert not rest_is_zero(light.encode(), 100.0)


def test_one_turned_copy_takes_the_moment_of_a_force_balanced_arm():
    (found,) = apply_duplicates(request_of(*BALANCED_FORCE))
    assert found.verdict == "feasible" and found.added_mass == pytest.approx(3.0, abs=1e-12)
    (copy,) = found.details["copies"]
    assert not copy["mirrored"] and copy["rotation"][2][2] == -1.0
    assert rest_is_zero(found.urdf, 10.0)


def test_one_copy_takes_a_force_along_a_line():
    """A slide and a rotor beside it: turned about the line across the slide that fits both."""
    slide = rod("s", "base", "0.3 0.2 0.4", 2.0, "0 0.1 0", SLENDER, "prismatic", "1 0 0")
    rotor = rod("w", "base", "0 1 0", 1.0, "0 0 0", (0.1, 0.1, 0.2))
    (found,) = apply_duplicates(request_of(slide, rotor))
    (copy,) = found.details["copies"]
    assert found.verdict == "feasible" and not copy["mirrored"]
    assert copy["rotation"] == [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]
    assert copy["point"][2] == pytest.approx(0.4, abs=1e-9)
    assert rest_is_zero(found.urdf, 10.0)


def test_a_mirrored_copy_where_no_turn_helps():
    """A force along x, moments along y and z: only the mirror with the normal x cancels all."""
    request = request_of(
        rod("s", "base", "0 0 0", 2.0, "0 0 0", SLENDER, "prismatic", "1 0 0"),
        rod("y", "base", "0 1 0", 1.0, "0 0 0", (0.1, 0.2, 0.1), axis="0 1 0"),
        rod("z", "base", "0 2 0", 1.0, "0 0 0", (0.1, 0.1, 0.2), axis="0 0 1"),
    )
    (found,) = apply_duplicates(request)
    assert found.verdict == "feasible"
    (copy,) = found.details["copies"]
    assert copy["mirrored"] and "normal" in copy["words"]
    # The whole map is -Q, and keeps y and z.
    np.testing.assert_allclose(-np.array(copy["rotation"]), np.diag([-1.0, 1.0, 1.0]))
    assert rest_is_zero(found.urdf, 10.0)


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", range(3))
def test_an_inverted_copy_balances_the_force_of_anything(seed):
    """The inversion is a mirroring: slides, screws and centres of mass change their signs."""
    rng = np.random.default_rng(10 + seed)
    parts, parent = [], "base"
    for k, kind in enumerate(["continuous", "prismatic", "continuous"]):
        place, com, axis = (" ".join(map(repr, rng.normal(size=3).tolist())) for _ in range(3))
        rpy = " ".join(map(repr, rng.uniform(-1, 1, 3).tolist()))
        part = rod(f"l{k}", parent, place, 1.0, com, (0.2, 0.3, 0.4), kind, axis)
        parts.append(part.replace('"/><parent', f'" rpy="{rpy}"/><parent'))
        parent = f"l{k}"
    (found,) = apply_duplicates(request_of(*parts, balance="force"))
    (copy,) = found.details["copies"]
    assert found.verdict == "feasible" and copy["mirrored"] and found.residual <= 1e-9
    rng = np.random.default_rng(seed)
    for _ in range(4):
        momentum = step_momentum(found.urdf, rng)
        assert np.abs(momentum[:3]).max() <= 1e-12 * 100 < np.abs(momentum[3:]).max()


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("model", "force"),
    [
        ("hprs", False),
        ("hprs", True),
        ("four_bar_general", True),
        ("slider_crank", False),
        ("sarrus", True),
    ],
)
def test_copies_of_loops_and_screws_keep_the_numbers_of_the_file(model, force):
    """Only signs change; `verify` confirms the file that is read again."""
    request = RemedyRequest(kinematics.load(model), balance="force" if force else "dynamic")
    found = next(apply_duplicates(request))
    count = len(found.details["copies"])
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert found.mass_ratio == pytest.approx(count, rel=1e-9)
    assert found.inertia_ratio == pytest.approx(count + 1, rel=1e-9)
    again = kinematics.load(Document("again.urdf", found.urdf))
    assert again.mobility == request.linkage.mobility
    assert len(again.loops) == (count + 1) * len(request.linkage.loops)

    for copy in range(count):
        suffix = "_copy" if count == 1 else f"_copy{copy + 1}"
        for tag in ("joint", "loop"):
            made = {item.name: item for item in again.tree.every(tag)}
            for item in request.linkage.tree.every(tag):
                both = zip(item.walk(), made[f"{item.name}{suffix}"].walk(), strict=False)
                for one, other in both:
                    for key in {"xyz", "rpy", "value"} & one.attributes.keys():
                        assert unsigned(other.attributes[key]) == unsigned(one.attributes[key])


def unsigned(text: str) -> list[str]:
    """The words of numbers without their signs."""
    return [word.lstrip("+-") for word in text.split()]


@pytest.mark.slow
def test_relations_of_the_linkage_are_those_of_its_copies():
    """A mimic joint: the copies have one too, and one input drives all."""
    parts = [
        PENDULUM[0],
        PENDULUM[1].replace("</joint>", '<mimic joint="j_a" multiplier="-2"/></joint>'),
    ]
    three, one = apply_duplicates(request_of(*parts))
    assert three.verdict == "feasible" and one.verdict == "feasible"
    assert kinematics.load(Document("again.urdf", three.urdf)).mobility == 1
    assert three.inertia_ratio == pytest.approx(4.0, rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_axis_that_momenta_leave_is_found(seed):
    """Slides in a tilted plane, and a balanced rotor across it: no axis of the file fits."""
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=rng).as_matrix()
    axes = [" ".join(map(repr, column.tolist())) for column in R.T]
    linkage = request_of(
        rod("a", "base", "0 0 0", 1.0, "0 0 0", SLENDER, "prismatic", axes[0]),
        rod("b", "a", "0 0 0", 1.0, "0 0 0", SLENDER, "prismatic", axes[1]),
        rod("c", "base", "0 0 0", 1.0, "0 0 0", (1.0, 1.0, 1.0), axis=axes[0]),
    ).linkage
    assert not linkage.planar
    turn = next(single_copies(linkage, (), True, place_of(linkage)))
    assert not turn.mirrored
    np.testing.assert_allclose(turn.rotation @ R[:, 2], R[:, 2], atol=1e-9)
    np.testing.assert_allclose(turn.rotation @ R[:, 0], -R[:, 0], atol=1e-9)


def test_the_pose_of_a_copy_keeps_its_point():
    point = np.array([0.3, -0.2, 0.7])
    for mirrored in (False, True):
        copy = Copy(np.diag([1.0, -1.0, -1.0]), mirrored, point, "")
        inside = -point if mirrored else point
        np.testing.assert_allclose(copy.pose[:3, :3] @ inside + copy.pose[:3, 3], point)


@pytest.mark.parametrize("model", ["four_bar_general", "three_rsr", "hprs"])
def test_balls_about_the_copies_do_not_overlap(model):
    """Nor does any joint leave its ball along random motions."""
    linkage = kinematics.load(model)
    place = place_of(linkage)
    centres = [place.centre] + [
        copy.pose[:3, :3] @ place.centre + copy.pose[:3, 3] for copy in four_group(place)
    ]
    for i, one in enumerate(centres):
        for other in centres[:i]:
            assert np.linalg.norm(one - other) >= 2.0 * place.radius * (1 - 1e-12)
    points = np.array([joint.point for joint in linkage.joints])
    assert np.linalg.norm(points - place.centre, axis=1).max() <= place.radius


def test_refusals_say_why():
    balanced = RemedyRequest(kinematics.load("four_bar_kite_balanced"))
    (found,) = apply_duplicates(balanced)
    assert found.verdict == "refused" and "needs no copy" in found.reason
    general = kinematics.load("four_bar_general", inputs=["q3"])
    (found,) = apply_duplicates(RemedyRequest(general))
    assert found.verdict == "refused" and "closes a loop" in found.reason
    text = rod("a", "base", "0 0 0", 1.0, "0.5 0 0", SLENDER, "universal", "0 0 1")
    (found,) = apply_duplicates(request_of(text))
    assert found.verdict == "refused" and "several degrees of freedom" in found.reason
