"""A judge of tampered proofs, which shares no code with the checker.

The conditions come from the product's kernels, modulo another prime and along other rays
where the proof leaves a choice; determinants come from `exactly`, and whether joints lead
from one body to another from a graph. A proof that it finds false is false; of the others it
decides nothing.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from balance.space.exact.chain import ExactChain, loops_are_regular
from balance.space.exact.modular import eliminate
from tests.independent.exactly import determinant, modulo
from tests.support.modular_rows import conditions

# Another prime than those of proofs; orders at which what a transfer does must vanish.
OTHER = 1073741723
ORDER = 3


def why_false(proof, original):
    """Why a well formed proof is false; empty if the judge finds nothing false in it."""
    chain, first = proof["chain"], original["chain"]
    for name in ("rows", "parameters"):
        if not _same_span(chain[name], first[name]):
            return name
    for name in ("dependent", "links"):
        if len(set(chain[name])) < len(chain[name]):
            return name
    size = len(chain["links"]) * len(chain["parameters"])
    if proof["rank"] + proof["nullity"] != size:
        return "another number of parameters"
    exact = _exact(chain)
    if _driven_twice(exact) or not loops_are_regular(exact) or _deviates(exact):
        return "loops that are not regular, or joints out of the plane"
    return _no_minor(proof, exact) or _no_transfers(proof, exact)


def _exact(chain):
    def turned(value):
        if isinstance(value, list):
            return tuple(turned(x) for x in value)
        return Fraction(value) if isinstance(value, str) else value

    return ExactChain(**{name: turned(value) for name, value in chain.items()})


def _rank(rows, p=OTHER):
    A = np.array([[modulo(Fraction(x), p) for x in row] for row in rows], np.int64)
    return int(np.sum(eliminate(A, A.shape[1], p) >= 0)) if len(rows) else 0


def _same_span(rows, others):
    return len(rows) == len(others) == _rank(rows) == _rank([*rows, *others])


def _driven_twice(chain):
    """Whether a dependent joint is driven, or the columns depend on each other."""
    driven = any(any(chain.columns[j]) for j in chain.dependent)
    return driven or _rank(chain.columns) < chain.width


def _deviates(chain):
    """Whether a screw that moves leads momenta out of the rows, where these are of a plane."""
    if len(chain.rows) == 6 or not any(any(row[:3]) for row in chain.rows):
        return len(chain.rows) == 2 and any(s[0] or s[1] or s[5] for s in chain.screws)
    n = np.array(chain.rows[0][:3], object)
    return any(np.cross(s[:3], n).any() or np.array(s[3:], object) @ n for s in chain.screws)


def _no_minor(proof, chain):
    """Whether the minor of the pivots vanishes, by the kernels of the product."""
    pivots, p = proof["pivots"], proof["prime"]
    order = max((pivot["order"] for pivot in pivots), default=0)
    rays = np.array(proof["rays"], np.int64) % p
    found = conditions(chain, rays, order, p)
    if found is None or found[1] <= order:
        return "loops that do not close"
    X, size = found[0], len(chain.parameters)
    rows = [X[a["order"], a["ray"], a["column"], a["row"]].tolist() for a in pivots]
    minor = [[row[b["body"] * size + b["parameter"]] for b in pivots] for row in rows]
    return "" if determinant(minor, p) else "a minor that vanishes"


def _no_transfers(proof, chain):
    """Whether one changes the momentum, does not lead where it says, or they depend."""
    bodies, size = len(chain.links), len(chain.parameters)
    moved = []
    for transfer in proof["transfers"]:
        if transfer["source"] == transfer["target"] or not _leads(transfer, chain):
            return "a walk that does not lead there"
        row = [[Fraction(0)] * size for _ in range(bodies)]
        for body, sign in ((transfer["target"], 1), (transfer["source"], -1)):
            if body >= 0:
                row[body] = [sign * Fraction(x) for x in transfer["z"]]
        moved.append([x for part in row for x in part])
    if _rank(moved) < len(moved):
        return "transfers that depend on each other"
    rays = np.random.default_rng(3).integers(1, 2**20, (2, chain.width))
    X = conditions(chain, rays, ORDER, OTHER)[0].reshape(-1, bodies * size).astype(object)
    Z = np.array([[modulo(x, OTHER) for x in row] for row in moved], object)
    return "a transfer that changes the momentum" if (X @ Z.T % OTHER).any() else ""


def _leads(transfer, chain):
    """Whether the joints lead from the ground to the source and on to the target."""
    still = {
        j for j, row in enumerate(chain.columns) if not any(row) and j not in chain.dependent
    }
    welds = [*chain.ends, *((j, chain.parent[j]) for j in still)]

    def same(link):
        """All links of its rigid part."""
        part, before = {link}, 0
        while len(part) > before:
            before = len(part)
            part.update(x for weld in welds if part & set(weld) for x in weld)
        return part

    def place(body):
        return chain.links[body] if body >= 0 else -1

    if len(set(transfer["joints"])) < len(transfer["joints"]):
        return False
    if not transfer["joints"]:
        return not transfer["below"] and place(transfer["target"]) in same(
            place(transfer["source"])
        )
    here = same(-1)
    for i, j in enumerate([*transfer["below"], *transfer["joints"]]):
        if i == len(transfer["below"]) and place(transfer["source"]) not in here:
            return False
        ends = {j, chain.parent[j]}
        if len(ends & here) != 1:
            return False
        here = same((ends - here).pop())
    return place(transfer["target"]) in here
