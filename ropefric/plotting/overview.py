"""A whole campaign at a glance: every trial against every check."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, drawing, legend_of_figure, say_instead
from ropefric.traces.breakaway import Status
from ropefric.trials.result import count_trials, outcome_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.trials.result import Extraction, TrialResult


OK, NOT_JUDGED, FLAG, FAIL = "ok", "not judged", "flag", "fail"
"""What a check says of a trial."""
# Four steps of lightness, and a hatch for the flag: the levels hold on grey paper.
_LOOKS: dict[str, Any] = {
    OK: {"facecolor": "#B9D7EA"},
    NOT_JUDGED: {"facecolor": "#F3F3F3"},
    FLAG: {"facecolor": "#E69F00", "hatch": "////", "edgecolor": "#5A3E00"},
    FAIL: {"facecolor": "#4A0A12"},
}
_ONE_BAND, _BAND, _MANY = 40, 100, 600


def _status(*failing: Status) -> "Callable[[TrialResult], str]":
    return lambda trial: FAIL if trial.breakaway.status in failing else OK


def _saturation(trial: "TrialResult") -> str:
    if trial.breakaway.status is Status.SATURATED:
        return FAIL
    return FLAG if trial.saturated_samples > 0 else OK


def _warned(trial: "TrialResult") -> str:
    return FLAG if trial.breakaway.status is Status.OK and trial.problems else OK


CHECKS: "dict[str, tuple[str, Callable[[TrialResult], str]]]" = {
    "file could be read": ("unreadable", _status(Status.UNREADABLE)),
    "long enough": ("too short", _status(Status.TOO_SHORT)),
    "below the converter's ceiling": ("at the converter's ceiling", _saturation),
    "rope slipped": ("without a slip", _status(Status.NO_BREAKAWAY)),
    "static peak found": ("without a static peak", _status(Status.NO_PEAK)),
    "one force stands out": ("doubtful", _status(Status.DOUBTFUL)),
    "no warning": ("with a warning", _warned),
    "not excluded by the user": ("excluded by the user", lambda trial: FLAG if trial.excluded else OK),
    "not rejected by the rule": ("rejected by the rule", lambda trial: FLAG if trial.rejected_by else OK),
}
"""What is looked at, in the order in which a recording goes through it; its opposite, and what it says of a trial."""


def check_trial(trial: "TrialResult") -> tuple[str, ...]:
    """Return what each of `CHECKS` says of a trial; after a failure nothing more is judged."""
    said: list[str] = []
    for _, check in CHECKS.values():
        said.append(NOT_JUDGED if FAIL in said else check(trial))
    return tuple(said)


def draw_overview(extraction: "Extraction") -> FigureWithData:
    """Return the matrix of all trials of a campaign against the checks: ok, flag or fail.

    Up to 40 trials stand in one band, each with its name; more are broken into bands of about 100, in the order of
    the trial list, with every tenth name.
    """
    rows = tuple((trial.trial, *check_trial(trial)) for trial in extraction.trials)
    n = len(rows)
    widest = n if n <= _ONE_BAND else _BAND if n <= _MANY else 2 * _BAND
    width = math.ceil(n / math.ceil(n / widest)) if n else 1
    bands = [rows[start : start + width] for start in range(0, n, width)] or [()]
    longest = max((len(name) for name, *_ in rows), default=0)
    counts = f"{counted(n, 'trial')}: {outcome_words(count_trials(extraction))}"
    band_inch = 0.19 * len(CHECKS) + 0.25 + 0.065 * min(longest, 20)
    with drawing(10.0, 1.1 + band_inch * len(bands)) as figure:
        panels = figure.subplots(len(bands), 1, squeeze=False)[:, 0]
        if not rows:
            say_instead(panels[0], "there is no trial")
        for axes, band in zip(panels, bands if rows else (), strict=False):
            _draw_band(axes, band, width)
        figure.suptitle(f"{extraction.name}, {counts}")
        legend_of_figure(figure)
    alt = (
        f"Campaign {extraction.name}, {counts}."
        if rows
        else f"Campaign {extraction.name}: there is no trial."
    )
    told = Counter(
        check for _, *said in rows for check, one in zip(CHECKS, said, strict=True) if one in {FLAG, FAIL}
    )
    if told:
        alt += (
            f" By check: {', '.join(f'{told[check]} {CHECKS[check][0]}' for check in CHECKS if told[check])}."
        )
    return FigureWithData(figure=figure, tables=(DataTable(header=("trial", *CHECKS), rows=rows),), alt=alt)


def _draw_band(axes: "Axes", band: Sequence[tuple[str, ...]], width: int) -> None:
    names, *columns = zip(*band, strict=True)
    crowded = width > _ONE_BAND
    for row, column in enumerate(columns):
        for said, look in _LOOKS.items():
            spans, place = [], 0
            for found, run in groupby(column):
                length = len(list(run))
                spans += [(float(place), float(length))] if found == said else []
                place += length
            if spans:
                axes.broken_barh(spans, (row - 0.42, 0.84), linewidth=0, label=said, **look)
    edges = range(1, len(names))
    axes.vlines(edges, -0.5, len(CHECKS) - 0.5, color="white", linewidth=0.5 if crowded else 1.5)
    axes.set(xlim=(0, width), ylim=(len(CHECKS) - 0.5, -0.5))
    places = range(0, len(names), 10 if crowded else 1)
    words = [names[place][:20] for place in places]
    axes.set_xticks([place + 0.5 for place in places], words, rotation=90, fontsize=7)
    axes.set_yticks(range(len(CHECKS)), list(CHECKS), fontsize=8)
    axes.tick_params(length=0)
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)
