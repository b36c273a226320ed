"""Slow stick-slip: every tooth of one recording is a trial of its own."""

from dataclasses import replace

import numpy as np

from ropefric.rig.protocols.breakaway import draw_breakaway
from ropefric.rig.protocols.protocol import RigProtocol
from ropefric.rig.settings import Bench
from ropefric.rig.story import BreakawayStory
from ropefric.rig.teeth import lay_teeth

__all__ = ["PROTOCOL"]

TEETH = (8, 16)
RATE_HZ = (2.0, 6.0)


def _draw(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> BreakawayStory:
    n = int(rng.integers(TEETH[0], TEETH[1], endpoint=True))
    tops_N = lift_force_N * (1.0 + bench.trial_scatter * rng.standard_normal(n + 1))
    story = draw_breakaway(bench, float(tops_N[0]), end_tension_N, rng)
    drop_N = story.lift_force_N - story.kinetic_N
    # Static tops stand on the static friction, not on the kinetic level, so that level must not drift here.
    teeth = lay_teeth(
        top_N=tops_N - story.kinetic_N,
        bottom_N=-drop_N * rng.uniform(0.6, 1.0, n + 1),
        reload_N_s=1.8 * drop_N * rng.uniform(*RATE_HZ),
    )
    off_s = story.breakaway_s + float(teeth.time_s[-2] + 0.7 * (teeth.time_s[-1] - teeth.time_s[-2]))
    end_s = off_s + (story.end_s - story.off_s)
    return replace(story, teeth=teeth, drift=0.0, off_s=off_s, end_s=end_s)


PROTOCOL = RigProtocol(
    name="stick-slip",
    meaning="slow teeth after the first break-away, each a trial",
    scatters_inside=True,
    measures_lift=True,
    draw=_draw,
)
