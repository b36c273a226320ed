"""Input quantities, and from a measurement equation to the statement of its uncertainty.

A budget by the law of propagation of uncertainty (JCGM 100): one line a source, their sum, and the expanded
uncertainty; its check by draws (JCGM 101); and what would make it smaller. Here, too, are the roots of a covariance.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.glossary import AdvisedStatus
from ropefric.shown import Shown, in_words

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
    """An input quantity, independent of all others; by default normal, type B, a correction of zero."""

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
    parameters: int = 0  # of the fit that it comes from
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


def limit_of_error(
    name: str, symbol: str, unit: str, half_width: float, *, estimate: float = 0.0, assumed: str = ""
) -> Quantity:
    """Return a quantity that lies anywhere within ± a limit of error: rectangular, divisor √3, type B."""
    flat: dict[str, Any] = {"divisor": RECTANGULAR, "distribution": "rectangular"}
    return Quantity(name, symbol, unit, half_width, estimate=estimate, assumed=assumed, **flat)


def repeats(name: str, symbol: str, unit: str, *, mean: float, std: float, n: int) -> Quantity:
    """Return the mean of n readings with their sample standard deviation s: s/√n, type A, n − 1 degrees of freedom."""
    known: dict[str, Any] = {"divisor": math.sqrt(n), "type": "A", "repeats": n}
    return Quantity(name, symbol, unit, std, estimate=mean, dof=n - 1.0, **known)


# ---- the statement ----

SCHEMA = "ropefric.uncertainty/1"

# Sources with a smaller part of u_c² change U by less than 4 % even if they vanish.
_WORTH_A_WORD = 0.08
# Less than half a per cent of U is no help to anybody.
_NOTICED = 0.005

_FEWEST, _MOST = 10_000, 10_000_000
# The end of a 95 % interval from N draws scatters by about 2.7 σ/√N; U is about 2 σ.
_END_NOISE = 2.7 / 1.96
DISAGREEMENT = 0.1
"""Part of U by which an end of y ± U may differ from that of the draws [-]."""
_UNANSWERED = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class MeasurementModel:
    """A measurement equation y = f(x) of independent quantities x, with its slopes at their estimates."""

    name: str
    symbol: str
    unit: str
    quantities: tuple[Quantity, ...]
    evaluate: Callable[[FloatArray], FloatArray]
    sensitivities: FloatArray

    def __post_init__(self) -> None:
        if not (np.isfinite(self.estimate) and np.isfinite(self.sensitivities).all()):
            raise InputError(f"{self.name}: there is no answer at the estimates of the inputs", key=self.name)

    @property
    def inputs(self) -> FloatArray:
        """Return the estimates of all inputs, shape (k,)."""
        return np.array([item.estimate for item in self.quantities])

    @property
    def estimate(self) -> float:
        """Return y at the estimates of the inputs."""
        return float(self.evaluate(self.inputs[np.newaxis, :])[0])

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return the answer to n draws of the inputs, shape (n,); NaN where there is none."""
        return self.evaluate(np.column_stack([item.draw(rng, n) for item in self.quantities]))


class BudgetLine(NamedTuple):
    """One source of uncertainty."""

    source: Quantity
    sensitivity: float
    contribution: float
    share: float

    @property
    def name(self) -> str:
        """Return what it is, in words."""
        return self.source.name

    @property
    def label(self) -> str:
        """Return its name, with the word where its uncertainty is assumed and nobody stated it."""
        return f"{self.name} (assumed)" if self.source.assumed else self.name

    def to_dict(self) -> dict[str, Any]:
        """Return the line as JSON-able values; infinite degrees of freedom are None."""
        item = self.source
        names = ("name", "symbol", "type", "unit", "estimate", "stated", "divisor", "distribution")
        return {name: getattr(item, name) for name in names} | {
            "assumed": item.assumed or None,
            "contribution": self.contribution,
            "share": self.share,
            "dof": item.dof if math.isfinite(item.dof) else None,
            "standard_uncertainty": item.std,
            "sensitivity": self.sensitivity,
        }


