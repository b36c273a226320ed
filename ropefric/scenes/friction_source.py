"""Where a scene's friction comes from: a number, a law, or a stored fit with its covariance."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, RopefricError
from ropefric.files.read import kind_of_file
from ropefric.fitting.predict import degrees_of_freedom
from ropefric.fitting.result import FitResult
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.schema import FrictionTable, ReferenceTable
from ropefric.systems.friction import ScaleTo, WrapFriction

_HALF_A_TURN = math.pi
_USUAL_TENSION_N = 100.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionSource:
    """A friction law as a scene uses it, and how well it is known."""

    friction: WrapFriction
    origin: str
    covariance: FloatArray | None = None
    dof: float = math.inf
    tested: Mapping[str, tuple[float, float]] | None = None
    warnings: tuple[str, ...] = ()

    def with_theta(self, theta: FloatArray) -> WrapFriction:
        """Return the same friction with other parameters."""
        return replace(self.friction, theta=theta)


def friction_source(
    table: FrictionTable, folder: Path, *, wheel_radius_m: float, rope_radius_m: float
) -> FrictionSource:
    """Return the friction that a scene's `[friction]` names."""
    scale_to = (
        None if table.scale_to is None else ScaleTo(mu=table.scale_to.mu, wrap_angle_rad=table.scale_to.wrap)
    )
    if table.fit is not None:
        return _from_fit(table, _find(table.fit, folder), scale_to)
    own = one_condition(wheel_radius_m, rope_radius_m, _HALF_A_TURN, _USUAL_TENSION_N)
    if table.mu is not None:
        law, theta, origin = ALL_LAWS["constant"], np.array([table.mu]), f"mu = {table.mu:g}"
    else:
        law = ALL_LAWS[table.law or ""]
        theta = law.theta_from(table.parameters or {})
        values = ", ".join(f"{name} = {value:g}" for name, value in law.as_mapping(theta).items())
        origin = f"{law.name} with {values}"
    friction = WrapFriction(
        law=law, theta=theta, reference=_reference(table.reference, own), scale_to=scale_to
    )
    _ = friction.scale  # a law without an answer at the reference is refused here, not while solving
    return FrictionSource(friction=friction, origin=origin + _scaled(scale_to))


def _from_fit(table: FrictionTable, path: Path, scale_to: ScaleTo | None) -> FrictionSource:
    fit = load_fit(path)
    law = ALL_LAWS[fit.law]
    friction = WrapFriction(
        law=law,
        theta=np.asarray(fit.theta),
        reference=_reference(table.reference, _amid(fit)),
        scale_to=scale_to,
    )
    _ = friction.scale
    warnings = () if fit.status.value == "ok" else (f"the fit's status is {fit.status.value}", *fit.advice)
    return FrictionSource(
        friction=friction,
        origin=f"{fit.law} fitted to {fit.statistics.n} trials ({Path(table.fit or '').name})"
        + _scaled(scale_to),
        covariance=np.asarray(fit.covariance),
        dof=degrees_of_freedom(fit),
        tested={name: (float(low), float(high)) for name, (low, high) in fit.validity.items()},
        warnings=warnings,
    )


def _scaled(scale_to: ScaleTo | None) -> str:
    if scale_to is None:
        return ""
    return f", scaled to mu = {scale_to.mu:g} over {math.degrees(scale_to.wrap_angle_rad):g} deg"


def _find(name: str, folder: Path) -> Path:
    for place in (folder / name, Path(name)):
        if kind_of_file(place):
            return place
    raise DataError(
        f"there is no fit {name!r}, neither beside the scene nor in the folder of the command",
        key="friction.fit",
        fix="give the path of a file from fits/, relative to the scene",
    )


def _amid(fit: FitResult) -> Conditions:
    """Return the geometric middle of what was tested; a law changes by factors, not by differences."""
    ranges = fit.validity
    middle = {
        name: math.sqrt(low * high)
        for name, (low, high) in ranges.items()
        if name in {"wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N"}
    }
    try:
        return Conditions(**{name: np.array([value]) for name, value in middle.items()})
    except (TypeError, RopefricError):
        raise DataError(
            "the fit does not say at which conditions it was tested",
            key="friction.fit",
            fix="fit again: `ropefric fit TRIALS.csv --law NAME --out FIT.json`, or save_fit in Python",
        ) from None


def _reference(table: ReferenceTable, default: Conditions) -> Conditions:
    given = {
        "wheel_radius_m": table.wheel_radius,
        "rope_radius_m": None if table.rope_diameter is None else 0.5 * table.rope_diameter,
        "wrap_angle_rad": table.wrap,
        "end_tension_N": table.end_tension,
    }
    return Conditions(
        **{
            name: getattr(default, name) if value is None else np.array([value])
            for name, value in given.items()
        }
    )
