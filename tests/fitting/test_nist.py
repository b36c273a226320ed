"""NIST StRD nonlinear regression: certified values and standard deviations through the package's own search.

Data and certified values: National Institute of Standards and Technology, Statistical Reference Datasets,
https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml.
"""

from itertools import product

import numpy as np
import pytest

from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.fitting.statistics import plain_covariance
from ropefric.friction.condition import Conditions


def pairs(text):
    return np.array(text.split(), dtype=float).reshape(-1, 2)


MISRA1A = pairs(
    """
    10.07 77.6  14.73 114.9  17.94 141.1  23.93 190.8  29.61 239.9  35.18 289.0  40.02 332.8
    44.82 378.4 50.76 434.8  55.05 477.3  61.01 536.8  66.40 593.1  75.47 689.1  81.78 760.0
    """
)

ECKERLE4 = pairs(
    """
    .0001575 400   .0001699 405   .0002350 410   .0003102 415   .0004917 420   .0008710 425   .0017418 430
    .0046400 435   .0065895 436.5 .0097302 438   .0149002 439.5 .0237310 441   .0401683 442.5 .0712559 444
    .1264458 445.5 .2073413 447   .2902366 448.5 .3445623 450   .3698049 451.5 .3668534 453   .3106727 454.5
    .2078154 456   .1164354 457.5 .0616764 459   .0337200 460.5 .0194023 462   .0117831 463.5 .0074357 465
    .0022732 470   .0008800 475   .0004579 480   .0002345 485   .0001586 490   .0001143 495   .0000710 500
    """
)

THURBER = pairs(
    """
    80.574 -3.067   84.248 -2.981   87.264 -2.921   87.195 -2.912   89.076 -2.840   89.608 -2.797
    89.868 -2.702   90.101 -2.699   92.405 -2.633   95.854 -2.481   100.696 -2.363  101.060 -2.322
    401.672 -1.501  390.724 -1.460  567.534 -1.274  635.316 -1.212  733.054 -1.100  759.087 -1.046
    894.206 -0.915  990.785 -0.714  1090.109 -0.566 1080.914 -0.545 1122.643 -0.400 1178.351 -0.309
    1260.531 -0.109 1273.514 -0.103 1288.339 0.010  1327.543 0.119  1353.863 0.377  1414.509 0.790
    1425.208 0.963  1421.384 1.006  1442.962 1.115  1464.350 1.572  1468.705 1.841  1447.894 2.047
    1457.628 2.200
    """
)


def misra(b, x):
    decay = np.exp(-b[1] * x)
    return b[0] * (1 - decay), np.stack([1 - decay, b[0] * x * decay], axis=-1)


def eckerle(b, x):
    z = (x - b[2]) / b[1]
    peak = np.exp(-0.5 * z**2) / b[1]
    y = b[0] * peak
    return y, np.stack([peak, y * (z**2 - 1) / b[1], y * z / b[1]], axis=-1)


def thurber(b, x):
    above, below = b[0] + x * (b[1] + x * (b[2] + x * b[3])), 1 + x * (b[4] + x * (b[5] + x * b[6]))
    powers = np.stack([x**0, x, x**2, x**3], axis=-1)
    return above / below, np.hstack([powers, -powers[:, 1:] * (above / below)[:, None]]) / below[:, None]


CASES = {
    "Misra1a": (MISRA1A, misra, [(500, 1e-4), (250, 5e-4)],
                (2.3894212918e02, 5.5015643181e-04), (2.7070075241e00, 7.2668688436e-06), 1.2455138894e-01),
    "Eckerle4": (ECKERLE4, eckerle, [(1, 10, 500), (1.5, 5, 450)],
                 (1.5543827178e00, 4.0888321754e00, 4.5154121844e02),
                 (1.5408051163e-02, 4.6803020753e-02, 4.6800518816e-02), 1.4635887487e-03),
    "Thurber": (
        THURBER, thurber, [(1000, 1000, 400, 40, 0.7, 0.3, 0.03), (1300, 1500, 500, 75, 1, 0.4, 0.05)],
        (1.2881396800e03, 1.4910792535e03, 5.8323836877e02, 7.5416644291e01, 9.6629502864e-01, 3.9797285797e-01,
         4.9727297349e-02),
        (4.6647963344e00, 3.9571156086e01, 2.8698696102e01, 5.5675370270e00, 3.1333340687e-02, 1.4984928198e-02,
         6.5842344623e-03), 5.6427082397e03),
}  # fmt: skip


class Model:
    """A model of NIST as a law: its x is a wrap angle, moved so that none is negative."""

    name = "nist"
    effects = frozenset()

    def __init__(self, model, n):
        self.model, self.parameters = model, (None,) * n
        self.parameter_names = tuple(f"b{i}" for i in range(n))

    def log_lift_and_jacobian(self, theta, conditions):
        x = conditions.wrap_angle_rad - SHIFT
        if np.ndim(theta) == 1:
            return self.model(theta, x)
        found = [self.model(one, x) for one in theta]
        return np.stack([values for values, _ in found]), np.stack([slopes for _, slopes in found])

    def log_lift(self, theta, conditions):
        with np.errstate(all="ignore"):
            return self.log_lift_and_jacobian(theta, conditions)[0]


SHIFT = 4.0


def problem_of(model, y, x, start, *, lower=-np.inf, upper=np.inf):
    p = len(start)
    return FitProblem(law=Model(model, p), conditions=Conditions(wheel_radius_m=1, rope_radius_m=1,
        wrap_angle_rad=x + SHIFT, end_tension_N=1), log_lift=y, std=np.ones_like(y), group=np.arange(len(y)),
        start=np.array(start, float), lower=np.broadcast_to(np.asarray(lower, float), p),
        upper=np.broadcast_to(np.asarray(upper, float), p), vary=np.ones(p, bool))  # fmt: skip


def test_certified_values_and_standard_deviations_to_six_digits():
    starts_of = (("Misra1a", 0), ("Misra1a", 1), ("Eckerle4", 1), ("Thurber", 0), ("Thurber", 1))
    for (name, which), bounded in product(starts_of, (False, True)):
        data, model, starts, values, deviations, rss = CASES[name]
        y, x = data.T
        bounds = {"lower": 0.0, "upper": 1e4} if bounded else {}
        found = batched_fit(problem_of(model, y, x, starts[which], **bounds), max_iterations=2000,
            tolerance=1e-13)  # fmt: skip
        assert found.converged[0]
        assert found.theta[0] == pytest.approx(values, rel=1e-7)
        assert found.chi2[0] == pytest.approx(rss, rel=1e-8)
        variance = found.chi2[0] / (len(y) - len(values))
        std = np.sqrt(np.diag(plain_covariance(model(found.theta[0], x)[1])) * variance)
        assert std == pytest.approx(deviations, rel=1e-6)


def test_the_far_start_of_eckerle4_is_never_called_a_success():
    """From b = (1, 10, 500) Gauss-Newton methods run away; the answer must be right or doubted, not wrong."""
    data, model, starts, values, _, rss = CASES["Eckerle4"]
    y, x = data.T
    low, high = np.array([0.0, 1.0, 400.0]), np.array([10.0, 20.0, 500.0])
    found = batched_fit(problem_of(model, y, x, starts[0], lower=low, upper=high))
    if found.converged[0] and ((found.theta[0] > low) & (found.theta[0] < high)).all():
        assert found.theta[0] == pytest.approx(values, rel=1e-7)
        assert found.chi2[0] == pytest.approx(rss, rel=1e-8)
