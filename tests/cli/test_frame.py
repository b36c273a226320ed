"""The frame of the command line: exit codes, pure JSON, words on stderr, help that starts light."""

import io
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import pytest
import typer

from ropefric.cli import app
from ropefric.cli.app import build_app, find_commands
from ropefric.cli.options import Answer, Command
from ropefric.cli.output import json_text
from ropefric.errors import DataError, FitError, Problem
from ropefric.registry import Registry

NOT_TRUSTED = 4


@pytest.fixture
def run(monkeypatch, capfd):
    """Run a made-up command `do` through the real frame; return exit code, stdout, stderr."""

    def run(body, *argv):
        def do(out, *, size: Annotated[int, typer.Option(help="How large.")] = 1):
            """Do it."""
            return body(out, size)

        command = Command(name="do", run=do, example="ropefric do", order=1)
        monkeypatch.setattr(app, "find_commands", lambda: Registry("command", [command]))
        monkeypatch.setattr(
            app, "build_app", build_app.__wrapped__
        )  # which remembers the commands it was built of
        code = app.main(argv)
        said = capfd.readouterr()
        return code, said.out, said.err

    return run


def answer(data=None, text="done", exit_code=0):
    return Answer(data=data or {"b": 1, "a": 2}, show=text, exit_code=exit_code)


def fail(error):
    def body(out, size):
        raise error

    return body


def test_a_result_goes_to_stdout_and_notes_to_stderr(run):
    def body(out, size):
        out.note(f"working on {size}")
        return answer(text=f"size {size}")

    assert run(body, "do", "--size", "3") == (0, "size 3\n", "working on 3\n")
    assert run(body, "do", "--quiet") == (0, "size 1\n", "")
    assert run(body, "--quiet", "do") == (0, "size 1\n", "")
    # One that is not to be trusted too.
    assert run(lambda out, size: answer(exit_code=NOT_TRUSTED), "do")[:2] == (NOT_TRUSTED, "done\n")


def test_json_is_alone_on_stdout_sorted_and_strict(run, strict):
    def body(out, size):
        out.note("a note")
        return answer({"nan": float("nan"), "inf": [float("-inf")], "a": {"z": 1, "y": Path("x/y")}})

    for argv in (("do", "--json"), ("--json", "do")):
        code, out, err = run(body, *argv)
        assert (code, err) == (0, "a note\n")
        assert strict(out) == {"nan": None, "inf": [None], "a": {"z": 1, "y": "x/y"}}
        assert out.index('"a"') < out.index('"inf"') < out.index('"nan"')


def test_an_error_says_what_where_and_the_fix(run):
    error = DataError('cannot read "12,47"', code="RF102", path="run07.csv", line=4,
        fix='[import] decimal = ","')  # fmt: skip
    code, out, err = run(fail(error), "do")
    assert (code, out) == (3, "")
    assert err == 'error RF102 run07.csv:4  cannot read "12,47"\n  fix: [import] decimal = ","\n'
    assert "RF101" in run(fail(DataError("empty")), "do", "--quiet")[2], "even when quiet"
    assert "[import] [/bold]" in run(fail(DataError("[import] [/bold]")), "do")[2], "no markup"


def test_all_problems_are_said_and_listed(run, strict):
    problems = [Problem(code=f"RF12{i}", message=f"wrong {i}", path="c.toml", line=i) for i in range(3)]
    error = DataError("wrong 0", problems=problems)
    _, _, err = run(fail(error), "do")
    assert [line.split()[2] for line in err.splitlines()] == ["c.toml:0", "c.toml:1", "c.toml:2"]
    code, out, err = run(fail(error), "do", "--json")
    assert (code, err) == (3, "")
    assert [p["message"] for p in strict(out)["error"]["problems"]] == ["wrong 0", "wrong 1", "wrong 2"]
    code, out, err = run(fail(FitError("no minimum", fix="give starts")), "do", "--json")
    assert (code, err) == (3, "")
    one = {"code": "RF400", "message": "no minimum", "where": "", "fix": "give starts"}
    assert strict(out) == {"error": one}


def test_an_unexpected_failure_is_owned_up_to_without_a_traceback(run, monkeypatch, strict):
    monkeypatch.delenv("ROPEFRIC_DEBUG", raising=False)
    code, out, err = run(fail(ZeroDivisionError("by zero")), "do")
    assert (code, out) == (1, "")
    assert all(one in err for one in ("internal fault, ZeroDivisionError: by zero", "report"))
    assert "Traceback" not in err
    monkeypatch.setenv("ROPEFRIC_DEBUG", "1")
    code, out, err = run(fail(ZeroDivisionError("by zero")), "do", "--json")
    assert (code, strict(out)["error"]["code"]) == (1, "RF000")
    assert "Traceback" in err


def test_a_file_the_system_refuses_is_the_users_to_mend(run):
    code, _, err = run(lambda out, size: open("no/such.toml"), "do")  # noqa: PTH123, SIM115
    assert code == 3
    assert all(one in err for one in ("no/such.toml", "no such file"))


def test_an_interruption_is_130(run, strict):
    assert run(fail(KeyboardInterrupt()), "do") == (130, "", "error RF001  interrupted\n")
    code, out, err = run(fail(KeyboardInterrupt()), "do", "--json")
    assert ((code, err), strict(out)["error"]["message"]) == ((130, ""), "interrupted")


USAGES = {("od",): ("no such command 'od'", "see ropefric --help"),
    ("doo",): ("no such command 'doo'", "did you mean 'do'?"),
    ("do", "--sise", "3"): ("no such option: --sise", "did you mean '--size'?"),
    ("do", "--size", "big"): ("invalid value for '--size'", "see ropefric do --help"),
    ("do", "--size"): ("requires", "see ropefric --help"),
    ("do", "surplus"): ("surplus", "see ropefric do --help")}  # fmt: skip


