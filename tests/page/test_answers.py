"""What the page says of a law, of wheels and of machines is what the commands say."""

import csv
import io
import json
import math
import shutil
import time
from contextlib import redirect_stdout
from threading import Event

import pytest

from ropefric.cli.app import main
from ropefric.errors import DataError, InputError
from ropefric.fitting import compare
from ropefric.page import answers
from ropefric.page import review as page_review
from ropefric.page.desk import Desk
from ropefric.page.review import Review
from ropefric.report.page import find_browser

FEW = {name: compare.LAWS[name] for name in compare.ALWAYS}


@pytest.fixture(scope="module")
def reviewed(extracted, settled, tmp_path_factory):
    """A review after two decisions, its answers before and after, and what `run` prints; only read it."""
    folder = tmp_path_factory.mktemp("answers") / "campaign"
    shutil.copytree(extracted, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compare, "LAWS", FEW)
        review = Review(folder / "campaign.toml", by="A. Meier")
        first, decided, fitted = settled(review)["now"], Event(), page_review._fitted
        patch.setattr(page_review, "_fitted", lambda *given: decided.wait(60.0) and fitted(*given))
        for trial in ("c28-r03", "c35-r02"):  # the second while the first is being fitted
            review.decide(trial, "pick", pick_s=review.trial(trial)["candidates"][0]["time_s"])
        decided.set()
        answer = settled(review)
        with redirect_stdout(io.StringIO()) as said:
            words = ["run", str(folder / "campaign.toml"), "--out", str(folder / "fresh"), "--no-figures"]
            main([*words, "--quiet", "--json"])
    yield review, first, answer, json.loads(said.getvalue())
    review.close()


def test_what_the_page_says_is_what_run_says(reviewed):
    review, first, answer, told = reviewed
    assert answer["before"] == answer["first"] == first
    said, found = answer["now"], told["prediction"]
    assert (said["law"], said["lift"] != first["lift"]) == (told["law"], True)
    assert said["lift"]["lift_force_N"] == pytest.approx(found["lift_force_N"], rel=1e-6)
    assert said["lift"]["interval_N"] == pytest.approx(found["interval_N"], rel=1e-6)
    with (review.campaign_file.parent / "fresh" / "trials.csv").open(newline="") as file:
        row = next(one for one in csv.DictReader(file) if one["trial"] == "c28-r03")
    assert (row["status"], row["kept"], row["decided_by"]) == ("ok", "true", "A. Meier")
    force_N = review.overview()["rows"]["c28-r03"]["force_N"]
    assert float(row["peak_N"]) == pytest.approx(force_N, rel=1e-7)


def test_laws_data_and_wheels_are_those_of_the_commands(reviewed, capfd):
    review, _, _, told = reviewed
    run = review.run()
    tree = answers.law_of(review, run)
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    assert (tree["law"], tree["verdict"]) == (told["law"], told["verdict"])
    assert [one["law"] for one in tree["ranking"]] == [one["law"] for one in told["ranking"]]
    assert tree["verdicts"][tree["law"]] in {"supported", "undecided", "not judged"}
    assert [*tree["verdicts"]] == [one["law"] for one in tree["ranking"]]
    points = [point for one in tree["series"] for point in one["points"]]
    assert len(points) == told["fit"]["statistics"]["n_conditions"]
    assert all(low < force < high for _, force, low, high in points)

    wheel = ("--wheel-radius", "35 mm", "--wrap", "300 deg", "--end-tension", "60 N", "--json")
    fit = str(review.campaign_file.parent / "fresh" / "fits" / f"{tree['law']}.json")
    main(["predict", "--fit", fit, *wheel])
    said = json.loads(capfd.readouterr().out)
    rope_m = run.campaign.rope.radius_m
    at = {"wheel_radius_m": 0.035, "rope_radius_m": rope_m, "wrap_angle_rad": math.radians(300)}
    at["end_tension_N"] = 60.0
    lift = answers.lift_of(run, at)
    assert lift["lift_force_N"] == pytest.approx(said["lift_force_N"], rel=1e-6)
    assert lift["interval_N"] == pytest.approx(said["interval_N"], rel=1e-4)
    within = [math.degrees(end) for end in run.answer.fit.validity["wrap_angle_rad"]]
    assert lift["tested_deg"] == within
    assert answers.lift_of(run, at | {"end_tension_N": 6000.0})["tested_deg"] == []  # then no wrap was tested
    main(["design", "--fit", fit, "--lift", "200 N", *wheel[:2], *wheel[4:]])
    said = json.loads(capfd.readouterr().out)
    found = answers.inverse_of(run, {"lift_N": "200", "solve_for": "wrap", "probability": "0.95"}, at)
    assert found["status"] == said["status"]
    assert found["wrap_angle_rad"] == pytest.approx(said["wrap_angle_rad"], rel=1e-5)


