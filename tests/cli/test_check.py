"""`check`: all problems at once, and what a campaign holds."""

import shutil
from pathlib import Path

SCENES = Path(__file__).parents[2] / "data" / "scenes"


def test_a_sound_campaign_is_told_in_the_rigs_units_and_as_json_in_si(call, bench):
    done = call("check", bench / "campaign.toml")
    assert done.code == 0
    for fact in ("0 errors", "12 in 12 files", "15, 30 mm", "540 deg", "60 N", "two-sigma"):
        assert fact in done.out
    assert "read traces/c01-r01.csv.gz: " in done.out, "one recording of every kind"
    assert "3000 Hz" in done.out
    # One wrap and one tension: their effect cannot be seen. That does not fail.
    assert "warning RF" in done.err
    assert call("check", bench / "campaign.toml", "--quiet").err == ""
    tree = call("check", bench / "campaign.toml", "--json").json()
    held = tree["campaign"]
    assert (tree["ok"], held["n_trials"], held["repeats"]) == (True, 12, {"fewest": 6, "most": 6})
    assert (held["wheel_radius_m"], len(held["recordings"])) == ([0.015, 0.03], 1)
    assert "samples, 3000 Hz" in held["recordings"][0]


def test_all_errors_come_at_once_with_exit_3(call, bench, tmp_path):
    folder = tmp_path / "broken"
    shutil.copytree(bench, folder)
    trials = folder / "trials.csv"
    lines = trials.read_text(encoding="utf-8").splitlines()
    lines[2] = lines[2].replace(",540,", ",,")
    lines[4] = lines[4].replace(",60,", ",-60,")
    trials.write_text("\n".join(lines) + "\n", encoding="utf-8")
    done = call("check", folder / "campaign.toml")
    assert done.code == 3
    assert all(one in done.err for one in ("trials.csv:3", "trials.csv:5"))
    answer = call("check", folder / "campaign.toml", "--json").json()
    assert answer["ok"] is False
    assert {"code", "message", "where", "fix"} <= set(answer["error"])
    assert sum(problem["severity"] == "error" for problem in answer["problems"]) >= 2
    assert "campaign" not in answer


def test_a_campaign_that_is_not_there(call, tmp_path):
    done = call("check", tmp_path / "nope.toml")
    assert done.code == 3
    assert "nope.toml" in done.err
    assert call("check", tmp_path / "nope.toml", "--json").json()["error"]["where"].endswith("nope.toml")


def test_a_scene_is_checked_as_one(call, tmp_path):
    sound = call("check", SCENES / "hoist.toml")
    assert (sound.code, sound.err) == (0, "")
    assert "0 errors, 0 warnings" in sound.out
    path, text = tmp_path / "scene.toml", (SCENES / "hoist.toml").read_text(encoding="utf-8")
    text = text.replace("../../fits", (SCENES / "../../fits").as_posix())
    path.write_text(text.replace("540 deg", "540 mm").replace("9.8 mm", "9.8 N"), encoding="utf-8")
    broken = call("check", path)
    assert broken.code == 3
    for words in ("wheel.wrap", "rope.diameter"):
        assert words in broken.err
    assert "2 errors" in broken.out
    tree = call("check", path, "--json").json()
    assert (tree["ok"], len(tree["problems"])) == (False, 2)
    path.write_text('system = "hoist\n', encoding="utf-8")
    done = call("check", path, "--json")
    assert (done.code, len(done.json()["problems"])) == (3, 1)


def test_every_bundled_scene_passes(call):
    for path in sorted(SCENES.glob("*.toml")):
        assert call("check", path, "--json").json() == {"ok": True, "problems": []}, path.name


def test_recordings_that_cannot_be_read_are_an_error_told_once(call, bench, tmp_path):
    folder = tmp_path / "broken"
    shutil.copytree(bench, folder)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    column = next(line for line in text.splitlines() if line.startswith("time"))
    (folder / "campaign.toml").write_text(text.replace(column, 'time = "Zeit"'), encoding="utf-8")
    done = call("check", folder)
    assert (done.code, done.err.count("there is no column 'Zeit'")) == (3, 1)
    assert "1 error" in done.out
    assert "others of the 12 that end in '.csv.gz'" in done.err
    done = call("extract", folder, "--out", tmp_path / "out", "--no-figures")
    assert (done.code, done.out.count("there is no column 'Zeit'")) == (3, 1)
    assert "(12 trials)" in " ".join(done.out.split())
    assert "12 of them for one reason: there is no column 'Zeit'" in done.err


def test_a_single_bad_recording_is_a_warning(call, bench, tmp_path):
    folder = tmp_path / "bad"
    shutil.copytree(bench, folder)
    first = min((folder / "traces").iterdir())
    first.write_bytes(b"")
    done = call("check", folder)
    assert done.code == 0
    assert "the file is empty" in done.err


def test_dots_in_names_make_no_kinds(call, bench, tmp_path):
    folder = tmp_path / "dots"
    shutil.copytree(bench, folder)
    text = (folder / "trials.csv").read_text(encoding="utf-8")
    for number, path in enumerate(sorted((folder / "traces").iterdir())):
        name = f"pull_{number}.5N.csv.gz"
        text = text.replace(path.name, name)
        path.rename(path.with_name(name))
    (folder / "trials.csv").write_text(text, encoding="utf-8")
    assert len(call("check", folder, "--json").json()["campaign"]["recordings"]) == 1
