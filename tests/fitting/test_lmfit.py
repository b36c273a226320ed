"""Laws as lmfit models: names, start values and bounds, and lmfit as an independent check of our own engine."""

import numpy as np
import pytest

import ropefric as rf
from ropefric.errors import UnknownNameError
from ropefric.fitting.problem import batched_fit
from ropefric.friction.laws import ALL_LAWS

SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")


def settings(conditions):
    return {name: getattr(conditions, name) for name in SETTINGS}


def test_a_model_is_its_law(bench_problem):
    for law in ALL_LAWS.values():
        problem = bench_problem(law)
        model = rf.lmfit_model(law.name)
        assert (tuple(model.independent_vars), tuple(model.param_names)) == (SETTINGS, law.parameter_names)
        params = model.make_params()
        for item in law.parameters:
            made = params[item.name]
            assert (made.value, made.min, made.max) == (item.start, item.lower, item.upper)
            assert made.vary is not item.fixed
        found = model.eval(params, **settings(problem.conditions))
        assert np.array_equal(found, law.log_lift(problem.start, problem.conditions))


def test_lmfit_ends_where_our_own_engine_does(bench_problem):
    for law in ALL_LAWS.values():
        problem = bench_problem(law, std=0.005)
        own = batched_fit(problem)
        free = problem.vary & (own.theta[0] > problem.lower) & (own.theta[0] < problem.upper)
        found = rf.lmfit_model(law.name).fit(problem.log_lift, **settings(problem.conditions),
            method="least_squares", fit_kws={"x_scale": "jac", "xtol": 1e-14, "ftol": 1e-14,
            "gtol": 1e-14})  # fmt: skip
        theirs = np.array([found.best_values[name] for name in law.parameter_names])
        assert own.chi2[0] <= ((problem.residuals(theirs)) ** 2).sum() * (1 + 1e-9)
        J = problem.jacobian(own.theta[0])[:, free]
        std = np.sqrt(np.diag(np.linalg.pinv(J.T @ J)))
        assert (np.abs(theirs - own.theta[0])[free] <= 1e-3 * std).all()


def test_an_unknown_law_says_which_was_meant():
    with pytest.raises(UnknownNameError, match="did you mean 'coupled'"):
        rf.lmfit_model("copled")
