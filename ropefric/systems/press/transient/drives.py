"""Drives of a press: ways to bring it to its speed, and all inputs as polynomials on common pieces."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PPoly

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.checks import checked


def piecewise(starts_s: Sequence[float] | FloatArray, coefficients: npt.ArrayLike) -> PPoly:
    """Return the function Σ c_j (t − t_i)^j on each piece; the first starts at 0, the last never ends."""
    rows = np.array(coefficients, dtype=np.float64)
    return PPoly(rows.T[::-1], np.append(starts_s, 2.0 * starts_s[-1] + 1.0))


def final_value(function: PPoly) -> float:
    """Return the constant that a function ends with."""
    return float(function.c[-1, -1])


def _constant(*, speed_m_s: float) -> PPoly:
    """Return full speed from the first moment, while the rest of the machine is still at rest."""
    return piecewise([0.0], [[float(checked("speed_m_s", speed_m_s))]])


def _ramp(*, speed_m_s: float, duration_s: float) -> PPoly:
    """Return constant acceleration; it jumps at both ends of the ramp."""
    final, duration = float(checked("speed_m_s", speed_m_s)), float(checked("duration_s", duration_s))
    return piecewise([0.0, duration], [[0.0, final / duration], [final, 0.0]])


def _s_curve(*, speed_m_s: float, duration_s: float) -> PPoly:
    """Return a smooth rise whose acceleration starts and ends at zero; its greatest is 1.5 times the mean."""
    final, duration = float(checked("speed_m_s", speed_m_s)), float(checked("duration_s", duration_s))
    rise = [0.0, 0.0, 3.0 * final / duration**2, -2.0 * final / duration**3]
    return piecewise([0.0, duration], [rise, [final, 0.0, 0.0, 0.0]])


def _table(*, time_s: npt.ArrayLike, speed_m_s: npt.ArrayLike) -> PPoly:
    """Return speeds at given times with straight lines between them; after the last one the speed stays."""
    times, speeds = np.asarray(time_s, dtype=np.float64), np.asarray(speed_m_s, dtype=np.float64)
    if times.ndim != 1 or times.shape != speeds.shape or not times.size:
        raise InputError(
            f"the table has {times.size} times and {speeds.size} speeds",
            key="time_s",
            fix="give one speed for each time",
        )
    if times[0] != 0.0 or (np.diff(times) <= 0.0).any() or not np.isfinite(times).all():
        raise InputError("the times of the table must start at 0 s and rise", key="time_s")
    checked("speed_m_s", speeds, "zero or more")
    slopes = np.append(np.diff(speeds) / np.diff(times), 0.0)
    return piecewise(times, np.column_stack([speeds, slopes]))


DRIVE_LAWS: dict[str, Callable[..., PPoly]] = {
    "constant": _constant,
    "ramp": _ramp,
    "s-curve": _s_curve,
    "table": _table,
}
"""Ways to run up; position and acceleration follow from the speed exactly."""

Loads = Literal["with-speed", "constant"]

ONE, LOAD, SPEED, ACCELERATION, SPEED_SQUARED, FIRST_DRIVER = range(6)
"""Places of the inputs: 1, the factor on all loads, v, dv/dt, v²; then shift and its two derivatives per driver."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inputs:
    """Inputs u(t) of a press, by their Taylor coefficients on common pieces, shape (n_pieces, n_inputs, n_orders)."""

    starts_s: FloatArray
    taylor: FloatArray

    def at(self, time_s: npt.ArrayLike, piece: int | None = None) -> FloatArray:
        """Return u, shape (..., n_inputs); at a jump the value after it, unless a piece is named."""
        time = np.asarray(time_s, dtype=np.float64)
        place = np.searchsorted(self.starts_s, time, side="right") - 1 if piece is None else piece
        tau = np.asarray(time - self.starts_s[place])[..., None]
        value = np.zeros(1)
        for order in reversed(range(self.taylor.shape[2])):
            value = self.taylor[place, :, order] + value * (tau / (order + 1.0))
        return value


def press_inputs(overspeed: FloatArray, speed: PPoly, loads: Loads) -> Inputs:
    """Return the inputs of a press whose drivers run ahead of the drive by some share each."""
    one = piecewise([0.0], [[1.0]])
    if loads == "with-speed" and final_value(speed) <= 0.0:
        raise InputError("loads 'with-speed' need a drive that ends with a positive speed", key="loads")
    factor = one if loads == "constant" else PPoly(speed.c / final_value(speed), speed.x)
    squared = PPoly(np.array([np.convolve(row, row) for row in speed.c.T]).T, speed.x)
    functions = [one, factor, speed, speed.derivative(), squared]
    for extra in overspeed - overspeed[0]:
        own = PPoly(extra * speed.c, speed.x)
        functions += [own.antiderivative(), own, own.derivative()]
    return common_pieces(functions)


def common_pieces(functions: Sequence[PPoly]) -> Inputs:
    """Return functions by their Taylor coefficients on pieces on which all of them are polynomials."""
    starts = np.unique(np.concatenate([function.x[:-1] for function in functions]))
    orders = range(max(len(function.c) for function in functions))
    taylor = [[function(starts, order) for order in orders] for function in functions]
    return Inputs(starts_s=starts, taylor=np.moveaxis(np.array(taylor), 2, 0))
