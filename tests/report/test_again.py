"""`report`: the same bytes again, from its folder or another, and what it says where there is nothing."""

from dataclasses import replace

import pytest

from ropefric.cli.app import main
from ropefric.files.folder import OutputFolder
from ropefric.fitting import compare
from ropefric.fitting.compare import choose_law
from ropefric.fitting.predict import predict
from ropefric.fitting.result import Verdict
from ropefric.friction.condition import one_condition
from ropefric.report.campaign import write_report
from ropefric.report.page import Wish


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*"))
        if path.is_file()}  # fmt: skip


def with_prediction(run, prediction):
    return replace(run, answer=replace(run.answer, prediction=prediction))


@pytest.mark.slow
def test_the_report_is_made_again(run, few_laws, tmp_path, capfd, monkeypatch):
    """From its folder alone: the manifest knows the campaign and the law that was asked for."""
    monkeypatch.setattr(compare, "LAWS", few_laws)
    folder = tmp_path / "out"
    wheel = run.answer.prediction.conditions
    winner = choose_law(run.answer.comparison, "constant", wheel)
    doubts = dict.fromkeys((*winner.doubts, *winner.fit.advice, *run.answer.comparison.notes[1:]))
    prediction = winner.of(predict(winner.fit, wheel))
    asked = replace(run.answer, winner=winner, prediction=prediction, doubts=tuple(doubts))
    with OutputFolder(folder, family="campaign") as target:
        write_report(replace(run, answer=asked), target, Wish(figures=False))
        target.publish("answer")
    before = files(folder)
    (folder / "report.html").unlink()
    assert main(["report", str(folder), "--no-figures"]) in {0, 4}
    said = capfd.readouterr()
    assert "constant, as asked for" in said.out
    assert "report.html" in said.out
    made = files(folder)
    assert {name for name in before if made[name] != before[name]} <= {".ropefric/files.json"}


def test_without_a_wheel_there_is_no_lift_force_and_that_is_said(run, tmp_path):
    bare = replace(with_prediction(run, None), campaign=run.campaign.model_copy(update={"design": None}))
    write_report(bare, tmp_path, Wish(figures=False))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for said in ("No lift force", "No figures"):
        assert said in page
    for gone in ('id="next"', "confidence interval", "<svg"):
        assert gone not in page
    assert not (tmp_path / "uncertainty.json").exists()


def test_a_law_not_to_be_trusted_is_the_first_thing_to_be_read(run, without_figures):
    winner = choose_law(run.answer.comparison, "coupled")
    assert not winner.fit.trustworthy
    answer = replace(run.answer, winner=winner, prediction=winner.of(run.answer.prediction))
    page = without_figures(replace(run, answer=answer))
    first = page[page.index('<ul class="alerts">') :].split("</li>")[0]
    for said in ('class="stop"', "Do not use", f"The law coupled is {winner.verdict.word}"):
        assert said in first
    assert f"coupled, {winner.verdict.word}" in page
    assert "--law coupled" in page


def test_doubts_about_the_lift_force_alone_are_not_about_the_law(run, without_figures):
    assert run.answer.winner.verdict.supported
    doubted = replace(run.answer.prediction, verdict=Verdict(word="undecided", reasons=("it is far off",)))
    page = without_figures(with_prediction(run, doubted))
    first = page[page.index('<ul class="alerts">') :].split("</li>")[0]
    assert f"The lift force by {run.answer.fit.law} is undecided" in first
    far = predict(run.answer.fit, one_condition(0.09, 0.0049, 5.0, 60.0))
    page = without_figures(with_prediction(run, far))
    assert "The design lies outside the tested range" in page
    assert "Wheel radius 90 mm is outside the tested 15–60 mm" in page


def test_what_the_user_writes_is_shown_and_not_obeyed(run, without_figures):
    rope = run.campaign.rope.model_copy(update={"material": "</p><b>"})
    changed = run.campaign.model_copy(update={"name": "<script>&", "rope": rope})
    page = without_figures(replace(run, campaign=changed))
    assert "<h1>&lt;script&gt;&amp;" in page
    assert "<script" not in page
    assert "<b>" not in page


def test_a_folder_without_results_is_3(tmp_path, capfd):
    assert main(["report", str(tmp_path)]) == 3
    assert "no results stand here" in capfd.readouterr().err
    assert main(["report", str(tmp_path / "nowhere.toml")]) == 3
    assert main(["report", str(tmp_path), "--out", str(tmp_path)]) == 2
