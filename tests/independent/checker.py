"""A checker of proofs: it reads their data alone, and shares nothing with what wrote them.

What it proves is a statement on the chain in the proof. Its joints move with the rates
``columns · u̇``, and those in ``dependent`` follow: loops stay closed, mimics keep their
relations. A screw counts times the square roots of its radicands, which exist modulo the
prime; as these are coprime and no squares, any roots do. Then for all u, u̇ the momentum of its
bodies, or its force alone, is linear in their parameters, and these conditions have the rank
and the nullity that the proof says.
`check` returns which momentum is meant. That the chain is that of a file is not part of it:
`checker_file` compares the two.

A twist t = [ω; v] is a 4×4 matrix here, and a body of parameters z twice its pseudo-inertia
P. With ``A = t P``, a twist that carries the body changes it at the rate ``A + Aᵀ``, and
``A - Aᵀ`` holds its momentum [ξ; p]. All numbers are fractions, or whole numbers modulo the
prime of the proof.

``python -m tests.independent.checker PROOF.json [ROBOT.urdf]`` checks a file.
"""

import math
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np

from tests.independent.checker_form import Rejected, check_form, need, read

NUMBERS = "screws mimics columns rows parameters".split()


def check(proof):
    """The momentum of which a proof says the rank and the nullity.

    Returns:
        ``"spatial"`` or ``"planar"``, and ``"dynamic"`` or ``"force"``.

    Raises:
        Rejected: it is not well formed, or does not prove what it says.
    """
    check_form(proof)
    chain = fractions(proof["chain"]) | {"idle": set(proof["idle"])}
    p, pivots = proof["prime"], proof["pivots"]
    kind, way = momentum_of(chain), well_posed(chain)
    for name in NUMBERS:
        need(all(x.denominator % p for x in chain[name].flat), name, "prime in a denominator")
    chain["roots"] = roots(chain["radicands"], p)
    order = max((pivot["order"] for pivot in pivots), default=0)
    X = [list(conditions(chain, way, ray, order, p)) for ray in proof["rays"]]
    rows = [X[a["ray"]][a["order"]][a["column"], a["row"]] for a in pivots]
    minor = [[row[a["body"], a["parameter"]] for a in pivots] for row in rows]
    regular = len(echelon(np.array(minor, object), p)) == len(pivots)
    need(regular, "pivots", "their minor is zero modulo the prime")
    bodies, size = len(chain["links"]), len(chain["parameters"])
    moved = np.zeros((len(proof["transfers"]), bodies, size), object)
    parts = rigid_parts(chain)
    for row, transfer in zip(moved, proof["transfers"], strict=True):
        z = np.array([Fraction(x) for x in transfer["z"]], object)
        need(all(x.denominator % p for x in z), "transfers: z", "prime in a denominator")
        harmless(chain, parts, transfer, z)
        row[transfer["target"]] += z
        row[transfer["source"]] -= z * (transfer["source"] >= 0)
    different = echelon(modulo(moved.reshape(-1, bodies * size), p), p)
    need(len(different) == len(moved), "transfers", "not independent modulo the prime")
    return kind


def fractions(chain):
    """A well formed chain with arrays of fractions for its texts."""
    return chain | {
        name: np.array([[Fraction(x) for x in row] for row in chain[name]], object)
        for name in NUMBERS
    }


