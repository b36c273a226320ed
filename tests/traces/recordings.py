"""Recordings of known truth, stored: drawn by hand, of the bench and of other rigs; and how a picker fares on them.

`python tests/traces/recordings.py draw` draws them anew, `python tests/traces/recordings.py score` writes what the
picker of today makes of them into `recordings.csv`, which the tests hold it to.
"""

import csv
import sys
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from drawn import hung, knock, line, loaded, ring, settles, since

from ropefric.rig.bench import Bench
from ropefric.rig.recording import FAULTS, simulate_recording
from ropefric.rig.strangers import FAMILIES, recordings
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.noise import noise_std, resolution
from ropefric.traces.trace import ForceTrace

STORED, SCORES = (Path(__file__).with_name(f"recordings.{suffix}") for suffix in ("npz", "csv"))
MISSING, LEFT_OUT = -32768, -32767  # counts of a sample that is empty, and of one that was not recorded
LARGEST, MOST_SAMPLES = 30_000, 14_000
T = np.arange(0.0, 8.0, 0.002)
OK, NONE, NO_PEAK, CUT, OPEN = (
    Status.OK, Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED, Status.DOUBTFUL,
)  # fmt: skip
"""What is true of a recording; `doubtful`, where nobody could say."""


class Stored(NamedTuple):
    """A recording of one kind at an even rate, and what is true of it."""

    kind: str
    rate_Hz: float
    force_N: np.ndarray  # NaN where a sample is missing
    is_there: np.ndarray
    status: Status
    peak_N: float = np.nan

    def trace(self):
        time_s = np.flatnonzero(self.is_there) / self.rate_Hz
        return ForceTrace(time_s=time_s, force_N=self.force_N[self.is_there], name=self.kind)


# --- drawn by hand: a pull to 100 N within 8 s, drawn by a generator of its own --------------------------------------


class Pull:
    """A pull to 100 N that begins, breaks away and slides somewhere, and a range of numbers to draw from."""

    def __init__(self, rng):
        self.rng, self.u = rng, rng.uniform
        self.begin_s, self.slid_N = self.u(1.6, 2.4), self.u(60.0, 85.0)
        self.top_s = self.begin_s + self.u(1.5, 2.5)
        self.rate_N_s = 100.0 / (self.top_s - self.begin_s)
        self.climb = self.to((self.top_s, 100.0))

    def to(self, *corners):
        """Return the force along a line from the begin of the pull on."""
        return line((0.0, 0.0), (self.begin_s, 0.0), *corners, time_s=T)

    def line(self, *, fall_s=0.004, from_N=0.0):
        """Return the force of the pull alone, above what hangs there already."""
        slides_N = self.slid_N - from_N
        return self.to((self.top_s, 100.0 - from_N), (self.top_s + fall_s, slides_N), (8.0, slides_N))

    def weights(self):
        """Return the force of two to four weights hung one by one, and what the last of them brings it to."""
        levels_N = np.cumsum(self.u(5.0, 15.0, self.rng.integers(2, 5)))
        swing = {"swing_Hz": self.u(6.0, 20.0), "damping": self.u(0.05, 0.2)}
        return hung(levels_N, begin_s=0.2, every_s=0.35, time_s=T, **swing), levels_N[-1]


KINDS = {}


def kind(name, status=OK, peak_N=100.0, *, every=1):
    """Register what draws one kind: force, or force and which samples are there, or force and another peak."""
    return lambda draws: KINDS.setdefault(name, (draws, status, peak_N, every)) and draws


def _drawn(name, seed):
    draws, status, peak_N, every = KINDS[name]
    rng = np.random.default_rng([seed, *name.encode()])
    made = draws(Pull(rng))
    force_N, more = made if isinstance(made, tuple) else (made, None)
    is_there = more if isinstance(more, np.ndarray) else np.ones(T.size, dtype=bool)
    peak_N = more if isinstance(more, float) else peak_N
    if "limit" not in name and "stuck" not in name:
        force_N = force_N + rng.normal(0.0, np.exp(rng.uniform(*np.log((0.03, 0.3)))), T.size)
    scale, rate_Hz = np.exp(rng.uniform(-3.0, 3.0)), 500.0 / every * np.exp(rng.uniform(-1.0, 1.0))
    true_N = scale * peak_N if status == OK else np.nan
    return Stored(name, rate_Hz, scale * force_N[::every], is_there[::every], status, true_N)


