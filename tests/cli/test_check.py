"""`check`: all problems at once, and what a campaign holds."""

from pathlib import Path

SCENES = Path(__file__).parents[2] / "data" / "scenes"


def test_a_sound_campaign_is_told_in_the_rigs_units_and_as_json_in_si(call, bench):
    done = call("check", bench / "campaign.toml")
    assert done.code == 0
    for fact in ("0 errors", "12 in 12 files", "15, 30 mm", "540 deg", "60 N", "two-sigma"):
        assert fact in done.out
    assert "read traces/c01-r01.csv.gz: " in done.out, "one recording of every kind"
    assert "3000 Hz" in done.out
    # One wrap and one tension: what cannot be judged is stated. That does not fail.
    assert "wrap-power: cannot be judged" in done.out
    assert done.err == ""
    tree = call("check", bench / "campaign.toml", "--json").json()
    held = tree["campaign"]
    assert (tree["ok"], held["n_trials"], held["repeats"]) == (True, 12, {"fewest": 6, "most": 6})
    assert (held["wheel_radius_m"], len(held["recordings"])) == ([0.015, 0.03], 1)
    assert "samples, 3000 Hz" in held["recordings"][0]


def test_all_errors_come_at_once_with_exit_3(call, campaign):
    trials = campaign / "trials.csv"
    lines = trials.read_text(encoding="utf-8").splitlines()
    lines[2] = lines[2].replace(",540,", ",,")
    lines[4] = lines[4].replace(",60,", ",-60,")
    trials.write_text("\n".join(lines) + "\n", encoding="utf-8")
    done = call("check", campaign / "campaign.toml")
    assert done.code == 3
    assert all(one in done.err for one in ("trials.csv:3", "trials.csv:5"))
    answer = call("check", campaign / "campaign.toml", "--json").json()
    assert answer["ok"] is False
    assert {"code", "message", "where", "fix"} <= set(answer["error"])
    assert sum(problem["severity"] == "error" for problem in answer["problems"]) >= 2
    assert "campaign" not in answer
    nowhere = call("check", campaign / "nope.toml", "--json")
    assert (nowhere.code, nowhere.json()["error"]["where"][-9:]) == (3, "nope.toml")


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


def test_recordings_that_cannot_be_read_are_an_error_told_once(call, campaign, tmp_path):
    text = (campaign / "campaign.toml").read_text(encoding="utf-8")
    column = next(line for line in text.splitlines() if line.startswith("time"))
    (campaign / "campaign.toml").write_text(text.replace(column, 'time = "Zeit"'), encoding="utf-8")
    done = call("check", campaign)
    assert (done.code, done.err.count("there is no column 'Zeit'")) == (3, 1)
    assert "1 error" in done.out
    done = call("extract", campaign, "--out", tmp_path / "out", "--no-figures")
    assert (done.code, done.out.count("there is no column 'Zeit'")) == (3, 1)
    assert "(12 trials)" in " ".join(done.out.split())
    assert "12 of them for one reason: there is no column 'Zeit'" in done.err


def test_one_cause_is_one_line_and_all_causes_come_at_once(call, campaign, tmp_path):
    """Two wheels that are not described, an import that does not fit, two recordings that are not there."""
    toml, table = campaign / "campaign.toml", campaign / "trials.csv"
    text = toml.read_text(encoding="utf-8")
    column = next(line for line in text.splitlines() if line.startswith("time"))
    toml.write_text(text.replace(column, 'time = "Zeit"'), encoding="utf-8")
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    wheel = head.split(",").index("wheel")
    rows = [row.split(",") for row in rows]
    for number, row in enumerate(rows):
        row[wheel] = f"X{number % 2}"
    lost = [
        ["lost" if i == 0 else cell.replace("c01-r01", f"gone{n}") for i, cell in enumerate(rows[0])]
        for n in range(9)
    ]
    lost = [[f"lost{n}", *row[1:]] for n, row in enumerate(lost)]
    table.write_text("\n".join([head, *map(",".join, [*rows, *lost]), ""]), encoding="utf-8")
    for command in (["check"], ["run", "--out", tmp_path / "out"], ["extract", "--out", tmp_path / "out"]):
        done = call(command[0], campaign, *command[1:], "--quiet")
        told = [line for line in done.err.splitlines() if line.startswith("error")]
        first, second, third, last = told if command[0] != "extract" else (*told[:2], "", told[2])
        assert "unknown wheel 'X0'" in first
        assert "(15 times: lines 2, 4, 6, …; --json lists all)" in first
        assert "unknown wheel 'X1'" in second
        assert "(6 times: lines 3, 5, 7, …; --json lists all)" in second
        assert not third or "(9 such: lines 14, 15, 16, …; --json lists all)" in third
        assert "there is no column 'Zeit'" in last
        assert done.code == 3
    answer = call("check", campaign, "--json").json()
    assert len(answer["problems"]) == 21 + 9 + 1 + sum(
        one["severity"] == "warning" for one in answer["problems"]
    )


def test_dots_in_names_make_no_kinds_and_a_single_bad_recording_is_a_warning(call, campaign):
    text = (campaign / "trials.csv").read_text(encoding="utf-8")
    for number, path in enumerate(sorted((campaign / "traces").iterdir())):
        name = f"pull_{number}.5N.csv.gz"
        text = text.replace(path.name, name)
        path.rename(path.with_name(name))
    (campaign / "trials.csv").write_text(text, encoding="utf-8")
    assert len(call("check", campaign, "--json").json()["campaign"]["recordings"]) == 1
    min((campaign / "traces").iterdir()).write_bytes(b"")
    done = call("check", campaign)
    assert done.code == 0
    assert "the file is empty" in done.err
