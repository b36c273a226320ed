"""Progress: lines for logs, a bar at terminals, silence on request."""

import io
import sys

import pytest

from ropefric.cli.output import Output, Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def work(out, items):
    with Progress(out, "extract") as progress:
        for done, item in enumerate(items, start=1):
            progress.update(done, len(items), item)


def test_a_log_gets_one_line_every_ten_percent_and_few_items_one_each(capsys):
    work(Output(), [f"run_{i}" for i in range(200)])
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines() == [f"extract {20 * k}/200  {10 * k} %" for k in range(1, 11)]
    work(Output(), ["a", "b", "c"])
    told = [f"extract {k}/3  {share} %" for k, share in enumerate((33, 66, 100), start=1)]
    assert capsys.readouterr().err.splitlines() == told
    work(Output(), ["run_1 ok", "run_2 no-peak", "run_3 unreadable", "run_4 saturated"])
    assert capsys.readouterr().err.splitlines()[-1] == "extract 4/4  100 % · 3 without a force"


def test_quiet_and_nothing_to_do_are_silent(capsys):
    work(Output(quiet=True), ["a", "b"])
    with Progress(Output(), "extract") as progress:
        progress.update(0, 0, "")
    assert capsys.readouterr() == ("", "")


def test_a_terminal_gets_a_bar_that_fits_on_its_line(monkeypatch):
    for columns in ("40", "80", "160"):
        stream = Terminal()
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setenv("COLUMNS", columns)
        monkeypatch.setenv("TERM", "xterm")
        work(Output(color=False), [f"run_{i} ok" for i in range(147)])
        text = stream.getvalue()
        assert all(one in text for one in ("extract 147/147", "100 %"))
        assert "None" not in text


def test_the_bar_gives_the_cursor_back_after_a_failure(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")

    def interrupted():
        with Progress(Output(), "extract") as progress:
            progress.update(1, 3, "a")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert stream.getvalue().rfind("\x1b[?25h") > stream.getvalue().rfind("\x1b[?25l")
