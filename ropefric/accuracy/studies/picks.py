"""Pickers of the break-away force, side by side, on recordings of two rigs, one of them unknown to all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from math import inf, isfinite, nan

import numpy as np
import scipy.signal

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study, in_case
from ropefric.arrays import FloatArray
from ropefric.rig.further import contacts, pulls
from ropefric.rig.strangers import recordings
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

SEED, PER_FAMILY, UNSEEN = 2027, 2, 80
RIGHT = 0.02
"""A pick further off than this part of F_A is wrong."""

Picked = tuple[float, float, bool]
"""Force, its standard uncertainty where the picker states one [N], and whether it says that it is in doubt."""
Picker = Callable[[ForceTrace], Picked]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A recording with its truth: F_A, or NaN where there is none; and its kind."""

    trace: ForceTrace
    peak_N: float
    kind: str = ""


@cache
def known_recordings(tier: str) -> tuple[Known, ...]:
    """Return recordings of one tier of the second rig, other draws than those that the network was trained on."""
    drawn = recordings(SEED, per_family=PER_FAMILY, tiers=(tier,))
    return tuple(Known(one.trace(), one.truth.peak_N, one.family) for one in drawn)


@cache
def unseen_recordings() -> tuple[Known, ...]:
    """Return recordings of the fourth rig, which no picker was made for or trained on."""
    drawn = pulls(np.random.default_rng(SEED), UNSEEN, contacts)
    return tuple(Known(ForceTrace(time_s=one.time_s, force_N=one.force_N), one.peak_N) for one in drawn)


def _filled(trace: ForceTrace) -> FloatArray:
    """Return the force with straight lines across missing samples: what a script would do."""
    here = np.isfinite(trace.force_N)
    return np.interp(trace.time_s, trace.time_s[here], trace.force_N[here]) if here.any() else np.zeros(1)


def _mean_of(values: FloatArray, n: int) -> FloatArray:
    n = max(1, min(n, values.size))
    return np.convolve(values, np.full(n, 1.0 / n), mode="valid")


def by_ropefric(trace: ForceTrace, *, picker: str = "trained") -> Picked:
    """Return what ropefric picks with no settings at all, or with its transparent picker."""
    found = pick_breakaway(trace, PickSettings(picker=picker))[0]
    return (
        found.peak_N if found.status is Status.OK else nan,
        found.peak_std_N,
        found.status is Status.DOUBTFUL,
    )


def by_highest_mean(trace: ForceTrace, *, points: int = 0, lasting_s: float = 0.0) -> Picked:
    """Return the maximum of a moving average over points or time: the usual way of the field."""
    n = points or round(lasting_s * trace.sampling_rate_Hz)
    return float(_mean_of(_filled(trace), n).max()), nan, False


def by_prominence(trace: ForceTrace, *, part: float) -> Picked:
    """Return the first peak of a 5-point mean that `scipy.signal.find_peaks` finds with a prominence."""
    mean_N = _mean_of(_filled(trace), 5)
    found, _ = scipy.signal.find_peaks(mean_N, prominence=max(part * float(np.ptp(mean_N)), 1e-12))
    return float(mean_N[found[0]]) if found.size else nan, nan, False


def by_sta_lta(trace: ForceTrace, *, short: int, long: int, ratio: float = 8.0) -> Picked:
    """Return the highest 5-point mean around the trigger of the energy of force changes, short over long mean.

    Allen, R. V. (1978), Automatic earthquake recognition and timing from single traces, Bull. Seism. Soc. Am. 68,
    1521-1532; windows and ratio as in Withers et al. (1998), ibid. 88, 95-106.
    """
    force_N = _filled(trace)
    change = np.diff(force_N)
    if change.size < long + 2 * short:
        return nan, nan, False
    energy = (change - np.median(change)) ** 2 + 1e-30
    sta = _mean_of(energy, short)[long:]
    lta = _mean_of(energy, long)[: sta.size]
    above = np.flatnonzero(sta[: lta.size] > ratio * lta)
    if not above.size:
        return nan, nan, False
    at = long + int(above[0])
    return float(_mean_of(force_N[max(0, at - short) : at + 2 * short], 5).max()), nan, False


def by_aic(trace: ForceTrace) -> Picked:
    """Return the highest 5-point mean around where two stretches of unlike variance meet best.

    AIC(k) = k ln var(x[:k]) + (n - k - 1) ln var(x[k:]) of the force changes is least at the onset: Maeda, N. (1985), A
    method for reading and checking phase times in autoprocessing system of seismic wave data, Zisin 38, 365-379. As
    there, the stretch looked at ends with the event: here the steepest fall.
    """
    force_N = _filled(trace)
    x = np.diff(force_N)
    x = x[: int(np.argmin(_mean_of(x, 5))) + 15] if x.size else x
    if x.size < 30:
        return nan, nan, False
    n, k = x.size, np.arange(10, x.size - 10)
    total, squares = np.concatenate([[0.0], np.cumsum(x)]), np.concatenate([[0.0], np.cumsum(x**2)])
    before = squares[k] / k - (total[k] / k) ** 2
    after = (squares[n] - squares[k]) / (n - k) - ((total[n] - total[k]) / (n - k)) ** 2
    least = 1e-12 * max(float(squares[n]) / n, 1e-300)
    aic = k * np.log(np.maximum(before, least)) + (n - k - 1) * np.log(np.maximum(after, least))
    at = int(k[np.argmin(aic)])
    return float(_mean_of(force_N[max(0, at - 10) : at + 10], 5).max()), nan, False


