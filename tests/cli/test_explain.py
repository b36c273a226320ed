"""`ropefric explain`: which effects are simulated, why, and what they turn out to be worth."""

import json
from pathlib import Path

import pytest

SCENES = Path(__file__).parents[2] / "data" / "scenes"
KEYS = {"name", "simulated", "fate", "bound", "why", "missing", "adds", "instead", "worth",
    "time_s", "time_spread_s"}  # fmt: skip
EFFECTS = {"climbing-hoist": ["wrap-dependence", "size", "end-tension", "rope-weight", "centrifugal",
    "bending-stiffness"], "fast-belt-press": ["gravity-load", "squeeze-load", "belt-inertia",
    "tensioner-spring", "belt-elasticity", "elastic-creep", "wrap-dependence", "size", "belt-damping",
    "tensioner-damping", "arc-inertia", "transient-friction", "transient"],
    "fast-band-saw": ["tension-difference", "wheel-inertia-tension", "travel", "bending",
    "torsion"]}  # fmt: skip


@pytest.fixture(autouse=True)
def two_rounds(monkeypatch):
    """Times are those of the fewest rounds there are."""
    monkeypatch.setattr("ropefric.scenes.explain._LONG_S", 0.0)


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_is_told_of_and_measured_it_is_within_what_was_promised(call, name):
    done = call("explain", SCENES / f"{name}.toml", "--measure", "--json")
    assert done.code == 0, done.err
    tree = done.json()
    assert sorted(one["name"] for one in tree["effects"]) == sorted(EFFECTS[name])
    assert all(set(one) == KEYS for one in tree["effects"])
    assert done.out == json.dumps(tree, indent=2, sort_keys=True, ensure_ascii=False) + "\n"
    rounding = 1e-9 + tree["method"]["error"]
    for one in tree["effects"]:
        if one["fate"] == "not applicable":
            assert one["worth"] is None
            assert one["missing"]
        elif one["bound"] is not None and one["worth"] is not None:
            # A worth counted from the planned answer is e^bound − 1 at most, either way round.
            assert one["worth"] <= one["bound"] + rounding, one["name"]
    assert tree["measured"]["difference"] <= min(tree["accuracy"], tree["error_bound"])
    assert tree["measured"]["planned_s"] > 0.0
    assert tree["measured"]["all_effects_s"] > 0.0


def test_words_say_fate_worth_and_reason(call):
    done = call("explain", SCENES / "climbing-hoist.toml", "--measure", "--quiet")
    flat = " ".join(done.out.split())
    assert all(one in flat for one in ("centrifugal yes 4.2e-05", "as planned"))
    assert "the scene does not give rope.bending_stiffness" in flat
    assert done.err == ""


def test_without_a_start_up_its_effects_ask_for_one_and_nothing_else(call):
    done = call("explain", SCENES / "belt-press.toml", "--json")
    missing = {one["name"]: one["missing"] for one in done.json()["effects"]}
    for name in ("belt-damping", "tensioner-damping", "arc-inertia", "transient"):
        assert missing[name] == ["start_up"]
    flat = " ".join(call("explain", SCENES / "belt-press.toml").out.split())
    assert flat.count("the scene does not give start_up") == 1, "once for all that need it"
    assert "tensioner-damping, arc-inertia, transient-friction, transient: " in flat


def test_a_long_list_of_missing_keys_is_cut_short_in_words_and_whole_in_json(call, tmp_path):
    path = tmp_path / "scene.toml"
    text = ((SCENES / "belt-press.toml").read_text(encoding="utf-8").replace('effects = "auto"',
        "effects = []"))  # fmt: skip
    path.write_text(text + '\n[start_up]\nlaw = "ramp"\nduration = "1 s"\nsimulate = "2 s"\n',
        encoding="utf-8")  # fmt: skip
    done = call("explain", path, "--json")
    (transient,) = (one for one in done.json()["effects"] if one["name"] == "transient")
    told = " ".join(call("explain", path).out.split())
    n = len(transient["missing"])
    assert n > 4
    assert (f"transient: the scene does not give {', '.join(transient['missing'][:4])} and {n - 4} more" in
        told)  # fmt: skip
    assert all(key in transient["why"] for key in transient["missing"])


def test_a_picture_and_the_json_of_it_are_written(call, tmp_path):
    done = call("explain", SCENES / "fast-band-saw.toml", "--measure", "--out", tmp_path / "told", "--json")
    assert done.code == 0, done.err
    tree = done.json()
    assert [Path(one).name for one in tree["files"]] == ["explanation.json", "effects.png", "effects.csv"]
    assert (json.loads((tmp_path / "told" / "explanation.json").read_text(encoding="utf-8"))["system"] ==
        "bandsaw")  # fmt: skip
    header, *rows = (tmp_path / "told" / "effects.csv").read_text(encoding="utf-8").splitlines()
    assert header == "effect,fate,bound,worth,time_s"
    assert [row.split(",")[0] for row in rows] == EFFECTS["fast-band-saw"]
    assert tree["measured"]["saved_s"] == pytest.approx(tree["measured"]["all_effects_s"] -
        tree["measured"]["planned_s"])  # fmt: skip


def test_a_scene_whose_effects_have_no_bound_is_drawn_too(call, tmp_path):
    done = call("explain", SCENES / "band-brake.toml", "--out", tmp_path / "out", "--quiet")
    assert done.code == 0
    assert (tmp_path / "out" / "effects.png").is_file()
