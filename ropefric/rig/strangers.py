"""Recordings of rigs unlike the first, with known truth: families of mechanics, of sensors and of what goes wrong.

`recordings(seed)` draws rigs over wide ranges (1 N to 5 kN, 50 Hz to 10 kHz, micro-slip from a thousandth of the climb's
way to more than what stays stable), integrates them (`dynamics`) and passes the spring's force through a sensor.
The truth comes from the noise-free force of the spring alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, frozen_array
from ropefric.registry import Registry
from ropefric.rig.disturbances import Take, sense
from ropefric.rig.dynamics import simulate
from ropefric.rig.pulls import NO_PEAK, SLOW, Truth, draw_numbers, draw_slider, truth_of
from ropefric.traces.breakaway import Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.clock import mend_clock
from ropefric.traces.trace import ForceTrace

TIERS = ("clean", "lab", "nasty")
_BATCH, _ATTEMPTS = 240, 15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """One recording as a stranger sends it."""

    name: str
    family: str
    tier: str
    time_s: FloatArray
    force_N: FloatArray
    truth: Truth
    counts: FloatArray | None = None
    calibration: Calibration | None = None

    def trace(self) -> ForceTrace:
        """Return the recording as the picker gets it: clock mended, counts with their saturation."""
        keep, time_s, notes = mend_clock(self.time_s, [self.force_N], name=self.name)
        trace = ForceTrace(time_s=time_s, force_N=self.force_N[keep], name=self.name, notes=notes)
        if self.counts is None or self.calibration is None:
            return trace
        counts = self.counts.astype(np.int64)
        force_N, saturation = self.calibration.apply(counts)
        return replace(
            trace, force_N=force_N, counts=counts, calibration=self.calibration, saturation=saturation
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Recordings of one kind: how they are drawn, and what the sensor does to them."""

    name: str
    tier: str
    ranges: Mapping[str, Any]
    faults: tuple[str, ...]
    expects: Status


_LAB = {"noise": (1e-3, 6e-3), "rough": (0.0, 0.012), "bits": 12, "rate_Hz": (150.0, 1e4)}
_NASTY = {"noise": (3e-3, 1.5e-2), "rough": (0.0, 0.02), "bits": 11, "rate_Hz": (100.0, 1e4)}
_TEETH = {"direct": (0.3, 0.7), "laws": ("ageing", "slip"), "slide_s": (1.5, 4.0)}
_OK, _NONE, _PEAKLESS, _CUT = Status.OK, Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED


def _family(name: str, tier: str, *faults: str, expects: Status = Status.OK, **ranges: Any) -> Family:
    like = ranges.pop("like", {})
    basis = {"clean": {}, "lab": _LAB, "nasty": _NASTY}[tier]
    return Family(name=name, tier=tier, ranges=basis | like | ranges, faults=faults, expects=expects)