PICKERS: tuple[tuple[str, str, Picker, bool], ...] = (
    ("ropefric", "", by_ropefric, True),
    ("ropefric", "highest", partial(by_ropefric, picker="highest"), True),
    *(("moving average", f"{n} points", partial(by_highest_mean, points=n), n == 15) for n in (5, 10, 15)),
    *(
        ("moving average", f"{n} ms", partial(by_highest_mean, lasting_s=1e-3 * n), False)
        for n in (5, 10, 15)
    ),
    *(
        ("find_peaks", f"prominence {100 * p:g} %", partial(by_prominence, part=p), p == 0.05)
        for p in (0.02, 0.05)
    ),
    ("STA/LTA", "10 over 100", partial(by_sta_lta, short=10, long=100), True),
    ("STA/LTA", "20 over 400", partial(by_sta_lta, short=20, long=400), False),
    ("AIC", "", by_aic, True),
)
"""Method, setting, picker, whether a quick look has it."""


def score(picked: Sequence[Picked], known: Sequence[Known]) -> Outcome:
    """Return how a picker did.

    Shares of the recordings that have an F_A: `right`, `wrong`, `missed`, `doubtful`; of those that have none:
    `false` (a force all the same). Of the right ones: bias and scatter; `within_2u`, where the picker states u. The
    error is the one that 95 % of the forces given stay below; infinite where none was given. Of each kind, the share
    that is right: a force to within `RIGHT`, or none where there is none.
    """
    force_N, std_N = np.array([one[:2] for one in picked], dtype=np.float64).T
    doubt = np.array([one[2] for one in picked])
    true_N = np.array([one.peak_N for one in known])
    usable, given = np.isfinite(true_N), np.isfinite(force_N)
    errors = (force_N / true_N - 1.0)[usable & given]
    right = errors[np.abs(errors) <= RIGHT]
    is_right = np.where(usable, np.abs(force_N / true_N - 1.0) <= RIGHT, ~given)
    kinds = np.array([one.kind for one in known])
    close = (np.abs(force_N - true_N) <= 2.0 * std_N)[usable & given & np.isfinite(std_N)]

    def share(which: FloatArray, of: FloatArray) -> float:
        return float(np.count_nonzero(which) / of.size) if of.size else nan

    return Outcome(
        error=float(np.quantile(np.abs(errors), 0.95)) if errors.size else inf,
        evaluations=float(np.mean([one.trace.force_N.size for one in known])),
        bias=float(right.mean()) if right.size else nan,
        noise=float(right.std(ddof=1)) if right.size > 1 else nan,
        shares={
            "recordings": float(true_N.size),
            "right": share(right, true_N[usable]),
            "wrong": share(errors[np.abs(errors) > RIGHT], true_N[usable]),
            "missed": share((usable & ~given & ~doubt)[usable], true_N[usable]),
            "doubtful": share((usable & doubt)[usable], true_N[usable]),
            "false": share((~usable & given)[~usable], true_N[~usable]),
            "within_2u": share(close, close),
        },
        kinds={kind: float(is_right[kinds == kind].mean()) for kind in dict.fromkeys(kinds.tolist()) if kind},
    )


def _settings(load: Callable[[], tuple[Known, ...]]) -> tuple[Setting, ...]:
    def setting(method: str, name: str, pick: Picker, *, quick: bool) -> Setting:
        def assess() -> Outcome:
            return score([pick(one.trace) for one in load()], load())

        def call() -> object:  # on the recording of middling length
            return pick(sorted(load(), key=lambda one: one.trace.force_N.size)[len(load()) // 2].trace)

        return Setting(method, name, call, assess, quick)

    return tuple(setting(method, name, pick, quick=quick) for method, name, pick, quick in PICKERS)


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    lines = []
    for case in dict.fromkeys(point.case for point in points):
        ours, *others = in_case(points, case)
        for what, better in (("right", max), ("wrong", min), ("false", min)):
            best = better(others, key=lambda point, what=what: point.shares[what])  # type: ignore[misc]
            mine, theirs = ours.shares[what], best.shares[what]
            if isfinite(mine) and mine != theirs and better(mine, theirs) == theirs:
                lines.append(
                    f"{case}: ropefric loses to {best.name}: {what} {100 * mine:.0f} % against {100 * theirs:.0f} %."
                )
        if ours.kinds:
            worst = sorted((part, kind) for kind, part in ours.kinds.items() if part < 1.0)
            said = ", ".join(f"{kind} ({100 * part:.0f} % right)" for part, kind in worst)
            n = len(ours.kinds)
            lines.append(
                f"{case}: kinds that are not all right: {said}; the other {n - len(worst)} are."
                if worst
                else f"{case}: all {n} kinds are all right."
            )
    return tuple(lines)


UNKNOWN = "unseen rig"
_SAID = {
    "lab": "the noise, sampling, bumps and teeth of ordinary laboratories",
    "clean": "little noise; sharp breaks, a second slip, a hardening wheel, held and climbing motors",
    "nasty": "loud noise, hum, spikes, drift, gaps, clipped and damaged recordings",
}
STUDY = Study(
    name="picks",
    title="Picking the break-away force: who finds it, who makes one up",
    question="Which picker can be trusted with a recording of a rig it has not seen?",
    reference=(
        "largest noise-free force between the onset of macroscopic slip and its first fall, of two simulated rigs: "
        f"{PER_FAMILY} recordings of a family of the second, {UNSEEN} of the fourth, seed {SEED}"
    ),
    counted="samples of a recording; error: what 95 % of the forces given stay below",
    used="a trained network says where, the window of the measured peak follows the noise",
    cases=(
        Case(
            UNKNOWN,
            "a rope held by many junctions: no picker was made for it",
            partial(_settings, unseen_recordings),
        ),
        *(
            Case(tier, said, partial(_settings, partial(known_recordings, tier)))
            for tier, said in _SAID.items()
        ),
    ),
    findings=_findings,
)
