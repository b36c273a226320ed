"""Fitting a law: numerical against analytic Jacobian, and where to stop."""

from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ropefric.accuracy.study import Case, Setting, Study, against, largest_error
from ropefric.arrays import FloatArray
from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS

TRUTH = (0.2, -0.5, 0.1)
START = (0.4, -0.3, 0.05)
SCATTER = 0.005

# 50-digit minimisers of the sum of squares; the tests compute them again with mpmath.
BEST = {
    "wide": (0.19890743438850641037, -0.50393344625312553004, 0.10081282347372692106),
    "narrow": (0.19745451647715007688, -0.51025134520662045737, 0.10200176200322571056),
}
_WRAPS_RAD = {"wide": (0.5, 25.0), "narrow": (6.0, 20.0)}
_N_POINTS = 12
# Data of so many decimals are the same on every processor, whatever its last bits of sine and logarithm.
_DECIMALS = 6
_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-15)


@cache
def fitting_problem(case: str) -> FitProblem:
    """Return twelve pulls of wrap-power, counted from φ = 0, with a scatter of half a per cent."""
    law = ALL_LAWS["wrap-power-from-zero"]
    low, high = _WRAPS_RAD[case]
    pulls = Conditions(
        wheel_radius_m=np.full(_N_POINTS, 0.04),
        rope_radius_m=np.full(_N_POINTS, 0.005),
        wrap_angle_rad=np.linspace(low, high, _N_POINTS).round(_DECIMALS),
        end_tension_N=np.full(_N_POINTS, 20.0),
    )
    scatter = SCATTER * np.sin(1.0 + 2.0 * np.arange(_N_POINTS))
    log_lift = (law.log_lift(TRUTH, pulls) + scatter).round(_DECIMALS)
    return FitProblem.plain(law, pulls, log_lift, SCATTER, START)


def _settings(case: str) -> tuple[Setting, ...]:
    problem, exact = fitting_problem(case), BEST[case]

    def by_scipy(tolerance: float, residuals: Any, slopes: Any = None, *, jacobian: Any = "") -> FloatArray:
        found = least_squares(
            residuals, problem.start, jac=slopes or jacobian, bounds=(problem.lower, problem.upper), x_scale="jac",
            ftol=tolerance, xtol=tolerance, gtol=tolerance, max_nfev=500,
        )  # fmt: skip
        return np.asarray(found.x)

    judged = partial(against, exact, over=_TOLERANCES, work="calls")
    label, residuals = "tolerance {:g}", problem.residuals
    return (
        *judged("2-point Jacobian", label, partial(by_scipy, jacobian="2-point"), residuals),
        *judged("3-point Jacobian", label, partial(by_scipy, jacobian="3-point"), residuals),
        *judged("analytic Jacobian", label, by_scipy, residuals, problem.jacobian),
        *judged("ropefric, batched", label, lambda tolerance: batched_fit(problem, tolerance=tolerance),
                error=lambda found, best: largest_error(found.theta[0], best),
                work=lambda found, _: found.n_iterations + 1),
    )  # fmt: skip


STUDY = Study(
    name="fit",
    title="Fitting wrap-power to twelve pulls: Jacobian and tolerance",
    question="What does an analytic Jacobian save, and how tight must the tolerance be for the digits wanted?",
    reference="minimiser of the same sum of squares in 50-digit arithmetic (mpmath)",
    counted="evaluations of the law or of its slopes at all pulls",
    used="analytic Jacobian, batched",
    cases=(
        Case("wide", "wraps from 0.5 to 25 rad, which see all three parameters", partial(_settings, "wide")),
        Case(
            "narrow",
            "wraps from 6 to 20 rad, along which the parameters are strongly correlated",
            partial(_settings, "narrow"),
        ),
    ),
)
