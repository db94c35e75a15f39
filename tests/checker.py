"""A checker of proofs: it reads their data alone, and shares nothing with what wrote them.

A twist t = [ω; v] is a 4×4 matrix here, and a body of parameters z twice its pseudo-inertia
P. With ``A = t P``, a twist that carries the body changes it at the rate ``A + Aᵀ``, and
``A - Aᵀ`` holds its momentum [ξ; p]. All numbers are fractions, or whole numbers modulo the
prime of the proof.
"""

import json
from fractions import Fraction
from hashlib import sha256

import numpy as np


def check(proof):
    """Raise an error unless the rank and the nullity are what a proof says."""
    rest = {name: value for name, value in proof.items() if name != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    assert sha256(text.encode()).hexdigest() == proof["sha256"]
    chain = proof["chain"] | {
        name: np.array([[Fraction(x) for x in row] for row in proof["chain"][name]], object)
        for name in ("screws", "mimics", "columns", "rows", "parameters")
    }
    (bodies, size), p = (len(chain[name]) for name in ("links", "parameters")), proof["prime"]
    rank, nullity, pivots = proof["rank"], proof["nullity"], proof["pivots"]
    assert rank + nullity == bodies * size and proof["format"] == "balance.proof/1"
    way = well_posed(chain)
    order = max((pivot["order"] for pivot in pivots), default=0)
    X = [list(conditions(chain, way, ray, order, p)) for ray in proof["rays"]]
    rows = [X[a["ray"]][a["order"]][a["column"], a["row"]] for a in pivots]
    minor = [[row[a["body"], a["parameter"]] for a in pivots] for row in rows]
    assert len(echelon(np.array(minor, object), p)) == rank == len(pivots)
    moved = np.zeros((len(proof["transfers"]), bodies, size), object)
    for row, transfer in zip(moved, proof["transfers"], strict=True):
        z = np.array([Fraction(x) for x in transfer["z"]], object)
        harmless(chain, transfer, z)
        row[transfer["target"]] += z
        row[transfer["source"]] -= z * (transfer["source"] >= 0)
    assert len(echelon(modulo(moved.reshape(-1, bodies * size), p), p)) == nullity == len(moved)


def well_posed(chain):
    """Joints on the way to each link, and last to the ground; their loops close for good.

    Constraints are as many as the dimensions of what the loops can do, and `conditions`
    finds them independent. The rows of momentum must not depend on the pose.
    """
    screws, rows, dependent = chain["screws"], chain["rows"], chain["dependent"]
    way = np.zeros((len(screws) + 1, len(screws)), dtype=int)
    for j, parent in enumerate(chain["parent"]):
        assert -1 <= parent < j
        way[j] = way[parent]
        way[j, j] = 1
    loops = [screws[way[e] != way[f]] for e, f in chain["ends"]]
    constraints = sum(len(closed(loop, loop)) for loop in loops) + len(chain["mimics"])
    assert len(dependent) == constraints and not chain["columns"][dependent].any()
    assert len(closed(rows, screws)) == len(rows)
    return way


def conditions(chain, way, ray, order, p):
    """Conditions of each order along a ray, modulo p: (w, rows, bodies, parameters)."""
    screws, mimics, columns, rows, parameters = (
        modulo(chain[name], p) for name in ("screws", "mimics", "columns", "rows", "parameters")
    )
    parent, links, dependent = (chain[name] for name in ("parent", "links", "dependent"))
    S, P = [np.array([hat(s) for s in screws])], [np.array([[pseudo(z) for z in parameters]])]
    C, G, T, V = [columns], [], [], []
    for k in range(order + 1):
        if k:
            S.append(sum(bracket(V[a][parent], S[-1 - a]) for a in range(k)))
            A = sum(V[a][links, None] @ P[-1 - a] for a in range(k))
            P.append(A + A.mT)
            S[k], P[k] = (x * pow(k, -1, p) % p for x in (S[k], P[k]))
            C.append(0 * columns)
        # The rates around a loop, and those of a mimic, cancel.
        loops = [vee((way[e] - way[f])[:, None, None] * S[k]).T for e, f in chain["ends"]]
        G.append(np.concatenate([*loops, mimics.reshape(-1, len(parent)) * (k == 0)]))
        left = sum(G[a] @ C[k - a] for a in range(k + 1))
        solved = echelon(np.concatenate([G[0][:, dependent], -left], axis=1) % p, p)
        assert sorted(solved) == list(range(len(dependent)))
        for c, row in solved.items():
            C[k][dependent[c]] = row[len(dependent) :]
        rates = sum(S[a][:, None] * C[k - a][..., None, None] for a in range(k + 1))
        T.append(np.tensordot(way, rates, 1) % p)
        V.append(np.tensordot(T[k], np.array(ray, object), ((1,), (0,))) % p)
        A = sum(T[a][links][:, :, None] @ P[k - a][:, None] for a in range(k + 1))
        yield (vee(A - A.mT) @ rows.T % p).transpose(1, 3, 0, 2)


def harmless(chain, transfer, z):
    """Parameters z pass joints, one by one, and the momentum of all motions stays 0.

    They turn into ``Lᵏ z`` on the other side: of the twists V below a joint, and its screw
    s, ``M(Lᵏ z) s = 0`` for all k, and ``M(Lᵏ z) V = 0`` but for k = 0. Nine k are enough.
    """
    parent, links, columns = chain["parent"], chain["links"], chain["columns"]
    part, below = [*range(len(parent)), -1], transfer["below"]
    idle = set(np.flatnonzero(~columns.any(axis=1))) - set(chain["dependent"])
    for a, b in [*chain["ends"], *((j, parent[j]) for j in idle)]:
        part = [part[b] if x == part[a] else x for x in part]
    stops = [part[links[transfer[b]] if transfer[b] >= 0 else -1] for b in ("source", "target")]
    visited, V = [part[-1]], []
    for i, j in enumerate([*below, *transfer["joints"]]):
        P, s = pseudo(z @ chain["parameters"]), chain["screws"][j]
        for k in range(10 if i >= len(below) else 0):
            for A in [hat(t) @ P for t in (*V[: None if k else 0], s)]:
                assert not (chain["rows"] @ vee(A - A.T)).any()
            P = A + A.T  # by the last of them, s
        ends = [part[j], part[parent[j]]]
        ends.remove(visited[-1])
        visited, V = visited + ends, closed([s, *V], [s])
    assert [visited[len(below)], visited[-1]] == stops


def closed(twists, by):
    """A basis of the smallest span that contains twists, and its brackets with others."""
    span = list(echelon(twists).values())
    more = [vee(bracket(hat(s), hat(t))) for s in by for t in span]
    wider = echelon([*span, *more]).values()
    return closed(wider, by) if len(wider) > len(span) else span


def echelon(rows, p=None):
    """Rows reduced by one another, by columns of their pivots; modulo p if there is one."""
    trim = (lambda row: row) if p is None else (lambda row: row % p)
    done = {}
    for row in rows:
        for c, other in done.items():
            row = trim(row - row[c] * other)
        if row.any():
            c = np.flatnonzero(row)[0]
            row = trim(row * pow(row[c], -1, p))
            done = {d: trim(r - r[c] * row) for d, r in done.items()} | {c: row}
    return done


def bracket(a, b):
    return a @ b - b @ a


def hat(t):
    a, b, c, x, y, z = t
    return np.array([[0, -c, b, x], [c, 0, -a, y], [-b, a, 0, z], [0, 0, 0, 0]], object)


def vee(A):
    """The entries of a twist, or of a momentum [[ξ̂, p], [-pᵀ, 0]]."""
    return np.stack(
        [A[..., i, j] for i, j in ((2, 1), (0, 2), (1, 0), (0, 3), (1, 3), (2, 3))], -1
    )


def pseudo(z):
    """Of [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz], with E about the origin."""
    m, x, y, w, a, b, c, d, e, f = z * [2, 2, 2, 2, 1, 1, 1, 2, 2, 2]
    first, second = [b + c - a, -d, -e, x], [-d, c + a - b, -f, y]
    return np.array([first, second, [-e, -f, a + b - c, w], [x, y, w, m]], object)


def modulo(A, p):
    return np.vectorize(lambda x: x.numerator * pow(x.denominator, -1, p) % p, [object])(A)
