"""Work on files that may do anything, in processes that may die: bounded in time and memory.

A file is handed to a process at a time. Where reading it kills the process, takes too long or too much memory, that
file alone is lost; another process takes the dead one's place. No process outlives this one, however it ends.
"""

import os
import signal
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from ropefric.errors import RopefricError, plugin_error
from ropefric.executors import carried, usable_cores

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.context import BaseContext
    from multiprocessing.process import BaseProcess


T = TypeVar("T")
_Work = Callable[[int], T]

START_S = 60.0
"""Time for a new process to say that it is ready."""

GRACE_S = 1.0
"""Time for a process to finish what it does when nothing more is wanted of it."""

_RAISE = "check the file; if it is good, raise the limit: [limits] {0} of the campaign, --{0} of inspect"
_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG
_HELD = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_READY, _DONE, _RAISED, _NO_MEMORY = range(4)


class Limits(NamedTuple):
    """Limits of reading one recording."""

    memory_bytes: float = 2e9
    time_s: float = 120.0

    @property
    def memory(self) -> str:
        """Return the memory in words."""
        scale, unit = (1e9, "GB") if self.memory_bytes >= 1e9 else (1e6, "MB")
        return f"{self.memory_bytes / scale:.4g} {unit}"


class Lost(NamedTuple):
    """A piece of work that gave nothing, and why."""

    reason: str
    fix: str


def guarded(
    work: Callable[[int], T], n: int, *, jobs: int = 1, limits: Limits | None = None
) -> Generator[tuple[int, T | Lost]]:
    """Give number and result of each of `n` pieces of work, in the order they are finished.

    What `work` raises is raised here; close the iterator to end the processes early.
    """
    context = _way_to_start()
    if context is None:
        yield from ((number, work(number)) for number in range(n))
        return
    limits, most, waiting = limits or Limits(), max(1, min(jobs, n, usable_cores())), deque(range(n))
    workers: list[_Worker[T]] = []
    try:
        while waiting or any(worker.given is not None for worker in workers):
            n_idle = sum(worker.given is None for worker in workers)
            while len(workers) < min(most, len(waiting) + len(workers) - n_idle):
                workers.append(_Worker(context, work, limits, [worker.ours for worker in workers]))
            for worker in workers:
                if waiting and worker.given is None:
                    worker.give(waiting.popleft())
            yield from _heard(workers)
            workers[:] = [worker for worker in workers if not worker.dead]
    finally:
        _end(workers)


def _way_to_start() -> "BaseContext | None":
    """Return how processes are started here; None in a process that may have none of its own."""
    import multiprocessing  # noqa: PLC0415  (quick start-up)

    if multiprocessing.current_process().daemon:
        return None
    # Threads may hold locks that a forked child would find locked for ever.
    may_fork = sys.platform == "linux" and threading.active_count() == 1
    return multiprocessing.get_context("fork" if may_fork else "spawn")


def _heard(workers: "list[_Worker[T]]") -> Iterator[tuple[int, T | Lost]]:
    """Wait until a worker says something or is late; give what was done or lost."""
    from multiprocessing.connection import wait  # noqa: PLC0415  (quick start-up)

    until_s = min(worker.deadline_s for worker in workers)
    speaking = wait([worker.ours for worker in workers], max(0.0, until_s - time.monotonic()))
    for worker in workers:
        if worker.ours in speaking:
            yield from worker.hear()
        elif time.monotonic() > worker.deadline_s:
            yield worker.stop_late()


def _end(workers: "list[_Worker[T]]") -> None:
    """End all processes: an idle one at once, a busy one after its piece, or soon."""
    for worker in workers:
        worker.dead = True
        worker.ours.close()
    until_s = time.monotonic() + GRACE_S
    for worker in workers:
        worker.process.join(max(0.0, until_s - time.monotonic()))
        if worker.process.is_alive():
            worker.process.kill()
            worker.process.join()


