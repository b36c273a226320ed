"""Channels computed from others by a short formula: arithmetic only, checked before it is run."""

import ast
import math
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.registry import did_you_mean

FUNCTIONS: dict[str, Any] = {
    name: getattr(np, name)
    for name in (
        "abs", "sign", "sqrt", "cbrt", "exp", "log", "log10", "sin", "cos", "tan", "arcsin", "arccos", "arctan",
        "arctan2", "sinh", "cosh", "tanh", "hypot", "radians", "degrees", "minimum", "maximum", "clip", "where",
        "cumsum", "gradient", "mean", "median", "min", "max",
    )
}  # fmt: skip
"""Functions that a formula may call: numpy's of these names."""

_CONSTANTS = {"pi": math.pi}
_GRAMMAR = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Compare, ast.Call, ast.Name, ast.Load, ast.Constant,
    ast.operator, ast.unaryop, ast.cmpop,
)  # fmt: skip
_NO_BITS = (ast.LShift, ast.RShift, ast.BitOr, ast.BitXor, ast.MatMult, ast.In, ast.NotIn, ast.Is, ast.IsNot)
_MAX_LENGTH = 1000
_HINT = 'write arithmetic with channels in SI, such as force = "pull - pressure * area"'


def evaluate_derived(
    derived: Mapping[str, str],
    channels: Mapping[str, FloatArray],
    constants: Mapping[str, float],
    *,
    path: str = "",
) -> dict[str, FloatArray]:
    """Return the channels together with the derived ones, computed in the order written.

    A formula sees every channel, those derived before it, the constants, `pi` and `FUNCTIONS`, all in SI.
    It may take the name of a channel, which it then replaces.
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
    symbols = {**FUNCTIONS, **_CONSTANTS, **constants, **channels}
    tree, used = _parse(formula, symbols.keys())
    try:
        with np.errstate(all="ignore"):  # what comes of it is judged below
            code = compile(tree, "<derived>", "eval")
            result = np.asarray(eval(code, {"__builtins__": {}}, symbols))  # noqa: S307  (arithmetic only, see _parse)
    except Exception as error:  # noqa: BLE001  (whatever a formula does wrong, the user hears of the formula)
        reason = str(error).strip().splitlines()
        raise _FormulaError(f"fails: {reason[0] if reason else type(error).__name__}") from None
    inputs = [channels[word] for word in channels if word in used]
    if result.dtype.kind not in "buif":
        raise _FormulaError(f"gives {result.dtype} values, not real numbers")
    if not inputs:
        raise _FormulaError("uses no channel")
    if result.shape != inputs[0].shape:
        raise _FormulaError(f"gives shape {result.shape}, but the channels have {inputs[0].shape}")
    result = result.astype(np.float64)
    unexplained = ~np.isfinite(result) & np.all([np.isfinite(channel) for channel in inputs], axis=0)
    unexplained |= np.isinf(result)
    if unexplained.any():
        index = int(np.argmax(unexplained))
        raise _FormulaError(f"gives {result[index]} at sample {index + 1}")
    return np.ascontiguousarray(result)


def _parse(formula: str, known: AbstractSet[str]) -> tuple[ast.Expression, set[str]]:
    """Return the formula's tree and the names it uses, after checking that it is arithmetic only."""
    if len(formula) > _MAX_LENGTH:
        raise _FormulaError(f"is longer than {_MAX_LENGTH} characters")
    try:
        tree = ast.parse(formula, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError, Warning):
        raise _FormulaError("is not a formula") from None
    used: set[str] = set()
    for node in ast.walk(tree):
        if not isinstance(node, _GRAMMAR) or isinstance(node, _NO_BITS):
            raise _FormulaError(f"is more than arithmetic ({type(node).__name__})")
        if isinstance(node, ast.Constant):
            node.value = _to_float(node.value)
        elif isinstance(node, ast.Call):
            called = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
            if called not in FUNCTIONS:
                raise _FormulaError(
                    f"calls {called!r}, which is not offered", did_you_mean(called, FUNCTIONS)
                )
        elif isinstance(node, ast.Name):
            if node.id not in known:
                hint = did_you_mean(node.id, known - FUNCTIONS.keys())
                raise _FormulaError(f"uses the unknown name {node.id!r}", hint)
            used.add(node.id)
    return tree, used


def _to_float(literal: object) -> float:
    """Return a literal as a float: 9**9**9 in integers would never end."""
    if isinstance(literal, bool) or not isinstance(literal, int | float):
        raise _FormulaError(f"holds {literal!r}, which is no number")
    try:
        return float(literal)
    except OverflowError:
        raise _FormulaError("holds a number too large for a float") from None
