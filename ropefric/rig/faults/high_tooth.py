"""A stick-slip tooth that stands higher than the break-away."""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup, breakaway_story
from ropefric.rig.protocols.breakaway import draw_teeth
from ropefric.rig.settings import Bench
from ropefric.rig.teeth import lay_teeth

__all__ = ["FAULT"]


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    """Raise one to three of the first later teeth to 2-8 % above F_A; each then takes longer to reload."""
    story = breakaway_story(setup, FAULT.name)
    sliding_s = story.off_s - story.breakaway_s
    drop_N = story.lift_force_N - story.kinetic_N
    # Where one tooth can stand so high, all teeth are large: redraw them.
    height_N, rate_Hz = 0.6 * drop_N, float(rng.uniform(8.0, 25.0))
    teeth = draw_teeth(rng, drop_N=drop_N, height_N=height_N, rate_Hz=rate_Hz, lasting_s=4.0 * sliding_s)
    n = int(rng.integers(1, 4))
    chosen = rng.choice(np.arange(2, 5), size=n, replace=False)
    top_N = teeth.top_N.copy()
    top_N[chosen] = story.lift_force_N * rng.uniform(1.02, 1.08, n) - story.kinetic_N
    # The last of them must come before the motor is off, if need be by a faster reload.
    needed_N_s = float((top_N[1:5] - teeth.bottom_N[:4]).sum()) / (0.8 * sliding_s)
    laid = lay_teeth(top_N=top_N, bottom_N=teeth.bottom_N, reload_N_s=max(height_N * rate_Hz, needed_N_s))
    return Setup(story=replace(story, teeth=laid, drift=0.0), sensor=setup.sensor)


FAULT = Fault(
    name="high-tooth",
    meaning="one to three later teeth stand 2 to 8 % above the break-away",
    expected_status=None,
    rate=0.02,
    protocols=("breakaway",),
    on_setup=_apply,
)
