"""The main job: which law is used, what is written, and what happens when something is wrong."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from ropefric.errors import DataError, FitError, UnknownNameError
from ropefric.files.folder import OutputFolder
from ropefric.fitting.compare import choose_law
from ropefric.fitting.result import FitStatus
from ropefric.pipeline import answer_trials, run_campaign, write_answer
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import DesignWheel
from ropefric.trials.result import NOT_ABOVE, count_trials, set_aside_impossible
from tests.trials.conftest import Lab, pull_text

WHEEL = DesignWheel.model_construct(wheel_radius_m=0.05, wrap_angle_rad=6.0, end_tension_N=40.0)


def tree(folder):
    return {
        p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()
    }


@pytest.mark.slow
def test_the_bench_leaves_what_others_can_check(bench_run):
    run, folder = bench_run
    names = set(tree(folder))
    assert names >= {"trials.csv", "conditions.csv", "problems.csv", "comparison.csv", "prediction.json"}
    assert {f"fits/{fit.law}.json" for fit in run.answer.fits} <= names
    assert {path.relative_to(folder).as_posix() for path in run.written} == names
    with (folder / "comparison.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["law"] for row in rows] == [entry.law for entry in run.answer.comparison.ranking]
    assert float(rows[0]["delta_aicc"]) == 0.0
    prediction = json.loads((folder / "prediction.json").read_text(encoding="utf-8"))
    nine_digits = pytest.approx(run.answer.prediction.lift_force_N[0], rel=5e-9)
    assert prediction["lift_force_N"] == nine_digits
    source = json.loads((folder / "fits" / "coupled.json").read_text(encoding="utf-8"))["provenance"]["input"]
    assert source["path"] == "../trials.csv"
    counts = run.to_dict()["extraction"]
    assert counts == count_trials(run.extraction)
    assert (counts["n_trials"], counts["n_conditions"]) == (432, 36)
    assert sum(counts["status"].values()) == 432
    json.dumps(run.to_dict(), allow_nan=False)


@pytest.fixture(scope="module")
def answer(pulls):
    """What 72 trials that obey a constant coefficient say."""
    return answer_trials(pulls("constant", 0.2), design=WHEEL, rope_radius_m=0.005)


def test_the_law_that_made_the_data_is_used(pulls, answer):
    theta = (0.46, -0.22, -0.3)
    other = answer_trials(pulls("size-exponential", *theta), design=WHEEL, rope_radius_m=0.005)
    for found, law, truth in ((answer, "constant", (0.2,)), (other, "size-exponential", theta)):
        assert found.fit.law == law
        log_lift = found.fit.friction_law.log_lift(list(truth), found.prediction.conditions)[0]
        assert abs(found.prediction.log_lift[0] - log_lift) < 4 * found.prediction.std_log[0]


def test_a_law_that_is_asked_for_is_used_and_its_place_is_said(answer, few_laws):
    found = answer_trials(answer.table, law="wrap-exponential-from-zero", design=WHEEL)
    assert found.fit.law == "wrap-exponential-from-zero"
    assert found.winner.forced
    assert any("was asked for" in doubt or "takes no part" in doubt for doubt in found.doubts)
    with pytest.raises(UnknownNameError, match="did you mean 'constant'"):
        answer_trials(answer.table, law="constnat")


def test_a_law_that_cannot_be_trusted_does_not_win_and_one_without_an_answer_cannot_be_asked_for(answer):
    found = answer.comparison
    best = found.ranking[0]
    spoilt = replace(best, fit=replace(best.fit, status=FitStatus.AT_BOUND), status="at-bound")
    winner = choose_law(replace(found, ranking=(spoilt, *found.ranking[1:])))
    assert winner.fit.law != best.law
    assert winner.fit.trustworthy
    assert f"{best.law} fits better" in winner.doubts[0]
    assert "at-bound" in winner.doubts[0]
    gone = replace(best, fit=None, counted=False, note="no answer here")
    with pytest.raises(FitError, match="no answer here"):
        choose_law(replace(found, ranking=(gone, *found.ranking[1:])), gone.law)
    # Where none can be trusted the best says so.
    bad = FitStatus.UNIDENTIFIABLE
    none = tuple(
        one if one.fit is None else replace(one, fit=replace(one.fit, status=bad)) for one in found.ranking
    )
    winner = choose_law(replace(found, ranking=none))
    assert winner.fit.law == found.best.law
    assert not winner.fit.trustworthy


def test_a_design_without_an_answer_is_a_doubt_and_no_number(answer, few_laws):
    wild = WHEEL.model_copy(update={"wrap_angle_rad": 1e6})
    found = answer_trials(answer.table, design=wild)
    assert found.prediction is None
    assert any("no lift force for the design" in doubt and "overflows" in doubt for doubt in found.doubts)
    assert found.to_dict()["prediction"] is None


def test_what_an_earlier_run_left_is_removed_and_what_others_left_is_not(answer, tmp_path):
    def written(answer):
        with OutputFolder(tmp_path, family="campaign") as folder:
            write_answer(answer, folder)
            folder.publish("answer")
        return tree(tmp_path)

    before = written(answer)
    (tmp_path / "fits" / "mine.json").write_text("{}")
    gone = answer.comparison.ranking[-1].law
    ranking = tuple(entry for entry in answer.comparison.ranking if entry.law != gone)
    fewer = replace(answer, prediction=None, comparison=replace(answer.comparison, ranking=ranking))
    assert before.keys() - written(fewer).keys() == {"prediction.json", f"fits/{gone}.json"}
    assert "fits/mine.json" in tree(tmp_path)


@pytest.fixture
def lab(tmp_path):
    """Twelve recordings of a straight pull: wraps of half a turn and a turn, from 30 to 90 N."""
    lab, rows, rng = Lab(tmp_path), [], np.random.default_rng(3)
    for number in range(12):
        wrap_deg = (180, 360)[number % 2]
        peak_N = 20 * math.exp(0.2 * math.radians(wrap_deg)) * (1 + 0.01 * rng.standard_normal())
        (tmp_path / f"p{number}.csv").write_text(pull_text(peak_N, seed=number), encoding="utf-8")
        rows.append(lab.row(f"p{number}.csv", wrap_angle_deg=wrap_deg))
    return lab, rows


def test_a_pull_below_its_end_tension_is_set_aside_and_ends_nothing(lab, tmp_path, few_laws):
    lab, rows = lab
    campaign = lab.write([*rows[:5], rows[5] | {"end_tension_N": 2000}, *rows[6:]]).load()
    run = run_campaign(campaign, tmp_path / "out")
    (odd,) = [trial for trial in run.extraction.trials if trial.trial == "p5"]
    assert ((odd.kept, odd.excluded), count_trials(run.extraction)["n_kept"]) == ((False, NOT_ABOVE), 11)
    assert any(problem.code == "RF240" for problem in run.extraction.problems)
    assert run.answer.fit["mu"].value == pytest.approx(0.2, rel=0.02)
    assert set_aside_impossible(run.extraction, campaign) is run.extraction


def test_no_usable_force_is_told_with_the_tables_written(lab, tmp_path):
    lab, rows = lab
    campaign = lab.write(rows).load()
    for path in tmp_path.glob("p*.csv"):
        path.write_text("time_s,force_N\n", encoding="utf-8")
    with pytest.raises(DataError, match="none of the 12 recordings gave a usable force") as caught:
        run_campaign(campaign, tmp_path / "out")
    assert caught.value.code == "RF301"
    assert (tmp_path / "out" / "problems.csv").exists()


# --- a real rope, held: the negative control ---


@pytest.fixture
def capstan(real_data, tmp_path):
    source = real_data / "phy_mini_ia_capstan"
    with (source / "per_trial.csv").open(encoding="utf-8") as stream:
        wraps = {round(float(row["nominal_deg"])): row["wrap_rad_measured"] for row in csv.DictReader(stream)}
    rows = [f"wrap{deg},force_{deg}deg.csv,20.75,{rad},7.8816" for deg, rad in wraps.items()]
    header = "trial,file,wheel_radius_mm,wrap_angle_rad,lift_force_N"
    (tmp_path / "trials.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(
        f'schema = "ropefric.campaign/1"\nname = "capstan"\ntrials = "trials.csv"\ndata = "{source.as_posix()}"\n'
        '[rope]\ndiameter = "4 mm"\n[protocol]\nname = "held"\nside = "slack"\n'
        '[design]\nwheel_radius = "20.75 mm"\nwrap_angle = "200 deg"\nend_tension = "4.2 N"\n',
        encoding="utf-8",
    )
    return load_campaign(tmp_path / "campaign.toml")


@pytest.mark.slow
def test_a_real_rope_on_a_cylinder_obeys_the_capstan_equation(capstan, tmp_path):
    answer = run_campaign(capstan, tmp_path / "out").answer
    assert (answer.fit.law, answer.verdict.word) == ("constant", "supported")
    assert answer.fit["mu"].value == pytest.approx(0.181, abs=0.006)
    low, high = answer.fit["mu"].ci95
    assert low < 0.181 < high
    assert high - low < 0.04
    assert answer.diagnosis["wrap effect"].supported == "no"
    assert answer.diagnosis["load dependence"].supported == "cannot-tell"
    laws = {entry.law: entry for entry in answer.comparison.ranking}
    others = (laws[law] for law in ("wrap-power", "wrap-exponential", "coupled"))
    assert all(one.delta_aicc > 2 or not one.counted for one in others)
    expected_N = 4.2 * math.exp(0.181 * math.radians(200))
    assert answer.prediction.lift_force_N[0] == pytest.approx(expected_N, rel=0.03)