kind("plain pull")(lambda p: p.line())


@kind("bump at rest")
def _(p):
    return p.line() + knock(p.u(0.2, 1.0), p.u(35.0, 90.0), np.exp(p.u(*np.log((0.01, 0.4)))), T)


@kind("weights hung one by one")
def _(p):
    weights, hung_N = p.weights()
    return weights + p.line(from_N=hung_N)


@kind("weights, then a climb without end", NONE)
def _(p):
    return p.weights()[0] + p.to((8.0, 120.0))


@kind("last weight slips")
def _(p):
    count = int(p.rng.integers(6, 11))
    force = hung(10.0 * np.arange(1, count + 1), swing_Hz=6.0, damping=0.25, begin_s=1.0, time_s=T)
    top = int(np.argmax(force * (1.0 + 0.5 * count > T)))
    force[top:] = force[top] - settles(T[top], p.u(0.5, 0.65) * force[top], 0.05, T)[top:]
    return force, float(force[top])


@kind("impacts on the climb")
def _(p):
    force = p.line()
    for at_s in p.u(p.begin_s + 0.3, p.top_s - 0.5, p.rng.integers(1, 4)):
        height_N, lasts_s = p.u(50.0, 120.0), p.u(0.012, 0.04)
        force += knock(at_s, height_N, lasts_s, T) - ring(at_s + lasts_s, p.u(0.0, 0.2) * height_N, time_s=T)
    return force


@kind("blow higher than the pull")
def _(p):
    return p.line() + ring(p.u(0.3, 0.9), p.u(150.0, 300.0), lasts_s=0.1, hz=p.u(20.0, 40.0), time_s=T)


@kind("blow and no pull", NONE)
def _(p):
    return knock(1.0, 500.0, 0.02, T) + ring(1.02, 60.0, lasts_s=0.05, hz=30.0, time_s=T)


@kind("snag that lets go")
def _(p):
    top_N, at_s = p.u(40.0, 85.0), p.u(0.5, 1.0)
    snag = ((0.0, 0.0), (0.2, 0.0), (at_s, top_N), (at_s + 0.004, 0.0), (p.begin_s, 0.0))
    return p.line() + line(*snag, time_s=T)


@kind("snag little by little")
def _(p):
    force = p.line()
    for n, lobe_N in enumerate(p.u(20.0, 60.0, 3)):
        force = np.maximum(force, knock(0.5 + 0.2 * n, lobe_N, 0.3, T))
    return force


@kind("jog before the pull")
def _(p):
    top_N = p.u(40.0, 60.0)
    held_N = top_N - 2.0
    return p.line() + line((0.2, 0.0), (0.8, top_N), (0.82, held_N), (1.1, held_N), (1.4, 0.0), time_s=T)


@kind("one partial slip")
def _(p):
    drop_N = p.u(3.0, 8.0)
    slip = np.clip(since(p.top_s - p.u(0.1, 0.3), T) / 0.006, 0.0, 1.0)
    return p.line() - drop_N * slip * (p.top_s >= T), 100.0 - drop_N


@kind("partial slips that ring")
def _(p):
    part = p.u(0.03, 0.12)
    tops = np.sort(p.u(40.0, 88.0, p.rng.integers(1, 4)))
    teeth = (*((top, (1.0 - part) * top) for top in tops), (100.0, 45.0))
    corners = loaded(*teeth, rate_N_s=50.0, begins=((0.0, 0.0), (1.0, 0.0)))
    force = line(*corners, (8.0, 45.0), time_s=T)
    for top, (slipped_s, _) in zip(tops, corners[3::2], strict=False):
        force -= ring(slipped_s, p.u(0.0, 0.8) * part * top, lasts_s=0.02, time_s=T)
    return force


@kind("partial slips that spring back")
def _(p):
    force = p.climb
    for at in p.u(0.35, 0.9, 2):
        at_s = p.begin_s + at * (p.top_s - p.begin_s)
        force -= (at_s <= T) * (3.0 + p.u(20.0, 50.0) * np.exp(-since(at_s, T) / 0.006))
    return np.where(p.top_s <= T, 45.0, force), float(force[p.top_s > T].max())


@kind("small slips below an even train")
def _(p):
    tops = np.sort(p.u(50.0, 65.0, 3))
    teeth = (*((top, 0.97 * top) for top in tops), *[(100.0, p.u(70.0, 80.0))] * 5)
    corners = loaded(*teeth, rate_N_s=60.0, begins=((0.0, 0.0), (1.0, 0.0)))
    return line(*corners, (8.0, 78.0), time_s=T)


