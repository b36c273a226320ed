"""One model of scatter: ln F_A = law(θ) + what ropes, mountings, operators bring + condition + repeat + stated errors.

A rope, a mounting, an operator may have a μ of its own: it changes ln F_A in proportion to the rise ln(F_A/F_B). What a
condition brings (a setting) is shared by its repeats. Stated errors are known components, shared
by exactly what the user says shares them. The variances of the others are found by restricted maximum likelihood (REML)
on the linearised law (Patterson & Thompson 1971, Biometrika 58:545), without a floor at zero: a mean square between
conditions that happens to lie below the repeats' stays what it is, which makes Student's t exact in balanced designs.
Standard errors are Kenward and Roger's (1997, Biometrics 53:983), degrees of freedom Satterthwaite's. Of a group with
few levels the estimated variance is often zero by chance. Its intervals hold for all variances that the restricted
likelihood leaves possible, see `Mixture`, so that three ropes count as three. A rope of its own for each condition is
told from what else a condition brings by the growth with the rise.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtrc, gammaln, ndtri, psi, stdtrit, zeta

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.files.plain_text import GIVEN_DIGITS, significant
from ropefric.fitting import statistics as stats
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.reml import CONDITION, REPEAT, Known, Mixture, Reml, times
from ropefric.friction.condition import SETTINGS, Conditions

ALL = "all"
"""The one component of the parameters' covariance in a fit stored before there was a model of scatter."""

# Uneven scatter: standard errors of its exponent (p = 0.001), cells with repeats, and range of ln F_A to see it in.
_BEYOND_CHANCE, _LEAST_CELLS, _SAME_FORCE = 3.29, 4, 0.1
# A pull off its repeats: degrees of freedom of the others, what is rounding, and its p-value.
_LEAST_DOF, _SAME, _FAR_P = 5, 1e-6, 1e-3
# Student's t that repeats may follow, the heaviest with a variance that a sample can show, and the p-value of the test.
_TAIL_DOFS, _TAIL_P = np.arange(3.0, 31.0), 0.05
# Smallest eigenvalue of the correlations between components: below, two of them cannot be separated.
_SEPARABLE = 1e-3
_MOST_CELLS = 3000
_TINY = 1e-300


class Uneven(NamedTuple):
    """How the variance of ln F_A grows with the force: by e^{exponent (ln F_A − centre)}, over the forces tested."""

    exponent: float = 0.0
    centre: float = 0.0
    low: float = 0.0
    high: float = 0.0

    def factor(self, log_lift: FloatArray) -> FloatArray:
        """Return the variance at forces over that at the centre."""
        return np.exp(self.exponent * (np.clip(log_lift, self.low, self.high) - self.centre))


EVEN = Uneven()


class Layout(NamedTuple):
    """Trials in cells that agree in condition and in all groups, and the levels of these cells.

    Attributes
    ----------
    problem : FitProblem
        A law and the mean ln F_A of the k cells.
    cell : ndarray, shape (n,)
        Of each trial.
    size, condition : ndarray, shape (k,)
        Trials of a cell, and its condition.
    squares, spare : float, int
        Of repeats about the mean of their cell, the sum and its degrees of freedom.
    groups : mapping of str to ndarray, shape (k,)
        The level of each cell in each group whose scatter the trials can show.
    notes : tuple of str
        Which groups they cannot show, and why.
    labels : mapping of str to tuple of str
        What the levels of each group are called.
    tail_dof : float
        Degrees of freedom of the Student's t that repeats follow; infinite where they are normal.
    """

    problem: FitProblem
    cell: IntArray
    size: FloatArray
    condition: IntArray
    squares: float
    spare: int
    groups: Mapping[str, IntArray]
    notes: tuple[str, ...] = ()
    uneven: "Uneven" = EVEN
    labels: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    tail_dof: float = np.inf

    @property
    def nested(self) -> bool:
        """Return whether conditions have several cells."""
        return int(self.condition.max()) + 1 < self.condition.size

    @property
    def repeated(self) -> bool:
        """Return whether any condition has several trials, with one rope or with several."""
        return self.spare > 0 or self.nested

    @property
    def level_counts(self) -> dict[str, int]:
        """Return the number of conditions, of trials, and of levels of each group."""
        counts = {CONDITION: int(self.condition.max()) + 1, REPEAT: int(self.size.sum())}
        return counts | {name: int(np.unique(level).size) for name, level in self.groups.items()}

    @property
    def within(self) -> float:
        """Return the scatter of repeats; NaN without any, 0 where they agree to rounding."""
        if not self.spare:
            return float("nan")
        found = (self.squares / self.spare) ** 0.5
        return float(found) if found > stats.SMALLEST_SCATTER else 0.0


