"""Proofs that somebody tampered with, each with the digest of what became of it.

Two kinds. *Ill formed* by construction: every entry, every list and every mapping of a proof
is replaced in turn by one that cannot be there. *Altered* at random: `judge.why_false` decides
whether the proof is false now. One that it does not find false is not counted, such as a
transfer of twice the parameters, or another minor that does not vanish.

``python -m tests.fuzz.tampered --cases 3000`` tries so many of each of ten models, and prints
how many were false and accepted, which must be none, and how many were still true.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from copy import deepcopy
from fractions import Fraction

import numpy as np

import kinematics
from balance import design_space
from tests.fuzz.judge import why_false
from tests.independent.checker import check
from tests.independent.checker_form import CHAIN, PIVOT, TRANSFER
from tests.support.proofs import accepted, proof_of, sealed

MODELS = (
    ("four_bar_general", "dynamic"),
    ("slider_crank", "force"),
    ("rusr", "dynamic"),
    ("five_bar", "dynamic"),
    ("four_bar_spherical", "dynamic"),
    ("hprs", "force"),
    ("three_rrr", "dynamic"),
    ("six_bar_watt", "dynamic"),
    ("three_rsr_rational", "force"),
    ("eight_bar", "dynamic"),
    ("four_rrr_parallel", "dynamic"),
)
# Never a whole number, or never one that may be there.
NO_WHOLE = (None, True, 1.0, "1", [1], {}, -1000, 2**40)
NO_TEXT = (
    None, True, 1, 0.5, [], ["1"], "", "x", "1/0", "+1", "1.5", "01", "2/4", "3/1", "-0", "--1",
    "1/-2", " 1", "1 ", "1_0", "1e3", "nan", "inf", "١", "1/2/3", "/2", "2/", "1" * 9999,
)  # fmt: skip
NO_LIST = (None, True, 0, "", {}, [None], [[]], [{}], [True], [-1000], [2**40])
# Lists that cannot be shorter, or longer, while the rest is what it is.
FIXED = "screws columns parent z pivots transfers ray".split()


def proof_for(model, balance):
    """The proof of a model of the gallery."""
    return proof_of(design_space(kinematics.load(model), balance=balance))


def places(value, path=()):
    """All places in plain data, from the outside in."""
    yield path
    if isinstance(value, (dict, list)):
        keys = value if isinstance(value, dict) else range(len(value))
        for key in keys:
            yield from places(value[key], (*path, key))


def field(path):
    """The name of the field that a place belongs to."""
    return next((x for x in reversed(path) if isinstance(x, str)), "")


def at(proof, path):
    """What stands at a place."""
    for key in path:
        proof = proof[key]
    return proof


def put(proof, path, value):
    """A copy with another value at a place, with the digest that belongs to it."""
    if not path:
        return sealed(value) if isinstance(value, dict) else value
    if path == ("sha256",):
        return proof | {"sha256": value}
    copy = deepcopy(proof)
    at(copy, path[:-1])[path[-1]] = value
    return sealed(copy)


def ill_formed(proof):
    """All that cannot be there, at all places: the field, the place, and the value."""
    for path in places(proof):
        old, name = at(proof, path), field(path)
        if path == ("sha256",):
            wrong = ["", "0" * 64, old.upper(), old[:-1], None, 5]
        else:
            wrong = NO_WHOLE if type(old) is int else NO_TEXT if type(old) is str else NO_LIST
        for value in wrong:
            if name != "below" or value != []:
                yield name, path, value
        if isinstance(old, dict):
            for key in sorted(old.keys() - {"sha256"}):
                rest = {k: value for k, value in old.items() if k != key}
                for value in (rest, rest | {key.upper(): old[key]}, old | {f"{key} ": 0}):
                    yield key, path, value
        elif isinstance(old, list) and _fixed(path, name):
            others = (old[:-1], old[1:], [*old, *old[-1:]], [], [old], _by_place(old))
            yield from ((name, path, value) for value in others if value != old)


def _by_place(items):
    """A mapping from places to entries, which is no list."""
    return {str(i): item for i, item in enumerate(items)}


def _fixed(path, name):
    """Whether a list has a length that nothing else could give it."""
    inner = isinstance(path[-1], int)
    return name in FIXED or (inner and name in "mimics rows parameters rays ends".split())


def altered(proof, rng):
    """A well formed proof with another number, index or list: the field, and the proof."""
    copy = deepcopy(proof)
    name = str(rng.choice(ALTERATIONS))
    if name in PIVOT:
        limits = (5, *_limits(proof))
        pivot = copy["pivots"][rng.integers(len(copy["pivots"]))]
        pivot[name] = int(rng.integers(limits[PIVOT.index(name)]))
    elif name in TRANSFER:
        _alter_transfer(copy, name, rng)
    elif name == "rays":
        ray = copy["rays"][rng.integers(len(copy["rays"]))]
        ray[rng.integers(len(ray))] = int(rng.choice([0, 1, 2, 3, copy["prime"]]))
    elif name == "rank":
        _claim_another_rank(copy, int(rng.choice([-2, -1, 1, 2])), rng)
    else:
        alter_chain(copy["chain"], name, rng)
    return name, sealed(copy)


# A root that is added to a joint in no relation changes nothing.
ALTERATIONS = [*CHAIN, *PIVOT, *TRANSFER, "rays", "rank", "z", "screws", "target", "row"]
ALTERATIONS.remove("radicands")


def _limits(proof):
    chain = proof["chain"]
    width, bodies = len(chain["columns"][0]), len(chain["links"])
    return len(proof["rays"]), width, len(chain["rows"]), bodies, len(chain["parameters"])


def _other_text(text, rng):
    """Another rational number, mostly a near or a simple one."""
    x = Fraction(text)
    return str(
        [x + 1, x - 1, -x, 2 * x, x + Fraction(1, 1000), Fraction(0), Fraction(1)][
            rng.integers(7)
        ]
    )


def _alter_transfer(proof, name, rng):
    chain, transfers = proof["chain"], proof["transfers"]
    transfer = transfers[rng.integers(len(transfers))]
    joints, bodies = len(chain["parent"]), len(chain["links"])
    if name == "z":
        if rng.integers(4):
            i = rng.integers(len(transfer["z"]))
            transfer["z"][i] = _other_text(transfer["z"][i], rng)
        else:
            transfer["z"] = list(transfers[rng.integers(len(transfers))]["z"])
    elif name in ("source", "target"):
        transfer[name] = int(rng.integers(-(name == "source"), bodies))
    else:
        _alter_indices(transfer[name], joints, rng)


def _alter_indices(items, limit, rng):
    """Change, drop, double, swap or add one of a list of indices."""
    i, what = int(rng.integers(max(len(items), 1))), rng.integers(5)
    if what == 0 or not items:
        items.insert(i, int(rng.integers(limit)))
    elif what == 1:
        items.pop(i)
    elif what == 2:
        items.insert(i, items[i])
    elif what == 3:
        items[i] = int(rng.integers(limit))
    else:
        items.reverse()


def _claim_another_rank(proof, step, rng):
    """More pivots and fewer transfers, or fewer and more: the numbers still fit."""
    pivots, transfers = proof["pivots"], proof["transfers"]
    for _ in range(abs(step)):
        if step < 0 and len(pivots) > 1:
            pivots.pop(rng.integers(len(pivots)))
            other = deepcopy(transfers[rng.integers(len(transfers))])
            _alter_transfer({**proof, "transfers": [other]}, str(rng.choice(TRANSFER)), rng)
            transfers.append(other)
        elif step > 0 and len(transfers) > 1:
            transfers.pop(rng.integers(len(transfers)))
            limits = (5, *_limits(proof))
            values = (int(rng.integers(limit)) for limit in limits)
            pivots.append(dict(zip(PIVOT, values, strict=True)))
    proof["rank"], proof["nullity"] = len(pivots), len(transfers)


def alter_chain(chain, name, rng):
    value = chain[name]
    if name == "parent":
        j = int(rng.integers(len(value)))
        value[j] = int(rng.integers(-1, j)) if j else -1
    elif name in ("dependent", "links"):
        _alter_indices(value, len(chain["parent"]), rng)
    elif name == "ends" and value:
        end = value[rng.integers(len(value))]
        end[rng.integers(2)] = int(rng.integers(-1, len(chain["parent"])))
        if not rng.integers(4):
            value.pop()
    elif name in ("ends", "mimics"):
        value = chain["mimics"]
        row = ["0"] * len(chain["parent"])
        i, j = rng.integers(len(row), size=2)
        row[j], row[i] = str(rng.integers(-2, 3)), "1"
        value.append(row)
    else:
        row = value[rng.integers(len(value))]
        i = rng.integers(len(row))
        row[i] = _other_text(row[i], rng)
        if not rng.integers(6):
            value[rng.integers(len(value))] = list(value[rng.integers(len(value))])


def _fairly(cases, rng):
    """Cases at random, but with one of each field before the second of another."""
    seen, order = Counter(), []
    for i in rng.permutation(len(cases)).tolist():
        seen[cases[i][0]] += 1
        order.append((seen[cases[i][0]], i))
    return [cases[i] for _, i in sorted(order)]


def trial(proof, rng, wrong, random):
    """Tamper with a proof: how often by field and outcome, and what was false and accepted."""
    counts, escaped = Counter(), []
    for name, *change in _fairly(list(ill_formed(proof)), rng)[:wrong]:
        forged = put(proof, *change)
        counts[name, "ill formed"] += 1
        if accepted(forged):
            escaped.append((name, "ill formed", forged))
    for _ in range(random):
        name, forged = altered(proof, rng)
        if sealed(forged)["sha256"] == proof["sha256"]:
            continue
        why = why_false(forged, proof)
        passes = accepted(forged)
        counts[name, "false" if why else "still true" if passes else "not judged"] += 1
        if why and passes:
            escaped.append((name, why, forged))
    return counts, escaped


def main():
    """Tamper with proofs of all models, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000, help="of each kind, per model")
    parser.add_argument("--seed", type=int, default=0)
    told = parser.parse_args()
    total, rng = Counter(), np.random.default_rng(told.seed)
    for model, balance in MODELS:
        proof = proof_for(model, balance)
        check(proof)
        counts, escaped = trial(proof, rng, told.cases, told.cases)
        outcomes = Counter()
        for (_, outcome), count in counts.items():
            outcomes[outcome] += count
        total += outcomes
        sys.stdout.write(f"{model}: {dict(outcomes)}, accepted: {len(escaped)}\n")
        for name, why, forged in escaped[:3]:
            sys.stdout.write(f"  {name}: {why}: {json.dumps(forged)}\n")
    sys.stdout.write(f"{dict(total)}\n")


if __name__ == "__main__":
    main()
