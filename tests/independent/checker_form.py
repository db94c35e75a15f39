"""The form of a proof: each entry is of the type, the length and the range that it must have.

`check_form` passes only what `balance.proof/3` means; what the entries claim together is for
`checker` to judge. Booleans are no whole numbers here, and a rational number is a text in
lowest terms.
"""

import json
from fractions import Fraction
from functools import cache
from hashlib import sha256
from math import gcd, isqrt

FORMAT = "balance.proof/3"
CHAIN = "parent screws radicands ends mimics dependent columns links rows parameters".split()
PIVOT = "order ray column row body parameter".split()
TRANSFER = "below joints source target z".split()
PROOF = "format chain prime rays pivots transfers idle rank nullity sha256".split()
# Whole numbers stay below 2^31, orders below this, and texts of numbers below 4,000 digits.
ORDERS = 200
DIGITS = 4000


class Rejected(ValueError):
    """What is given is no proof: where, and why not."""


def need(holds, where, why):
    """Reject the proof unless something holds."""
    if not holds:
        raise Rejected(f"{where}: {why}")


def read(text):
    """The proof in a file: JSON, in which no name stands twice."""

    def once(pairs):
        need(len({name for name, _ in pairs}) == len(pairs), "file", "a name stands twice")
        return dict(pairs)

    try:
        return json.loads(text, object_pairs_hook=once)
    except json.JSONDecodeError as error:
        raise Rejected(f"file: {error}") from None


def check_form(proof):
    """Raise `Rejected` unless all entries are well formed, and the digest is that of them."""
    _fields(proof, PROOF, "proof")
    need(proof["format"] == FORMAT, "format", f"not {FORMAT}")
    width = _chain(proof["chain"])
    chain = proof["chain"]
    _radicands(chain["radicands"], len(chain["parent"]))
    size, bodies = len(chain["parameters"]), len(chain["links"])
    _prime(proof["prime"])
    rays = _list(proof["rays"], "rays")
    for ray in rays:
        _wholes(ray, 0, 2**31, "rays", width)
        need(any(ray), "rays", "a ray without a direction")
    _distinct(rays, "rays")
    limits = (ORDERS, len(rays), width, len(chain["rows"]), bodies, size)
    _pivots(proof["pivots"], limits)
    for transfer in _list(proof["transfers"], "transfers"):
        _transfer(transfer, len(chain["parent"]), bodies, size)
    _wholes(proof["idle"], 0, len(chain["parent"]), "idle")
    _distinct(proof["idle"], "idle")
    for name, items in (("rank", "pivots"), ("nullity", "transfers")):
        _whole(proof[name], 0, 2**31, name)
        need(proof[name] == len(proof[items]), name, f"not the number of {items}")
    need(proof["rank"] + proof["nullity"] == bodies * size, "rank", "does not fit the nullity")
    rest = {name: value for name, value in proof.items() if name != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    need(proof["sha256"] == sha256(text.encode()).hexdigest(), "sha256", "not that of the rest")


def _chain(chain):
    """The number of columns of a well formed chain."""
    _fields(chain, CHAIN, "chain")
    joints = len(_list(chain["parent"], "parent"))
    need(joints, "parent", "no joints")
    for j, parent in enumerate(chain["parent"]):
        _whole(parent, -1, j, "parent")
    for end in _list(chain["ends"], "ends"):
        _wholes(end, -1, joints, "ends", 2)
    _distinct([x for end in chain["ends"] for x in (end, end[::-1])], "ends")
    for name in ("dependent", "links"):
        _wholes(chain[name], 0, joints, name)
        _distinct(chain[name], name)
    need(chain["links"], "links", "no bodies")
    need(_list(chain["columns"], "columns"), "columns", "not one per joint")
    width = len(_list(chain["columns"][0], "columns"))
    shapes = {
        "screws": (joints, 6),
        "columns": (joints, width),
        "mimics": (None, joints),
        "rows": (None, 6),
        "parameters": (None, 10),
    }
    for name, (count, length) in shapes.items():
        for row in _list(chain[name], name, count):
            _rationals(row, length, name)
            zero = all(x == "0" for x in row)
            need(name == "columns" or not zero, name, "a row of zeros")
    for row in chain["mimics"]:
        others = [x for x in row if x != "0"]
        need("1" in others and len(others) <= 2, "mimics", "no joint that follows another")
    need(width, "columns", "no motion")
    return width


def _radicands(radicands, joints):
    """Numbers that are coprime and no squares, so that roots of them are independent."""
    for numbers in _list(radicands, "radicands", joints):
        _wholes(numbers, 2, 10**DIGITS, "radicands")
        _distinct(numbers, "radicands")
    every = sorted({b for numbers in radicands for b in numbers})
    need(all(isqrt(b) ** 2 != b for b in every), "radicands", "a square")
    coprime = all(gcd(b, c) == 1 for k, b in enumerate(every) for c in every[:k])
    need(coprime, "radicands", "two that are not coprime")


def _prime(p):
    _whole(p, 2**20, 2**31, "prime")
    need(_is_prime(p), "prime", "not a prime")


@cache
def _is_prime(p):
    return all(p % k for k in range(2, isqrt(p) + 1))


def _pivots(pivots, limits):
    """Pivots within their limits; no row and no column of the minor is there twice."""
    for pivot in _list(pivots, "pivots"):
        _fields(pivot, PIVOT, "pivots")
        for name, limit in zip(PIVOT, limits, strict=True):
            _whole(pivot[name], 0, limit, f"pivots: {name}")
    for names in (PIVOT[:4], PIVOT[4:]):
        _distinct([[pivot[name] for name in names] for pivot in pivots], "pivots")


def _transfer(transfer, joints, bodies, size):
    """From a body or the ground to another body, through joints of which none is twice."""
    _fields(transfer, TRANSFER, "transfers")
    for name in ("below", "joints"):
        _wholes(transfer[name], 0, joints, f"transfers: {name}")
    _distinct(transfer["joints"], "transfers: joints")
    _whole(transfer["source"], -1, bodies, "transfers: source")
    _whole(transfer["target"], 0, bodies, "transfers: target")
    need(transfer["source"] != transfer["target"], "transfers", "from a body to itself")
    _rationals(transfer["z"], size, "transfers: z")
    need(any(x != "0" for x in transfer["z"]), "transfers: z", "nothing is transferred")


def _fields(value, names, where):
    need(type(value) is dict and set(value) == set(names), where, f"not the fields {names}")


def _list(value, where, count=None):
    need(type(value) is list, where, "not a list")
    need(count is None or len(value) == count, where, f"not {count} entries")
    return value


def _whole(value, low, high, where):
    need(type(value) is int, where, "not a whole number")
    need(low <= value < high, where, f"not from {low} to {high - 1}")


def _wholes(value, low, high, where, count=None):
    for x in _list(value, where, count):
        _whole(x, low, high, where)


def _rationals(row, length, where):
    """Texts such as "-3/4", in lowest terms."""
    for x in _list(row, where, length):
        need(type(x) is str and len(x) <= DIGITS and x.isascii(), where, "not a number as text")
        top, slash, bottom = x.partition("/")
        digits = top.removeprefix("-").isdigit() and (bottom.isdigit() or not slash)
        need(digits and (not slash or bottom.strip("0")), where, f"{x[:40]!r} is no number")
        need(str(Fraction(x)) == x, where, f"{x[:40]!r} is not in lowest terms")


def _distinct(items, where):
    keys = [tuple(item) if type(item) is list else item for item in items]
    need(len(set(keys)) == len(keys), where, "one entry twice")