def laid_out(problem: FitProblem, groups: Mapping[str, Sequence[str]]) -> Layout:
    """Return the layout of trials; those of one cell agree in condition and in the levels of groups."""
    condition, notes, shown, columns = problem.group, [], dict[str, IntArray](), [problem.group]
    labels = dict[str, tuple[str, ...]]()
    for name, words in groups.items():
        names, level = np.unique(np.array(words), return_inverse=True)
        if why := _hidden(level, problem, shown):
            notes.append(f"{name} {why}")
        elif level.max(initial=0):
            shown[name], labels[name] = level, tuple(names.tolist())
            columns.append(level)
    first, cell = np.unique(np.stack(columns), axis=1, return_index=True, return_inverse=True)[1:]
    # In the order of the trials, so that conditions stay in theirs.
    order = np.argsort(np.argsort(first))
    cell, first = order[cell.ravel()], np.sort(first)
    by_cell = replace(problem, group=cell, std=np.ones(problem.n_points))
    means = stats.condition_means(by_cell)
    rise = problem.log_lift - problem.conditions.log_end_tension
    about = rise - (np.bincount(cell, rise) / means.size)[cell]
    k = len(means)
    on_means = replace(
        by_cell, conditions=means.conditions, log_lift=means.log_lift, std=np.ones(k), group=np.arange(k)
    )
    own = {name: level[first] for name, level in shown.items()}
    if own and k > _MOST_CELLS:
        text = f"{k} cells of conditions and {', '.join(own)} are more than one matrix of covariances holds"
        raise InputError(text, key="groups", fix=f"name fewer groups, for {_MOST_CELLS} cells at most")
    size, of_cell = means.size.astype(np.float64), np.asarray(np.bincount(cell, about**2), np.float64)
    uneven = _unevenness(means.log_lift, size, of_cell)
    factor, spare = uneven.factor(means.log_lift), cell.size - k
    squares = float((of_cell / factor).sum())
    if uneven.exponent:
        ends = squares / max(spare, 1) * uneven.factor(np.array([uneven.low, uneven.high]))
        low, high = (f"{100.0 * value**0.5:.2g} %" for value in ends.tolist())
        text = f"repeats scatter by about {low} at the lowest force and {high} at the highest"
        notes.append(f"{text}, and are weighed so")
    even, left, tail_dof = about / np.sqrt(factor)[cell], 1.0 - 1.0 / size[cell], np.inf
    if spare > _LEAST_DOF and np.abs(even).max() > _SAME:
        tail_dof, tails = _tails(even, left, spare)
        notes += [*tails, *_far_pull(even, left, spare - 1, problem.conditions)]
    return Layout(
        on_means, cell, size, condition[first], squares, spare, own, tuple(notes), uneven, labels, tail_dof
    )


def _unevenness(log_lift: FloatArray, size: FloatArray, squares: FloatArray) -> Uneven:
    """Return how the variance of repeats goes with the force, where that is beyond chance.

    ln s² of ν degrees of freedom scatters by ψ'(ν/2) about ln σ² + ψ(ν/2) − ln(ν/2) (Bartlett & Kendall 1946), so that
    a straight line through them, weighed, has a known error.
    """
    seen = (size > 1.0) & (squares > stats.SMALLEST_SCATTER**2)
    half, x = 0.5 * (size[seen] - 1.0), log_lift[seen]
    if half.size < _LEAST_CELLS or np.ptp(x) < _SAME_FORCE:
        return EVEN
    y, weight = np.log(squares[seen] / (2.0 * half)) - psi(half) + np.log(half), 1.0 / zeta(2, half)
    centre = float(weight @ x / weight.sum())
    spread = float(weight @ (x - centre) ** 2)
    exponent = float(weight @ ((x - centre) * y)) / spread
    if abs(exponent) * spread**0.5 < _BEYOND_CHANCE:
        return EVEN
    ends = significant(float(log_lift.min()), 6), significant(float(log_lift.max()), 6)
    return Uneven(significant(exponent, 6), significant(centre, 6), *ends)


