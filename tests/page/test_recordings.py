"""A folder becomes a campaign that is corrected before it is written; the files are those of the commands."""

import math
import shutil
import time
import tomllib

import pytest
from newcomer import PATTERN, write_daq

from ropefric.cli.app import main
from ropefric.errors import DataError, InputError
from ropefric.page import review
from ropefric.page.desk import Desk
from ropefric.page.recordings import Draft, wish_of
from ropefric.trials.campaign import check_campaign, template_texts

SENSITIVITIES = {"force": "25 N/mV", "end_tension": "40 N/mV"}
CELL = {"full_scale": "1 kN", "zero_voltage": "0 V", "full_scale_voltage": "5 V"}


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    write_daq(folder / "daq")
    for path in sorted((folder / "daq").iterdir())[4:]:
        path.unlink()
    return folder


def asked(lab, **more):
    return {"recordings": str(lab / "daq"), "pattern": PATTERN} | more


def corrected(lab, told):
    read = told["channels"].items()
    channels = {name: one | {"sensitivity": SENSITIVITIES.get(name, "")} for name, one in read}
    settings = {"name": "Mine", "rope": {"diameter": "10 mm"}, "tare": {"interval": ["0 s", "0.35 s"]}}
    settings["wheels"] = {"R30": {"radius": "30 mm"}}
    return wish_of(asked(lab, channels=channels, settings=settings))


def errors_of(told):
    return [one["message"] for one in told["problems"] if one["severity"] == "error"]


def test_what_is_proposed_is_what_init_writes(lab, tmp_path):
    draft = Draft(lab)
    told = draft.propose(wish_of(asked(lab)))
    assert told["header"] == ["file", "wheel", "wrap_angle_deg", "end_tension_N", "repeat"]
    assert [row[1] for row in told["rows"]] == ["R30"] * 4
    force = told["channels"]["force"]
    assert [force[name] for name in ("column", "unit", "sensitivity")] == ["Zugkraft [mV]", "mV", ""]
    (fix,) = (one["fix"] for one in told["problems"] if one["key"] == "import.channels.force")
    assert "sensitivity" in fix
    with pytest.raises(DataError, match="no such folder"):
        Draft(tmp_path / "nowhere").propose(wish_of(asked(lab)))
    draft = Draft(tmp_path)
    with pytest.raises(InputError, match="nothing is proposed"):
        draft.write(draft.shown, overwrite=False)
    with pytest.raises(InputError, match="no recording is read"):
        draft.trace(0, 100)
    draft.propose(wish_of(asked(lab)))
    # A recording is drawn in its own unit before anybody knows what that means.
    tree = draft.trace(0, 100)
    assert tree["units"] == {"force": "mV", "end_tension": "mV"}
    highest_mV = 20 * math.exp(0.21 * math.pi) / 25 + 0.31
    assert max(tree["curves"]["force"]["high_N"]) == pytest.approx(highest_mV, rel=0.02)
    assert len(tree["curves"]["force"]["time_s"]) <= 100
    draft.write(draft.shown, overwrite=False)
    words = ["init", str(tmp_path / "mine"), "--from", str(lab / "daq"), "--pattern", PATTERN, "--quiet"]
    assert main(words) == 0
    assert (tmp_path / "campaign.toml").read_bytes() == (tmp_path / "mine" / "campaign.toml").read_bytes()
    # One folder further down.
    listed = (tmp_path / "mine" / "trials.csv").read_bytes().replace(b"\n../", b"\n")
    assert (tmp_path / "trials.csv").read_bytes() == listed


def test_what_no_file_tells_is_put_in_and_nothing_is_left_to_say(lab, tmp_path):
    draft, seen = Draft(tmp_path), []

    def progress(done, total, item):
        seen.append((done, total))

    told = draft.propose(wish_of(asked(lab)), progress)
    assert seen == [(1, 4), (2, 4), (3, 4), (4, 4)]
    # Recordings are read again only where it matters.
    draft.propose(wish_of(asked(lab, settings={"rope": {"diameter": "8 mm"}})), progress)
    assert len(seen) == 4
    told = draft.propose(corrected(lab, told), progress)
    assert (len(seen), errors_of(told)) == (8, [])
    assert not (tmp_path / "campaign.toml").exists()
    path = draft.write(draft.shown, overwrite=False)
    assert not [one for one in check_campaign(path) if one.severity == "error"]
    text = path.read_text(encoding="utf-8")
    for said in ('name   = "Mine"', 'diameter = "10 mm" ', '[wheels.R30]\nradius = "30 mm"',
        '[tare]\ninterval = ["0 s", "0.35 s"]'):  # fmt: skip
        assert text.count(said) == 1
    with pytest.raises(DataError, match="somebody else"):  # the files are not those that were shown
        draft.write(told["shown"], overwrite=True)
    told = draft.propose(wish_of(asked(lab, settings={"name": "Other"})))
    assert told["there"] == ["campaign.toml", "trials.csv"]
    assert '+name   = "Other"' in told["difference"]
    with pytest.raises(InputError, match="already") as refused:
        draft.write(draft.shown, overwrite=False)
    assert (refused.value.code, path.read_text(encoding="utf-8")) == ("RF150", text)
    draft.write(draft.shown, overwrite=True)
    assert 'name   = "Other"' in path.read_text(encoding="utf-8")


