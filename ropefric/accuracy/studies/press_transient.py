"""The start-up of a belt press: integrators by step and tolerance, on a pliant and on a stiff belt."""

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study, in_case, largest_error
from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS, SPEED, Inputs, press_inputs
from ropefric.systems.press.transient.exact import Propagator
from ropefric.systems.press.transient.motion import ElasticPress, Motion, starting_state, sticking

TIMES_S = (0.1, 0.2, 0.4)
SPEED_M_S, RUN_UP_S = 0.916, 0.3
BELTS = {"pliant": (2e6, 1e-3), "stiff": (1e7, 1e-2)}
"""Axial stiffness EA [N] and damping time η [s] of each case."""

# 50-digit tensions [N] of the four spans at these times; the tests compute them again with mpmath.
TENSIONS_N = {
    "pliant": (
        (760.57866183269964196, 1138.5276947421640285, 1514.1088324854375466, 2500.3140643605943745),
        (533.49168652213471957, 1070.6272507797642053, 1605.5778433573462879, 2762.6271096403935389),
        (797.29733990230051717, 1162.0416922480501366, 1504.6686987935599831, 1806.7048645823546011),
    ),
    "stiff": (
        (799.21228030685921994, 1160.0312878673571473, 1532.1208279010668071, 2558.5922879342989554),
        (555.28841499355259537, 1084.4857005515349988, 1625.0572194880797627, 2843.1331245021648695),
        (833.68036234477897341, 1183.0136402716689191, 1532.347084389801537, 1928.3479023048632124),
    ),
}
_RK4_STEPS_MS = {"pliant": (8.0, 4.0, 2.0, 1.0, 0.5, 0.25), "stiff": (0.5, 0.25, 0.125)}
_QUICK = {"pliant": {4.0, 2.0, 1e-4, 1e-7}, "stiff": {0.5, 1e-4, 1e-7}}
"""Steps [ms] and tolerances."""
_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12)


class LinearStartUp:
    """A start-up in which no belt slips or goes slack: dy/dt = A y + B u(t), y = (q, dq/dt)."""

    def __init__(self, model: ElasticPress, inputs: Inputs) -> None:
        self.model, self.inputs = model, inputs
        self.motion = Motion(model, sticking(model))
        self.start = starting_state(self.motion, inputs)
        self.n_state = len(self.start)
        self.matrix = self.motion.derivative[:, : self.n_state]
        way = float((model.preload_N / model.stiffness_N_m).max())
        speed = max(float(np.abs(inputs.taylor[:, SPEED, 0]).max()), 1e-3)
        self.scale = np.repeat([way, speed], self.motion.n_coordinates)
        # On a stiff, damped belt a speed that is small beside the drive's is a large tension.
        with np.errstate(divide="ignore"):
            ways = model.preload_N[:, np.newaxis] / np.abs(self.motion.tension_N[:, : self.n_state])
        self.tension_scale = ways.min(axis=0)

    @property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s]."""
        return np.linalg.eigvals(self.matrix)

    def rate(self, y: FloatArray, u: FloatArray) -> FloatArray:
        """Return dy/dt, shape (n_state,)."""
        return np.asarray(self.motion.derivative @ np.concatenate([y, u]))


Advance = Callable[[int, float, FloatArray, FloatArray], FloatArray]
"""(piece of the drive, its start, stops inside it, state at its start) to the states at the stops."""


def _piece_by_piece(problem: LinearStartUp, times_s: FloatArray, advance: Advance) -> FloatArray:
    """Carry the state through the pieces of the drive, and return it at sorted times."""
    y = problem.start
    states = np.zeros((len(times_s), len(y)))
    states[times_s == 0.0] = y
    starts = problem.inputs.starts_s
    for piece, (start, next_start) in enumerate(zip(starts, [*starts[1:], np.inf], strict=True)):
        if start >= times_s[-1]:
            break
        inside = np.flatnonzero((times_s > start) & (times_s <= next_start))
        stops = np.unique(np.append(times_s[inside], min(next_start, times_s[-1])))
        found = advance(piece, float(start), stops, y)
        states[inside], y = found[: inside.size], found[-1]
    return states


def _exact(problem: LinearStartUp, times_s: FloatArray) -> FloatArray:
    """Take one matrix exponential to each time: no error of discretisation at any stiffness."""

    def advance(piece: int, start: float, stops: FloatArray, y: FloatArray) -> FloatArray:
        drive = problem.motion.derivative[:, problem.n_state :]
        made = Propagator(problem.matrix, drive, problem.inputs.taylor[piece])
        z = made.lift(y, 0.0)
        return np.array([(made.step(stop - start) @ z)[: len(y)] for stop in stops.tolist()])

    return _piece_by_piece(problem, times_s, advance)


def rk4_limit_s(eigenvalues: np.ndarray) -> float:
    """Return the greatest step at which the classical Runge-Kutta method does not amplify any motion [s].

    |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1 has to hold for z = hλ of every eigenvalue. Seen from 0 the region's border is
    more than 2 away in every direction of the left half-plane, 2√2 along the imaginary axis.
    """
    limits = [_border(value / abs(value)) / abs(value) for value in eigenvalues if abs(value) > 0.0]
    return float(min(limits, default=np.inf))


def _border(direction: complex) -> float:
    # |R|² − 1 is a polynomial in the distance; its root at 0 is divided out.
    series = direction ** np.arange(5) / np.array([1.0, 1.0, 2.0, 6.0, 24.0])
    roots = np.roots(np.convolve(series, series.conj()).real[:0:-1])
    real = roots[np.abs(roots.imag) <= 1e-6 * np.abs(roots)].real
    return float(real[real > 1.5].min()) if (real > 1.5).any() else 2.0 * np.sqrt(2.0)


def _rk4(problem: LinearStartUp, times_s: FloatArray, *, step_s: float) -> FloatArray:
    """Take the classical Runge-Kutta method with a fixed step, the paper's; an unstable step is refused."""
    limit_s = rk4_limit_s(problem.eigenvalues)
    if not 0.0 < step_s <= limit_s:
        raise SolverError(
            f"the step of {step_s:.6g} s is not within RK4's limit of stability, {limit_s:.6g} s"
        )

    def advance(piece: int, start: float, stops: FloatArray, y: FloatArray) -> FloatArray:
        now, found = start, []
        for stop in stops.tolist():
            # The step is shortened a little so that every time asked for is met.
            count = max(1, math.ceil((stop - now) / step_s * (1.0 - 1e-9)))
            h = (stop - now) / count
            for k in range(count):
                first, middle, last = problem.inputs.at(now + (k + np.array([0.0, 0.5, 1.0])) * h, piece)
                k1 = problem.rate(y, first)
                k2 = problem.rate(y + 0.5 * h * k1, middle)
                k3 = problem.rate(y + 0.5 * h * k2, middle)
                k4 = problem.rate(y + h * k3, last)
                y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            now = stop
            found.append(y)
        return np.array(found)

    return _piece_by_piece(problem, times_s, advance)


