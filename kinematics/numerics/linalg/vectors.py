"""Floating-point vectors: cross products, groups of equal ones, projection, complements."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinematics.numerics.array_types import Array, Flags

Alike = Callable[[Array, Array], Flags]
# Cyclic permutations of the axes.
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def alike_groups(vectors: Sequence[Array] | Array, alike: Alike) -> list[list[int]]:
    """Group vectors: each joins the first group whose first vector is alike.

    Args:
        vectors: of one length d (count, d).
        alike: decides which of some vectors (k, d) are alike another (d,), as (k,), by a
            tolerance of the caller's.

    Returns:
        Indices of the vectors of each group, ascending; groups in the order of their first.
    """
    all_vectors = np.asarray(vectors, dtype=np.float64)
    groups: list[list[int]] = []
    firsts = np.empty_like(all_vectors)
    for i, vector in enumerate(all_vectors):
        same = np.flatnonzero(alike(firsts[: len(groups)], vector))
        if same.size:
            groups[same[0]].append(i)
        else:
            firsts[len(groups)] = vector
            groups.append([i])
    return groups


def distinct_vectors(vectors: Sequence[Array] | Array, alike: Alike) -> list[int]:
    """Find the vectors that are alike none of those before them.

    Args:
        vectors: of one length d (count, d).
        alike: as for `alike_groups`.

    Returns:
        Their indices, ascending.
    """
    return [group[0] for group in alike_groups(vectors, alike)]


def complement(basis: Array) -> Array:
    """Compute orthonormal columns (n, n - k) that complete orthonormal ones (n, k)."""
    return np.asarray(np.linalg.qr(basis, mode="complete")[0][:, basis.shape[1] :])


def project_out(vectors: Array, directions: Array) -> Array:
    """Project vectors onto the complement of directions, ``v - D (Dᵀ v)``.

    Args:
        vectors: one (n,), or several as columns (n, m).
        directions: a unit vector (n,), or orthonormal columns D (n, count).

    Returns:
        Shape of ``vectors``.
    """
    if directions.ndim == 1:
        along = np.multiply.outer(directions, directions @ vectors)
    else:
        along = directions @ (directions.T @ vectors)
    return np.asarray(vectors - along)


def cross_products(a: Array, b: Array) -> Array:
    """Compute cross products ``a × b``, those of NumPy bit by bit in a quarter of its time.

    Args:
        a: vectors (..., 3).
        b: vectors (..., 3).
    """
    return np.asarray(a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT])
