"""A whole campaign at a glance: every trial against every check."""

import math
from collections.abc import Callable, Sequence
from enum import IntEnum
from itertools import groupby
from typing import TYPE_CHECKING

from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, legend_of_figure, new_figure, say_instead
from ropefric.plotting.style import house_style
from ropefric.traces.breakaway import Status
from ropefric.trials.result import count_trials, outcome_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.trials.result import Extraction, TrialResult


class Level(IntEnum):
    """What a check says of a trial."""

    NOT_JUDGED = 0
    OK = 1
    FLAG = 2
    FAIL = 3


_WORDS = {Level.NOT_JUDGED: "not judged", Level.OK: "ok", Level.FLAG: "flag", Level.FAIL: "fail"}
# Four steps of lightness, and a hatch for the flag: the levels hold on grey paper.
_LOOKS: dict[Level, dict[str, str]] = {
    Level.OK: {"facecolor": "#B9D7EA"},
    Level.NOT_JUDGED: {"facecolor": "#F3F3F3"},
    Level.FLAG: {"facecolor": "#E69F00", "hatch": "////", "edgecolor": "#5A3E00"},
    Level.FAIL: {"facecolor": "#4A0A12"},
}
_OPPOSITE = {
    "file could be read": "unreadable",
    "long enough": "too short",
    "below the converter's ceiling": "at the converter's ceiling",
    "rope slipped": "without a slip",
    "static peak found": "without a static peak",
    "no warning": "with a warning",
    "not excluded by the user": "excluded by the user",
    "not rejected by the rule": "rejected by the rule",
}
_ONE_BAND = 40
_BAND = 100
_MANY = 600


def _status(*failing: Status) -> "Callable[[TrialResult], Level]":
    return lambda trial: Level.FAIL if trial.breakaway.status in failing else Level.OK


def _saturation(trial: "TrialResult") -> Level:
    if trial.breakaway.status is Status.SATURATED:
        return Level.FAIL
    return Level.FLAG if trial.saturated_samples > 0 else Level.OK


def _warned(trial: "TrialResult") -> Level:
    usable = trial.breakaway.status is Status.OK
    return Level.FLAG if usable and trial.problems else Level.OK


CHECKS: dict[str, "Callable[[TrialResult], Level]"] = {
    "file could be read": _status(Status.UNREADABLE),
    "long enough": _status(Status.TOO_SHORT),
    "below the converter's ceiling": _saturation,
    "rope slipped": _status(Status.NO_BREAKAWAY),
    "static peak found": _status(Status.NO_PEAK, Status.DOUBTFUL),
    "no warning": _warned,
    "not excluded by the user": lambda trial: Level.FLAG if trial.excluded else Level.OK,
    "not rejected by the rule": lambda trial: Level.FLAG if trial.rejected_by else Level.OK,
}
"""What is looked at, in the order in which a recording goes through it."""


def check_trial(trial: "TrialResult") -> tuple[Level, ...]:
    """Return what each of `CHECKS` says of a trial; after a failure nothing more is judged."""
    levels: list[Level] = []
    for check in CHECKS.values():
        failed = Level.FAIL in levels
        levels.append(Level.NOT_JUDGED if failed else check(trial))
    return tuple(levels)


def draw_overview(extraction: "Extraction") -> FigureWithData:
    """Return the matrix of all trials of a campaign against the checks: ok, flag or fail.

    Up to 40 trials stand in one band, each with its name; more are broken into bands of about 100, in the order of
    the trial list, with every tenth name.
    """
    trials = extraction.trials
    levels = [check_trial(trial) for trial in trials]
    bands = _bands(len(trials))
    names = [trial.trial for trial in trials]
    longest = max((len(name) for name in names), default=0)
    counts = f"{counted(len(trials), 'trial')}: {outcome_words(count_trials(extraction))}"
    with house_style():
        band_inch = 0.19 * len(CHECKS) + 0.25 + 0.065 * min(longest, 20)
        figure = new_figure(10.0, 1.1 + band_inch * max(len(bands), 1))
        panels = figure.subplots(max(len(bands), 1), 1, squeeze=False)[:, 0]
        if not trials:
            say_instead(panels[0], "there is no trial")
        for axes, (start, stop) in zip(panels, bands, strict=False):
            _draw_band(axes, names[start:stop], levels[start:stop], width=bands[0][1])
        figure.suptitle(f"{extraction.name}, {counts}")
        legend_of_figure(figure)
    rows = tuple((name, *(_WORDS[level] for level in row)) for name, row in zip(names, levels, strict=True))
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("trial", *CHECKS), rows=rows),),
        alt=_alt(extraction.name, levels, counts),
    )


def _bands(n: int) -> list[tuple[int, int]]:
    """Return the ranges of trials that stand in one band, of nearly equal length."""
    if n == 0:
        return []
    widest = n if n <= _ONE_BAND else _BAND if n <= _MANY else 2 * _BAND
    size = math.ceil(n / math.ceil(n / widest))
    return [(start, min(start + size, n)) for start in range(0, n, size)]


def _draw_band(
    axes: "Axes", names: Sequence[str], levels: Sequence[tuple[Level, ...]], *, width: int
) -> None:
    for row in range(len(CHECKS)):
        for level, look in _LOOKS.items():
            spans = _spans([found[row] for found in levels], level)
            if spans:
                axes.broken_barh(spans, (row - 0.42, 0.84), linewidth=0, label=_WORDS[level], **look)  # type: ignore[arg-type]
    edges = range(1, len(names))
    axes.vlines(edges, -0.5, len(CHECKS) - 0.5, color="white", linewidth=1.5 if width <= _ONE_BAND else 0.5)
    axes.set(xlim=(0, width), ylim=(len(CHECKS) - 0.5, -0.5))
    step = 1 if width <= _ONE_BAND else 10
    places = range(0, len(names), step)
    axes.set_xticks(
        [place + 0.5 for place in places], [names[place][:20] for place in places], rotation=90, fontsize=7
    )
    axes.set_yticks(range(len(CHECKS)), list(CHECKS), fontsize=8)
    axes.tick_params(length=0)
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _spans(column: Sequence[Level], level: Level) -> list[tuple[float, float]]:
    """Return start and width of every run of a level."""
    spans, place = [], 0
    for found, run in groupby(column):
        length = len(list(run))
        if found is level:
            spans.append((float(place), float(length)))
        place += length
    return spans


def _alt(name: str, levels: Sequence[tuple[Level, ...]], counts: str) -> str:
    if not levels:
        return f"Campaign {name}: there is no trial."
    text = f"Campaign {name}, {counts}."
    found = []
    for place, check in enumerate(CHECKS):
        n = sum(row[place] in {Level.FLAG, Level.FAIL} for row in levels)
        if n:
            found.append(f"{n} {_OPPOSITE[check]}")
    return f"{text} By check: {', '.join(found)}." if found else text
