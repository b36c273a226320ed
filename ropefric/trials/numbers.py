"""The columns of a trial's row, each declared once: how it is taken, its words, its symbol, and where it is shown.

The row of trials.csv and of the JSON, the means of conditions.csv, and the labels of reports, figures and the review
page follow from `COLUMNS`. Who adds a number adds a line here, and measures it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite, nan
from operator import attrgetter
from typing import Any, NamedTuple

from ropefric.quantities import split_unit_suffix, unit_factor
from ropefric.traces.breakaway import Breakaway


class OnPage(NamedTuple):
    """How and where the review page shows a number: its own words, unit, digits, and the column of its scatter."""

    place: int
    words: str
    unit: str = ""
    digits: int = 4
    std: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialColumn:
    """A column of a trial's row.

    Attributes
    ----------
    name : str
        Header and JSON field, with the unit where it is a number that has one.
    taken : callable
        What the column holds of a `TrialResult`.
    is_set : bool
        Whether people set it: then it stays as it came out of the trial list.
    words : str
        What reports call the mean of a condition's kept trials; none is formed where this is empty.
    rank : int
        Of these means, those of lower rank stand first.
    brief : str
        What the summary of `extract` calls that mean; not said there where this is empty.
    symbol : str
        As in the field.
    drawn : str
        What the rope does at this force: it is drawn in figures of recordings; not drawn where this is empty.
    on_page : OnPage or None
        How the review page shows it.
    read_as : tuple of str
        What trial tables may call it, without the unit, beside what every fit reads.
    """

    name: str
    taken: Callable[[Any], Any]
    is_set: bool = False
    words: str = ""
    rank: int = 0
    brief: str = ""
    symbol: str = ""
    drawn: str = ""
    on_page: OnPage | None = None
    read_as: tuple[str, ...] = ()

    @property
    def stem(self) -> str:
        """Return the name without its unit."""
        return split_unit_suffix(self.name)[0].removeprefix("n_")

    @property
    def unit(self) -> str:
        """Return the unit of its numbers; "" where there is none."""
        return split_unit_suffix(self.name)[1]

    def heading(self, words: str) -> str:
        """Return words with the unit."""
        return f"{words} [{self.unit}]" if self.unit else words

    def shown_on_page(self, trial: Any) -> list[Any]:
        """Return words, number, its scatter, unit and digits as the review page shows them."""
        how = self.on_page or OnPage(0, self.name)
        factor = unit_factor(self.unit, how.unit) if how.unit else 1.0
        std = column(how.std).taken(trial) if how.std else nan
        value = self.taken(trial)
        return [how.words, value if factor == 1.0 else value * factor, std, how.unit, how.digits]


def candidates_in_words(found: Breakaway) -> str:
    """Return the forces that may be the break-away, and how likely each is where that is known."""
    return "; ".join(
        f"{event.force_N:.5g} N at {event.time_s:.5g} s"
        + (f" ({event.probability:.2f})" if isfinite(event.probability) else "")
        for event in found.candidates
    )


def _raw_N(trial: Any) -> float:
    return nan if trial.measures_slack else float(trial.breakaway.peak_raw_N)


def _of_trial(*names: str, **shown: Any) -> Iterator[TrialColumn]:
    return (TrialColumn(name=name, taken=attrgetter(name), **shown) for name in names)


def _picked(name: str, held_as: str = "", **shown: Any) -> TrialColumn:
    """Return the column of what picking found."""
    return TrialColumn(name=name, taken=attrgetter(f"breakaway.{held_as or name}"), **shown)


def _also(name: str, taken: Callable[[Any], Any] | str) -> TrialColumn:
    """Return a column that is held under another name, or computed from held ones."""
    return TrialColumn(name=name, taken=attrgetter(taken) if isinstance(taken, str) else taken)


COLUMNS: tuple[TrialColumn, ...] = (
    *_of_trial("trial", "file", "sample"),
    *_of_trial("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", is_set=True),
    *_of_trial(
        "wheel_radius_std_m", "rope_radius_std_m", "wrap_std_rad", "end_tension_N", "end_tension_std_N"
    ),
    *_of_trial("end_tension_set_N", is_set=True, read_as=("end_tension_set",)),
    *_of_trial("peak_N", "peak_std_N", "cell_std_N"),
    _also("peak_raw_N", _raw_N),
    _picked("probability", on_page=OnPage(0, "probability", digits=2)),
    _picked("peak_time_s"),
    _picked("bias_N"),
    _picked("window_s", on_page=OnPage(4, "smoothed over", "ms", 3)),
    _picked("noise_std_N", on_page=OnPage(3, "noise of a sample", "N", 3)),
    _picked("loading_rate_N_s", words="loading rate", rank=1, on_page=OnPage(5, "loading rate", "N/s")),
    _picked("measured_dwell_s", "dwell_s", words="dwell", rank=1),
    _picked(
        "kinetic_N",
        words="kinetic force",
        brief="mean kinetic",
        symbol="F_k",
        drawn="sliding",
        on_page=OnPage(1, "kinetic force", "N", 5, std="kinetic_std_N"),
        read_as=("kinetic", "kinetic_force"),
    ),
    _picked("kinetic_std_N"),
    *_of_trial("kinetic_mean_std_N", read_as=("kinetic_mean_std",)),
    _picked("sliding_s", "kinetic_s"),
    _picked("drop_N", words="drop", on_page=OnPage(2, "drop", "N")),
    _picked("trough_N", words="trough"),
    _picked("n_slips", words="slips", on_page=OnPage(6, "stick-slip events")),
    _picked("recurrence_s", words="recurrence"),
    *_of_trial("mu", words="μ", rank=2),
    *_of_trial("mu_std"),
    *_of_trial("mu_kinetic", words="kinetic μ", rank=2),
    _also("status", "breakaway.status.value"),
    _also("candidates", lambda trial: candidates_in_words(trial.breakaway)),
    *_of_trial("kept", "rejected_by", "excluded", "decision"),
    _also("decided_by", "by"),
    _also("decided_why", "why"),
    _also("decided_when", "when"),
    _picked("detail"),
    _also("notes", lambda trial: "; ".join(trial.breakaway.notes)),
    *_of_trial("wheel", "cell", "end_cell", "rope_id"),
    *_of_trial("dwell_s", is_set=True),
    _also("from_s", "start_s"),
    _also("until_s", "stop_s"),
    *_of_trial("tare_N", "saturated_samples", "note"),
)
"""Of a trial's row, in their order."""


def column(name: str) -> TrialColumn:
    """Return a column by its name."""
    return next(one for one in COLUMNS if one.name == name)


def summarised() -> list[TrialColumn]:
    """Return what a condition has the mean, scatter and number of, beside the break-away force."""
    return sorted((one for one in COLUMNS if one.words), key=lambda one: one.rank)


def on_page(trial: Any) -> list[list[Any]]:
    """Return what the review page shows of a trial beside the break-away force, each as `shown_on_page`."""
    shown = [(one.on_page.place, one) for one in COLUMNS if one.on_page]
    return [one.shown_on_page(trial) for _, one in sorted(shown, key=lambda item: item[0])]


def levels_drawn(trial: Any) -> list[tuple[TrialColumn, float]]:
    """Return the forces, beside the break-away, that are drawn of a recording, where it has them."""
    found = ((one, float(one.taken(trial))) for one in COLUMNS if one.drawn)
    return [(one, value) for one, value in found if isfinite(value)]
