"""Stacks through positions: their files by Pinocchio alone, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from balance import synthesize, verify
from balance.motion import from_csv
from balance.space import decoupling
from balance.studies.synthesis.constrained_motion import motion_csv
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.stack_designs import stack_designs
from kinematics import load
from kinematics.errors import SynthesisError, UsageError
from kinematics.model.document.element import Document
from tests.independent.synthesis_run import judge_task
from tests.support.covering import number_of_cases
from tests.support.planar_in_pinocchio import PlanarFile

THREE = [(0.3, 0.1, 0.2), (0.1, 0.4, -0.7), (-0.1, 0.5, 0.2)]
TASKS = {
    "turned in place": [(0.2, 0.1, 0.0), (0.2, 0.1, 1.0)],
    "three": THREE,
    "moved along": [(0.2, 0.1, 0.3), (0.5, 0.1, 0.3), (0.2, 0.4, 0.3), (0.5, 0.4, 0.3)],
}


def random_places(count, seed):
    rng = np.random.default_rng([count, seed])
    points, angles = rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(-0.6, 0.6, count)
    return [(*point, angle) for point, angle in zip(points.tolist(), angles, strict=True)]


def tool_of(model):
    frame = model.frame("tool")
    return frame.translation[:2], np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0])


@pytest.fixture(scope="module")
def stack():
    synthesis = synthesize(THREE, kind="stack")
    assert synthesis.verdict == "feasible", synthesis.words
    return synthesis


@pytest.mark.table(1)
@pytest.mark.parametrize("places", TASKS.values(), ids=TASKS)
def test_the_tool_is_at_the_positions(places):
    """Cranks turn by the printed angles, and the rest by Newton's method in Pinocchio."""
    design = next(stack_designs([Position(*each) for each in places]))
    model = PlanarFile(design.urdf, [f"crank_joint_{k}" for k in (1, 2, 3)])
    for turns, (x, y, angle) in zip(design.turns, places, strict=True):
        assert model.turn_to(turns) < np.pi
        at, turned = tool_of(model)
        assert np.abs(at - [x, y]).max() < 1e-9
        assert abs(np.angle(np.exp(1j * (turned - angle)))) < 1e-9


@pytest.mark.slow
def test_many_random_positions_are_met():
    """Of three to six within 69°, most are: each found one by Pinocchio."""
    cases, met = number_of_cases(4, 30), 0
    for seed in range(cases):
        places = random_places(3 + seed % 4, seed)
        design = next(stack_designs([Position(*each) for each in places]), None)
        if design is None:
            continue
        met += 1
        model = PlanarFile(design.urdf, [f"crank_joint_{k}" for k in (1, 2, 3)])
        for turns, (x, y, _) in zip(design.turns, places, strict=True):
            assert model.turn_to(turns) < np.pi
            assert np.abs(tool_of(model)[0] - [x, y]).max() < 1e-9
    assert met > 0.7 * cases


@pytest.mark.slow
def test_files_of_random_tasks_are_balanced_and_decoupled(tmp_path):
    """By Pinocchio from the written file; most tasks within 115° have a stack."""
    cases = number_of_cases(2, 20)
    lines = [
        judge_task("stack", 2 + seed % 4, seed, False, False, tmp_path) for seed in range(cases)
    ]
    assert not any(line.get("wrong") for line in lines), lines
    assert sum(line.get("met", 0) for line in lines) > 0.7 * cases


