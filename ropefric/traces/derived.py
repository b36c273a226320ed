"""Channels computed from others by a short formula that can do nothing but arithmetic."""

import ast
import math
from collections.abc import Mapping
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
"""What a formula may call: numpy's functions of these names."""

_CONSTANTS = {"pi": math.pi}
_GRAMMAR = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Compare, ast.Call, ast.Name, ast.Load, ast.Constant,
    ast.operator, ast.unaryop, ast.cmpop,
)  # fmt: skip
_NO_BITS = (ast.LShift, ast.RShift, ast.BitOr, ast.BitXor, ast.MatMult, ast.In, ast.NotIn, ast.Is, ast.IsNot)
_MAX_LENGTH = 1000


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
        raise DataError(
            f"{clash[0]!r} is a constant and a channel at once",
            code="RF109",
            path=path,
            key="[import.constants]",
            fix="rename one of them",
        )
    for name, formula in derived.items():
        known[name] = _evaluate(name, formula, known, constants, path)
    return known


def _evaluate(
    name: str, formula: str, channels: Mapping[str, FloatArray], constants: Mapping[str, float], path: str
) -> FloatArray:
    tree, used = _parse(name, formula, {*FUNCTIONS, *_CONSTANTS, *constants, *channels}, path)
    symbols = {**FUNCTIONS, **_CONSTANTS, **constants, **channels}
    try:
        with np.errstate(all="ignore"):  # what comes of it is judged below
            code = compile(tree, "<derived>", "eval")
            result = np.asarray(eval(code, {"__builtins__": {}}, symbols))  # noqa: S307  (arithmetic only, see _parse)
    except Exception as error:  # noqa: BLE001  (whatever a formula does wrong, the user hears of the formula)
        reason = str(error).strip().splitlines()
        raise _refuse(
            name, formula, f"fails: {reason[0] if reason else type(error).__name__}", path
        ) from None
    return _judge(name, formula, result, [channels[word] for word in channels if word in used], path)


def _judge(name: str, formula: str, result: Any, inputs: list[FloatArray], path: str) -> FloatArray:
    if result.dtype.kind not in "buif":
        raise _refuse(name, formula, f"gives {result.dtype} values, not real numbers", path)
    if not inputs:
        raise _refuse(name, formula, "uses no channel", path)
    if result.shape != inputs[0].shape:
        raise _refuse(
            name, formula, f"gives shape {result.shape}, but the channels have {inputs[0].shape}", path
        )
    result = result.astype(np.float64)
    unexplained = ~np.isfinite(result) & np.all([np.isfinite(channel) for channel in inputs], axis=0)
    unexplained |= np.isinf(result)
    if unexplained.any():
        index = int(np.argmax(unexplained))
        raise _refuse(name, formula, f"gives {result[index]} at sample {index + 1}", path)
    return np.ascontiguousarray(result)


def _parse(name: str, formula: str, known: set[str], path: str) -> tuple[ast.Expression, set[str]]:
    """Return the formula's tree and the names it uses, after checking that it is arithmetic only."""
    if len(formula) > _MAX_LENGTH:
        raise _refuse(name, formula, f"is longer than {_MAX_LENGTH} characters", path)
    try:
        tree = ast.parse(formula.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError, Warning):
        raise _refuse(name, formula, "is not a formula", path) from None
    used: set[str] = set()
    for node in ast.walk(tree):
        if not isinstance(node, _GRAMMAR) or isinstance(node, _NO_BITS):
            raise _refuse(name, formula, f"is more than arithmetic ({type(node).__name__})", path)
        if isinstance(node, ast.Constant):
            node.value = _float(node.value, name, formula, path)
        elif isinstance(node, ast.Call) and not (
            isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
        ):
            called = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
            hint = did_you_mean(called, FUNCTIONS)
            raise _refuse(name, formula, f"calls {called!r}, which is not offered", path, hint)
        elif isinstance(node, ast.Name):
            if node.id not in known:
                hint = did_you_mean(node.id, known - FUNCTIONS.keys())
                raise _refuse(name, formula, f"uses the unknown name {node.id!r}", path, hint)
            used.add(node.id)
    return tree, used


def _float(value: object, name: str, formula: str, path: str) -> float:
    """Return a literal as a float: 9**9**9 in integers would never end."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _refuse(name, formula, f"holds {value!r}, which is no number", path)
    try:
        return float(value)
    except OverflowError:
        raise _refuse(name, formula, "holds a number too large for a float", path) from None


def _refuse(name: str, formula: str, why: str, path: str, fix: str = "") -> DataError:
    shown = formula if len(formula) <= 80 else formula[:77] + "..."
    return DataError(
        f"{shown!r} {why}",
        code="RF109",
        path=path,
        key=f"[import.derived] {name}",
        fix=fix or 'write arithmetic with channels in SI, such as force = "pull - pressure * area"',
    )
