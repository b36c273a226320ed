"""Where words go: results on stdout, everything said to people along the way on stderr."""

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TextIO

from ropefric.errors import Problem
from ropefric.files.plain_text import visible
from ropefric.files.write import cannot_write

if TYPE_CHECKING:
    from rich.console import Console


PIPE_WIDTH = 200
"""Columns for tables that go into a file or pipe, where nothing needs to be folded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """What the user wants to see."""

    json: bool = False
    quiet: bool = False
    color: bool = True

    @property
    def stdout(self) -> "Console":
        """Return a console for the result."""
        return console_on(sys.stdout, color=self.color)

    @property
    def stderr(self) -> "Console":
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
            self._say(lambda console: console.print(text, soft_wrap=True, markup=False))

    def problems(self, problems: Iterable[Problem]) -> None:
        """List problems on stderr; warnings only if not asked to be quiet."""
        for problem in problems:
            if problem.severity == "error" or not self.quiet:
                self._say(partial(_print_problem, problem))

    def _say(self, show: "Callable[[Console], None]") -> None:
        # The work goes on when nobody listens any more (`2>&1 | head`), or the log's disk is full.
        with suppress(OSError):
            sys.stderr.write(rendered(self.stderr, show))
            sys.stderr.flush()


def console_on(stream: TextIO, *, color: bool = True) -> "Console":
    r"""Return a console that writes to `stream`: as wide as the terminal, unstyled in a pipe."""
    width = None if stream.isatty() or "COLUMNS" in os.environ else PIPE_WIDTH
    styled = {} if color else {"color_system": None}
    return _console_class()(file=stream, highlight=False, emoji=False, width=width, **styled)  # type: ignore[arg-type]


@cache
def _console_class() -> "type[Console]":
    from rich.console import Console  # noqa: PLC0415
    from rich.segment import Segment  # noqa: PLC0415

    class PlainConsole(Console):
        """Shows what steers a terminal instead of obeying it, whoever wrote it: headers, names, messages."""

        def render(self, renderable: Any, options: Any = None) -> Iterator[Segment]:
            for segment in super().render(renderable, options):
                text, style, control = segment
                yield segment if control else Segment(visible(text), style)

    return PlainConsole


def rendered(console: "Console", show: "Callable[[Console], None]") -> str:
    r"""Return what `show` prints on a console, styled as the console's stream can take it."""
    # Not printed directly: rich ends the program when the reader of a pipe goes away.
    with console.capture() as capture:
        show(console)
    return capture.get()


def _print_problem(problem: Problem, console: "Console") -> None:
    from rich.text import Text  # noqa: PLC0415

    text = Text(str(problem))
    text.stylize("bold red" if problem.severity == "error" else "bold yellow", 0, len(problem.severity))
    fix = text.plain.rfind("\n  fix: ")
    if problem.fix and fix >= 0:
        text.stylize("cyan", fix + 3, fix + 7)
    console.print(text, soft_wrap=True)
