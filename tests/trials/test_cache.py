"""What was extracted once: reused while nothing changed, never trusted when damaged, never in the way."""

import hashlib
import json
import os
import re
import shutil
from dataclasses import asdict, replace

import numpy as np
import pytest
from thinned import thinned

from ropefric.plotting.campaign import start_condition_figures
from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
from ropefric.trials import extract as cache_module
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import ResultCache, extract_campaign
from ropefric.trials.result import write_tables
from ropefric.trials.workers import AHEAD


@pytest.fixture(scope="module")
def small_campaign(tmp_path_factory):
    """Six simulated recordings of two conditions, three of them spoilt; do not write to it."""
    folder = tmp_path_factory.mktemp("small")
    plan = prth_bench_plan()
    faults = {"no-peak": 0.17, "too-short": 0.17, "unreadable": 0.17}
    simulate_campaign(folder, replace(plan, conditions=plan.conditions[:2], repeats=3, faults=faults), seed=3)
    return folder


@pytest.fixture
def campaign(small_campaign, tmp_path):
    """Six recordings, some spoilt, in a folder of one's own."""
    shutil.copytree(small_campaign, tmp_path / "campaign")
    return tmp_path / "campaign"


@pytest.fixture
def store(tmp_path):
    return tmp_path / "cache"


@pytest.fixture(scope="module")
def filled(small_campaign, tmp_path_factory):
    """What was extracted, and the store it was put into."""
    store = tmp_path_factory.mktemp("filled") / "cache"
    return store, run(small_campaign, store)


def run(folder, store, **options):
    return extract_campaign(load_campaign(folder / "campaign.toml"), cache_dir=store, **options)


def spoil(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def tables(extraction, folder):
    return [path.read_bytes() for path in write_tables(extraction, folder)]


def assert_same(one, other, folder):
    assert one.to_dict() == other.to_dict()
    assert tables(one, folder) == tables(other, folder)
    for mine, theirs in zip(one.trials, other.trials, strict=True):
        # NaN is not equal to itself, but is written alike.
        assert repr(asdict(replace(mine, outline=None))) == repr(asdict(replace(theirs, outline=None)))
        assert (mine.outline is None) == (theirs.outline is None)
        if mine.outline is not None:
            for name in ("time_s", "low_N", "high_N", "smoothed_N"):
                np.testing.assert_array_equal(getattr(mine.outline, name), getattr(theirs.outline, name))


def test_a_second_run_extracts_nothing_and_says_the_same(campaign, store, tmp_path):
    fresh = extract_campaign(load_campaign(campaign / "campaign.toml"))
    first = run(campaign, store)
    assert (first.n_reused, len(list(store.iterdir()))) == (0, 6)
    stamps = {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in store.iterdir()}
    second = run(campaign, store)
    assert second.n_reused == 6
    assert {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in store.iterdir()} == stamps
    assert_same(fresh, first, tmp_path)
    assert_same(fresh, second, tmp_path)
    assert {trial.breakaway.status for trial in second.trials} == {"ok", "no-peak", "too-short", "unreadable"}


def test_figures_of_a_cached_run_show_the_same_data(campaign, store, tmp_path):
    for name in ("fresh", "cached"):
        start_condition_figures(run(campaign, store), tmp_path / name)(None)
    fresh = {path.name: path.read_bytes() for path in (tmp_path / "fresh").iterdir()}
    cached = {path.name: path.read_bytes() for path in (tmp_path / "cached").iterdir()}
    assert any(name.endswith(".csv") for name in fresh)
    assert cached == fresh


@pytest.mark.parametrize("jobs", [1, 2])
def test_whoever_works_finds_what_another_left(campaign, store, tmp_path, jobs):
    fresh = run(campaign, store, jobs=2)
    again = run(campaign, store, jobs=jobs)
    assert again.n_reused == 6
    assert_same(fresh, again, tmp_path)


def test_several_workers_fill_one_cache(campaign, store, tmp_path):
    first = run(campaign, store, jobs=2)
    assert sorted(path.suffix for path in store.iterdir()) == [".json"] * 6
    assert_same(first, run(campaign, store), tmp_path)


def test_a_changed_recording_alone_is_extracted_again(campaign, store, tmp_path):
    run(campaign, store)
    traces = sorted((campaign / "traces").iterdir())
    traces[0].write_bytes(traces[1].read_bytes())
    again = run(campaign, store)
    assert again.n_reused == 5
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)


