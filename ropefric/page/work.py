"""Long work in a thread of its own, with its progress; it can be stopped."""

import threading
from collections.abc import Callable
from typing import Any

from ropefric.errors import InputError, known_error

REPORT_WITH = "what you did on the page"
"""The part of a fault report that only the person at the page knows."""

Step = Callable[[int, int, str], None]
"""Takes the number of parts that are done, their total, and the name of the present one."""


class _StoppedError(BaseException):
    """The work in progress is no longer wanted; like Ctrl-C, it is no fault that the work may answer."""


class Work:
    """One long work at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._stop = False
        self._state: dict[str, Any] = {"name": "", "running": False}

    def begin(self, name: str, do: Callable[[Step], Any], *, instead: bool = False) -> dict[str, Any]:
        """Begin a work, which calls its `Step` now and then, and return its state.

        With `instead` it takes the place of a work in progress, whose result is lost.
        """
        with self._lock:
            if self._state["running"] and not instead:
                raise InputError(f"{self._state['name']} has not finished yet", fix="wait for it, or stop it")
            self._stop = False
            self._state = {"name": name, "running": True, "done": 0, "total": 0, "item": ""}
            self._thread = threading.Thread(target=self._run, args=(do, self._state), name=name, daemon=True)
            self._thread.start()
        return {"work": self.state()}

    def _run(self, do: Callable[[Step], Any], state: dict[str, Any]) -> None:
        def step(done: int, total: int, item: str) -> None:
            with self._lock:
                if self._stop or state is not self._state:
                    raise _StoppedError
                state.update(done=done, total=total, item=item)

        try:
            ended = {"result": do(step)}
        except _StoppedError:
            message = f"{state['name']} was stopped; nothing of it is lost"
            ended = {"error": {"code": "", "message": message}}
        except Exception as error:  # noqa: BLE001  (the boundary: the page gets words)
            ended = known_error(error, report_with=REPORT_WITH).to_dict()
        with self._lock:
            state.update(running=False, **ended)

    def state(self) -> dict[str, Any]:
        """Return name and progress of the work; or its result, or its error, once it has ended."""
        with self._lock:
            return dict(self._state)

    def stop(self) -> dict[str, Any]:
        """Let the work end at its next step."""
        self._stop = True
        return self.state()

    def close(self) -> None:
        """End the work, and wait a moment for it."""
        self._stop = True
        if self._thread is not None:
            self._thread.join(5.0)
