"""Time stamps that repeat, jitter, run backwards or stop: mended or refused by a stated rule."""

from collections.abc import Callable, Sequence

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, median
from ropefric.errors import DataError
from ropefric.glossary import counted

GAP_STEPS = 5.0
"""A step longer than this many median steps is a gap [-]."""

MAX_REPEATED_SHARE = 0.01
"""Up to this share of the samples, repeated stamps are single faults; beyond it they are rounding or refused [-]."""

_BY_RATE = 'leave the time channel out and set [import] sampling_rate = "3 kHz"'
_MAX_GROUP = 3.0
_ON_LATTICE = 1e-3


@np.errstate(all="ignore")  # stamps such as 1e308 and -1e308 are judged, not warned of
def mend_clock(
    time_s: FloatArray,
    others: Sequence[FloatArray] = (),
    *,
    name: str = "trace",
    source: str = "",
    first_line: int = 0,
) -> tuple[slice | BoolArray, FloatArray, tuple[str, ...]]:
    """Return which samples to keep, their strictly increasing time, and what was mended.

    The rule, in this order:

    1. A row without any value is dropped and noted. A row with values but without a stamp is refused.
    2. A stamp earlier than the one before it is refused: whether the clock was reset or the rows are out of
       order, the place of the samples is unknown.
    3. If every row that repeats a stamp repeats all values of the row before too, rows were written twice:
       the copies are dropped and noted.
    4. Repeated stamps with other values, up to 1 % of the samples: the first is kept, the others dropped and
       noted.
    5. More than that, but as a rounded clock would print them (all steps are multiples of the smallest one,
       no stamp is shared by more than three times the average number of samples): the samples of each stamp
       are spread evenly over the time to the next stamp, at most a median step, and noted. No sample moves
       by more than one step of the printed clock.
    6. Anything else that repeats is refused.

    Jitter is left as it is, and so is the time of the first sample. Steps above five median steps are noted
    as gaps.
    """
    steps_s = np.diff(time_s)
    # Where all steps are positive, only the ends can be anything but finite.
    if (steps_s > 0).all() and np.isfinite(time_s[:1]).all() and np.isfinite(time_s[-1:]).all():
        return slice(None), time_s, _gap_notes(time_s, steps_s)

    def refuse(sample: int, message: str, *, code: str = "RF202", fix: str = "") -> DataError:
        line = first_line + sample if first_line else None
        message = f"{name}: sample {sample + 1} {message}"
        return DataError(message, code=code, path=source, line=line, key="time", fix=fix)

    has_stamp, notes = _stamped_rows(time_s, others, refuse)
    index = np.flatnonzero(has_stamp)  # of the samples kept, in the recording
    steps_s = np.diff(time_s[index])
    if (steps_s < 0).any():
        n_back, at = int(np.count_nonzero(steps_s < 0)), int(np.argmax(steps_s < 0))
        before_s, after_s = time_s[index[at : at + 2]]
        why = f"this happens {n_back} times; sort the rows by time"
        if n_back == 1:
            why = "the clock was reset or wrapped once; cut the file there into two recordings"
        message = f"has time {after_s:.9g} s after {before_s:.9g} s: time runs backwards"
        raise refuse(int(index[at + 1]), message, fix=f"{why}, or {_BY_RATE}")
    if (steps_s == 0).any():
        twice = np.concatenate(([False], steps_s == 0))
        for channel in others:
            before, after = channel[index][:-1], channel[index][1:]
            twice[1:] &= (before == after) | (np.isnan(before) & np.isnan(after))
        # In an idle stretch even rounded stamps meet equal values; copies are copies only if all of them are.
        if others and twice.sum() == np.count_nonzero(steps_s == 0):
            notes.append(f"{counted(int(twice.sum()), 'sample')} written twice; the copies were dropped")
            index = index[~twice]
    mended_s = time_s[index]
    repeated = np.concatenate(([False], np.diff(mended_s) == 0))
    n_repeated = int(repeated.sum())
    if n_repeated > MAX_REPEATED_SHARE * index.size:
        mended_s = _spread(mended_s, repeated, lambda at, *text, **fix: refuse(int(index[at]), *text, **fix))
        notes.append(
            f"{counted(n_repeated, 'sample')} with a rounded time stamp; spread evenly between the stamps"
        )
    elif n_repeated:
        notes.append(
            f"{counted(n_repeated, 'sample')} with a repeated time stamp; only the first of each was kept"
        )
        index, mended_s = index[~repeated], mended_s[~repeated]
    keep = np.zeros(time_s.size, dtype=np.bool_)
    keep[index] = True
    return keep, mended_s, (*notes, *_gap_notes(mended_s, np.diff(mended_s)))


