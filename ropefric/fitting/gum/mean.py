"""The mean of a condition's trials: s/√n, of a single trial with the scatter that the other conditions show."""

import math
from collections.abc import Sequence

from ropefric.arrays import FloatArray
from ropefric.fitting.gum.quantity import Quantity, repeats


def mean_force(
    symbol: str, values_N: FloatArray, pooled: tuple[float, float], ratio: float = 1.0
) -> tuple[Quantity, tuple[str, ...]]:
    """Return a mean force with its repeatability, and what was assumed."""
    mean_N, n = float(values_N.mean()), int(values_N.size)
    if n > 1:
        std_N = float(values_N.std(ddof=1)) / ratio
        notes: tuple[str, ...] = ()
        if ratio < 1.0:
            notes = (f"s is divided by {ratio:.3f}, which the rejection rule leaves of it on average",)
        return repeats("repeatability", f"mean {symbol}", "N", mean=mean_N, std=std_N, n=n), notes
    relative, dof = pooled
    if not dof:
        alone = Quantity(
            name="repeatability",
            symbol=f"mean {symbol}",
            unit="N",
            estimate=mean_N,
            stated=0.0,
            type="A",
            repeats=1,
        )
        return alone, ("one trial, and no condition is repeated: the repeatability is unknown",)
    note = f"one trial: its scatter is that of the other conditions, {100 * relative:.2g} % of the force"
    return (
        repeats("repeatability", f"mean {symbol}", "N", mean=mean_N, std=relative * mean_N, n=1, dof=dof),
        (note,),
    )


def pooled_scatter(parts: Sequence[tuple[float, int]]) -> tuple[float, float]:
    """Return the pooled relative scatter of conditions and its degrees of freedom; 0, 0 if there is none."""
    dof = sum(count for _, count in parts)
    square = math.fsum(count * scatter**2 for scatter, count in parts)
    return (math.sqrt(square / dof), float(dof)) if dof and square else (0.0, 0.0)