_SHARES = {"DOP853": 0.01, "Radau": 0.1, "LSODA": 0.1}
"""Largest error of a step, as a fraction of the tensions: steps add up, and explicit ones on a stiff belt are at the
limit of their stability, where each keeps the error of the one before."""


def _adaptive(problem: LinearStartUp, times_s: FloatArray, *, method: str, tolerance: float) -> FloatArray:
    """Take a method of scipy, the implicit ones with A as their Jacobian, to a tolerance of the tensions."""
    absolute = tolerance * np.minimum(problem.scale, _SHARES[method] * problem.tension_scale)
    options: dict[str, Any] = {"method": method, "rtol": tolerance, "atol": absolute}
    if method != "DOP853":
        options["jac"] = lambda t, y: problem.matrix  # noqa: ARG005  (it is constant)

    def advance(piece: int, start: float, stops: FloatArray, y: FloatArray) -> FloatArray:
        def rate(t: float, y: FloatArray) -> FloatArray:
            return problem.rate(y, problem.inputs.at(t, piece))

        return np.asarray(solve_ivp(rate, (start, float(stops[-1])), y, t_eval=stops, **options).y.T)

    return _piece_by_piece(problem, times_s, advance)


INTEGRATORS: dict[str, Callable[..., FloatArray]] = {
    "exact": _exact,
    "rk4": _rk4,
    "dop853": partial(_adaptive, method="DOP853"),  # explicit, eighth order
    "radau": partial(_adaptive, method="Radau"),  # implicit, fifth order: stiff, damped belts
    "lsoda": partial(_adaptive, method="LSODA"),  # multistep, changes between stiff and non-stiff by itself
}
"""Return states at sorted times, shape (n_times, n_state)."""


class _Counting(LinearStartUp):
    """A start-up that counts the evaluations of its rate."""

    evaluations = 0

    def rate(self, y: FloatArray, u: FloatArray) -> FloatArray:
        self.evaluations += 1
        return super().rate(y, u)


