"""How uncertain forces are and why, and what to test so that they become less so."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ropefric.api.campaigns import PathLike
from ropefric.api.inputs import as_fit, trial_table
from ropefric.errors import InputError
from ropefric.fitting.lift_budget import WheelUncertainty, state_lift
from ropefric.fitting.measured_budget import (
    GRAVITY_LIMIT,
    MeasuredQuantity,
    conditions_of_extraction,
    conditions_of_table,
    state_condition,
)
from ropefric.fitting.next_tests import LabPlan, PlannedLaw, planned_fit
from ropefric.fitting.next_tests import plan_tests as find_plan
from ropefric.fitting.plan_search import Criterion, RigLimits
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import one_condition
from ropefric.trials.result import Extraction
from ropefric.uncertainty.statement import Statement

if TYPE_CHECKING:
    import pandas as pd

    from ropefric.trials.table import TrialTable


def budget(
    fit: FitResult | PathLike,
    *,
    wheel_radius_m: float,
    wrap_angle_rad: float,
    end_tension_N: float,
    rope_radius_m: float | None = None,
    u_wheel_radius_m: float = 0.0,
    u_rope_radius_m: float = 0.0,
    u_wrap_angle_rad: float = 0.0,
    u_end_tension_N: float = 0.0,
    one_pull: bool = False,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> Statement:
    """Return the uncertainty budget of a lift force that a fit predicts for a wheel known only so well.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    wheel_radius_m, wrap_angle_rad, end_tension_N : float
        R_w [m], φ [rad], F_B [N].
    rope_radius_m : float, optional
        R_r [m]; that of the trials where they had one rope only.
    u_wheel_radius_m, u_rope_radius_m, u_wrap_angle_rad, u_end_tension_N : float
        Their standard uncertainties; 0 for what is exact.
    one_pull : bool
        Of one pull with a new rope, not of the mean law.
    level, draws, seed
        As `ropefric.uncertainty.statement.state_uncertainty`.

    Returns
    -------
    Statement
        `budget.lines`, its check by draws, what would make it smaller, and a `status`.

    Raises
    ------
    InputError
        If the law has no answer for this wheel, or the rope is not given and not known.

    Examples
    --------
    >>> import numpy as np
    >>> import pandas as pd
    >>> from ropefric.api.fits import fit
    >>> wrap_rad = np.repeat([3.0, 6.0, 9.0], 2)
    >>> frame = pd.DataFrame({"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad,
    ...     "end_tension_N": 20, "peak_N": 20 * np.exp(0.2 * wrap_rad + 0.01 * np.array([1, -1, -1, 1, 1, -1]))})
    >>> stated = budget(fit(frame, "constant"), wheel_radius_m=0.04, wrap_angle_rad=7.0, end_tension_N=20.0,
    ...                 u_wrap_angle_rad=0.03, draws=20_000)
    >>> round(stated.budget.estimate, 1), max(stated.budget.lines, key=lambda line: line.share).name
    (81.1, 'wrap angle')
    """
    stored = as_fit(fit)
    radius_m = stored.only_rope_radius_m() if rope_radius_m is None else rope_radius_m
    at = one_condition(wheel_radius_m, radius_m, wrap_angle_rad, end_tension_N)
    uncertainty = WheelUncertainty(
        wheel_radius_m=u_wheel_radius_m,
        rope_radius_m=u_rope_radius_m,
        wrap_angle_rad=u_wrap_angle_rad,
        end_tension_N=u_end_tension_N,
    )
    return state_lift(stored, at, uncertainty, one_pull=one_pull, level=level, draws=draws, seed=seed)


def measured_budgets(
    trials: "TrialTable | Extraction | pd.DataFrame | PathLike",
    quantity: MeasuredQuantity = "force",
    *,
    u_wrap_angle_rad: float | None = None,
    gain_limit: float = 0.0,
    weights_tolerance: float = 0.0,
    gravity_limit: float = GRAVITY_LIMIT,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> tuple[Statement, ...]:
    """Return the uncertainty budget of each measured condition: of its force, or of μ̄ = ln(F_A/F_B)/φ.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame or path-like
        See `trial_table`. An extraction knows its measuring chain, a table only the total.
    quantity : {"force", "mu"}
        What the budget is of.
    u_wrap_angle_rad : float, optional
        Standard uncertainty of the wraps [rad]; by default what the trials say.
    gain_limit : float
        Limit of error of the gain, common to both sides [-].
    weights_tolerance : float
        Of the dead weights of an extraction [-], see `ropefric.fitting.measured_budget.weights`.
    gravity_limit : float
        Limit of error of g of the weights [-].
    level, draws, seed
        As `budget`.

    Raises
    ------
    DataError
        With everything that is wrong in a table.
    InputError
        If the quantity is neither, or an argument is out of range.

    Examples
    --------
    >>> import pandas as pd
    >>> frame = pd.DataFrame({"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": 3.0,
    ...                       "end_tension_N": 20, "peak_N": [36.0, 36.8, 36.3]})
    >>> [round(one.budget.estimate, 2) for one in measured_budgets(frame, draws=20_000)]
    [36.37]
    """
    if isinstance(trials, Extraction):
        found = conditions_of_extraction(
            trials, weights_tolerance=weights_tolerance, gravity_limit=gravity_limit
        )
    else:
        found = conditions_of_table(trial_table(trials), gravity_limit=gravity_limit)
    return tuple(
        state_condition(
            item,
            quantity,
            u_wrap_angle_rad=u_wrap_angle_rad,
            gain_limit=gain_limit,
            level=level,
            draws=draws,
            seed=seed,
        )
        for item in found
    )


def plan_tests(
    known: FitResult | PlannedLaw | PathLike,
    *,
    wheels_m: Sequence[float],
    wraps_rad: Sequence[float],
    end_tensions_N: Sequence[float],
    wheel_radius_m: float,
    wrap_angle_rad: float,
    end_tension_N: float,
    rope_radius_m: float | None = None,
    largest_force_N: float = math.inf,
    n_conditions: int = 12,
    repeats: int = 12,
    criterion: Criterion = "v",
    level: float = 0.95,
    starts: int = 10,
    seed: int = 0,
) -> LabPlan:
    """Return the conditions to test next so that one wanted lift force becomes as certain as it can.

    Parameters
    ----------
    known : FitResult, PlannedLaw or path-like
        A fit or its file; or a law with guessed parameters, from `ropefric.fitting.next_tests.planned_guess`.
    wheels_m, wraps_rad, end_tensions_N : sequence of float
        Settings the rig has: R_w [m], φ [rad], F_B [N].
    wheel_radius_m, wrap_angle_rad, end_tension_N : float
        The wheel whose lift force is wanted.
    rope_radius_m : float, optional
        R_r [m]; that of the trials where they had one rope only, and needed with a guessed law.
    largest_force_N : float
        The largest F_A the cell takes [N].
    n_conditions, repeats, criterion, level, starts, seed
        As `ropefric.fitting.next_tests.plan_tests`.

    Raises
    ------
    InputError
        If the rope is not given and not known, or no plan within these settings can tell.

    Examples
    --------
    >>> from ropefric.fitting.next_tests import MeanScatter, planned_guess
    >>> from ropefric.friction.laws import LAWS
    >>> law = planned_guess(LAWS["constant"], {"mu": 0.2}, MeanScatter(within=0.02))
    >>> plan = plan_tests(law, wheels_m=[0.03, 0.04], wraps_rad=[3.0, 6.0, 9.0, 12.0], end_tensions_N=[20.0, 40.0],
    ...     wheel_radius_m=0.05, wrap_angle_rad=14.0, end_tension_N=20.0, rope_radius_m=0.005, largest_force_N=300.0,
    ...     n_conditions=3, repeats=4)
    >>> plan.conditions.wrap_angle_rad.tolist()
    [9.0, 12.0, 12.0]
    """
    rope_m = rope_radius_m
    if isinstance(known, PlannedLaw):
        planned = known
        if rope_m is None:
            raise InputError(
                "a guessed law does not know its rope", key="rope_radius_m", fix="give the rope's radius [m]"
            )
    else:
        stored = as_fit(known)
        planned = planned_fit(stored)
        rope_m = stored.only_rope_radius_m() if rope_m is None else rope_m
    return find_plan(
        planned,
        RigLimits(
            wheel_radius_m=tuple(wheels_m),
            wrap_angle_rad=tuple(wraps_rad),
            end_tension_N=tuple(end_tensions_N),
            rope_radius_m=rope_m,
            largest_force_N=largest_force_N,
        ),
        one_condition(wheel_radius_m, rope_m, wrap_angle_rad, end_tension_N),
        n_conditions=n_conditions,
        repeats=repeats,
        criterion=criterion,
        level=level,
        starts=starts,
        seed=seed,
    )
