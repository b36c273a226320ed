"""RK4's limit of stability, and the frequencies and decay rates of the linear start-up."""

import numpy as np
import pytest

from ropefric.accuracy.studies.press_transient import rk4_limit_s
from ropefric.errors import SolverError
from ropefric.systems.press.transient.motion import MOVING


@pytest.mark.parametrize(("EA_N", "eta_s"), [(1e6, 0.0), (2e6, 1e-2), (1e7, 1e-3)])
def test_rk4_is_stable_below_its_limit_and_not_above(kit, EA_N, eta_s):
    problem = kit.problem(kit.paper(EA_N=EA_N, eta_s=eta_s))
    limit = rk4_limit_s(problem.eigenvalues)
    state = problem.motion.derivative[:, : problem.n_state]

    def growth(h):
        z = h * state
        flow = np.eye(len(z)) + z @ (
            np.eye(len(z)) + z @ (np.eye(len(z)) + z @ (np.eye(len(z)) + z / 4) / 3) / 2
        )
        return np.abs(np.linalg.eigvals(flow)).max()

    assert growth(0.999 * limit) <= 1.0 + 1e-12
    assert growth(1.001 * limit) > 1.0 + 1e-4
    with pytest.raises(SolverError, match=f"{limit:.6g} s"):
        kit.solve(problem, [1.0], "rk4", step_s=1.001 * limit)


def test_the_frequencies_and_limits_of_the_science_page(kit):
    """Within the page's ranges, which leave the span lengths open: 6 to 67 Hz, 7, 1.7, 3.0 and 0.32 ms."""

    def of(EA_N, eta_s):
        return kit.problem(kit.paper(EA_N=EA_N, eta_s=eta_s)).eigenvalues

    frequencies = np.sort(np.abs(of(2e6, 0.0).imag)) / (2.0 * np.pi)
    assert frequencies[0] == pytest.approx(6.0, rel=0.2)
    assert frequencies[-1] == pytest.approx(67.0, rel=0.2)
    page_ms = {(2e6, 0.0): 7.0, (2e6, 1e-2): 1.7, (1e7, 0.0): 3.0, (1e7, 1e-2): 0.32}
    for (EA_N, eta_s), limit_ms in page_ms.items():
        assert 1e3 * rk4_limit_s(of(EA_N, eta_s)) == pytest.approx(limit_ms, rel=0.3)
    # Where nothing is damped the limit is 2√2 over the highest frequency.
    free = rk4_limit_s(of(2e6, 0.0))
    assert free == pytest.approx(np.sqrt(8.0) / (2.0 * np.pi * frequencies[-1]), rel=1e-4)


def test_the_tensioners_damping_alone_leaves_motions_that_hardly_decay(kit):
    def decay_rates_1_s(press, **model):
        return np.sort(-kit.problem(press, **model).eigenvalues.real)

    slowest = decay_rates_1_s(kit.paper(eta_s=0.0))[0]
    assert 0.5e-6 < slowest < 5e-6  # the page: "down to 2e-6 1/s"
    assert decay_rates_1_s(kit.paper(eta_s=1e-2))[0] > 1.0
    bare = {"effects": MOVING - {"belt-damping", "tensioner-damping"}}
    undamped = kit.problem(kit.paper(), **bare).eigenvalues
    assert np.abs(decay_rates_1_s(kit.paper(), **bare)).max() < 1e-9 * np.abs(undamped).max()
