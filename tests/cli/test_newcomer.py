"""A newcomer's campaign comes in right: German, two channels in mV with offsets, a clock across midnight, a footer."""

import csv
import datetime as dt
import math
from pathlib import Path

import numpy as np
import pytest

MU, RATE_HZ = 0.21, 200.0
GAINS_N_MV, OFFSETS_MV = (25.0, 40.0), (0.31, -0.12)
HEAD = "Prüfstand 2\nPrüfer: Müller\nAbtastrate: 200 Hz\n\nUhrzeit;Zugkraft [mV];Gegenkraft [mV]\n"
FOOTER = "Ende der Messung;;\nMaximum;{:.4f};{:.4f}\n"


def recording(radius_mm, wrap_deg, end_N, k):
    """Both sides hang free for 0.4 s; the slack weight is lowered onto the rope, then the winch pulls until it slips."""
    rng = np.random.default_rng(round(radius_mm * 1000 + wrap_deg * 10 + end_N + k))
    time_s = np.arange(900) / RATE_HZ
    lift_N = end_N * math.exp(MU * math.radians(wrap_deg)) * (1 + 0.004 * rng.standard_normal())
    end = np.interp(time_s, [0.4, 0.6, 9], [0, end_N, end_N])
    pull = np.interp(
        time_s, [0.4, 0.6, 1.0, 3.0, 3.02, 9], [0, end_N, end_N, lift_N, 0.85 * lift_N, 0.85 * lift_N]
    )
    signals = [
        values / gain + offset + 0.002 * rng.standard_normal(time_s.size)
        for values, gain, offset in zip((pull, end), GAINS_N_MV, OFFSETS_MV, strict=True)
    ]
    return time_s, *signals, lift_N


def write_daq(folder):
    """Write 32 files; two begin just before midnight."""
    folder.mkdir()
    truth = {}
    for n, (radius_mm, wrap_deg, end_N, k) in enumerate(
        (r, w, e, k) for r in (30, 50) for w in (180, 360) for e in (20, 40) for k in range(1, 5)
    ):
        time_s, pull_mV, end_mV, lift_N = recording(radius_mm, wrap_deg, end_N, k)
        began = dt.datetime(2026, 3, 2, 23, 59, 58) if n in (3, 20) else dt.datetime(2026, 3, 2, 10, n)  # noqa: DTZ001
        rows = [
            f"{(began + dt.timedelta(seconds=t)).strftime('%H:%M:%S.%f')[:-3]};{a:.4f};{b:.4f}"
            for t, a, b in zip(time_s.tolist(), pull_mV, end_mV, strict=True)
        ]
        text = HEAD + "\n".join(rows) + "\n" + FOOTER.format(pull_mV.max(), end_mV.max())
        name = f"R{radius_mm}_{wrap_deg}Grad_{end_N}N_{k}"
        (folder / f"{name}.txt").write_bytes(text.replace(".", ",").encode("cp1252"))
        truth[name] = lift_N
    return truth


def test_the_newcomers_campaign_comes_in_right_with_one_edit(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    truth = write_daq(tmp_path / "daq")
    begun = call(
        "init", "mine", "--from", "daq", "--pattern", "{wheel}_{wrap_angle_deg}Grad_{end_tension_N}N_{repeat}"
    )
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
