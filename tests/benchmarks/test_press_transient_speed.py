"""Ten seconds of start-up with tensions to 1e-6: the exact solution against `solve_ivp`, in one run.

Compared by pytest-benchmark and never asserted on the clock; the ratio is in the benchmark's extra information.
"""

import math
import time

import numpy as np
import pytest

from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS, press_inputs
from ropefric.systems.press.transient.integrators import INTEGRATORS, LinearStartUp
from ropefric.systems.press.transient.motion import ElasticPress
from ropefric.systems.press.transient.start_up import GRID_ERROR, largest_difference, start_up

TIMES_S = np.linspace(0.0, 10.0, 201)
ERROR = 1e-6


def machine(eta_s):
    """The size of the paper's press: thirteen rollers on one belt."""
    take_up = Tensioner(spring_N_m=2e4, travel_m=0.03, force_N=2000.0, mass_kg=121.0, damping_N_s_m=500.0)
    names = tuple(str(i) for i in range(1, 14))
    rollers = tuple(Roller(name=name, radius_m=0.15, wrap_angle_rad=math.radians(90.0),
                           role="driver" if name == "1" else "tensioner" if name == "3" else "driven",
                           inertia_kg_m2=1.5, squeeze_torque_N_m=0.0 if name == "1" else 15.0,
                           tensioner=take_up if name == "3" else None)
                    for name in names)  # fmt: skip
    belt = Belt(
        name="belt", loop=names, linear_density_kg_m=15.0, thickness_m=0.005, width_m=2.0, axial_stiffness_N=2e6,
        damping_s=eta_s, span_lengths_m=tuple(0.6 + 0.1 * i for i in range(13)),
    )  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=0.9)


@pytest.fixture(scope="module", params=[1e-3, 1e-2], ids=["eta=1e-3", "eta=1e-2"])
def problem(request):
    model = ElasticPress(machine(request.param))
    speed = DRIVE_LAWS["ramp"](speed_m_s=0.9, duration_s=2.0)
    return LinearStartUp(model=model, inputs=press_inputs(model.overspeed, speed, "with-speed"))


def fresh(problem):
    return LinearStartUp(model=problem.model, inputs=problem.inputs)


def tensions(problem, states):
    w = np.hstack([states[:, : problem.n_state], problem.inputs.at(TIMES_S)])
    return w @ problem.motion.tension_N.T


def timed(problem, name, **settings):
    begun = time.perf_counter()
    found = INTEGRATORS[name](fresh(problem), TIMES_S, **settings)
    return time.perf_counter() - begun, found


def test_exact_against_the_best_of_solve_ivp(benchmark, problem):
    exact = benchmark.pedantic(
        lambda: INTEGRATORS["exact"](fresh(problem), TIMES_S), rounds=5, warmup_rounds=1
    )
    taken = {}
    for name in ("dop853", "radau", "lsoda"):
        for tolerance in 10.0 ** -np.arange(5.0, 11.0):
            seconds, found = timed(problem, name, tolerance=tolerance)
            wanted_N = tensions(problem, exact)
            if np.abs(tensions(problem, found) - wanted_N).max() <= ERROR * wanted_N.max():
                taken[name] = seconds
                break
    assert taken, "no method of solve_ivp reaches the error"
    own = benchmark.stats.stats.min if benchmark.stats else timed(problem, "exact")[0]
    benchmark.extra_info["times_faster"] = {name: seconds / own for name, seconds in taken.items()}


def test_a_start_up_with_slip(benchmark):
    speed = DRIVE_LAWS["ramp"](speed_m_s=0.9, duration_s=0.3)
    found = benchmark.pedantic(start_up, args=(machine(1e-3),),
                               kwargs={"speed": speed, "time_s": TIMES_S, "friction": 0.15}, rounds=1)  # fmt: skip
    assert found.slips


@pytest.mark.parametrize("friction", [0.15, 0.9], ids=["belts slip", "only drags let go"])
def test_a_start_up_on_a_grid(benchmark, friction):
    """Changes of contacts to 0.5 %; how many times the exact moments take is in the extra information."""
    question = {"speed": DRIVE_LAWS["ramp"](speed_m_s=0.9, duration_s=0.3),
                "time_s": np.linspace(0.0, 10.0, 2001), "friction": friction}  # fmt: skip
    found = benchmark(start_up, machine(1e-3), exact_switching=False, **question)
    begun = time.perf_counter()
    exact = start_up(machine(1e-3), **question)
    seconds = time.perf_counter() - begun
    assert largest_difference(found, exact) <= GRID_ERROR
    if benchmark.stats:
        benchmark.extra_info["times_faster"] = seconds / benchmark.stats.stats.min
