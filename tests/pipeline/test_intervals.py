"""Other intervals of a fit: where they must agree, where they must not, and what is refused."""

import numpy as np
import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import with_intervals
from ropefric.fitting.store import load_fit, save_fit


@pytest.mark.parametrize("options", [{}, {"clustered": False}, {"scale_covar": True, "clustered": False}])
def test_of_a_linear_law_profile_and_covariance_agree(pulls, options):
    fit = fit_law(pulls("constant", 0.2), "constant", **options)
    profiled = with_intervals(fit, "profile")
    assert profiled["mu"].ci95 == pytest.approx(fit["mu"].ci95, rel=1e-6)
    assert (profiled["mu"].std, profiled.provenance["intervals"]) == (fit["mu"].std, {"method": "profile"})


def test_a_bootstrap_agrees_with_the_covariance_where_there_are_many_trials(pulls):
    fit = fit_law(pulls("constant", 0.2, repeats=8), "constant", clustered=False)
    drawn = with_intervals(fit, "bootstrap", n=1000, seed=4)
    assert np.diff(drawn["mu"].ci95)[0] == pytest.approx(np.diff(fit["mu"].ci95)[0], rel=0.15)
    assert with_intervals(fit, "bootstrap", n=1000, seed=4)["mu"] == drawn["mu"]


def test_a_parameter_near_its_bound_has_a_one_sided_profile(pulls):
    fit = fit_law(
        pulls("constant-offset", 0.2, 0.01, scatter=0.05), "constant-offset", bounds={"k": (0.0, 1.0)}
    )
    low, high = with_intervals(fit, "profile")["k"].ci95
    assert low >= 0.0
    assert high > 0.01


def test_a_fixed_parameter_stays_fixed(pulls):
    fit = fit_law(pulls("constant-offset", 0.2, 0.05), "constant-offset", fixed={"k": 0.05})
    for method in ("profile", "bootstrap"):
        assert with_intervals(fit, method)["k"] == fit["k"]


def test_what_cannot_be_done_is_refused(pulls, tmp_path):
    table = pulls("constant", 0.2)
    fit = fit_law(table, "constant")
    assert with_intervals(fit, "covariance") is fit
    with pytest.raises(UnknownNameError, match="did you mean 'profile'"):
        with_intervals(fit, "profil")
    with pytest.raises(InputError, match="robust loss"):
        with_intervals(fit_law(table, "constant", loss="huber"), "profile")
    with pytest.raises(InputError, match="carries no data"):
        with_intervals(load_fit(save_fit(fit, tmp_path / "fit.json")), "bootstrap")


def test_profiled_intervals_survive_the_file(pulls, tmp_path):
    fit = with_intervals(fit_law(pulls("constant", 0.2), "constant"), "profile")
    assert load_fit(save_fit(fit, tmp_path / "fit.json"))["mu"] == fit["mu"]
