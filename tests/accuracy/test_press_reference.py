"""The press of the study, its equations written down separately and solved in 30-digit arithmetic."""

import mpmath as mp
import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.studies import press_transient as study


def convolved(first, second):
    out = [mp.mpf(0)] * (len(first) + len(second) - 1)
    for i, x in enumerate(first):
        for j, y in enumerate(second):
            out[i + j] += x * y
    return out


class Machine:
    """z = ways of three rollers relative to the driver, and the tensioner's; T = T_0 + k (e + η e'), e = E z.

    Balances: (J/R² + ρARα) s'' = T_out − T_in − M/R f(t), m x'' = (T_2 − T_2,0 − ρAv²) + (T_3 − T_3,0 − ρAv²) cos β
    − k1 x − C1 x'; the loads follow f = v(t)/v, and T_0 (1 + cos β) = k1 x_0 + F of a press at rest.
    """

    def __init__(self, stiffness_N, damping_s):
        number = mp.mpf
        self.eta = number(damping_s)
        self.k = [number(stiffness_N) / number(length) for length in (1.2, 0.8, 0.9, 1.6)]
        self.density = number(15.0)
        radii, angles = (0.075, 0.075, 0.25), (0.49, 2.85, 0.99)
        self.mass = [number(J) / number(R) ** 2 + self.density * number(R) * number(angle)
                     for J, R, angle in zip((0.37, 0.37, 13.9), radii, angles, strict=True)]  # fmt: skip
        self.load = [number(M) / number(R) for M, R in zip((26.2, 26.2, 99.0), radii, strict=True)]
        self.cos = mp.cos(number(0.347))
        self.rest = (number(2e4) * number(0.03) + 2000) / (1 + self.cos)
        self.stretch = mp.matrix([[1, 0, 0, 0], [-1, 1, 0, -1], [0, -1, 1, -self.cos], [0, 0, -1, 0]])

    def acceleration(self):
        """z'' by z."""
        pull = mp.diag(self.k) * self.stretch
        rows = [(pull[i + 1, :] - pull[i, :]) / self.mass[i] for i in range(3)]
        rows.append((pull[1, :] + self.cos * pull[2, :]) / 121)
        return mp.matrix([[row[j] for j in range(4)] for row in rows])

    def generator(self, speed):
        """The matrix that carries (z, z', τ^j/j!) along, for a speed Σ speed_j τ^j."""
        of_z, of_rate = self.acceleration(), self.eta * self.acceleration()
        of_z[3, 3] -= mp.mpf(2e4) / 121
        of_rate[3, 3] -= mp.mpf(500) / 121
        squared = convolved(speed, speed)
        powers = len(squared)
        full = [*speed, *[mp.mpf(0)] * powers]
        G = mp.zeros(8 + powers)
        for i in range(4):
            G[i, 4 + i] = 1
            for j in range(4):
                G[4 + i, j], G[4 + i, 4 + j] = of_z[i, j], of_rate[i, j]
        for j in range(powers):
            for i in range(3):
                share = full[j] / mp.mpf(study.SPEED_M_S)
                G[4 + i, 8 + j] = -mp.factorial(j) * (
                    self.load[i] / self.mass[i] * share + (j + 1) * full[j + 1]
                )
            G[7, 8 + j] = -mp.factorial(j) * self.density * (1 + self.cos) / 121 * squared[j]
            if j:
                G[8 + j, 8 + j - 1] = 1
        return G

    def tensions(self, state):
        z, rate = state[:4], state[4:8]
        moved = self.stretch * (mp.matrix(z) + self.eta * mp.matrix(rate))
        return [self.rest + k * e for k, e in zip(self.k, moved, strict=True)]


@pytest.mark.parametrize("case", list(study.BELTS))
def test_tensions(case):
    with mp.workdps(30):
        machine = Machine(*study.BELTS[case])
        final, run_up = mp.mpf(study.SPEED_M_S), mp.mpf(study.RUN_UP_S)
        rising = [mp.mpf(0), mp.mpf(0), 3 * final / run_up**2, -2 * final / run_up**3]

        def advance(state, speed, time):
            G = machine.generator(speed)
            start = mp.matrix([*state, 1, *[0] * (G.rows - 9)])
            return list(mp.expm(G * time, method="taylor") * start)[:8]

        during = [advance([0] * 8, rising, mp.mpf(time)) for time in study.TIMES_S[:2]]
        top = advance([0] * 8, rising, run_up)
        after = advance(top, [final], mp.mpf(study.TIMES_S[2]) - run_up)
        found = [machine.tensions(state) for state in (*during, after)]
    np.testing.assert_allclose(np.array(found, dtype=float), study.TENSIONS_N[case], rtol=2e-16, atol=0)


def test_every_span_stays_taut_so_that_the_linear_model_holds():
    assert all(min(row) > 0.0 for rows in study.TENSIONS_N.values() for row in rows)


def test_rk4_is_fourth_order(errors, order):
    assert order(errors("press-transient", "pliant", "rk4"), 2.0, 0.5) == pytest.approx(-4.0, abs=0.15)


def test_the_exponential_has_no_error_of_discretisation(errors):
    for case in study.BELTS:
        (row,) = error_table("press-transient", case, method="exact")
        assert row.error < 1e-11
        assert row.evaluations == 0


def test_a_stiff_belt_takes_an_explicit_method_far_more_steps_at_every_tolerance():
    """Stability and not accuracy sets the step: the tolerance hardly changes the work."""
    settings = {(s.method, s.setting): s for s in STUDIES["press-transient"].case("stiff").settings()}
    rough, fine = (settings["dop853", f"tolerance {t}"].assess() for t in ("0.001", "1e-05"))
    assert fine.evaluations < 1.2 * rough.evaluations
    radau = settings["radau", "tolerance 0.0001"].assess()
    assert radau.evaluations < 0.1 * fine.evaluations
    assert radau.error < fine.error
