"""How sure an answer is: what is proved, what is verified, and what is an estimate."""

import json
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from scipy.linalg import expm

import kinematics
from balance import certify, design_space
from balance.app.answers.data import schema
from balance.app.cli.main import main
from balance.motion.verification.trajectory import random_motions
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.inputs.geometry import four_bar_chain, variants
from kinematics.model.spatial.screws import hat
from kinematics.numerics.linalg.pivoted_qr import RANK_RELATIVE
from tests.independent.checker import check
from tests.support.covering import spread
from tests.support.figures import FIGURES, Figure
from tests.support.laws import altered, known, space
from tests.support.proofs import arm, proof_of

# The table has it with the forces alone.
FOUR_RRR = Figure("four_rrr", (9, 24), 12, 0, 36)
ROWS = (*FIGURES, FOUR_RRR)
# Of sqrt(3) its file has 17 digits: two conditions of low order hold only without them.
ROUNDED = "three_rsr"


def expected_level(figure):
    """What has a parallel part is verified, and what stands on rounded numbers."""
    rounded = figure.model == ROUNDED and not figure.motion and figure.balance == "dynamic"
    return "verified" if figure.parallel or rounded else "proved"


def certified(model):
    """The certified design space of a file."""
    return certify(design_space(kinematics.load(model)))


@pytest.mark.table
@pytest.mark.parametrize("figure", spread(ROWS, 3, 1), ids=str)
def test_what_has_no_parallel_part_is_proved_and_the_rest_verified(figure):
    found = known(figure)
    certainty = found.certainty
    assert certainty.level == expected_level(figure)
    assert certainty.reason and "\n" not in certainty.reason
    assert (certainty.rank, certainty.nullity) == (found.rank, figure.serial)
    assert certainty.poses > 0 and certainty.residual < 1e-10
    assert (certainty.proof is None) == (certainty.level == "verified")
    if certainty.proof:
        assert (certainty.proof.rank, certainty.proof.nullity) == (found.rank, found.nullity)
        check(proof_of(found))
    report = found.to_dict()
    assert report["certainty"] == certainty.level
    assert report["evidence"]["reason"] == certainty.reason


def test_serial_arms_are_proved(tmp_path):
    """Five for the first joint, and three for each of the two that are skew to it."""
    found = certified(arm(tmp_path))
    assert (found.nullity, found.certainty.level) == (11, "proved")
    check(proof_of(found))


@pytest.mark.table(2)
@pytest.mark.parametrize("digits", range(2, 15))
def test_a_margin_falls_with_what_makes_it_down_to_the_floor(digits, tmp_path):
    """The base of an antiparallelogram longer by a part δ of 10^-digits.

    The eighth singular value is 0.0326 δ of the first: beyond δ = 2.8e-11 it is less than
    the floor of 2^-40 = 9.1e-13, below which nothing counts as a condition.
    """

    def lengthened(robot):
        longer = f"{10**digits + 1}"
        robot.find("joint[@name='q4']/origin").set("xyz", f"{longer[0]}.{longer[1:]} 0 0")
        shorter = (
            f"-0.488{'0' * (digits - 4)}1" if digits > 3 else f"-{0.488 + 10**-digits:.3f}"
        )
        robot.find("loop/successor/origin").set("xyz", f"{shorter} -0.384 0")

    model = "four_bar_antiparallelogram"
    found = design_space(kinematics.load(altered(model, tmp_path, lengthened)))
    assert exact_ranks(found).rank == 8
    sure, margin = certify(found), 0.032615 * 10.0**-digits
    certainty = sure.certainty
    assert (certainty.rank, certainty.nullity) == (8, 4)
    if margin > RANK_RELATIVE:
        assert found.rank == 8
        assert found.kept == pytest.approx(margin, rel=0.01)
        thin = [notice.code for notice in found.notices] == ["thin_margin"]
        assert thin == (found.kept < 1e3 * RANK_RELATIVE)
    else:
        assert digits > 10 and RANK_RELATIVE == 2.0**-40 and found.rank == 7
    assert [order.rank for order in sure.orders] == [3, 6, 7, 8]
    assert (sure.nullity, sure.kmax, certainty.level) == (4, 3, "proved")
    corrected = [notice for notice in sure.notices if notice.code == "corrected"]
    assert bool(corrected) == (margin <= RANK_RELATIVE)
    check(proof_of(sure))


def with_axis(name, axis):
    def change(robot):
        robot.find(f"joint[@name='{name}']/axis").set("xyz", axis)

    return change


