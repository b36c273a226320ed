"""The blade of a saw as assembled from its effects, and its frequencies."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.resonance import Excitation
from ropefric.systems.bandsaw.saw import Section, Side
from ropefric.systems.bandsaw.span import CLAMPED, Ends, Span, refuse_no_modes
from ropefric.systems.checks import Rule, side_by_side
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawProblem:
    """A blade on two wheels, m cases side by side; scalars are spread."""

    free_span_m: FloatArray
    linear_density_kg_m: FloatArray
    preload_N: FloatArray
    n_modes: int
    wheel_radius_m: FloatArray | None = None
    wheel_speed_rad_s: FloatArray | None = None
    tension_difference_N: FloatArray | None = None
    mounting_factor: FloatArray | None = None
    bending_stiffness_N_m2: FloatArray | None = None
    ends: Ends = CLAMPED
    section: Section | None = None
    friction: WrapFriction | None = None
    wheel_wrap_rad: float = np.pi
    excitations: tuple[Excitation, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    margin_wanted: float | None = None
    preload_range_N: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name, array in side_by_side({name: getattr(self, name) for name in _RULES}, _RULES).items():
            object.__setattr__(self, name, array)
        refuse_no_modes(self.n_modes)

    @property
    def m(self) -> int:
        """Return how many cases there are."""
        return self.preload_N.size

    @property
    def speed_m_s(self) -> FloatArray | None:
        """Return the blade's speed v = ω R [m/s], shape (m,), where the wheels are known."""
        if self.wheel_radius_m is None or self.wheel_speed_rad_s is None:
            return None
        return self.wheel_speed_rad_s * self.wheel_radius_m

    @property
    def inertia_N(self) -> FloatArray:
        """Return ρA v² [N]; zero where the scene does not give a speed."""
        speed = self.speed_m_s
        return np.zeros(self.m) if speed is None else self.linear_density_kg_m * speed**2

    @property
    def wheels_N(self) -> FloatArray:
        """Return κ ρA v² [N]; zero where the scene does not give it."""
        return np.zeros(self.m) if self.mounting_factor is None else self.mounting_factor * self.inertia_N

    @property
    def pull_N(self) -> FloatArray:
        """Return ΔF/2 [N]; zero where the scene does not give it."""
        return np.zeros(self.m) if self.tension_difference_N is None else 0.5 * self.tension_difference_N

    @property
    def knows_grip(self) -> bool:
        """Return whether the scene says what the wheel's friction is."""
        return all(part is not None for part in (self.friction, self.wheel_radius_m, self.section))

    def grip_exponent(self, slack_tension_N: FloatArray) -> FloatArray:
        """Return M over the wheel's wrap, where `knows_grip`."""
        assert self.friction is not None  # noqa: S101
        assert self.wheel_radius_m is not None  # noqa: S101
        assert self.section is not None  # noqa: S101
        return self.friction.exponent(
            wheel_radius_m=self.wheel_radius_m,
            rope_radius_m=0.5 * self.section.thickness_m,
            wrap_angle_rad=self.wheel_wrap_rad,
            slack_tension_N=slack_tension_N,
        )


_RULES: dict[str, Rule] = {
    "free_span_m": "positive",
    "linear_density_kg_m": "positive",
    "preload_N": "positive",
    "wheel_radius_m": "positive",
    "wheel_speed_rad_s": "zero or more",
    "tension_difference_N": "zero or more",
    "mounting_factor": "zero or more",
    "bending_stiffness_N_m2": "zero or more",
}


class SawModel(Model[SawProblem]):
    """A saw's blade with the effects that are in it; without any on all sides a string at rest under its preload."""

    @cached_property
    def spans(self) -> Mapping[Side, Span]:
        """Return the blade's free span on each side, and at rest."""
        return {side: self._span(side) for side in Side}

    def _span(self, side: Side) -> Span:
        problem = self.problem
        parts: dict[str, Any] = {
            "free_span_m": problem.free_span_m,
            "linear_density_kg_m": problem.linear_density_kg_m,
            "preload_N": problem.preload_N,
        }
        running = self.effects if side is not Side.REST else frozenset()
        if "tension-difference" in running:
            parts["pull_N"] = side.sign * problem.pull_N
            Span(**parts)  # refuses a side that is slack before the wheels' inertia helps it
        if "wheel-inertia-tension" in running:
            parts |= {"mounting_factor": problem.mounting_factor, "wheel_speed_m_s": problem.speed_m_s}
        if "travel" in running:
            parts["travel_speed_m_s"] = problem.speed_m_s
        if "bending" in self.effects:
            parts["bending_stiffness_N_m2"] = problem.bending_stiffness_N_m2
        return Span(**parts)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SideAnswer:
    """One side of a blade."""

    tension_N: FloatArray
    wave_speed_m_s: FloatArray
    critical_speed_m_s: FloatArray
    frequencies_Hz: FloatArray
    torsion_Hz: FloatArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawAnswer:
    """The frequencies of a saw."""

    model: SawModel
    sides: Mapping[Side, SideAnswer]
    wheel_utilisation: FloatArray | None = None


