"""Variances of several components by restricted maximum likelihood (REML), and all others that are possible.

Patterson & Thompson 1971, Biometrika 58:545. What the components are is said in `ropefric.fitting.scatter`.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.fitting.statistics import decomposed

Known = FloatArray | float
CONDITION, REPEAT = "condition", "repeat"

# The variance of a mean stays above this part of what its repeats leave (of single pulls, what pulls scatter by),
# however low the others happen to be. Where each condition has a level of its own only the shape of its scatter tells
# it from the condition's: were the sum of both let below zero, the mean of least rise would count for all.
_LEAST, _LEAST_BY_SHAPE = 0.05, 1.0
_ROUNDS, _HALVINGS, _LONGER = 100, 30, 4.0
_SETTLED, _CLOSE = 1e-9, 1e-10
# ln ρ of a group, its largest eigenvalue one, where the likelihood is looked for; and its nodes, in standard deviations.
_LOG_RATIOS, _NODES = np.arange(-14.0, 60.0, 0.1), np.linspace(-6.0, 12.0, 46)
_TINY = 1e-300


class Mixture(NamedTuple):
    """All variances that are possible where one group may scatter more or less than estimated.

    Attributes
    ----------
    weight : ndarray, shape (k,)
        Probabilities, their sum one.
    variance : ndarray, shape (k, m)
        Of each component, as in `ScatterModel`.
    dof : float
        Degrees of freedom of the residuals, by which each row of variances is known.
    """

    weight: FloatArray
    variance: FloatArray
    dof: float

    def precision(self, slopes: FloatArray, known: Known) -> tuple[FloatArray, FloatArray]:
        """Return the mean of 1/v and its relative variance, v = Σ slopes_i σ_i² + known, shapes (r,)."""
        variance = slopes @ self.variance.T + np.reshape(known, (-1, 1))
        unsure = 1.0 + 2.0 / self.dof * (slopes @ self.variance.T / variance) ** 2
        mean = variance**-1.0 @ self.weight
        return mean, (unsure * variance**-2.0) @ self.weight / mean**2 - 1.0


def times(whitening: FloatArray, columns: FloatArray) -> FloatArray:
    """Return R X of columns X (k, …), R a matrix or the diagonal of one."""
    return columns * whitening[:, None] if whitening.ndim == 1 else whitening @ columns


class Moments(NamedTuple):
    """The restricted likelihood of some variances, in coordinates in which V is one: its score and information."""

    likelihood: float
    score: FloatArray
    information: FloatArray
    whitening: FloatArray
    half: FloatArray
    left: FloatArray
    parts: list[FloatArray]

    def corrections(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the covariance of the variances, Uᵀ A_i U, and Kenward and Roger's factor of the covariance.

        I + 2 Σ w_ij (Uᵀ A_i A_j U − Uᵀ A_i U Uᵀ A_j U), A_i the whitened parts and U the whitened slopes' basis.
        """
        inverse = np.asarray(np.linalg.pinv(self.information, hermitian=True), np.float64)
        C = np.stack([_seen(self.left, A) for A in self.parts])
        factor = np.eye(self.left.shape[1])
        for i, A in enumerate(self.parts):
            for j, B in enumerate(self.parts):
                product = _seen(self.left, A * B) if A.ndim == 1 else (self.left.T @ A) @ (B @ self.left)
                factor = factor + 2.0 * inverse[i, j] * (product - C[i] @ C[j])
        return inverse, C, 0.5 * (factor + factor.T)


def _seen(left: FloatArray, A: FloatArray) -> FloatArray:
    """Return Uᵀ A U for a matrix or a diagonal, shape (q, q)."""
    return np.asarray((left.T * A) @ left if A.ndim == 1 else left.T @ A @ left)


def _whitening(V: FloatArray, least: FloatArray) -> tuple[FloatArray, float] | None:
    """Return R with Rᵀ R = V⁻¹, or its diagonal, and ln |V|; None unless `least` is positive definite."""
    if V.ndim == 1:
        return (V**-0.5, float(np.log(V).sum())) if float(least.min()) > 0.0 else None
    try:
        np.linalg.cholesky(least)
        triangle = np.linalg.cholesky(V)
    except np.linalg.LinAlgError:
        return None
    return np.linalg.inv(triangle), 2.0 * float(np.log(np.diag(triangle)).sum())


def _turned(whitening: FloatArray, part: FloatArray) -> FloatArray:
    """Return R A Rᵀ, or its diagonal."""
    return part * whitening**2 if part.ndim == 1 else whitening @ part @ whitening.T


def _sums(A: Sequence[FloatArray], left: FloatArray, e: FloatArray) -> tuple[FloatArray, list[float]]:
    """Return tr(A_i A_j) − 2 tr(Uᵀ A_i A_j U), shape (m, m), and eᵀ A_i e − tr(A_i)."""
    if A[0].ndim == 1:
        rest = 1.0 - 2.0 * (left**2).sum(axis=1)
        trace = [[float(rest @ (a * b)) for a in A] for b in A]
        return np.array(trace), [float(a @ (e * e - 1.0)) for a in A]
    trace = [[float((a * b).sum() - 2.0 * ((a @ left) * (b @ left)).sum()) for a in A] for b in A]
    return np.array(trace), [float(e @ a @ e - np.trace(a)) for a in A]


