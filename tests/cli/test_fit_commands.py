"""`fit`, `show`, `compare`, `diagnose`, `predict`, `design`, `verify` on the stored trials and fits of the bench."""

import json
import math
import shlex
import shutil
from pathlib import Path

import pytest

from ropefric.cli.app import find_commands

ROOT = Path(__file__).parents[2]
TRIALS = ROOT / "fits" / "prth-trials.csv"
COUPLED = ROOT / "fits" / "prth-coupled.json"
CONSTANT = ROOT / "fits" / "prth-constant.json"
NOT_TRUSTED = 4
WHEEL = ("--wheel-radius", "35 mm", "--wrap", "400 deg", "--end-tension", "60 N")
RANKING_KEYS = {"law", "aicc", "delta_aicc", "weight", "bic", "status"}
PREDICT_KEYS = {"lift_force_N", "std_N", "interval_N", "level", "extrapolated", "method"}
HEADER = "wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N"
GOOD = tuple(f"40,10,{180 * turn},20,{20 * math.exp(0.6 * turn):.3f}" for turn in (1, 2, 3))


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(ROOT)


def table(path, header=HEADER, rows=()):
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    return path


def words_of(example):
    return [*shlex.split(example)[1:], "--quiet"]


def test_a_rope_of_the_trials_has_a_prediction_of_its_own(call, tmp_path):
    """Two ropes whose μ differ by a tenth, each at four wraps: the stronger one lifts more than the law says."""
    rows = []
    for k, wrap in enumerate((180, 270, 400, 540)):
        for rope, mu, sign in (("r1", 0.2, 1), ("r2", 0.22, -1)):
            peak_N = 20 * math.exp(mu * math.radians(wrap) + sign * 1e-3 * (-1) ** k)
            rows.append(f"40,10,{wrap},20,{peak_N:.4f},{rope}")
    trials, fit = table(tmp_path / "t.csv", f"{HEADER},rope_id", rows), tmp_path / "fit.json"
    call("fit", trials, "--law", "constant", "--out", fit)
    words = ("predict", "--fit", fit, "--wheel-radius", "40 mm", *WHEEL[2:5], "20 N", "--rope")
    found = call(*words, "r2", "--json").json()
    assert found["this_rope"]["rope"] == "r2"
    assert found["this_rope"]["lift_force_N"] == pytest.approx(
        20 * math.exp(0.22 * math.radians(400)), rel=0.003
    )
    assert found["lift_force_N"] < found["this_rope"]["interval_N"][0]
    assert "With rope r2" in call(*words, "r2").out
    assert "did you mean 'r2'" in call(*words, "r22").err


def test_the_examples_in_the_help_work(call, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "fits", tmp_path / "fits")
    monkeypatch.chdir(tmp_path)
    for name in ("fit", "show", "predict", "design"):
        example = find_commands()[name].example
        assert example.split()[1] in call(name, "--help").out.replace("\n", " ")
        done = call(*words_of(example))
        assert (done.code, done.err) == (0, ""), name
        assert done.out


# --- fit and show --------------------------------------------------------------------------------------------------


def test_a_fit_is_what_is_stored_and_told(call, tmp_path):
    done = call("fit", TRIALS, "--law", "coupled", "--out", tmp_path / "x.json", "--json")
    tree = done.json()
    assert (done.code, tree["schema"]) == (0, "ropefric.fit/1")
    stored = json.loads((tmp_path / "x.json").read_text(encoding="utf-8"))
    assert tree.keys() >= stored.keys()
    assert all(
        stored[name] == tree[name] for name in ("law", "parameters", "covariance", "statistics", "status")
    )
    assert stored["provenance"]["input"]["sha256"] == tree["provenance"]["input"]["sha256"]
    assert "wrote" in done.err
    told = call("fit", TRIALS, "--law", "coupled")
    assert told.code == 0
    for words in ("mu_inf", "0.460", "95 % interval", "coefficient of a very large wheel"):
        assert words in told.out
    assert "399 trials of 36 conditions" in told.out


def test_a_law_that_misses_an_effect_is_4_and_says_why(call):
    done = call("fit", TRIALS, "--law", "constant")
    assert done.code == NOT_TRUSTED
    assert all(one in done.out for one in ("residual-structure", "Compare laws with a size effect"))


