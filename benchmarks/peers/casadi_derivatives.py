"""CasADi: nested directional derivatives of ``J(q)⁻¹ v`` as expressions, compiled to C.

Each mixed derivative is that of the one before along one more input. Expressions grow fast:
up to order 5 here.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial

import numpy as np

from benchmarks.peers import jobs, library

HIGHEST = 5


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    if order > HIGHEST:
        raise NotImplementedError(f"casadi takes too long to compile beyond order {HIGHEST}")
    ca = library("casadi")
    q = ca.SX.sym("q", 4)
    along = _fields(ca, q)
    known = {(0, 0): q}
    for i, j in jobs.exponents(order)[1:]:
        earlier, field = ((i - 1, j), along[0]) if i else ((i, j - 1), along[1])
        known[i, j] = ca.jtimes(known[earlier], q, field)
    scaled = [known[i, j] / (factorial(i) * factorial(j)) for i, j in jobs.exponents(order)]
    whole = ca.densify(ca.horzcat(*scaled))
    flags = ["-O2" if order < HIGHEST else "-O1"]
    options = {
        "jit": True,
        "compiler": "shell",
        "jit_temp_suffix": True,
        "jit_options": {"flags": flags, "verbose": False},
    }
    function = ca.Function("coefficients", [q], [whole], options)
    buffer, run = function.buffer()
    values, out = jobs.ANGLES.copy(), np.zeros(whole.numel())
    buffer.set_arg(0, memoryview(values))
    buffer.set_res(0, memoryview(out))
    kept = (function, buffer, values)

    def read(_: object, kept: tuple = kept) -> np.ndarray:
        return out.reshape(whole.shape, order="F").copy()

    return run, read


def _fields(ca, q) -> list:
    """Rates of the angles as the tip moves along x, and along y."""
    x, y = [], []
    for i in (0, 2):
        both = q[i] + q[i + 1]
        b = -jobs.UPPER * ca.sin(both), jobs.UPPER * ca.cos(both)
        a = b[0] - jobs.LOWER * ca.sin(q[i]), b[1] + jobs.LOWER * ca.cos(q[i])
        determinant = a[0] * b[1] - a[1] * b[0]
        x += [b[1] / determinant, -a[1] / determinant]
        y += [-b[0] / determinant, a[0] / determinant]
    return [ca.vertcat(*x), ca.vertcat(*y)]
