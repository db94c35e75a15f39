"""Spaces of several requirements equal null spaces of regressors at finite poses.

The second route is that of `tests/independent/reference.py`: clouds of points on bodies, loops
closed by Newton's method.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from kinematics import ScrewJoint, from_screws
from kinematics.errors import LinkageError, UsageError
from tests.independent.reference import decide, load
from tests.support.required_rows import parameters, region_of, rows_of

GRAVITY = (1.0, -2.0, 0.5)
# Requirements as text, and as quantity and region of the second route; A and B are inputs.
ONE_INPUT = [
    ["force", "dynamic at A=0.2"],
    ["gravity", "force y at A=0.1"],
    ["dynamic up to order 1 about A=0.1", "gravity"],
    ["moment about 0.3,-0.2,0.1", "force x"],
    ["moment", "moment about 0.4,0.1,0.3"],
    ["decoupled", "force"],
    ["moment z at A=0.2", "force x,y up to order 1"],
    ["force at A=0.15", "gravity"],
    ["dynamic at A=0.1", "dynamic at A=-0.15"],
    ["moment about 0.2,0,0.1 at A=0.1", "gravity", "force at A=-0.1"],
]
TWO_INPUTS = [
    ["dynamic along A=B", "force"],
    ["dynamic along A=B", "dynamic along A=-1*B", "gravity"],
    ["dynamic along B=A**2"],
    ["moment about 0.1,0.2,0 along B=A**2-0.3*A", "force x"],
    ["dynamic up to order 2 about A=0.1"],
    ["dynamic at A=0.1", "dynamic at B=0.2", "force z"],
]
ONE = [
    "four_bar_general",
    "four_bar_antiparallelogram",
    "slider_crank",
    "bennett",
    "rusr",
    "four_bar_kite",
    "four_bar_spherical",
    "six_bar_watt",
    "four_bar_parallelogram",
    "principal_vector_linkage_slider",
    "slider_pantograph",
]
MORE = [
    "five_bar",
    "hprs",
    "two_rrr",
    "fuga_i",
    "pantograph",
    "zero_reaction_arm",
    "principal_vector_linkage",
    "double_pendulum_duplicates",
    "four_rrr",
    "three_rrr",
    "three_rsr",
]
CASES = [(model, tuple(texts)) for texts in ONE_INPUT for model in ONE + MORE]
CASES += [(model, tuple(texts)) for texts in TWO_INPUTS for model in MORE]
# Neighbours in the table differ in linkage and list.
CASES = [CASES[(37 * k) % len(CASES)] for k in range(len(CASES))]


@pytest.mark.table(5)
@pytest.mark.parametrize(("model", "texts"), CASES, ids=str)
def test_the_space_is_the_null_space_of_regressors_at_finite_poses(model, texts):
    """Of the same dimension, and all of it fulfils the conditions."""
    mechanism, linkage = load(model), kinematics.load(model)
    names = list(linkage.inputs)
    first, second = names[0], names[1 % len(names)]
    texts = [text.replace("A", first).replace("B", second) for text in texts]
    space = balance.require(linkage, texts, gravity=GRAVITY)
    columns = parameters(mechanism, not linkage.planar, space.balance == "force")
    order = [mechanism.bodies.index(name) for name in space.bodies]
    width = len(columns) // len(order)
    rows = np.concatenate(
        [
            rows_of(
                mechanism, *region_of(text, names), not linkage.planar, np.array(GRAVITY), seed
            )
            for seed, text in enumerate(texts)
        ]
    )[:, columns]
    decision = decide(rows)
    assert decision.dropped < 1e-3 * decision.kept
    assert space.rank == (decision.rank if rows.any() else 0)
    by_body = rows.reshape(len(rows), -1, width)[:, order].reshape(len(rows), -1)
    basis = space.basis / np.linalg.norm(space.basis, axis=0)
    assert np.abs(by_body @ basis).max() < 1e-9 * max(1.0, np.abs(basis).max())
    assert not space.doubts


def test_the_order_of_requirements_does_not_matter():
    texts = ["force", "dynamic at u1=0.1", "moment along u2=u1**2"]
    spaces = [balance.require("five_bar", order) for order in (texts, texts[::-1])]
    spaces.append(balance.require("five_bar", "; ".join([*texts, texts[0]])))
    assert all(np.array_equal(space.basis, spaces[0].basis) for space in spaces)


def test_fuga_i_has_eight_dimensions():
    """In one pose, and of forces everywhere: 6 + 2 conditions (design of the source)."""
    space = balance.require("fuga_i", "force; dynamic at u1=0")
    assert (space.rank, space.nullity) == (8, 8)
    assert [(item.rank, item.adds) for item in space.requirements] == [(6, 2), (6, 2)]
    assert space.level == "verified"


@pytest.mark.slow
def test_the_three_rsr_on_three_planes():
    space = balance.require(
        "three_rsr", [f"dynamic along {x}" for x in ("u1=u2", "u2=u3", "u3=u1")]
    )
    assert (space.rank, space.nullity, space.level) == (41, 29, "verified")


@pytest.mark.parametrize("model", ["five_bar", "four_bar_antiparallelogram", "hprs"])
@pytest.mark.parametrize("kind", ["force", "dynamic"])
def test_one_requirement_everywhere_is_the_design_space(model, kind):
    space = balance.require(model, kind)
    alone = balance.design_space(model, balance=kind)
    assert (space.rank, space.serial_nullity) == (alone.rank, alone.serial_nullity)
    assert not [line for line in space.differences(alone) if not line.startswith("kmax")]


def test_moments_about_three_points_are_force_and_moment():
    """``ξ - c × p`` at three points off one line leaves neither ξ nor p."""
    points = ["0,0,0", "1,0,0", "0,1,0"]
    space = balance.require("hprs", [f"moment about {point}" for point in points])
    assert space.differences(balance.require("hprs", "dynamic")) == ()


def test_moments_about_two_points_leave_the_force_along_their_line():
    """``(c - c') × p`` vanishes: a slide along that line keeps its force, and no other does."""
    points = "moment about 0,0,0; moment about 1,0,0"
    for axis, rank in (((1, 0, 0), 2), ((0, 1, 0), 3)):
        slide = ScrewJoint("u1", "base", "slide", axis=axis, kind="prismatic")
        linkage = from_screws([slide], bodies={"slide": (1.0, (0, 0, 0), np.eye(3))})
        spaces = [
            balance.require(linkage, texts, spatial=True)
            for texts in (points, f"{points}; force x", "dynamic")
        ]
        assert [space.rank for space in spaces] == [rank, 3, 3]
        assert spaces[1].differences(spaces[2]) == ()


@pytest.mark.parametrize(
    ("model", "texts"),
    [
        ("five_bar", ["force", "dynamic at u1=0.1"]),
        pytest.param("four_bar_general", ["force", "gravity"], marks=pytest.mark.slow),
        pytest.param("slider_crank", ["force at u1=0.2"], marks=pytest.mark.slow),
    ],
)
def test_masses_of_a_space_of_requirements_meet_them(model, texts):
    """What `certify`, `feasible` and `fewest_rotors` say of such a space, by finite poses."""
    mechanism, linkage = load(model), kinematics.load(model)
    space = balance.require(linkage, texts, gravity=GRAVITY)
    assert balance.certify(space) is space
    answer = balance.masses.feasible(space)
    assert answer.verdict == "feasible"
    names = list(linkage.inputs)
    z = np.zeros((len(mechanism.links), 10))
    z[[mechanism.bodies.index(name) for name in space.bodies]] = answer.z
    for seed, text in enumerate(texts):
        rows = rows_of(
            mechanism, *region_of(text, names), not linkage.planar, np.array(GRAVITY), seed
        )
        by_body = np.einsum("rbp,bp->rb", rows.reshape(len(rows), -1, 10), z)
        assert np.abs(by_body.sum(axis=1)).max() < 1e-9 * np.abs(by_body).max()
    if space.balance == "dynamic":
        assert balance.masses.fewest_rotors(space).count == 0


def test_gravity_that_may_turn_is_force_balance():
    linkage = kinematics.load("hprs")
    ways = [balance.require(linkage, "gravity", gravity=g) for g in np.eye(3)]
    force = balance.require(linkage, "force")
    rows = np.concatenate([space.decision.conditions.rows for space in ways])
    assert np.linalg.matrix_rank(rows, tol=1e-9) == force.rank
    assert all(space.rank < force.rank for space in ways)
    assert np.abs(rows @ force.scaled_basis).max() < 1e-12


def test_a_moment_about_an_axis_of_the_plane_asks_for_nothing():
    space = balance.require("five_bar", "moment x; force")
    assert [(item.rank, item.adds) for item in space.requirements] == [(6, 6), (0, 0)]
    assert balance.require("five_bar", "moment x").nullity == 16


def test_moment_about_the_centre_of_mass_needs_force_balance():
    with pytest.raises(UsageError, match="require force there too"):
        balance.require("five_bar", "moment about com; force x")
    both = balance.require("five_bar", "moment about com; force")
    assert both.differences(balance.require("five_bar", "dynamic")) == ()


def test_a_file_of_a_path_is_a_path(tmp_path):
    """The samples of a straight path are those of the linear relation."""
    path = tmp_path / "way.csv"
    t = np.linspace(-0.3, 0.3, 13)
    path.write_text("u1,u2\n" + "".join(f"{x},{-x}\n" for x in t.tolist()))
    along = balance.require("five_bar", f"dynamic along {path}")
    assert along.differences(balance.require("five_bar", "dynamic along u2=-1*u1")) == ()


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("force q", 2, "cannot be read"),
        ("", 2, "cannot be read"),
        ("dynamic x", 2, "has no axes"),
        ("force about 0,0,0", 2, "about no point"),
        ("dynamic at u1=x", 2, "is no pose"),
        ("dynamic at u9=1", 3, "requirement 'dynamic at u9=1': joint u9 is not an input"),
        ("dynamic at u1=9", 3, "cannot be closed beyond"),
        ("dynamic along u2=q**2", 2, "'q' is not an input"),
        ("dynamic along u2=abs(u1)", 2, "smooth"),
        ("dynamic along u2=u1**2, u1=u2**2", 2, "given by others"),
        ("dynamic along u2=u1**", 2, "cannot read"),
        ("dynamic along u9=u1", 3, "u9"),
        ("dynamic along missing.csv", 3, "missing.csv"),
        ("dynamic up to order 99", 2, "highest order"),
        ("decoupled at u1=0", 2, "linear relations"),
    ],
)
def test_what_cannot_be_required_is_refused(text, code, words, capsys):
    assert main(["report", "five_bar", f"--require={text}"]) == code
    lines = capsys.readouterr().err.strip().splitlines()
    # What is wrong, and for a request where the help is.
    assert lines[1:] == ["balance report --help lists what there is"] * (code == 2)
    assert words in lines[0]


@pytest.mark.parametrize("value", [(0, 0, 0), (0, 1), (0, 0, np.nan)])
def test_gravity_is_a_direction(value):
    with pytest.raises(LinkageError, match="gravity has three"):
        balance.require("five_bar", "gravity", gravity=value)
