"""A newcomer's campaign comes in right: German, two channels in mV with offsets, a clock across midnight, a footer."""

import csv
from pathlib import Path

import pytest
from newcomer import PATTERN, write_daq


def test_the_newcomers_campaign_comes_in_right_with_one_edit(call, tmp_path, monkeypatch, few_laws):
    monkeypatch.chdir(tmp_path)
    truth = write_daq(tmp_path / "daq")
    begun = call("init", "mine", "--from", "daq", "--pattern", PATTERN)
    assert begun.code == 0, begun.err
    assert "1 recording of 900 samples, 200 Hz" in begun.err
    campaign = tmp_path / "mine" / "campaign.toml"
    text = campaign.read_text(encoding="utf-8")
    assert "2 of 32" not in begun.err

    # The one edit: what no file tells.
    for side, gain in (("Zugkraft", 25), ("Gegenkraft", 40)):
        told = f'column = "{side} [mV]", unit = "mV"'
        assert told in text
        text = text.replace(told, f'{told}, sensitivity = "{gain} N/mV"')
    wheels = '[wheels.R30]\nradius = "30 mm"\n[wheels.R50]\nradius = "50 mm"\n[tare]\ninterval = ["0 s", "0.35 s"]\n'
    campaign.write_text(text.replace("[smoothing]", wheels + "[smoothing]"), encoding="utf-8")

    assert call("check", "mine").code == 0
    assert call("run", campaign, "--out", "out", "--no-figures", "-q").code in {0, 4}
    with Path("out/trials.csv").open(encoding="utf-8") as file:
        trials = [*csv.DictReader(file)]
    assert len(trials) == 32
    assert {trial["status"] for trial in trials} == {"ok"}
    assert [float(t["peak_N"]) / truth[t["trial"]] for t in trials] == pytest.approx([1.0] * 32, rel=0.01)
    set_N = [float(t["trial"].split("_")[2].removesuffix("N")) for t in trials]
    assert [float(t["end_tension_N"]) for t in trials] == pytest.approx(set_N, rel=0.01)
