"""Processes for reading: they get the work once, die alone, and outlive nobody."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ropefric.errors import DataError
from ropefric.trials.workers import Limits, Lost, guarded, usable_cores

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
DEADLINE_S = 60.0


def own_process(_):
    return os.getpid()


def fail(number):
    if number == 1:
        raise DataError("bad", path="a.csv", fix="mend it")
    return number


def large(number):
    return bytes(300_000 * (number + 1))


def test_every_piece_is_done_once_whatever_the_jobs():
    for jobs in (1, 2, 100_000):
        assert sorted(guarded(float, 23, jobs=jobs)) == [(i, float(i)) for i in range(23)]
    assert list(guarded(float, 0)) == []
    sizes = sorted(len(content) for _, content in guarded(large, 6, jobs=2))
    assert sizes == [300_000 * i for i in range(1, 7)]


def test_there_are_no_more_processes_than_pieces_and_cores():
    for n in (1, 40):
        used = {process for _, process in guarded(own_process, n, jobs=100_000)}
        assert 1 <= len(used) <= min(n, usable_cores())
        assert os.getpid() not in used


def test_what_the_work_raises_is_raised_here_as_it_was():
    with pytest.raises(DataError, match=r"a\.csv: bad") as caught:
        list(guarded(fail, 3))
    assert (caught.value.code, caught.value.fix) == ("RF101", "mend it")


def test_a_script_without_a_guard_is_not_run_again(tmp_path):
    """Where processes are spawned, as beside other threads, they would import it."""
    (tmp_path / "script.py").write_text(
        "import ropefric as rf\nimport threading\nfrom ropefric.trials.workers import guarded\n"
        "print('once', flush=True)\ndone = threading.Event()\nthreading.Thread(target=done.wait).start()\n"
        "print(sorted(guarded(float, 2)))\ndone.set()\n",
        encoding="utf-8",
    )
    words = [sys.executable, str(tmp_path / "script.py")]
    said = subprocess.run(words, capture_output=True, text=True, timeout=DEADLINE_S, check=True)
    assert said.stdout.split("\n")[:2] == ["once", "[(0, 0.0), (1, 1.0)]"]


def hang(number):
    time.sleep(600 if number == 1 else 0)
    return number


def test_a_piece_that_takes_too_long_is_lost_and_the_rest_is_done():
    found = dict(guarded(hang, 6, jobs=2, limits=Limits(time_s=1)))
    assert isinstance(found.pop(1), Lost)
    assert found == {number: number for number in (0, 2, 3, 4, 5)}


# --- what is left behind -------------------------------------------------------------------------------------------

HOLD = """
import os, signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored, and nohup the next
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from ropefric.trials.workers import guarded
folder = sys.argv[1]
def hold(number):
    open(os.path.join(folder, f"{os.getpid()}.pid"), "w").close()
    time.sleep(600)
if __name__ == "__main__":
    for _ in guarded(hold, 4, jobs=2):
        pass
"""


def until(condition):
    end_s = time.monotonic() + DEADLINE_S
    while not condition() and time.monotonic() < end_s:
        time.sleep(0.02)
    assert condition()


def runs(process):
    """Return whether a process is there and no corpse."""
    try:
        found = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
        return found.rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


@LINUX
@pytest.mark.parametrize("how", ["SIGKILL", *(pytest.param(one, marks=pytest.mark.slow)
    for one in ("SIGINT", "SIGTERM", "SIGHUP"))])  # fmt: skip
def test_a_killed_run_leaves_no_process_behind(tmp_path, how):
    script = tmp_path / "hold.py"
    script.write_text(HOLD, encoding="utf-8")
    parent = subprocess.Popen([sys.executable, str(script), str(tmp_path)], stderr=subprocess.DEVNULL)
    wanted = min(2, usable_cores())
    try:
        until(lambda: len(list(tmp_path.glob("*.pid"))) == wanted)
        workers = [int(path.stem) for path in tmp_path.glob("*.pid")]
        assert all(map(runs, workers))
        parent.send_signal(getattr(signal, how))
        parent.wait(DEADLINE_S)
        until(lambda: not any(map(runs, workers)))
    finally:
        parent.kill()
        parent.wait(DEADLINE_S)
