"""Proofs are taken by an independent checker, and what is not one is refused."""

import json
from copy import deepcopy
from fractions import Fraction

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from tests.independent.checker import check
from tests.independent.checker_file import check_file
from tests.independent.checker_form import Rejected
from tests.independent.exactly import determinant
from tests.support.laws import altered, placed
from tests.support.modular_rows import conditions
from tests.support.proofs import accepted, arm, arm_text, proof_of, sealed
from tests.support.urdf_text import INERTIAL


@pytest.fixture(scope="module")
def four_bar(tmp_path_factory):
    """Of a four-bar none of whose pivots is at the origin, so that no screw can be scaled."""
    H = np.eye(4)
    H[:3, 3] = 0.5, -0.75, 0.0
    path = altered("four_bar_general", tmp_path_factory.mktemp("four_bar"), placed(H))
    return proof_of(design_space(kinematics.load(path)))


def test_joints_that_follow_others_are_proved(tmp_path):
    """Of the force, for a relation adds to the conditions of the moment what it takes."""
    follower = arm_text().replace("</joint>", '<mimic joint="j0" multiplier="3"/></joint>', 2)
    follower = follower.replace('<mimic joint="j0" multiplier="3"/>', "", 1)
    path = arm(tmp_path, follower)
    proof = proof_of(design_space(kinematics.load(path), balance="force"))
    assert accepted(proof) and len(proof["chain"]["mimics"]) == 1
    assert not accepted(sealed(proof | {"chain": proof["chain"] | {"mimics": []}}))


def test_joints_that_follow_others_at_an_irrational_ratio_are_proved(tmp_path):
    """The axis of the last joint is as long as √5: a proof holds with its root alone."""
    head, last = arm_text().rsplit("</joint>", 1)
    path = arm(tmp_path, f'{head}<mimic joint="j0" multiplier="3"/></joint>{last}')
    proof = proof_of(design_space(kinematics.load(path), balance="force"))
    assert accepted(proof) and proof["chain"]["radicands"] == [[], [], [5]]
    check_file(proof, path.read_bytes())
    for roots in ([[], [], [4]], [[], [2], [6]], [[], [], [-5]], [[], [5, 5], []]):
        other = proof["chain"] | {"radicands": roots}
        assert not accepted(sealed(proof | {"chain": other}))
    other = proof["chain"] | {"radicands": [[], [], []]}
    with pytest.raises(Rejected, match="mimics"):
        check_file(sealed(proof | {"chain": other}), path.read_bytes())


def altered_digits(text):
    """Texts with one digit changed: the place, and the new digit."""
    for i, old in enumerate(text):
        yield from ((i, new) for new in "0123456789" if old.isdigit() and new != old)


@pytest.mark.slow
def test_a_proof_with_another_digit_is_refused(four_bar, tmp_path):
    """Every digit of the small one; of the arm, one change in twenty."""
    texts = [
        json.dumps(four_bar),
        json.dumps(proof_of(design_space(kinematics.load(arm(tmp_path))))),
    ]
    for text, step in zip(texts, (1, 20), strict=True):
        changes = list(altered_digits(text))[::step]
        assert len(changes) > 200
        for i, digit in changes:
            try:
                proof = json.loads(text[:i] + digit + text[i + 1 :])
            except json.JSONDecodeError:
                continue
            assert not accepted(proof), (i, digit)


CLAIMS = (
    "rank",
    "nullity",
    "transfers",
    "chain.parent",
    "chain.screws",
    "chain.ends",
    "chain.dependent",
    "chain.links",
)


