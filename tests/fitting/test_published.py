"""The numbers in data/published are complete and hang together as their papers say."""

import math
from pathlib import Path

import pandas as pd
import pytest

FOLDER = Path(__file__).parents[2] / "data" / "published"


def values(name):
    return pd.read_csv(FOLDER / name).set_index("quantity")["value"]


def test_every_file_is_cited():
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    for path in FOLDER.glob("*.csv"):
        assert f"`{path.name}`" in readme
        assert not pd.read_csv(path).empty


def test_example_series_of_the_hoist_paper():
    prth = values("prth_experiment.csv")
    names = ["mean_lift_force", "std_lift_force", "mean_lift_force_kept"]
    assert prth[names].tolist() == [321.7, 5.5, 320.7]
    assert prth["std_lift_force"] / prth["mean_lift_force"] == pytest.approx(0.017, abs=0.0005)
    # One point beyond 2 s leaves a series of 10 to 15 by about (2…3) s/n.
    assert 0.5 < prth["mean_lift_force"] - prth["mean_lift_force_kept"] < 2 * prth["std_lift_force"]


def test_press_torques_are_those_of_one_squeeze():
    rollers = pd.read_csv(FOLDER / "belt_press_rollers.csv").set_index("roller")
    assert len(rollers) == 13
    assert rollers["wrap_angle_deg"].between(20, 180).all()
    # b R Δh K_max with Δh K_max = 84 N/m; roller 5 carries two units.
    units = (rollers["squeeze_torque_N_m"] / (2 * rollers["roller_radius_mm"] / 1000 * 84)).dropna()
    assert units.round(6).to_dict() == {5: 2.0, 6: 1.0, 7: 1.0, 8: 1.0, 9: 1.0}
    loads = (rollers[["gravity_torque_N_m", "squeeze_torque_N_m"]].sum(axis=1) / rollers["roller_radius_mm"] *
        1000)  # fmt: skip
    assert loads.sum() == pytest.approx(1826.667, abs=0.001)
    machine = values("belt_press_machine.csv")
    speed = math.pi * machine["driver_speed"] / 30 * 0.175
    assert speed == pytest.approx(0.916298, abs=1e-6)


def test_blade_frequencies_are_multiples_of_the_first_but_for_the_misprint():
    saw = pd.read_csv(FOLDER / "band_saw_frequencies.csv")
    assert len(saw) == 9 * 6
    for (table, side, state), series in saw.groupby(["table", "side", "state"]):
        first = series.loc[series["mode"] == 1, "frequency_Hz"].item()
        off = series[(series["frequency_Hz"] - first * series["mode"]).abs() > 0.051 * series["mode"]]
        if (table, side, state) == (3, "tight", "running"):
            assert (off["mode"].tolist(), off["remark"].item()) == ([5], "misprint for 109.0")
        else:
            assert off.empty, (table, side, state)


def test_blade_at_rest_is_the_string_of_the_machine_data():
    saw, machine = pd.read_csv(FOLDER / "band_saw_frequencies.csv"), values("band_saw_machine.csv")
    line = machine["density"] * machine["cross_section"]
    first = math.sqrt(machine["preload"] / line) / (2 * machine["free_span"])
    printed = saw.loc[saw["table"] == 1, "frequency_Hz"].tolist()
    assert [math.floor(10 * mode * first) / 10 for mode in range(1, 7)] == printed