def test_a_condition_is_switched_off_with_a_reason_and_on_again(begin):
    review = begin()
    words = review.overview()["rows"]["c11-r01"]["condition"]

    def excluded():
        rows = review.overview()["rows"].values()
        return [row["excluded"] for row in rows if row["condition"] == words]

    review.decide("c11-r01", "exclude", text="torn")
    review.switch("c11-r02", "wet rope")
    assert excluded() == ["torn", *["wet rope"] * 3]
    # All of it is one decision, which is undone at once.
    assert (review.undo()["undo"], excluded()) == (1, ["torn", *[""] * 3])
    review.switch("c11-r02", "wet rope")
    review.switch("c11-r02", "")
    assert excluded() == ["torn", *[""] * 3]
    with pytest.raises(InputError, match="changes nothing"):
        review.switch("c11-r02", "")


def test_another_law_is_used_where_that_is_asked(begin, settled, monkeypatch):
    monkeypatch.setattr(compare, "LAWS", FEW)
    review = begin(fits=True)
    review.use_law("constant-offset")
    assert settled(review)["now"]["law"] == review.law == "constant-offset"
    assert answers.law_of(review, review.run())["asked"] == "constant-offset"
    with pytest.raises(LookupError):
        review.use_law("nonsense")


@pytest.mark.slow  # a browser prints the page
@pytest.mark.parametrize("options", [["--short"], ["--pdf"]])
def test_a_report_has_the_bytes_of_the_command(campaign, begin, monkeypatch, options):
    if "--pdf" in options:
        find_browser()
    monkeypatch.setattr(compare, "LAWS", FEW)
    monkeypatch.chdir(campaign)
    (campaign / "page").mkdir()
    desk = Desk(campaign / "page", by="A. Meier", campaign=campaign / "campaign.toml")
    desk.review = begin()
    desk.writes["report"]({name.removeprefix("--"): True for name in options})
    while (told := desk.work.state())["running"]:
        time.sleep(0.05)
    assert told["result"]["reports"][0] == "report.html"
    words = ["report", str(campaign / "campaign.toml"), "--out", "command", *options, "--quiet"]
    assert main(words) in {0, 4}
    made, same = (
        {path.name: path.read_bytes() for path in (campaign / name).glob("*") if path.is_file()}
        for name in ("page", "command")
    )
    assert made.keys() == same.keys()
    assert [name for name in made if made[name] != same[name]] == []
    assert ("report.pdf" in made) == ("--pdf" in options)


def test_every_template_is_a_form_that_solves_as_the_command_does(tmp_path, capfd):
    names = [one["name"] for one in answers.machine_names()]
    assert {"hoist", "belt-press", "band-saw", "traction", "belt-drive"} <= set(names)
    for name in names:
        rows = answers.machine_form(name)
        assert len({row["key"] for row in rows}) == len(rows)
        is_given = [bool(row["value"]) for row in rows]
        assert is_given == sorted(is_given, reverse=True)
    assert main(["init", str(tmp_path), "--scene", "hoist", "--quiet"]) == 0
    capfd.readouterr()
    main(["solve", str(tmp_path / "hoist.toml"), "--json"])
    said = json.loads(capfd.readouterr().out)
    told = answers.solve_machine("hoist", {}, None)
    assert told["answer"]["lift_force_N"] == pytest.approx(said["lift_force_N"], rel=1e-6)
    assert told["text"].startswith("hoist\n  friction: ")  # not the page's own file of it
    more = answers.solve_machine("hoist", {"wheel.wrap": "720 deg"}, None)
    assert more["answer"]["lift_force_N"] > told["answer"]["lift_force_N"]
    assert {one["fate"] for one in told["effects"]} <= {"simulated", "left out", "not applicable"}
    with pytest.raises(DataError, match="wrap"):
        answers.solve_machine("hoist", {"wheel.wrap": "720"}, None)
    with pytest.raises(LookupError):
        answers.machine_form("../../etc/passwd")


def test_the_law_of_the_campaign_drives_a_machine(reviewed):
    told = answers.solve_machine("hoist", {}, reviewed[0].run().answer.fit)
    assert told["answer"]["lift_force_N"] > 0
    assert told["answer"] != answers.solve_machine("hoist", {}, None)["answer"]
