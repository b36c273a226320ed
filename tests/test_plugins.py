"""A user's plugin files, those of docs/plugins.md: on the command line, in a campaign, a scene and in Python."""

import json
import multiprocessing
import pickle
import re
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import ropefric as rf
from ropefric import plugins
from ropefric.cli.app import main
from ropefric.friction.laws import ALL_LAWS, LAWS

ROOT = Path(__file__).parents[1]
TRIALS = ROOT / "fits" / "prth-trials.csv"
PAGE = (ROOT / "docs" / "plugins.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"```(?:python|toml)\n# file: (\S+)\n(.*?)```", PAGE, re.DOTALL))


@pytest.fixture(autouse=True)
def nothing_stays():
    with plugins.unloaded_after():
        yield


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A folder with the files of the page and a recording of the odd logger, as the place where somebody works."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for i, top_N in enumerate([100.0, 101.0, 99.5, 100.4, 130.0]):
        time_s = np.arange(5000) / 1000
        force_N = np.interp(time_s, [0.5, 2.5, 2.52, 4.9], [0, top_N, 0.8 * top_N, 0.8 * top_N])
        force_N += np.random.default_rng(i).normal(0, 0.05, time_s.size)
        rows = "\n".join(f"{1e3 * t:.3f}|{f / 1e3:.6f}" for t, f in zip(time_s, force_N, strict=True))
        (tmp_path / f"pull{i}.rlg").write_text(f"ROPELOG\n{rows}\n", encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(
        'schema = "ropefric.campaign/1"\nname = "odd"\ntrials = "trials.csv"\n'
        'plugins = ["my_reader.py", "my_rule.py", "my_protocol.py"]\n'
        '[rope]\ndiameter = "10 mm"\n[wheels]\nw = { radius = "40 mm" }\n'
        '[protocol]\nname = "largest-sample"\n[rejection]\nrule = "half-range"\n',
        encoding="utf-8",
    )
    rows = "".join(f"p{i},pull{i}.rlg,w,180,20\n" for i in range(5))
    (tmp_path / "trials.csv").write_text(f"trial,file,wheel,wrap_deg,end_tension_N\n{rows}", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(capsys, *line):
    code = main([*line, "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("name", "files"),
    [
        ("my_law.py", []),
        ("my_reader.py", ["--file", "pull0.rlg"]),
        ("my_rule.py", []),
        ("my_protocol.py", []),
        ("my_machine.py", ["--file", "quay.toml"]),
    ],
)
def test_every_plugin_of_the_page_keeps_its_promises(lab, capsys, name, files):
    code, told = run(capsys, "check-plugin", name, *files)
    assert [one["broken"] for one in told["promises"] if one["broken"]] == []
    assert (code, told["ok"]) == (0, True)
    assert len(told["promises"]) >= 2
    assert not plugins.loaded(), "a command's plugins are not those of the next"


def test_what_a_plugin_prints_stays_out_of_the_json(lab, capsys):
    (lab / "talks.py").write_text(f"print('hello')\n{FILES['my_law.py']}", encoding="utf-8")
    fit = str(ROOT / "fits" / "prth-coupled.json")
    for line in (("show", fit, "--plugin", "talks.py"), ("--plugin", "talks.py", "show", fit)):
        assert main(["--json", *line]) == 0
        told = capsys.readouterr()
        assert json.loads(told.out)["law"] == "coupled"
        assert told.err == "hello\n"


def test_a_law_is_fitted_compared_and_stored_with_its_plugin(lab, capsys):
    code, fit = run(
        capsys, "fit", str(TRIALS), "--law", "two-term", "--plugin", "my_law.py", "--out", "two.json"
    )
    assert code in {0, 4}
    (known,) = fit["provenance"]["plugins"]
    assert known["file"] == "my_law.py"
    assert known["declares"] == ["LAW two-term"]
    assert len(known["sha256"]) == 64
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
    assert lift["lift_force_N"] == pytest.approx(
        60.0 * np.exp(a * phi + b * np.log1p(phi)), rel=1e-8
    )  # as printed
    _, compared = run(capsys, "compare", str(TRIALS), "--plugin", "my_law.py")
    assert "two-term" in [entry["law"] for entry in compared["ranking"]]
    # A changed plugin is told of.
    path = lab / "my_law.py"
    path.write_text(path.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    rf.load_plugin(path)
    assert any("has changed since this fit was made" in note for note in rf.load_fit("two.json").notes)


def test_a_campaign_names_reader_rule_and_protocol(lab, capsys):
    assert run(capsys, "extract", "campaign.toml", "--out", "out")[0] == 0
    campaign = rf.load_campaign("campaign.toml")
    extraction = rf.extract(campaign)
    assert [trial.breakaway.detail for trial in extraction.trials] == ["the largest sample"] * 5
    assert [trial.trial for trial in extraction.trials if trial.rejected_by == "half-range"] == ["p4"]
    assert [trial.peak_N for trial in extraction.trials] == pytest.approx(
        [100, 101, 99.5, 100.4, 130], abs=0.3
    )
    assert set(rf.load_campaign("campaign.toml").plugins) == {"my_reader.py", "my_rule.py", "my_protocol.py"}
    tree = campaign.resolved()
    assert [one["file"] for one in tree["plugins"]] == ["my_reader.py", "my_rule.py", "my_protocol.py"]


def test_a_reader_that_changed_is_other_settings(lab):
    first = rf.load_campaign("campaign.toml").settings_fingerprint()
    path = lab / "my_reader.py"
    path.write_text(path.read_text(encoding="utf-8").replace('"kN"', '"N"'), encoding="utf-8")
    again = rf.load_campaign("campaign.toml")
    assert again.settings_fingerprint() != first
    assert rf.extract(again).trials[0].peak_N == pytest.approx(0.1, abs=1e-3)


def test_worker_processes_have_it(lab, monkeypatch):
    """A spawned one, too, which knows nothing of this process but what it is handed."""
    campaign = rf.load_campaign("campaign.toml")
    monkeypatch.setattr("threading.active_count", lambda: 2)  # then it does not fork
    found = rf.extract(campaign)
    assert [trial.breakaway.detail for trial in found.trials] == ["the largest sample"] * 5


def test_an_executor_has_it(lab):
    """Processes that are spawned: recordings by a plugin's reader, a bootstrap of a plugin's law with a lambda in it."""
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
    assert found.columns["held_N"] == pytest.approx(
        150.0 * np.exp(0.25 * 2 * np.pi * np.array([1, 2, 3])), rel=1e-12
    )
    assert main(["solve", "quay.toml"]) == 0
    assert "Pull that the hand holds" in capsys.readouterr().out
    code, told = run(capsys, "solve", "quay.toml", "--sweep", "post.wrap=1turn:4turn:4")
    assert code == 0
    path = lab / "quay.toml"
    path.write_text(path.read_text(encoding="utf-8").replace("2 turn", "1 turn"), encoding="utf-8")
    code, told = run(capsys, "solve", "quay.toml")
    assert code == 4
    assert told["failures"][0].startswith("the line runs out")
    path.write_text(path.read_text(encoding="utf-8").replace("150 mm", "-150 mm"), encoding="utf-8")
    with pytest.raises(rf.RopefricError) as error:
        rf.solve("quay.toml")
    assert error.value.problems[0].line == 5


BROKEN = {
    "LAW = (": (r"the plugin is no Python", 1, "RF160"),
    "import math\n\nx = math.sqrt(-1)\n": (r"ValueError: math domain error", 3, "RF160"),
    "import sys\nsys.exit(3)\n": (r"SystemExit: 3", 2, "RF160"),
    "import numpy_of_ours\n": (r"No module named 'numpy_of_ours'", 1, "RF160"),
    "law = 3\n": (r"declares nothing.*LAW = FrictionLaw", None, "RF161"),
    "x = 1\nLAW = 3\n": (r"LAW is of type int, not FrictionLaw", 2, "RF161"),
    "from ropefric.friction.laws import LAWS\nLAW = LAWS['coupled']\n": (r"law 'coupled' already", 2, "RF162"),
    "from dataclasses import replace\nfrom ropefric.friction.laws import LAWS\n\nLAW = (replace(LAWS['constant'], "
    "name='fine'), replace(LAWS['constant'], name='../out'))\n": (r"the name '../out' cannot be used", 4, "RF161"),
}  # fmt: skip


@pytest.mark.parametrize("text", BROKEN)
def test_a_broken_plugin_is_an_error_with_its_line(tmp_path, capsys, text):
    words, line, code = BROKEN[text]
    path = tmp_path / "broken.py"
    path.write_text(text, encoding="utf-8")
    before = list(ALL_LAWS), list(LAWS)
    with pytest.raises(rf.RopefricError, match=words) as error:
        rf.load_plugin(path)
    assert (error.value.code, error.value.problem.line) == (code, line)
    assert error.value.fix
    assert (list(ALL_LAWS), list(LAWS)) == before, "all of it or nothing"
    assert main(["check-plugin", str(path)]) == 3
    assert str(path.name) in capsys.readouterr().err
    campaign = tmp_path / "campaign.toml"
    campaign.write_text('plugins = ["broken.py"]\nname = "x"\n', encoding="utf-8")
    assert main(["check", str(campaign)]) == 3
    assert "broken.py" in capsys.readouterr().err


def test_what_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(rf.RopefricError, match="no such file"):
        rf.load_plugin("nothing.py")
    with pytest.raises(rf.RopefricError, match="no installed plugin is called 'our-lab'"):
        rf.load_plugin("our-lab")


def test_an_entry_point_is_asked_for_by_name(lab, monkeypatch, capsys):
    (lab / "our_lab").mkdir()
    (lab / "our_lab" / "__init__.py").write_text("", encoding="utf-8")
    (lab / "our_lab" / "friction.py").write_text(FILES["my_law.py"], encoding="utf-8")
    info = lab / "our_lab-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: our-lab\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(
        "[ropefric.plugins]\nour-lab = our_lab.friction\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(str(lab))
    assert "two-term" not in LAWS, "an installed plugin is never loaded by itself"
    plugin = rf.load_plugin("our-lab")
    assert (plugin.source, plugin.declares) == ("our-lab", ("LAW two-term",))
    assert "two-term" in LAWS
    sys.modules.pop("our_lab.friction")
    sys.modules.pop("our_lab")


def test_a_file_that_is_loaded_twice_is_loaded_once_and_anew_when_edited(lab):
    first = rf.load_plugin("my_law.py")
    assert rf.load_plugin("my_law.py") == first
    rf.load_plugin("my_rule.py")
    path = lab / "my_law.py"
    path.write_text(
        path.read_text(encoding="utf-8").replace("0.1, 0.0, 2.0", "0.1, 0.0, 1.5"), encoding="utf-8"
    )
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
    assert set(FILES) == {
        "my_law.py",
        "my_reader.py",
        "my_rule.py",
        "my_protocol.py",
        "my_machine.py",
        "quay.toml",
    }
