"""A friction law fitted to a trial table: ln F_A by weighted least squares through the integral."""

from collections.abc import Mapping
from typing import Literal

import numpy as np

from ropefric.errors import InputError
from ropefric.fitting.assemble import assemble
from ropefric.fitting.losses import Loss
from ropefric.fitting.nonlinear import check_start
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.result import FitResult
from ropefric.fitting.search import search
from ropefric.fitting.settings import FitSettings, check_settings
from ropefric.fitting.table import TrialTable
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.friction.start import guess

_LARGEST = 1e100
"""Beyond this the squares of residuals and slopes, and their sums, are no floats."""


def fit_law(
    table: TrialTable,
    law: str | FrictionLaw,
    *,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    scale_covar: Literal["auto"] | bool = "auto",
    loss: Loss = "linear",
    clustered: bool = True,
    n_starts: int = 4,
    seed: int = 0,
) -> FitResult:
    """Return a law fitted to the used trials of a table.

    A doubtful result comes back with a status that says so; see `FitResult.status`.
    """
    chosen = ALL_LAWS[law] if isinstance(law, str) else law
    settings = FitSettings(
        fixed=dict(fixed or {}),
        bounds=dict(bounds or {}),
        start=dict(start or {}),
        scale_covar=scale_covar,
        loss=loss,
        clustered=clustered,
        n_starts=n_starts,
        seed=seed,
    )
    problem = problem_of(table, chosen, settings)
    return assemble(search(problem, table, settings), table, settings)


def problem_of(table: TrialTable, law: FrictionLaw, settings: FitSettings) -> FitProblem:
    """Return the data of a table as a least-squares problem with equal weights, start values and bounds."""
    check_settings(settings, law)
    if not table.used.any():
        raise InputError(
            "no trial of the table can be used", code="RF410", fix="check the columns kept and status"
        )
    conditions, log_lift = table.conditions(), table.log_lift()
    _check_range(conditions)
    bounds, starts, held = settings.bounds or {}, settings.start or {}, settings.fixed
    spans = [bounds.get(item.name, (item.lower, item.upper)) for item in law.parameters]
    lower, upper = np.array(spans, dtype=np.float64).T
    given = {item.name: item.start for item in law.parameters if item.fixed} | dict(starts) | dict(held)
    found = np.clip(guess(law, conditions, log_lift), lower, upper)
    theta = [given.get(name, value) for name, value in zip(law.parameter_names, found, strict=True)]
    vary = [
        item.name not in held and (not item.fixed or item.name in starts or item.name in bounds)
        for item in law.parameters
    ]
    start = np.array(theta, dtype=np.float64)
    check_start(start, lower, upper, law.parameter_names, None)
    if not law.admissible(start, conditions):
        law.log_lift(start, conditions)  # raises, and says why and what to do
    return FitProblem(
        law=law,
        conditions=conditions,
        log_lift=log_lift,
        std=np.ones_like(log_lift),
        group=table.group(),
        start=start,
        lower=lower,
        upper=upper,
        vary=np.array(vary),
    )


def _check_range(conditions: Conditions) -> None:
    for name in ("size_ratio", "wrap_angle_rad"):
        too_large = getattr(conditions, name) > _LARGEST
        if too_large.any():
            at = conditions.describe(int(np.argmax(too_large)))
            raise InputError(
                f"{name} is above {_LARGEST:g} at {at}: no sum of squares holds it",
                code="RF410",
                fix="correct the trial or its units, or leave it out",
            )
