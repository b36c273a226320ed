"""Stored recordings of known truth, of which `recordings.npz` is all that is kept: how a picker fares on them.

They were drawn by hand, on the bench (also with a sliding friction that ages) and on the second rig; each kind has its
name. `python tests/traces/recordings.py` writes what the picker of today makes of them into `recordings.csv`, which the
tests hold it to.
"""

import csv
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

STORED, SCORES = (Path(__file__).with_name(f"recordings.{suffix}") for suffix in ("npz", "csv"))
LEFT_OUT = -32767
"""Counts of a sample that was not recorded; one less is one that is empty."""


class Stored(NamedTuple):
    """A recording of one kind at an even rate, and what is true of it."""

    kind: str
    rate_Hz: float
    force_N: np.ndarray  # NaN where a sample is missing
    is_there: np.ndarray
    status: Status  # doubtful, where nobody could say
    peak_N: float = np.nan

    def trace(self):
        time_s = np.flatnonzero(self.is_there) / self.rate_Hz
        return ForceTrace(time_s=time_s, force_N=self.force_N[self.is_there], name=self.kind)


def load():
    """Return the stored recordings."""
    with np.load(STORED) as file:
        stored = {key: file[key] for key in file.files}
    folded = stored["low"].astype(np.uint16) | stored["high"].astype(np.uint16) << 8
    counts = np.cumsum((folded >> 1).astype(np.int16) ^ -(folded & 1).astype(np.int16), dtype=np.int16)
    found = []
    for n, (start, end) in enumerate(pairwise((0, *stored["ends"]))):
        own = counts[start:end]
        force_N = np.where(own <= LEFT_OUT, np.nan, own * stored["step_N"][n])
        told = str(stored["kind"][n]), float(stored["rate_Hz"][n])
        truth = Status(str(stored["status"][n])), float(stored["peak_N"][n])
        found.append(Stored(*told, force_N, own != LEFT_OUT, *truth))
    return found


def judged(one, found):
    """Return `right`, `wrong` or `doubtful`: what a picker found against what is true.

    Wrong is a force where there is none, or one that is off by more than 2 %. Without a force, right is the true reason;
    where nobody could say, any.
    """
    if found.status is Status.OK:
        return (
            "right" if one.status is Status.OK and abs(found.peak_N / one.peak_N - 1.0) <= 0.02 else "wrong"
        )
    return "right" if one.status in {found.status, Status.DOUBTFUL} else "doubtful"


def pick(trace):
    """Return what the picker that is put to the test finds."""
    return pick_breakaway(trace, PickSettings())[0]


def score(stored, pick=pick):
    """Return for every kind what was reached, recording by recording."""
    scores = {}
    for one in stored:
        scores.setdefault(one.kind, []).append(judged(one, pick(one.trace())))
    return scores


def reached():
    """Return what a picker had reached when `score` was last written."""
    with SCORES.open(encoding="utf-8", newline="") as stream:
        return {row["kind"]: row["reached"].split() for row in csv.DictReader(stream)}


if __name__ == "__main__":
    lines = [f'"{kind}",{" ".join(found)}' for kind, found in score(load()).items()]
    SCORES.write_text("\n".join(["kind,reached", *lines, ""]), encoding="utf-8")
