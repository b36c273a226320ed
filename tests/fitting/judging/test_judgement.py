"""The one verdict, in three words, wherever it is read: terminal, JSON, report, Python and exit code."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from pulled import grid, table_at

import ropefric
from ropefric.cli.app import main
from ropefric.fitting.compare import choose_law, compare_laws
from ropefric.fitting.predict import predict
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import LAWS
from ropefric.pipeline import answer_trials
from ropefric.trials.campaign_model import DesignWheel

NOT_TRUSTED = 4
WHEEL = ("--wheel-radius", "40 mm", "--wrap", "200 deg", "--end-tension", "20 N")


def pulls(law, theta, radii=(0.04,), wraps=(6.0,), loads=(20.0,), *, repeats=4, within=0.01, between=(0.0,),
        seed=1):  # fmt: skip
    """A table that obeys a law, each condition off it by the next of `between`."""
    at = grid(radii, wraps, loads, repeats)
    off = np.repeat(np.resize(between, len(at) // repeats), repeats)
    noise = within * np.random.default_rng(seed).standard_normal(len(at))
    return table_at(at, LAWS[law].log_lift(list(theta), at) + noise + off)


def write(table, path):
    rows = ["wheel_radius_mm,rope_diameter_mm,wrap_angle_rad,end_tension_N,peak_N"]
    lengths_mm = 1e3 * table.wheel_radius_m, 2e3 * table.rope_radius_m
    columns = (*lengths_mm, table.wrap_angle_rad, table.end_tension_N, table.peak_N)
    rows += [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([*rows, ""]), encoding="utf-8")
    return path


def everywhere(table, folder, capfd, laws=("wrap-power", "size-exponential")):
    """Return the verdict on a table as the command and Python give it, the same; and what is printed."""
    path = write(table, folder / "trials.csv")
    word = choose_law(ropefric.compare(path, laws)).verdict
    code = main(["compare", str(path), "--quiet", "--laws", ",".join(laws)])
    printed = " ".join(capfd.readouterr().out.split())
    assert f"{word.word}: {word.reason}" in printed
    assert code == (0 if word.supported else NOT_TRUSTED)
    return word, printed


def test_few_conditions_judge_nothing(tmp_path, capfd):
    table = pulls("constant", [0.2], wraps=np.pi * np.array([1.0, 2.0]))
    verdict, printed = everywhere(table, tmp_path, capfd)
    assert verdict.word == "not judged"
    assert "no choice of law" in verdict.reason
    assert not any(one in printed for one in ("trusted", "1.000"))
    assert main(["diagnose", str(tmp_path / "trials.csv"), "--quiet", "--json"]) == NOT_TRUSTED
    assert json.loads(capfd.readouterr().out)["verdict"]["word"] == "not judged"
    stored = str(tmp_path / "f.json")
    assert main(["fit", str(tmp_path / "trials.csv"), "--law", "constant", "--out", stored]) == NOT_TRUSTED
    assert main(["predict", "--fit", stored, *WHEEL]) == NOT_TRUSTED
    assert "not judged" in capfd.readouterr().out


@pytest.mark.slow
def test_conditions_far_beyond_their_repeats_leave_it_undecided(tmp_path, capfd):
    """Six conditions five times as far off as their repeats: most residuals lie beyond ±2 of the repeats' scatter."""
    off = 0.05 * np.array([1.0, -1.2, 0.9, 1.1, -1.0, -0.9])
    table = pulls("constant", [0.2], wraps=np.pi / 2 * np.arange(1, 7), repeats=5, between=off)
    fit = ropefric.fit(table, "constant")
    beyond = np.abs(fit.problem.residuals(fit.theta)) > 2
    assert beyond.sum() > 15
    verdict, _ = everywhere(table, tmp_path, capfd)
    assert verdict.word == "undecided"
    assert "do not show whether the cause is a new rope each time" in verdict.reason
    # That each condition had a rope of its own explains it, and no more than an effect that the law lacks.
    named = replace(table, labels={"rope_id": tuple(map(str, table.group()))})
    fit = ropefric.fit(named, "constant")
    assert fit.scatter.groups == ("rope",)
    assert "do not show whether the cause is a new rope each time" in fit.verdict.reason
    calm = pulls("constant", [0.2], wraps=np.pi / 2 * np.arange(1, 7), repeats=5)
    assert choose_law(compare_laws(calm)).verdict.word == "supported"


def test_many_conditions_show_a_new_rope_each_time(tmp_path, capfd):
    off = 0.04 * np.random.default_rng(4).standard_normal(24)
    table = pulls("constant", [0.2], (0.02, 0.04), np.linspace(2, 12, 6), (10, 60), repeats=3, between=off)
    verdict, _ = everywhere(table, tmp_path, capfd)
    assert verdict.word == "supported"


# --- laws that are not told apart -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def one_wheel():
    """A wrap effect on one wheel, which three laws explain within 2 in AICc."""
    return pulls("wrap-power", (0.2, -0.5, 0.1), wraps=(1.0, 2.0, 4.0, 8.0), loads=(5.0, 50.0), within=0.02)


@pytest.fixture(scope="module")
def answer(one_wheel):
    design = DesignWheel.model_construct(wheel_radius_m=0.12, wrap_angle_rad=7.0, end_tension_N=40.0)
    return answer_trials(one_wheel, design=design)