def _train(p, tops_N, drop_N):
    teeth = ((top_N, top_N - drop_N) for top_N in tops_N)
    corners = loaded(*teeth, rate_N_s=p.rate_N_s, begins=((0.0, 0.0), (p.begin_s, 0.0)))
    return line(*corners, (max(8.0, corners[-1][0] + 1.0), corners[-1][1]), time_s=T)


kind("even train")(lambda p: _train(p, [100.0, *p.u(93.0, 101.0, 12)], p.u(15.0, 40.0)))
kind("train that grows")(lambda p: _train(p, 100.0 + p.u(2.0, 6.0) * np.arange(8), p.u(15.0, 25.0)))


@kind("small teeth")
def _(p):
    tops, at_s, corners = 100.0 + p.u(0.0, 0.6) * np.arange(12), p.top_s, []
    for top in tops:
        corners += [(at_s, top), (at_s + 0.02, top - 3.0)]
        at_s += p.u(0.25, 0.35)
    return p.to(*corners, (8.0, tops[-1] - 3.0))


@kind("wears in")
def _(p):
    return p.to((p.top_s, 100.0), (p.top_s + 0.05, 86.0), (8.0, p.u(102.0, 125.0)))


@kind("hardens by a half")
def _(p):
    slid_s = p.top_s + 0.02
    return settles(slid_s, p.u(45.0, 70.0), 3.0, T) + p.to((p.top_s, 100.0), (slid_s, 88.0), (8.0, 88.0))


@kind("obstacle while it slides")
def _(p):
    later_s = p.top_s + 0.8
    obstacle = np.interp(T, (later_s, later_s + 0.8, later_s + 0.804), (0.0, 45.0, 0.0))
    return p.line() + obstacle


@kind("pulled twice")
def _(p):
    let_down = ((2.604, p.slid_N), (4.0, p.slid_N), (4.2, 0.0), (5.0, 0.0))
    second = ((6.5, p.u(100.0, 115.0)), (6.504, p.slid_N + 5.0), (8.0, p.slid_N))
    return line((0.0, 0.0), (0.6, 0.0), (2.6, 100.0), *let_down, *second, time_s=T)


@kind("slips to nothing and is loaded again")
def _(p):
    teeth = [(100.0, 0.0), *((top, 0.0) for top in p.u(70.0, 80.0, 3))]
    corners = loaded(*teeth, rate_N_s=60.0, begins=((0.0, 0.0), (1.0, 0.0)))
    return line(*corners, (10.0, 0.0), time_s=T)


@kind("rounded waves after the peak")
def _(p):
    gone_s = since(p.top_s, T)
    return p.climb - p.u(2.0, 3.0) * (1.0 - np.cos(2.0 * np.pi * gone_s / 0.3))


@kind("ripples on the way down")
def _(p):
    ripples = p.u(0.5, 1.2) * np.sin(2.0 * np.pi * 14.0 * since(p.top_s, T))
    return p.climb - settles(p.top_s, 25.0, p.u(0.15, 0.3), T) + ripples


@kind("slip that rings on")
def _(p):
    swings = 60.0 * p.u(0.2, 0.45) * np.cos(2.0 * np.pi * since(p.top_s, T) / p.u(0.08, 0.2))
    return np.where(p.top_s > T, p.climb, 45.0 + swings * np.exp(-since(p.top_s, T)))


kind("slow fall")(lambda p: p.line(fall_s=np.exp(p.u(*np.log((0.01, 0.15))))))


@kind("gives way until let down")
def _(p):
    falls = settles(p.top_s, p.u(25.0, 40.0), p.u(0.8, 1.5), T)
    return (p.climb - falls) * np.clip((7.3 - T) / 0.2, 0.0, 1.0)


@kind("faster at the end")
def _(p):
    slack = ((0.0, 0.0), (1.0, 0.0), (4.0, 50.0), (4.4, 100.0), (4.404, p.slid_N))
    tooth = ((0.0, p.slid_N + 10.0), (0.004, p.slid_N))
    return line(
        *slack, *((4.404 + 0.1 * n + dt, force) for n in range(1, 36) for dt, force in tooth), time_s=T
    )


