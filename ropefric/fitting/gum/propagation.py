"""The propagation of distributions (JCGM 101): draws that check a budget made by linear propagation."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.gum.budget import LinearBudget
from ropefric.fitting.gum.model import MeasurementModel

_FEWEST, _MOST = 10_000, 10_000_000
# The end of a 95 % interval from N draws scatters by about 2.7 σ/√N; U is about 2 σ.
_END_NOISE = 2.7 / 1.96
DISAGREEMENT = 0.1
"""Part of U by which an end of y ± U may differ from that of the draws [-]."""
_UNANSWERED = 0.01
_ONE_SIGMA = 0.8413447460685429


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnAnswer:
    """What draws of the inputs say about the answer."""

    draws: int
    seed: int
    unanswered: int
    median: float
    half_68: float
    symmetric: tuple[float, float]
    shortest: tuple[float, float]
    low_gap: float
    high_gap: float
    digits: int
    agrees: bool

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as JSON-able values."""
        return {
            "draws": self.draws,
            "seed": self.seed,
            "unanswered": self.unanswered,
            "median": self.median,
            "half_68": self.half_68,
            "symmetric_interval": list(self.symmetric),
            "shortest_interval": list(self.shortest),
            "gaps": [self.low_gap, self.high_gap],
            "validated_digits": self.digits,
            "agrees": self.agrees,
        }


def numerical_tolerance(std: float, digits: int) -> float:
    """Return δ = ½·10^l for u = c·10^l with c a whole number of `digits` digits, section 7.9.2 of JCGM 101."""
    # Rounding may carry into the next decade (0.996 -> 1.0), so the exponent is read off the rounded number.
    exponent = int(f"{std:.{digits - 1}e}".partition("e")[2]) - (digits - 1)
    return 0.5 * 10.0**exponent


def shortest_interval(values: FloatArray, level: float) -> tuple[float, float]:
    """Return the shortest interval that holds a share `level` of sorted values, section 7.7.4 of JCGM 101."""
    span = min(max(math.floor(level * values.size + 0.5), 1), values.size)
    widths = values[span - 1 :] - values[: values.size - span + 1]
    first = int(np.argmin(widths))
    return float(values[first]), float(values[first + span - 1])


def propagate(
    model: MeasurementModel, budget: LinearBudget, *, draws: int = 200_000, seed: int = 0
) -> DrawnAnswer:
    """Return the answer to draws of the inputs, and whether the linear budget agrees with it."""
    if not _FEWEST <= draws <= _MOST or seed < 0:
        raise InputError(
            f"{draws} draws with seed {seed}",
            key="draws",
            fix=f"draw {_FEWEST} or more, at most {_MOST}, with seed 0 or more",
        )
    values = model.draw(np.random.default_rng(seed), draws)
    values = np.sort(values[np.isfinite(values)])
    unanswered = draws - values.size
    if 2 * unanswered > draws:
        raise InputError(
            f"{model.name} has no answer for {unanswered} of {draws} draws of its inputs",
            code="RF420",
            key="draws",
            fix="the inputs are too uncertain for any budget; measure them better",
        )
    tail = 0.5 * (1.0 - budget.level)
    at = [tail, 1.0 - tail, 1.0 - _ONE_SIGMA, 0.5, _ONE_SIGMA]
    low, high, below, median, above = (float(end) for end in np.quantile(values, at))
    low_gap, high_gap = abs(low - budget.interval[0]), abs(high - budget.interval[1])
    wider = max(low_gap, high_gap)
    room = (DISAGREEMENT + 3.0 * _END_NOISE / math.sqrt(draws)) * budget.expanded
    return DrawnAnswer(
        draws=draws,
        seed=seed,
        unanswered=unanswered,
        median=median,
        half_68=0.5 * (above - below),
        symmetric=(low, high),
        shortest=shortest_interval(values, budget.level),
        low_gap=low_gap,
        high_gap=high_gap,
        digits=next((d for d in (2, 1) if wider <= numerical_tolerance(budget.combined, d)), 0),
        agrees=wider <= room and unanswered <= _UNANSWERED * draws,
    )