def test_names_are_matched_without_reading(lab, tmp_path):
    draft = Draft(tmp_path)
    told = draft.names(str(lab / "daq"), "R{wheel_radius_mm}_{wrap_angle_deg}Grad_*_{repeat}")
    assert told["header"][:4] == ["file", "wheel_radius_mm", "wrap_angle_deg", "repeat"]
    assert told["rows"][0][1:4] == ["30", "180", "1"]
    with pytest.raises(InputError, match="none of 4 names matches"):
        draft.names(str(lab / "daq"), "W{repeat}")


def test_a_folder_may_have_any_name(lab, tmp_path):
    name = "-daq* [1] 50 % # Seil 'ü'"
    shutil.copytree(lab / "daq", tmp_path / name)
    draft = Draft(tmp_path)
    told = draft.propose(wish_of(asked(lab) | {"recordings": str(tmp_path / name)}))
    assert [row[0] for row in told["rows"]][::4] == [f"{name}/R30_180Grad_20N_1.txt"]
    assert draft.trace(0, 50)["units"]["force"] == "mV"
    assert not any("cannot be read" in one for one in told["said"])


WRONG = "rope = 3\nwheels = 4\nimport = 5\ntrials = 6\ndata = 7\n"


@pytest.mark.parametrize("text", [WRONG, 'schema = "ropefric.campaign/1"\n', 'trials = "no.csv"\n'])
def test_a_campaign_file_that_is_wrong_throughout_is_told_in_words(tmp_path, text):
    (tmp_path / "campaign.toml").write_text(text)
    draft = Draft(tmp_path, tmp_path / "campaign.toml")
    told = draft.propose(wish_of({"settings": {"name": "Mine"}}))
    assert (told["rows"], told["said"]) == ([], ["the list of trials names no recording"])
    assert errors_of(told)
    if text == WRONG:
        with pytest.raises(DataError, match="rope is a value where a table is needed"):
            draft.propose(wish_of({"settings": {"rope": {"diameter": "9 mm"}}}))


def test_a_template_takes_settings():
    settings = {"wheels": {"R 30": {"radius": "12 mm"}}, "design": {"wrap_angle": "90 deg"}}
    text = template_texts("", wish_of({"settings": settings}).settings)["campaign.toml"].decode()
    assert '\n[wheels."R 30"]\nradius = "12 mm"\n' in text
    assert '\n[design]\nwrap_angle = "90 deg"\n' in text


def test_a_desk_begins_with_what_stands_there(lab, campaign):
    desk = Desk(lab / "daq", by="me")
    assert (desk.campaign, desk.draft.home) == (None, lab)
    assert desk.state()["recordings"] == str(lab / "daq")
    toml, results = campaign / "campaign.toml", campaign / "results"
    for place in (campaign, toml):
        desk = Desk(place, by="me")
        assert (desk.campaign, desk.draft.home, desk.out) == (toml, campaign, campaign / "out")
    results.mkdir()
    desk = Desk(results, by="me", campaign=toml)
    assert (desk.campaign, desk.draft.home, desk.out) == (toml, campaign, results)
    (results / "manifest.json").write_text(
        '{"schema": "ropefric.run/1", "campaign": "../campaign.toml", "law": ""}'
    )
    assert (Desk(results, by="me").campaign, Desk(results, by="me").out) == (toml, results)
    with pytest.raises(InputError, match="no campaign is open"):
        _ = desk.opened


