"""A million operating points of a press in one call; compared by pytest-benchmark, never asserted on the clock."""

import numpy as np
import pytest

from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics, steady_state

N = 1_000_000


@pytest.fixture(scope="module")
def statics():
    """Two belts, 13 rollers, 14 spans: as large as the machine of the paper."""
    up = Tensioner(spring_N_m=2e4, travel_m=0.03, force_N=2000.0, downstream_angle_rad=0.35)
    down = Tensioner(spring_N_m=2e4, travel_m=0.03, force_N=2000.0, upstream_angle_rad=0.99)
    roles = {1: "driver", 10: "driver", 3: "tensioner", 13: "tensioner"}
    rollers = tuple(Roller(name=str(i), radius_m=0.1 + 0.01 * (i % 5), wrap_angle_rad=1.0 + 0.1 * i,
                           role=roles.get(i, "driven"), squeeze_torque_N_m=0.0 if i in {1, 10} else 10.0,
                           tensioner={3: up, 13: down}.get(i))
                    for i in range(1, 14))  # fmt: skip
    data = {"linear_density_kg_m": 15.0, "thickness_m": 0.005, "width_m": 2.0}
    upper = Belt(name="upper", loop=tuple(map(str, range(1, 10))), **data)
    lower = Belt(name="lower", loop=("9", "10", "11", "12", "13", "5", "6", "7", "8"), **data)
    return solve_statics(Press(rollers=rollers, belts=(upper, lower), speed_m_s=1.0))


@pytest.fixture(scope="module")
def points():
    rng = np.random.default_rng(0)
    return {"preload_N": rng.uniform(1500, 4000, N), "speed_m_s": rng.uniform(0, 3, N)}


def run(statics, points):
    state = steady_state(statics, **points)
    return state.effective_tension_N, SlipTable(state.press, state.effective_tension_N, 1.2).utilisation


def test_the_yardstick_a_million_exponentials(benchmark):
    values = np.random.default_rng(0).uniform(0, 5, N)
    assert benchmark(np.exp, values).size == N


def test_tensions_and_utilisation_of_a_million_points(benchmark, statics, points):
    """The aim: below a hundred times the yardstick."""
    tension, used = benchmark.pedantic(run, args=(statics, points), rounds=5, warmup_rounds=1)
    assert tension.shape == (N, 14)
    assert used.shape == (N, 13)
    assert (used > 0.0).all(axis=0).sum() == 13
