"""A good campaign comes out in SI, complete, portable and with a stable fingerprint."""

import json
import math
import pickle
import shutil
from itertools import product

import pytest

from ropefric.traces.calibration import Adc, ForceCell
from ropefric.traces.readers.profile import Channel
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import SCHEMA


def test_settings_in_si(bench):
    campaign = load_campaign(bench.path)
    assert (campaign.name, campaign.schema) == ("PRTH bench", SCHEMA)
    assert (campaign.folder, campaign.rope.radius_m) == (bench.folder / "recordings", 0.0049)
    assert campaign.rope.linear_density_kg_m == 0.062
    assert {name: wheel.radius_m for name, wheel in campaign.wheels.items()} == {"W40": 0.04, "W60": 0.06}
    assert campaign.cells["K1"] == ForceCell(
        name="K1", full_scale_N=1000.0, zero_V=0.0, full_scale_V=5.0, linearity=0.0002, hysteresis=0.0003,
        repeatability=0.0002, transmitter=0.001, points=((0.0, 0.002), (500.0, 2.501)), serial="K-7",
        calibrated="2026-01-15",
    )  # fmt: skip
    assert campaign.adc == Adc(bits=10, low_V=0.0, high_V=5.0)
    protocol, smoothing = campaign.protocol, campaign.smoothing
    assert (protocol.name, protocol.stop_s, protocol.min_step_N) == ("breakaway", 6.0, 5.0)
    assert campaign.tare_interval_s == (0.0, 0.3)
    assert (smoothing.mode, smoothing.window_s) == ("fixed", 0.01)
    assert (campaign.rejection, campaign.weights_tolerance) == ("grubbs", 0.0005)
    assert (campaign.design.wheel_radius_m, campaign.design.wrap_angle_rad) == (0.035, math.radians(400))
    assert campaign.design.end_tension_N == 60.0


def test_profile(bench):
    profile = load_campaign(bench.path).profile
    assert profile.channels == {"time": Channel(column="time_s", unit="s"),
        "counts": Channel(column="counts"), "pressure": Channel(column=3, unit="bar")}  # fmt: skip
    assert (profile.constants, profile.derived) == ({"area": 490.9e-6}, {"load": "pressure * area"})
    assert (profile.sampling_rate_Hz, profile.header_row, profile.missing) == (3000.0, 1, ("--",))


def test_trials_in_si(bench):
    first, second, third = load_campaign(bench.path).trials
    assert (first.trial, first.line, first.wheel_radius_m, first.wrap_angle_rad) == ("t1", 2, 0.04, math.pi)
    assert (first.end_tension_N, first.dwell_s, first.start_s, first.stop_s) == (80.0, 30.0, 0.0, 6.0)
    assert first.path == bench.folder / "recordings" / "a.csv"
    assert (second.exclude, second.note, second.wheel_radius_m) == ("rope jumped", "see book", 0.06)
    assert (third.trial, third.wheel, third.wheel_radius_m, third.dwell_s) == ("c", "", 0.035, None)
    assert third.rope_radius_m == 0.0049
    assert third.lift_force_N is None


def test_defaults(bench):
    bench.write('schema = "ropefric.campaign/1"\nname = "x"\ntrials = "t.csv"\n[rope]\nradius = "5 mm"\n')
    head = "file,wheel_radius_mm,wrap_turns,end_mass_kg\n"
    (bench.folder / "t.csv").write_text(f"{head}recordings/a.csv,40,1.5,10\n")
    campaign = load_campaign(bench.path)
    smoothing = campaign.smoothing
    assert (campaign.protocol.name, smoothing.mode, smoothing.window_s) == ("breakaway", "auto", None)
    assert (campaign.rejection, campaign.tare_interval_s, campaign.adc) == ("two-sigma", None, None)
    assert (campaign.design, campaign.cells, campaign.wheels) == (None, {}, {})
    (trial,) = campaign.trials
    assert trial.end_tension_N == pytest.approx(98.0665, rel=1e-15)
    assert trial.wrap_angle_rad == pytest.approx(3 * math.pi, rel=1e-15)


def test_any_unit_of_the_right_dimension(bench):
    good = bench.table.read_bytes()
    cases = (("end_tension_kN", "0.08", 80.0), ("End tension (N)", "80", 80.0),
        ("end_mass_g", "500", 4.903325))  # fmt: skip
    for column, cell, expected_N in cases:
        bench.write(trials=good)
        bench.spoil_table("end_tension_N", column)
        bench.spoil_table("180,80", f"180,{cell}")
        assert load_campaign(bench.path).trials[0].end_tension_N == pytest.approx(expected_N, rel=1e-15), (
            column
        )


def test_diameters_are_halved_and_rows_override_the_rope(bench):
    table = "file,wheel_diameter_in,rope_diameter_mm,wrap_deg,end_tension_N,cell,from_s,until_ms\n"
    bench.write(trials=table + "a.csv,2,12,180,80,K1,1,2500\nb.csv,4,,180,80,K1,,\n")
    first, second = load_campaign(bench.path).trials
    assert (first.wheel_radius_m, first.rope_radius_m) == (0.0254, 0.006)
    assert (first.start_s, first.stop_s) == (1.0, 2.5)
    assert (second.rope_radius_m, second.start_s, second.stop_s) == (0.0049, 0.0, 6.0)