def test_laws_that_answer_differently_show_their_spread(answer):
    found = answer.prediction
    assert answer.verdict.word == "undecided"
    assert "which answers differently for this wheel" in answer.verdict.reason
    lifts = {item.law: item.lift_force_N for item in found.candidates}
    assert len(lifts) > 1
    # The wheel is far larger than the one tested: there the interval holds those of all that are not told apart.
    assert found.extrapolated[0]
    ends = [item.interval_N for item in found.candidates]
    assert found.interval_N[0] == pytest.approx([min(e[0] for e in ends), max(e[1] for e in ends)], rel=1e-9)
    low, high = found.spread_N
    assert all(low <= end <= high for item in found.candidates for end in item.interval_N)
    assert low < min(lifts.values()) < max(lifts.values()) < high
    tree = answer.to_dict()
    assert tree["verdict"] == tree["prediction"]["verdict"]
    assert [item["law"] for item in tree["prediction"]["candidates"]] == list(lifts)
    assert tree["prediction"]["spread_N"] == pytest.approx([low, high], rel=1e-8)  # written with nine digits


def test_laws_that_answer_alike_are_no_contradiction(answer):
    near = one_condition(0.04, 0.005, 6.0, 40.0)
    choice = choose_law(answer.comparison, "", near)
    found = choice.of(predict(choice.fit, near))
    assert choice.fit.rivals
    assert choice.verdict.word == "supported"
    assert "answer alike" in choice.verdict.reason
    assert found.candidates


def test_what_a_law_says_of_a_setting_that_all_trials_have_alike_is_not_supported():
    """A tenth less friction over six wraps at one end tension: Howell's law wins, and nothing shows its load effect."""
    wraps, loads = np.linspace(1.6, 12.6, 6), (10.0, 40.0, 160.0)
    asked = one_condition(0.04, 0.005, 7.0, 40.0)
    theta = (0.3, 0.95)
    one_load = pulls("howell", theta, wraps=wraps, loads=(40.0,), repeats=5, within=0.005)
    comparison = compare_laws(one_load, ["howell", "wrap-power"])
    untested = "the trials have one size ratio and one end tension only: "
    untested += "what howell says of others is not tested"
    assert comparison.best.law == "howell"
    elsewhere = {"end tension": one_condition(0.04, 0.005, 7.0, 60.0),
        "size": one_condition(0.08, 0.005, 7.0, 40.0)}  # fmt: skip
    for named, wheel in {untested: None, **elsewhere}.items():
        verdict = choose_law(comparison, "", wheel).verdict
        assert verdict.word == "undecided"
        assert named in verdict.reason
        assert "what howell says of others is not tested" in verdict.reason
    fit = comparison.best.fit
    assert not fit.trustworthy
    assert untested in fit.verdict.reason
    # Asked about what was tested, it interpolates: that stands, and so does what is not known.
    here = choose_law(comparison, "", asked).verdict
    assert here.supported
    assert untested in here.reason
    assert predict(fit, asked).verdict.supported
    assert not predict(fit, elsewhere["size"]).verdict.supported
    # The same law on wheels and end tensions that differ is shown by them.
    varied = pulls("howell", theta, (0.02, 0.08), wraps[::2], loads, repeats=5, within=0.005)
    assert choose_law(compare_laws(varied, ["howell"]), "howell").verdict.supported


def test_a_law_asked_for_against_the_data_is_not_supported(answer):
    choice = choose_law(answer.comparison, "constant")
    assert choice.verdict.word != "supported"
    assert "constant was asked for" in choice.verdict.reason


# --- intervals ------------------------------------------------------------------------------------------------------


def test_an_interval_of_a_curved_law_is_its_profile(tmp_path, capfd):
    """Three wheels and two wraps for five parameters: what the parameters may be together is no ellipsoid."""
    table = pulls("coupled", (0.46, -0.22, -0.3, -0.48, 0.055), (0.015, 0.03, 0.06), (2.0, 6.0), (20.0, 80.0))
    fit = ropefric.fit(table, "coupled")
    settings = {"wheel_radius_m": 0.04, "wrap_angle_rad": 4.0, "end_tension_N": 40.0}
    found, straight = ropefric.predict(fit, **settings), ropefric.predict(fit, **settings, method="linear")
    assert found.method == "profile"
    assert not np.allclose(found.interval_N, straight.interval_N, rtol=1e-5)
    ropefric.save_fit(fit, tmp_path / "fit.json")
    assert ropefric.predict(tmp_path / "fit.json", **settings).to_dict() == found.to_dict()


def test_nothing_left_over_gives_no_interval(tmp_path, capfd):
    """As many conditions as parameters, and no repeats."""
    table = pulls("constant-offset", (0.2, 0.1), wraps=(3.0, 6.0), repeats=1)
    path, stored = write(table, tmp_path / "trials.csv"), str(tmp_path / "fit.json")
    assert main(["fit", str(path), "--law", "constant-offset", "--out", stored]) == NOT_TRUSTED
    capfd.readouterr()
    assert main(["predict", "--fit", stored, *WHEEL, "--quiet"]) == NOT_TRUSTED
    said = capfd.readouterr().out
    assert all(one in said for one in ("standard error not known", "interval of the mean: not known"))
    main(["predict", "--fit", stored, *WHEEL, "--quiet", "--json"])
    tree = json.loads(capfd.readouterr().out)
    assert tree["std_N"] is None
    assert tree["interval_N"] == tree["prediction_interval_N"] == [None, None]
    assert math.isfinite(tree["lift_force_N"])
    assert tree["verdict"]["word"] == "not judged"
