"""`init`: templates that `check` understands."""


def test_templates_are_written_and_never_over_others_work(call, tmp_path):
    done = call("init", tmp_path / "mine")
    assert done.code == 0
    assert "wrote" in done.out
    assert "ropefric check" in done.err
    campaign = tmp_path / "mine" / "campaign.toml"
    campaign.write_text("mine", encoding="utf-8")
    again = call("init", tmp_path / "mine", "--json")
    assert again.code == 3
    assert "already" in again.json()["error"]["message"]
    assert campaign.read_text(encoding="utf-8") == "mine"
    assert call("init", tmp_path / "mine", "--force", "-q").code == 0
    assert campaign.read_text(encoding="utf-8") != "mine"


def test_what_is_left_to_do_is_said_by_check(call, tmp_path):
    call("init", tmp_path / "mine")
    done = call("check", tmp_path / "mine")
    assert done.code == 3
    errors = [
        p for p in call("check", tmp_path / "mine", "--json").json()["problems"] if p["severity"] == "error"
    ]
    assert errors
    assert all("is not there" in error["message"] for error in errors)  # only the recordings are missing


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
    wrong = call("init", tmp_path, "--scene", "band-swa")
    assert wrong.code == 3
    assert "did you mean 'band-saw'" in wrong.err
