"""Laws fitted to the kinetic force: the same table, another force, said in every answer."""

import json

import numpy as np
import pandas as pd
import pytest

import ropefric as rf
from ropefric.cli.app import main
from ropefric.errors import InputError, UnknownNameError

STATIC_MU, KINETIC_MU, END_N = 0.25, 0.18, 20.0


def frame(**columns):
    """Three wraps of four pulls each: a static and a kinetic coefficient, both with 0.5 % of scatter."""
    wrap_rad = np.repeat([2.0, 4.0, 6.0], 4)
    scatter = END_N * (1.0 + 0.005 * np.tile([-1.0, -1.0, 1.0, 1.0], 3))
    wheel = {"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad}
    forces = {"end_tension_N": END_N, "peak_N": np.exp(STATIC_MU * wrap_rad) * scatter}
    forces |= {"kinetic_N": np.exp(KINETIC_MU * wrap_rad) * scatter, "kinetic_mean_std_N": 0.1}
    return pd.DataFrame(wheel | forces | columns)


def test_the_kinetic_coefficient_comes_out_of_the_same_table():
    table = rf.trial_table(frame())
    assert rf.fit(table, "constant")["mu"].value == pytest.approx(STATIC_MU, rel=1e-3)
    found = rf.fit(table, "constant", of="kinetic")
    assert found["mu"].value == pytest.approx(KINETIC_MU, rel=1e-3)
    assert (found.of, rf.fit(table, "constant").of) == ("kinetic", "peak")
    wheel = {"wheel_radius_m": 0.04, "wrap_angle_rad": 3.0, "end_tension_N": 30.0}
    prediction = rf.predict(found, **wheel)
    assert prediction.lift_force_N[0] == pytest.approx(30.0 * np.exp(3.0 * KINETIC_MU), rel=1e-3)
    assert prediction.to_dict()["of"] == "kinetic"
    assert rf.predict(rf.fit(table, "constant"), **wheel).to_dict()["of"] == "peak"


def test_every_law_is_compared_on_the_kinetic_force():
    comparison = rf.compare(frame(), ["wrap-power"], of="kinetic")
    assert {entry.fit.of for entry in comparison.ranking if entry.fit is not None} == {"kinetic"}
    assert comparison["constant"].fit["mu"].value == pytest.approx(KINETIC_MU, rel=2e-3)


def test_trials_without_a_kinetic_force_are_left_out_and_counted():
    gaps = frame()
    gaps.loc[[0, 5], "kinetic_N"] = [np.nan, 10.0]
    table = rf.trial_table(gaps)
    kinetic = table.of("kinetic")
    assert (int(table.used.sum()), int(kinetic.used.sum())) == (12, 10)
    assert "2 trials left out: no kinetic force above the end tension" in kinetic.warnings[-1].message
    assert rf.fit(table, "constant", of="kinetic").statistics.n == 10


def test_a_column_that_a_fit_of_the_peak_does_not_need_may_hold_anything():
    odd = frame(kinetic_N="rough", kinetic_mean_std_N=-1.0, kinetic_force="high")
    assert rf.fit(odd, "constant")["mu"].value == pytest.approx(STATIC_MU, rel=1e-3)
    with pytest.raises(InputError, match="no trial that is used has a kinetic force"):
        rf.fit(odd, "constant", of="kinetic")


def test_a_table_without_kinetic_forces_or_an_unknown_force_is_refused():
    bare = frame().drop(columns=["kinetic_N", "kinetic_mean_std_N"])
    with pytest.raises(InputError, match="no trial that is used has a kinetic force"):
        rf.fit(bare, "constant", of="kinetic")
    with pytest.raises(UnknownNameError, match=r"of: unknown force 'kinetics' Fix: did you mean 'kinetic'\?"):
        rf.fit(frame(), "constant", of="kinetics")


def test_the_commands_fit_compare_predict_and_verify_a_kinetic_law(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    frame().to_csv("trials.csv", index=False)
    fit = ["fit", "trials.csv", "--law", "constant", "--of", "kinetic", "--out", "fits/kinetic.json"]
    main([*fit, "--json"])
    found = json.loads(capsys.readouterr().out)
    assert found["of"] == found["provenance"]["settings"]["of"] == "kinetic"
    assert found["parameters"]["mu"]["value"] == pytest.approx(KINETIC_MU, rel=1e-3)
    wheel = ["--wheel-radius", "40 mm", "--wrap", "3 rad", "--end-tension", "30 N"]
    main(["predict", "--fit", "fits/kinetic.json", *wheel])
    said = capsys.readouterr()
    assert all(one in said.out for one in ("Kinetic force", "F_A while sliding = "))
    assert "a law of the kinetic force" in said.err
    assert main(["verify", "fits"]) == 0
    capsys.readouterr()
    main(["compare", "trials.csv", "--laws", "wrap-power", "--of", "kinetic", "--json"])
    assert json.loads(capsys.readouterr().out)["of"] == "kinetic"
    assert main(["fit", "trials.csv", "--law", "constant", "--of", "sliding"]) == 3
    assert "unknown force 'sliding'" in capsys.readouterr().err
