"""The uncertainty of a measured force: what the measuring chain, the tare and the picking add to it.

Components follow GUM (JCGM 100): limits of error count as rectangular distributions, standard uncertainties
add as squares. All are of the force itself, so every sensitivity is 1. The end tension F_B hangs from dead
weights, not from this chain; `end_tension_std_N` serves it.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.traces.calibration import Calibration

SCHEMA = "ropefric.budget/1"
_RECTANGULAR = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Component:
    """One line of an uncertainty budget."""

    name: str
    estimate_N: float
    standard_uncertainty_N: float
    type: Literal["A", "B"]
    distribution: Literal["rectangular", "normal"]
    divisor: float
    sensitivity: float = 1.0
    dof: float = math.inf
    assumed: str = ""

    @property
    def contribution_N(self) -> float:
        """Return |sensitivity| times standard uncertainty [N]."""
        return abs(self.sensitivity) * self.standard_uncertainty_N


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorBudget:
    """What makes up the uncertainty of one force."""

    force_N: float
    components: tuple[Component, ...]

    @property
    def combined_N(self) -> float:
        """Return the combined standard uncertainty [N]: root of the sum of squared contributions."""
        return math.hypot(*(component.contribution_N for component in self.components))

    @property
    def worst_case_N(self) -> float:
        """Return the sum of all limits of error [N], as data sheets add them; normal components have none."""
        return math.fsum(c.estimate_N for c in self.components if c.distribution == "rectangular")

    @property
    def effective_dof(self) -> float:
        """Return the effective degrees of freedom, Welch-Satterthwaite (GUM G.2b); infinite if all are."""
        parts = (c.contribution_N**4 / c.dof for c in self.components if c.dof > 0)
        total = math.fsum(parts)
        return self.combined_N**4 / total if total > 0 else math.inf

    def to_dict(self) -> dict[str, Any]:
        """Return the budget as JSON-able values; infinite degrees of freedom are None."""
        lines = [asdict(c) | {"dof": c.dof if math.isfinite(c.dof) else None} for c in self.components]
        dof = self.effective_dof
        return {
            "schema": SCHEMA,
            "force_N": self.force_N,
            "components": lines,
            "combined_N": self.combined_N,
            "worst_case_N": self.worst_case_N,
            "effective_dof": dof if math.isfinite(dof) else None,
        }


def _limit(name: str, limit_N: float, assumed: str = "") -> Component:
    return Component(
        name=name,
        estimate_N=limit_N,
        standard_uncertainty_N=limit_N / _RECTANGULAR,
        type="B",
        distribution="rectangular",
        divisor=_RECTANGULAR,
        assumed=assumed,
    )


def _normal(name: str, std_N: float, *, dof: float = math.inf) -> Component:
    return Component(
        name=name,
        estimate_N=std_N,
        standard_uncertainty_N=std_N,
        type="A",
        distribution="normal",
        divisor=1.0,
        dof=dof,
    )


def _chain(calibration: Calibration) -> Iterator[Component]:
    """Give the components that are the same at every force."""
    cell = calibration.cell
    for name in ("linearity", "hysteresis", "repeatability", "transmitter"):
        key = f"cells.{cell.name}.{name}" if name in cell.assumed else ""
        yield _limit(name, getattr(cell, name) * cell.full_scale_N, key)
    # Half a count, u = LSB/√12. Averaging reduces it only where noise dithers the converter, and a peak is
    # no place to rely on that: it stays whole.
    yield _limit("quantisation", calibration.lsb_N / 2.0)


def _line_std_N(force_N: FloatArray, calibration: Calibration) -> FloatArray:
    """Return the standard uncertainty of a reading by the calibration line, s √(1 + 1/n + (F − F̄)²/S)."""
    line = calibration.cell.line
    if line.n < 3:
        return np.zeros_like(force_N)
    # The line saw the rope rig's untared reading, not the force after the tare.
    distance_N = force_N + calibration.tare_N - line.mean_N
    std_N: FloatArray = line.scatter_N * np.sqrt(1.0 + 1.0 / line.n + distance_N**2 / line.spread_N2)
    return std_N


def force_budget(
    force_N: float,
    calibration: Calibration | None,
    *,
    picking_std_N: float = 0.0,
    tare_std_N: float | None = None,
) -> ErrorBudget:
    """Return the uncertainty budget of one break-away force.

    Linearity, hysteresis, repeatability, transmitter: limits as fractions of full scale, divisor √3.
    Quantisation: LSB/√12, not reduced by smoothing. Calibration line: scatter of three or more calibration
    points about it, n − 2 degrees of freedom; two points tell nothing of it. Tare and picking: as given.
    """
    if not math.isfinite(force_N):
        raise InputError(f"no budget for a force of {force_N} N", code="RF214", key="force_N")
    if tare_std_N is None:
        tare_std_N = calibration.tare_std_N if calibration else 0.0
    _check_std("tare_std_N", tare_std_N)
    _check_std("picking_std_N", picking_std_N)
    components: list[Component] = []
    if calibration is not None:
        components += _chain(calibration)
        if calibration.cell.line.n:
            std_N = float(_line_std_N(np.array([force_N]), calibration)[0])
            components.append(_normal("calibration line", std_N, dof=calibration.cell.line.dof))
    components += [_normal("tare", float(tare_std_N)), _normal("picking", float(picking_std_N))]
    return ErrorBudget(force_N=float(force_N), components=tuple(components))


def combined_std_N(
    force_N: npt.ArrayLike,
    calibration: Calibration | None,
    *,
    picking_std_N: npt.ArrayLike = 0.0,
    tare_std_N: npt.ArrayLike | None = None,
) -> FloatArray:
    """Return the combined standard uncertainty [N] of many forces: `force_budget(...).combined_N` for each."""
    force_N = np.atleast_1d(np.asarray(force_N, dtype=np.float64))
    present = np.isfinite(force_N)
    if tare_std_N is None:
        tare_std_N = calibration.tare_std_N if calibration else 0.0
    squares_N2 = np.zeros_like(force_N)
    for name, given in (("tare_std_N", tare_std_N), ("picking_std_N", picking_std_N)):
        std_N = np.asarray(given, dtype=np.float64)
        if std_N.ndim and std_N.shape != force_N.shape:
            raise InputError(
                f"{std_N.size} values of {name} for {force_N.size} forces", code="RF214", key=name
            )
        std_N = np.broadcast_to(std_N, force_N.shape)
        for value in std_N[present & ~((std_N >= 0) & np.isfinite(std_N))][:1]:
            _check_std(name, float(value))
        squares_N2 = squares_N2 + np.where(present, std_N, 0.0) ** 2
    if calibration is not None:
        squares_N2 += math.fsum(component.contribution_N**2 for component in _chain(calibration))
        squares_N2 += _line_std_N(force_N, calibration) ** 2
    return np.where(present, np.sqrt(squares_N2), np.nan)


def end_tension_std_N(end_tension_N: float, weights: float = 0.0005) -> float:
    """Return the standard uncertainty [N] of an end tension made by dead weights, F_B·weights/√3."""
    _check_std("end_tension_N", end_tension_N)
    _check_std("weights", weights)
    return float(end_tension_N) * weights / _RECTANGULAR


def _check_std(name: str, value: float) -> None:
    if not (math.isfinite(value) and value >= 0):
        raise InputError(f"{name} = {value:g} is not a finite number from 0", code="RF214", key=name)