@kind("sliding that scatters")
def _(p):
    return p.line() + (p.top_s + 0.01 < T) * p.rng.normal(0.0, p.u(3.0, 7.0), T.size)


kind("held, creeps", NONE)(lambda p: p.climb - settles(p.top_s, p.u(0.0, 5.0), p.u(1.0, 3.0), T))


@kind("let down slowly", NONE)
def _(p):
    level_N = p.u(0.0, 30.0)
    stays_s = p.top_s + p.u(0.3, 1.0)
    return p.climb - (100.0 - level_N) * np.clip(since(stays_s, T) / p.u(0.5, 2.0), 0.0, 1.0)


@kind("motor stops, masses swing", NONE)
def _(p):
    hz = p.u(8.0, 20.0)
    height_N = p.rate_N_s / (2.0 * np.pi * hz)
    return p.climb + ring(p.top_s, height_N, lasts_s=p.u(0.05, 0.2), hz=hz, time_s=T)


kind("climbs to the end", NONE)(lambda p: line((0.0, 0.0), (p.begin_s, 0.0), (8.0, 100.0), time_s=T))


@kind("bends into sliding", NO_PEAK)
def _(p):
    waves = np.sin(20.0 * T + p.u(0.0, 6.0)) + np.sin(33.0 * T + p.u(0.0, 6.0))
    comes = -np.expm1(-since(p.begin_s, T) / 0.7)
    return 100.0 * comes + p.u(0.5, 1.5) * waves * np.clip(since(p.begin_s + 2.0, T), 0.0, 1.0)


@kind("comes off and swings", NONE)
def _(p):
    gone_s = since(p.top_s, T)
    swings = 100.0 * np.exp(-gone_s / 0.4) * np.cos(2.0 * np.pi * p.u(3.0, 6.0) * gone_s)
    return np.where(p.top_s > T, p.climb, swings)


@kind("spikes")
def _(p):
    force = p.line()
    for at in p.rng.integers(50, T.size - 50, 5):
        force[at : at + p.rng.integers(1, 6)] += p.rng.choice((-1.0, 1.0)) * p.u(40.0, 150.0)
    return force


kind("drift that the rest shows")(lambda p: p.line() + p.rng.choice((-1.0, 1.0)) * p.u(0.3, 0.6) * T)
kind("jump of the zero at rest", OPEN)(lambda p: p.line() + p.u(4.0, 9.0) * (p.u(0.5, 1.0) < T))
kind("zero below nothing")(lambda p: p.line() - p.u(3.0, 15.0))


@kind("cut off at a limit", CUT)
def _(p):
    return np.minimum(p.line() + p.rng.normal(0.0, 0.2, T.size), p.u(85.0, 96.0))


@kind("stuck over the peak", NO_PEAK)
def _(p):
    force = np.round(p.line() + p.rng.normal(0.0, 0.5, T.size))
    start = int(np.searchsorted(T, p.top_s)) - int(p.u(20, 180))
    force[start : start + 200] = force[start]
    return force


@kind("gap over the peak", OPEN)
def _(p):
    return p.line(), (p.top_s - p.u(0.1, 0.4) > T) | (p.top_s + p.u(0.1, 0.4) < T)


@kind("gap in the climb")
def _(p):
    at_s = p.u(p.begin_s + 0.2, p.top_s - 0.6)
    return p.line(), (at_s > T) | (at_s + p.u(0.05, 0.3) < T)


kind("hum")(lambda p: p.line() + p.u(0.5, 3.0) * np.sin(2.0 * np.pi * 50.02 * T + p.u(0.0, 6.0)))


@kind("burst of noise at rest")
def _(p):
    force, at = p.line(), int(p.u(100, 500))
    force[at : at + 40] += p.rng.normal(-2.5, 8.0, 40)
    return force


@kind("begins within the climb")
def _(p):
    return p.line(), p.begin_s + p.u(0.3, 0.6) * (p.top_s - p.begin_s) < T


@kind("ends within the climb", NONE)
def _(p):
    return p.line(), p.begin_s + p.u(0.5, 0.95) * (p.top_s - p.begin_s) > T


kind("few samples", every=25)(lambda p: p.line(fall_s=0.05))


# --- of the rigs -------------------------------------------------------------------------------------------------------


