"""Whether data can tell the parameters of a law apart: the singular values of the scaled Jacobian."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.digits import significant

# Rounding of the Jacobian alone gives ratios up to this.
RANK_RATIO = 1e8
# A parameter whose slopes are below this has a variance that no float holds: it changes nothing.
NOT_SEEN = 1e-150
# Part of a parameter in the weak direction from which it is named.
_TAKES_PART = 0.15
_DECIMALS = 6
# What is left of a singular value that is zero.
_RESIDUE = 1e-14


@dataclass(frozen=True, slots=True, kw_only=True)
class Identifiability:
    """How well data tell parameters apart."""

    ratio: float
    singular_values: tuple[float, ...]
    worst_pair: tuple[str, ...]
    correlation: float
    weak: tuple[str, ...]
    weak_direction: str
    unseen: tuple[str, ...]

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> "Identifiability":
        """Return the same from a JSON tree, where None stands for an infinite ratio."""
        lists = {key: tuple(tree[key]) for key in ("singular_values", "worst_pair", "weak", "unseen")}
        ratio = inf if tree["ratio"] is None else float(tree["ratio"])
        correlation = float(tree["correlation"])
        return cls(ratio=ratio, correlation=correlation, weak_direction=tree["weak_direction"], **lists)


def identify(jacobian: FloatArray, names: Sequence[str]) -> Identifiability:
    """Return how well a Jacobian tells its parameters apart.

    Columns are scaled to unit length first, so that the ratio does not depend on the parameters' units
    (Belsley's condition number without centring).
    """
    q = len(names)
    length = np.linalg.norm(jacobian, axis=0)
    dead = length <= NOT_SEEN
    scaled = np.where(dead, 0.0, jacobian) / np.where(dead, 1.0, length)
    # Fewer points than parameters leave some combinations unseen: zero rows make them show up as zeros.
    padded = np.vstack([scaled, np.zeros((max(q - len(scaled), 0), q))])
    _, values, rows = np.linalg.svd(padded, full_matrices=False)
    lost = values <= values.max(initial=0.0) / RANK_RATIO
    ratio = inf if q == 0 or lost.any() else float(values[0] / values[-1])
    weakest = rows[-1] if q else np.zeros(0)
    unseen = np.abs(rows[lost]).max(axis=0, initial=0.0) > _TAKES_PART if q else np.zeros(0, dtype=bool)
    # Two parameters take part in equal shares: the last bits may not say which comes first.
    order = np.argsort(-np.abs(weakest).round(_DECIMALS), kind="stable")
    weak = tuple(names[i] for i in order if abs(weakest[i]) > _TAKES_PART)
    pair, correlation = _worst_pair(values, rows, lost, names)
    return Identifiability(
        ratio=significant(ratio, _DECIMALS) if q else 1.0,
        singular_values=tuple(significant(value, _DECIMALS, smallest=_RESIDUE) for value in values.tolist()),
        worst_pair=pair,
        correlation=correlation,
        weak=weak,
        weak_direction=_in_words(weakest, weak, names),
        unseen=tuple(name for name, gone in zip(names, unseen, strict=True) if gone),
    )


def _worst_pair(
    values: FloatArray, rows: FloatArray, lost: BoolArray, names: Sequence[str]
) -> tuple[tuple[str, ...], float]:
    if len(names) < 2:
        return (), 0.0
    inverse = np.where(lost, 1.0 / RANK_RATIO, values) ** -2.0
    covariance = (rows.T * inverse) @ rows
    size = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(size, size)
    correlation = correlation.round(_DECIMALS)
    apart = np.abs(np.triu(correlation, k=1))
    i, j = divmod(int(np.argmax(apart)), len(names))
    return (names[i], names[j]), float(np.clip(correlation[i, j], -1.0, 1.0))


def _in_words(weakest: FloatArray, weak: tuple[str, ...], names: Sequence[str]) -> str:
    if len(weak) < 2:
        return f"{weak[0]} alone" if weak else ""
    lead = np.sign(weakest[list(names).index(weak[0])])
    ways = {name: "up" if weakest[list(names).index(name)] * lead > 0 else "down" for name in weak}
    rising = [name for name in weak if ways[name] == "up"]
    falling = [name for name in weak if ways[name] == "down"]
    text = f"{' and '.join(rising)} up"
    return f"{text} while {' and '.join(falling)} down" if falling else f"{text} together"
