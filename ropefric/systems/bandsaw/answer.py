"""The blade of a saw as assembled from its effects, and its frequencies."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.ends import Ends
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.section import Section
from ropefric.systems.bandsaw.span import Span
from ropefric.systems.friction import WrapFriction


def grip_utilisation(
    tight: Span,
    slack: Span,
    friction: WrapFriction,
    *,
    wheel_radius_m: FloatArray,
    half_thickness_m: float,
    wrap_angle_rad: float,
) -> FloatArray:
    """Return required over available friction pull of the driving wheel, shape (m,) [-]; 1 at gross slip.

    U = (F_tight − F_slack) / ((F_slack − ρAv²)(e^M − 1)): what keeps the blade on its circle presses nothing.
    """
    # Part by part: a small pull is lost in the difference of two large tensions.
    needed_N = (
        (tight.preload_N - slack.preload_N)
        + (tight.pull_N - slack.pull_N)
        + (_wheels_N(tight) - _wheels_N(slack))
    )
    pressing_N = slack.net_tension_N
    touching = pressing_N > 0.0
    if not touching.any():
        return np.where(needed_N > 0.0, np.inf, 0.0)
    exponent = friction.exponent(
        wheel_radius_m=wheel_radius_m,
        rope_radius_m=half_thickness_m,
        wrap_angle_rad=wrap_angle_rad,
        slack_tension_N=np.where(touching, pressing_N, 1.0),
    )
    # Both times e^{−M}: e^M itself may be beyond floats.
    available_N = np.where(touching, -pressing_N * np.expm1(-exponent), 0.0)
    share: FloatArray = np.divide(
        needed_N * np.exp(-exponent), available_N, out=np.full_like(needed_N, np.inf), where=available_N > 0.0
    )
    return share


def _wheels_N(span: Span) -> FloatArray:
    """Return κ ρA v_w² [N]."""
    return span.mounting_factor * span.linear_density_kg_m * span.wheel_speed_m_s**2


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
    if n_modes < 1:
        raise InputError(f"{n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawModel:
    """A saw's blade as assembled from its effects."""

    spans: Mapping[Side, Span]
    n_modes: int
    ends: Ends
    torsion: Section | None = None
    friction: WrapFriction | None = None
    wheel_radius_m: FloatArray | None = None
    half_thickness_m: float = 0.0
    wheel_wrap_rad: float = np.pi


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
        wheel_utilisation=_utilisation(model),
    )


def _solve_side(model: SawModel, span: Span, accuracy: float) -> SideAnswer:
    return SideAnswer(
        tension_N=span.tension_N,
        wave_speed_m_s=span.wave_speed_m_s,
        critical_speed_m_s=span.critical_speed_m_s(model.ends),
        frequencies_Hz=beam_frequencies_Hz(span, model.ends, model.n_modes, accuracy=accuracy),
        torsion_Hz=None
        if model.torsion is None
        else torsion_frequencies_Hz(span, model.torsion, model.n_modes),
    )


def _utilisation(model: SawModel) -> FloatArray | None:
    if model.friction is None or model.wheel_radius_m is None or not model.half_thickness_m:
        return None
    return grip_utilisation(
        model.spans[Side.TIGHT],
        model.spans[Side.SLACK],
        model.friction,
        wheel_radius_m=model.wheel_radius_m,
        half_thickness_m=model.half_thickness_m,
        wrap_angle_rad=model.wheel_wrap_rad,
    )