def test_parameters_are_held_bounded_and_started(call):
    words = ("--fix", "d=0.055", "--bound", "c=-0.9:-0.1", "--start", "a=-0.3", "--intervals", "profile")
    tree = call("fit", TRIALS, "--law", "coupled", *words, "--json").json()
    assert (tree["parameters"]["d"]["value"], tree["parameters"]["d"]["vary"]) == (0.055, False)
    assert (tree["parameters"]["c"]["lower"], tree["parameters"]["c"]["upper"]) == (-0.9, -0.1)
    assert tree["provenance"]["intervals"] == {"method": "profile"}
    walled = call("fit", TRIALS, "--law", "coupled", "--bound", "d=0.1:0.3", "--json")
    assert (walled.code, walled.json()["parameters"]["d"]["at_bound"]) == (NOT_TRUSTED, True)


BAD_SETTINGS = {("--law", "copled"): (3, "did you mean 'coupled'?"),
    ("--law", "coupled", "--fix", "e=1"): (3, "no parameter 'e'"),
    ("--law", "coupled", "--fix", "d"): (2, "is not like mu=0.2"),
    ("--law", "coupled", "--bound", "d=1"): (2, "is not like d=0:0.2"),
    ("--law", "coupled", "--bound", "d=2:1"): (2, "is not like d=0:0.2"),
    ("--law", "coupled", "--bound", "d=0:1", "--bound", "d=0:2"): (2, "given twice"),
    ("--law", "constant", "--intervals", "profiel"): (3, "did you mean 'profile'?"),
    (): (2, "--law")}  # fmt: skip
BAD_TABLES = [("wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N", ("40,10,180,20",),
    "break-away force"), ("wheel_radius_mm,rope_diameter_mm,wrap_angle_mm,end_tension_N,peak_N", GOOD,
    "wrap_angle_mm"), (HEADER, (*GOOD, "40,10,180,80,60"), "is not above the end tension"),
    (HEADER, (*GOOD, "40,10,-180,20,60"), ":5"), (HEADER, (*GOOD, "40,10,180,NaN,60"), "empty or NaN"),
    (HEADER, GOOD[:1], "at least two"), (HEADER, (*GOOD, "40,10,180,20,sixty"), "sixty")]  # fmt: skip


def test_what_a_fit_cannot_follow_is_told(call, tmp_path):
    for words, (code, told) in BAD_SETTINGS.items():
        done = call("fit", TRIALS, *words)
        assert (done.code, done.out) == (code, ""), words
        assert told in done.err
        error = call("fit", TRIALS, *words, "--json").json()["error"]
        assert error.keys() >= {"code", "message", "where", "fix"}
    for header, rows, told in BAD_TABLES:
        path = table(tmp_path / "bad.csv", header, rows)
        for command in (("fit", "--law", "constant"), ("compare",), ("diagnose",)):
            done = call(command[0], path, *command[1:])
            assert (done.code, done.out) == (3, ""), (command, told)
            assert "bad.csv" in done.err
            assert told in done.err
    missing = call("fit", "nosuch.csv", "--law", "constant", "--json")
    assert (missing.code, missing.json()["error"]["message"]) == (3, "there is no such file")
    assert missing.json()["error"]["fix"] == "check the path"


def test_the_law_from_zero_is_named_where_no_wrap_stands_for_an_end_tension(call, tmp_path):
    rows = [f"40,10,{wrap},0.5,{0.5 * math.exp(0.2 * wrap)}" for wrap in range(3, 12)]
    path = table(tmp_path / "trials.csv", HEADER.replace("_deg", "_rad"), rows)
    refused = call("fit", path, "--law", "wrap-power", "--quiet")
    assert refused.code == 3
    assert "ends in -from-zero" in refused.err
    assert call("fit", path, "--law", "wrap-power-from-zero", "--quiet").code in {0, NOT_TRUSTED}


def test_a_stored_fit_is_shown_as_it_was_made(call):
    done = call("show", COUPLED)
    assert done.code == 0
    for words in ("0.4603(23)", "The law: coupled", "wrap 90 to 1080 deg", "prth-trials.csv"):
        assert words in done.out
    shown = call("show", COUPLED, "--json").json()
    assert shown.pop("verdict")["word"] == "supported"
    assert shown == json.loads(COUPLED.read_text(encoding="utf-8"))
    assert (call("show", CONSTANT).code, call("show", TRIALS).code) == (NOT_TRUSTED, 3)


# --- compare and diagnose ------------------------------------------------------------------------------------------