def test_time_stamps_and_places_do_not_matter(campaign, store, tmp_path):
    run(campaign, store)
    for path in (campaign / "traces").iterdir():
        os.utime(path, (1e9, 1e9))
    campaign.rename(tmp_path / "elsewhere")
    assert run(tmp_path / "elsewhere", store).n_reused == 6


@pytest.mark.parametrize(
    ("old", "new"),
    thinned(
        [
            ('window = "auto"', 'window = "20 ms"'),
            ('name = "breakaway"', 'name = "breakaway"\nmin_step = "60 N"'),
            ('interval = ["0 s", "0.25 s"]', 'interval = ["0 s", "0.2 s"]'),
            ('linearity = "0.02 %FS"', 'linearity = "0.03 %FS"'),
            ('full_scale = "1 kN"', 'full_scale = "1001 N"'),
            ("bits = 10", "bits = 12"),
            ('tolerance = "0.05 %"', 'tolerance = "0.06 %"'),
            ('separator = ","', 'separator = ","\nheader_row = 1'),
        ]
    ),
)
def test_a_changed_setting_of_the_extraction_counts(campaign, store, tmp_path, old, new):
    before = run(campaign, store)
    spoil(campaign / "campaign.toml", old, new)
    again = run(campaign, store)
    assert again.n_reused == 0
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)
    if "header_row" not in new:
        assert again.to_dict() != before.to_dict()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('rule = "two-sigma"', 'rule = "none"'),
        ('material = "polyamide', 'material = "hemp'),
        ('wheel_radius = "35 mm"', 'wheel_radius = "36 mm"'),
        ('name = "prth-bench', 'name = "other'),
    ],
)
def test_settings_that_no_recording_depends_on_cost_nothing_and_are_obeyed(
    campaign, store, tmp_path, old, new
):
    run(campaign, store)
    spoil(campaign / "campaign.toml", old, new)
    again = run(campaign, store)
    assert again.n_reused == 6
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)


def test_another_radius_of_a_wheel_or_the_rope_reaches_the_results(campaign, store, tmp_path):
    run(campaign, store)
    spoil(campaign / "campaign.toml", 'radius = "30 mm"', 'radius = "31 mm"')
    spoil(campaign / "campaign.toml", 'diameter = "9.8 mm"', 'diameter = "9.9 mm"')
    again = run(campaign, store)
    assert {round(trial.rope_radius_m, 6) for trial in again.trials} == {0.00495}
    assert 0.031 in {trial.wheel_radius_m for trial in again.trials}
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)


@pytest.mark.parametrize(
    ("old", "new"), [(",60,", ",61,"), ("540", "541"), ("c01-r01,", "first,"), ("sim-rope-001", "mine")]
)
def test_a_changed_row_alone_is_extracted_again(campaign, store, tmp_path, old, new):
    run(campaign, store)
    spoil(campaign / "trials.csv", old, new)
    again = run(campaign, store)
    assert again.n_reused == 5
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)


