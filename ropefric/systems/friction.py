"""The friction of a machine: a law, its reference condition, and the regressors that it gets from a contact."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.law import FrictionLaw

EVERYTHING = frozenset({"wrap", "end-tension", "size"})
"""Regressors of a law: wrap, end tension, size."""
_REGRESSOR_OF = {"wrap-dependence": "wrap", "end-tension": "end-tension", "size": "size"}


def own_regressors(effects: Collection[str]) -> frozenset[str]:
    """Return the regressors behind a law's own effects, one each."""
    return frozenset(regressor for name, regressor in _REGRESSOR_OF.items() if name in effects)


def regressors_of(effects: Collection[str]) -> frozenset[str]:
    """Return the regressors that a law gets with these effects of a machine whose tension goes with the wrap."""
    more = {"end-tension"} if "wrap-dependence" in effects else set()
    return own_regressors({*effects} - {"end-tension"} | more)


class ScaleTo(NamedTuple):
    """A coefficient that a law is scaled to, and the wrap over which it then has it at its reference."""

    mu: float
    wrap_angle_rad: float


@dataclass(frozen=True, kw_only=True, eq=False)
class WrapFriction:
    """A friction law with parameters, as a machine uses it: one set, or one for each of n cases, shape (n, p)."""

    law: FrictionLaw
    theta: FloatArray
    reference: Conditions
    scale_to: ScaleTo | None = None

    @classmethod
    def constant(cls, mu: float) -> "WrapFriction":
        """Return a coefficient that is the same everywhere."""
        from ropefric.friction.laws import LAWS  # noqa: PLC0415  (thirty laws, for callers that bring none)

        anywhere = one_condition(1.0, 0.1, np.pi, 100.0)
        return cls(law=LAWS["constant"], theta=np.array([mu], dtype=np.float64), reference=anywhere)

    @property
    def follows_tension(self) -> bool:
        """Return whether the coefficient depends on the tension of the slack side."""
        return not self.law.effects.isdisjoint({"wrap-dependence", "end-tension", "offset"})

    @cached_property
    def scale(self) -> FloatArray:
        """Return the factor on every coefficient of the law, shape () or (n,); 1 unless it is scaled."""
        if self.scale_to is None:
            return np.array(1.0)
        at = replace(self.reference, wrap_angle_rad=np.array([self.scale_to.wrap_angle_rad]))
        own = self.law.average_mu(self.theta, at)[..., 0]
        if not (own > 0.0).all():
            raise InputError(
                f"{self.law.name} gives the coefficient {own.min():g} at the reference; it cannot be scaled to "
                f"{self.scale_to.mu:g}",
                fix="check the law's parameters",
            )
        return np.asarray(self.scale_to.mu / own)

    def exponent(
        self,
        wheel_radius_m: npt.ArrayLike,
        rope_radius_m: npt.ArrayLike,
        wrap_angle_rad: npt.ArrayLike,
        slack_tension_N: npt.ArrayLike,
        *,
        regressors: frozenset[str] = EVERYTHING,
        places: int = 0,
    ) -> FloatArray:
        """Return M = ∫μ dφ over the wrap, the logarithm of the greatest tension ratio, eq. (17).

        Where each case has parameters of its own, the cases lie along the axis before the last `places`.
        """
        given = (wheel_radius_m, rope_radius_m, wrap_angle_rad, slack_tension_N)
        arrays = {name: np.asarray(one, dtype=np.float64) for name, one in zip(_OWNER, given, strict=True)}
        shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
        if self.law.weakens:  # what such a law cannot describe it does not look at
            regressors = regressors & own_regressors(self.law.effects)
        # What the law gets to see of the contacts, on one axis; over a wrap of zero no coefficient is needed.
        seen = {
            name: array if _OWNER[name] in regressors else getattr(self.reference, name)
            for name, array in arrays.items()
        }
        seen["wrap_angle_rad"] = np.where(seen["wrap_angle_rad"] == 0.0, 1.0, seen["wrap_angle_rad"])
        own = [one.reshape(-1, *(1,) * places) for one in self.theta.T] if self.theta.ndim > 1 else []
        spread = np.broadcast_arrays(*seen.values(), *own)
        flat = [one.ravel() for one in spread]
        contacts = Conditions(**dict(zip(arrays, flat, strict=False)))
        if own:
            average = self._average_of_pairs(
                np.stack(flat[len(arrays) :], axis=-1), contacts, spread[0].shape, places
            )
            coefficient = self.scale.reshape(-1, *(1,) * places) * average
        else:
            coefficient = self.scale * self.law.average_mu(self.theta, contacts).reshape(spread[0].shape)
        negative = coefficient < 0.0
        if negative.any():
            raise InputError(
                f"{self.law.name} gives the negative coefficient {coefficient.min():.4g} where the machine uses it",
                code="RF420",
                fix="keep to wheels, wraps and tensions near those the law was fitted to",
                cases=_of_cases(negative, places),
            )
        if coefficient.size == 1:
            coefficient = coefficient.reshape(())
        return np.broadcast_to(
            coefficient * arrays["wrap_angle_rad"], np.broadcast_shapes(shape, coefficient.shape)
        )

    def _average_of_pairs(
        self, theta: FloatArray, contacts: Conditions, shape: tuple[int, ...], places: int
    ) -> FloatArray:
        """Return the average coefficient of m parameter sets, each at its own contact, in this shape of m numbers."""
        rise = self.law.rise_of_pairs(theta, contacts)
        wrong = np.isnan(rise)
        if wrong.any():
            at = contacts.select(np.flatnonzero(wrong)[:1])
            first = theta[wrong][0]
            reasons = (*self.law.validity(first, at), f"no finite value at {at.describe(0)}")
            given = ", ".join(f"{name} = {value:g}" for name, value in self.law.as_mapping(first).items())
            raise InputError(
                f"{self.law.name} with {given}: {reasons[0]}",
                code="RF420",
                fix="keep to parameters and machines near those that were tested",
                cases=_of_cases(wrong.reshape(shape), places),
            )
        return np.asarray((rise / contacts.wrap_angle_rad).reshape(shape))

    def has_answer(self, contacts: Conditions) -> BoolArray:
        """Return for which of n contacts in their valid range `exponent` has an answer, shape (n,)."""
        if self.theta.ndim > 1:
            return np.isfinite(self.law.rise_of_pairs(self.theta, contacts))
        return self.law.answers(self.theta, contacts)


_OWNER = {
    "wheel_radius_m": "size",
    "rope_radius_m": "size",
    "wrap_angle_rad": "wrap",
    "end_tension_N": "end-tension",
}


def _of_cases(wrong: BoolArray, places: int) -> BoolArray:
    """Return in which cases anything is wrong; they lie along the axis before the last `places`."""
    own = wrong.ndim - 1 - places
    return np.asarray(wrong.any(axis=tuple(axis for axis in range(wrong.ndim) if axis != own)))


_LARGEST_EXPONENT = 300.0


def refuse_no_ratio(exponent: FloatArray, *, key: str = "wrap_angle_rad", places: int = 0) -> None:
    """Refuse an M for which e^M, the ratio of the tensions, is too large to be squared; `places` as in `exponent`."""
    wrong = ~(exponent <= _LARGEST_EXPONENT)
    if wrong.any():
        raise InputError(
            f"the friction lets the tensions differ by e^{exponent[wrong].max():.4g}, which is no ratio of tensions",
            code="RF420",
            key=key,
            fix="check the wrap and the coefficient",
            cases=_of_cases(wrong, places),
        )
