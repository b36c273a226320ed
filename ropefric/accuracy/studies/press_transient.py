"""The start-up of a belt press: integrators by step and tolerance, on a pliant and on a stiff belt."""

from functools import cache, partial

import numpy as np

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study, in_case, largest_error
from ropefric.arrays import FloatArray
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS, press_inputs
from ropefric.systems.press.transient.integrators import INTEGRATORS, LinearStartUp, rk4_limit_s
from ropefric.systems.press.transient.motion import ElasticPress

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