def test_another_version_or_algorithm_uses_nothing_of_this_one(campaign, store, monkeypatch):
    run(campaign, store)
    for name, other in (
        ("hash_sources", lambda: "other"),
        ("__version__", "999"),
        ("SCHEMA", "other"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(cache_module, name, other)
            assert run(campaign, store).n_reused == 0
    assert run(campaign, store).n_reused == 6


def with_checksum(text):
    """What somebody who knows the form could have written."""
    return f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}"


def first_digit_changed(text):
    place = text.index('"peak_raw_N":') + len('"peak_raw_N":')
    return text[:place] + str((int(text[place]) + 1) % 10) + text[place + 1 :]


@pytest.mark.parametrize(
    "damage",
    thinned(
        [
            lambda text: "",
            lambda text: text[: len(text) // 2],
            lambda text: "not json",
            lambda text: "[]",
            lambda text: "{}",
            lambda text: "null",
            lambda text: "[" * 100_000,
            lambda text: "\0" * len(text),
            lambda text: "\ufeff" + text,
            lambda text: json.dumps([{"trial": "x"}]),
            first_digit_changed,
            lambda text: with_checksum("[]"),
            lambda text: with_checksum("[[]]"),
            lambda text: with_checksum('[["x"]]'),
            lambda text: with_checksum("[" * 100_000),
            lambda text: with_checksum(re.sub(r'"peak_N":[^,]*', '"peak_N":"1"', text.partition("\n")[2])),
            lambda text: with_checksum(re.sub(r'"peak_N":[^,]*', '"peak_N":true', text.partition("\n")[2])),
            lambda text: with_checksum(re.sub(r'"detail":"[^"]*"', '"detail":7', text.partition("\n")[2])),
            lambda text: with_checksum(re.sub(r'"file":"[^"]*"', '"file":"other"', text.partition("\n")[2])),
            lambda text: with_checksum(text.partition("\n")[2].replace('"outline":{', '"outline":{"x":[],')),
            lambda text: with_checksum(re.sub(r'"low_N":\[[^]]*', '"low_N":["a"', text.partition("\n")[2])),
            lambda text: with_checksum(re.sub(r'"low_N":\[[^]]*', '"low_N":[1', text.partition("\n")[2])),
            lambda text: with_checksum(
                re.sub(r'"status":"[^"]*"', '"status":"fine"', text.partition("\n")[2])
            ),
        ]
    ),
)
def test_a_damaged_entry_counts_as_none(small_campaign, filled, store, tmp_path, damage):
    campaign, (kept, first) = small_campaign, filled
    shutil.copytree(kept, store)
    entries = sorted(store.iterdir())
    (good,) = [path for path in entries if '"trial":"c01-r01"' in path.read_text(encoding="utf-8")]
    good.write_text(damage(good.read_text(encoding="utf-8")), encoding="utf-8")
    again = run(campaign, store)
    assert again.n_reused == 5
    assert_same(first, again, tmp_path)
    assert run(campaign, store).n_reused == 6  # mended


def test_bytes_that_are_no_text_and_folders_in_the_place_of_entries_are_ignored(campaign, store, tmp_path):
    first = run(campaign, store)
    one, other, *_ = sorted(store.iterdir())
    one.write_bytes(b"\xff\xfe\x80" * 50)
    other.unlink()
    other.mkdir()
    again = run(campaign, store)
    assert again.n_reused == 4
    assert_same(first, again, tmp_path)


def test_a_cache_that_cannot_be_written_is_no_error(campaign, store, tmp_path):
    store.write_text("a file where the folder should be", encoding="utf-8")
    first = run(campaign, store)
    assert first.n_reused == 0
    assert_same(first, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)
    assert store.read_text(encoding="utf-8") == "a file where the folder should be"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_no_error(campaign, store):
    store.mkdir(mode=0o500)
    assert run(campaign, store).n_reused == 0


def test_a_recording_that_was_not_there_is_looked_for_again(campaign, store):
    victim = campaign / "traces" / "c01-r01.csv.gz"
    kept = victim.read_bytes()
    victim.unlink()
    loaded = load_campaign(campaign / "campaign.toml", missing_recordings="flag")
    assert extract_campaign(loaded, cache_dir=store).trials[0].breakaway.status == "unreadable"
    victim.write_bytes(kept)
    again = extract_campaign(loaded, cache_dir=store)
    assert again.n_reused == 5
    assert again.trials[0].breakaway.status == "ok"


@pytest.mark.parametrize(("jobs", "after"), [(1, 1), (1, 4), (2, 1)])
def test_an_interrupted_run_keeps_what_is_done(campaign, store, tmp_path, jobs, after):
    def stop(done, total, text):
        if done == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(campaign, store, jobs=jobs, progress=stop)
    kept = len(list(store.glob("*.json")))
    assert after <= kept <= 6
    assert list(store.glob("*.part")) == []
    assert kept <= after + AHEAD * jobs  # what the processes had in hand
    again = run(campaign, store)
    assert again.n_reused == kept
    assert_same(again, extract_campaign(load_campaign(campaign / "campaign.toml")), tmp_path)


def test_a_recording_without_a_hash_is_neither_stored_nor_found(store, filled):
    results = ResultCache(store, "settings")
    results.store((), "", (filled[1].trials[:1],))
    assert not store.exists()
    assert results.load((), "") is None
