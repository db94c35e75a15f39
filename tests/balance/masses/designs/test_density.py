"""Limits of density: which bodies there are, their solids, optima and certificates."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import kinematics
from balance import design, design_space
from balance.checks import check_certificate, check_design
from balance.masses.designs.certificate import _least_product
from balance.masses.designs.constraints import Constraints, constraints_of
from balance.masses.designs.density import DensityLimit, density_over_limit, solid_of
from balance.space.inertial_parameters.conversions import MassProperties
from kinematics.errors import LinkageError
from tests.fuzz.random_designs import (
    MOVED,
    _space,
    forms_of,
    mechanism_of,
    question,
    rows_of,
)
from tests.independent.second_densities import least
from tests.support.command_runs import asked
from tests.support.designs import design_of_any_density
from tests.support.json_answers import read_schema
from tests.support.shapes import matrix

STEEL = 7850.0
# Random questions that are cheap, and how they end.
SOME = {60_007: "feasible", 60_016: "feasible", 60_083: "infeasible"}


def pseudo_inertia(mass, centre, C):
    """``[[C + m c cᵀ, m c], [m cᵀ, m]]`` of second moments C about the centre of mass."""
    c = np.append(centre, 1.0)
    P = mass * np.outer(c, c)
    P[: len(C), : len(C)] += C
    return P


def second_moments(z):
    """Mass, centre and second moments about it, of parameters (10,)."""
    P = matrix(z)
    return P[3, 3], P[:3, 3] / P[3, 3], P[:3, :3] - np.outer(P[:3, 3], P[:3, 3]) / P[3, 3]


# --- which bodies there are -----------------------------------------------------------------


@pytest.mark.parametrize("seed", range(25))
def test_a_solid_at_the_limit_is_on_it(seed):
    """``(m / 5) a²`` and ``m = ρ (4/3) π a b c``; ``(m / 4) a²`` and ``m = ρ π a b t``."""
    rng = np.random.default_rng(seed)
    density, (a, b, c) = 10.0 ** rng.uniform(2, 4.3), 10.0 ** rng.uniform(-3, 0, 3)
    R = Rotation.random(random_state=rng).as_matrix()
    m = density * 4.0 / 3.0 * np.pi * a * b * c
    C = R @ np.diag([a**2, b**2, c**2]) @ R.T * m / 5.0
    P = pseudo_inertia(m, 0.1 * rng.standard_normal(3), C)
    assert density_over_limit(P, DensityLimit(density).least_moment) == pytest.approx(1, 1e-9)
    plate, turn = density * np.pi * a * b * c, R[:2, :2] / np.linalg.norm(R[0, :2])
    turn = np.array([turn[0], [-turn[0, 1], turn[0, 0]]])
    C = turn.T @ np.diag([a**2, b**2]) @ turn * plate / 4.0
    P = pseudo_inertia(plate, 0.1 * rng.standard_normal(2), C)
    kappa = DensityLimit(density, c).least_moment
    assert density_over_limit(P, kappa) == pytest.approx(1, 1e-9)


@pytest.mark.parametrize("flat", [False, True])
def test_no_body_is_beyond_the_limit(flat):
    """Boxes side by side, each of some density up to the limit."""
    rng = np.random.default_rng(flat)
    for _ in range(200):
        count, t = int(rng.integers(1, 4)), 0.02
        sides = rng.uniform(0.02, 0.3, (count, 3))
        sides[:, 2] = t if flat else sides[:, 2]
        places = np.cumsum(sides, axis=0) - 0.5 * sides
        places[:, 1:] = 0.0
        masses = STEEL * rng.uniform(0.3, 1.0, count) * np.prod(sides, axis=1)
        P = sum(
            pseudo_inertia(m, c, np.diag(side**2) * m / 12.0)
            for m, c, side in zip(masses, places, sides, strict=True)
        )
        limit = DensityLimit(STEEL, t if flat else None)
        P = P[np.ix_([0, 1, 3], [0, 1, 3])] if flat else P
        assert density_over_limit(P, limit.least_moment) < 1.0


def bodies_at_limits(count):
    """Bodies of designs whose densities are limited, and the solids that are printed."""
    asked_of = (
        ("three_rsr", "u2=u3", {"bounds": {"lower1": (5.0, 9.0)}}, 40.0),
        ("four_bar_antiparallelogram", None, {"bounds": {"coupler": (0.5, 2.0)}}, STEEL),
        ("four_bar_kite", None, {}, STEEL),
        ("slider_crank", None, {}, 100.0),
    )
    for model, motion, more, density in asked_of:
        space = design_space(model, motion)
        for minimise in ("mass", "rotor", "inertia", "change"):
            thickness = 0.01 if space.planar else None
            found = design(space, minimise, density=density, thickness=thickness, **more)
            assert found.verdict == "feasible"
            for body, solid in zip(found.bodies, found.to_dict()["bodies"], strict=True):
                yield body, solid["solid"], density
                count -= 1
                if not count:
                    return


@pytest.mark.slow
def test_the_printed_solid_has_the_inertia_of_its_body():
    """Integrals of a homogeneous ellipsoid and of an elliptic cylinder."""
    bodies, limits = list(bodies_at_limits(50)), 0
    assert len(bodies) == 50
    for body, solid, density in bodies:
        m, (a, b, c) = solid["mass_g"] / 1e3, np.array(solid["sizes_mm"]) / 2e3
        parts, volume = (5.0, 5.0, 5.0), 4.0 / 3.0 * np.pi * a * b * c
        if solid["shape"] == "plate":
            parts, volume = (4.0, 4.0, 3.0), 2.0 * np.pi * a * b * c
        Q = np.array(solid["directions"])
        C = Q.T @ np.diag(m * np.array([a, b, c]) ** 2 / parts) @ Q
        inertia = np.trace(C) * np.eye(3) - C
        assert np.abs(inertia - body.link_inertia).max() < 1e-9 * np.abs(inertia).max()
        assert m == pytest.approx(body.mass, rel=1e-12)
        assert np.allclose(np.array(solid["centre_mm"]) / 1e3, body.link_com, rtol=1e-12)
        assert solid["density"] == pytest.approx(m / volume, rel=1e-9)
        assert m / volume <= density * (1.0 + 1e-8)
        limits += m / volume > 0.999 * density
    assert limits >= 12


def test_a_solid_without_volume_has_no_density():
    rod = MassProperties(1.0, np.zeros(3), np.diag([0.0, 1.0, 1.0]))
    assert solid_of(rod).density == inf
    assert solid_of(MassProperties(1.0, np.zeros(3), np.diag([1.0, 1.0, 3.0]))) is None
    assert solid_of(MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))) is None


# --- optima ---------------------------------------------------------------------------------


def compare(seed, folder, factor=None):
    """Compare a random question at a limit of density with CVXPY; None if nothing is asked."""
    rng = np.random.default_rng(seed)
    one = question(seed, folder)
    # Where no ball bounds them, traces are bounded by a limit of their own.
    one = one._replace(within=one.within or 3.0)
    minimise = ("mass", "change")[seed % 2]
    try:
        space = _space(one.model, one.balance)
        if MOVED & {notice.code for notice in space.notices}:
            return None
        free = {"keep": one.keep, "bounds": one.bounds, "within": one.within}
        loose = design(space, minimise, **free)
    except LinkageError:
        return None
    if loose.z is None or loose.space is not space:
        return None
    thickness = 0.02 * space.length if space.planar else None
    pairs = [(loose.z[b], name) for b, name in enumerate(space.bodies) if name not in one.keep]
    needed = max(_needed(space, z, thickness) for z, _ in pairs)
    density = needed * (10.0 ** rng.uniform(-1.0, 0.1) if factor is None else factor)
    found = design(space, minimise, density=density, thickness=thickness, **free)
    mechanism = mechanism_of(one.model, space.inputs, space.bodies)
    rows = rows_of(one.model, one.balance, space.inputs, space.bodies)
    forms = forms_of(one, space, mechanism)
    try:
        value, status = least(
            found, one.keep, one.bounds, rows, mechanism, forms, density, thickness
        )
    except Exception as error:
        if type(error).__name__ != "SolverError":
            raise
        return None
    if found.verdict == "feasible":
        if status != "optimal":
            return None
        # The mass of the nearest of the lightest ones exceeds the least one by 1e-5 of it.
        most = value * (1.0 + 1e-5 * (minimise == "mass"))
        assert value * (1.0 - 1e-6) <= found.value + 1e-8, one
        assert found.value <= most * (1.0 + 1e-6) + 1e-8, one
        return "feasible"
    if found.verdict == "infeasible":
        assert status != "optimal", one
        return "infeasible"
    return "undecided"


def _needed(space, z, thickness):
    """Density of the ellipsoid, or of the plate, that has the inertia of a body."""
    m, _, C = second_moments(z)
    if thickness is None:
        return m / (4.0 / 3.0 * np.pi * np.sqrt(np.linalg.det(5.0 * C / m)))
    R = space.chain.frame.R[:2]
    return m / (thickness * np.pi * np.sqrt(np.linalg.det(4.0 * R @ C @ R.T / m)))


@pytest.mark.slow
def test_cvxpy_finds_the_same_optima(tmp_path):
    """Until 200 of them are feasible."""
    pytest.importorskip("cvxpy")
    ends, seed = [], 60_000
    while ends.count("feasible") < 200:
        ends.append(compare(seed, tmp_path))
        seed += 1
    assert ends.count("infeasible") >= 10
    assert ends.count("undecided") <= 2


@pytest.mark.parametrize("seed", SOME)
def test_cvxpy_finds_some_of_the_optima(seed, tmp_path):
    pytest.importorskip("cvxpy")
    assert compare(seed, tmp_path) == SOME[seed]


def test_the_least_change_keeps_to_the_limit():
    """Nearer designs are denser; without an objective the change is what is minimised."""
    space = design_space("four_bar_kite")
    limits = {"density": STEEL, "thickness": 0.01}
    free, found = design_of_any_density(space, "change"), design(space, "change", **limits)
    assert found.value > 1.01 * free.value and found.residuals.density == pytest.approx(1.0)
    asked_again = constraints_of(space, [], {}, 1.5, STEEL, 0.01)
    assert not check_design(space, free.z, asked_again).accepted
    assert check_design(space, found.z, asked_again).accepted
    implied = design(space, **limits)
    assert implied.minimise == "change" and implied.value == pytest.approx(found.value)
    wide = design(space, "change", density=1e9, thickness=0.01)
    assert wide.value == pytest.approx(free.value, rel=1e-9)


def test_flat_bodies_are_plates_of_the_thickness():
    space = design_space("four_bar_antiparallelogram")
    found = design(space, "mass", density=STEEL, thickness=0.02, bounds={"crank": (0.5, 2.0)})
    n = space.chain.frame.R[2]
    for z in found.z:
        m, _, C = second_moments(z)
        assert n @ C @ n == pytest.approx(m * 0.02**2 / 12.0, rel=1e-9)
    thick = constraints_of(space, [], {"crank": (0.5, 2.0)}, 1.5, STEEL, 0.0201)
    assert not check_design(space, found.z, thick).accepted


def test_a_kept_link_and_a_link_that_is_not_named_have_no_limit():
    space = design_space("four_bar_general", balance="force")
    found = design(space, "mass", density={"coupler": 5e4}, thickness=0.01, keep=["crank"])
    assert found.density == {"coupler": 5e4}
    assert [solid.shape for solid in found.solids] == ["ellipsoid", "plate", "ellipsoid"]
    assert np.array_equal(found.z[0], space.linkage.bodies[0].inertia)
    every = design(space, density=5e4, thickness=0.01, keep=["crank"])
    assert set(every.density) == {"coupler", "rocker"}


# --- certificates ---------------------------------------------------------------------------


def pendulum(tmp_path, axis):
    """One link on a pivot, whose centre of mass in the file is 0.4 m away."""
    path = tmp_path / "pendulum.urdf"
    path.write_text(
        '<robot name="pendulum"><link name="base"/><link name="arm"><inertial>'
        '<origin xyz="0.4 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.025" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="pivot" type="continuous">'
        f'<parent link="base"/><child link="arm"/><axis xyz="{axis}"/></joint></robot>',
        "utf-8",
    )
    return kinematics.load(str(path))


@pytest.mark.parametrize("spatial", [False, True])
def test_the_limit_of_a_link_on_a_pivot(spatial, tmp_path):
    """Its centre of mass is on the pivot, half of its length from the middle of its ball.

    With at least 2 kg within a ball of 0.8 of the length, ``tr C ≤ 2 (0.32² - 0.2²)``, and
    det C is largest if C is isotropic: a determinant that is 1e-3 too small is refused.
    """
    space = design_space(pendulum(tmp_path, "0 0 1"), balance="force", spatial=spatial)
    d, m, trace = 3 if spatial else 2, 2.0, 2.0 * (0.32**2 - 0.2**2)
    thickness = None if spatial else 0.01
    kappa = (trace / d) / m ** (1.0 + 2.0 / d)
    limit = 0.25 / (np.pi * kappa * 0.01) if d == 2 else 0.75 / np.pi * (5.0 * kappa) ** -1.5
    more = {"bounds": {"arm": (m, inf)}, "within": 0.8, "thickness": thickness}
    # det C at the limit goes with the density to the power of minus two.
    above = design(space, density=limit * (1.0 + 0.5e-3), **more)
    below = design(space, density=limit * (1.0 - 0.5e-3), **more)
    assert (above.verdict, below.verdict) == ("feasible", "infeasible")
    assert "at no more than" in below.words and "denser" in below.words
    assert check_certificate(
        space, below.certificate, below.constraints, below.multipliers
    ).accepted


def refused_kite():
    space = design_space("four_bar_kite")
    found = design(space, density=1e6, thickness=0.01, bounds={"coupler": (0.5, 2.0)})
    assert found.verdict == "infeasible" and found.multipliers.any()
    return space, found


def test_a_certificate_holds_for_its_question_alone():
    space, found = refused_kite()
    Z, spare, limits = np.array(found.certificate), found.multipliers, found.constraints

    def holds(Z=Z, spare=spare, limits=limits):
        return check_certificate(space, Z, limits, spare).accepted

    assert holds()
    easier = constraints_of(space, [], found.bounds, 1.5, 4e6, 0.01)
    assert design(space, density=4e6, thickness=0.01, bounds=found.bounds).verdict == "feasible"
    assert not holds(limits=easier)
    assert not holds(limits=limits._replace(densities={}))
    assert not holds(limits=limits._replace(densities={0: limits.densities[0]}))
    assert not holds(limits=limits._replace(bounds={1: (0.05, 2.0)}))
    assert not holds(limits=limits.anywhere)


def test_a_certificate_that_is_changed_is_refused():
    space, found = refused_kite()
    Z, spare = np.array(found.certificate), found.multipliers
    rng, corner = np.random.default_rng(0), np.zeros((3, 3))
    corner[-1, -1] = 1.0
    changed = [
        Z + 0.03 * np.abs(Z).max() * (S + S.transpose(0, 2, 1))
        for S in rng.standard_normal((20, *Z.shape))
    ]
    changed += [-Z, Z[[1, 0, 2]], np.zeros_like(Z), np.nan * Z]
    changed += [
        Z - 0.03 * np.abs(Z).max() * corner,
        Z * np.array([1.0, 1.0, 1.1])[:, None, None],
    ]
    for other in changed:
        assert not check_certificate(space, other, found.constraints, spare).accepted
    for other in (0.0 * spare, 2.0 * spare, -spare):
        assert not check_certificate(space, Z, found.constraints, other).accepted


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("seed", range(6))
def test_the_least_product_is_that_of_a_search(seed, d):
    """The least of ``<Z, P>`` over the bodies that a density allows, by another minimiser."""
    rng = np.random.default_rng(seed)
    space = design_space("four_bar_kite")
    length = space.chain.frame.length
    L = rng.standard_normal((d + 1, d + 1))
    Z = L @ L.T
    S, w = Z[:d, :d], Z[:d, -1]
    Z[-1, -1] = w @ np.linalg.solve(S, w) - rng.uniform(0.1, 2.0)
    limit = DensityLimit(1.0, 0.5 if d == 2 else None)
    low, high = ((0.0, inf), (0.3, 0.6), (2.0, inf))[seed % 3]
    limits = Constraints(bounds={0: (low, high)}, densities={0: limit})
    _, value = _least_product(space, Z, limits, 0)
    kappa = limit.least_moment / length**2

    def product(x):
        """Of a body at the limit: mass, centre, and a matrix of determinant 1."""
        m = np.exp(x[0])
        A = np.zeros((d, d))
        A[np.tril_indices(d)] = x[1 + d :]
        A[range(d), range(d)] = np.exp(np.diagonal(A) - np.trace(A) / d)
        C = kappa * m ** (1.0 + 2.0 / d) * A @ A.T
        return np.sum(Z * pseudo_inertia(m, x[1 : 1 + d], C))

    bounds = [(np.log(max(low, 1e-9)), np.log(min(high, 1e9)))]
    bounds += [(None, None)] * (d + d * (d + 1) // 2)
    best = min(
        minimize(
            product,
            rng.standard_normal(len(bounds)) * 0.3,
            bounds=bounds,
            options={"maxiter": 5000, "maxfun": 200_000, "ftol": 1e-15},
        ).fun
        for _ in range(3)
    )
    assert value <= best + 1e-9 * abs(best)
    assert value == pytest.approx(best, rel=1e-5)


# --- what is refused, and what is printed -----------------------------------------------------


REFUSED = [
    ("four_bar_kite", {"density": -1.0, "thickness": 0.01}, "density = -1.0: give a number"),
    (
        "four_bar_kite",
        {"density": (7850.0,), "thickness": 0.01},
        r"density = \(7850.0,\): give a number",
    ),
    ("four_bar_kite", {"density": inf, "thickness": 0.01}, "density = inf: give a number"),
    ("four_bar_kite", {"density": 1.0, "thickness": 0.0}, "thickness = 0.0: give a number"),
    ("four_bar_kite", {"density": {"bar": 1.0}, "thickness": 0.01}, "link 'bar'"),
    (
        "four_bar_kite",
        {"density": None, "thickness": 0.01},
        "limits nothing without a density",
    ),
    (
        "four_bar_kite",
        {"density": {"crank": 1.0}, "thickness": 0.01, "keep": ["crank"]},
        "is kept and has a density",
    ),
    ("bennett", {"density": 1.0, "thickness": 0.01}, "have no thickness"),
]


@pytest.mark.parametrize(("model", "asked_for", "text"), REFUSED)
def test_what_cannot_be_asked_is_refused_in_one_line(model, asked_for, text):
    with pytest.raises(ValueError, match=text) as caught:
        design(design_space(model, balance="force"), **asked_for)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ("four_bar_kite --density -3", 2, "'-3' is not a positive number"),
        ("four_bar_kite --density =3", 2, "names no link"),
        ("four_bar_kite --density 1 --thickness 0", 2, "'0' is not a positive number"),
        ("four_bar_kite --density bar=3 --thickness 0.01", 3, "link 'bar'"),
        ("four_bar_kite --density none --thickness 1", 3, "limits nothing without a density"),
        ("bennett --density 7850 --thickness 0.01", 3, "have no thickness"),
    ],
)
def test_the_command_refuses_in_one_line(words, code, text):
    outcome = asked(["design", *words.split()])
    said = [line for line in outcome.err.splitlines() if line.startswith("balance")]
    assert outcome.code == code and outcome.out == "" and text in said[0]


def test_the_command_prints_solids():
    """Of two densities the one of the link holds, and the others have the general one."""
    words = "design four_bar_kite --density 7850 --density coupler=2700 --thickness 0.01"
    outcome = asked(words.split())
    assert outcome.code == 0
    assert (
        "at most 2700 to 7850 kg/m³, links 10 mm thick (--density none lifts this); densest"
        in outcome.out
    )
    assert outcome.out.count("elliptic plate") == 3
    data = json.loads(asked([*words.split(), "--json"]).out)
    Draft202012Validator(read_schema("design")).validate(data)
    assert data["density"] == {"crank": 7850.0, "coupler": 2700.0, "rocker": 7850.0}
    assert data["thickness"] == 0.01
    assert data["bodies"][0]["solid"]["sizes_mm"][2] == pytest.approx(10.0)


def test_designs_are_of_steel_unless_another_density_is_asked_for():
    """A least mass of the crank of 5,300 times the density of steel is none."""
    space = design_space("four_bar_kite")
    found, thickness = design(space), 0.05 * space.length
    assert found.thickness == thickness and set(found.density.values()) == {STEEL}
    assert max(solid.density for solid in found.solids) == pytest.approx(STEEL, rel=1e-6)
    asked_for = constraints_of(space, [], {}, 1.5, STEEL, thickness)
    assert check_design(space, found.z, asked_for).accepted
    bounds = {"coupler": (0.5, 2.0)}
    assert design(space, "mass", bounds=bounds).verdict == "infeasible"
    dense = design_of_any_density(space, "mass", bounds=bounds)
    assert dense.verdict == "feasible" and dense.densest[1] > 5000.0 * STEEL


@pytest.mark.parametrize(
    ("options", "densities"),
    [
        ("", {"crank": 7850.0, "coupler": 7850.0, "rocker": 7850.0}),
        ("--density coupler=brass", {"crank": 7850.0, "coupler": 8500.0, "rocker": 7850.0}),
        ("--density none --density coupler=brass", {"coupler": 8500.0}),
        ("--density none", {}),
    ],
)
def test_links_without_another_density_are_of_steel(options, densities):
    outcome = asked(["design", "four_bar_kite", "--json", *options.split()])
    assert outcome.code == 0 and json.loads(outcome.out)["density"] == densities


def test_every_design_tells_its_densest_body():
    """Of 17 times the density of steel here."""
    found = design_of_any_density("four_bar_kite")
    name, density = found.densest
    z = found.z[found.space.bodies.index(name)]
    assert name == "crank" and density == pytest.approx(_needed(found.space, z, None))
    assert "densest body: crank, " in asked(["design", "four_bar_kite"]).out
    assert replace(found, z=None).densest is None
