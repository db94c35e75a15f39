"""Certificates: what is changed is rejected, and what is accepted excludes what it says."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.checks import check_certificate, check_design
from balance.masses.designs.best_design import design
from balance.masses.designs.certificate_search import refine_matrices
from balance.masses.designs.constraints import constraints_of
from balance.masses.designs.feasibility import feasible
from balance.support.tolerances import CERTIFICATE_RANK_RELATIVE
from tests.support.laws import bounded_cloud, coordinates
from tests.support.shapes import conditions, functional, outside

PROVED = ["four_bar_general", "bennett", "three_rsr", "four_bar_spherical", "five_bar"]


def certified(model):
    space = design_space(kinematics.load(model))
    found = feasible(space)
    assert found.verdict == "infeasible"
    return space, found.certificate


@pytest.mark.parametrize("model", PROVED)
def test_certificates_are_sharp(model):
    """Eigenvalues, orthogonality and the margins left are round-off."""
    space, certificate = certified(model)
    check = check_certificate(space, certificate)
    assert check.accepted and check.separation < 1e-12
    assert check.eigenvalue > -1e-15 and check.orthogonality < 3e-13
    assert sum(np.trace(Z) for Z in certificate) == pytest.approx(1.0, rel=1e-12)


def test_a_singular_system_of_conditions_ends_the_refinement():
    """Two equal conditions among forty: their diagonal term is lost in round-off."""
    blocks = np.zeros((1, 40, 2, 2))
    blocks[0, :2] = np.diag([1.0, -0.5])
    refined = list(refine_matrices(blocks, np.eye(2)[None]))
    assert len(refined) == len(CERTIFICATE_RANK_RELATIVE)
    for Z in refined:
        assert np.trace(Z[0]) == pytest.approx(1.0, rel=1e-12)
        assert np.linalg.eigvalsh(Z[0]).min() >= 0.0


def changed(number, digit):
    """A number with another digit at a place after its first."""
    text = f"{number:.12e}"
    old = text[text.index(".") + digit]
    return float(text.replace(text, _swap(text, text.index(".") + digit, old)))


def _swap(text, at, old):
    return text[:at] + str((int(old) + 1) % 10) + text[at + 1 :]


@pytest.mark.parametrize("model", PROVED)
def test_one_digit_changed_is_rejected(model):
    """Any of the first nine digits of any entry that weighs at least a thousandth."""
    space, certificate = certified(model)
    rng = np.random.default_rng(4)
    tried = 0
    for b, i, j in rng.permutation(list(np.ndindex(np.shape(certificate))))[:40]:
        if i > j or abs(certificate[b][i, j]) < 1e-3:
            continue
        Z = np.array(certificate)
        Z[b, i, j] = Z[b, j, i] = changed(Z[b, i, j], int(rng.integers(1, 8)))
        assert not check_certificate(space, Z).accepted
        one = np.array(certificate)
        one[b, i, j] = Z[b, i, j]
        assert i == j or not check_certificate(space, one).accepted, "not symmetric"
        tried += 1
    assert tried > 3


def test_what_is_no_certificate_is_rejected():
    space, certificate = certified("four_bar_general")
    Z = np.array(certificate)
    # Of the same sums, and semidefinite to who reads but one triangle.
    skew = Z * (1.0 + 0.1 * (np.triu(np.ones((3, 3))) - np.tril(np.ones((3, 3)))))
    # The same trace of second moments; but of their parts only the sum is a condition.
    uneven = Z.copy()
    uneven[1] += 1e-3 * Z[1, 0, 0] * np.diag([1.0, -1.0, 0.0])
    assert np.linalg.eigvalsh(uneven[1])[0] > 0.0
    every = np.tile(np.eye(3), (3, 1, 1))
    for wrong in (0.0 * Z, -Z, Z * np.nan, every, Z[[1, 0, 2]], skew, uneven):
        assert not check_certificate(space, wrong).accepted
    assert check_certificate(space, 7.0 * Z).accepted
    with pytest.raises(ValueError, match="one matrix for each body"):
        check_certificate(space, Z[:2])


def test_a_feasible_space_has_no_certificate():
    """A design of margin μ gives any matrices of trace 1 at least that value."""
    space = design_space(kinematics.load("four_bar_kite"))
    z = feasible(space).z
    other, certificate = certified("four_bar_general")
    assert functional(space, certificate) @ z.reshape(-1) > 0.0
    assert not check_certificate(space, certificate).accepted


CLASHES = [
    ("four_bar_kite_balanced", ["rocker"], {"coupler": (0.4, 0.5)}),
    ("four_bar_kite_balanced", ["rocker"], {"coupler": (0.0, 0.1)}),
    ("four_bar_kite_balanced", ["rocker"], {"coupler": (0.5, 0.5)}),
    (
        "four_bar_antiparallelogram",
        [],
        {
            "coupler": (1.0, 2.0),
            "crank": (0.0, 0.1),
            "rocker": (0.0, 0.1),
        },
    ),
    ("four_bar_kite", ["crank"], {}),
    ("four_bar_kite", ["crank"], {"rocker": (0.5, 2.0)}),
    ("four_bar_kite", [], {"crank": (1.0, 1.0), "coupler": (1.0, 1.0)}),
]


@pytest.mark.parametrize(("model", "keep", "bounds"), CLASHES)
def test_restrictions_that_clash(model, keep, bounds):
    """The functional vanishes on balanced masses, but not on any that heed what is asked.

    The second is tried with bodies that do: clouds of points of the masses allowed.
    """
    space = design_space(kinematics.load(model))
    found = design(space, keep=keep, bounds=bounds)
    assert feasible(space).verdict == "feasible"
    assert found.verdict == "infeasible" and found.z is None
    asked = constraints_of(space, keep, bounds)
    assert check_certificate(space, found.certificate, asked).accepted
    value = functional(space, found.certificate)
    assert outside(value, conditions(space)) < 1e-7
    rng = np.random.default_rng(6)
    for _ in range(50):
        z = np.array(
            [bounded_cloud(rng, *bounds.get(name, (0.01, 5.0))) for name in space.bodies]
        )
        for b in asked.keep:
            z[b] = space.linkage.bodies[b].inertia
        assert value @ z.reshape(-1) > 0.0
    loose = {name: (low, 1e3) for name, (low, _) in bounds.items()}
    other = constraints_of(space, [], loose)
    assert not check_certificate(space, found.certificate, other).accepted


def test_a_certificate_holds_for_just_those_bounds_that_it_excludes():
    """A point mass, where the functional is least, tells how little it can be."""
    model, keep, bounds = CLASHES[3]
    space = design_space(kinematics.load(model))
    certificate = design(space, keep=keep, bounds=bounds).certificate
    places = [np.linalg.lstsq(Z[:2, :2], -Z[:2, 2])[0] for Z in certificate]
    unit = [np.r_[c, 1.0] @ Z @ np.r_[c, 1.0] for c, Z in zip(places, certificate, strict=True)]
    verdicts = set()
    for factor in np.geomspace(1.0, 300.0, 40):
        wider = {name: (low, factor * high) for name, (low, high) in bounds.items()}
        least = sum(
            min(m * value for m in wider[name])
            for name, value in zip(space.bodies, unit, strict=True)
        )
        accepted = check_certificate(
            space, certificate, constraints_of(space, [], wider)
        ).accepted
        assert accepted == (least >= 0.0), factor
        verdicts.add(accepted)
    assert verdicts == {True, False}


@pytest.mark.parametrize(("model", "motion"), [("four_bar_kite", None), ("three_rsr", "u2=u3")])
def test_a_design_with_one_entry_changed_is_rejected(model, motion):
    """By one part in a million: unless the entry is one that no condition sees."""
    space = design_space(kinematics.load(model), motion)
    z = feasible(space).z
    rows, seen = conditions(space), 0
    assert check_design(space, z).accepted
    for b, i in np.ndindex(z.shape):
        step = np.zeros_like(z)
        step[b, i] = 1e-6 * z[b, i]
        felt = np.abs(rows @ step.reshape(-1)).max() / (np.abs(rows).max() * np.abs(z).max())
        if felt > 1e-11:
            assert not check_design(space, z + step).accepted, (b, i)
            seen += 1
    assert seen > 5
    assert not check_design(space, -z).accepted and not check_design(space, 0.0 * z).accepted
    assert not check_design(space, np.full_like(z, np.nan)).accepted


@pytest.mark.parametrize("entry", [3, 8, 9])
def test_a_flat_design_stays_in_its_plane(entry):
    """No planar condition sees mcz, Exz and Eyz, which make moments out of the plane."""
    space = design_space(kinematics.load("four_bar_kite"))
    z = feasible(space).z.copy()
    z[1, entry] += 1e-6 * np.abs(z[1]).max()
    assert not check_design(space, z).accepted


def test_what_is_balanced_need_not_be_a_body():
    space = design_space(kinematics.load("three_rsr"), "u2=u3")
    z = feasible(space).z
    worst = (space.basis @ coordinates(space, seed=2)).reshape(7, 10)
    for share in (0.5, 1.0):
        mixed = (1.0 - share) * z + share * worst * (z[:, 0].sum() / worst[:, 0].sum())
        check = check_design(space, mixed)
        assert check.conditions < 1e-12 and check.eigenvalue < 0.0 and not check.accepted


def test_a_design_that_does_not_heed_what_is_asked_is_rejected():
    space = design_space(kinematics.load("four_bar_kite_balanced"))
    z = feasible(space).z
    mass = float(z[0, 0])
    asked = [
        {"bounds": {"crank": (0.9 * mass, 1.1 * mass)}},
        {"bounds": {"crank": (1.001 * mass, 2.0 * mass)}},
        {"bounds": {"crank": (0.0, 0.999 * mass)}},
        {"keep": ["rocker"]},
    ]
    restrictions = [
        constraints_of(space, **{"keep": [], "bounds": {}} | more) for more in asked
    ]
    heeded = [check_design(space, z, one).accepted for one in restrictions]
    assert heeded == [True, False, False, False]
