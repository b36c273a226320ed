"""What the page says of a law, of wheels and of machines is what the commands say."""

import json

import pytest

from ropefric.cli.app import main
from ropefric.errors import DataError
from ropefric.fitting import compare
from ropefric.page import answers
from ropefric.scenes.keys import scene_keys
from ropefric.scenes.kinds import KINDS


@pytest.fixture
def reviewed(begin, settled, monkeypatch):
    """A review of the campaign with few laws, and what all its trials say."""
    monkeypatch.setattr(compare, "LAWS", {name: compare.LAWS[name] for name in compare.ALWAYS})
    review = begin(fits=True)
    settled(review)
    return review, review.run()


@pytest.fixture
def machines():
    made = answers.Machines()
    yield made
    made.close()


def test_laws_data_and_wheels_are_those_of_the_commands(reviewed, settled, campaign, capfd):
    review, run = reviewed
    out = campaign / "fresh"
    main(["run", str(campaign / "campaign.toml"), "--out", str(out), "--no-figures", "--quiet", "--json"])
    told, tree = json.loads(capfd.readouterr().out), answers.law_of(review, run)
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    assert (tree["law"], tree["verdict"]) == (told["law"], told["verdict"])
    assert [one["law"] for one in tree["ranking"]] == [one["law"] for one in told["ranking"]]
    (used,) = (one for one in tree["ranking"] if one["law"] == tree["law"])
    assert used["verdict"] in {"supported", "undecided", "not judged"}
    points = [point for one in tree["series"] for point in one["points"]]
    assert len(points) == told["fit"]["statistics"]["n_conditions"]
    assert all(low < force < high for _, force, low, high in points)

    wheel = ("--wheel-radius", "35 mm", "--wrap", "300 deg", "--end-tension", "60 N", "--json")
    fit = str(out / "fits" / f"{tree['law']}.json")
    main(["predict", "--fit", fit, *wheel])
    said = json.loads(capfd.readouterr().out)
    rope_m = run.campaign.rope.radius_m
    at = {
        "wheel_radius_m": 0.035,
        "rope_radius_m": rope_m,
        "wrap_angle_rad": 300 * 3.141592653589793 / 180,
        "end_tension_N": 60.0,
    }
    lift = answers.lift_of(run, at)
    assert lift["lift_force_N"] == pytest.approx(said["lift_force_N"], rel=1e-6)
    assert lift["interval_N"] == pytest.approx(said["interval_N"], rel=1e-4)
    main(
        [
            "design",
            "--fit",
            fit,
            "--lift",
            "200 N",
            "--wheel-radius",
            "35 mm",
            "--end-tension",
            "60 N",
            "--json",
        ]
    )
    said = json.loads(capfd.readouterr().out)
    found = answers.inverse_of(run, 200.0, "wrap", 0.95, at)
    assert (found["status"], found["wrap_angle_rad"]) == (
        said["status"],
        pytest.approx(said["wrap_angle_rad"], rel=1e-5),
    )


def test_a_condition_is_switched_off_with_a_reason_and_on_again(reviewed, settled):
    review, run = reviewed
    one = answers.law_of(review, run)["conditions"][0]
    names = [name for name, row in review.overview()["rows"].items() if row["condition"] == one["words"]]
    first = names[0]
    review.decide(first, "exclude", text="torn")
    review.switch(one["trial"] if one["trial"] != first else names[1], "wet rope")
    rows = review.overview()["rows"]
    assert [rows[name]["excluded"] for name in names] == ["torn", *["wet rope"] * (len(names) - 1)]
    settled(review)
    review.switch(names[1], "")
    rows = review.overview()["rows"]
    assert [rows[name]["excluded"] for name in names] == ["torn", *[""] * (len(names) - 1)]


def test_another_law_is_used_where_that_is_asked(reviewed, settled):
    review, run = reviewed
    other = next(one.law for one in run.answer.comparison.ranking if one.law != run.answer.fit.law)
    review.use_law(other)
    assert settled(review)["now"]["law"] == other
    assert answers.law_of(review, review.run())["asked"] == other
    with pytest.raises(LookupError):
        review.use_law("nonsense")


def test_every_template_is_a_form_that_solves_as_the_command_does(machines, tmp_path, capfd):
    names = [one["name"] for one in machines.names()]
    assert {"hoist", "belt-press", "band-saw", "traction", "belt-drive"} <= set(names)
    for name in names:
        rows = machines.form(name)
        assert len({row["key"] for row in rows}) == len(rows)
        assert all(
            row["value"] for row in rows[: sum(bool(row["value"]) for row in rows)]
        )  # what is given stands first
    assert main(["init", str(tmp_path), "--scene", "hoist", "--quiet"]) == 0
    capfd.readouterr()
    main(["solve", str(tmp_path / "hoist.toml"), "--json"])
    said = json.loads(capfd.readouterr().out)
    told = machines.solve("hoist", {}, None)
    assert told["answer"]["lift_force_N"] == pytest.approx(said["lift_force_N"], rel=1e-6)
    more = machines.solve("hoist", {"wheel.wrap": "720 deg"}, None)
    assert more["answer"]["lift_force_N"] > told["answer"]["lift_force_N"]
    assert {one["fate"] for one in told["effects"]} <= {"simulated", "left out", "not applicable"}
    with pytest.raises(DataError, match="wrap"):
        machines.solve("hoist", {"wheel.wrap": "720"}, None)
    with pytest.raises(KeyError):
        machines.form("../../etc/passwd")


def test_the_law_of_the_campaign_drives_a_machine(reviewed, machines):
    _, run = reviewed
    told = machines.solve("hoist", {}, run.answer.fit)
    assert told["answer"]["lift_force_N"] > 0
    assert told["answer"] != machines.solve("hoist", {}, None)["answer"]


def test_every_key_says_what_it_is():
    for kind in KINDS.values():
        for one in scene_keys(kind.schema):
            assert one.meaning or one.name in {"system", "effects", "accuracy", "tolerances", "plugins"}, (
                one.name
            )