def test_held_on_the_slack_side_needs_the_lift_force_instead(bench):
    bench.spoil('name = "breakaway"', 'name = "held"')
    bench.spoil('min_step = "5 N"\n', "")
    problem = bench.only()
    assert (problem.code, problem.line, problem.key) == ("RF121", 1, "lift_force_N")
    bench.spoil_table("end_tension_N", "lift_mass_kg")
    trial = load_campaign(bench.path).trials[0]
    assert (trial.end_tension_N, trial.lift_force_N) == (None, pytest.approx(80 * 9.80665))
    bench.spoil('name = "held"', 'name = "held"\nside = "tight"')
    assert bench.only().key == "end_tension_N"


def test_dialects_of_the_table_mean_the_same(bench):
    for encoding, marks in product(
        ("utf-8", "utf-8-sig", "cp1252", "utf-16"), (";,", "\t,", ";.", "\t.", ",.")
    ):
        separator, decimal = marks
        rows = [["file", "wheel_radius_mm", "wrap_angle_deg", "end_tension_N", "cell", "note"],
            ["a.csv", f"40{decimal}5", "180", f"1{decimal}234", "K1", "Prüfstand µ"],
            ["b.csv", "60", f"360{decimal}0", "120", "K1", ""]]  # fmt: skip
        newline = "\r\n" if separator == ";" else "\n"
        bench.write(trials="".join(separator.join(row) + newline for row in rows).encode(encoding))
        first, second = load_campaign(bench.path).trials
        assert (first.wheel_radius_m, first.end_tension_N, first.note) == (0.0405, 1.234, "Prüfstand µ"), (
            marks
        )
        assert second.wrap_angle_rad == 2 * math.pi


def test_byte_order_mark_and_windows_line_ends_in_the_campaign_file(bench):
    bench.write(toml=b"\xef\xbb\xbf" + bench.path.read_bytes().replace(b"\n", b"\r\n"))
    assert bench.problems() == ()
    bench.spoil('"9.8 mm"', "9.8")
    assert bench.only().line == 7


def test_comments_blank_lines_and_spreadsheet_leftovers_are_skipped(bench):
    text = bench.table.read_text().splitlines()
    bench.write(trials="\n".join(['# a comment, with "quotes', "", text[0] + ",,", ",,,,,",
        *(row + ",," for row in text[1:3])]))  # fmt: skip
    assert [trial.line for trial in load_campaign(bench.path).trials] == [5, 6]


def test_ignored_columns(bench):
    bench.spoil_table("exclude,note", "_mine,notes on weather")
    assert load_campaign(bench.path).trials[1].note == ""


def test_names_default_to_the_file_and_are_unique(bench):
    for name in ("sub/a.csv", "pull_0.5kN.csv.gz", "wide.csv"):
        bench.record(name)
    rows = ["file,sample,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell,trial"]
    files = ["a.csv,,", "sub\\a.csv,,", "pull_0.5kN.csv.gz,,", "wide.csv,S 1,", "wide.csv,S 2,", "b.csv,,b"]
    rows += [f"{file},{sample},40,180,80,K1,{name}" for file, sample, name in (f.split(",") for f in files)]
    rows.append("c.csv,*,40,180,80,K1,a-2")
    bench.write(trials="\n".join(rows))
    trials = load_campaign(bench.path).trials
    assert [t.trial for t in trials] == ["a", "a-3", "pull_0.5kN", "wide#S 1", "wide#S 2", "b", "a-2"]
    assert trials[1].path.is_file()
    assert trials[-1].sample == "*"


def test_survives_pickling_and_is_deterministic(bench):
    campaign = load_campaign(bench.path)
    assert pickle.loads(pickle.dumps(campaign)) == campaign == load_campaign(bench.path)  # noqa: S301


def test_resolved_is_json_without_absolute_paths(bench, tmp_path):
    resolved = load_campaign(bench.path).resolved()
    text = json.dumps(resolved, allow_nan=False)
    assert str(tmp_path) not in text
    assert resolved["smoothing"] == {"mode": "fixed", "window_s": 0.01, "peak": "smoothed"}
    assert resolved["cells"]["K1"]["points"] == [[0.0, 0.002], [500.0, 2.501]]


def test_a_moved_campaign_is_the_same_campaign(bench, tmp_path_factory):
    other = tmp_path_factory.mktemp("moved") / "copy"
    shutil.copytree(bench.folder, other)
    here, there = load_campaign(bench.path), load_campaign(other / "campaign.toml")
    assert here.resolved() == there.resolved()
    assert here.settings() == there.settings()


def test_the_fingerprint_sees_what_extraction_sees_and_nothing_else(bench):
    good, before = bench.path.read_bytes(), load_campaign(bench.path).settings()
    seen = [
        ('"1 kN"', '"2 kN"'), ("bits = 10", "bits = 12"), ('until = "6 s"', 'until = "5 s"'), ("490.9", "490.8"),
        ('"300 ms"', '"200 ms"'), ('"10 ms"', '"11 ms"'), ('"counts"', '"n"'),
        ('"0.05 %"', '"0.06 %"'), ('"3 kHz"', '"2 kHz"'), ("pressure * area", "area * pressure"),
        ("[wheels.W40]\n", '[wheels.W40]\ntolerance = "1 mm"\n'),
    ]  # fmt: skip
    unseen = [
        ("PRTH bench", "other"), ('"400 deg"', '"300 deg"'), ("grubbs", "none"), ('"10 ms"', '"0.01 s"'),
        ("62 g/m", "60 g/m"),
    ]  # fmt: skip
    for old, new in (*seen, *unseen):
        bench.write(toml=good)
        bench.spoil(old, new)
        found = load_campaign(bench.path).settings()
        assert (found == before) == ((old, new) in unseen), new
