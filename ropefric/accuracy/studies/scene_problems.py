"""The machines that the study of scenes plans and solves, one for each kind of scene and one sweep."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ropefric.accuracy.studies.press_transient import SPEED_M_S, machine
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.systems.bandsaw.effects import SYSTEM as SAW
from ropefric.systems.bandsaw.effects import SawProblem
from ropefric.systems.bandsaw.section import STEEL_85_09
from ropefric.systems.effect import System
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.problem import HoistProblem
from ropefric.systems.hoist.system import SYSTEM as HOIST
from ropefric.systems.press.problem import PressProblem
from ropefric.systems.press.system import SYSTEM as PRESS

__all__ = ["N_SWEEP", "PROBLEMS", "Planned"]

N_SWEEP = 8
"""Preloads of the sweep."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Planned:
    """A machine to be planned and solved.

    Attributes
    ----------
    title : str
        What it is, with its numbers.
    system : System
        Its kind.
    problem : callable
        Returns what its scene says.
    """

    title: str
    system: System[Any, Any, Any]
    problem: Callable[[], Any]


def _hoist() -> HoistProblem:
    """Return a rope that climbs, runs, hangs and is a little stiff: all six effects have something to say."""
    law = ALL_LAWS["coupled"]
    rope = WrapFriction(
        law=law,
        theta=law.theta_from({"mu_inf": 0.46, "a": -0.22, "b": -0.3, "c": -0.48, "d": 0.055}),
        reference=one_condition(0.035, 0.0049, 5.4, 32.0),
    )
    return HoistProblem(
        friction=rope,
        wheel_radius_m=np.array([0.04]),
        rope_radius_m=np.array([0.0049]),
        wrap_angle_rad=np.array([5.0 * np.pi]),
        end_tension_N=np.array([80.0]),
        speed_m_s=np.array([0.3]),
        linear_density_kg_m=np.array([0.062]),
        hanging_length_m=np.array([25.0]),
        bending_stiffness_N_m2=np.array([1e-4]),
    )


def _saw(preload_N: np.ndarray) -> SawProblem:
    return SawProblem(
        free_span_m=np.array([1.6]),
        linear_density_kg_m=np.array([STEEL_85_09.linear_density_kg_m]),
        preload_N=preload_N,
        n_modes=3,
        wheel_radius_m=np.array([0.35]),
        wheel_speed_rad_s=np.array([100.0]),
        tension_difference_N=np.array([211.0]),
        mounting_factor=np.array([0.1]),
        bending_stiffness_N_m2=np.array([STEEL_85_09.bending_stiffness_N_m2]),
        section=STEEL_85_09,
    )


def _press() -> PressProblem:
    return PressProblem(
        press=machine(2e6, 1e-3),
        closure="share",
        friction=WrapFriction.constant(0.9),
        speed_m_s=np.array([SPEED_M_S]),
        load_factor=np.array([1.0]),
    )


PROBLEMS: Mapping[str, Planned] = MappingProxyType({
    "hoist": Planned(
        title="a rope of 9.8 mm climbing on a wheel of 40 mm, 2.5 turns, 25 m of it hanging; law: coupled",
        system=HOIST,
        problem=_hoist,
    ),
    "saw": Planned(
        title="a blade of 85 × 0.9 mm on 1.6 m at 35 m/s, three frequencies of each side",
        system=SAW,
        problem=lambda: _saw(np.array([12_000.0])),
    ),
    "saw-sweep": Planned(
        title=f"the same blade at {N_SWEEP} preloads from 8 to 16 kN, planned once and solved in one call",
        system=SAW,
        problem=lambda: _saw(np.linspace(8_000.0, 16_000.0, N_SWEEP)),
    ),
    "press": Planned(
        title=f"one belt over four rollers, at {SPEED_M_S:g} m/s",
        system=PRESS,
        problem=_press,
    ),
})  # fmt: skip
"""By the name of their case."""
