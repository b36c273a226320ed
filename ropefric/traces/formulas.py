"""Channels computed from others by a short formula: arithmetic of channels, constants and numbers, nothing else."""

import ast
from collections.abc import Mapping

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.registry import did_you_mean

_OPERATIONS: dict[type[ast.operator], np.ufunc] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power
}  # fmt: skip
_LONGEST = 400
_HINT = 'write arithmetic of channels in SI (+ - * / **), such as force = "pull - pressure * area"'


def evaluate_derived(
    derived: Mapping[str, str],
    channels: Mapping[str, FloatArray],
    constants: Mapping[str, float],
    *,
    path: str = "",
) -> dict[str, FloatArray]:
    """Return the channels together with the derived ones, computed in the order written.

    A formula sees every channel, those derived before it, and the constants, all in SI. It may take the name of a
    channel, which it then replaces.
    """
    known: dict[str, FloatArray] = dict(channels)
    clash = sorted(set(constants) & (set(channels) | set(derived)))
    if clash:
        why, key = f"{clash[0]!r} is a constant and a channel at once", "[import.constants]"
        raise DataError(why, code="RF109", path=path, key=key, fix="rename one of them")
    for name, formula in derived.items():
        try:
            known[name] = _evaluate(formula.strip(), known, constants)
        except _FormulaError as error:
            shown = formula if len(formula) <= 80 else formula[:77] + "..."
            why, key = f"{shown!r} {error.args[0]}", f"[import.derived] {name}"
            raise DataError(why, code="RF109", path=path, key=key, fix=error.args[1] or _HINT) from None
    return known


class _FormulaError(Exception):
    """The error of a formula."""

    def __init__(self, why: str, fix: str = "") -> None:
        super().__init__(why, fix)


def _evaluate(formula: str, channels: Mapping[str, FloatArray], constants: Mapping[str, float]) -> FloatArray:
    if len(formula) > _LONGEST:
        raise _FormulaError(f"is longer than {_LONGEST} characters")
    try:
        tree = ast.parse(formula, mode="eval")
        with np.errstate(all="ignore"):  # what comes of it is judged below
            result = np.asarray(_value(tree.body, {**constants, **channels}))
    except (SyntaxError, ValueError, RecursionError, MemoryError, OverflowError, Warning):
        raise _FormulaError("is not a formula") from None
    words = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    inputs = [channels[word] for word in channels if word in words]
    if not inputs:
        raise _FormulaError("uses no channel")
    unexplained = ~np.isfinite(result) & np.all([np.isfinite(channel) for channel in inputs], axis=0)
    unexplained |= np.isinf(result)
    if unexplained.any():
        index = int(np.argmax(unexplained))
        raise _FormulaError(f"gives {result[index]} at sample {index + 1}")
    return result.astype(np.float64)


def _value(node: ast.AST, symbols: Mapping[str, FloatArray | float]) -> FloatArray | float:
    """Return the value of a part of a formula."""
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        operands = _value(node.left, symbols), _value(node.right, symbols)
        value = np.asarray(_OPERATIONS[type(node.op)](*operands))
        if value.ndim == 0 and not np.isfinite(
            value
        ):  # a channel divided by it would be zero, and look like one
            raise _FormulaError(f"gives {value} in {ast.unparse(node)!r}")
        return value
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_value(node.operand, symbols)
    if isinstance(node, ast.Name):
        if node.id not in symbols:
            raise _FormulaError(f"uses the unknown name {node.id!r}", did_you_mean(node.id, symbols))
        return symbols[node.id]
    number = node.value if isinstance(node, ast.Constant) else None
    if isinstance(number, int | float) and not isinstance(number, bool):
        return float(number)
    raise _FormulaError(f"is more than arithmetic ({type(node).__name__})")
