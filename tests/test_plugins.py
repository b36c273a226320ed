"""A user's plugin files, those of the pages on plugins: on the command line, in a campaign, a scene and in Python."""

import json
import multiprocessing
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import ropefric as rf
from ropefric import plugins, testing
from ropefric.cli.app import main
from ropefric.friction.laws import ALL_LAWS, LAWS

ROOT = Path(__file__).parents[1]
TRIALS = ROOT / "fits" / "prth-trials.csv"
PAGE = "".join(
    (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("plugins.md", "plugin-machine.md")
)
FILES = dict(re.findall(r"```(?:python|toml)\n# file: (\S+)\n(.*?)```", PAGE, re.DOTALL))


@pytest.fixture(autouse=True)
def nothing_stays():
    with plugins.unloaded_after():
        yield


def recording(number, top_N):
    time_s = np.arange(1000) / 200
    force_N = np.interp(time_s, [0.5, 2.5, 2.52, 4.9], [0, top_N, 0.8 * top_N, 0.8 * top_N])
    force_N += np.random.default_rng(number).normal(0, 0.05, time_s.size)
    rows = (f"{1e3 * t:.3f}|{f / 1e3:.6f}\n" for t, f in zip(time_s, force_N, strict=True))
    return f"ROPELOG\n{''.join(rows)}"


TOPS_N = (100.0, 101.0, 99.5, 100.4, 130.0)
LAB = FILES | {f"pull{i}.rlg": recording(i, top_N) for i, top_N in enumerate(TOPS_N)}
LAB["campaign.toml"] = """schema = "ropefric.campaign/1"
name = "odd"
trials = "trials.csv"
plugins = ["my_reader.py", "my_rule.py", "my_protocol.py"]
rope = { diameter = "10 mm" }
wheels = { w = { radius = "40 mm" } }
protocol = { name = "largest-sample" }
rejection = { rule = "half-range" }
"""
LAB["trials.csv"] = "trial,file,wheel,wrap_deg,end_tension_N\n" + "".join(f"p{i},pull{i}.rlg,w,180,20\n"
    for i in range(5))  # fmt: skip


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A folder with the files of the page and recordings of the odd logger, as the place where somebody works."""
    for name, text in LAB.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def edit(path, old, new):
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")


def run(capsys, *line):
    code = main([*line, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_every_plugin_of_the_page_keeps_its_promises(lab, capsys):
    files = {"my_reader.py": ["--file", "pull0.rlg"], "my_machine.py": ["--file", "quay.toml"]}
    for name in (one for one in FILES if one.endswith(".py")):
        code, told = run(capsys, "check-plugin", name, *files.get(name, []))
        assert [one["broken"] for one in told["promises"] if one["broken"]] == []
        assert (code, told["ok"]) == (0, True)
        assert len(told["promises"]) >= 2
        assert all(one["promise"].endswith(".") for one in told["promises"])
        assert not plugins.loaded(), "a command's plugins are not those of the next"
    edit(lab / "my_law.py", "return by_radius, a + b / (1.0 + conditions.wrap_angle_rad)",
        "return by_radius, a + b")  # fmt: skip
    edit(lab / "my_rule.py", "return flagged if", "return deviations if")
    for name, broken in (("my_law.py", "the slope by wrap_angle_rad is"), ("my_rule.py", "the answer is")):
        code, told = run(capsys, "check-plugin", name)
        assert (code, told["ok"]) == (4, False)
        assert any(broken in one["broken"] for one in told["promises"])


def test_what_a_plugin_prints_stays_out_of_the_json(lab, capsys):
    (lab / "talks.py").write_text(f"print('hello')\n{FILES['my_law.py']}", encoding="utf-8")
    fit = str(ROOT / "fits" / "prth-coupled.json")
    for line in (("show", fit, "--plugin", "talks.py"), ("--plugin", "talks.py", "show", fit)):
        assert main(["--json", *line]) == 0
        told = capsys.readouterr()
        assert (json.loads(told.out)["law"], told.err) == ("coupled", "hello\n")


def test_a_law_is_fitted_compared_and_stored_with_its_plugin(lab, capsys):
    code, fit = run(capsys, "fit", str(TRIALS), "--law", "two-term", "--plugin", "my_law.py", "--out",
        "two.json")  # fmt: skip
    assert code in {0, 4}
    (known,) = fit["provenance"]["plugins"]
    assert (known["file"], known["declares"], len(known["sha256"])) == ("my_law.py", ["LAW two-term"], 64)
    assert "two-term" not in LAWS
    # Without the plugin the fit says what it needs; with it, it predicts.
    wheel = ["--wheel-radius", "40 mm", "--wrap", "400 deg", "--end-tension", "60 N"]
    code, told = run(capsys, "predict", "--fit", "two.json", *wheel)
    assert code == 3
    assert "declared by the plugin my_law.py" in told["error"]["message"]
    assert "--plugin my_law.py" in told["error"]["fix"]
    _, lift = run(capsys, "--plugin", "my_law.py", "predict", "--fit", "two.json", *wheel)
    a, b = (fit["parameters"][name]["value"] for name in "ab")
    phi = np.radians(400.0)
    lift_N = 60.0 * np.exp(a * phi + b * np.log1p(phi))
    assert lift["lift_force_N"] == pytest.approx(lift_N, rel=1e-8)  # as printed
    rows = TRIALS.read_text(encoding="utf-8").splitlines(keepends=True)
    (lab / "few.csv").write_text("".join([rows[0], *rows[1::6]]), encoding="utf-8")
    _, compared = run(capsys, "compare", "few.csv", "--plugin", "my_law.py")
    assert "two-term" in [entry["law"] for entry in compared["ranking"]]
    # A changed plugin is told of.
    edit(lab / "my_law.py", "our lab, 2026", "our lab, 2027")
    rf.load_plugin("my_law.py")
    assert any("has changed since this fit was made" in note for note in rf.load_fit("two.json").notes)


def test_a_campaign_names_reader_rule_and_protocol(lab, capsys):
    assert run(capsys, "extract", "campaign.toml", "--out", "out")[0] == 0
    campaign = rf.load_campaign("campaign.toml")
    extraction = rf.extract(campaign)
    assert [trial.breakaway.detail for trial in extraction.trials] == ["the largest sample"] * 5
    assert [trial.trial for trial in extraction.trials if trial.rejected_by == "half-range"] == ["p4"]
    assert [trial.peak_N for trial in extraction.trials] == pytest.approx(TOPS_N, abs=0.6)
    names = ["my_reader.py", "my_rule.py", "my_protocol.py"]
    assert list(campaign.plugins) == [one["file"] for one in campaign.resolved()["plugins"]] == names
    edit(lab / "my_reader.py", '"kN"', '"N"')
    changed = rf.extract(rf.load_campaign("campaign.toml"))
    assert changed.trials[0].peak_N == pytest.approx(0.1, abs=1e-3)


def test_a_reader_that_fails_on_a_file_is_named_with_its_line(lab, capsys):
    edit(lab / "my_reader.py", "    rows = []\n", "    rows = [][1]\n")
    code, told = run(capsys, "inspect", "pull0.rlg", "--plugin", "my_reader.py")
    where = told["error"]["where"]
    assert (code, told["error"]["code"], "IndexError" in told["error"]["message"]) == (3, "RF160", True)
    line = next(
        n for n, text in enumerate((lab / "my_reader.py").read_text().split("\n"), 1) if "[][1]" in text
    )
    assert where.endswith(f"my_reader.py:{line}")
    extraction = rf.extract(rf.load_campaign("campaign.toml"))
    assert {(one.code, one.line) for one in extraction.problems if one.severity == "error"} == {
        ("RF160", line)
    }


@pytest.mark.slow
def test_worker_processes_have_it(lab, monkeypatch):
    """A spawned one, too, which knows nothing of this process but what it is handed."""
    campaign = rf.load_campaign("campaign.toml")
    monkeypatch.setattr("threading.active_count", lambda: 2)  # then it does not fork
    found = rf.extract(campaign)
    assert [trial.breakaway.detail for trial in found.trials] == ["the largest sample"] * 5


@pytest.mark.slow
def test_an_executor_has_it(lab):
    """Processes that are spawned: recordings by a plugin's reader, a plugin's law with a lambda in it."""
    campaign = rf.load_campaign("campaign.toml")
    rf.load_plugin("my_law.py")
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there, here = rf.extract(campaign, executor=pool), rf.extract(campaign)
        assert [trial.peak_N for trial in there.trials] == [trial.peak_N for trial in here.trials]
        assert pool.submit(parameters_of, LAWS["two-term"]).result() == ("a", "b")


def parameters_of(law):
    return law.parameter_names


def test_a_plugin_that_is_unpickled_is_loaded(lab):
    plugin = rf.load_plugin("my_law.py")
    packed = pickle.dumps(plugin)
    with plugins.unloaded_after():
        plugins.forget_added()
        plugins._LOADED.clear()
        assert "two-term" not in ALL_LAWS
        assert pickle.loads(packed) == plugin  # noqa: S301  (our own)
        assert "two-term" in ALL_LAWS
    rf.load_plugin("my_law.py")


def test_a_machine_is_solved_explained_and_swept(lab, capsys):
    code, told = run(capsys, "solve", "quay.toml")
    assert code == 0
    held_N = 150.0 * np.exp(0.25 * 4 * np.pi)
    assert told["held_N"] == pytest.approx(held_N, rel=1e-12)
    assert told["hold_margin"] == pytest.approx(held_N / 2000.0, rel=1e-12)
    assert told["plugins"][0]["declares"] == ["KIND bollard"]
    found = rf.sweep("quay.toml", "post.wrap=1turn,2turn,3turn")
    assert found.columns["held_N"] == pytest.approx(150.0 * np.exp(0.25 * 2 * np.pi * np.array([1, 2, 3])),
        rel=1e-12)  # fmt: skip
    assert main(["solve", "quay.toml"]) == 0
    assert "Pull that the hand holds" in capsys.readouterr().out
    code, told = run(capsys, "solve", "quay.toml", "--sweep", "post.wrap=1turn:4turn:4")
    assert code == 0
    edit(lab / "quay.toml", "2 turn", "1 turn")
    code, told = run(capsys, "solve", "quay.toml")
    assert code == 4
    assert told["failures"][0].startswith("the line runs out")
    edit(lab / "quay.toml", "150 mm", "-150 mm")
    with pytest.raises(rf.RopefricError) as error:
        rf.solve("quay.toml")
    assert error.value.problems[0].line == 5


BROKEN = {
    "LAW = (": (r"the plugin is no Python", 1, "RF160"),
    "import math\n\nx = math.sqrt(-1)\n": (r"ValueError: (math domain|expected a nonneg)", 3, "RF160"),
    "import sys\nsys.exit(3)\n": (r"SystemExit: 3", 2, "RF160"),
    "import numpy_of_ours\n": (r"No module named 'numpy_of_ours'", 1, "RF160"),
    "law = 3\n": (r"declares nothing.*LAW = FrictionLaw", None, "RF161"),
    "x = 1\nLAW = 3\n": (r"LAW is of type int, not FrictionLaw", 2, "RF161"),
    "from ropefric.friction.laws import LAWS\nLAW = LAWS['coupled']\n": (r"law 'coupled' already", 2, "RF162"),
    "from dataclasses import replace\nfrom ropefric.friction.laws import LAWS\n\nLAW = (replace(LAWS['constant'], "
    "name='fine'), replace(LAWS['constant'], name='../out'))\n": (r"the name '../out' cannot be used", 4, "RF161"),
}  # fmt: skip


def test_a_broken_plugin_is_an_error_with_its_line(tmp_path, capsys):
    path, campaign = tmp_path / "broken.py", tmp_path / "campaign.toml"
    campaign.write_text('plugins = ["broken.py"]\nname = "x"\n', encoding="utf-8")
    before = list(ALL_LAWS), list(LAWS)
    for text, (words, line, code) in BROKEN.items():
        path.write_text(text, encoding="utf-8")
        with pytest.raises(rf.RopefricError, match=words) as error:
            rf.load_plugin(path)
        assert (error.value.code, error.value.problem.line) == (code, line)
        assert error.value.fix
        assert (list(ALL_LAWS), list(LAWS)) == before, "all of it or nothing"
    for command in ("check-plugin", "check"):
        assert main([command, str(path if command == "check-plugin" else campaign)]) == 3
        assert "broken.py" in capsys.readouterr().err


def test_code_that_a_campaign_names_is_told_of_before_it_runs(tmp_path, capsys):
    (tmp_path / "loud.py").write_text("import sys\nsys.stderr.write('RAN')\n", encoding="utf-8")
    (tmp_path / "campaign.toml").write_text('plugins = ["loud.py"]\nname = "x"\n', encoding="utf-8")
    for command in ("check", "run", "extract"):
        assert main([command, str(tmp_path)]) == 3
        told, _, _ = capsys.readouterr().err.partition("RAN")
        assert "names the plugin loud.py, whose code runs now" in told
    (tmp_path / "scene.toml").write_text('plugins = ["loud.py"]\nsystem = "hoist"\n', encoding="utf-8")
    assert main(["solve", str(tmp_path / "scene.toml")]) == 3
    assert "whose code runs now" in capsys.readouterr().err.partition("RAN")[0]


def test_what_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(rf.RopefricError, match="no such file"):
        rf.load_plugin("nothing.py")


def test_a_file_that_is_loaded_twice_is_loaded_once_and_anew_when_edited(lab):
    first = rf.load_plugin("my_law.py")
    assert rf.load_plugin("my_law.py") == first
    rf.load_plugin("my_rule.py")
    edit(lab / "my_law.py", "0.1, 0.0, 2.0", "0.1, 0.0, 1.5")
    again = rf.load_plugin("my_law.py")
    assert again.sha256 != first.sha256
    assert LAWS["two-term"].parameters[0].upper == 1.5
    assert [one.path.name for one in plugins.loaded()] == ["my_rule.py", "my_law.py"]


def test_the_rest_of_the_page_is_true():
    assert set(plugins.SLOTS) == set(re.findall(r"^\| `([A-Z]+)` \|", PAGE, re.MULTILINE))
    for slot, where in re.findall(r"^\| `([A-Z]+)` \|.*\| `(ropefric\.[\w.]+)` \|", PAGE, re.MULTILINE):
        registry = plugins.registry_of(slot)
        kind = type(registry[next(iter(registry))])
        assert f"{kind.__module__}.{kind.__qualname__}" == where
    assert {"RF160", "RF161", "RF162"} <= set(re.findall(r"RF\d+", PAGE))
    assert all(hasattr(testing, name) for name in re.findall(r"check_\w+", PAGE))
    assert set(FILES) == {*(f"my_{one}.py" for one in ("law", "reader", "rule", "protocol", "machine")),
        "quay.toml"}  # fmt: skip