def test_wrong_usage_is_2_and_says_what_would_have_worked(run, strict):
    for argv, (message, hint) in USAGES.items():
        code, out, err = run(lambda out, size: answer(), *argv)
        assert (code, out) == (2, ""), argv
        assert message in err
        assert hint in err
        code, out, err = run(lambda out, size: answer(), "--json", *argv)
        assert (code, err) == (2, "")
        assert message in strict(out)["error"]["message"]


def test_no_command_shows_the_help_and_the_version_is_told(run, capfd, strict):
    code, out, _ = run(lambda out, size: answer())
    assert (code, "do" in out, "Exit codes" in out) == (0, True, True)
    assert app.main(["--version"]) == 0
    assert capfd.readouterr().out.startswith("ropefric ")
    assert app.main(["--version", "--json"]) == 0
    assert "version" in strict(capfd.readouterr().out)


def test_every_command_explains_itself_and_takes_the_global_options(capsys):
    assert app.main(["--help"]) == 0
    of_all = " ".join(capsys.readouterr().out.split())
    for name, command in find_commands().items():
        assert app.main([name, "--help"]) == 0
        text = capsys.readouterr().out
        assert all(option in text for option in ("--json", "--quiet", "--no-color")), name
        assert command.example.startswith(f"ropefric {name}")
        said = command.run.__doc__.strip()
        assert said.splitlines()[0].endswith(".")
        assert " ".join(said.partition("\n\n")[0].split()) in of_all


def test_commands_stand_in_the_order_of_work_each_at_a_place_of_its_own():
    commands = find_commands()
    orders = [command.order for command in commands.values()]
    assert len(set(orders)) == len(orders)
    assert list(commands) == [*("app", "init", "inspect", "check", "simulate", "extract", "run", "review", "report"),
        *("fit", "show", "compare", "diagnose", "predict", "budget", "design", "plan-tests"),
        *("solve", "explain", "cost", "verify", "check-plugin")]  # fmt: skip


def test_problems_are_colored_at_a_terminal_but_where_color_is_not_wanted(monkeypatch):
    from ropefric.cli.output import Output

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    def said(**wishes):
        stream = Terminal()
        monkeypatch.setattr(sys, "stderr", stream)
        Output(**wishes).problems([Problem(code="RF110", message="an error of 3 N", fix="correct it")])
        return stream.getvalue()

    monkeypatch.delenv("NO_COLOR", raising=False)
    plain = "error RF110  an error of 3 N\n  fix: correct it\n"
    assert said() == f"\x1b[31m\x1b[1merror\x1b[0m{plain.removeprefix('error')}"
    assert said(color=False) == plain
    monkeypatch.setenv("NO_COLOR", "1")
    assert said() == plain


def test_json_takes_numpy_and_refuses_what_has_no_place_in_it(strict):
    import numpy as np

    array = np.array([[1.5, np.inf]])
    data = {"flag": np.bool_(True), "n": np.int64(3), "x": np.float64("nan"), "array": array}
    assert strict(json_text(data)) == {"flag": True, "n": 3, "x": None, "array": [[1.5, None]]}
    with pytest.raises(TypeError, match="object has no place"):
        json_text({"a": object()})


def test_help_starts_light():
    """Asserted on what is loaded, never on the clock."""
    code = ("import sys\nfrom ropefric.cli.app import main\nassert main(['--help']) == 0\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'matplotlib', 'lmfit', 'pint', 'pydantic', 'asteval', 'rich'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n")  # fmt: skip
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_python_m_runs_it():
    done = subprocess.run([sys.executable, "-m", "ropefric", "chekc"], capture_output=True, text=True,
        check=False)  # fmt: skip
    assert done.returncode == 2
    assert "did you mean 'check'?" in done.stderr


def test_a_reader_that_goes_away_is_no_failure():
    """As in `ropefric … | head -1`: the pipe's reading end is closed before anything is written."""
    code = ("import os, sys\nfrom ropefric.cli import app\n"
        "from ropefric.cli.options import Answer, Command\nfrom ropefric.registry import Registry\n"
        "def run(out):\n    'Say much.'\n"
        "    return Answer(data={'x': ['y' * 99] * 9999}, show='y' * 99999, exit_code=4)\n"
        "command = Command(name='do', run=run, example='', order=1)\n"
        "app.find_commands = lambda: Registry('command', [command])\n"
        "sys.exit(app.main(sys.argv[1:]))\n")  # fmt: skip
    for argv, expected in ((["do"], 4), (["--help"], 0)):
        process = subprocess.Popen([sys.executable, "-c", code, *argv], stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True)  # fmt: skip
        process.stdout.close()
        process.stdout = None
        _, err = process.communicate()
        assert (process.returncode, err) == (expected, "")


def test_work_goes_on_when_nobody_listens_to_stderr(tmp_path):
    done = tmp_path / "done"
    code = ("import sys\nfrom pathlib import Path\nfrom ropefric.cli.output import Output\n"
        "for i in range(9):\n    Output().note('y' * 99999)\nPath(sys.argv[1]).touch()\n")  # fmt: skip
    process = subprocess.Popen([sys.executable, "-c", code, str(done)], stderr=subprocess.PIPE)
    process.stderr.close()
    assert process.wait() == 0
    assert done.exists()
    if (full := Path("/dev/full")).exists():
        with full.open("w") as stream:
            subprocess.run([sys.executable, "-c", code, str(done)], stderr=stream, check=True)
