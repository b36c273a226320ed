"""What commands write: never over what others wrote, never over an input, nothing left of another run."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

SCENES = Path(__file__).parents[2] / "data" / "scenes"
FIT = Path(__file__).parents[2] / "fits" / "prth-coupled.json"
TRIALS = Path(__file__).parents[2] / "fits" / "prth-trials.csv"
PLAN = (*("plan-tests", "--fit", FIT, "--wheels", "15 mm, 30 mm", "--wraps", "90deg, 360deg, 720deg"),
    *("--end-tensions", "5N, 50N, 200N", "--max-force", "800 N", "--wheel-radius", "100 mm"),
    *("--wrap", "720 deg", "--end-tension", "80 N", "--conditions", "7"))  # fmt: skip
SWEEP = ("solve", SCENES / "hoist.toml", "--sweep", "wheel.wrap=1turn,2turn", "--out")


def tree(folder, *, own=False):
    """Every file by name, without what ropefric keeps for itself."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*"))
        if path.is_file() and (own or not {".ropefric", ".cache"} & set(path.parts))}  # fmt: skip


# --- inputs ---


def test_the_campaign_is_never_written_over(call, campaign, monkeypatch):
    monkeypatch.chdir(campaign)
    (campaign.parent / "link").symlink_to(campaign)
    before = tree(campaign, own=True)
    for words in (("extract", "campaign.toml", "--out", "."),
            ("extract", "campaign.toml", "--out", "", "--force"),
            ("extract", "campaign.toml", "--out", ".", "--force"), ("run", ".", "--out", "."),
            ("run", "campaign.toml", "--out", "../campaign", "--force"),
            ("run", "campaign.toml", "--out", "../link"),
            ("report", "campaign.toml", "--out", "../link", "--force")):  # fmt: skip
        done = call(*words)
        assert done.code == 3, words
        assert "extract 1" not in done.err
        assert ("trials.csv" in done.err and "RF151" in done.err) or "the folder has no name" in done.err
        assert tree(campaign, own=True) == before, words


