"""`import ropefric as rf`: the names, their signatures, that they load late, and that they work together."""

import ast
import inspect
import json
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pint
import pytest

import ropefric as rf
from ropefric.errors import DataError, InputError, UnknownNameError
from ropefric.fitting.next_tests import planned_guess
from ropefric.fitting.resolution import MeanScatter
from ropefric.friction.laws import LAWS
from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.traces.trace import ForceTrace

ROOT = Path(__file__).parents[1]
TRIALS = ROOT / "fits" / "prth-trials.csv"
COUPLED = ROOT / "fits" / "prth-coupled.json"
HOIST = ROOT / "data" / "scenes" / "hoist.toml"

WHEEL = "wheel_radius_m=None, wrap_angle_rad=None, end_tension_N=None, rope_radius_m=None"
SIGNATURES = {
    "accuracy_table": "(study='', case='', *, method='', timed=False)",
    "budget": f"(fit, *, {WHEEL}, u_wheel_radius_m=None, u_rope_radius_m=None, u_wrap_angle_rad=None, "
    "u_end_tension_N=None, one_pull=False, level=0.95, draws=200000, seed=0, **named)",
    "compare": "(trials, laws=None, *, progress=None, of='peak', columns=None)",
    "design": f"(fit, *, lift_N=None, solve_for='wrap', {WHEEL}, probability=0.95, **named)",
    "diagnose": "(trials, comparison=None, *, columns=None)",
    "explain": "(scene, *, measure=False)",
    "extract": "(campaign, *, jobs=1, progress=None, executor=None)",
    "find_breakaway": "(trace, force_N=None, *, sampling_rate=None, tare=None, rest='unknown', columns=None, "
    "window_s=None, start_s=None, stop_s=None, min_step_N=None, ending='sliding', pick_s=None)",
    "fit": "(trials, law, *, fixed=None, bounds=None, start=None, groups=None, shared=None, n_starts=4, "
    "seed=0, intervals='auto', of='peak', columns=None)",
    "lmfit_model": "(law)",
    "load_campaign": "(path, *, missing_recordings='error')",
    "load_fit": "(path)",
    "load_plugin": "(source, called='')",
    "load_scene": "(path, changes=None)",
    "monte_carlo": "(scene, *, draws=10000, seed=0, level=0.95, progress=None, table=None, executor=None)",
    "plan_tests": f"(known, *, wheels_m=None, wraps_rad=None, end_tensions_N=None, {WHEEL}, largest_force_N=None, "
    "n_conditions=12, repeats=12, level=0.95, **named)",
    "predict": f"(fit, wheels=None, *, {WHEEL}, level=0.95, method='auto', linear_density_kg_m=None, speed_m_s=None, "
    "rope=None, columns=None, **named)",
    "read_trace": "(path, profile=None, *, sample='', calibration=None)",
    "read_trial": "(campaign, trial)",
    "reject": "(values, rule='two-sigma')",
    "run": "(campaign, folder, *, law='', jobs=1, overwrite=False, executor=None)",
    "save_fit": "(fit, path, *, overwrite=False)",
    "smooth": "(trace, window_s=None, *, columns=None)",
    "solve": "(scene, *, level=0.95)",
    "sweep": "(scene, *axes, progress=None, table=None, executor=None)",
    "trial_table": "(trials, *, columns=None)",
    "write_scenes": "(folder, names=(), *, overwrite=False)",
}


CLASSES = ["RopefricError", "RopefricWarning"]


def bare(function):
    """Return the signature without annotations."""
    signature = inspect.signature(function)
    plain = [one.replace(annotation=inspect.Parameter.empty) for one in signature.parameters.values()]
    return str(inspect.Signature(plain))


