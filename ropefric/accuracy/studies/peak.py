"""The break-away peak: a long window takes the peak off with the noise, a short one leaves the noise on the peak."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study, by_case, over_seeds
from ropefric.rig.bench import Bench
from ropefric.rig.recording import simulate_recording
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.calibration import Calibration
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.smoothing import average_over_samples
from ropefric.traces.trace import ForceTrace

LIFT_N, END_N = 320.0, 80.0
N_RECORDINGS = 40
IDLE_S = 0.25

_SAMPLES = (3, 5, 7, 11, 15, 21, 31, 61, 121, 301)


@cache
def recordings(noise_counts: tuple[float, float]) -> tuple[ForceTrace, ...]:
    """Return calibrated recordings of the virtual rig, all of which break away at exactly 320 N."""
    bench = Bench(noise_counts=noise_counts)
    return tuple(_recording(bench, seed) for seed in range(N_RECORDINGS))


def _recording(bench: Bench, seed: int) -> ForceTrace:
    made = simulate_recording(
        bench, lift_force_N=LIFT_N, end_tension_N=END_N, rng=np.random.default_rng(seed)
    )
    counts = made.counts.astype(np.int64)
    calibration = Calibration(cell=bench.cell_named(made.truth.cell), adc=bench.adc)
    force_N, saturation = calibration.with_tare(counts[made.time_s <= IDLE_S])[0].apply(counts)
    return ForceTrace(time_s=made.time_s, force_N=force_N, saturation=saturation, name=f"seed {seed}")


def _settings(noise_counts: tuple[float, float]) -> tuple[Setting, ...]:
    traces = recordings(noise_counts)
    size = float(np.mean([trace.force_N.size for trace in traces]))

    def setting(method: str, pick: Callable[[ForceTrace], float], n_window: int = 0) -> Setting:
        def assess() -> Outcome:
            errors = np.array([pick(trace) / LIFT_N - 1.0 for trace in traces])
            given = np.isfinite(errors)  # of a recording that is in doubt there is no force
            return replace(over_seeds(errors[given], size), shares={"given": float(given.mean())})

        name, quick = f"{n_window} samples" if n_window else "", n_window in {0, *_SAMPLES[1::3]}
        return Setting(method, name, partial(pick, traces[0]), assess, quick)

    def highest_average(n_window: int, trace: ForceTrace) -> float:  # the way of the paper
        return float(average_over_samples(trace.force_N, n_window).max())

    return (
        setting("raw maximum", lambda trace: float(trace.force_N.max())),
        *(setting("moving average", partial(highest_average, n), n) for n in _SAMPLES),
        setting("chosen window", lambda trace: pick_breakaway(trace, PickSettings())[0].peak_N),
    )


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    lines = []
    for case, here in by_case(points).items():
        averages = [point for point in here if point.method == "moving average"]
        best, longest = min(averages, key=lambda point: point.error), averages[-1]
        others = [f"{point.method} {_percent(point)}" for point in here if point not in averages]
        lines.append(
            f"{case}: of the fixed windows {best.setting} are best, {_percent(best)}; {longest.setting} read "
            f"{100 * longest.bias:+.2g} % on average. {'; '.join(others)}."
        )
    return tuple(lines)


def _percent(point: Measured) -> str:
    return f"{100 * point.error:.2g} % (bias {100 * point.bias:+.2g} %, scatter {100 * point.noise:.2g} %)"


STUDY = Study(
    name="peak",
    title="Break-away peak of a recording: window and estimator",
    question="How long may the smoothing window be, and what does it cost to let the tool choose it?",
    reference=f"known truth of {N_RECORDINGS} recordings of the virtual rig; error: rms where there is a force",
    counted="samples of a recording",
    used="window chosen from the trace",
    cases=(
        Case("bench", "3 kHz, 10 bit, noise of 0.3 to 1 counts, as on the bench", partial(_settings, (0.3, 1.0))),
        Case("noisy", "the same with a noise of 6 counts (5.9 N)", partial(_settings, (6.0, 6.0))),
    ),
    findings=_findings,
)  # fmt: skip
