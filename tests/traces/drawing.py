"""Forces drawn over a time, with noise, and the break-away that is picked of them."""

import numpy as np

from ropefric.traces.breakaway import PickSettings
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace


def loaded(*teeth, rate_N_s, begins=((0.0, 0.0), (0.3, 0.0)), fall_s=0.004):
    """Return the corners of a force that a machine loads at one rate up to each of some teeth (top, bottom)."""
    corners = [*begins]
    for top_N, bottom_N in teeth:
        now_s, force_N = corners[-1]
        slips_s = now_s + (top_N - force_N) / rate_N_s
        corners += [(slips_s, top_N), (slips_s + fall_s, bottom_N)]
    return corners


class Drawing:
    """A time over which forces are drawn, and the seed of their noise."""

    def __init__(self, time_s, seed):
        self.time_s, self.seed = time_s, seed

    def drawn(self, *corners, noise_N=0.1, time_s=None, seed=None):
        """Return the force along a line through corners (time, force), with noise."""
        time_s = self.time_s if time_s is None else time_s
        noise = np.random.default_rng(self.seed if seed is None else seed).normal(0.0, noise_N, time_s.size)
        return np.interp(time_s, *zip(*corners, strict=True)) + noise

    def picked(self, force_N, settings=PickSettings(), time_s=None):  # noqa: B008  (it is frozen)
        """Return what is picked of a force."""
        time_s = self.time_s if time_s is None else time_s
        return pick_breakaway(ForceTrace(time_s=time_s, force_N=force_N), settings)[0]

    def since(self, begin_s, time_s=None):
        """Return the time since a moment, nothing before."""
        return np.maximum((self.time_s if time_s is None else time_s) - begin_s, 0.0)