def _stamped_rows(
    time_s: FloatArray, others: Sequence[FloatArray], refuse: Callable[..., DataError]
) -> tuple[BoolArray, list[str]]:
    has_stamp = np.isfinite(time_s)
    has_value = np.isinf(time_s) if others else np.ones(time_s.size, dtype=np.bool_)
    for channel in others:
        has_value |= ~np.isnan(channel)
    lost, n_empty = ~has_stamp & has_value, int(np.count_nonzero(~has_stamp))
    if lost.any():
        fix = f"remove the row, or {_BY_RATE}"
        raise refuse(int(np.argmax(lost)), "has values but no time stamp", fix=fix)
    if n_empty == time_s.size:
        raise refuse(0, "and all others are empty: there is no value in the recording", code="RF201")
    return has_stamp, [f"{n_empty} empty rows dropped"] if n_empty else []


def _spread(time_s: FloatArray, repeated: BoolArray, refuse: Callable[..., DataError]) -> FloatArray:
    """Return rounded stamps with the samples of each spread over the time to the next."""
    starts = np.flatnonzero(~repeated)
    sizes = np.diff(starts, append=time_s.size)
    stamps_s = time_s[starts]
    steps_s = np.diff(stamps_s)
    longest = int(np.argmax(sizes))
    if steps_s.size:
        ticks = steps_s / steps_s.min()
        on_lattice = bool((np.abs(ticks - np.round(ticks)) <= _ON_LATTICE * np.round(ticks)).all())
    if not steps_s.size or not on_lattice or sizes[longest] > _MAX_GROUP * sizes.mean() + 1:
        raise refuse(
            int(starts[longest]),
            f"shares its time stamp {stamps_s[longest]:.9g} s with {counted(int(sizes[longest]) - 1, 'sample')}; "
            f"{int(repeated.sum())} of {time_s.size} stamps repeat, and not as rounding would repeat them",
            fix=_BY_RATE,
        )
    median_s = float(np.median(steps_s))
    lengths_s = np.minimum(np.append(steps_s, median_s), median_s)
    rank = np.arange(time_s.size) - np.repeat(starts, sizes)
    mended_s = np.asarray(time_s + rank * np.repeat(lengths_s / sizes, sizes), dtype=np.float64)
    stuck = ~((np.diff(mended_s) > 0) & np.isfinite(mended_s[1:]))
    if stuck.any():
        raise refuse(
            int(np.argmax(stuck)) + 1, "cannot be distinguished from the one before it by its time stamp"
        )
    return mended_s


def mean_step_s(steps_s: FloatArray) -> float:
    """Return the mean step of a clock without its gaps [s]; rounded stamps do not change it."""
    return float(steps_s[steps_s <= GAP_STEPS * median(steps_s)].mean())


def _gap_notes(time_s: FloatArray, steps_s: FloatArray) -> tuple[str, ...]:
    # The median is at least the minimum, so this cheap test can only say "perhaps".
    if steps_s.size < 2 or steps_s.max() <= GAP_STEPS * steps_s.min():
        return ()
    gaps = np.flatnonzero(steps_s > GAP_STEPS * np.median(steps_s))
    if not gaps.size:
        return ()
    longest = int(gaps[np.argmax(steps_s[gaps])])
    gap_s, after_s = steps_s[longest], time_s[longest]
    return (f"{counted(gaps.size, 'gap')} in time; the longest is {gap_s:.4g} s after {after_s:.6g} s",)