FAMILIES: Registry[Family] = Registry("family of recordings", [
    _family("sharp", "clean"),
    _family("sharp-slip-law", "clean", laws="slip", critical=(0.01, 0.2)),
    _family("bristles", "clean", laws="lugre"),
    _family("rounded", "clean", like=SLOW, fall_s=(0.05, 0.3), climb_s=(0.5, 4.0)),
    _family("fall-20-80-ms", "clean", like=SLOW, fall_s=(0.02, 0.08), climb_s=(0.4, 2.0)),
    _family("fall-0.1-0.6-s", "clean", like=SLOW, fall_s=(0.1, 0.6), climb_s=(0.8, 6.0)),
    _family("strong-stick-slip", "clean", like=_TEETH, drop=(0.3, 0.6), critical=(0.02, 0.2)),
    _family("weak-stick-slip", "clean", like=_TEETH, drop=(0.06, 0.15), critical=(0.3, 0.9)),
    _family("hardening", "clean", wear=(0.03, 0.12)),
    _family("second-higher", "clean", teeth="second", critical=(0.03, 0.2)),
    _family("rests", "clean", rests=True),
    _family("held-quiet", "clean", expects=_NONE, held=(0.4, 0.85), laws=("ageing", "slip"), slide_s=(0.5, 2.0)),
    _family("climbing", "clean", expects=_NONE, stopped=(0.3, 0.9)),
    _family("no-peak", "clean", like=NO_PEAK, expects=_PEAKLESS),
    _family("lab", "lab"),
    _family("lab-bristles", "lab", laws="lugre"),
    _family("lab-rounded", "lab", like=SLOW, fall_s=(0.03, 0.4)),
    _family("fall-0.3-2-s", "lab", like=SLOW, fall_s=(0.3, 2.0), climb_s=(1.5, 8.0)),
    _family("lab-stick-slip", "lab", like=_TEETH, critical=(0.03, 0.7)),
    _family("one-precursor", "lab", partials="one"),
    _family("many-precursors", "lab", partials="many"),
    _family("snag", "lab", "snag", idle_s=(0.5, 2.0)),
    _family("jog", "lab", jog=(0.1, 0.8)),
    _family("impact", "lab", "impact", idle_s=(0.4, 2.0)),
    _family("late-higher", "lab", teeth="late", slide_s=(1.5, 4.0)),
    _family("wear", "lab", like=SLOW, fall_s=(0.02, 0.2), wear=(0.1, 0.5), slide_s=(1.0, 3.0)),
    _family("two-pulls", "lab", pulls=2),
    _family("strokes", "lab", pulls=4, slide_s=(0.3, 1.0), climb_s=(0.2, 1.5)),
    _family("short", "lab", idle_s=(0.05, 0.15), slide_s=(0.1, 0.4), ending="cut", climb_s=(0.2, 0.8), hang=0.0),
    _family("few-samples", "lab", rate_Hz=(50.0, 100.0), climb_s=(0.3, 1.0), per_climb=8.0),
    _family("hum", "lab", "hum", hum=(1e-3, 8e-3), rate_Hz=(400.0, 1e4)),
    _family("pink", "lab", "pink", noise=(1e-3, 3e-3)),
    _family("filter", "lab", "filter", climb_s=(1.0, 6.0)),
    _family("held-creeping", "lab", expects=_NONE, held=(0.7, 0.95), slide_s=(0.8, 3.0)),
    _family("held-let-down", "lab", expects=_NONE, held=(0.5, 0.9), ending="let-down"),
    _family("lab-climbing", "lab", expects=_NONE, stopped=(0.3, 0.93)),
    _family("lab-no-peak", "lab", like=NO_PEAK, expects=_PEAKLESS),
    _family("nasty", "nasty"),
    _family("ringing", "nasty", "ringing", rate_Hz=(800.0, 1e4), critical=(0.03, 0.15)),
    _family("tare-shift", "nasty", "tare-shift"),
    _family("drift", "nasty", "drift"),
    _family("spikes", "nasty", "spikes"),
    _family("double-spikes", "nasty", "double-spikes"),
    _family("dropouts", "nasty", "dropouts"),
    _family("gaps", "nasty", "gaps"),
    _family("jitter", "nasty", "jitter"),
    _family("duplicated-rows", "nasty", "doubled"),
    _family("coarse", "nasty", "coarse"),
    _family("loud-hum", "nasty", "hum", hum=(8e-3, 3e-2), rate_Hz=(300.0, 5e3)),
    _family("hard-snag", "nasty", "snag", "hum", hum=(1e-3, 1e-2), idle_s=(0.5, 2.0)),
    _family("hard-impact", "nasty", "impact", "ringing", idle_s=(0.4, 2.0), rate_Hz=(500.0, 1e4)),
    _family("hard-precursor", "nasty", "spikes", partials="one"),
    _family("everything", "nasty", "snag", "filter", "hum", "drift", "spikes", hum=(1e-3, 1e-2), climb_s=(1.0, 5.0)),
    _family("clipped", "nasty", "clipped", expects=_CUT),
    _family("clipped-counts", "nasty", "clipped-counts", expects=_CUT),
    _family("late-start", "nasty", "late", like=SLOW, expects=_PEAKLESS, fall_s=(0.02, 0.2), slide_s=(1.5, 3.0)),
    _family("hard-held", "nasty", "hum", "drift", hum=(1e-3, 1e-2), expects=_NONE, held=(0.5, 0.9)),
])  # fmt: skip
"""Every kind of recording by name."""


def recordings(
    seed: int, *, per_family: int = 8, families: Sequence[str] = (), tiers: Sequence[str] = TIERS
) -> Iterator[Recording]:
    """Yield recordings of unfamiliar rigs with known truth; the same for the same seed, whichever families are asked.

    Parameters
    ----------
    seed : int
        The same seed draws the same recordings.
    per_family : int
        How many of each family.
    families, tiers : sequence of str
        Only these families, only these tiers; all by default.

    Examples
    --------
    >>> one = next(recordings(1, per_family=1, families=("sharp",)))
    >>> one.truth.status.value, one.tier, one.force_N.size == one.time_s.size
    ('ok', 'clean', True)
    """
    chosen = [FAMILIES[name] for name in families or FAMILIES]
    jobs = [(one, number) for one in chosen if one.tier in tiers for number in range(per_family)]
    for start in range(0, len(jobs), _BATCH):
        yield from _made(seed, jobs[start : start + _BATCH])


def _made(seed: int, jobs: list[tuple[Family, int]]) -> Iterator[Recording]:
    """Draw until every recording's truth is one that can be told; a draw that is not is thrown away."""
    order = list(FAMILIES)
    done: dict[int, Recording] = {}
    for attempt in range(_ATTEMPTS):
        drawn = []
        for i, (family, number) in enumerate(jobs):
            if i not in done:
                rng = np.random.default_rng([seed, order.index(family.name), number, attempt])
                numbers = draw_numbers(rng, family.ranges)
                drawn.append((i, rng, numbers, draw_slider(rng, numbers)))
        for (i, rng, numbers, slider), motion in zip(drawn, simulate([one[3] for one in drawn]), strict=True):
            family, number = jobs[i]
            truth = truth_of(motion, slider, noise=6.0 * numbers["noise"] + 3.0 * numbers.get("hum", 0.0))
            if truth is None:
                continue
            take = Take(rng=rng, drawn=numbers, slider=slider, truth=truth)
            sense(take, motion, family.faults)
            if take.truth.status == family.expects:
                done[i] = Recording(
                    name=f"{family.name}-{number:03d}", family=family.name, tier=family.tier, truth=take.truth,
                    time_s=frozen_array(take.time_s), force_N=frozen_array(take.force_N),
                    counts=take.counts, calibration=take.calibration,
                )  # fmt: skip
        if len(done) == len(jobs):
            break
    yield from (done[i] for i in sorted(done))
