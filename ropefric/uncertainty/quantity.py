"""What goes into a budget: single quantities, quantities known together with their covariance, and their draws."""

import math
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal

import numpy as np
from scipy.special import ndtri, stdtrit

from ropefric.arrays import FloatArray
from ropefric.errors import InputError

Evaluation = Literal["A", "B"]
Distribution = Literal["normal", "rectangular"]

RECTANGULAR = math.sqrt(3.0)
"""Half the width of a flat distribution over its standard deviation."""


def quantile(probability: float, dof: float) -> float:
    """Return Student's t quantile; the normal one for infinitely many degrees of freedom."""
    return float(ndtri(probability)) if math.isinf(dof) else float(stdtrit(dof, probability))


def check_level(level: float) -> None:
    """Refuse a level that is none."""
    if not 0.0 < level < 1.0:
        fix = "give a level between 0 and 1, such as 0.95"
        raise InputError(f"the level is {level:g}", key="level", fix=fix)


def _turned(covariance: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return sizes (q,), and eigenvectors (q, q) with roots of eigenvalues (q,) of the correlation matrix.

    Of the correlation matrix, so that they do not depend on units; a covariance may be singular.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return scale, vectors, np.sqrt(np.maximum(values, 0.0))


def directions(covariance: FloatArray) -> FloatArray:
    """Return the independent directions of a covariance, each one standard uncertainty long, shape (q, q).

    Column i is a change of all quantities together, Σ eᵢ eᵢᵀ = covariance; largest first.
    """
    scale, vectors, roots = _turned(covariance)
    # A direction and its opposite are the same; the sign that eigh returns depends on the library.
    strongest = np.abs(vectors).argmax(axis=0)
    signs = np.where(np.take_along_axis(vectors, strongest[None, :], axis=0)[0] < 0.0, -1.0, 1.0)
    return np.asarray((vectors * roots * scale[:, None] * signs)[:, ::-1])


def symmetric_root(covariance: FloatArray) -> FloatArray:
    """Return a root of a covariance that no library's choice of signs and order of eigenvectors changes."""
    scale, vectors, roots = _turned(covariance)
    return np.asarray(scale[:, None] * ((vectors * roots) @ vectors.T))


def joint_draws(
    estimates: FloatArray, root: FloatArray, *, dof: float, n: int, rng: np.random.Generator
) -> FloatArray:
    """Return n draws from the multivariate normal, or t for finite degrees of freedom, shape (n, q)."""
    changes = rng.standard_normal((n, estimates.size)) @ root.T
    if math.isfinite(dof):
        changes *= np.sqrt(dof / rng.chisquare(dof, n))[:, np.newaxis]
    return np.asarray(estimates + changes)


@dataclass(frozen=True, slots=True)
class Quantity:
    """An input quantity, independent of all others; unless told otherwise normal, type B, a correction of zero."""

    name: str
    symbol: str
    unit: str
    stated: float
    _: KW_ONLY
    estimate: float = 0.0
    divisor: float = 1.0
    distribution: Distribution = "normal"
    type: Evaluation = "B"
    dof: float = math.inf
    repeats: int = 0
    assumed: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.estimate) and math.isfinite(self.stated) and self.stated >= 0.0):
            text = f"{self.name}: {self.estimate:g} with {self.stated:g}/{self.divisor:g} is no standard uncertainty"
            raise InputError(text, key=self.name, fix="give a finite number from 0")

    @property
    def std(self) -> float:
        """Return the standard uncertainty, in the unit of the estimate."""
        return self.stated / self.divisor

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return n draws from its distribution, shape (n,)."""
        if self.std == 0.0:
            return np.full(n, self.estimate)
        if self.distribution == "rectangular":
            half = RECTANGULAR * self.std
            return np.asarray(rng.uniform(self.estimate - half, self.estimate + half, n))
        shape = rng.standard_normal(n) if math.isinf(self.dof) else rng.standard_t(self.dof, n)
        return np.asarray(self.estimate + self.std * shape)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """Quantities known together, with their covariance: the parameters of a fitted law."""

    name: str
    symbols: tuple[str, ...]
    estimates: FloatArray
    covariance: FloatArray
    dof: float = math.inf
    type: Evaluation = "A"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.estimates).all() and np.isfinite(self.covariance).all()):
            text = f"{self.name}: the covariance is not finite, so the data do not show all of {self.symbols}"
            fix = "measure the conditions that would show it, or fit a simpler law"
            raise InputError(text, key=self.name, fix=fix)

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return n draws, shape (n, q); see `joint_draws`."""
        return joint_draws(self.estimates, directions(self.covariance), dof=self.dof, n=n, rng=rng)


def limit_of_error(
    name: str, symbol: str, unit: str, half_width: float, *, estimate: float = 0.0, assumed: str = ""
) -> Quantity:
    """Return a quantity that lies anywhere within ± a limit of error: rectangular, divisor √3, type B."""
    flat: dict[str, Any] = {"divisor": RECTANGULAR, "distribution": "rectangular"}
    return Quantity(name, symbol, unit, half_width, estimate=estimate, assumed=assumed, **flat)


def repeats(
    name: str, symbol: str, unit: str, *, mean: float, std: float, n: int, dof: float | None = None
) -> Quantity:
    """Return the mean of n readings with their sample standard deviation s: s/√n, type A, n − 1 degrees of freedom.

    With `dof`, s is a pooled one with that many degrees of freedom (GUM 4.2.4).
    """
    known: dict[str, Any] = {"divisor": math.sqrt(n), "type": "A", "repeats": n}
    return Quantity(name, symbol, unit, std, estimate=mean, dof=n - 1.0 if dof is None else dof, **known)
