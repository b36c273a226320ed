"""From what was found in a recording to the result that is handed on."""

import numpy as np

from ropefric.traces.breakaway import Breakaway, Phase, Status
from ropefric.traces.peak import Neighbourhood, Peak, measure_peak
from ropefric.traces.prepare import Prepared
from ropefric.traces.settings import PickSettings
from ropefric.traces.sliding import Sliding
from ropefric.traces.slips import DROP_SIGMAS

WIDE_GAP = 5.0


def kinetic(prepared: Prepared, sliding: Sliding | None) -> tuple[float, float]:
    """Return mean and sample standard deviation of the force while sliding [N]; NaN where nothing slid."""
    if sliding is None:
        return float("nan"), float("nan")
    stretch = prepared.force_N[prepared.view.samples(sliding.first, sliding.stop, prepared.force_N.size)]
    return float(stretch.mean()), float(stretch.std(ddof=1))


def peak_between(prepared: Prepared, settings: PickSettings, *, climb: int, block: int, fallen: int) -> Peak:
    """Return the peak at a block, measured on its samples."""
    view, n = prepared.view, prepared.force_N.size
    where = Neighbourhood(
        loading=view.first_sample(climb),
        first=view.first_sample(block - 1),
        stop=view.last_sample(min(fallen - 1, block + 1), n) + 1 if fallen > block else n,
        fallen=view.last_sample(fallen, n),
    )
    return measure_peak(
        prepared.time_s,
        prepared.force_N,
        where,
        noise_std_N=prepared.noise_N,
        window_s=settings.window_s,
    )


def phases_of(prepared: Prepared, block: int, sliding: Sliding | None) -> tuple[Phase, ...]:
    """Return what happened when: idle, loading, break-away, sliding, unloading."""
    view = prepared.view
    base_N = float(view.force_N[: block + 1].min())
    idle_N = base_N + max(DROP_SIGMAS * view.noise_N, 0.05 * (float(view.force_N[block]) - base_N))
    idle = np.flatnonzero(view.force_N[: block + 1] <= idle_N)
    start_s, peak_s, end_s = (float(t) for t in (view.time_s[0], view.time_s[block], prepared.time_s[-1]))
    loading_s = float(view.time_s[idle[-1]]) if idle.size else start_s
    phases = [Phase(name="idle", start_s=start_s, end_s=loading_s)] if loading_s > start_s else []
    phases.append(Phase(name="loading", start_s=loading_s, end_s=peak_s))
    if sliding is None:
        return (*phases, Phase(name="unloading", start_s=peak_s, end_s=end_s))
    slides_s = float(view.time_s[sliding.first])
    stops_s = float(view.time_s[sliding.stop]) if sliding.stop < view.time_s.size else end_s
    phases.append(Phase(name="break-away", start_s=peak_s, end_s=slides_s))
    phases.append(Phase(name="sliding", start_s=slides_s, end_s=stops_s))
    if stops_s < end_s:
        phases.append(Phase(name="unloading", start_s=stops_s, end_s=end_s))
    return tuple(phases)


def peak_result(
    prepared: Prepared,
    peak: Peak,
    settings: PickSettings,
    *,
    sliding: Sliding | None,
    phases: tuple[Phase, ...],
) -> Breakaway:
    """Return the result `ok` for a measured peak, in the estimate asked for, with what was met on the way."""
    kinetic_N, kinetic_std_N = kinetic(prepared, sliding)
    notes = [*prepared.notes]
    two_line = settings.peak == "two-line" and np.isfinite(peak.two_line_N)
    if settings.peak == "two-line" and not two_line:
        notes.append("too few samples for the two-line fit; the smoothed peak is given")
    std_N = peak.std_N
    gap_s = _gap_beside_s(prepared, peak.time_s)
    if gap_s:
        notes.append(
            f"there is a gap of {1000 * gap_s:.3g} ms in the samples next to the peak: the force may have been "
            "higher in it"
        )
        # It may have climbed on at its rate, but hardly by more than the whole step to the sliding force.
        missed_N = max(peak.loading_rate_N_s, 0.0) * gap_s
        if np.isfinite(kinetic_N):
            missed_N = min(missed_N, max(peak.peak_N - kinetic_N, 0.0))
        std_N = float(np.hypot(std_N, missed_N / np.sqrt(3.0)))
    return Breakaway(
        status=Status.OK,
        detail=""
        if sliding
        else "the force falls away after the peak: no sliding phase, kinetic force unknown",
        peak_N=peak.two_line_N if two_line else peak.peak_N,
        peak_raw_N=peak.peak_raw_N,
        peak_time_s=peak.time_s,
        peak_std_N=std_N,
        two_line_N=peak.two_line_N,
        bias_N=0.0 if two_line else peak.bias_N,
        kinetic_N=kinetic_N,
        kinetic_std_N=kinetic_std_N,
        window_s=peak.window_s,
        noise_std_N=prepared.noise_N,
        loading_rate_N_s=peak.loading_rate_N_s,
        phases=phases,
        notes=tuple(notes),
    )


def _gap_beside_s(prepared: Prepared, peak_s: float) -> float:
    """Return the length of a gap in the samples next to the peak [s]; 0 where there is none."""
    time_s = prepared.time_s
    index = int(np.searchsorted(time_s, peak_s))
    steps_s = np.diff(time_s[max(0, index - 2) : index + 4])
    usual_s = np.median(np.diff(time_s[max(0, index - 250) : index + 250]))
    longest_s = float(steps_s.max(initial=0.0))
    return longest_s if longest_s > WIDE_GAP * usual_s else 0.0
