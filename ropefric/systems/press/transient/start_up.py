"""The start-up of a press: from the machine and its drive to tensions, speeds, slips and energies."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.transient.energy import POWERS
from ropefric.systems.press.transient.histories import histories_of, slip_intervals
from ropefric.systems.press.transient.hybrid import solve_hybrid
from ropefric.systems.press.transient.ingredients import Ingredients
from ropefric.systems.press.transient.inputs import Loads, press_inputs
from ropefric.systems.press.transient.integrators import INTEGRATORS, Settings
from ropefric.systems.press.transient.limit import friction_limit
from ropefric.systems.press.transient.model import ElasticPress, elastic_press
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial
from ropefric.systems.press.transient.problem import LinearStartUp
from ropefric.systems.press.transient.rest import settled_tension_N
from ropefric.systems.press.transient.result import SlipInterval, StartUp


def start_up(
    press: Press,
    *,
    speed: PiecewisePolynomial,
    time_s: npt.ArrayLike,
    friction: float | WrapFriction | None = None,
    slip: bool = True,
    loads: Loads = "with-speed",
    ingredients: Ingredients | None = None,
    preload_N: npt.ArrayLike | None = None,
    integrator: str = "exact",
    settings: Settings | None = None,
) -> StartUp:
    """Return the start-up of a press from rest, eqs. (10)-(22) closed by elastic belts.

    The drivers follow `speed` exactly; span tensions are T_0 + Σ EA/L (e + η de/dt). Without friction no belt slips
    and none goes slack, the problem is linear and any integrator may solve it. With friction and `slip` a belt does
    not push, and a roller takes no more than T'_tight = T'_slack e^M with what accelerating the belt adds; between
    two changes of a contact the solution is exact.
    """
    times = _times(time_s)
    model = elastic_press(press, ingredients=ingredients, preload_N=preload_N)
    inputs = press_inputs(model, speed, loads)
    limit = None if friction is None else friction_limit(model, friction)
    method = INTEGRATORS[integrator]
    slips: tuple[SlipInterval, ...] = ()
    if limit is not None and slip:
        if method.control != "exact":
            raise InputError(
                f"'{integrator}' solves the linear start-up; slip and slack are solved exactly between their events",
                key="integrator",
                fix="take the integrator 'exact', or set slip to false",
            )
        if not (model.arc_mass_kg > 0.0).all():
            raise InputError(
                "a belt that slips moves by its own mass, but it has none on the rollers",
                key="arc_inertia",
                fix="give every belt a density and keep the effect arc-inertia, or set slip = false",
            )
        solved = solve_hybrid(model, inputs, limit, times)
        histories = histories_of(
            solved.motions, solved.states, solved.works, inputs=inputs, times_s=times, limit=limit
        )
        names = [roller.name for roller in press.rollers]
        slips = slip_intervals(names, solved.changes, float(times[-1]))
    else:
        problem = LinearStartUp(model=model, inputs=inputs)
        states = method.solve(problem, times, settings or Settings())
        n = states.shape[1] - len(POWERS)
        histories = histories_of(
            [problem.motion], states[:, :n], states[:, n:], inputs=inputs, times_s=times, limit=limit
        )
    return StartUp(
        press=press,
        integrator=integrator,
        slips=slips,
        settled_tension_N=_settled(model, speed, loads),
        **histories,
    )


def _times(time_s: npt.ArrayLike) -> FloatArray:
    times = np.array(time_s, dtype=np.float64)
    if times.ndim != 1 or not times.size or not np.isfinite(times).all():
        raise InputError("a start-up needs a list of finite times", key="time_s")
    if times[0] < 0.0 or times[-1] <= 0.0 or (np.diff(times) <= 0.0).any():
        raise InputError("the times of a start-up must rise from 0 on", key="time_s")
    return times


def _settled(model: ElasticPress, speed: PiecewisePolynomial, loads: Loads) -> FloatArray | None:
    settles = not speed.coefficients[-1, 1:].any() and np.ptp(model.overspeed) == 0.0
    if isinstance(loads, PiecewisePolynomial):
        if not settles or loads.coefficients[-1, 1:].any():
            return None
        return settled_tension_N(model, speed_m_s=speed.final, load_factor=loads.final)
    return settled_tension_N(model, speed_m_s=speed.final) if settles else None