def _of_bench(fault, seed):
    """Return a recording of the bench as the picker gets it, at a third of its rate."""
    bench, rng = Bench(sampling_rate_Hz=1000.0), np.random.default_rng([seed, *fault.encode()])
    lift_N = float(np.exp(rng.uniform(*np.log((90.0, 900.0)))))
    given = {"lift_force_N": lift_N, "end_tension_N": lift_N * rng.uniform(0.15, 0.4)}
    made = simulate_recording(bench, **given, rng=rng, faults=(fault,) if fault else ())
    counts = np.where(np.isnan(made.counts), -1, made.counts).astype(np.int64)
    whole = Calibration(cell=bench.cell_named(made.truth.cell), adc=bench.adc)
    force_N, _ = whole.with_tare(counts[:250])[0].apply(counts)
    status, is_there = made.truth.status, np.ones(counts.size, dtype=bool)
    peak_N = made.truth.lift_force_N if status == OK else np.nan
    return Stored(f"bench: {fault or 'as it is'}", 1000.0, force_N, is_there, status, peak_N)


def _of_stranger(one):
    """Return a recording of the second rig whose rows are put on an even clock."""
    rate_Hz = 1.0 / np.median(np.diff(one.time_s))
    rows = np.rint((one.time_s - one.time_s[0]) * rate_Hz).astype(int)
    force_N, is_there = np.zeros(rows[-1] + 1), np.zeros(rows[-1] + 1, bool)
    force_N[rows], is_there[rows] = one.force_N, True
    return Stored(f"rig: {one.family}", rate_Hz, force_N, is_there, one.truth.status, one.truth.peak_N)


LEFT_TO_OTHERS = ("jitter", "duplicated-rows", "clock-jitter", "unreadable", "too-short")
"""What is mended or refused before anything is picked: see the tests of clock and readers."""


def draw(each=3):
    """Return all recordings, the same each time."""
    made = [_drawn(name, seed) for name in KINDS for seed in range(each)]
    faults = ["", *(name for name in FAULTS if name not in LEFT_TO_OTHERS)]
    made += [_of_bench(fault, seed) for fault in faults for seed in range(each)]
    for family in (name for name in FAMILIES if name not in LEFT_TO_OTHERS):
        strangers = map(_of_stranger, recordings(7, per_family=2 * each, families=(family,)))
        made += [one for one in strangers if one.force_N.size <= MOST_SAMPLES][:each]
    return made


# --- stored ------------------------------------------------------------------------------------------------------------


def _as_counts(one):
    """Return the force in counts, and what one of them is worth: a step of the converter, or a third of the noise."""
    forces_N = one.force_N[one.is_there & np.isfinite(one.force_N)]
    step_N = max(resolution(forces_N), float(np.abs(forces_N).max()) / LARGEST)
    step_N *= max(1.0, np.rint(noise_std(forces_N) / 2.5 / step_N))
    counts = np.rint(np.nan_to_num(one.force_N) / step_N).astype(np.int16)
    counts[np.isnan(one.force_N)] = MISSING
    counts[~one.is_there] = LEFT_OUT
    return counts, step_N


def save(made):
    """Write recordings: counts as differences from sample to sample, small ones in few bytes."""
    counts, steps_N = zip(*map(_as_counts, made), strict=True)
    changes = np.diff(np.concatenate(counts), prepend=np.int16(0))
    folded = ((changes << 1) ^ (changes >> 15)).astype(np.uint16)
    np.savez_compressed(
        STORED, low=(folded & 255).astype(np.uint8), high=(folded >> 8).astype(np.uint8), step_N=steps_N,
        ends=np.cumsum([one.size for one in counts]), **{
            key: [getattr(one, key) for one in made] for key in ("kind", "rate_Hz", "status", "peak_N")
        },
    )  # fmt: skip


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


# --- scored ------------------------------------------------------------------------------------------------------------


def judged(one, found):
    """Return `right`, `wrong` or `doubtful`: what a picker found against what is true.

    Wrong is a force where there is none, or one that is off by more than 2 %. Without a force, right is the true reason;
    where nobody could say, any.
    """
    if found.status is OK:
        return "right" if one.status is OK and abs(found.peak_N / one.peak_N - 1.0) <= 0.02 else "wrong"
    return "right" if one.status in {found.status, OPEN} else "doubtful"


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
    if "draw" in sys.argv:
        save(draw())
    lines = [f'"{kind}",{" ".join(found)}' for kind, found in score(load()).items()]
    SCORES.write_text("\n".join(["kind,reached", *lines, ""]), encoding="utf-8")
