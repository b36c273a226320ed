"""How every fuzz target is run: short by default, long with `-m slow`, both the same on every machine.

ROPEFRIC_FUZZ_EXAMPLES is the number of examples of the whole long run (15 000 if not set); every target has its
share of it. Ten seconds of processor time an example are a hang.
"""

import atexit
import os
import shutil
import signal
import tempfile
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings

from ropefric.errors import RopefricError

__all__ = ["HOSTILE", "LONG", "answered", "fuzzed", "limit", "scratch", "usable"]

HOSTILE = ("", "nan", "-inf", "1e300", "5e-324", "1e400", "9" * 5000, "-0", "1e-99999999999999999999", "١٢",
    "0x1F", "1_000", "1e300 mm", "1e300 Hz", "10**10**10 mm", "9**9**9**9", "1 " + "a" * 30 + "!",
    "9.8 Millimeterdurchmesserlaut-2019", "1 m" + "²" * 30, "_" * 20_000, "(" * 20_000, "a." * 20_000,
    "[" * 5000, "{a=" * 2000, '"', "'''", '"""', "\\", "\x00", "\x1b[31m", "\ufeff", "\u202e", "$\\frac{$",
    "=cmd|'/C calc'!A0", "+1", "@SUM(A1)", "-1+1", "../../x", "CON", "x" * 400, "%s%n", "{0}", "<script>",
    "&", "]]>", "NaN", "true", "null", "1979-05-27", "12:00", "1,5", "1.234,5", "1;2", "#", "\t",
    "\r")  # fmt: skip

LONG = int(os.environ.get("ROPEFRIC_FUZZ_EXAMPLES", "15000"))
HANG_S = 10


@contextmanager
def limit(seconds=HANG_S):
    """Fail where the work takes more processor time than this; only the main thread of a Unix can be interrupted.

    A clock on the wall would fail a busy machine.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_):
        raise AssertionError(f"hangs: more than {seconds} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def usable(error):
    """Assert that an error says what is wrong, in words, and has a code."""
    assert isinstance(error, RopefricError)
    assert error.code.startswith("RF")
    for problem in error.problems:
        assert len(problem.message) > 10, problem
        assert "Traceback" not in problem.message
        assert problem.severity in {"error", "warning"}
    assert error.exit_code == 3
    assert error.to_dict()["error"]["message"]


def answered(call, said=None):
    """Return what a call returns, or None where it is refused with a usable error; nothing else may come out.

    A list `said` gets the refusal's text.
    """
    try:
        return call()
    except RopefricError as error:
        usable(error)
        if said is not None:
            said.append(str(error))
        return None


def fuzzed(check, *, short, share, examples=(), **strategies):
    """Return the short and the long test of a target.

    `check` gets what the strategies draw; `share` is the target's part of the long run; `examples` are inputs that
    once went wrong.
    """

    def build(n):
        @settings(max_examples=max(n, 1), derandomize=True, deadline=None, database=None,
            suppress_health_check=list(HealthCheck))  # fmt: skip
        @given(**strategies)
        def test(**drawn):
            with limit():
                check(**drawn)

        for known in examples:
            test = example(**known)(test)
        test.__doc__ = check.__doc__
        return test

    return build(short), pytest.mark.slow(build(round(LONG * share)))


def scratch():
    """Return a folder to write in, gone at the end."""
    folder = Path(tempfile.mkdtemp(prefix="ropefric-fuzz-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