class Reml(NamedTuple):
    """Residuals r of k means with slopes X, V = Σ s_i part_i + known, and the squares of repeats about their means.

    `by_shape`: whether a group has a level for each mean.
    """

    r: FloatArray
    X: FloatArray
    parts: Mapping[str, FloatArray]
    known: FloatArray
    squares: float
    spare: int
    by_shape: bool = False

    def solved(self) -> tuple[FloatArray, Moments]:
        """Return the variances of greatest restricted likelihood, by Fisher's scoring with steps that must gain."""
        within = max(self.squares / self.spare, 1e-3) if self.spare else 0.5
        start = {CONDITION: max(1.0 - within, 0.1)}
        s = np.array([within if name == REPEAT else start.get(name, 1e-3) for name in self.parts])
        at = self.moments(s)
        while at is None:  # what is known may be more than all that residuals show
            s = 2.0 * s
            at = self.moments(s)
        share = 1.0
        for _ in range(_ROUNDS):
            # On the way to the edge of what is possible each step is a part of the one before it.
            share = min(1.0, _LONGER * share)
            whole, new = np.linalg.lstsq(at.information, at.score, rcond=None)[0], None
            for _ in range(_HALVINGS):
                new = self.moments(s + share * whole)
                if new is not None and new.likelihood >= at.likelihood - _SETTLED:
                    break
                share, new = 0.5 * share, None
            if new is None:
                break
            step, gain = share * whole, abs(new.likelihood - at.likelihood)
            s, at = s + step, new
            if gain < _SETTLED and float(np.abs(step).max()) < _CLOSE * float(np.abs(s).max()):
                break
        return s, at

    def moments(self, s: FloatArray) -> Moments | None:
        """Return what the likelihood says at some variances; None where they leave no covariance."""
        of = dict(zip(self.parts, s.tolist(), strict=True))
        V = self.known + sum(size * self.parts[name] for name, size in of.items())
        repeat, last = of.get(REPEAT, 1.0), [*of][-1]
        if repeat <= 0.0 or (self.by_shape and of[last] <= 0.0):
            return None
        floor = (_LEAST_BY_SHAPE if self.by_shape else _LEAST) * max(of[last], 0.0) * self.parts[last]
        if (found := _whitening(V, V - floor)) is None:
            return None
        whitening, log_det = found
        svd = decomposed(times(whitening, self.X))
        half, left = svd.root()
        log_det += 2.0 * float(np.log(svd.values[~svd.lost]).sum() + np.log(svd.length).sum())
        e = times(whitening, self.r[:, None])[:, 0]
        e = e - left @ (left.T @ e)
        A = [_turned(whitening, part) for part in self.parts.values()]
        trace, score = _sums(A, left, e)
        C = [_seen(left, a) for a in A]
        information = 0.5 * (trace + np.array([[float((c * d).sum()) for c in C] for d in C]))
        gradient = 0.5 * np.array([x + float(np.trace(c)) for x, c in zip(score, C, strict=True)])
        likelihood = -0.5 * (log_det + float(e @ e))
        if REPEAT in of and self.spare:
            place = [*of].index(REPEAT)
            information[place, place] += 0.5 * self.spare / repeat**2
            gradient[place] += 0.5 * (self.squares / repeat**2 - self.spare / repeat)
            likelihood -= 0.5 * (self.spare * np.log(repeat) + self.squares / repeat)
        return Moments(float(likelihood), gradient, information, whitening, half, left, A)

    def mixture(self, name: str, levels: FloatArray, s: FloatArray) -> Mixture:
        """Return the variances that are possible for the group `name`, the others in the proportions of s.

        `levels` (k, l) move the means. V = σ² (W + ρ levels levelsᵀ) with W of the other components: the restricted
        likelihood of ρ and σ, times Jeffreys' prior for both, is integrated over σ in closed form. The mean squares
        of a balanced design then have their exact distribution, but for the part below zero.
        """
        place, size = [*self.parts].index(name), np.maximum(s, 0.0)
        size[place], size[-1] = 0.0, max(size[-1], _SETTLED)  # W stays definite
        W = self.known + sum(x * part for x, part in zip(size.tolist(), self.parts.values(), strict=True))
        whitening = np.asarray(W**-0.5 if W.ndim == 1 else np.linalg.inv(np.linalg.cholesky(W)))
        left = decomposed(times(whitening, self.X)).root()[1]
        turned = times(whitening, np.column_stack([levels, self.r]))
        turned -= left @ (left.T @ turned)
        basis, length, _ = np.linalg.svd(turned[:, :-1], full_matrices=False)
        e, by_level = turned[:, -1], (length / length[0]) ** 2
        shown = (basis.T @ e) ** 2
        rest, dof = max(float(e @ e - shown.sum()), _TINY), e.size - left.shape[1]
        if REPEAT in self.parts and self.spare:
            rest, dof = rest + self.squares / size[-1], dof + self.spare  # repeats come last

        def density(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Return the probabilities of ln ρ = x on a grid, and σ² there."""
            share = 1.0 / (1.0 + np.exp(x)[:, None] * by_level)
            size2 = (rest + share @ shown) / dof
            first, second = share @ by_level, share**2 @ by_level**2
            prior = x + 0.5 * np.log(np.maximum(dof * second - first**2, _TINY))
            log_density = prior + 0.5 * np.log(share).sum(axis=1) - 0.5 * dof * np.log(size2)
            weight = np.exp(log_density - log_density.max())
            return weight / weight.sum(), size2

        weight = density(_LOG_RATIOS)[0]
        centre = float(weight @ _LOG_RATIOS)
        x = centre + _NODES * float(weight @ (_LOG_RATIOS - centre) ** 2) ** 0.5
        weight, size2 = density(x)
        variance = np.outer(size2, size)
        variance[:, place] = size2 * np.exp(x) / length[0] ** 2
        return Mixture(weight, variance, float(dof))
