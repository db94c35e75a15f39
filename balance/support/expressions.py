"""Arithmetic expressions of parameters, read without ever being executed as code.

An expression is made of numbers, names of parameters such as ``q2.origin.x``, the operations
``+ - * / **``, parentheses, the constant ``pi`` and the functions of `FUNCTIONS`. Conditions
compare two or more expressions by ``< <= > >=``.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics.numerics.array_types import Array

FUNCTIONS: dict[str, tuple[Callable[..., Any], int]] = {
    "abs": (np.abs, 1),
    "acos": (np.arccos, 1),
    "asin": (np.arcsin, 1),
    "atan2": (np.arctan2, 2),
    "cos": (np.cos, 1),
    "hypot": (np.hypot, 2),
    "max": (np.maximum, 2),
    "min": (np.minimum, 2),
    "sin": (np.sin, 1),
    "sqrt": (np.sqrt, 1),
    "tan": (np.tan, 1),
}
"""Functions that an expression may use, and how many arguments each takes."""
_OPERATIONS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
# Most characters of an expression, and most operations inside one another.
LONGEST, DEEPEST = 2000, 50


class ExpressionError(ValueError):
    """A text that is no expression; the message says why, without place and remedy."""


@dataclass(frozen=True)
class Expression:
    """An expression that was read.

    Attributes:
        text: the expression as it was written.
        names: names of the parameters in it, in order, each once.
        comparison: whether it is a condition, true or false.
    """

    text: str
    names: tuple[str, ...]
    comparison: bool

    def __call__(self, values: Mapping[str, Array]) -> NDArray[Any]:
        """Compute the values of the expression; NaN or infinite where it has none.

        Args:
            values: of each name (rows,).
        """
        with np.errstate(all="ignore"):
            return np.asarray(_value(_body(self.text), values))


def read_expression(text: str, comparison: bool = False) -> Expression:
    """Read an expression.

    Args:
        text: such as ``"2*q2.origin.x + 0.1"``.
        comparison: whether it must be a condition, such as ``"q2.origin.x < 0.3"``.

    Returns:
        The expression, which can be called with values of its names.

    Raises:
        ExpressionError: the text is none.
    """
    body = _body(text)
    if isinstance(body, ast.Compare) != comparison:
        wanted = (
            "a condition such as 'a.length < 0.5'" if comparison else "a number, not a test"
        )
        raise ExpressionError(f"'{text.strip()[:80]}' must be {wanted}")
    names = tuple(dict.fromkeys(_names(body, 0)))
    return Expression(text, names, comparison)


def _body(text: str) -> ast.expr:
    """Parse a text into a tree of expressions."""
    if len(text) > LONGEST:
        raise ExpressionError(f"longer than {LONGEST} characters")
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"cannot read '{' '.join(text.split())[:80]}'") from None


def _names(node: ast.expr, depth: int) -> Iterator[str]:
    """Yield the names of parameters in an expression.

    Raises:
        ExpressionError: it has a part that is not allowed.
    """
    if depth > DEEPEST:
        raise ExpressionError(f"more than {DEEPEST} operations inside one another")
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return
    if isinstance(node, (ast.Name, ast.Attribute)):
        name = _dotted(node)
        if name != "pi":
            yield name
        return
    for part in _parts(node):
        yield from _names(part, depth + 1)


def _parts(node: ast.expr) -> list[ast.expr]:
    """List the operands of an operation, a comparison or a function.

    Raises:
        ExpressionError: it is none of these, or not one that is known.
    """
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        return [node.left, node.right]
    if isinstance(node, ast.UnaryOp) and type(node.op) in _OPERATIONS:
        return [node.operand]
    if isinstance(node, ast.Compare) and all(type(op) in _OPERATIONS for op in node.ops):
        return [node.left, *node.comparators]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        name = node.func.id
        if name not in FUNCTIONS:
            choices = ", ".join(sorted(FUNCTIONS))
            raise ExpressionError(f"no function '{name}'; there are {choices}")
        if len(node.args) == FUNCTIONS[name][1]:
            return node.args
        raise ExpressionError(f"'{name}' takes {FUNCTIONS[name][1]} arguments")
    raise ExpressionError(f"'{ast.unparse(node)[:80]}' is no arithmetic of parameters")


def _dotted(node: ast.expr) -> str:
    """Join the parts of a name such as ``q2.origin.x``."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    raise ExpressionError(f"'{ast.unparse(node)[:80]}' is no name of a parameter")


def _value(node: ast.expr, values: Mapping[str, Array]) -> Any:
    """Compute a part of an expression."""
    if isinstance(node, ast.Constant):
        return np.float64(node.value)  # type: ignore[arg-type]
    if isinstance(node, (ast.Name, ast.Attribute)):
        name = _dotted(node)
        return np.pi if name == "pi" else values[name]
    parts = [_value(part, values) for part in _parts(node)]
    if isinstance(node, ast.Call):
        return FUNCTIONS[_dotted(node.func)][0](*parts)
    if isinstance(node, ast.Compare):
        pairs = zip(node.ops, parts[:-1], parts[1:], strict=True)
        return np.all(
            np.broadcast_arrays(*[_OPERATIONS[type(op)](a, b) for op, a, b in pairs]), axis=0
        )
    assert isinstance(node, (ast.BinOp, ast.UnaryOp))
    return _OPERATIONS[type(node.op)](*parts)
