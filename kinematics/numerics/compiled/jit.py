"""The decorator ``kernel``: functions of numbers and arrays, compiled by Numba or uncompiled.

    from kinematics.numerics.compiled.jit import kernel

A kernel may use functions and constants of files that contain this line, or the dotted name in
it, and of no others: their hash names the folder of compiled kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial, update_wrapper
from threading import local
from time import perf_counter
from typing import Any

import numpy as np

from kinematics.numerics.compiled.background import compile_mode, kernel_clock
from kinematics.numerics.compiled.cache_contents import kernel_name


def kernel(
    function: Callable[..., Any] | None = None,
    *,
    inline: bool = False,
    reference_counting: bool = True,
    uncompiled: Callable[..., Any] | None = None,
) -> Any:
    """Make a kernel of ``function``: compiled at its first call, or not at all.

    `kinematics.numerics.compiled.background` chooses which.

    Args:
        function: a function of numbers and arrays.
        inline: put the code into that of its callers. A call with array arguments costs as
            much as dozens of multiplications.
        reference_counting: False if the kernel neither makes arrays, nor returns any, nor
            keeps one that another kernel returns; this is checked when it is compiled. Numba
            then needs no atomic instructions for array arguments, which makes the sweep of
            `balance.space.design_space_many` two to three times as fast, and single answers by
            a sixth.
        uncompiled: a function of the same arguments and effects by operations on whole arrays,
            which is called until the kernel is compiled: for loops that Python runs a hundred
            times slower.

    Returns:
        The kernel; a decorator if there is no function.
    """
    if function is None:
        return partial(
            kernel, inline=inline, reference_counting=reference_counting, uncompiled=uncompiled
        )
    wrapper = _Kernel(function, inline, reference_counting, uncompiled or function)
    return wrapper.compiled if compile_mode() == "now" else wrapper


class _RunningKernel(local):
    """Whether an uncompiled kernel is running in this thread."""

    kernel = False


_running = _RunningKernel()


class _Kernel:
    """A kernel that runs without a compiler, until a compiled one is worth loading.

    It takes the arguments of a compiled one and returns the same results: Python numbers
    instead of NumPy scalars. Division by zero gives an infinity or a NaN without a warning.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        inline: bool,
        reference_counting: bool,
        uncompiled: Callable[..., Any],
    ) -> None:
        """Keep the options of the compiler."""
        update_wrapper(self, function)
        self._uncompiled = uncompiled
        self.py_func, self._options = function, (inline, reference_counting)
        self._name = kernel_name(function)

    def __call__(self, *args: Any) -> Any:
        """Call the function, uncompiled unless compiled kernels are worth loading by now."""
        if _running.kernel:
            return self._uncompiled(*args)
        if kernel_clock.runs_compiled(self._name):
            return self.compiled(*args)
        _running.kernel, start = True, perf_counter()
        try:
            with np.errstate(all="ignore"):
                numbers = (np.float64(x) if type(x) is float else x for x in args)
                return _unbox_numbers(self._uncompiled(*numbers))
        finally:
            _running.kernel = False
            kernel_clock.add(perf_counter() - start)

    @cached_property
    def compiled(self) -> Any:
        """The same function, compiled at its first call or loaded from the disk."""
        from kinematics.numerics.compiled.numba_compiler import compile_kernel, let_kernels_call

        let_kernels_call(_Kernel)
        return compile_kernel(self.py_func, *self._options)


def _unbox_numbers(value: Any) -> Any:
    """Convert NumPy scalars to Python numbers, in tuples too."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple):
        items = map(_unbox_numbers, value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value