def _tails(about: FloatArray, own: FloatArray, spare: int) -> tuple[float, list[str]]:
    """Return the degrees of freedom of the t that repeats follow where they are not normal, and that in words.

    Deviations from the means of cells, of which the part `own` (n,) of the variance is left, are put to their own
    variance. Student's t of the same variance is tested against the normal by its likelihood; normal scatter lies at
    the end of its range, so that half of χ² with one degree of freedom counts (Self & Liang 1987, JASA 82:605).
    """
    z2 = about**2 * spare / (about @ about) / np.where(own > 0.0, own, 1.0)
    nu = _TAIL_DOFS
    constant = gammaln(0.5 * nu + 0.5) - gammaln(0.5 * nu) - 0.5 * np.log(0.5 * nu - 1.0)
    gain = constant - 0.5 * (nu + 1.0) * np.log1p(z2[:, None] / (nu - 2.0)) + 0.5 * z2[:, None]
    gains = own @ gain
    best = int(np.argmax(gains))
    p_value = 0.5 * float(chdtrc(1, 2.0 * max(gains[best], 0.0)))
    if p_value >= _TAIL_P:
        return np.inf, []
    text = f"repeats have heavier tails than normal scatter (p = {p_value:.1g}): one pull is taken to follow Student's t"
    return float(nu[best]), [f"{text} with {nu[best]:.0f} degrees of freedom"]


def _far_pull(about: FloatArray, own: FloatArray, dof: int, at: Conditions) -> list[str]:
    """Return that a pull lies further off its repeats than normal scatter allows, in words."""
    worst, off, p_value = stats.furthest(about, own, dof)
    if p_value >= _FAR_P:
        return []
    radius_mm, wrap_deg = 1e3 * at.wheel_radius_m[worst], np.degrees(at.wrap_angle_rad[worst])
    where = f"R_w = {radius_mm:.4g} mm, wrap {wrap_deg:.4g} deg, F_B = {at.end_tension_N[worst]:.4g} N"
    text = f"a pull at {where} lies {off:.1f} standard deviations off its repeats (p = {p_value:.1g})"
    return [f"{text}. Look at its recording; the intervals count it as scatter"]


