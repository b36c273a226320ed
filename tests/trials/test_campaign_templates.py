"""The templates are a campaign as they stand, and every setting they show can be used."""

import pytest

from ropefric.trials.campaign import check_campaign, load_campaign, write_templates


def test_templates_pass_once_there_is_a_recording(tmp_path):
    paths = write_templates(tmp_path / "new")
    (missing,) = [p for p in check_campaign(paths[0]) if p.severity == "error"]
    assert (missing.code, missing.key) == ("RF124", "file")
    recording = tmp_path / "new" / "recordings" / "pull_01.csv"
    recording.parent.mkdir()
    recording.write_text("time_s,force_N\n0,1\n")
    campaign = load_campaign(paths[0])
    assert [problem.code for problem in campaign.warnings] == ["RF310"]


def test_every_commented_setting_of_the_template_is_valid(tmp_path):
    """Take the '#' off every line that holds a setting: still a campaign (with counts, a cell and a formula)."""
    path, table = write_templates(tmp_path)
    lines = []
    for line in path.read_text().splitlines():
        bare = line.removeprefix("# ")
        is_setting = line.startswith("# [") or (
            line.startswith("# ") and bare.partition(" ")[2].lstrip().startswith("= ")
        )
        lines.append(bare if is_setting else line)
    text = "\n".join(lines).replace('"pull - pressure * area"', '"force * area / area"')
    path.write_text(text.replace('side = "slack"', "").replace("block_columns = 0", "block_columns = 2"))
    table.write_text("file,wheel,wrap_turns,end_tension_N,cell\na.csv,W40,1,80,K1\n")
    (tmp_path / "a.csv").write_text("x")
    campaign = load_campaign(path)
    assert campaign.cells["K1"].calibrated == "2026-01-15"
    assert campaign.design is not None
    assert campaign.profile.derived == {"force": "force * area / area"}


def test_templates_are_not_written_over(tmp_path):
    (tmp_path / "trials.csv").write_text("mine")
    with pytest.raises(ValueError, match="there already") as caught:
        write_templates(tmp_path)
    assert caught.value.where.endswith("trials.csv")
    assert not (tmp_path / "campaign.toml").exists()
    assert (tmp_path / "trials.csv").read_text() == "mine"
    assert [p.name for p in write_templates(tmp_path, overwrite=True)] == ["campaign.toml", "trials.csv"]
    assert (tmp_path / "trials.csv").read_text() != "mine"


def test_templates_need_a_folder(tmp_path):
    (tmp_path / "file").write_text("")
    for name in ("file", "fi\0le", "x" * 300):
        with pytest.raises(ValueError) as caught:
            write_templates(tmp_path / name)
        assert caught.value.code == "RF105"