def test_a_recording_is_an_input_too(call, campaign, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    os.link(min((campaign / "traces").iterdir()), out / "conditions.csv")
    done = call("extract", campaign, "--out", out, "--force", "--no-figures")
    assert done.code == 3
    assert "conditions.csv  this is an input" in done.err


def test_no_command_writes_over_what_it_reads(call, campaign, tmp_path):
    table, fit = shutil.copy(TRIALS, tmp_path / "T.csv"), shutil.copy(FIT, tmp_path / "answer.json")
    scene, recording = tmp_path / "hoist.toml", min((campaign / "traces").iterdir())
    text = (SCENES / "hoist.toml").read_text(encoding="utf-8")
    assert "../../fits/prth-coupled.json" in text
    scene.write_text(text.replace("../../fits/prth-coupled.json", "answer.json"), encoding="utf-8")
    read = {path: path.read_bytes() for path in (table, fit, scene, recording)}
    plan = [fit if word == FIT else word for word in PLAN]
    for words, name in ((("fit", table, "--law", "constant", "--out", table), "T.csv"),
            ((*plan, "--out", fit), "answer.json"), (("solve", scene, "--out", tmp_path), "answer.json"),
            (("inspect", recording, "--write-profile", recording), recording.name)):  # fmt: skip
        for force in ((), ("--force",)):
            done = call(*words, *force)
            assert done.code == 3
            assert f"{name}  this is an input of the same command" in done.err
            assert {path: path.read_bytes() for path in read} == read


# --- what others wrote ---


def test_a_folder_with_a_file_of_others_is_refused(call, tmp_path):
    for words, name in ((("solve", SCENES / "hoist.toml", "--out"), "answer.json"),
            (SWEEP, "sweep_figure.csv"),
            (("cost", "integral", "--quick", "--out"), "cost.html")):  # fmt: skip
        folder = tmp_path / name
        folder.mkdir()
        for mine in (name, "other.txt"):
            (folder / mine).write_text("mine", encoding="utf-8")
        done = call(*words, folder)
        assert done.code == 3, words
        assert f"error RF150 {(folder / name).as_posix()}  ropefric did not write this file" in done.err
        assert "--force" in done.err
        assert tree(folder, own=True) == {name: b"mine", "other.txt": b"mine"}
        if words[0] == "solve":
            for option in ("--force", "-q"):
                assert call(*words, folder, option).code == 0
            made = tree(folder)
            assert made[name] != b"mine"
            assert made["other.txt"] == b"mine"


def test_results_of_others_are_refused_before_the_work(call, bench, tmp_path):
    names = ("trials.csv", "report.html", "fits/coupled.json", "figures/Rw15mm_phi540deg_FB60N.png")
    for number, name in enumerate(names):
        out = tmp_path / str(number)
        (out / name).parent.mkdir(parents=True)
        (out / name).write_text("mine", encoding="utf-8")
        done = call("run", bench, "--out", out)
        assert done.code == 3
        assert f"{name}  ropefric did not write this file" in done.err
        assert "extract 1" not in done.err
        assert tree(out, own=True) == {name: b"mine"}


def test_a_fit_is_replaced_by_a_fit_and_nothing_else_is(call, tmp_path):
    words = ("fit", TRIALS, "--law", "constant", "-q", "--out")
    for _ in range(2):
        assert call(*words, tmp_path / "fit.json").code in {0, 4}
    for name, text in (("campaign.toml", "[rope]"), ("notes.json", '{"a": 1}'), ("list.json", "[]")):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        done = call(*words, path)
        assert done.code == 3
        assert f"{path.as_posix()}  the file is there already, and it is no stored fit" in done.err
        assert path.read_text(encoding="utf-8") == text
        assert call(*words, path, "--force").code in {0, 4}


def test_a_file_that_exists_is_not_written_over(call, bench, tmp_path):
    recording = min((bench / "traces").iterdir())
    for words in ((*PLAN, "--out"), ("inspect", recording, "--write-profile")):
        path = tmp_path / f"{words[0]}.txt"
        assert call(*words, path, "-q").code == 0
        made = path.read_text(encoding="utf-8")
        path.write_text(f"{made}done on Monday\n", encoding="utf-8")
        done = call(*words, path)
        assert done.code == 3
        assert f"error RF150 {path.as_posix()}  the file is there already" in done.err
        assert path.read_text(encoding="utf-8").endswith("done on Monday\n")
        assert (call(*words, path, "-q", "--force").code, path.read_text(encoding="utf-8")) == (0, made)


def test_nothing_is_written_through_links(call, tmp_path):
    for name in ("init", "simulated", "elsewhere"):
        (tmp_path / name).mkdir()
    mine, target = tmp_path / "mine.json", tmp_path / "link"
    mine.write_bytes(FIT.read_bytes())
    for link in (target, tmp_path / "init" / "campaign.toml"):
        link.symlink_to(mine)
    (tmp_path / "simulated" / "traces").symlink_to(tmp_path / "elsewhere")
    for words in (("fit", TRIALS, "--law", "constant", "--out"), (*PLAN, "--out")):
        done = call(*words, target, "--force")
        assert done.code == 3
        assert all(one in done.err for one in ("this is a link, to ", "mine.json"))
    assert call("init", tmp_path / "init", "--force").code == 3
    assert call("simulate", tmp_path / "simulated", "--conditions", "1", "--repeats", "1").code == 3
    assert mine.read_bytes() == FIT.read_bytes()
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.slow
def test_results_of_an_earlier_version_are_taken_over_only_when_asked(call, bench, tmp_path):
    out = tmp_path / "out"
    assert call("extract", bench, "--out", out, "-q").code == 0
    shutil.rmtree(out / ".ropefric")
    before = tree(out)
    done = call("extract", bench, "--out", out)
    assert done.code == 3
    assert all(one in done.err for one in ("an earlier version of it did", "the same holds for 5 more files"))
    assert (done.err.count("error RF150"), tree(out).keys()) == (2, before.keys())
    assert call("extract", bench, "--out", out, "-q", "--force", "--no-figures").code == 0
    assert tree(out) == before


def test_from_python_too(campaign, tmp_path, few_laws):
    import ropefric as rf
    from ropefric.errors import DataError

    before = tree(campaign, own=True)
    with pytest.raises(DataError, match="input of the same command"):
        rf.run(campaign / "campaign.toml", campaign, overwrite=True)
    with pytest.raises(DataError, match="no stored fit"):
        rf.save_fit(rf.load_fit(FIT), campaign / "campaign.toml")
    assert tree(campaign, own=True) == before
    rf.run(campaign / "campaign.toml", tmp_path / "out", law="constant")
    for _ in range(2):
        rf.save_fit(rf.load_fit(FIT), tmp_path / "fit.json")
    assert "comparison.csv" in tree(tmp_path / "out")


# --- what fits together ---


def drop_condition(campaign):
    """Take the second condition out of the list, and the last pull of the first."""
    path = campaign / "trials.csv"
    lines = path.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith(("c02-", "c01-r06"))]
    assert len(kept) < len(lines) - 6
    path.write_text("\n".join([*kept, ""]), encoding="utf-8")


