"""Every integrator against the exact solution; RK4's order, its limit, and the numbers of the science page."""

import numpy as np
import pytest

from ropefric.accuracy.studies.press_transient import rk4_limit_s
from ropefric.errors import SolverError
from ropefric.systems.press.transient.motion import MOVING

TIMES_S = np.linspace(0.0, 1.5, 16)


def error(problem, found, exact):
    return float((np.abs(found - exact).max(axis=0) / problem.scale).max())


@pytest.fixture(scope="module")
def case(kit):
    """A small machine with two corners in its drive, and its exact solution."""
    problem = kit.problem(kit.small(), kit.run_up("ramp", 1.0, 1.0))
    return problem, kit.solve(problem, TIMES_S)


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("dop853", 1e-8), ("radau", 1e-5), ("lsoda", 1e-8), pytest.param("radau", 1e-8, marks=pytest.mark.slow)],
)
def test_adaptive_methods_agree_with_the_exact_solution(kit, case, name, tolerance):
    problem, exact = case
    found = kit.solve(problem, TIMES_S, name, tolerance=tolerance)
    # Steps are controlled one by one; over the hundreds of steps here their errors add up.
    assert error(problem, found, exact) < 3e3 * tolerance


def test_rk4_converges_with_its_order(kit, case):
    problem, exact = case
    errors = [error(problem, kit.solve(problem, TIMES_S, "rk4", step_s=h), exact) for h in (2e-3, 1e-3, 5e-4)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert ((orders > 3.8) & (orders < 4.3)).all()


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


@pytest.mark.parametrize("name", ["radau", "lsoda"])
def test_the_stiff_case_needs_no_tuning(kit, name):
    """EA = 1e8 N and η = 0.1 s: decay rates from 10 to 1e6 1/s."""
    problem = kit.problem(kit.small(EA_N=1e8, eta_s=0.1), kit.run_up("ramp", 1.0, 1.0))
    rates = -problem.eigenvalues.real
    assert rates.max() / rates.min() > 1e4
    exact = kit.solve(problem, TIMES_S)
    found = kit.solve(problem, TIMES_S, name, tolerance=1e-7)
    w, wanted = (np.hstack([s, problem.inputs.at(TIMES_S)]) for s in (found, exact))
    # Ways of a micrometre carry the tensions here, so the tensions are the honest measure.
    np.testing.assert_allclose(
        (w @ problem.motion.tension_N.T)[2:], (wanted @ problem.motion.tension_N.T)[2:], rtol=1e-4
    )