def test_what_exact_arithmetic_refuses_falls_back_and_says_so(tmp_path):
    rounded = with_axis("q2", "0.360000000000001 0.48 0.8")
    path = altered("bennett_rational", tmp_path, rounded)
    found = certify(design_space(kinematics.load(path, angles="as_written")))
    assert (found.rank, found.certainty.level) == (13, "estimated")
    assert found.doubts[0].startswith("rank: the parallel part of 1 rests on floating point")
    assert "not exactly representable" in found.certainty.reason
    tilted = with_axis("q2", "0 0.0000000001 1")
    found = certified(altered("four_bar_general", tmp_path, tilted))
    assert (found.rank, found.certainty.level) == (8, "estimated")
    assert "planar only up to rounding" in found.certainty.reason
    from yourdfpy import URDF

    found = certified(URDF.load(str(arm(tmp_path)), load_meshes=False))
    assert (found.nullity, found.certainty.level) == (11, "estimated")
    assert "decimals of a URDF file" in found.certainty.reason
    assert found.certainty.rank is found.certainty.nullity is found.certainty.proof is None
    found = certify(design_space(variants("four_bar_general", 1)[0]))
    assert (found.rank, found.certainty.level) == (8, "estimated")


@pytest.mark.parametrize("tilt, doubted", [("0.00000000001", True), ("1e-17", False)])
def test_what_is_in_doubt_is_an_estimate(tilt, doubted, tmp_path, capsys):
    """An axis that is parallel to the others to within 1e-11, or to double precision."""
    path = altered("four_bar_kite", tmp_path, with_axis("q2", f"0 {tilt} 1"))
    found = certified(path)
    assert bool(found.certainty.doubts) == doubted
    assert not doubted or found.certainty.level == "estimated"
    assert main(["report", str(path), "--json"]) == (4 if doubted else 0)
    assert bool(json.loads(capsys.readouterr().out)["evidence"]["doubts"]) == doubted


BREAKS = {
    "an order": lambda space: {
        "orders": (*space.orders[:1], space.orders[0]._replace(rank=4), *space.orders[2:])
    },
    "one order less": lambda space: {"orders": space.orders[:-1]},
    "the serial part": lambda space: {"serial_nullity": space.serial_nullity - 1},
    "the rank": lambda space: {
        "decision": space.decision.with_basis(space.decision.basis[:, 1:])
    },
}


@pytest.mark.parametrize("change", BREAKS)
def test_no_integer_is_proved_but_the_exact_one(change):
    """An answer with another integer, however it came about, is not printed as proved."""
    space = certify(design_space(kinematics.load("four_bar_general")))
    assert space.to_dict()["certainty"] == "proved"
    broken = replace(space, **BREAKS[change](space))
    with pytest.raises(AssertionError, match="proved"):
        broken.to_dict()


def test_masses_and_names_do_not_make_a_linkage_another_one():
    linkage = kinematics.load("four_bar_general")
    bodies = tuple(replace(body, inertia=2.0 * body.inertia) for body in linkage.bodies)
    both = (linkage, replace(linkage, bodies=bodies))
    one, other = (certify(design_space(each)).certainty for each in both)
    assert one == other and one.level == "proved"


@pytest.mark.table(3)
@pytest.mark.parametrize("figure", [f for f in ROWS if f.kmax > 1 and not f.motion], ids=str)
def test_orders_that_are_not_enough_are_an_estimate(figure):
    found = certify(space(figure, max_order=figure.kmax - 1))
    certainty = found.certainty
    assert certainty.level == "estimated" and certainty.reason and certainty.proof is None
    assert not found.settled and certainty.residual > 1e-8
    assert not certainty.doubts and (certainty.rank == found.rank or figure.model == ROUNDED)


@pytest.mark.parametrize(
    "words, code",
    [
        ("four_bar_general --certainty proved", 0),
        ("four_bar_general --certainty verified", 0),
        ("four_bar_kite --certainty proved", 4),
        ("four_bar_kite --certainty verified", 0),
        ("four_bar_general --max-order 2 --certainty verified", 4),
        ("four_bar_general --max-order 2", 0),
        ("four_bar_kite --max-order 1 --certainty verified", 4),
        ("hprs --certainty proved", 0),
    ],
)
def test_the_certainty_that_is_required(words, code, capsys):
    """The answer is printed all the same."""
    assert main(["report", *words.split(), "--json"]) == code
    assert json.loads(capsys.readouterr().out)["certainty"] in (
        "proved",
        "verified",
        "estimated",
    )


@pytest.mark.parametrize(
    "words",
    ["four_bar_kite --certainty proved", "four_bar_general --max-order 2 --certainty verified"],
)
def test_a_certainty_that_is_missed_is_told(words, capsys, caplog):
    """The level that was reached, the one that was required, and the reason."""
    for json_too in ([], ["--json"]):
        caplog.clear()
        assert main(["report", *words.split(), *json_too]) == 4
        required = words.split()[-1]
        found = certify(design_space(words.split()[0], max_order=2 if "2" in words else None))
        level, reason = found.certainty.level, found.certainty.reason
        assert caplog.messages[-1] == (
            f"required: the answer is {level}, not {required}: {reason}"
        )
    caplog.clear()
    assert main(["report", "four_bar_kite", "--certainty", "verified"]) == 0
    assert not [line for line in caplog.messages if line.startswith("required")]