def momentum_of(chain):
    """Which momentum and which parameters the conditions are about: one of four kinds.

    In space [ξ; p] of all ten parameters, or p of m and mc. In a plane of normal n, and
    spanned by a and b: [ξ·n, p·a, p·b] of m, mc·a, mc·b and n·En, or p·a and p·b of the first
    three. All that moves does so in that plane.
    """
    rows, given = chain["rows"], chain["parameters"]
    units = np.array([[Fraction(int(i == j)) for j in range(10)] for i in range(10)], object)
    spatial = len(rows) == 6 or (len(rows) == 3 and not rows[:, :3].any())
    force = len(rows) == 2 or (len(rows) == 3 and spatial)
    if spatial:
        momenta, meant = units[3 * force : 6, :6], units[: 4 if force else 10]
    else:
        need(len(rows) in (2, 3), "rows", "neither of space nor of a plane")
        a, b = rows[-2:, 3:]
        zero, n = 0 * a, np.cross(a, b)
        momenta = [[*n, *zero], [*zero, *a], [*zero, *b]][force:]
        squares = [n[i] * n[j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        firsts = [[Fraction(0), *x, *[Fraction(0)] * 6] for x in (a, b)]
        meant = [units[0], *firsts, [*units[0, 1:5], *squares]][: 4 - force]
        for s in chain["screws"][sorted(set(range(len(chain["parent"]))) - chain["idle"])]:
            flat = not np.cross(s[:3], n).any() and s[3:] @ n == 0
            need(flat, "screws", "what moves does so out of the plane")
    need(same_span(rows, momenta), "rows", "not a momentum, or its rows depend on each other")
    need(same_span(given, meant), "parameters", "not those that the momentum depends on")
    return "spatial" if spatial else "planar", "force" if force else "dynamic"


def same_span(rows, others):
    """Whether independent rows span what others do, which are as many."""
    others = np.array(others, object)
    return len(rows) == len(others) == len(echelon(rows)) == len(echelon([*rows, *others]))


def well_posed(chain):
    """Joints on the way to each link, and last to the ground; their loops close for good.

    Constraints are as many as the dimensions of what the loops can do, and `conditions`
    finds them independent. The rows of momentum must not depend on the pose: no joint that
    moves leads out of their span.
    """
    screws, columns, dependent = (chain[name] for name in ("screws", "columns", "dependent"))
    way = np.zeros((len(screws) + 1, len(screws)), dtype=int)
    for j, parent in enumerate(chain["parent"]):
        way[j] = way[parent]
        way[j, j] = 1
    constraints = constraints_of(chain, way, set())
    need(len(dependent) == constraints, "dependent", f"not {constraints}, as constraints are")
    need(at_rest(chain, way), "idle", "not shown to be at rest")
    need(not columns[dependent].any(), "columns", "a dependent joint is driven")
    need(len(echelon(columns.T)) == columns.shape[1], "columns", "not independent")
    moving = [s for j, s in enumerate(screws) if j not in chain["idle"]]
    fixed = len(closed(chain["rows"], moving)) == len(chain["rows"])
    need(fixed, "rows", "they depend on the pose")
    return way


def constraints_of(chain, way, locked):
    """How many constraints loops and mimics are, for joints that are not locked."""
    free = np.array([j not in locked for j in range(len(chain["screws"]))])
    loops = [chain["screws"][(way[e] != way[f]) & free] for e, f in chain["ends"]]
    mimics = [row for row in chain["mimics"] if row[free].any()]
    return sum(len(closed(loop, loop)) for loop in loops) + len(mimics)


def at_rest(chain, way):
    """Whether the idle joints are at rest in every motion.

    Either they are kept at rest; or the linkage in which they are locked has as many
    independent constraints as dependent joints too, so that it loses no motion: both sets of
    poses are manifolds of the same dimension.
    """
    still, dependent = chain["idle"], set(chain["dependent"])
    if not still & dependent and not chain["columns"][sorted(still)].any():
        return True
    return constraints_of(chain, way, still) == len(dependent - still)


def conditions(chain, way, ray, order, p):
    """Conditions of each order along a ray, modulo p: (w, rows, bodies, parameters)."""
    screws, mimics, columns, rows, parameters = (
        modulo(chain[name], p) for name in ("screws", "mimics", "columns", "rows", "parameters")
    )
    parent, links, dependent = (chain[name] for name in ("parent", "links", "dependent"))
    screws = screws * chain["roots"][:, None] % p
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
        full = sorted(solved) == list(range(len(dependent)))
        need(full, "dependent", "their rates do not follow from the others")
        for c, row in solved.items():
            C[k][dependent[c]] = row[len(dependent) :]
        rates = sum(S[a][:, None] * C[k - a][..., None, None] for a in range(k + 1))
        T.append(np.tensordot(way, rates, 1) % p)
        V.append(np.tensordot(T[k], np.array(ray, object), ((1,), (0,))) % p)
        A = sum(T[a][links][:, :, None] @ P[k - a][:, None] for a in range(k + 1))
        yield (vee(A - A.mT) @ rows.T % p).transpose(1, 3, 0, 2)


def roots(radicands, p):
    """The product of roots of the radicands of each joint modulo p."""
    found = {}
    for b in {b for numbers in radicands for b in numbers}:
        need(p % 4 == 3 and pow(b, (p - 1) // 2, p) == 1, "radicands", "no root modulo p")
        found[b] = pow(b, (p + 1) // 4, p)
    return np.array([math.prod(found[b] for b in numbers) % p for numbers in radicands], object)


def rigid_parts(chain):
    """The part of each link, and last of the ground: what is welded or idle is one part."""
    parent = chain["parent"]
    part = [*range(len(parent)), -1]
    for a, b in [*chain["ends"], *((j, parent[j]) for j in sorted(chain["idle"]))]:
        part = [part[b] if x == part[a] else x for x in part]
    return part


def harmless(chain, part, transfer, z):
    """Parameters z pass joints, one by one, and the momentum of all motions stays 0.

    They turn into ``Lᵏ z`` on the other side: of the twists V below a joint, and its screw
    s, ``M(Lᵏ z) s = 0`` for all k, and ``M(Lᵏ z) V = 0`` but for k = 0. L acts on ten
    parameters, so that nine k are enough. Bodies of one part exchange anything.
    """
    links, below, joints = chain["links"], transfer["below"], transfer["joints"]
    stops = [part[links[transfer[b]] if transfer[b] >= 0 else -1] for b in ("source", "target")]
    if not joints:
        need(not below and stops[0] == stops[1], "transfers", "no joint, and not one part")
        return
    visited, V = [part[-1]], []
    for i, j in enumerate([*below, *joints]):
        P, s = pseudo(z @ chain["parameters"]), chain["screws"][j]
        for k in range(10 if i >= len(below) else 0):
            for A in [hat(t) @ P for t in (*V[: None if k else 0], s)]:
                still = not (chain["rows"] @ vee(A - A.T)).any()
                need(still, "transfers: z", "it changes the momentum")
            P = A + A.T  # by the last of them, s
        ends = [part[j], part[chain["parent"][j]]]
        joined = visited[-1] in ends and ends[0] != ends[1]
        need(joined, "transfers: joints", "one does not lead on from the part before")
        ends.remove(visited[-1])
        visited, V = visited + ends, closed([s, *V], [s])
    right = [visited[len(below)], visited[-1]] == stops
    need(right, "transfers: joints", "they do not lead from the source to the target")


def closed(twists, by):
    """A basis of the smallest span that contains twists, and its brackets with others."""
    span = list(echelon(twists).values())
    more = [
        np.concatenate(
            [np.cross(s[:3], t[:3]), np.cross(s[:3], t[3:]) + np.cross(s[3:], t[:3])]
        )
        for s in by
        for t in span
    ]
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


if __name__ == "__main__":
    try:
        found = read(Path(sys.argv[1]).read_text("utf-8"))
        words = check(found)
        for file in sys.argv[2:3]:
            from tests.independent.checker_file import check_file

            check_file(found, Path(file).read_bytes())
    except Rejected as error:
        sys.exit(f"rejected: {error}")
    sys.stdout.write(f"{' '.join(words)}: rank {found['rank']}, nullity {found['nullity']}\n")
