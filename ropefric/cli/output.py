"""Where words go: results on stdout, as JSON or for people; everything said along the way, and progress, on stderr."""

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Self, TextIO

from ropefric.errors import Problem
from ropefric.files.plain_text import visible
from ropefric.files.write import cannot_write

if TYPE_CHECKING:
    from rich.console import Console as Console  # noqa: PLC0414  (for the commands)
    from rich.progress import Progress as Bar
    from rich.table import Table
else:
    Console = object  # rich costs half the start-up time


PIPE_WIDTH = 200
"""Columns for tables that go into a file or pipe, where nothing needs to be folded."""
REDRAW_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """What the user wants to see."""

    json: bool = False
    quiet: bool = False
    color: bool = True

    @property
    def stdout(self) -> Console:
        """Return a console for the result."""
        return console_on(sys.stdout, color=self.color)

    @property
    def stderr(self) -> Console:
        """Return a console for messages."""
        return console_on(sys.stderr, color=self.color)

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
            self._say(f"{visible(text)}\n")

    def problems(self, problems: Iterable[Problem]) -> None:
        """List problems on stderr; warnings only if not asked to be quiet."""
        for problem in problems:
            if problem.severity == "error" or not self.quiet:
                styled = (
                    sys.stderr.isatty() or "FORCE_COLOR" in os.environ
                )  # else without rich, which takes a while
                show = partial(_print_problem, problem)
                self._say(rendered(self.stderr, show) if styled else f"{visible(str(problem))}\n")

    def _say(self, text: str) -> None:
        # The work goes on when nobody listens any more (`2>&1 | head`), or the log's disk is full.
        with suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()


def console_on(stream: TextIO, *, color: bool = True) -> Console:
    r"""Return a console that writes to `stream`: as wide as the terminal, unstyled in a pipe."""
    width = None if stream.isatty() or "COLUMNS" in os.environ else PIPE_WIDTH
    styled = {} if color else {"color_system": None}
    return _console_class()(file=stream, highlight=False, emoji=False, width=width, **styled)  # type: ignore[arg-type]


@cache
def _console_class() -> type[Console]:
    from rich.console import Console as RichConsole  # noqa: PLC0415
    from rich.segment import Segment  # noqa: PLC0415

    class PlainConsole(RichConsole):
        """Shows what steers a terminal instead of obeying it, whoever wrote it: headers, names, messages."""

        def render(self, renderable: Any, options: Any = None) -> Iterator[Segment]:
            for segment in super().render(renderable, options):
                text, style, control = segment
                yield segment if control else Segment(visible(text), style)

    return PlainConsole


def rendered(console: Console, show: Callable[[Console], None]) -> str:
    r"""Return what `show` prints on a console, styled as the console's stream can take it."""
    # Not printed directly: rich ends the program when the reader of a pipe goes away.
    with console.capture() as capture:
        show(console)
    return capture.get()


def _print_problem(problem: Problem, console: Console) -> None:
    from rich.text import Text  # noqa: PLC0415

    text = Text(str(problem))
    text.stylize("bold red" if problem.severity == "error" else "bold yellow", 0, len(problem.severity))
    fix = text.plain.rfind("\n  fix: ")
    if problem.fix and fix >= 0:
        text.stylize("cyan", fix + 3, fix + 7)
    console.print(text, soft_wrap=True)


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


def number(value: float, form: str = ".4g") -> str:
    """Return a number for a table cell; a dash where there is none."""
    return format(value, form) if math.isfinite(value) else "–"


def make_table(headings: Sequence[str], rows: Iterable[Sequence[str]], *, left: int = 1) -> "Table":
    """Return a table whose first `left` columns (and the last, if its heading ends in a space) hold words."""
    from rich import box  # noqa: PLC0415  (rich costs half the start-up time)
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold")
    for place, heading in enumerate(headings):
        words = place < left or heading.endswith(" ")
        table.add_column(Text(heading.rstrip()), justify="left" if words else "right", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))  # Text, because file names may look like markup
    return table


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
