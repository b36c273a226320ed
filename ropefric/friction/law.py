"""What a friction law is: one question (ln F_A for a condition), its gradient, and how far it may be trusted."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.parameter import Parameter, columns_of, vector_from
from ropefric.friction.physics import Columns, Physics, evaluated, reason, refusals_of

__all__ = ["FrictionLaw", "Parameter"]

_LEAST_WRAP_RAD = 1e-290


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionLaw:
    """A friction law of a rope on a wheel.

    Attributes
    ----------
    name : str
        The name in the registry.
    equation : str
        The law as printed.
    source : str
        Where it comes from.
    parameters : tuple of Parameter
        Its p parameters, in the order of every `theta`.
    coefficient : {"local", "average"}
        Whether its μ is the coefficient at a point or the mean over the wrap. They are different laws unless μ
        does not depend on the wrap angle.
    effects : frozenset of str
        What it can describe: "size", "wrap-dependence", "end-tension", "bending-stiffness", "offset", "groove".
    physics : Physics
        The formulae.
    start : callable
        `start(law, conditions, log_lift) -> (p,)`; use `guess`.
    variant : FrictionLaw, optional
        The same law without the equivalence of end tension and wrap, where it has one.

    Examples
    --------
    >>> from ropefric.friction.laws import LAWS
    >>> pull = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=10, end_tension_N=20)
    >>> float(LAWS["constant"].log_lift([0.2], pull)[0].round(4))
    4.9957
    """

    name: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    coefficient: Literal["local", "average"]
    effects: frozenset[str]
    physics: Physics
    start: "Callable[[FrictionLaw, Conditions, FloatArray], FloatArray]"
    variant: "FrictionLaw | None" = None

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Return the names of the parameters in the order of every `theta`."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def lower(self) -> FloatArray:
        """Return the lower bounds, shape (p,)."""
        return np.array([parameter.lower for parameter in self.parameters])

    @property
    def upper(self) -> FloatArray:
        """Return the upper bounds, shape (p,)."""
        return np.array([parameter.upper for parameter in self.parameters])

    def log_lift(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ln(F_A / 1 N) for every condition.

        Parameters
        ----------
        theta : array_like, shape (p,) or (m, p)
            One parameter set, or m of them.
        conditions : Conditions
            n conditions.

        Returns
        -------
        ndarray, shape (n,) or (m, n)
            ln(F_A / 1 N) [-], always finite; it may exceed 709, where the force itself overflows a float.

        Raises
        ------
        InputError
            If theta has the wrong shape or is not finite, or the law has no answer; the message names the first
            condition.
        """
        return conditions.log_end_tension + self._rise(theta, conditions)

    def jacobian(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ, analytically.

        Parameters and refusals are those of `log_lift`.

        Returns
        -------
        ndarray, shape (n, p) or (m, n, p)
            One column a parameter, in 1/(its unit).
        """
        columns = self._checked(theta, conditions)
        return evaluated(
            lambda: self.physics.rise_and_slopes(columns, conditions)[1], columns, conditions, self.name
        )

    def log_lift_and_jacobian(
        self, theta: npt.ArrayLike, conditions: Conditions
    ) -> tuple[FloatArray, FloatArray]:
        """Return `log_lift` and `jacobian`, what both need made once.

        Parameters and refusals are those of `log_lift`; where only the derivative is not finite, it is refused too.

        Returns
        -------
        tuple of ndarray, shapes (n,) and (n, p), or (m, n) and (m, n, p)
            The same numbers as of the two by themselves.

        Examples
        --------
        >>> from ropefric.friction.laws import LAWS
        >>> pull = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=10, end_tension_N=20)
        >>> log_lift, jacobian = LAWS["constant"].log_lift_and_jacobian([0.2], pull)
        >>> log_lift.round(4).tolist(), jacobian.tolist()
        ([4.9957], [[10.0]])
        """
        columns = self._checked(theta, conditions)

        def formula() -> tuple[FloatArray, ...]:
            rise, slopes = self.physics.rise_and_slopes(columns, conditions)
            return rise, *slopes

        table = evaluated(formula, columns, conditions, self.name)
        return conditions.log_end_tension + table[..., 0], table[..., 1:]

    def log_lift_gradient_conditions(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂(R_w, φ, ln F_B), analytically.

        Parameters and refusals are those of `log_lift`; ∂/∂φ does not exist where the local coefficient is
        infinite.

        Returns
        -------
        ndarray, shape (n, 3) or (m, n, 3)
            Columns in 1/m, 1/rad and [-].
        """
        columns = self._checked(theta, conditions)
        return evaluated(
            lambda: self.physics.condition_slopes(columns, conditions), columns, conditions, self.name
        )

    def local_mu(self, theta: npt.ArrayLike, wrap_rad: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return the local coefficient μ(φ) at an angle measured from the slack end.

        Parameters
        ----------
        theta : array_like, shape (p,) or (m, p)
            Parameters.
        wrap_rad : array_like, scalar or shape (n,)
            Where on the wheel [rad], counted from where the rope with F_B touches; zero or more.
        conditions : Conditions
            n conditions; their wrap angles are not used.

        Returns
        -------
        ndarray, shape (n,) or (m, n)
            μ [-].
        """
        angle = np.asarray(wrap_rad, dtype=np.float64)
        if not (np.isfinite(angle) & (angle >= 0.0)).all():
            raise InputError(f"wrap_rad must be finite and zero or more, got {angle.min():g}", key="wrap_rad")
        columns = self._checked(theta, conditions)
        table = evaluated(
            lambda: (self.physics.local_mu(columns, angle, conditions),), columns, conditions, self.name
        )
        return table[..., 0]

    def average_mu(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return the average coefficient μ̄ = (ln F_A − ln F_B)/φ, eq. (2).

        Raises
        ------
        InputError
            As `log_lift`, and where the wrap angle is below 1e-290 rad: the average over nothing does not exist.
        """
        if (conditions.wrap_angle_rad < _LEAST_WRAP_RAD).any():
            first = int(np.argmin(conditions.wrap_angle_rad))
            raise InputError(
                f"{self.name}: no average coefficient over a wrap of zero at {conditions.describe(first)}",
                key="wrap_angle_rad",
                fix="leave out the conditions with zero wrap",
            )
        return self._rise(theta, conditions, per=conditions.wrap_angle_rad)

    def guess(self, conditions: Conditions, log_lift: npt.ArrayLike) -> FloatArray:
        """Return parameters to start a fit from, inside the bounds.

        Parameters
        ----------
        conditions : Conditions
            n conditions.
        log_lift : array_like, shape (n,)
            Measured ln(F_A / 1 N).

        Returns
        -------
        ndarray, shape (p,)
            The start; the parameters' typical values where no number of the data leads to a better one.
        """
        data = np.asarray(log_lift, dtype=np.float64)
        if data.shape != (len(conditions),) or not np.isfinite(data).all():
            raise InputError(
                f"{self.name}: {data.shape} finite values of ln F_A are needed for {len(conditions)} conditions",
                key="log_lift",
            )
        start = self.start(self, conditions, data)
        return np.clip(start, self.lower, self.upper)

    def validity(self, theta: npt.ArrayLike, conditions: Conditions) -> tuple[str, ...]:
        """Return why the law has no answer for some of the conditions; empty where it has one for all."""
        columns = self._columns(theta)
        return tuple(
            reason(refusal, conditions) for refusal in refusals_of(self.physics, columns, conditions)
        )

    def admissible(self, theta: npt.ArrayLike, conditions: Conditions) -> BoolArray:
        """Return which parameter sets have an answer for every condition, shape () or (m,).

        A fit that tries many sets at once uses this to turn down a step without an exception.
        """
        columns = self._columns(theta)
        bad = np.zeros((*columns[0].shape[:-1], len(conditions)), dtype=bool)
        for refusal in refusals_of(self.physics, columns, conditions):
            bad |= refusal.mask
        return np.asarray(~bad.any(axis=-1))

    def theta_from(self, mapping: Mapping[str, float]) -> FloatArray:
        """Return theta, shape (p,), from named parameters; a fixed parameter may be left out.

        Raises
        ------
        UnknownNameError
            For a name the law does not have.
        InputError
            For a parameter that is missing.
        """
        return vector_from(mapping, self.parameters, self.name)

    def as_mapping(self, theta: npt.ArrayLike) -> dict[str, float]:
        """Return one parameter set, shape (p,), as a mapping from name to value.

        Examples
        --------
        >>> from ropefric.friction.laws import LAWS
        >>> LAWS["wrap-power"].as_mapping([0.2, -0.5, 0.1])
        {'a': 0.2, 'b': -0.5, 'c': 0.1}
        """
        return {
            name: float(column)
            for name, column in zip(self.parameter_names, self._columns(theta), strict=True)
        }

    def without_end_tension(self) -> "FrictionLaw":
        """Return the law with the wrap counted from zero whatever the end tension, under its own name.

        Raises
        ------
        InputError
            If end tension and wrap are not coupled in this law.
        """
        if self.variant is None:
            raise InputError(f"{self.name} does not count an end tension as wrap", fix="use it as it is")
        return self.variant

    def _rise(
        self, theta: npt.ArrayLike, conditions: Conditions, per: FloatArray | float = 1.0
    ) -> FloatArray:
        columns = self._checked(theta, conditions)
        return evaluated(
            lambda: (self.physics.rise(columns, conditions) / per,), columns, conditions, self.name
        )[..., 0]

    def _columns(self, theta: npt.ArrayLike) -> Columns:
        return columns_of(theta, self.parameter_names, self.name)

    def _checked(self, theta: npt.ArrayLike, conditions: Conditions) -> Columns:
        columns = self._columns(theta)
        for refusal in refusals_of(self.physics, columns, conditions):
            raise InputError(f"{self.name}: {reason(refusal, conditions)}", code="RF420", fix=refusal.fix)
        return columns