def test_a_comparison_has_the_agreed_shape_best_first(call):
    example = shlex.split(find_commands()["compare"].example)[1:]
    done = call(*example, "--laws", "coupled,wrap-power", "--json")
    ranking = done.json()["ranking"]
    assert (done.code, ranking[0]["delta_aicc"]) == (0, 0)
    assert [entry["law"] for entry in ranking][:2] == ["coupled", "wrap-power"]
    assert all(entry.keys() >= RANKING_KEYS for entry in ranking)
    assert sum(entry["weight"] for entry in ranking) == pytest.approx(1)
    assert "fit 5/5" in done.err
    without = call("compare", TRIALS, "--laws", "wrap-power")
    assert without.code == NOT_TRUSTED
    assert "ΔAICc" in without.out
    assert call("compare", TRIALS, "--laws", "wrap-pwoer").code == 3


def test_a_diagnosis_names_effects_evidence_and_experiments(call, tmp_path):
    """As in the help, of every sixth trial."""
    command, trials, *words = words_of(find_commands()["diagnose"].example)
    header, *rows = (ROOT / trials).read_text(encoding="utf-8").splitlines()
    done = call(command, table(tmp_path / "few.csv", header, rows[::6]), *words)
    assert (done.code, done.err) == (0, "")
    for words in ("size effect: supported", "wrap effect: supported", "offset: not supported", "to decide:"):
        assert words in done.out
    # No condition has two wheels, and the means of its pulls leave rounding within conditions.
    assert "wheel: undetermined" in done.out


# --- predict -------------------------------------------------------------------------------------------------------


def test_a_prediction_has_the_agreed_shape(call):
    def predicted(*words):
        return call("predict", "--fit", COUPLED, *WHEEL, *words, "--json").json()

    def width(found):
        return found["interval_N"][1] - found["interval_N"][0]

    found = predicted()
    assert found.keys() >= PREDICT_KEYS
    assert found["lift_force_N"] == pytest.approx(168.82, rel=0.01)
    assert found["interval_N"][0] < found["lift_force_N"] < found["interval_N"][1]
    assert (found["level"], found["extrapolated"], found["method"]) == (0.95, False, "profile")
    assert width(predicted("--level", "0.99")) > 1.2 * width(found)
    assert width(predicted("--method", "linear")) == pytest.approx(width(found), rel=0.2)
    moving = predicted("--speed", "10 m/s", "--linear-density", "62 g/m")
    assert moving["lift_force_N"] < found["lift_force_N"]


def test_what_was_not_tested_is_flagged(call):
    words = ("predict", "--fit", COUPLED, "--wheel-radius", "0.5 m", *WHEEL[2:])
    assert "wheel radius 500 mm is outside the tested 15–60 mm" in call(*words).out
    assert call(*words, "--json").json()["extrapolated"]


def test_the_hand_calculation_can_be_checked_by_hand(call):
    done = call("predict", "--fit", COUPLED, *WHEEL, "--hand")
    lines = [line.strip() for line in done.out.partition("By hand")[2].splitlines()]
    (last,) = [line for line in lines if line.startswith("F_A [N] = exp(")]
    argument, value = last.removeprefix("F_A [N] = exp(").split(") = ")
    assert math.exp(float(argument)) == pytest.approx(float(value), rel=1e-7)
    assert float(value) == pytest.approx(168.82, rel=0.01)


def test_a_number_without_a_unit_or_of_another_is_refused_with_the_way_to_write_it(call):
    for option, bare, fix in (
        *(("--wheel-radius", "35", "35 mm"), ("--wrap", "400", "400 deg"), ("--end-tension", "60", "60 N")),
    ):
        words = dict(zip(WHEEL[::2], WHEEL[1::2], strict=True)) | {option: bare}
        argv = ("predict", "--fit", COUPLED, *(word for pair in words.items() for word in pair))
        done = call(*argv)
        assert (done.code, done.out) == (2, "")
        assert option in done.err
        assert all(one in done.err for one in ("has no unit", f'for example "{fix}"'))
        error = call(*argv, "--json").json()["error"]
        assert error["code"] == "RF130"
        assert fix in error["fix"]
    other = call("predict", "--fit", COUPLED, *WHEEL[:4], "--end-tension", "60 mm")
    assert other.code == 2
    assert "is not a unit of force" in other.err
    done = call("predict", "--fit", COUPLED, *WHEEL, "--speed", "0.3 m/s")
    assert done.code == 3
    assert "linear_density_kg_m is missing" in done.err


