"""One break-away a recording: the bench of the PRTH paper."""

import numpy as np

from ropefric.rig.protocols.protocol import RigProtocol
from ropefric.rig.settings import Bench
from ropefric.rig.story import BreakawayStory
from ropefric.rig.teeth import Snap, Teeth, lay_teeth

__all__ = ["PROTOCOL", "draw_breakaway", "draw_teeth"]


def draw_teeth(
    rng: np.random.Generator, *, drop_N: float, height_N: float, rate_Hz: float, lasting_s: float
) -> Teeth:
    """Return jittered teeth of a mean height and rate that last at least some time.

    Parameters
    ----------
    rng : Generator
        Source of the jitter.
    drop_N : float
        Break-away force above the kinetic level [N].
    height_N, rate_Hz : float
        Mean height of the teeth [N] and their number per second.
    lasting_s : float
        Time to fill [s].

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> teeth = draw_teeth(rng, drop_N=60.0, height_N=20.0, rate_Hz=10.0, lasting_s=1.0)
    >>> teeth.time_s[-1] > 1.0, float(teeth.top_N[0])
    (np.True_, 60.0)
    """
    n = int(2.0 * lasting_s * rate_Hz) + 4
    half_N = 0.5 * height_N
    top_N = half_N * rng.uniform(0.5, 1.5, n)
    bottom_N = -half_N * rng.uniform(0.7, 1.3, n)
    top_N[0] = drop_N
    return lay_teeth(top_N=top_N, bottom_N=bottom_N, reload_N_s=height_N * rate_Hz)


def draw_breakaway(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> BreakawayStory:
    """Return what happens in one recording, drawn from the bench; it breaks away at exactly `lift_force_N`.

    Examples
    --------
    >>> story = draw_breakaway(Bench(), 320.7, 80.0, np.random.default_rng(1))
    >>> story.force_N(np.array([0.0, story.breakaway_s])).round(6).tolist()
    [0.0, 320.7]
    """
    hang_s = rng.uniform(*bench.idle_s)
    settle_s = hang_s + rng.uniform(*bench.hang_s)
    dwell_s = rng.uniform(*bench.dwell_s)
    ramp_s = settle_s + dwell_s
    breakaway_s = ramp_s + rng.uniform(*bench.load_s)
    off_s = breakaway_s + rng.uniform(*bench.slide_s)
    end_s = off_s + rng.uniform(*bench.off_s)
    # The cell cannot read more than the static friction before the pull, however the weights bounce.
    pretension_N = min(end_tension_N * rng.uniform(*bench.pretension), 0.9 * lift_force_N)
    bounce_N = min(pretension_N * rng.uniform(*bench.bounce), 0.6 * (lift_force_N - pretension_N))
    kinetic_N = lift_force_N * rng.uniform(*bench.kinetic_ratio)
    drop_N = lift_force_N - kinetic_N
    return BreakawayStory(
        hang_s=hang_s,
        settle_s=settle_s,
        ramp_s=ramp_s,
        breakaway_s=breakaway_s,
        off_s=off_s,
        end_s=end_s,
        pretension_N=pretension_N,
        bounce_N=bounce_N,
        bounce_Hz=rng.uniform(*bench.bounce_Hz),
        bounce_decay_s=dwell_s * rng.uniform(0.1, 0.2),
        lift_force_N=lift_force_N,
        ramp_top_N=lift_force_N,
        soft_start=rng.uniform(*bench.soft_start),
        micro_slip=rng.uniform(*bench.micro_slip),
        micro_slip_loss=rng.uniform(*bench.micro_slip_loss),
        kinetic_N=kinetic_N,
        drift=bench.kinetic_drift * rng.uniform(-1.0, 1.0),
        teeth=draw_teeth(
            rng,
            drop_N=drop_N,
            height_N=drop_N * rng.uniform(*bench.tooth_height),
            rate_Hz=rng.uniform(*bench.tooth_Hz),
            lasting_s=off_s - breakaway_s,
        ),
        snap=Snap(
            natural_Hz=bench.natural_frequency_Hz(rng.uniform(*bench.stiffness_factor)),
            damping_ratio=rng.uniform(*bench.damping_ratio),
        ),
        holding_N=pretension_N + (kinetic_N - pretension_N) * rng.uniform(0.3, 0.8),
        release_s=rng.uniform(*bench.release_s),
    )


PROTOCOL = RigProtocol(
    name="breakaway",
    meaning="one static peak a recording, then sliding",
    scatters_inside=False,
    measures_lift=True,
    draw=draw_breakaway,
)
