"""Recordings that others made, as whole campaigns: what their sources know about them must come out."""

import csv
import json
import math

import numpy as np
import pytest

from ropefric.cli.app import main
from ropefric.traces.breakaway import Status

MECMESIN_PEAKS_N = [7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]
MECMESIN_IMPORT = ('\n[import]\nheader_row = 1\nunits_row = 2\nblock_names_row = 3\ndata_row = 5\n'
    'block_columns = 4\n[import.channels]\ntime = "Time"\nforce = "Force"\n')  # fmt: skip
SEAL_CHANNELS = ('\n[import]\nheader_row = 0\nseparator = "tab"\n[import.channels]\n'
    'time = { column = 1, unit = "ms" }\n')  # fmt: skip
WITH_PEAK = ("KDN_1bar", "KDN_3bar", "KDN_5bar", "KDN_7bar", "NAPN_1bar", "PK_3bar")
WITH_PEAK += ("X-ring257_1bar", "X-ring257_3bar")
WITHOUT_PEAK = ("O-ring257_1bar", "O-ring257_3bar", "PK_1bar", "NAPN_3bar")
RAW_STEPS_N = {"KDN_3bar": 13.7, "X-ring257_3bar": 10.5, "NAPN_1bar": 9.2}
WEIGHT_N = 7.8816
MU_TOLERANCE = 0.012


def one(extraction):
    (trial,) = extraction.trials
    return trial


# --- mecmesin_wide -------------------------------------------------------------------------------------------------


def mecmesin(lab, real_data, smoothing, samples=("*",)):
    rows = [lab.row("example_forces_big.csv", trial=f"pull{place}", sample=sample, end_tension_N=1)
        for place, sample in enumerate(samples)]  # fmt: skip
    settings = f'[protocol]\nending = "separation"\n[smoothing]\nwindow = "{smoothing}"\n{MECMESIN_IMPORT}'
    return lab.write(rows, settings, data=(real_data / "mecmesin_wide").as_posix()).extract()


def test_ten_wide_recordings_and_the_one_that_two_sigma_sets_aside(lab, real_data):
    extraction = mecmesin(lab, real_data, "none")
    peaks_N = [trial.peak_N for trial in extraction.trials]
    assert [trial.trial for trial in extraction.trials] == [f"pull0#Sample {i}" for i in range(1, 11)]
    assert {trial.breakaway.status for trial in extraction.trials} == {Status.OK}
    assert peaks_N == pytest.approx(MECMESIN_PEAKS_N, rel=5e-3)
    assert [trial.kept for trial in extraction.trials] == [place != 4 for place in range(10)]
    assert extraction.trials[4].rejected_by == "two-sigma"
    (condition,) = extraction.conditions
    assert (condition.rejected, (condition.n, condition.n_kept)) == (("pull0#Sample 5",), (10, 9))
    assert (condition.mean_all_N, condition.std_all_N) == pytest.approx((7.813, 0.566), rel=5e-3)
    others = [peak for peak in MECMESIN_PEAKS_N if peak != 9.14]
    assert condition.mean_kept_N == pytest.approx(np.mean(others), rel=5e-3)


def test_named_blocks_give_what_all_blocks_give_and_one_that_is_not_there_is_told(lab, real_data):
    named = mecmesin(lab, real_data, "none", samples=["Sample 9", "Sample 1", "Sampel 2", ""])
    assert [trial.trial for trial in named.trials] == ["pull0", "pull1", "pull2", "pull3"]
    assert [trial.breakaway.status for trial in named.trials] == ["ok", "ok", "unreadable", "unreadable"]
    assert [trial.peak_N for trial in named.trials[:2]] == pytest.approx([8.27, 7.18], rel=5e-3)
    wrong, none = (trial.problems[0] for trial in named.trials[2:])
    assert (wrong.code, wrong.key) == (none.code, none.key) == ("RF123", "sample")
    assert "did you mean 'Sample 2'" in wrong.fix
    assert "'*'" in none.fix
    # Smoothing by itself takes little off a pull that tears.
    extraction = mecmesin(lab, real_data, "auto")
    assert [trial.peak_N for trial in extraction.trials] == pytest.approx(MECMESIN_PEAKS_N, rel=0.03)


# --- seal_breakaway ------------------------------------------------------------------------------------------------


def seal(lab, real_data, name, force, settings=""):
    rows = [lab.row(f"{name}.csv", end_tension_N=1)]
    text = f"{settings}\n{SEAL_CHANNELS}{force}"
    return one(lab.write(rows, text, data=(real_data / "seal_breakaway").as_posix()).extract())


def seal_friction(lab, real_data, name):
    """Derive the friction force: what pulls less what the pressure carries."""
    radius_m = 0.01285 if "257" in name else 0.0125
    area_m2 = math.pi * radius_m**2
    force = (
        f'pressure = {{ column = 6, unit = "bar" }}\npull = {{ column = 7, unit = "N" }}\n'
        f'[import.constants]\narea = "{area_m2!r} m^2"\n[import.derived]\nforce = "pull - pressure * area"\n'
    )
    table = np.loadtxt(real_data / "seal_breakaway" / f"{name}.csv", delimiter="\t")
    return seal(lab, real_data, name, force), table[:, 0] / 1000, table[:, 6] - table[:, 5] * 1e5 * area_m2