def test_no_other_certainty_can_be_required(capsys):
    assert main(["report", "four_bar_kite", "--certainty", "estimated"]) == 2
    assert "estimated" in capsys.readouterr().err


@pytest.mark.table(1)
@pytest.mark.parametrize("words", ["four_bar_kite", "three_rsr --motion u2=u3", "hprs"])
def test_exact_ranks_stand_in_the_report(words, capsys):
    assert main(["report", *words.split(), "--exact", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    Draft202012Validator(schema()).validate(report)
    orders, exact_orders = report["orders"], report["exact"]["orders"]
    assert exact_orders[: len(orders)] == orders and report["exact"]["agreed"]
    assert exact_orders[-1]["rank"] == report["rank"]
    assert len(set(report["exact"]["primes"])) == 2
    assert bool(report["exact"]["replaced"]) == ("kite" not in words)
    assert main(["report", *words.split(), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == report | {"exact": None}


def test_where_exact_ranks_are_refused_the_report_stands(tmp_path, capsys, caplog):
    rounded = with_axis("q2", "0.360000000000001 0.48 0.8")
    words = [str(altered("bennett_rational", tmp_path, rounded)), "--as-written"]
    assert main(["report", *words, "--json"]) == 4
    plain = json.loads(capsys.readouterr().out)
    assert main(["report", *words, "--exact", "--certainty", "verified", "--json"]) == 4
    report = json.loads(capsys.readouterr().out)
    Draft202012Validator(schema()).validate(report)
    notice = report["warnings"].pop()
    assert report == plain and report["exact"] is None
    assert notice["code"] == "exact_refused"
    assert "not exactly representable" in notice["message"]
    assert main(["report", *words, "--exact"]) == 4
    assert "conditions    13" in capsys.readouterr().out
    assert caplog.messages[-1] == f"exact_refused: {notice['message']}"


@pytest.mark.slow
@pytest.mark.parametrize("count, seed", [(12, 0), (20, 1)])
def test_poses_find_what_orders_alone_do_not(count, seed, tmp_path):
    """Of 8 n + 4 parameters, a point mass is free at each of the 3 n + 1 joints."""
    path = tmp_path / "chain.urdf"
    path.write_text(four_bar_chain(count, seed), encoding="utf-8")
    found = design_space(kinematics.load(path))
    assert found.kmax is None and found.poses > 0 and found.settled
    assert max(order.rank for order in found.orders) < found.rank == 5 * count + 3
    sure = certify(found)
    certainty = sure.certainty
    assert (certainty.level, certainty.rank) == ("proved", found.rank)
    assert certainty.nullity == found.nullity == 3 * count + 1
    assert sure.kmax == len(sure.orders) - 1 > found.orders[-1].order
    if count == 12:
        check(proof_of(sure))


@pytest.mark.slow
def test_digits_that_describe_another_linkage(capsys):
    """By its digits a 3-UPU has skew axes: which answer to believe, and why.

    Its numbers are roots in the frame of its axes: with these, it translates.
    """
    path = str(Path(__file__).parents[3] / "data" / "three_upu_17_digits.urdf")
    assert main(["report", path, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["certainty"], report["rank"], report["mobility"]) == ("verified", 40, 3)
    assert report["readings"][0]["conditions_as_written"] == 46
    assert main(["report", path, "--json", "--as-written"]) == 4
    report = json.loads(capsys.readouterr().out)
    assert (report["certainty"], report["rank"], report["mobility"]) == ("estimated", 40, 3)
    reason = report["evidence"]["reason"]
    assert report["evidence"]["rank"] == 46 and "rank 46, not 40; believe the latter:" in reason
    assert "the digits of the file describe another linkage, which does not move so" in reason
    assert reason.endswith("the answer is for the linkage that closes")
    # What is said there is so: the platform translates, and by the digits axes are skew.
    linkage = kinematics.load(path)
    way = next(iter(random_motions(linkage, 1, 20)))
    found = followed_platform(linkage, way.q[7])
    assert np.abs(found[:3, :3] - np.eye(3)).max() < 1e-12 < np.abs(found[:3, 3]).max()
    first, second = (
        [Fraction(x) for x in axis.split()]
        for axis in re.findall(r'name="[ad]2".*?axis xyz="([^"]*)"', Path(path).read_text())
    )
    assert first[0] * second[1] != first[1] * second[0]


def followed_platform(linkage, q):
    """Displacement of the platform at joint positions q, as a product of exponentials."""
    (body,) = (body for body in linkage.bodies if body.name == "platform")
    H, link = np.eye(4), body.link
    while link >= 0:
        joint = linkage.joints[link]
        H, link = expm(hat(joint.screw) * q[link]) @ H, joint.parent
    return H
