"""Other intervals of a fit: where they must agree, where they must not, and what is refused."""

from dataclasses import replace

import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import with_intervals
from ropefric.fitting.store import load_fit, save_fit


def test_of_a_linear_law_profile_and_covariance_agree(pulls):
    fit = fit_law(pulls("constant", 0.2), "constant")
    profiled = with_intervals(fit, "profile")
    assert profiled["mu"].ci95 == pytest.approx(fit["mu"].ci95, rel=1e-6)
    assert (profiled["mu"].std, profiled.provenance["intervals"]) == (fit["mu"].std, {"method": "profile"})


def test_a_parameter_near_its_bound_has_a_one_sided_profile(pulls):
    fit = fit_law(
        pulls("constant-offset", 0.2, 0.01, scatter=0.05), "constant-offset", bounds={"k": (0.0, 1.0)}
    )
    low, high = with_intervals(fit, "profile")["k"].ci95
    assert low >= 0.0
    assert high > 0.01


def test_a_fixed_parameter_stays_fixed(pulls):
    fit = fit_law(pulls("constant-offset", 0.2, 0.05), "constant-offset", fixed={"k": 0.05})
    assert with_intervals(fit, "profile")["k"] == fit["k"]


def test_what_cannot_be_done_is_refused(pulls, tmp_path):
    table = pulls("constant", 0.2)
    fit = fit_law(table, "constant")
    assert with_intervals(fit, "covariance") is fit
    with pytest.raises(UnknownNameError, match="did you mean 'profile'"):
        with_intervals(fit, "profil")
    again = load_fit(save_fit(fit, tmp_path / "fit.json"))
    assert with_intervals(again, "profile")["mu"] == with_intervals(fit, "profile")["mu"]
    one = table.group() == 0
    with pytest.raises(InputError, match="no scatter that profiles could rest on"):
        with_intervals(fit_law(replace(table, kept=one), "constant"), "profile")


def test_profiled_intervals_survive_the_file(pulls, tmp_path):
    fit = with_intervals(fit_law(pulls("constant", 0.2), "constant"), "profile")
    assert load_fit(save_fit(fit, tmp_path / "fit.json"))["mu"] == fit["mu"]
