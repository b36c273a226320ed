"""What a closure is: the statement that settles how belts share a pull which no balance divides."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.systems.press.machine import Press

__all__ = ["Closure", "Statement"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """One linear equation between tensions: Σ coefficient · T = value.

    Attributes
    ----------
    coefficients : dict of str to float
        Factor of each span's tension, by span name.
    value_N : float
        The right-hand side [N].

    Examples
    --------
    >>> Statement(coefficients={"9": 1.0, "10": -1.0}, value_N=0.0).value_N
    0.0
    """

    coefficients: dict[str, float]
    value_N: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """A named assumption about the split.

    Attributes
    ----------
    name : str
        Its name.
    rule : str
        What it says, in words and symbols.
    basis : str
        When that is true.
    statements : callable
        `statements(press)` returns the equations; it raises `InputError` where the press lacks data for them.

    Examples
    --------
    >>> Closure(name="none", rule="", basis="", statements=lambda press: ()).name
    'none'
    """

    name: str
    rule: str
    basis: str
    statements: Callable[[Press], tuple[Statement, ...]]

    def equations(self, press: Press) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the statements as a matrix, shape (k, n_spans), and its right-hand side, shape (k,) [N]."""
        statements = self.statements(press)
        matrix = [[said.coefficients.get(span.name, 0.0) for span in press.spans] for said in statements]
        values = [said.value_N for said in statements]
        return np.array(matrix).reshape(len(values), len(press.spans)), np.array(values, dtype=np.float64)
