"""What Wang and Jiang (2010) print, at the tolerance the print supports."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from paper import whole

from ropefric.systems.bandsaw.answer import frequencies_Hz, span_of
from ropefric.systems.bandsaw.saw import (
    STEEL_85_09,
    Side,
    tension_difference_N,
    torque_N_m,
)
from ropefric.systems.bandsaw.span import string_frequencies_Hz


def plain(saw):
    """Return the numbers of one saw."""
    names = ("free_span_m", "linear_density_kg_m", "preload_N", "wheel_radius_m", "wheel_speed_rad_s",
             "tension_difference_N", "speed_m_s")  # fmt: skip
    return SimpleNamespace(**{name: float(getattr(saw, name)[0]) for name in names})


def frequency_Hz(mode, free_span_m, wave_speed_m_s, speed_m_s=0.0):
    """Eq. (8)."""
    return mode * (wave_speed_m_s**2 - speed_m_s**2) / (2.0 * free_span_m * wave_speed_m_s)


T, S, R = Side.TIGHT, Side.SLACK, Side.REST
# f_1 unrounded; the tables' inertia tension acts whether or not the column regards the speed.
EXACT_HZ = {(1, R, False): 23.6307, (2, T, False): 23.9932, (2, S, False): 23.2626, (2, T, True): 18.8486,
            (2, S, True): 17.9564, (3, T, False): 26.4406, (3, S, False): 25.7795, (3, T, True): 21.7723,
            (3, S, True): 20.9914}  # fmt: skip


# Cells of the print that its own way of reckoning does not give: (table, side, runs, mode) -> what it gives.
MISPRINTS = {(2, S, False, 5): 116.5, (3, T, True, 5): 109.0}
MISPRINTS |= {(2, T, True, mode): round(18.8 * mode, 1) for mode in range(1, 7)}


def printed_frequencies_Hz(saw, table, side, runs, power_kW):
    """A column of a table as it was worked out on paper, with each rounding on the way [Hz].

    Table 1 cuts n f_1 off after the first decimal. Tables 2 and 3 have M by 9549, ΔF in full newtons, v cut off to
    35.5 m/s, c to a tenth, and multiply an f_1 of one decimal, cut off in the running columns of table 2.
    """
    saw, modes = plain(saw), np.arange(1.0, 7.0)
    if table == 1:
        wave_m_s = math.sqrt(saw.preload_N / saw.linear_density_kg_m)
        return np.floor(10.0 * frequency_Hz(modes, saw.free_span_m, wave_m_s)) / 10.0
    turns = round(saw.wheel_speed_rad_s * 30.0 / math.pi, 6)
    pull_N = round(9549.0 * power_kW / turns / saw.wheel_radius_m) / 2.0
    rim_m_s = 2.0 * 3.14 * round(turns / 60.0, 1) * saw.wheel_radius_m
    inertia_N = round(0.6 * rim_m_s**2) if table == 3 else 0.0
    tension_N = saw.preload_N + side.sign * pull_N + inertia_N
    wave_m_s = round(math.sqrt(tension_N / saw.linear_density_kg_m), 1)
    speed_m_s = math.floor(10.0 * saw.speed_m_s) / 10.0 if runs else 0.0
    first = float(frequency_Hz(1, saw.free_span_m, wave_m_s, speed_m_s))
    # On paper a half is rounded up, 23.25 to 23.3.
    tenths = math.floor(round(10.0 * first, 6) + (0.0 if table == 2 and runs else 0.5))
    return np.round(tenths * modes) / 10.0


def string_span(saw, table, side, runs):
    """One column's parts: the speed through the span is a part of its own."""
    span = span_of(whole(replace(saw, mounting_factor=1.0 if table == 3 else 0.0)), side)
    return replace(span, travel_speed_m_s=span.travel_speed_m_s if runs else 0.0)


def test_drive(machine, saw):
    saw = plain(saw)
    omega = machine["wheel_speed"] * math.pi / 30.0
    assert saw.speed_m_s == pytest.approx(35.552, abs=5e-4)
    assert saw.tension_difference_N == pytest.approx(210.95, abs=5e-3)
    unrounded = tension_difference_N(torque_N_m(7500.0, omega), 0.35)
    assert float(unrounded) / saw.tension_difference_N == pytest.approx(30000 / math.pi / 9549, rel=1e-14)
    assert saw.linear_density_kg_m * saw.speed_m_s**2 == pytest.approx(754.2, abs=0.05)
    # From 0.6 kg/m, 3.14 and 16.2 1/s the print has 761 N.
    assert pytest.approx(machine["inertia_tension"], abs=0.5) == 0.6 * (2 * 3.14 * 16.2 * 0.35) ** 2


def test_unrounded_first_frequencies_and_their_multiples(saw, columns):
    for column, first_Hz in EXACT_HZ.items():
        found = string_frequencies_Hz(string_span(saw, *column), 6)[0]
        assert found[0] == pytest.approx(first_Hz, abs=1e-4), column
        np.testing.assert_allclose(found, found[0] * np.arange(1, 7), rtol=1e-15)
        # The print rounds f_1 by up to 0.15 Hz on the way and multiplies that.
        assert np.abs(found - columns[column])[0] < 0.16, column


def test_printed_tables_come_out_digit_by_digit(saw, machine, columns):
    assert set(columns) == set(EXACT_HZ)
    for column, printed in columns.items():
        made = printed_frequencies_Hz(saw, *column, machine["power"])
        wanted = [MISPRINTS.get((*column, mode), one) for mode, one in enumerate(printed, start=1)]
        assert made.tolist() == wanted, column
        apart = {mode for mode in range(1, 7) if made[mode - 1] != printed[mode - 1]}
        assert apart == {mode for *known, mode in MISPRINTS if tuple(known) == column}, column


def test_what_the_unrounded_torque_factor_changes_is_below_the_last_printed_digit(saw):
    more = replace(saw, tension_difference_N=saw.tension_difference_N * 30000 / math.pi / 9549)
    change = frequencies_Hz(whole(more), T) / frequencies_Hz(whole(saw), T) - 1.0
    assert 0 < change.max() < 2e-6


def test_the_beam_of_a_likely_section(saw, stiffness):
    assert STEEL_85_09.linear_density_kg_m == pytest.approx(plain(saw).linear_density_kg_m, rel=1e-14)
    stiff = replace(saw, bending_stiffness_N_m2=stiffness, mounting_factor=1.0)
    e = math.sqrt(stiffness / (plain(saw).preload_N * plain(saw).free_span_m ** 2))
    assert e == pytest.approx(0.0110, abs=5e-5)
    assert frequencies_Hz(whole(stiff), T)[0, 0] == pytest.approx(22.28, abs=5e-3)
    assert frequencies_Hz(whole(stiff), S)[0, 0] == pytest.approx(21.50, abs=5e-3)