@pytest.mark.slow
def test_runs_extractions_and_reports_into_one_folder_fit_together(call, campaign, tmp_path):
    out = tmp_path / "out"
    assert call("run", campaign, "--out", out, "-q").code in {0, 4}
    whole = tree(out)
    assert sum(name.endswith(".png") for name in whole) == 2
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    (out / "figures" / "mine.png").write_text("mine", encoding="utf-8")
    mine = {"notes.txt", "figures/mine.png"}
    for words in (("extract", campaign, "--out", out, "--no-figures"), ("extract", campaign, "--out", out),
            ("report", out)):  # fmt: skip
        assert call(*words, "-q").code in {0, 4}
        made = tree(out)
        # How the campaign's file was named stands in these.
        for name in whole.keys() - {"problems.csv", "report.html"}:
            assert made[name] == whole[name], (words, name)
        assert made.keys() == whole.keys() | mine
    # A page without figures has no numbers of figures; the pictures of the conditions and their numbers stay.
    assert call("report", out, "--no-figures", "-q").code in {0, 4}
    left = tree(out)
    assert "figures/overview.csv" not in left
    assert {name for name in whole if name.startswith("figures/Rw")} <= left.keys()
    # Other trials: what rests on the old ones goes, even where the new run makes none of it.
    drop_condition(campaign)
    assert call("extract", campaign, "--out", out, "--no-figures", "-q").code == 0
    assert tree(out).keys() == mine | {"trials.csv", "conditions.csv", "problems.csv"}
    assert call("extract", campaign, "--out", out, "-q").code == 0
    assert sum(name.endswith(".png") for name in tree(out)) == 1 + 1


@pytest.mark.slow
def test_a_scene_without_a_start_up_leaves_none_of_another(call, tmp_path):
    call("solve", SCENES / "press-start-up.toml", "--out", tmp_path, "-q")
    assert "start_up.csv" in tree(tmp_path)
    call(*SWEEP, tmp_path, "-q")
    assert {"start_up.csv", "answer.json", "sweep.csv"} <= tree(tmp_path).keys()
    call("solve", SCENES / "hoist.toml", "--out", tmp_path, "-q")
    assert tree(tmp_path).keys() == {"answer.json", "sweep.csv", "sweep_figure.png", "sweep_figure.csv"}


# --- the process ---


def program(code, *words, stdout=None):
    """Run the program anew after some lines of Python; return exit code and stderr, or stdout and stderr as one."""
    start = "\nimport sys\nfrom ropefric.__main__ import main\nsys.exit(main())\n"
    done = subprocess.run([sys.executable, "-c", code + start, *map(str, words)],
        stdout=stdout or subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False,
        timeout=120)  # fmt: skip
    return done.returncode, (done.stdout or "") + done.stderr


def test_a_signal_ends_the_work_in_order(call, forked, bench, tmp_path):
    words = ("extract", bench, "--out", tmp_path / "out", "--no-figures", "--jobs", "1")
    number = signal.SIGHUP

    def prepare():
        from ropefric.trials import result

        def stop(*_, **__):
            os.kill(os.getpid(), number)
            raise AssertionError("went on")

        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        result.write_tables = stop

    code, out, err = forked(prepare, *words)
    assert (code, out) == (128 + number, "")
    assert err.endswith("error RF001  interrupted\n")
    assert tree(tmp_path / "out") == {}
    assert call(*words).code == 0