def solve_saw(model: SawModel, *, accuracy: float = 1e-10) -> SawAnswer:
    """Return the frequencies of a model."""
    return SawAnswer(
        model=model,
        sides={side: _solve_side(model, span, accuracy) for side, span in model.spans.items()},
        wheel_utilisation=grip_utilisation(model),
    )


def _solve_side(model: SawModel, span: Span, accuracy: float) -> SideAnswer:
    problem, section = model.problem, model.problem.section
    twists = section is not None and "torsion" in model.effects
    return SideAnswer(
        tension_N=span.tension_N,
        wave_speed_m_s=span.wave_speed_m_s,
        critical_speed_m_s=span.critical_speed_m_s(problem.ends),
        frequencies_Hz=beam_frequencies_Hz(span, problem.ends, problem.n_modes, accuracy=accuracy),
        torsion_Hz=torsion_frequencies_Hz(span, section, problem.n_modes) if section and twists else None,
    )


def grip_utilisation(model: SawModel) -> FloatArray | None:
    """Return required over available friction pull of the driving wheel, shape (m,) [-]; 1 at gross slip.

    U = (F_tight − F_slack) / ((F_slack − ρAv²)(e^M − 1)): what keeps the blade on its circle presses nothing. None
    where the scene does not say what friction there is.
    """
    problem = model.problem
    if not problem.knows_grip:
        return None
    tight, slack = model.spans[Side.TIGHT], model.spans[Side.SLACK]
    # The difference of two large tensions loses a small pull, and what the wheels add is the same on both sides.
    needed_N = tight.pull_N - slack.pull_N
    pressing_N = slack.net_tension_N
    touching = pressing_N > 0.0
    if not touching.any():
        return np.where(needed_N > 0.0, np.inf, 0.0)
    exponent = problem.grip_exponent(np.where(touching, pressing_N, 1.0))
    # Both times e^{−M}: e^M itself may be beyond floats.
    available_N = np.where(touching, -pressing_N * np.expm1(-exponent), 0.0)
    share: FloatArray = np.divide(
        needed_N * np.exp(-exponent), available_N, out=np.full_like(needed_N, np.inf), where=available_N > 0.0
    )
    return share


def torsion_wave_speed_m_s(span: Span, section: Section) -> FloatArray:
    """Return c_t = √(F/ρA + 4 (G/ρ)(h/b)²) [m/s], shape (m,).

    The strip's own stiffness G b h³/3 and the tension's, F b²/12 (outer fibres lie askew when it is twisted), over
    the inertia ρ h b³/12.
    """
    return np.sqrt(span.tension_N / span.linear_density_kg_m + _stiffness_part(section))


def torsion_frequencies_Hz(span: Span, section: Section, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of torsion f_n = n (c_t² − v²)/(2 l c_t) [Hz], shape (m, n_modes).

    The ends are held against twisting. Parameters as in `torsion_wave_speed_m_s`.
    """
    refuse_no_modes(n_modes)
    speed = torsion_wave_speed_m_s(span, section)
    squared = span.net_tension_N / span.linear_density_kg_m + _stiffness_part(section)
    beyond = squared <= 0.0
    if beyond.any():
        first = int(np.argmax(beyond))
        raise InputError(
            f"the blade travels at {span.travel_speed_m_s[first]:.9g} m/s{span.place(first)} and the critical speed "
            f"of torsion is {speed[first]:.9g} m/s, where its frequency is zero",
            code="RF530",
            key="travel_speed_m_s",
            fix="run slower, or raise the preload",
        )
    first_Hz = squared / (2.0 * span.free_span_m * speed)
    return np.asarray(first_Hz[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))


def _stiffness_part(section: Section) -> float:
    """Return 4 (G/ρ)(h/b)² [m2/s2]."""
    ratio = section.thickness_m / section.width_m
    return 4.0 * section.shear_modulus_Pa / section.density_kg_m3 * ratio**2
