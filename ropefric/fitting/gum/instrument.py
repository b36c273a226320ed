"""What the measuring chain adds to the mean force of a condition: what its trials share, and only that."""

import math
from collections.abc import Iterable, Sequence

from ropefric.fitting.gum.quantity import Quantity, limit_of_error
from ropefric.traces.budget import Component, force_budget
from ropefric.traces.calibration import Calibration
from ropefric.trials.result import TrialResult

_SYMBOLS = {
    "linearity": "δ_lin",
    "hysteresis": "δ_hys",
    "repeatability": "δ_rep",
    "transmitter": "δ_tr",
    "quantisation": "δ_q",
    "calibration line": "δ_cal",
}
_OWN = "each trial has its own {what} ({size_N:.2g} N): the repeatability holds it already"


def instrument_quantities(trials: Sequence[TrialResult]) -> tuple[tuple[Quantity, ...], tuple[str, ...]]:
    """Return the corrections of a mean force that are not made, and what is left out because it is counted already."""
    chains = [trial.calibration for trial in trials if trial.calibration is not None]
    found: list[Quantity] = []
    notes: list[str] = []
    single = len(trials) == 1
    if chains:
        worst = max(chains, key=lambda chain: chain.cell.full_scale_N)
        if any(chain.cell != worst.cell for chain in chains):
            notes.append(
                f"several force cells were used: the chain is that of the largest, {worst.cell.name}"
            )
        found += _chain(trials, worst, single=single)
        found += _tare(chains, notes, single=single)
        if not single and worst.cell.repeatability:
            limit_N = worst.cell.repeatability * worst.cell.full_scale_N
            notes.append(
                f"the cell's own repeatability (limit {limit_N:.2g} N) is part of that of the trials"
            )
    else:
        notes.append(
            "the recordings come in newtons without their chain: calibration and resolution are unknown"
        )
    bias_N = _mean(trial.breakaway.bias_N for trial in trials)
    found.append(limit_of_error("bias of the smoothing", "δ_sm", "N", abs(bias_N)))
    picking_N = math.sqrt(_mean(trial.breakaway.peak_std_N**2 for trial in trials))
    if single:
        found.append(Quantity(name="picking", symbol="δ_pick", unit="N", estimate=0.0, stated=picking_N))
    else:
        notes.append(_OWN.format(what="peak to pick", size_N=picking_N))
    return tuple(found), tuple(notes)


def _chain(trials: Sequence[TrialResult], chain: Calibration, *, single: bool) -> list[Quantity]:
    force_N = _mean(trial.measured_N for trial in trials)
    components = [c for c in force_budget(force_N, chain).components if c.name in _SYMBOLS]
    # What changes from one loading to the next shows in the scatter of the trials.
    return [_quantity(c, chain) for c in components if single or c.name != "repeatability"]


def _quantity(component: Component, chain: Calibration) -> Quantity:
    name, symbol = component.name, _SYMBOLS[component.name]
    if name == "quantisation":
        return Quantity(
            name="resolution",
            symbol=symbol,
            unit="N",
            estimate=0.0,
            stated=chain.lsb_N,
            divisor=math.sqrt(12.0),
            distribution="rectangular",
        )
    return Quantity(
        name=f"cell's {name}" if name == "repeatability" else name,
        symbol=symbol,
        unit="N",
        estimate=0.0,
        stated=component.estimate_N,
        divisor=component.divisor,
        distribution=component.distribution,
        type=component.type,
        dof=component.dof,
        assumed=component.assumed,
    )


def _tare(chains: Sequence[Calibration], notes: list[str], *, single: bool) -> list[Quantity]:
    """Return the uncertainty of a tare that all trials share."""
    tare_N = math.sqrt(_mean(chain.tare_std_N**2 for chain in chains))
    if single or len({chain.tare_N for chain in chains}) == 1:
        return [Quantity(name="tare", symbol="δ_0", unit="N", estimate=0.0, stated=tare_N)]
    notes.append(_OWN.format(what="tare", size_N=tare_N))
    return []


def _mean(values: Iterable[float]) -> float:
    numbers = [value for value in values if math.isfinite(value)]
    return math.fsum(numbers) / len(numbers) if numbers else 0.0
