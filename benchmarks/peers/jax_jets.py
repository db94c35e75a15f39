"""JAX: `jax.experimental.jet` of the closure, order by order with one factorised Jacobian.

For two inputs, along as many directions as there are monomials of the highest degree, whose
coefficients give those of the monomials by least squares. Compiled as a whole.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial

import numpy as np

from benchmarks.peers import jobs, library


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    jax = library("jax")
    jet = library("jax.experimental.jet").jet
    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy
    turn = np.pi * (np.arange(order + 1) + 0.25) / (order + 1)
    rays = np.column_stack([np.cos(turn), np.sin(turn)])
    fits = [
        np.linalg.pinv([[x ** (k - j) * y**j for j in range(k + 1)] for x, y in rays])
        / factorial(k)
        for k in range(1, order + 1)
    ]

    def closure(q, tip):
        parts = []
        for i, base in zip((0, 2), jobs.BASES, strict=True):
            both = q[i] + q[i + 1]
            x = jobs.LOWER * jnp.cos(q[i]) + jobs.UPPER * jnp.cos(both)
            y = jobs.LOWER * jnp.sin(q[i]) + jobs.UPPER * jnp.sin(both)
            parts += [x + base - tip[0], y - tip[1]]
        return jnp.stack(parts)

    def along(q, tip, ray):
        factors = jax.scipy.linalg.lu_factor(jax.jacfwd(closure)(q, tip))
        found = []
        for k in range(1, order + 1):
            straight = [ray] + [jnp.zeros(2)] * (k - 1)
            _, series = jet(closure, (q, tip), ([*found, jnp.zeros(4)], straight))
            found.append(-jax.scipy.linalg.lu_solve(factors, series[-1]))
        return jnp.stack(found)

    @jax.jit
    def expand(q, tip):
        jets = jax.vmap(lambda ray: along(q, tip, ray))(jnp.array(rays))
        parts = [(fit @ jets[:, k]).T for k, fit in enumerate(fits)]
        return jnp.concatenate([q[:, None], *parts], axis=1)

    start, tip = jnp.array(jobs.ANGLES), jnp.array(jobs.TIP)
    return lambda: np.asarray(expand(start, tip)), np.array