@pytest.mark.table(2)
@pytest.mark.parametrize("claim", CLAIMS)
def test_a_proof_of_something_else_is_refused_whatever_its_digest(claim, four_bar):
    """With the digest of what was changed: the numbers themselves do not fit."""
    owner, _, name = claim.rpartition(".")
    part = (four_bar[owner] if owner else four_bar)[name]
    text, refused = json.dumps(part), 0
    changes = list(altered_digits(text))
    for i, digit in changes[:: -(-len(changes) // 60)]:
        try:
            other = json.loads(text[:i] + digit + text[i + 1 :])
        except json.JSONDecodeError:
            continue
        forged = four_bar | (
            {owner: four_bar[owner] | {name: other}} if owner else {name: other}
        )
        # Links 2 and 3 are welded: a body may be said to be on either.
        same = [2 if x == 3 else x for x in other] == part if name == "links" else False
        if not same and exactly(other) != exactly(part):
            assert not accepted(sealed(forged)), (claim, text[:i] + digit + text[i + 1 :])
            refused += 1
    assert refused >= min(9, len(changes) // 2)


def exactly(part):
    """Numbers in the place of texts: -0 and 0/7 are 0."""
    if isinstance(part, dict):
        return {name: exactly(value) for name, value in part.items()}
    if isinstance(part, list):
        return [exactly(value) for value in part]
    try:
        return Fraction(part)
    except ZeroDivisionError:
        return part


@pytest.mark.table(1)
@pytest.mark.parametrize("model", ["four_bar_general", "five_bar", "four_bar_spherical"])
def test_other_pivots_are_refused_where_their_minor_vanishes(model):
    """The determinant comes from the product's conditions, the verdict from the checker."""
    found = certify(design_space(kinematics.load(model))).certainty.proof
    plain, p = json.loads(json.dumps(found.to_dict())), found.witness.prime
    order = max(pivot.order for pivot in found.witness.pivots)
    X, _ = conditions(found.chain, np.array(found.witness.rays), order, p)
    size = len(found.chain.parameters)
    rng = np.random.default_rng(7)
    limits = dict(
        zip(plain["pivots"][0], (*X.shape[:4], len(found.chain.links), size), strict=True)
    )
    verdicts = []
    for _ in range(12):
        forged = deepcopy(plain)
        key = rng.choice(list(limits))
        rng.choice(forged["pivots"])[key] = int(rng.integers(limits[key]))
        pivots = forged["pivots"]
        rows = [X[a["order"], a["ray"], a["column"], a["row"]].tolist() for a in pivots]
        minor = [[row[b["body"] * size + b["parameter"]] for b in pivots] for row in rows]
        verdicts.append(accepted(sealed(forged)))
        assert verdicts[-1] == (determinant(minor, p) != 0), (key, pivots)
    assert len(set(verdicts)) == 2


def forged_claims(proof):
    """Proofs that something is wrong with, by what it is."""
    shorter = proof["transfers"][:-1]
    last, pivots, chain = proof["transfers"][-1], proof["pivots"], proof["chain"]
    fewer = {"transfers": shorter, "nullity": proof["nullity"] - 1}
    more = {"pivots": [*pivots, pivots[-1] | {"row": 0}], "rank": proof["rank"] + 1}
    zero = last | {"z": ["0"] * len(last["z"])}
    doubled = last | {"z": [str(2 * Fraction(x)) for x in shorter[0]["z"]]}
    yield "too few transfers", fewer
    yield "a rank too high", fewer | more
    yield "nothing is transferred", {"transfers": [*shorter, zero]}
    yield "one transfer twice", {"transfers": [*shorter, shorter[0] | {"z": doubled["z"]}]}
    yield "no joint on the way", {"transfers": [*shorter, last | {"joints": []}]}
    yield "the way is broken", {"transfers": [*shorter, last | {"below": []}]}
    yield "from the ground", {"transfers": [*shorter, last | {"source": -1}]}
    yield "rays that do not move", {"rays": [[0] * len(ray) for ray in proof["rays"]]}
    yield "rows of one pose only", {"chain": chain | {"rows": chain["rows"][-1:]}}
    yield "a loop left open", {"chain": chain | {"ends": [], "dependent": []}}
    yield "another format", {"format": "balance.proof/0"}


@pytest.mark.table(1)
@pytest.mark.parametrize("model", ["four_bar_general", "six_bar_watt", "rusr"])
def test_forged_proofs_are_refused(model):
    proof = proof_of(design_space(kinematics.load(model)))
    assert accepted(proof) and accepted(sealed(proof))
    for label, change in forged_claims(proof):
        assert not accepted(sealed(proof | change)), label


def test_what_passes_a_joint_by_itself_does_not_where_others_are_below(tmp_path):
    """Five transfers of a joint on the ground, of which three pass it on a skew one."""
    proof = proof_of(design_space(kinematics.load(arm(tmp_path))))
    fixed = arm_text().replace('"continuous"', '"fixed"', 1).replace(INERTIAL, "", 1)
    path = arm(tmp_path, fixed)
    alone = proof_of(design_space(kinematics.load(path)))
    check(alone)
    passing = [t["z"] for t in alone["transfers"] if t["source"] == -1]
    places = [i for i, t in enumerate(proof["transfers"]) if t["joints"] == [1]]
    assert (len(passing), len(places)) == (5, 3)
    verdicts = []
    for z in passing:
        forged = deepcopy(proof)
        forged["transfers"][places[0]]["z"] = z
        forged["transfers"][places[1]]["z"] = proof["transfers"][places[0]]["z"]
        verdicts.append(accepted(sealed(forged)))
    assert verdicts.count(False) >= 2


MASSLESS_LOOP = """
<link name="m1"/><link name="m2"/>
<joint name="xa" type="prismatic"><parent link="crank"/><child link="m1"/>
  <axis xyz="1 0 0"/></joint>
<joint name="xb" type="prismatic"><parent link="m1"/><child link="m2"/>
  <axis xyz="0 1 0"/></joint>
<loop name="xd" type="prismatic"><predecessor link="m2"/><successor link="crank"/>
  <axis xyz="1 1 0"/></loop>
</robot>"""


def test_what_a_body_gives_to_itself_is_no_transfer(tmp_path):
    """A ring of links without mass on one body adds no solution, and proves none."""
    text = kinematics.gallery()["four_bar_antiparallelogram"].read_text("utf-8")
    path = tmp_path / "ring.urdf"
    path.write_text(text.replace("</robot>", MASSLESS_LOOP), encoding="utf-8")
    found = certify(design_space(kinematics.load(path)))
    certainty = found.certainty
    assert (found.rank, found.serial_nullity, found.nullity) == (7, 4, 5)
    assert (certainty.level, certainty.rank, certainty.nullity) == ("verified", 7, 4)
