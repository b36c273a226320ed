"""What moves a press from outside, as functions of time: the drive, the loads, the square of the speed."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial, common_pieces

Loads = Literal["with-speed", "constant"] | PiecewisePolynomial

ONE, LOAD, SPEED, ACCELERATION, SPEED_SQUARED, FIRST_DRIVER = range(6)
"""Places of the inputs: 1, the factor on all loads, v, dv/dt, v²; then shift and its two derivatives per driver."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inputs:
    """Inputs u(t) of a press, polynomials on common pieces."""

    starts_s: FloatArray
    taylor: FloatArray

    def at(self, time_s: FloatArray) -> FloatArray:
        """Return u at sorted times, shape (n, n_inputs); at a jump the value after it."""
        piece = np.searchsorted(self.starts_s, time_s, side="right") - 1
        tau = np.asarray(time_s - self.starts_s[piece])
        value = np.zeros((*tau.shape, self.taylor.shape[1]))
        for order in reversed(range(self.taylor.shape[2])):
            value = self.taylor[piece, :, order] + value * (tau / (order + 1.0))[..., None]
        return value


def press_inputs(model: ElasticPress, speed: PiecewisePolynomial, loads: Loads) -> Inputs:
    """Return the inputs of a press."""
    if isinstance(loads, PiecewisePolynomial):
        factor = loads
    elif loads == "with-speed":
        if speed.final <= 0.0:
            raise InputError("loads 'with-speed' need a drive that ends with a positive speed", key="loads")
        factor = speed.times(1.0 / speed.final)
    elif loads == "constant":
        factor = PiecewisePolynomial.of([0.0], [[1.0]])
    else:
        raise InputError(
            f"loads = '{loads}' is unknown", key="loads", fix="with-speed, constant, or a function"
        )
    one = PiecewisePolynomial.of([0.0], [[1.0]])
    functions = [one, factor, speed, speed.derivative(), speed.squared()]
    for extra in model.overspeed - model.overspeed[0]:
        own = speed.times(float(extra))
        functions += [own.integral(), own, own.derivative()]
    starts_s, taylor = common_pieces(functions)
    return Inputs(starts_s=starts_s, taylor=taylor)
