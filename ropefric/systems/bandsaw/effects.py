"""The effects a band saw's blade may be simulated with, and how much each can matter at most."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from ropefric.friction.condition import FloatArray
from ropefric.registry import Registry
from ropefric.systems.bandsaw.answer import SawModel
from ropefric.systems.bandsaw.influence import (
    bending_bound,
    bounded,
    difference_bound,
    travel_bound,
    wheels_bound,
)
from ropefric.systems.bandsaw.problem import SawProblem
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.span import Span
from ropefric.systems.effect import Effect

__all__ = ["EFFECTS", "bare"]

_KEYS = {
    "wheel_radius_m": "wheel.radius",
    "wheel_speed_rad_s": "wheel.speed",
    "tension_difference_N": "drive.power or drive.tension_difference",
    "mounting_factor": "tension.mounting_factor",
    "bending_stiffness_N_m2": "blade.bending_stiffness or blade.width, thickness and youngs_modulus",
    "section": "blade.width, thickness, density and shear_modulus",
}


def bare(problem: SawProblem) -> SawModel:
    """Return the model without any effect: on all sides a string at rest under its preload."""
    string = Span(
        free_span_m=problem.free_span_m,
        linear_density_kg_m=problem.linear_density_kg_m,
        preload_N=problem.preload_N,
    )
    return SawModel(
        spans=dict.fromkeys(Side, string),
        n_modes=problem.n_modes,
        ends=problem.ends,
        friction=problem.friction,
        wheel_radius_m=problem.wheel_radius_m,
        half_thickness_m=0.0 if problem.section is None else 0.5 * problem.section.thickness_m,
        wheel_wrap_rad=problem.wheel_wrap_rad,
    )


def _needs(*names: str) -> Callable[[SawProblem], tuple[str, ...]]:
    def missing(problem: SawProblem) -> tuple[str, ...]:
        return tuple(_KEYS[name] for name in names if getattr(problem, name) is None)

    return missing


def _changed(
    model: SawModel, parts: Callable[[Side], Mapping[str, FloatArray]], sides: tuple[Side, ...] = tuple(Side)
) -> SawModel:
    """Return the model with parts added to the spans of some of its sides."""
    spans = {
        side: replace(span, **parts(side)) if side in sides else span for side, span in model.spans.items()
    }
    return replace(model, spans=spans)


_RUNNING = (Side.TIGHT, Side.SLACK)


def _given(values: FloatArray | None) -> FloatArray:
    """Return data of which `needs` has made sure that they are there."""
    assert values is not None  # noqa: S101
    return values


def _pull(model: SawModel, problem: SawProblem) -> SawModel:
    half_N = 0.5 * _given(problem.tension_difference_N)
    return _changed(model, lambda side: {"pull_N": side.sign * half_N}, _RUNNING)


def _press_wheels(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {
        "mounting_factor": _given(problem.mounting_factor),
        "wheel_speed_m_s": _given(problem.speed_m_s),
    }
    return _changed(model, lambda side: parts, _RUNNING)  # noqa: ARG005  (the same on both sides)


def _travel(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {"travel_speed_m_s": _given(problem.speed_m_s)}
    return _changed(model, lambda side: parts, _RUNNING)  # noqa: ARG005  (the same on both sides)


def _bend(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {"bending_stiffness_N_m2": _given(problem.bending_stiffness_N_m2)}
    return _changed(model, lambda side: parts)  # noqa: ARG005  (the same on all sides)


def _twist(model: SawModel, problem: SawProblem) -> SawModel:
    return replace(model, torsion=problem.section)


def _none(problem: SawProblem) -> float:  # noqa: ARG001  (the signature of `influence`)
    return 0.0


EFFECTS: Registry[Effect[SawProblem, SawModel]] = Registry(
    "effect of a band saw",
    (
        Effect(
            name="tension-difference",
            adds="half the pull of the saw's torque on the tight side, and less on the slack side",
            instead="the preload on both sides",
            needs=_needs("tension_difference_N"),
            influence=bounded(difference_bound),
            apply=_pull,
            cost=0.05,
        ),
        Effect(
            name="wheel-inertia-tension",
            adds="the tension kappa rho A v^2 by which wheels that may give way follow the running blade",
            instead="wheel axles that do not give way",
            needs=_needs("mounting_factor", "wheel_radius_m", "wheel_speed_rad_s"),
            influence=bounded(wheels_bound),
            apply=_press_wheels,
            cost=0.05,
        ),
        Effect(
            name="travel",
            adds="the motion of the blade through its span, which its waves run with and against",
            instead="a blade that stands still",
            needs=_needs("wheel_radius_m", "wheel_speed_rad_s"),
            influence=bounded(travel_bound),
            apply=_travel,
            cost=0.05,
        ),
        Effect(
            name="bending",
            adds="the blade's stiffness EI, with a boundary layer at held ends",
            instead="a string",
            needs=_needs("bending_stiffness_N_m2"),
            influence=bounded(bending_bound),
            apply=_bend,
            cost=50.0,
        ),
        Effect(
            name="torsion",
            adds="the frequencies of twisting, beside those of bending",
            instead="no frequencies of twisting; those of bending do not depend on them",
            needs=_needs("section"),
            influence=_none,
            apply=_twist,
            cost=0.2,
        ),
    ),
)
"""In the order in which they are applied."""