def test_fits_that_do_not_answer(call, tmp_path):
    done = call("predict", "--fit", CONSTANT, *WHEEL)
    assert done.code == NOT_TRUSTED
    assert "the law is undecided: The residuals of constant depend on" in done.err
    assert "F_A = " in done.out
    other = tmp_path / "other.json"
    other.write_text('{"schema": "ropefric.fit/9"}', encoding="utf-8")
    assert "newer" in call("predict", "--fit", other, *WHEEL).err
    for path in (other, tmp_path / "nowhere.json", TRIALS):
        assert call("predict", "--fit", path, *WHEEL).code == 3


def test_several_ropes_need_to_be_told_apart(call, tmp_path):
    rows = [row.replace(",10,", f",{rope},", 1) for rope in (8, 10) for row in GOOD]
    call("fit", table(tmp_path / "t.csv", rows=rows), "--law", "constant", "--out", tmp_path / "f.json", "-q")
    done = call("predict", "--fit", tmp_path / "f.json", *WHEEL)
    assert done.code == 2
    assert "ropes of 8 to 10 mm" in done.err
    found = call("predict", "--fit", tmp_path / "f.json", *WHEEL, "--rope-diameter", "8 mm", "--json").json()
    assert found["rope_radius_m"] == pytest.approx(0.004)


# --- design --------------------------------------------------------------------------------------------------------


SETTINGS = {"wheel_radius_m": "40 mm", "wrap_angle_rad": "540 deg", "end_tension_N": "80 N"}
SOUGHT = {"wrap": ("wrap_angle_rad", "--wrap", "rad"), "radius": ("wheel_radius_m", "--wheel-radius", "m"),
    "end-tension": ("end_tension_N", "--end-tension", "N")}  # fmt: skip


def test_a_design_lifts_its_load(call):
    for key, option, unit, solve_for in ((*SOUGHT[name], name) for name in SOUGHT):
        others = [word for key_, name, _ in SOUGHT.values() if key_ != key for word in (name, SETTINGS[key_])]
        words = ("design", "--fit", COUPLED, "--lift", "300 N", "--solve-for", solve_for, *others)
        done = call(*words, "--on-average", "--json")
        assert done.code == 0, done.err
        value = done.json()[key]
        back = call("predict", "--fit", COUPLED, *others, option, f"{value!r} {unit}", "--json").json()
        assert back["lift_force_N"] == pytest.approx(300, rel=1e-6)
    safer = call(*words, "--json").json()
    assert safer[key] > value
    assert safer["lower_bound_N"] == pytest.approx(300, rel=1e-6)
    assert call(*words, "--probability", "0.99", "--json").json()[key] > safer[key]


def test_a_design_for_people_out_of_reach_and_without_what_it_needs(call):
    words = ("--wheel-radius", "40 mm", "--end-tension", "80 N")
    done = call("design", "--fit", COUPLED, "--lift", "900 N", *words)
    assert all(one in done.out for one in ("wrap = ", "95 % of pulls with a new rope lift more than 900 N"))
    words = ("--wheel-radius", "40 mm", "--wrap", "90 deg", "--solve-for", "end-tension")
    done = call("design", "--fit", COUPLED, "--lift", "9000 kN", *words)
    assert done.code == NOT_TRUSTED
    assert "out of reach" in done.out
    wheel = ("--solve-for", "wheel", "--wrap", "90 deg", "--end-tension", "80 N")
    for words, code, told in ((("--lift", "900"), 2, 'for example "900 N"'),
            (("--lift", "900 N", *wheel), 3, "wrap, radius"),
            (("--lift", "900 N", "--wheel-radius", "40 mm"), 3, "end_tension_N")):  # fmt: skip
        done = call("design", "--fit", COUPLED, *words)
        assert done.code == code
        assert told in done.err


# --- verify --------------------------------------------------------------------------------------------------------


def test_changed_fits_are_found(call, tmp_path):
    folder = tmp_path / "fits"
    folder.mkdir()
    for file in (TRIALS, COUPLED, CONSTANT):
        shutil.copy(file, folder)
    path = folder / "prth-coupled.json"
    tree = json.loads(path.read_text(encoding="utf-8"))
    tree["parameters"]["c"]["value"] += 0.5 * tree["parameters"]["c"]["std"]
    path.write_text(json.dumps(tree), encoding="utf-8")
    done = call("verify", folder, "--json")
    assert done.code == NOT_TRUSTED
    found = {item["law"]: item["ok"] for item in done.json()["fits"]}
    assert found.pop("coupled") is False
    assert all(found.values())
    assert call("verify", tmp_path).code == call("verify", tmp_path / "nowhere").code == 3
