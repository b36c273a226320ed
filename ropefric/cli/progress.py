"""Progress on stderr: a bar for people at a terminal, a line every ten per cent for logs."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from ropefric.cli.output import Output
from ropefric.traces.breakaway import Status

if TYPE_CHECKING:
    from rich.progress import Progress as Bar


REDRAW_S = 0.1
_WITHOUT_FORCE = set(Status) - {Status.OK}


class Progress:
    """Shows how far a piece of work is; use as a context manager and hand `update` to the library."""

    def __init__(self, out: Output, what: str) -> None:
        self._out = out
        self._what = what
        self._bar: Bar | None = None
        self._drawn_s = -REDRAW_S
        self._tenths = 0
        self._without = 0

    def __enter__(self) -> Self:
        if not self._out.quiet and sys.stderr.isatty():
            self._bar = _make_bar(self._out)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update(self, done: int, total: int, item: str) -> None:
        """Take note that `done` of `total` items are finished, the last being `item`.

        An item that ends in the status of a recording ("run_148 no-peak") is counted if it gave no usable force.
        """
        self._count(item)
        if self._out.quiet:
            return
        if self._bar is not None:
            self._redraw(done, total)
        elif total > 0 and done * 10 // total > self._tenths:
            self._tenths = done * 10 // total
            self._out.note(f"{self._what} {done}/{total}  {100 * done // total} %{self._tally()}")

    def _count(self, item: str) -> None:
        self._without += item.rpartition(" ")[2] in _WITHOUT_FORCE

    def _tally(self) -> str:
        return f" · {self._without} without a force" if self._without else ""

    def _redraw(self, done: int, total: int) -> None:
        now_s = time.monotonic()
        if self._bar is None or (done < total and now_s - self._drawn_s < REDRAW_S):
            return
        self._drawn_s = now_s
        if not self._bar.task_ids:  # only now is the total known
            self._bar.add_task(self._what, total=total, note="")
            self._bar.start()
        self._bar.update(self._bar.task_ids[0], completed=done, total=total, note=self._tally())
        self._bar.refresh()


def _make_bar(out: Output) -> "Bar":
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn  # noqa: PLC0415  (only at a terminal)
    from rich.progress import Progress as RichProgress  # noqa: PLC0415

    return RichProgress(
        TextColumn("{task.description} {task.completed}/{task.total}"),
        BarColumn(bar_width=24),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=out.stderr,
        transient=True,
        auto_refresh=False,  # no drawing thread: worker processes are forked while the bar is up
    )