@pytest.fixture(scope="module")
def of_the_page(lab, tmp_path_factory):
    """A folder with a campaign that was written by the page, and then changed by its user in an editor."""
    draft = Draft(tmp_path_factory.mktemp("written"))
    draft.propose(corrected(lab, draft.propose(wish_of(asked(lab)))))
    path = draft.write(draft.shown, overwrite=False)
    text = path.read_text(encoding="utf-8").replace('name   = "Mine"', "name   = 'Mine'  # of spring")
    text = text.replace("[protocol]\n", '[protocol]\nwrap_tolerance = "1 deg"\n')
    path.write_text(text, encoding="utf-8")
    return path.parent


@pytest.fixture
def written(of_the_page, tmp_path_factory):
    """A copy of that campaign, which finds its recordings."""
    folder = tmp_path_factory.mktemp("written")
    return shutil.copytree(of_the_page, folder, dirs_exist_ok=True) / "campaign.toml"


def shown(draft):
    """What the page sends of a campaign that is there, where nobody has changed a field."""
    data, told = draft.form(), draft.propose(wish_of({}))
    names = ("name", "rope", "tare", "design", "adc", "wheels")
    settings = {"cells": {}} | {name: data[name] for name in names if name in data}
    given = {"format": data["import"].get("format", "")}
    settings["import"] = given | {"recording_column": "", "sampling_rate": ""}
    return {"channels": told["channels"], "settings": settings}


def test_a_campaign_that_is_there_is_changed_in_the_lines_that_were_asked_for(written):
    draft, before = Draft(written.parent, written), written.read_text(encoding="utf-8")
    tree = shown(draft)
    told = draft.propose(wish_of(tree))
    assert (told["difference"], told["there"], errors_of(told), len(told["rows"])) == ("", [], [], 4)
    tree["settings"]["rope"]["diameter"] = "11 mm"
    tree["settings"]["tare"]["interval"] = ""
    tree["settings"]["wheels"]["R30"]["radius"] = "31 mm"
    tree["settings"]["design"] = {"wheel_radius": "35 mm", "wrap_angle": "90 deg", "end_tension": "60 N"}
    tree["channels"]["force"]["sensitivity"] = "26 N/mV"
    told = draft.propose(wish_of(tree))
    lists = written.with_name("trials.csv").read_bytes()
    lines = told["difference"].splitlines()
    went, came = ({line[1:].strip() for line in lines if line[:1] == mark != line[1:2]} for mark in "-+")
    assert {line for line in came if line and "sensitivity" not in line and "diameter" not in line} == {
        *('radius = "31 mm"', "[design]", 'wheel_radius = "35 mm"'),
        *('wrap_angle = "90 deg"', 'end_tension = "60 N"'),
    }
    assert {"[tare]", 'interval = ["0 s", "0.35 s"]'} <= went
    assert draft.write(draft.shown, overwrite=True) == written
    after = written.read_text(encoding="utf-8")
    assert [one for one in check_campaign(written) if one.severity == "error"] == []
    for kept in ("name   = 'Mine'  # of spring", 'wrap_tolerance = "1 deg"', 'sensitivity = "26 N/mV"',
        'sensitivity = "40 N/mV"'):  # fmt: skip
        assert kept in after
    assert after.count("\n#") == before.count("\n#")
    assert written.with_name("trials.csv").read_bytes() == lists
    assert draft.trace(3, 50)["units"]["force"] == "N"


def test_a_campaign_changed_by_somebody_else_meanwhile_is_not_written_over(written):
    draft = Draft(written.parent, written)
    tree = shown(draft)
    tree["settings"]["name"] = "Other"
    assert "Other" in draft.propose(wish_of(tree))["difference"]
    theirs = written.read_bytes() + b"# theirs\n"
    written.write_bytes(theirs)
    with pytest.raises(DataError, match="somebody else") as refused:
        draft.write(draft.shown, overwrite=True)
    assert (refused.value.code, written.read_bytes()) == ("RF153", theirs)
    # Nor is a change shown that would take theirs back.
    with pytest.raises(DataError, match="somebody else"):
        draft.propose(wish_of(tree))
    assert Draft(written.parent, written).propose(wish_of(tree))["difference"].count("\n-") == 1


def test_of_two_windows_each_writes_only_what_it_has_shown_and_says_what_is_wrong_before(written):
    draft = Draft(written.parent, written)
    tree, before = shown(draft), written.read_bytes()
    tree["settings"]["name"] = "Mine too"
    mine = draft.propose(wish_of(tree))
    tree["settings"] |= {"name": "Theirs", "rope": {"diameter": "11"}}
    assert any("unit" in one for one in errors_of(draft.propose(wish_of(tree))))
    with pytest.raises(DataError, match="somebody else"):
        draft.write(mine["shown"], overwrite=True)
    assert written.read_bytes() == before