def _hidden(level: IntArray, problem: FitProblem, shown: Mapping[str, IntArray]) -> str:
    """Return the reason why the scatter of a group cannot be separated; empty if it can."""

    def finer(one: IntArray, other: IntArray) -> bool:
        """Return whether each level of the one has one level of the other only."""
        pairs = np.unique(np.stack([one, other]), axis=1).shape[1]
        return bool(pairs == np.unique(one).size)

    def same(one: IntArray, other: IntArray) -> bool:
        return finer(one, other) and finer(other, one)

    if not level.max(initial=0):
        return ""
    single = same(level, problem.group)
    if finer(level, np.arange(level.size)) and not single:
        return "is another one in every pull: its scatter is part of that of repeats"
    if single and problem.n_conditions > _MOST_CELLS:
        return "is another one in every condition: its scatter is part of that between conditions"
    for name in SETTINGS if not single else ():
        setting = np.unique(getattr(problem.conditions, name).round(12), return_inverse=True)[1]
        if setting.max(initial=0) and same(level, setting):
            return f"changes only with the {name.rsplit('_', 1)[0].replace('_', ' ')}: its effect is part of the law"
    for name, other in shown.items():
        if same(level, other):
            return f"changes only with {name}, and is counted once"
    return ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScatterModel:
    """Components of the scatter about a law, and what they leave open of its p parameters.

    Attributes
    ----------
    names : tuple of str
        Of the m components: groups, "condition", "repeat".
    levels : tuple of int
        How many ropes, conditions, trials each has.
    variance : ndarray, shape (m,)
        Of ln F_A by condition and repeat, of the relative change of μ by a group [-]; below zero where a mean square
        happens to lie below the one it holds.
    covariance : ndarray, shape (m, m)
        Of these variances, the inverse of their information.
    slopes : ndarray, shape (m, p, p)
        Derivatives of the parameters' covariance by each variance.
    uneven : Uneven
        How the variances by condition and repeat, those at its centre, grow with the force.
    labels : mapping of str to tuple of str
        What the levels of each group are called.
    tail_dof : float
        Degrees of freedom of the Student's t that repeats follow; infinite where they are normal.
    mixtures : tuple of Mixture
        One for each group, in their order; none in a fit that was stored without them.
    """

    names: tuple[str, ...] = ()
    levels: tuple[int, ...] = ()
    variance: FloatArray
    covariance: FloatArray
    slopes: FloatArray
    uneven: Uneven = EVEN
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    tail_dof: float = np.inf
    mixtures: tuple[Mixture, ...] = ()

    def std(self, name: str) -> float:
        """Return the standard deviation by a component, 0 where its variance is below zero; NaN if there is none."""
        if name not in self.names:
            return float("nan")
        return float(max(self.variance[self.names.index(name)], 0.0) ** 0.5)

    @property
    def groups(self) -> tuple[str, ...]:
        """Return the names of the groups."""
        return tuple(name for name in self.names if name not in {ALL, CONDITION, REPEAT})

    @property
    def of_pulls(self) -> bool:
        """Return whether it is known how single pulls scatter, or conditions."""
        return bool({CONDITION, REPEAT} & {*self.names})

    def own_mu_variance(self, n_cells: int) -> float:
        """Return the variance of μ, relative to itself, by groups that have a level for each of the cells."""
        each = zip(self.names, self.levels, self.variance.tolist(), strict=True)
        return math.fsum(max(s2, 0.0) for name, n, s2 in each if n == n_cells and name in self.groups)

    def one_pull(self, log_lift: FloatArray, rise: FloatArray) -> FloatArray:
        """Return how much of each variance one pull with all groups new adds to that of ln F_A, shape (r, m)."""
        single = self.uneven.factor(log_lift)
        own = [rise**2 if name in self.groups else single * (name != ALL) for name in self.names]
        return np.array(own).reshape(len(own), rise.size).T

    def dof(self, rows: FloatArray, own: FloatArray | None = None, known: Known = 0.0) -> FloatArray:
        """Return the degrees of freedom of variances, shape (r,), one at least: Satterthwaite's 2 v²/Var(v).

        v = j C jᵀ for combinations j of parameters in `rows` (r, p), plus Σ σ_i² of the components in `own` (r, m),
        what one pull brings beside the law, plus `known` (r,), which is sure.
        """
        return self.integrated(rows, own, known)[1]

    def reach(
        self,
        probability: float,
        variance: FloatArray,
        rows: FloatArray,
        own: FloatArray | None = None,
        known: Known = 0.0,
    ) -> FloatArray:
        """Return how many standard deviations an interval reaches with a probability to one side, shape (r,).

        Student's t of `dof`, where `variance` (r,) is the square of the standard deviation; in groups, times the
        root of what their mixtures make of the variance.
        """
        if not self.names:
            return np.full(len(rows), np.nan)
        integrated, dof = self.integrated(rows, own, known)
        student = stdtrit(np.where(np.isinf(dof), 1.0, dof), probability)
        reach = np.where(np.isinf(dof), float(ndtri(probability)), student)
        if self.mixtures:
            reach = reach * np.sqrt(
                np.divide(integrated, variance, out=np.ones_like(dof), where=variance > 0.0)
            )
        return reach

    def integrated(
        self, rows: FloatArray, own: FloatArray | None = None, known: Known = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Return variances as in `dof`, of groups over their mixtures, and the degrees of freedom.

        The precision 1/v of mean E is taken to follow E χ²_ν/ν with ν = 2 E²/Var(1/v), so that Student's t with ν
        degrees of freedom belongs to a variance 1/E; exact where one mean square is all there is to know.
        """
        slopes = np.einsum("rp,mpq,rq->rm", rows, self.slopes, rows, optimize=True)
        if own is not None:
            # A component below zero is one that the data do not show: a new rope brings nothing by it.
            slopes = slopes + (own if self.mixtures else own * (self.variance > 0.0))
        # Of a parameter that is hardly known the square overflows; a power of two loses no digit.
        scale = np.ldexp(1.0, np.frexp(np.abs(slopes).max(axis=1, initial=0.0))[1])
        slopes, known = slopes / scale[:, None], known / scale
        variance, covariance = slopes @ self.variance + known, self.covariance
        unsure = np.zeros(len(rows))
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.mixtures:
                plain = slopes @ np.maximum(self.variance, 0.0) + known
                variance, covariance = plain, self._beside_groups()
                for mixture in self.mixtures:
                    mean, spread = mixture.precision(slopes, known)
                    variance = variance + 1.0 / mean - plain
                    unsure = unsure + spread / mean**2
            unsure = unsure + np.einsum("rm,mn,rn->r", slopes, covariance, slopes)
            dof = np.where(unsure > 0.0, 2.0 * variance**2 / unsure, np.inf)
        return variance * scale, np.maximum(dof, 1.0)

    def _beside_groups(self) -> FloatArray:
        """Return the covariance of the variances by condition and repeat if groups and the size of all are known."""
        own = np.array([name not in self.groups for name in self.names])
        size, block = np.maximum(self.variance[own], 0.0), np.ix_(own, own)
        information = np.linalg.pinv(self.covariance, hermitian=True)[block]
        found = np.zeros_like(self.covariance)
        found[block] = np.linalg.pinv(information, hermitian=True)
        found[block] -= np.outer(size, size) / (size @ information @ size)
        return found

    def rounded(self) -> "ScatterModel":
        """Return the model to the digits that mean something."""
        digits = np.vectorize(lambda value: significant(float(value), GIVEN_DIGITS), otypes=[np.float64])
        slopes = np.array([*map(stats.rounded_covariance, self.slopes)]).reshape(self.slopes.shape)
        mixtures = tuple(Mixture(digits(w), digits(v), dof) for w, v, dof in self.mixtures)
        variance, covariance = digits(self.variance), digits(self.covariance)
        return replace(self, variance=variance, covariance=covariance, slopes=slopes, mixtures=mixtures)

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        names = ("names", "levels", "variance", "covariance", "slopes")
        tree = {name: getattr(self, name) for name in names} | {"uneven": self.uneven._asdict()}
        tree |= {"labels": dict(self.labels)} if self.labels else {}
        tree |= {"mixtures": [one._asdict() for one in self.mixtures]} if self.mixtures else {}
        return tree | ({"tail_dof": self.tail_dof} if np.isfinite(self.tail_dof) else {})

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any], p: int) -> "ScatterModel":
        """Return the model of such a tree."""
        m = len(tree["names"])
        shapes = {"variance": (m,), "covariance": (m, m), "slopes": (m, p, p)}
        arrays = {name: np.array(tree[name], np.float64).reshape(shape) for name, shape in shapes.items()}
        words, levels = tuple(map(str, tree["names"])), tuple(map(int, tree["levels"]))
        labels = {name: tuple(map(str, of)) for name, of in tree.get("labels", {}).items()}
        uneven, tail_dof = Uneven(**tree["uneven"]), float(tree.get("tail_dof", np.inf))
        mixtures = tuple(
            Mixture(
                np.array(one["weight"], np.float64), np.array(one["variance"], np.float64), float(one["dof"])
            )
            for one in tree.get("mixtures", ())
        )
        return cls(
            names=words, levels=levels, uneven=uneven, labels=labels, tail_dof=tail_dof, mixtures=mixtures, **arrays
        )  # fmt: skip


def nothing_known(p: int) -> ScatterModel:
    """Return the model of data that leave nothing to estimate a scatter from."""
    return ScatterModel(variance=np.zeros(0), covariance=np.zeros((0, 0)), slopes=np.zeros((0, p, p)))


class Estimate(NamedTuple):
    """The scatter about a law at some parameters, the means weighed by it, and the covariance (q, q) it leaves."""

    weighted: FitProblem
    model: ScatterModel
    covariance: FloatArray
    moved: FloatArray
    """How one standard uncertainty of each stated error moves the free parameters, shape (q, b)."""


def estimated(
    layout: Layout,
    theta: FloatArray,
    free: BoolArray,
    errors: FloatArray | None = None,
    *,
    mixed: bool = True,
) -> Estimate | None:
    """Return the scatter of cells about their law at theta, for the parameters that are `free`.

    `errors` (k, b): how one standard uncertainty of each stated error moves ln F_A of each cell. Weights alone need no
    mixtures (`mixed`). None where nothing is left to estimate from: no cell more than parameters, or means that agree
    with the law to rounding.
    """
    problem, p = layout.problem, theta.size
    values, J = problem.law.log_lift_and_jacobian(theta, problem.conditions)
    X, r = J[:, free], problem.log_lift - values
    Z = np.zeros((r.size, 0)) if errors is None else errors
    seen = stats.decomposed(X)
    left = seen.left[:, ~seen.lost]
    spare, rest = r.size - left.shape[1], r - left @ (left.T @ r)
    within = layout.within if layout.spare else 0.0
    size2 = float(rest @ rest) / max(spare, 1) + within**2
    if spare < 1 or size2**0.5 < stats.SMALLEST_SCATTER:
        return None
    rise = values - problem.conditions.log_end_tension
    parts = _parts_of(_separable(layout, left, rise), layout, rise, full=bool(Z.shape[1]))
    known = Z @ Z.T if Z.shape[1] else np.zeros(())
    # In units of what the residuals scatter by.
    by_shape = any(np.unique(layout.groups[name]).size == r.size for name in parts if name in layout.groups)
    reml = Reml(r / size2**0.5, X, parts, known / size2, layout.squares / size2, layout.spare, by_shape)
    variance, at = reml.solved()
    inverse, C, adjusted = at.corrections()
    slopes, place = np.zeros((len(parts), p, p)), free.nonzero()[0]
    slopes[np.ix_(np.arange(len(parts)), place, place)] = at.half @ C @ at.half.T
    counts, groups = layout.level_counts, [name for name in parts if mixed and name in layout.groups]
    mixtures = (reml.mixture(name, _levels(name, layout, rise), variance) for name in groups)
    model = ScatterModel(
        names=tuple(parts), levels=tuple(counts[name] for name in parts), variance=variance * size2,
        covariance=inverse * size2**2, slopes=slopes, uneven=layout.uneven,
        labels={name: words for name, words in layout.labels.items() if name in parts}, tail_dof=layout.tail_dof,
        mixtures=tuple(one._replace(variance=one.variance * size2) for one in mixtures),
    )  # fmt: skip
    whitening = at.whitening / size2**0.5
    weight = {"std": 1.0 / whitening} if whitening.ndim == 1 else {"root": whitening}
    covariance = at.half @ adjusted @ at.half.T * size2
    moved = size2**0.5 * at.half @ (at.left.T @ times(whitening, Z))
    return Estimate(replace(problem, **weight), model, covariance, moved)


def weighed(layout: Layout, model: ScatterModel, theta: FloatArray, errors: FloatArray) -> FitProblem:
    """Return the means of cells weighed by a model of their scatter and by stated errors (k, b)."""
    problem = layout.problem
    rise = problem.law.log_lift(theta, problem.conditions) - problem.conditions.log_end_tension
    parts = _parts_of(model.names, layout, rise, full=bool(errors.shape[1]))
    V = sum(size * part for size, part in zip(model.variance.tolist(), parts.values(), strict=True))
    V = V + errors @ errors.T if errors.shape[1] else V
    if V.ndim == 1:
        return replace(problem, std=np.sqrt(V))
    return replace(problem, root=np.linalg.inv(np.linalg.cholesky(V)))


class MeasuredLevel(NamedTuple):
    """Information of the trials about one level of a group at c conditions, such as a rope that was pulled.

    Beside the law, ln F_A of the level's mean (c,); of its error the part of each variance (c, m), what stated errors
    bring (c,), and what the variances being estimated bring (c,).
    """

    shift: FloatArray
    own: FloatArray
    known: FloatArray
    estimated: FloatArray


def measured_level(  # noqa: PLR0917  (each is a part of the mixed model)
    layout: Layout,
    model: ScatterModel,
    theta: FloatArray,
    errors: FloatArray,
    of: tuple[str, int],
    slopes: FloatArray,
    rise: FloatArray,
) -> MeasuredLevel:
    """Return the best linear unbiased prediction for a level, where ln F_A has some slopes (c, p) and rises (c,).

    k is what the level shares with the means y of the cells, X their slopes, C = (Xᵀ V⁻¹ X)⁻¹. The prediction is λᵀ y,
    λ = V⁻¹ k + V⁻¹ X C (j − Xᵀ V⁻¹ k) (Henderson 1975, Biometrics 31:423), and its variance changes with each σ_i² by
    λᵀ A_i λ − 2 λᵀ ∂k/∂σ_i² + ∂σ²/∂σ_i² rise². Estimated variances add 2 Σ w_ij m_iᵀ P m_j, m_i = ∂k/∂σ_i² − A_i λ
    (Kackar & Harville 1984, JASA 79:853), which for the law alone is what Kenward and Roger add.
    """
    name, level = of
    weighted, place = weighed(layout, model, theta, errors), model.names.index(name)
    values, J = weighted.law.log_lift_and_jacobian(theta, weighted.conditions)
    X, slopes = J[:, weighted.vary], slopes[:, weighted.vary]
    there = values - weighted.conditions.log_end_tension
    shared = np.outer(rise, there * (layout.groups[name] == level))
    size = max(float(model.variance[place]), 0.0)
    half, left = stats.decomposed(weighted.whitened(X.T).T).root()
    k = size * weighted.whitened(shared)
    turned = k + (slopes @ half - k @ left) @ left.T
    weights = turned / weighted.std if weighted.root is None else turned @ weighted.root
    own, moved = [], []
    for one in model.names:
        part = _part(one, layout, there)
        by = weights * part if part.ndim == 1 else weights @ part
        own.append((weights * by).sum(axis=1))
        if one == name:
            by = by - shared
            own[-1] += (shared.any(axis=1) * rise**2) - 2.0 * (weights * shared).sum(axis=1)
        by = weighted.whitened(by)
        moved.append(by - (by @ left) @ left.T)
    more = 2.0 * np.einsum("ij,ick,jck->c", model.covariance, np.stack(moved), np.stack(moved))
    known = ((weights @ errors) ** 2).sum(axis=1)
    return MeasuredLevel(k @ weighted.whitened(weighted.log_lift - values), np.array(own).T, known, more)


def _parts_of(names: Sequence[str], layout: Layout, rise: FloatArray, *, full: bool) -> dict[str, FloatArray]:
    """Return `_part` of each component: all diagonals, or all matrices where one of them is or `full` demands it."""
    parts = {name: _part(name, layout, rise) for name in names}
    if full or any(part.ndim == 2 for part in parts.values()):
        parts = {name: np.diag(part) if part.ndim == 1 else part for name, part in parts.items()}
    return parts


def _part(name: str, layout: Layout, rise: FloatArray) -> FloatArray:
    """Return what a component adds to the covariance of the cells by a variance of one; a vector for a diagonal."""
    factor = layout.uneven.factor(layout.problem.log_lift)
    if name == REPEAT:
        return factor / layout.size
    if name == CONDITION:
        return np.sqrt(np.outer(factor, factor)) * _same(layout.condition) if layout.nested else factor
    levels = _levels(name, layout, rise)
    return rise**2 if levels.shape[1] == rise.size else levels @ levels.T


def _levels(name: str, layout: Layout, rise: FloatArray) -> FloatArray:
    """Return by how much each level of a group moves ln F_A of the cells, shape (k, levels)."""
    level = layout.groups[name]
    return rise[:, None] * np.equal.outer(level, np.unique(level))


def _separable(layout: Layout, left: FloatArray, rise: FloatArray) -> tuple[str, ...]:
    """Return the components that residuals can separate, the groups first.

    Without repeats, or where all of them agree to rounding, the scatter between conditions is all there is.
    """
    found = (CONDITION, REPEAT) if layout.nested or layout.within > 0.0 else (CONDITION,)
    if not layout.groups:
        return found
    M = np.eye(rise.size) - left @ left.T

    def beside(name: str) -> FloatArray:
        """Return what the law leaves of a component, in one row."""
        return np.asarray(times(_part(name, layout, rise), M).T @ M).ravel()

    seen = [beside(CONDITION)]
    for name in layout.groups:
        more = [*seen, beside(name)]
        gram = np.array([[one @ other for one in more] for other in more])
        size = np.sqrt(np.maximum(np.diag(gram), _TINY))
        if float(np.linalg.eigvalsh(gram / np.outer(size, size))[0]) > _SEPARABLE:
            found, seen = (name, *found), more
    return found


def _same(level: IntArray) -> FloatArray:
    """Return which pairs of cells share a level, 1 or 0, shape (k, k)."""
    return np.equal.outer(level, level).astype(np.float64)
