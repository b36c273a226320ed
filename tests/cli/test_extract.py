"""`extract`: from a campaign to tables, figures, a summary; through the whole library."""

import csv

import pytest

CONDITION_KEYS = {*("wheel_radius_m", "wrap_angle_rad", "end_tension_N", "n", "n_kept", "rejected"),
    *("mean_all_N", "std_all_N", "mean_kept_N", "std_kept_N")}  # fmt: skip
TRIAL_KEYS = {*("trial", "file", "wheel_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N", "peak_raw_N"),
    *("peak_time_s", "kinetic_N", "status", "kept")}  # fmt: skip


def test_tables_figures_and_a_summary_and_json(call, bench, tmp_path):
    done = call("extract", bench / "campaign.toml", "--out", tmp_path / "out")
    assert done.code == 0
    for name in ("trials.csv", "conditions.csv", "problems.csv"):
        assert (tmp_path / "out" / name).exists()
    pictures = sorted(path.name for path in (tmp_path / "out" / "figures").glob("*.png"))
    assert pictures == ["Rw15mm_phi540deg_FB60N.png", "Rw30mm_phi540deg_FB60N.png"]
    for words in ("R_w [mm]", "φ [deg]", "F_B [N]", "mean F_A [N]", "540"):
        assert words in done.out
    assert "12 trials: 12 kept → " in done.err.splitlines()[-1]
    assert "figures 2/2" in done.err
    # JSON is the only thing on stdout; quiet leaves the result alone.
    again = call("extract", bench, "--out", tmp_path / "out", "--json", "--no-figures")
    result = again.json()
    assert (len(result["trials"]), len(result["conditions"])) == (12, 2)
    assert all(set(trial) >= TRIAL_KEYS for trial in result["trials"])
    assert all(set(condition) >= CONDITION_KEYS for condition in result["conditions"])
    assert "extract 12/12" in again.err
    quiet = call("extract", bench, "--out", tmp_path / "out", "--quiet", "--no-figures")
    assert (quiet.err, "mean F_A [N]" in quiet.out) == ("", True)


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes_however_it_is_worked_through(call, bench, tmp_path):
    runs = []
    for name, *options in (("a", "--jobs", "1"), ("b", "--jobs", "2"), ("a",)):
        out = tmp_path / name
        said = call("extract", bench, "--out", out, "--json", *options).out
        runs.append([said, *(p.read_bytes() for p in sorted(out.rglob("*")) if p.suffix in (".csv", ".png"))])
    assert (len(runs[0]), runs[1:]) == (1 + 3 + 2 * 3, runs[:1] * 2)


def test_a_bad_recording_is_listed_with_its_remedy_and_ends_nothing(call, campaign, tmp_path):
    victim = sorted((campaign / "traces").iterdir())[3]
    victim.write_bytes(b"")
    done = call("extract", campaign, "--out", tmp_path / "out", "--no-figures")
    assert done.code == 0
    assert all(one in done.out for one in ("1 of 12 trials are without a force", "unreadable"))
    assert "extract 12/12  100 % · 1 without a force" in done.err
    assert "12 trials: 11 kept, 1 without a force" in done.err
    with (tmp_path / "out" / "problems.csv").open(encoding="utf-8") as stream:
        assert any(victim.name in row["path"] for row in csv.DictReader(stream))


def test_a_campaign_without_a_usable_force_is_3_and_still_tells_everything(call, campaign, tmp_path):
    for path in (campaign / "traces").iterdir():
        path.write_bytes(b"")
    done = call("extract", campaign, "--out", tmp_path / "out", "--no-figures")
    assert done.code == 3
    assert all(one in done.err for one in ("error RF301", "none of the 12 recordings gave a usable force"))
    assert (tmp_path / "out" / "trials.csv").exists()
    result = call("extract", campaign, "--out", tmp_path / "out", "--json")
    assert (result.code, result.json()["error"]["code"]) == (3, "RF301")
    assert {trial["status"] for trial in result.json()["trials"]} == {"unreadable"}


def test_what_is_wrong_is_said_before_the_work(call, campaign, tmp_path):
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    done = call("extract", campaign, "--out", tmp_path / "taken")
    assert done.code == 3
    assert "taken" in done.err
    assert "extract 1/12" not in done.err
    for jobs in ("0", "many"):
        done = call("extract", campaign, "--out", tmp_path / "out", "--jobs", jobs)
        assert (done.code, "--jobs" in done.err) == (2, True)
    text = (campaign / "trials.csv").read_text(encoding="utf-8")
    (campaign / "trials.csv").write_text(text.replace("wrap_angle_deg", "warp_angle_deg"), encoding="utf-8")
    done = call("extract", campaign, "--out", tmp_path / "out")
    assert (done.code, done.out) == (3, "")
    assert "there is no column wrap_angle_deg" in done.err
    assert "error" in call("extract", campaign, "--out", tmp_path / "out", "--json").json()
