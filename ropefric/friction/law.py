"""Friction laws: ln F_A for a condition, its gradient, and its range of validity."""

import math
import re
from collections import UserDict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.registry import did_you_mean

Columns = tuple[FloatArray, ...]
"""The parameters one by one: each of shape () for one parameter set, or (m, 1) for m sets."""

Slopes = tuple[FloatArray, ...]
"""Derivatives, each of which broadcasts to what it is a derivative of."""

FROM_ZERO = "use the form of the law that counts the wrap from zero, whose name ends in -from-zero"
"""Fix where no wrap angle is equivalent to an end tension."""

_LEAST_WRAP_RAD = 1e-290
_DIGITS = 9
_FUNCTIONS = {"ln": math.log, "exp": math.exp, "sqrt": math.sqrt, "sin": math.sin, "acos": math.acos}
_NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a law: its name, unit, typical value, bounds and meaning; a fixed one is not fitted."""

    name: str
    unit: str
    start: float
    lower: float
    upper: float
    meaning: str
    fixed: bool = False


class Refusal(NamedTuple):
    """Where a law has no answer, the numbers it is refused for, why (`{value}` is the first of them), and a way out."""

    mask: npt.ArrayLike
    values: FloatArray
    what: str
    fix: str

    def words(self, conditions: Conditions) -> str:
        """Return the refusal in words, with the first condition it concerns."""
        mask, values = np.broadcast_arrays(np.atleast_1d(self.mask), self.values)
        where = np.argwhere(mask)[0]
        condition = int(where[-1]) if mask.shape[-1] == len(conditions) else 0
        parameter_set = f", parameter set {where[0]}" if mask.ndim > 1 and mask.shape[0] > 1 else ""
        text = self.what.format(value=f"{values[tuple(where)]:.6g}")
        return f"{text} at {conditions.describe(condition)}{parameter_set}"


def negative(values: FloatArray, what: str, fix: str = "keep it at zero or more") -> Refusal:
    """Return the refusal of numbers below zero."""
    return Refusal(values < 0.0, values, what, fix)


def below_reference(conditions: Conditions) -> Refusal:
    """Return the refusal of end tensions below F_0 = 1 N, for laws that count the end tension as wrap."""
    F_B = conditions.end_tension_N
    what = "F_B = {value} N is below F_0 = 1 N, so no wrap angle is equivalent to it"
    return Refusal(F_B < 1.0, F_B, what, f"leave it out, or {FROM_ZERO}")


class Sheet(UserDict[str, float]):
    """A calculation by hand: its lines so far, the numbers in them by symbol, as printed, and the effects of the law.

    Each line is worked out from the rounded numbers printed above it, as a person would, so every line is right to its
    last digits.
    """

    def __init__(self, effects: frozenset[str] = frozenset()) -> None:
        super().__init__()
        self.lines: list[str] = []
        self.effects = effects

    def __setitem__(self, symbol: str, value: float) -> None:
        super().__setitem__(symbol, float(f"{value:.{_DIGITS}g}"))

    def say(self, text: str) -> None:
        """Write a line without arithmetic."""
        self.lines.append(text)

    def given(self, symbol: str, value: float, name: str = "") -> None:
        """Write a number that is not worked out here, and keep it under its symbol."""
        self[symbol] = value
        self.lines.append(f"{name or symbol}: {self._printed(symbol)}")

    def line(self, name: str, formula: str, symbol: str = "") -> float:
        """Write `name = arithmetic = value`, keep the value under the symbol, else the name, and return it.

        The formula is written in the symbols of the sheet, + - * / ^ ( ) and `ln`, `exp`, `sqrt`, `sin`, `acos`.
        """
        key = symbol or name
        shown = _NAME.sub(lambda found: self._printed(found[0]) if found[0] in self else found[0], formula)
        # Ours, not a user's text: a law declares it.
        self[key] = eval(formula.replace("^", "**"), _FUNCTIONS | self.data)  # noqa: S307
        self.lines.append(f"{name} = {shown} = {self._printed(key)}")
        return self[key]

    def _printed(self, symbol: str) -> str:
        """Return a number for the sheet; a negative one in brackets."""
        text = f"{self[symbol]:.{_DIGITS}g}"
        return f"({text})" if self[symbol] < 0.0 else text


class Physics(Protocol):
    """The formulae behind a law, on parameter columns that broadcast against the n conditions."""

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return ln F_A − ln F_B, shape (n,) or (m, n)."""
        ...

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return the rise and its derivative by each parameter, what both need made once.

        The rise is that of `rise` to the last bit, and each slope broadcasts to it.
        """
        ...

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return the derivative of ln F_A by R_w, φ and ln F_B; each broadcasts to the rise."""
        ...

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Return where there is no answer."""
        ...


def combinations(*axes: npt.ArrayLike) -> FloatArray:
    """Return every combination of one value from each axis, shape (m, number of axes)."""
    grid = np.meshgrid(*(np.asarray(axis, dtype=np.float64) for axis in axes), indexing="ij")
    return np.stack([values.ravel() for values in grid], axis=-1)


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
    candidates : callable
        `candidates(mu, conditions, log_lift) -> (m, p)`: parameter sets to start a fit from, to measured
        ln F_A, whose median average coefficient is mu.
    special_cases : tuple of FrictionLaw
        Simpler laws that are special or limiting cases of it: a comparison tests it against them.
    arithmetic : callable, optional
        `arithmetic(sheet) -> value`: writes ln(F_A/F_B) as lines a pocket calculator can follow, see `Sheet`.
    weakens : bool
        Whether for parameters within their bounds bounds of error may rest on this: ln(F_A/F_B) is concave in the wrap
        and not negative at none, falls with ln F_B by no more than ln F_B rises, and over the wrap is monotone in each
        of the condition's numbers by itself.
    variant : FrictionLaw, optional
        The same law without the equivalence of end tension and wrap, where it has one; see `with_variant`.

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
    candidates: Callable[[float, Conditions, FloatArray], npt.ArrayLike]
    special_cases: "tuple[FrictionLaw, ...]" = ()
    arithmetic: Callable[[Sheet], float] | None = None
    weakens: bool = False
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
        rise = self._table(theta, conditions, lambda columns: (self.physics.rise(columns, conditions),))
        return conditions.log_end_tension + rise[..., 0]

    def jacobian(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ, analytically.

        Parameters and refusals are those of `log_lift`.

        Returns
        -------
        ndarray, shape (n, p) or (m, n, p)
            One column a parameter, in 1/(its unit).
        """
        return self.log_lift_and_jacobian(theta, conditions)[1]

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

        def formula(columns: Columns) -> tuple[FloatArray, ...]:
            rise, slopes = self.physics.rise_and_slopes(columns, conditions)
            return rise, *slopes

        table = self._table(theta, conditions, formula)
        return conditions.log_end_tension + table[..., 0], table[..., 1:]

    def log_lift_gradient_conditions(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂(R_w, φ, ln F_B), analytically.

        Parameters and refusals are those of `log_lift`; ∂/∂φ is the local coefficient μ where the wrap ends, and does
        not exist where that is infinite.

        Returns
        -------
        ndarray, shape (n, 3) or (m, n, 3)
            Columns in 1/m, 1/rad and [-].
        """
        slopes = self.physics.condition_slopes
        return self._table(theta, conditions, lambda columns: slopes(columns, conditions))

    def average_mu(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return the average coefficient μ̄ = (ln F_A − ln F_B)/φ, eq. (2).

        Raises
        ------
        InputError
            As `log_lift`, and where the wrap angle is below 1e-290 rad: the average over nothing does not exist.
        """
        if (conditions.wrap_angle_rad < _LEAST_WRAP_RAD).any():
            first = int(np.argmin(conditions.wrap_angle_rad))
            what = f"{self.name}: no average coefficient over a wrap of zero at {conditions.describe(first)}"
            raise InputError(what, key="wrap_angle_rad", fix="leave out the conditions with zero wrap")
        wrap_rad = conditions.wrap_angle_rad
        rise = self.physics.rise
        return self._table(theta, conditions, lambda columns: (rise(columns, conditions) / wrap_rad,))[..., 0]

    def validity(self, theta: npt.ArrayLike, conditions: Conditions) -> tuple[str, ...]:
        """Return why the law has no answer for some of the conditions; empty where it has one for all."""
        return tuple(one.words(conditions) for one in self._refusals(self._columns(theta), conditions))

    def answers(self, theta: npt.ArrayLike, conditions: Conditions) -> BoolArray:
        """Return for which conditions the law has an answer, shape (n,) or (m, n)."""
        return self._answered(self._columns(theta), conditions)

    def admissible(self, theta: npt.ArrayLike, conditions: Conditions) -> BoolArray:
        """Return which parameter sets have an answer for every condition, shape () or (m,).

        A fit that tries many sets at once uses this to turn down a step without an exception.
        """
        return np.asarray(self.answers(theta, conditions).all(axis=-1))

    def rise_of_pairs(self, theta: FloatArray, conditions: Conditions) -> FloatArray:
        """Return ln(F_A/F_B) of m parameter sets, each at its own condition, shape (m,); NaN where it has none."""
        good = self._answered(tuple(theta.T), conditions)
        found = np.full(len(conditions), np.nan)
        if good.any():
            part = conditions.select(good)
            # Every number is looked at right after, so overflow need not be warned about.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                rise = self.physics.rise(tuple(theta[good].T), part)
            found[good] = np.where(np.isfinite(rise), rise, np.nan)
        return found

    def log_lift_of_pairs(self, theta: FloatArray, conditions: Conditions) -> FloatArray:
        """Return ln(F_A / 1 N) of m parameter sets, each at its own condition, shape (m,); NaN where there is no answer.

        `log_lift` gives every set at every condition, of which this is the diagonal.
        """
        return np.asarray(conditions.log_end_tension + self.rise_of_pairs(theta, conditions))

    def theta_from(self, mapping: Mapping[str, float]) -> FloatArray:
        """Return theta, shape (p,), from named parameters; a fixed parameter may be left out.

        Raises
        ------
        UnknownNameError
            For a name the law does not have.
        InputError
            For a parameter that is missing.
        """
        names = self.parameter_names
        for name in mapping:
            if name not in names:
                fix = did_you_mean(name, names)
                raise UnknownNameError(f"{self.name} has no parameter {name!r}", fix=fix)
        values = {parameter.name: parameter.start for parameter in self.parameters if parameter.fixed}
        values |= mapping
        missing = [name for name in names if name not in values]
        if missing:
            fix = f"it needs {', '.join(names)}"
            raise InputError(f"{self.name}: no value for {', '.join(missing)}", fix=fix)
        return np.array([float(values[name]) for name in names])

    def as_mapping(self, theta: npt.ArrayLike) -> dict[str, float]:
        """Return one parameter set, shape (p,), as a mapping from name to value.

        Examples
        --------
        >>> from ropefric.friction.laws import LAWS
        >>> LAWS["wrap-power"].as_mapping([0.2, -0.5, 0.1])
        {'a': 0.2, 'b': -0.5, 'c': 0.1}
        """
        return dict(zip(self.parameter_names, map(float, self._columns(theta)), strict=True))

    def calculation(self, theta: npt.ArrayLike, conditions: Conditions, index: int = 0) -> tuple[str, ...]:
        """Return the lift force of one condition as lines of arithmetic.

        Lines `name = arithmetic = value` use `ln`, `exp`, `sqrt`, `sin`, `acos`, `^` and the numbers above them; the
        others are words.
        """
        if self.arithmetic is None:
            fix = "declare its `arithmetic`, see FrictionLaw"
            raise InputError(f"there is no hand calculation for law {self.name}", fix=fix)
        at = conditions.select([index])
        sheet = Sheet(self.effects)
        sheet.say(f"law {self.name}: {self.equation}")
        for name, value in self.as_mapping(theta).items():
            sheet.given(name, value)
        for symbol, setting in zip(("R_w", "R_r", "phi", "F_B"), SETTINGS, strict=True):
            sheet.given(symbol, float(getattr(at, setting)[0]), f"{symbol} [{setting.rpartition('_')[2]}]")
        sheet.line("ln F_B", "ln(F_B)", "y")
        sheet["rise"] = self.arithmetic(sheet)
        log_lift = sheet.line("ln F_A", "y + rise", "log_lift")
        if log_lift > 700.0:
            raise InputError(f"ln F_A = {log_lift:g}: the force overflows a calculator", code="RF420")
        lift_N = sheet.line("F_A [N]", "exp(log_lift)")
        exact_N = math.exp(self.log_lift(theta, at)[0])
        sheet.say(f"at full precision F_A is {exact_N:.10g} N; by hand {lift_N:.10g} N")
        return tuple(sheet.lines)

    def _columns(self, theta: npt.ArrayLike) -> Columns:
        """Return theta, shape (p,) or (m, p), as p columns of shape () or (m, 1)."""
        try:
            array = np.asarray(theta, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{self.name}: theta is not an array of numbers", key="theta") from None
        p = len(self.parameters)
        if array.ndim not in {1, 2} or array.shape[-1] != p:
            why = f"{self.name}: theta has shape {array.shape}; it needs ({p},) or (m, {p})"
            fix = f"its parameters are {', '.join(self.parameter_names)}"
            raise InputError(why, key="theta", fix=fix)
        if not np.isfinite(array).all():
            why = f"{self.name}: a parameter is not finite"
            raise InputError(why, key="theta", fix="give finite numbers")
        return tuple(array[..., i] if array.ndim == 1 else array[:, i, np.newaxis] for i in range(p))

    def _answered(self, columns: Columns, conditions: Conditions) -> BoolArray:
        answered = np.ones(np.broadcast_shapes(columns[0].shape, (len(conditions),)), dtype=np.bool_)
        for refusal in self._refusals(columns, conditions):
            answered &= np.asarray(~np.asarray(refusal.mask))
        return answered

    def _refusals(self, columns: Columns, conditions: Conditions) -> list[Refusal]:
        """Return the refusals that concern any condition."""
        # Absurd parameters overflow on the way to being refused.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return [item for item in self.physics.refusals(columns, conditions) if np.any(item.mask)]

    def _table(
        self,
        theta: npt.ArrayLike,
        conditions: Conditions,
        formula: Callable[[Columns], tuple[FloatArray, ...]],
    ) -> FloatArray:
        """Return the parts of a formula side by side on a last axis, shape (n, k) or (m, n, k), all finite."""
        columns = self._columns(theta)
        for refusal in self._refusals(columns, conditions):
            raise InputError(f"{self.name}: {refusal.words(conditions)}", code="RF420", fix=refusal.fix)
        # Overflow is not warned about where it happens, because every number is looked at right after.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            parts = formula(columns)
        table = np.empty((*columns[0].shape[:-1], len(conditions), len(parts)))
        for i, part in enumerate(parts):
            table[..., i] = part
        wrong = ~np.isfinite(table)
        if wrong.any():
            condition = int(np.argwhere(wrong)[0][-2])
            why = f"{self.name}: no finite value at {conditions.describe(condition)}: the coefficient is infinite where "
            why += "the wrap starts from nothing, or a parameter is so large or small that floats overflow"
            fix = "ask at a wrap angle above zero, with parameters inside their bounds"
            raise InputError(why, code="RF420", fix=fix)
        return table


def with_variant(law: FrictionLaw) -> FrictionLaw:
    """Return a law that counts the end tension as wrap together with its own form that does not.

    Its physics is a dataclass with a field `equivalence`.
    """
    physics: Any = law.physics
    variant = replace(
        law,
        name=f"{law.name}-from-zero",
        equation=law.equation.replace("from phi0 to phi0 + phi", "from 0 to phi"),
        effects=law.effects - {"end-tension"},
        physics=replace(physics, equivalence=False),
        special_cases=tuple(case.variant or case for case in law.special_cases),
    )
    return replace(law, variant=variant)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiftModel:
    """A law and how fast its rope runs: ln F_A and its gradient, at rest or moving.

    The part ρv² of the tension only bends the rope's path and presses nothing. Friction sees F − ρv² everywhere, in
    the equivalence of end tension and wrap too: F_A − ρv² = (F_B − ρv²) exp ∫μ holds for every law.
    """

    law: FrictionLaw
    linear_density_kg_m: float = 0.0
    speed_m_s: float = 0.0

    def __post_init__(self) -> None:
        rho, v = self.linear_density_kg_m, self.speed_m_s
        if not (math.isfinite(rho) and math.isfinite(v) and rho >= 0.0):
            why = f"mass per length {rho:g} kg/m and speed {v:g} m/s must be finite and the mass zero or more"
            raise InputError(why, key="linear_density_kg_m")

    @property
    def inertia_N(self) -> float:
        """Return ρv² [N]."""
        speed_m_s = float(self.speed_m_s)
        return float(self.linear_density_kg_m) * (speed_m_s * speed_m_s)

    def log_lift(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ln(F_A / 1 N), shape (n,) or (m, n)."""
        pressing = self.law.log_lift(theta, self.pressing(conditions))
        return pressing if self.inertia_N == 0.0 else np.logaddexp(math.log(self.inertia_N), pressing)

    def jacobian(self, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ, shape (n, p) or (m, n, p); only F_A − ρv² depends on the parameters."""
        slopes = self.law.jacobian(theta, self.pressing(conditions))
        if self.inertia_N == 0.0:
            return slopes
        share = -np.expm1(math.log(self.inertia_N) - self.log_lift(theta, conditions))
        return np.asarray(slopes * share[..., np.newaxis])

    def pressing(self, conditions: Conditions) -> Conditions:
        """Return the conditions with F_B − ρv², the part of the end tension that presses on the wheel."""
        if self.inertia_N == 0.0:
            return conditions
        left_N = conditions.end_tension_N - self.inertia_N
        if not (left_N > 0.0).all():
            where = conditions.describe(int(np.argmin(left_N)))
            why = (
                f"rho v^2 = {self.inertia_N:.6g} N is not below F_B at {where}: the rope lifts off the wheel"
            )
            raise InputError(why, code="RF420", fix="raise the end tension or lower the speed")
        return replace(conditions, end_tension_N=left_N)
