"""`init`: templates that `check` understands."""

import re


def test_templates_are_written_never_over_others_work_and_check_says_what_is_left_to_do(call, tmp_path):
    done = call("init", tmp_path / "mine")
    assert done.code == 0
    assert "wrote" in done.out
    assert "ropefric check" in done.err
    campaign = tmp_path / "mine" / "campaign.toml"
    campaign.write_text("mine", encoding="utf-8")
    spaced = call("init", tmp_path / "Prüf stand").err  # to be copied into a shell
    assert spaced.endswith(f"ropefric check '{tmp_path / 'Prüf stand' / 'campaign.toml'}'\n")
    again = call("init", tmp_path / "mine", "--json")
    assert again.code == 3
    assert "already" in again.json()["error"]["message"]
    assert campaign.read_text(encoding="utf-8") == "mine"
    assert call("init", tmp_path / "mine", "--force", "-q").code == 0
    assert campaign.read_text(encoding="utf-8") != "mine"
    # Only the recordings are missing.
    done = call("check", tmp_path / "mine", "--json")
    errors = [p["message"] for p in done.json()["problems"] if p["severity"] == "error"]
    assert (done.code, bool(errors)) == (3, True)
    assert all("is not there" in message for message in errors)


def test_scenes_can_be_solved_at_once(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call("init", "my", "--scenes")
    assert done.code == 0
    assert "ropefric solve my/hoist.toml" in done.err
    assert not (tmp_path / "my" / "campaign.toml").exists()
    solved = call("solve", "my/hoist.toml", "--json")
    assert solved.code == 0
    assert 300 < solved.json()["lift_force_N"] < 340
    assert call("init", "my", "--scenes").code == 3


def test_single_scenes_are_asked_for_by_name(call, tmp_path):
    done = call("init", tmp_path, "--scene", "band-saw", "--scene", "many-turns", "--json")
    assert [path.rsplit("/", 1)[1] for path in done.json()["written"]] == ["band-saw.toml", "many-turns.toml"]
    assert [*done.json()["keys"]] == ["bandsaw", "hoist"]
    said = call("init", tmp_path, "--scene", "hoist").err
    assert re.search(r"^  wheel\.radius +m +needed +\w.*\.$", said, re.MULTILINE)
    wrong = call("init", tmp_path, "--scene", "band-swa")
    assert wrong.code == 3
    assert "did you mean 'band-saw'" in wrong.err


def recordings(tmp_path, *names):
    for name in names:
        (tmp_path / "daq" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "daq" / name).write_text("time_s,force_N\n0,1\n", encoding="utf-8")


NAMES = [f"W35_{wrap}deg_{load}N_{k}.csv" for wrap in (90, 180) for load in ("20", "40,5")
    for k in (1, 2, 10)]  # fmt: skip


def test_a_list_of_trials_is_made_from_names(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recordings(tmp_path, *NAMES, "notes.csv")
    pattern = "{wheel}_{wrap_angle_deg}deg_{end_tension_N}N_{repeat}"
    done = call("init", "mine", "--from", "daq/*.csv", "--pattern", pattern)
    assert done.code == 0
    assert "1 of 13 names do not match the pattern and are left out: daq/notes.csv" in done.err
    rows = (tmp_path / "mine" / "trials.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "file,wheel,wrap_angle_deg,end_tension_N,repeat"
    assert rows[1] == "../daq/W35_90deg_20N_1.csv,W35,90,20,1"
    assert [row.rsplit(",", 1)[1] for row in rows[1:4]] == ["1", "2", "10"]  # as people count
    assert "40.5" in rows[4]
    campaign = tmp_path / "mine" / "campaign.toml"
    text = campaign.read_text(encoding="utf-8")
    campaign.write_text(text.replace("# [wheels.W40]", '[wheels.W35]\nradius = "35 mm"'), encoding="utf-8")
    problems = call("check", "mine", "--json").json()["problems"]
    assert problems[0]["code"] != "RF124", "the recordings are there"


def test_nothing_is_written_over(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recordings(tmp_path, *NAMES)
    pattern = "W{wheel_radius_mm}_{wrap_angle_deg}deg_*"
    call("init", "mine", "--from", "daq/*.csv", "--pattern", pattern)
    rows = (tmp_path / "mine" / "trials.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "file,wheel_radius_mm,wrap_angle_deg,end_tension_N"
    assert rows[1].endswith("_1.csv,35,90,")  # the tension is left to fill in
    assert call("init", "mine", "--from", "daq/*.csv").code == 3
    (tmp_path / "mine" / "trials.csv").unlink()
    (tmp_path / "mine" / "campaign.toml").write_text("mine", encoding="utf-8")
    assert call("init", "mine", "--from", "daq/*.csv", "-q").code == 0  # a list beside a campaign
    assert (tmp_path / "mine" / "campaign.toml").read_text(encoding="utf-8") == "mine"


def test_folders_say_things_too(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recordings(tmp_path, "R40/180deg/a1.csv.gz", "R40/360deg/a1.csv.gz")
    pattern = "R{wheel_radius_mm}/{wrap_angle_deg}deg/*{repeat}"
    call("init", ".", "--from", "daq/**/*.gz", "--pattern", pattern)
    rows = (tmp_path / "trials.csv").read_text(encoding="utf-8").splitlines()
    assert rows[1:] == ["daq/R40/180deg/a1.csv.gz,40,180,a1,", "daq/R40/360deg/a1.csv.gz,40,360,a1,"]


def test_what_does_not_match_is_helped_with(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recordings(tmp_path, *NAMES)
    none = call("init", "mine", "--from", "daq/*.txt", "--json").json()["error"]
    assert "no file matches" in none["message"]
    words = ("init", "mine", "--from", "daq/*.csv", "--pattern")
    none = call(*words, "{wheel}-{repeat}", "--json").json()["error"]
    assert all(one in none["message"] for one in ("none of 12 names matches", "'daq/W35_90deg_20N_1.csv'"))
    assert "{header}" in none["fix"]
    unit = call(*words, "{wheel}_{wrap_angle}deg_*", "--json")
    assert (unit.code, unit.json()["error"]["code"]) == (3, "RF130")
    for wrong in ("{1a}", "{wheel}_{wheel}", "plain"):
        assert call(*words, wrong).code == 3
    assert call("init", "mine", "--pattern", "{wheel}").code == 3
    assert not (tmp_path / "mine").exists()


def test_heads_of_several_lengths_are_one_campaign(call, tmp_path):
    (tmp_path / "daq").mkdir()
    rows = "".join(f"{i / 25:.2f},{2 * i}\n" for i in range(60))
    for name, head in (("a", ""), ("b", "Rate,60,mm/min\n\n"), ("c", "Specimen 7\nOperator: me\n\n")):
        (tmp_path / "daq" / f"{name}.csv").write_text(f"{head}Time,Load\n(s),(N)\n{rows}", encoding="utf-8")
    done = call("init", tmp_path / "mine", "--from", tmp_path / "daq")
    assert (done.code, "not read" in done.err) == (0, False)
    section = (tmp_path / "mine" / "campaign.toml").read_text(encoding="utf-8").partition("[import]")[2]
    assert ("data_row" in section, 'force = "Load"' in section) == (False, True)
