"""The same work wherever it is done: here, in other processes, or on the machines of a cluster.

Work is cut into pieces that do not depend on who does them. `spread` hands them to an executor, a few ahead of the
results, and gives these back in the order of the pieces; what comes of them is the same to the last bit.
"""

import hashlib
import logging
import os
import socket
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import ExitStack, contextmanager
from functools import lru_cache, partial
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

from ropefric.errors import InputError, RopefricError

A = TypeVar("A")
T = TypeVar("T")

AHEAD = 128
"""Pieces in hand at most: a limit of waiting work and results, and of the workers that can be kept busy."""

CONNECT_S = 10.0
"""Time for a scheduler to answer."""

SILENT_S = 8.0
"""After so long without a result it is asked whether a cluster has workers; so long it may have none."""

CARRIED: list[Callable[[], Any]] = []
"""Executors that give something that every worker must have before its work: to unpickle it is to have it."""

_MADE_BY = ("numpy", "scipy", "pandas")
_OF_WORKERS = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}
# Memory that one recording took serves the next; dask would give it back after each, and fetch it again.
_OF_WORKERS |= {"MALLOC_MMAP_THRESHOLD_": str(32 * 2**20), "MALLOC_TRIM_THRESHOLD_": str(128 * 2**20)}


def usable_cores() -> int:
    """Return the number of processors this process may use."""
    if hasattr(os, "sched_getaffinity"):  # a container may own fewer cores than the machine has
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@lru_cache(maxsize=1)
def software() -> str:
    """Return what numbers are made by: the code of this package and the versions of its numerical libraries."""
    package, found = Path(__file__).parent, hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        found.update(path.read_bytes())
    libraries = ", ".join(f"{name} {version(name)}" for name in _MADE_BY)
    return f"ropefric {version('ropefric')} ({found.hexdigest()[:12]}), {libraries}"


def spread(
    work: Callable[[A], T],
    pieces: Iterable[A],
    executor: Any = None,
    *,
    again: Callable[[A, BaseException], T] | None = None,
    patience_s: float | None = None,
) -> Generator[T]:
    """Yield what comes of each piece of work, in order: done by an executor, or here without one.

    An executor is what `concurrent.futures` calls so, or a client of dask. At most `AHEAD` pieces are with it. A piece
    whose worker died, or that fails in any way but a `RopefricError`, is done here, by `again` where there is one; so is
    the oldest piece once an executor has been silent for `patience_s`. A cluster whose workers are all gone is an error.
    Close the iterator to call off the rest.
    """
    if executor is None:
        yield from map(work, pieces)
        return
    look = _nothing_to_look_at
    if hasattr(executor, "get_executor"):  # dask's client, whose own futures are of another kind
        look, executor = partial(_refuse_deserted, executor), executor.get_executor(pure=False)
    ahead: deque[tuple[A, Future[T]]] = deque()
    left = iter(pieces)
    try:
        while True:
            ahead.extend(
                (piece, _handed(executor, work, piece)) for piece in islice(left, AHEAD - len(ahead))
            )
            if not ahead:
                return
            piece, future = ahead[0]
            try:
                _wait_for(future, [one for _, one in ahead], patience_s, look)
                found = future.result(0.0)
            except RopefricError:
                raise
            # As with one process: what a piece brings about by itself, it brings about here as well.
            except Exception as error:  # noqa: BLE001
                look()
                future.cancel()
                found = work(piece) if again is None else again(piece, error)
            ahead.popleft()
            yield found
    finally:
        for _, future in ahead:
            future.cancel()


def carried() -> list[Any]:
    """Return what goes with the work to other processes, to be unpickled there first."""
    return [one() for one in CARRIED]


def _handed(executor: Executor, work: Callable[[A], T], piece: A) -> "Future[T]":
    """Return the future of a piece; of an executor that is broken, one that failed."""
    try:
        return executor.submit(_there, software(), carried(), work, piece)
    except Exception as error:  # noqa: BLE001
        future: Future[T] = Future()
        future.set_exception(error)
        return future