class LinearBudget(NamedTuple):
    """Lines of a budget with their sum."""

    estimate: float
    lines: tuple[BudgetLine, ...]
    combined: float
    effective_dof: float
    level: float
    coverage_factor: float

    @property
    def expanded(self) -> float:
        """Return the expanded uncertainty U = k u_c."""
        return self.coverage_factor * self.combined

    @property
    def relative(self) -> float:
        """Return u_c over the size of the estimate [-]."""
        return self.combined / abs(self.estimate)

    @property
    def interval(self) -> tuple[float, float]:
        """Return y − U and y + U."""
        return self.estimate - self.expanded, self.estimate + self.expanded


def effective_dof(contributions: Sequence[float], dof: Sequence[float]) -> float:
    """Return ν_eff = u_c⁴/Σ(uᵢ⁴/νᵢ), eq. (G.2b) of JCGM 100; infinite if all are.

    It holds for independent contributions.
    """
    total = math.fsum(u**4 / nu for u, nu in zip(contributions, dof, strict=True) if u > 0.0)
    return math.hypot(*contributions) ** 4 / total if total > 0.0 else math.inf


def linear_budget(model: MeasurementModel, *, level: float = 0.95) -> LinearBudget:
    """Return the budget of a measurement equation by the law of propagation of uncertainty, eq. (10) of JCGM 100."""
    check_level(level)
    slopes = model.sensitivities.tolist()
    sizes = [abs(slope) * item.std for item, slope in zip(model.quantities, slopes, strict=True)]
    combined = math.hypot(*sizes)
    if combined == 0.0:
        text = f"nothing that goes into {model.name} is uncertain"
        raise InputError(text, key=model.name, fix="give an uncertainty")
    lines = [
        BudgetLine(source, slope, size, (size / combined) ** 2)
        for source, slope, size in zip(model.quantities, slopes, sizes, strict=True)
    ]
    dof = effective_dof(sizes, [source.dof for source in model.quantities])
    return LinearBudget(
        estimate=model.estimate,
        lines=tuple(sorted(lines, key=lambda line: -line.contribution)),
        combined=combined,
        effective_dof=dof,
        level=level,
        coverage_factor=quantile(0.5 + 0.5 * level, dof),
    )


class DrawnAnswer(NamedTuple):
    """Statistics of the answer over random draws of the inputs."""

    draws: int
    seed: int
    unanswered: int
    symmetric_interval: tuple[float, float]
    gaps: tuple[float, float]
    agrees: bool


def propagate(
    model: MeasurementModel, budget: LinearBudget, *, draws: int = 200_000, seed: int = 0
) -> DrawnAnswer:
    """Return the answer to draws of the inputs, and whether the linear budget agrees with it."""
    if not _FEWEST <= draws <= _MOST or seed < 0:
        fix = f"draw {_FEWEST} or more, at most {_MOST}, with seed 0 or more"
        raise InputError(f"{draws} draws with seed {seed}", key="draws", fix=fix)
    values = model.draw(np.random.default_rng(seed), draws)
    values = values[np.isfinite(values)]
    unanswered = draws - values.size
    if 2 * unanswered > draws:
        text = f"{model.name} has no answer for {unanswered} of {draws} draws of its inputs"
        fix = "the inputs are too uncertain for any budget; measure them better"
        raise InputError(text, code="RF420", key="draws", fix=fix)
    tail = 0.5 * (1.0 - budget.level)
    low, high = (float(end) for end in np.quantile(values, [tail, 1.0 - tail]))
    gaps = abs(low - budget.interval[0]), abs(high - budget.interval[1])
    room = (DISAGREEMENT + 3.0 * _END_NOISE / math.sqrt(draws)) * budget.expanded
    return DrawnAnswer(
        draws=draws,
        seed=seed,
        unanswered=unanswered,
        symmetric_interval=(low, high),
        gaps=gaps,
        agrees=max(gaps) <= room and unanswered <= _UNANSWERED * draws,
    )


class BudgetStatus(AdvisedStatus):
    """Status of a budget, from good to bad."""

    OK = "ok: The draws agree with the budget."
    DRAWS_DISAGREE = (
        "draws-disagree: The draws disagree with the budget: the answer is not linear within the uncertainty of "
        "the inputs, or an input with a rectangular distribution or few degrees of freedom dominates. Use the interval "
        "of the draws, not y ± U."
    )
    FIT_NOT_TRUSTED = "fit-not-trusted: The fit cannot be trusted, nor can its contribution to the budget."