def test_a_seal_that_sticks_first_gives_its_static_peak_and_one_that_only_slides_no_number(lab, real_data):
    for name in WITH_PEAK:
        trial, time_s, force_N = seal_friction(lab, real_data, name)
        found = trial.breakaway
        assert found.status == "ok", (name, found.detail)  # a pull of 0.1 s at the beginning of 77 s
        assert found.peak_N == pytest.approx(force_N[time_s < 0.2].max(), rel=0.1), name
        assert found.peak_time_s < 0.2, name
    for name in WITHOUT_PEAK:
        trial, time_s, force_N = seal_friction(lab, real_data, name)
        assert trial.breakaway.status in {"no-peak", "doubtful"}, (name, trial.breakaway.detail)
        assert math.isnan(trial.peak_N), name
        assert trial.to_dict()["peak_N"] is None, name
        # What a bare maximum would have returned lies in the middle of a later stroke.
        assert time_s[np.argmax(force_N)] > 1, name


def test_the_steps_of_the_source_are_those_of_the_force_channel_alone(lab, real_data):
    """SOURCE.txt counts them from the raw channel 7, not from the friction force."""
    part = '[protocol]\nfrom = "0 s"\nuntil = "3 s"\n'
    for name, told_N in RAW_STEPS_N.items():
        table = np.loadtxt(real_data / "seal_breakaway" / f"{name}.csv", delimiter="\t")
        time_s, raw_N = table[:, 0] / 1000, table[:, 6]
        slides_N = raw_N[(time_s >= 1) & (time_s <= 3)].mean()
        assert raw_N[time_s < 0.5].max() - slides_N == pytest.approx(told_N, rel=0.02), name
        trial = seal(lab, real_data, name, 'force = { column = 7, unit = "N" }\n', part)
        found = trial.breakaway
        best_N = found.peak_N if found.status == "ok" else found.candidates[0].force_N
        assert best_N - slides_N == pytest.approx(told_N, rel=0.1), name
        assert found.status != "ok" or found.peak_N - found.kinetic_N == pytest.approx(told_N, rel=0.1), name


# --- phy_mini_ia_capstan -------------------------------------------------------------------------------------------


def capstan_table(real_data):
    with (real_data / "phy_mini_ia_capstan" / "per_trial.csv").open(encoding="utf-8") as stream:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(stream)]


def friction(trial):
    return math.log(trial.peak_N / trial.end_tension_N) / trial.wrap_angle_rad


def test_every_plateau_of_the_authors_comes_out_as_an_end_tension_under_a_known_weight(lab, real_data):
    authors = capstan_table(real_data)
    wraps_rad = {int(row["nominal_deg"]): row["wrap_rad_measured"] for row in authors}
    rows = [{"trial": f"wrap{degrees}", "file": f"force_{degrees}deg.csv",
        "wheel_radius_mm": 20.75} | {"wrap_angle_rad": wrap_rad, "lift_force_N": WEIGHT_N} for degrees,
        wrap_rad in wraps_rad.items()]  # fmt: skip
    settings = '[protocol]\nname = "held"\nside = "slack"\n'
    extraction = lab.write(rows, settings, data=(real_data / "phy_mini_ia_capstan").as_posix()).extract()
    numbers = [(degrees, i) for degrees in wraps_rad for i in range(1, 5 if degrees == 270 else 4)]
    assert [trial.trial for trial in extraction.trials] == [f"wrap{degrees}#{i}" for degrees, i in numbers]
    for row in authors:
        found = (t for t in extraction.trials if t.trial.startswith(f"wrap{int(row['nominal_deg'])}#"))
        nearest = min(found, key=lambda trial: abs(trial.end_tension_N - row["F_hold_mid_N"]))
        assert nearest.breakaway.status == "ok"
        assert abs(friction(nearest) - row["mu_capstan"]) < MU_TOLERANCE
        if (row["nominal_deg"], row["trial"]) == (315, 2):  # the authors' minimum lies outside the plateau
            assert row["F_hold_min_N"] < nearest.end_tension_N < row["F_hold_max_N"]
        else:
            assert nearest.end_tension_N == pytest.approx(row["F_hold_mid_N"], rel=0.01)
    for trial in extraction.trials:
        assert trial.measures_slack
        assert trial.peak_N == WEIGHT_N
        assert 0 < trial.end_tension_std_N < 0.05 * trial.end_tension_N
    assert len(extraction.conditions) == 7
    for condition in extraction.conditions:
        assert (condition.lift_force_N, condition.end_tension_N) == (WEIGHT_N, condition.mean_kept_N)


# --- rock_direct_shear ---------------------------------------------------------------------------------------------


def test_a_shifted_table_is_refused_and_the_run_says_that_nothing_is_left(lab, real_data, capfd):
    name = "TM11_Pc130_Pp50_T180_repeat_test.txt"
    lab.write([lab.row(name)], data=(real_data / "rock_direct_shear").as_posix())
    trial = one(lab.extract())
    assert trial.breakaway.status == "unreadable"
    (problem,) = trial.problems
    assert (problem.code, problem.path, problem.line) == ("RF103", name, 4)
    assert "20 values" in problem.message
    assert "names 19" in problem.message
    out = lab.folder / "out"
    assert main(["extract", str(lab.path), "--out", str(out), "--no-figures", "--json"]) == 3
    told = json.loads(capfd.readouterr().out)
    assert told["trials"][0]["status"] == "unreadable"
    assert told["trials"][0]["peak_N"] is None
    assert told["error"]["code"] == "RF301"