def machine(stiffness_N: float, damping_s: float) -> Press:
    """Return one belt over a driver, a loaded roller, a tensioner and a press roller: 8 states instead of 26."""
    tensioner = Tensioner(
        spring_N_m=2e4,
        travel_m=0.03,
        force_N=2000.0,
        mass_kg=121.0,
        damping_N_s_m=500.0,
        downstream_angle_rad=0.347,
    )
    small = partial(Roller, radius_m=0.075, inertia_kg_m2=0.37, gravity_torque_N_m=26.2)
    rollers = (
        Roller(name="driver", radius_m=0.175, wrap_angle_rad=3.1, role="driver"),
        small(name="support", wrap_angle_rad=0.49),
        small(name="tensioner", wrap_angle_rad=2.85, role="tensioner", tensioner=tensioner),
        Roller(name="press", radius_m=0.25, wrap_angle_rad=0.99, inertia_kg_m2=13.9, squeeze_torque_N_m=99.0),
    )
    belt = Belt(
        name="belt",
        loop=tuple(roller.name for roller in rollers),
        linear_density_kg_m=15.0,
        thickness_m=0.005,
        width_m=2.0,
        axial_stiffness_N=stiffness_N,
        damping_s=damping_s,
        span_lengths_m=(1.2, 0.8, 0.9, 1.6),
    )
    return Press(rollers=rollers, belts=(belt,), speed_m_s=SPEED_M_S)


@cache
def start_up(case: str) -> LinearStartUp:
    """Return the start-up of a case: a smooth run-up in 0.3 s, the loads in proportion to the speed."""
    model = ElasticPress(machine(*BELTS[case]))
    speed = DRIVE_LAWS["s-curve"](speed_m_s=SPEED_M_S, duration_s=RUN_UP_S)
    return LinearStartUp(model=model, inputs=press_inputs(model.overspeed, speed, "with-speed"))


def tensions_N(problem: LinearStartUp, integrator: str, settings: dict[str, float]) -> FloatArray:
    """Return the tensions of all spans at `TIMES_S`, shape (3, 4) [N]."""
    times_s = np.array(TIMES_S)
    states = INTEGRATORS[integrator](problem, times_s, **settings)
    rows = np.hstack([states, problem.inputs.at(times_s)])
    return np.asarray(rows @ problem.motion.tension_N.T)


def _settings(case: str) -> tuple[Setting, ...]:
    problem, exact = start_up(case), np.array(TENSIONS_N[case])

    def setting(integrator: str, text: str, chosen: dict[str, float], *, quick: bool) -> Setting:
        def assess() -> Outcome:
            counting = _Counting(model=problem.model, inputs=problem.inputs)
            error = largest_error(tensions_N(counting, integrator, chosen), exact)
            return Outcome(error=error, evaluations=float(counting.evaluations))

        return Setting(integrator, text, partial(tensions_N, problem, integrator, chosen), assess, quick)

    quick = _QUICK[case]
    steps = [
        setting("rk4", f"step {ms:g} ms", {"step_s": 1e-3 * ms}, quick=ms in quick)
        for ms in _RK4_STEPS_MS[case]
    ]
    # Explicit steps on a stiff belt take the same time at every tolerance: once is enough. Beyond 1e-8 the method of
    # fifth order, and the explicit one on a stiff belt, take seconds.
    tolerated = [
        setting(name, f"tolerance {one:g}", {"tolerance": one},
                quick=one in quick and (one < 1e-6 or (name, case) != ("dop853", "stiff")))
        for name in ("dop853", "radau", "lsoda") for one in _TOLERANCES
        if one >= 1e-8 or name == "lsoda" or (name, case) == ("dop853", "pliant")
    ]  # fmt: skip
    return (*steps, *tolerated, setting("exact", "", {}, quick=True))


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    cases = [case for case in BELTS if in_case(points, case)]
    limits = [f"{1e3 * rk4_limit_s(start_up(case).eigenvalues):.3g} ms ({case})" for case in cases]
    return (f"RK4 is stable up to a step of {', '.join(limits)}.",) if limits else ()


STUDY = Study(
    name="press-transient",
    title="Start-up of a belt press: tensions of all spans at three times",
    question="What does the paper's Runge-Kutta method cost against the exact solution, also on a stiff belt?",
    reference="matrix exponential of equations written down separately, in 50-digit arithmetic (mpmath)",
    counted="evaluations of the rate of change",
    used="matrix exponential",
    cases=tuple(
        Case(
            name,
            f"one belt over four rollers, run up in {RUN_UP_S:g} s; EA = {1e-6 * stiffness_N:g} MN, "
            f"η = {1e3 * damping_s:g} ms",
            partial(_settings, name),
        )
        for name, (stiffness_N, damping_s) in BELTS.items()
    ),
    findings=_findings,
)
