"""Scene files with their values, units and keys garbled: an answer that holds together, or a refusal in words."""

import json
import math
import re
from pathlib import Path

from fuzz_kit import HOSTILE, answered, fuzzed, scratch
from hypothesis import strategies as st

from ropefric.scenes.explain import explain_scene
from ropefric.scenes.scene import check_scene, load_scene
from ropefric.scenes.solve import solve_scene

SCENES = Path(__file__).parents[2] / "data" / "scenes"
FITS = (SCENES / "../../fits").resolve().as_posix()
TEXTS = {path.stem: path.read_text(encoding="utf-8").replace("../../fits", FITS).splitlines()
    for path in sorted(SCENES.glob("*.toml"))}  # fmt: skip
# A start-up takes a second; its garbled forms are for the long run of its own tests.
CHEAP = [name for name in TEXTS if name != "press-start-up"]
JUNK = ("0", "-1", "1", "1e-300", "1e300", "nan", "inf", "true", "[]", "{}", '""', '"x"', '"auto"', '"all"',
    "[1]", '["size"]', '["travel", "bending"]', '["belt-inertia"]', '"1 mm"', '"-1 mm"', '"1e300 m"',
    '"1e-300 m"', '"0 N"', '"1e9 N"', '"1 kN"', '"1 N*m"', '"90 deg"', '"1e6 turn"', '"1e-9 deg"',
    '"100 m/s"', '"1e5 rpm"', '"1e160 m/s"', '"1e300 kg/m"', '"1e200 rpm"', '"1e-200 N"', '"1e200 N"',
    '"1e200 N*m^2"', '"1e-200 m"', '"1 MPa"', '"1 kg"', '"1e-12 kg/m"', '"clamped"', '"pinned"', '"equal"',
    '"speed-ratio"', '"driver"', *HOSTILE)  # fmt: skip
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
FOLDER = scratch()


def garbled(name, edits):
    """Return a scene's text with values replaced, scaled, moved or taken out."""
    lines = list(TEXTS[name])
    places = [number for number, line in enumerate(lines) if " = " in line]
    for place, how, junk, power in edits:
        at = places[place % len(places)]
        key, _, value = lines[at].partition(" = ")
        if how == "junk":
            lines[at] = f"{key} = {junk}"
        elif how == "gone":
            lines[at] = ""
        elif how == "key":
            lines[at] = f"{key[:-1]} = {value}"
        else:
            found = NUMBER.search(value)
            number = f"{float(found[0]) * 10.0**power:.6g}" if found else ""
            lines[at] = f"{key} = {value.replace(found[0], number, 1) if found else junk}"
    return "\n".join(lines)


def every_number(tree):
    if isinstance(tree, dict):
        for value in tree.values():
            yield from every_number(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from every_number(value)
    elif isinstance(tree, float):
        yield tree


def check_kind(kind, tree):
    """What holds of an answer of every kind of machine."""
    if kind == "hoist":
        assert tree["lift_force_N"] >= tree["end_tension_N"] * (1.0 - 1e-9)
        assert tree["mu_average"] >= 0.0
        if tree.get("std_N") is not None:
            assert tree["interval_N"][0] <= tree["lift_force_N"] <= tree["interval_N"][1]
    elif kind == "press":
        assert min(tree["effective_tension_N"].values()) > 0.0
        assert all(one["utilisation"] is None or one["utilisation"] >= 0.0 for one in tree["slip"].values())
    elif kind == "bandsaw":
        for side in ("tight", "slack", "rest"):
            frequencies = tree[side]["frequencies_Hz"]
            assert frequencies[0] > 0.0
            assert frequencies == sorted(frequencies)
        assert tree["tight"]["tension_N"] >= tree["slack"]["tension_N"]
    elif kind == "traction":
        for one in tree["cases"].values():
            assert one["passes"] == (one["utilisation"] <= 1.0)
            assert one["capacity"] >= 1.0
        assert tree["cases"]["loading"]["tight_N"] >= tree["cases"]["loading"]["slack_N"] > 0.0
    elif kind == "line":
        rises = [
            one["tension_out_N"] - one["tension_in_N"] for one in tree["elements"] if one["kind"] == "bend"
        ]
        if min(tree["tension_N"]) > 0.0 and "both_ends" not in tree:
            assert (
                all(one >= -1e-9 for one in rises)
                if tree["direction"] == "pull"
                else max(rises, default=0.0) <= 1e-9
            )
    else:
        assert kind == "beltdrive"
        assert tree["full_tight_N"] >= tree["full_slack_N"] > 0.0
        slips = [one["slip_arc_rad"] for one in tree["pulleys"].values()]
        assert all(slip is None or slip >= -1e-9 for slip in slips)


def check_scene_file(name, edits):
    """An answer is finite, keeps the invariants of its system and its own promise; all else is refused in words."""
    path = FOLDER / f"{name}.toml"
    path.write_text(garbled(name, edits), encoding="utf-8")
    problems = check_scene(path)
    scene = answered(lambda: load_scene(path))
    assert (scene is None) == bool(problems)
    if scene is None:
        return
    solution = answered(lambda: solve_scene(scene))
    if solution is None:
        return
    tree = solution.to_dict()
    json.dumps(tree, allow_nan=False)
    assert all(math.isfinite(number) for number in every_number(tree))
    assert tree["error_bound"] is None or tree["error_bound"] >= 0.0
    if scene.effects == "auto":
        assert tree["error_bound"] is not None
        assert tree["error_bound"] <= scene.accuracy * (1.0 + 1e-9)
    check_kind(scene.kind.name, tree)
    told = explain_scene(scene).to_dict()
    assert [one["name"] for one in told["effects"] if one["simulated"]] == tree["effects"]["simulated"]


test_scenes, test_scenes_long = fuzzed(
    check_scene_file,
    short=30,
    share=0.02,
    examples=tuple({"name": name, "edits": [(place, how, junk, power)]} for name, place, how, junk, power in (
        ("fast-band-saw", 10, "scaled", "0", -1),  # the bound a hair above the accuracy
        ("band-saw", 11, "scaled", "0", 1),  # a blade ten times as slow
        ("belt-press", 59, "scaled", "0", 3),  # e^M beyond all floats
        ("fast-band-saw", 15, "scaled", "0", 4),  # the same of a saw's wheels
        ("fast-belt-press", 3, "junk", '"1e160 m/s"', 0),  # whose square is no float
    )),
    name=st.sampled_from(CHEAP),
    edits=st.lists(
        st.tuples(
            st.integers(0, 99),
            st.sampled_from(["junk", "junk", "scaled", "scaled", "scaled", "gone", "key"]),
            st.sampled_from(JUNK),
            st.integers(-4, 4),
        ),
        min_size=1,
        max_size=3,
    ),
)  # fmt: skip