@pytest.mark.slow
def test_its_mass_matrix_is_that_of_decoupled_drives_on_a_base(stack):
    """By CRBA with the loops closed: no reactions, no term between drives, a rigid base."""
    best = stack.mechanisms[0]
    model = PlanarFile(best.urdf, best.table.inputs)
    rng, matrices = np.random.default_rng(3), []
    for _ in range(6):
        assert model.turn_to(rng.uniform(-0.4, 0.4, 3)) < np.pi
        matrices.append(model.mass_matrix())
    for M in matrices:
        own = np.sqrt(np.diagonal(M))
        shares = M / np.outer(own, own)
        between = shares[3:, 3:] - np.eye(3)
        assert np.abs(between).max() < 1e-9
        assert np.abs(shares[:3, 3:]).max() < 1e-9
    bases, drives = np.array([M[:3, :3] for M in matrices]), np.array(matrices)[:, 3:, 3:]
    assert np.ptp(bases, axis=0).max() < 1e-9 * np.abs(bases).max()
    # The drives do feel the pose: each inertia follows its own crank.
    assert np.ptp(drives, axis=0).max() > 1e-3 * np.abs(drives).max()


@pytest.mark.slow
def test_each_drive_feels_its_own_crank_alone(stack):
    """``m_k(q_k)``: the others turn, and the inertia at one crank stays."""
    best = stack.mechanisms[0]
    model, rng = PlanarFile(best.urdf, best.table.inputs), np.random.default_rng(5)
    for k in range(3):
        inertias = []
        for turns in rng.uniform(-0.4, 0.4, (3, 3)):
            turns[k] = 0.3
            assert model.turn_to(turns) < np.pi
            inertias.append(model.mass_matrix()[3 + k, 3 + k])
        assert np.ptp(inertias) < 1e-9 * max(inertias)


@pytest.mark.slow
def test_a_heavier_link_couples_the_drives_and_is_seen(stack):
    best = stack.mechanisms[0]
    mass = best.numbers["coupler_2_mass"]
    heavy = best.urdf.decode()
    at = heavy.index('<link name="coupler_2">')
    start = heavy.index("<mass value=", at)
    end = heavy.index("/>", start)
    heavy = f'{heavy[:start]}<mass value="{1.01 * mass!r}"{heavy[end:]}'
    model = PlanarFile(heavy.encode(), best.table.inputs)
    assert model.turn_to([0.2, -0.1, 0.3]) < np.pi
    M = model.mass_matrix()
    own = np.sqrt(np.diagonal(M))
    assert np.abs(M / np.outer(own, own))[:, 3:][:5].max() > 1e-6
    assert not verify(load(Document("heavy", heavy.encode())), trajectories=1).balanced


@pytest.mark.slow
def test_the_product_agrees(stack, tmp_path):
    """Design space, decoupling on a base that moves, and Pinocchio along the table."""
    best = stack.mechanisms[0]
    assert best.good and best.confirmation.coupling < 1e-10
    linkage = load(Document("stack", best.to_urdf()))
    assert linkage.mobility == 3
    assert decoupling(linkage).words.startswith("yes")
    (tmp_path / "way.csv").write_bytes(motion_csv(best.table))
    moved = from_csv(linkage, tmp_path / "way.csv")
    assert verify(linkage, motions=[moved]).balanced
    for name, turns in best.input_turns.items():
        k = linkage.inputs.index(name)
        assert moved.u[::120, k] == pytest.approx(turns, abs=1e-9)


def test_positions_that_turn_too_far_are_refused():
    with pytest.raises(SynthesisError, match="turns by up to 153°, and the positions differ"):
        synthesize([(0, 0, 0), (0.1, 0, 1.0), (0.2, 0, 2.9)], kind="stack")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"fixed": 0j}, "leave out the fixed"),
        ({"within": 0.01}, "leave out 'within'"),
        ({"ratio": -1.0}, "a ratio is for"),
        ({"density": None, "thickness": 0.01}, "points have none"),
    ],
)
def test_what_a_stack_has_no_use_for_is_refused(options, said):
    with pytest.raises(UsageError, match=said):
        synthesize(THREE, kind="stack", **options)


@pytest.mark.slow
def test_without_matter_the_answer_is_undecided():
    """Plates of a tenth of a millimetre hold no kilogram."""
    synthesis = synthesize(THREE[:2], kind="stack", thickness=1e-4)
    assert (synthesis.verdict, synthesis.mechanisms) == ("undecided", ())
    assert "denser or thicker matter" in synthesis.words
