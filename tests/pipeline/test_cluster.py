"""A real cluster of two worker processes: the same bytes as one process, though a worker dies in the middle."""

import os
import runpy
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor
from dataclasses import fields, replace
from itertools import product
from pathlib import Path

import pytest
from distributed import Client, LocalCluster

import ropefric as rf
from ropefric.cli.app import main
from ropefric.errors import DataError
from ropefric.executors import cluster
from ropefric.scenes.sweep import columns_text, parse_axis, sweep_scene
from ropefric.trials import extract as extracting
from ropefric.trials.campaign import load_campaign
from ropefric.trials.result import write_tables

# Threads that dask leaves behind make every later extraction of this process start others afresh, not fork them.
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
BENCH = ROOT / "data" / "prth-bench"


@pytest.fixture(scope="module")
def client():
    """Two processes behind a scheduler, reached by its address as a remote one would be."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as two, Client(two) as one:
        yield one


@pytest.fixture
def bench():
    loaded = load_campaign(BENCH / "campaign.toml")
    return loaded.model_copy(update={"trials": loaded.trials[:40]})


def written(extraction, folder):
    return {path.name: path.read_bytes() for path in write_tables(extraction, folder)}


class Killing(Executor):
    """Kills a worker when half of twenty pieces are handed over, before any of them can be done."""

    def __init__(self, client):
        self.client, self.executor, self.submitted = client, client.get_executor(pure=False), 0

    def submit(self, work, *arguments):
        self.submitted += 1
        if self.submitted == 10:
            kill_one(self.client)
        return self.executor.submit(work, *arguments)


def kill_one(client):
    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_recordings_give_the_same_bytes_though_a_worker_is_killed(client, bench, tmp_path, monkeypatch):
    monkeypatch.setattr(extracting, "_PIECE", 2)
    monkeypatch.chdir(tmp_path)  # the workers' own folder is another
    seen = []
    found = rf.extract(
        bench, executor=Killing(client), progress=lambda done, total, _: seen.append((done, total))
    )
    assert seen == [(i, 40) for i in range(1, 41)]
    alone = rf.extract(bench)
    assert written(found, tmp_path / "two") == written(alone, tmp_path / "one")


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_recordings_that_workers_do_not_find_are_an_error_and_no_bad_recordings(client, bench, monkeypatch):
    monkeypatch.chdir(BENCH / "traces")  # what follows names another folder in each process
    moved = replace(bench.trials[3], path=Path("/proc/self/cwd") / bench.trials[3].path.name)
    hidden = bench.model_copy(update={"trials": (*bench.trials[:3], moved)})
    assert [trial.breakaway.status for trial in rf.extract(hidden).trials].count("unreadable") == 0
    with pytest.raises(DataError, match="a worker does not find this file") as caught:
        rf.extract(hidden, executor=client)
    assert "under the same name" in caught.value.fix


SWEEPS = {"planned for its box": ("hoist", ["wheel.wrap=90deg:1440deg:300", "rope.diameter=1mm:80mm:400"]),
    "some without an answer": ("press-start-up", ["friction.mu=0.001,0.1,0.3"]),
    "point by point": ("belt-press", ["belts.upper.width=1m:2m:45"])}  # fmt: skip


@pytest.mark.parametrize("name", SWEEPS)
def test_the_table_of_a_sweep_is_the_same(client, name):
    scene = rf.load_scene(BENCH.parent / "scenes" / f"{SWEEPS[name][0]}.toml")
    axes = tuple(parse_axis(scene, text) for text in SWEEPS[name][1])

    def swept(executor):
        seen = []
        found = sweep_scene(scene, axes, progress=lambda *told: seen.append(told), executor=executor)
        names = [one.name for one in fields(found) if one.name not in {"axes", "columns"}]
        rest = [getattr(found, name) for name in names]
        return columns_text(found.table), seen, repr(rest)

    assert swept(None) == swept(client)


def test_the_commands_take_the_address_of_a_cluster_or_make_one(client, tmp_path):
    said = ["--quiet", "--no-figures"]
    assert main(["simulate", str(tmp_path / "lab"), "--conditions", "2", "--repeats", "6", "--quiet"]) == 0
    scene, axis = str(BENCH.parent / "scenes" / "hoist.toml"), "wheel.wrap=90deg:1440deg:50"
    sweep = ["solve", scene, "--sweep", axis, "--quiet"]
    ways = {"one": [], "two": ["--cluster", client.scheduler.address], "local": ["--cluster", "local"]}
    for name, more in ways.items():
        folder = ["--out", str(tmp_path / name)]
        assert main(["extract", str(tmp_path / "lab"), *folder, *said, *more]) == 0
        assert main([*sweep, "--out", str(tmp_path / f"{name}-sweep"), *more]) == 0
    for name, way in product(("one", "one-sweep"), ("two", "local")):
        files = {path.name: path.read_bytes() for path in (tmp_path / name).iterdir() if path.is_file()}
        other = tmp_path / name.replace("one", way)
        assert files == {path.name: path.read_bytes() for path in other.iterdir() if path.is_file()}


@pytest.fixture
def servants():
    """A scheduler and two workers as commands start them; their processes, and the address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    host, port = address.removeprefix("tcp://").split(":")
    commands = [["scheduler", "--host", host, "--port", port, "--no-dashboard"]]
    commands += [["worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]] * 2
    started = [
        subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", f"distributed.cli.dask_{words[0]}", *words[1:]],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for words in commands
    ]
    with Client(address, set_as_default=False, timeout=60) as here:
        here.wait_for_workers(2)
    yield started, address
    for one in started:
        one.kill()
        one.wait()


@pytest.mark.parametrize(
    "whom",
    [[1], pytest.param([1, 2], marks=pytest.mark.release), [0]],
    ids=["one worker", "all workers", "the scheduler"],
)
def test_a_command_whose_workers_are_killed_goes_on_or_ends_in_words(servants, tmp_path, whom):
    started, address = servants
    words = ["extract", str(BENCH / "campaign.toml"), "--out", str(tmp_path / "out"), "--no-figures"]
    words += ["--cluster", address]
    command = subprocess.Popen([sys.executable, "-m", "ropefric", *words], stderr=subprocess.PIPE, text=True)
    with Client(address, set_as_default=False) as here:
        while not any(here.processing().values()):
            assert command.poll() is None
            time.sleep(0.02)
    for number in whom:
        started[number].kill()
    begun_s = time.monotonic()
    _, said = command.communicate(timeout=120)
    if whom == [1]:
        assert command.returncode == 0
        return
    assert time.monotonic() - begun_s < 30.0
    assert (command.returncode, "Traceback" in said) == (3, False)
    assert "has no worker that works" in said
    assert "dask worker ADDRESS" in said


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_a_local_cluster_is_open_to_this_machine_alone():
    def listening():
        return {row.split()[1] for row in Path("/proc/net/tcp").read_text().splitlines() if " 0A " in row}

    before, seen, ended = listening(), set(), threading.Event()

    def watch():
        while not ended.wait(0.01):
            seen.update(listening() - before)

    watching = threading.Thread(target=watch)
    watching.start()
    with cluster("local") as one:
        assert len(one.nthreads()) == 2
    ended.set()
    watching.join()
    assert seen
    assert {place.split(":")[0] for place in seen} == {"0100007F"}


def test_a_recording_that_kills_its_reader_costs_that_recording(client, bench, tmp_path):
    hostile = runpy.run_path(str(ROOT / "tests" / "trials" / "test_hostile_files.py"))
    (tmp_path / "nested.mat").write_bytes(hostile["mat_of_nested_cells"](5000))
    fatal = replace(bench.trials[20], path=tmp_path / "nested.mat")
    spoilt = bench.model_copy(update={"trials": (*bench.trials[:20], fatal, *bench.trials[21:])})
    found = rf.extract(spoilt, executor=client)
    assert (repr(found), found.trials[20].breakaway.status) == (repr(rf.extract(spoilt)), "unreadable")
