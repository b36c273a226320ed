"""The formulae behind a law, and where they have no answer."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions

Columns = tuple[FloatArray, ...]
"""The parameters one by one: each of shape () for one parameter set, or (m, 1) for m sets."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Refusal:
    """A reason why a law has no answer, and where."""

    mask: BoolArray
    values: FloatArray
    what: str
    fix: str


class Physics(Protocol):
    """The formulae behind a law, on parameter columns that broadcast against the n conditions."""

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return ln F_A − ln F_B, shape (n,) or (m, n)."""
        ...

    def rise_and_slopes(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """Return the rise and its derivative by each parameter, what both need made once.

        The rise is that of `rise` to the last bit, and each slope broadcasts to it.
        """
        ...

    def condition_slopes(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the derivative of ln F_A by R_w, φ and ln F_B; each broadcasts to the rise."""
        ...

    def local_mu(self, columns: Columns, wrap_rad: FloatArray, conditions: Conditions) -> FloatArray:
        """Return the local coefficient at an angle from the slack end."""
        ...

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Return where there is no answer."""
        ...


FROM_ZERO = "use the law that counts the wrap from zero (NAME-from-zero; in Python law.without_end_tension())"
"""What to do where no wrap angle stands for an end tension."""


def refuse(mask: npt.ArrayLike, values: npt.ArrayLike, what: str, fix: str) -> Refusal:
    """Return a refusal from anything array-like."""
    return Refusal(mask=np.asarray(mask), values=np.asarray(values, dtype=np.float64), what=what, fix=fix)


def below_reference(conditions: Conditions) -> Refusal:
    """Return the refusal of end tensions below F_0 = 1 N, for laws that count the end tension as wrap."""
    return refuse(
        conditions.end_tension_N < 1.0,
        conditions.end_tension_N,
        "F_B = {value} N is below F_0 = 1 N, so no wrap angle stands for it",
        f"leave it out, or {FROM_ZERO}",
    )


def refusals_of(physics: Physics, columns: Columns, conditions: Conditions) -> list[Refusal]:
    """Return the refusals that concern any condition."""
    # Absurd parameters overflow on the way to being refused.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return [refusal for refusal in physics.refusals(columns, conditions) if refusal.mask.any()]


def reason(refusal: Refusal, conditions: Conditions) -> str:
    """Return a refusal in words, with the first condition it concerns."""
    n = len(conditions)
    mask, values = np.broadcast_arrays(np.atleast_1d(refusal.mask), refusal.values)
    where = np.argwhere(mask)[0]
    text = refusal.what.format(value=f"{values[tuple(where)]:.6g}")
    condition = int(where[-1]) if mask.shape[-1] == n else 0
    parameter_set = f", parameter set {where[0]}" if mask.ndim > 1 and mask.shape[0] > 1 else ""
    return f"{text} at {conditions.describe(condition)}{parameter_set}"


def evaluated(
    formula: Callable[[], tuple[FloatArray, ...]], columns: Columns, conditions: Conditions, law: str
) -> FloatArray:
    """Return the parts of a formula side by side on a last axis, shape (n, k) or (m, n, k), all finite."""
    # Overflow is not warned about where it happens, because every number is looked at right after.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        parts = formula()
    shape = (*columns[0].shape[:-1], len(conditions))
    table = np.empty((*shape, len(parts)))
    for i, part in enumerate(parts):
        table[..., i] = part
    wrong = ~np.isfinite(table)
    if wrong.any():
        condition = int(np.argwhere(wrong)[0][-2])
        raise InputError(
            f"{law}: no finite value at {conditions.describe(condition)}: the coefficient is infinite where the "
            "wrap starts from nothing, or a parameter is so large or small that floats overflow",
            code="RF420",
            fix="ask at a wrap angle above zero, with parameters inside their bounds",
        )
    return table
