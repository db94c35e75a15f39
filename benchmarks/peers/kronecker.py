"""Full tensors of mixed derivatives with Kronecker products, in NumPy, as the thesis has them.

D^k of a matrix has an index for each differentiation: symmetric entries are all there. The
product rule sums over the subsets of these indices; ``D sin q = cos q ⊗ Dq``. The closure of
order k is linear in ``D^k q``, with the Jacobian of order 1.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations
from math import factorial

import numpy as np

from benchmarks.peers import jobs

Tensors = list[np.ndarray]


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    inverse = np.linalg.inv(jacobian())

    def read(q: list[Tensors]) -> np.ndarray:
        return np.array(
            [
                [
                    each[i + j][(0,) * i + (1,) * j] / (factorial(i) * factorial(j))
                    for i, j in jobs.exponents(order)
                ]
                for each in q
            ]
        )

    return lambda: _expand(order, inverse), read


def jacobian() -> np.ndarray:
    """Motion of both tips with the angles (4, 4)."""
    J = np.zeros((4, 4))
    for i in (0, 2):
        a, b = jobs.ANGLES[i], jobs.ANGLES[i] + jobs.ANGLES[i + 1]
        upper = jobs.UPPER * np.array([-np.sin(b), np.cos(b)])
        J[i : i + 2, i + 1] = upper
        J[i : i + 2, i] = upper + jobs.LOWER * np.array([-np.sin(a), np.cos(a)])
    return J


@cache
def _subsets(k: int) -> list[tuple[int, tuple[int, ...]]]:
    """Sizes of the subsets of k indices, and the order that puts them back in their places."""
    found = []
    for size in range(k + 1):
        for chosen in combinations(range(k), size):
            rest = tuple(i for i in range(k) if i not in chosen)
            found.append((size, tuple(np.argsort(chosen + rest).tolist())))
    return found


def _ordered(k: int, form: Callable[[int], np.ndarray], kept: int) -> np.ndarray:
    """Sum over all subsets of k indices; ``form(size)`` has them after ``kept`` others."""
    formed = [form(size) for size in range(k + 1)]
    head = tuple(range(kept))
    return sum(
        formed[size].transpose(head + tuple(kept + i for i in places))
        for size, places in _subsets(k)
    )


def _product(A: Tensors, B: Tensors, k: int) -> np.ndarray:
    """D^k of the matrix product A B."""

    def form(size: int) -> np.ndarray:
        both = np.tensordot(A[size], np.moveaxis(B[k - size], 1, -1), axes=([1], [0]))
        return np.moveaxis(both, -1, 1)

    return _ordered(k, form, 2)


class _Turn:
    """A joint at an offset along x: its angle, and its matrix, with all their derivatives."""

    def __init__(self, offset: float, angle: float) -> None:
        self.q, self.sin, self.cos = ([np.array(f(angle))] for f in (float, np.sin, np.cos))
        self.S = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 0]])
        self.C = np.diag([1.0, 1.0, 0.0])
        fixed = np.array([[0.0, 0, offset], [0, 0, 0], [0, 0, 1]])
        self.matrix = [fixed + self.S * self.sin[0] + self.C * self.cos[0]]

    def extend(self, k: int, angle: np.ndarray) -> None:
        """Derivatives of order k, from that of the angle."""
        self.q[k:], self.sin[k:], self.cos[k:], self.matrix[k:] = [angle], [], [], []

        def rate(of: Tensors) -> np.ndarray:
            def form(size: int) -> np.ndarray:
                both = np.multiply.outer(self.q[k - size], of[size])
                places = (0, *range(k - size, k), *range(1, k - size))
                return both.transpose(places)

            return _ordered(k - 1, form, 1)

        sine, cosine = rate(self.cos), -rate(self.sin)
        self.sin.append(sine)
        self.cos.append(cosine)
        self.matrix.append(np.multiply.outer(self.S, sine) + np.multiply.outer(self.C, cosine))


def _expand(order: int, inverse: np.ndarray) -> list[Tensors]:
    """All derivatives of the angles."""
    arms = [
        [_Turn(base, jobs.ANGLES[2 * i]), _Turn(jobs.LOWER, jobs.ANGLES[2 * i + 1])]
        for i, base in enumerate(jobs.BASES)
    ]
    joints = [joint for arm in arms for joint in arm]
    end = np.array([jobs.UPPER, 0.0, 1.0])
    chains: list[Tensors] = [[one.matrix[0] @ two.matrix[0]] for one, two in arms]
    for k in range(1, order + 1):
        shape = (2,) * k
        known = _tips(arms, chains, end, k, np.zeros((4, *shape)))
        if k == 1:
            known -= np.tile(np.eye(2), (2, 1))
        q = -(inverse @ known.reshape(4, -1)).reshape(4, *shape)
        if k < order:
            _tips(arms, chains, end, k, q)
        else:
            for joint, angle in zip(joints, q, strict=True):
                joint.q[k] = angle
    return [joint.q for joint in joints]


def _tips(
    arms: list[list[_Turn]], chains: list[Tensors], end: np.ndarray, k: int, q: np.ndarray
) -> np.ndarray:
    """D^k of the positions of both tips, given that of the angles."""
    found = []
    for i, (one, two) in enumerate(arms):
        one.extend(k, q[2 * i])
        two.extend(k, q[2 * i + 1])
        chains[i][k:] = [_product(one.matrix, two.matrix, k)]
        found.append(np.tensordot(chains[i][k], end, axes=([1], [0]))[:2])
    return np.concatenate(found)