def _wait_for(
    future: "Future[Any]", every: "list[Future[Any]]", patience_s: float | None, look: Callable[[], None]
) -> None:
    """Wait for a result, as long as any comes; look from time to time whether anybody is there to give one."""
    step_s = SILENT_S if patience_s is None else min(SILENT_S, patience_s)
    waiting, silent_s = {one for one in every if not one.done()}, 0.0
    while not future.done():
        done, waiting = wait(waiting, step_s, FIRST_COMPLETED)
        silent_s = 0.0 if done else silent_s + step_s
        if not done:
            look()
        if patience_s is not None and silent_s >= patience_s:
            raise TimeoutError


def _nothing_to_look_at() -> None:
    """Do nothing: the end of a process of this machine is reported anyway."""


def _refuse_deserted(client: Any) -> None:
    """Refuse to wait for a cluster whose workers, or whose scheduler, are gone."""
    try:
        client.wait_for_workers(1, timeout=SILENT_S)
    except Exception as error:  # noqa: BLE001  (each way to lose a scheduler has an exception of its own)
        message = (
            f"the cluster at {client.scheduler.address} has no worker that works ({type(error).__name__})"
        )
        fix = "start workers again with `dask worker ADDRESS`, or leave --cluster out; nothing was written"
        raise InputError(message, code="RF110", key="--cluster", fix=fix) from None


def _there(made_by: str, _carried: object, work: Callable[[A], T], piece: A) -> T:
    """Do a piece in another process, if that is of the same make."""
    if software() != made_by:
        raise InputError(
            f"a worker runs {software()}, this process {made_by}: numbers may differ",
            key="executor",
            fix="install the same versions on all machines, and start the workers again",
        )
    return work(piece)


@contextmanager
def cluster(address: str, n_workers: int = 0) -> Iterator[Any]:
    """Yield a client of a dask scheduler, or of one on this machine ("local"), as an executor; None without address.

    A local worker is a process with one thread; there are `n_workers` of them, at least two, and nobody outside this
    machine can reach them.
    """
    if not address:
        yield None
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        fix = 'pip install "ropefric[cluster]", or leave --cluster out'
        message = "a cluster needs dask.distributed, which is not installed"
        raise InputError(message, code="RF107", key="--cluster", fix=fix) from None
    # What dask logs of lost connections, with tracebacks, is said here in words.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    configured = {
        "distributed.comm.timeouts.connect": f"{CONNECT_S:g}s",
        "distributed.nanny.pre-spawn-environ": _OF_WORKERS,
        "distributed.worker.profile.enabled": False,  # a hundred looks a second at what a worker does
    }
    import_module("dask").config.set(configured)
    with ExitStack() as stack:
        if address == "local":
            at_home: dict[str, Any] = {"host": "127.0.0.1", "dashboard_address": None}
            at_home |= {"worker_dashboard_address": None, "silence_logs": logging.CRITICAL}
            local = distributed.LocalCluster(
                n_workers=max(2, n_workers or usable_cores()), threads_per_worker=1, **at_home
            )
            address = stack.enter_context(local).scheduler_address
        try:
            _knock(address)
            client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            message = f"no scheduler answers at {address!r}: {str(error) or type(error).__name__}"
            fix = "start one with `dask scheduler`, give its address as tcp://HOST:8786, or say local"
            raise InputError(message, code="RF110", key="--cluster", fix=fix) from None
        yield stack.enter_context(client)


def _knock(address: str) -> None:
    """Connect to an address and leave again: dask would try for long, and leave a traceback."""
    if not address.rpartition(":")[2].isdigit():
        raise ValueError("the address has no port")
    place = urlsplit(address if "://" in address else f"tcp://{address}")
    socket.create_connection((place.hostname or "", place.port or 0), CONNECT_S).close()
