"""Work that is spread over executors: in order, a few ahead, and done here where an executor fails."""

import os
import signal
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from itertools import count, islice
from multiprocessing import parent_process

import pytest

from ropefric import executors
from ropefric.errors import DataError, InputError
from ropefric.executors import AHEAD, cluster, software, spread, usable_cores


def square(number):
    return number * number


def fatal_elsewhere(number):
    if number == 7 and parent_process() is not None:
        os.kill(os.getpid(), signal.SIGKILL if sys.platform != "win32" else signal.SIGTERM)
    return number * number


def refuse(number):
    raise DataError(f"{number} is bad", path="a.csv", fix="mend it")


def divide(number):
    return 1 / (3 - number)


class Backwards(Executor):
    """Does everything that was handed over, the last first, once as much waits as will ever be."""

    def __init__(self, most=AHEAD):
        self.waiting, self.most, self.longest, self.submitted = [], most, 0, 0

    def submit(self, work, *arguments):
        future = Future()
        self.waiting.append((future, work, arguments))
        self.submitted += 1
        self.longest = max(self.longest, len(self.waiting))
        if len(self.waiting) == self.most:
            self.flush()
        return future

    def flush(self):
        while self.waiting:
            future, work, arguments = self.waiting.pop()
            if future.set_running_or_notify_cancel():
                future.set_result(work(*arguments))


class Silent(Executor):
    """Never answers."""

    def submit(self, work, *arguments):
        return Future()


def test_results_come_in_order_whatever_order_they_are_made_in():
    for n in (0, 1, AHEAD):
        backwards = Backwards(most=n)
        assert list(spread(square, range(n), backwards)) == [i * i for i in range(n)]
        assert backwards.longest == n
    assert list(spread(square, range(9))) == [i * i for i in range(9)]


def test_no_more_is_in_hand_than_may_be_whatever_there_is_to_do():
    drawn = count()
    with ThreadPoolExecutor(2) as pool:
        running = spread(square, drawn, pool)
        for done, found in enumerate(islice(running, 5 * AHEAD)):
            assert found == done * done
            handed = int(repr(drawn).removeprefix("count(").removesuffix(")"))
            assert handed <= done + AHEAD
        running.close()


@pytest.mark.parametrize("n", [20, AHEAD + 20])
def test_a_pool_that_breaks_in_the_middle_loses_nothing(n):
    with ProcessPoolExecutor(2) as pool:
        assert list(spread(fatal_elsewhere, range(n), pool)) == [i * i for i in range(n)]
        told = []
        again = spread(square, range(3), pool, again=lambda piece,
            error: told.append((piece, type(error).__name__)))  # fmt: skip
        assert (list(again), told) == ([None] * 3, [(piece, "BrokenProcessPool") for piece in range(3)])


def test_what_is_wrong_with_the_work_is_raised_as_with_one_process():
    with ThreadPoolExecutor(2) as pool:
        with pytest.raises(DataError, match=r"a\.csv: 0 is bad"):
            list(spread(refuse, range(4), pool))
        running = spread(divide, range(6), pool)
        assert [next(running) for _ in range(3)] == [1 / 3, 1 / 2, 1.0]
        with pytest.raises(ZeroDivisionError):
            next(running)


def test_an_executor_that_falls_silent_is_not_waited_for():
    assert list(spread(square, range(3), Silent(), patience_s=0.01)) == [0, 1, 4]


def test_what_is_called_off_is_cancelled():
    futures = []

    class First(Executor):
        def submit(self, work, *arguments):
            futures.append(Future())
            if len(futures) == 1:
                futures[0].set_result(work(*arguments))
            return futures[-1]

    running = spread(square, range(50), First())
    assert next(running) == 0
    running.close()
    assert len(futures) == 50
    assert all(future.cancelled() for future in futures[1:])


def test_workers_of_another_make_are_refused(monkeypatch):
    def there(_made_by, work, piece):
        return executors._there("ropefric 0.0.1", (), work, piece)

    monkeypatch.setattr(executors, "_handed", lambda pool, work, piece: pool.submit(there, "", work, piece))
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match=r"a worker runs .*numpy .*0\.0\.1"):
        list(spread(square, range(2), pool))
    assert "numpy" in software()


def test_there_is_a_core_to_use():
    assert 1 <= usable_cores() <= (os.cpu_count() or 1)


def test_without_an_address_there_is_no_cluster_and_without_dask_it_says_what_to_install(monkeypatch):
    with cluster("") as executor:
        assert executor is None

    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(executors, "import_module", missing)
    with pytest.raises(InputError, match=r"dask\.distributed") as caught, cluster("local"):
        pass
    assert "ropefric[cluster]" in caught.value.fix


@pytest.mark.parametrize(
    "address",
    [
        # Dask leaves a thread behind; extractions of this process would no longer fork.
        pytest.param("tcp://127.0.0.1:9", marks=pytest.mark.slow),
        *("foo", "tcp://host", "nonsense://x", "127.0.0.1:no"),
    ],
)
def test_where_no_scheduler_answers_that_is_said(monkeypatch, address):
    monkeypatch.setattr(executors, "CONNECT_S", 0.2)
    with pytest.raises(InputError, match="no scheduler answers") as caught, cluster(address):
        pass
    assert "dask scheduler" in caught.value.fix