def test_an_interrupt_amid_the_recordings_leaves_nothing_half_written(call, forked, bench, tmp_path):
    words = ("extract", bench, "--out", tmp_path, "--jobs", "2", "--no-figures")

    def prepare():
        from ropefric.cli import output

        whole = output.Progress.update

        def update(self, done, *more):
            whole(self, done, *more)
            if done == 3:
                os.kill(os.getpid(), signal.SIGINT)

        signal.signal(signal.SIGINT, signal.default_int_handler)
        output.Progress.update = update

    code, out, err = forked(prepare, *words)
    assert (code, out) == (130, "")
    assert "Traceback" not in err
    assert not list(tmp_path.rglob("*.csv"))
    assert call(*words).code == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no signals")
@pytest.mark.parametrize(("module", "name", "code"),
    [("typer", "SIGINT", 130), ("ropefric.cli.commands.scenes", "SIGTERM", 143)])  # fmt: skip
def test_a_signal_while_the_program_is_loaded_is_one_line(module, name, code):
    """Even where the module that is being loaded makes another error of the interruption."""
    hook = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            try:
                os.kill(os.getpid(), signal.{name})
            except BaseException:
                raise ImportError("broken off")
sys.modules.pop({module!r}, None)
sys.meta_path.insert(0, Finder())
"""
    assert program(hook, "--help") == (code, "error RF001  interrupted\n")


def test_an_interrupt_that_a_library_put_into_its_own_words_is_one(call, monkeypatch):
    from ropefric.scenes import scene

    def broken(_):
        raise ImportError("broken off") from KeyboardInterrupt()

    monkeypatch.setattr(scene, "load_scene", broken)
    done = call("solve", SCENES / "hoist.toml")
    assert (done.code, done.out, done.err) == (130, "", "error RF001  interrupted\n")


@pytest.mark.parametrize("closed", [(1,), (0, 1, 2)])
def test_closed_streams_end_no_work(forked, bench, tmp_path, closed):
    def prepare():
        for number in closed:
            os.close(number)
            setattr(sys, ("stdin", "stdout", "stderr")[number], None)

    code, out, err = forked(prepare, "extract", bench, "--out", tmp_path, "--no-figures")
    assert (code, bool(out), bool(err)) == (0, 1 not in closed, 2 not in closed)
    assert tree(tmp_path).keys() == {"trials.csv", "conditions.csv", "problems.csv"}
    assert b"recordings:" not in b"".join(tree(tmp_path).values())


NOWHERE = """
import os, tempfile
for name in ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR", "TMPDIR"):
    os.environ[name] = "/proc/nowhere"
os.environ["HOME"] = "/proc/nowhere"
def none():
    raise FileNotFoundError(2, "No usable temporary directory found")
tempfile._get_default_tempdir = none
"""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no folder that is read-only for root too")
@pytest.mark.slow
def test_without_a_place_for_what_is_temporary_or_for_the_result_the_files_are_written(tmp_path):
    """The figure is drawn without a place for settings; a result that cannot be told is no fault of ours."""
    with Path("/dev/full").open("w") as full:
        code, err = program(NOWHERE, *SWEEP, tmp_path / "out", "--quiet", stdout=full)
    assert code == 3
    assert err.startswith("error RF")
    assert "no space left on device" in err
    assert not any(one in err for one in ("RF000", "Exception"))
    assert len(err.splitlines()) <= 2
    assert (tmp_path / "out" / "sweep_figure.png").stat().st_size > 10_000


@pytest.mark.slow
def test_what_libraries_log_is_not_for_the_reader(tmp_path):
    """A new folder for matplotlib's settings makes it tell of its list of fonts."""
    code = f"import os\nos.environ['MPLCONFIGDIR'] = {str(tmp_path / 'mpl')!r}\n"
    assert program(code, *SWEEP, tmp_path / "out", "--quiet", stdout=subprocess.DEVNULL) == (0, "")
