"""Whole statements for the two questions asked: of a measured condition, and of a lift force that a fit predicts."""

from typing import Literal

from ropefric.errors import InputError
from ropefric.fitting.extrapolation import outside_words
from ropefric.fitting.gum.forces import coefficient_model, force_model
from ropefric.fitting.gum.lift import WheelUncertainty, lift_model
from ropefric.fitting.gum.measured import MeasuredCondition
from ropefric.fitting.gum.quantity import normal
from ropefric.fitting.gum.statement import BudgetStatus, Statement, state_uncertainty
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions

__all__ = ["MeasuredQuantity", "state_condition", "state_lift"]

MeasuredQuantity = Literal["force", "mu"]
"""The force that was measured, or μ̄ = ln(F_A/F_B)/φ."""


def state_condition(
    condition: MeasuredCondition,
    quantity: MeasuredQuantity = "force",
    *,
    u_wrap_angle_rad: float | None = None,
    gain_limit: float = 0.0,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> Statement:
    """Return the uncertainty of what was measured at one condition.

    Parameters
    ----------
    condition : MeasuredCondition
        The condition, its forces taken apart.
    quantity : {"force", "mu"}
        What the budget is of.
    u_wrap_angle_rad : float, optional
        Standard uncertainty of the wrap [rad]; by default what the condition says.
    gain_limit : float
        Limit of error of the gain, common to both sides [-].
    level, draws, seed
        As `state_uncertainty`.

    Raises
    ------
    InputError
        If the quantity is neither, or an argument is out of range.

    Examples
    --------
    >>> from ropefric.fitting.gum.from_table import conditions_of_table
    >>> from ropefric.fitting.table import TrialTable
    >>> table = TrialTable(
    ...     trial=("a", "b", "c"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0, end_tension_N=20,
    ...     peak_N=[36.0, 36.8, 36.3],
    ... )
    >>> stated = state_condition(conditions_of_table(table)[0], "mu", u_wrap_angle_rad=0.03, draws=20_000)
    >>> round(stated.budget.estimate, 3), [line.name for line in stated.budget.lines][:2]
    (0.199, ['repeatability', 'wrap angle'])
    """
    notes = condition.notes
    if quantity == "force":
        model = force_model(condition.measured)
    elif quantity == "mu":
        u_rad = condition.wrap_std_rad if u_wrap_angle_rad is None else u_wrap_angle_rad
        if not u_rad:
            notes += (
                'the wrap is taken as exact; --u-wrap "2 deg", or u_wrap_angle_rad in Python, says otherwise',
            )
        wrap = normal("wrap angle", "φ", "rad", u_rad, estimate=condition.wrap_angle_rad)
        model = coefficient_model(condition.lift, condition.end, wrap, gain_limit=gain_limit)
    else:
        raise InputError(
            f"{quantity!r} is neither 'force' nor 'mu'", key="quantity", fix="choose one of the two"
        )
    status = BudgetStatus.OK if condition.has_scatter else BudgetStatus.NO_REPEATS
    return state_uncertainty(model, level=level, draws=draws, seed=seed, status=status, notes=notes)


def state_lift(
    fit: FitResult,
    at: Conditions,
    uncertainty: WheelUncertainty,
    *,
    one_pull: bool = False,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> Statement:
    """Return the uncertainty of the lift force that a fit predicts for a wheel known only so well.

    Parameters
    ----------
    fit : FitResult
        The fit.
    at : Conditions
        The one condition.
    uncertainty : WheelUncertainty
        Of the wheel.
    one_pull : bool
        Of one pull with a new rope, not of the mean law.
    level, draws, seed
        As `state_uncertainty`.

    Raises
    ------
    InputError
        If the law has no answer for this wheel, or an argument is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from ropefric.fitting.fit import fit_law
    >>> from ropefric.fitting.table import TrialTable
    >>> from ropefric.friction.condition import one_condition
    >>> wrap = np.repeat([3.0, 6.0, 9.0], 2)
    >>> table = TrialTable(
    ...     trial=tuple("abcdef"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=wrap, end_tension_N=20,
    ...     peak_N=20 * np.exp(0.2 * wrap + 0.01 * np.array([1, -1, -1, 1, 1, -1])),
    ... )
    >>> wheel = one_condition(0.04, 0.005, 7.0, 20.0)
    >>> stated = state_lift(
    ...     fit_law(table, "constant"), wheel, WheelUncertainty(wrap_angle_rad=0.03), draws=20_000
    ... )
    >>> round(stated.budget.estimate, 1)
    81.1
    """
    return state_uncertainty(
        lift_model(fit, at, uncertainty, one_pull=one_pull),
        level=level,
        draws=draws,
        seed=seed,
        status=BudgetStatus.OK if fit.trustworthy else BudgetStatus.FIT_NOT_TRUSTED,
        notes=outside_words(fit.validity, at),
    )
