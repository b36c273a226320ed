"""The tables of Wang and Jiang (2010) the way they were worked out on paper, with each rounding on the way."""

import math
from typing import Literal

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.saw import PRINTED_TORQUE_FACTOR, Saw, Side
from ropefric.systems.bandsaw.span import frequency_Hz


def printed_frequencies_Hz(
    saw: Saw, table: Literal[1, 2, 3], side: Side, *, runs: bool, power_W: float, n_modes: int = 6
) -> FloatArray:
    """Return a column of a table as it is printed, shape (n_modes,) [Hz].

    Table 1 cuts n f_1 off after the first decimal. Tables 2 and 3 work on with rounded numbers: M by 9549, ΔF in full
    newtons, v cut off to 35.5 m/s, c to a tenth, and multiply an f_1 of one decimal, cut off in the running columns
    of table 2. Table 3 has the inertia tension from the factors 0.6 kg/m, 3.14 and 16.2 1/s.

    One column and two cells of the print do not follow from this or anything near it, and are misprints: table 2,
    tight, running (19.0 n, where it should be 18.8 n; unrounded 18.85 n); table 2, slack, v = 0, mode 5 (116.6 for
    116.5); table 3, tight, running, mode 5 (108.0 for 109.0).
    """
    modes = np.arange(1.0, n_modes + 1.0)
    if table == 1 and side is Side.REST and not runs:
        exact = frequency_Hz(modes, saw.free_span_m, math.sqrt(saw.preload_N / saw.linear_density_kg_m))
        return _tenths(np.floor(10.0 * exact))
    if table not in (2, 3) or side is Side.REST:
        raise InputError(
            f"table {table} has no such column",
            fix="table 1 is for rest without speed, tables 2 and 3 for the tight and the slack side",
        )
    turns = round(saw.wheel_speed_rad_s * 30.0 / math.pi, 6)
    pull_N = round(PRINTED_TORQUE_FACTOR * power_W / 1e3 / turns / saw.wheel_radius_m) / 2.0
    inertia_N = 0.0
    if table == 3:
        rim_m_s = 2.0 * 3.14 * round(turns / 60.0, 1) * saw.wheel_radius_m
        inertia_N = round(round(saw.linear_density_kg_m, 1) * rim_m_s**2)
    tension_N = saw.preload_N + side.sign * pull_N + inertia_N
    wave_m_s = round(math.sqrt(tension_N / saw.linear_density_kg_m), 1)
    speed_m_s = math.floor(10.0 * saw.speed_m_s) / 10.0 if runs else 0.0
    first = float(frequency_Hz(1, saw.free_span_m, wave_m_s, speed_m_s))
    # On paper a half is rounded up, 23.25 to 23.3.
    tenths = math.floor(round(10.0 * first, 6) + (0.0 if table == 2 and runs else 0.5))
    return _tenths(tenths * modes)


def _tenths(counts: FloatArray) -> FloatArray:
    return np.asarray(np.round(counts) / 10.0)
