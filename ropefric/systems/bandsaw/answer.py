"""The blade of a saw as assembled from its effects, and its frequencies."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.ends import Ends
from ropefric.systems.bandsaw.grip import grip_utilisation
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.section import Section
from ropefric.systems.bandsaw.span import Span
from ropefric.systems.bandsaw.torsion import torsion_frequencies_Hz
from ropefric.systems.friction import WrapFriction

__all__ = ["SawAnswer", "SawModel", "SideAnswer", "solve_saw"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawModel:
    """A saw's blade as assembled from its effects.

    Attributes
    ----------
    spans : mapping of Side to Span
        The three sides that are asked for: tight, slack and at rest.
    n_modes : int
        Frequencies of each.
    ends : Ends
        How the ends of a stiff blade are held.
    torsion : Section or None
        The section that is twisted; None where torsion is left out.
    friction : WrapFriction or None
        Between blade and wheel.
    wheel_radius_m, half_thickness_m, wheel_wrap_rad : float
        The contact of the wheel that drives.
    """

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
    """One side of a blade.

    Attributes
    ----------
    tension_N, wave_speed_m_s, critical_speed_m_s : ndarray, shape (m,)
        F, c and v_c; the last is infinite for a constant-force mounting.
    frequencies_Hz : ndarray, shape (m, n_modes)
        Of bending out of the blade's plane.
    torsion_Hz : ndarray, shape (m, n_modes), or None
        Of twisting.
    """

    tension_N: FloatArray
    wave_speed_m_s: FloatArray
    critical_speed_m_s: FloatArray
    frequencies_Hz: FloatArray
    torsion_Hz: FloatArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawAnswer:
    """The frequencies of a saw.

    Attributes
    ----------
    model : SawModel
        What was solved.
    sides : mapping of Side to SideAnswer
        Tight, slack and at rest.
    wheel_utilisation : ndarray, shape (m,), or None
        Share of the driving wheel's friction that its torque needs; 1 at gross slip.
    """

    model: SawModel
    sides: Mapping[Side, SideAnswer]
    wheel_utilisation: FloatArray | None = None


def solve_saw(model: SawModel, *, accuracy: float = 1e-10) -> SawAnswer:
    """Return the frequencies of a model.

    Parameters
    ----------
    model : SawModel
        m cases.
    accuracy : float
        Relative accuracy of the frequencies of a stiff blade; those of a string are exact.

    Raises
    ------
    InputError
        If a side travels at its critical speed or above.
    SolverError
        As `solve_beam`.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> span = Span(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0)
    >>> model = SawModel(spans={Side.REST: span}, n_modes=2, ends=PINNED)
    >>> solve_saw(model).sides[Side.REST].frequencies_Hz.round(2).tolist()
    [[23.63, 47.26]]
    """
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
