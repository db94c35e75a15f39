"""The independent route is sound, the gallery is sound, and every figure comes out.

Ranks are decided at 1e-11 of the largest singular value. Double precision leaves zeros
near 1e-15, and the smallest singular value that counts is 7e-8 (3-RSR with u2 = u3, whose
last condition is scaled by ``radius**4``), so two decades on each side are asked for: a
rank that came out by luck would fail.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.independent.reference import (
    Decision,
    closure,
    displacements,
    follow,
    load,
    motion_basis,
    rank_over_poses,
    ranks_by_order,
    regressor,
    velocities,
)
from tests.independent.reference_model import Mechanism, hat
from tests.support.covering import spread
from tests.support.figures import DESIGNS, FIGURES, Figure

GALLERY = sorted(Path(__file__).resolve().parents[2].glob("urdf_models/*.urdf"))
MODELS = [path.stem for path in GALLERY]
# Models with bodies that are point masses.
POINT_MASSES = {"slider_pantograph", "pantograph_reaction_wheel"}


def check(decision: Decision, rank: int) -> None:
    """The rank is as expected and lies in a wide gap."""
    assert decision.rank == rank
    assert decision.kept > 1e-9
    assert decision.dropped < 1e-13


def moved(mechanism: Mechanism, reach: float, motion: tuple[str, ...] = (), seed: int = 3):
    """A random pose and the joint rates of its motions; shapes (n,) and (n, nw)."""
    basis = motion_basis(mechanism, motion)
    inputs = basis @ np.random.default_rng(seed).uniform(-reach, reach, basis.shape[1])
    q = follow(mechanism, np.zeros(len(mechanism.joints)), inputs)
    return q, velocities(mechanism, q, basis)


@pytest.mark.table
@pytest.mark.parametrize("figure", spread(FIGURES, 2, 1), ids=str)
def test_design_space_has_its_size(figure: Figure):
    """Stacked over random finite poses, the conditions have the final rank."""
    decision = rank_over_poses(
        load(figure.model), figure.motion, figure.balance, figure.spatial, reach=figure.reach
    )
    check(decision, figure.ranks[-1])
    if figure.serial is not None and figure.parallel is not None:
        assert figure.nullity == figure.serial + figure.parallel


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize("figure", spread(FIGURES, 3, 0), ids=str)
def test_rank_grows_order_by_order(figure: Figure):
    """The conditions up to each order have the rank of the table, and then two plateaus."""
    decisions = ranks_by_order(
        load(figure.model),
        figure.kmax + 2,
        figure.motion,
        figure.balance,
        figure.spatial,
        radius=figure.radius,
        samples=figure.samples,
    )
    for decision, rank in zip(decisions, (*figure.ranks, *figure.ranks[-1:] * 2), strict=True):
        check(decision, rank)


@pytest.mark.slow
def test_ranks_do_not_depend_on_the_inputs():
    """The 4-RRR is driven by three legs, or by the three joints of its first leg."""
    mechanism = load("four_rrr", ("a1", "b1", "c1"))
    decisions = ranks_by_order(mechanism, 2, (), "force", False, radius=0.04)
    assert [decision.rank for decision in decisions] == [6, 12, 12]


@pytest.mark.table(26)
@pytest.mark.parametrize("model", MODELS)
def test_rates_are_the_derivative_of_poses(model: str):
    """The loops stay closed to first order: an imaginary step of 1e-30 loses no digits."""
    mechanism = load(model)
    q, rates = moved(mechanism, 0.2)
    step = 1e-30j * np.random.default_rng(4).standard_normal(len(mechanism.inputs))
    gap = closure(mechanism, q + rates @ step)[0]
    assert np.abs(gap.real).max(initial=0) < 1e-14
    assert np.abs(gap.imag).max(initial=0) < 1e-44
    assert rates[list(mechanism.inputs)] == pytest.approx(np.eye(len(mechanism.inputs)))


@pytest.mark.table
@pytest.mark.parametrize("model", MODELS)
def test_linear_momentum_is_the_rate_of_the_mass_moment(model: str):
    """``p = d/dt Σ m c``, the sum differentiated by an imaginary step."""
    mechanism = load(model)
    q, rates = moved(mechanism, 0.2)
    momentum = regressor(mechanism, q, rates) @ mechanism.inertias.ravel()
    placed = displacements(mechanism, q + 1e-30j * rates[:, 0])[0]
    mass_moment = sum(
        placed[link][:3] @ [*z[1:4], z[0]]
        for link, z in zip(mechanism.links, mechanism.inertias, strict=True)
    )
    assert momentum[3:6] == pytest.approx(mass_moment.imag * 1e30, abs=1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_momentum_at_the_reference_pose_is_that_of_the_textbook(model: str):
    """``ξ = E ω + mc × v`` and ``p = m v - mc × ω`` where all displacements are 1."""
    mechanism = load(model)
    q, rates = moved(mechanism, 0.0)
    spins = displacements(mechanism, q)[1]
    expected = np.zeros(6)
    for link, z in zip(mechanism.links, mechanism.inertias, strict=True):
        twist = np.zeros((4, 4))
        while link >= 0:
            twist += spins[link] * rates[link, 0]
            link = mechanism.parents[link]
        omega, v = np.array([twist[2, 1], twist[0, 2], twist[1, 0]]), twist[:3, 3]
        tensor = z[[4, 7, 8, 7, 5, 9, 8, 9, 6]].reshape(3, 3)
        expected[:3] += tensor @ omega + hat(z[1:4]) @ v
        expected[3:] += z[0] * v - hat(z[1:4]) @ omega
    momentum = regressor(mechanism, q, rates)[:6] @ mechanism.inertias.ravel()
    assert momentum == pytest.approx(expected, abs=1e-12)


def test_the_branch_is_kept():
    """Far from the reference pose the antiparallelogram is still crossed.

    Its angular velocities obey ``ω1 - ω2 + ω3 = 0``; those of the parallelogram that has
    the same links do not.
    """
    mechanism = load("four_bar_antiparallelogram")
    for angle in (-1.5, -0.8, 0.4, 0.9):
        q = follow(mechanism, np.zeros(3), np.array([angle]))
        crank, coupler, rocker = velocities(mechanism, q, np.eye(1))[:, 0]
        assert crank - (crank + coupler) + rocker == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("motion", [("u2=u3",), ("u1=u3",), ("u1=u2",)])
def test_the_three_rsr_of_the_thesis_is_balanced_on_its_planes(motion: tuple[str, ...]):
    """The inertias of the file are table 5.4: no momentum on a plane of symmetry."""
    mechanism = load("three_rsr")
    q, rates = moved(mechanism, 0.3, motion)
    momentum = regressor(mechanism, q, rates) @ mechanism.inertias.ravel()
    # Momenta of single links are near 10; the decimals of sqrt(3)/2 and sums leave 1e-14.
    assert np.abs(momentum).max() < 1e-12
    q, rates = moved(mechanism, 0.3)
    assert np.abs(regressor(mechanism, q, rates) @ mechanism.inertias.ravel()).max() > 1e-3


@pytest.mark.parametrize("model", MODELS)
def test_bodies_are_physical(model: str):
    """The pseudo-inertia of every body is positive definite; of point masses semidefinite."""
    for z in load(model).inertias:
        tensor = z[[4, 7, 8, 7, 5, 9, 8, 9, 6]].reshape(3, 3)
        second = np.trace(tensor) / 2 * np.eye(3) - tensor
        pseudo = np.block([[second, z[1:4, None]], [z[None, 1:4], z[0]]])
        least = np.linalg.eigvalsh(pseudo)[0]
        assert least > 0 or (model in POINT_MASSES and least > -1e-15)


def test_the_gallery_is_described():
    """Each model has a row in the table of figures, or the geometry of one that has."""
    readme = (GALLERY[0].parent / "README.md").read_text(encoding="utf-8")
    for model in MODELS:
        assert DESIGNS.get(model, model) in {figure.model for figure in FIGURES}
        assert f"`{model}`" in readme
        assert load(model).name == model