def test_channels_that_were_found_out_are_all_stated_once_one_is_changed(written):
    text = written.read_text(encoding="utf-8")
    written.write_text(text[: text.index("[import.channels]")], encoding="utf-8")
    draft = Draft(written.parent, written)
    tree = shown(draft)
    assert draft.propose(wish_of(tree))["difference"] == ""
    for name, one in tree["channels"].items():
        one["sensitivity"] = SENSITIVITIES.get(name, "")
    assert errors_of(draft.propose(wish_of(tree))) == []
    draft.write(draft.shown, overwrite=True)
    assert "Uhrzeit" in written.read_text(encoding="utf-8")
    assert not [one for one in check_campaign(written) if one.severity == "error"]


def test_force_cells_and_the_converter_are_stated_and_named_in_the_list(lab, tmp_path):
    (tmp_path / "daq").mkdir()
    for name in ("R30_180deg_20N_1.csv", "R30_360deg_20N_1.csv"):
        rows = [f"{i / 100},{100 + 3 * min(i, 200) - (60 if i > 200 else 0)}" for i in range(400)]
        (tmp_path / "daq" / name).write_text("time_s,counts\n" + "\n".join(rows) + "\n")
    pattern = "R{wheel_radius_mm}_{wrap_angle_deg}deg_{end_tension_N}N_{repeat}"
    tree = {"recordings": str(tmp_path / "daq"), "pattern": pattern}
    channels = {"time": {"column": "time_s", "unit": "s"}, "counts": {"column": "counts"}}
    settings = {"rope": {"diameter": "9 mm"}, "adc": {"bits": 12, "low": "0 V", "high": "5 V"}}
    settings["cells"] = {"K7": CELL | {"rated_output": ""}}
    draft = Draft(tmp_path)
    told = draft.propose(wish_of(tree | {"channels": channels}))
    assert any("force cell" in one for one in errors_of(told))
    tree |= {"channels": channels, "settings": settings, "cells": {"cell": "K7", "end_cell": ""}}
    told = draft.propose(wish_of(tree))
    assert (errors_of(told), told["header"][-1], {row[-1] for row in told["rows"]}) == ([], "cell", {"K7"})
    path = draft.write(draft.shown, overwrite=False)
    assert "[adc]\n" in path.read_text(encoding="utf-8")
    assert not [one for one in check_campaign(path) if one.severity == "error"]


def test_a_cell_that_the_list_names_is_described_in_a_campaign_that_is_there(written):
    """The page has a row for one more cell; an error of the list leads to it."""
    rows = written.with_name("trials.csv").read_text(encoding="utf-8").splitlines()
    with_cell = [f"{row},{'K2' if place else 'cell'}" for place, row in enumerate(rows)]
    written.with_name("trials.csv").write_text("\n".join([*with_cell, ""]), encoding="utf-8")
    draft = Draft(written.parent, written)
    told = draft.propose(wish_of(shown(draft)))
    fixes = {one["fix"] for one in told["problems"] if one["severity"] == "error"}
    assert fixes == {"describe it under [cells.K2] in the campaign file"}
    tree = shown(draft)
    tree["settings"]["cells"]["K2"] = CELL
    assert errors_of(draft.propose(wish_of(tree))) == []
    draft.write(draft.shown, overwrite=True)
    assert tomllib.loads(written.read_text(encoding="utf-8"))["cells"] == {"K2": CELL}
    assert [one for one in check_campaign(written) if one.severity == "error"] == []


@pytest.mark.slow
def test_after_a_setting_is_changed_only_what_depends_on_it_is_picked_again(written, monkeypatch):
    desk, extract, asked = Desk(written.parent, by="me"), review.extract_rows, []

    def extract_rows(campaign, **options):
        asked.append(len(campaign.trials))
        return extract(campaign, **options)

    monkeypatch.setattr(review, "extract_rows", extract_rows)
    monkeypatch.setattr(review, "_answered", lambda *_: 1 / 0)

    def done(name, **body):
        desk.writes[name](body)
        while (state := desk.work.state())["running"]:
            time.sleep(0.005)
        return state["result"]

    done("open")
    first = desk.review
    desk.writes["begin"]({})
    design = {"wheel_radius": "35 mm", "wrap_angle": "90 deg", "end_tension": "60 N"}
    told = done("propose", settings={"design": design})
    assert desk.writes["write"]({"shown": told["shown"], "overwrite": True})["ready"]
    done("open")
    assert desk.review is first
    assert desk.review.campaign.design is not None
    assert asked == [4, 0]  # none is picked again
    desk.close()
