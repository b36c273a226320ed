"""Anything at all in a recording: no exception, no force that is not there; tests/fuzz does the rest."""

import gzip
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ropefric.traces.breakaway import Status
from ropefric.trials.extract import extract_campaign, extract_recording

HEAD = "time_s,force_N\n"
FUZZ = settings(deadline=None, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
NO_FORCE = set(Status) - {Status.OK}


def rows(text):
    return [line.split(",") for line in text.splitlines()[1:]]


def table(cells):
    return HEAD + "".join(f"{t},{f}\n" for t, f in cells)


@pytest.fixture(scope="module")
def bench_of_one(tmp_path_factory, new_lab, pull_csv, allowed):
    """A campaign of one recording, to be written over, and its good text with few enough rows to be hit."""
    lab = new_lab(tmp_path_factory.mktemp("fuzz"))
    text = pull_csv(100.0, rate_Hz=300.0)
    lab.folder.joinpath("r.csv").write_text(text)
    campaign = lab.write([lab.row("r.csv")]).load()
    (sound,) = extract_campaign(campaign).trials
    assert sound.breakaway.status == "ok"
    return One(campaign, text, allowed)


class One:
    """A campaign and the text of its recording; short in hypothesis' reports."""

    def __init__(self, campaign, text, allowed):
        self.campaign, self.text, self.allowed = campaign, text, allowed

    def __repr__(self):
        return "one recording"


def extract_bytes(bench, data, name="r.csv"):
    campaign = bench.campaign
    path = campaign.folder / name
    path.write_bytes(data)
    spec = replace(campaign.trials[0], path=path, file=name)
    (results,) = extract_recording(campaign, [spec])
    assert len(results) >= 1
    for result in results:
        bench.allowed(result)
    return results[0]


@given(
    data=st.binary(max_size=400), text=st.text(alphabet='0123456789.,;\t\n -+eEnaNif"_Ntime', max_size=400)
)
@FUZZ
def test_random_bytes_and_tables_give_no_force(bench_of_one, data, text):
    for name in ("r.csv", "r.csv.gz", "r.txt", "r.mat", "r.xlsx", "r.tdms"):
        assert extract_bytes(bench_of_one, data, name).breakaway.status in NO_FORCE
    for content in (text, HEAD + text):
        assert extract_bytes(bench_of_one, content.encode()).breakaway.status in NO_FORCE


@given(data=st.data())
@FUZZ
def test_bytes_changed_in_a_packed_recording_never_give_another_force(bench_of_one, data):
    spoilt = bytearray(gzip.compress(bench_of_one.text.encode(), mtime=0))
    place = data.draw(st.integers(0, len(spoilt) - 1))
    spoilt[place] ^= data.draw(st.integers(1, 255))
    result = extract_bytes(bench_of_one, bytes(spoilt), "r.csv.gz")
    if result.breakaway.status is Status.OK:  # a header byte that says nothing about the content
        assert result.peak_N == pytest.approx(100.0, rel=5e-3)


@given(scale=st.floats(-300, 300), offset=st.floats(-1e6, 1e6), stretch=st.floats(-12, 12))
@FUZZ
def test_recordings_of_any_scale(bench_of_one, scale, offset, stretch):
    """Units nobody thought of: a force that comes out is the scaled one."""
    factor, slower = 10.0**scale, 10.0**stretch
    cells = [(float(t) * slower, float(f) * factor + offset) for t, f in rows(bench_of_one.text)]
    result = extract_bytes(bench_of_one, table((repr(t), repr(f)) for t, f in cells).encode())
    if result.breakaway.status is Status.OK:
        # A level below zero is none of a rope's, and is taken off and said.
        below = offset < 0.0 and "less than nothing: taken off" in " ".join(result.breakaway.notes)
        wanted = 100.0 * factor + (0.0 if below else offset)
        assert result.peak_N == pytest.approx(wanted, abs=2.0 * factor)
