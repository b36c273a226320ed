"""The effects a band saw may be simulated with, and how much the stiffness can matter at most."""

import math
from itertools import product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.bandsaw.answer import SawAnswer, SawModel, SawProblem, solve_saw
from ropefric.systems.effect import Effect, Method, System, missing

_ROUNDING = 1e-11


_ANY = np.array(list(product((-1.0, 0.0, 1.0), (0.0, 1.0), (0.0, 1.0)))).T[..., np.newaxis]
"""Side and effects: the sign of ΔF/2, and how much of the wheels' tension and of the travel there is."""


def bending_bound(problem: SawProblem, _: SawAnswer | None = None) -> FloatArray:
    """Return an upper bound of the change of any mode's ln f and of ln v_c by the stiffness, shape (n,).

    Held ends shorten the string by a layer of δ = e/√(1 − V²) at each end, e = √(EI/F l²) and V = v/c; for ends that
    may turn δ = 0. Along the rest, mode n is the string's own e^(iκVx) sin κx, κ = nπ/(1 − 2δ), whose stiffness
    raises its frequency by ½κ²e² (1 + 6V² + V⁴)/(1 − V²) of itself, to first order. A mode yields to more stiffness
    by taking a softer shape, so the first order at the string's shape is too large: for mode 1 because it has
    the least of Rayleigh's quotients, for the others by trial. Both terms are exact as e → 0. v_c² goes with
    F_0 ± ΔF/2 + β EI/l². The tensions are those of all sides with whatever other effects are simulated.
    """
    pull, wheels, travels = _ANY
    stiff_N = problem.product("bending_stiffness_N_m2") / problem.free_span_m**2
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        static_N = problem.preload_N + pull * problem.pull_N
        inertia_N = problem.inertia_N
        held = 0.0 if problem.mounting_factor is None else problem.mounting_factor
        tension_N = static_N + wheels * held * inertia_N
        e, V2 = np.sqrt(stiff_N / tension_N), travels * inertia_N / tension_N
        layers = 0.0 * e if problem.ends.turns else 2.0 * e / np.sqrt(1.0 - V2)
        kappa = problem.n_modes * math.pi / (1.0 - layers)
        bent = 0.5 * (kappa * e) ** 2 * (1.0 + 6.0 * V2 + V2**2) / (1.0 - V2)
        change = np.where(layers < 1.0, np.log1p(bent) - np.log1p(-layers), np.inf)
        change = np.maximum(change, 0.5 * np.log1p(problem.ends.buckling * stiff_N / static_N))
        worst = np.where(np.isnan(change), np.inf, change).max(axis=0)
    return np.asarray(worst * (1.0 + _ROUNDING) + _ROUNDING * (worst > 0.0))


_SPEED = {"wheel_radius_m": "wheel.radius", "wheel_speed_rad_s": "wheel.speed"}
EFFECTS: Registry[Effect] = Registry(
    "effect of a band saw",
    (
        Effect(
            name="tension-difference",
            adds="half the pull of the saw's torque on the tight side, and less on the slack side",
            instead="the preload on both sides",
            needs=missing({"tension_difference_N": "drive.power or drive.tension_difference"}),
        ),
        Effect(
            name="wheel-inertia-tension",
            adds="the tension kappa rho A v^2 by which wheels that may give way follow the running blade",
            instead="wheel axles that do not give way",
            needs=missing({"mounting_factor": "tension.mounting_factor", **_SPEED}),
        ),
        Effect(
            name="travel",
            adds="the motion of the blade through its span, which its waves run with and against",
            instead="a blade at rest",
            needs=missing(_SPEED),
        ),
        Effect(
            name="bending",
            adds="the blade's stiffness EI, with a boundary layer at held ends",
            instead="a string",
            needs=missing(
                {
                    "bending_stiffness_N_m2": "blade.bending_stiffness or blade.width, thickness and "
                    "youngs_modulus"
                }
            ),
            bound=bending_bound,
            cost=5e-3,
        ),
        Effect(
            name="torsion",
            adds="the frequencies of twisting, beside those of bending",
            instead="no frequencies of twisting; those of bending do not depend on them",
            needs=missing({"section": "blade.width, thickness, density and shear_modulus"}),
        ),
    ),
)
"""In the order in which they are applied."""
_CLOSED_FORM = Method(name="closed form", error=1e-13, why="a string's travelling waves have one")
_FINEST = 1e-12
"""Rounding leaves a few units of 1e-14."""
_COARSEST = 1e-3
"""A beam to a thousandth takes at most two orders more than to a hundredth: both need their boundary layers."""

_MARGIN = 0.25
"""Largest own error of a mode, as a fraction of the error allowed: it is an estimate, not a bound."""


def _method(model: SawModel, budget: float) -> Method:
    if not model.part("bending", model.problem.bending_stiffness_N_m2).any():
        return _CLOSED_FORM
    accuracy = min(max(budget, _FINEST), _COARSEST)
    return Method(
        name="spectral elements",
        settings={"accuracy": _MARGIN * accuracy},
        error=accuracy,
        why="the order is raised for every mode whose own error is above a quarter of this",
    )


SYSTEM: System = System(
    name="bandsaw",
    effects=EFFECTS,
    model=SawModel,
    method=_method,
    solve=lambda model, method: solve_saw(model, accuracy=method.settings.get("accuracy", _FINEST)),
)
"""A blade on two wheels."""
