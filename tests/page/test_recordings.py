"""A folder becomes a campaign that is corrected before it is written; the files are those of the commands."""

import pytest
from newcomer import PATTERN, write_daq

from ropefric.cli.app import main
from ropefric.errors import DataError, InputError
from ropefric.page.desk import Desk
from ropefric.page.recordings import Draft, wish_of
from ropefric.trials.campaign import check_campaign, template_texts

SENSITIVITIES = {"force": "25 N/mV", "end_tension": "40 N/mV"}


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
    channels = {
        name: one | {"sensitivity": SENSITIVITIES.get(name, "")} for name, one in told["channels"].items()
    }
    settings = {"": {"name": "Mine"}, "rope": {"diameter": "10 mm"}, "wheels.R30": {"radius": "30 mm"}}
    settings["tare"] = {"interval": ["0 s", "0.35 s"]}
    return wish_of(asked(lab, channels=channels, settings=settings))


def errors_of(told):
    return [one["message"] for one in told["problems"] if one["severity"] == "error"]


def test_what_is_proposed_is_what_init_writes(lab, tmp_path):
    draft = Draft(lab)
    told = draft.propose(wish_of(asked(lab)))
    assert (told["n_rows"], told["header"], told["wheels"]) == (
        4,
        ["file", "wheel", "wrap_angle_deg", "end_tension_N", "repeat"],
        ["R30"],
    )
    assert told["channels"]["force"] == {"column": "Zugkraft [mV]", "unit": "mV", "sensitivity": ""}
    assert any(
        "sensitivity" in one["fix"] for one in told["problems"] if one.get("key") == "import.channels.force"
    )
    draft.home = tmp_path
    draft._texts = {}
    with pytest.raises(InputError, match="nothing is proposed"):
        draft.write(overwrite=False)
    draft.propose(wish_of(asked(lab)))
    draft.write(overwrite=False)
    words = ["init", str(tmp_path / "mine"), "--from", str(lab / "daq"), "--pattern", PATTERN, "--quiet"]
    assert main(words) == 0
    assert (tmp_path / "campaign.toml").read_bytes() == (tmp_path / "mine" / "campaign.toml").read_bytes()
    # One folder further down.
    listed = (tmp_path / "mine" / "trials.csv").read_bytes().replace(b"\n../", b"\n")
    assert (tmp_path / "trials.csv").read_bytes() == listed


def test_what_no_file_tells_is_put_in_and_nothing_is_left_to_say(lab, tmp_path):
    draft = Draft(tmp_path)
    told = draft.propose(corrected(lab, draft.propose(wish_of(asked(lab)))))
    assert errors_of(told) == []
    assert not (tmp_path / "campaign.toml").exists()
    path = draft.write(overwrite=False)
    assert not [one for one in check_campaign(path) if one.severity == "error"]
    text = path.read_text(encoding="utf-8")
    for said in (
        'name   = "Mine"',
        'diameter = "10 mm" ',
        '[wheels.R30]\nradius = "30 mm"',
        '[tare]\ninterval = ["0 s", "0.35 s"]',
    ):
        assert text.count(said) == 1
    with pytest.raises(InputError, match="already") as refused:
        draft.write(overwrite=False)
    assert (refused.value.code, path.read_text(encoding="utf-8")) == ("RF150", text)
    draft.propose(wish_of(asked(lab, settings={"": {"name": "Other"}})))
    draft.write(overwrite=True)
    assert 'name   = "Other"' in path.read_text(encoding="utf-8")


def test_recordings_are_read_again_only_where_it_matters(lab, tmp_path):
    draft, seen = Draft(tmp_path), []

    def progress(done, total, item):
        seen.append((done, total))

    told = draft.propose(wish_of(asked(lab)), progress)
    assert seen == [(1, 4), (2, 4), (3, 4), (4, 4)]
    draft.propose(wish_of(asked(lab, settings={"rope": {"diameter": "8 mm"}})), progress)
    assert len(seen) == 4
    draft.propose(corrected(lab, told), progress)
    assert len(seen) == 8


def test_a_recording_is_drawn_in_its_own_unit_before_anybody_knows_what_that_means(lab, tmp_path):
    draft = Draft(tmp_path)
    with pytest.raises(InputError, match="no recording is read"):
        draft.trace(0, float("nan"), float("nan"), 100)
    draft.propose(wish_of(asked(lab)))
    tree = draft.trace(0, float("nan"), float("nan"), 100)
    assert tree["units"] == {"force": "mV", "end_tension": "mV"}
    assert max(tree["curves"]["force"]["high_N"]) == pytest.approx(
        20 * 2.718281828 ** (0.21 * 3.14159265) / 25 + 0.31, rel=0.02
    )
    assert len(tree["curves"]["force"]["time_s"]) <= 100


def test_names_are_matched_without_reading(lab, tmp_path):
    draft = Draft(tmp_path)
    told = draft.names(str(lab / "daq"), "R{wheel_radius_mm}_{wrap_angle_deg}Grad_*_{repeat}")
    assert told["header"][:4] == ["file", "wheel_radius_mm", "wrap_angle_deg", "repeat"]
    assert told["rows"][0][1:4] == ["30", "180", "1"]
    with pytest.raises(InputError, match="none of 4 names matches"):
        draft.names(str(lab / "daq"), "W{repeat}")


def test_a_folder_that_is_not_there_is_told(lab, tmp_path):
    with pytest.raises(DataError, match="no such folder"):
        Draft(tmp_path / "nowhere").propose(wish_of(asked(lab)))


@pytest.mark.parametrize(
    ("name", "table"), [("wheels.R 30", '[wheels."R 30"]'), ("wheels.W40", "\n[wheels.W40]")]
)
def test_a_template_takes_settings_in_the_line_that_waits_for_them(name, table):
    wish = wish_of(
        {"recordings": "x", "settings": {name: {"radius": "12 mm"}, "design": {"wrap_angle": "90 deg"}}}
    )
    text = template_texts("", wish.settings)["campaign.toml"].decode()
    assert f'{table}\nradius = "12 mm"' in text
    assert '\n[design]\n# wheel_radius = "35 mm"\nwrap_angle   = "90 deg"\n' in text
    assert template_texts()["campaign.toml"].decode().count("[design]") == 1


def test_a_desk_begins_with_what_stands_there(lab, campaign):
    desk = Desk(lab / "daq", by="me")
    assert (desk.campaign, desk.draft.home) == (None, lab)
    assert desk.state()["recordings"] == str(lab / "daq")
    for place in (campaign, campaign / "campaign.toml"):
        desk = Desk(place, by="me")
        assert (desk.campaign, desk.draft.home, desk.out) == (
            campaign / "campaign.toml",
            campaign,
            campaign / "out",
        )
    with pytest.raises(InputError, match="no campaign is open"):
        _ = desk.opened
