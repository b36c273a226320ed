"""The conditions of a trial table as inputs of a budget."""

import math

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.fitting.gum.forces import GRAVITY_LIMIT, ForceSide, weights
from ropefric.fitting.gum.mean import mean_force, pooled_scatter
from ropefric.fitting.gum.measured import MeasuredCondition
from ropefric.fitting.gum.quantity import normal
from ropefric.trials.table import TrialTable

_RECTANGULAR = math.sqrt(3.0)


def conditions_of_table(
    table: TrialTable, *, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of a trial table; its measuring chain is one line, `peak_std_N`, shared by all trials."""
    used, group, slack = table.used, table.group(), table.measures_slack
    measured_N = (table.end_tension_N if slack else table.peak_N)[used]
    chain_N = (table.end_tension_std_N if slack else np.nan_to_num(table.peak_std_N))[used]
    other_N = (table.peak_N if slack else table.end_tension_N)[used]
    other_std_N = (np.nan_to_num(table.peak_std_N) if slack else table.end_tension_std_N)[used]
    wrap, pulls = table.wrap_std_rad[used], table.conditions()
    rows = [np.flatnonzero(group == label) for label in range(int(group.max(initial=-1)) + 1)]
    pooled = pooled_scatter([_spread(measured_N[row]) for row in rows])
    symbols = ("F_B", "F_A") if slack else ("F_A", "F_B")
    found = []
    for number, row in enumerate(rows, start=1):
        u_N = float(np.sqrt((chain_N[row] ** 2).mean()))
        known_N, known_std_N = float(other_N[row].mean()), float(other_std_N[row].max())
        mean, notes = mean_force(symbols[0], measured_N[row], pooled)
        chain = normal("measuring chain, tare and picking", "δ_chain", "N", u_N)
        if not u_N:
            notes += ("the table gives no uncertainty of the measuring chain: it is taken as exact",)
        elif row.size > 1:
            notes += (
                "tare and picking of each trial are counted with the chain as if shared: on the safe side",
            )
        if not known_std_N:
            notes += (f"the table gives no uncertainty of {symbols[1]}: only gravity is counted",)
        tolerance = _RECTANGULAR * known_std_N / known_N
        other = weights(symbols[1], known_N, tolerance=tolerance, gravity_limit=gravity_limit)
        side = ForceSide(symbol=symbols[0], quantities=(mean, chain))
        lift, end = (other, side) if slack else (side, other)
        found.append(
            MeasuredCondition(
                number=number,
                wheel_radius_m=float(pulls.wheel_radius_m[row[0]]),
                rope_radius_m=float(pulls.rope_radius_m[row[0]]),
                wrap_angle_rad=float(pulls.wrap_angle_rad[row[0]]),
                wrap_std_rad=float(wrap[row].max()),
                lift=lift,
                end=end,
                measures_slack=slack,
                n=row.size,
                has_scatter=bool(mean.stated),
                notes=notes,
            )
        )
    return tuple(found)


def _spread(values_N: FloatArray) -> tuple[float, int]:
    return (
        (float(values_N.std(ddof=1) / values_N.mean()), values_N.size - 1) if values_N.size > 1 else (0.0, 0)
    )