class _Worker(Generic[T]):
    """A process, the piece of work it has in hand, and when that must be done."""

    def __init__(
        self, context: "BaseContext", work: "_Work[T]", limits: Limits, others: "list[Connection]"
    ) -> None:
        self.ours, theirs = context.Pipe()
        self._limits = limits
        self.given: int | None = None
        self.dead = self._ready = False
        forks = context.get_start_method() == "fork"
        # A process that is not forked loads the plugins with its arguments, before what may be made of them.
        arguments = (carried(), work, theirs, limits, [*others, self.ours] if forks else [])
        self.process: BaseProcess = context.Process(target=_serve, args=arguments, daemon=True)  # type: ignore[attr-defined]
        try:
            with warnings.catch_warnings(), _signals_held(), nullcontext() if forks else _nobody_is_main():
                warnings.simplefilter("ignore", DeprecationWarning)  # of threads that numpy has already ended
                self.process.start()
        except OSError as error:
            message = f"no process can be started: {error.strerror}"
            raise RopefricError(message, code="RF110", key="jobs", fix="use fewer jobs") from None
        theirs.close()
        self.deadline_s = time.monotonic() + START_S

    def give(self, number: int) -> None:
        """Hand over a piece of work."""
        if self._ready:
            self.deadline_s = time.monotonic() + self._limits.time_s
        self.given = number
        with suppress(OSError):  # if it died, hearing from it will tell
            self.ours.send(number)

    def hear(self) -> Iterator[tuple[int, T | Lost]]:
        """Give the result that is there, if it is one."""
        try:
            kind, content = self.ours.recv()
        except (EOFError, OSError):
            _end([self])
            if not self._ready:
                message = f"a process for reading ended as it started (exit code {self.process.exitcode})"
                raise RopefricError(message, code="RF000") from None
            if self.given is not None:
                yield self.given, self._crashed()
            return
        if kind == _READY:
            self._ready = True
            self.deadline_s = float("inf") if self.given is None else time.monotonic() + self._limits.time_s
        elif kind == _RAISED:
            raise content
        elif self.given is not None:
            number, self.given, self.deadline_s = self.given, None, float("inf")
            if kind == _NO_MEMORY:
                _end([self])
                reason = f"reading it took more than {self._limits.memory} of memory"
                content = Lost(reason=reason, fix=_RAISE.format("memory"))
            yield number, content

    def stop_late(self) -> tuple[int, Lost]:
        """End the process, which took too long."""
        self.process.kill()
        _end([self])
        reason = f"reading it took longer than {self._limits.time_s:g} s"
        assert self.given is not None  # noqa: S101  (else there is no deadline)
        return self.given, Lost(reason=reason, fix=_RAISE.format("time"))

    def _crashed(self) -> Lost:
        code = self.process.exitcode or 0
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        reason = f"the reader crashed ({how}): the file is damaged, or needs more than {self._limits.memory} of memory"
        return Lost(reason=reason, fix="save the file again, for example as CSV")


@contextmanager
def _signals_held() -> Iterator[None]:
    """Keep signals waiting while a process starts, which would answer them with its parent's words."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _HELD)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _nobody_is_main() -> Iterator[None]:
    """Hide the main module, which a spawned process would import: it may be a script that does its work at once."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _serve(
    _carried: object, work: "_Work[Any]", connection: "Connection", limits: Limits, others: "list[Connection]"
) -> None:
    """Work on tasks until the other end is closed."""
    for other in others:  # else this process would keep the pipes of its sisters open
        other.close()
    become_expendable()
    _limit_memory(limits.memory_bytes)
    try:
        connection.send((_READY, None))
        while True:
            number = connection.recv()
            if hasattr(signal, "alarm"):  # for a parent that died and cannot end a piece that hangs
                signal.alarm(int(limits.time_s) + 60)
            try:
                answer = (_DONE, work(number))
            except MemoryError:
                connection.send((_NO_MEMORY, None))
                return  # what memory is left is in pieces
            except Exception as error:  # noqa: BLE001  (it is raised where the work was asked for)
                answer = (_RAISED, plugin_error(error) or error)  # its traceback stays here
            connection.send(answer)
    except (EOFError, OSError):
        return


def become_expendable() -> None:
    """Leave Ctrl-C to the parent, die with it, and say nothing on the way."""
    import faulthandler  # noqa: PLC0415

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in ("SIGTERM", "SIGHUP", "SIGALRM"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _HELD)
    if sys.platform == "linux":
        import ctypes  # noqa: PLC0415

        parent = os.getppid()
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
        if os.getppid() != parent:  # it died just before
            os._exit(0)
    faulthandler.disable()
    silence = os.open(os.devnull, os.O_WRONLY)
    for descriptor in (1, 2):
        os.dup2(silence, descriptor)


def _limit_memory(most_bytes: float) -> None:
    if sys.platform != "linux":
        return
    import resource  # noqa: PLC0415

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        has_bytes = (
            int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5]) * resource.getpagesize()
        )
    except (OSError, ValueError, IndexError):  # no such file system here: then there is no limit either
        return
    # Data, not address space: what threads and libraries merely reserve takes no memory.
    wanted, (_, hard) = int(has_bytes + most_bytes), resource.getrlimit(resource.RLIMIT_DATA)
    if hard == resource.RLIM_INFINITY or wanted < hard:
        resource.setrlimit(resource.RLIMIT_DATA, (wanted, wanted))
