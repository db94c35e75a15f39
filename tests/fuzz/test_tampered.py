"""Tampered proofs are rejected, all of them, and with the one error that says why."""

import json
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from tests.fuzz.tampered import MODELS, alter_chain, proof_for, trial
from tests.independent.checker import check
from tests.independent.checker_file import check_file
from tests.independent.checker_form import CHAIN, PIVOT, TRANSFER, Rejected, check_form, read
from tests.support.covering import number_of_cases
from tests.support.proofs import accepted, proof_of, sealed

# A proof that the first checker took: rank 7 of the general four-bar, which is 8.
FALSE = Path(__file__).parents[1] / "data" / "false_proof.json"
# Wrong and random changes of the proof of a model.
CASES = {
    "four_bar_general": (number_of_cases(300, 600), number_of_cases(60, 120)),
    "slider_crank": (number_of_cases(150, 300), number_of_cases(30, 60)),
    "rusr": (number_of_cases(100, 200), number_of_cases(10, 20)),
}


def data_of(model):
    return kinematics.gallery()[model].read_bytes()


@pytest.mark.table(2)
@pytest.mark.parametrize("model, balance", MODELS)
def test_true_proofs_are_accepted_and_are_of_their_files(model, balance):
    proof = proof_for(model, balance)
    assert check(proof)[1] == balance
    check_file(proof, data_of(model))
    other = "five_bar" if model != "five_bar" else "six_bar_watt"
    with pytest.raises(Rejected, match="chain"):
        check_file(proof, data_of(other))


@pytest.mark.slow
@pytest.mark.parametrize("model", CASES)
def test_tampered_proofs_are_rejected(model):
    """Ill formed or false by an independent judge; twice as many with ``ALL_CASES=1``.

    See `tampered`.
    """
    wrong, random = CASES[model]
    proof = proof_for(model, dict(MODELS)[model])
    counts, escaped = trial(proof, np.random.default_rng(16), wrong, random)
    assert not escaped, escaped[0]
    refused = sum(n for (_, why), n in counts.items() if why in ("ill formed", "false"))
    assert refused >= wrong + 0.5 * random
    assert {*CHAIN, *PIVOT, *TRANSFER, "rays", "rank", "prime"} <= {name for name, _ in counts}


def test_the_proof_of_rank_7_of_the_general_four_bar_is_rejected():
    proof = read(FALSE.read_text("utf-8"))
    with pytest.raises(Rejected, match="fields"):
        check(proof)
    # It is of an older format, which named no idle joints.
    roots = [[] for _ in proof["chain"]["parent"]]
    chain = proof["chain"] | {"radicands": roots}
    proof = sealed(proof | {"format": "balance.proof/3", "idle": [], "chain": chain})
    with pytest.raises(Rejected, match="target"):
        check(proof)
    unsealed = {name: value for name, value in proof.items() if name != "sha256"}
    with pytest.raises(Rejected, match="fields"):
        check(unsealed)
    # Nor does it help to let the transfer go to the body that -1 stood for.
    proof["transfers"][-1]["target"] = 2
    with pytest.raises(Rejected, match="lead"):
        check(sealed(proof))


def test_what_says_the_same_is_still_accepted():
    """Other orders, multiples and signs: the checker does not reject for the sake of it."""
    proof = proof_for("four_bar_general", "dynamic")
    rng = np.random.default_rng(4)
    for name in ("pivots", "transfers"):
        proof[name] = [proof[name][i] for i in rng.permutation(len(proof[name]))]
    assert accepted(sealed(proof))
    for transfer in proof["transfers"]:
        transfer["z"] = [f"-{x}".replace("--", "") if x != "0" else x for x in transfer["z"]]
    proof["rays"] = [[3 * x for x in ray] for ray in proof["rays"]]
    proof["chain"]["columns"] = [[x.replace("1", "7")] for (x,) in proof["chain"]["columns"]]
    assert accepted(sealed(proof))


@pytest.mark.slow
def test_a_chain_that_was_altered_is_not_that_of_the_file():
    """Whatever the rank of what became of it: screws, parents, loops, bodies and inputs."""
    rng, tried = np.random.default_rng(2), 0
    for model, balance in (("four_bar_general", "dynamic"), ("stewart_6ups", "force")):
        proof = proof_for(model, balance)
        for name in rng.choice(["screws", "parent", "ends", "dependent", "links"], 60):
            chain = json.loads(json.dumps(proof["chain"]))
            alter_chain(chain, str(name), rng)
            if same(chain, proof["chain"]):
                continue
            forged = sealed(proof | {"chain": chain})
            with pytest.raises(Rejected):
                check_form(forged)
                check_file(forged, data_of(model))
            tried += 1
    assert tried > 80


def same(chain, other):
    """Whether screws are multiples of the others, and the rest is theirs in some order."""
    for a, b in zip(chain["screws"], other["screws"], strict=True):
        a, b = (np.array([float_of(x) for x in row]) for row in (a, b))
        if np.abs(np.outer(a, b) - np.outer(b, a)).max() > 1e-9 or a @ b <= 0:
            return False
    return chain["parent"] == other["parent"] and all(
        in_order(chain[name]) == in_order(other[name])
        for name in ("ends", "dependent", "links")
    )


def in_order(items):
    """Indices, and pairs of them, sorted."""
    return sorted(sorted(x) if isinstance(x, list) else x for x in items)


def float_of(text):
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or "1")


def test_the_motion_of_a_proof_is_that_asked_for(tmp_path):
    """A proof for the whole motion is none for a part of it, and the other way round."""
    proof = proof_for("four_rrr_parallel", "dynamic")
    data = data_of("four_rrr_parallel")
    names = kinematics.load("four_rrr_parallel").inputs
    check_file(proof, data, inputs=names)
    with pytest.raises(Rejected, match="columns"):
        check_file(proof, data, motion=[{names[0]: 1, names[1]: -1}])
    found = certify(
        design_space(kinematics.load("five_bar"), motion=f"{five()[0]}=2*{five()[1]}")
    )
    if found.certainty.proof is not None:
        part = proof_of(found)
        check_file(part, data_of("five_bar"), motion=[{five()[0]: 1, five()[1]: -2}])
        with pytest.raises(Rejected, match="columns"):
            check_file(part, data_of("five_bar"), motion=[{five()[0]: 1, five()[1]: -1}])


def five():
    return kinematics.load("five_bar").inputs


def test_a_name_that_stands_twice_in_a_file_is_rejected():
    text = FALSE.read_text("utf-8")
    with pytest.raises(Rejected, match="twice"):
        read(text.replace('"rank": 7', '"rank": 7, "rank": 8'))
    with pytest.raises(Rejected, match="file"):
        read(text[:-2])
