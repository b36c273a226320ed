"""What an extraction costs beside merely reading the same files; compared, never asserted on the clock."""

import gzip
import statistics
import time
from dataclasses import replace

import pandas as pd
import pytest

from ropefric.rig.bench import Bench
from ropefric.rig.campaign import campaign_text, plan_trials, prth_bench_plan, record_trial
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import extract_campaign

N_RECORDINGS, N_SAMPLES = 100, 60_000
HEAD = "trial,file,wheel,wrap_angle_deg,end_tension_N,cell\n"


@pytest.fixture(scope="module", params=["csv", "csv.gz"])
def campaign(request, tmp_path_factory):
    """A hundred recordings of twenty seconds at 3 kHz; four simulated ones, each under twenty-five names."""
    folder = tmp_path_factory.mktemp("speed")
    times = {"idle_s": 2.0, "dwell_s": 2.0, "load_s": 5.0, "slide_s": 10.0, "off_s": 1.0}
    bench = Bench(**{name: (value, value) for name, value in times.items()})
    plan = prth_bench_plan()
    plan = replace(plan, bench=bench, conditions=plan.conditions[:4], repeats=1, faults={})
    trials = plan_trials(plan, seed=1)
    rows = []
    for number in range(N_RECORDINGS):
        trial = trials[number % len(trials)]
        file = f"r{number:03d}.{request.param}"
        if number < len(trials):
            lines = gzip.decompress(record_trial(plan, trial, seed=1)[1]).splitlines(keepends=True)
            assert len(lines) > N_SAMPLES
            text = b"".join(lines[: N_SAMPLES + 1])
            packed = request.param.endswith("gz")
            (folder / file).write_bytes(gzip.compress(text, mtime=0) if packed else text)
        else:
            (folder / file).write_bytes(
                (folder / f"r{number % len(trials):03d}.{request.param}").read_bytes()
            )
        rows.append(f"r{number:03d},{file},{trial.condition.wheel},540,60,{trial.cell}\n")
    (folder / "campaign.toml").write_text(campaign_text(plan), encoding="utf-8")
    (folder / "trials.csv").write_text(HEAD + "".join(rows), encoding="utf-8")
    return load_campaign(folder / "campaign.toml")


@pytest.mark.benchmark(group="extraction of 100 recordings of 60 000 samples")
def test_extraction_beside_reading(benchmark, campaign):
    reading_s = []

    def read():
        start = time.perf_counter()
        for spec in campaign.trials:
            pd.read_csv(spec.path)
        reading_s.append(time.perf_counter() - start)

    extraction = benchmark.pedantic(extract_campaign, args=(campaign,), setup=read, rounds=5, warmup_rounds=1)
    assert {trial.breakaway.status for trial in extraction.trials} == {"ok"}
    read_s = statistics.median(reading_s[1:])
    benchmark.extra_info["pandas.read_csv alone [s]"] = round(read_s, 3)
    benchmark.extra_info["extraction / reading"] = round(benchmark.stats.stats.median / read_s, 3)
    pairs = zip(benchmark.stats.stats.data, reading_s[1:], strict=True)
    benchmark.extra_info["of each round"] = [round(whole / alone, 2) for whole, alone in pairs]
