"""Where words go: results on stdout, as JSON or for people; everything said along the way, and progress, on stderr."""

import json
import math
import os
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import typer

from ropefric.errors import Problem
from ropefric.files.disk import cannot_write
from ropefric.files.plain_text import visible

if TYPE_CHECKING:
    from rich.progress import Progress as Bar


ALL_BY_JSON = "--json lists all"
_SHOWN = 3
PIPE_WIDTH = 200
"""Columns of what goes into a file or pipe."""
REDRAW_S = 0.1


class Output(NamedTuple):
    """The wanted form of output."""

    json: bool = False
    quiet: bool = False
    color: bool = True

    def result(self, text: str) -> None:
        """Write the result to stdout, in one piece; a reader that goes away is no failure of the work."""
        try:
            sys.stdout.write(text)
            sys.stdout.flush()
        except OSError as error:
            # Else the interpreter's last flush would complain.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            if not isinstance(error, BrokenPipeError):
                raise cannot_write(error, "the result") from None

    def note(self, text: str) -> None:
        """Say something on stderr, unless asked to be quiet."""
        if not self.quiet:
            self._say(visible(text))

    def problems(self, problems: Iterable[Problem], rest: str = ALL_BY_JSON) -> None:
        """List problems on stderr, a line for each cause; warnings only if not asked to be quiet."""
        for_eyes = sys.stderr.isatty() or "FORCE_COLOR" in os.environ
        colored = for_eyes and self.color and not os.environ.get("NO_COLOR")
        for problem in by_cause(problems, rest):
            if problem.severity == "error" or not self.quiet:
                text = visible(str(problem))
                if colored:
                    color = {"error": "red", "warning": "yellow"}[problem.severity]
                    severity = typer.style(problem.severity, fg=color, bold=True)
                    text = severity + text.removeprefix(problem.severity)
                self._say(text, colored=colored)

    def _say(self, text: str, *, colored: bool = False) -> None:
        # The work goes on when nobody listens any more (`2>&1 | head`), or the log's disk is full.
        with suppress(OSError):
            if colored:
                typer.echo(text, err=True, color=True)  # it translates colours for terminals that need it
            else:
                sys.stderr.write(f"{text}\n")
                sys.stderr.flush()


def by_cause(problems: Iterable[Problem], rest: str = ALL_BY_JSON) -> list[Problem]:
    """Return one problem for each cause: how many it is, where the first three of them are, and where the rest is.

    Of one cause are problems that one remedy mends; with a few messages, such as the names of two wheels that are
    not known, each of these is one.
    """
    causes: dict[tuple[str, ...], dict[str, list[Problem]]] = {}
    for one in problems:
        alike = causes.setdefault((one.severity, one.code, one.key, one.fix), {})
        alike.setdefault(one.message, []).append(one)
    told: list[Problem] = []
    for by_message in causes.values():
        groups = [*by_message.values()]
        if len(groups) > _SHOWN:
            groups = [[one for group in groups for one in group]]
        told += (group[0] if len(group) == 1 else _as_one(group, rest) for group in groups)
    return told


def _as_one(alike: Sequence[Problem], rest: str) -> Problem:
    """Return problems of one cause as one."""
    first, shown, n = alike[0], alike[:_SHOWN], len(alike)
    more = f", …; {rest}" if n > _SHOWN else ""
    if all(one.path == first.path and one.line is not None for one in shown):
        places = "lines " + ", ".join(str(one.line) for one in shown)
    elif len({one.path for one in shown}) == len(shown):
        places = ", ".join(one.path for one in shown)
    else:
        # "R_w = 40 mm: n = 3, …": what they have in common is said once.
        heads, _, tails = zip(*(one.message.partition(": ") for one in shown), strict=True)
        others = heads[1:] if all(tails) and len(set(tails)) == 1 else [one.message for one in shown[1:]]
        places = "; ".join(["this", *others])
    times = "times" if len({one.message for one in alike}) == 1 else "such"
    return replace(first, message=f"{first.message} ({n} {times}: {places}{more})")


def json_text(data: Any) -> str:
    """Return `data` as one strict JSON document, keys sorted, NaN and infinities as null."""
    return json.dumps(_plain(data), indent=2, sort_keys=True, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):  # NumPy scalars and arrays, without loading NumPy to ask
        return _plain(value.tolist())
    raise TypeError(f"{type(value).__name__} has no place in a JSON result")


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

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update_named(self, item: str, done: int, total: int) -> None:
        """Take note as `update` does, with the item first."""
        self.update(done, total, item)

    def update(self, done: int, total: int, item: str) -> None:
        """Take note that `done` of `total` items are finished, the last being `item`.

        An item that ends in the status of a recording ("run_148 no-peak") is counted if it gave no usable force.
        """
        from ropefric.traces.breakaway import Status  # noqa: PLC0415  (quick start-up)

        self._without += item.rpartition(" ")[2] in set(Status) - {Status.OK}
        without = f" · {self._without} without a force" if self._without else ""
        if self._out.quiet:
            return
        if self._bar is None:
            if total > 0 and done * 10 // total > self._tenths:
                self._tenths = done * 10 // total
                self._out.note(f"{self._what} {done}/{total}  {100 * done // total} %{without}")
            return
        now_s = time.monotonic()
        if done < total and now_s - self._drawn_s < REDRAW_S:
            return
        self._drawn_s = now_s
        if not self._bar.task_ids:  # only now is the total known
            self._bar.add_task(self._what, total=total, note="")
            self._bar.start()
        self._bar.update(self._bar.task_ids[0], completed=done, total=total, note=without)
        self._bar.refresh()


def _make_bar(out: Output) -> "Bar":
    from rich.console import Console  # noqa: PLC0415  (only at a terminal)
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn  # noqa: PLC0415
    from rich.progress import Progress as RichProgress  # noqa: PLC0415

    count = TextColumn("{task.description} {task.completed}/{task.total}"), BarColumn(bar_width=24)
    left = TextColumn("{task.percentage:>3.0f} %"), TimeRemainingColumn(), TextColumn("{task.fields[note]}")
    # No drawing thread: worker processes are forked while the bar is up.
    console = Console(file=sys.stderr, emoji=False, color_system="auto" if out.color else None)
    return RichProgress(*count, *left, console=console, transient=True, auto_refresh=False)
