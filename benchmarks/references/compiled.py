"""Compile and call the kernels in C, as a lower bound on the cost of the same arithmetic."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.harness.processes import python
from kinematics.model.arrays import Chain

SOURCE = Path(__file__).with_name("kernels.c")
LIMIT = ("-O3", "-march=native")
COUNTING = ("-x", "c++", "-DCOUNT", "-O1")
# Runs the Python source of the kernel on numbers that count their operations.
COUNT_HERE = """
import sys
import numpy as np
from balance.space.momentum import regressor_kernels
from balance.space.momentum.regressor import body_regressors, regressor_workspace
from kinematics.closure.series import expand
from kinematics.loading.model_gallery import load

counts = [0, 0, 0]
# The loops that are compiled, not the whole arrays that stand in for them until then.
for each in vars(regressor_kernels).values():
    if hasattr(each, "py_func"):
        each._uncompiled = each.py_func

class Number:
    def __init__(self, x):
        self.x = x

def operation(which, does, swapped=False):
    def method(self, other):
        counts[which] += 1
        other = getattr(other, "x", other)
        return Number(does(other, self.x) if swapped else does(self.x, other))
    return method

for name, which, does in (
    ("add", 0, lambda a, b: a + b), ("sub", 0, lambda a, b: a - b),
    ("mul", 1, lambda a, b: a * b), ("truediv", 2, lambda a, b: a / b),
):
    setattr(Number, f"__{name}__", operation(which, does))
    setattr(Number, f"__r{name}__", operation(which, does, True))
Number.__neg__ = lambda self: Number(-self.x)

def counting(a):
    out = np.empty(a.shape, object)
    out.ravel()[:] = [Number(x) for x in a.ravel().tolist()]
    return out

chain, order, rays = load(sys.argv[1]).chain, int(sys.argv[2]), int(sys.argv[3])
series = expand(chain, np.ones((rays, chain.width)), order)
size, rows = (4, 3) if chain.planar else (10, 6)
X = counting(np.zeros((order + 1, rays, chain.width, rows, chain.links.size * size)))
workspace = regressor_workspace(series.V, chain.links, chain.moves)
both = [a.astype(object) for a in workspace]
start = np.empty((0, 4, 4))
V, T = counting(series.V), counting(series.T)
body_regressors(0, order, start, chain.links, chain.moves, V, T, both, X)
print(*counts)
"""


@cache
def _library(options: tuple[str, ...] = LIMIT) -> ctypes.CDLL:
    """Compile the C file; NotImplementedError if that fails."""
    compiler = shutil.which("cc") or shutil.which("clang")
    if compiler is None:
        raise NotImplementedError("no C compiler was found")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "kernels.so"
        command = [compiler, *options, "-shared", "-fPIC", str(SOURCE), "-o", str(file), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise NotImplementedError(f"the C compiler failed: {done.stderr[:200]}")
        return ctypes.CDLL(str(file))


def _call(function: ctypes._CFuncPtr, *arguments: int | np.ndarray) -> None:
    """Call C with integers as ``long`` and arrays as pointers."""
    function(
        *(
            ctypes.c_void_p(a.ctypes.data) if isinstance(a, np.ndarray) else ctypes.c_long(a)
            for a in arguments
        )
    )


def momentum(
    chain: Chain, V: np.ndarray, T: np.ndarray, X: np.ndarray, options: tuple[str, ...] = LIMIT
) -> None:
    """Add the rows of all orders to X, like `momentum.regressor.body_regressors`."""
    library = _library(options)
    function = library.momentum_planar if chain.planar else library.momentum_spatial
    rays, orders, n = V.shape[:3]
    bodies, width = chain.links.size, chain.width
    H = np.empty(12 * rays * orders * bodies)
    N = np.empty(15 * rays * orders * bodies * width)
    _call(function, rays, orders, n, width, bodies, chain.links, chain.moves, V, T, H, N, X)


def operations_in_c(chain: Chain, V: np.ndarray, T: np.ndarray) -> list[int]:
    """Count additions, multiplications and divisions of the C kernel as it runs."""
    rays, orders = V.shape[:2]
    counts = np.zeros(3, np.int64)
    size, rows = (4, 3) if chain.planar else (10, 6)
    X = np.zeros((orders, rays, chain.width, rows, chain.links.size * size))
    _call(_library(COUNTING).counted, counts)
    momentum(chain, V, T, X, COUNTING)
    _call(_library(COUNTING).counted, counts)
    return counts.tolist()


def operations_here(model: str, order: int, rays: int) -> list[int]:
    """Count those of the Python source of our kernel, in a process that compiles nothing."""
    text = python("-c", COUNT_HERE, model, str(order), str(rays), NUMBA_DISABLE_JIT="1")
    return [int(word) for word in text.split()]


def both_kernels(chain: Chain, screws: np.ndarray, order: int, X: np.ndarray) -> None:
    """Run closure and momentum of planar geometries (count, n, 3), one input; X of the last."""
    n, bodies, loops = chain.parent.size, chain.links.size, len(chain.ends)
    count = chain.dependent.size
    work = np.empty(
        3 * loops * (count + 1) + count + 3 * n + (order + 1) * (10 * n + 8 * bodies)
    )
    columns = np.ascontiguousarray(chain.columns)
    _call(
        _library().kernels_planar,
        len(screws),
        order + 1,
        n,
        chain.parent,
        screws,
        loops,
        chain.ends,
        count,
        chain.dependent,
        columns,
        work,
        bodies,
        chain.links,
        chain.moves,
        X,
    )
