"""What the measuring chain adds to the uncertainty of a measured force, as quantities of a budget.

Limits of error count as flat distributions (JCGM 100, 4.3.7), and all are of the force itself, so every sensitivity
is 1. The end tension F_B hangs from dead weights, not from this chain; `end_tension_std_N` serves it.
"""

import math

from ropefric.traces.calibration import Calibration
from ropefric.uncertainty.quantity import Quantity, limit_of_error

_LIMITS = {
    "linearity": ("linearity", "δ_lin"),
    "hysteresis": ("hysteresis", "δ_hys"),
    "repeatability": ("cell's repeatability", "δ_rep"),
    "transmitter": ("transmitter", "δ_tr"),
}


def chain_quantities(force_N: float, calibration: Calibration) -> tuple[Quantity, ...]:
    """Return what a chain leaves uncertain of one of its forces, corrections of zero that are not made.

    Linearity, hysteresis, repeatability, transmitter: limits as fractions of full scale. Calibration line: the scatter
    of three or more calibration points about it, n − 2 degrees of freedom; two points tell nothing of it.
    """
    cell, line = calibration.cell, calibration.cell.line
    found = []
    for key, (name, symbol) in _LIMITS.items():
        assumed = f"cells.{cell.name}.{key}" if key in cell.assumed else ""
        limit_N = getattr(cell, key) * cell.full_scale_N
        found.append(limit_of_error(name, symbol, "N", limit_N, assumed=assumed))
    # Half a count, u = LSB/√12. Averaging reduces it only where noise dithers the converter, and a peak is
    # no place to rely on that: it stays whole.
    found.append(
        Quantity(
            name="resolution",
            symbol="δ_q",
            unit="N",
            estimate=0.0,
            stated=calibration.lsb_N,
            divisor=math.sqrt(12.0),
            distribution="rectangular",
        )
    )
    if line.n:
        std_N, dof = 0.0, math.inf
        if line.n > 2:
            # The line saw the rope rig's untared reading, not the force after the tare.
            distance_N = force_N + calibration.tare_N - line.mean_N
            std_N = line.scatter_N * math.sqrt(1.0 + 1.0 / line.n + distance_N**2 / line.squares_N2)
            dof = line.dof
        found.append(
            Quantity(
                name="calibration line",
                symbol="δ_cal",
                unit="N",
                estimate=0.0,
                stated=std_N,
                type="A",
                dof=dof,
            )
        )
    return tuple(found)


def cell_std_N(force_N: float, calibration: Calibration | None) -> float:
    """Return the part [N] of a force's standard uncertainty that all forces of its cell share; NaN without a chain.

    Linearity, hysteresis, transmitter and calibration line: what neither repeats nor other conditions average out.
    """
    if calibration is None:
        return math.nan
    own = ("cell's repeatability", "resolution")
    return math.hypot(*(item.std for item in chain_quantities(force_N, calibration) if item.name not in own))


def force_std_N(force_N: float, calibration: Calibration | None, *, picking_std_N: float = 0.0) -> float:
    """Return the standard uncertainty [N] of one force: its chain, its tare and the picking of its peak."""
    if calibration is None:
        return picking_std_N
    chain = (quantity.std for quantity in chain_quantities(force_N, calibration))
    return math.hypot(*chain, calibration.tare_std_N, picking_std_N)


def end_tension_std_N(end_tension_N: float, tolerance: float) -> float:
    """Return the standard uncertainty [N] of an end tension made by dead weights, F_B·tolerance/√3."""
    return limit_of_error("end tension", "F_B", "N", end_tension_N * tolerance).std