def test_the_public_names_and_signatures_are_these_and_documented():
    assert {name: bare(getattr(rf, name)) for name in dir(rf) if name in SIGNATURES} == SIGNATURES
    assert (rf.__all__, dir(rf)) == (["__version__", *CLASSES, *SIGNATURES], sorted(rf.__all__))
    for name in SIGNATURES:
        assert inspect.getdoc(getattr(rf, name)).startswith(("Load ", "Return ", "Write "))
    # Editors are told the same.
    stub = ast.parse((ROOT / "ropefric" / "__init__.pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    assert {alias.asname: node.module for node in imports for alias in node.names} == rf._WHERE
    assert sorted(rf._WHERE) == [*CLASSES, *SIGNATURES]


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """Every sixth of the trials, in a file."""
    rows = TRIALS.read_text(encoding="utf-8").splitlines(keepends=True)
    path = tmp_path_factory.mktemp("few") / "few.csv"
    path.write_text("".join([rows[0], *rows[1::6]]), encoding="utf-8")
    return path


def test_a_clean_process_loads_names_late_and_predicts_the_same_to_the_last_digit():
    code = ("import sys, ropefric as rf\nassert 'numpy' not in sys.modules\n"
        "rf.read_trace, rf.reject, rf.extract, rf.load_scene, rf.solve, rf.explain, rf.sweep, rf.budget\n"
        "heavy = {'pandas', 'lmfit', 'matplotlib', 'typer'} & set(sys.modules)\n"
        "assert not heavy, heavy\n")  # fmt: skip
    asked = (
        f"fit = rf.load_fit({str(COUPLED)!r})\n"
        "found = rf.predict(fit, wheel_radius_m=0.05, wrap_angle_rad=8.25, end_tension_N=77.7)\n"
        "told = repr([found.lift_force_N.tolist(), found.interval_N.tolist(), fit.covariance.tolist()])\n"
    )
    here = {"rf": rf}
    exec(asked, here)  # noqa: S102  (the very lines that the other process runs)
    command = [sys.executable, "-c", f"{code}{asked}print(told)"]
    done = subprocess.run(command, check=True, cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.strip() == here["told"]


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'fti'"):
        _ = rf.fti


def test_all_kinds_of_tables_are_one(few):
    from_path, frame = rf.trial_table(few), pd.read_csv(few)
    before = frame.copy()
    for table in (rf.trial_table(str(few)), rf.trial_table(frame), rf.trial_table(from_path.to_frame())):
        assert table.trial == from_path.trial
        np.testing.assert_array_equal(table.used, from_path.used)
        np.testing.assert_array_equal(table.peak_N, from_path.peak_N)
    pd.testing.assert_frame_equal(frame, before)
    assert rf.trial_table(from_path) is from_path
    assert len({rf.fit(table, "constant")["mu"].value for table in (few, frame, from_path)}) == 1
    with pytest.raises(InputError, match="list is no trial table"):
        rf.trial_table([1, 2])


def test_an_extraction_is_a_table(tmp_path):
    plan = replace(prth_bench_plan(), conditions=prth_bench_plan().conditions[:2], repeats=4, faults={})
    simulate_campaign(tmp_path, plan, seed=5)
    campaign = rf.load_campaign(tmp_path / "campaign.toml")
    extraction = rf.extract(campaign)
    table = rf.trial_table(extraction)
    assert table.trial == tuple(trial.trial for trial in extraction.trials)
    assert table.peak_N.tolist() == [trial.peak_N for trial in extraction.trials]
    fit = rf.fit(extraction, "constant")
    assert fit.statistics.n == 8
    trace = rf.read_trial(campaign, "c01-r02")
    assert rf.find_breakaway(trace).peak_N == pytest.approx(extraction.trials[1].peak_N, rel=1e-12)
    assert rf.smooth(trace).window_s == pytest.approx(extraction.trials[1].breakaway.window_s, rel=0.01)
    with pytest.raises(InputError, match="no trial 'c99'"):
        rf.read_trial(campaign, "c99")


def test_a_fit_goes_into_a_file_and_predicts_the_same(tmp_path):
    fit = rf.fit(TRIALS, "coupled", intervals="profile")
    path = rf.save_fit(fit, tmp_path / "fit.json")
    wheels = {"wheel_radius_m": [0.02, 0.05], "wrap_angle_rad": 7.0, "end_tension_N": [20.0, 90.0]}
    made, stored = rf.predict(fit, **wheels), rf.predict(path, **wheels)
    np.testing.assert_array_equal(made.lift_force_N, stored.lift_force_N)
    np.testing.assert_array_equal(made.interval_N, stored.interval_N)
    needed = rf.design(path, lift_N=made.lift_force_N, probability=None, wheel_radius_m=[0.02, 0.05],
                       end_tension_N=[20.0, 90.0])  # fmt: skip
    np.testing.assert_allclose(needed.value, 7.0, rtol=1e-9)


def test_what_is_not_there_or_not_one_is_told():
    with pytest.raises(UnknownNameError, match="unknown parameter 'mu_in' Fix: did you mean 'mu_inf'"):
        rf.load_fit(COUPLED)["mu_in"]
    with pytest.raises(InputError, match="wheel_radius_m: 2 values where one is meant"):
        rf.budget(COUPLED, wheel_radius_m=[0.03, 0.04], wrap_angle_rad=6.98, end_tension_N=60.0)
    flat = ForceTrace(time_s=np.arange(500) / 1000, force_N=np.zeros(500))
    with pytest.raises(InputError, match="no window can be chosen"):
        rf.smooth(flat)
    assert rf.smooth(flat, 0.01).force_N.tolist() == [0.0] * 500


def test_settings_come_in_any_unit_under_the_names_of_a_table():
    fit = rf.load_fit(COUPLED)
    radius = (
        {"wheel_radius_m": 0.035},
        {"wheel_radius_mm": 35},
        {"wheel_radius": "35 mm"},
        {"wheel_diameter_mm": 70},
    )
    for own, wrap in zip(radius, ("wrap_angle", "wrap"), strict=False):
        lift_N = rf.predict(fit, **own, **{wrap: "400 deg"}, end_tension_kN=0.06).lift_force_N
        assert lift_N == pytest.approx(168.8, abs=0.05)
    for own in radius:
        wheel = own | {"wrap_deg": 400, "end_tension_N": 60}
        assert fit.predict(**wheel).lift_force_N == pytest.approx(168.8, abs=0.05)
        needed = rf.design(fit, lift="168.8 N", **own, end_tension="60 N", probability=None)
        assert np.degrees(needed.value) == pytest.approx(400, abs=0.5)
    exact, loose = (rf.budget(fit, **wheel, **u, draws=10_000).budget for u in ({}, {"u_wrap": "2 deg"}))
    assert exact.estimate == loose.estimate
    assert exact.combined < loose.combined
    running = fit.predict(**wheel, linear_density="62 g/m", speed_m_s=2.0)
    assert running.lift_force_N != fit.predict(**wheel).lift_force_N
    for wrong, error, words in (
        ({"wheel_radius": 0.035}, InputError, 'wheel_radius does not say its unit Fix: write wheel_radius="… mm"'),
        ({"wheel_radius_m": 0.035, "wheel_diameter_mm": 70}, InputError, "both give wheel_radius_m"),
        ({"wheel_radius_N": 3}, InputError, "wheel_radius_N: 'N' is not a unit of"),
        ({"wheel_radios_m": 3}, UnknownNameError, "no argument wheel_radios_m Fix: did you mean 'wheel_radius_m'"),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            fit.predict(**wrong, wrap_deg=400, end_tension_N=60)


def test_a_fit_has_its_parameters_by_name():
    fit = rf.load_fit(COUPLED)
    assert list(fit.params) == ["mu_inf", "a", "b", "c", "d"]
    assert fit.params["mu_inf"] is fit["mu_inf"]


def test_comparison_and_diagnosis_fit_together(few):
    comparison = rf.compare(few, ["coupled", "constant"])
    lines = str(comparison).splitlines()
    assert [line.split()[0] for line in lines[-4:]] == [entry.law for entry in comparison.ranking]
    assert lines[-4].endswith(comparison.best.status)
    assert (comparison.best.law, rf.diagnose(few, comparison)["wrap effect"].supported) == ("coupled", "yes")


def test_side_by_side_recordings_need_a_name(tmp_path):
    path = tmp_path / "wide.csv"
    path.write_text("A,,B,\ntime_s,force_N,time_s,force_N\n0,1,0,2\n1,2,1,3\n2,3,2,4\n", encoding="utf-8")
    profile = ImportProfile(separator=",", header_row=2, data_row=3, block_names_row=1, block_columns=2,
        channels={"time": Channel(column="time_s"), "force": Channel(column="force_N")})  # fmt: skip
    assert rf.read_trace(path, profile, sample="B").force_N.tolist() == [2.0, 3.0, 4.0]
    with pytest.raises(DataError, match="names 2 of them"):
        rf.read_trace(path, profile)


def test_a_scene_is_solved_explained_and_swept_from_its_file_or_loaded():
    scene = rf.load_scene(HOIST)
    solved, loaded = rf.solve(HOIST), rf.solve(scene)
    assert (solved.to_dict(), rf.explain(scene).plan.simulated) == (loaded.to_dict(), solved.plan.simulated)
    found = rf.sweep(scene, "wheel.radius=40mm,20mm", "wheel.wrap=540deg,720deg")
    assert found.shape == (2, 2)
    lift_N = found.columns["lift_force_N"]
    assert lift_N[0] == pytest.approx(solved.to_dict()["lift_force_N"], rel=1e-12)
    again = rf.sweep(str(HOIST), *found.axes)
    np.testing.assert_array_equal(again.columns["lift_force_N"], lift_N)
    with pytest.raises(InputError, match="at least one key"):
        rf.sweep(scene)
    with pytest.raises(UnknownNameError, match="did you mean"):
        rf.sweep(scene, "wheel.warp=1turn,2turn")


def test_a_budget_of_exact_settings_is_the_standard_error_of_the_prediction():
    wheel = {"wheel_radius_m": 0.035, "wrap_angle_rad": 7.0, "end_tension_N": 60.0}
    predicted = rf.predict(COUPLED, **wheel)
    exact = rf.budget(COUPLED, **wheel, draws=20_000)
    assert exact.budget.estimate == pytest.approx(predicted.lift_force_N[0], rel=1e-12)
    assert exact.budget.combined == pytest.approx(predicted.std_N[0], rel=1e-6)
    # F_A is not far from proportional to F_B, so 1 % of F_B is worth about 1 % of F_A: far more than the law.
    loose = rf.budget(COUPLED, **wheel, u_end_tension_N=0.6, draws=20_000)
    assert max(loose.budget.lines, key=lambda line: line.share).name == "end tension"
    rope = np.sqrt(np.maximum(rf.load_fit(COUPLED).scatter.variance, 0.0).sum()) * predicted.lift_force_N[0]
    one_pull = rf.budget(COUPLED, **wheel, one_pull=True, draws=20_000)
    assert one_pull.budget.combined == pytest.approx(np.hypot(predicted.std_N[0], rope), rel=1e-6)


def test_tests_are_planned_from_a_fit():
    rig = {"wheels_m": [0.015, 0.06], "wraps_rad": [3.0, 6.0, 12.0, 18.0], "end_tensions_N": [5.0, 50.0]}
    wanted = {"wheel_radius_m": 0.1, "wrap_angle_rad": 12.0, "end_tension_N": 80.0}
    plan = rf.plan_tests(COUPLED, **rig, **wanted, largest_force_N=800.0, n_conditions=4, repeats=6)
    assert len(plan) == 4
    assert plan.after.std_log[0] < plan.before.std_log[0]
    guessed = planned_guess(LAWS["constant"], {"mu": 0.2}, MeanScatter(within=0.02))
    with pytest.raises(InputError, match="does not know its rope"):
        rf.plan_tests(guessed, **rig, **wanted)


def test_tables_of_any_form_with_names_and_units_of_ones_own(tmp_path):
    """A frame with a lab's headers, columns by name, an array and quantities all give the same trials."""
    unit = pint.UnitRegistry()
    forces, wraps_deg = np.array([36.6, 66.1, 121.7]), np.degrees([3.0, 6.0, 9.0]).tolist()
    lab = pd.DataFrame({"D [cm]": 8.0, "d [mm]": 10.0, "Winkel": wraps_deg, "F0": 20.0,
        "F [kN]": forces / 1e3})  # fmt: skip
    names = {"D [cm]": "wheel_diameter [cm]", "d [mm]": "rope_diameter_mm", "Winkel": "wrap_deg", "F0": "end_tension_N",
             "F [kN]": "peak_kN"}  # fmt: skip
    columns = {"wheel_radius": ["4 cm"] * 3, "rope_diameter": "10 mm", "wrap": [f"{one!r} deg" for one in wraps_deg],
               "end_tension": 20.0 * unit.newton, "peak": unit.Quantity(forces / 1e3, "kN")}  # fmt: skip
    texts = columns | {"end_tension": "20 N", "peak": [f"{f!r} N" for f in forces.tolist()]}
    array = np.column_stack([np.full(3, 0.04), np.full(3, 0.005), wraps_deg, np.full(3, 20.0), forces])
    heads = ["wheel_radius_m", "rope_radius_m", "wrap_angle_deg", "end_tension_N", "peak_N"]
    path = tmp_path / "lab.csv"
    lab.to_csv(path, index=False)
    last = rf.trial_table(array, columns=heads)
    for table in (rf.trial_table(lab, columns=names), rf.trial_table(columns), rf.trial_table(pd.DataFrame(texts)),
                  rf.trial_table(path, columns=names)):  # fmt: skip
        for name in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N"):
            np.testing.assert_allclose(getattr(table, name), getattr(last, name), rtol=1e-14)
    mu = rf.fit(array, "constant", columns=heads)["mu"].value
    assert rf.fit(lab, "constant", columns=names)["mu"].value == pytest.approx(mu, rel=1e-12)
    for given, named, error, words in (
        (lab, {"F [KN]": "peak_kN"}, UnknownNameError, r"no column 'F \[KN\]'.*did you mean 'F \[kN\]'"),
        (path, {"F": "peak_kN"}, UnknownNameError, "no column 'F'"), (path, heads, InputError, "a file have names"),
        (last, names, InputError, "columns of a TrialTable"),
        ({"wheel_radius_m": [1.0, 2.0], "peak_N": [1.0, 2.0, 3.0]}, None, InputError, "this is no table"),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            rf.trial_table(given, columns=named)
    with pytest.raises(InputError, match="cannot be given in N") as refused:
        rf.trial_table(columns | {"peak": unit.Quantity(forces, "m")})
    assert str(refused.value).count("peak") == 1


def test_a_recording_of_any_form_gives_the_same_break_away():
    time_s, force_N = PULL_S, PULL_N
    lab = pd.DataFrame({"Zeit": time_s, "F": force_N})
    found = [rf.find_breakaway(ForceTrace(time_s=time_s, force_N=force_N)),
        rf.find_breakaway(time_s, force_N), rf.find_breakaway(time_s.tolist(), force_N.tolist()),
        rf.find_breakaway({"t_s": time_s, "load [N]": force_N}),
        rf.find_breakaway(lab, columns={"Zeit": "time_s", "F": "force_N"})]  # fmt: skip
    assert {one.peak_N for one in found} == {found[0].peak_N}
    smoothed = rf.smooth({"time_ms": 1e3 * time_s, "force_N": force_N}, 0.01)
    assert smoothed.window_s == pytest.approx(0.01, rel=0.1)
    with pytest.raises(InputError, match="no force column with its unit in time_s, kraft_N"):
        rf.find_breakaway({"time_s": time_s, "kraft_N": force_N})
    with pytest.raises(InputError, match="no time column with its unit in time"):
        rf.find_breakaway({"time": time_s, "force_N": force_N})
    for odd in (pd.to_timedelta(time_s, unit="s"), pd.to_datetime(time_s, unit="s").to_numpy(), time_s + 0j):
        with pytest.raises(InputError, match="is no number Fix: give numbers in s"):
            rf.find_breakaway(odd, force_N)


PULL_S = np.arange(2500) / 1000
PULL_N = np.interp(PULL_S, [0.3, 1.3, 1.32], [0, 100, 80]) + np.random.default_rng(5).normal(
    0.0, 0.05, PULL_S.size
)


def written(path):
    pd.DataFrame({"time_s": PULL_S, "force_N": PULL_N}).to_csv(path, index=False)
    return path


def test_a_recording_is_a_file_a_series_a_table_or_forces_at_a_rate(tmp_path):
    asked, path = rf.find_breakaway(PULL_S, PULL_N), written(tmp_path / "pull.csv")
    forces = pd.DataFrame({"force_kN": PULL_N / 1000})
    stamps = pd.Timestamp("2026-03-01 10:00") + pd.to_timedelta(PULL_S, unit="s")
    for found in (
        rf.find_breakaway(path), rf.find_breakaway(str(path)), rf.find_breakaway(pd.Series(PULL_N, index=PULL_S)),
        rf.find_breakaway(pd.Series(PULL_N / 1000, index=stamps, name="force_kN")),
        rf.find_breakaway(pd.Series(PULL_N, index=pd.to_timedelta(PULL_S, unit="s"))),
        rf.find_breakaway(PULL_N, sampling_rate=1000), rf.find_breakaway(PULL_N.tolist(), sampling_rate="1 kHz"),
        rf.find_breakaway(forces.set_index(pd.Index(PULL_S, name="time_s"))),
        rf.find_breakaway(forces, sampling_rate="1 kHz"),
        rf.find_breakaway(PULL_S, PULL_N, start_s="0 s", stop_s="2499 ms"),
    ):  # fmt: skip
        assert (found.peak_N, found.peak_time_s) == pytest.approx((asked.peak_N, asked.peak_time_s), rel=1e-9)
    for wrong, said in (
        ({"sampling_rate": 0.0}, "sampling_rate"), ({"sampling_rate": "1 N"}, "sampling_rate"),
        ({"sampling_rate": 1000.0, "force_N": PULL_N}, "either the times or a sampling rate"), ({}, "sampling_rate"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said):
            rf.find_breakaway(PULL_N, **wrong)
    with pytest.raises(DataError, match="no such file"):
        rf.find_breakaway(tmp_path / "other.csv")
    assert rf.smooth(path, "10 ms").window_s == rf.smooth(pd.Series(PULL_N, index=PULL_S), 0.01).window_s


def test_an_argument_that_a_recording_does_not_need_is_refused(tmp_path):
    """It was left aside, and a series without times counted seconds."""
    path = written(tmp_path / "pull.csv")
    trace = rf.read_trace(path)
    for given, others, name in (
        (path, {"force_N": PULL_N}, "force_N"), (path, {"sampling_rate": 10}, "sampling_rate"),
        (trace, {"columns": {"a": "force_N"}}, "columns"), (pd.Series(PULL_N), {}, "sampling_rate"),
        (PULL_N.tolist(), {}, "sampling_rate"), ((PULL_S, PULL_N), {}, "trace"), ([], {"force_N": []}, "trace"),
        (PULL_S, {"force_N": PULL_N[1:]}, "force_N"), (PULL_S, {"force_N": PULL_N, "tare": 1.0, "rest": "zero"}, "rest"),
    ):  # fmt: skip
        with pytest.raises(InputError) as refused:
            rf.find_breakaway(given, **others)
        assert refused.value.where == name
        assert str(refused.value).count(f"{name}: ") == 1
        assert refused.value.fix


def test_a_setting_that_is_none_is_not_given_and_a_row_of_a_table_is_one_wheel():
    one = {"wheel_radius_mm": 35, "wrap_deg": 400, "end_tension_N": 60}
    asked = rf.predict(COUPLED, **one)
    assert rf.predict(COUPLED, pd.DataFrame([one]).iloc[0]).lift_force_N == asked.lift_force_N
    assert rf.predict(COUPLED, **one, wheel_radius=None).lift_force_N == asked.lift_force_N
    with pytest.raises(InputError, match="no value for wheel_radius_m Fix"):
        rf.predict(COUPLED, wheel_radius=None, wrap_deg=400, end_tension_N=60)


def test_a_zero_is_taken_off_as_asked():
    off_N = PULL_N + 5.0
    for given in ({"tare": (0.0, 0.25)}, {"tare": 5.0}, {"tare": "5 N"}, {"rest": "zero"}):
        assert rf.find_breakaway(PULL_S, off_N, **given).peak_N == pytest.approx(100.0, abs=0.2)
    assert rf.find_breakaway(PULL_S, off_N, rest="pretension").peak_N == pytest.approx(105.0, abs=0.2)
    assert rf.find_breakaway(PULL_S, off_N).status == "doubtful"
    for wrong in ((0.5, 0.2), (7.0, 8.0), "soon", (0.1,)):
        with pytest.raises((InputError, DataError), match="tare"):
            rf.find_breakaway(PULL_S, off_N, tare=wrong)


def test_a_breakaway_is_a_dictionary_and_draws_itself_with_its_recording():
    found = rf.find_breakaway(PULL_S, PULL_N)
    told = found.to_dict()
    assert json.loads(json.dumps(told)) == told
    assert (told["status"], told["peak_N"], told["recurrence_s"]) == ("ok", found.peak_N, None)
    assert told["phases"][0] == {"name": "idle", "start_s": 0.0, "end_s": pytest.approx(0.3, abs=0.05)}
    assert found.to_frame()["peak_N"].tolist() == [found.peak_N]
    assert found.plot().lines[0].get_ydata().size == PULL_N.size
    axes = found.plot({"time_s": PULL_S, "force_N": PULL_N})
    assert axes.get_ylabel() == "Force [N]"
    assert axes._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(InputError, match=r"found\.plot\(trace\)"):
        replace(found, trace=None).plot()


def test_arrays_are_mended_as_files_are_and_told():
    asked = rf.find_breakaway(PULL_S, PULL_N)
    twice = np.repeat(np.arange(PULL_S.size), np.where(np.arange(PULL_S.size) % 100 == 7, 2, 1))
    doubled, turned = rf.find_breakaway(PULL_S[twice], PULL_N[twice]), rf.find_breakaway(PULL_S, -PULL_N)
    assert (doubled.peak_N, turned.peak_N) == pytest.approx((asked.peak_N, asked.peak_N), rel=1e-9)
    assert "written twice" in doubled.notes[0]
    assert "reversed" in turned.notes[0]


def test_settings_of_any_form_and_a_warning_of_degrees_and_millimetres():
    wheel = {"wheel_radius_m": 0.035, "end_tension_N": 80.0}
    bare = rf.predict(COUPLED, **wheel, wrap_angle_rad=np.radians([400.0, 500.0]))
    wraps = ["400 deg", "500 deg"]
    united = rf.predict(COUPLED, wheel_radius_m="35 mm", wrap_angle_rad=wraps, end_tension_N="0.08 kN")
    frame = pd.DataFrame({"wheel_diameter_mm": 70.0, "wrap_deg": [400.0, 500.0], "F0": 80.0})
    for one in (united, rf.predict(COUPLED, frame, columns={"F0": "end_tension_N"})):
        np.testing.assert_allclose(one.lift_force_N, bare.lift_force_N, rtol=1e-13)
    found = rf.design(COUPLED, lift_N="0.9 kN", wheel_radius_m="4 cm", end_tension_N=80).value
    same = rf.design(COUPLED, lift_N=900.0, wheel_radius_m=0.04, end_tension_N=80.0).value
    assert found == pytest.approx(same, rel=1e-13)
    with pytest.raises(InputError, match="no value for wrap_angle_rad"):
        rf.predict(COUPLED, **wheel)
    with pytest.raises(InputError, match="does not say its unit"):
        rf.predict(COUPLED, {"wheel_radius": [35.0], "wrap_deg": [400.0], "end_tension_N": [80.0]})
    words = 'wrap_angle_rad: 400 rad is a wrap of 63.7 turns. Fix: .* "400 deg"'
    with pytest.warns(rf.RopefricWarning, match=words) as said:
        rf.predict(COUPLED, **wheel, wrap_angle_rad=400)
    assert said[0].filename == __file__
    with pytest.warns(rf.RopefricWarning, match=r'35 m is a wheel of 70 m diameter. Fix: .* "35 mm"'):
        rf.predict(COUPLED, wheel_radius_m=35, wrap_angle_rad=7.0, end_tension_N=80)
    with pytest.warns(rf.RopefricWarning, match="a wrap of 172 turns"):
        rf.trial_table({"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": [180, 360, 1080.0],
                        "end_tension_N": 20, "peak_N": [36.6, 66.1, 121.7]})  # fmt: skip


def test_training_without_its_extra_names_the_extra(monkeypatch):
    """In an environment that has only what `pip install ropefric` brings, `--help` ends with the fix."""
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "ropefric.training", raising=False)
    for run_name, kind in (("__main__", SystemExit), ("ropefric.training", ModuleNotFoundError)):
        with pytest.raises(kind, match=r"pip install 'ropefric\[train\]'"):
            runpy.run_module("ropefric.training", run_name=run_name)