class Improvement(NamedTuple):
    """Effect of one change on the expanded uncertainty."""

    source: str
    action: str
    expanded: float
    saving: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement(Shown):
    """The uncertainty of one answer.

    Attributes
    ----------
    model : MeasurementModel
        The measurement equation.
    budget : LinearBudget
        Its budget.
    drawn : DrawnAnswer
        The check by draws.
    improvements : tuple of Improvement
        Possible improvements, the largest first.
    status : BudgetStatus
        Whether to trust it.
    notes : tuple of str
        Parts missing in the budget, and why.
    """

    _said = ("status", "budget.coverage_factor", "budget.level", "drawn.agrees", "notes")
    _framed = "budget.lines"

    def _more_said(self) -> Iterator[tuple[str, str]]:
        yield self.model.symbol, in_words(self.budget.estimate, self.model.unit, self.budget.combined)
        yield "expanded", in_words(self.budget.expanded, self.model.unit)

    model: MeasurementModel
    budget: LinearBudget
    drawn: DrawnAnswer
    improvements: tuple[Improvement, ...]
    status: BudgetStatus
    notes: tuple[str, ...] = ()

    @property
    def trustworthy(self) -> bool:
        """Return whether y ± U may be used."""
        return self.status is BudgetStatus.OK

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.uncertainty/1`; infinite degrees of freedom are None."""
        found, model = self.budget, self.model
        names = ("estimate", "combined", "coverage_factor", "level", "expanded", "interval")
        return {name: getattr(found, name) for name in names} | {
            "schema": SCHEMA,
            "quantity": model.name,
            "symbol": model.symbol,
            "unit": model.unit,
            "lines": [line.to_dict() for line in found.lines],
            "effective_dof": found.effective_dof if math.isfinite(found.effective_dof) else None,
            "monte_carlo": self.drawn._asdict(),
            "improvements": [item._asdict() for item in self.improvements],
            "status": self.status.value,
            "trustworthy": self.trustworthy,
            "advice": self.status.advice,
            "notes": list(self.notes),
        }


def state_uncertainty(
    model: MeasurementModel,
    *,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
    status: BudgetStatus = BudgetStatus.OK,
    notes: tuple[str, ...] = (),
) -> Statement:
    """Return the budget of a measurement equation, checked by draws."""
    budget = linear_budget(model, level=level)
    drawn = propagate(model, budget, draws=draws, seed=seed)
    if status is BudgetStatus.OK and not drawn.agrees:
        status = BudgetStatus.DRAWS_DISAGREE
    exact = [item.name for item in model.quantities if not item.std]
    notes += (f"taken as exact: {', '.join(exact)}",) if exact else ()
    assumed = [item for item in model.quantities if item.assumed and item.std]
    notes += tuple(f"{item.name} is assumed, nobody stated it: state {item.assumed}" for item in assumed)
    better = improvements(budget)
    return Statement(model=model, budget=budget, drawn=drawn, improvements=better, status=status, notes=notes)


def improvements(budget: LinearBudget) -> tuple[Improvement, ...]:
    """Return what halving each large source would do to U, and what twice the repeats or conditions would.

    u_c, ν_eff and k are made anew for each. Twice the repeats shrink s/√n by √2 and more than double its degrees of
    freedom; twice the conditions behind a fit are taken to shrink its part by √2 too, which they do if they lie like
    those there are.
    """
    found = []
    for place, line in enumerate(budget.lines):
        if line.share < _WORTH_A_WORD:
            continue
        contributions = [one.contribution for one in budget.lines]
        dof = [one.source.dof for one in budget.lines]
        factor = math.sqrt(0.5)
        if q := line.source.parameters:
            # k − q degrees of freedom become 2k − q.
            action = f"twice the conditions behind the {line.name}"
            dof[place] += dof[place] + q
        elif n := line.source.repeats:
            action = f"{2 * n} instead of {n} repeats"
            dof[place] += n
        else:
            action, factor = f"halve the uncertainty of {line.name}", 0.5
        contributions[place] *= factor
        coverage = quantile(0.5 + 0.5 * budget.level, effective_dof(contributions, dof))
        expanded = coverage * math.hypot(*contributions)
        saving = 1.0 - expanded / budget.expanded
        if saving >= _NOTICED:
            found.append(Improvement(source=line.name, action=action, expanded=expanded, saving=saving))
    return tuple(sorted(found, key=lambda item: -item.saving))
