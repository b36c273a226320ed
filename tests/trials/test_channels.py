"""Channels are signals with their own unit, sensitivity and tare; what contradicts the file is an error."""

import numpy as np
import pytest

from ropefric.trials.campaign import check_campaign
from ropefric.trials.extract import check_recordings
from tests.trials.test_slack_tension import recording

PULL, END = 20.0 * np.exp(0.2 * np.pi), 20.0
TARE = '[tare]\ninterval = ["0 s", "0.25 s"]\n'


def two_channels(lab, settings, *, pull=(1.0, 0.0), end=(1.0, 0.0), names=("pull", "slack"), **cells):
    """Write a pull with a slack side that hangs free for 0.25 s: each channel by its scale and offset."""
    time_s, pull_N, end_N = recording(END, np.pi)
    idle = time_s < 0.28
    end_N = np.where(idle, end_N - np.interp(time_s, [0.0, 1.3], [0.7 * END, END]), end_N)
    columns = dict(zip(names, (pull_N * pull[0] + pull[1], end_N * end[0] + end[1]), strict=True))
    lab.record("p.csv", t=time_s, **columns)
    return lab.write([lab.row("p.csv", **cells)], settings)


def channels(force, end=""):
    end = f"end_tension = {{ {end} }}\n" if end else ""
    return f'[import.channels]\ntime = {{ column = "t", unit = "s" }}\nforce = {{ {force} }}\n{end}'


def forces(lab):
    trials = lab.extract().trials
    return [one.peak_N for one in trials], [one.end_tension_N for one in trials]


@pytest.mark.parametrize(
    ("settings", "pull", "end", "cells"),
    [
        (channels('column = "pull", unit = "N"', 'column = "slack", unit = "N"'), (1, 3), (1, 2), {}),
        (
            channels(
                'column = "pull", unit = "mV", sensitivity = "25 N/mV"',
                'column = "slack", unit = "mV", sensitivity = "40 mV/N"',
            ),
            (1 / 25, -7.5),
            (40, 12.5),
            {},
        ),
        (
            channels('column = "pull", unit = "V"', 'column = "slack", unit = "mV/V"')
            + '[cells.K1]\nfull_scale = "200 N"\nzero_voltage = "1 V"\n'
            + '[cells.K2]\nfull_scale = "100 N"\nrated_output = "2 mV/V"\n',
            (4 / 200, 1.05),
            (2 / 100, 0.04),
            {"cell": "K1", "end_cell": "K2"},
        ),
    ],
)
def test_every_channel_is_scaled_and_tared_alike(lab, settings, pull, end, cells):
    two_channels(lab, TARE + settings, pull=pull, end=end, **cells)
    assert not [one for one in check_campaign(lab.path) if one.severity == "error"]
    peaks_N, ends_N = forces(lab)
    assert peaks_N == pytest.approx([PULL], rel=5e-3)
    assert ends_N == pytest.approx([END], abs=0.1)


def test_a_channel_may_have_its_own_tare_or_none(lab):
    newtons = channels('column = "pull", unit = "N"', 'column = "slack", unit = "N", tare = "none"')
    two_channels(lab, TARE + newtons, pull=(1, 3), end=(1, 2))
    peaks_N, ends_N = forces(lab)
    assert (peaks_N, ends_N) == (pytest.approx([PULL], rel=5e-3), pytest.approx([END + 2], abs=0.1))
    own = newtons.replace('"none"', '["0.05 s", "0.2 s"]')
    two_channels(lab, own, pull=(1, 3), end=(1, 2))
    assert forces(lab)[1] == pytest.approx([END], abs=0.1)


def test_a_slack_side_that_was_loaded_in_the_tare_interval_is_told(lab):
    time_s, pull_N, end_N = recording(END, np.pi)
    lab.record("a.csv", t=time_s, pull=pull_N, slack=np.where(time_s < 1.3, END, end_N))
    settings = TARE + channels('column = "pull", unit = "N"', 'column = "slack", unit = "N"')
    (trial,) = lab.write([lab.row("a.csv")], settings).extract().trials
    assert (trial.breakaway.status, 'tare = "none"' in trial.problems[-1].fix) == ("unreadable", True)


def test_millivolts_without_their_meaning_are_an_error_that_says_how_to_write_it(lab):
    two_channels(lab, channels('column = "pull", unit = "mV"'))
    (error,) = (one for one in check_campaign(lab.path) if one.severity == "error")
    assert 'sensitivity = "25 N/mV"' in error.fix
    two_channels(lab, channels('column = "pull", unit = "mV"') + '[cells.K1]\nfull_scale = "100 N"\n')
    assert "cell" in {one.key for one in check_campaign(lab.path) if one.severity == "error"}


@pytest.mark.parametrize(("name", "unit"), [("Kraft [mV]", "mV"), ("force_kN", "kN"), ("Load (kg)", "kg")])
def test_a_unit_against_the_header_is_an_error_of_check_that_shows_both(lab, name, unit):
    newtons = f'column = "{name}", unit = "N"'
    two_channels(lab, channels(newtons), names=(name, "slack"))
    _, problems = check_recordings(lab.load())
    (error,) = (one for one in problems if one.severity == "error")
    assert f"the profile says N, the file {unit}" in error.message
    assert not any(one.kept for one in lab.extract().trials)
    two_channels(lab, channels(f'{newtons}, instead_of = "{unit}"'), names=(name, "slack"))
    assert forces(lab)[0] == pytest.approx([PULL], rel=5e-3)


def test_a_mass_in_the_header_may_be_read_as_its_weight(lab):
    two_channels(
        lab,
        channels('column = "Load (kg)", unit = "kgf"'),
        names=("Load (kg)", "slack"),
        pull=(1 / 9.80665, 0),
    )
    assert forces(lab)[0] == pytest.approx([PULL], rel=5e-3)


@pytest.mark.parametrize("cells", [{}, {"cell": "K1"}])
def test_a_force_beyond_the_full_scale_of_its_cell_is_an_error_of_check(lab, cells):
    settings = channels('column = "pull", unit = "kN"') + '[cells.K1]\nfull_scale = "1 kN"\n'
    two_channels(lab, settings, **cells)
    _, (error,) = check_recordings(lab.load())
    assert (error.code, error.severity) == ("RF204", "error")
    assert "3.75e+04 N" in error.message
    assert "1000 N" in error.message


def test_the_cell_of_the_other_side_says_nothing_of_a_force(lab):
    settings = channels('column = "pull", unit = "N"', 'column = "slack", unit = "V"')
    settings += '[cells.K2]\nfull_scale = "25 N"\n'
    two_channels(lab, settings, end=(5 / 25, 0.0), end_cell="K2")
    assert forces(lab)[0] == pytest.approx([PULL], rel=5e-3)


def test_three_readings_of_a_slow_sensor_are_a_tare(lab):
    time_s = np.arange(0.0, 12.0, 0.1)
    pull_N = np.interp(time_s, [0, 1, 9, 9.1, 12], [0, 0, PULL, 0.8 * PULL, 0.8 * PULL])
    lab.record(
        "a.csv", t=time_s, pull=pull_N + 3.0 + 0.02 * np.random.default_rng(4).standard_normal(time_s.size)
    )
    settings = '[tare]\ninterval = ["0 s", "0.3 s"]\n' + channels('column = "pull", unit = "N"')
    (trial,) = lab.write([lab.row("a.csv")], settings).extract().trials
    assert trial.tare_N == pytest.approx(3.0, abs=0.05)
